// Ties the parts of the page together: the player, its controls, the numbers of the current pose.

const RUN_SECONDS = 75;  // the speed offered first plays the whole path in about this time

function start() {
  const report = readReport(), poses = report.poses, count = poses.count, clock = poses.clock || new Float64Array(0);
  report.passFirst = report.passes.map((pass) => pass[0]);
  report.problemFirst = report.problems.map((run) => run[0]);
  const byId = (id) => document.getElementById(id);
  const begin = count > 0 ? clock[0] : 0, end = count > 0 ? clock[count - 1] : 0;

  let scene = null;
  try {
    scene = makeScene(report, byId('scene-canvas'));
  } catch (error) {
    const message = byId('scene-message');
    message.textContent = 'The 3-D picture cannot be drawn: this browser has no WebGL (' + error.message + '). Numbers and plots work without it.';
    message.hidden = false;
    byId('legend').hidden = true;
    byId('scene-bar').hidden = true;
  }
  const plots = makePlots(report, byId('plots'), (t) => { play(false); seek(t); });

  // ---- where we are: a time on the clock, and the last pose reached
  let now = begin, pose = 0, playing = false, lastFrame = 0;
  function seek(t, exactPose) {
    now = Math.min(Math.max(t, begin), end);
    pose = exactPose === undefined ? lastNotAfter(clock, now) : exactPose;
    const gap = pose + 1 < count ? clock[pose + 1] - clock[pose] : 0;
    if (scene) scene.placeTool(pose, exactPose === undefined && gap > 0 ? Math.min((now - clock[pose]) / gap, 1) : 0);
    plots.moveTo(now);
    byId('scrub').value = now;
    byId('clock').textContent = report.clock_is_time ? formatTime(now - begin) + ' / ' + formatTime(end - begin) : now.toFixed(1) + ' / ' + end.toFixed(1) + ' mm';
    readout.show(pose);
  }
  const goTo = (i) => { if (count > 0) seek(clock[Math.min(Math.max(i, 0), count - 1)], Math.min(Math.max(i, 0), count - 1)); };
  function play(on) {
    playing = on && count > 1;
    byId('play').textContent = playing ? 'Pause' : 'Play';
    if (!playing) return;
    if (now >= end) seek(begin);
    lastFrame = performance.now();
    requestAnimationFrame(advance);
  }
  function advance(time) {
    if (!playing) return;
    const seconds = Math.max(time - lastFrame, 0) / 1000;
    lastFrame = time;
    seek(now + seconds * Number(byId('speed').value));
    if (now >= end) play(false); else requestAnimationFrame(advance);
  }
  function nextProblem() {
    if (report.problems.length === 0) return;
    play(false);
    goTo((report.problems.find((run) => run[0] > pose) || report.problems[0])[0]);
  }

  // ---- controls
  const readout = makeReadout(report, byId('readout'));
  byId('scrub').min = begin;
  byId('scrub').max = end;
  byId('scrub').addEventListener('input', (event) => { play(false); seek(Number(event.target.value)); });
  byId('play').addEventListener('click', () => play(!playing));
  byId('previous').addEventListener('click', () => { play(false); goTo(pose - 1); });
  byId('next').addEventListener('click', () => { play(false); goTo(pose + 1); });
  byId('problem').addEventListener('click', nextProblem);
  byId('problem').disabled = report.problems.length === 0;
  for (const id of ['play', 'previous', 'next', 'scrub']) byId(id).disabled = count < 2;
  for (const button of document.querySelectorAll('[data-pose]'))
    button.addEventListener('click', () => { play(false); goTo(Number(button.dataset.pose)); });
  fillSpeeds(byId('speed'), report.clock_is_time, end - begin);
  if (scene) wireScene(report, scene, byId, (i) => { play(false); goTo(i); });
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA|BUTTON|SUMMARY)$/.test(event.target.tagName)) return;
    const actions = { ' ': () => play(!playing), ArrowLeft: () => goTo(pose - 1), ArrowRight: () => goTo(pose + 1), Home: () => goTo(0),
      End: () => goTo(count - 1), n: nextProblem, f: () => scene && scene.fit() };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });

  // ---- first picture: the tool cutting some third of the way along, or at the first problem
  const resize = () => { if (scene) scene.resize(); plots.resize(); };
  resize();
  goTo(report.problems.length > 0 ? report.problems[0][0] : cutNear(report, Math.floor(count / 3)));
  if (scene) scene.fit('iso');
  const observer = new ResizeObserver(resize);
  for (const id of ['scene', 'plots']) observer.observe(byId(id));
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { if (scene) scene.recolour(); plots.resize(); });
  document.documentElement.dataset.ready = scene ? 'ok' : 'no-webgl';
  if (location.hash === '#selftest') selfTest({ report, scene, plots, seek, goTo, nextProblem, begin, end, current: () => pose });
}

// The middle of the first cut that ends after the pose.
function cutNear(report, pose) {
  const cut = report.passes.find((pass) => pass[2] === 'cut' && pass[0] + pass[1] > pose);
  return cut ? cut[0] + (cut[1] >> 1) : pose;
}

function fillSpeeds(select, isTime, span) {
  const factors = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
  const usual = factors.find((factor) => span / (isTime ? factor : 25 * factor) <= RUN_SECONDS) || factors[factors.length - 1];
  for (const factor of factors) {
    const option = document.createElement('option');
    option.value = isTime ? factor : 25 * factor;
    option.textContent = isTime ? factor + '×' : 25 * factor + ' mm/s';
    option.selected = factor === usual;
    select.append(option);
  }
}

