// Draws curves over time with one shared cursor and one shared span of time, which the wheel with
// the control key changes. A box hides its curve. A plot is left out if the robot lacks one of its
// curves. Each curve is drawn with the minimum and maximum of each pixel column, which include those
// of all samples that the page leaves out.
const PLOTS = [
  { title: "Pitch", unit: "°", curves: [["truth", "pitch"], ["guard's estimate", "receivedPitch", "dashed"]] },
  { title: "Margin: centre of gravity to the edge of the support", unit: "m", zero: true, curves: [["rear, truth", "back"], ["rear, guard", "guardBack", "dashed", 0], ["front, truth", "front", "", 1], ["front, guard", "guardFront", "dashed", 1]] },
  { title: "Forward speed", unit: "m/s", curves: [["truth", "speed", "", 0], ["passed by the guard", "passedSpeed", "", 1], ["commanded", "askedSpeed", "dashed", 2]] },
  { title: "Bus load", unit: "%", zero: true, curves: [["last 100 ms", "busLoad", "", 2]] },
];
// Fig. 8 of the paper. When a belt meets a nose, the ZMP peaks for one or two samples. The plot cuts
// off these peaks, because they would make everything else too small to see.
const BALANCE_PLOTS = [
  { title: "CoG and ZMP", unit: "m", zero: true, areas: true, curves: [["ZMP", "zmpAlong", "", 1], ["CoG", "cogAlong", "", 0], ["P1", "p1", "dashed", 3], ["P2", "p2", "dashed", 3], ["P3", "p3", "dashed", 2]], range: ["cogAlong", "p1", "p2", "p3"] },
  { title: "ZMP − CoG", unit: "% of length", zero: true, areas: true, limits: [-6, 6], curves: [["raw", "zmpOff", "", 1], ["smoothed, 0.15 s", "zmpOffSmoothed", "", 0]] },
];

