// What of the page's state is drawn in space, and the flat things over it.

const NAMES_AT_MOST = 60, TRACES_AT_MOST = 24, DIRECTORS_AT_MOST = 300;
const VIEWS = { iso: [-0.9, 0.42], x: [0, 0], y: [-Math.PI / 2, 0], z: [-Math.PI / 2, Math.PI / 2] };
const FONT = "system-ui, 'DejaVu Sans', sans-serif";

const radius = runs.reduce((most, run) => run.rods.reduce((far, rod) => rod.outline.reduce((a, x) => Math.max(a, Math.abs(x)), far), most), 0);
const thicknesses = [1, 2, 5, 10, 20, 50, 100];
const fitting = radius > 0 ? thicknesses.find((k) => k * radius >= 0.004 * room.size) || 100 : 1;
const plainRadius = 0.008 * room.size / fitting;

const shownOnes = () => skeletons.filter(({ run }) => run.shown);

function skin() {
  if (scene) scene.setSkin(sweep(shownOnes(), Number(part("thickness").value), plainRadius));
}

function placeAll() {
  const factor = Number(part("deformation").value);
  for (const skeleton of skeletons) {
    const { run } = skeleton, u = clock.frame(run, seen.u);
    atFrame(run.r, 3 * run.nodes, u, run.r_);
    atFrame(run.turn, 6 * run.nodes, u, run.turn_);
    if (factor !== 1) exaggerate(run.r_, run.turn_, run.base, factor);
    place(skeleton, run.r_, run.turn_);
  }
}

function segments() {
  const lines = [], add = (from, to, colour, width) => lines.push(...from, ...to, ...colour, width * devicePixelRatio);
  for (const skeleton of shownOnes()) {
    const { run, poses, paints } = skeleton;
    for (const { firstSample, samples } of skeleton.rods) {
      for (let q = firstSample + 1; q < firstSample + samples; q++) {
        if (checked("ghost")) add(skeleton.still[q - 1], skeleton.still[q], seen.ink.ghost3, 1.6);
        if (!checked("sections")) add(spot(poses, 3 * (q - 1)), spot(poses, 3 * q), paints.subarray(3 * q, 3 * q + 3), 3);
      }
    }
    for (const { foot, tip } of jointEnds(run, run.r_, run.turn_).flat()) if (foot) add(foot, tip, seen.ink.ghost3, 1.6);
    if (checked("directors")) directors(skeleton, add);
    if (checked("traces")) traces(run, add);
  }
  return lines;
}

function directors(skeleton, add) {
  const length = Math.max(0.035 * room.size, 1.8 * radius * Number(part("thickness").value)), count = skeleton.knotNode.length;
  const colours = [seen.ink.x3, seen.ink.y3, seen.ink.z3], stride = Math.ceil(count / DIRECTORS_AT_MOST);
  for (let k = 0; k < count; k += stride) {
    const [from, d1, d2] = [0, 1, 2].map((m) => spot(skeleton.knots, 3 * k + m));
    const d3 = [d1[1] * d2[2] - d1[2] * d2[1], d1[2] * d2[0] - d1[0] * d2[2], d1[0] * d2[1] - d1[1] * d2[0]];
    [d1, d2, d3].forEach((d, i) => add(from, from.map((x, m) => x + length * d[m]), colours[i], 2));
  }
}

function traces(run, add) {
  const factor = Number(part("deformation").value), u = clock.frame(run, seen.u);
  for (const [, node] of run.names.slice(0, TRACES_AT_MOST)) {
    const base = spot(run.base.r, node), at = (k) => spot(run.r, node, 3 * run.nodes * k).map((x, m) => base[m] + factor * (x - base[m]));
    let from = at(0);
    for (let k = 1; k <= u; k++) {
      const to = at(k);
      add(from, to, seen.ink.trace3, 1.3);
      from = to;
    }
    add(from, spot(run.r_, node), seen.ink.trace3, 1.3);
  }
}

const middleOf = (key) => centroid(runs.length === 1 ? runs[0][key] : Float32Array.from(runs.flatMap((run) => [...run[key]])));

function eyeOn() {
  const drift = checked("follow") ? middleOf("r_").map((x, i) => x - seen.home[i]) : [0, 0, 0];
  const eye = { ...seen, target: seen.target.map((x, i) => x + drift[i]) };
  return look(eye, space.width, space.height, { ...room, reach: room.reach + Math.hypot(...drift) }, covered());
}

// The shares of width and height that the options and the legend take.
function covered() {
  const wide = part("options").open ? part("options").offsetWidth + 12 : 0, all = space.clientWidth;
  const high = part("scale").hidden ? 0 : part("scale").offsetHeight + 10;
  return [all > 760 ? wide / all : 0, Math.min(0.3, high / Math.max(1, space.clientHeight))];
}

