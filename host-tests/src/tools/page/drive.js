// The page: drives the run in the worker, draws it, and lets the visitor change it.

const $ = name => document.getElementById(name);
const make = (tag, attributes = {}, ...inside) => {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value); else if (value !== false) element.setAttribute(key, value);
  }
  element.append(...inside);
  return element;
};

// The worker. A request is sent at once, its answers come in order.
const link = {
  worker: new Worker(URL.createObjectURL(new Blob([$("worker").textContent], { type: "text/javascript" }))),
  waiting: new Map(), next: 1,
  post(message, transfer = []) {
    return new Promise((done, failed) => {
      const id = this.next++;
      this.waiting.set(id, { done, failed });
      this.worker.postMessage({ id, ...message }, transfer);
    });
  },
  // The answers to some requests, which are carried out without a break.
  async ask(...requests) {
    const { answers, spent } = await this.post({ requests });
    const parsed = answers.map(text => JSON.parse(text));
    parsed.spent = spent;
    const refused = parsed.find(answer => answer && answer.error);
    if (refused) throw new Error(refused.error);
    return parsed;
  },
};
link.worker.onmessage = ({ data }) => {
  if (data.id === undefined) { link.other(data); return; }
  const { done, failed } = link.waiting.get(data.id);
  link.waiting.delete(data.id);
  if (data.error) failed(new Error(data.error)); else done(data);
};

// What the guard's verdict means, in a sentence. The first part is the effect, the second the reason.
const EDGE_WORDS = { "backward margin": 0, "forward margin": 1, "left margin": 2, "right margin": 3 };
const SIDES = ["rear", "front", "left", "right"];
function explain(verdict, { asked_speed: asked = 0, passed_speed: passed = 0 } = {}) {
  let [effect, reason = ""] = verdict.split(": ");
  // A speed that is scaled to nothing.
  if (effect === "scaled" && Math.abs(asked) > .03 && Math.abs(passed) < .005) effect = "refused";
  const posture = reason.startsWith("posture, "), tripped = reason.startsWith("tripped, ");
  const edge = EDGE_WORDS[reason.replace(/^(posture|tripped), /, "")];
  const side = edge === undefined ? "" : SIDES[edge];
  const near = `its centre of gravity is close to the ${side} edge of its support`;
  const texts = {
    passed: ["free", "The command passes", ""],
    scaled: ["scaled", posture ? "The guard slows the change of posture" : "The guard slows the robot",
      edge === undefined ? `The reason: ${reason}.` : `The robot would come too close to tipping over its ${side} edge: ${near}.`],
    refused: reason === "emergency stop" ? ["refused", "Emergency stop", "All drives stop and hold. Reset, then arm."] : ["refused", posture ? "The guard refuses the posture" : tripped ? "The guard has tripped" : "The guard refuses the command",
      edge === undefined ? `The reason: ${reason}.` : tripped
        ? `It has stopped the robot at its ${side} edge. Reset, then arm and drive away from that edge.`
        : `The robot would tip over its ${side} edge: ${near}. Only motion away from that edge passes.`],
    overridden: ["refused", "The guard drives by itself", `It moves the robot away from tipping over its ${side} edge, whatever you command.`],
    "backing off": ["scaled", "The guard backs off", `It moves the robot back from its ${side} edge, the way it came.`],
  };
  const [kind, title, text] = texts[effect] || ["scaled", verdict, ""];
  return { kind, title, text, edge: edge === undefined ? null : edge, effect };
}

const STATES = {
  "": "The nodes start.", "waiting for nodes": "The guard waits for the other nodes.",
  ready: "The motors are off. Arm the robot.", armed: "Drive.",
  held: "A fault or the emergency stop holds the robot.",
};

const places = JSON.parse($("places").textContent);
const app = {
  places, place: places[0], still: null, scene: null, camera: null, state: null, running: true, speed: 1,
  keys: new Set(), command: null, fast: 0.15, busy: false, carry: 0, worst: 0, frames: [], ended: false,
  pads: new Map(), stick: [0, 0], waits: false, explained: null, error: null, refusal: null, heldBy: null, shown: { support: true, balance: true, forces: true, trails: true },
  inputs: [], listeners: new Set(), changes: null, script: false, text: "", errors: [],
};
window.tautrack = app; // for tests and for the console

