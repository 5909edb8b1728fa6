// Draws the scene in the page's element #scene with WebGL 2: bodies on moving frames, lines, the sea.
// World axes: x downwind, y to port, z up, in metres. Quaternions are x, y, z, w.
"use strict";

// --- data ------------------------------------------------------------------------------------------------------------

const scene = JSON.parse(document.getElementById("scene").textContent);

function unpack(text, Kind) {
  const binary = atob(text), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return new Kind(bytes.buffer);
}

const times = unpack(scene.time, Float64Array), moments = times.length, last = moments - 1;
const poses = unpack(scene.poses, Float32Array), frames = scene.frames.length;
for (const item of scene.readings) item.values = unpack(item.values, Float32Array);
for (const item of scene.curves) item.points = unpack(item.points, Uint16Array);
for (const item of scene.arrows) {
  item.lengths = unpack(item.lengths, Float32Array);
  if (item.bearings) item.bearings = unpack(item.bearings, Float32Array);
}
const water = scene.water;
if (water) for (const name of ["omega", "amplitude", "phase", "wave_number"]) water[name] = unpack(water[name], Float64Array);

// The moment before t and how far it is to the next one, from 0 to 1.
function bracket(t) {
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  const step = times[high] - times[low];
  return [low, high, step > 0 ? Math.min(Math.max((t - times[low]) / step, 0), 1) : 0];
}

// --- vectors, quaternions, matrices ----------------------------------------------------------------------------------

const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => { const n = Math.hypot(...a) || 1; return a.map((x) => x / n); };

// Between two orientations along the shortest turn.
function slerp(a, b, f) {
  let c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3], sign = 1;
  if (c < 0) { c = -c; sign = -1; }
  let p = 1 - f, q = f;
  if (c < 0.9995) {
    const angle = Math.acos(c), s = Math.sin(angle);
    p = Math.sin((1 - f) * angle) / s; q = Math.sin(f * angle) / s;
  }
  const r = a.map((x, i) => p * x + sign * q * b[i]), n = Math.hypot(...r);
  return r.map((x) => x / n);
}

// The turn from the x axis to a direction.
function turnTo(direction) {
  const d = unit(direction);
  if (d[0] < -0.999999) return [0, 0, 1, 0];
  const axis = cross([1, 0, 0], d), q = [...axis, 1 + d[0]], n = Math.hypot(...q);
  return q.map((x) => x / n);
}

// Matrices are stored by columns, as WebGL wants them.
function multiply(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2), d = near - far;
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, 2 * far * near / d, 0];
}

