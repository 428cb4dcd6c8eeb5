// Two runs of a scenario, with the guard's filter on and off: both robots in one scene, one of them
// as a ghost, and their curves and events on one time line.
const $ = id => document.getElementById(id);
const make = (tag, attributes = {}, ...inside) => {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value); else element.setAttribute(key, value);
  }
  element.append(...inside);
  return element;
};
const app = { time: 0, playing: false, window: null, frames: [], errors: [] };
window.tautrack = app;

const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// The curves: name, unit, and value in a state; a value that is absent leaves a gap.
const degrees = value => value * 180 / Math.PI;
const CURVES = [
  ["Pitch", "°", state => degrees(state.sample.truth.pitch)],
  ["Narrowest margin of the guard", "mm", ({ sample: { received } }) => received.margins ? 1000 * Math.min(...received.margins) : NaN],
  ["Speed over ground", "m/s", state => state.sample.truth.ground_speed],
  ["Speed that passes", "m/s", state => state.sample.received.passed_speed],
  ["Chassis angle", "°", state => degrees(state.sample.truth.theta)],
  ["Height of the centre of gravity", "m", state => state.sample.truth.cog[2]],
  ["Belt tension", "N", state => state.sample.received.belt_tension],
];

function indexAt(run, time) {
  let low = 0, high = run.states.length - 1;
  while (low < high) { const middle = low + high + 1 >> 1; if (run.states[middle].sample.time_s <= time + 1e-6) low = middle; else high = middle - 1; }
  return low;
}

function shifted(state, by) {
  const move = ([x, y, z]) => [x, y + by, z];
  return { ...state, sample: { ...state.sample, bodies: state.sample.bodies.map(pose => ({ ...pose, place: move(pose.place) })),
    belts: state.sample.belts.map(belt => ({ ...belt, points: belt.points.map(move) })),
    truth: { ...state.sample.truth, points: (state.sample.truth.points || []).map(move) } } };
}

function begin(data) {
  const [on, off] = app.runs = data.runs;
  app.theme = sceneTheme();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { app.theme = sceneTheme(); drawPlots(); });
  app.renderer = createRenderer($("view"));
  if (!app.renderer) throw new Error("This browser has no WebGL 2.");
  app.scene = createScene(app.renderer, data.still);
  app.scene.setGround(data.ground, null);
  app.camera = createCamera($("view"), sizeOf(data.still));
  app.camera.mode = "side";
  addCameras($("cameras"), app.camera);
  app.end = Math.max(...app.runs.map(run => run.states.at(-1).sample.time_s));
  app.window = [0, app.end];
  $("about").textContent = data.still.about;
  $("names").append(make("span", { class: "on" }, "guard on"), " · ", make("span", { class: "off" }, "ghost: guard off"));
  $("outcome").append(...app.runs.map((run, at) => make("tr", { class: at ? "off" : "on" }, make("th", {}, at ? "guard off" : "guard on"), make("td", {}, run.outcome), make("td", {}, `hash ${run.hash.slice(0, 16)}…`))));
  app.events = app.runs.flatMap((run, at) => run.states.flatMap(({ sample }, index) => {
    const verdict = sample.received.verdict, before = index ? run.states[index - 1].sample.received.verdict : "";
    const commands = at === 0 && index && ["asked_speed"].filter(key => sample.received[key] !== run.states[index - 1].sample.received[key]).map(key => ({ time: sample.time_s, at, level: "info", text: `command: ${sample.received[key].toFixed(2)} m/s` })) || [];
    const verdicts = at === 0 && verdict !== before && verdict ? [{ time: sample.time_s, at, level: verdict === "passed" ? "info" : "warning", text: `guard: ${verdict}` }] : [];
    return [...commands, ...verdicts, ...sample.received.events.map(event => ({ time: sample.time_s, at, level: event.level, text: event.text }))];
  })).sort((a, b) => a.time - b.time);
  $("log").append(...app.events.map(event => make("li", { class: event.level, onclick: () => seek(event.time) }, make("time", {}, `${event.time.toFixed(2)} s`), make("span", { class: event.at ? "off" : "on" }, event.at ? "off" : "on"), make("span", {}, event.text))));
  buildPlots();
  $("play").onclick = () => { app.playing = !app.playing; if (app.playing && app.time >= app.end) app.time = 0; $("play").textContent = app.playing ? "Pause" : "Play"; };
  addEventListener("keydown", event => {
    if (event.target.tagName === "SELECT") return;
    if (event.code === "Space") { event.preventDefault(); $("play").click(); }
    if (event.code === "ArrowLeft") seek(app.time - .04);
    if (event.code === "ArrowRight") seek(app.time + .04);
  });
  requestAnimationFrame(frame);
}

function seek(time) { app.time = Math.min(app.end, Math.max(0, time)); drawPlots(); }

let before = 0;
function frame(now) {
  const began = performance.now(), dt = Math.min(.1, (now - before) / 1000 || .016);
  before = now;
  if (app.playing) {
    app.time += dt * Number($("speed").value);
    if (app.time >= app.end) { app.time = app.end; $("play").click(); }
    drawPlots();
  }
  const [on, off] = app.runs.map(run => run.states[indexAt(run, app.time)]);
  if (app.shown !== on) { app.scene.update(on); app.shown = on; }
  const { truth } = on.sample;
  app.scene.draw(app.camera.look(aimAt(truth), truth.yaw, dt, Math.min(2, devicePixelRatio || 1)), app.theme, { support: true, balance: true, forces: true, trails: true }, $("apart").checked ? shifted(off, 1.1) : off);
  $("time").textContent = `${app.time.toFixed(2)} s of ${app.end.toFixed(0)} s`;
  app.frames.push(performance.now() - began);
  requestAnimationFrame(frame);
}

