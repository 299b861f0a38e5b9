// The page: what is shown, what the hand does, and the energies below.

const run = readRun(document.getElementById("data").textContent);
const skeleton = makeSkeleton(run), room = extent(run);
const part = (id) => document.getElementById(id);
const space = part("space"), overlay = part("overlay"), chart = part("energy"), slider = part("slider");
const last = run.frames - 1, dynamic = run.kind === "dynamic", clock = dynamic ? "t" : "load factor";
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
const NAMES_AT_MOST = 60, TRACES_AT_MOST = 24, DIRECTORS_AT_MOST = 300;
const COMPONENTS = ["shear 1", "shear 2", "axial", "bending 1", "bending 2", "torsion"];
const PALETTE = ["#4f87b8", "#d2601a", "#2b8a4b", "#a02c8c", "#b8860b", "#00808a", "#b3372e", "#6b7480"];
const VIEWS = { iso: [-0.9, 0.42], x: [0, 0], y: [-Math.PI / 2, 0], z: [-Math.PI / 2, Math.PI / 2] };

const r = new Float32Array(3 * run.nodes), turn = new Float32Array(6 * run.nodes), values = new Float32Array(6 * run.stations);
const paints = new Float32Array(3 * skeleton.count);
const seen = { u: 0, playing: false, hold: 0, yaw: 0, pitch: 0, distance: 1, target: [0, 0, 0], ink: {} };
const scene = makeScene(space, skeleton.count);
let due = false, before = 0;

// ---- numbers and words

const brief = (x) => (x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(3) : String(+x.toPrecision(5)));
const colourOf = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
const checked = (id) => part(id).checked;
const option = (select, value, text) => select.add(new Option(text, value));

function readInk() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "ink", "soft", "line", "accent", "rod", "ghost", "trace", "middle", "kinetic", "stored", "x", "y", "z"]) {
    seen.ink[name] = style.getPropertyValue("--" + name).trim();
  }
  for (const [name, text] of Object.entries(seen.ink)) seen.ink[name + "3"] = colourOf(text);
  const { z, middle, x } = seen.ink;
  part("bar").style.background = `linear-gradient(to right, ${z}, ${middle}, ${x})`;
}

function words() {
  part("title").textContent = run.title;
  part("about").textContent = run.about.join(" · ");
  part("status").textContent = run.status;
  part("status").classList.toggle("bad", !run.success);
  part("verdict").textContent = "audit " + run.verdict;
  part("verdict").classList.add(run.passed ? "good" : "bad");
  const remarks = part("remarks");
  remarks.hidden = run.notes.length === 0;
  remarks.querySelector("summary").textContent = run.notes.length === 1 ? "1 note" : `${run.notes.length} notes`;
  for (const note of run.notes) {
    const item = document.createElement("li");
    item.textContent = note;
    remarks.querySelector("ul").append(item);
  }
  const hints = [run.frames < run.instants ? `${run.frames} of ${run.instants} saved instants are shown` : `all ${run.instants} saved instants are shown`];
  if (run.rods.some((rod) => rod.outline.length < 6)) hints.push("sections without an outline are drawn round");
  hints.push("space plays, arrows step, drag turns, wheel zooms, shift-drag moves, F fits");
  part("hint").textContent = hints.join(" · ");
}

// ---- time

const span = run.t[last] - run.t[0];
const realTime = dynamic && span >= 2 && span <= 60;
const pace = realTime ? 1 : Math.max(span, 1e-30) / 10; // model time per second at speed 1

function step(seconds) {
  const k = Math.min(Math.floor(seen.u), last - 1), gap = run.t[k + 1] - run.t[k];
  const ahead = dynamic && gap > 0 ? seconds * pace / gap : seconds * last / 8;
  seen.u += ahead * Number(part("speed").value);
  if (seen.u < last) return;
  seen.u = last;
  seen.hold += seconds;
  if (seen.hold > 1) [seen.u, seen.hold] = [0, 0];
}

