// Unpacks the data, fills the page, and plays the run.
const run = JSON.parse(document.getElementById("data").textContent);
// A series has the first value of each interval of samples. Where an interval has several samples,
// `least` and `most` have the minimum and the maximum of all their values.
run.series = {};
run.least = {};
run.most = {};
for (const name in run.columns) {
  const { one, values, below, above } = run.columns[name];
  const scaled = offset => values.map((value, i) => value === null ? null : (value + offset(i)) * one);
  run.series[name] = scaled(() => 0);
  run.least[name] = below ? scaled(i => -below[i]) : run.series[name];
  run.most[name] = above ? scaled(i => above[i]) : run.series[name];
}
const byId = id => document.getElementById(id);
// ZMP minus CoG in percent of the robot's length.
for (const name of ["zmpOff", "zmpOffSmoothed"]) for (const series of [run.series, run.least, run.most]) {
  if (series[name]) series[name] = series[name].map(value => value === null ? null : value / run.length * 100);
}
// Removes the sign of a zero, and writes other negative numbers with a minus sign.
const minus = text => text.replace(/-(0(?:\.0+)?)(?![\d.])/, "$1").replace("-", "−");
const summary = run.summary, count = run.series.t.length;

// Periods in which the guard changed the command.
run.bands = run.verdict.flatMap(([from, text], i) => {
  if (["", "passed"].includes(text.split(":")[0].trim())) return [];
  const to = i + 1 < run.verdict.length ? run.verdict[i + 1][0] : count - 1;
  return [[run.series.t[from], run.series.t[to]]];
});

// The parts of the page that do not change with time.
{
  const outcome = summary.toppled ? "Toppled" : summary.landed ? "Landed" : "Upright";
  byId("verdict").textContent = `${outcome} · ${summary.expectation_met ? "as expected" : "not as expected"}`;
  byId("verdict").className = summary.expectation_met ? "good" : "bad";
  byId("about").textContent = run.about + (run.guardOn ? "" : " The guard's filter is switched off.");
  for (const sentence of summary.unmet) byId("unmet").appendChild(document.createElement("li")).textContent = sentence;

  const figure = (name, value, unit, below) => {
    const box = byId("figures").appendChild(document.createElement("div"));
    box.appendChild(document.createElement("dt")).textContent = name;
    const main = box.appendChild(document.createElement("dd"));
    main.textContent = value;
    if (unit) main.appendChild(document.createElement("small")).textContent = " " + unit;
    if (below) { const sub = box.appendChild(document.createElement("dd")); sub.className = "sub"; sub.textContent = below; }
  };
  for (const sentence of summary.notes || []) byId("notes").appendChild(document.createElement("p")).textContent = sentence;
  const { guard, bus, tension_error_m: belt, pitch_deg: pitch } = summary;
  robotPage.figures(figure);
  if (belt) figure("Belt error, 99th percentile", (belt.p99 * 1e3).toFixed(2), "mm", `maximum ${(belt.max * 1e3).toFixed(2)} mm`);
  figure("Maximum pitch", minus(pitch.max.toFixed(1)), "°", `minimum ${minus(pitch.min.toFixed(1))}°`);
  const margin = summary.min_backward_margin_m;
  if (margin !== null) figure("Minimum rear margin", minus((margin * 1e3).toFixed(0)), "mm", "centre of gravity to the rearmost contact");
  figure("Guard", guard.interventions, guard.interventions === 1 ? "intervention" : "interventions", `${guard.scaled} scaled, ${guard.refused} refused`);
  const zmp = summary.zero_moment_point;
  if (zmp) figure("|ZMP − CoG|", zmp.smoothed.mean.toFixed(2), "%", `of the length, mean; in the paper: ${run.paperZmpPercent} %`);
  figure("Bus load", (bus.load_mean * 100).toFixed(0), "%", `peak ${(bus.load_max * 100).toFixed(0)} %, worst wait ${bus.worst_latency_ms.toFixed(2)} ms`);
  figure("Simulation speed", summary.realtime_factor.toFixed(1), "× real time", `${summary.steps.toLocaleString("en")} steps in ${summary.wall_s.toFixed(1)} s`);

  byId("origin").textContent = run.origin;
  byId("plots-note").textContent = run.note;
  byId("assumptions").textContent = robotPage.assumptions();
  byId("hash").textContent = `State hash ${summary.state_hash}, seed ${summary.seed}` + (run.resolution ? `. ${run.resolution}` : "");

  if (zmp) {
    const line = (name, { mean, peak }) => `${name}: mean ${mean.toFixed(2)} %, peak ${peak.toFixed(1)} %`;
    byId("balance").hidden = false;
    byId("balance-figures").textContent = `|ZMP − CoG| over A1 to A3, in percent of the straight robot's ${run.length.toFixed(3)} m. `
      + line("Raw", zmp.raw) + ". " + line("Smoothed with a Gaussian of 0.15 s", zmp.smoothed)
      + `. In the paper: mean ${run.paperZmpPercent} %. The paper does not say to which length this refers, or how it filters its accelerations.`;
  }

  const row = (cells, kind) => {
    const line = byId("nodes").appendChild(document.createElement("tr"));
    for (const cell of cells) line.appendChild(document.createElement(kind)).textContent = cell;
  };
  row(["Node", "Role", "Board", "Id", "Program (SHA-256)"], "th");
  for (const node of summary.nodes) row([node.name.replaceAll("_", " "), node.role, node.board, node.node_id, node.program_sha256.slice(0, 16) + "…"], "td");

  const last = run.series.t[count - 1] || 1;
  for (const mark of run.marks) {
    const colour = `var(--mark-${mark.kind})`;
    const item = byId("marks").appendChild(document.createElement("li"));
    item.tabIndex = 0;
    item.appendChild(document.createElement("time")).textContent = mark.t.toFixed(2) + " s";
    item.appendChild(document.createElement("i")).style.background = colour;
    item.appendChild(document.createElement("span")).textContent = mark.text;
    item.onclick = () => seek(mark.t);
    item.onkeydown = event => { if (event.key === "Enter") seek(mark.t); };
    const tick = byId("ticks").appendChild(document.createElement("button"));
    const text = `${mark.t.toFixed(2)} s: ${mark.text}`;
    tick.type = "button";
    tick.title = text;
    tick.setAttribute("aria-label", text);
    tick.style.setProperty("--mark", colour);
    tick.style.left = `${100 * mark.t / last}%`;
    const tell = () => { byId("tick-text").textContent = text; };
    tick.onpointerenter = tick.onfocus = tell;
    tick.onclick = () => { tell(); seek(mark.t); };
  }
  if (run.marksLeftOut) byId("marks").appendChild(document.createElement("li")).textContent = `and ${run.marksLeftOut} more in run.mcap`;
  if (!run.marks.length) byId("marks").appendChild(document.createElement("li")).textContent = "No events: the guard passed every command unchanged, and nothing failed.";
}

