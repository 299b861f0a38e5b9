"""What formulations that interpolate rotations share: nodes and history read, weak form, books (over scalars)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from directrix.formulations.directors import mass_times
from directrix.formulations.layout import HISTORY, PER_NODE, Layout, Point, Scalar, Vector, points
from directrix.formulations.so3 import Columns, add, from_body, scale, sub, to_body
from directrix.kernels.trace import cross, dot

__all__ = [
    "Node", "Section", "as_rows", "balance", "books", "columns", "frame", "nodes", "row", "slope", "spin_momentum",
    "strain",
]  # fmt: skip


class Node(NamedTuple):
    """A node's values: r1, columns of R1, Δr, columns of R0, ṙ, columns of Ṙ."""

    r: Vector
    R: Columns
    step: Vector
    R0: Columns
    v: Vector
    rate: Columns


class Section(NamedTuple):
    """A cross-section at a Gauss point: its frame (columns) and its curvature minus the reference one (body)."""

    frame: Columns
    curvature: Vector


def columns(x: Sequence[Scalar], first: int) -> Columns:
    """The three columns of a rotation whose nine values begin at ``first``."""
    return [x[first + 3 * c : first + 3 * c + 3] for c in range(3)]


def nodes(layout: Layout, x: Sequence[Scalar]) -> list[Node]:
    """The nodes of an element."""
    at = range(0, PER_NODE * layout.nn, PER_NODE)
    return [
        Node(
            x[i : i + 3], columns(x, i + 3), x[i + 12 : i + 15], columns(x, i + 15), x[i + 24 : i + 27],
            columns(x, i + 27),
        )
        for i in at
    ]  # fmt: skip


def row(layout: Layout, x: Sequence[Scalar], k: int) -> Section:
    """Row ``k`` of the history: frame (9), curvature (3)."""
    first = PER_NODE * (layout.nn + k)
    return Section(columns(x, first), x[first + 9 : first + HISTORY])


def as_rows(sections: Sequence[Section]) -> list[Scalar]:
    """Rows of history that hold ``sections``."""
    return [c for s in sections for c in (*s.frame[0], *s.frame[1], *s.frame[2], *s.curvature)]


def slope(positions: Sequence[Vector], dn: Sequence[float]) -> Vector:
    """dr/dξ."""
    return add(*(scale(float(d), r) for d, r in zip(dn, positions, strict=True)))


def strain(section: Section, tangent: Vector, inverse_j: Scalar, e0: Sequence[Scalar]) -> list[Scalar]:
    """Γ = Λᵀ r' − reference, and the curvature as it is; ``tangent`` is dr/dξ."""
    stretch = to_body(section.frame, scale(inverse_j, tangent))
    return [*(a - b for a, b in zip(stretch, e0[:3], strict=True)), *section.curvature]


def balance(point: Point, tangent: Vector, n: Vector, m: Vector) -> list[tuple[Vector, Vector]]:
    """Force and moment on each node of the stress resultants n, m (spatial) at a Gauss point.

    δr and the spin are interpolated by the shape functions: ∫ n·(δr' − δθ × r') + m·δθ' dS; ``tangent`` is dr/dξ.
    """
    w, shape, dn = point
    couple = cross(tangent, n)
    return [
        (scale(w * d, n), sub(scale(w * d, m), scale(w * value, couple))) for value, d in zip(shape, dn, strict=True)
    ]


def books(
    layout: Layout, at: Sequence[Node], p: Sequence[Scalar], strains: Sequence[Sequence[Scalar]],
    spins: Sequence[tuple[Scalar, Columns, Vector]] = (),
) -> list[Scalar]:  # fmt: skip
    """See :meth:`Element.audit`. ``spins`` are the inertia points: weight · dS/dξ, frame, angular velocity."""
    parts = layout.split(p)
    stored: Scalar = 0.0
    tail: list[Scalar] = []
    for g, ((w, _, _), inverse_j, e) in enumerate(
        zip(points(layout.nn, layout.points), parts[2], strains, strict=True)
    ):
        stored = stored + w / inverse_j * layout.energy(layout.at(parts[1], g), e)
        tail += [0.0 * e[0], *e]
    momentum = [m[0] for m in mass_times(layout, parts, [[n.v, n.v, n.v] for n in at])]
    kinetic = 0.5 * sum(dot(m, n.v) for m, n in zip(momentum, at, strict=True))
    linear, angular = add(*momentum), add(*(cross(n.r, m) for n, m in zip(at, momentum, strict=True)))
    for weight, frame, omega in spins:
        spin = scale(weight, spin_momentum(parts[5], frame, omega))
        kinetic = kinetic + 0.5 * dot(spin, omega)
        angular = add(angular, spin)
    turn = [sum(dot(a.R[c], b.R[c]) for c in range(3)) for a, b in itertools.pairwise(_turned(at, parts[0]))]
    return [stored, kinetic, *linear, *angular, *turn, *tail]


def _turned(at: Sequence[Node], d0: Sequence[Scalar]) -> list[Node]:
    """The nodes with their section frames in the place of R."""
    return [n._replace(R=frame(n.R, d0[9 * a : 9 * a + 9])) for a, n in enumerate(at)]


def frame(R: Columns, d0: Sequence[Scalar]) -> Columns:
    """Directors d_i = R d_i⁰ of an element end."""
    return [from_body(R, d0[3 * i : 3 * i + 3]) for i in range(3)]


def spin_momentum(inertia: Sequence[Scalar], axes: Columns, omega: Vector) -> Vector:
    """π = Λ J Λᵀ ω (paper B5), J = tr(I_ρ) 1 − I_ρ from the Euler dyadic I_ρ1, I_ρ2 (, I_ρ12)."""
    w = to_body(axes, omega)
    first, second, mixed = inertia[1], inertia[2], inertia[3] if len(inertia) > 3 else 0.0
    body = (second * w[0] - mixed * w[1], first * w[1] - mixed * w[0], (first + second) * w[2])
    return from_body(axes, body)
