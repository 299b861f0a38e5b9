// Supports, loads, springs and masses, drawn flat over the picture: they keep their size on the screen.

const ARROW = 0.28; // of the model's reach about its centre: the longest arrow of a load

// The places and directions of a run's marks at this moment.
function marksAt(run, r, turn) {
  const largest = {}; // of each kind: forces and moments cannot be compared
  for (const { kind, vector } of run.marks) largest[kind] = Math.max(largest[kind] || 0, Math.hypot(...vector));
  return run.marks.map((mark) => {
    const length = Math.hypot(...mark.vector), share = largest[mark.kind] ? length / largest[mark.kind] : 0;
    const scaled = mark.vector.map((x) => x / (length || 1) * (0.45 + 0.55 * share));
    const ways = length ? mark.nodes.map((node) => (mark.follower ? carried(turn, node, scaled) : scaled)) : null;
    return { ...mark, ways, at: mark.nodes.map((node) => spot(r, node)) };
  });
}

function drawMarks(pen, mark, onto, size, ink) {
  const [here] = mark.at, flat = here && onto(here);
  const arrow = (k, heads) => {
    const tip = mark.at[k], tail = onto(tip.map((x, m) => x - ARROW * size * mark.ways[k][m])), end = onto(tip);
    if (tail && end) drawArrow(pen, tail, end, heads, ink.load);
  };
  if (mark.kind === "distributed" && mark.ways) {
    const stride = Math.ceil(mark.at.length / 9);
    mark.at.forEach((_, k) => { if (k % stride === 0 || k === mark.at.length - 1) arrow(k, 1); });
  } else if (mark.kind === "spring") {
    const ends = [...mark.at, ...(mark.place ? [mark.place] : [])].map(onto);
    if (ends.length === 2 && ends[0] && ends[1]) drawSpring(pen, ...ends, mark.text === "cable", ink.soft);
  } else if (!flat) return;
  else if (["force", "moment", "pressure", "distributed"].includes(mark.kind)) {
    if (mark.ways) arrow(0, mark.kind === "moment" ? 2 : 1);
    else drawSign(pen, flat, mark.text, ink.load);
  } else if (mark.kind === "mass") drawShape(pen, flat, "mass", ink.ink, ink.paper);
  else drawShape(pen, flat, mark.kind, ink.support, ink.paper);
}

function drawArrow(pen, tail, tip, heads, colour) {
  const length = Math.hypot(tip[0] - tail[0], tip[1] - tail[1]);
  pen.strokeStyle = pen.fillStyle = colour;
  pen.lineWidth = 2;
  if (length < 5) { // it points into the screen
    pen.beginPath();
    pen.arc(...tip, 5, 0, 2 * Math.PI);
    pen.stroke();
    return;
  }
  const x = (tip[0] - tail[0]) / length, y = (tip[1] - tail[1]) / length, head = Math.min(10, 0.6 * length);
  pen.beginPath();
  pen.moveTo(...tail);
  pen.lineTo(tip[0] - head * x, tip[1] - head * y);
  pen.stroke();
  for (let k = 0; k < heads; k++) {
    const [px, py] = [tip[0] - 0.8 * k * head * x, tip[1] - 0.8 * k * head * y];
    pen.beginPath();
    pen.moveTo(px, py);
    pen.lineTo(px - head * x - 0.42 * head * y, py - head * y + 0.42 * head * x);
    pen.lineTo(px - head * x + 0.42 * head * y, py - head * y - 0.42 * head * x);
    pen.fill();
  }
}

// A load whose value is a function of its own has no direction to draw.
function drawSign(pen, [x, y], text, colour) {
  pen.strokeStyle = colour;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.arc(x, y, 7, 0, 2 * Math.PI);
  pen.stroke();
  write(pen, text, x + 10, y + 15, colour);
}

function drawSpring(pen, [x, y], [u, v], slack, colour) {
  const length = Math.hypot(u - x, v - y) || 1, a = (u - x) / length, b = (v - y) / length, turns = slack ? 0 : Math.max(6, Math.min(24, Math.round(length / 14)));
  pen.strokeStyle = colour;
  pen.lineWidth = 1.6;
  pen.beginPath();
  const along = (share, side) => pen.lineTo(x + share * length * a - side * b, y + share * length * b + side * a);
  along(0, 0);
  if (turns) along(0.2, 0);
  for (let k = 0; k < turns; k++) along(0.2 + 0.6 * (k + 0.5) / turns, k % 2 ? 5 : -5);
  if (turns) along(0.8, 0);
  along(1, 0);
  pen.stroke();
}

// Clamp: a full square. Pin: a full triangle under the node. Single components: an open triangle. Prescribed: a diamond.
function drawShape(pen, [x, y], kind, colour, paper) {
  const shapes = {
    clamp: [[-6, -6], [6, -6], [6, 6], [-6, 6]], prescribe: [[0, -8], [8, 0], [0, 8], [-8, 0]],
    pin: [[0, 0], [8, 13], [-8, 13]], fix: [[0, 0], [8, 13], [-8, 13]],
  };
  pen.fillStyle = kind === "fix" ? paper : colour;
  pen.strokeStyle = kind === "fix" ? colour : paper;
  pen.lineWidth = kind === "fix" ? 2 : 1;
  pen.beginPath();
  if (kind === "mass") pen.arc(x, y, 6, 0, 2 * Math.PI);
  else shapes[kind].forEach(([u, v]) => pen.lineTo(x + u, y + v));
  pen.closePath();
  pen.fill();
  pen.stroke();
}
