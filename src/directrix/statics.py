"""Load control, and the way into every static run. The loop knows load factors, when to cut and when to stop."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix import points
from directrix.audit import StaticBooks
from directrix.checks import choice, flag, reporting, whole
from directrix.contact_groups import refuse_rod_contacts
from directrix.controls import SMALLEST, ArcLength, Control, DisplacementControl
from directrix.critical import PathStability
from directrix.diagnosis import at_start, noted, refuse
from directrix.discretisation import discretise
from directrix.errors import ConvergenceError, ModelError
from directrix.failures import explained
from directrix.formulations import CrisfieldJelenic, Directors, SimoVuQuoc, refuse_strategies
from directrix.formulations.crisfield_jelenic import CrisfieldJelenicStatics
from directrix.formulations.directors import DirectorStep, Rule
from directrix.formulations.simo_vu_quoc import SimoVuQuocStatics
from directrix.hessian import not_conservative
from directrix.integrators import Formulation
from directrix.joint_checks import refuse_joints
from directrix.keeping import Folder, Keeper, RunFolder, fingerprint, recall, remember
from directrix.linear.choice import Linear, chosen, said_of
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.parts import Keep, Parts
from directrix.path import Walk
from directrix.recorder import Progress, Recorder, feed_of
from directrix.result import Result, Status, TurningPoint, turn_length
from directrix.scheme import Scheme
from directrix.state import initial_state, place_supports
from directrix.telling import line
from directrix.threads import one_blas_thread
from directrix.turning import folded, within_reach
from directrix.watch import Watch

Array = NDArray[np.float64]

__all__ = ["PATIENCE", "solve_static", "static_scheme", "watch_for"]

PATIENCE = 20  # Newton iterations of a step along a path: it is cheaper to cut it


@one_blas_thread()
def solve_static(
    model: Model,
    steps: int | None = None,
    *,
    control: Control | None = None,
    formulation: Formulation | None = None,
    start: Result | None = None,
    save_every: int = 1,
    keep: Keep | None = None,
    folder: Folder | RunFolder | str | os.PathLike[str] | None = None,
    tolerance: float = 1e-9,
    threads: int = 1,
    linear: Linear | None = None,
    rotation: str = "exponential",
    stability: bool | None = None,
    record: Sequence[points.Recorder] = (),
    progress: Progress | Literal[True] | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """Find equilibria while the load factor goes from 0 to 1 in equal parts, or along the path of a ``control``.

    A part that does not converge is cut in halves, down to 1/4096 of itself, and the steps grow again after
    easy ones. Loads are multiplied by the load factor unless marked ``constant``; prescribed values ramp with it.
    With a ``control`` the load factor is an unknown: it may fall, pass limit points, which are located and
    reported, and pass 1.

    Parameters
    ----------
    model
        Rods, supports and loads.
    steps
        Parts of the load path that are saved (the cuts between them are not, unless they are the last state);
        10 unless given, and not for a ``control``.
    control
        None is load control; ``dx.ArcLength(…)`` or ``dx.DisplacementControl(…)``.
    formulation
        ``Directors()`` (default); for comparison ``SimoVuQuoc()`` and ``CrisfieldJelenic()``.
    start
        Begin at the last state of this result instead of the reference. A ``control`` goes on from its load factor,
        load control begins at 0 again.
    save_every
        Keep every so many parts; the last one is always kept.
    keep
        Which rods, nodes and fields: ``dx.Keep(…)``; all unless given.
    folder
        Where the run is kept while it goes on: a path, or ``dx.Folder(path, resume=True)`` to go on with a run that was
        killed or interrupted, to the same digits. The result is written there in the end.
    tolerance
        Unbalanced over largest element force at which a state is accepted (never below round-off).
    threads
        How many threads share the work on a frame of many junctions; no bit of the result depends on it.
    rotation
        Update of the rotations in an iteration, "exponential" or "cayley"; both reach the same state.
    stability
        Whether to count the negative pivots of the stiffness at every saved state (:attr:`Result.stability`) and, with
        a ``control``, to look for critical points; True with a control unless said otherwise. Where loads have no
        potential there is nothing to read, and ``info["stability"]`` says why.
    record
        Points of rods whose history goes to files while the run goes on: ``dx.Recorder(rod, s=…)``.
    linear
        Who solves a frame: None is SciPy and LAPACK; "rslab" and "pardiso" are packages that are faster where there are
        many joints, "petsc" or ``dx.Petsc(…)`` is for frames that go beyond one machine. Chains need none of them.
    progress
        Called after each part with the fraction done and a line of text. What it raises ends the run, which is kept.
        True shows a line, in a notebook a bar.
    raise_on_failure
        Raise ConvergenceError instead of returning a Result with ``success`` False.

    Raises
    ------
    ModelError
        The model or an argument cannot be right.
    """
    if control is None:
        steps = 10 if steps is None else steps
    elif not isinstance(control, (ArcLength, DisplacementControl)):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"control = {control!r} is no control", "use dx.ArcLength(…) or dx.DisplacementControl(…)")
    elif steps is not None:
        raise ModelError("steps= are those of load control", "leave it out: the control has its own", "steps=")
    steps = None if steps is None else whole(steps, "steps", 1, 10**9)
    save_every = whole(save_every, "save_every", 1, 10**9)
    choice(rotation, "rotation update", ("exponential", "cayley"))
    refuse_strategies(formulation, progress)
    if control is not None and isinstance(formulation, SimoVuQuoc):
        raise ModelError(
            "SimoVuQuoc() carries its rotations from iteration to iteration, a path has to know where its step began",
            "follow it with dx.Directors() or dx.CrisfieldJelenic()",
            "formulation=",
        )
    if control is not None and isinstance(model, Model):  # pyright: ignore[reportUnnecessaryIsInstance]
        refuse_rod_contacts(model, "a path with a control has its system of equations for good", "control=")
    scheme = static_scheme(model, formulation)
    disc = discretise(model, scheme)
    x = initial_state(disc, start, scheme)
    settings = Settings(tolerance, rotation=rotation, threads=threads, linear=chosen(linear))
    if control is not None:
        settings = replace(settings, iterations=PATIENCE)
    newton = Newton(disc, scheme, settings)
    refuse_joints(newton, x)
    found = refuse(at_start(newton, x, stressed=start is not None))
    recorder = Recorder(disc, "static", Parts(disc.mesh, keep), record, feed_of(progress))
    watch, unread = watch_for(newton, stability, control)
    asked = {
        "steps": steps, "control": control, "formulation": formulation, "tolerance": tolerance, "rotation": rotation,
        "save_every": save_every, "keep": keep, "stability": watch is not None, "x": x,
        **said_of(linear),
    }  # fmt: skip
    print_ = "" if folder is None else fingerprint(disc, scheme, asked, (0.0, 1.0))
    run: _LoadSteps | Walk
    if control is None:
        run = _LoadSteps(newton, recorder, steps or 10, save_every, watch)
    else:
        run = Walk(newton, control, recorder, save_every, watch)
    status = run.begin(x, start)
    keeper = Keeper(folder, recorder, print_)
    if keeper.memory is not None and status is None:
        run.recall(keeper.memory)
    report = reporting(progress)
    status = status or keeper.attend(lambda: run.go(report, keeper), lambda: f"load factor {run.factor:.6g}")
    run.close()
    status = noted(status, found)
    info = {
        "formulation": repr(formulation or Directors()), "tolerance": tolerance, "cuts": run.cuts, "rotation": rotation,
        "element": repr(scheme.element),
        **({"steps": steps} if control is None else {"control": repr(control)}),
        **({"stability": f"not read: {unread}"} if unread else {}),
    }  # fmt: skip
    result = recorder.result(status, run.ledger.audit(), info, keeper.earlier())
    result = replace(result, turning_points=tuple(run.turning_points), stability=run.stability)
    result = keeper.finish(result)
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result


class _LoadSteps:
    """Load control: equal parts of the way from load factor 0 to 1."""

    turning_points: tuple[TurningPoint, ...] = ()

    def __init__(
        self, newton: Newton, recorder: Recorder, steps: int, save_every: int, watch: Watch | None = None
    ) -> None:
        self.newton, self.recorder, self.steps, self.save_every = newton, recorder, steps, save_every
        self.watch, self.counts = watch, list[int]()
        self.factor, self.kept, self.cuts = 0.0, 0.0, 0
        self.reach = 1.0 / steps

    def begin(self, x: Array, start: Result | None) -> None:
        """Keep the first state."""
        self.x = x
        self.newton.driver.place(0.0, 0.0)
        self.newton.driver.shift()
        self.books = self.newton.books(x)
        self.ledger = StaticBooks(self.newton.disc, self.books)
        self._keep()
        self.acting = self.newton.applied(x, self.newton.disc.external(0.0, 0.0))

    def remember(self) -> dict[str, Any]:
        """All that the next step depends on."""
        own = remember(self, "x", "factor", "kept", "cuts", "reach", "acting", "counts")
        parts = {"newton": self.newton, "ledger": self.ledger, "trail": self.recorder.log.trail}
        return {"own": own, **{name: part.remember() for name, part in parts.items()}}

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        recall(self, memory["own"])
        self.books = self.newton.recall(memory["newton"])
        self.ledger.recall(memory["ledger"])
        self.recorder.log.trail.recall(memory["trail"])

    def go(self, progress: Progress, keeper: Keeper) -> Status:
        """Step on until load factor 1, or a step that fails at its smallest."""
        newton, disc, steps = self.newton, self.newton.disc, self.steps
        while self.factor < 1.0:
            if keeper.due(tried := len(self.recorder.iterations)):
                keeper.keep(tried, self.factor, self.remember)
                if keeper.stopping:
                    return keeper.interrupted(f"load factor {self.factor:.6g}")
            done, reach = self.factor, self.reach
            goal = min(np.floor(done * steps + 1e-9) + 1.0, steps) / steps
            factor = goal if done + reach >= goal * (1.0 - 1e-12) else done + reach
            factor = within_reach(newton, self.x, done, factor, 2.0 * SMALLEST / steps)
            before = self.x.copy()
            newton.begin(self.x)
            moved = place_supports(disc, self.x, factor)
            loads = disc.external(factor, factor)
            newton.driver.place(factor, factor)
            outcome = newton.solve(self.x, loads, moved)
            failed = outcome.status or folded(newton, self.x)
            self.recorder.log.tried(newton.trail, solved=failed is None)
            if failed is not None:
                self.x = before
                self.reach, self.cuts = 0.5 * (factor - done), self.cuts + 1
                if self.reach < SMALLEST / steps:
                    why = explained(newton, before, failed)
                    sentence = f"stopped at load factor {done:.6g}, after {self.cuts} cuts of the step: {why.sentence}"
                    return Status(why.code, sentence, why.advice)
                continue
            self.books = newton.finish(self.x, self.acting)
            self.ledger.add(self.books, self.x[: disc.nodes, :3])
            self.acting, self.factor = self.books.applied.copy(), factor
            self.reach = min(1.0 / steps, 2.0 * reach)
            if factor == goal and round(factor * steps) % self.save_every == 0:
                self._keep()
            progress(factor, line("load factor", factor, self.recorder.iterations, cuts=self.cuts))
        keeper.keep(len(self.recorder.iterations), self.factor, self.remember, done=True)
        cut = f", {self.cuts} of them cut" if self.cuts else ""
        return Status("done", f"reached load factor 1 in {len(self.recorder.iterations)} steps{cut}.")

    def close(self) -> None:
        """Keep the last state."""
        if self.kept < self.factor:
            self._keep()

    def _keep(self) -> None:
        r = self.x[: self.newton.disc.nodes, :3]
        self.recorder.keep(self.factor, self.factor, r, self.x, self.books, self.ledger.flows)
        if self.watch is not None:
            self.counts.append(self.watch.pivots(self.x, self.factor))
        self.kept = self.factor

    @property
    def stability(self) -> PathStability | None:
        """Of the saved states; None when nobody watched."""
        counts = np.array(self.counts, np.int64)
        return None if self.watch is None else PathStability(counts, np.zeros(len(counts), bool))


def watch_for(newton: Newton, wanted: bool | None, control: Control | None) -> tuple[Watch | None, str]:
    """What looks at stability, or why that cannot be read. Raises ModelError when it is asked for and cannot."""
    if wanted is not None:
        flag(wanted, "stability")
    if wanted is False or (wanted is None and control is None):
        if isinstance(control, ArcLength) and control.turns:
            raise ModelError("branch= needs stability", "leave stability=False out", "stability=")
        return None, ""
    why = not_conservative(newton)
    if why and (wanted or (isinstance(control, ArcLength) and control.turns)):
        raise ModelError(
            f"stability cannot be read from the stiffness: {why}", "follow the path without it", "stability="
        )
    return (None if why else Watch(newton, turn_length(newton.disc.mesh.r0))), why


def static_scheme(model: Model, formulation: Formulation | None) -> Scheme:
    """Statics of a formulation; raises ModelError for one that does not go with the model."""
    match formulation:
        case None | Directors():
            return Scheme(DirectorStep(Rule(static=True)))
        case SimoVuQuoc():
            return Scheme(SimoVuQuocStatics())
        case CrisfieldJelenic():
            for rod in model.rods:
                if rod.order > 2:
                    raise ModelError(
                        f"rod {rod.name!r} has elements of order {rod.order}; CrisfieldJelenic() knows 1 and 2",
                        "use order=1 or order=2",
                        "formulation=",
                    )
            return Scheme(CrisfieldJelenicStatics())
    raise ModelError(f"{formulation!r} is not a formulation", "use dx.Directors()", "formulation=")