// The parts of the page that show the current time of the run.
let time = 0, playing = false, before = 0;
const end = count ? run.series.t[count - 1] : 0;
function indexAt(moment) {
  let low = 0, high = count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (run.series.t[middle] <= moment) low = middle; else high = middle - 1;
  }
  return low;
}
function textAt(changes, index) {
  let text = "";
  for (const [from, value] of changes) { if (from > index) break; text = value; }
  return text;
}
function seek(moment) { time = Math.max(0, Math.min(end, moment)); show(); }
function show() {
  const index = indexAt(time);
  const at = name => run.series[name][index] ?? 0;
  at.index = index;
  scene.show(at);
  solid.show(time);
  for (const group of plots) group.show(at);
  byId("scrub").value = time;
  // If no tick is pointed at, the text is that of the last mark.
  const past = run.marks.filter(mark => mark.t <= time + 1e-9);
  if (playing || !byId("ticks").matches(":hover, :focus-within")) byId("tick-text").textContent = past.length ? `${past[past.length - 1].t.toFixed(2)} s: ${past[past.length - 1].text}` : "";
  byId("clock").textContent = `${time.toFixed(1)} / ${end.toFixed(1)} s`;
  const verdict = textAt(run.verdict, index), state = textAt(run.guardState, index);
  byId("state").replaceChildren("Guard ", Object.assign(document.createElement("b"), { textContent: state || "not received yet" }), verdict ? `, command ${verdict}` : "");
  byId("now").textContent = minus(`pitch ${at("pitch").toFixed(1)}°`) + " · " + robotPage.now(at);
}
// Shows a span of time in all plots, as far as the run has it.
function zoom(from, to) {
  const length = Math.min(end || 1, Math.max(.2, to - from)), start = Math.min((end || 1) - length, Math.max(0, from));
  for (const group of plots) group.shows(start, length);
}
function play(on) {
  playing = on;
  byId("play").textContent = on ? "Pause" : "Play";
  byId("play").setAttribute("aria-label", on ? "Pause" : "Play");
  if (on) { if (time >= end) time = 0; before = performance.now(); requestAnimationFrame(frame); }
}
function frame(now) {
  if (!playing) return;
  seek(time + (now - before) / 1000 * Number(byId("rate").value));
  before = now;
  if (time >= end) play(false); else requestAnimationFrame(frame);
}
const scene = makeScene(byId("view"), run);
let solid = { show() {} };
const plots = [
  makePlots(byId("plots"), robotPage.plots(PLOTS), run, seek, zoom),
  ...(summary.zero_moment_point ? [makePlots(byId("balance-plots"), BALANCE_PLOTS, run, seek, zoom)] : []),
];
byId("scrub").max = end;
byId("scrub").oninput = event => seek(Number(event.target.value));
byId("play").onclick = () => play(!playing);
document.onkeydown = event => {
  if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName)) return;
  if (event.key === " ") { event.preventDefault(); play(!playing); }
  if (event.key === "ArrowRight") seek(time + 0.1);
  if (event.key === "ArrowLeft") seek(time - 0.1);
};
addEventListener("resize", () => { scene.resize(); for (const group of plots) group.draw(); show(); });
makeSolid(byId("solid"), run.scene).then(made => { solid = made; solid.show(time); });
// A page opened with #t=12.5 starts at 12.5 s.
seek(Number((location.hash.match(/^#t=([\d.]+)$/) || [])[1] || 0));
