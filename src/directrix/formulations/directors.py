"""The element of Romero & Armero (2002): directors interpolated directly.

Everything here is plain Python over scalars, for one element: floats, complex numbers, SymPy symbols and
arrays (one entry an element) work as well as the recording scalars of :mod:`directrix.kernels.trace`, from
which tangent and machine code are derived. Nothing is branched on a value.

``q`` is the element's vector x of director coordinates: per node a tuple (r, d1, d2, d3) of 3-tuples. Every
strain is a quadratic form of it, so the discrete-gradient identity ε(x1) − ε(x0) = B(x½)(x1 − x0) is exact.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from directrix.basis import gauss, lagrange
from directrix.kernels.trace import Graph, Sym, cross, derivative, dot

__all__ = [
    "Directors",
    "Layout",
    "Rule",
    "audit",
    "internal",
    "record_audit",
    "record_step",
    "residual",
    "strains",
]

Scalar = Any
Vector = Sequence[Scalar]
Coordinates = Sequence[Sequence[Vector]]
# Per node (r1, R1 e_i), (Δr, R0 e_i), (ṙ0, Ṙ0 e_i). The step Δr = r1 − r0 is kept by itself: far from the origin
# the difference of two positions would lose the digits that momentum is made of.
PER_NODE = 40  # 36 values, then room to a whole number of vectors


@dataclass(frozen=True)
class Directors:
    """Directors interpolated directly (paper section 3): objective and path independent.

    Between nodes the directors are shorter than one; a linear element that turns by 2δ strains by
    sin(2δ)/h. Quadratic elements are far better. Strains are quadratic in the unknowns, so
    energy–momentum steps are available.
    """


@dataclass(frozen=True)
class Rule:
    """One row of the midpoint family: S* = C (w0 ε0 + w1 ε1 + wh ε½); ``static`` evaluates all at x1."""

    w0: float = 0.0
    w1: float = 1.0
    wh: float = 0.0
    static: bool = False


@dataclass(frozen=True)
class Layout:
    """What kind of element, and where its parameters are.

    ``nn`` nodes; ``points`` Gauss points for the stresses; ``principal`` when stiffness and rotary inertia
    are diagonal. Parameters in order: reference directors (9 nn), stiffness (6 or the 21 of the upper
    triangle by rows), dξ/dS at the stress points, their reference strains (6 each), ∫N_a N_b dS
    (upper triangle by rows), A_ρ, I_ρ1, I_ρ2 (, I_ρ12).
    """

    nn: int
    points: int
    principal: bool

    @property
    def sizes(self) -> tuple[int, int, int, int, int, int]:
        """Lengths of the parameter blocks."""
        pairs = self.nn * (self.nn + 1) // 2
        small = self.principal
        return 9 * self.nn, 6 if small else 21, self.points, 6 * self.points, pairs, 3 if small else 4

    @property
    def size(self) -> int:
        """Number of parameters."""
        return sum(self.sizes)

    def split(self, p: Sequence[Scalar]) -> list[Sequence[Scalar]]:
        """The parameter blocks of ``p``."""
        parts: list[Sequence[Scalar]] = []
        first = 0
        for n in self.sizes:
            parts.append(p[first : first + n])
            first += n
        return parts


def place(x: Sequence[Scalar], d0: Sequence[Scalar]) -> tuple[Vector, Vector, Vector, Vector]:
    """(r, d1, d2, d3) of an element end from a node's (r, R e1, R e2, R e3); d_i = R d_i⁰ (paper A17)."""
    columns = [x[3 + 3 * c : 6 + 3 * c] for c in range(3)]
    directors = [tuple(sum(columns[c][k] * d0[3 * i + c] for c in range(3)) for k in range(3)) for i in range(3)]
    return tuple(x[:3]), directors[0], directors[1], directors[2]


def _sum(weights: Sequence[float], vectors: Sequence[Vector]) -> Vector:
    return tuple(sum(float(w) * v[k] for w, v in zip(weights, vectors, strict=True)) for k in range(3))


def _at_point(q: Coordinates, n: Sequence[float], dn: Sequence[float]) -> tuple[list[Vector], list[Vector]]:
    """Directors (d1, d2, d3) and the slopes (r, d1, d2, d3),ξ at a Gauss point."""
    d = [_sum(n, [node[i] for node in q]) for i in (1, 2, 3)]
    slope = [_sum(dn, [node[i] for node in q]) for i in range(4)]
    return d, slope


def strains(q: Coordinates, n: Sequence[float], dn: Sequence[float], inverse_j: Scalar) -> list[Scalar]:
    """Γ1, Γ2, Γ3, Ω1, Ω2, Ω3 of the configuration, without the reference values (paper 26, 34)."""
    d, s = _at_point(q, n, dn)
    r, d1, d2, d3 = s
    bend1 = 0.5 * (dot(d[2], d2) - dot(d[1], d3))
    bend2 = 0.5 * (dot(d[0], d3) - dot(d[2], d1))
    twist = 0.5 * (dot(d[1], d1) - dot(d[0], d2))
    return [inverse_j * e for e in (dot(d[0], r), dot(d[1], r), dot(d[2], r), bend1, bend2, twist)]


