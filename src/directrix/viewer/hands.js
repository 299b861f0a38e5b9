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
  placeAll();
  drawSpace();
  drawChart();
  drawNumbers();
  if (seen.playing) redraw();
}

function lookFrom(name) {
  if (name !== "fit") [seen.yaw, seen.pitch] = VIEWS[name];
  const follow = checked("follow"), factor = Number(part("deformation").value);
  seen.target = (follow ? seen.home : room.centre).slice();
  const { right, up, back } = look(seen, 1, 1, room), dot = (v, x, y, z) => v[0] * x + v[1] * y + v[2] * z;
  const [aside, below] = covered(), base = 1 / Math.tan(0.5 * FIELD), steep = base / (1 - below);
  const flat = base * space.clientHeight / Math.max(1, space.clientWidth * (1 - aside));
  const loads = checked("marks") && runs.some((run) => run.marks.some(({ vector }) => vector.some(Boolean)));
  const margin = loads ? 1.35 : 1.15; // arrows want room as well
  seen.distance = 0.2 * room.own; // far enough for every node at every instant
  for (const run of runs) {
    const width = 3 * run.nodes, base = run.base.r;
    for (let k = 0; k < run.frames; k++) {
      const points = run.r.subarray(k * width, (k + 1) * width), about = follow ? centroid(points) : seen.target;
      for (let i = 0; i < width; i += 3) {
        const p = [0, 1, 2].map((m) => base[i + m] + factor * (points[i + m] - base[i + m]) - about[m]);
        const needed = dot(back, ...p) + margin * Math.max(flat * Math.abs(dot(right, ...p)), steep * Math.abs(dot(up, ...p)));
        seen.distance = Math.max(seen.distance, needed);
      }
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
  for (const id of ["sections", "directors", "ghost", "marks", "names", "traces"]) part(id).addEventListener("change", redraw);
  part("follow").addEventListener("change", () => lookFrom("fit"));
  part("colour").addEventListener("change", () => { showScale(); redraw(); });
  part("thickness").addEventListener("change", () => { skin(); redraw(); });
  part("deformation").addEventListener("change", () => { tellDeformation(); lookFrom("fit"); });
  part("options").addEventListener("toggle", redraw);
  part("photo").addEventListener("click", savePhoto);
  for (const id of ["ask", "close"]) part(id).addEventListener("click", help);
  addEventListener("resize", redraw);
  dark.addEventListener("change", () => { readInk(); redraw(); });
  addEventListener("keydown", (event) => {
    const typed = event.key.length === 1 ? event.key.toLowerCase() : event.key, letter = /^[a-z1-4]$/.test(typed);
    // arrows and space belong to what has the focus; a letter in a list as well
    const own = event.target.closest(letter ? "select" : "select, input, button, summary"), jump = event.shiftKey ? 10 : 1;
    if (own || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = {
      " ": () => play(!seen.playing),
      ArrowRight: () => stop(seen.u + jump),
      ArrowLeft: () => stop(seen.u - jump),
      Home: () => stop(0),
      End: () => stop(clock.last),
      1: () => lookFrom("x"),
      2: () => lookFrom("y"),
      3: () => lookFrom("z"),
      4: () => lookFrom("iso"),
      f: () => lookFrom("fit"),
      d: () => part("directors").click(),
      m: () => part("marks").click(),
      n: () => part("names").click(),
      l: () => part("loop").click(),
      s: savePhoto,
      h: help,
      Escape: () => { part("help").hidden = true; },
    }[typed];
    if (act) { event.preventDefault(); act(); }
  });
}

function help() {
  part("help").hidden = !part("help").hidden;
}

// A picture that is not to scale says so.
function tellDeformation() {
  const factor = part("deformation").value, select = part("deformation").parentElement;
  select.classList.toggle("untrue", factor !== "1");
}

function fillLists() {
  const colour = part("colour"), groups = new Map();
  option(colour, "plain", runs.length > 1 ? "by run" : "plain");
  if (runs.some((run) => run.rods.length > 1)) option(colour, "rod", "by rod");
  for (const [key, field] of Object.entries(FIELDS)) {
    if (!runs.some((run) => has(run, field))) continue;
    if (!groups.has(field.group)) groups.set(field.group, Object.assign(document.createElement("optgroup"), { label: field.group }));
    option(groups.get(field.group), key, field.name);
  }
  colour.append(...groups.values());
  for (const k of thicknesses) option(part("thickness"), k, k === 1 ? "true" : `${k} times`);
  part("thickness").value = fitting;
  for (const k of [0, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100]) option(part("deformation"), k, k === 1 ? page.mode ? "as given" : "true" : `${k} times`);
  part("deformation").value = 1;
  for (const k of [0.1, 0.25, 0.5, 1, 2, 5]) option(part("speed"), k, `× ${k}`);
  part("speed").value = 1;
}

// What the address says after its hash: frame=, colour=, view=, deformation=.
function asked() {
  const wanted = new URLSearchParams(location.hash.slice(1)), frame = Number(wanted.get("frame") ?? NaN);
  for (const id of ["colour", "deformation", "thickness"]) {
    if ([...part(id).options].some((one) => one.value === wanted.get(id))) part(id).value = wanted.get(id);
  }
  return { frame, view: wanted.get("view") in VIEWS ? wanted.get("view") : null };
}

function begin() {
  fillLists();
  const { frame, view } = asked();
  setClock();
  part("refusal").hidden = Boolean(scene);
  part("options").hidden = !scene;
  if (innerWidth < 700 || innerHeight < 560) part("options").open = false;
  for (const run of runs) run.held = new Set(run.marks.filter(({ kind }) => ["clamp", "pin", "fix", "prescribe"].includes(kind)).flatMap(({ nodes }) => nodes));
  readInk();
  words();
  skin();
  tellDeformation();
  for (const skeleton of skeletons) {
    place(skeleton, skeleton.run.base.r, skeleton.run.base.turn);
    skeleton.still = skeleton.samples.map((_, q) => [...skeleton.poses.subarray(9 * q, 9 * q + 3)]);
  }
  for (const run of runs) atFrame(run.r, 3 * run.nodes, 0, run.r_);
  seen.home = middleOf("r_");
  part("follow").checked = room.own < 0.7 * room.reach; // a body that flies away would be small in its own picture
  const flat = ["z", "y", "x"].find((name) => room.span["xyz".indexOf(name)] < 1e-6 * room.reach);
  hands();
  lookFrom(view || flat || "iso");
  if (frame >= 0) go(frame);
  else if (dynamic && !calm && !page.live) play(true);
  else go(dynamic ? 0 : clock.last);
  render(0); // at once, not with the next frame: a page opened in the background is complete
  document.documentElement.dataset.state = "ready";
}

begin();
