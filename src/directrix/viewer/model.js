"use strict";
// The runs as arrays, and the kinematics of a picture: what lies between nodes and between saved instants.

function floats(code) {
  const bytes = Uint8Array.from(atob(code), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

function readPage(text) {
  const page = JSON.parse(text);
  page.runs.forEach(readRun);
  return page;
}

function readRun(run) {
  for (const part of [run, ...run.rods]) {
    for (const key of Object.keys(part.arrays)) part[key] = floats(part.arrays[key]);
    delete part.arrays;
  }
  run.last = run.frames - 1;
  run.total = run.kinetic.map((kinetic, k) => kinetic + run.stored[k]);
  run.rising = run.t.every((t, k) => k === 0 || t > run.t[k - 1]); // along an arc the load factor may turn back
  return run;
}

// The common clock: ticks that the slider counts, the time at a place u between them, and the frame of each run there.
// A run that ended earlier stays at its end. Where load factors turn back the saved instants are counted instead.
function makeClock(runs) {
  const rising = runs.every((run) => run.rising), longest = runs.reduce((a, b) => (b.last > a.last ? b : a));
  const all = rising ? Float64Array.from(runs.flatMap((run) => [...run.t])).sort() : longest.t;
  const near = 1e-6 * Math.abs(all[all.length - 1] - all[0]);
  const ticks = rising ? all.filter((t, k) => k === 0 || k === all.length - 1 || t > all[k - 1] + near) : all;
  const last = ticks.length - 1;
  const time = (u) => {
    const k = Math.min(Math.floor(u), last), next = Math.min(k + 1, last);
    return ticks[k] + (u - k) * (ticks[next] - ticks[k]);
  };
  const frame = (run, u) => {
    if (!rising) return last === 0 ? run.last : u / last * run.last;
    if (runs.length === 1 && run.last === last) return u;
    const t = time(u);
    let low = 0, high = run.last;
    if (t >= run.t[high]) return high;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (run.t[middle] <= t) low = middle;
      else high = middle;
    }
    return high === low ? low : low + Math.max(0, (t - run.t[low]) / (run.t[high] - run.t[low]));
  };
  return { rising, ticks, last, span: ticks[last] - ticks[0], time, frame };
}

// Lagrange polynomials of equispaced nodes, as the elements have them; ξ in [−1, 1].
function lagrange(order, xi) {
  const place = (a) => -1 + 2 * a / order;
  return Array.from({ length: order + 1 }, (_, a) => {
    let value = 1;
    for (let b = 0; b <= order; b++) if (b !== a) value *= (xi - place(b)) / (place(a) - place(b));
    return value;
  });
}

const elementsOf = (run) => run.rods.reduce((sum, rod) => sum + (rod.nodes.length - 1) / rod.order, 0);

// Knots are the nodes as each rod sees them (a corner node is one node and two knots); samples lie on the
// rods' axes, finer than the nodes, and know their knots with weights and their two neighbouring stations.
function makeSkeleton(run, elements = elementsOf(run)) {
  const finest = Math.max(1, Math.floor(5000 / elements));
  const knotNode = [], knotDirectors = [], rods = [], samples = [];
  run.rods.forEach((rod, index) => {
    const cuts = Math.min(finest, rod.order === 1 ? 4 : 10), firstKnot = knotNode.length, firstSample = samples.length;
    rod.nodes.forEach((node, a) => {
      knotNode.push(node);
      knotDirectors.push(...rod.directors.subarray(6 * a, 6 * a + 6));
    });
    const last = (rod.nodes.length - 1) / rod.order;
    for (let e = 0; e < last; e++) {
      for (let c = 0; c < cuts + (e === last - 1 ? 1 : 0); c++) {
        const shape = lagrange(rod.order, -1 + 2 * c / cuts), knots = shape.map((_, a) => firstKnot + e * rod.order + a);
        const s = shape.reduce((sum, value, a) => sum + value * rod.s[e * rod.order + a], 0);
        samples.push({ knots, shape, ...between(rod, s) });
      }
    }
    rods.push({ rod, index, firstSample, samples: samples.length - firstSample });
  });
  return {
    rods, samples, knotNode, knotDirectors, count: samples.length,
    knots: new Float32Array(9 * knotNode.length), poses: new Float32Array(9 * samples.length),
  };
}

function between(rod, s) {
  let k = 0;
  while (k < rod.stations.length - 2 && rod.stations[k + 1] < s) k++;
  const next = Math.min(k + 1, rod.stations.length - 1), gap = rod.stations[next] - rod.stations[k];
  const weight = gap > 0 ? Math.min(1, Math.max(0, (s - rod.stations[k]) / gap)) : 0;
  return { station: rod.first + k, next: rod.first + next, weight };
}

// Values of all nodes (width numbers each) at frame u; between two saved instants linearly, for smooth playing.
function atFrame(array, width, u, out) {
  const k = Math.min(Math.floor(u), array.length / width - 1), a = u - k, from = k * width;
  const to = Math.min(from + width, array.length - width);
  for (let i = 0; i < width; i++) out[i] = (1 - a) * array[from + i] + a * array[to + i];
  return out;
}

// Displacements and turns from a base, multiplied: r += (k − 1)(r − base), and the two columns of each rotation likewise.
function exaggerate(r, turn, base, factor) {
  for (let i = 0; i < r.length; i++) r[i] = base.r[i] + factor * (r[i] - base.r[i]);
  for (let i = 0; i < turn.length; i += 6) {
    for (let m = 0; m < 6; m++) turn[i + m] = base.turn[i + m] + factor * (turn[i + m] - base.turn[i + m]);
    const one = turn.subarray(i, i + 3), other = turn.subarray(i + 3, i + 6), length = Math.hypot(...one) || 1;
    for (let m = 0; m < 3; m++) one[m] /= length;
    const along = one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
    for (let m = 0; m < 3; m++) other[m] -= along * one[m];
    const rest = Math.hypot(...other) || 1;
    for (let m = 0; m < 3; m++) other[m] /= rest;
  }
}

const unturned = (nodes) => Float32Array.from({ length: 6 * nodes }, (_, i) => (i % 6 === 0 || i % 6 === 4 ? 1 : 0));

// Fills skeleton.knots and skeleton.poses with (r, d1, d2) from node positions (n, 3) and the first two
// columns of the node rotations (n, 2, 3).
function place(skeleton, r, turn) {
  const { knots, poses, knotNode, knotDirectors } = skeleton;
  knotNode.forEach((node, k) => {
    const [a, b, c, d, e, f] = turn.subarray(6 * node, 6 * node + 6);
    const g = b * f - c * e, h = c * d - a * f, i = a * e - b * d; // third column
    for (let m = 0; m < 3; m++) knots[9 * k + m] = r[3 * node + m];
    for (let m = 0; m < 2; m++) {
      const x = knotDirectors[6 * k + 3 * m], y = knotDirectors[6 * k + 3 * m + 1], z = knotDirectors[6 * k + 3 * m + 2];
      knots[9 * k + 3 + 3 * m] = a * x + d * y + g * z;
      knots[9 * k + 4 + 3 * m] = b * x + e * y + h * z;
      knots[9 * k + 5 + 3 * m] = c * x + f * y + i * z;
    }
  });
  skeleton.samples.forEach((sample, q) => {
    for (let m = 0; m < 9; m++) {
      let sum = 0;
      for (let a = 0; a < sample.knots.length; a++) sum += sample.shape[a] * knots[9 * sample.knots[a] + m];
      poses[9 * q + m] = sum;
    }
    for (const m of [3, 6]) {
      const length = Math.hypot(poses[9 * q + m], poses[9 * q + m + 1], poses[9 * q + m + 2]) || 1;
      for (let j = 0; j < 3; j++) poses[9 * q + m + j] /= length; // sections keep their size in the picture
    }
  });
}

// A vector that a node carries along, from the two columns of its rotation.
function carried(turn, node, [x, y, z]) {
  const [a, b, c, d, e, f] = turn.subarray(6 * node, 6 * node + 6);
  return [a * x + d * y + (b * f - c * e) * z, b * x + e * y + (c * d - a * f) * z, c * x + f * y + (a * e - b * d) * z];
}

const spot = (array, k, from = 0) => [array[from + 3 * k], array[from + 3 * k + 1], array[from + 3 * k + 2]];

// Of every joint's base and of what it moves: the node and the point it carries to the joint; the ground has no node.
function jointEnds(run, r, turn) {
  return run.joints.map((pair, j) => pair.map((node, end) => {
    const arm = [...run.arms.subarray(6 * j + 3 * end, 6 * j + 3 * end + 3)];
    if (node < 0) return { foot: null, tip: arm };
    const foot = spot(r, node), turned = carried(turn, node, arm);
    return { foot, tip: foot.map((p, m) => p + turned[m]) };
  }));
}

// Box of everything that is ever shown; `own` is the models' reach about their own centre, wherever that goes.
function extent(runs) {
  const pins = runs.map((run) => new Float32Array(run.joints.flatMap(([base], j) => (base < 0 ? [...run.arms.subarray(6 * j, 6 * j + 3)] : []))));
  const references = runs.map((run) => run.r0), all = box([...references, ...runs.map((run) => run.r), ...pins]), still = box([...references, ...pins]);
  let own = 0;
  for (const run of runs) {
    const width = 3 * run.nodes;
    for (let k = 0; k < run.frames; k++) {
      const r = run.r.subarray(k * width, (k + 1) * width), c = centroid(r);
      for (let i = 0; i < width; i += 3) own = Math.max(own, Math.hypot(r[i] - c[0], r[i + 1] - c[1], r[i + 2] - c[2]));
    }
  }
  return { ...all, reach: 0.5 * Math.hypot(...all.span) || 1, own: own || 1, size: Math.hypot(...still.span) || 1 };
}

function box(arrays) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const array of arrays) {
    for (let i = 0; i < array.length; i++) {
      low[i % 3] = Math.min(low[i % 3], array[i]);
      high[i % 3] = Math.max(high[i % 3], array[i]);
    }
  }
  return { low, high, span: low.map((x, i) => high[i] - x), centre: low.map((x, i) => 0.5 * (x + high[i])) };
}

function centroid(r) {
  const sum = [0, 0, 0];
  for (let i = 0; i < r.length; i++) sum[i % 3] += 3 * r[i] / r.length;
  return sum;
}
