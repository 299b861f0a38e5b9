"""Springs, dashpots, cables and rigid bodies in director coordinates (elements, over scalars).

A point r + R c is linear in (r, R), so a step that balances at x½ does exactly the work of the energies below: the
conditions under which the rods conserve hold for what is attached to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from directrix.formulations import rotational as rot
from directrix.formulations.layout import Coordinates, Layout, Scalar, Step, Vector
from directrix.formulations.so3 import Columns, add, from_body, log, scale, sub, times, transposed
from directrix.kernels.trace import cross, dot
from directrix.scheme import Rates

__all__ = [
    "Attached", "AttachedLayout", "BodyElement", "LinkElement", "TendonElement", "books", "discrete_ramp", "length",
    "ramp",
]  # fmt: skip


@dataclass(frozen=True)
class AttachedLayout(Layout):
    """Some nodes and a plain list of ``size`` parameters; no stress points."""

    parameters: int = 0

    @property
    def sizes(self) -> tuple[int, ...]:
        """One block."""
        return (self.parameters,)


@dataclass(frozen=True)
class Attached:
    """What links, bodies, joints and contacts share: no history, no strains."""

    rates: Rates
    sampled = False

    def rows(self, layout: Layout) -> int:
        """No history."""
        return 0

    def reference(self, layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
        """No strains."""
        return []

    @property
    def half(self) -> bool:
        """True when the step balances at its middle."""
        return self.rates.half


@dataclass(frozen=True)
class _Straight(Attached):
    """What pulls along the line between two points; parameters begin with offsets (3, 3) or offset and place."""

    def _vectors(
        self, x: Sequence[Scalar], layout: Layout, p: Sequence[Scalar]
    ) -> tuple[list[rot.Node], Vector, Vector]:
        """Nodes, and from the first point to the second at x1 and x0."""
        at = rot.nodes(layout, x)
        after = [add(n.r, from_body(n.R, p[3 * k : 3 * k + 3])) for k, n in enumerate(at)]
        before = [add(sub(n.r, n.step), from_body(n.R0, p[3 * k : 3 * k + 3])) for k, n in enumerate(at)]
        if layout.nn == 1:
            after.append(p[3:6])
            before.append(p[3:6])
        return at, sub(after[1], after[0]), sub(before[1], before[0])

    def _pull(self, at: Sequence[rot.Node], p: Sequence[Scalar], force: Vector) -> Step:
        """``force`` from the first point to the second, as :meth:`Element.step` gives it."""
        out: list[Scalar] = []
        for k, n in enumerate(at):
            on = force if k == 1 else scale(-1.0, force)
            axes: Columns = [scale(0.5, add(u, v)) for u, v in zip(n.R, n.R0, strict=True)] if self.half else n.R
            out += [*on, *cross(from_body(axes, p[3 * k : 3 * k + 3]), on)]
        return Step(out, [(n.r, n.step) for n in at], [n.R for n in at])


@dataclass(frozen=True)
class TendonElement(_Straight):
    """A segment of a tendon of given tension (an :class:`Element`); behind the offsets T at the start and the end.

    The force 2T/(ℓ0 + ℓ1) d½ with T = ½(T0 + T1) does exactly the work −T Δℓ on what it pulls together.
    """

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`."""
        at, d1, d0 = self._vectors(x, layout, p)
        if self.half:
            return self._pull(at, p, scale(0.5 * (p[6] + p[7]) / (length(d0) + length(d1)), add(d0, d1)))
        return self._pull(at, p, scale(p[7] / length(d1), d1))

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`: nothing is stored."""
        nothing = 0.0 * p[6]
        return books(layout, nothing, nothing, [nothing] * 3, [nothing] * 3)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """Nothing dissipated; the work −½(T0 + T1) Δℓ."""
        _, d1, d0 = self._vectors(x, layout, p)
        return [0.0 * p[6], 0.5 * (p[6] + p[7]) * (length(d0) - length(d1))]


@dataclass(frozen=True)
class LinkElement(_Straight):
    """A link (an :class:`Element`); parameters: offsets (3, 3) or offset and place, k, ℓ0, c, width.

    With T the mean tension of a step, T Δℓ = ΔW + c Δℓ²/Δt, the force on the ends is 2T/(ℓ0 + ℓ1) d½ with
    d½ = ½(d0 + d1), whose work is T Δℓ. Statics and schemes that balance at x1 take T at x1.
    """

    cable: bool = False

    def _step(self, x: Sequence[Scalar], layout: Layout, p: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """Lengths at x0 and x1, tension of the step from its energy."""
        _, d1, d0 = self._vectors(x, layout, p)
        a, b = length(d0), length(d1)
        if not self.half:
            return b, b, self._tension(b - p[7], b - p[7], p)
        return a, b, self._tension(a - p[7], b - p[7], p)

    def _tension(self, e0: Scalar, e1: Scalar, p: Sequence[Scalar]) -> Scalar:
        """ΔW/Δe without a difference: W = ½ k e², or ½ k p² with the ramp p."""
        if not self.cable:
            return 0.5 * p[6] * (e0 + e1)
        return p[6] * discrete_ramp(e0, e1, p[9])

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`; ``g`` = (2/Δt, 1/Δt)."""
        at, d1, d0 = self._vectors(x, layout, p)
        a, b, tension = self._step(x, layout, p)
        if self.half:
            tension = tension + p[8] * g[1] * (b - a)
        middle = scale(0.5, add(d0, d1)) if self.half else d1
        return self._pull(at, p, scale(2.0 * tension / (a + b), middle))

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`: the stored energy."""
        e = length(self._vectors(x, layout, p)[1]) - p[7]
        pulled = ramp(e, p[9]) if self.cable else e
        return books(layout, 0.5 * p[6] * pulled * pulled, 0.0 * e, [0.0 * e] * 3, [0.0 * e] * 3)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """What the dashpot took in the step: c Δℓ²/Δt."""
        a, b, _ = self._step(x, layout, p)
        return [p[8] * g[1] * (b - a) * (b - a)]


