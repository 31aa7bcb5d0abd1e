// The 3-D picture: bodies, path, needles and the tool. Coordinates are millimetres from report.origin.

const NEEDLES_SHOWN = 700;   // more than this is fur, not information
const PICK_PIXELS = 12;       // a click this near to a pose means that pose

function makeScene(report, canvas) {
  const poses = report.poses, count = poses.count;
  const renderer = new THREE.WebGLRenderer({ canvas: canvas, antialias: true, alpha: true });
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  renderer.autoClear = false;
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(28, 1, 1, 1000);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.screenSpacePanning = true;
  controls.keys = {};  // arrow keys step through the poses
  const coloured = [];  // [colour, name in the style sheet]: set again when light and dark change
  const colour = (name) => { const c = new THREE.Color(cssColour(name)); coloured.push([c, name]); return c; };

  // A key light that moves with the eye, so that every side that is looked at is lit, and a soft sky.
  scene.add(new THREE.HemisphereLight(0xffffff, 0x9a9388, 0.55));
  const key = new THREE.DirectionalLight(0xffffff, 0.5), fill = new THREE.DirectionalLight(0xffffff, 0.18);
  key.position.set(-0.5, 0.7, 0.8);
  fill.position.set(0.9, 0.1, 0.4);
  camera.add(key, fill);
  scene.add(camera);

  const surface = (name, options) => {
    const material = new THREE.MeshPhongMaterial(Object.assign({ specular: 0x222222, shininess: 30, side: THREE.DoubleSide }, options));
    material.color = colour(name);
    return material;
  };
  const line = (name, options) => {
    const material = new THREE.LineBasicMaterial(options);
    material.color = colour(name);
    return material;
  };

  // Bodies. The offset lets lines that lie on a surface win over it.
  const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 };
  const materials = { plain: surface('part', offset), machined: surface('machined', offset), check: surface('check', offset) };
  const edgeMaterial = line('edge', { transparent: true, opacity: 0.55 });
  const groups = { check: new THREE.Group(), part: new THREE.Group(), needles: new THREE.Group(), links: new THREE.Group(), tool: new THREE.Group() };
  for (const body of report.bodies) {
    const group = body.role === 'check' ? groups.check : groups.part;
    const positions = new THREE.BufferAttribute(body.positions, 3), normals = new THREE.BufferAttribute(body.normals, 3, true);
    for (const piece of ['plain', 'machined']) {
      if (body[piece].length === 0) continue;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', positions);
      geometry.setAttribute('normal', normals);
      geometry.setIndex(new THREE.BufferAttribute(body[piece], 1));
      group.add(new THREE.Mesh(geometry, body.role === 'check' ? materials.check : materials[piece]));
    }
    if (body.edges.length > 0) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', positions);
      geometry.setIndex(new THREE.BufferAttribute(body.edges, 1));
      group.add(new THREE.LineSegments(geometry, edgeMaterial));
    }
  }

  // The path: one set of segments per kind, all on one vertex array. The move that leads to a pose has that pose's kind.
  const pathGeometry = new THREE.BufferAttribute(poses.cl || new Float32Array(0), 3);
  const segments = { cut: [], lead: [], link: [], invalid: [] };
  const kinds = { 'cut': 'cut', 'lead-in': 'lead', 'lead-out': 'lead', 'link': 'link' };
  const passList = report.passes.length > 0 ? report.passes : [[0, count, 'cut']];
  for (const [first, length, kind] of passList)
    for (let i = Math.max(first, 1); i < first + length; ++i)
      segments[poses.valid && !poses.valid[i] ? 'invalid' : kinds[kind]].push(i - 1, i);
  for (const kind of Object.keys(segments)) {
    if (segments[kind].length === 0) continue;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', pathGeometry);
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(segments[kind]), 1));
    // Hundreds of links side by side would hide the part they fly over: the more there are, the fainter each one.
    const faint = kind === 'link' ? Math.max(0.12, Math.min(0.9, 60 / Math.max(1, segments[kind].length / 40))) : 1;
    const lines = new THREE.LineSegments(geometry, line(kind, faint < 1 ? { transparent: true, opacity: faint, depthWrite: false } : {}));
    lines.frustumCulled = false;
    (kind === 'lead' || kind === 'link' ? groups.links : scene).add(lines);
  }

  // Needles along the tool axes; where there are too many, every so many-th, but the invalid ones first.
  const size = 2 * Math.hypot(report.half[0], report.half[1], report.half[2]) || 1;
  const needleLength = 0.07 * size;
  const wanted = { needle: [], invalid: [] };
  const problemStep = Math.ceil(report.problems.reduce((sum, run) => sum + run[1], 0) / NEEDLES_SHOWN) || 1;
  for (const [first, length] of report.problems)
    for (let i = first; i < first + length; i += problemStep) wanted.invalid.push(i);
  const isCut = passList.filter((pass) => pass[2] === 'cut');
  const step = Math.ceil(isCut.reduce((sum, pass) => sum + pass[1], 0) / NEEDLES_SHOWN) || 1;
  for (const [first, length] of isCut)
    for (let i = first; i < first + length; i += step) if (!poses.valid || poses.valid[i]) wanted.needle.push(i);
  for (const name of ['needle', 'invalid']) {
    const points = new Float32Array(6 * wanted[name].length);
    wanted[name].forEach((i, slot) => {
      for (let k = 0; k < 3; ++k) {
        points[6 * slot + k] = poses.cl[3 * i + k];
        points[6 * slot + 3 + k] = poses.cl[3 * i + k] + needleLength * poses.axis[3 * i + k];
      }
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(points, 3));
    const needles = new THREE.LineSegments(geometry, line(name, { transparent: true, opacity: name === 'needle' ? 0.5 : 0.9 }));
    needles.frustumCulled = false;
    groups.needles.add(needles);
  }

  // The tool: each piece's outline turned about its axis (three.js turns about y), split where the outline has a corner
  // so that the corner stays sharp under the light.
  let toolRadius = 0, toolTop = 0;
  for (const piece of report.tool) {
    const material = surface(piece.name.startsWith('holder') ? 'holder' : piece.name.startsWith('shank') ? 'shank' : 'cutter', { specular: 0x555555, shininess: 60 });
    for (const [radius, height] of piece.outline) { toolRadius = Math.max(toolRadius, radius); toolTop = Math.max(toolTop, height); }
    for (const run of smoothRuns(piece.outline.map(([r, h]) => new THREE.Vector2(Math.max(r, 0), h))))
      groups.tool.add(new THREE.Mesh(new THREE.LatheBufferGeometry(run, 72), material));
  }

  Object.keys(groups).forEach((name) => scene.add(groups[name]));

  // The three directions in the corner, drawn after the picture.
  const corner = makeCorner();

  const up = new THREE.Vector3(0, 1, 0), axis = new THREE.Vector3(), other = new THREE.Vector3();
  let asked = false;
  function render() {
    asked = false;
    const distance = camera.position.distanceTo(controls.target);
    camera.near = Math.max(distance - 4 * reach(), distance * 0.02);
    camera.far = distance + 4 * reach();
    camera.updateProjectionMatrix();
    renderer.clear();
    renderer.render(scene, camera);
    corner.render(renderer, camera);
  }
  function ask() {
    if (!asked) requestAnimationFrame(render);
    asked = true;
  }
  const reach = () => size + toolTop;
  controls.addEventListener('change', ask);
  let fitted = null;  // the view that was asked for, until the user moves it
  controls.addEventListener('start', () => { fitted = null; });

  // The pose between k and k + 1: tip on a straight line, axis on a great circle (as the motion was checked).
  function placeTool(k, fraction) {
    if (count === 0) return;
    const n = Math.min(k + 1, count - 1), cl = poses.cl, a = poses.axis;
    groups.tool.position.set(...[0, 1, 2].map((c) => cl[3 * k + c] + fraction * (cl[3 * n + c] - cl[3 * k + c])));
    axis.set(a[3 * k], a[3 * k + 1], a[3 * k + 2]);
    other.set(a[3 * n], a[3 * n + 1], a[3 * n + 2]);
    const angle = axis.angleTo(other);
    if (angle > 0) axis.multiplyScalar(Math.sin((1 - fraction) * angle)).addScaledVector(other, Math.sin(fraction * angle));
    groups.tool.quaternion.setFromUnitVectors(up, axis.normalize());
    groups.tool.updateMatrixWorld();
    ask();
  }

  // Everything that must be seen: the part's box, the check bodies unless they dwarf it, and the tool where it stands.
  const partBox = new THREE.Box3(new THREE.Vector3(...report.half).negate(), new THREE.Vector3(...report.half));
  const wholeBox = groups.check.children.length > 0 ? new THREE.Box3().setFromObject(groups.check).union(partBox) : partBox;
  const shownWhole = wholeBox.getSize(new THREE.Vector3()).length() < 2.5 * size;
  function outerPoints() {
    const points = [], box = shownWhole && groups.check.visible ? wholeBox : partBox;
    for (let corners = 0; corners < 8; ++corners)
      points.push(new THREE.Vector3(...['x', 'y', 'z'].map((k, bit) => (corners >> bit & 1 ? box.max : box.min)[k])));
    if (groups.tool.visible && toolTop > 0)
      for (const height of [0, toolTop])
        for (const [x, z] of [[1, 0], [-1, 0], [0, 1], [0, -1]])
          points.push(groups.tool.localToWorld(new THREE.Vector3(x * toolRadius, height, z * toolRadius)));
    return points;
  }

  const directions = { iso: [-0.55, -0.75, 0.5], top: [0, -1e-4, 1], front: [0, -1, 0], right: [1, 0, 0] };
  // Moves the eye along `direction` (default: where it is) to the nearest place that sees all outer points.
  function fit(view) {
    const back = directions[view] ? new THREE.Vector3(...directions[view]) : camera.position.clone().sub(controls.target);
    back.normalize();
    const right = new THREE.Vector3().crossVectors(camera.up, back).normalize(), top = new THREE.Vector3().crossVectors(back, right);
    const tall = Math.tan(camera.fov * Math.PI / 360) * 0.92, broad = tall * camera.aspect;
    const points = outerPoints().map((p) => [p.dot(right), p.dot(top), p.dot(back)]);
    // A point (x, y, z) is in view from (X, Y, Z) if |x - X| <= broad (Z - z) and |y - Y| <= tall (Z - z): each pair of
    // sides meets in one place, and the farther of the two decides.
    const extent = (k, slope) => {
      const plus = Math.max(...points.map((p) => p[k] + slope * p[2])), minus = Math.max(...points.map((p) => slope * p[2] - p[k]));
      return { middle: (plus - minus) / 2, distance: (plus + minus) / (2 * slope) };
    };
    const x = extent(0, broad), y = extent(1, tall), z = Math.max(x.distance, y.distance);
    const eye = right.clone().multiplyScalar(x.middle).addScaledVector(top, y.middle);
    controls.target.copy(eye).addScaledVector(back, points.reduce((sum, p) => sum + p[2], 0) / points.length);
    camera.position.copy(eye).addScaledVector(back, z);
    controls.update();
    fitted = view || 'fit';
    ask();
  }

  function resize() {
    const box = canvas.parentElement.getBoundingClientRect();
    if (box.width === 0 || box.height === 0) return;
    renderer.setSize(box.width, box.height, false);
    camera.aspect = box.width / box.height;
    camera.updateProjectionMatrix();
    if (fitted) fit(fitted);
    render();  // at once: setting the size has emptied the canvas
  }

  // Pose nearest to a place on the canvas (CSS pixels), or -1.
  function pick(x, y) {
    camera.updateMatrixWorld();
    const matrix = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements;
    const cl = poses.cl || [], width = canvas.clientWidth, height = canvas.clientHeight;
    let best = -1, least = PICK_PIXELS * PICK_PIXELS;
    for (let i = 0; i < count; ++i) {
      const a = cl[3 * i], b = cl[3 * i + 1], c = cl[3 * i + 2];
      const w = matrix[3] * a + matrix[7] * b + matrix[11] * c + matrix[15];
      const dx = ((matrix[0] * a + matrix[4] * b + matrix[8] * c + matrix[12]) / w + 1) * width / 2 - x;
      const dy = (1 - (matrix[1] * a + matrix[5] * b + matrix[9] * c + matrix[13]) / w) * height / 2 - y;
      if (dx * dx + dy * dy < least) { least = dx * dx + dy * dy; best = i; }
    }
    return best;
  }

  function setOpacity(opacity) {
    for (const material of [materials.plain, materials.machined]) {
      material.opacity = opacity;
      material.transparent = opacity < 1;
      material.depthWrite = opacity >= 0.5;
    }
    groups.part.visible = opacity > 0;
    ask();
  }

  function recolour() {
    for (const [target, name] of coloured) target.set(cssColour(name));
    ask();
  }

  return {
    camera, groups, render, ask, placeTool, fit, resize, pick, setOpacity, recolour,
    show(name, visible) { groups[name].visible = visible; ask(); },
    has: (name) => groups[name].children.length > 0,
    hasKind: (kind) => segments[kind].length > 0,
    // For the page's own test: how many different colours the picture has.
    countColours() {
      render();
      const gl = renderer.getContext(), width = gl.drawingBufferWidth, height = gl.drawingBufferHeight, pixels = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return new Set(new Uint32Array(pixels.buffer)).size;
    },
  };
}