def _scale(a: Scalar, v: Vector) -> Vector:
    return tuple(a * c for c in v)


def _sub(a: Vector, b: Vector) -> Vector:
    return tuple(s - t for s, t in zip(a, b, strict=True))


def _add(*vectors: Vector) -> Vector:
    return tuple(sum(v[k] for v in vectors) for k in range(3))


def internal(
    q: Coordinates, n: Sequence[float], dn: Sequence[float], w: float, s: Sequence[Scalar]
) -> list[list[Vector]]:
    """w·dS/dξ·Bᵀ(q) S at one Gauss point, per node four vectors; B as in the strains above."""
    d, slope = _at_point(q, n, dn)
    t = [w * c for c in s]
    half = [0.5 * c for c in t[3:]]
    on_r = _add(*(_scale(t[i], d[i]) for i in range(3)))
    on_d: list[Vector] = []
    on_slope: list[Vector] = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # ½ Ω_k carries d_j·d_i' − d_i·d_j', and ½ Ω_j carries d_i·d_k' − d_k·d_i'
        on_d.append(_add(_scale(t[i], slope[0]), _scale(half[j], slope[1 + k]), _scale(-half[k], slope[1 + j])))
        on_slope.append(_add(_scale(half[k], d[j]), _scale(-half[j], d[k])))
    return [
        [_scale(float(dn[a]), on_r)]
        + [_add(_scale(float(n[a]), on_d[i]), _scale(float(dn[a]), on_slope[i])) for i in range(3)]
        for a in range(len(q))
    ]


