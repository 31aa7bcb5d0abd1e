// Curves against time (or path length) on one canvas, one lane each, with a cursor that follows the player.

function lanesOf(report) {
  const poses = report.poses, lanes = [];
  const column = (array, width, k) => (width === 1 ? array : Float32Array.from({ length: poses.count }, (unused, i) => array[width * i + k]));
  if (poses.positions)
    report.axes.slice(3, 5).forEach((letter, k) => lanes.push({ name: letter, unit: 'deg', values: column(poses.positions, 5, 3 + k) }));
  else
    for (const name of ['lead', 'tilt']) if (poses[name + '_deg']) lanes.push({ name: name, unit: 'deg', values: poses[name + '_deg'] });
  // At most two of what methods and measures add, so that every lane stays high enough to read.
  for (const key of Object.keys(poses).filter((name) => name.startsWith('extra:')).slice(0, 2)) {
    const [name, unit] = nameAndUnit(key.slice(6));
    lanes.push({ name: name, unit: unit, values: poses[key] });
  }
  if (poses.feed_mm_min) lanes.push({ name: 'feed', unit: 'mm/min', values: poses.feed_mm_min, steps: true });
  return lanes;
}

// Round numbers, at most `most` of them, that divide [low, high].
function ticks(low, high, most) {
  const raw = (high - low) / most, power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw * (1 - 1e-9));
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), list = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9 * step; ++i) list.push({ at: i * step, text: (i * step).toFixed(digits).replace('-', '\u2212') });
  return list;
}

function makePlots(report, canvas, onJump) {
  const lanes = lanesOf(report), clock = report.poses.clock || new Float64Array(0), count = clock.length;
  const context = canvas.getContext('2d'), still = document.createElement('canvas');
  const left = 64, rightGap = 16, bottom = 34, topGap = 20, laneGap = 24;
  const begin = count > 0 ? clock[0] : 0, end = count > 0 ? clock[count - 1] : 1, span = end - begin || 1;
  for (const lane of lanes) {
    let low = Infinity, high = -Infinity;
    for (const value of lane.values) if (isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    const pad = (high - low) * 0.08 || Math.max(Math.abs(high) * 0.1, 1);
    lane.low = isFinite(low) ? low - pad : -1;
    lane.high = isFinite(high) ? high + pad : 1;
  }
  let width = 0, height = 0, ratio = 1, now = begin;
  const xOf = (t) => left + (t - begin) / span * (width - left - rightGap);

  // First, least, greatest and last value of each pixel column draw the same picture as all values do.
  function curve(target, lane, yOf) {
    target.beginPath();
    let pen = false, column = -1, least = 0, greatest = 0, last = 0;
    const flush = () => {
      if (column < 0) return;
      target.lineTo(column, yOf(least));
      target.lineTo(column, yOf(greatest));
      target.lineTo(column, yOf(last));
      column = -1;
    };
    const dense = count > 2 * width;
    for (let i = 0; i < count; ++i) {
      const value = lane.values[i];
      if (!isFinite(value)) { flush(); pen = false; continue; }
      const x = dense ? Math.round(xOf(clock[i])) : xOf(clock[i]);
      if (!pen) { target.moveTo(x, yOf(value)); pen = true; }
      if (dense && x === column) {
        least = Math.min(least, value);
        greatest = Math.max(greatest, value);
        last = value;
      } else if (dense) {
        flush();
        target.lineTo(x, yOf(value));
        column = x; least = greatest = last = value;
      } else {
        if (lane.steps && i > 0) target.lineTo(xOf(clock[i - 1]), yOf(value));  // a feed holds for the whole move
        target.lineTo(x, yOf(value));
      }
    }
    flush();
    target.stroke();
  }

  function drawStill() {
    still.width = canvas.width;
    still.height = canvas.height;
    const target = still.getContext('2d');
    target.scale(ratio, ratio);
    target.font = '11px ' + getComputedStyle(document.body).fontFamily;
    const quiet = cssColour('quiet'), rule = cssColour('line');
    const laneHeight = (height - topGap - bottom - laneGap * (lanes.length - 1)) / Math.max(lanes.length, 1);
    target.fillStyle = cssColour('problem');
    for (const [first, length] of report.problems) {
      const x = xOf(clock[Math.max(first - 1, 0)]), to = xOf(clock[first + length - 1]);
      target.fillRect(x - 0.5, topGap, Math.max(to - x, 2), height - topGap - bottom);
    }
    target.textBaseline = 'middle';
    lanes.forEach((lane, k) => {
      const top = topGap + k * (laneHeight + laneGap), yOf = (value) => top + (lane.high - value) / (lane.high - lane.low) * laneHeight;
      target.lineWidth = 1;
      target.strokeStyle = rule;
      target.fillStyle = quiet;
      target.textAlign = 'right';
      for (const tick of ticks(lane.low, lane.high, Math.max(2, Math.floor(laneHeight / 16)))) {
        const y = Math.round(yOf(tick.at)) + 0.5;
        target.beginPath();
        target.moveTo(left, y);
        target.lineTo(width - rightGap, y);
        target.stroke();
        target.fillText(tick.text, left - 6, y);
      }
      target.strokeStyle = cssColour(['plot-a', 'plot-b', 'plot-c'][k % 3]);
      target.lineWidth = 1.5;
      target.lineJoin = 'round';
      target.save();
      target.beginPath();
      target.rect(left, top - 2, width - left - rightGap, laneHeight + 4);
      target.clip();
      curve(target, lane, yOf);
      target.restore();
      // Above its lane: beside it, long names run into each other.
      target.textAlign = 'left';
      target.fillStyle = cssColour('text');
      target.fillText(lane.name + ' (' + lane.unit + ')', left, top - 10);
    });
    target.fillStyle = quiet;
    target.textAlign = 'center';
    const minutes = report.clock_is_time && span > 600, scale = minutes ? 60 : 1;
    for (const tick of ticks(begin / scale, end / scale, Math.max(2, Math.floor((width - left) / 90)))) target.fillText(tick.text, xOf(tick.at * scale), height - bottom + 10);
    target.fillText(!report.clock_is_time ? 'tip path (mm)' : minutes ? 'time (min)' : 'time (s)', (left + width - rightGap) / 2, height - 8);
  }

  function draw() {
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (canvas.width === 0 || count === 0) return;
    context.drawImage(still, 0, 0);
    context.scale(ratio, ratio);
    context.strokeStyle = cssColour('text');
    context.lineWidth = 1.25;
    context.beginPath();
    context.moveTo(xOf(now), topGap - 4);
    context.lineTo(xOf(now), height - bottom + 2);
    context.stroke();
  }

  function resize() {
    ratio = Math.min(window.devicePixelRatio || 1, 2);
    width = canvas.clientWidth;
    height = canvas.clientHeight;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    if (canvas.width === 0 || count === 0) return;
    drawStill();
    draw();
  }

  const jump = (event) => {
    const share = (event.clientX - canvas.getBoundingClientRect().left - left) / (width - left - rightGap);
    onJump(begin + Math.min(Math.max(share, 0), 1) * span);
  };
  canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); jump(event); });
  canvas.addEventListener('pointermove', (event) => { if (event.buttons & 1) jump(event); });
  canvas.hidden = lanes.length === 0 || count === 0;

  return {
    resize,
    moveTo(t) { now = t; draw(); },
    cursor: () => xOf(now),
    countColours() { return new Set(new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size; },
  };
}
