"""How long the next time step is: a frozen strategy, and a value that says where it stands.

A step that cannot be taken is tried again, shorter, from the state that it began with.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.checks import number, step_count
from directrix.errors import ModelError
from directrix.integrators import Integrator

Array = NDArray[np.float64]

__all__ = ["Adaptive", "Beat", "Fixed", "Judged", "Stepping", "stepping", "way"]

PARTS = 4096
"""A fixed step is cut into so many parts at most."""
MOST_CUTS = 200
"""Within one fixed step, or of one adaptive step; then a run ends."""
SAFETY, SLOWEST, FASTEST = 0.9, 0.1, 2.0
MOST_WAITING = 64


@dataclass(frozen=True)
class Beat:
    """Where a motion is, and the step that it tries next.

    ``t`` to ``to`` is the step, ``dt`` long; ``asked`` says that somebody asked for the instant ``to``; ``done`` that
    nothing is left. ``k`` fixed steps (adaptive: instants that were asked for) are behind it. A fixed step is at
    ``part`` of PARTS, ``size`` of them long. ``wait`` good steps have to come before they grow, twice as many
    (``patience``) after every cut. ``wish`` is the length that an adaptive step would have if no instant were in the
    way, ``past`` the steps before: how long, and the mean rates over them; ``error`` the last one over its bound.
    """

    t: float
    to: float
    dt: float
    asked: bool
    done: bool = False
    k: int = 0
    cuts: int = 0
    part: int = 0
    size: int = PARTS
    wait: int = 0
    patience: int = 1
    wish: float = 0.0
    error: float = 1.0
    past: tuple[tuple[float, Array], ...] = ()

    @property
    def whole(self) -> bool:
        """True for a fixed step that is not cut."""
        return self.size == PARTS

    def remember(self) -> dict[str, Any]:
        """All of it, as plain values."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @staticmethod
    def recalled(memory: Mapping[str, Any]) -> Beat:
        """From what :meth:`remember` gave."""
        values: dict[str, Any] = {**memory, "past": tuple((float(dt), rates) for dt, rates in memory["past"])}
        return Beat(**values)


class Judged(NamedTuple):
    """A step that was solved: whether it is good enough, and what to try next; None when it cannot be shorter."""

    good: bool
    beat: Beat | None


