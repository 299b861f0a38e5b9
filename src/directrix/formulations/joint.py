"""Joints in director coordinates (elements, over scalars).

Every constraint is at most quadratic in (r, R e_i), so Φ(x1) − Φ(x0) = ∇Φ(x½)·(x1 − x0): held at x1 by multipliers on
the gradient at x½ they do no work, and as they see only relative positions and rotations they exert no net force or
moment (Betsch & Steinmann 2002; Betsch & Leyendecker 2006).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from directrix.formulations import rotational as rot
from directrix.formulations.attached import Attached, AttachedLayout, books, discrete_ramp, ramp
from directrix.formulations.layout import PER_NODE, Layout, Scalar, Step, Vector
from directrix.formulations.so3 import (
    Columns,
    add,
    cayley_vector,
    from_body,
    relative,
    scale,
    sub,
    turn_over_sine,
)  # fmt: skip
from directrix.joints import KINDS, U, V, W
from directrix.kernels.trace import cross, dot

__all__ = ["COORDINATE", "DRIVE", "TARGET", "JointElement", "JointLayout"]

COORDINATE, TARGET, DRIVE = 6, 12, 13
"""Behind its six multipliers the row of a joint holds the coordinate at x0, the value prescribed at x1, the drive."""

ZERO = (0.0, 0.0, 0.0)
UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class JointLayout(AttachedLayout):
    """One or two nodes, and behind them the row of multipliers: three lengths, three angles."""

    last_adds: ClassVar[bool] = True


class _End(NamedTuple):
    """Arm, point, axes (v, w, u) and columns of R of an end at one state; the ground has no arm."""

    arm: Vector
    point: Vector
    axes: Columns
    R: Columns


class _Wrench(NamedTuple):
    """Gradient of a scalar: force on the point of what moves (opposite on the base), moments on what moves and base."""

    force: Vector
    mover: Vector
    base: Vector


class _Coordinate(NamedTuple):
    """The free coordinate at x0 and x1, and its gradient."""

    before: Scalar
    after: Scalar
    gradient: _Wrench


def _couple(moment: Vector) -> _Wrench:
    return _Wrench(ZERO, moment, scale(-1.0, moment))


def _times(amount: Scalar, w: _Wrench) -> _Wrench:
    return _Wrench(*(scale(amount, part) for part in w))


def _along(base: _End, mover: _End, axis: int) -> _Wrench:
    """∇ (p_b − p_a)·k_a."""
    k = base.axes[axis]
    return _Wrench(k, ZERO, cross(k, sub(mover.point, base.point)))


def _across(base: _End, mover: _End, i: int, j: int) -> _Wrench:
    """∇ i_a·j_b."""
    return _couple(cross(mover.axes[j], base.axes[i]))


def _mean(one: _End, other: _End) -> _End:
    def half(u: Vector, v: Vector) -> Vector:
        return scale(0.5, add(u, v))

    def each(u: Columns, v: Columns) -> Columns:
        return [half(*pair) for pair in zip(u, v, strict=True)]

    return _End(
        half(one.arm, other.arm), half(one.point, other.point), each(one.axes, other.axes), each(one.R, other.R)
    )


@dataclass(frozen=True)
class JointElement(Attached):
    """A joint (an :class:`Element`); parameters: arm (of the ground: place) and axes (9) of the base, the same of what
    moves, and where it is ``active``: k, rest, c, lower and upper stop, stop stiffness, stop width.

    The residual of its row are the constraints at x1. Where a step balances at x½ gradients are taken there and forces
    on the coordinate q are discrete gradients, F Δq = ΔV + c Δq²/Δt. An angle follows from s = sin q and c = cos q,
    both quadratic: (c̄ ∇s − s̄ ∇c)·Δx = sin Δq with the means s̄, c̄ of both ends, so Δq / sin Δq makes it ∇q.
    """

    kind: str = "spherical"
    grounded: bool = False
    driven: bool = False
    active: bool = False

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`; ``g`` = (2/Δt, 1/Δt)."""
        at, row = rot.nodes(layout, x)[:-1], _row(layout, x)
        now, before = self._ends(layout, x, p)
        held, wrench = self._balance(now, before, row, p, g)
        base, mover = (_mean(*pair) for pair in zip(now, before, strict=True)) if self.half else now
        pulled = [
            (scale(-1.0, wrench.force), sub(wrench.base, cross(base.arm, wrench.force))),
            (wrench.force, add(wrench.mover, cross(mover.arm, wrench.force))),
        ]
        out = [c for force, moment in pulled[self.grounded :] for c in (*force, *moment)]
        moving: list[Sequence[Vector]] = [*((n.r, n.step) for n in at), [row[0:3]]]
        turning: list[Sequence[Vector]] = [*(n.R for n in at), [row[3:6]]]
        return Step([*out, *held], moving, turning)

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`: the stored energy."""
        now, before = self._ends(layout, x, p)
        stored = 0.0 * x[0]
        if self.active and self._single:
            k, rest, _, low, high, stop, width = p[24:31]
            q = self._coordinate(now, before, now, _row(layout, x)).after
            beyond, below = ramp(q - high, width), ramp(low - q, width)
            stored = 0.5 * k * (q - rest) * (q - rest) + 0.5 * stop * (beyond * beyond + below * below)
        elif self.active:
            stored = 0.5 * p[24] * (3.0 - sum(dot(u, v) for u, v in zip(now[0].R, now[1].R, strict=True)))
        return books(layout, stored, 0.0 * stored, [0.0 * stored] * 3, [0.0 * stored] * 3)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """What its damper took in the step: c Δq²/Δt."""
        now, before = self._ends(layout, x, p)
        if self._single:
            q = self._coordinate(now, before, now, _row(layout, x))
            return [p[26] * g[1] * (q.after - q.before) * (q.after - q.before)]
        turned = _turned(now, before)
        return [p[26] * g[1] * dot(turned, turned)]

    def acts(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """Force and moment (about its point) on what moves, the coordinate at x1, its increment, and the forces on it
        that are prescribed motion's and the drive's."""
        row = _row(layout, x)
        now, before = self._ends(layout, x, p)
        wrench = self._balance(now, before, row, p, g)[1]
        out = [*scale(-1.0, wrench.force), *scale(-1.0, wrench.mover)]
        nothing = 0.0 * row[0]
        if not self._single:
            return [*out, nothing, nothing, nothing, nothing]
        q = self._coordinate(now, before, now, row)
        motion = -row[KINDS[self.kind].driven] if self.driven else nothing
        return [*out, q.after, q.after - q.before, motion, row[DRIVE] if self.active else nothing]

    @property
    def _single(self) -> bool:
        """True when one coordinate is free, or two of which one counts."""
        return KINDS[self.kind].free in ("angle", "displacement")

    def _ends(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> tuple[list[_End], list[_End]]:
        """Base and what moves, at x1 and at x0."""
        now: list[_End] = []
        before: list[_End] = []
        arms, axes = (p[0:3], p[12:15]), [[p[k + 3 * i : k + 3 * i + 3] for i in range(3)] for k in (3, 15)]
        if self.grounded:
            now.append(_End(ZERO, arms[0], axes[0], UNIT))
            before.append(now[0])
        for n in rot.nodes(layout, x)[:-1]:
            k = len(now)
            for ends, r, R in ((now, n.r, n.R), (before, sub(n.r, n.step), n.R0)):
                arm = from_body(R, arms[k])
                ends.append(_End(arm, add(r, arm), [from_body(R, a) for a in axes[k]], R))
        return now, before

    def _coordinate(
        self, now: Sequence[_End], before: Sequence[_End], middle: Sequence[_End], row: Sequence[Scalar]
    ) -> _Coordinate:
        base, mover = middle
        if KINDS[self.kind].free == "displacement":
            q0, q1 = (dot(sub(b.point, a.point), a.axes[U]) for a, b in (before, now))
            return _Coordinate(q0, q1, _along(base, mover, U))
        s0, s1 = (dot(a.axes[W], b.axes[V]) for a, b in (before, now))
        c0, c1 = (dot(a.axes[V], b.axes[V]) for a, b in (before, now))
        sine = s1 * c0 - c1 * s0
        ratio = turn_over_sine(c1 * c0 + s1 * s0, sine * sine)
        s, c = (0.5 * (s0 + s1) * ratio, 0.5 * (c0 + c1) * ratio) if self.half else (s1, c1)
        gradient = _sum(_times(c, _across(base, mover, W, V)), _times(-1.0 * s, _across(base, mover, V, V)))
        return _Coordinate(row[COORDINATE], row[COORDINATE] + ratio * sine, gradient)

    def _balance(
        self, now: list[_End], before: list[_End], row: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]
    ) -> tuple[list[Scalar], _Wrench]:
        """Constraints (6) at x1, and what pulls on both ends."""
        kind = KINDS[self.kind]
        base, mover = middle = [_mean(*pair) for pair in zip(now, before, strict=True)] if self.half else now
        gap = sub(now[1].point, now[0].point)
        held: list[Scalar] = [0.0 * row[0]] * 6
        parts: list[_Wrench] = []
        if kind.point:
            held[:3] = gap
            parts.append(_Wrench(row[0:3], ZERO, ZERO))
        for slot, axis in enumerate(kind.along):
            held[slot] = dot(gap, now[0].axes[axis])
            parts.append(_times(row[slot], _along(base, mover, axis)))
        for slot, (i, j) in enumerate(kind.across, start=3):
            held[slot] = dot(now[0].axes[i], now[1].axes[j])
            parts.append(_times(row[slot], _across(base, mover, i, j)))
        if self._single and (self.driven or self.active):
            q = self._coordinate(now, before, middle, row)
            if self.driven:
                held[kind.driven] = q.after - row[TARGET]
            force = row[kind.driven] if self.driven else self._force(q, p, g) - row[DRIVE]
            parts.append(_times(force, q.gradient))
        elif self.active:
            moment = scale(-0.5 * p[24], add(*(cross(v, u) for u, v in zip(base.R, mover.R, strict=True))))
            parts.append(_couple(moment))
            if self.half:
                parts.append(_couple(scale(p[26] * g[1], _turned(now, before))))
        return held, _sum(*parts)

    def _force(self, q: _Coordinate, p: Sequence[Scalar], g: Sequence[Scalar]) -> Scalar:
        """Of spring, stops and damper on the coordinate."""
        k, rest, c, low, high, stop, width = p[24:31]
        q0, q1 = (q.before, q.after) if self.half else (q.after, q.after)
        force = k * (0.5 * (q0 + q1) - rest) + c * g[1] * (q.after - q.before)
        beyond, below = discrete_ramp(q0 - high, q1 - high, width), discrete_ramp(low - q0, low - q1, width)
        return force + stop * (beyond - below)


def _row(layout: Layout, x: Sequence[Scalar]) -> Sequence[Scalar]:
    return x[PER_NODE * (layout.nn - 1) : PER_NODE * layout.nn]


def _sum(*parts: _Wrench) -> _Wrench:
    return _Wrench(*(add(*column) for column in zip(*parts, strict=True)))


def _turned(now: Sequence[_End], before: Sequence[_End]) -> Vector:
    """ϑ_b − ϑ_a, the Cayley vectors of what moves and of the base over the step."""
    a, b = (cayley_vector(relative(end.R, old.R)) for end, old in zip(now, before, strict=True))
    return sub(b, a)
