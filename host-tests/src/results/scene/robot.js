// The 3-D scene of a robot: its bodies, belts and legs, the ground, and what decides whether it
// tips over. `still` is what does not change (host-tests/src/results/scene), a state what does.

const EDGES = ["back", "front", "left", "right"];
// Length of a robot, m, from which the camera takes its distance.
const sizeOf = still => ({ b2p2: .95, crawler: .5, hylos: .8, "rt-mover": .75 })[still.robot] || 1;
// The place at which the camera looks.
const aimAt = ({ cog, axle_1: axle }) => [cog[0], cog[1], cog[2] * .5 + axle[2] * .5];

// Unpacks data of the page into a response.
function unpack(text) {
  const packed = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")));
}

// Colours of the scene, light or dark as the page is.
function sceneTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)").matches, style = getComputedStyle(document.documentElement);
  const band = number => {
    const hex = style.getPropertyValue(`--band${number}`).trim();
    return [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16) / 255);
  };
  return {
    haze: dark ? [.075, .09, .10] : [.90, .915, .92], ground: dark ? [.22, .245, .255] : [.80, .785, .745],
    line: dark ? [.30, .33, .345] : [.70, .685, .64], light: dark ? 1.25 : 1,
    body: dark ? [.36, .50, .62] : [.33, .52, .68], second: dark ? [.62, .66, .70] : [.56, .60, .64],
    tyre: dark ? [.36, .385, .41] : [.17, .18, .19], hub: dark ? [.72, .74, .76] : [.78, .79, .80],
    load: [.80, .42, .16], ghost: dark ? [.93, .54, .82] : [.69, .22, .56], force: dark ? [.55, .82, 1] : [.10, .40, .75],
    cog: dark ? [1, .82, .3] : [.86, .55, 0], zmp: dark ? [.85, .6, 1] : [.52, .22, .72],
    bands: [0, 1, 2, 3].map(band),
  };
}

// Adds the buttons that choose the camera.
function addCameras(host, camera) {
  const show = () => { for (const button of host.children) button.setAttribute("aria-pressed", String(button.dataset.mode === camera.mode)); };
  for (const [mode, name] of Object.entries({ follow: "Follow", side: "Side", top: "Top", orbit: "Orbit" })) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: name });
    button.dataset.mode = mode;
    button.onclick = () => {
      if (mode === "orbit") Object.assign(camera, { yaw: camera.heading - 2.45, pitch: .38 });
      camera.mode = mode;
      show();
    };
    host.append(button);
  }
  camera.changed = show;
  show();
}

// Band of a margin, m, by the levels of the guard: 0 free, 1 caution, 2 limit, 3 trip.
function bandOf(margin, levels) {
  if (!(margin >= levels.trip)) return 3;
  return margin < levels.stop ? 2 : margin < levels.caution ? 1 : 0;
}

// Convex hull of points in x and y, counter-clockwise.
function hullOf(points) {
  const sorted = points.slice().sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = list => {
    const kept = [];
    for (const point of list) {
      while (kept.length > 1 && turn(kept.at(-2), kept.at(-1), point) <= 1e-6) kept.pop();
      kept.push(point);
    }
    kept.pop();
    return kept;
  };
  return sorted.length < 3 ? sorted : [...half(sorted), ...half(sorted.reverse())];
}

// Zero moment point of the whole mass in its centre of gravity, from the places of that centre.
function createZmp() {
  let last, speed, acceleration = [0, 0, 0];
  return (time, cog, floor) => {
    if (!last || time <= last.time || time > last.time + 0.2) {
      last = { time, cog }; speed = null; acceleration = [0, 0, 0];
    } else {
      const dt = time - last.time, now = vector.times(vector.minus(cog, last.cog), 1 / dt);
      if (speed) {
        const raw = vector.times(vector.minus(now, speed), 1 / dt), part = dt / (0.25 + dt);
        acceleration = acceleration.map((value, i) => value + (raw[i] - value) * part);
      }
      speed = now;
      last = { time, cog };
    }
    const fall = 9.81 + acceleration[2];
    if (fall < 2) return null;
    const high = cog[2] - floor;
    return [cog[0] - high * acceleration[0] / fall, cog[1] - high * acceleration[1] / fall, floor];
  };
}