function makePlots(host, wanted, run, seek, zoom) {
  const times = run.series.t;
  let start = 0, span = times[times.length - 1] || 1;
  const space = { left: 46, right: 8, top: 8, bottom: 20, height: 168 };
  const svgNs = "http://www.w3.org/2000/svg";
  const element = (name, attributes, parent) => {
    const made = document.createElementNS(svgNs, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    return parent.appendChild(made);
  };
  const digits = unit => ({ "°": 1, "%": 0, m: 3, mm: 2, "m/s": 2, A: 2, "% of length": 2, 1: 3 })[unit] ?? 2;

  function niceStep(range, count) {
    const rough = range / count, power = 10 ** Math.floor(Math.log10(rough));
    return [1, 2, 5, 10].map(factor => factor * power).find(step => step >= rough * 0.999);
  }
  function grid(low, high, count) {
    const step = niceStep(high - low, count), lines = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) lines.push(k * step);
    return { lines, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
  }

  const plots = wanted.filter(plot => plot.curves.every(([, name]) => name in run.series)).map(plot => {
    const figure = host.appendChild(document.createElement("figure"));
    const caption = figure.appendChild(document.createElement("figcaption"));
    caption.innerHTML = `<strong>${plot.title} <span class="unit">${plot.unit}</span></strong>`;
    const svg = element("svg", { role: "img", "aria-label": `${plot.title}, ${plot.unit}, over time` }, figure);
    const curves = plot.curves.map(([label, name, dash, colour], i) => {
      const key = caption.appendChild(document.createElement("label")), box = key.appendChild(document.createElement("input"));
      Object.assign(box, { type: "checkbox", checked: true, onchange: () => draw() });
      key.className = "key";
      // The page has four colours. More curves get hues around the colour circle.
      const paint = plot.curves.length > 4 ? `hsl(${i * 360 / plot.curves.length} 60% 48%)` : `var(--c${colour ?? i})`;
      key.style.setProperty("--key", paint);
      if (dash) key.style.setProperty("--dash", dash);
      key.append(label + " ");
      return { values: run.series[name], least: run.least[name], most: run.most[name], dash, paint, box, value: key.appendChild(document.createElement("b")) };
    });
    let low = Infinity, high = -Infinity;
    const within = plot.range ? plot.range.map(name => ({ least: run.least[name], most: run.most[name] })) : curves;
    for (const { least, most } of within) for (let i = 0; i < least.length; i++) if (least[i] !== null) {
      if (least[i] < low) low = least[i];
      if (most[i] > high) high = most[i];
    }
    if (plot.zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
    if (!(low <= high)) { low = 0; high = 1; }
    // The range is at least ten steps of the last digit in the key, so that noise looks flat.
    const missing = 10 * 10 ** -digits(plot.unit) - (high - low);
    if (missing > 0) { low -= plot.zero ? 0 : missing / 2; high += plot.zero ? missing : missing / 2; }
    const pad = (high - low) * 0.06 || 0.5;
    low -= low === 0 && plot.zero ? 0 : pad; high += pad;
    if (plot.limits) { low = Math.max(low, plot.limits[0]); high = Math.min(high, plot.limits[1]); }
    const timeAt = event => {
      const box = svg.getBoundingClientRect();
      return start + span * Math.max(0, Math.min(1, (event.clientX - box.left - space.left) / (box.width - space.left - space.right)));
    };
    const seekTo = event => seek(timeAt(event));
    svg.addEventListener("wheel", event => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      const by = Math.exp(event.deltaY * .002), here = timeAt(event);
      zoom(here - (here - start) * by, here + (start + span - here) * by);
    }, { passive: false });
    svg.addEventListener("dblclick", () => zoom(0, Infinity));
    svg.addEventListener("pointerdown", event => { svg.setPointerCapture(event.pointerId); seekTo(event); });
    svg.addEventListener("pointermove", event => { if (event.buttons) seekTo(event); });
    return { plot, svg, curves, low, high };
  });

  function path({ values, least: minima, most: maxima }, width, y) {
    let text = "", pen = false, column = null, least, most, end;
    const x = time => space.left + (time - start) / span * width;
    const flush = () => {
      if (column === null) return;
      const at = (space.left + column).toFixed(0);
      text += `${pen ? "L" : "M"}${at} ${y(least).toFixed(1)}`;
      if (most > least) text += `L${at} ${y(most).toFixed(1)}L${at} ${y(end).toFixed(1)}`;
      pen = true; column = null;
    };
    for (let i = 0; i < values.length; i++) {
      const value = values[i];
      if (value === null) { flush(); pen = false; continue; }
      const next = Math.floor(x(times[i]) - space.left);
      if (next !== column) { flush(); column = next; least = most = value; }
      least = Math.min(least, minima[i]); most = Math.max(most, maxima[i]); end = value;
    }
    flush();
    return text;
  }

  function draw() {
    for (const item of plots) {
      const { svg, plot, curves, low, high } = item;
      const total = svg.clientWidth || 480, width = total - space.left - space.right, floor = space.height - space.bottom;
      const y = value => floor - (value - low) / (high - low) * (floor - space.top);
      svg.replaceChildren();
      svg.setAttribute("viewBox", `0 0 ${total} ${space.height}`);
      svg.style.height = `${space.height}px`;
      for (const [begins, ends] of run.bands) {
        const from = Math.max(start, begins), to = Math.min(start + span, ends);
        if (to < from) continue;
        const x = space.left + (from - start) / span * width;
        element("rect", { x, width: Math.max(1, (to - from) / span * width), y: space.top, height: floor - space.top, fill: "var(--mark-guard)", opacity: 0.18 }, svg);
      }
      const rows = grid(low, high, 6);
      for (const value of rows.lines) {
        const zero = plot.zero && Math.abs(value) < 1e-9;
        element("line", { x1: space.left, x2: total - space.right, y1: y(value), y2: y(value), stroke: zero ? "var(--soft)" : "var(--line)" }, svg);
        element("text", { x: space.left - 6, y: y(value) + 4, "text-anchor": "end" }, svg).textContent = minus(value.toFixed(rows.decimals));
      }
      const columns = grid(start, start + span, Math.max(4, width / 60));
      columns.lines.forEach((time, i) => {
        const x = space.left + (time - start) / span * width;
        const isLast = i === columns.lines.length - 1;
        element("text", { x, y: space.height - 5, "text-anchor": x > total - 30 ? "end" : "middle" }, svg).textContent = time.toFixed(columns.decimals) + (isLast ? " s" : "");
      });
      for (const mark of run.marks.filter(mark => mark.kind !== "guard" && mark.t >= start && mark.t <= start + span)) {
        const x = space.left + (mark.t - start) / span * width;
        const made = element("line", { x1: x, x2: x, y1: space.top, y2: floor, stroke: `var(--mark-${mark.kind})`, "stroke-width": 1, opacity: ["event", "warning"].includes(mark.kind) ? 0.4 : 0.9 }, svg);
        element("title", {}, made).textContent = `${mark.t.toFixed(2)} s: ${mark.text}`;
      }
      // An inner svg cuts off curves at its bounds.
      const window = element("svg", { x: space.left, y: space.top, width, height: floor - space.top, viewBox: `${space.left} ${space.top} ${width} ${floor - space.top}` }, svg);
      for (const curve of curves) if (curve.box.checked) {
        element("path", { d: path(curve, width, y), fill: "none", stroke: curve.paint, "stroke-width": 1.6, "stroke-linejoin": "round", "stroke-dasharray": curve.dash ? "5 3" : "none" }, window);
      }
      if (plot.areas) for (const [name, ...times] of run.areas) {
        const ends = times.map(time => space.left + (time - start) / span * width);
        for (const x of ends) element("line", { x1: x, x2: x, y1: space.top, y2: floor, stroke: "var(--soft)", "stroke-dasharray": "2 3" }, window);
        element("text", { x: (ends[0] + ends[1]) / 2, y: space.top + 12, "text-anchor": "middle", class: "area" }, window).textContent = name;
      }
      item.cursor = element("line", { y1: space.top, y2: floor, stroke: "var(--ink)", "stroke-width": 1 }, window);
      item.width = width;
      place(item);
    }
  }

  let now = 0;
  function place({ cursor, width }) {
    const x = space.left + (now - start) / span * width;
    cursor.setAttribute("x1", x); cursor.setAttribute("x2", x);
  }
  function show(at) {
    now = at("t");
    for (const item of plots) {
      const { plot, curves } = item;
      place(item);
      for (const curve of curves) {
        const value = curve.values[at.index];
        curve.value.textContent = value == null ? "none" : minus(value.toFixed(digits(plot.unit)));
      }
    }
  }
  draw();
  // Shows this span of time.
  const shows = (from, length) => { start = from; span = length; draw(); };
  return { draw, show, shows };
}
