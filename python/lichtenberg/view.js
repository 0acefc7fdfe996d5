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

const NORMS = { linear: (x) => x, log: Math.log, asinh: Math.asinh };

const channels = (hex) => [0, 2, 4].map((at) => parseInt(hex.replace("#", "").slice(at, at + 2), 16));

/** Colour scale of a column, as Scale of pictures/colours.py. `range`: low and high of the user, or null for the run's. */
class Scale {
  constructor(column, range, pale) {
    Object.assign(this, column);
    this.paleColour = channels(pale);
    if (column.kind === "category") return;
    if (range) this.setRange(range);
    const steps = this.kind === "order" ? Math.round(this.ends[1] - this.ends[0]) : 0;
    const norm = (value) => NORMS[this.norm](value / this.width);
    const [from, to] = this.ends.map(norm);
    /** Returns the position of a value in the colour map, from 0 to 1. */
    this.share = (value) => (norm(value) - from) / (to - from);
    [this.barLow, this.barHigh] = (this.kind === "order" ? this.ends : [this.low, this.high]).map(this.share);
    const step = (share) => Math.min(Math.floor(share * steps), steps - 1);
    const index = (share) => Math.floor(!steps ? share * 256 : steps > 1 ? step(share) * 255 / (steps - 1) : 127);
    const colours = Array.from({ length: 256 }, (_, i) => channels(this.table.slice(6 * i, 6 * i + 6)));
    this.colourAt = (share) => colours[Math.max(0, Math.min(255, index(share)))];
  }

  setRange([low, high]) {
    const reach = Math.max(-low, high);
    const ends = { signed: [-reach, reach], order: [Math.floor(low) - 0.5, Math.floor(high) + 0.5] }[this.kind] ?? [low, high];
    const ticks = [low, high].map((value) => [value * this.factor, short(value * this.factor)]);
    const norm = this.norm === "log" ? "log" : "linear";
    Object.assign(this, { low, high, ends, norm, width: 1, beyond: "neither", bar: { ...this.bar, ticks } });
  }

  hasColour(value) {
    return this.kind === "category" ? value !== NO_SET : Number.isFinite(value) && (value > 0 || this.kind !== "decades");
  }

  colour(value) {
    if (!this.hasColour(value)) return this.paleColour;
    if (this.kind === "category") return setColour(value);
    return this.colourAt(this.share(Math.max(this.low, Math.min(this.high, value))));
  }
}

const NO_SET = -(2 ** 31);  // of a particle in no set

/** Returns the colour of a set by its number, as set_colours of ranges.py. */
function setColour(n) {
  const hue = ((0.6 + n * 0.6180339887) % 1 + 1) % 1, light = [0.5, 0.68, 0.34][((n % 3) + 3) % 3];
  const swing = 0.6 * Math.min(light, 1 - light);
  return [0, 8, 4].map((k) => {  // of red, green and blue, in twelfths of the circle
    const at = (k + 12 * hue) % 12;
    return Math.round(255 * (light - swing * Math.max(-1, Math.min(at - 3, 9 - at, 1))));
  });
}

// ---- Space ----

/** Multiplies 4 x 4 matrices, stored by columns. */
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

