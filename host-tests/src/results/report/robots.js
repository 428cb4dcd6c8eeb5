// Draws the robot in the side view. B2P2 has its own drawing; other robots are drawn from the
// circles and lines of their plant's sketch.
function makeB2p2(run, element, set, line) {
  const { robot, l1, l2 } = run;
  const radius = robot.pulley_radius_m;
  // The hull of the three pulleys: a triangle between the axles with a thick, rounded outline.
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
  }
  return { show };
}

function makeSketch(run, element, set, line) {
  const { circles, lines, points } = run.sketch;
  const place = (index, number) => [points[index][2 * number] / 1000, points[index][2 * number + 1] / 1000];
  const scale = run.view.scale;
  const wheels = circles.map(([, r]) => {
    const group = element("g", {});
    element("circle", { r, fill: "var(--inside)", stroke: "var(--belt)", "stroke-width": 0.012 * scale }, group);
    element("circle", { r: 0.15 * r, fill: "var(--belt)" }, group);
    return group;
  });
  const bones = lines.map(() => element("polyline", { fill: "none", stroke: "var(--belt)", "stroke-width": 0.014 * scale, "stroke-linejoin": "round", "stroke-linecap": "round" }));
  function show(at) {
    if (!points.length) return;
    circles.forEach(([number], i) => { const [x, z] = place(at.index, number); set(wheels[i], { transform: `translate(${x} ${-z})` }); });
    lines.forEach((numbers, i) => set(bones[i], { points: line(numbers.map(number => place(at.index, number))) }));
  }
  return { show };
}
