"""The element of Simo, Tarnow & Doblaré (1995) as in appendix B of the paper: Cayley vectors ϑ are interpolated.

At a Gauss point Λ1 = cay(ϑ) Λ0 (B4), with Λ½ = ½(Λ0 + Λ1) and Λ1 − Λ0 = ϑ × Λ½, so

    ΔΓ = Λ½ᵀ (Δr' − ϑ × r'½),     ΔK = Λ_cᵀ ϑ',   Λ_c = (1 + ½ ϑ̂) Λ0 / (1 + ¼ ϑ·ϑ)

and the stresses S* = C ½(ε0 + ε1) on n = Λ½ N*, m = Λ_c M* do exactly the work of the stored energy. What is not
exact is the kinetic energy of rotation: angular velocities are interpolated too, and that does not commute with (B4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from directrix.formulations import rotational as rot
from directrix.formulations.directors import Rule, elastic_stress, mass_times
from directrix.formulations.layout import Coordinates, Layout, Point, Scalar, Step, Vector, points
from directrix.formulations.simo_vu_quoc import initial, reference, strains
from directrix.formulations.so3 import (
    add,
    cayley,
    cayley_vector,
    combine,
    from_body,
    relative,
    scale,
    sub,
    times,
    to_body,
)
from directrix.kernels.trace import cross, dot

__all__ = ["SimoTarnowDoblareStep"]

RULE = Rule(w0=0.5, w1=0.5)


@dataclass(frozen=True)
class SimoTarnowDoblareStep:
    """An :class:`Element` with history: rows for the stress points, then for the inertia points."""

    sampled = True

    def rows(self, layout: Layout) -> int:
        """Stress points and inertia points (as many as nodes)."""
        return layout.points + layout.nn

    def reference(self, layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
        """As in :mod:`simo_vu_quoc`."""
        return reference(layout, q, inverse_j)

    def initial(self, layout: Layout, q: Coordinates) -> list[Scalar]:
        """See :class:`Committed`."""
        return initial(layout, q, (layout.points, layout.nn))

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`; ``g`` = (2/Δt, 1/Δt)."""
        parts, at = layout.split(p), rot.nodes(layout, x)
        middle = [sub(n.r, scale(0.5, n.step)) for n in at]
        thetas = [cayley_vector(relative(n.R, n.R0)) for n in at]
        before = [rot.row(layout, x, k) for k in range(layout.points)]
        after = _sections(layout, x, thetas, parts[2])
        starts = [n._replace(r=sub(n.r, n.step)) for n in at]
        e0, e1 = strains(layout, parts, starts, before), strains(layout, parts, at, after)
        total: list[list[Vector]] = [[(0.0,) * 3, (0.0,) * 3] for _ in at]
        for k, point in enumerate(points(layout.nn, layout.points)):
            s = elastic_stress(layout, RULE, parts, k, (e0[k], e1[k], e1[k]))
            theta = combine(point[1], thetas)
            mean = [scale(0.5, add(a, b)) for a, b in zip(before[k].frame, after[k].frame, strict=True)]
            m = from_body(before[k].frame, s[3:])
            m = scale(1.0 / (1.0 + 0.25 * dot(theta, theta)), add(m, scale(0.5, cross(theta, m))))
            forces = rot.balance(point, rot.slope(middle, point[2]), from_body(mean, s[:3]), m)
            total = [[add(a, b) for a, b in zip(*pair, strict=True)] for pair in zip(total, forces, strict=True)]
        for node, inertia in zip(total, _inertia(layout, x, parts, at, thetas, g), strict=True):
            node[:] = [add(a, b) for a, b in zip(node, inertia, strict=True)]
        forces = [c for node in total for v in node for c in v]
        return Step(forces, [(n.r, n.step) for n in at], [n.R for n in at])

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`; the history is that of x1."""
        parts, at = layout.split(p), rot.nodes(layout, x)
        sections = [rot.row(layout, x, k) for k in range(layout.points)]
        velocities = [angular_velocity(n.R, n.rate) for n in at]
        spins: list[tuple[Scalar, Sequence[Vector], Vector]] = []
        for k, (w, n, _) in enumerate(points(layout.nn, layout.nn)):
            axes = rot.row(layout, x, layout.points + k).frame
            spins.append((w * parts[7][k], axes, combine(n, velocities)))
        return rot.books(layout, at, p, strains(layout, parts, at, sections), spins)

    def commit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Committed`."""
        thetas = [cayley_vector(relative(n.R, n.R0)) for n in rot.nodes(layout, x)]
        rows = _sections(layout, x, thetas, layout.split(p)[2])
        for k, (_, n, _) in enumerate(points(layout.nn, layout.nn)):
            axes = rot.row(layout, x, layout.points + k).frame
            rows.append(rot.Section(times(cayley(combine(n, thetas)), axes), (0.0, 0.0, 0.0)))
        return rot.as_rows(rows)


def angular_velocity(R: Sequence[Vector], rate: Sequence[Vector]) -> Vector:
    """ω of Ṙ = ω̂ R."""
    return scale(0.5, add(*(cross(R[c], rate[c]) for c in range(3))))


def _sections(
    layout: Layout, x: Sequence[Scalar], thetas: Sequence[Vector], inverse_j: Sequence[Scalar]
) -> list[rot.Section]:
    """The stress points at x1 (B4)."""
    out: list[rot.Section] = []
    for k, point in enumerate(points(layout.nn, layout.points)):
        out.append(_after(rot.row(layout, x, k), thetas, point, inverse_j[k]))
    return out


def _after(before: rot.Section, thetas: Sequence[Vector], point: Point, inverse_j: Scalar) -> rot.Section:
    theta = combine(point[1], thetas)
    rate = scale(inverse_j, combine(point[2], thetas))
    axes = times(cayley(theta), before.frame)
    spin = scale(1.0 / (1.0 + 0.25 * dot(theta, theta)), add(rate, scale(0.5, cross(theta, rate))))
    return rot.Section(axes, add(before.curvature, to_body(axes, spin)))


def _inertia(
    layout: Layout, x: Sequence[Scalar], parts: Sequence[Sequence[Scalar]], at: Sequence[rot.Node],
    thetas: Sequence[Vector], g: Sequence[Scalar],
) -> list[tuple[Vector, Vector]]:  # fmt: skip
    """(B6): Δp/Δt at the nodes through the consistent mass, Δπ/Δt at the inertia points."""
    # v1 − v0 = (2/Δt) Δr − 2 v0 (B1), ω1 = (2/Δt) ϑ − cay(ϑ) ω0 (B2)
    change = [scale(g[1], sub(scale(g[0], n.step), scale(2.0, n.v))) for n in at]
    force = [node[0] for node in mass_times(layout, parts, [[c, c, c] for c in change])]
    start = [angular_velocity(n.R0, n.rate) for n in at]
    end = [
        sub(scale(g[0], theta), from_body(relative(n.R, n.R0), omega))
        for n, theta, omega in zip(at, thetas, start, strict=True)
    ]
    moment: list[Vector] = [(0.0, 0.0, 0.0)] * layout.nn
    for k, (w, n, _) in enumerate(points(layout.nn, layout.nn)):
        axes = rot.row(layout, x, layout.points + k).frame
        turned = times(cayley(combine(n, thetas)), axes)
        spin = sub(
            rot.spin_momentum(parts[5], turned, combine(n, end)), rot.spin_momentum(parts[5], axes, combine(n, start))
        )
        moment = [
            add(m, scale(w * float(value) * g[1] * parts[7][k], spin)) for m, value in zip(moment, n, strict=True)
        ]
    return list(zip(force, moment, strict=True))