def _stress(c: Sequence[Scalar], e: Sequence[Scalar]) -> list[Scalar]:
    if len(c) == 6:
        return [c[i] * e[i] for i in range(6)]
    full: dict[tuple[int, int], Scalar] = {}
    for i in range(6):
        for j in range(i, 6):
            full[i, j] = full[j, i] = c[i * 6 - i * (i - 1) // 2 + j - i]
    return [sum(full[i, j] * e[j] for j in range(6)) for i in range(6)]


def _points(layout: Layout) -> list[tuple[float, Sequence[float], Sequence[float]]]:
    xi, w = gauss(layout.points)
    n, dn = lagrange(layout.nn - 1, xi)
    return [(float(w[g]), n[g].tolist(), dn[g].tolist()) for g in range(layout.points)]


def _mass_times(layout: Layout, parts: Sequence[Sequence[Scalar]], v: Coordinates) -> list[list[Vector]]:
    """M v for one element, per node four vectors: A_ρ on r, the Euler dyadic on (d1, d2), nothing on d3."""
    m, inertia = parts[4], parts[5]
    out: list[list[Vector]] = []
    for a in range(layout.nn):
        weights: list[Scalar] = []
        for b in range(layout.nn):
            i, j = min(a, b), max(a, b)
            weights.append(m[i * layout.nn - i * (i - 1) // 2 + j - i])
        mean = [_add(*(_scale(weights[b], v[b][i]) for b in range(layout.nn))) for i in range(3)]
        on_d1, on_d2 = _scale(inertia[1], mean[1]), _scale(inertia[2], mean[2])
        if not layout.principal:
            on_d1 = _add(on_d1, _scale(inertia[3], mean[2]))
            on_d2 = _add(on_d2, _scale(inertia[3], mean[1]))
        out.append([_scale(inertia[0], mean[0]), on_d1, on_d2])
    return out


def residual(
    layout: Layout,
    rule: Rule,
    q1: Coordinates,
    q0: Coordinates,
    v0: Coordinates,
    p: Sequence[Scalar],
    dt: Sequence[Scalar],
) -> list[Scalar]:
    """Forces and moments of one element on its nodes, (force, moment) per node (paper 44–50, 67).

    ``q0`` holds Δr = r1 − r0 in the place of r0. ``dt`` holds 2/Δt and 1/Δt. With ``rule.static`` only ``q1``
    is read.
    """
    parts = layout.split(p)
    step = [node[0] for node in q0]
    q0 = [[_sub(b[0], a[0]), *a[1:]] for a, b in zip(q0, q1, strict=True)]
    middle = (
        q1
        if rule.static
        else [[_scale(0.5, _add(a, b)) for a, b in zip(*n, strict=True)] for n in zip(q0, q1, strict=True)]
    )
    total: list[list[Vector]] = [[(0.0, 0.0, 0.0)] * 4 for _ in range(layout.nn)]
    for g, (w, n, dn) in enumerate(_points(layout)):
        inverse_j, e0 = parts[2][g], parts[3][6 * g : 6 * g + 6]
        mixed = [0.0] * 6
        for weight, q in ((rule.w0, q0), (rule.w1, q1), (rule.wh, middle)):
            if weight:
                mixed = [m + weight * e for m, e in zip(mixed, strains(q, n, dn, inverse_j), strict=True)]
        s = _stress(parts[1], [m - e for m, e in zip(mixed, e0, strict=True)])
        force = internal(middle, n, dn, w, s)
        total = [[_add(a, b) for a, b in zip(*pair, strict=True)] for pair in zip(total, force, strict=True)]
    if not rule.static:
        # M (ẋ1 − ẋ0)/Δt with ẋ1 = (2/Δt)(x1 − x0) − ẋ0, by the very 2/Δt that updates ẋ: no bias in long runs
        rate = [
            [
                tuple(dt[1] * (dt[0] * d - 2.0 * c) for d, c in zip(delta, v, strict=True))
                for delta, v in zip(
                    [dr, *(_sub(b, a) for a, b in zip(x0[1:], x1[1:], strict=True))], rates, strict=True
                )
            ]
            for dr, x0, x1, rates in zip(step, q0, q1, v0, strict=True)
        ]
        for node, inertia in zip(total, _mass_times(layout, parts, rate), strict=True):
            node[:3] = [_add(a, b) for a, b in zip(node[:3], inertia, strict=True)]
    out: list[Scalar] = []
    for q, f in zip(middle, total, strict=True):
        moment = _add(*(cross(q[i], f[i]) for i in (1, 2, 3)))
        out += [*f[0], *moment]
    return out


def audit(layout: Layout, q: Coordinates, v: Coordinates, p: Sequence[Scalar]) -> list[Scalar]:
    """Books of one element: W, T, L (3), J (3), then per pair of neighbouring nodes Σ_i d_i·d_i,
    then per stress point Σ (d_i·d_j − δ_ij)² and the six strains ε."""
    parts = layout.split(p)
    stored: Scalar = 0.0
    tail: list[Scalar] = []
    for g, (w, n, dn) in enumerate(_points(layout)):
        inverse_j, e0 = parts[2][g], parts[3][6 * g : 6 * g + 6]
        e = [a - b for a, b in zip(strains(q, n, dn, inverse_j), e0, strict=True)]
        s = _stress(parts[1], e)
        stored = stored + (0.5 * w) / inverse_j * sum(a * b for a, b in zip(s, e, strict=True))
        d = _at_point(q, n, dn)[0]
        gram = sum((dot(d[i], d[i]) - 1.0) * (dot(d[i], d[i]) - 1.0) for i in range(3))
        gram = gram + 2.0 * sum(dot(d[i], d[j]) * dot(d[i], d[j]) for i, j in ((0, 1), (0, 2), (1, 2)))
        tail += [gram, *e]
    momentum = _mass_times(layout, parts, v)
    kinetic = 0.5 * sum(dot(m[i], rate[i]) for m, rate in zip(momentum, v, strict=True) for i in range(3))
    linear = _add(*(m[0] for m in momentum))
    angular = _add(*(cross(x[i], m[i]) for m, x in zip(momentum, q, strict=True) for i in range(3)))
    turn = [sum(dot(a[i], b[i]) for i in (1, 2, 3)) for a, b in itertools.pairwise(q)]
    return [stored, kinetic, *linear, *angular, *turn, *tail]


def _coordinates(layout: Layout, x: Sequence[Scalar], d0: Sequence[Scalar], first: int) -> list[Any]:
    return [place(x[PER_NODE * a + first : PER_NODE * a + first + 12], d0[9 * a : 9 * a + 9]) for a in range(layout.nn)]


def record_step(layout: Layout, rule: Rule, tangent: bool) -> tuple[Graph, list[Sym], list[int]]:
    """Residual (6 nn), and behind it the tangent if asked for: blocks (6, 6) by rows, for each node b (increments)
    and each node a (forces). The results come in the order to compute them, with the place of each.

    The tangent is the derivative of the residual for increments (δr, spin θ at n + 1), δd_i = θ × d_i.
    """
    graph = Graph()
    x = graph.inputs("x", PER_NODE * layout.nn)
    p = graph.inputs("p", layout.size)
    dt = graph.inputs("g", 2)
    d0 = layout.split(p)[0]
    q1, q0, v0 = (_coordinates(layout, x, d0, first) for first in (0, 12, 24))
    out = residual(layout, rule, q1, q0, v0, p, dt)
    size = 6 * layout.nn
    results, places = list(out), list(range(size))
    # column after column: what one direction computes is used while it is at hand
    for b, (node, before) in enumerate(zip(q1, q0, strict=True)) if tangent else ():
        for k in range(6):
            if k < 3:
                seed = {node[0][k]: 1.0, before[0][k]: 1.0}
            else:
                e = [1.0 if c == k - 3 else 0.0 for c in range(3)]
                seed = {d[c]: turned for d in node[1:] for c, turned in enumerate(cross(e, d))}
            results += derivative(graph, out, seed)
            places += [size + 36 * (layout.nn * b + i // 6) + 6 * (i % 6) + k for i in range(size)]
    return graph, results, places


def record_audit(layout: Layout) -> tuple[Graph, list[Sym], list[int]]:
    """The books of one element at (x1, ẋ in the place of the rate)."""
    graph = Graph()
    x = graph.inputs("x", PER_NODE * layout.nn)
    p = graph.inputs("p", layout.size)
    d0 = layout.split(p)[0]
    out = audit(layout, _coordinates(layout, x, d0, 0), _coordinates(layout, x, d0, 24), p)
    return graph, out, list(range(len(out)))
