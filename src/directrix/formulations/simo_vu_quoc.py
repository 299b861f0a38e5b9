"""Simo & Vu-Quoc (1986): rotations carried at the Gauss points, increments of rotation interpolated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from directrix.formulations import rotational as rot
from directrix.formulations.layout import Coordinates, Layout, Point, Scalar, Step, Vector, points
from directrix.formulations.so3 import add, combine, exp, from_body, log, relative, scale, spin_rate, times, to_body

__all__ = ["SimoVuQuoc", "SimoVuQuocStatics"]


@dataclass(frozen=True)
class SimoVuQuoc:
    """The formulation of Simo & Vu-Quoc (1986), for comparison: neither objective nor path independent.

    Each Gauss point carries its rotation and curvature along: the nodes' rotation vectors of an iteration are
    interpolated, Λ ← exp(ψ) Λ and ω ← T(ψ) ψ' + exp(ψ) ω, so the result depends on the way that led to it. What is
    carried is part of the state: a step that is cut or tried again starts from where it started.
    Statics; in dynamics it is the kinematics of ``dx.SimoTarnowDoblare()``.
    """


@dataclass(frozen=True)
class SimoVuQuocStatics:
    """Its element in statics (an :class:`Element` with history: a row for each stress point)."""

    sampled = False

    def rows(self, layout: Layout) -> int:
        """One for each stress point."""
        return layout.points

    def reference(self, layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
        """Λᵀr' with the mean frame of the nodes; the curvature counts from zero."""
        return reference(layout, q, inverse_j)

    def initial(self, layout: Layout, q: Coordinates) -> list[Scalar]:
        """See :class:`Committed`."""
        return initial(layout, q, (layout.points,))

    def _section(
        self, layout: Layout, turns: Sequence[Vector], point: Point, inverse_j: Scalar, before: rot.Section
    ) -> rot.Section:
        psi = combine(point[1], turns)
        rate = spin_rate(psi, scale(inverse_j, combine(point[2], turns)))
        axes = times(exp(psi), before.frame)
        return rot.Section(axes, add(before.curvature, to_body(axes, rate)))

    def _sections(self, layout: Layout, x: Sequence[Scalar], inverse_j: Sequence[Scalar]) -> list[rot.Section]:
        turns = [log(relative(n.R, n.R0)) for n in rot.nodes(layout, x)]
        at = zip(points(layout.nn, layout.points), inverse_j, strict=True)
        return [self._section(layout, turns, point, j, rot.row(layout, x, k)) for k, (point, j) in enumerate(at)]

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`."""
        parts, at = layout.split(p), rot.nodes(layout, x)
        sections = self._sections(layout, x, parts[2])
        return Step(statics(layout, parts, at, sections), [(n.r,) for n in at], [n.R for n in at])

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`; the history is that of x1."""
        parts, at = layout.split(p), rot.nodes(layout, x)
        sections = [rot.row(layout, x, k) for k in range(layout.points)]
        return rot.books(layout, at, p, strains(layout, parts, at, sections))

    def commit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Committed`."""
        sections = self._sections(layout, x, layout.split(p)[2])
        return rot.as_rows(sections)


def reference(layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
    """(Λᵀr', 0) at the stress points of the reference, Λ from :func:`mean_frame`."""
    out: list[list[Scalar]] = []
    for (_, n, dn), j in zip(points(layout.nn, layout.points), inverse_j, strict=True):
        tangent = scale(j, rot.slope([node[0] for node in q], dn))
        axes = mean_frame(n, [node[1:] for node in q])
        out.append([*to_body(axes, tangent), *(0.0 * j for _ in range(3))])
    return out


def initial(layout: Layout, q: Coordinates, rules: Sequence[int]) -> list[Scalar]:
    """Frames of the reference, no curvature: a row for every point of the Gauss rules in turn."""
    nothing = 0.0 * q[0][0][0]
    out: list[Scalar] = []
    for count in rules:
        for _, n, _ in points(layout.nn, count):
            axes = mean_frame(n, [node[1:] for node in q])
            out += [*axes[0], *axes[1], *axes[2], nothing, nothing, nothing]
    return out


def mean_frame(n: Sequence[float], frames: Sequence[Sequence[Vector]]) -> Sequence[Vector]:
    """Frame between the nodal ones: rotation vectors from the first are interpolated."""
    turns = [log(relative(f, frames[0])) for f in frames]
    return times(exp(combine(n, turns)), frames[0])


def strains(
    layout: Layout, parts: Sequence[Sequence[Scalar]], at: Sequence[rot.Node], sections: Sequence[rot.Section]
) -> list[list[Scalar]]:
    """The six strains at each stress point."""
    out: list[list[Scalar]] = []
    for k, ((_, _, dn), section) in enumerate(zip(points(layout.nn, layout.points), sections, strict=True)):
        tangent = rot.slope([n.r for n in at], dn)
        out.append(rot.strain(section, tangent, parts[2][k], parts[3][6 * k : 6 * k + 6]))
    return out


def statics(
    layout: Layout, parts: Sequence[Sequence[Scalar]], at: Sequence[rot.Node], sections: Sequence[rot.Section]
) -> list[Scalar]:
    """Forces and moments on the nodes in statics: stresses at x1."""
    total: list[list[Vector]] = [[(0.0,) * 3, (0.0,) * 3] for _ in at]
    rows = zip(points(layout.nn, layout.points), sections, strains(layout, parts, at, sections), strict=True)
    for g, (point, section, e) in enumerate(rows):
        s = layout.stress(layout.at(parts[1], g), e)
        n, m = from_body(section.frame, s[:3]), from_body(section.frame, s[3:])
        forces = rot.balance(point, rot.slope([node.r for node in at], point[2]), n, m)
        total = [[add(a, b) for a, b in zip(*pair, strict=True)] for pair in zip(total, forces, strict=True)]
    return [c for node in total for vector in node for c in vector]
