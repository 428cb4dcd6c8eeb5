// A small renderer on WebGL 2 for bodies on their ground: lit meshes with a shadow, wide lines, and
// flat areas. Axes are those of the simulator: x forward, y left, z up; matrices are in columns.

const matrix = {
  identity: () => new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
  product(a, b) {
    const c = new Float32Array(16);
    for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) {
      c[4 * i + j] = a[j] * b[4 * i] + a[4 + j] * b[4 * i + 1] + a[8 + j] * b[4 * i + 2] + a[12 + j] * b[4 * i + 3];
    }
    return c;
  },
  perspective(angle, aspect, near, far) {
    const f = 1 / Math.tan(angle / 2), m = new Float32Array(16);
    m[0] = f / aspect; m[5] = f; m[10] = (far + near) / (near - far); m[11] = -1; m[14] = 2 * far * near / (near - far);
    return m;
  },
  orthographic(half, near, far) {
    const m = new Float32Array(16);
    m[0] = m[5] = 1 / half; m[10] = 2 / (near - far); m[14] = (far + near) / (near - far); m[15] = 1;
    return m;
  },
  look(eye, at, up) {
    const z = vector.unit(vector.minus(eye, at)), x = vector.unit(vector.cross(up, z)), y = vector.cross(z, x);
    return new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
      -vector.dot(x, eye), -vector.dot(y, eye), -vector.dot(z, eye), 1]);
  },
  // Pose of a body: place and unit quaternion x, y, z, w.
  pose([px, py, pz], [x, y, z, w]) {
    return new Float32Array([
      1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0,
      2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0,
      2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0, px, py, pz, 1]);
  },
  // Axes and origin of a local frame.
  frame: (x, y, z, o) => new Float32Array([...x, 0, ...y, 0, ...z, 0, ...o, 1]),
  at: (m, [x, y, z]) => [0, 1, 2].map(i => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]),
  turn: (m, [x, y, z]) => [0, 1, 2].map(i => m[i] * x + m[4 + i] * y + m[8 + i] * z),
  moved(m, place) {
    const moved = m.slice(), to = matrix.at(m, place);
    moved[12] = to[0]; moved[13] = to[1]; moved[14] = to[2];
    return moved;
  },
  // Rotation about the local y axis.
  spun(m, angle) {
    const c = Math.cos(angle), s = Math.sin(angle), r = m.slice();
    for (let i = 0; i < 3; i++) { r[i] = m[i] * c - m[8 + i] * s; r[8 + i] = m[i] * s + m[8 + i] * c; }
    return r;
  },
};

const vector = {
  plus: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  minus: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  times: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  length: a => Math.hypot(a[0], a[1], a[2]),
  unit(a) { const l = Math.hypot(a[0], a[1], a[2]) || 1; return [a[0] / l, a[1] / l, a[2] / l]; },
};

