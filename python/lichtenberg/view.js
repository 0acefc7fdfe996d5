// The page of a run: particles drawn by WebGL2, observables as curves. view.py says how the arrays are stored.
"use strict";

// ---- Arrays ----

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Numbers of 2 or 4 bytes out of planes of bytes, each row of so many the sum of all differences up to it. */
function summed(planes, size, row) {
  const count = planes.length / size;
  const values = size === 2 ? new Uint16Array(count) : new Uint32Array(count);
  for (let b = 0; b < size; b++)
    for (let i = 0, at = b * count; i < count; i++, at++) values[i] += planes[at] << (8 * b);
  for (let i = row; i < count; i++) values[i] += values[i - row];
  return values;
}

async function unpacked(base64, size, row) {
  return summed(await inflated(bytesOf(base64)), size, row);
}

const floats = (values) => new Float32Array(values.buffer);
const integers = (values) => new Int32Array(values.buffer);

// ---- Colours ----

const MAPS = {  // equally far apart; of one sign, of two
  one: ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"],
  two: ["#053061", "#2166ac", "#4393c3", "#92c5de", "#f7f7f7", "#f4a582", "#d6604d", "#b2182b", "#67001f"],
};
const UNKNOWN = [200, 200, 200];  // of what is no number

const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

/** 256 colours, 3 bytes each, between those of a map. */
function table(map) {
  const stops = MAPS[map].map(channels);
  return Uint8Array.from({ length: 768 }, (_, i) => {
    const at = Math.floor(i / 3) / 255 * (stops.length - 1);
    const k = Math.min(Math.floor(at), stops.length - 2);
    return Math.round(stops[k][i % 3] + (at - k) * (stops[k + 1][i % 3] - stops[k][i % 3]));
  });
}

/** 4 bytes a value; what lies beyond low or high has the colour of the end. */
function shades(values, low, high, colours) {
  const result = new Uint8Array(4 * values.length).fill(255);
  const steps = high > low ? 255 / (high - low) : 0;
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    const at = 3 * Math.max(0, Math.min(255, Math.round((value - low) * steps)));
    for (let k = 0; k < 3; k++) result[4 * i + k] = value === value ? colours[at + k] : UNKNOWN[k];
  }
  return result;
}

/** Of a set by its number, as set_colours of ranges.py. */
function setColour(n) {
  const hue = ((0.6 + n * 0.6180339887) % 1 + 1) % 1, light = [0.5, 0.68, 0.34][((n % 3) + 3) % 3];
  const swing = 0.6 * Math.min(light, 1 - light);
  return [0, 8, 4].map((k) => {  // of red, green and blue, in twelfths of the circle
    const at = (k + 12 * hue) % 12;
    return Math.round(255 * (light - swing * Math.max(-1, Math.min(at - 3, 9 - at, 1))));
  });
}

/** 4 bytes a particle by the set that it is in, pale grey for sets of one. */
function setShades(values) {
  const size = new Map();
  for (const value of values) size.set(value, (size.get(value) || 0) + 1);
  const result = new Uint8Array(4 * values.length).fill(255);
  values.forEach((value, i) => {
    const colour = size.get(value) === 1 ? [220, 220, 220] : setColour(value);
    result.set(colour, 4 * i);
  });
  return result;
}

