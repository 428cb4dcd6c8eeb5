// Draws the side view along the robot's path: ground, robot, centre of gravity and contacts. The
// camera follows the robot. Units are metres, z points up; SVG's y points down. Line widths suit a
// robot of about one metre, and are multiplied by the view's `scale`.
function makeScene(svg, run) {
  const { contacts, groundOne, view } = run;
  const element = (name, attributes, parent = svg) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    return parent.appendChild(made);
  };
  const set = (node, attributes) => { for (const key in attributes) node.setAttribute(key, attributes[key]); };
  const line = points => points.map(([x, z]) => `${x.toFixed(4)},${(-z).toFixed(4)}`).join(" ");

  // A section of the ground is used until the next one begins. It has points [distance, height]
  // under the middle of the robot and, where the ground differs there, under its sides.
  const unpack = values => values && Array.from({ length: values.length / 2 }, (_, i) => [values[2 * i] * groundOne, values[2 * i + 1] * groundOne]);
  const sections = run.ground.map(({ from, middle, left, right }) => ({ from, middle: unpack(middle), left: unpack(left), right: unpack(right) }));
  const solid = points => {
    const low = Math.min(...points.map(point => point[1])) - 9;
    return line([...points, [points[points.length - 1][0], low], [points[0][0], low]]);
  };
  const ground = element("polygon", { fill: "var(--earth)" });
  const edge = element("polyline", { fill: "none", stroke: "var(--earth-edge)" });
  const robot = robotPage.draw(run, element, set, line), k = view.scale;
  // The ground on the near side hides part of the robot.
  const near = element("polygon", { fill: "var(--earth)", opacity: 0.7 });
  const nearEdge = element("polyline", { fill: "none", stroke: "var(--earth-edge)", "stroke-width": 0.006 * k });
  const posts = element("g", { stroke: "var(--earth-edge)", fill: "var(--earth-edge)" });
  set(edge, { "stroke-width": 0.008 * k });
  const plumb = element("line", { stroke: "var(--c1)", "stroke-width": 0.006 * k, "stroke-dasharray": `${0.02 * k} ${0.014 * k}` });
  const touches = element("g", { fill: "var(--c0)" });
  const cog = element("g", {});
  element("circle", { r: 0.019 * k, fill: "var(--card)", stroke: "var(--c1)", "stroke-width": 0.009 * k }, cog);
  element("circle", { r: 0.007 * k, fill: "var(--c1)" }, cog);

  let section, size;
  const groundAt = x => {
    const points = section.middle;
    for (let i = points.length - 2; i >= 0; i--) {
      const [x0, z0] = points[i], [x1, z1] = points[i + 1];
      if (x >= x0 && x1 > x0) return z0 + (z1 - z0) * Math.min(1, (x - x0) / (x1 - x0));
    }
    return points[0][1];
  };
  function lay(next) {
    section = next;
    const { middle, left, right } = section;
    set(ground, { points: solid(left ? left : middle), fill: left ? "var(--earth-far)" : "var(--earth)" });
    set(edge, { points: line(left ? left : middle) });
    set(near, { display: right ? "" : "none", points: right ? solid(right) : "" });
    set(nearEdge, { display: right ? "" : "none", points: right ? line(right) : "" });
  }

  function resize() {
    size = (svg.clientWidth || 800) < 700 ? view.narrow : view.wide;
    svg.style.aspectRatio = `${size[0]} / ${size[1]}`;
  }

  // Posts at round distances make motion visible on level ground.
  const apart = k > 0.6 ? 0.5 : 0.1;
  function post(left) {
    posts.replaceChildren();
    for (let n = Math.ceil(left / apart); n * apart < left + size[0]; n++) {
      const x = n * apart, z = groundAt(x);
      element("line", { x1: x, x2: x, y1: -z, y2: -z + 0.05 * k, "stroke-width": 0.006 * k }, posts);
      // A label is left out if the edge of the view or a riser would cut it.
      const bend = Math.abs(groundAt(x - 0.1 * k) + groundAt(x + 0.1 * k) - 2 * z);
      if (bend > 0.05 * k || Math.min(x - left, left + size[0] - x) < 0.12 * k) continue;
      element("text", { x, y: -z + 0.12 * k, "font-size": 0.055 * k, "text-anchor": "middle", stroke: "none" }, posts).textContent = `${x.toFixed(1).replace("-", "−")} m`;
    }
  }

  function show(at) {
    let now = sections[0];
    for (const next of sections) { if (next.from > at.index) break; now = next; }
    if (now && now !== section) lay(now);
    robot.show(at);
    const c = [at("cogX"), at("cogZ")];
    set(cog, { transform: `translate(${c[0]} ${-c[1]})` });
    if (section) set(plumb, { x1: c[0], x2: c[0], y1: -c[1], y2: -Math.min(groundAt(c[0]), c[1]) });
    const points = contacts[at.index] || [];
    touches.replaceChildren();
    for (let i = 0; i < points.length; i += 2) {
      element("circle", { cx: points[i] * run.contactOne, cy: -points[i + 1] * run.contactOne, r: 0.013 * k }, touches);
    }
    const left = at("viewX") - size[0] / 2, top = -at("viewZ") - size[1] / 2;
    if (section) post(left);
    set(svg, { viewBox: `${left} ${top} ${size[0]} ${size[1]}` });
  }
  resize();
  return { show, resize };
}