// Points and normals of a mesh: six numbers a point, three points a triangle.
const shapes = {
  box() {
    const data = [];
    for (let axis = 0; axis < 3; axis++) for (const sign of [-1, 1]) {
      const normal = [0, 0, 0], u = (axis + 1) % 3, v = (axis + 2) % 3;
      normal[axis] = sign;
      for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) {
        const place = [0, 0, 0];
        place[axis] = sign / 2; place[u] = sign * a / 2; place[v] = b / 2;
        data.push(...place, ...normal);
      }
    }
    return data;
  },
  // Radius 1, length 1, about the y axis.
  cylinder(sides = 36) {
    const data = [], at = i => [Math.cos(2 * Math.PI * i / sides), Math.sin(2 * Math.PI * i / sides)];
    for (let i = 0; i < sides; i++) {
      const [x0, z0] = at(i), [x1, z1] = at(i + 1), p = (x, y, z, ...n) => data.push(x, y, z, ...n);
      for (const [x, y, z] of [[x0, -.5, z0], [x1, .5, z1], [x1, -.5, z1], [x0, -.5, z0], [x0, .5, z0], [x1, .5, z1]]) p(x, y, z, x, 0, z);
      for (const y of [-.5, .5]) { const n = [0, 2 * y, 0]; p(0, y, 0, ...n); p(x0, y, z0, ...n); p(x1, y, z1, ...n); }
    }
    return data;
  },
  sphere(rings = 10) {
    const data = [], at = (i, j) => {
      const a = Math.PI * i / rings - Math.PI / 2, b = Math.PI * j / rings;
      return [Math.cos(a) * Math.cos(b), Math.cos(a) * Math.sin(b), Math.sin(a)];
    };
    for (let i = 0; i < rings; i++) for (let j = 0; j < 2 * rings; j++) {
      for (const [a, b] of [[0, 0], [0, 1], [1, 1], [0, 0], [1, 1], [1, 0]]) { const p = at(i + a, j + b); data.push(...p, ...p); }
    }
    return data;
  },
  // A cone along z with its point at the origin, radius 1 and height 1.
  cone(sides = 20) {
    const data = [];
    for (let i = 0; i < sides; i++) {
      const a = 2 * Math.PI * i / sides, b = 2 * Math.PI * (i + 1) / sides;
      for (const t of [null, a, b]) {
        const mid = t ?? (a + b) / 2, n = [Math.cos(mid) * .7, Math.sin(mid) * .7, .7];
        data.push(...(t === null ? [0, 0, 0] : [Math.cos(t), Math.sin(t), -1]), ...n);
      }
      data.push(0, 0, -1, 0, 0, -1, Math.cos(b), Math.sin(b), -1, 0, 0, -1, Math.cos(a), Math.sin(a), -1, 0, 0, -1);
    }
    return data;
  },
};