@dataclass(frozen=True)
class BodyElement(Attached):
    """A rigid body (an :class:`Element` of one node); parameters: mass, Euler tensor E by its upper triangle.

    Its momenta are m ṙ and E_ij Ṙ e_j on the columns R e_i, so M is constant as for the rods.
    """

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`."""
        (n,) = rot.nodes(layout, x)
        if self.rates is Rates.DISSIPATIVE:  # its inertia is in the lumped mass of the node
            return Step([0.0 * p[0]] * 6, [(n.r, n.step)], [n.R])
        if self.rates is Rates.ALPHA:
            turn = log(times(transposed(n.R0), n.R))
            omega, spin = add(scale(g[0], turn), x[30:33]), add(scale(g[1], turn), x[33:36])
            linear = add(scale(g[1], n.step), x[27:30])
            unit = [tuple(1.0 if i == k else 0.0 for i in range(3)) for k in range(3)]
            second = [from_body(n.R, add(cross(omega, cross(omega, e)), cross(spin, e))) for e in unit]
            axes: Columns = n.R
        else:
            linear = scale(g[1], sub(scale(g[0], n.step), scale(2.0, n.v)))
            turned = [sub(a, b) for a, b in zip(n.R, n.R0, strict=True)]
            second = [scale(g[1], sub(scale(g[0], d), scale(2.0, c))) for d, c in zip(turned, n.rate, strict=True)]
            axes = [scale(0.5, add(a, b)) for a, b in zip(n.R, n.R0, strict=True)]
        moment = add(*(cross(axes[i], f) for i, f in enumerate(_euler_times(p, second))))
        return Step([*scale(p[0], linear), *moment], [(n.r, n.step)], [n.R])

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`."""
        (n,) = rot.nodes(layout, x)
        momentum, spins = scale(p[0], n.v), _euler_times(p, n.rate)
        kinetic = 0.5 * dot(momentum, n.v) + 0.5 * sum(dot(s, c) for s, c in zip(spins, n.rate, strict=True))
        angular = add(cross(n.r, momentum), *(cross(axis, s) for axis, s in zip(n.R, spins, strict=True)))
        return books(layout, 0.0 * kinetic, kinetic, momentum, angular)


def ramp(e: Scalar, width: Scalar) -> Scalar:
    """p(e) = ½(e + √(e² + w²)): 0 below, e above, smooth over the width w."""
    return 0.5 * (e + (e * e + width * width) ** 0.5)


def discrete_ramp(e0: Scalar, e1: Scalar, width: Scalar) -> Scalar:
    """½ Δ(p²)/Δe without a difference, p p' for e0 = e1."""
    q0, q1 = (e0 * e0 + width * width) ** 0.5, (e1 * e1 + width * width) ** 0.5
    ramps = 0.5 * (e0 + q0) + 0.5 * (e1 + q1)
    return 0.25 * ramps * (1.0 + (e0 + e1) / (q0 + q1))


def length(d: Vector) -> Scalar:
    """|d|; a link of no length has no direction, and no force either."""
    return (dot(d, d) + 1e-300) ** 0.5


def _euler_times(p: Sequence[Scalar], v: Sequence[Vector]) -> list[Vector]:
    """E_ij v_j from the upper triangle behind the mass."""
    place = {(0, 0): 1, (0, 1): 2, (0, 2): 3, (1, 1): 4, (1, 2): 5, (2, 2): 6}
    return [add(*(scale(p[place[min(i, j), max(i, j)]], v[j]) for j in range(3))) for i in range(3)]


def books(
    layout: Layout, stored: Scalar, kinetic: Scalar, linear: Sequence[Scalar], angular: Sequence[Scalar]
) -> list[Scalar]:
    """In the order of :meth:`Element.audit`; what is attached does not turn between its nodes."""
    return [stored, kinetic, *linear, *angular, *(0.0 * stored + 3.0 for _ in range(layout.nn - 1))]
