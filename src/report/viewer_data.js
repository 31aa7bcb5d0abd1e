// What C++ wrote into the page (scene_data.cpp), as typed arrays.

const BLOCK_TYPES = { f4: Float32Array, f8: Float64Array, i2: Int16Array, u1: Uint8Array, u4: Uint32Array };

function readBlock(number) {
  const element = document.getElementById('b' + number);
  const text = atob(element.textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const Type = BLOCK_TYPES[element.dataset.type];
  element.remove();  // its text is as large as the array, and no longer needed
  return new Type(bytes.buffer);
}

// Bodies and pose arrays name their blocks by number; everything else stays as it is.
function readReport() {
  const report = JSON.parse(document.getElementById('report').textContent);
  for (const body of report.bodies)
    for (const key of ['positions', 'normals', 'machined', 'plain', 'edges']) body[key] = readBlock(body[key]);
  for (const key of Object.keys(report.poses))
    if (key !== 'count') report.poses[key] = readBlock(report.poses[key]);
  return report;
}

// Greatest k with sorted[k] <= value; 0 if there is none.
function lastNotAfter(sorted, value) {
  let low = 0, high = sorted.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle; else high = middle;
  }
  return low;
}

// Index into report.passes of the pass that holds the pose, or -1.
function passOf(report, pose) {
  const k = lastNotAfter(report.passFirst, pose);
  const pass = report.passes[k];
  return pass && pose >= pass[0] && pose < pass[0] + pass[1] ? k : -1;
}

// The run of invalid poses [first, count, why] that holds the pose, or undefined.
function problemAt(report, pose) {
  const run = report.problems[lastNotAfter(report.problemFirst, pose)];
  return run && pose >= run[0] && pose < run[0] + run[1] ? run : undefined;
}

function cssColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
}

function formatTime(seconds) {
  const hours = Math.floor(seconds / 3600), minutes = Math.floor(seconds / 60) % 60, rest = (seconds % 60).toFixed(1).padStart(4, '0');
  return hours > 0 ? hours + ':' + String(minutes).padStart(2, '0') + ':' + rest : minutes + ':' + rest;
}

// 'axis_rate_deg_per_mm' -> ['axis rate', 'deg/mm']: units stand at the end of a name.
function nameAndUnit(name) {
  for (const [ending, unit] of [['_deg_per_mm', 'deg/mm'], ['_mm_min', 'mm/min'], ['_deg', 'deg'], ['_mm', 'mm'], ['_s', 's']])
    if (name.endsWith(ending)) return [name.slice(0, -ending.length).replaceAll('_', ' '), unit];
  return [name.replaceAll('_', ' '), ''];
}
