// Shows the run in the 3-D scene of the live page. Paper, and a browser without WebGL 2, have the
// side view.
async function makeSolid(host, packed) {
  const nothing = { show() {} };
  if (!packed || typeof DecompressionStream === "undefined") return nothing;
  const canvas = host.querySelector("canvas"), renderer = createRenderer(canvas);
  if (!renderer) return nothing;
  const { still, ground, states } = await unpack(packed).json();
  const scene = createScene(renderer, still), camera = createCamera(canvas, sizeOf(still), true);
  scene.setGround(ground, null);
  camera.mode = "side";
  camera.zoom(.75);
  addCameras(host.querySelector("[role=group]"), camera);
  const wanted = { support: true, balance: true, forces: false, trails: true };
  let theme = sceneTheme(), before = 0, shown;
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { theme = sceneTheme(); });
  host.hidden = false;
  host.parentElement.classList.add("is-solid");
  const show = time => {
    let low = 0, high = states.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (states[middle].sample.time_s <= time + 1e-6) low = middle; else high = middle - 1;
    }
    if (states[low] !== shown) scene.update(shown = states[low]);
  };
  show(0);
  requestAnimationFrame(function frame(now) {
    const { truth } = shown.sample, dt = Math.min(.1, (now - before) / 1000);
    before = now;
    scene.draw(camera.look(aimAt(truth), truth.yaw, dt, Math.min(2, devicePixelRatio || 1)), theme, wanted, null);
    requestAnimationFrame(frame);
  });
  return { show };
}
