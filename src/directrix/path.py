"""Path following: the loop. It knows load factors, steps, when to cut and when to stop; the mechanics are elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.audit import StaticBooks
from directrix.bordered import Bordered, dot, normal_to, travelled
from directrix.controls import SMALLEST, ArcLength, Control, Snapshot
from directrix.critical import CriticalPoint, Kind, PathStability
from directrix.errors import ModelError
from directrix.failures import explained
from directrix.gauge import Gauge, gauge_for
from directrix.keeping import Keeper, recall, remember
from directrix.kernels import step as kernel
from directrix.newton import Newton
from directrix.recorder import Progress, Recorder
from directrix.result import Result, Status, TurningPoint
from directrix.rotations import log
from directrix.telling import line
from directrix.watch import Crossing, Settled, Watch

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
BEFORE_LIMIT = 0.99  # of a step to a limit point: there its eigenvalue still has its old sign
ASIDE = 0.5  # cos of the largest angle between a mode and the tangent of the path that it leads to
TOO_SHORT = 1e-6  # of a step: an event that near to its start is the start


class Point(NamedTuple):
    """An equilibrium: state, load factor, unit tangent (n, 6) onward and dλ/ds along it (±∞ where nothing moves)."""

    x: Array
    factor: float
    tangent: Array
    slope: float


class Trial(NamedTuple):
    """A step that converged: where it leads, its reach, and how its iterations went."""

    to: Point
    reach: float
    trail: Array

    @property
    def iterations(self) -> int:
        """How many it took."""
        return len(self.trail)


class _LostError(ArithmeticError):
    """A step that has to be cut, and why."""

    def __init__(self, status: Status, trail: Array) -> None:
        self.status, self.trail = status, trail


def settle(bordered: Bordered, gauge: Gauge | None, at: Point, reach: float) -> tuple[Array, float, Array]:
    """From one equilibrium to the next: predicted along the tangent, corrected in the gauge's plane.

    Without a gauge ``reach`` is a change of the load factor. State, load factor and trail. Raises _LostError when
    that fails.
    """
    x = at.x.copy()
    far = reach / (abs(at.slope) if gauge is None else max(gauge.rate(at.tangent), 1e-12))
    limit, cayley = bordered.newton.options[4], bordered.newton.options[6] > 0.0
    _, turned, _ = kernel.move(far * at.tangent, bordered.disc.nodes, x, False, cayley, limit)
    row = None if gauge is None else gauge.row(at.tangent, reach)
    if gauge is None:
        factor = at.factor + float(np.copysign(reach, at.slope))
    else:
        factor = float(at.factor + far * at.slope * min(1.0, limit / max(turned, 1e-300)))
    bordered.newton.place(x, factor)
    factor, trail, status = bordered.correct(x, factor, row)
    if status is not None:
        raise _LostError(status, trail)
    return x, factor, trail


def try_step(bordered: Bordered, gauge: Gauge | None, at: Point, reach: float) -> Trial:
    """:func:`settle`, and where the path goes on from there.

    Raises _LostError also when the path turns too much on the way to be sure it is the same path.
    """
    x, factor, trail = settle(bordered, gauge, at, reach)
    found = bordered.tangent(x, factor)
    if isinstance(found, Status):
        raise _LostError(found, trail)
    along = dot(found[0], at.tangent, bordered.length)
    if np.isinf(at.slope) or np.isinf(found[1]):  # nothing moves at one end: only the load factor tells the sense
        along = float(np.sign(at.slope))
    tangent = np.copysign(1.0, along) * found[0]
    if abs(along) < STRAIGHT or (gauge is not None and gauge.rate(tangent) <= 0.0):
        raise _LostError(SHARP, trail)
    return Trial(Point(x, factor, tangent, float(np.copysign(found[1], along))), reach, trail)


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

    ``turning_points``, ``critical``, ``cuts`` and ``ledger`` are what was found on the way; states go to the recorder.
    Stability is looked at when there is a ``watch``.
    """

    def __init__(
        self, newton: Newton, control: Control, recorder: Recorder, save_every: int, watch: Watch | None = None
    ) -> None:
        self.newton, self.disc, self.bordered = newton, newton.disc, Bordered(newton)
        self.control, self.recorder, self.save_every = control, recorder, save_every
        self.turning_points: list[TurningPoint] = []
        self.watch, self.critical = watch, list[CriticalPoint]()
        self.counts: list[int] = []  # negative pivots of the saved states, and what they are at the point
        self.inside = 0
        self.turns = list(control.turns) if isinstance(control, ArcLength) else []
        self.by: Gauge | None = None  # what measures the step that is tried; the load factor without one
        self.met = 0  # bifurcations since the start, or since the last branch was taken
        self.arc, self.steps, self.cuts, self.parts, self.kept = 0.0, 0, 0, 0, True
        self.ended: Status | None = None

    @property
    def factor(self) -> float:
        """Load factor of the last state."""
        return self.point.factor

    def begin(self, x: Array, start: Result | None) -> Status | None:
        """Bring ``x`` to balance at the load factor it has; a Status when it cannot be. Raises ModelError."""
        if start is not None and start.kind != "static":
            raise ModelError("start= is a motion, which has no load factor to go on from", "start from solve_static")
        factor = 0.0 if start is None else float(start.load_factor[-1])
        self.loads = self.newton.loads(factor)
        self.newton.driver.place(factor, factor)
        self.newton.driver.shift()
        self.acting = self.newton.applied(x, self.loads)
        self.books = self.newton.books(x)
        self.ledger = StaticBooks(self.disc, self.books)
        self.point = Point(x.copy(), factor, np.zeros((self.disc.nodes, 6)), 0.0)
        outcome = self.newton.solve(x, self.loads, self.newton.place(x, factor))
        found = outcome.status or self.bordered.tangent(x, factor, at_limit=start is not None)
        if isinstance(found, Status):
            self._keep()
            sentence = f"there is no equilibrium to start from at load factor {factor:.6g}: {found.sentence}"
            return Status(found.code, sentence, HELD_UP if np.any(self.loads) else found.advice)
        tangent, slope = found
        self.gauge = gauge_for(self.control, self.bordered, x)
        self.reach, self.share = self.gauge.first, 1.0
        if not np.isfinite(slope) and not self.gauge.load_step(1.0, slope):
            raise ModelError(
                f"nothing moves with the load factor, at {factor:.6g}",
                "give a load that is neither constant nor on a support, nor a function that begins flat; if that is "
                "meant, ArcLength(load_step=…) follows such a path",
            )
        sense = self.gauge.orient(tangent, _onward(start))
        self.point = Point(x, factor, sense * tangent, sense * slope)
        self.gauge.walk(0.0, self.point.tangent)
        self.rising = sense
        if self.watch is not None:
            self.inside = self.watch.count = self.watch.pivots(x, factor)
        if start is None:
            self.acting[:] = 0.0
        self._book()
        self._keep()
        if self._asked():
            raise ModelError(
                f"until is true at the start, load factor {factor:.6g}", "give a rule that becomes true on the way"
            )
        return None

    def remember(self) -> dict[str, Any]:
        """All that the next step depends on."""
        point = self.point
        names = (
            "acting", "rising", "inside", "turns", "met", "arc", "steps", "cuts", "parts", "kept", "counts", "reach",
            "share",
        )  # fmt: skip
        return {
            "own": remember(self, *names), "newton": self.newton.remember(), "ledger": self.ledger.remember(),
            "point": [point.x.copy(), point.factor, point.tangent.copy(), point.slope],
            "trail": self.recorder.log.trail.remember(), "gauge": self.gauge.remember(),
            "watch": None if self.watch is None else self.watch.count,
            "ended": None if self.ended is None else vars(self.ended),
            "turning_points": [vars(p) for p in self.turning_points], "critical": [vars(p) for p in self.critical],
        }  # fmt: skip

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave, after :meth:`begin`."""
        recall(self, memory["own"])
        self.point = Point(*memory["point"])
        self.loads = self.newton.loads(self.point.factor)
        self.books = self.newton.recall(memory["newton"])
        self.ledger.recall(memory["ledger"])
        recall(self.gauge, memory["gauge"])
        self.recorder.log.trail.recall(memory["trail"])
        self.ended = None if memory["ended"] is None else Status(**memory["ended"])
        if self.watch is not None:
            self.watch.count = memory["watch"]
        self.turning_points = [TurningPoint(**p) for p in memory["turning_points"]]
        self.critical = [CriticalPoint(**p) for p in memory["critical"]]

    def go(self, progress: Progress, keeper: Keeper) -> Status:
        """Step on until the end, ``until``, the most steps, or a step that fails at its smallest."""
        if self.ended is not None and self._asked():  # it was killed after that, or until asks for no more than it did
            return self.ended
        status = self._go(progress, keeper)
        if status.success:
            self.ended = status
            keeper.keep(len(self.recorder.iterations), self.factor, self.remember, done=True)
        return status

    def _go(self, progress: Progress, keeper: Keeper) -> Status:
        gauge = self.gauge
        while gauge.left > 0.0:
            if keeper.due(tried := len(self.recorder.iterations)):
                keeper.keep(tried, self.factor, self.remember)
                if keeper.stopping:
                    return keeper.interrupted(f"load factor {self.factor:.6g}")
            reach, share = self.reach, self.share
            if self.steps >= gauge.most:
                return self._out_of_steps()
            steer = gauge.load_step(reach, self.point.slope)
            self.by = None if steer else gauge
            wish, part = (share * steer, True) if steer else gauge.goal(reach)
            try:
                whole = try_step(self.bordered, self.by, self.point, wish)
                trial, turned = self._first_event(whole)
                crossings = self._crossings(trial, turned)
            except _LostError as lost:
                self.recorder.log.tried(lost.trail, solved=False)
                self.cuts += 1
                self.reach, self.share = (reach, 0.5 * share) if steer else (0.5 * wish, share)
                if self.reach < gauge.smallest or self.share < SMALLEST:
                    return self._stuck(gauge.blame(self.point.tangent) or lost.status)
                continue
            self.reach, self.share = (
                (reach, min(1.0, 2.0 * share)) if steer else (gauge.after(wish, whole.iterations), share)
            )
            leaving = self._pass(crossings)
            if leaving is None:
                if crossings:
                    _rebase(trial.to.x, self.point.x, self.disc.nodes)
                self._take(trial, part and trial is whole, turned)
            else:
                trial = self._leave(*leaving)
                if isinstance(trial, Status):
                    return trial
                self.reach = gauge.after(trial.reach, trial.iterations)
            told = line("load factor", self.point.factor, self.recorder.iterations, cuts=self.cuts)
            progress(gauge.share(self.steps), told)
            if self._asked():
                return self._missed() or Status("stopped", f"until is true{self._here()}")
        return Status("done", f"reached {gauge.aim}{self._here()}")

    def close(self) -> None:
        """Keep the last state."""
        if not self.kept:
            self._keep()

    def _crossings(self, trial: Trial, turned: bool) -> list[Crossing]:
        """Bifurcations on the way to the end of a trial; its own limit point is not among them."""
        if self.watch is None:
            return []
        end = Settled(trial.reach, trial.to.x, trial.to.factor)
        if turned:
            end = self._settled(BEFORE_LIMIT * trial.reach)
        start = Settled(0.0, self.point.x, self.point.factor)
        return self.watch.between(start, end, self._settled, self.watch.pivots(end.x, end.factor))

    def _settled(self, reach: float) -> Settled:
        x, factor, _ = settle(self.bordered, self.by, self.point, reach)
        return Settled(reach, x, factor)

    def _pass(self, crossings: list[Crossing]) -> tuple[Crossing, int] | None:
        """Keep the bifurcations of a step. The one where the path is to be left, and to which side, if it is there."""
        for crossing in crossings:
            x = crossing.at.x
            _rebase(x, self.point.x, self.disc.nodes)
            self.point = self.point._replace(x=x, factor=crossing.at.factor)
            self._arrive()
            self.inside = crossing.inside
            self._keep()
            self._note("multiple bifurcation" if len(crossing.modes) > 1 else "simple bifurcation", crossing)
            self.met += 1
            if self.turns and self.met == abs(self.turns[0]):
                return crossing, 1 if self.turns[0] > 0 else -1
        return None

    def _leave(self, crossing: Crossing, side: int) -> Trial | Status:
        """Take the other path through a bifurcation: a step along its mode, corrected in the plane normal to that."""
        here = f"bifurcation {self.met} at load factor {self.point.factor:.6g}"
        if len(crossing.modes) > 1:
            return Status(
                "singular",
                f"{here} is multiple: {len(crossing.modes)} modes, and no telling which paths go through it.",
                "Hold a component that one of the modes moves, or make the model a little less symmetric.",
            )
        length, onto = self.bordered.length, self.point.tangent
        across = crossing.modes[0] - dot(crossing.modes[0], onto, length) * onto
        across *= side / np.sqrt(dot(across, across, length))
        reach = self.gauge.first
        while reach >= self.gauge.smallest:
            trial = self._sideways(across, reach)
            if trial is not None:
                self.turns, self.met = self.turns[1:], 0
                self.rising = float(np.copysign(1.0, trial.to.slope))
                if self.watch is not None:
                    self.watch.count = self.watch.pivots(trial.to.x, trial.to.factor)
                self._take(trial, True, False)
                return trial
            reach, self.cuts = 0.5 * reach, self.cuts + 1
        return Status(
            "not_converged", f"no other path was found through {here}.", "Try another ds, or refine the mesh."
        )

    def _sideways(self, across: Array, reach: float) -> Trial | None:
        """An equilibrium at the distance ``reach`` along ``across``, when the path through it goes that way too."""
        bordered, x = self.bordered, self.point.x.copy()
        limit, cayley = self.newton.options[4], self.newton.options[6] > 0.0
        kernel.move(reach * across, self.disc.nodes, x, False, cayley, limit)
        self.newton.place(x, self.point.factor)
        factor, trail, status = bordered.correct(x, self.point.factor, normal_to(across, reach, bordered.length))
        self.recorder.log.tried(trail, solved=status is None)
        found = status or bordered.tangent(x, factor)
        if isinstance(found, Status):
            return None
        along = dot(found[0], across, bordered.length)
        if abs(along) < ASIDE or travelled(x, self.disc.nodes, bordered.length) > reach / ASIDE:
            return None
        sense = float(np.copysign(1.0, along))
        return Trial(Point(x, factor, sense * found[0], sense * found[1]), reach, trail)

    def _note(self, kind: Kind, crossing: Crossing) -> None:
        """Remember the point just kept as a critical one."""
        at = self.recorder.count - 1
        self.critical.append(
            CriticalPoint(kind, crossing.factor, self.arc, at, crossing.before, crossing.after, crossing.modes)
        )

    def _first_event(self, whole: Trial) -> tuple[Trial, bool]:
        """The step up to the first limit point or load factor asked for on it, and whether that is a limit point."""

        def step(reach: float) -> Trial:
            return try_step(self.bordered, self.by, self.point, reach)

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
        crossing = self._limit() if turned and self.watch is not None else None
        self._arrive()
        if self.watch is not None:
            self.inside = self.watch.count if crossing is None else crossing.inside
        self.gauge.walk(trial.reach, self.point.tangent)
        self.recorder.log.tried(trial.trail, solved=True)
        self.steps, self.parts, self.kept = self.steps + 1, self.parts + part, False
        if turned or self.point.factor in self.control.load_factors or (part and self.parts % self.save_every == 0):
            self._keep()
        if turned:
            kind: Kind = "limit point (maximum)" if self.rising > 0.0 else "limit point (minimum)"
            self.turning_points.append(TurningPoint(kind, self.point.factor, self.arc, self.recorder.count - 1))
            if crossing is not None:
                self._note(kind, crossing)
            self.rising = -self.rising

    def _limit(self) -> Crossing:
        """What the stiffness says of a limit point: one eigenvalue vanishes, and changes its sign."""
        watch, x = self.watch, self.point.x
        assert watch is not None
        before, (inside, modes) = watch.count, watch.singular(x, self.point.factor)
        watch.count = inside + 1 if before == inside else inside
        return Crossing(Settled(0.0, x, self.point.factor), self.point.factor, before, inside, watch.count, modes)

    def _arrive(self) -> None:
        """Book the way to the point."""
        self.arc += travelled(self.point.x, self.disc.nodes, self.bordered.length)
        self.loads = self.newton.loads(self.point.factor)
        self._book()

    def _book(self) -> None:
        newton, x = self.newton, self.point.x
        newton.driver.place(self.point.factor, self.point.factor)
        before, self.acting = self.acting, newton.applied(x, self.loads)  # other states were tried since
        self.books = newton.finish(x, before)
        self.ledger.add(self.books, x[: self.disc.nodes, :3])

    def _keep(self) -> None:
        x, factor = self.point.x, self.point.factor
        self.recorder.keep(factor, factor, x[: self.disc.nodes, :3], x, self.books, self.ledger.flows)
        self.counts.append(self.inside)
        self.kept = True

    @property
    def stability(self) -> PathStability | None:
        """Of the saved states; None when nobody watched."""
        if self.watch is None:
            return None
        critical = np.zeros(len(self.counts), bool)
        critical[[p.index for p in self.critical]] = True
        return PathStability(np.array(self.counts, np.int64), critical, tuple(self.critical))

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
        points = self.turning_points if self.watch is None else self.critical
        return at + "".join(f"; {point}" for point in points) + "."

    def _out_of_steps(self) -> Status:
        if self.control.until is None:
            return self._missed() or Status("done", f"took all steps{self._here()}")
        return Status(
            "step_limit", f"until did not become true{self._here()}", "Raise max_steps, or go on with start=."
        )

    def _missed(self) -> Status | None:
        """The bifurcation where the path was to be left has not come."""
        if not self.turns:
            return None
        return Status(
            "step_limit",
            f"bifurcation {abs(self.turns[0])}, where another path was to be taken, was not met{self._here()}",
            "Go further, or name another one with branch=.",
        )

    def _stuck(self, why: Status) -> Status:
        why = explained(self.newton, self.point.x, why)
        return Status(
            why.code,
            f"stopped at load factor {self.point.factor:.6g}, arc length {self.arc:.6g}, after {self.cuts} cuts of the "
            f"step: {why.sentence}",
            why.advice,
        )


def _rebase(x: Array, onto: Array, nodes: int) -> None:
    """Count the step of a state from another one, just booked."""
    x[:nodes, 12:15], x[:nodes, 15:24] = x[:nodes, :3] - onto[:nodes, :3], onto[:nodes, 3:12]


def _onward(start: Result | None) -> Array | None:
    """The last increment (n, 6) of an earlier run, or None when it has none."""
    if start is None or len(start.t) < 2:
        return None
    turn = log(start.R[-1] @ np.swapaxes(start.R[-2], -1, -2))
    step = np.hstack([start.r[-1] - start.r[-2], turn])
    return step if np.any(step) else None