/** Least and largest. */
function spanOf(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

// ---- Space ----

/** Product of 4 x 4 matrices, columns one after the other. */
function times(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++)
      for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

function apply(matrix, [x, y, z]) {
  return [0, 1, 2, 3].map((i) => matrix[i] * x + matrix[4 + i] * y + matrix[8 + i] * z + matrix[12 + i]);
}

/** The axes of the box, with their signs, that point to the right, up and towards the eye. `down`: the direction of the
 * fall, of which the axis that is nearest to it counts; null: y points up. */
function frameOf(down) {
  if (!down) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const axis = down.reduce((most, part, k) => Math.abs(part) > Math.abs(down[most]) ? k : most, 0);
  const [right, up] = [[0, 0, 0], [0, 0, 0]];
  up[axis] = -Math.sign(down[axis]);
  right[axis === 0 ? 1 : 0] = 1;
  return [right, up, [0, 1, 2].map((k) => right[(k + 1) % 3] * up[(k + 2) % 3] - right[(k + 2) % 3] * up[(k + 1) % 3])];
}

/** The eye looks at a point `centre`: from above in the plane, else turned about the axis that points up (frameOf). */
class Camera {
  constructor(size, dimension, down) {
    this.spatial = dimension === 3;
    this.frame = frameOf(this.spatial ? down : null);
    this.size = size;
    this.reset();
  }

  reset() {
    this.centre = this.size.map((length) => length / 2);
    this.turn = 0.5;
    this.rise = 0.3;
    this.span = this.spatial ? 1.1 * Math.hypot(...this.size) : 1.04 * Math.max(this.size[0], this.size[1]);  // height of what is seen
  }

  /** [view, projection] for a picture of that aspect. */
  matrices(aspect) {
    const [x, y, z] = this.centre;
    const away = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1];
    if (!this.spatial) {
      const height = this.span / Math.min(1, aspect);
      const scale = [2 / (height * aspect), 2 / height, -1 / (4 * height)];
      return [away, [scale[0], 0, 0, 0, 0, scale[1], 0, 0, 0, 0, scale[2], 0, 0, 0, 0, 1]];
    }
    const distance = this.distance();
    const [c, s, cr, sr] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.rise), Math.sin(this.rise)];
    const turned = [c, sr * s, cr * s, 0, 0, cr, -sr, 0, -s, sr * c, cr * c, 0, 0, 0, -distance, 1];
    const [near, far, f] = [distance / 50, 6 * distance + 3 * Math.hypot(...this.size), 2];
    const depth = [(far + near) / (near - far), 2 * far * near / (near - far)];
    const squeeze = Math.min(1, aspect);
    const upright = [...[0, 1, 2].flatMap((k) => [...this.frame.map((axis) => axis[k]), 0]), 0, 0, 0, 1];
    return [times(turned, times(upright, away)), [f * squeeze / aspect, 0, 0, 0, 0, f * squeeze, 0, 0, 0, 0, depth[0], -1, 0, 0, depth[1], 0]];
  }

  distance() { return this.span; }  // for f = 2 what is seen there is as high as it is far

  /** By pixels, in a picture `height` pixels high. */
  drag(dx, dy, height, sideways) {
    if (this.spatial && !sideways) {
      this.turn += dx * 0.008;
      this.rise = Math.max(-1.55, Math.min(1.55, this.rise + dy * 0.008));
      return;
    }
    const unit = this.span / height;
    const [c, s] = this.spatial ? [Math.cos(this.turn), Math.sin(this.turn)] : [1, 0];
    const moved = [-dx * unit * c, dy * unit, dx * unit * s];  // to the right, up, towards the eye
    this.centre = this.centre.map((place, k) => this.frame.reduce((sum, axis, n) => sum + moved[n] * axis[k], place));
  }

  zoom(factor) { this.span *= factor; }
}

// ---- Drawing ----

const PARTICLES = [`#version 300 es
  in vec2 corner; in vec3 place; in float radius; in vec4 colour;
  uniform mat4 view, projection; uniform vec3 low, extent; uniform float factor;
  out vec2 at; out vec4 shade; out vec3 middle; out float size;
  void main() {
    middle = (view * vec4(low + place * extent, 1)).xyz;
    size = radius * factor;
    at = corner * 1.1;  // room for the edge's smoothing
    shade = colour;
    gl_Position = projection * vec4(middle + vec3(at * size, 0), 1);
  }`, `#version 300 es
  precision highp float;
  in vec2 at; in vec4 shade; in vec3 middle; in float size;
  uniform mat4 projection; uniform bool flat_; uniform vec2 fog;
  out vec4 pixel;
  void main() {
    float r = length(at), soft = fwidth(r);
    if (r > 1.0 + (flat_ ? soft : 0.0)) discard;
    if (flat_) {
      float rim = smoothstep(0.88 - soft, 0.88 + soft, r) * (1.0 - smoothstep(0.1, 0.4, soft));
      pixel = vec4(mix(shade.rgb, vec3(0.1), rim), clamp((1.0 - r) / max(soft, 1e-6) + 0.5, 0.0, 1.0));
      gl_FragDepth = gl_FragCoord.z;
    } else {
      float up = sqrt(1.0 - min(r * r, 1.0));
      vec4 surface = projection * vec4(middle + vec3(at, up) * size, 1);
      gl_FragDepth = 0.5 * surface.z / surface.w + 0.5;
      float light = 0.35 + 0.65 * clamp(dot(vec3(at, up), vec3(-0.35, 0.5, 0.79)), 0.0, 1.0);
      pixel = vec4(mix(shade.rgb * light, vec3(1), 0.3 * clamp((-middle.z - fog.x) / fog.y, 0.0, 1.0)), 1);
    }
  }`];

