// The side view: terrain, robot, centre of gravity, contacts. World metres, z up; SVG y points down.
function makeScene(svg, run) {
  const { robot, l1, l2, terrain, contacts } = run;
  const radius = robot.pulley_radius_m;
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
  element("polyline", { points: line(terrain), fill: "none", stroke: "var(--earth-edge)", "stroke-width": 0.008 });

  // A thick line with round joins around the three axles is the hull of the three pulleys.
  const hull = (width, colour) => element("polygon", { fill: colour, stroke: colour, "stroke-width": width, "stroke-linejoin": "round" });
  const belt = 0.012;
  const outer = hull(2 * radius, "var(--belt)");
  const inner = hull(2 * (radius - belt), "var(--inside)");
  const bone = width => element("line", { stroke: "var(--body)", "stroke-width": width, "stroke-linecap": "round" });
  const body1 = bone(0.042), body2 = bone(0.042), screw = bone(0.014);
  const pulleys = [0, 1, 2].map(() => {
    const group = element("g", {});
    element("circle", { r: radius - belt, fill: "var(--card)", stroke: "var(--belt)", "stroke-width": 0.006 }, group);
    const spoke = radius - belt - 0.004;
    for (const angle of [0, 60, 120]) {
      element("line", { x1: -spoke, x2: spoke, transform: `rotate(${angle})`, stroke: "var(--body)", "stroke-width": 0.007 }, group);
    }
    element("circle", { r: 0.01, fill: "var(--belt)" }, group);
    return group;
  });
  const load = element("g", { fill: "var(--c3)", stroke: "var(--c3)" });
  const strut = element("line", { "stroke-width": 0.006 }, load);
  const payload = element("rect", { width: 0.07, height: 0.07, rx: 0.008 }, load);
  const plumb = element("line", { stroke: "var(--c1)", "stroke-width": 0.006, "stroke-dasharray": "0.02 0.014" });
  const touches = element("g", { fill: "var(--c0)" });
  const cog = element("g", {});
  element("circle", { r: 0.019, fill: "var(--card)", stroke: "var(--c1)", "stroke-width": 0.009 }, cog);
  element("circle", { r: 0.007, fill: "var(--c1)" }, cog);

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
    const widest = (svg.clientWidth || 800) < 700 ? 2.1 : 3.8;
    follows = full > widest * 1.1;
    width = follows ? widest : full;
    height = Math.max(1.1, Math.min(width * 0.36, highest - lowest + 0.95));
    svg.style.aspectRatio = `${width} / ${height}`;
  }

  function show(at) {
    const pitch = at("pitch") * Math.PI / 180, theta = at("theta") * Math.PI / 180;
    const step = ([x, z], length, angle) => [x + length * Math.cos(angle), z + length * Math.sin(angle)];
    const a1 = [at("x"), at("z")], a2 = step(a1, l1, pitch);
    const end2 = step(a2, l2, pitch + theta), a3 = step(a2, l2 + at("extension"), pitch + theta);
    for (const shape of [outer, inner]) set(shape, { points: line([a1, a2, a3]) });
    const join = (bar, [x1, z1], [x2, z2]) => set(bar, { x1, x2, y1: -z1, y2: -z2 });
    join(body1, a1, a2); join(body2, a2, end2); join(screw, end2, a3);
    const turn = at("odometry") / radius * 180 / Math.PI;
    [a1, a2, a3].forEach(([x, z], i) => set(pulleys[i], { transform: `translate(${x} ${-z}) rotate(${turn})` }));
    const loaded = robot.payload && at("t") >= robot.payload.from_s;
    set(load, { display: loaded ? "" : "none" });
    if (loaded) {
      const [forward, , up] = robot.payload.place_m;
      const foot = step(a1, forward, pitch), place = step(foot, up, pitch + Math.PI / 2);
      join(strut, foot, place);
      set(payload, { x: place[0] - 0.035, y: -place[1] - 0.035 });
    }
    const c = [at("cogX"), at("cogZ")];
    set(cog, { transform: `translate(${c[0]} ${-c[1]})` });
    join(plumb, c, [c[0], Math.min(groundAt(c[0]), c[1])]);
    const points = contacts[at.index] || [];
    touches.replaceChildren();
    for (let i = 0; i < points.length; i += 2) {
      element("circle", { cx: points[i] / 100, cy: -points[i + 1] / 100, r: 0.013 }, touches);
    }
    const bottom = lowest - 0.12;
    let left = first[0], low = bottom;
    if (follows) {
      left = Math.max(first[0], Math.min(last[0] - width, c[0] - width * 0.5));
      low = Math.max(bottom, Math.min(c[1] - height * 0.45, highest + 1 - height));
    }
    set(svg, { viewBox: `${left} ${-low - height} ${width} ${height}` });
  }
  resize();
  return { show, resize };
}