function createRenderer(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
  if (!gl) return null;
  const compile = (vertex, fragment) => {
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, `#version 300 es\nprecision highp float;\nprecision highp sampler2DShadow;\n${text}`);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    ["place", "normal", "from", "to", "tint", "wide"].forEach((name, index) => gl.bindAttribLocation(program, index, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const places = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  };
  const solid = compile(`
    in vec3 place, normal; uniform mat4 view, model, lamp; uniform vec3 size;
    out vec3 at, n; out vec4 lit;
    void main() {
      vec4 w = model * vec4(place * size, 1.);
      at = w.xyz; n = mat3(model) * (normal / size); lit = lamp * w; gl_Position = view * w;
    }`, `
    in vec3 at, n; in vec4 lit; uniform vec4 color; uniform vec3 sun, eye, haze, line; uniform float grid, far; uniform vec2 light;
    uniform sampler2DShadow shadow; out vec4 result;
    void main() {
      vec3 N = normalize(n), V = normalize(eye - at);
      if (dot(N, V) < 0.) N = -N;
      float d = max(dot(N, sun), 0.), s = 1.;
      vec3 p = lit.xyz * .5 + .5;
      if (light.x > 0. && all(greaterThan(p, vec3(0.))) && all(lessThan(p, vec3(1.)))) {
        s = 0.;
        for (int i = 0; i < 4; i++) {
          vec2 o = (vec2(float(i & 1), float(i >> 1)) - .5) * light.x;
          s += .25 * texture(shadow, vec3(p.xy + o, p.z - .0012 - .003 * (1. - d)));
        }
      }
      vec3 c = color.rgb;
      if (grid > 0.) {
        vec2 g = at.xy / grid, w = max(fwidth(g), vec2(1e-6)), e = abs(fract(g - .5) - .5) / w;
        float near = 1. - smoothstep(.15, .5, max(w.x, w.y));
        c = mix(c, line, near * smoothstep(.5, .9, N.z) * (1. - min(min(e.x, e.y), 1.)));
      }
      vec3 ambient = mix(vec3(.30, .29, .28), vec3(.45, .48, .52), N.z * .5 + .5) * light.y;
      float shine = pow(max(dot(reflect(-sun, N), V), 0.), 24.) * (grid > 0. ? 0. : .16) * s;
      vec3 shaded = c * (ambient + d * s * vec3(.62, .60, .54)) + shine;
      float f = 1. - exp(-pow(length(eye - at) / far, 3.));
      result = vec4(mix(shaded, haze, f), color.a);
    }`);
  const depth = compile(`
    in vec3 place; uniform mat4 view, model; uniform vec3 size;
    void main() { gl_Position = view * (model * vec4(place * size, 1.)); }`, `
    void main() {}`);
  const lines = compile(`
    in vec3 place; in vec3 from, to; in vec4 tint; in float wide; uniform mat4 view; uniform vec2 screen; uniform float fade;
    out vec4 c; out vec2 across;
    void main() {
      vec4 a = view * vec4(from, 1.), b = view * vec4(to, 1.);
      a.w = max(a.w, .01); b.w = max(b.w, .01);
      vec2 p = a.xy / a.w * screen, q = b.xy / b.w * screen, d = q - p;
      float l = length(d); d = l > 1e-4 ? d / l : vec2(1., 0.);
      vec4 o = place.x < .5 ? a : b;
      float w = wide * .5 + 1.;
      o.xy += (vec2(-d.y, d.x) * place.y * w + d * (place.x - .5) * 2. * w * .5) / screen * o.w;
      gl_Position = o; c = vec4(tint.rgb, tint.a * fade); across = vec2(place.y * w, wide * .5);
    }`, `
    in vec4 c; in vec2 across; out vec4 result;
    void main() { result = vec4(c.rgb, c.a * clamp(across.y + .5 - abs(across.x), 0., 1.)); }`);
  const flat = compile(`
    in vec3 place; in vec4 tint; uniform mat4 view; out vec4 c;
    void main() { gl_Position = view * vec4(place, 1.); c = tint; }`, `
    in vec4 c; out vec4 result; void main() { result = c; }`);

  const SHADOW = 1024;
  const shadowMap = gl.createTexture(), shadowFrame = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, shadowMap);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW, SHADOW);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  gl.bindFramebuffer(gl.FRAMEBUFFER, shadowFrame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, shadowMap, 0);
  gl.drawBuffers([gl.NONE]);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);

  const attribute = (index, size, stride, offset, divisor = 0) => {
    gl.enableVertexAttribArray(index);
    gl.vertexAttribPointer(index, size, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(index, divisor);
  };
  // A mesh; one that changes is filled again with `fill`.
  function mesh(data) {
    const array = gl.createVertexArray(), buffer = gl.createBuffer(), made = { array, count: 0 };
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    attribute(0, 3, 24, 0);
    attribute(1, 3, 24, 12);
    made.fill = (values, length = values.length, use = gl.DYNAMIC_DRAW) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values.subarray ? values.subarray(0, length) : new Float32Array(values), use);
      made.count = length / 6;
    };
    if (data) made.fill(new Float32Array(data), data.length, gl.STATIC_DRAW);
    return made;
  }
  const corner = gl.createBuffer(), lineArray = gl.createVertexArray(), lineBuffer = gl.createBuffer();
  gl.bindVertexArray(lineArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, corner);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 1, 0]), gl.STATIC_DRAW);
  attribute(0, 3, 12, 0);
  gl.bindBuffer(gl.ARRAY_BUFFER, lineBuffer);
  attribute(2, 3, 44, 0, 1); attribute(3, 3, 44, 12, 1); attribute(4, 4, 44, 24, 1); attribute(5, 1, 44, 40, 1);
  const flatArray = gl.createVertexArray(), flatBuffer = gl.createBuffer();
  gl.bindVertexArray(flatArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, flatBuffer);
  attribute(0, 3, 28, 0); attribute(4, 4, 28, 12);
  gl.bindVertexArray(null);

  const common = { box: mesh(shapes.box()), cylinder: mesh(shapes.cylinder()), sphere: mesh(shapes.sphere()), cone: mesh(shapes.cone()) };
  const sun = vector.unit([-0.35, 0.5, 0.9]);
  let shadows = true;

  // Draws `items` ({mesh, model, size, color, grid, casts}), `marks` (the same, in front of everything),
  // `strokes` ({from, to, color, width}) and `areas` ({points, color}). `look` is the camera.
  function draw({ items, marks, strokes, areas }, look, theme) {
    const ratio = look.ratio;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const projection = matrix.perspective(look.angle, width / height, 0.05, 120);
    const view = matrix.product(projection, matrix.look(look.eye, look.at, look.up));
    const lamp = matrix.product(matrix.orthographic(look.reach, 0.1, 12 + 2 * look.reach),
      matrix.look(vector.plus(look.at, vector.times(sun, 6 + look.reach)), look.at, [0, 0, 1]));
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    const put = (places, item) => {
      gl.uniformMatrix4fv(places.model, false, item.model || unmoved);
      gl.uniform3fv(places.size, item.size || ones);
      gl.bindVertexArray(item.mesh.array);
    };
    if (shadows) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, shadowFrame);
      gl.viewport(0, 0, SHADOW, SHADOW);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.useProgram(depth.program);
      gl.uniformMatrix4fv(depth.places.view, false, lamp);
      for (const item of items) if (item.casts !== false) { put(depth.places, item); gl.drawArrays(gl.TRIANGLES, 0, item.mesh.count); }
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(...theme.haze, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { places } = solid;
    gl.useProgram(solid.program);
    gl.uniformMatrix4fv(places.view, false, view);
    gl.uniformMatrix4fv(places.lamp, false, lamp);
    gl.uniform3fv(places.sun, sun);
    gl.uniform3fv(places.eye, look.eye);
    gl.uniform3fv(places.haze, theme.haze);
    gl.uniform3fv(places.line, theme.line);
    gl.uniform1f(places.far, look.far);
    gl.uniform2f(places.light, shadows ? 1.4 / SHADOW : 0, theme.light);
    gl.uniform1i(places.shadow, 0);
    gl.bindTexture(gl.TEXTURE_2D, shadowMap);
    const paint = item => {
      put(places, item);
      gl.uniform4fv(places.color, item.color.length === 4 ? item.color : [...item.color, 1]);
      gl.uniform1f(places.grid, item.grid || 0);
      gl.drawArrays(gl.TRIANGLES, 0, item.mesh.count);
    };
    const clear = item => item.color.length === 4 && item.color[3] < 1;
    for (const item of items) if (!clear(item)) paint(item);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    for (const item of items) if (clear(item)) paint(item);

    gl.depthMask(false);
    if (areas.length) {
      const data = [];
      for (const { points, color } of areas) for (let i = 1; i + 1 < points.length; i++) {
        for (const point of [points[0], points[i], points[i + 1]]) data.push(...point, ...color);
      }
      gl.useProgram(flat.program);
      gl.uniformMatrix4fv(flat.places.view, false, view);
      gl.bindVertexArray(flatArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, flatBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.DYNAMIC_DRAW);
      gl.disable(gl.DEPTH_TEST);
      gl.drawArrays(gl.TRIANGLES, 0, data.length / 7);
      gl.enable(gl.DEPTH_TEST);
    }
    if (strokes.length) {
      const data = new Float32Array(strokes.length * 11);
      strokes.forEach(({ from, to, color, width: wide }, i) => {
        data.set(from, 11 * i); data.set(to, 11 * i + 3); data.set(color, 11 * i + 6);
        if (color.length < 4) data[11 * i + 9] = 1;
        data[11 * i + 10] = wide * ratio;
      });
      gl.useProgram(lines.program);
      gl.uniformMatrix4fv(lines.places.view, false, view);
      gl.uniform2f(lines.places.screen, width / 2, height / 2);
      gl.bindVertexArray(lineArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, lineBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
      // What is hidden shines through.
      gl.uniform1f(lines.places.fade, 1);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, strokes.length);
      gl.depthFunc(gl.GREATER);
      gl.uniform1f(lines.places.fade, 0.45);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, strokes.length);
      gl.depthFunc(gl.LESS);
    }
    gl.depthMask(true);
    if (marks.length) {
      gl.useProgram(solid.program);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      marks.forEach(paint);
    }
    gl.bindVertexArray(null);
    return view;
  }
  const unmoved = matrix.identity(), ones = [1, 1, 1];
  return { mesh, draw, ...common, setShadows: on => { shadows = on; } };
}