const LINES = [`#version 300 es
  in vec2 corner; in vec3 from, to;
  uniform mat4 view, projection; uniform vec2 pixels; uniform float width;
  void main() {
    vec4 a = projection * view * vec4(from, 1), b = projection * view * vec4(to, 1);
    vec2 along = (b.xy / b.w - a.xy / a.w) * pixels;
    along = dot(along, along) > 0.0 ? normalize(along) : vec2(1, 0);
    vec4 end = corner.x < 0.0 ? a : b;
    vec2 aside = vec2(-along.y, along.x) * corner.y + along * corner.x;  // square caps
    gl_Position = end + vec4(aside * width / pixels * end.w, 0, 0);
  }`, `#version 300 es
  precision highp float;
  uniform vec4 ink; out vec4 pixel;
  void main() { pixel = ink; }`];

function compiled(gl, [vertex, fragment]) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return program;
}

/** Many copies of one square: attributes are given by name, one value a copy. */
class Copies {
  constructor(gl, sources) {
    this.gl = gl;
    this.program = compiled(gl, sources);
    this.array = gl.createVertexArray();
    this.buffers = {};
    this.count = 0;
    this.set("corner", new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), 2, gl.FLOAT, 0);
  }

  /** `step` floats or integers apart, from an offset in bytes; integers come as shares of the largest. */
  set(name, data, components, type, divisor = 1, stride = 0, offset = 0) {
    const { gl } = this;
    const place = gl.getAttribLocation(this.program, name);
    gl.bindVertexArray(this.array);
    this.buffers[name] ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, components, type, true, stride, offset);
    gl.vertexAttribDivisor(place, divisor);
  }

  draw(uniforms) {
    if (this.count === 0) return;
    const { gl } = this;
    gl.useProgram(this.program);
    for (const [name, value] of Object.entries(uniforms)) {
      const place = gl.getUniformLocation(this.program, name);
      if (typeof value === "boolean") gl.uniform1i(place, value);
      else if (typeof value === "number") gl.uniform1f(place, value);
      else if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
      else gl[`uniform${value.length}fv`](place, value);
    }
    gl.bindVertexArray(this.array);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
  }
}

class Lines extends Copies {
  constructor(gl) { super(gl, LINES); }

  /** Six numbers a line, its ends. */
  ends(numbers) {
    this.count = numbers.length / 6;
    this.set("from", numbers, 3, this.gl.FLOAT, 1, 24, 0);
    this.set("to", numbers, 3, this.gl.FLOAT, 1, 24, 12);
  }
}

function circle([x, y], radius) {
  const ends = [];
  const point = (k) => [x + radius * Math.cos(k * Math.PI / 90), y + radius * Math.sin(k * Math.PI / 90), 0];
  for (let k = 0; k < 180; k++) ends.push(...point(k), ...point(k + 1));
  return ends;
}

/** Of a rectangle or a box between two corners. */
function edgesBetween(low, high) {
  const axes = [0, 1, 2].filter((k) => high[k] > low[k]);
  const corners = Array.from({ length: 1 << axes.length }, (_, i) => low.map((start, k) => i & 1 << axes.indexOf(k) ? high[k] : start));
  return corners.flatMap((corner, i) => axes.map((_, bit) => 1 << bit).filter((bit) => !(i & bit)).flatMap((bit) => [...corner, ...corners[i | bit]]));
}