// ---- theme
const readTheme = () => { app.theme = sceneTheme(); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", readTheme);

// ---- start
async function begin() {
  readTheme();
  app.renderer = createRenderer($("view"));
  if (!app.renderer) throw new Error("This browser has no WebGL 2.");
  const bytes = await unpack($("module").textContent).arrayBuffer();
  await link.post({ bytes }, [bytes]);
  $("module").remove();
  build();
  await start(app.place.text, {}, false);
  $("loading").hidden = true;
  requestAnimationFrame(frame);
}

// Starts a run of a scenario with changes, driven by the visitor or by the scenario's own operator.
async function start(text, changes = {}, script = app.script) {
  while (app.busy) await new Promise(done => setTimeout(done, 2));
  app.busy = true;
  try {
    const [still] = await link.ask({ start: { scenario: text, changes, person: !script } });
    // What was meant for the run before.
    app.inputs.length = 0;
    app.panel?.start();
    const [state] = await link.ask({ advance: 1 });
    Object.assign(app, { text, changes, script, still, state: null, ended: false, explained: null, error: null, refusal: null, heldBy: null, armed: false, running: true, carry: 0 });
    const first = still.posture.kind === "clearance" ? still.posture.first_m : 0;
    app.command = { speed_mps: 0, yaw_rate_deg_s: 0, chassis_deg: 0, clearance_m: first, step_m: 0, released: false, autonomous: false };
    app.fast = { b2p2: .15, crawler: .15, hylos: .3, "rt-mover": .12 }[still.robot] || .15;
    for (const part of document.querySelectorAll("[data-keys]")) part.hidden = !part.dataset.keys.split(" ").includes(still.posture.kind);
    app.scene = createScene(app.renderer, still);
    if (!app.camera) { app.camera = createCamera($("view"), sizeOf(still)); addCameras($("cameras"), app.camera); }
    app.camera.begin(sizeOf(still));
    $("log").replaceChildren();
    take(state);
    await lay();
    showStill();
    // These robots sink or fall while their motors are off.
    if (["rt-mover", "hylos"].includes(still.robot) && !script) arm();
  } finally {
    app.busy = false;
  }
}

async function lay() {
  const area = app.scene.wantsGround();
  if (!area) return;
  const [ground] = await link.ask({ ground: { area, cell: .125 } });
  app.scene.setGround(ground, area);
}

// ---- the loop
let before = 0;
function frame(time) {
  const began = performance.now();
  const dt = Math.min(.1, (time - before) / 1000 || .016);
  before = time;
  gather(dt);
  if (!app.busy && app.running && !app.ended) {
    app.carry += dt * 1000 * app.speed;
    // What the computer cannot do in time is left out.
    const steps = Math.min(Math.floor(app.carry), Math.ceil(60 * Math.max(1, app.speed)));
    if (steps > 0) { app.carry = Math.min(app.carry - steps, 20); advance(steps); }
  }
  paint(dt);
  app.worst = performance.now() - began;
  app.frames.push(app.worst);
  if (app.frames.length > 600) app.frames.shift();
  requestAnimationFrame(frame);
}

async function advance(steps) {
  app.busy = true;
  try {
    const requests = [...app.inputs.splice(0), { command: app.command }, { advance: steps }];
    const answers = await link.ask(...requests);
    take(answers.at(-1));
    app.spent = (app.spent ?? answers.spent / steps) * .95 + .05 * answers.spent / steps;
    await lay();
  } catch (error) {
    fail(error);
  } finally {
    app.busy = false;
  }
}

function fail(error) {
  app.running = false;
  app.errors.push(String(error.message || error));
  note(app.state?.sample.time_s ?? 0, "error", error.message || String(error));
  showTime();
}

// Something that the visitor does besides driving; it is done before the next step.
function act(request) {
  app.inputs.push(request);
  if (!app.running) advance(1);
}

// Something of the panel; a paused run does not go on for it.
const queue = request => app.inputs.push(request);

function take(state) {
  app.state = state;
  app.scene.update(state);
  const { received, time_s: time, truth } = state.sample;
  for (const { level, text, injected } of received.events) {
    note(time, injected ? "error" : level, text);
    if (level === "error" && !injected) app.error = { time, text };
  }
  for (const line of state.log) {
    const [, words, code] = line.match(/guard: .*: not armed: (reason (\d+)|.*)/) ?? [];
    if (words) app.refusal = { code: Number(code ?? RATE_AT_REST), since: performance.now() };
  }
  // The latest error of the second before the robot was held, or the first one after that.
  if (received.guard_state !== "held") app.heldBy = null;
  else if (!app.heldBy && app.error && time - app.error.time < 1) app.heldBy = app.error.text;
  const found = explain(received.verdict || "passed", received);
  const held = found.effect !== "passed" && received.guard_state === "armed";
  if (held && app.explained !== received.verdict) {
    app.explained = received.verdict;
    note(time, "warning", `guard: ${received.verdict}`);
  } else if (!held) app.explained = null;
  if (truth.toppled && !app.toppled) note(time, "error", "The robot has toppled.");
  app.toppled = truth.toppled;
  if (state.ended && !app.ended) { app.ended = true; note(time, "info", "The run ends here."); }
  for (const listener of app.listeners) listener(state);
  showNow(found);
}

// ---- what the visitor commands
const held = (...names) => names.some(name => app.keys.has(name));
function gather(dt) {
  if (!app.still || !app.command) return;
  const { command } = app;
  const keys = [held("KeyW", "ArrowUp") - held("KeyS", "ArrowDown"), held("KeyA", "ArrowLeft") - held("KeyD", "ArrowRight")];
  let [forward, turn] = keys, lift = held("KeyE", "PageUp") - held("KeyQ", "PageDown");
  for (const pad of navigator.getGamepads?.() ?? []) {
    if (!pad) continue;
    const before = app.pads.get(pad.index) ?? [];
    const dead = value => Math.abs(value) < .15 ? 0 : value;
    forward = forward || -dead(pad.axes[1] ?? 0); turn = turn || -dead(pad.axes[0] ?? 0); lift = lift || -dead(pad.axes[3] ?? 0);
    const pressed = pad.buttons.map(button => button.pressed);
    const actions = { 0: arm, 1: stop, 2: reset, 8: emergency, 9: pause };
    for (const [index, does] of Object.entries(actions)) if (pressed[index] && !before[index]) does();
    app.pads.set(pad.index, pressed);
  }
  forward = forward || app.stick[0]; turn = turn || app.stick[1];
  // A stop holds until everything that drives has been released.
  app.waits &&= Boolean(forward || turn || lift);
  if (app.waits) forward = turn = lift = 0;
  const moves = forward !== 0 || turn !== 0;
  // After a stop, driving goes on with the next command to drive.
  if (moves && app.state?.requested === "stop" && app.state.sample.received.guard_state === "armed" && !app.armed) arm();
  command.speed_mps = forward * app.fast;
  command.yaw_rate_deg_s = turn * 25;
  if (lift) raise(lift * dt);
}

function raise(amount) {
  const { posture } = app.still, { command } = app;
  const bound = (value, [least, most]) => Math.min(most, Math.max(least, value));
  if (posture.kind === "chassis") command.chassis_deg = bound(command.chassis_deg + 28 * amount, posture.travel_deg);
  if (posture.kind === "clearance") command.clearance_m = bound(command.clearance_m + .08 * amount, [.1, .4]);
  showPosture();
}

// After a stop, driving goes on by itself.
const arms = () => ["arm", "arm_off_level"].includes(app.state.requested);
const goesOn = () => arms() || app.state.requested === "stop";
// Why the guard has not armed the robot, in the words of object 0x4006:6.
const REFUSALS = JSON.parse($("tables").textContent).roles.flatMap(role => role.objects).find(({ index, sub }) => index === 0x4006 && sub === 6)
  .meaning.matchAll(/(\d+) (.*?)(?=, \d+ |\.$)/g).reduce((words, [, code, text]) => words.set(Number(code), text.replaceAll("*", "")), new Map());
const OFF_LEVEL = 11, RATE_AT_REST = 13;
const refusesToArm = () => app.refusal && app.state?.sample.received.guard_state === "ready" && app.state.requested === "arm";
const refusal = () => `The guard starts no drive: ${app.refusal.code === OFF_LEVEL ? "the robot is not level. Arm again to confirm" : REFUSALS.get(app.refusal.code)}.`;
// The guard does not home the drives of a robot that is not level, unless the operator confirms it by
// a second request. Whoever presses twice at once has not read why.
const confirms = () => refusesToArm() && app.refusal.code === OFF_LEVEL && performance.now() - app.refusal.since > 300;
function arm() { app.armed = true; act({ ask: confirms() ? "arm_off_level" : "arm" }); }
function halt(request) { app.armed = false; app.waits = true; Object.assign(app.command, { speed_mps: 0, yaw_rate_deg_s: 0 }); act({ ask: request }); }
const stop = () => halt("stop"), emergency = () => halt("emergency_stop"), reset = () => halt("reset");
function pause() { app.running = !app.running; showTime(); }
function single() { app.running = false; if (!app.busy && !app.ended) advance(1); showTime(); }
const restart = () => app.still && start(app.text, app.changes, app.script).catch(fail);
function toggle(key) { if (app.still.posture.kind === "chassis") { app.command[key] = !app.command[key]; showPosture(); } }
const slack = () => toggle("released");
const autonomous = () => toggle("autonomous");

const KEYS = { Enter: arm, Space: stop, Escape: emergency, KeyR: reset, KeyP: pause, Period: single, Digit0: restart, KeyB: slack, KeyC: autonomous };
addEventListener("keydown", event => {
  const writing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range" && event.target.type !== "checkbox";
  if (event.ctrlKey || event.metaKey || event.altKey || (writing && event.code !== "Escape")) return;
  if (event.code === "Enter" && /^(BUTTON|SUMMARY|A)$/.test(event.target.tagName) && event.target.id !== "arm") return;
  const does = KEYS[event.code];
  if (does && !event.repeat) does();
  if (!does && !event.repeat) app.keys.add(event.code);
  if (does || /^(Arrow|Page|Key[WASDEQ])/.test(event.code)) event.preventDefault();
});
addEventListener("keyup", event => app.keys.delete(event.code));
addEventListener("blur", () => app.keys.clear());
// A click leaves no focus on a button: Enter arms.
addEventListener("click", ({ detail }) => { if (detail && document.activeElement?.matches("button, summary, a, [type=checkbox]")) document.activeElement.blur(); });

function buildStick() {
  const stick = $("stick"), knob = stick.firstElementChild;
  const move = event => {
    const { left, top, width } = stick.getBoundingClientRect(), half = width / 2;
    let x = (event.clientX - left - half) / half, y = (event.clientY - top - half) / half;
    const length = Math.max(1, Math.hypot(x, y));
    x /= length; y /= length;
    app.stick = [Math.abs(y) < .12 ? 0 : -y, Math.abs(x) < .12 ? 0 : -x];
    knob.style.transform = `translate(${x * 100}%, ${y * 100}%)`;
  };
  stick.addEventListener("pointerdown", event => { stick.setPointerCapture(event.pointerId); move(event); });
  stick.addEventListener("pointermove", event => { if (stick.hasPointerCapture(event.pointerId)) move(event); });
  for (const type of ["pointerup", "pointercancel"]) stick.addEventListener(type, () => { app.stick = [0, 0]; knob.style.transform = ""; });
}

// ---- what the page shows
const text = (element, value) => { if (element.textContent !== value) element.textContent = value; };
const number = (value, digits) => value.toFixed(digits).replace(/^-(0(\.0+)?)$/, "$1").replace("-", "−");
const signed = (value, digits, unit) => `${number(value, digits)} ${unit}`;

function paint(dt) {
  if (!app.scene || !app.state) return;
  const { truth } = app.state.sample;
  // A slow computer draws fewer points, then no shadow.
  app.slow = (app.slow ?? 16) * .95 + Math.min(200, dt * 1000) * .05;
  const ratio = Math.min(devicePixelRatio || 1, app.slow > 45 ? 1 : 2);
  app.renderer.setShadows(app.slow < 60);
  app.scene.draw(app.camera.look(aimAt(truth), truth.yaw, dt, ratio), app.theme, app.shown, null);
}

function showNow(found) {
  const { received, time_s: time, truth } = app.state.sample, { still } = app;
  text($("clock"), `${time.toFixed(1)} s`);
  const name = received.guard_state || "";
  text($("state").firstElementChild, name || "starting");
  text($("state").lastElementChild, refusesToArm() ? refusal()
    : name === "held" ? `${app.heldBy ? `Held by ${app.heldBy}.` : STATES.held} Reset, then arm.` : name === "armed" && !goesOn() ? "Arm to drive on." : STATES[name] ?? "The guard homes the drives and switches them on.");
  const armed = name === "armed";
  text($("verdict"), !still.guard ? "The filter is off" : armed ? found.title : "");
  $("verdict").className = !still.guard ? "refused" : found.kind;
  text($("reason"), !still.guard ? "Every command passes: the robot can topple." : armed ? found.text : "");
  app.scene.flash(armed && found.effect !== "passed" ? found.edge : null);
  const margins = received.margins, rows = $("margins").querySelectorAll("b");
  EDGES.forEach((edge, index) => {
    const margin = margins ? margins[index] : NaN, row = rows[index];
    const band = bandOf(margin, still.levels);
    row.style.width = `${Number.isFinite(margin) ? Math.min(100, Math.max(0, margin / .3 * 100)) : 0}%`;
    row.style.background = `var(--band${band})`;
    // The guard publishes 10 m where there is no edge.
    text(row.parentElement.nextElementSibling, margin < 9 ? `${number(margin * 1000, 0)} mm` : "–");
  });
  text($("moment"), truth.toppled ? "The robot has toppled. Restart it." : truth.came_off ? `Off the robot: ${truth.came_off}` : app.ended ? "The run ends here. Restart it." : "");
  $("arm").disabled = app.script; $("stop").disabled = app.script; $("reset").disabled = app.script; $("emergency").disabled = app.script;
  $("arm").setAttribute("aria-pressed", String(armed && arms()));
  const rate = app.spent ? 1 / app.spent : 0;
  text($("pace"), rate && rate < app.speed * .95 ? `${rate.toFixed(1)} ×` : "");
  if ((app.shownAt ?? -1) > time || time - (app.shownAt ?? -1) > .1) { app.shownAt = time; showFigures(); showNodes(); }
}

function showFigures() {
  const { received, truth } = app.state.sample, degrees = value => value * 180 / Math.PI;
  const rows = [
    ["Speed: commanded, passed", `${number(received.asked_speed, 2)}, ${number(received.passed_speed, 2)} m/s`],
    ["Speed over ground", signed(truth.ground_speed, 2, "m/s")],
    ["Driven", signed(received.odometry, 2, "m")],
    ["Pitch, roll", `${number(degrees(received.pitch), 1)}, ${number(degrees(received.roll), 1)}°`],
  ];
  const { posture } = received;
  if ("passed_chassis_rad" in posture) rows.push(["Chassis angle: passed, real", `${number(degrees(posture.passed_chassis_rad), 0)}, ${number(degrees(truth.theta), 0)}°`]);
  if ("passed_clearance_m" in posture) rows.push(["Clearance passed", signed(posture.passed_clearance_m * 100, 0, "cm")]);
  if (app.still.robot === "b2p2") rows.push(["Belt tension", signed(received.belt_tension, 0, "N")]);
  if (app.command.autonomous) rows.push(["By itself", received.clearance || "not yet"]);
  rows.push(["Load of the bus", signed(received.bus_load * 100, 0, "%")]);
  const table = $("figures");
  while (table.rows.length < rows.length) table.append(make("tr", {}, make("td"), make("td")));
  while (table.rows.length > rows.length) table.deleteRow(-1);
  rows.forEach(([name, value], index) => { text(table.rows[index].cells[0], name); text(table.rows[index].cells[1], value); });
}

function note(time, kind, what) {
  const list = $("log");
  list.prepend(make("li", { class: kind }, make("time", {}, `${time.toFixed(1)} s`), make("span", {}, what)));
  while (list.children.length > 60) list.lastElementChild.remove();
}

function showTime() {
  text($("pause"), app.running ? "Pause" : "Go on");
  $("pause").setAttribute("aria-pressed", String(!app.running));
}

// The controls of the robot's posture.
const POSTURES = {
  none: () => [],
  chassis: ({ travel_deg: [least, most] }) => [
    slider("Chassis angle", "chassis_deg", Math.ceil(least), Math.floor(most), 1, value => `${value.toFixed(0)}°`),
    make("label", { class: "row" }, make("input", { type: "checkbox", id: "released", onchange: slack }), " Release the belts (slack)"),
    make("label", { class: "row" }, make("input", { type: "checkbox", id: "autonomous", onchange: autonomous }), " Clear stairs and curbs by itself"),
  ],
  clearance: () => [slider("Clearance", "clearance_m", .1, .4, .005, value => `${(value * 100).toFixed(1)} cm`)],
  step: () => [make("div", { class: "row" }, make("span", {}, "Step ahead, cm"), make("span", {}, ...[0, .05, .1, .15, .2].map(height =>
    make("button", { type: "button", "data-step": height, onclick: () => { app.command.step_m = height; showPosture(); } }, height ? String(height * 100) : "none"))))],
};
function slider(name, key, min, max, step, words) {
  const input = make("input", { type: "range", min, max, step, "data-key": key, oninput: () => { app.command[key] = Number(input.value); showPosture(); } });
  const output = make("output");
  output.words = words;
  return make("label", { class: "row" }, `${name} `, input, output);
}
function showPosture() {
  for (const input of $("posture").querySelectorAll("input[data-key]")) {
    const value = app.command[input.dataset.key];
    if (Number(input.value) !== value) input.value = value;
    text(input.nextElementSibling, input.nextElementSibling.words(value));
  }
  for (const button of $("posture").querySelectorAll("button")) button.setAttribute("aria-pressed", String(Number(button.dataset.step) === app.command.step_m));
  for (const key of ["released", "autonomous"]) if ($(key)) $(key).checked = app.command[key];
}

const FAULTS = [
  ["Kill", name => ({ node_dead: name }), () => true],
  ["Restart", name => ({ restart: name }), () => true],
  ["Cut bus", name => ({ bus_cut: name }), () => true],
  ["Freeze encoder", name => ({ encoder_frozen: name }), node => node.motor],
];
function showNodes() {
  const table = $("nodes");
  app.still.nodes.forEach((node, index) => {
    const row = table.rows[index];
    row?.cells[0].classList.toggle("dead", !app.state.powered[index]);
    for (const button of row?.querySelectorAll("button[data-mends]") ?? []) {
      const on = app.state.faults.some(fault => JSON.stringify(fault) === button.dataset.fault);
      button.setAttribute("aria-pressed", String(on));
    }
  });
}
function buildNodes() {
  const rows = app.still.nodes.map(node => {
    const buttons = FAULTS.filter(([, , fits]) => fits(node)).map(([label, what]) => {
      const fault = what(node.name), mends = label === "Cut bus" || label === "Freeze encoder";
      const button = make("button", { type: "button", "data-fault": JSON.stringify(fault), ...(mends ? { "data-mends": "" } : {}) }, label);
      button.addEventListener("click", () => act(mends && button.getAttribute("aria-pressed") === "true" ? { mend: fault } : { break: fault }));
      return button;
    });
    return make("tr", { "data-node": node.name }, make("td", {}, `${node.name.replaceAll("_", " ")} (${node.id})`), make("td", {}, ...buttons.flatMap(button => [button, " "])));
  });
  $("nodes").replaceChildren(...rows);
}

function showStill() {
  const { still } = app, form = $("changes").elements, { description } = still;
  document.title = `tautrack: ${still.name}`;
  text($("about"), still.about);
  $("posture").replaceChildren(...POSTURES[still.posture.kind](still.posture));
  showPosture(); buildNodes(); showTime();
  form.guard.checked = still.guard;
  form.script.checked = app.script;
  form.seed.value = description.seed; form.friction.value = description.friction;
  const section = Object.values(description.robot)[0];
  $("payload").hidden = still.robot === "hylos";
  const payload = section.payload;
  form.mass.value = payload?.mass_kg ?? 0;
  if (payload) { [form.x.value, form.y.value, form.z.value] = payload.place_m; form.declared.checked = payload.declared; }
  $("saved").hidden = true;
  $("fast").value = app.fast; $("fast").oninput();
}

async function save() {
  try {
    const [{ scenario, hash }] = await link.ask("save");
    text($("hash"), hash);
    text($("command"), "cargo demo --nodes host --scenario run.toml");
    text($("scenario"), scenario);
    $("download").href = URL.createObjectURL(new Blob([scenario], { type: "application/toml" }));
    $("saved").hidden = false;
    app.saved = { scenario, hash };
  } catch (error) { fail(error); }
}

function changesOf(form) {
  const robot = Object.keys(app.still.description.robot)[0], number = name => Number(form[name].value);
  const load = number("mass") > 0 && robot !== "hylos"
    ? { mass_kg: number("mass"), place_m: [number("x"), number("y"), number("z")], declared: form.declared.checked, from_s: 0 } : null;
  return { guard: form.guard.checked, friction: number("friction"), seed: number("seed"), robot: { [robot]: { payload: load } },
    ...(form.guard.checked ? {} : { expect: { guard_intervenes: null } }) };
}

function build() {
  const groups = {};
  places.forEach((place, index) => {
    // A name within sentences becomes one of a list.
    place.robot = place.robot[0].toUpperCase() + place.robot.slice(1);
    groups[place.robot] ??= make("optgroup", { label: place.robot });
    groups[place.robot].append(make("option", { value: index }, `${place.robot}: ${place.ground}`));
  });
  $("place").append(...Object.values(groups));
  const attempt = (...run) => start(...run).then(() => { text($("refused"), ""); return true; })
    .catch(error => { text($("refused"), error.message); $("tabs").querySelector("[data-tab=setup]").click(); $("refused").scrollIntoView(); return false; });
  $("place").onchange = event => { app.place = places[event.target.value]; attempt(app.place.text, {}, false).then(() => $("place").blur()); };
  // A file becomes an option of the list.
  const open = async file => {
    if (!file) return;
    const text = await file.text();
    if (!await attempt(text, {}, false)) return;
    app.place = { text };
    const at = places.push(app.place) - 1;
    $("place").append(make("option", { value: at }, file.name));
    $("place").value = at;
  };
  $("margins").append(...EDGES.map(edge => make("div", {}, make("span", {}, edge), make("i", {}, make("b")), make("span"))));
  for (const [id, does] of Object.entries({ arm, stop, emergency, reset, pause, single, restart, save })) $(id).onclick = () => does();
  $("speed").append(...[.1, .25, .5, 1, 2, 4].map(value => make("option", { value, ...(value === 1 ? { selected: "" } : {}) }, `${value} ×`)));
  $("speed").onchange = event => { app.speed = Number(event.target.value); event.target.blur(); };
  $("fast").oninput = () => { app.fast = Number($("fast").value); text($("fast").nextElementSibling, `${app.fast.toFixed(2)} m/s`); };
  const tabs = { drive: "Drive", break: "Break", setup: "Set up", panel: "Nodes", save: "Save" };
  $("tabs").append(...Object.entries(tabs).map(([id, name]) => make("button", { role: "tab", "data-tab": id, "aria-selected": String(id === "drive"), onclick: () => {
    for (const button of $("tabs").children) button.setAttribute("aria-selected", String(button.dataset.tab === id));
    for (const key of Object.keys(tabs)) $(`tab-${key}`).hidden = key !== id;
  } }, name)));
  const names = { support: "Support and margins", balance: "Centre of gravity and zero moment point", forces: "Forces of the ground", trails: "Trails" };
  $("shown").append(...Object.entries(names).map(([key, name]) => make("label", { class: "row" },
    make("input", { type: "checkbox", checked: "", onchange: event => { app.shown[key] = event.target.checked; } }), ` ${name}`)));
  $("changes").addEventListener("submit", event => { event.preventDefault(); const form = $("changes").elements; attempt(app.text, changesOf(form), form.script.checked); });
  $("file").onchange = event => { open(event.target.files[0]); event.target.value = ""; };
  addEventListener("dragover", event => { event.preventDefault(); document.body.classList.add("drop"); });
  addEventListener("dragleave", event => { if (!event.relatedTarget) document.body.classList.remove("drop"); });
  addEventListener("drop", event => { event.preventDefault(); document.body.classList.remove("drop"); open(event.dataTransfer.files[0]); });
  buildStick();
  app.panel = createPanel($("tab-panel"), app, link, queue, make);
}

// Speed of the simulator alone: seconds of the run in a second of the computer.
app.measure = async seconds => {
  while (app.busy) await new Promise(done => setTimeout(done, 2));
  app.busy = true;
  const answers = await link.ask({ command: app.command }, { advance: Math.round(seconds * 1000) });
  take(answers.at(-1));
  app.busy = false;
  return seconds * 1000 / answers.spent;
};
Object.assign(app, { start, act, ask: (...requests) => link.ask(...requests), explain });

begin().catch(error => {
  $("loading").replaceChildren(make("p", {}, `The page cannot start: ${error.message}`));
  app.errors.push(String(error.message));
});
