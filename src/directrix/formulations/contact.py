"""Contact by a penalty, in director coordinates (elements, over scalars): nodes against surfaces, axis against axis.

With the penetration e and p = max(e, 0) the energy is W = ½ k p³/(p + w): nothing at all outside, then a force that
grows from zero slope and is k (e − ½ w) or so from e = 2 w on. A step takes the mean force ΔW/Δe on the line of its
middle, so that what it does is ΔW exactly. Friction is a force −μ N v/√(v² + v0²) on the surfaces where they meet,
v their sliding Δs/Δt; what it takes is that force times Δs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from directrix.formulations import rotational as rot
from directrix.formulations.attached import Attached, books, length
from directrix.formulations.layout import Layout, Scalar, Step, Vector
from directrix.formulations.so3 import add, cayley_vector, relative, scale, sub
from directrix.kernels.trace import cross, dot

__all__ = ["SOFTENING", "ObstacleElement", "PairElement"]

SOFTENING = 7  # place among the common scalars: what is added to the slip speed, in slip speeds


def _absolute(a: Scalar) -> Scalar:
    """|a|, with a slope of 0 at 0."""
    return (a * a + 1e-300) ** 0.5


def _positive(a: Scalar) -> Scalar:
    """max(a, 0), exactly 0 below."""
    return 0.5 * (a + _absolute(a))


def _energy(e: Scalar, k: Scalar, w: Scalar) -> Scalar:
    """W(e)."""
    p = _positive(e)
    return 0.5 * k * p * p * p / (p + w)


def _away(d: Vector) -> Scalar:
    """|d| for derivatives that divide by its cube: on the axis of a pipe there is no direction, and no force either."""
    return (dot(d, d) + 1e-200) ** 0.5


def _mean_force(e0: Scalar, e1: Scalar, k: Scalar, w: Scalar) -> Scalar:
    """ΔW/Δe without a difference: (p1 − p0)/(e1 − e0) times ΔW/Δp, and each is a quotient of sums."""
    p0, p1 = _positive(e0), _positive(e1)
    share = 0.5 + 0.5 * (e0 + e1) / (_absolute(e0) + _absolute(e1))
    top = p0 * p1 * (p0 + p1) + w * (p0 * p0 + p0 * p1 + p1 * p1)
    return 0.5 * k * share * top / ((p0 + w) * (p1 + w))


def _turn(n: rot.Node) -> Vector:
    """ϑ with R1 = cay(ϑ) R0: what a moment works on in a step."""
    return cayley_vector(relative(n.R, n.R0))


@dataclass(frozen=True)
class _Friction:
    """Sliding per step, the force on the first surface and what it takes."""

    force: Vector
    lost: Scalar


def _rub(slip: Vector, normal: Vector, pressure: Scalar, mu: Scalar, slow: Scalar, g: Sequence[Scalar]) -> _Friction:
    """Friction for relative displacements ``slip`` of a step; only what is tangential counts."""
    along = sub(slip, scale(dot(slip, normal), normal))
    v = scale(g[1], along)
    slow = slow * (1.0 + g[SOFTENING])
    share = mu * pressure / (dot(v, v) + slow * slow) ** 0.5
    return _Friction(scale(-1.0 * share, v), share * dot(v, along))


@dataclass(frozen=True)
class ObstacleElement(Attached):
    """A node against a surface that is fixed (an :class:`Element` of one node).

    Parameters: point (3), axis (3), radius R of the surface, side, radius ρ of the rod, k, w, μ, v0. The axis is the
    outer normal of a plane (``flat``), the unit axis of a cylinder, or zero for a sphere; ``side`` is 1 for a rod
    outside and −1 for one inside. Gap: n·(r − point) − ρ, or side (ℓ − R) − ρ, ℓ the distance from the point or axis.
    """

    flat: bool = False
    rough: bool = False

    def _gap(self, y: Vector, p: Sequence[Scalar]) -> tuple[Scalar, Scalar, Vector]:
        """Gap, ℓ and the vector of that length, for r − point = ``y``."""
        if self.flat:
            away = dot(y, p[3:6])
            return away - p[8], away, p[3:6]
        out = sub(y, scale(dot(y, p[3:6]), p[3:6]))
        away = _away(out)
        return p[7] * (away - p[6]) - p[8], away, out

    def _push(self, n: rot.Node, p: Sequence[Scalar]) -> tuple[Scalar, Vector]:
        """Normal force and its direction; a sphere's is not of length 1, see :class:`LinkElement`."""
        y1 = sub(n.r, p[0:3])
        g1, a, d1 = self._gap(y1, p)
        if not self.half:
            return _mean_force(-1.0 * g1, -1.0 * g1, p[9], p[10]), d1 if self.flat else scale(p[7] / a, d1)
        g0, b, d0 = self._gap(sub(y1, n.step), p)
        force = _mean_force(-1.0 * g0, -1.0 * g1, p[9], p[10])
        return force, d1 if self.flat else scale(p[7] / (a + b), add(d0, d1))

    def _friction(self, n: rot.Node, p: Sequence[Scalar], g: Sequence[Scalar]) -> tuple[Vector, _Friction]:
        """Arm from the node to where the surfaces meet, and friction there."""
        force, out = self._push(n, p)
        size = _away(out)
        normal = scale(1.0 / size, out)
        arm = scale(-1.0 * p[8], normal)
        slip = add(n.step, cross(_turn(n), arm))
        return arm, _rub(slip, normal, force * size, p[11], p[12], g)

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`; ``g`` = (2/Δt, 1/Δt)."""
        (n,) = rot.nodes(layout, x)
        force, out = self._push(n, p)
        on, moment = scale(-1.0 * force, out), [0.0 * force] * 3
        if self.rough:
            arm, friction = self._friction(n, p, g)
            on, moment = sub(on, friction.force), scale(-1.0, cross(arm, friction.force))
        return Step([*on, *moment], [(n.r, n.step)], [n.R])

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`: the stored energy."""
        (n,) = rot.nodes(layout, x)
        stored = _energy(-1.0 * self._gap(sub(n.r, p[0:3]), p)[0], p[9], p[10])
        return books(layout, stored, 0.0 * stored, [0.0 * stored] * 3, [0.0 * stored] * 3)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """What friction took in the step."""
        (n,) = rot.nodes(layout, x)
        return [self._friction(n, p, g)[1].lost]


@dataclass(frozen=True)
class _Meeting:
    """A point of one axis and a straight piece of another, over a step.

    ``place`` and ``square`` are the means of t and t² over the nearest places at x0 and x1 with their weights, see
    :class:`PairElement`; ``y`` from the start of the piece to the point and ``u`` along it, at the middle.
    """

    place: Scalar
    square: Scalar
    y: Vector
    u: Vector
    pull: Scalar  # N/ℓ
    end_pull: Scalar  # the same of the end of the piece, taken off

    def apart(self, t: Scalar) -> Vector:
        """From place t to the point."""
        return sub(self.y, scale(t, self.u))


@dataclass(frozen=True)
class PairElement(Attached):
    """A point of one rod's axis against a straight piece of another's (an :class:`Element` of nodes a1, a2, b1, b2).

    Parameters: place s of the point between a1 and a2, k (with the length that the point stands for), reach = sum of
    the radii, w, share of the first radius in it, ``end``, μ, v0. ℓ(x) is the distance to the nearest place t of the
    piece, 0 ≤ t ≤ 1, and W(reach − ℓ) the energy. Where the next piece begins at b2 (``end`` = 1), the energy of the
    distance to b2 is taken off: summed over the pieces, every point then counts once, also beside a corner.

    ℓ² = min_t q(t; x). With E0 = q(t1; x0) − q(t0; x0) ≥ 0 and E1 = q(t0; x1) − q(t1; x1) ≥ 0, t0 and t1 nearest at
    x0 and x1, Δℓ² = α [q(t0; x1) − q(t0; x0)] + (1 − α) [q(t1; x1) − q(t1; x0)] for α = E0/(E0 + E1), and each
    bracket is 2 d½(t)·Δd(t) at a fixed t. So the forces below, along d½(t) between two points of the middle, do ΔW
    exactly and have no resultant and no moment.
    """

    rough: bool = False

    def _nearest(self, y: Vector, u: Vector) -> Scalar:
        """Place of the piece nearest to the point, cut off at its ends."""
        t = dot(y, u) / (dot(u, u) + 1e-300)
        return 1.0 - _positive(1.0 - _positive(t))  # exactly 0 and 1 at the ends

    def _meet(self, at: Sequence[rot.Node], p: Sequence[Scalar]) -> _Meeting:
        a1, a2, b1, b2 = at
        ends = (1.0 - p[0], p[0])
        y1 = sub(_between(ends, a1.r, a2.r), b1.r)
        u1 = sub(b2.r, b1.r)
        t1 = self._nearest(y1, u1)
        d1, f1 = sub(y1, scale(t1, u1)), sub(y1, u1)
        b, c = length(d1), length(f1)
        if not self.half:
            pull = _mean_force(p[2] - b, p[2] - b, p[1], p[3]) / b
            off = p[5] * _mean_force(p[2] - c, p[2] - c, p[1], p[3]) / c
            return _Meeting(t1, t1 * t1, y1, u1, pull, off)
        y0 = sub(y1, sub(_between(ends, a1.step, a2.step), b1.step))
        u0 = sub(u1, sub(b2.step, b1.step))
        t0 = self._nearest(y0, u0)
        d0, f0 = sub(y0, scale(t0, u0)), sub(y0, u0)
        a, e = length(d0), length(f0)
        pull = 2.0 * _mean_force(p[2] - a, p[2] - b, p[1], p[3]) / (a + b)
        off = 2.0 * p[5] * _mean_force(p[2] - e, p[2] - c, p[1], p[3]) / (e + c)
        moved = t1 - t0
        uu0, uu1 = dot(u0, u0), dot(u1, u1)
        excess0 = moved * (moved * uu0 - 2.0 * dot(d0, u0))
        excess1 = moved * (moved * uu1 + 2.0 * dot(d1, u1))
        least = 1e-24 * (uu0 + uu1)
        share = (excess0 + least) / (excess0 + excess1 + 2.0 * least)
        # by differences: the slope of the share is large where the places are next to the same
        back = share * moved
        y, u = scale(0.5, add(y0, y1)), scale(0.5, add(u0, u1))
        return _Meeting(t1 - back, t1 * t1 - back * (t0 + t1), y, u, pull, off)

    def _friction(
        self, at: Sequence[rot.Node], m: _Meeting, p: Sequence[Scalar], g: Sequence[Scalar]
    ) -> tuple[Vector, Vector, _Friction]:
        """Arms from the two axes to where the surfaces meet, and friction on the first."""
        ends, on_piece = (1.0 - p[0], p[0]), (1.0 - m.place, m.place)
        out = m.apart(m.place)
        size = length(out)
        normal = scale(1.0 / size, out)
        # the arms add up to the whole distance: action and reaction are then at one point, and J is kept
        first, second = scale(-1.0 * p[4], out), scale(1.0 - p[4], out)
        spins = [_turn(n) for n in at]
        slip = sub(
            add(_between(ends, at[0].step, at[1].step), cross(_between(ends, *spins[:2]), first)),
            add(_between(on_piece, at[2].step, at[3].step), cross(_between(on_piece, *spins[2:]), second)),
        )
        pressure = _positive(m.pull * size - m.end_pull * length(m.apart(1.0)))
        return first, second, _rub(slip, normal, pressure, p[6], p[7], g)

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`; ``g`` = (2/Δt, 1/Δt)."""
        at = rot.nodes(layout, x)
        m = self._meet(at, p)
        nothing = [0.0 * m.pull] * 3
        off = scale(m.end_pull, m.apart(1.0))
        whole = sub(scale(m.pull, m.apart(m.place)), off)
        at_end = sub(scale(m.pull, sub(scale(m.place, m.y), scale(m.square, m.u))), off)
        forces = [scale(1.0 - p[0], whole), scale(p[0], whole), sub(at_end, whole), scale(-1.0, at_end)]
        moments: list[Vector] = [nothing] * 4
        if self.rough:
            first, second, friction = self._friction(at, m, p, g)
            rub = friction.force
            shares = (1.0 - p[0], p[0], m.place - 1.0, -1.0 * m.place)
            forces = [add(f, scale(s, rub)) for f, s in zip(forces, shares, strict=True)]
            turning = (cross(first, rub), cross(first, rub), cross(second, rub), cross(second, rub))
            moments = [scale(s, c) for s, c in zip(shares, turning, strict=True)]
        out: list[Scalar] = []
        for f, c in zip(forces, moments, strict=True):
            out += [*scale(-1.0, f), *scale(-1.0, c)]
        return Step(out, [(n.r, n.step) for n in at], [n.R for n in at])

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`: the stored energy."""
        a1, a2, b1, b2 = rot.nodes(layout, x)
        y = sub(_between((1.0 - p[0], p[0]), a1.r, a2.r), b1.r)
        u = sub(b2.r, b1.r)
        near = length(sub(y, scale(self._nearest(y, u), u)))
        stored = _energy(p[2] - near, p[1], p[3]) - p[5] * _energy(p[2] - length(sub(y, u)), p[1], p[3])
        return books(layout, stored, 0.0 * stored, [0.0 * stored] * 3, [0.0 * stored] * 3)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """What friction took in the step."""
        at = rot.nodes(layout, x)
        return [self._friction(at, self._meet(at, p), p, g)[2].lost]


def _between(weights: Sequence[Scalar], a: Vector, b: Vector) -> Vector:
    """Weighted sum of two vectors."""
    return add(scale(weights[0], a), scale(weights[1], b))