/** Ends of the lines of an electrode's outline; spheres are drawn like particles. */
function outline(electrode) {
  if (electrode.shape === "sphere") return [];
  if (electrode.shape === "face") return edgesBetween(electrode.low, electrode.high);
  if (electrode.shape === "side") {
    const [a, b, c, d] = electrode.ends;
    return [a, b, 0, c, d, 0];
  }
  if (electrode.shape !== "bar") return circle(electrode.centre, electrode.radius);
  const [[a, b], [c, d]] = [electrode.from, electrode.to];
  const half = electrode.width / 2 / Math.hypot(c - a, d - b);
  const [x, y] = [-(d - b) * half, (c - a) * half];
  const corners = [[a + x, b + y], [c + x, d + y], [c - x, d - y], [a - x, b - y]];
  return corners.flatMap(([p, q], k) => [p, q, 0, ...corners[(k + 1) % 4], 0]);
}

// ---- The run ----

class Run {
  constructor(about) {
    this.about = about;
    this.size = [...about.size, 0].slice(0, 3);
    this.extent = about.high.map((high, k) => high - about.low[k]);
  }

  async unpack(arrays) {
    const { count } = this.about;
    this.places = await unpacked(arrays.places, 2, 3 * count);
    this.radius = floats(await unpacked(arrays.radius, 4, count));
    this.columns = {};
    for (const column of this.about.columns) {
      const values = await unpacked(arrays[`column ${column.name}`], 4, count);
      this.columns[column.name] = { ...column, values: column.sets ? integers(values) : floats(values) };
    }
    for (const kind of ["contacts", "tree"]) {
      if (!(kind in this.about)) continue;
      const total = this.about[kind].at(-1) ?? 0;
      this[kind] = integers(await unpacked(arrays[kind], 4, total));
    }
    if (arrays.ground) {
      this.ground = floats(await unpacked(arrays.ground, 4, Infinity));
      this.groundEnds = this.countGroundEdges();
    }
    return this;
  }

  /** Where each frame's edges to the ground end. */
  countGroundEdges() {
    const to = this.tree.subarray(this.tree.length / 2);
    let [k, sum] = [0, 0];
    return this.about.tree.map((end) => {
      for (; k < end; k++) sum += to[k] === -1;
      return sum;
    });
  }

  /** Values of a column in a frame. */
  values(name, frame) {
    const { values, changes } = this.columns[name];
    return changes ? values.subarray(frame * this.about.count, (frame + 1) * this.about.count) : values;
  }

  place(frame, i) {
    const result = [0, 0, 0];
    this.putPlace(result, 0, frame, i);
    return result;
  }

  /** Six numbers an edge: of a pair around a periodic box, to the nearest image. Walls have no place. */
  edges(kind, frame) {
    const [begin, end] = [frame > 0 ? this.about[kind][frame - 1] : 0, this.about[kind][frame]];
    const pairs = this[kind];
    const half = pairs.length / 2;
    const result = new Float32Array(6 * (end - begin));
    let used = 0;
    let ground = kind === "tree" && frame > 0 ? this.groundEnds[frame - 1] : 0;
    for (let e = begin; e < end; e++) {
      const j = pairs[half + e];
      const inside = j >= 0 && j < this.about.count;
      if (!inside && kind !== "tree") continue;
      this.putPlace(result, used, frame, pairs[e]);
      if (inside) this.putPlace(result, used + 3, frame, j);
      else for (let k = 0; k < 3; k++) result[used + 3 + k] = this.ground[3 * ground + k];
      ground += !inside;
      this.shorten(result, used);
      used += 6;
    }
    return result.subarray(0, used);
  }

  putPlace(result, at, frame, i) {
    const from = 3 * (frame * this.about.count + i);
    for (let k = 0; k < 3; k++) result[at + k] = this.about.low[k] + this.places[from + k] / 65535 * this.extent[k];
  }

  /** An edge's second end goes to its image nearest to the first. */
  shorten(result, at) {
    for (let k = 0; k < 3; k++) {
      const length = this.about.periodic[k] ? this.size[k] : 0;
      if (length > 0) result[at + 3 + k] -= Math.round((result[at + 3 + k] - result[at + k]) / length) * length;
    }
  }
}

