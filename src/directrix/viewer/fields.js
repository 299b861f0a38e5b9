// What rods can be coloured by: fields on stress stations or on nodes, their range over all times, and their unit.

const part6 = (array, of, i, name, unit) => ({ group: of, array, name, unit, width: 6, signed: true, value: (a, k) => a[6 * k + i] });
const size6 = (array, of, i, name, unit) => ({ group: of, array, name, unit, width: 6, value: (a, k) => Math.hypot(a[6 * k + i], a[6 * k + i + 1]) });

const FIELDS = {
  axial: part6("force", "section force", 2, "axial force N3", "force"),
  shear: size6("force", "section force", 0, "shear force |N1, N2|", "force"),
  shear1: part6("force", "section force", 0, "shear force N1", "force"),
  shear2: part6("force", "section force", 1, "shear force N2", "force"),
  bending: size6("force", "section force", 3, "bending moment |M1, M2|", "moment"),
  bending1: part6("force", "section force", 3, "bending moment M1", "moment"),
  bending2: part6("force", "section force", 4, "bending moment M2", "moment"),
  torsion: part6("force", "section force", 5, "torsion M3", "moment"),
  stretch: part6("strain", "strain", 2, "axial strain Γ3", ""),
  slide1: part6("strain", "strain", 0, "shear strain Γ1", ""),
  slide2: part6("strain", "strain", 1, "shear strain Γ2", ""),
  curvature: size6("strain", "strain", 3, "curvature |Ω1, Ω2|", "per_length"),
  curvature1: part6("strain", "strain", 3, "curvature Ω1", "per_length"),
  curvature2: part6("strain", "strain", 4, "curvature Ω2", "per_length"),
  twist: part6("strain", "strain", 5, "twist Ω3", "per_length"),
  density: { group: "energy", array: "density", name: "strain energy density", unit: "energy_per_length", width: 1, value: (a, k) => a[k] },
  speed: { group: "motion", array: "speed", name: "speed", unit: "speed", width: 1, nodal: true, value: (a, k) => a[k] },
  displacement: {
    group: "motion", array: "r", name: "displacement", unit: "length", width: 3, nodal: true,
    value: (a, k, run) => {
      const i = 3 * k, j = 3 * (k % run.nodes);
      return Math.hypot(a[i] - run.r0[j], a[i + 1] - run.r0[j + 1], a[i + 2] - run.r0[j + 2]);
    },
  },
};

const places = (run, field) => (field.nodal ? run.nodes : run.stations);
const has = (run, field) => places(run, field) > 0 && run[field.array].length === run.frames * places(run, field) * field.width;

// Least and largest value over all runs and all of their instants.
function rangeOf(runs, field) {
  let low = Infinity, high = -Infinity;
  for (const run of runs) {
    if (!has(run, field)) continue;
    const array = run[field.array], count = array.length / field.width;
    for (let k = 0; k < count; k++) {
      const value = field.value(array, k, run);
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? { low, high } : { low: 0, high: 0 };
}

// The field at the samples of a run's rods, at frame u.
function fieldAt(run, skeleton, field, u, buffer, out) {
  const count = places(run, field), now = atFrame(run[field.array], field.width * count, u, buffer);
  skeleton.samples.forEach((sample, q) => {
    if (field.nodal) {
      out[q] = sample.shape.reduce((sum, shape, a) => sum + shape * field.value(now, skeleton.knotNode[sample.knots[a]], run), 0);
    } else {
      out[q] = (1 - sample.weight) * field.value(now, sample.station, run) + sample.weight * field.value(now, sample.next, run);
    }
  });
  return out;
}

// Colour of a share in [0, 1] of a scale, its stops as rgb triples.
function onScale(stops, share) {
  const x = Math.min(1, Math.max(0, share)) * (stops.length - 1), k = Math.min(Math.floor(x), stops.length - 2);
  return stops[k].map((c, m) => c + (x - k) * (stops[k + 1][m] - c));
}