function drawSpace() {
  const view = eyeOn();
  paint();
  if (scene) scene.draw({ poses, paints, lines: segments(), view, paper: seen.ink.paper3, sections: checked("sections") });
  const pen = overlay.getContext("2d"), scale = devicePixelRatio, width = overlay.width / scale, height = overlay.height / scale;
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = `600 13px ${FONT}`;
  pen.lineJoin = "round";
  if (!scene) return;
  const onto = (point) => project(view, point, width, height);
  for (const { run } of shownOnes()) {
    for (const node of run.loose) dot(pen, onto(spot(run.r_, node)), true);
    if (checked("marks")) {
      for (const mark of marksAt(run, run.r_, run.turn_)) drawMarks(pen, mark, onto, room.own, seen.ink);
      for (const ends of jointEnds(run, run.r_, run.turn_)) dot(pen, onto(ends[1].tip), false);
    }
    if (checked("names")) namesOf(pen, run, onto, width, height);
  }
  gizmo(pen, view, 44, height - 44);
}

// Nodes at one place, as those of a hinge, share a label.
function namesOf(pen, run, onto, width, height) {
  const labels = [];
  for (const [name, node] of run.names.slice(0, NAMES_AT_MOST)) {
    const at = onto(spot(run.r_, node));
    if (!at) continue;
    if (!run.held.has(node)) dot(pen, at, true);
    const shared = labels.find(({ at: [x, y] }) => Math.hypot(x - at[0], y - at[1]) < 2);
    if (shared) shared.names.push(name);
    else labels.push({ at, names: [name] });
  }
  for (const { at: [x, y], names } of labels) {
    const text = names.join(", "), wide = pen.measureText(text).width;
    const left = x + 9 + wide > width - 4 ? x - 9 - wide : x + 9;
    write(pen, text, left, Math.min(height - 4, Math.max(14, y - 7)), seen.ink.ink);
  }
}

// A full dot for a node, an open one for a joint.
function dot(pen, at, full) {
  if (!at) return;
  pen.fillStyle = full ? seen.ink.ink : seen.ink.paper;
  pen.strokeStyle = seen.ink.ink;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.arc(at[0], at[1], full ? 3 : 3.5, 0, 2 * Math.PI);
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
  const gravity = checked("marks") ? runs.find((run) => run.gravity) : null;
  const arms = ["x", "y", "z"].map((name, i) => ({ name, colour: seen.ink[name], right: view.right[i], up: view.up[i], back: view.back[i] }));
  if (gravity) {
    const along = (v) => v.reduce((sum, x, i) => sum + x * gravity.gravity[i], 0) / (Math.hypot(...gravity.gravity) || 1);
    arms.push({ name: "g", colour: seen.ink.load, right: along(view.right), up: along(view.up), back: along(view.back) });
  }
  for (const { name, colour, right, up } of arms.sort((a, b) => a.back - b.back)) {
    const end = [x + 26 * right, y - 26 * up];
    if (name === "g") {
      if (Math.hypot(right, up) > 0.2) drawArrow(pen, [x, y], end, 1, colour);
    } else {
      pen.strokeStyle = colour;
      pen.lineWidth = 2;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(...end);
      pen.stroke();
    }
    const aside = name === "g" ? [10 * up, 10 * right] : [0, 0]; // gravity often lies on an axis
    if (Math.hypot(right, up) > 0.2) write(pen, name, x + 35 * right - 4 + aside[0], y - 35 * up + 4 + aside[1], colour);
  }
}

// What is on the stage, with title, time and legend, as a picture to keep.
function photo() {
  drawSpace(); // a drawing buffer is gone after its frame
  const scale = devicePixelRatio, sheet = document.createElement("canvas"), pen = sheet.getContext("2d");
  [sheet.width, sheet.height] = [space.width, space.height];
  if (scene) pen.drawImage(space, 0, 0);
  pen.drawImage(overlay, 0, 0);
  pen.scale(scale, scale);
  pen.fillStyle = seen.ink.ink;
  pen.font = `600 16px ${FONT}`;
  pen.fillText(page.title, 16, 28);
  pen.font = `13px ${FONT}`;
  pen.fillText(`${clockName} = ${brief(timeShown())}`, 16, 48);
  runs.forEach((run, k) => {
    if (runs.length === 1) return;
    pen.fillStyle = PALETTE[k % PALETTE.length];
    pen.fillText(`━ ${run.label}`, 16, 68 + 18 * k);
  });
  if (!part("scale").hidden) {
    const left = sheet.width / scale - 236, top = 16, ramp = pen.createLinearGradient(left, 0, left + 220, 0);
    seen.stops.forEach((stop, k) => ramp.addColorStop(k / (seen.stops.length - 1), cssOf(stop)));
    pen.fillStyle = seen.ink.ink;
    pen.fillText(seen.caption, left, top + 12);
    pen.fillStyle = ramp;
    pen.fillRect(left, top + 20, 220, 10);
    pen.fillStyle = seen.ink.soft;
    pen.fillText(brief(seen.low), left, top + 46);
    pen.textAlign = "right";
    pen.fillText(brief(seen.high), left + 220, top + 46);
  }
  return sheet;
}

function savePhoto() {
  photo().toBlob((blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${page.title.replace(/[^\p{L}\p{N}]+/gu, "-") || "run"}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }, "image/png");
}

const timeShown = () => (clock.rising || runs.length === 1 ? clock.time(seen.u) : seen.u);
