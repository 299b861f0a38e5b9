// The energies in the course of the run, with a mark that follows the picture.

const curves = () => (runs.length > 1
  ? runs.filter((run) => run.shown).map((run) => [dynamic ? `total, ${run.label}` : `stored, ${run.label}`, run, dynamic ? run.total : run.stored, PALETTE[runs.indexOf(run) % PALETTE.length], 2])
  : dynamic
    ? [["kinetic", runs[0], runs[0].kinetic, seen.ink.kinetic, 1.4], ["stored", runs[0], runs[0].stored, seen.ink.stored, 1.4], ["total", runs[0], runs[0].total, seen.ink.ink, 2.2]]
    : [["stored", runs[0], runs[0].stored, seen.ink.stored, 2], ["work done on it", runs[0], runs[0].work, seen.ink.soft, 1.4, [6, 5]]]);
const frame = { left: 56, right: 12, top: 6, bottom: 18 };

function drawChart() {
  const scale = devicePixelRatio, width = chart.width / scale, height = chart.height / scale, pen = chart.getContext("2d");
  const series = curves(), all = series.flatMap(([, , array]) => [Math.min(...array), Math.max(...array)]);
  const { rising, ticks, last, span } = clock;
  const low = Math.min(0, ...all), high = Math.max(...all) > low ? Math.max(...all) : low + 1;
  const across = (share) => frame.left + share * (width - frame.left - frame.right);
  const x = (run, k) => across(last === 0 ? 0 : rising ? (run.t[k] - ticks[0]) / span : k / (run.last || 1));
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
  pen.fillText(rising ? brief(ticks[last]) : `instant ${last}`, width - frame.right, height - 4);
  pen.textAlign = "left";
  pen.fillText(rising ? brief(ticks[0]) : "0", frame.left, height - 4);
  for (const [, run, array, colour, thick, dash] of series) {
    pen.setLineDash(dash || []);
    pen.strokeStyle = colour;
    pen.lineWidth = thick;
    pen.beginPath();
    array.forEach((v, k) => pen.lineTo(x(run, k), y(v)));
    pen.stroke();
  }
  pen.setLineDash([]);
  const here = across(last === 0 ? 0 : rising ? (clock.time(seen.u) - ticks[0]) / span : seen.u / last);
  pen.strokeStyle = seen.ink.accent;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(here, frame.top - 4);
  pen.lineTo(here, height - frame.bottom);
  pen.stroke();
  seen.pick = (pixel) => {
    const share = Math.min(1, Math.max(0, (pixel - frame.left) / (width - frame.left - frame.right)));
    if (!rising) return share * last;
    const t = ticks[0] + share * span, k = ticks.findIndex((value) => value >= t);
    return k > 0 && t - ticks[k - 1] < ticks[k] - t ? k - 1 : Math.max(0, k);
  };
}

function drawNumbers() {
  part("legend").replaceChildren(
    ...curves().map(([name, run, array, colour]) => {
      const item = made("span", `━ ${name} ${brief(array[Math.round(clock.frame(run, seen.u))])}`);
      item.style.color = colour;
      return item;
    }),
  );
  part("clock").textContent = clock.rising || runs.length === 1 ? `${clockName} = ${brief(timeShown())}` : `instant ${Math.round(seen.u)}`;
  slider.value = Math.round(seen.u);
}