// Pieces of a polyline between corners of more than 25 degrees.
function smoothRuns(points) {
  const distinct = points.filter((p, i) => i === 0 || p.distanceTo(points[i - 1]) > 0);
  const runs = [];
  let run = distinct.slice(0, 1);
  for (let i = 1; i < distinct.length; ++i) {
    run.push(distinct[i]);
    if (i + 1 === distinct.length) break;
    const before = distinct[i].clone().sub(distinct[i - 1]).normalize(), after = distinct[i + 1].clone().sub(distinct[i]).normalize();
    if (before.dot(after) < Math.cos(25 * Math.PI / 180)) { runs.push(run); run = [distinct[i]]; }
  }
  if (run.length > 1) runs.push(run);
  return runs;
}

// X, Y and Z of the workpiece as three arrows in the lower left corner.
function makeCorner() {
  const scene = new THREE.Scene(), camera = new THREE.OrthographicCamera(-1.55, 1.55, 1.55, -1.55, 0.1, 10);
  camera.up.set(0, 0, 1);
  [['X', 0xd03a3a, [1, 0, 0]], ['Y', 0x2f9e44, [0, 1, 0]], ['Z', 0x2f6fd0, [0, 0, 1]]].forEach(([letter, hue, direction]) => {
    const along = new THREE.Vector3(...direction);
    scene.add(new THREE.ArrowHelper(along, new THREE.Vector3(), 1, hue, 0.3, 0.18));
    const label = document.createElement('canvas');
    label.width = label.height = 64;
    const context = label.getContext('2d');
    context.font = 'bold 48px sans-serif';
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillStyle = '#' + hue.toString(16).padStart(6, '0');
    context.fillText(letter, 32, 34);
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: new THREE.CanvasTexture(label), depthTest: false }));
    sprite.position.copy(along).multiplyScalar(1.28);
    sprite.scale.set(0.5, 0.5, 1);
    scene.add(sprite);
  });
  return {
    render(renderer, eye) {
      const full = renderer.getSize(new THREE.Vector2()), side = 84;
      eye.getWorldDirection(camera.position).multiplyScalar(-4);
      camera.lookAt(0, 0, 0);
      renderer.setViewport(4, 4, side, side);
      renderer.clearDepth();
      renderer.render(scene, camera);
      renderer.setViewport(0, 0, full.x, full.y);
    },
  };
}