function go(frame) {
  seen.u = Math.min(last, Math.max(0, Math.round(frame)));
  seen.hold = 0;
  redraw();
}

function play(on) {
  seen.playing = on && last > 0;
  if (!seen.playing) seen.u = Math.round(seen.u); // rest on an instant that was computed
  if (seen.playing && seen.u >= last) seen.u = 0;
  part("play").textContent = seen.playing ? "❚❚" : "▶";
  part("play").setAttribute("aria-label", seen.playing ? "pause" : "play");
  before = 0;
  redraw();
}

function timeAt(u) {
  const k = Math.min(Math.floor(u), last), next = Math.min(k + 1, last);
  return run.t[k] + (u - k) * (run.t[next] - run.t[k]);
}

// ---- colours

function paint() {
  const [field, component] = part("colour").value.split(":"), plain = seen.ink.rod3;
  if (field === "plain" || field === "rod") {
    for (const { index, firstSample, samples } of skeleton.rods) {
      const colour = field === "rod" ? colourOf(PALETTE[index % PALETTE.length]) : plain;
      for (let q = firstSample; q < firstSample + samples; q++) paints.set(colour, 3 * q);
    }
    return;
  }
  atFrame(run[field], 6 * run.stations, seen.u, values);
  const { x3, z3, middle3 } = seen.ink, most = seen.most || 1;
  skeleton.samples.forEach((sample, q) => {
    const one = values[6 * sample.station + +component], other = values[6 * sample.next + +component];
    const value = ((1 - sample.weight) * one + sample.weight * other) / most, end = value < 0 ? z3 : x3, a = Math.min(1, Math.abs(value));
    for (let m = 0; m < 3; m++) paints[3 * q + m] = middle3[m] + a * (end[m] - middle3[m]);
  });
}

function chooseColour() {
  const [field, component] = part("colour").value.split(":");
  part("scale").hidden = component === undefined;
  if (component === undefined) return;
  seen.most = 0;
  for (let i = +component; i < run[field].length; i += 6) seen.most = Math.max(seen.most, Math.abs(run[field][i]));
  part("low").textContent = brief(-seen.most);
  part("high").textContent = brief(seen.most);
}

// ---- the picture in space

const radius = run.rods.reduce((most, rod) => rod.outline.reduce((a, x) => Math.max(a, Math.abs(x)), most), 0);
const thicknesses = [1, 2, 5, 10, 20, 50, 100];
const fitting = radius > 0 ? thicknesses.find((k) => k * radius >= 0.004 * room.size) || 100 : 1;
const plainRadius = 0.008 * room.size / fitting;

function skin() {
  if (scene) scene.setSkin(sweep(skeleton, Number(part("thickness").value), plainRadius));
}

function segments() {
  const lines = [], add = (from, to, colour, width) => lines.push(...from, ...to, ...colour, width * devicePixelRatio);
  const at = (array, k, from = 0) => [array[from + 3 * k], array[from + 3 * k + 1], array[from + 3 * k + 2]];
  for (const { firstSample, samples } of skeleton.rods) {
    for (let q = firstSample + 1; q < firstSample + samples; q++) {
      if (checked("ghost")) add(seen.still[q - 1], seen.still[q], seen.ink.ghost3, 1.6);
      if (!checked("sections")) add(at(skeleton.poses, 3 * (q - 1)), at(skeleton.poses, 3 * q), paints.subarray(3 * q, 3 * q + 3), 3);
    }
  }
  if (checked("directors")) {
    const length = Math.max(0.035 * room.size, 1.8 * radius * Number(part("thickness").value)), count = skeleton.knotNode.length;
    const colours = [seen.ink.x3, seen.ink.y3, seen.ink.z3], stride = Math.ceil(count / DIRECTORS_AT_MOST);
    for (let k = 0; k < count; k += stride) {
      const from = at(skeleton.knots, 3 * k), d1 = at(skeleton.knots, 3 * k + 1), d2 = at(skeleton.knots, 3 * k + 2);
      const d3 = [d1[1] * d2[2] - d1[2] * d2[1], d1[2] * d2[0] - d1[0] * d2[2], d1[0] * d2[1] - d1[1] * d2[0]];
      [d1, d2, d3].forEach((d, i) => add(from, from.map((x, m) => x + length * d[m]), colours[i], 2));
    }
  }
  if (checked("traces")) {
    for (const [, node] of run.names.slice(0, TRACES_AT_MOST)) {
      let from = at(run.r, node);
      for (let k = 1; k <= seen.u; k++) {
        const to = at(run.r, node, 3 * run.nodes * k);
        add(from, to, seen.ink.trace3, 1.3);
        from = to;
      }
      add(from, at(r, node), seen.ink.trace3, 1.3);
    }
  }
  return lines;
}

