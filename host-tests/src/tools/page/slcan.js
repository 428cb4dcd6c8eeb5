// The protocol of SLCAN adapters: lines of text on a serial line. `write` takes text.
function createSlcan(write, receive) {
  let rest = "";
  const hex = (value, digits) => value.toString(16).toUpperCase().padStart(digits, "0");
  return {
    // Closes the channel, sets 1 Mbit/s and opens it.
    open() { write("C\r"); write("S8\r"); write("O\r"); },
    close() { write("C\r"); },
    send({ id, data }) { write(`t${hex(id, 3)}${data.length}${data.map(byte => hex(byte, 2)).join("")}\r`); },
    // Takes text that the adapter sent, in pieces of any length.
    take(text) {
      const lines = (rest + text).split(/[\r\x07]/);
      rest = lines.pop().slice(-64);
      for (const line of lines) {
        const frame = /^t([0-7][0-9a-fA-F]{2})([0-8])([0-9a-fA-F]*)$/.exec(line);
        // Behind the data an adapter may write the time, four digits.
        if (!frame || frame[3].length < 2 * frame[2]) continue;
        const data = Array.from({ length: Number(frame[2]) }, (_, at) => parseInt(frame[3].slice(2 * at, 2 * at + 2), 16));
        receive({ id: parseInt(frame[1], 16), data });
      }
    },
  };
}