// ---- Numbers as text ----

/** With four digits. */
function short(value) {
  if (value === null || !Number.isFinite(value)) return "–";
  const small = value !== 0 && Math.abs(value) < 1e-3;
  return small ? value.toExponential(3).replace(/\.?0+e/, "e") : String(Number(value.toPrecision(4)));
}

const withUnit = (text, unit) => unit && unit !== "1" ? `${text} ${unit}` : text;
const titleOf = ({ name, unit }) => unit && unit !== "1" ? `${name} (${unit})` : name;

/** A round length of about that. */
function roundLength(aim) {
  const decade = 10 ** Math.floor(Math.log10(aim));
  return Math.max(...[1, 2, 5].filter((m) => m * decade <= aim * 1.0001)) * decade;
}

/** Index of the time nearest to one. */
function nearestIndex(times, time) {
  let best = 0;
  times.forEach((t, i) => { if (Math.abs(t - time) < Math.abs(times[best] - time)) best = i; });
  return best;
}

// ---- The page ----

class Curve {
  constructor(data, page) {
    this.data = data;
    const heading = document.createElement("h4");
    heading.append(titleOf(data), document.createElement("span"));
    this.now = heading.lastChild;
    this.canvas = document.createElement("canvas");
    this.cursor = document.createElement("i");
    const plot = document.createElement("div");
    plot.append(this.canvas, this.cursor);
    this.page = page;
    page.element("curves").append(heading, plot);
    this.canvas.onpointerdown = this.canvas.onpointermove = (event) => { if (event.buttons) this.goTo(event); };
  }

  shown() {
    const { time, values } = this.data;
    const log = this.page.element("log").checked;
    const good = (x) => x !== null && (!log || x > 0);
    return time.map((t, i) => [t, values[i]]).filter(([t, v]) => good(t) && good(v)).map((p) => log ? p.map(Math.log10) : p);
  }

  draw() {
    const { canvas } = this;
    const ratio = devicePixelRatio;
    [canvas.width, canvas.height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
    const points = this.shown();
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const span = (k) => {
      const [low, high] = points.reduce(([a, b], p) => [Math.min(a, p[k]), Math.max(b, p[k])], [Infinity, -Infinity]);
      return high > low ? [low, high] : [low - 0.5, high + 0.5];
    };
    const [[t0, t1], [v0, v1]] = points.length ? [span(0), span(1)] : [[0, 1], [0, 1]];
    this.x = (t) => 4 + (t - t0) / (t1 - t0) * (width - 8);
    this.t = (x) => t0 + (x - 4) / (width - 8) * (t1 - t0);
    const y = (v) => height - 6 - (v - v0) / (v1 - v0) * (height - 12);
    context.strokeStyle = "#ddd";
    context.strokeRect(0.5, 0.5, width - 1, height - 1);
    context.strokeStyle = "#08519c";
    context.beginPath();
    points.forEach(([t, v], i) => i ? context.lineTo(this.x(t), y(v)) : context.moveTo(this.x(t), y(v)));
    context.stroke();
    if (points.length) this.drawEnds(context, v0, v1, height);
    this.mark();
  }

  drawEnds(context, v0, v1, height) {
    const text = (v) => short(this.page.element("log").checked ? 10 ** v : v);
    context.fillStyle = "#666";
    context.font = "10px system-ui, sans-serif";
    context.fillText(text(v1), 5, 12);
    context.fillText(text(v0), 5, height - 5);
  }

  /** The cursor at the frame's time, and the value there. */
  mark() {
    const { time, values } = this.data;
    const now = this.page.run.about.time[this.page.frame];
    const log = this.page.element("log").checked;
    const x = this.x(log ? Math.log10(now) : now);
    this.cursor.style.display = Number.isFinite(x) ? "block" : "none";
    this.cursor.style.left = `${x}px`;
    this.now.textContent = short(values[nearestIndex(time, now)]);
  }

  goTo(event) {
    const t = this.t(event.offsetX);
    this.page.show(nearestIndex(this.page.run.about.time, this.page.element("log").checked ? 10 ** t : t));
  }
}

class Page {
  constructor(run) {
    this.run = run;
    this.frame = run.about.time.length - 1;
    this.canvas = this.element("scene");
    this.gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("this browser has no WebGL2");
    this.camera = new Camera(run.size, run.about.dimension, run.about.down);
    this.particles = new Copies(this.gl, PARTICLES);
    this.held = new Copies(this.gl, PARTICLES);  // electrodes that are spheres
    this.lines = Object.fromEntries(["outlines", "electrodes", "contacts", "tree"].map((name) => [name, new Lines(this.gl)]));
    this.particles.set("radius", run.radius, 1, this.gl.FLOAT);
    this.particles.count = run.about.count;
    this.describe();
    this.fillControls();
    this.listen();
    this.curves = run.about.curves.filter(({ values }) => new Set(values).size > 1).map((data) => new Curve(data, this));
    this.chooseColour();
    this.resize();
  }

