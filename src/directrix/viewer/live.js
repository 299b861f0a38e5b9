// The page of a run that goes on: asks for what is new, and stays usable when nobody answers any more.

let got = page.live, touched = false;

async function ask() {
  const asked = performance.now();
  try {
    const said = await (await fetch(`state?after=${got}`)).json();
    tell(said.done, said.line);
    if (said.page) renew(said);
    if (said.over) return tell(1, "the run has ended; this page stays as it is");
  } catch {
    return tell(0, "nobody answers any more; this page stays as it is");
  }
  setTimeout(ask, Math.min(1500, Math.max(300, 4 * (performance.now() - asked)))); // a slow answer is not asked for often
}

function tell(done, line) {
  part("live").hidden = false;
  part("done").value = done;
  part("line").textContent = line;
}

function renew({ page: fresh, count }) {
  got = count;
  const newest = seen.newest, time = clock.time(seen.u);
  fresh.runs.forEach((run, k) => Object.assign(runs[k], readRun(run)));
  page.title = fresh.title;
  room = extent(runs);
  setClock();
  const after = clock.ticks.findIndex((t) => t >= time - 1e-9 * clock.span);
  seen.u = newest || after < 0 ? clock.last : after;
  seen.newest = newest;
  words();
  showScale();
  if (!touched && newest) lookFrom("fit");
  redraw();
}

for (const kind of ["pointerdown", "wheel"]) space.addEventListener(kind, () => { touched = true; });
seen.newest = true;
tell(0, "the run goes on");
ask();
