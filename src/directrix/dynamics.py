"""Time stepping. The loop knows states, times and when to save or stop; the mechanics are elsewhere."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, Literal

from directrix import points
from directrix.accounts import Taken
from directrix.checks import reporting
from directrix.errors import ConvergenceError
from directrix.failures import explained
from directrix.fast import fast_for
from directrix.integrators import Formulation, Integrator
from directrix.keeping import Folder, Keeper, RunFolder
from directrix.linear.choice import Linear
from directrix.model import Model
from directrix.motion import Asked, Motion
from directrix.newton import Outcome
from directrix.parts import Keep
from directrix.recorder import Progress
from directrix.result import Result, Status
from directrix.state import place_supports
from directrix.stepping import Adaptive, Beat, Fixed, way
from directrix.telling import every_step, line
from directrix.threads import one_blas_thread

__all__ = ["moved", "simulate"]


@one_blas_thread()
def simulate(
    model: Model,
    t_end: float,
    dt: float | Adaptive,
    *,
    integrator: Integrator | None = None,
    formulation: Formulation | None = None,
    load_rule: Literal["midpoint", "average"] = "midpoint",
    start: Result | None = None,
    save_every: int = 1,
    keep: Keep | None = None,
    folder: Folder | RunFolder | str | os.PathLike[str] | None = None,
    tolerance: float = 1e-9,
    record: Sequence[points.Recorder] = (),
    threads: int = 1,
    linear: Linear | None = None,
    progress: Progress | Literal[True] | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """Integrate the motion from t = 0 (or from ``start``) to ``t_end``, in equal steps or as long as an error allows.

    A step that cannot be solved is cut in halves, down to 1/4096, and the steps grow again after easy ones; what the
    integrator conserves it conserves in steps of any length. ``result.dt`` and ``result.cuts`` tell.

    Parameters
    ----------
    model
        Rods with mass, supports, loads, initial velocities.
    t_end, dt
        End and step; ``t_end`` must be a whole number of steps away. Or ``dx.Adaptive(…)``, which see.
    integrator
        ``EnergyMomentum()`` (default), ``Midpoint()``, ``EnergyDissipating(..)``, ``GeneralizedAlpha(rho_inf)``,
        ``HilberHughesTaylor(alpha)``, ``Newmark(..)``, ``SimoTarnowDoblare()``.
    formulation
        The one that the integrator works with, ``Directors()`` for most; any other is refused.
    load_rule
        A load acts over a step with its value at t½ ("midpoint") or the mean of its end values ("average");
        the generalised-α family takes its value at the end of the step.
    start
        Go on from the last instant of this result, at its time if it is dynamic and at t = 0 if static.
    save_every
        Keep every so many steps, whole ones of a fixed ``dt``; the last state is always kept.
    keep
        Which rods, nodes and fields: ``dx.Keep(…)``; all unless given.
    folder
        Where the run is kept while it goes on: a path, or ``dx.Folder(path, resume=True)`` to go on with a run that was
        killed or interrupted, to the same digits. The result is written there in the end.
    tolerance
        Unbalanced over largest element force at which a step is accepted (never below round-off).
    record
        Points of rods whose history goes to files while the run goes on: ``dx.Recorder(rod, s=…)``.
    threads
        How many threads share the work on a frame of many junctions or a chain of 4096 elements and more; no bit of the
        result depends on it.
    linear
        Who solves a frame: None is SciPy and LAPACK; "rslab" and "pardiso" are packages that are faster where there are
        many joints, "petsc" or ``dx.Petsc(…)`` is for frames that go beyond one machine. Chains need none of them.
    progress
        Called after each step with the fraction done and a line of text. What it raises ends the run, which is kept.
        True shows a line, in a notebook a bar. A chain takes its steps many times faster when nobody asks for each.
    raise_on_failure
        Raise ConvergenceError instead of returning a Result with ``success`` False.

    Raises
    ------
    ModelError
        The model or an argument cannot be right.
    """
    asked = Asked(
        t_end, dt, integrator, formulation, load_rule, start, save_every, keep, tolerance, record, threads, linear,
        progress,
    )  # fmt: skip
    return moved(Motion(model, asked), folder, raise_on_failure)


def moved(
    motion: Motion, folder: Folder | RunFolder | str | os.PathLike[str] | None = None, raise_on_failure: bool = False
) -> Result:
    """Take a motion to its end; see :func:`simulate`."""
    keeper = Keeper(folder, motion.recorder, "" if folder is None else motion.fingerprint())
    steps = _Steps(motion, reporting(motion.asked.progress))
    if keeper.memory is not None:
        steps.recall(keeper.memory)
    status = keeper.attend(lambda: steps.go(keeper), steps.broken_off)
    steps.close()
    result = keeper.finish(motion.result(status, keeper.earlier()))
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result


class _Steps:
    """The loop over the steps of a motion."""

    def __init__(self, motion: Motion, report: Callable[[float, str], None]) -> None:
        self.motion, self.report = motion, report
        self.newton, self.pace, self.recorder, self.ledger = motion.newton, motion.pace, motion.recorder, motion.ledger
        self.save_every = motion.save_every
        self.x, self.beat, self.books, self.acting = motion.x, motion.beat, motion.books, motion.acting
        self.watched = every_step(motion.asked.progress)
        self.fast = fast_for(self.newton, self.pace, self.save_every) if isinstance(self.pace, Fixed) else None
        self.saved = 0  # steps that are behind what was last kept
        self.paced = self.beat.dt  # of the last step
        self.unsaved: tuple[Any, Any] | None = None

    def remember(self) -> dict[str, Any]:
        """All that the next step depends on."""
        return {
            "beat": self.beat.remember(), "saved": self.saved, "paced": self.paced, "x": self.x, "acting": self.acting,
            "newton": self.newton.remember(), "ledger": self.ledger.remember(), "log": self.recorder.log.remember(),
            "fast": None if self.fast is None else self.fast.remember(),
        }  # fmt: skip

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        self.beat = self.pace.again(Beat.recalled(memory["beat"]))
        self.saved, self.paced = memory["saved"], memory["paced"]
        self.newton.retime(self.motion.integrator.scheme(self.paced), self.x)
        self.x, self.acting = memory["x"], memory["acting"]
        self.books = self.newton.recall(memory["newton"])
        self.ledger.recall(memory["ledger"])
        self.recorder.log.recall(memory["log"])
        if self.fast is not None:
            self.fast.recall(memory["fast"])
        if self.saved < self.taken and not self.inside:
            self._hold()

    @property
    def taken(self) -> int:
        """Steps so far."""
        return len(self.recorder.iterations)

    @property
    def inside(self) -> bool:
        """True while the state is in the lanes."""
        return self.fast is not None and self.fast.inside

    def go(self, keeper: Keeper) -> Status:
        """Step on until the end, or a step that fails at its shortest."""
        while not self.beat.done:
            if keeper.due(self.taken):
                keeper.keep(self.taken, self.beat.t, self.remember)
                if keeper.stopping:
                    return keeper.interrupted(f"t = {self.beat.t:g}")
            if not self._many(keeper.room(self.taken)):
                failed = self._one()
                if failed is not None:
                    return failed
        keeper.keep(self.taken, self.beat.t, self.remember, done=True)
        return self.motion.done()

    def broken_off(self) -> str:
        """Where the run is when something came in between; steps may have been taken that are not booked yet."""
        if self.fast is not None:
            self._booked(self.fast.settle(self.ledger))
        return f"t = {self.beat.t:g}"

    def close(self) -> None:
        """Keep the last state."""
        if self.fast is not None:
            self.fast.close(self.ledger)
            if self.fast.inside and self.saved < self.taken:
                self.books = self.fast.books(self.x)
                self._hold()
        if self.unsaved is not None:
            self.recorder.keep(self.beat.t, 1.0, *self.unsaved, self.books, self.ledger.flows)

    def _hold(self) -> None:
        """The state as it is, for a run that ends on the way: a step that fails leaves ``x`` somewhere."""
        self.unsaved = self.newton.positions(self.x), self.x.copy()

    def _tell(self, energy: float) -> None:
        if self.motion.asked.progress is None:
            return
        log, t = self.recorder.log, self.beat.t
        text = line("t =", t, log.iterations, cuts=log.failed, energy=energy, error=self.ledger.error(energy))
        self.report(self.pace.fraction(self.beat), text)

    def _many(self, room: int) -> bool:
        """Take steps the fast way, ``room`` at most; False when it took none."""
        if self.fast is None or not isinstance(self.pace, Fixed) or not self.beat.whole:
            return False
        k = self.beat.k
        many = 1 if self.watched else min(room, self.pace.steps - k, self.fast.room(k))
        if self.motion.asked.record:  # what is saved is to be in their files before the next step
            many = min(many, self.save_every - k % self.save_every)
        external = self.motion.loads(self.pace, k, many)
        many = many if self.motion.steady else len(external)
        if self._booked(self.fast.take(self.x, external, many, self.ledger, k)):
            self._tell(self.fast.energy)
            return True
        if self.fast.inside:
            self.books = self.fast.books(self.x)
            self.fast.give(self.x)
        if self.saved < self.taken:
            self._hold()
        else:
            self.unsaved = None
        return False

    def _booked(self, taken: Taken) -> bool:
        """Note and save steps that were taken the fast way; True when there are any."""
        if not taken.iterations or not isinstance(self.pace, Fixed):
            return False
        self.recorder.log.took(self.beat.dt, taken.iterations, taken.moves)
        self.beat = self.pace.on(self.beat, len(taken.iterations))
        if taken.instants is not None:
            self.recorder.keep_all(taken.instants)
            self.unsaved, self.saved = None, self.taken - (self.beat.k - taken.saved)
        return True

    def _one(self) -> Status | None:
        """Take a step the general way, or try it shorter the next time; how the run ends if it has to."""
        newton, disc, pace, beat, log = self.newton, self.motion.disc, self.pace, self.beat, self.recorder.log
        ends = self.motion.ends
        self.x, self.paced = newton.retime(self.motion.integrator.scheme(beat.dt), self.x), beat.dt
        good = self.x.copy()
        if newton.driver.varies and ends:
            newton.driver.place(beat.to, 1.0)
        elif newton.driver.varies:
            newton.driver.act(beat.t, beat.to, self.motion.asked.load_rule)
        external = self.motion.standing[0] if self.motion.steady else self.motion.load(beat.t, beat.to)
        newton.begin(self.x)
        moved = bool(disc.prescribed or disc.driven) and place_supports(disc, self.x, beat.to)
        outcome = newton.solve(self.x, external, moved)
        if outcome.status is not None:
            self.x, shorter = good, pace.shorter(beat)
            log.threw(newton.trail, rejected=False)
            if shorter is None:
                failed = explained(newton, newton.start, outcome.status, static=False)
                return Status(failed.code, f"{self._stopped()}: {failed.sentence}", failed.advice)
            self.beat = shorter
            return None
        judged = pace.judge(beat, way(self.x, disc.nodes) / beat.dt if pace.adaptive else None, disc.length)
        if not judged.good:
            self.x = good
            log.threw(newton.trail, rejected=True)
            if judged.beat is None:
                return Status("inaccurate", f"{self._stopped()}.", "Raise the tolerance, or lower dt_min.")
            self.beat = judged.beat
            return None
        assert judged.beat is not None
        self._took(outcome, judged.beat)
        return None

    def _took(self, outcome: Outcome, after: Beat) -> None:
        """Book and save a step that was solved; ``after`` is what comes next."""
        newton, ends, beat = self.newton, self.motion.ends, self.beat
        self.books = newton.finish(self.x, self.acting if ends else None)
        if ends:
            self.acting = self.books.applied.copy()
        self.ledger.add(self.books, beat.dt)
        self.recorder.log.took(beat.dt, [outcome.iterations], newton.trail)
        self.beat = after
        count = self.taken if self.pace.adaptive else after.k
        if (beat.asked or not self.pace.on_time) and count % self.save_every == 0:
            self.recorder.keep(after.t, 1.0, newton.positions(self.x), self.x, self.books, self.ledger.flows)
            self.unsaved, self.saved = None, self.taken
        else:
            self._hold()
        self._tell(float(self.books.totals[0] + self.books.totals[1]))

    def _stopped(self) -> str:
        beat = self.beat
        where = f", in step {beat.k + 1} to t = {beat.to:g}" if beat.whole and not self.pace.adaptive else ""
        return f"stopped at t = {beat.t:g}{where}: {self.pace.why(beat)}"