function createScene(renderer, still) {
  const ground = renderer.mesh(), belts = [renderer.mesh(), renderer.mesh()];
  const zmpOf = createZmp();
  const trails = { cog: [], zmp: [] };
  const travel = [0, 0];
  let beltData = new Float32Array(0);
  let now = null, zmp = null, groundArea = null, flash = null;
  const payload = Object.values(still.description.robot)[0].payload;
  const hasBelts = still.robot === "b2p2" || still.robot === "crawler";

  // Triangles of a ground from the lines of its points, each with the normal of its face.
  function setGround({ x, y, z }, area) {
    const columns = y.length, data = new Float32Array((x.length - 1) * (columns - 1) * 36);
    let at = 0;
    const corner = (i, j) => [x[i], y[j], z[i * columns + j]];
    for (let i = 0; i + 1 < x.length; i++) for (let j = 0; j + 1 < columns; j++) {
      const a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
      for (const [p, q, r] of [[a, b, c], [a, c, d]]) {
        const n = vector.cross(vector.minus(q, p), vector.minus(r, p));
        // A cell without area between the two lines of a vertical face.
        if (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < 1e-20) continue;
        for (const point of [p, q, r]) { data.set(point, at); data.set(n, at + 3); at += 6; }
      }
    }
    ground.fill(data, at);
    groundArea = area;
  }

  // The area that a ground should cover now; null if the present one still serves.
  function wantsGround() {
    const [cx, cy] = now ? now.sample.truth.cog : [0, 0], half = 7;
    let area = [[cx - half, cx + half], [cy - half, cy + half]];
    const limits = still.extent;
    if (limits) area = limits;
    if (!groundArea) return area;
    if (limits) return null;
    const inside = ([from, to], value) => value - from > 4 && to - value > 4;
    return inside(groundArea[0], cx) && inside(groundArea[1], cy) ? null : area;
  }

  // Adds a state. `dt` is the time since the one before, s.
  function update(state) {
    const { truth, time_s: time } = state.sample;
    const dt = now ? time - now.sample.time_s : 0;
    if (dt < 0) { trails.cog = []; trails.zmp = []; }
    now = state;
    if (dt > 0) for (const side of [0, 1]) travel[side] += truth.belt_speed[side] * dt;
    const floor = floorOf(truth);
    zmp = zmpOf(time, truth.cog, floor);
    if (dt > 0) for (const [trail, place] of [[trails.cog, truth.cog], [trails.zmp, zmp]]) {
      if (!place) continue;
      const last = trail.at(-1);
      if (!last || Math.hypot(place[0] - last[0], place[1] - last[1], place[2] - last[2]) > 0.01) trail.push(place);
      if (trail.length > 400) trail.shift();
    }
  }

  function floorOf(truth) {
    const { contacts } = truth;
    return contacts.length ? contacts.reduce((sum, point) => sum + point[2], 0) / contacts.length : truth.axle_1[2];
  }

  function beltMesh(mesh, strips, turned) {
    const left = matrix.turn(matrix.pose(turned.place, turned.rotation), [0, 1, 0]);
    const points = strips.reduce((sum, strip) => sum + strip.points.length, 0);
    const room = points * 8 * 18 + strips.length * 80 * 36 * 6;
    if (beltData.length < room) beltData = new Float32Array(2 * room);
    let at = 0;
    const put = (p, n) => { beltData[at] = p[0]; beltData[at + 1] = p[1]; beltData[at + 2] = p[2];
      beltData[at + 3] = n[0]; beltData[at + 4] = n[1]; beltData[at + 5] = n[2]; at += 6; };
    const quad = (a, b, c, d, n) => { for (const p of [a, b, c, a, c, d]) put(p, n); };
    const add = (p, l, ls, o, os) => [p[0] + l[0] * ls + o[0] * os, p[1] + l[1] * ls + o[1] * os, p[2] + l[2] * ls + o[2] * os];
    const THICK = 0.012, CLEAT = 0.006, PITCH = 0.05;
    strips.forEach(({ width, points: line }, side) => {
      const half = width / 2, count = line.length;
      if (count < 3) return;
      let along = ((travel[side] % PITCH) + PITCH) % PITCH;
      for (let i = 0; i < count; i++) {
        const p = line[i], q = line[(i + 1) % count], d = vector.minus(q, p), length = vector.length(d);
        if (length < 1e-5) continue;
        const forward = vector.times(d, 1 / length), out = vector.cross(left, forward);
        const [a, b] = [p, q];
        quad(add(a, left, half, out, 0), add(a, left, -half, out, 0), add(b, left, -half, out, 0), add(b, left, half, out, 0), out);
        const inward = vector.times(out, -1);
        quad(add(a, left, half, out, -THICK), add(a, left, -half, out, -THICK), add(b, left, -half, out, -THICK), add(b, left, half, out, -THICK), inward);
        for (const s of [half, -half]) quad(add(a, left, s, out, 0), add(b, left, s, out, 0), add(b, left, s, out, -THICK), add(a, left, s, out, -THICK), vector.times(left, Math.sign(s)));
        // Cleats: small bars across the belt.
        for (; along < length; along += PITCH) {
          const c = add(p, forward, along, out, 0), f = 0.006;
          const corner = (x, y, z) => add(add(c, forward, x * f, left, y * half), out, z, left, 0);
          quad(corner(-1, -1, CLEAT), corner(1, -1, CLEAT), corner(1, 1, CLEAT), corner(-1, 1, CLEAT), out);
          for (const x of [-1, 1]) quad(corner(x, -1, 0), corner(x, 1, 0), corner(x, 1, CLEAT), corner(x, -1, CLEAT), vector.times(forward, x));
          for (const y of [-1, 1]) quad(corner(-1, y, 0), corner(1, y, 0), corner(1, y, CLEAT), corner(-1, y, CLEAT), vector.times(left, y));
        }
        along -= length;
      }
    });
    mesh.fill(beltData, at);
  }

  // Adds the bodies of a state to the items. A ghost is another run of the same robot.
  function addRobot(items, state, theme, ghost) {
    const tone = (color, alpha = 1) => ghost ? [...theme.ghost, 0.32] : [...color, alpha];
    const put = (mesh, model, size, color) => items.push({ mesh, model, size, color: tone(color), casts: !ghost });
    state.sample.bodies.forEach((pose, index) => {
      const model = matrix.pose(pose.place, pose.rotation), body = still.bodies[index];
      body.parts.forEach((part, number) => {
        const at = matrix.moved(model, part.centre);
        if (part.box) {
          put(renderer.box, at, part.box, index === 0 || still.robot === "b2p2" ? theme.body : theme.second);
          return;
        }
        const [radius, width] = part.wheel, rolls = hasBelts ? radius - 0.012 : radius;
        const spin = hasBelts ? matrix.spun(at, (travel[0] + travel[1]) / 2 / radius) : at;
        put(renderer.cylinder, spin, [rolls, width * (hasBelts ? 0.98 : 1), rolls], theme.tyre);
        put(renderer.cylinder, spin, [rolls * 0.62, width * 1.01 + 0.002, rolls * 0.62], theme.hub);
        for (const turn of [0, 1, 2]) {
          put(renderer.box, matrix.spun(spin, turn * Math.PI / 3), [rolls * 1.5, width * 1.015 + 0.004, rolls * 0.14], theme.tyre);
        }
      });
    });
    if (state.sample.belts.length) {
      const mesh = belts[Number(ghost)];
      beltMesh(mesh, state.sample.belts, state.sample.bodies[0]);
      items.push({ mesh, color: tone(theme.tyre), casts: !ghost });
    }
    const points = state.sample.truth.points || [];
    for (const line of still.sketch.lines) for (let i = 0; i + 1 < line.length; i++) {
      const [a, b] = [points[line[i]], points[line[i + 1]]];
      if (!a || !b || still.robot === "crawler") continue;
      const d = vector.minus(b, a), length = vector.length(d);
      if (length < 1e-4) continue;
      const y = vector.times(d, 1 / length), x = vector.unit(vector.cross(y, Math.abs(y[2]) < .9 ? [0, 0, 1] : [1, 0, 0]));
      const middle = vector.times(vector.plus(a, b), .5);
      put(renderer.cylinder, matrix.frame(x, y, vector.cross(x, y), middle), [0.014, length, 0.014], theme.second);
    }
    if (payload && state.sample.time_s >= (payload.from_s || 0) && payload.mass_kg > 0 && !ghost) {
      const on = state.sample.bodies[still.robot === "rt-mover" ? 1 : 0];
      const side = 0.045 * Math.cbrt(payload.mass_kg);
      const model = matrix.moved(matrix.pose(on.place, on.rotation), payload.place_m);
      items.push({ mesh: renderer.box, model, size: [side, side, side], color: theme.load });
    }
  }

  // Which of the guard's edges an edge of the support belongs to: by the direction of its normal.
  function edgeOf(a, b, yaw) {
    const outward = [b[1] - a[1], a[0] - b[0]];
    const along = outward[0] * Math.cos(yaw) + outward[1] * Math.sin(yaw), across = outward[1] * Math.cos(yaw) - outward[0] * Math.sin(yaw);
    return Math.abs(along) > Math.abs(across) ? (along > 0 ? 1 : 0) : across > 0 ? 2 : 3;
  }

  // Margin to each edge of the support, and the support itself.
  function support() {
    const { truth, received } = now.sample;
    const hull = hullOf(truth.contacts);
    return hull.map((a, i) => {
      const b = hull[(i + 1) % hull.length], edge = edgeOf(a, b, truth.yaw);
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      const margin = ((b[0] - a[0]) * (truth.cog[1] - a[1]) - (b[1] - a[1]) * (truth.cog[0] - a[0])) / length;
      return { a, b, edge, margin: received.margins ? received.margins[edge] : margin };
    });
  }

  function draw(look, theme, shown, ghostState) {
    if (!now) return;
    const items = [], marks = [], strokes = [], areas = [];
    if (ground.count) items.push({ mesh: ground, color: theme.ground, grid: 0.25, casts: true });
    addRobot(items, now, theme, false);
    if (ghostState) addRobot(items, ghostState, theme, true);
    const { truth } = now.sample, lift = 0.004;
    const raise = ([x, y, z], by = lift) => [x, y, z + by];
    if (shown.support && truth.contacts.length > 1) {
      const edges = support();
      areas.push({ points: edges.map(({ a }) => raise(a)), color: [...theme.bands[0], 0.13] });
      for (const { a, b, edge, margin } of edges) {
        const blinks = flash && flash.edge === edge && Math.sin(performance.now() / 90) > 0;
        const color = blinks ? theme.bands[3] : theme.bands[bandOf(margin, still.levels)];
        strokes.push({ from: raise(a), to: raise(b), color, width: flash && flash.edge === edge ? 7 : 4 });
      }
    }
    if (shown.forces) for (const [place, force] of now.forces) {
      const size = vector.length(force);
      if (size < 1) continue;
      const length = Math.min(0.004 * size, 0.6), along = vector.unit(force), tip = vector.plus(place, vector.times(along, length));
      strokes.push({ from: place, to: vector.plus(place, vector.times(along, length * .85)), color: [...theme.force, .9], width: 3 });
      const z = along, x = vector.unit(vector.cross(z, Math.abs(z[1]) < .9 ? [0, 1, 0] : [1, 0, 0]));
      items.push({ mesh: renderer.cone, model: matrix.frame(x, vector.cross(z, x), z, tip), size: [.009, .009, .03], color: theme.force, casts: false });
    }
    const floor = floorOf(truth);
    if (shown.trails) for (const [trail, color] of [[trails.cog, theme.cog], [trails.zmp, theme.zmp]]) {
      for (let i = 1; i < trail.length; i++) strokes.push({ from: trail[i - 1], to: trail[i], color: [...color, .15 + .6 * i / trail.length], width: 2 });
    }
    if (shown.balance) {
      const foot = [truth.cog[0], truth.cog[1], floor];
      strokes.push({ from: truth.cog, to: raise(foot), color: [...theme.cog, .8], width: 2 });
      const ball = (place, size, color) => marks.push({ mesh: renderer.sphere, model: matrix.frame([1, 0, 0], [0, 1, 0], [0, 0, 1], place), size: [size, size, size], color });
      ball(truth.cog, .016, theme.cog);
      ball(raise(foot), .009, theme.cog);
      if (zmp) ball(raise(zmp), .012, theme.zmp);
    }
    renderer.draw({ items, marks, strokes, areas }, look, theme);
  }

  return {
    setGround, wantsGround, update, draw, support,
    state: () => now,
    // Lets an edge blink for a moment.
    flash(edge) { flash = edge === null ? null : { edge }; },
    clearTrails() { trails.cog = []; trails.zmp = []; },
  };
}