/** The camera of the pictures (camera_of of view.py), which can be moved. In the plane it looks along z. */
class Camera {
  constructor(start) {
    this.start = start;
    this.spatial = "frame" in start;
    this.frame = start.frame ?? [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    this.reset();
  }

  reset() {
    Object.assign(this, { turn: 0, rise: 0, zoomed: 1, ...this.start });
    this.centre = [...this.start.centre];
  }

  /** Returns half the visible height at the centre without zoom, for a picture of that aspect. */
  half(aspect) { return Math.max(this.high[1] - this.low[1], (this.high[0] - this.low[0]) / aspect) / 2; }

  /** Returns [view, projection] for a picture of that aspect. */
  matrices(aspect) {
    const [x, y, z] = this.centre;
    const away = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1];
    const half = this.half(aspect);
    if (!this.spatial) {
      const scale = 1 / (half * this.zoomed);
      return [away, [scale / aspect, 0, 0, 0, 0, scale, 0, 0, 0, 0, -scale / 8, 0, 0, 0, 0, 1]];
    }
    const distance = this.distance * this.zoomed, f = this.distance / half;
    const [c, s, cr, sr] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.rise), Math.sin(this.rise)];
    const turned = [c, -sr * s, cr * s, 0, 0, cr, sr, 0, -s, -sr * c, cr * c, 0, 0, 0, -distance, 1];
    const [near, far] = [distance / 50, 6 * distance + 3 * this.distance];
    const depth = [(far + near) / (near - far), 2 * far * near / (near - far)];
    const [right, up] = [0, 1].map((k) => (this.low[k] + this.high[k]) / 2 / half);  // middle of the window
    const upright = [...[0, 1, 2].flatMap((k) => [...this.frame.map((axis) => axis[k]), 0]), 0, 0, 0, 1];
    return [times(turned, times(upright, away)), [f / aspect, 0, 0, 0, 0, f, 0, 0, right / aspect, up, depth[0], -1, 0, 0, depth[1], 0]];
  }

  /** Moves the camera by pixels, in a picture of that width and height. */
  drag(dx, dy, width, height, sideways) {
    if (this.spatial && !sideways) {
      this.turn -= dx * 0.008;
      this.rise = Math.max(-1.55, Math.min(1.55, this.rise + dy * 0.008));
      return;
    }
    const unit = 2 * this.half(width / height) * this.zoomed / height;
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)];
    const moved = [-dx * unit * c, dy * unit, dx * unit * s];  // to the right, up, towards the eye
    this.centre = this.centre.map((place, k) => this.frame.reduce((sum, axis, n) => sum + moved[n] * axis[k], place));
  }

  zoom(factor) { this.zoomed *= factor; }
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
  uniform mat4 projection; uniform bool flat_; uniform vec3 haze, light;
  out vec4 pixel;
  void main() {
    float r = length(at), soft = fwidth(r);
    if (r > 1.0 + (flat_ ? soft : 0.0)) discard;
    if (flat_) {
      float edge = 1.0 - min(0.1, 1.2 * soft);
      float rim = smoothstep(edge - soft, edge + soft, r) * (1.0 - smoothstep(0.1, 0.4, soft));
      pixel = vec4(mix(shade.rgb, vec3(0.1), rim), mix(shade.a, 1.0, rim) * clamp((1.0 - r) / max(soft, 1e-6) + 0.5, 0.0, 1.0));
      gl_FragDepth = gl_FragCoord.z;
    } else {
      float up = sqrt(1.0 - min(r * r, 1.0));
      vec4 surface = projection * vec4(middle + vec3(at, up) * size, 1);
      gl_FragDepth = 0.5 * surface.z / surface.w + 0.5;
      float lit = clamp(dot(vec3(at, up), light), 0.0, 1.0);  // as shaded() of pictures/space.py, without its hollows
      vec3 own = shade.rgb * (0.42 + 0.62 * lit) * (0.55 + 0.45 * min(up / 0.4, 1.0)) + 0.25 * pow(lit, 24.0);
      pixel = vec4(mix(min(own, 1.0), vec3(1), haze.z * clamp((-middle.z - haze.x) / haze.y, 0.0, 1.0)), 1);
    }
  }`];

const LINES = [`#version 300 es
  in vec2 corner; in vec3 from, to; in float share;
  uniform mat4 view, projection; uniform vec2 pixels; uniform float width;
  void main() {
    vec4 a = projection * view * vec4(from, 1), b = projection * view * vec4(to, 1);
    vec2 along = (b.xy / b.w - a.xy / a.w) * pixels;
    along = dot(along, along) > 0.0 ? normalize(along) : vec2(1, 0);
    vec4 end = corner.x < 0.0 ? a : b;
    vec2 aside = vec2(-along.y, along.x) * corner.y + along * corner.x;  // square caps
    gl_Position = end + vec4(aside * share * width / pixels * end.w, 0, 0);
  }`, `#version 300 es
  precision highp float;
  uniform vec4 ink; out vec4 pixel;
  void main() { pixel = ink; }`];

const AREAS = [`#version 300 es
  in vec2 corner; in vec3 a, b, c, d;
  uniform mat4 view, projection;
  void main() {
    vec2 share = (corner + 1.0) / 2.0;
    gl_Position = projection * view * vec4(mix(mix(a, b, share.x), mix(c, d, share.x), share.y), 1);
  }`, LINES[1]];

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

/** Draws many copies of one square. Attributes are given by name, with one value for each copy. */
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

  /** Draws lines, each with six numbers for its ends. `shares`: width of each, relative to the usual one. */
  ends(numbers, shares) {
    this.count = numbers.length / 6;
    this.set("share", Float32Array.from({ length: this.count }, (_, k) => shares ? shares[k] : 1), 1, this.gl.FLOAT);
    this.set("from", numbers, 3, this.gl.FLOAT, 1, 24, 0);
    this.set("to", numbers, 3, this.gl.FLOAT, 1, 24, 12);
  }
}

class Areas extends Copies {
  /** Draws quadrangles, each with twelve numbers for its corners. */
  constructor(gl, numbers) {
    super(gl, AREAS);
    this.count = numbers.length / 12;
    ["a", "b", "c", "d"].forEach((name, k) => this.set(name, numbers, 3, gl.FLOAT, 1, 48, 12 * k));
  }
}

/** Returns the edges of a rectangle or a box between two corners. */
function edgesBetween(low, high) {
  const axes = [0, 1, 2].filter((k) => high[k] > low[k]);
  const corners = Array.from({ length: 1 << axes.length }, (_, i) => low.map((start, k) => i & 1 << axes.indexOf(k) ? high[k] : start));
  return corners.flatMap((corner, i) => axes.map((_, bit) => 1 << bit).filter((bit) => !(i & bit)).flatMap((bit) => [...corner, ...corners[i | bit]]));
}

const isRound = ({ shape }) => shape === "sphere" || shape === "disk";

/** Returns the ends of the lines of electrodes, which are sides and polygons in the plane. */
function sideLines({ shape, ends, points }) {
  if (shape.endsWith("polygon")) return points.flatMap((point, k) => [...point, 0, ...points[(k + 1) % points.length], 0]);
  return shape === "side" ? [...ends.slice(0, 2), 0, ...ends.slice(2), 0] : [];
}

/** Returns the corners of the quadrangles of an electrode: a face in space, a bar, or the area outside of a ring. */
function areas({ shape, low, high, from, to, width, centre, radius }) {
  if (shape === "face") {
    const [p, q] = [0, 1, 2].filter((k) => high[k] > low[k]);
    return [[], [p], [q], [p, q]].flatMap((far) => low.map((start, k) => far.includes(k) ? high[k] : start));
  }
  if (shape === "bar") {
    const [[a, b], [c, d]] = [from, to];
    const half = width / 2 / Math.hypot(c - a, d - b);
    const [x, y] = [-(d - b) * half, (c - a) * half];
    return [a + x, b + y, 0, c + x, d + y, 0, a - x, b - y, 0, c - x, d - y, 0];
  }
  const point = (k, far) => [centre[0] + far * radius * Math.cos(k * Math.PI / 90), centre[1] + far * radius * Math.sin(k * Math.PI / 90), 0];
  return shape !== "ring" ? [] : Array.from({ length: 180 }, (_, k) => [...point(k, 1), ...point(k + 1, 1), ...point(k, 9), ...point(k + 1, 9)]).flat();
}

// ---- The run ----

class Run {
  constructor(about) {
    this.about = about;
    this.size = [...about.size, 0].slice(0, 3);
    this.extent = about.high.map((high, k) => high - about.low[k]);
  }

  /** Returns the size of the domain in a frame, three numbers. */
  sizeAt(frame) {
    return this.about.sizes ? [...this.about.sizes[frame], 0].slice(0, 3) : this.size;
  }

  async unpack(arrays) {
    const { count } = this.about;
    this.places = await unpacked(arrays.places, 2, 3 * count);
    this.radius = floats(await unpacked(arrays.radius, 4, count));
    this.columns = {};
    for (const column of this.about.columns) {
      const values = await unpacked(arrays[`column ${column.name}`], 4, count);
      this.columns[column.name] = { ...column, values: column.kind === "category" ? integers(values) : floats(values) };
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

  /** Returns the index after the last edge to the ground of each frame. */
  countGroundEdges() {
    const to = this.tree.subarray(this.tree.length / 2);
    let [k, sum] = [0, 0];
    return this.about.tree.map((end) => {
      for (; k < end; k++) sum += to[k] === -1;
      return sum;
    });
  }

  /** Returns the values of a column in a frame. */
  values(name, frame) {
    const { values, changes } = this.columns[name];
    return changes ? values.subarray(frame * this.about.count, (frame + 1) * this.about.count) : values;
  }

  place(frame, i) {
    const result = [0, 0, 0];
    this.putPlace(result, 0, frame, i);
    return result;
  }

  /** Returns the edges of a frame, each with six numbers. Edges across a periodic side go to the nearest image. */
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
      this.shorten(result, used, this.sizeAt(frame));
      used += 6;
    }
    return result.subarray(0, used);
  }

  putPlace(result, at, frame, i) {
    const from = 3 * (frame * this.about.count + i);
    for (let k = 0; k < 3; k++) result[at + k] = this.about.low[k] + this.places[from + k] / 65535 * this.extent[k];
  }

  /** An edge's second end goes to its image nearest to the first. */
  shorten(result, at, size) {
    for (let k = 0; k < 3; k++) {
      const length = this.about.periodic[k] ? size[k] : 0;
      if (length > 0) result[at + 3 + k] -= Math.round((result[at + 3 + k] - result[at + k]) / length) * length;
    }
  }
}

// ---- Numbers as text ----

/** Formats a number with four digits. */
function short(value) {
  if (value === null || !Number.isFinite(value)) return "–";
  const small = value !== 0 && Math.abs(value) < 1e-3;
  return small ? value.toExponential(3).replace(/\.?0+e/, "e") : String(Number(value.toPrecision(4)));
}

const withUnit = (text, unit) => unit && unit !== "1" ? `${text} ${unit}` : text;

/** Returns a round length close to the given one. */
function roundLength(aim) {
  const decade = 10 ** Math.floor(Math.log10(aim));
  return Math.max(...[1, 2, 5].filter((m) => m * decade <= aim * 1.0001)) * decade;
}

/** Returns the index of the nearest time. */
function nearestIndex(times, time) {
  let best = 0;
  times.forEach((t, i) => { if (Math.abs(t - time) < Math.abs(times[best] - time)) best = i; });
  return best;
}

// ---- The page ----

const FRAME = { left: 52, right: 10, top: 14, bottom: 30 };  // margins of a panel's axes (pixels)

/** A panel of curves on the axes of the pictures (curves_of of view.py). */
class Panel {
  constructor(data, page) {
    this.data = data;
    this.page = page;
    this.heading = document.createElement("h4");
    this.canvas = document.createElement("canvas");
    this.cursor = document.createElement("i");
    const plot = document.createElement("div");
    plot.append(this.canvas, this.cursor);
    this.keys = data.curves.map(({ label, colour, dashed }) => {
      const key = document.createElement("p"), mark = document.createElement("b");
      mark.textContent = dashed ? "– –" : "——";
      mark.style.color = colour;
      key.append(...(label ? [mark, `${label}: `] : []), document.createElement("span"));
      return key;
    });
    this.heading.append(data.axes[1].label, ...(data.curves.some(({ label }) => label) ? [] : this.keys));
    page.element("curves").append(this.heading, ...(this.keys[0]?.parentNode ? [] : this.keys), plot);
    this.canvas.onpointerdown = this.canvas.onpointermove = (event) => { if (event.buttons) this.goTo(event); };
  }

  draw() {
    const { canvas, data } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [width * devicePixelRatio, height * devicePixelRatio];
    const context = canvas.getContext("2d");
    context.scale(devicePixelRatio, devicePixelRatio);
    const [across, up] = this.page.element("log").checked && data.logarithmic || data.axes;
    const place = ({ log, low, high }, from, to) => {
      const norm = NORMS[log ? "log" : "linear"];
      return (value) => from + (norm(value) - norm(low)) / (norm(high) - norm(low)) * (to - from);
    };
    const [left, right, top, bottom] = [FRAME.left, width - FRAME.right, FRAME.top, height - FRAME.bottom];
    this.x = place(across, left, right);
    const y = place(up, bottom, top);
    this.drawAxes(context, { left, right, top, bottom }, across, up, y);
    context.rect(left, top, right - left, bottom - top);
    context.clip();
    for (const curve of data.curves) {
      const points = curve.x.map((x, i) => [x, curve.y[i]]).filter((point) => point.every((v) => v !== null))
        .map(([x, v]) => [this.x(x), y(v)]).filter((point) => point.every(Number.isFinite));
      context.strokeStyle = context.fillStyle = curve.colour;
      context.setLineDash(curve.dashed ? [5, 3] : []);
      context.beginPath();
      points.forEach(([a, b], i) => i ? context.lineTo(a, b) : context.moveTo(a, b));
      context.stroke();
      if (points.length <= 40) points.forEach(([a, b]) => context.fillRect(a - 1.5, b - 1.5, 3, 3));
    }
    this.mark();
  }

  drawAxes(context, { left, right, top, bottom }, across, up, y) {
    context.strokeStyle = context.fillStyle = "#1a1a1a";
    context.lineWidth = 0.8;
    context.font = "10px system-ui, sans-serif";
    context.strokeRect(left, top, right - left, bottom - top);
    context.beginPath();
    context.textAlign = "center";
    for (const [value, text] of across.ticks) {
      context.moveTo(this.x(value), bottom), context.lineTo(this.x(value), bottom + 3);
      context.fillText(text, this.x(value), bottom + 13);
    }
    context.fillText(across.label, (left + right) / 2, bottom + 26);
    context.textAlign = "left";
    context.fillText(up.offset, left, top - 3);
    context.textAlign = "right";
    context.fillText(across.offset, right, bottom + 26);
    for (const [value, text] of up.ticks) {
      context.moveTo(left, y(value)), context.lineTo(left - 3, y(value));
      context.fillText(text, left - 5, y(value) + 3.5);
    }
    context.stroke();
  }

  /** The cursor at the frame's time, and the values there. */
  mark() {
    const now = this.page.run.about.time[this.page.frame] - this.data.start;
    const x = this.x(now);
    this.cursor.style.display = x >= FRAME.left && x <= this.canvas.clientWidth - FRAME.right ? "block" : "none";
    this.cursor.style.left = `${x}px`;
    this.data.curves.forEach(({ x, y }, k) => { this.keys[k].lastChild.textContent = short(y[nearestIndex(x, now)] ?? null); });
  }

  goTo(event) {
    const { time } = this.page.run.about;
    const distance = (t) => Math.abs(this.x(t - this.data.start) - event.offsetX);
    this.page.show(time.reduce((best, t, k) => distance(t) < distance(time[best]) ? k : best, 0));
  }
}

class Page {
  constructor(run) {
    this.run = run;
    this.frame = run.about.time.length - 1;
    this.canvas = this.element("scene");
    this.gl = this.canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("this browser has no WebGL2");
    this.camera = new Camera(run.about.camera);
    this.particles = new Copies(this.gl, PARTICLES);
    this.held = new Copies(this.gl, PARTICLES);  // electrodes that are spheres
    this.lines = Object.fromEntries(["outlines", "electrodes", "contacts", "forces", "tree"].map((name) => [name, new Lines(this.gl)]));
    this.particles.set("radius", run.radius, 1, this.gl.FLOAT);
    this.particles.count = run.about.count;
    this.electrodeColour = run.about.camera.box ? "#4d4d4d" : "#8c8c8c";
    this.describe();
    this.fillControls();
    this.listen();
    this.curves = run.about.curves.map((data) => new Panel(data, this));
    this.chooseColour();
    this.resize();
  }

  element(id) { return document.getElementById(id); }

  describe() {
    const { about } = this.run;
    const steps = about.high.map((high, k) => short((high - about.low[k]) / 65535 * about.lengthFactor)).slice(0, about.dimension).join(" x ");
    this.element("title").innerHTML = "<b></b> <span></span>";
    this.element("title").firstChild.textContent = about.title;
    this.element("warnings").textContent = about.warnings.map((warning) => `WARNING: ${warning}`).join("\n");
    this.element("summary").textContent = Object.entries(about.summary).map(([name, value]) => `${name} = ${short(value)}`).join("\n");
    this.element("text").textContent = about.scene;
    const stored = `${about.file}\nHere places are rounded to steps of ${withUnit(steps, about.lengthUnit)}, other numbers to four digits.`;
    const sessions = about.provenance.map((session) => Object.entries(session).map(([key, value]) => `${key}: ${value}`).join("\n"));
    this.element("provenance").textContent = [stored, ...sessions].join("\n\n");
    const spheres = about.electrodes.filter(isRound);
    this.element("path").textContent = about.path;
    this.labels = (about.camera.labels ?? []).map(({ text }) => Object.assign(document.createElement("span"), { textContent: text }));
    this.element("picture").append(...this.labels);
    this.held.count = spheres.length;
    this.held.set("place", Float32Array.from(spheres.flatMap(({ centre }) => [...centre, 0].slice(0, 3).map((x, k) => (x - about.low[k]) / (this.run.extent[k] || 1)))), 3, this.gl.FLOAT);
    this.held.set("radius", Float32Array.from(spheres, ({ radius }) => radius), 1, this.gl.FLOAT);
    const grey = channels(this.electrodeColour);
    this.held.set("colour", Uint8Array.from(spheres.flatMap(() => [...grey, 255])), 4, this.gl.UNSIGNED_BYTE);
    this.lines.electrodes.ends(new Float32Array(about.electrodes.flatMap(sideLines)));
    this.areas = new Areas(this.gl, new Float32Array(about.electrodes.flatMap(areas)));
  }

  fillControls() {
    const { about, columns } = this.run;
    for (const { name, label } of Object.values(columns)) this.element("colour").append(new Option(label, name));
    this.element("colour").append(new Option("no quantity", ""));
    this.element("colour").value = about.colour ?? "";
    for (const kind of ["contacts", "tree"]) {
      const has = kind in about && this.run[kind].length > 0;
      this.element(kind).disabled = !has;
      this.element(kind).checked = has && kind === "tree";
    }
    this.element("frame").max = about.time.length - 1;
  }

  listen() {
    const on = (id, event, action) => this.element(id).addEventListener(event, action);
    on("frame", "input", () => this.show(Number(this.element("frame").value)));
    on("play", "click", () => this.play());
    on("colour", "change", () => this.chooseColour());
    for (const id of ["low", "high"]) on(id, "change", () => this.chooseRange());
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
      this.camera.drag(event.movementX, event.movementY, this.canvas.clientWidth, this.canvas.clientHeight, event.buttons > 1 || event.shiftKey);
      this.draw();
    } else {
      this.tell(event);
    }
  }

  /** Shows the values of the particle under the pointer. */
  tell(event) {
    const tip = this.element("tip");
    const i = this.particleAt(event.offsetX, event.offsetY);
    tip.style.display = i === null ? "none" : "block";
    if (i === null) return;
    const text = ({ kind, factor }, value) => kind === "category" ? value === NO_SET ? "–" : value : short(value * factor);
    const values = Object.values(this.run.columns).map((column) => `${column.label}: ${text(column, this.run.values(column.name, this.frame)[i])}`);
    const { dimension, lengthFactor } = this.run.about;
    const place = this.run.place(this.frame, i).slice(0, dimension).map((x) => short(x * lengthFactor)).join(", ");
    tip.textContent = [`particle ${i}`, `at ${withUnit(place, this.run.about.lengthUnit)}`, ...values].join("\n");
    tip.style.left = `${Math.min(event.offsetX + 14, this.canvas.clientWidth - tip.offsetWidth)}px`;
    tip.style.top = `${Math.min(event.offsetY + 14, this.canvas.clientHeight - tip.offsetHeight)}px`;
  }

  /** Returns the particle nearest to the eye that covers the pixel, or null. */
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
    this.column = this.run.columns[this.element("colour").value];
    this.setScale(null);
  }

  chooseRange() {
    const { name, kind, factor } = this.column;
    const [low, high] = ["low", "high"].map((id) => this.element(id).value === "" ? NaN : this.element(id).value / factor);
    const refused = !(low < high) ? "The range needs two numbers, of which the first is less than the second."
      : kind === "decades" && low <= 0 ? `The range must begin above 0: ${name} is drawn by decades.` : "";
    this.element("refusal").textContent = refused;
    if (!refused) this.setScale([low, high]);
  }

  /** Returns the scale of a column. `range`: as for Scale. */
  setScale(range) {
    const { column } = this;
    this.scale = column && new Scale(column, range, this.run.about.paleColour);
    const ordered = column && column.kind !== "category";
    for (const id of ["low", "high"]) {
      this.element(id).disabled = !ordered;
      if (!range) this.element(id).value = ordered ? short(column[id] * column.factor) : "";
    }
    if (!range) this.element("refusal").textContent = "";
    this.drawBar();
    this.show(this.frame);
  }

  show(frame) {
    const { about } = this.run;
    this.frame = Math.max(0, Math.min(about.time.length - 1, frame));
    const box = (about.sizes ? null : about.camera.box) ?? [[0, 0, 0], this.run.sizeAt(this.frame)];
    this.lines.outlines.ends(new Float32Array(edgesBetween(...box)));
    const three = 3 * about.count;
    this.particles.set("place", this.run.places.subarray(this.frame * three, (this.frame + 1) * three), 3, this.gl.UNSIGNED_SHORT);
    this.particles.set("colour", this.colours(), 4, this.gl.UNSIGNED_BYTE);
    for (const kind of ["contacts", "tree"])
      this.lines[kind].ends(this.element(kind).checked ? this.run.edges(kind, this.frame) : new Float32Array());
    this.element("frame").value = this.frame;
    const caption = about.captions[this.frame];
    this.element("now").textContent = `${caption.split(",")[0]}, frame ${about.frames[this.frame]}`;
    this.element("title").lastChild.textContent = caption;
    this.curves?.forEach((curve) => curve.x && curve.mark());
    this.draw();
  }

  /** Returns the colours of the particles, 4 bytes each. */
  colours() {
    const { about } = this.run;
    const values = this.column ? this.run.values(this.column.name, this.frame) : [];
    const packing = about.packing?.frame === about.frames[this.frame] ? about.packing : null;
    const lines = !this.column && packing ? packing.lines : [];
    this.lines.forces.ends(Float32Array.from(lines), packing?.widths);
    const result = new Uint8Array(4 * about.count);
    const opaque = lines.length ? 191 : 255;  // both outlines of overlapping particles are visible
    const plain = channels(about.plainColour);
    for (let i = 0; i < about.count; i++) result.set([...this.column ? this.scale.colour(values[i]) : plain, opaque], 4 * i);
    for (const i of packing?.rattlers ?? []) result.set(channels(packing.rattlerColour), 4 * i);
    this.drawMarks(values, packing?.rattlers ?? [], lines.length > 0);
    return result;
  }

  /** Draws the legend of particles without a colour of the scale. */
  drawMarks(values, rattlers, forces) {
    const { about } = this.run;
    const mark = (colour, label, kind = "") => {
      const entry = document.createElement("span"), sign = document.createElement("i");
      [sign.className, sign.style.background] = [kind, colour];
      entry.append(sign, label);
      return entry;
    };
    const others = new Set(rattlers);
    const pale = this.column && values.some((value, i) => !this.scale.hasColour(value) && !others.has(i));
    this.element("marks").replaceChildren(
      ...(pale ? [mark(about.paleColour, this.column.pale)] : []),
      ...(forces ? [mark(about.packing.colour, about.packing.label, "line")] : []),
      ...(rattlers.length ? [mark(about.packing.rattlerColour, "rattler")] : []),
      ...(about.electrodes.length ? [mark(this.electrodeColour, about.electrodes.map(({ label }) => label).join(", "), "area")] : []));
  }

  drawBar() {
    const bar = this.element("scale-bar"), { scale } = this;
    bar.style.display = scale?.bar ? "block" : "none";
    this.element("what").textContent = scale ? (scale.bar ? `${scale.bar.label} ${scale.bar.offset}`.trim() : `colour: ${scale.label}`) : "";
    bar.replaceChildren();
    if (!scale?.bar) return;
    const canvas = Object.assign(document.createElement("canvas"), { width: 1, height: 420 });
    const context = canvas.getContext("2d");
    const { barLow, barHigh } = scale;
    for (let row = 0; row < 420; row++) {
      context.fillStyle = `rgb(${scale.colourAt(barHigh + (row + 0.5) / 420 * (barLow - barHigh))})`;
      context.fillRect(0, row, 1, 1);
    }
    bar.append(canvas);
    const put = (kind, share, text) => {
      const entry = Object.assign(document.createElement("span"), { className: kind, textContent: text });
      entry.style.bottom = `${100 * share}%`;
      bar.append(entry);
      return entry;
    };
    for (const [value, text] of scale.bar.ticks) put("tick", (scale.share(value / scale.factor) - barLow) / (barHigh - barLow), text);
    // Triangles as at a colour bar of matplotlib: some values are outside.
    for (const [end, share, sign] of [["min", -0.02, "▼"], ["max", 1.02, "▲"]])
      if ([end, "both"].includes(scale.beyond)) put("end", share, sign).style.color = `rgb(${scale.colourAt(end === "min" ? barLow : barHigh)})`;
  }

  resize() {
    [this.canvas.width, this.canvas.height] = [this.canvas.clientWidth * devicePixelRatio, this.canvas.clientHeight * devicePixelRatio];
    this.curves.forEach((curve) => curve.draw());
    this.draw();
  }

  /** In space contacts would be hidden inside of the particles. */
  radiusFactor() {
    return this.element("radius").value * (this.camera.spatial && this.element("contacts").checked ? 0.4 : 1);
  }

  draw() {
    const { gl, canvas, camera, run } = this;
    const { about } = run;
    const [view, projection] = camera.matrices(canvas.width / canvas.height);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    camera.spatial ? gl.enable(gl.DEPTH_TEST) : gl.disable(gl.DEPTH_TEST);
    const pixels = [canvas.width / 2, canvas.height / 2];
    const line = (name, ink, width) => this.lines[name].draw({ view, projection, pixels, ink, width: width * devicePixelRatio });
    line("outlines", [0.3, 0.3, 0.3, 1], 0.5);
    const grey = channels(this.electrodeColour).map((part) => part / 255);
    const seen = { view, projection, haze: this.haze(view), light: about.camera.light ?? [0, 0, 1], extent: run.extent, flat_: !camera.spatial };
    const shifts = [0, 1].map((k) => about.images && about.periodic[k] ? [0, run.size[k], -run.size[k]] : [0]);
    if (!camera.spatial) this.clip(view, projection);
    for (const x of shifts[0])
      for (const y of shifts[1])
        this.particles.draw({ ...seen, low: [about.low[0] + x, about.low[1] + y, about.low[2]], factor: this.radiusFactor() });
    this.held.draw({ ...seen, low: about.low, factor: 1 });
    const thick = Math.max(0.6, Math.min(2, 0.12 * (run.radius[0] ?? 0) / this.pixel(projection)));
    line("forces", [...channels(run.about.packing?.colour ?? "#000000").map((part) => part / 255), 1], Math.min(1.3, 0.075 * (run.radius[0] ?? 0) / this.pixel(projection)));
    line("contacts", [0.85, 0.37, 0.01, 1], thick);
    gl.depthMask(false);  // faces of a box are transparent
    this.areas.draw({ view, projection, ink: [...grey, camera.spatial ? 0.22 : 1] });
    gl.depthMask(true);
    gl.disable(gl.DEPTH_TEST);  // paths are in front of the particles
    line("tree", [0.1, 0.1, 0.1, 1], thick);
    gl.disable(gl.SCISSOR_TEST);
    line("electrodes", [...grey, 1], 2.5);
    this.drawScale(projection);
    this.placeLabels(times(projection, view));
  }

  /** Returns the depths of the box at which the haze begins and ends, and its strength. */
  haze(view) {
    const { box, fog } = this.run.about.camera;
    if (!box) return [0, 1, 0];
    const depths = Array.from({ length: 8 }, (_, i) => -apply(view, [0, 1, 2].map((k) => box[i >> k & 1][k]))[2]);
    return [Math.min(...depths), Math.max(...depths) - Math.min(...depths), fog];
  }

  /** In the plane particles and electrodes are cut at the domain, or at the window of a cloud that has left it. */
  clip(view, projection) {
    const corner = (point) => apply(times(projection, view), point).slice(0, 2).map((x, k) => Math.round((x + 1) / 2 * [this.canvas.width, this.canvas.height][k]));
    const [low, high] = this.run.about.camera.window.map(([x, y]) => corner([x, y, 0]));
    this.gl.enable(this.gl.SCISSOR_TEST);
    this.gl.scissor(low[0], low[1], high[0] - low[0], high[1] - low[1]);
  }

  placeLabels(whole) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const place = (point) => {
      const [x, y, , w] = apply(whole, point);
      return [(x / w + 1) / 2 * width, (1 - y / w) / 2 * height];
    };
    (this.run.about.camera.labels ?? []).forEach(({ at, shift }, k) => {
      const { style, offsetWidth, offsetHeight } = this.labels[k];
      const [x, y] = place(at);
      const away = shift[0] && Math.sign(x - place(this.run.about.camera.centre)[0]);
      [style.left, style.top] = [`${x + 7 * away + (away - 1) * offsetWidth / 2}px`, `${shift[1] ? y + 5 : y - offsetHeight / 2}px`];
    });
  }

  /** Returns the length of a pixel in the middle. */
  pixel(projection) { return 2 * (this.camera.spatial ? this.camera.distance * this.camera.zoomed : 1) / (projection[0] * this.canvas.clientWidth); }

  /** Draws the scale bar, for lengths in the middle. */
  drawScale(projection) {
    const { lengthFactor, lengthUnit } = this.run.about;
    const unit = this.pixel(projection) * lengthFactor;
    const length = roundLength(120 * unit);
    this.element("scale").firstElementChild.textContent = `${short(length)} ${lengthUnit}`;
    this.element("scale").lastElementChild.style.width = `${length / unit}px`;
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