// ---- plots: one time for all of them
const plots = [];
function buildPlots() {
  CURVES.forEach(([name, unit, value]) => {
    const series = app.runs.map(run => run.states.map(state => value(state)));
    if (!series.flat().some(number => Number.isFinite(number) && Math.abs(number) > 1e-6)) return;
    const canvas = make("canvas"), shown = [true, true];
    const numbers = ["on", "off"].map((kind, at) => {
      const number = make("span");
      const box = make("input", { type: "checkbox", checked: "", onchange: event => { shown[at] = event.target.checked; drawPlots(); } });
      return { label: make("label", { class: kind }, box, ` ${kind} `, number), number };
    });
    $("plots").append(make("figure", {}, make("figcaption", {}, make("b", {}, `${name}, ${unit}`), ...numbers.map(({ label }) => label)), canvas));
    plots.push({ canvas, series, shown, numbers });
    steer(canvas);
  });
  steer($("events"));
  addEventListener("resize", drawPlots);
  drawPlots();
}

// The pointer sets the time, the wheel zooms around it, and dragging with the shift key moves.
function steer(canvas) {
  const at = event => { const { left, width } = canvas.getBoundingClientRect(), [from, to] = app.window; return from + (event.clientX - left) / width * (to - from); };
  let held = null;
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); held = event.shiftKey ? [at(event), ...app.window] : []; if (!event.shiftKey) seek(at(event)); });
  canvas.addEventListener("pointermove", event => {
    if (canvas === $("events") && !held) nameEvent(at(event));
    if (!held) return;
    if (held.length) { const by = held[0] - at(event); zoomTo(app.window[0] + by, app.window[1] + by); } else seek(at(event));
  });
  for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, () => { held = null; });
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const by = Math.exp(event.deltaY * .0015), here = at(event), [from, to] = app.window;
    zoomTo(here - (here - from) * by, here + (to - here) * by);
  }, { passive: false });
  canvas.addEventListener("dblclick", () => zoomTo(0, app.end));
}
function zoomTo(from, to) {
  const length = Math.min(app.end, Math.max(.2, to - from)), start = Math.min(app.end - length, Math.max(0, from));
  app.window = [start, start + length];
  drawPlots();
}
function nameEvent(time) {
  const near = app.events.filter(event => Math.abs(event.time - time) < (app.window[1] - app.window[0]) * .01);
  $("event").textContent = near.map(event => `${event.time.toFixed(2)} s, ${event.at ? "guard off" : "guard on"}: ${event.text}`).join(" · ");
}
function pen(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  return { context, width, height };
}
function drawPlots() {
  const [from, to] = app.window, colors = [style("--on"), style("--off")], soft = style("--soft"), line = style("--line");
  const cursor = (context, width, height) => {
    const x = (app.time - from) / (to - from) * width;
    context.strokeStyle = soft;
    context.beginPath(); context.moveTo(x, 0); context.lineTo(x, height); context.stroke();
  };
  for (const { canvas, series, shown, numbers } of plots) {
    const { context, width, height } = pen(canvas);
    const spans = app.runs.map(run => [indexAt(run, from), indexAt(run, to)]);
    let low = Infinity, high = -Infinity;
    series.forEach((values, at) => { if (shown[at]) for (let i = spans[at][0]; i <= spans[at][1]; i++) if (Number.isFinite(values[i])) { low = Math.min(low, values[i]); high = Math.max(high, values[i]); } });
    if (!(high > low)) { low -= .5; high += .5; }
    const y = value => height - 4 - (value - low) / (high - low) * (height - 18);
    context.fillStyle = soft;
    for (const value of [low, high]) { context.strokeStyle = line; context.beginPath(); context.moveTo(0, y(value)); context.lineTo(width, y(value)); context.stroke(); context.fillText(value.toPrecision(3), 2, y(value) - 2); }
    series.forEach((values, at) => {
      numbers[at].number.textContent = Number.isFinite(values[indexAt(app.runs[at], app.time)]) ? values[indexAt(app.runs[at], app.time)].toFixed(2) : "–";
      if (!shown[at]) return;
      context.strokeStyle = colors[at]; context.lineWidth = 1.5; context.beginPath();
      let on = false;
      for (let i = spans[at][0]; i <= spans[at][1]; i++) {
        if (!Number.isFinite(values[i])) { on = false; continue; }
        const x = (app.runs[at].states[i].sample.time_s - from) / (to - from) * width;
        if (on) context.lineTo(x, y(values[i])); else context.moveTo(x, y(values[i]));
        on = true;
      }
      context.stroke(); context.lineWidth = 1;
    });
    cursor(context, width, height);
  }
  const { context, width, height } = pen($("events"));
  let free = [-1e9, -1e9];
  for (const event of app.events) {
    const x = (event.time - from) / (to - from) * width, row = event.at * height / 2;
    if (x < 0 || x > width) continue;
    context.fillStyle = event.level === "error" ? style("--bad") : colors[event.at];
    context.fillRect(x - 1, row + 2, 2, height / 2 - 6);
    if (x > free[event.at]) { context.fillText(event.text, x + 4, row + 14); free[event.at] = x + 10 + context.measureText(event.text).width; }
  }
  cursor(context, width, height);
}

unpack($("data").textContent).json().then(begin).catch(error => { app.errors.push(String(error)); $("about").textContent = `The page cannot start: ${error.message}`; });