// Cameras: follow (behind and beside the robot), side, top, and orbit, which the pointer moves.
// In a page that scrolls, the wheel zooms with the control key.
function createCamera(canvas, size, scrolls = false) {
  const camera = { mode: "follow", yaw: -2.2, pitch: .42, at: null, heading: 0 };
  // Starts anew with a robot of this size.
  camera.begin = size => Object.assign(camera, { at: null, heading: 0, distance: camera.size === size ? camera.distance : 3.4 * size, size });
  camera.begin(size);
  const pointers = new Map();
  const orbit = () => { if (camera.mode !== "orbit") { Object.assign(camera, anglesOf(), { mode: "orbit" }); camera.changed?.(); } };
  const anglesOf = () => ({
    follow: { yaw: camera.heading - 2.45, pitch: .38 },
    side: { yaw: camera.heading - Math.PI / 2, pitch: .1 },
    top: { yaw: camera.heading - Math.PI, pitch: 1.5 },
    orbit: { yaw: camera.yaw, pitch: camera.pitch },
  })[camera.mode];
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]); });
  canvas.addEventListener("pointermove", event => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const here = [event.clientX, event.clientY];
    if (pointers.size === 1) {
      orbit();
      camera.yaw -= (here[0] - before[0]) * .008;
      camera.pitch = Math.min(1.5, Math.max(-.1, camera.pitch + (here[1] - before[1]) * .006));
    } else {
      const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = p => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      zoom(apart(before) / apart(here));
    }
    pointers.set(event.pointerId, here);
  });
  for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, event => pointers.delete(event.pointerId));
  const zoom = by => { camera.distance = Math.min(8 * camera.size, Math.max(.8 * camera.size, camera.distance * by)); };
  canvas.addEventListener("wheel", event => { if (scrolls && !event.ctrlKey) return; event.preventDefault(); zoom(Math.exp(event.deltaY * .001)); }, { passive: false });
  camera.zoom = zoom;
  // Follows a place and a heading; returns what the renderer needs.
  camera.look = (place, heading, dt, ratio) => {
    const part = 1 - Math.exp(-dt / .25);
    camera.at = camera.at ? camera.at.map((value, i) => value + (place[i] - value) * part) : place.slice();
    if (vector.length(vector.minus(camera.at, place)) > 1) camera.at = place.slice();
    const turn = Math.atan2(Math.sin(heading - camera.heading), Math.cos(heading - camera.heading));
    camera.heading += turn * (1 - Math.exp(-dt / .8));
    const { yaw, pitch } = anglesOf(), c = Math.cos(pitch);
    const away = [Math.cos(yaw) * c, Math.sin(yaw) * c, Math.sin(pitch)];
    const narrow = canvas.clientWidth < canvas.clientHeight ? 1.2 : 1;
    const distance = camera.distance * narrow;
    const up = camera.mode === "top" || pitch > 1.45 ? [Math.cos(yaw + Math.PI), Math.sin(yaw + Math.PI), 0] : [0, 0, 1];
    // On a narrow screen the guard's texts are above the robot.
    const at = narrow > 1 ? vector.plus(camera.at, vector.times(up, .09 * distance)) : camera.at;
    return { eye: vector.plus(at, vector.times(away, distance)), at, up, angle: .62, far: 9 + 1.5 * distance, reach: 1.6 * camera.size + .4, ratio };
  };
  return camera;
}
