// Draws a robot from the circles and lines of its plant's sketch, and shows its channels. A robot
// may have a script of its own instead.
const robotPage = {
  // Draws the robot in the side view.
  draw(run, element, set, line) {
    const { circles, lines } = run.sketch, points = run.points;
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
  },
  // Returns its plots, with the general ones among them.
  plots: general => [...run.sketch.plots, ...general],
  // Adds its figures.
  figures(figure) {
    for (const [name, settled, unit, range] of run.sketch.figures) {
      figure(name, minus(settled.toFixed(3)), unit === "1" ? "" : unit, "mean of the last 5 s; " + range.map(value => minus(value.toFixed(3))).join(" to ") + " in the whole run");
    }
  },
  // Says what the run assumes.
  assumptions: () => "",
  // Says what is shown beside the pitch.
  now: at => minus(`${at("speed").toFixed(3)} m/s`),
};
