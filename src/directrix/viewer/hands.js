// The loop that redraws, and what mouse, fingers and keys do.

function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(render);
}

function fitCanvas(canvas) {
  const box = canvas.getBoundingClientRect();
  const [width, height] = [box.width, box.height].map((x) => Math.round(x * devicePixelRatio));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
}

function render(now) {
  due = false;
  if (seen.playing) {
    if (before) step(Math.min(0.1, (now - before) / 1000));
    before = now;
  }
  [space, overlay, chart].forEach(fitCanvas);
  place(skeleton, atFrame(run.r, 3 * run.nodes, seen.u, r), atFrame(run.turn, 6 * run.nodes, seen.u, turn));
  drawSpace();
  drawChart();
  drawNumbers();
  if (seen.playing) redraw();
}

function lookFrom(name) {
  if (name !== "fit") [seen.yaw, seen.pitch] = VIEWS[name];
  const follow = checked("follow"), width = 3 * run.nodes;
  seen.target = (follow ? seen.home : room.centre).slice();
  const { right, up, back } = look(seen, 1, 1, room), dot = (v, x, y, z) => v[0] * x + v[1] * y + v[2] * z;
  const steep = 1 / Math.tan(0.5 * FIELD), flat = steep * space.clientHeight / Math.max(1, space.clientWidth);
  seen.distance = 0.2 * room.own; // far enough for every node at every instant
  for (let k = 0; k < run.frames; k++) {
    const points = run.r.subarray(k * width, (k + 1) * width), about = follow ? centroid(points) : seen.target;
    for (let i = 0; i < width; i += 3) {
      const p = [points[i] - about[0], points[i + 1] - about[1], points[i + 2] - about[2]];
      const needed = dot(back, ...p) + 1.15 * Math.max(flat * Math.abs(dot(right, ...p)), steep * Math.abs(dot(up, ...p)));
      seen.distance = Math.max(seen.distance, needed);
    }
  }
  redraw();
}

function turnBy(dx, dy) {
  seen.yaw -= 0.008 * dx;
  seen.pitch = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, seen.pitch + 0.008 * dy));
  redraw();
}

function moveBy(dx, dy) {
  const view = eyeOn(), unit = 2 * seen.distance * Math.tan(0.5 * FIELD) / space.clientHeight;
  seen.target = seen.target.map((x, i) => x + unit * (dy * view.up[i] - dx * view.right[i]));
  redraw();
}

function zoomBy(factor) {
  seen.distance = Math.min(100 * room.reach, Math.max(0.01 * room.reach, seen.distance * factor));
  redraw();
}

function hands() {
  const fingers = new Map();
  const middle = () => [...fingers.values()].reduce((sum, p) => [sum[0] + p[0] / fingers.size, sum[1] + p[1] / fingers.size], [0, 0]);
  const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  space.addEventListener("pointerdown", (event) => {
    space.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  space.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const from = middle(), wide = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    const to = middle(), dx = to[0] - from[0], dy = to[1] - from[1];
    if (fingers.size === 2 && spread() > 0) zoomBy(wide / spread());
    (fingers.size > 1 || event.shiftKey || event.buttons & 6 ? moveBy : turnBy)(dx, dy);
  });
  for (const kind of ["pointerup", "pointercancel"]) space.addEventListener(kind, (event) => fingers.delete(event.pointerId));
  space.addEventListener("contextmenu", (event) => event.preventDefault());
  space.addEventListener("dblclick", () => lookFrom("fit"));
  space.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(Math.exp(0.0012 * Math.max(-200, Math.min(200, event.deltaY * (event.deltaMode ? 30 : 1)))));
  }, { passive: false });
  const seek = (event) => {
    if (!event.buttons) return;
    stop(seen.pick(event.clientX - chart.getBoundingClientRect().left));
  };
  chart.addEventListener("pointerdown", (event) => { chart.setPointerCapture(event.pointerId); seek(event); });
  chart.addEventListener("pointermove", seek);
  slider.addEventListener("input", () => stop(Number(slider.value)));
  part("play").addEventListener("click", () => play(!seen.playing));
  for (const button of document.querySelectorAll("[data-look]")) button.addEventListener("click", () => lookFrom(button.dataset.look));
  for (const id of ["sections", "directors", "ghost", "names", "traces"]) part(id).addEventListener("change", redraw);
  part("follow").addEventListener("change", () => lookFrom("fit"));
  part("colour").addEventListener("change", () => { chooseColour(); redraw(); });
  part("thickness").addEventListener("change", () => { skin(); redraw(); });
  addEventListener("resize", redraw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readInk(); redraw(); });
  addEventListener("keydown", (event) => {
    const own = event.target.closest("select, input, button, summary"), jump = event.shiftKey ? 10 : 1;
    if (own || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = {
      " ": () => play(!seen.playing),
      ArrowRight: () => stop(seen.u + jump),
      ArrowLeft: () => stop(seen.u - jump),
      Home: () => stop(0),
      End: () => stop(last),
      d: () => part("directors").click(),
      f: () => lookFrom("fit"),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (act) { event.preventDefault(); act(); }
  });
}

function begin() {
  option(part("colour"), "plain", "plain");
  if (run.rods.length > 1) option(part("colour"), "rod", "by rod");
  for (const field of ["strain", "force"]) {
    COMPONENTS.forEach((name, i) => option(part("colour"), `${field}:${i}`, `${field}: ${name}`));
  }
  for (const k of thicknesses) option(part("thickness"), k, k === 1 ? "true" : `${k} times`);
  part("thickness").value = fitting;
  for (const k of [0.1, 0.25, 0.5, 1, 2, 5]) option(part("speed"), k, k === 1 && realTime ? "real time" : `× ${k}`);
  part("speed").value = 1;
  slider.max = last;
  part("play").disabled = slider.disabled = last === 0;
  part("refusal").hidden = Boolean(scene);
  part("options").hidden = !scene;
  if (innerWidth < 640) part("options").open = false;
  readInk();
  words();
  skin();
  place(skeleton, run.r0, Float32Array.from({ length: 6 * run.nodes }, (_, i) => (i % 6 === 0 || i % 6 === 4 ? 1 : 0)));
  seen.still = skeleton.samples.map((_, q) => [...skeleton.poses.subarray(9 * q, 9 * q + 3)]);
  seen.home = centroid(run.r.subarray(0, 3 * run.nodes));
  part("follow").checked = room.own < 0.7 * room.reach; // a body that flies away would be small in its own picture
  const flat = ["z", "y", "x"].find((name) => room.span["xyz".indexOf(name)] < 1e-6 * room.reach);
  hands();
  lookFrom(flat || "iso");
  const asked = Number(new URLSearchParams(location.hash.slice(1)).get("frame") ?? NaN);
  if (asked >= 0) go(asked);
  else if (dynamic && !calm) play(true);
  else go(dynamic ? 0 : last);
  render(0); // at once, not with the next frame: a page opened in the background is complete
  document.documentElement.dataset.state = "ready";
}

begin();