function eyeOn() {
  const drift = checked("follow") ? centroid(r).map((x, i) => x - seen.home[i]) : [0, 0, 0];
  return look({ ...seen, target: seen.target.map((x, i) => x + drift[i]) }, space.width, space.height, { ...room, reach: room.reach + Math.hypot(...drift) });
}

function drawSpace() {
  const view = eyeOn();
  paint();
  if (scene) scene.draw({ poses: skeleton.poses, paints, lines: segments(), view, paper: seen.ink.paper3, sections: checked("sections") });
  const pen = overlay.getContext("2d"), scale = devicePixelRatio, width = overlay.width / scale, height = overlay.height / scale;
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "600 13px system-ui, 'DejaVu Sans', sans-serif";
  pen.lineJoin = "round";
  if (checked("names") && scene) {
    for (const [name, node] of run.names.slice(0, NAMES_AT_MOST)) {
      const spot = project(view, [r[3 * node], r[3 * node + 1], r[3 * node + 2]], width, height);
      if (!spot) continue;
      pen.fillStyle = seen.ink.ink;
      pen.beginPath();
      pen.arc(spot[0], spot[1], 3, 0, 2 * Math.PI);
      pen.fill();
      write(pen, name, spot[0] + 8, spot[1] - 6, seen.ink.ink);
    }
  }
  if (scene) gizmo(pen, view, 44, height - 44);
}

function write(pen, text, x, y, colour) {
  pen.strokeStyle = seen.ink.paper;
  pen.lineWidth = 4;
  pen.strokeText(text, x, y);
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
}

function gizmo(pen, view, x, y) {
  const arms = ["x", "y", "z"].map((name, i) => ({ name, right: view.right[i], up: view.up[i], back: view.back[i] }));
  for (const { name, right, up } of arms.sort((a, b) => a.back - b.back)) {
    pen.strokeStyle = seen.ink[name];
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + 26 * right, y - 26 * up);
    pen.stroke();
    if (Math.hypot(right, up) > 0.2) write(pen, name, x + 35 * right - 4, y - 35 * up + 4, seen.ink[name]);
  }
}

// ---- the energies

const rising = run.t.every((t, k) => k === 0 || t > run.t[k - 1]); // along an arc the load factor may turn back
const series = dynamic
  ? [["kinetic", run.kinetic, "kinetic", 1.4], ["stored", run.stored, "stored", 1.4], ["total", run.total, "ink", 2.2]]
  : [["stored", run.stored, "stored", 2], ["work done on it", run.work, "soft", 1.4, [6, 5]]];
const frame = { left: 56, right: 12, top: 6, bottom: 18 };

