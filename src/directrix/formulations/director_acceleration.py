"""The director element with accelerations as unknowns, in balance at the end of a step (Lie-group schemes)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from directrix.formulations.directors import (
    DirectorElement,
    Rule,
    coordinates,
    elastic_stress,
    flows,
    internal,
    local,
    mass_times,
    on_nodes,
    sub6,
    weight,
)
from directrix.formulations.directors import strains as director_strains
from directrix.formulations.layout import PER_NODE, Layout, Scalar, Step, Vector, points
from directrix.formulations.rotational import columns
from directrix.formulations.so3 import add, from_body, log, scale, sub, times, transposed
from directrix.kernels.trace import cross

__all__ = ["DirectorAcceleration"]

AT_END = Rule(static=True)


@dataclass(frozen=True)
class DirectorAcceleration(DirectorElement):
    """Π(d1)ᵀ { M ẍ1 + ∫ Bᵀ(x1) S(x1) dS }, an :class:`Element`.

    With q = (Δr, Θ), R1 = R0 exp(Θ): velocity c_v q + v*, acceleration c_a q + a*. In the place of the rates a node
    holds v*, a* (translation), Ω*, A* (rotation, body frame); ``g`` = (c_v, c_a). d̈_i = R1 (Ω×(Ω×d_i⁰) + A×d_i⁰).
    """

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`."""
        parts = layout.split(p)
        d0 = parts[0]
        q = coordinates(layout, x, d0, 0)
        total: list[list[Vector]] = []
        turning: list[Sequence[Vector]] = []
        moving: list[Sequence[Vector]] = []
        second: list[list[Vector]] = []
        stresses: list[Scalar] = []
        for a in range(layout.nn):
            y = x[PER_NODE * a : PER_NODE * a + PER_NODE]
            step, before, after = (y[12:15], columns(y, 15), columns(y, 3))
            turn = log(times(transposed(before), after))
            omega = add(scale(g[0], turn), y[30:33])
            spin = add(scale(g[1], turn), y[33:36])
            bent = [
                from_body(after, add(cross(omega, cross(omega, d)), cross(spin, d)))
                for d in (d0[9 * a + 3 * i : 9 * a + 3 * i + 3] for i in range(2))
            ]
            second.append([add(scale(g[1], step), y[27:30]), *bent])
            moving.append((q[a][0], step))
            turning.append(after)
            total.append([(0.0, 0.0, 0.0)] * 4)
        for k, (w, n, dn) in enumerate(points(layout.nn, layout.points)):
            at = local(q, n, dn)
            e = sub6(director_strains(at, parts[2][k]), parts[3][6 * k : 6 * k + 6])
            s = elastic_stress(layout, AT_END, parts, k, (e, e, e))
            stresses += s
            force = internal(at, n, dn, w, s)
            total = [[add(a, b) for a, b in zip(*pair, strict=True)] for pair in zip(total, force, strict=True)]
        if layout.eccentric:
            for node, heavy in zip(total, weight(layout, parts, True), strict=True):
                node[:3] = [sub(a, b) for a, b in zip(node[:3], heavy, strict=True)]
        for node, inertia in zip(total, mass_times(layout, parts, second), strict=True):
            node[:3] = [add(a, b) for a, b in zip(node[:3], inertia, strict=True)]
        through = [[c for node in total for v in node[1:] for c in v], stresses]
        return Step(on_nodes(q, total), moving, turning, through)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """See :func:`directrix.formulations.directors.flows`: work with the mean of the stresses at both ends."""
        d0 = layout.split(p)[0]
        q1, q0 = (coordinates(layout, x, d0, first) for first in (0, 12))
        return flows(layout, AT_END, q1, q0, p, g)
