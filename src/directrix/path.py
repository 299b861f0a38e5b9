"""Path following: the loop. It knows load factors, steps, when to cut and when to stop; the mechanics are elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.audit import StaticBooks
from directrix.bordered import Bordered, dot, travelled
from directrix.controls import Control, Snapshot
from directrix.errors import ModelError
from directrix.failures import explained
from directrix.gauge import Gauge, gauge_for
from directrix.kernels import step as kernel
from directrix.newton import Newton
from directrix.recorder import Progress, Recorder
from directrix.result import Result, Status, TurningPoint
from directrix.rotations import log
from directrix.state import place_supports

Array = NDArray[np.float64]

__all__ = ["Walk"]

STRAIGHT = 0.7  # cos of the largest angle between the tangents at the two ends of a step
LOCATED = 1e-8  # of the slope at the ends of the step
ON_TARGET = 1e-12  # of the load factor
HELD_UP = "Bring loads that are constant on by load control first, and go on with start=."
SHARP = Status(
    "not_converged",
    "the path turns too sharply to tell where it goes on.",
    "Take smaller steps, refine the mesh, or look for a bifurcation there.",
)
TOO_SHORT = 1e-6  # of a step: an event that near to its start is the start


class Point(NamedTuple):
    """An equilibrium: state, load factor, unit tangent (n, 6) onward and dλ/ds along it."""

    x: Array
    factor: float
    tangent: Array
    slope: float


class Trial(NamedTuple):
    """A step that converged: where it leads, its reach, and the iterations it took."""

    to: Point
    reach: float
    iterations: int


class _LostError(Exception):
    """A step that has to be cut, and why."""

    def __init__(self, status: Status, iterations: int) -> None:
        self.status, self.iterations = status, iterations


def try_step(bordered: Bordered, gauge: Gauge, at: Point, reach: float) -> Trial:
    """From one equilibrium to the next: predicted along the tangent, corrected in the gauge's plane.

    Raises _LostError when that fails, or when the path turns too much on the way to be sure it is the same path.
    """
    x, rate = at.x.copy(), gauge.rate(at.tangent)
    far = reach / max(rate, 1e-12)
    limit, cayley = bordered.newton.options[4], bordered.newton.options[6] > 0.0
    _, turned, _ = kernel.move(far * at.tangent, bordered.disc.nodes, x, False, cayley, limit)
    factor = float(at.factor + far * at.slope * min(1.0, limit / max(turned, 1e-300)))
    place_supports(bordered.disc, x, factor)
    factor, iterations, status = bordered.correct(x, factor, gauge.row(at.tangent, reach))
    if status is not None:
        raise _LostError(status, iterations)
    found = bordered.tangent(x, factor)
    if isinstance(found, Status):
        raise _LostError(found, iterations)
    along = dot(found[0], at.tangent, bordered.length)
    tangent = np.copysign(1.0, along) * found[0]
    if abs(along) < STRAIGHT or gauge.rate(tangent) <= 0.0:
        raise _LostError(SHARP, iterations)
    return Trial(Point(x, factor, tangent, float(np.copysign(found[1], along))), reach, iterations)


def locate(
    step: Callable[[float], Trial], measure: Callable[[Point], float], start: float, end: Trial, small: float
) -> Trial:
    """The trial short of ``end`` where ``measure`` vanishes to ``small``: secants in a bracket (Anderson and Björck).

    ``start``, the measure of the step's start, and that of ``end`` have different signs.
    """
    a, b, f_a, f_b, trial = 0.0, end.reach, start, measure(end.to), end
    for _ in range(60):
        reach = b - f_b * (b - a) / (f_b - f_a)
        if not min(a, b) < reach < max(a, b):
            break
        trial = step(reach)
        f = measure(trial.to)
        if abs(f) <= small:
            break
        if f * f_b < 0.0:
            a, f_a = b, f_b
        else:  # an end that stays is given less weight
            f_a *= 1.0 - f / f_b if f / f_b < 1.0 else 0.5
        b, f_b = reach, f
    return trial


class Walk:
    """One run along a path. :meth:`begin` finds the first equilibrium, :meth:`go` walks until it ends, and says how.

    ``turning_points``, ``cuts`` and ``ledger`` are what was found on the way; states go to the recorder.
    """

    def __init__(self, newton: Newton, control: Control, recorder: Recorder, save_every: int) -> None:
        self.newton, self.disc, self.bordered = newton, newton.disc, Bordered(newton)
        self.control, self.recorder, self.save_every = control, recorder, save_every
        self.turning_points: list[TurningPoint] = []
        self.arc, self.steps, self.cuts, self.parts, self.kept = 0.0, 0, 0, 0, True

    @property
    def factor(self) -> float:
        """Load factor of the last state."""
        return self.point.factor

    def begin(self, x: Array, start: Result | None) -> Status | None:
        """Bring ``x`` to balance at the load factor it has; a Status when it cannot be. Raises ModelError."""
        if start is not None and start.kind != "static":
            raise ModelError("start= is a motion, which has no load factor to go on from", "start from solve_static")
        factor = 0.0 if start is None else float(start.load_factor[-1])
        self.loads = self.disc.external(factor, factor)
        self.newton.driver.place(factor, factor)
        self.newton.driver.shift()
        self.acting = self.newton.applied(x, self.loads)
        self.books = self.newton.books(x)
        self.ledger = StaticBooks(self.disc, self.books)
        self.point = Point(x.copy(), factor, np.zeros((self.disc.nodes, 6)), 0.0)
        outcome = self.newton.solve(x, self.loads, place_supports(self.disc, x, factor))
        found = outcome.status or self.bordered.tangent(x, factor, at_limit=start is not None)
        if isinstance(found, Status):
            self._keep()
            sentence = f"there is no equilibrium to start from at load factor {factor:.6g}: {found.sentence}"
            return Status(found.code, sentence, HELD_UP if np.any(self.loads) else found.advice)
        tangent, slope = found
        if not np.isfinite(slope):
            raise ModelError(
                f"nothing moves with the load factor, at {factor:.6g}",
                "give a load that is neither constant nor on a support, nor a function that begins flat",
            )
        self.gauge = gauge_for(self.control, self.bordered, x)
        sense = self.gauge.orient(tangent, _onward(start))
        self.point = Point(x, factor, sense * tangent, sense * slope)
        self.gauge.walk(0.0, self.point.tangent)
        self.rising = sense
        if start is None:
            self.acting[:] = 0.0
        self._book()
        self._keep()
        if self._asked():
            raise ModelError(
                f"until is true at the start, load factor {factor:.6g}", "give a rule that becomes true on the way"
            )
        return None

    def go(self, progress: Progress) -> Status:
        """Step on until the end, ``until``, the most steps, or a step that fails at its smallest."""
        gauge, reach = self.gauge, self.gauge.first
        while gauge.left > 0.0:
            if self.steps >= gauge.most:
                return self._out_of_steps()
            wish, part = gauge.goal(reach)
            try:
                whole = try_step(self.bordered, gauge, self.point, wish)
                trial, turned = self._first_event(whole)
            except _LostError as lost:
                self.recorder.iterations.append(lost.iterations)
                reach, self.cuts = 0.5 * wish, self.cuts + 1
                if reach < gauge.smallest:
                    return self._stuck(gauge.blame(self.point.tangent) or lost.status)
                continue
            self._take(trial, part and trial is whole, turned)
            reach = gauge.after(wish, whole.iterations)
            progress(gauge.share(self.steps), f"load factor {self.point.factor:.6g}  {trial.iterations} iterations")
            if self._asked():
                return Status("stopped", f"until is true{self._here()}")
        return Status("done", f"reached {gauge.aim}{self._here()}")

    def close(self) -> None:
        """Keep the last state."""
        if not self.kept:
            self._keep()

    def _first_event(self, whole: Trial) -> tuple[Trial, bool]:
        """The step up to the first limit point or load factor asked for on it, and whether that is a limit point."""

        def step(reach: float) -> Trial:
            return try_step(self.bordered, self.gauge, self.point, reach)

        trial, turned, at = whole, False, self.point
        if whole.to.slope * self.rising < 0.0:
            small = LOCATED * max(abs(at.slope), abs(whole.to.slope))
            limit = locate(step, lambda p: p.slope * self.rising, abs(at.slope), whole, small)
            if limit.reach > TOO_SHORT * whole.reach:
                trial, turned = limit, True
            else:
                self.rising = -self.rising
        passed = [
            f for f in self.control.load_factors
            if f != at.factor and (f - at.factor) * (trial.to.factor - f) >= 0.0
        ]  # fmt: skip
        if passed:
            target = min(passed, key=lambda f: abs(f - at.factor))
            small = ON_TARGET * max(abs(target), abs(trial.to.factor - at.factor))
            hit = locate(step, lambda p: p.factor - target, at.factor - target, trial, small)
            turned = turned and hit is trial
            if abs(hit.to.factor - target) <= 1e3 * small:
                hit = hit._replace(to=hit.to._replace(factor=target))
            trial = hit
        return trial, turned

    def _take(self, trial: Trial, part: bool, turned: bool) -> None:
        """Make the end of a trial the point where the path goes on."""
        self.point = trial.to
        self.arc += travelled(self.point.x, self.disc.nodes, self.bordered.length)
        self.loads = self.disc.external(self.point.factor, self.point.factor)
        self._book()
        self.gauge.walk(trial.reach, self.point.tangent)
        self.recorder.iterations.append(trial.iterations)
        self.steps, self.parts, self.kept = self.steps + 1, self.parts + part, False
        if turned or self.point.factor in self.control.load_factors or (part and self.parts % self.save_every == 0):
            self._keep()
        if turned:
            kind = "maximum" if self.rising > 0.0 else "minimum"
            self.turning_points.append(
                TurningPoint(f"limit point ({kind})", self.point.factor, self.arc, len(self.recorder.rows) - 1)
            )
            self.rising = -self.rising

    def _book(self) -> None:
        newton, x = self.newton, self.point.x
        newton.driver.place(self.point.factor, self.point.factor)
        before, self.acting = self.acting, newton.applied(x, self.loads)  # other states were tried since
        self.books = newton.finish(x, before)
        self.ledger.add(self.books, x[: self.disc.nodes, :3])

    def _keep(self) -> None:
        x, factor = self.point.x, self.point.factor
        self.recorder.keep(factor, factor, x[: self.disc.nodes, :3], x, self.books, self.ledger.flows)
        self.kept = True

    def _asked(self) -> bool:
        """What ``until`` says of the state; raises ModelError when that is no answer."""
        until, x, n = self.control.until, self.point.x, self.disc.nodes
        if until is None:
            return False
        rotation = x[:n, 3:12].reshape(n, 3, 3).transpose(0, 2, 1).copy()
        reaction = self.books.reaction.copy()
        seen = Snapshot(self.point.factor, self.arc, self.steps, self.disc.mesh, x[:n, :3].copy(), rotation, reaction)
        try:
            answer = cast("object", until(seen))
        except ModelError:
            raise
        except Exception as error:  # whatever a user's function raises
            raise ModelError(
                f"until fails at load factor {seen.load_factor:.6g}: {error!r}",
                "it gets a snapshot with .load_factor, .arc_length and .node(name).displacement",
            ) from error
        if type(answer) not in (bool, np.bool_):
            raise ModelError(f"until gives {answer!r} at load factor {seen.load_factor:.6g}", "return True or False")
        return bool(answer)

    def _here(self) -> str:
        cut = f", {self.cuts} of them cut" if self.cuts else ""
        at = f" at load factor {self.point.factor:.6g}, arc length {self.arc:.6g}, in {self.steps} steps{cut}"
        return at + "".join(f"; {point}" for point in self.turning_points) + "."

    def _out_of_steps(self) -> Status:
        if self.control.until is None:
            return Status("done", f"took all steps{self._here()}")
        return Status(
            "step_limit", f"until did not become true{self._here()}", "Raise max_steps, or go on with start=."
        )

    def _stuck(self, why: Status) -> Status:
        why = explained(self.newton, self.point.x, why)
        return Status(
            why.code,
            f"stopped at load factor {self.point.factor:.6g}, arc length {self.arc:.6g}, after {self.cuts} cuts of the "
            f"step: {why.sentence}",
            why.advice,
        )


def _onward(start: Result | None) -> Array | None:
    """The last increment (n, 6) of an earlier run, or None when it has none."""
    if start is None or len(start.t) < 2:
        return None
    turn = log(start.R[-1] @ np.swapaxes(start.R[-2], -1, -2))
    step = np.hstack([start.r[-1] - start.r[-2], turn])
    return step if np.any(step) else None
