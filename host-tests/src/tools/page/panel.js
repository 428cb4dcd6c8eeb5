// The panel of the nodes on a bus: their states and faults, their settings and objects, recordings,
// bench mode and node ids. A bus has `transfer(node, index, sub, value)` and `lss(bytes, answer)`,
// which promise bytes, `send(frame)`, `nodes()`, and `open(on)`, which tells it that the panel
// is shown. The simulated bus and an adapter are two of them.

// The simulated bus: its client is in the worker.
function createSimulatedBus(app, link, act) {
  const tickets = new Map();
  let next = 1, nodes = [];
  const promise = request => new Promise((done, failed) => {
    const ticket = next++;
    tickets.set(ticket, { done, failed });
    act(request(ticket));
  });
  return {
    take(data) {
      if (data.nodes) { nodes = data.nodes; return; }
      // The run before may have been asked.
      if (!tickets.has(data.ticket)) return;
      const { done, failed } = tickets.get(data.ticket);
      tickets.delete(data.ticket);
      if (data.error) failed(new Error(data.error)); else done(data.bytes);
    },
    nodes: () => nodes,
    send: frame => act({ send: frame }),
    transfer: (node, index, sub, value) => promise(ticket => ({ transfer: { node, index, sub, value, ticket } })),
    lss: (bytes, answer) => promise(ticket => ({ lss: { bytes, answer, ticket } })),
    open: on => act({ listen: on }),
    start() {
      nodes = [];
      for (const { failed } of tickets.values()) failed(new Error("The run has been restarted"));
      tickets.clear();
    },
  };
}

// A bus behind an SLCAN adapter on a serial port (Web Serial).
async function openAdapter(port) {
  await port.open({ baudRate: 115200 });
  const writer = port.writable.getWriter(), reader = port.readable.getReader();
  const encoder = new TextEncoder(), decoder = new TextDecoder();
  const line = createSlcan(text => writer.write(encoder.encode(text)), frame => client.frame(frame));
  const client = createCanopen(frame => line.send(frame));
  const timer = setInterval(() => client.tick(performance.now()), 20);
  const promised = call => new Promise((done, failed) => call((error, bytes) => { if (error) failed(new Error(error)); else done(bytes); }));
  line.open();
  (async () => {
    for (;;) {
      const { value, done } = await reader.read();
      if (done) return;
      line.take(decoder.decode(value, { stream: true }));
    }
  })().catch(() => {});
  return {
    nodes: () => [...client.nodes.values()],
    send: frame => line.send(frame),
    transfer: (node, index, sub, value) => promised(done => client.transfer(node, index, sub, value, done)),
    lss: (bytes, answer) => promised(done => client.lss(bytes, answer, done)),
    open() {},
    start() {},
    async close() {
      clearInterval(timer);
      line.close();
      await writer.close().catch(() => {});
      await reader.cancel().catch(() => {});
      await port.close().catch(() => {});
    },
  };
}

const bytesOf = (value, size) => Array.from({ length: size }, (_, at) => Number(BigInt.asUintN(64, BigInt(value)) >> BigInt(8 * at) & 255n));
function numberOf(bytes, type) {
  if (type === 9) return String.fromCharCode(...bytes).replace(/\0+$/, "");
  if (type === 10) return bytes.map(byte => byte.toString(16).padStart(2, "0")).join(" ");
  const bits = 8 * bytes.length, value = bytes.reduce((sum, byte, at) => sum | BigInt(byte) << BigInt(8 * at), 0n);
  return Number(type >= 2 && type <= 4 ? BigInt.asIntN(bits, value) : value);
}
const SIZES = { 2: 1, 3: 2, 4: 4, 5: 1, 6: 2, 7: 4 };
const NMT = { 0: "booted", 4: "stopped", 5: "operational", 127: "pre-operational" };

