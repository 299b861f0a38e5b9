// The state of the page, and what of it is drawn in space.

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
  const hints = [`${run.frames < run.instants ? run.frames + " of" : "all"} ${run.instants} saved instants are shown`];
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

function stop(frame) {
  play(false);
  go(frame);
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
  for (const { foot, tip } of jointEnds(run, r, turn).flat()) if (foot) add(foot, tip, seen.ink.ghost3, 1.6);
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
  const eye = { ...seen, target: seen.target.map((x, i) => x + drift[i]) };
  return look(eye, space.width, space.height, { ...room, reach: room.reach + Math.hypot(...drift) });
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
  if (scene) {
    for (const node of run.loose) dot(pen, project(view, [r[3 * node], r[3 * node + 1], r[3 * node + 2]], width, height), true);
  }
  if (checked("names") && scene) {
    for (const [name, node] of run.names.slice(0, NAMES_AT_MOST)) {
      const spot = project(view, [r[3 * node], r[3 * node + 1], r[3 * node + 2]], width, height);
      if (!spot) continue;
      dot(pen, spot, true);
      write(pen, name, spot[0] + 8, spot[1] - 6, seen.ink.ink);
    }
  }
  if (scene) for (const ends of jointEnds(run, r, turn)) dot(pen, project(view, ends[1].tip, width, height), false);
  if (scene) gizmo(pen, view, 44, height - 44);
}

// A full dot for a node, an open one for a joint.
function dot(pen, spot, full) {
  if (!spot) return;
  pen.fillStyle = full ? seen.ink.ink : seen.ink.paper;
  pen.strokeStyle = seen.ink.ink;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.arc(spot[0], spot[1], full ? 3 : 3.5, 0, 2 * Math.PI);
  pen.fill();
  if (!full) pen.stroke();
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
