// The worker of the page: holds the module with simulator and nodes, and answers lists of requests.
let module = null, listens = false, time = 0, told = 0;

function ask(request) {
  const { buffer, answer, contents, memory } = module.exports;
  const bytes = new TextEncoder().encode(JSON.stringify(request));
  const at = buffer(bytes.length);
  new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
  let length;
  try {
    length = answer();
  } catch (trap) {
    const { panicked, panicked_length: size } = module.exports;
    const text = new TextDecoder().decode(new Uint8Array(memory.buffer, panicked(), size()));
    throw new Error(text || String(trap));
  }
  return new TextDecoder().decode(new Uint8Array(memory.buffer, contents(), length));
}

// The client of the panel is a participant of the simulated bus.
const client = createCanopen(frame => ask({ send: frame }));
const finished = ticket => (error, bytes) => postMessage({ ticket, error, bytes });

// Advances the run. While a transfer is under way, the client answers within a millisecond.
function advance(steps) {
  for (let left = steps; listens && left > 0;) {
    const count = client.busy() ? 1 : left;
    const frames = JSON.parse(ask({ bus: count }));
    if (frames.error) throw new Error(frames.error);
    for (const [, , id, data] of frames) client.frame({ id, data });
    time += count;
    left -= count;
    client.tick(time);
  }
  if (listens && (time - told > 100 || time < told)) { told = time; postMessage({ nodes: [...client.nodes.values()] }); }
  return ask({ advance: listens ? 0 : steps });
}

function act(request) {
  if (request.advance !== undefined) return advance(request.advance);
  if (request.transfer) {
    const { node, index, sub, value, ticket } = request.transfer;
    client.transfer(node, index, sub, value, finished(ticket));
    return "null";
  }
  if (request.lss) {
    client.lss(request.lss.bytes, request.lss.answer, finished(request.lss.ticket));
    return "null";
  }
  if (request.listen !== undefined) listens = request.listen;
  const answer = ask(request);
  if (request.start && !JSON.parse(answer).error) { client.clear(); time = 0; ask({ listen: listens }); }
  return answer;
}

// An answer is the text of a JSON value: whoever needs it parses it.
onmessage = async ({ data: { id, bytes, requests } }) => {
  try {
    if (bytes) module = (await WebAssembly.instantiate(bytes, {})).instance;
    const began = performance.now();
    const answers = (requests || []).map(act);
    postMessage({ id, answers, spent: performance.now() - began });
  } catch (error) {
    postMessage({ id, error: String(error.message || error) });
  }
};