function createPanel(root, app, link, act, make) {
  const tables = JSON.parse(document.getElementById("tables").textContent);
  const simulated = createSimulatedBus(app, link, act);
  const faults = new Map(tables.faults.map(row => [row.code, row]));
  let bus = simulated, chosen = null, shown = false, values = new Map(), benching = null;

  const message = make("p", { role: "status", id: "panel-message" });
  const say = (text, bad = false) => { message.textContent = text; message.className = bad ? "dead" : ""; };
  const attempt = async work => { try { await work(); } catch (error) { say(error.message, true); } };
  const read = async (index, sub, type) => numberOf(await bus.transfer(chosen, index, sub), type);
  const write = (index, sub, value, size) => bus.transfer(chosen, index, sub, bytesOf(value, size));

  // ---- list of nodes
  const list = make("table", { id: "panel-nodes" });
  const named = id => (bus === simulated && app.still?.nodes.find(node => node.id === id)) || { name: `node ${id}` };
  function showNodes() {
    const nodes = bus.nodes().slice().sort((a, b) => a.id - b.id);
    const text = JSON.stringify([nodes.map(({ id, state, code, silent }) => [id, state, code, silent]), chosen]);
    if (list.text === text) return;
    list.text = text;
    list.replaceChildren(...nodes.map(node => make("tr", { "data-id": node.id },
      make("td", {}, make("button", { type: "button", "aria-pressed": String(node.id === chosen), onclick: () => choose(node.id) }, `${named(node.id).name.replaceAll("_", " ")} (${node.id})`)),
      make("td", {}, node.silent ? "silent" : NMT[node.state] ?? ""),
      make("td", { class: node.code ? "dead" : "" }, node.code ? faults.get(node.code)?.name ?? node.code.toString(16) : "no fault"))));
    const code = nodes.find(node => node.id === chosen)?.code, row = faults.get(code);
    fault.replaceChildren(...(row ? [make("b", {}, `${row.name} (0x${code.toString(16).toUpperCase()})`), make("p", {}, row.cause), make("p", {}, row.reaction),
      make("p", {}, make("b", {}, "What to do: "), row.remedy), make("p", {}, make("b", {}, "It clears: "), row.clears)] : []));
  }
  const fault = make("div", { id: "panel-fault" });

  // ---- settings
  const search = make("input", { type: "search", placeholder: "Search a setting", oninput: () => showSettings() });
  const settings = make("table", { id: "panel-settings" });
  function showSettings() {
    const words = search.value.toLowerCase();
    settings.replaceChildren(...tables.settings.filter(row => values.has(row.index) && row.name.includes(words)).map(row => {
      const value = values.get(row.index);
      const input = make("input", { type: "number", min: row.min, max: row.max, step: 1, value, "data-name": row.name, "aria-label": row.name });
      input.onchange = () => attempt(async () => {
        const wanted = Number(input.value);
        if (!Number.isInteger(wanted) || wanted < row.min || wanted > row.max) throw new Error(`${row.name}: a whole number from ${row.min} to ${row.max}`);
        await write(row.index, 0, wanted, 4);
        values.set(row.index, wanted);
        say(`${row.name} is ${wanted} ${row.unit}. ` + (row.live ? "A drive uses it now; save it to keep it. A guard must restart." : "Save it and restart the node: then it counts."));
      });
      return make("tr", {}, make("td", { title: `0x${row.index.toString(16)}, default ${row.default}` }, row.name, make("br"), make("small", {}, `${row.min} to ${row.max}` + (row.live ? `, ${row.effect}` : ""))), make("td", {}, input, ` ${row.unit}`));
    }));
  }
  async function readSettings() {
    const node = chosen;
    values = new Map();
    // The client reads one after the other. A frame of the page would pass between two requests.
    for (let count = 0; count < tables.settings.length; count += 10) {
      const rows = tables.settings.slice(count, count + 10);
      const found = await Promise.all(rows.map(row => read(row.index, 0, 4)));
      if (node !== chosen) return;
      rows.forEach((row, at) => values.set(row.index, found[at]));
      say(`Reading: ${values.size} of ${tables.settings.length} settings`);
    }
    say(`${values.size} settings of node ${node}`);
    showSettings();
  }
  const save = async () => { await bus.transfer(chosen, 0x1010, 1, [0x73, 0x61, 0x76, 0x65]); say("The settings are in the flash memory of the node."); };
  const restart = () => { bus.send({ id: 0, data: [0x81, chosen] }); say(`Node ${chosen} restarts. A guard reports a second master: reset it.`); };
  const toFile = () => {
    const lines = tables.settings.filter(row => values.has(row.index)).map(row => `${row.name} = ${values.get(row.index)} # ${row.unit}`);
    const link = make("a", { download: `node-${chosen}.toml`, href: URL.createObjectURL(new Blob([`# Settings of node ${chosen}\n${lines.join("\n")}\n`])) });
    link.click();
  };
  const fromFile = file => attempt(async () => {
    const given = [...(await file.text()).matchAll(/^([a-z0-9_]+) *= *(-?[0-9]+)/gm)].map(([, name, value]) => [tables.settings.find(row => row.name === name), Number(value)]);
    const bad = given.find(([row, value]) => !row || value < row.min || value > row.max);
    if (bad) throw new Error(`The file has a bad value: ${bad[0]?.name ?? "an unknown setting"}. Nothing is written.`);
    let count = 0;
    for (const [row, value] of given) if (values.get(row.index) !== value) { await write(row.index, 0, value, 4); values.set(row.index, value); count += 1; }
    say(`${count} settings have changed. Save them.`);
    showSettings();
  });

  // ---- objects
  const objects = make("div", { id: "panel-objects" });
  async function readObjects() {
    const product = await read(0x1018, 2, 7), role = tables.roles.find(role => role.product === product);
    if (!role) throw new Error(`Product ${product} is none of tautrack.`);
    const rows = [];
    for (const entry of role.objects) {
      if (entry.index < 0x2000 || entry.type === 10) continue;
      try {
        const value = await read(entry.index, entry.sub, entry.type);
        rows.push(make("tr", { title: entry.meaning ?? "" }, make("td", {}, entry.name), make("td", {}, String(value))));
      } catch { /* an object that cannot be read now */ }
    }
    objects.replaceChildren(make("table", {}, ...rows));
    say(`${rows.length} objects of a node with the role ${role.name}`);
  }

  // ---- recording
  const SIGNALS = { "current a": 1, "current b": 2, "current d": 3, "current q": 4, demand: 5, "compare a": 6, "compare b": 7, "compare c": 8, rotor: 9, velocity: 10 };
  const pick = make("span", {}, ...["current q", "demand", "compare a", "velocity"].map((first, at) =>
    make("select", { "data-signal": at, "aria-label": `Signal ${at + 1}` }, ...Object.keys(SIGNALS).map(name => make("option", name === first ? { selected: "" } : {}, name)))));
  const plot = make("canvas", { id: "panel-plot", width: 560, height: 360, hidden: "" }), legend = make("p", { id: "panel-legend" });
  async function record() {
    const names = [...pick.children].map(select => select.value);
    await write(0x2060, 2, names.reduce((sum, name, at) => sum + SIGNALS[name] * 2 ** (8 * at), 0), 4);
    await write(0x2060, 3, 4, 2);
    await write(0x2060, 4, 256, 2);
    await write(0x2060, 1, 1, 1);
    while (await read(0x2061, 1, 5) !== 3) { /* it still records */ }
    const samples = [];
    for (let window = 0; window < 8; window++) {
      await write(0x2062, 0, window, 2);
      let bytes;
      do bytes = await bus.transfer(chosen, 0x2063, 0); while ((bytes[0] | bytes[1] << 8) !== window);
      for (let at = 2; at + 8 <= bytes.length; at += 8) samples.push([0, 2, 4, 6].map(of => (bytes[at + of] | bytes[at + of + 1] << 8) << 16 >> 16));
      say(`Recording: ${window + 1} of 8 windows`);
    }
    const ampere = await read(0x2061, 4, 7) * 1e-3 / 32768, period = await read(0x2061, 5, 6), rate = await read(0x2061, 3, 7);
    const scales = names.map(name => name.startsWith("compare") ? 1 / period : name === "rotor" ? 1 : name === "velocity" ? .01 : ampere);
    draw(samples.map(sample => sample.map((value, at) => value * scales[at])), names, 4000 / rate);
    app.recorded = samples.length;
    say(`${samples.length} samples, one every ${(4000 / rate).toFixed(2)} ms`);
  }
  function draw(samples, names, step) {
    const pen = plot.getContext("2d"), { width, height } = plot, style = getComputedStyle(document.body);
    plot.hidden = false;
    pen.clearRect(0, 0, width, height);
    names.forEach((name, at) => {
      const column = samples.map(sample => sample[at]), low = Math.min(...column), high = Math.max(...column), span = high - low || 1;
      const top = at * height / 4, room = height / 4 - 24;
      pen.fillStyle = style.color;
      pen.font = "17px system-ui";
      pen.fillText(`${name}: ${low.toPrecision(3)} to ${high.toPrecision(3)} ${name.startsWith("current") || name === "demand" ? "A" : name === "velocity" ? "rad/s" : ""}`, 2, top + 16);
      pen.strokeStyle = style.getPropertyValue(`--band${at}`);
      pen.beginPath();
      column.forEach((value, i) => pen.lineTo(i / (column.length - 1) * width, top + 22 + room * (1 - (value - low) / span)));
      pen.stroke();
    });
    legend.textContent = `${(samples.length * step).toFixed(0)} ms`;
  }

  // ---- bench mode: a set-point every 10 to 20 ms, as long as the button is held
  const speed = make("input", { type: "range", min: -1, max: 1, step: .05, value: .3, "aria-label": "Speed, rad/s" });
  const speedText = make("output", {}, "0.30 rad/s");
  speed.oninput = () => { speedText.textContent = `${Number(speed.value).toFixed(2)} rad/s`; };
  const set = (own, control, target = 0) => own.node && own.bus.send({ id: 0x300 + own.node, data: [...bytesOf(control, 2), 9, ...bytesOf(Math.round(target * 1e6), 4)] });
  async function bench() {
    if (benching) return;
    const own = benching = { on: true, control: 0x06, target: 0, node: chosen, bus };
    const timer = setInterval(() => { if (own.bus !== simulated || app.running) set(own, own.control, own.target); }, 15);
    const ask = (index, sub, value) => {
      if (!own.node) throw new Error("The run has been restarted");
      return own.bus.transfer(own.node, index, sub, value);
    };
    const measured = async (index, type) => numberOf(await ask(index, 0), type);
    const wait = time => new Promise(done => setTimeout(done, time));
    try {
      own.bus.send({ id: 0, data: [1, own.node] });
      set(own, 0x80);
      await wait(60);
      set(own, 0);
      await ask(0x2001, 0, bytesOf(1, 1));
      for (const control of [0x06, 0x07, 0x0f]) { own.control = control; await wait(120); }
      while (own.on) {
        const status = await measured(0x6041, 6);
        if ((status & 0x6f) !== 0x27 && !(status & 0x8000)) throw new Error(`The drive does not run: statusword 0x${status.toString(16)}. Is a fault latched?`);
        own.target = Number(speed.value);
        say(`velocity ${(await measured(0x606c, 4) * 1e-6).toFixed(2)} rad/s, current ${(await measured(0x6078, 3) * 1e-3).toFixed(2)} A`);
      }
      say("The motor is off.");
    } catch (error) {
      say(`${error.message}. Bench mode needs a drive that no guard commands: kill the guard first.`, true);
    } finally {
      clearInterval(timer);
      set(own, 0);
      benching = null;
    }
  }
  const release = () => { if (benching) benching.on = false; };
  const hold = make("button", { type: "button", id: "panel-bench", class: "bad" }, "Hold to run");
  hold.addEventListener("pointerdown", event => { hold.setPointerCapture?.(event.pointerId); bench(); });
  for (const type of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) hold.addEventListener(type, release);

  // ---- node id
  const id = make("input", { type: "number", min: 1, max: 127, value: 2, "aria-label": "Node id" });
  const serial = make("input", { type: "number", min: 0, value: 0, "aria-label": "Serial number" });
  const role = make("select", { "aria-label": "Role" }, ...tables.roles.map(of => make("option", { value: of.product }, of.name)));
  async function give() {
    const of = tables.roles.find(of => of.product === Number(role.value));
    const select = [[0x40, of.vendor], [0x41, of.product], [0x42, of.revision]];
    for (const [command, number] of select) await bus.lss([command, ...bytesOf(number, 4)], null);
    await bus.lss([0x43, ...bytesOf(serial.value, 4)], 0x44);
    for (const request of [[0x11, Number(id.value)], [0x17]]) {
      const answer = await bus.lss(request, request[0]);
      if (answer[1]) throw new Error(`The node refuses the id: error ${answer[1]}`);
    }
    await bus.lss([0x04, 0], null);
    say(`The node has the id ${id.value}.`);
  }

  // ---- the bus
  const source = make("span", {}, make("b", {}, "Simulated bus"));
  const connect = make("button", { type: "button", onclick: () => attempt(async () => {
    if (bus !== simulated) {
      await bus.close();
      bus = simulated;
      connect.textContent = "Adapter…";
      source.firstElementChild.textContent = "Simulated bus";
    } else {
      if (!navigator.serial) throw new Error("This browser has no Web Serial.");
      bus = await openAdapter(await navigator.serial.requestPort());
      connect.textContent = "Disconnect";
      source.firstElementChild.textContent = "Adapter";
    }
    chosen = null; values = new Map(); list.text = "";
    showNodes(); showSettings();
  }) }, "Adapter…");
  const button = (text, work, attributes = {}) => make("button", { type: "button", onclick: () => attempt(work), ...attributes }, text);
  const file = make("input", { type: "file", accept: ".toml" });
  file.onchange = () => { if (file.files[0]) fromFile(file.files[0]); file.value = ""; };
  const part = (name, ...inside) => make("details", {}, make("summary", {}, name), ...inside);
  const own = make("div", { hidden: "" },
    fault,
    part("Settings", make("p", { class: "row" }, button("Read all", readSettings, { id: "panel-read" }), button("Save", save, { id: "panel-save" }), button("Restart", async () => restart(), { id: "panel-restart" }),
      button("To file", async () => toFile()), make("label", { class: "file" }, "From file", file)), search, settings),
    part("Objects", button("Read all", readObjects), objects),
    part("Recording", make("p", {}, pick), button("Record", record, { id: "panel-record" }), plot, legend),
    part("Bench mode", make("p", {}, "One motor alone, slowly. The drive must be free of a guard's heartbeat."), make("label", { class: "row" }, "Speed ", speed, speedText), hold));
  root.append(
    make("p", { class: "row" }, source, connect),
    make("p", {}, make("small", {}, "The adapter is for real nodes (Web Serial, SLCAN). It is untried: no adapter was at hand.")),
    list, message, own,
    part("Id of a blank node", make("p", { class: "row" }, make("label", {}, "Role ", role), make("label", {}, "Serial ", serial), make("label", {}, "Id ", id), button("Give the id", give))));

  function choose(node) {
    if (benching) release();
    chosen = node;
    own.hidden = false;
    values = new Map();
    search.value = "";
    objects.replaceChildren(); plot.hidden = true; legend.textContent = "";
    showSettings(); showNodes();
    say("");
  }
  link.other = data => simulated.take(data);
  setInterval(() => {
    const now = !root.hidden;
    if (now !== shown) { shown = now; bus.open(shown); if (!shown) release(); }
    if (shown) showNodes();
  }, 100);
  return {
    start() {
      simulated.start();
      if (shown) simulated.open(true);
      if (benching?.bus === simulated) Object.assign(benching, { on: false, node: null });
      if (bus === simulated) { chosen = null; own.hidden = true; values = new Map(); }
      list.text = "";
    },
    choose, openAdapter,
  };
}