function drawChart() {
  const scale = devicePixelRatio, width = chart.width / scale, height = chart.height / scale, pen = chart.getContext("2d");
  const all = series.flatMap(([, array]) => [Math.min(...array), Math.max(...array)]);
  const low = Math.min(0, ...all), high = Math.max(...all) > low ? Math.max(...all) : low + 1;
  const abscissa = (k) => (last === 0 ? 0 : rising ? (run.t[k] - run.t[0]) / span : k / last);
  const x = (k) => frame.left + abscissa(k) * (width - frame.left - frame.right);
  const y = (v) => height - frame.bottom - (v - low) / (high - low) * (height - frame.top - frame.bottom);
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  pen.fillStyle = seen.ink.soft;
  pen.lineWidth = 1;
  pen.strokeStyle = seen.ink.line;
  pen.textAlign = "right";
  for (const v of [low, high]) {
    pen.strokeRect(frame.left, y(v), width - frame.left - frame.right, 0);
    pen.fillText(brief(v), frame.left - 6, y(v) + (v === high ? 8 : 3));
  }
  pen.fillText(rising ? brief(run.t[last]) : `instant ${last}`, width - frame.right, height - 4);
  pen.textAlign = "left";
  pen.fillText(rising ? brief(run.t[0]) : "0", frame.left, height - 4);
  for (const [, array, colour, thick, dash] of series) {
    pen.setLineDash(dash || []);
    pen.strokeStyle = seen.ink[colour];
    pen.lineWidth = thick;
    pen.beginPath();
    array.forEach((v, k) => pen.lineTo(x(k), y(v)));
    pen.stroke();
  }
  pen.setLineDash([]);
  const k = Math.floor(seen.u), here = x(k) + (seen.u - k) * (x(Math.min(k + 1, last)) - x(k));
  pen.strokeStyle = seen.ink.accent;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(here, frame.top - 4);
  pen.lineTo(here, height - frame.bottom);
  pen.stroke();
  seen.pick = (pixel) => {
    const share = Math.min(1, Math.max(0, (pixel - frame.left) / (width - frame.left - frame.right)));
    if (!rising) return share * last;
    const t = run.t[0] + share * span, k = run.t.findIndex((value) => value >= t);
    return k > 0 && t - run.t[k - 1] < run.t[k] - t ? k - 1 : Math.max(0, k);
  };
}

function drawNumbers() {
  const k = Math.round(seen.u);
  part("legend").replaceChildren(
    ...series.map(([name, array, colour]) => {
      const item = document.createElement("span");
      item.textContent = `━ ${name} ${brief(array[k])}`;
      item.style.color = seen.ink[colour];
      return item;
    }),
  );
  part("clock").textContent = `${clock} = ${brief(timeAt(seen.u))}`;
  slider.value = k;
}

// ---- the loop, and the hand

function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(render);
}

function fitCanvas(canvas) {
  const box = canvas.getBoundingClientRect(), width = Math.round(box.width * devicePixelRatio), height = Math.round(box.height * devicePixelRatio);
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
    play(false);
    go(seen.pick(event.clientX - chart.getBoundingClientRect().left));
  };
  chart.addEventListener("pointerdown", (event) => { chart.setPointerCapture(event.pointerId); seek(event); });
  chart.addEventListener("pointermove", seek);
  slider.addEventListener("input", () => { const k = Number(slider.value); play(false); go(k); });
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
      " ": () => play(!seen.playing), ArrowRight: () => { play(false); go(seen.u + jump); }, ArrowLeft: () => { play(false); go(seen.u - jump); },
      Home: () => { play(false); go(0); }, End: () => { play(false); go(last); },
      d: () => part("directors").click(), f: () => lookFrom("fit"),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (act) { event.preventDefault(); act(); }
  });
}

function begin() {
  option(part("colour"), "plain", "plain");
  if (run.rods.length > 1) option(part("colour"), "rod", "by rod");
  for (const [field, title] of [["strain", "strain"], ["force", "section force"]]) {
    COMPONENTS.forEach((name, i) => option(part("colour"), `${field}:${i}`, `${title}: ${name}`));
  }
  for (const k of thicknesses) option(part("thickness"), k, k === 1 ? "true" : `${k} times`);
  part("thickness").value = fitting;
  for (const [value, text] of [[0.1, "× 0.1"], [0.25, "× 0.25"], [0.5, "× 0.5"], [1, realTime ? "real time" : "× 1"], [2, "× 2"], [5, "× 5"]]) option(part("speed"), value, text);
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
  document.documentElement.dataset.state = "ready";
}

begin();
