// The state of the page, its words, its clock and its colours.

const page = readPage(document.getElementById("data").textContent), runs = page.runs;
const part = (id) => document.getElementById(id);
const space = part("space"), overlay = part("overlay"), chart = part("energy"), slider = part("slider");
const dynamic = runs[0].kind === "dynamic", clockName = dynamic ? "t" : "load factor";
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
const PALETTE = ["#4f87b8", "#d2601a", "#2b8a4b", "#a02c8c", "#b8860b", "#00808a", "#b3372e", "#6b7480"];
const SEQUENTIAL = {
  light: ["#46327e", "#31688e", "#1f9e89", "#5ec962", "#d9b600"], dark: ["#4a6fb0", "#2aa0a4", "#45c474", "#b5de2b", "#fff06b"],
};
const dark = matchMedia("(prefers-color-scheme: dark)");

const elements = runs.reduce((sum, run) => sum + elementsOf(run), 0);
const skeletons = runs.map((run) => makeSkeleton(run, elements));
const count = skeletons.reduce((sum, skeleton) => sum + skeleton.count, 0);
const poses = new Float32Array(9 * count), paints = new Float32Array(3 * count);
let start = 0;
skeletons.forEach((skeleton, k) => { // all runs share one drawing, each has its own part of it
  Object.assign(skeleton, { start, run: runs[k], poses: poses.subarray(9 * start, 9 * (start + skeleton.count)) });
  Object.assign(skeleton, { paints: paints.subarray(3 * start, 3 * (start + skeleton.count)), values: new Float32Array(skeleton.count) });
  start += skeleton.count;
});
for (const run of runs) {
  Object.assign(run, { r_: new Float32Array(3 * run.nodes), turn_: new Float32Array(6 * run.nodes), buffer: new Float32Array(6 * Math.max(run.nodes, run.stations)) });
  run.base = run.base_r ? { r: run.base_r, turn: run.base_turn } : { r: run.r0, turn: unturned(run.nodes) };
  run.shown = true;
}

let room = extent(runs), clock = makeClock(runs), pace = 1;
const seen = { u: 0, playing: false, hold: 0, yaw: 0, pitch: 0, distance: 1, target: [0, 0, 0], ink: {}, newest: false };
const scene = makeScene(space, count);
let due = false, before = 0;

// ---- numbers and words

const brief = (x) => (x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(3) : String(+x.toPrecision(5)));
const colourOf = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
const cssOf = (colour) => `rgb(${colour.map((c) => Math.round(255 * c)).join()})`;
const checked = (id) => part(id).checked;
const option = (select, value, text) => select.append(new Option(text, value));
const made = (tag, text, name = "") => Object.assign(document.createElement(tag), { textContent: text, className: name });

function readInk() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "ink", "soft", "line", "accent", "rod", "ghost", "trace", "middle", "kinetic", "stored", "x", "y", "z", "load", "support"]) {
    seen.ink[name] = style.getPropertyValue("--" + name).trim();
  }
  for (const [name, text] of Object.entries(seen.ink)) seen.ink[name + "3"] = colourOf(text);
  seen.sequential = SEQUENTIAL[dark.matches ? "dark" : "light"].map(colourOf);
  showScale();
}

function words() {
  part("title").textContent = page.title;
  part("about").textContent = page.about.join(" · ");
  part("runs").replaceChildren(...runs.map((run, k) => {
    const row = made("div", "", "run"), swatch = made("input", "", "swatch"), label = made("label", "");
    if (runs.length > 1) {
      Object.assign(swatch, { type: "checkbox", checked: run.shown });
      swatch.style.accentColor = PALETTE[k % PALETTE.length];
      swatch.addEventListener("change", () => { run.shown = swatch.checked; skin(); redraw(); });
      label.append(swatch, made("b", run.label));
      label.style.color = PALETTE[k % PALETTE.length];
      row.append(label);
    }
    row.append(made("span", run.status, run.success ? "status" : "status bad"), made("span", run.verdict && `audit ${run.verdict}`, run.passed ? "verdict good" : "verdict bad"));
    return row;
  }));
  const notes = runs.flatMap((run) => run.notes.map((note) => (runs.length > 1 ? `${run.label}: ${note}` : note)));
  const remarks = part("remarks");
  remarks.hidden = notes.length === 0;
  remarks.querySelector("summary").textContent = notes.length === 1 ? "1 note" : `${notes.length} notes`;
  remarks.querySelector("ul").replaceChildren(...notes.map((note) => made("li", note)));
  const kept = runs.map((run) => (run.frames < run.instants ? `${run.frames} of ${run.instants}` : `all ${run.frames}`));
  const hints = [`${[...new Set(kept)].join(", ")} saved instants are shown`];
  if (runs.some((run) => run.frames < run.instants)) hints[0] += ", thinned to keep the page small";
  if (page.size) hints.push(page.size);
  if (runs.some((run) => run.rods.some((rod) => rod.outline.length < 6))) hints.push("sections without an outline are drawn round");
  hints.push("H for help");
  part("hint").textContent = hints.join(" · ");
}