function wireScene(report, scene, byId, goTo) {
  for (const button of document.querySelectorAll('[data-view]')) button.addEventListener('click', () => scene.fit(button.dataset.view));
  const add = (name, text, on) => {
    if (!scene.has(name)) return;
    const label = document.createElement('label'), box = document.createElement('input');
    box.type = 'checkbox';
    box.checked = on;
    box.addEventListener('change', () => scene.show(name, box.checked));
    scene.show(name, on);
    label.append(box, text);
    byId('toggles').append(label);
  };
  add('tool', 'Tool', true);
  add('needles', 'Axes', true);
  add('links', 'Links', true);
  add('check', 'Check bodies', true);
  byId('opacity').addEventListener('input', (event) => scene.setOpacity(event.target.value / 100));

  const legend = (name, text, shown, lineLike) => {
    if (!shown) return;
    const item = document.createElement('span'), mark = document.createElement('i');
    mark.style.background = 'var(--' + name + ')';
    if (lineLike) mark.className = 'line';
    item.append(mark, text);
    byId('legend').append(item);
  };
  legend('machined', 'machined face', report.bodies.some((body) => body.machined.length > 0));
  legend('check', 'check body', scene.has('check'));
  legend('cut', 'cut', scene.hasKind('cut'), true);
  legend('lead', 'lead-in, lead-out', scene.hasKind('lead'), true);
  legend('link', 'link', scene.hasKind('link'), true);
  legend('needle', 'tool axis', scene.has('needles'), true);
  legend('invalid', 'not valid', report.problems.length > 0, true);

  // A click that does not turn the view picks the pose under it.
  const canvas = byId('scene-canvas');
  let down = null;
  canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
  canvas.addEventListener('pointerup', (event) => {
    const still = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4;
    down = null;
    if (!still || event.button !== 0) return;
    const box = canvas.getBoundingClientRect(), picked = scene.pick(event.clientX - box.left, event.clientY - box.top);
    if (picked >= 0) goTo(picked);
  });
}

// The numbers of one pose. Its cells are made once and only their text changes.
function makeReadout(report, list) {
  const poses = report.poses, cells = [];
  const number = (digits) => (x) => (isFinite(x) ? x.toFixed(digits).replace('-', '\u2212') : '\u2013');
  const add = (name, text, className) => {
    const box = document.createElement('div'), term = document.createElement('dt'), value = document.createElement('dd');
    term.textContent = name;
    if (className) box.className = className;
    box.append(term, value);
    list.append(box);
    cells.push((i) => { value.textContent = text(i); });
  };
  const addArray = (name, array, digits, width, k, shift) => {
    if (array) add(name, (i) => number(digits)(array[(width || 1) * i + (k || 0)] + (shift || 0)));
  };
  add('pose of ' + poses.count, (i) => String(i));
  add('pass', (i) => { const k = passOf(report, i); return k < 0 ? '\u2013' : k + ' (' + report.passes[k][2] + ')'; });
  ['X', 'Y', 'Z'].forEach((letter, k) => addArray('tip ' + letter + ' (mm)', poses.cl, 3, 3, k, report.origin[k]));
  if (poses.axis) add('axis i, j, k', (i) => [0, 1, 2].map((k) => number(3)(poses.axis[3 * i + k])).join('  '), 'two');
  if (poses.positions) report.axes.slice(3, 5).forEach((letter, k) => addArray(letter + ' (deg)', poses.positions, 3, 5, 3 + k));
  addArray('feed (mm/min)', poses.feed_mm_min, 0);
  addArray('lead (deg)', poses.lead_deg, 2);
  addArray('tilt (deg)', poses.tilt_deg, 2);
  addArray('gouge (mm)', poses.gouge_mm, 4);
  addArray('move gouge (mm)', poses.motion_gouge_mm, 4);
  addArray('clearance (mm)', poses.clearance_mm, 3);
  addArray('strip width (mm)', poses.strip_width_mm, 3);
  for (const key of Object.keys(poses).filter((name) => name.startsWith('extra:'))) {
    const [name, unit] = nameAndUnit(key.slice(6));
    addArray(unit ? name + ' (' + unit + ')' : name, poses[key], 3);
  }
  if (report.problems.length > 0) add('not valid because', (i) => { const run = problemAt(report, i); return run ? run[2] : '\u2013'; }, 'why');
  list.hidden = poses.count === 0;
  return { show(i) { if (poses.count > 0) for (const cell of cells) cell(i); } };
}

// The page tries itself out and writes what it saw into the document, for the test that opened it (…report.html#selftest).
function selfTest(page) {
  const verdict = document.documentElement.dataset, tip = () => page.scene.groups.tool.position.toArray().join(' ');
  page.goTo(0);
  const cursor = page.plots.cursor();
  if (page.scene) {
    const before = tip();
    verdict.colours = page.scene.countColours();
    page.seek((page.begin + page.end) / 2);
    verdict.toolMoved = tip() !== before;
    const box = document.getElementById('scene-canvas');
    page.goTo(0);
    page.scene.render();
    const near = page.scene.groups.tool.position.clone().project(page.scene.camera);
    verdict.picked = page.scene.pick((near.x + 1) / 2 * box.clientWidth, (1 - near.y) / 2 * box.clientHeight);
  }
  page.seek((page.begin + page.end) / 2);
  verdict.cursorMoved = page.plots.cursor() - cursor;
  verdict.plotColours = page.plots.countColours();
  page.goTo(0);
  page.nextProblem();
  verdict.problemPose = page.current();
  verdict.clock = document.getElementById('clock').textContent;
  verdict.errors = JSON.stringify(window.reportErrors);
}