function lookAt(eye, right, up, back) {
  return [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
          -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
}

// --- what there is at a time -----------------------------------------------------------------------------------------

// Position and orientation of a frame; -1 is the world.
function pose(frame, t) {
  if (frame < 0) return [[0, 0, 0], [0, 0, 0, 1]];
  const [low, high, f] = bracket(t), i = 7 * (low * frames + frame), j = 7 * (high * frames + frame);
  const position = [0, 1, 2].map((k) => poses[i + k] * (1 - f) + poses[j + k] * f);
  const turn = slerp(Array.from(poses.subarray(i + 3, i + 7)), Array.from(poses.subarray(j + 3, j + 7)), f);
  return [position, turn];
}

function linePoints(curve, t) {
  const [low, high, f] = bracket(t), n = 3 * curve.count, found = new Float32Array(n);
  for (let i = 0; i < n; i++) {
    const steps = curve.points[low * n + i] * (1 - f) + curve.points[high * n + i] * f;
    found[i] = curve.low[i % 3] + curve.step[i % 3] * steps;
  }
  return found;
}

function valueAt(values, t) {
  const [low, high, f] = bracket(t);
  return values[low] * (1 - f) + values[high] * f;
}

function arrowDirection(arrow, t) {
  if (!arrow.bearings) return arrow.direction;
  const angle = valueAt(arrow.bearings, t);
  return [Math.cos(angle), Math.sin(angle), 0];
}

// Elevation at n places first, first + step, ... along the heading of the waves. Waves shorter than `shortest` are left
// out; neighbouring places differ by the same turn of each wave, so that no cosine is needed per place.
function elevations(t, first, step, n, shortest = 0) {
  const found = new Float64Array(n);
  if (!water) return found;
  const s = water.build_up > 0 ? Math.min(Math.max(t / water.build_up, 0), 1) : 1;
  const grown = s * s * s * (10 + s * (6 * s - 15));
  for (let k = 0; k < water.omega.length; k++) {
    const number = water.wave_number[k];
    if (shortest > 0 && 2 * Math.PI / number < shortest) continue;
    const angle = water.omega[k] * t - number * first + water.phase[k], a = grown * water.amplitude[k];
    let c = a * Math.cos(angle), d = a * Math.sin(angle);
    const p = Math.cos(number * step), q = Math.sin(number * step);
    for (let i = 0; i < n; i++) {
      found[i] += c;
      const next = c * p + d * q;
      d = d * p - c * q;
      c = next;
    }
  }
  return found;
}

// --- colours ---------------------------------------------------------------------------------------------------------

const THEMES = {
  light: { sky: [0.80, 0.87, 0.93], deep: [0.36, 0.56, 0.68], water: [0.27, 0.52, 0.66], ground: [0.62, 0.66, 0.66],
           line: [0.18, 0.22, 0.28], wind: [0.16, 0.45, 0.75] },
  dark: { sky: [0.055, 0.08, 0.115], deep: [0.03, 0.09, 0.14], water: [0.10, 0.30, 0.42], ground: [0.22, 0.26, 0.29],
          line: [0.72, 0.77, 0.82], wind: [0.45, 0.72, 1.0] },
};
const MATERIALS = {
  structure: [0.62, 0.66, 0.70], hull: [0.93, 0.73, 0.22], tower: [0.90, 0.91, 0.92], nacelle: [0.78, 0.81, 0.84],
  blade: [0.95, 0.96, 0.97], rod: [0.50, 0.58, 0.66], body: [0.83, 0.36, 0.22], glass: [0.93, 0.73, 0.22],
  water: [0.16, 0.50, 0.85],
};
const cover = (material) => material === "glass" ? 0.28 : 1;
let theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
const color = (material) => MATERIALS[material] || THEMES[theme].line;

// --- programs of the graphics card -----------------------------------------------------------------------------------

const canvas = document.getElementById("canvas"), gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
if (!gl) {
  document.getElementById("status").textContent =
    "This browser shows no WebGL 2, which the picture needs: switch on hardware acceleration, or take another browser.";
  throw new Error("no WebGL 2");
}

// Below the water colours fade to that of the deep.
const SUNK = `uniform vec3 deep; uniform float sunk;
vec3 under(vec3 c, float z) { return mix(c, deep, sunk * 0.72 * (1.0 - exp(min(z, 0.0) / 90.0))); }`;

const SOLID = program(`
  uniform mat4 camera; uniform vec3 place; uniform vec4 turn; uniform float size;
  in vec3 point, normal; out vec3 world, facing;
  vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
  void main() { world = place + turned(size * point); facing = turned(normal); gl_Position = camera * vec4(world, 1.0); }`, `
  uniform vec3 eye, tint; uniform float cover; ${SUNK}
  in vec3 world, facing; out vec4 pixel;
  void main() {
    vec3 view = normalize(eye - world), n = normalize(facing);
    if (dot(n, view) < -0.25) n = -n;  // the inside of an open skin; at an edge the sign is no news
    vec3 sun = normalize(vec3(-0.5, -0.6, 0.75));
    float shine = pow(max(dot(n, normalize(sun + view)), 0.0), 40.0);
    vec3 c = tint * (0.42 + 0.13 * n.z + 0.12 * dot(n, view) + 0.45 * max(dot(n, sun), 0.0)) + 0.12 * shine;
    pixel = vec4(under(c, world.z), cover);
  }`);

// Lines are ribbons that face the viewer: as wide as they are, and at least two pixels.
const RIBBON = program(`
  uniform mat4 camera; uniform vec2 screen; uniform float diameter, focal;
  in vec3 a, b; in vec2 corner; out vec3 world;
  void main() {
    vec4 p = camera * vec4(a, 1.0), q = camera * vec4(b, 1.0);
    vec4 here = corner.x < 0.5 ? p : q;
    world = corner.x < 0.5 ? a : b;
    vec2 along = q.xy / max(q.w, 1e-3) - p.xy / max(p.w, 1e-3);
    along = normalize(along * screen + vec2(1e-9, 0.0));
    float width = max(2.0, diameter * focal / max(here.w, 1e-3));
    here.xy += corner.y * vec2(-along.y, along.x) * width / screen * here.w;
    gl_Position = here;
  }`, `
  uniform vec3 tint; ${SUNK}
  in vec3 world; out vec4 pixel;
  void main() { pixel = vec4(under(tint, world.z), 1.0); }`);

const SEA = program(`
  uniform mat4 camera; uniform vec2 heading;
  in vec2 along; in vec2 surface; out vec3 world, normal;
  void main() {
    world = vec3(along.x * heading - along.y * vec2(heading.y, -heading.x), surface.x);
    normal = normalize(vec3(-surface.y * heading, 1.0));
    gl_Position = camera * vec4(world, 1.0);
  }`, `
  uniform vec3 eye, tint, sky; uniform float radius;
  in vec3 world, normal; out vec4 pixel;
  void main() {
    vec3 view = normalize(eye - world), n = normalize(normal);
    float facing = abs(dot(n, view)), edge = 1.0 - smoothstep(0.8, 1.0, length(world.xy) / radius);
    float mirror = 0.06 + 0.6 * pow(1.0 - facing, 4.0);
    float light = 0.5 + 2.2 * dot(n - vec3(0.0, 0.0, 1.0), normalize(vec3(-0.5, -0.6, 0.75))) + 0.45;
    vec3 c = mix(tint * clamp(light, 0.35, 1.8), sky, mirror);
    pixel = vec4(c, edge * mix(0.42, 0.9, mirror));
  }`);

const GROUND = program(`
  uniform mat4 camera; uniform float radius, level;
  in vec2 corner; out vec3 world;
  void main() { world = vec3(radius * corner, level); gl_Position = camera * vec4(world, 1.0); }`, `
  uniform vec3 tint, sky; uniform float radius, spacing; ${SUNK}
  in vec3 world; out vec4 pixel;
  void main() {
    vec2 cell = world.xy / spacing, width = fwidth(cell);
    vec2 near = abs(fract(cell - 0.5) - 0.5) / max(width, vec2(1e-6));
    float line = (1.0 - min(min(near.x, near.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(width.x, width.y)));
    float edge = 1.0 - smoothstep(0.75, 1.0, length(world.xy) / radius);
    vec3 c = mix(mix(tint, sky, 0.35), mix(tint, vec3(step(dot(tint, vec3(0.33)), 0.4)), 0.25), line);
    pixel = vec4(under(c, world.z), 0.9 * edge);
  }`);

function program(vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${text}`);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(made, i).name;
    places[name] = gl.getUniformLocation(made, name);
  }
  return { made, places };
}

function use(chosen, values) {
  gl.useProgram(chosen.made);
  for (const [name, value] of Object.entries(values)) {
    const at = chosen.places[name];
    if (at === undefined) continue;
    if (typeof value === "number") gl.uniform1f(at, value);
    else if (value.length === 16) gl.uniformMatrix4fv(at, false, value);
    else gl[`uniform${value.length}fv`](at, value);
  }
}

// A vertex array from named attributes: [numbers, components per vertex].
function vertices(chosen, attributes, triangles, usage = gl.STATIC_DRAW) {
  const array = gl.createVertexArray(), buffers = {};
  gl.bindVertexArray(array);
  for (const [name, [numbers, size]] of Object.entries(attributes)) {
    buffers[name] = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, usage);
    const at = gl.getAttribLocation(chosen.made, name);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
  }
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
  return { array, buffers, count: triangles.length };
}

function refill(buffer, numbers) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferSubData(gl.ARRAY_BUFFER, 0, numbers);
}

function draw(item) {
  gl.bindVertexArray(item.array);
  gl.drawElements(gl.TRIANGLES, item.count, gl.UNSIGNED_INT, 0);
}

// --- things to draw --------------------------------------------------------------------------------------------------

function solid(mesh) {
  const points = unpack(mesh.points, Float32Array), normals = unpack(mesh.normals, Float32Array);
  return vertices(SOLID, { point: [points, 3], normal: [normals, 3] }, unpack(mesh.triangles, Uint32Array));
}

// Two triangles for each pair (2 i, 2 i + 1), (2 i + 2, 2 i + 3) of vertices.
function strip(pairs, gap = 2) {
  const found = new Uint32Array(6 * pairs);
  for (let i = 0; i < pairs; i++) found.set([0, 1, 2, 1, 3, 2].map((k) => gap * i + k), 6 * i);
  return found;
}

const bodies = scene.meshes.map((mesh) => ({ frame: mesh.frame, material: mesh.material, ...solid(mesh) }));
const arrowMesh = scene.arrows.length ? solid(scene.arrow) : null;
const ribbons = scene.curves.map((curve) => {
  const pieces = curve.count - 1, corners = new Float32Array(8 * pieces);
  for (let i = 0; i < pieces; i++) corners.set([0, -1, 0, 1, 1, -1, 1, 1], 8 * i);
  const room = () => new Float32Array(12 * pieces);
  const parts = { a: [room(), 3], b: [room(), 3], corner: [corners, 2] };
  return { curve, pieces, a: room(), b: room(), ...vertices(RIBBON, parts, strip(pieces, 4), gl.DYNAMIC_DRAW) };
});

const reach = Math.hypot(scene.whole.centre[0], scene.whole.centre[1]) + scene.whole.size / 2;
const radius = Math.max(1.15 * reach, 1.5 * scene.bodies.size), STRIPS = 420;
const level = water ? -water.depth : scene.whole.low;
const spacing = 10 ** Math.floor(Math.log10(radius / 2));
const ground = vertices(GROUND, { corner: [new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), 2] }, strip(1));
const sea = water && (() => {
  const along = new Float32Array(4 * (STRIPS + 1));
  for (let i = 0; i <= STRIPS; i++) {
    const s = radius * (2 * i / STRIPS - 1), half = Math.sqrt(Math.max(radius * radius - s * s, 0));
    along.set([s, -half, s, half], 4 * i);
  }
  const surface = new Float32Array(4 * (STRIPS + 1));
  return { surface, ...vertices(SEA, { along: [along, 2], surface: [surface, 2] }, strip(STRIPS), gl.DYNAMIC_DRAW) };
})();

function moveSea(t) {
  if (sea.time === t) return;
  sea.time = t;
  const step = 2 * radius / STRIPS, height = elevations(t, -radius, step, STRIPS + 1, 3 * step);
  for (let i = 0; i <= STRIPS; i++) {
    const before = Math.max(i - 1, 0), after = Math.min(i + 1, STRIPS);
    const slope = (height[after] - height[before]) / ((after - before) * step);
    sea.surface.set([height[i], slope, height[i], slope], 4 * i);
  }
  refill(sea.buffers.surface, sea.surface);
}

function moveRibbon(ribbon, t) {
  if (ribbon.time === t) return;
  ribbon.time = t;
  const points = linePoints(ribbon.curve, t);
  for (let i = 0; i < ribbon.pieces; i++) {
    for (let corner = 0; corner < 4; corner++) {
      ribbon.a.set(points.subarray(3 * i, 3 * i + 3), 12 * i + 3 * corner);
      ribbon.b.set(points.subarray(3 * i + 3, 3 * i + 6), 12 * i + 3 * corner);
    }
  }
  refill(ribbon.buffers.a, ribbon.a);
  refill(ribbon.buffers.b, ribbon.b);
}

// --- camera ----------------------------------------------------------------------------------------------------------

const FIELD = 36 * Math.PI / 180;
const camera = { target: [0, 0, 0], distance: 1, azimuth: 0, elevation: 0 };
const VIEWS = {  // azimuth and elevation [deg] of the viewer seen from the target, what fills the window, how much nearer
  start: [scene.azimuths.start, 9, scene.bodies], front: [180, 2, scene.bodies], side: [-90, 2, scene.bodies],
  top: [-90, 89.9, scene.bodies], all: [scene.azimuths.all, 16, scene.whole, 0.75],
};
let followed = null;

function look(name) {
  const [azimuth, elevation, box, nearer = 1] = VIEWS[name], aspect = canvas.clientWidth / canvas.clientHeight;
  camera.azimuth = azimuth * Math.PI / 180;
  camera.elevation = elevation * Math.PI / 180;
  camera.target = add(box.centre, [0, 0, elevation < 45 ? -0.01 * box.size : 0]);  // the bar covers the lower edge
  camera.distance = 1.1 * nearer * box.size / 2 / Math.sin(FIELD / 2) / Math.min(1, aspect);
  if (followed) followed = pose(scene.follow, time)[0];
  stale = true;
}

function axesOfCamera() {
  const c = Math.cos(camera.elevation);
  const back = [c * Math.cos(camera.azimuth), c * Math.sin(camera.azimuth), Math.sin(camera.elevation)];
  const right = [-Math.sin(camera.azimuth), Math.cos(camera.azimuth), 0];
  return { back, right, up: cross(back, right), eye: add(camera.target, back, camera.distance) };
}

function orbit(dx, dy) {
  camera.azimuth -= 0.006 * dx;
  camera.elevation = Math.min(Math.max(camera.elevation + 0.006 * dy, -1.55), 1.55);
}

function pan(dx, dy) {
  const { right, up } = axesOfCamera(), scale = 2 * camera.distance * Math.tan(FIELD / 2) / canvas.clientHeight;
  camera.target = add(add(camera.target, right, -dx * scale), up, dy * scale);
}

function zoom(factor) {
  camera.distance = Math.min(Math.max(camera.distance * factor, 0.02 * scene.bodies.size), 8 * radius);
}

// --- drawing ---------------------------------------------------------------------------------------------------------

let time = times[0], playing = false, speed = 1, stale = true, wet = Boolean(water);

function render() {
  const ratio = Math.min(devicePixelRatio || 1, 2), colors = THEMES[theme];
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  if (followed) {
    const here = pose(scene.follow, time)[0];
    camera.target = add(camera.target, add(here, followed, -1));
    followed = here;
  }
  const { eye, right, up, back } = axesOfCamera();
  const lens = perspective(FIELD, width / height, 0.01 * camera.distance, 3 * camera.distance + 3 * radius);
  const sunk = wet && water.depth > 0 ? 1 : 0;
  const common = { camera: multiply(lens, lookAt(eye, right, up, back)), eye, sky: colors.sky, deep: colors.deep, sunk };

  gl.viewport(0, 0, width, height);
  gl.clearColor(...colors.sky, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthMask(false);  // behind everything above it, in front of nothing
  use(GROUND, { ...common, tint: colors.ground, radius, level, spacing });
  if (eye[2] > level) draw(ground);
  gl.depthMask(true);

  const drawBodies = (clear) => {
    for (const body of bodies) {
      if ((cover(body.material) < 1) !== clear) continue;
      const [place, turn] = pose(body.frame, time);
      use(SOLID, { place, turn, size: 1, tint: color(body.material), cover: cover(body.material) });
      draw(body);
    }
  };
  use(SOLID, { ...common, cover: 1 });
  drawBodies(false);
  use(SOLID, { cover: 1 });
  for (const arrow of scene.arrows) {
    const length = valueAt(arrow.lengths, time), along = arrowDirection(arrow, time);
    use(SOLID, { place: arrow.tip, turn: turnTo(length < 0 ? along.map((x) => -x) : along), size: Math.abs(length), tint: colors.wind });
    draw(arrowMesh);
  }
  const focal = height / 2 / Math.tan(FIELD / 2);
  for (const ribbon of ribbons) {
    moveRibbon(ribbon, time);
    use(RIBBON, { ...common, screen: [width, height], focal, diameter: ribbon.curve.diameter, tint: color(ribbon.curve.material) });
    draw(ribbon);
  }
  gl.depthMask(false);  // what is seen through, in front of what it holds
  use(SOLID, common);
  drawBodies(true);
  gl.depthMask(true);
  if (wet) {
    moveSea(time);
    gl.depthMask(false);
    const heading = [Math.cos(water.heading), Math.sin(water.heading)];
    use(SEA, { ...common, heading, radius, tint: colors.water });
    draw(sea);
    gl.depthMask(true);
  }
}

// --- page ------------------------------------------------------------------------------------------------------------

const byId = (name) => document.getElementById(name);
const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 50];
byId("status").textContent = `${scene.status} Grid: ${spacing} m.`;
byId("transport").hidden = last === 0;
byId("water").hidden = !water;
byId("follow").hidden = last === 0 || scene.follow < 0;
byId("readings").hidden = byId("values").hidden = !scene.readings.length;
byId("slider").min = times[0];
byId("slider").max = times[last];
for (const value of SPEEDS) byId("speed").add(new Option(`${value} x`, value));
const cells = scene.readings.map((item) => {
  const row = byId("readings").firstElementChild.insertRow();
  let unitText = item.unit === "1" ? "" : item.unit.replaceAll("*", " "), most = item.values.reduce((m, v) => Math.max(m, Math.abs(v)), 0);
  if (most >= 1e6 && /^(N|W|J|Pa)\b/.test(unitText)) {
    unitText = `M${unitText}`;
    most /= 1e6;
    item.values = item.values.map((v) => v / 1e6);
  }
  row.title = item.about;
  row.insertCell().textContent = item.name.replaceAll("_", " ");
  const cell = row.insertCell();
  row.insertCell().textContent = unitText;
  const digits = most > 0 ? Math.min(Math.max(3 - Math.ceil(Math.log10(most)), 0), 3) : 2;
  return { cell, digits, values: item.values };
});

// The directions of the world in the corner: x downwind, y to port, z up; those that point away are drawn first.
const AXES = [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]];
function showAxes() {
  const { back, right, up } = axesOfCamera(), along = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const drawn = AXES.map(([name, axis]) => ({ name, x: 26 * along(axis, right), y: -26 * along(axis, up), near: along(axis, back) }));
  byId("axes").innerHTML = drawn.sort((a, b) => a.near - b.near).map(({ name, x, y }) =>
    `<g class="${name}"><line x2="${x.toFixed(1)}" y2="${y.toFixed(1)}"/><text x="${(1.32 * x).toFixed(1)}" y="${(1.32 * y).toFixed(1)}">${name}</text></g>`).join("");
}

function tell() {
  showAxes();
  for (const item of cells) item.cell.textContent = valueAt(item.values, time).toFixed(item.digits).replace(/^-(0\.?0*)$/, "$1");
  byId("time").textContent = `${time.toFixed(1)} / ${times[last].toFixed(0)} s`;
  byId("slider").value = time;
}

function setTime(t) { time = Math.min(Math.max(t, times[0]), times[last]); stale = true; }
function setPlaying(on) {
  playing = on && last > 0;
  if (playing && time >= times[last]) setTime(times[0]);
  byId("play").textContent = playing ? "Pause" : "Play";
}
function setSpeed(value) { speed = value; byId("speed").value = value; }
function setTheme(name) { theme = name; document.documentElement.dataset.theme = name; stale = true; }
function setFollow(on) {
  followed = on && scene.follow >= 0 ? pose(scene.follow, time)[0] : null;
  byId("follow").setAttribute("aria-pressed", String(Boolean(followed)));
}
function setWater(on) { wet = on && Boolean(water); byId("water").setAttribute("aria-pressed", String(wet)); stale = true; }
function toggleReadings() { byId("readings").hidden = !byId("readings").hidden; }
function toggleHelp() { byId("help").hidden = !byId("help").hidden; }

byId("play").onclick = () => setPlaying(!playing);
byId("slider").oninput = (event) => setTime(Number(event.target.value));
byId("speed").onchange = (event) => setSpeed(Number(event.target.value));
byId("follow").onclick = () => setFollow(!followed);
byId("water").onclick = () => setWater(!wet);
byId("theme").onclick = () => setTheme(theme === "dark" ? "light" : "dark");
byId("values").onclick = toggleReadings;
byId("ask").onclick = byId("help").onclick = toggleHelp;
byId("views").onclick = (event) => { if (event.target.dataset.view) look(event.target.dataset.view); };

const KEYS = {
  " ": () => setPlaying(!playing), f: () => setFollow(!followed), w: () => setWater(!wet), v: toggleReadings, h: toggleHelp, "?": toggleHelp,
  t: () => byId("theme").onclick(), Home: () => setTime(times[0]), End: () => setTime(times[last]),
  ArrowLeft: () => setTime(times[Math.max(bracket(time - 1e-6)[0], 0)]),
  ArrowRight: () => setTime(times[Math.min(bracket(time + 1e-6)[0] + 1, last)]),
  "+": () => setSpeed(SPEEDS[Math.min(SPEEDS.indexOf(speed) + 1, SPEEDS.length - 1)]),
  "-": () => setSpeed(SPEEDS[Math.max(SPEEDS.indexOf(speed) - 1, 0)]),
};
Object.keys(VIEWS).forEach((name, i) => { KEYS[i + 1] = () => look(name); });
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT" || !KEYS[event.key]) return;
  if (event.target.tagName === "BUTTON" && event.key === " ") return;  // the button does it
  event.preventDefault();
  KEYS[event.key]();
});

// Pointers: one turns or moves, two move and zoom.
const pointers = new Map();
canvas.addEventListener("pointerdown", (event) => {
  pointers.set(event.pointerId, event);
  canvas.setPointerCapture(event.pointerId);
});
canvas.addEventListener("pointermove", (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
  if (pointers.size === 2) {
    const other = [...pointers.entries()].find(([id]) => id !== event.pointerId)[1];
    const apart = (e) => Math.hypot(e.clientX - other.clientX, e.clientY - other.clientY) || 1;
    zoom(apart(before) / apart(event));
    pan(dx / 2, dy / 2);
  } else if (before.button === 2 || before.button === 1 || event.shiftKey) pan(dx, dy);
  else orbit(dx, dy);
  pointers.set(event.pointerId, { button: before.button, clientX: event.clientX, clientY: event.clientY });
  stale = true;
});
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(0.0012 * event.deltaY * (event.deltaMode === 1 ? 30 : 1)));
  stale = true;
}, { passive: false });
addEventListener("resize", () => { stale = true; });

let before = null;
function tick(now) {
  if (playing && before !== null) {
    const next = time + speed * Math.min(now - before, 250) / 1000;
    setTime(scene.loop && next >= times[last] ? times[0] + (next - times[last]) % (times[last] - times[0]) : next);
    if (time >= times[last]) setPlaying(false);
  }
  before = now;
  if (stale) { stale = false; render(); tell(); }
  requestAnimationFrame(tick);
}

// A link may name a moment and a view: #t=12.5&view=side&theme=dark&play&follow&dry&speed=5
function obey(hash) {
  const wish = new URLSearchParams(hash.slice(1));
  setTheme(wish.get("theme") === "dark" || wish.get("theme") === "light" ? wish.get("theme") : theme);
  setWater(!wish.has("dry"));
  setSpeed(SPEEDS.includes(Number(wish.get("speed"))) ? Number(wish.get("speed")) : 1);
  if (Number.isFinite(parseFloat(wish.get("t")))) setTime(parseFloat(wish.get("t")));
  look(wish.get("view") in VIEWS ? wish.get("view") : "start");
  setFollow(wish.has("follow"));
  setPlaying(wish.has("play") || (scene.loop && !wish.has("t")));
}

obey(location.hash);
addEventListener("hashchange", () => obey(location.hash));
stale = false;
render();
tell();
document.documentElement.dataset.ready = "yes";
requestAnimationFrame(tick);
window.fowtView = { scene, pose, linePoints, elevations, valueAt };