@dataclass(frozen=True)
class Fixed:
    """Steps ``dt`` long from ``t0`` on, ``steps`` of them. One that is not solved is cut in halves, down to 1/4096."""

    dt: float
    t0: float
    steps: int
    adaptive: ClassVar[bool] = False

    @property
    def on_time(self) -> bool:
        """True when only instants that were asked for are kept."""
        return True

    def first(self) -> Beat:
        """The first step."""
        return self._at(Beat(0.0, 0.0, self.dt, True))

    def times(self, steps: NDArray[np.int64]) -> Array:
        """When so many whole steps have been taken."""
        return self.t0 + steps.astype(np.float64) * self.dt

    def again(self, beat: Beat) -> Beat:
        """``beat`` of a run that is gone on with, maybe to another end. Raises ModelError when it is past that."""
        if beat.k > self.steps:
            raise ModelError(f"the run has reached t = {beat.t:g} already", "give a later end", "t_end=")
        return replace(beat, done=beat.k == self.steps)

    def _at(self, beat: Beat) -> Beat:
        t0, dt, k = self.t0, self.dt, beat.k
        end = beat.part + beat.size
        t = t0 + (k + beat.part / PARTS) * dt if beat.part else t0 + k * dt
        to = t0 + (k + 1) * dt if end == PARTS else t0 + (k + end / PARTS) * dt
        return replace(beat, t=t, to=to, dt=dt * (beat.size / PARTS), asked=end == PARTS, done=k == self.steps)

    def on(self, beat: Beat, steps: int) -> Beat:
        """After so many more whole steps."""
        return self._at(replace(beat, k=beat.k + steps, cuts=0))

    def shorter(self, beat: Beat) -> Beat | None:
        """What to try when the step could not be solved; None when it is short enough to give up."""
        if beat.size == 1 or beat.cuts >= MOST_CUTS:
            return None
        patience = min(2 * beat.patience, MOST_WAITING)
        return self._at(replace(beat, size=beat.size // 2, cuts=beat.cuts + 1, wait=patience, patience=patience))

    def judge(self, beat: Beat, rates: Array | None = None, length: float = 1.0) -> Judged:
        """What comes after a step that was solved."""
        if beat.whole:
            return Judged(True, self.on(replace(beat, patience=1), 1))
        part, size, wait, patience = beat.part + beat.size, beat.size, max(0, beat.wait - 1), beat.patience
        if wait == 0 and part % (2 * size) == 0:
            size, patience, wait = 2 * size, max(1, patience // 2), 1
        on = part == PARTS
        beat = replace(beat, part=part % PARTS, size=size, wait=wait, patience=patience)
        return Judged(True, self._at(replace(beat, k=beat.k + 1, cuts=0) if on else beat))

    def fraction(self, beat: Beat) -> float:
        """Of the way."""
        return (beat.k + beat.part / PARTS) / self.steps

    def why(self, beat: Beat) -> str:
        """A sentence on a run that ended because steps could not be shorter."""
        return f"its step of {self.dt:g} was cut {beat.cuts} times, down to {beat.dt:.3g}"


@dataclass(frozen=True)
class Adaptive:
    """Steps as long as an error allows: ``dx.simulate(model, t_end, dt=dx.Adaptive(tolerance=1e-3))``.

    The local error of a step of second order is Δt³/12 · d³x/dt³. The third derivative comes from the mean rates of
    this step and the two before, x of every node: its position over the size of the model, and its rotation [rad].
    The largest node counts. A step above ``tolerance`` is taken again, shorter; the next one follows by a PI
    controller (Gustafsson 1991). A one-step scheme keeps what it keeps for any Δt, so also here; reversibility and
    the bounded energy error of schemes that do not conserve are those of constant steps.

    Offered for every integrator of order 2. The generalised-α family carries an acceleration that belongs to an
    instant between steps, which is moved when Δt changes.

    Parameters
    ----------
    tolerance
        Largest local error of a step, of positions over the size of the model and of rotations [rad].
    dt_min, dt_max
        Bounds of Δt; 1e-9 and 1/10 of the whole time unless given. A run that would need shorter steps ends and says
        so. Loads that come and go within ``dt_max`` may be overlooked.
    first
        Length of the first step that is tried; 1e-4 ``dt_max`` unless given.
    save_at
        Steps end at the multiples of this interval after the start, and those states are kept, not interpolated ones.
        Unless given, every ``save_every``-th step is kept, wherever it ends.
    """

    tolerance: float = 1e-3
    dt_min: float | None = None
    dt_max: float | None = None
    first: float | None = None
    save_at: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 < number(self.tolerance, "tolerance of the steps") < 1.0:
            raise ModelError(f"tolerance of the steps = {self.tolerance:g} is not between 0 and 1", "give e.g. 1e-4")
        for name in ("dt_min", "dt_max", "first", "save_at"):
            if getattr(self, name) is not None:
                number(getattr(self, name), name, above=0.0)
        for small, large in (("dt_min", "dt_max"), ("dt_min", "first"), ("first", "dt_max")):
            a, b = getattr(self, small), getattr(self, large)
            if a is not None and b is not None and a > b:
                raise ModelError(f"{small} = {a:g} is longer than {large} = {b:g}", "exchange them")


@dataclass(frozen=True)
class Controlled:
    """An :class:`Adaptive` from ``t0`` to ``t_end``, ``shortest`` to ``longest`` steps, with so many ``instants``."""

    given: Adaptive
    t0: float
    t_end: float
    shortest: float
    longest: float
    instants: int
    adaptive: ClassVar[bool] = True

    @property
    def on_time(self) -> bool:
        """True when only instants that were asked for are kept."""
        return self.given.save_at is not None

    def first(self) -> Beat:
        """The first step."""
        wish = min(self.longest, max(self.shortest, self.given.first or 1e-4 * self.longest))
        return self._at(Beat(self.t0, self.t0, 0.0, True, wish=wish))

    def _at(self, beat: Beat) -> Beat:
        """The step that ``wish`` becomes with the next instant that is asked for in view."""
        k = beat.k + 1
        goal = self.t_end if k >= self.instants else self.t0 + k * (self.given.save_at or 0.0)
        left, dt = goal - beat.t, beat.wish
        if dt >= left * (1.0 - 1e-9):
            return replace(beat, to=goal, dt=left, asked=True, done=beat.k >= self.instants)
        # two equal steps, not a long one and a crumb
        dt = 0.5 * left if 2.0 * dt > left else dt
        return replace(beat, to=beat.t + dt, dt=dt, asked=False)

    def again(self, beat: Beat) -> Beat:
        """See :meth:`Fixed.again`; the end is the same."""
        return beat

    def shorter(self, beat: Beat) -> Beat | None:
        """See :meth:`Fixed.shorter`."""
        patience = min(2 * beat.patience, MOST_WAITING)
        return self._again(replace(beat, wait=patience, patience=patience), 0.5)

    def _again(self, beat: Beat, factor: float) -> Beat | None:
        wish = factor * beat.dt
        if wish < self.shortest or beat.cuts >= MOST_CUTS:
            return None
        return self._at(replace(beat, wish=wish, cuts=beat.cuts + 1))

    def judge(self, beat: Beat, rates: Array | None = None, length: float = 1.0) -> Judged:
        """What comes after a step that was solved with mean ``rates`` (n, 12), for a model of some ``length``."""
        assert rates is not None
        error = max(_error(beat.dt, rates, beat.past, length) / self.given.tolerance, 1e-12)
        if not error <= 1.0:
            factor = min(SAFETY, max(SLOWEST, SAFETY * error ** (-1.0 / 3.0))) if np.isfinite(error) else SLOWEST
            return Judged(False, self._again(replace(beat, error=error, wait=max(1, beat.wait)), factor))
        factor = SAFETY * error ** (-0.7 / 3.0) * beat.error ** (0.4 / 3.0)
        factor = min(1.0 if beat.wait else FASTEST, max(SLOWEST, factor))
        # a step that was short because an instant came does not make the next one short
        wish = min(self.longest, max(self.shortest, factor * beat.dt, beat.wish if beat.asked and factor >= 1.0 else 0))
        past = ((beat.dt, rates), *beat.past[:1])
        calm = max(0, beat.wait - 1)
        beat = replace(
            beat, t=beat.to, wish=wish, error=error, past=past, wait=calm, cuts=0, k=beat.k + beat.asked,
            patience=beat.patience if calm else max(1, beat.patience // 2),
        )  # fmt: skip
        return Judged(True, replace(beat, done=True) if beat.k >= self.instants else self._at(beat))

    def fraction(self, beat: Beat) -> float:
        """Of the way."""
        return (beat.t - self.t0) / (self.t_end - self.t0)

    def why(self, beat: Beat) -> str:
        """See :meth:`Fixed.why`."""
        most = "" if beat.error <= 1.0 else f", where its error is {beat.error:.3g} times the tolerance"
        return f"no step longer than dt_min = {self.shortest:.3g} was good enough: the last was {beat.dt:.3g}{most}"


Stepping = Fixed | Controlled


def stepping(dt: float | Adaptive, t0: float, t_end: float, integrator: Integrator) -> Stepping:
    """The strategy for ``dt``; raises ModelError for what cannot be."""
    if not isinstance(dt, Adaptive):
        dt = number(dt, "dt", above=0.0)
        return Fixed(dt, t0, step_count(t0, t_end, dt))
    if integrator.order != 2:
        raise ModelError(
            f"Adaptive(…) estimates the error of a step of order 2, and {integrator!r} is of order {integrator.order}: "
            "what it dissipates would not be in the estimate",
            "use an integrator of order 2, or a fixed dt",
            "dt=",
        )
    if not t_end > t0:
        raise ModelError(f"t_end = {t_end} is not after the start at t = {t0:g}", "give a later end", "t_end=")
    span = t_end - t0
    longest = min(span, dt.dt_max or 0.1 * span)
    shortest = min(longest, dt.dt_min or 1e-9 * span)
    instants = 1 if dt.save_at is None else step_count(t0, t_end, dt.save_at, "save_at")
    return Controlled(dt, t0, t_end, shortest, longest, instants)


def way(x: Array, nodes: int) -> Array:
    """(n, 12) by how much the nodes of a solved step move: positions, and the columns of their rotations."""
    return np.concatenate([x[:nodes, 12:15], x[:nodes, 3:12] - x[:nodes, 15:24]], axis=1)


def _error(dt: float, rates: Array, past: tuple[tuple[float, Array], ...], length: float) -> float:
    """Δt³/12 times the third derivative by divided differences; of a first step what it is off from its start."""
    (before, old), *more = past
    bend = (rates - old) / (dt + before)
    if more:
        ((earlier, oldest),) = more
        bend = (bend - (old - oldest) / (before + earlier)) / (dt + before + earlier)
        bend *= 0.5 * dt
    far = np.linalg.norm(bend[:, :3], axis=1).max() / length
    turned = np.linalg.norm(bend[:, 3:], axis=1).max() / np.sqrt(2.0)
    return float(dt * dt * max(far, turned))