  element(id) { return document.getElementById(id); }

  describe() {
    const { about } = this.run;
    const steps = about.high.map((high, k) => short((high - about.low[k]) / 65535)).slice(0, about.dimension).join(" x ");
    this.element("title").innerHTML = "<b></b> <span></span>";
    this.element("title").firstChild.textContent = about.title;
    this.element("warnings").textContent = about.warnings.map((warning) => `WARNING: ${warning}`).join("\n");
    this.element("summary").textContent = Object.entries(about.summary).map(([name, value]) => `${name} = ${short(value)}`).join("\n");
    this.element("text").textContent = about.scene;
    const stored = `${about.file}\nHere places are rounded to steps of ${withUnit(steps, about.lengthUnit)}, other numbers to four digits.`;
    const sessions = about.provenance.map((session) => Object.entries(session).map(([key, value]) => `${key}: ${value}`).join("\n"));
    this.element("provenance").textContent = [stored, ...sessions].join("\n\n");
    const spheres = about.electrodes.filter(({ shape }) => shape === "sphere");
    const named = (mark, electrodes) => electrodes.length === 0 ? [] : [`${mark}: ${electrodes.map(({ name, potential }) => `${name} ${withUnit(short(potential), "V")}`).join(", ")}`];
    const others = about.electrodes.filter((electrode) => !spheres.includes(electrode));
    this.element("electrodes").textContent = [...named("thick grey", others), ...named("dark spheres", spheres)].join("; ");
    this.held.count = spheres.length;
    this.held.set("place", Float32Array.from(spheres.flatMap(({ centre }) => centre.map((x, k) => (x - about.low[k]) / this.run.extent[k]))), 3, this.gl.FLOAT);
    this.held.set("radius", Float32Array.from(spheres, ({ radius }) => radius), 1, this.gl.FLOAT);
    this.held.set("colour", new Uint8Array(4 * spheres.length).fill(90), 4, this.gl.UNSIGNED_BYTE);
    this.lines.outlines.ends(new Float32Array(edgesBetween([0, 0, 0], this.run.size)));
    this.lines.electrodes.ends(new Float32Array(about.electrodes.flatMap(outline)));
  }

  fillControls() {
    const { about, columns } = this.run;
    for (const name of Object.keys(columns)) this.element("colour").append(new Option(titleOf(columns[name]), name));
    this.element("colour").value = this.bestColour();
    for (const kind of ["contacts", "tree"]) {
      const has = kind in about && this.run[kind].length > 0;
      this.element(kind).disabled = !has;
      this.element(kind).checked = has && kind === "tree";
    }
    this.element("frame").max = about.time.length - 1;
  }

  /** What differs between the particles of the frame, of those first that say most: at a stationary tree not the potential. */
  bestColour() {
    const { columns } = this.run;
    const differs = (name) => {
      const [low, high] = spanOf(this.run.values(name, this.frame));
      return high - low > 1e-6 * Math.max(...spanOf(columns[name].values).map(Math.abs));
    };
    const wanted = ["potential", "charge", "cluster", "first joined the tree at", ...Object.keys(columns)].filter((name) => name in columns);
    return wanted.find(differs) ?? wanted[0];
  }

