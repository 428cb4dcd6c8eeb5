// Draws B2P2 with its belts, and shows its joints. The members are those of sketch.js.
const robotPage = {
  draw(run, element, set) {
    const { robot, l1, l2 } = run.own;
    const radius = robot.pulley_radius_m;
    const belt = 0.012;
    const loop = element("path", { fill: "var(--inside)", stroke: "var(--belt)", "stroke-width": belt, "stroke-linejoin": "round" });
    // The belt as it lies: straight pieces from pulley to pulley and over corners of the ground, with
    // arcs around the pulleys. The points are the ends of the straight pieces, in mm.
    const course = points => {
      const places = [], pieces = [];
      for (let i = 0; i < points.length; i += 2) places.push([points[i] / 1000, points[i + 1] / 1000]);
      for (let i = 0; i < places.length; i += 2) pieces.push([places[i], places[i + 1]]);
      const direction = ([[x0, z0], [x1, z1]]) => Math.atan2(z1 - z0, x1 - x0);
      return pieces.map((piece, i) => {
        const next = pieces[(i + 1) % pieces.length];
        const turn = (direction(next) - direction(piece) + 4 * Math.PI) % (2 * Math.PI);
        const [[x0, z0], [x1, z1]] = piece, [x, z] = next[0];
        const arc = Math.hypot(x - x1, z - z1) > 0.003 ? `A${radius} ${radius} 0 ${turn > Math.PI ? 1 : 0} 0 ${x} ${-z}` : "";
        return `${i ? "L" : "M"}${x0} ${-z0}L${x1} ${-z1}${arc}`;
      }).join("") + (pieces.length ? "Z" : "");
    };
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
      set(loop, { d: course(run.points[at.index] || []) });
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
  },
  plots: ([pitch, margin, speed, busLoad]) => [
    pitch,
    margin,
    { title: "Chassis angle", unit: "°", curves: [["truth", "theta", "", 0], ["passed by the guard", "passedTheta", "", 1], ["commanded", "askedTheta", "dashed", 2]] },
    speed,
    { title: "Screw extension L3", unit: "m", curves: [["truth", "extension", "", 2]] },
    { title: "Belt: L + L2 + L3 − K", unit: "mm", zero: true, curves: [["strain (+), slack (−)", "tension", "", 3]] },
    { title: "Tension of the belts", unit: "N", zero: true, curves: [["left", "leftTension", "", 0], ["right", "rightTension", "", 1]] },
    { title: "Motor currents", unit: "A", zero: true, curves: [["left", "leftCurrent"], ["right", "rightCurrent"], ["chassis", "chassisCurrent"], ["screw", "screwCurrent"]] },
    busLoad,
  ],
  figures(figure) {
    const landed = summary.landing_time_s !== null;
    figure("Landing", landed ? summary.landing_time_s.toFixed(2) : "none", landed ? "s" : "", `of ${summary.simulated_s.toFixed(1)} s simulated`);
  },
  assumptions() {
    const { robot } = run.own, height = robot.com_offset_m;
    const place = height === 0 ? "on the line of axles 1 and 2" : `${Math.abs(height * 1e3).toFixed(0)} mm ${height > 0 ? "above" : "below"} the line of axles 1 and 2`;
    return "The papers do not give the belt length K, the pulley radius, the position of the battery, or the friction of the cleats. "
      + `This run assumes K = ${robot.k_m} m, pulleys of ${robot.pulley_radius_m} m radius, the centre of mass of body 1 ${place} (which models the battery), and a friction coefficient of ${run.friction}`
      + (robot.payload ? `, with a payload of ${robot.payload.mass_kg} kg` : "")
      + ". Whether the robot climbs, and with what margin, depends on these values. No figure here was measured on a real one.";
  },
  now: at => minus(`chassis ${at("theta").toFixed(1)}°`) + ` · screw ${(at("extension") * 1e3).toFixed(0)} mm`,
};
