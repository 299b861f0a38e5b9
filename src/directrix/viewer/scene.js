// The picture in space: skins swept along the rods and lines of constant width, in WebGL 2.

const SKIN_VERTEX = `#version 300 es
precision highp float;
uniform highp sampler2D poses;
uniform mat4 camera;
uniform vec3 eye;
in float sample_;
in vec3 offset;
in vec3 normal;
out vec3 toward, facing, paint;
vec4 row(int k) {
  int width = textureSize(poses, 0).x, at = int(sample_) * 3 + k;
  return texelFetch(poses, ivec2(at % width, at / width), 0);
}
void main() {
  vec4 r = row(0), d1 = row(1), d2 = row(2);
  mat3 frame = mat3(d1.xyz, d2.xyz, cross(d1.xyz, d2.xyz));
  vec3 place = r.xyz + frame * offset;
  facing = frame * normal;
  toward = eye - place;
  paint = vec3(r.w, d1.w, d2.w);
  gl_Position = camera * vec4(place, 1.0);
}`;

const SKIN_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 above;
in vec3 toward, facing, paint;
out vec4 colour;
void main() {
  vec3 n = normalize(facing), e = normalize(toward);
  if (dot(n, e) < 0.0) n = -n;
  float light = 0.66 + 0.32 * max(dot(n, normalize(e + 1.2 * above)), 0.0) + 0.16 * max(dot(n, e), 0.0);
  float glint = 0.14 * pow(max(dot(n, normalize(2.0 * e + above)), 0.0), 40.0);
  colour = vec4(paint * light + glint, 1.0);
}`;

const LINE_VERTEX = `#version 300 es
precision highp float;
uniform mat4 camera;
uniform vec2 size;
uniform float near;
in vec2 corner;
in vec3 from, to, tint;
in float width;
out vec3 paint;
void main() {
  vec4 a = camera * vec4(from, 1.0), b = camera * vec4(to, 1.0);
  if (a.w < near && b.w > near) a = mix(a, b, (near - a.w) / (b.w - a.w));
  if (b.w < near && a.w > near) b = mix(b, a, (near - b.w) / (a.w - b.w));
  vec2 along = (b.xy / b.w - a.xy / a.w) * size;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  vec4 end = mix(a, b, corner.x);
  vec2 aside = vec2(-along.y, along.x) * corner.y + along * (corner.x - 0.5) * 0.6;
  end.xy += aside * width / size * end.w;
  paint = tint;
  gl_Position = (a.w < near && b.w < near) ? vec4(2.0, 2.0, 2.0, 1.0) : end;
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 paint;
out vec4 colour;
void main() { colour = vec4(paint, 1.0); }`;

const POSE_WIDTH = 1023; // texels in a row of the texture of poses: a multiple of three, below every limit

// Vertices (sample, offset, normal in d1, d2, d3) and triangles of all rods' skins; samples are counted from `start`.
function sweep(skeletons, thickness, plainRadius) {
  const vertices = [], triangles = [];
  const add = (sample, offset, normal) => vertices.push(sample, ...offset, ...normal) / 7 - 1;
  for (const skeleton of skeletons) {
    const shared = new Map();
    for (const { rod } of skeleton.rods) {
      for (const node of [rod.nodes[0], rod.nodes.at(-1)]) shared.set(node, (shared.get(node) || 0) + 1);
    }
    for (const { rod, firstSample, samples } of skeleton.rods) {
      const outline = outlineOf(rod, plainRadius).map(([x, y]) => [x * thickness, y * thickness]);
      const edges = outline.map((p, i) => {
        const q = outline[(i + 1) % outline.length], length = Math.hypot(q[0] - p[0], q[1] - p[1]);
        return { p, q, length, normal: [(q[1] - p[1]) / (length || 1), (p[0] - q[0]) / (length || 1)] };
      });
      skinOf(edges, skeleton.start + firstSample, samples, add, triangles);
      const cap = triangulate(outline), inner = solidRadius(edges);
      for (const [k, node, way] of [[0, rod.nodes[0], -1], [samples - 1, rod.nodes.at(-1), 1]]) {
        const end = skeleton.start + firstSample + k, first = outline.map((p) => add(end, [...p, 0], [0, 0, way]))[0];
        for (const corner of cap) triangles.push(first + corner);
        if (shared.get(node) > 1) ball(add, triangles, end, inner);
      }
    }
  }
  return { vertices: new Float32Array(vertices), triangles: new Uint32Array(triangles) };
}

// The two sides of the line on which an outline goes into a hole and out again, which is no surface.
const seamed = (edges) => {
  const key = (p, q) => [...p, ...q].join(), known = new Set(edges.map(({ p, q }) => key(p, q)));
  return edges.map(({ p, q, length }) => length === 0 || known.has(key(q, p)));
};

function skinOf(edges, start, samples, add, triangles) {
  const seam = seamed(edges);
  const soft = (one, other) => { // round corners are shaded round, sharp ones sharp
    if (one[0] * other[0] + one[1] * other[1] < 0.8) return [...one, 0];
    const sum = [one[0] + other[0], one[1] + other[1]], length = Math.hypot(...sum);
    return [sum[0] / length, sum[1] / length, 0];
  };
  const beside = ({ p, q }) => { // the edges before and after on the same ring
    const real = (_, k) => !seam[k], same = (a, b) => a[0] === b[0] && a[1] === b[1], ring = edges.filter(real);
    return [ring.find((other) => same(other.q, p)), ring.find((other) => same(other.p, q))];
  };
  edges.forEach((edge, i) => {
    if (seam[i]) return;
    const [one, other] = beside(edge), before = soft(edge.normal, one ? one.normal : edge.normal);
    const after = soft(edge.normal, other ? other.normal : edge.normal);
    for (let k = 0; k < samples; k++) {
      const first = add(start + k, [...edge.p, 0], before);
      add(start + k, [...edge.q, 0], after);
      if (k > 0) triangles.push(first - 2, first - 1, first, first, first - 1, first + 1);
    }
  });
}

// How near the outer ring comes to the axis.
function solidRadius(edges) {
  const hole = seamed(edges).indexOf(true), ring = hole > 0 ? edges.slice(0, hole) : edges;
  return ring.length ? Math.min(...ring.map(({ p, normal }) => Math.abs(p[0] * normal[0] + p[1] * normal[1]))) : 0;
}

// Corners of the triangles that fill an anticlockwise polygon, by cutting ears; it may touch itself along a seam.
function triangulate(points) {
  const left = points.map((_, i) => i), out = [];
  const cross = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const same = (a, b) => a[0] === b[0] && a[1] === b[1];
  const ear = (i) => {
    const n = left.length, [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]].map((k) => points[k]);
    if (cross(a, b, c) <= 0) return false;
    return !left.some((k) => {
      const p = points[k];
      if (same(p, a) || same(p, b) || same(p, c)) return false;
      return cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
    });
  };
  while (left.length > 2) {
    const n = left.length, i = left.findIndex((_, k) => ear(k));
    if (i >= 0) out.push(left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
    left.splice(Math.max(i, 0), 1); // a corner on a straight line is no ear and none is lost
  }
  return out;
}

// Rods that meet at an angle leave a notch between their ends; a ball of the section's inner radius fills it.
function ball(add, triangles, sample, radius) {
  const rings = 8, parts = 16;
  let first = -1;
  for (let i = 0; i <= rings; i++) {
    for (let j = 0; j <= parts; j++) {
      const polar = Math.PI * i / rings, round = 2 * Math.PI * j / parts;
      const n = [Math.sin(polar) * Math.cos(round), Math.sin(polar) * Math.sin(round), Math.cos(polar)];
      const at = add(sample, n.map((x) => x * radius), n);
      if (first < 0) first = at;
      if (i > 0 && j > 0) triangles.push(at, at - 1, at - parts - 1, at - 1, at - parts - 2, at - parts - 1);
    }
  }
}

// The section's polygon, anticlockwise and without a repeated last point; a circle where it has none.
function outlineOf(rod, plainRadius) {
  const points = [];
  for (let i = 0; i < rod.outline.length; i += 2) points.push([rod.outline[i], rod.outline[i + 1]]);
  if (points.length < 3) {
    return Array.from({ length: 16 }, (_, i) => [plainRadius * Math.cos(i * Math.PI / 8), plainRadius * Math.sin(i * Math.PI / 8)]);
  }
  const [a, z] = [points[0], points.at(-1)];
  if (a[0] === z[0] && a[1] === z[1]) points.pop();
  const area = points.reduce((sum, p, i) => {
    const q = points[(i + 1) % points.length];
    return sum + p[0] * q[1] - p[1] * q[0];
  }, 0);
  return area < 0 ? points.reverse() : points;
}

// Returns null when the browser has no WebGL 2.
function makeScene(canvas, samples) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
  if (!gl) return null;
  const skin = program(gl, SKIN_VERTEX, SKIN_FRAGMENT), line = program(gl, LINE_VERTEX, LINE_FRAGMENT);
  const rows = Math.max(1, Math.ceil(3 * samples / POSE_WIDTH)), texels = new Float32Array(4 * POSE_WIDTH * rows);
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const key of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, key, gl.NEAREST);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, POSE_WIDTH, rows);

  const skinArray = gl.createVertexArray(), skinBuffer = gl.createBuffer(), indexBuffer = gl.createBuffer();
  let corners = 0;
  gl.bindVertexArray(skinArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, skinBuffer);
  attributes(gl, skin, [["sample_", 1], ["offset", 3], ["normal", 3]], 0);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indexBuffer);

  const lineArray = gl.createVertexArray(), cornerBuffer = gl.createBuffer(), lineBuffer = gl.createBuffer();
  gl.bindVertexArray(lineArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, cornerBuffer);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]), gl.STATIC_DRAW);
  attributes(gl, line, [["corner", 2]], 0);
  gl.bindBuffer(gl.ARRAY_BUFFER, lineBuffer);
  attributes(gl, line, [["from", 3], ["to", 3], ["tint", 3], ["width", 1]], 1);
  gl.bindVertexArray(null);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => location.reload());

  return {
    setSkin({ vertices, triangles }) {
      gl.bindVertexArray(skinArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, skinBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
      gl.bindVertexArray(null);
      corners = triangles.length;
    },
    // poses (samples, 9), paints (samples, 3), lines (k, 10): from, to, colour, width in pixels
    draw({ poses, paints, lines, view, paper, sections }) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...paper, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      if (sections && corners) {
        for (let q = 0; q < samples; q++) {
          for (let k = 0; k < 3; k++) {
            for (let m = 0; m < 3; m++) texels[12 * q + 4 * k + m] = poses[9 * q + 3 * k + m];
            texels[12 * q + 4 * k + 3] = paints[3 * q + k];
          }
        }
        gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, POSE_WIDTH, rows, gl.RGBA, gl.FLOAT, texels);
        gl.useProgram(skin);
        gl.uniformMatrix4fv(gl.getUniformLocation(skin, "camera"), false, view.matrix);
        gl.uniform3fv(gl.getUniformLocation(skin, "eye"), view.eye);
        gl.uniform3fv(gl.getUniformLocation(skin, "above"), view.above);
        gl.bindVertexArray(skinArray);
        gl.drawElements(gl.TRIANGLES, corners, gl.UNSIGNED_INT, 0);
      }
      gl.useProgram(line);
      gl.uniformMatrix4fv(gl.getUniformLocation(line, "camera"), false, view.matrix);
      gl.uniform2f(gl.getUniformLocation(line, "size"), canvas.width, canvas.height);
      gl.uniform1f(gl.getUniformLocation(line, "near"), view.near);
      gl.bindVertexArray(lineArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, lineBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(lines), gl.STREAM_DRAW);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.length / 10);
      gl.bindVertexArray(null);
    },
  };
}

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  return made;
}

function attributes(gl, made, parts, divisor) {
  const stride = 4 * parts.reduce((sum, [, size]) => sum + size, 0);
  let offset = 0;
  for (const [name, size] of parts) {
    const at = gl.getAttribLocation(made, name);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(at, divisor);
    offset += 4 * size;
  }
}

// A camera that turns about a target: yaw about z, pitch over the x-y plane; straight down is no special case.
// `covered` are the shares of the width on the right and of the height below that something else covers.
function look({ target, yaw, pitch, distance }, width, height, room, covered = [0, 0]) {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const right = [-sy, cy, 0], up = [-sp * cy, -sp * sy, cp], back = [cp * cy, cp * sy, sp];
  const eye = target.map((t, i) => t + distance * back[i]);
  const near = 0.01 * distance, far = distance + 2 * room.reach + Math.hypot(...target.map((t, i) => t - room.centre[i]));
  const focal = 1 / Math.tan(0.5 * FIELD), slope = (far + near) / (near - far), shift = 2 * far * near / (near - far);
  const dot = (v) => -(v[0] * eye[0] + v[1] * eye[1] + v[2] * eye[2]);
  const rows = [right.map((x) => x * focal * height / width), up.map((x) => x * focal), back.map((x) => x * slope), back.map((x) => -x)];
  const last = [dot(right) * focal * height / width, dot(up) * focal, dot(back) * slope + shift, -dot(back)];
  covered.forEach((share, i) => {
    const shift = i === 0 ? -share : share;
    rows[i] = rows[i].map((x, j) => x + shift * rows[3][j]);
    last[i] += shift * last[3];
  });
  const matrix = new Float32Array(16);
  for (let i = 0; i < 4; i++) {
    for (let j = 0; j < 3; j++) matrix[4 * j + i] = rows[i][j];
    matrix[12 + i] = last[i];
  }
  return { matrix, eye, near, right, up, back, above: up.map((x, i) => x - 0.5 * right[i]) };
}

const FIELD = 0.5; // radians, the vertical field of view

// Pixels (x, y) of a point, or null behind the eye.
function project(view, point, width, height) {
  const m = view.matrix, at = (i) => m[i] * point[0] + m[4 + i] * point[1] + m[8 + i] * point[2] + m[12 + i];
  const w = at(3);
  return w > view.near ? [(0.5 + 0.5 * at(0) / w) * width, (0.5 - 0.5 * at(1) / w) * height] : null;
}