  listen() {
    const on = (id, event, action) => this.element(id).addEventListener(event, action);
    on("frame", "input", () => this.show(Number(this.element("frame").value)));
    on("play", "click", () => this.play());
    on("colour", "change", () => this.chooseColour());
    for (const id of ["low", "high"]) on(id, "change", () => this.show(this.frame));
    for (const id of ["contacts", "tree"]) on(id, "change", () => this.show(this.frame));
    on("radius", "input", () => this.draw());
    on("log", "change", () => this.curves.forEach((curve) => curve.draw()));
    on("scene", "pointerdown", (event) => this.canvas.setPointerCapture(event.pointerId));
    on("scene", "pointermove", (event) => this.point(event));
    on("scene", "pointerleave", () => { this.element("tip").style.display = "none"; });
    on("scene", "dblclick", () => { this.camera.reset(); this.draw(); });
    on("scene", "wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(event.deltaY * 0.001));
      this.draw();
    });
    addEventListener("resize", () => this.resize());
    addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (["INPUT", "SELECT"].includes(event.target.tagName) && event.target.id !== "frame") return;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step && event.target.id !== "frame") this.show(this.frame + step);
    if (event.key === " " && event.target.tagName !== "BUTTON") this.play();
  }

  point(event) {
    if (event.buttons) {
      this.camera.drag(event.movementX, event.movementY, this.canvas.clientHeight, event.buttons > 1 || event.shiftKey);
      this.draw();
    } else {
      this.tell(event);
    }
  }

  /** What the particle under the pointer is. */
  tell(event) {
    const tip = this.element("tip");
    const i = this.particleAt(event.offsetX, event.offsetY);
    tip.style.display = i === null ? "none" : "block";
    if (i === null) return;
    const values = Object.values(this.run.columns).map(({ name, unit }) => `${name} ${withUnit(short(this.run.values(name, this.frame)[i]), unit)}`);
    const place = this.run.place(this.frame, i).slice(0, this.run.about.dimension).map(short).join(", ");
    tip.textContent = [`particle ${i}`, `at ${withUnit(place, this.run.about.lengthUnit)}`, ...values].join("\n");
    tip.style.left = `${Math.min(event.offsetX + 14, this.canvas.clientWidth - tip.offsetWidth)}px`;
    tip.style.top = `${Math.min(event.offsetY + 14, this.canvas.clientHeight - tip.offsetHeight)}px`;
  }

  /** The nearest to the eye of those that cover the pixel, or null. */
  particleAt(x, y) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [view, projection] = this.camera.matrices(width / height);
    const whole = times(projection, view);
    const factor = this.radiusFactor();
    let [best, depth] = [null, Infinity];
    for (let i = 0; i < this.run.about.count; i++) {
      const [a, b, c, w] = apply(whole, this.run.place(this.frame, i));
      const reach = this.run.radius[i] * factor * projection[5] / w * height / 2;
      const off = Math.hypot((a / w + 1) / 2 * width - x, (1 - b / w) / 2 * height - y);
      if (off <= Math.max(reach, 1) && c / w < depth) [best, depth] = [i, c / w];
    }
    return best;
  }

  play() {
    if (this.timer) clearInterval(this.timer);
    const going = Boolean(this.timer);
    this.timer = going ? null : setInterval(() => this.show((this.frame + 1) % this.run.about.time.length), 1000 / this.element("rate").value);
    this.element("play").textContent = going ? "Play" : "Pause";
  }

  chooseColour() {
    const column = this.run.columns[this.element("colour").value];
    const { low, high } = column;  // ranges.py
    this.map = low < 0 && high > 0 ? "two" : "one";
    [this.element("low").value, this.element("high").value] = [short(low), short(high)];
    this.element("low").disabled = this.element("high").disabled = column.sets;
    this.show(this.frame);
  }

  show(frame) {
    const { about } = this.run;
    this.frame = Math.max(0, Math.min(about.time.length - 1, frame));
    const three = 3 * about.count;
    this.particles.set("place", this.run.places.subarray(this.frame * three, (this.frame + 1) * three), 3, this.gl.UNSIGNED_SHORT);
    this.particles.set("colour", this.colours(), 4, this.gl.UNSIGNED_BYTE);
    for (const kind of ["contacts", "tree"])
      this.lines[kind].ends(this.element(kind).checked ? this.run.edges(kind, this.frame) : new Float32Array());
    this.element("frame").value = this.frame;
    const time = withUnit(short(about.time[this.frame]), about.timeUnit);
    this.element("now").textContent = `${time}, frame ${about.frames[this.frame]}`;
    this.element("title").lastChild.textContent = `t = ${time}, N = ${about.count}`;
    this.curves?.forEach((curve) => curve.x && curve.mark());
    this.draw();
  }

  colours() {
    const column = this.run.columns[this.element("colour").value];
    const values = this.run.values(column.name, this.frame);
    const [low, high] = ["low", "high"].map((id) => Number(this.element(id).value));
    this.drawLegend(column, low, high);
    return column.sets ? setShades(values) : shades(values, low, high, table(this.map));
  }

  drawLegend(column, low, high) {
    const canvas = document.querySelector("#legend canvas");
    const context = canvas.getContext("2d");
    const steps = Float32Array.from({ length: 220 }, (_, i) => i / 219);
    context.putImageData(new ImageData(new Uint8ClampedArray(shades(steps, 0, 1, table(this.map))), 220, 1), 0, 0);
    canvas.style.display = column.sets ? "none" : "block";
    this.element("what").textContent = titleOf(column) + (column.sets ? ": one colour a set, grey alone" : "");
    [this.element("least").textContent, this.element("largest").textContent] = column.sets ? ["", ""] : [short(low), short(high)];
  }

  resize() {
    [this.canvas.width, this.canvas.height] = [this.canvas.clientWidth * devicePixelRatio, this.canvas.clientHeight * devicePixelRatio];
    this.curves.forEach((curve) => curve.draw());
    this.draw();
  }

  /** In space lines between centres would be hidden inside of the particles. */
  radiusFactor() {
    const hidden = this.camera.spatial && ["contacts", "tree"].some((kind) => this.element(kind).checked);
    return this.element("radius").value * (hidden ? 0.4 : 1);
  }

  draw() {
    const { gl, canvas, camera, run } = this;
    const [view, projection] = camera.matrices(canvas.width / canvas.height);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    camera.spatial ? gl.enable(gl.DEPTH_TEST) : gl.disable(gl.DEPTH_TEST);
    const reach = Math.hypot(...run.size);
    const fog = [camera.distance() - reach / 2, reach];
    const pixels = [canvas.width / 2, canvas.height / 2];
    const line = (name, ink, width) => this.lines[name].draw({ view, projection, pixels, ink, width: width * devicePixelRatio });
    line("outlines", [0.4, 0.4, 0.4, 1], 0.5);
    line("electrodes", [0.45, 0.45, 0.45, 1], 2);
    const seen = { view, projection, fog, low: run.about.low, extent: run.extent, flat_: !camera.spatial };
    this.particles.draw({ ...seen, factor: this.radiusFactor() });
    this.held.draw({ ...seen, factor: 1 });
    const thick = Math.max(0.6, Math.min(2, 0.12 * run.radius[0] * projection[5] / (camera.spatial ? camera.distance() : 1) * canvas.clientHeight / 2));
    line("contacts", [0.85, 0.37, 0.01, 1], thick);
    line("tree", [0.1, 0.1, 0.1, 1], thick);
    this.drawScale(projection);
  }

  /** Of what is in the middle. */
  drawScale(projection) {
    const pixels = projection[0] * this.canvas.clientWidth / 2 / (this.camera.spatial ? this.camera.distance() : 1);
    const length = roundLength(120 / pixels);
    this.element("scale").firstElementChild.textContent = withUnit(short(length), this.run.about.lengthUnit);
    this.element("scale").lastElementChild.style.width = `${length * pixels}px`;
  }
}

async function start() {
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  try {
    const run = await new Run(read("about")).unpack(read("arrays"));
    new Page(run);
    document.body.dataset.ready = "yes";
  } catch (error) {
    document.getElementById("failure").textContent = `This page cannot be shown: ${error.message}`;
    throw error;
  }
}

start();
