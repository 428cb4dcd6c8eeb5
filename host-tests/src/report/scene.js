// The side view: terrain, robot, centre of gravity, contacts; drawn for a robot of about a metre, and for others by their `scale`.
// World metres, z up; SVG y points down.
function makeScene(svg, run) {
  const { terrain, contacts } = run;
  const element = (name, attributes, parent = svg) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    return parent.appendChild(made);
  };
  const set = (node, attributes) => { for (const key in attributes) node.setAttribute(key, attributes[key]); };
  const line = points => points.map(([x, z]) => `${x.toFixed(4)},${(-z).toFixed(4)}`).join(" ");

  const first = terrain[0], last = terrain[terrain.length - 1];
  const lowest = Math.min(...terrain.map(point => point[1])), highest = Math.max(...terrain.map(point => point[1]));
  element("polygon", { points: line([...terrain, [last[0], lowest - 9], [first[0], lowest - 9]]), fill: "var(--earth)" });
  const edge = element("polyline", { points: line(terrain), fill: "none", stroke: "var(--earth-edge)" });

  const robot = (run.sketch ? makeSketch : makeB2p2)(run, element, set, line), k = robot.scale;
  set(edge, { "stroke-width": 0.008 * k });
  const plumb = element("line", { stroke: "var(--c1)", "stroke-width": 0.006 * k, "stroke-dasharray": `${0.02 * k} ${0.014 * k}` });
  const touches = element("g", { fill: "var(--c0)" });
  const cog = element("g", {});
  element("circle", { r: 0.019 * k, fill: "var(--card)", stroke: "var(--c1)", "stroke-width": 0.009 * k }, cog);
  element("circle", { r: 0.007 * k, fill: "var(--c1)" }, cog);

  const groundAt = x => {
    for (let i = terrain.length - 2; i >= 0; i--) {
      const [x0, z0] = terrain[i], [x1, z1] = terrain[i + 1];
      if (x >= x0 && x1 > x0) return z0 + (z1 - z0) * Math.min(1, (x - x0) / (x1 - x0));
    }
    return first[1];
  };

  let width = 0, height = 0, follows = false;
  const full = last[0] - first[0];
  function resize() {
    const widest = (svg.clientWidth || 800) < 700 ? 2.1 * k : 3.8 * k;
    follows = full > widest * 1.1;
    width = follows ? widest : full;
    height = Math.max(1.1 * k, Math.min(width * 0.36, highest - lowest + 0.95 * k));
    svg.style.aspectRatio = `${width} / ${height}`;
  }

  function show(at) {
    robot.show(at);
    const c = [at("cogX"), at("cogZ")];
    set(cog, { transform: `translate(${c[0]} ${-c[1]})` });
    set(plumb, { x1: c[0], x2: c[0], y1: -c[1], y2: -Math.min(groundAt(c[0]), c[1]) });
    const points = contacts[at.index] || [];
    touches.replaceChildren();
    for (let i = 0; i < points.length; i += 2) {
      element("circle", { cx: points[i] * run.contactOne, cy: -points[i + 1] * run.contactOne, r: 0.013 * k }, touches);
    }
    const bottom = lowest - 0.12 * k;
    let left = first[0], low = bottom;
    if (follows) {
      left = Math.max(first[0], Math.min(last[0] - width, c[0] - width * 0.5));
      low = Math.max(bottom, Math.min(c[1] - height * 0.45, highest + k - height));
    }
    set(svg, { viewBox: `${left} ${-low - height} ${width} ${height}` });
  }
  resize();
  return { show, resize };
}
