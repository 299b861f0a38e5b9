// The energies in the course of the run, with a mark that follows the picture.

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
