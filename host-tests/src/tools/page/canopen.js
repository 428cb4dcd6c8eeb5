// A CANopen client: transfers of objects (SDO, CiA 301), heartbeats and emergencies. It does not
// know what carries its frames: `send` sends one, `frame` takes one that was received, and `tick`
// tells it the time. So it serves the simulated bus and an adapter alike.
function createCanopen(send) {
  const waiting = [], nodes = new Map();
  let current = null, now = 0;
  const LIMIT = 2000, ATTEMPTS = 3;

  const header = (command, { index, sub }) => [command, index & 255, index >> 8, sub];
  const request = bytes => { current.sent = now; send({ id: 0x600 + current.node, data: [...bytes, 0, 0, 0, 0, 0, 0, 0, 0].slice(0, 8) }); };
  function begin() {
    if (current || !waiting.length) return;
    current = waiting.shift();
    again();
  }
  function again() {
    if (current.lss) {
      Object.assign(current, { sent: now, tries: (current.tries || 0) + 1 });
      const { lss, done } = current;
      send({ id: 0x7e5, data: [...lss, 0, 0, 0, 0, 0, 0, 0].slice(0, 8) });
      // A request without an answer.
      if (current.answer === null) { current = null; done(null, []); begin(); }
      return;
    }
    Object.assign(current, { toggle: 0, got: [], at: 0, segments: false, tries: (current.tries || 0) + 1 });
    const { value } = current;
    if (!value) request(header(0x40, current));
    else if (value.length <= 4) request([...header(0x23 | (4 - value.length) << 2, current), ...value]);
    else request([...header(0x21, current), ...[0, 8, 16, 24].map(shift => value.length >> shift & 255)]);
  }
  function end(error, bytes) {
    const { done } = current;
    current = null;
    done(error, bytes);
    begin();
  }
  const number = (data, at) => (data[at] | data[at + 1] << 8 | data[at + 2] << 16 | data[at + 3] << 24) >>> 0;
  const next = () => { const { toggle } = current; current.toggle ^= 0x10; return toggle; };
  function segment() {
    const rest = current.value.slice(current.at, current.at + 7);
    current.at += rest.length;
    request([next() | (7 - rest.length) << 1 | (current.at >= current.value.length ? 1 : 0), ...rest]);
  }
  function answer(data) {
    const command = data[0], ours = current.segments || data[1] === (current.index & 255) && data[2] === current.index >> 8 && data[3] === current.sub;
    if (!ours) return;
    if (command === 0x80) {
      const code = number(data, 4);
      // A node that gave a segment up, because this computer was too slow.
      if (code === 0x05040000 && current.tries < ATTEMPTS) return again();
      return end(`the node refuses, abort code ${code.toString(16).padStart(8, "0")}`);
    }
    if (current.value) {
      if (command === 0x60 && current.value.length <= 4) return end(null, []);
      if (command === 0x60 || (command & 0xe0) === 0x20) {
        current.segments = true;
        return current.at >= current.value.length ? end(null, []) : segment();
      }
    } else if (current.segments) {
      if ((command & 0xe0) !== 0) return;
      current.got.push(...data.slice(1, 8 - (command >> 1 & 7)));
      return command & 1 ? end(null, current.got) : request([0x60 | next()]);
    } else if ((command & 0xe0) === 0x40) {
      if (command & 2) return end(null, data.slice(4, command & 1 ? 8 - (command >> 2 & 3) : 8));
      current.segments = true;
      return request([0x60 | next()]);
    }
    end("an answer that is none");
  }
  return {
    nodes,
    busy: () => current !== null,
    // Reads an object, or writes `value` to it. `done` gets an error or null, and the bytes.
    transfer(node, index, sub, value, done) { waiting.push({ node, index, sub, value, done }); begin(); },
    // Sends an LSS request (CiA 305); `answer` is the first byte of its answer, or null.
    lss(bytes, answer, done) { waiting.push({ lss: bytes, answer, done }); begin(); },
    frame({ id, data }) {
      if (id === 0x7e4 && current?.lss && data[0] === current.answer) return end(null, data);
      const node = id & 0x7f, kind = id & 0x780;
      if (node === 0) return;
      const of = () => { if (!nodes.has(node)) nodes.set(node, { id: node }); return nodes.get(node); };
      if (kind === 0x700 && data.length === 1) Object.assign(of(), { state: data[0] & 0x7f, heard: now });
      else if (kind === 0x080) Object.assign(of(), { code: data[0] | data[1] << 8 });
      else if (kind === 0x580 && current && !current.lss && node === current.node) answer(data);
    },
    tick(time) {
      now = time;
      if (current && now - current.sent > LIMIT) {
        if (current.tries < ATTEMPTS) again(); else end("the node does not answer");
      }
      // A heartbeat comes once in a second at least.
      for (const of of nodes.values()) of.silent = now - (of.heard ?? -1e9) > 1500;
    },
    // Another bus, or a new run.
    clear() { nodes.clear(); waiting.length = 0; current = null; },
  };
}