// ---- time

function setClock() {
  clock = makeClock(runs);
  const seconds = dynamic && clock.span >= 2 && clock.span <= 60;
  pace = seconds ? 1 : Math.max(clock.span, 1e-30) / 10; // model time per second at speed 1
  slider.max = clock.last;
  part("play").disabled = slider.disabled = clock.last === 0;
  const same = [...part("speed").options].find((one) => one.value === "1");
  if (same) same.textContent = seconds ? "real time" : "× 1";
}

function step(seconds) {
  const k = Math.min(Math.floor(seen.u), clock.last - 1), gap = clock.ticks[k + 1] - clock.ticks[k];
  const ahead = dynamic && gap > 0 ? seconds * pace / gap : seconds * clock.last / 8;
  seen.u += ahead * Number(part("speed").value);
  if (seen.u < clock.last) return;
  seen.u = clock.last;
  if (!checked("loop")) return play(false);
  seen.hold += seconds;
  if (seen.hold > 1) [seen.u, seen.hold] = [0, 0];
}

function go(frame) {
  seen.u = Math.min(clock.last, Math.max(0, Math.round(frame)));
  seen.hold = 0;
  redraw();
}

function play(on) {
  seen.playing = on && clock.last > 0;
  if (!seen.playing) seen.u = Math.round(seen.u); // rest on an instant that was computed
  if (seen.playing && seen.u >= clock.last) seen.u = 0;
  part("play").textContent = seen.playing ? "❚❚" : "▶";
  part("play").setAttribute("aria-label", seen.playing ? "pause" : "play");
  seen.newest = false;
  before = 0;
  redraw();
}

function stop(frame) {
  play(false);
  go(frame);
  seen.newest = seen.u === clock.last; // of a run that goes on
}

// ---- colours

function paint() {
  const chosen = part("colour").value, field = FIELDS[chosen];
  for (const skeleton of skeletons) {
    const { run, paints } = skeleton, k = runs.indexOf(run), field_ = field && has(run, field);
    if (!field_) {
      for (const { index, firstSample, samples } of skeleton.rods) {
        const colour = chosen === "rod" ? colourOf(PALETTE[index % 8]) : runs.length > 1 ? colourOf(PALETTE[k % 8]) : seen.ink.rod3;
        for (let q = firstSample; q < firstSample + samples; q++) paints.set(colour, 3 * q);
      }
      continue;
    }
    fieldAt(run, skeleton, field, clock.frame(run, seen.u), run.buffer, skeleton.values);
    skeleton.values.forEach((value, q) => paints.set(onScale(seen.stops, (value - seen.low) / (seen.high - seen.low || 1)), 3 * q));
  }
}

function showScale() {
  const field = FIELDS[part("colour").value];
  part("scale").hidden = !field || !scene;
  if (!field) return;
  const { low, high } = rangeOf(runs, field), unit = field.unit && page.units[field.unit];
  const { z3, middle3, x3 } = seen.ink, most = Math.max(Math.abs(low), Math.abs(high));
  [seen.low, seen.high] = field.signed ? [-most, most] : [0, high];
  seen.stops = field.signed ? [z3, middle3, x3] : seen.sequential;
  part("bar").style.background = `linear-gradient(to right, ${seen.stops.map(cssOf).join(", ")})`;
  part("field").textContent = seen.caption = field.name + (unit ? ` [${unit}]` : "");
  part("low").textContent = brief(seen.low);
  part("zero").textContent = field.signed ? "0" : "";
  part("high").textContent = brief(seen.high);
  part("range").textContent = seen.extremes = `over all times ${[low, high].map((x) => brief(Math.abs(x) < 1e-6 * most ? 0 : x)).join(" … ")}`;
}
