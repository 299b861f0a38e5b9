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
from typing import Any, NamedTuple

from directrix.formulations.driven import drag, drag_flows, flow_of, intrinsic
from directrix.formulations.layout import (
    PER_NODE,
    Coordinates,
    Layout,
    Scalar,
    Step,
    Vector,
    points,
    symmetric_times,
)
from directrix.formulations.so3 import add, combine, scale, sub
from directrix.kernels.trace import cross, dot

__all__ = [
    "DirectorElement",
    "DirectorStep",
    "Directors",
    "Rule",
    "audit",
    "internal",
    "local",
    "place",
    "residual",
    "strains",
]


@dataclass(frozen=True)
class Directors:
    """Directors interpolated directly (paper section 3): objective and path independent.

    Between nodes the directors are shorter than one; a linear element that turns by 2δ strains by
    sin(2δ)/h. Quadratic elements are far better. Strains are quadratic in the unknowns, so
    energy–momentum steps are available.
    """


@dataclass(frozen=True)
class Rule:
    """One row of the midpoint family: S* = C (w0 ε0 + w1 ε1 + wh ε½) + C_v Δε/Δt; ``static`` evaluates all at x1.

    A section with a stored energy W takes ∂W at ε½ for wh = 1 and at ε1 in statics, else the discrete gradient.
    ``dissipative`` adds ½ χ1 C Δε, χ1 in the third of the common scalars; ``inertia`` False leaves M to the nodes.
    """

    w0: float = 0.0
    w1: float = 1.0
    wh: float = 0.0
    static: bool = False
    dissipative: bool = False
    inertia: bool = True


def place(x: Sequence[Scalar], d0: Sequence[Scalar]) -> tuple[Vector, Vector, Vector, Vector]:
    """(r, d1, d2, d3) of an element end from a node's (r, R e1, R e2, R e3); d_i = R d_i⁰ (paper A17)."""
    columns = [x[3 + 3 * c : 6 + 3 * c] for c in range(3)]
    directors = [tuple(sum(columns[c][k] * d0[3 * i + c] for c in range(3)) for k in range(3)) for i in range(3)]
    return tuple(x[:3]), directors[0], directors[1], directors[2]


class Local(NamedTuple):
    """A configuration at a Gauss point: directors d1, d2, d3, and the slopes (r, d1, d2, d3),ξ."""

    d: Sequence[Vector]
    slope: Sequence[Vector]


def local(q: Coordinates, n: Sequence[float], dn: Sequence[float]) -> Local:
    """What is interpolated at a Gauss point."""
    d = [combine(n, [node[i] for node in q]) for i in (1, 2, 3)]
    slope = [combine(dn, [node[i] for node in q]) for i in range(4)]
    return Local(d, slope)


def halfway(a: Local, b: Local) -> Local:
    """The mean of two configurations at a Gauss point."""
    return Local(*([scale(0.5, add(v, w)) for v, w in zip(*pair, strict=True)] for pair in zip(a, b, strict=True)))


def strains(at: Local, inverse_j: Scalar) -> list[Scalar]:
    """Γ1, Γ2, Γ3, Ω1, Ω2, Ω3 of the configuration, without the reference values (paper 26, 34)."""
    d, (r, d1, d2, d3) = at
    bend1 = 0.5 * (dot(d[2], d2) - dot(d[1], d3))
    bend2 = 0.5 * (dot(d[0], d3) - dot(d[2], d1))
    twist = 0.5 * (dot(d[1], d1) - dot(d[0], d2))
    return [inverse_j * e for e in (dot(d[0], r), dot(d[1], r), dot(d[2], r), bend1, bend2, twist)]


def internal(at: Local, n: Sequence[float], dn: Sequence[float], w: float, s: Sequence[Scalar]) -> list[list[Vector]]:
    """w·dS/dξ·Bᵀ S at one Gauss point, per node four vectors; B as in the strains above."""
    d, slope = at
    t = [w * c for c in s]
    half = [0.5 * c for c in t[3:]]
    on_r = add(*(scale(t[i], d[i]) for i in range(3)))
    on_d: list[Vector] = []
    on_slope: list[Vector] = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # ½ Ω_k carries d_j·d_i' − d_i·d_j', and ½ Ω_j carries d_i·d_k' − d_k·d_i'
        on_d.append(add(scale(t[i], slope[0]), scale(half[j], slope[1 + k]), scale(-half[k], slope[1 + j])))
        on_slope.append(add(scale(half[k], d[j]), scale(-half[j], d[k])))
    return [
        [scale(float(dn[a]), on_r)]
        + [add(scale(float(n[a]), on_d[i]), scale(float(dn[a]), on_slope[i])) for i in range(3)]
        for a in range(len(n))
    ]


def elastic_stress(
    layout: Layout, rule: Rule, parts: Sequence[Sequence[Scalar]], g: int, e: Sequence[Sequence[Scalar]]
) -> list[Scalar]:
    """S* of the stored energy, from the strains ``e`` at x0, x1 and x½ of stress point ``g``.

    With an intrinsic strain ε̂ the energy is W(ε − ε̂), and what S* does along Δε is ΔW and S*·Δε̂.
    """
    weights = (rule.w0, rule.w1, rule.wh)
    if layout.actuated:
        hats = intrinsic(layout, parts[8], g)
        mean = [0.5 * (a + b) for a, b in zip(*hats, strict=True)]
        e = [sub6(part, hat) for part, hat in zip(e, (*hats, mean), strict=True)]
    if layout.law is None:
        mixed = [sum(w * part[k] for w, part in zip(weights, e, strict=True) if w) for k in range(6)]
        return symmetric_times(layout.at(parts[1], g), mixed)
    if rule.static or rule.wh == 1.0:
        return layout.law.stress(e[1] if rule.static else e[2])
    return discrete_gradient(layout, e[0], e[1])


def algorithmic_stress(
    layout: Layout, rule: Rule, parts: Sequence[Sequence[Scalar]], g: int, e: Sequence[Sequence[Scalar]],
    dt: Sequence[Scalar],
) -> list[Scalar]:  # fmt: skip
    """S* with what resists the change of strain, from the strains ``e`` at x0, x1 and x½ of stress point ``g``."""
    s = elastic_stress(layout, rule, parts, g, e)
    if rule.static:
        return s
    c, viscous = layout.at(parts[1], g), layout.at(parts[6], g)
    delta = sub6(e[1], e[0])
    if rule.dissipative:
        s = [a + 0.5 * dt[2] * b for a, b in zip(s, symmetric_times(c, delta), strict=True)]
    if viscous:
        s = [a + dt[1] * b for a, b in zip(s, symmetric_times(viscous, delta), strict=True)]
    return s


def discrete_gradient(layout: Layout, e0: Sequence[Scalar], e1: Sequence[Scalar]) -> list[Scalar]:
    """S* with S*·Δε = ΔW (Gonzalez 1996), the metric G being the stiffness at no strain.

    As Δε → 0 the quotient 0/0 goes over into S̄: where Δε·GΔε is below 1e-10 of the energies it fades out, and what
    it would have corrected there, of third order in Δε, is below round-off.
    """
    law = layout.law
    assert law is not None
    delta = sub6(e1, e0)
    mean = law.stress([0.5 * (a + b) for a, b in zip(e0, e1, strict=True)])
    metric = law.metric
    pushed = [sum(float(metric[i, j]) * delta[j] for j in range(6) if metric[i, j]) for i in range(6)]
    w0, w1 = law.energy(e0), law.energy(e1)
    gap = w1 - w0 - sum(s * d for s, d in zip(mean, delta, strict=True))
    size = sum(p * d for p, d in zip(pushed, delta, strict=True))
    floor = 1e-10 * (w0 + w1)
    factor = gap * size / (size * size + floor * floor + 1e-300)
    return [s + factor * p for s, p in zip(mean, pushed, strict=True)]


def sub6(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
    """a − b for strains."""
    return [s - t for s, t in zip(a, b, strict=True)]


def mass_times(layout: Layout, parts: Sequence[Sequence[Scalar]], v: Coordinates) -> list[list[Vector]]:
    """M v for one element, per node three vectors: A_ρ on r, the Euler dyadic on (d1, d2), nothing on d3.

    First moments of mass S_ρα couple r and d_α; M stays constant.
    """
    m, inertia = parts[4], parts[5]
    out: list[list[Vector]] = []
    for a in range(layout.nn):
        weights: list[Scalar] = []
        for b in range(layout.nn):
            i, j = min(a, b), max(a, b)
            weights.append(m[i * layout.nn - i * (i - 1) // 2 + j - i])
        mean = [add(*(scale(weights[b], v[b][i]) for b in range(layout.nn))) for i in range(3)]
        on_d1, on_d2 = scale(inertia[1], mean[1]), scale(inertia[2], mean[2])
        if not layout.principal:
            on_d1 = add(on_d1, scale(inertia[3], mean[2]))
            on_d2 = add(on_d2, scale(inertia[3], mean[1]))
        on_r = scale(inertia[0], mean[0])
        if layout.eccentric:
            on_r = add(on_r, scale(inertia[4], mean[1]), scale(inertia[5], mean[2]))
            on_d1 = add(on_d1, scale(inertia[4], mean[0]))
            on_d2 = add(on_d2, scale(inertia[5], mean[0]))
        out.append([on_r, on_d1, on_d2])
    return out


def weight(layout: Layout, parts: Sequence[Sequence[Scalar]], static: bool) -> list[list[Vector]]:
    """Weight of an element whose mass is off its axis, on (r, d1, d2) of every node: M (g, 0, 0).

    ``static`` takes gravity at the end of a step, else its mean.
    """
    before, after = parts[10][:3], parts[10][3:]
    g = after if static else scale(0.5, add(before, after))
    nothing = scale(0.0, g)
    return mass_times(layout, parts, [[g, nothing, nothing]] * layout.nn)


def residual(
    layout: Layout,
    rule: Rule,
    q1: Coordinates,
    q0: Coordinates,
    v0: Coordinates,
    p: Sequence[Scalar],
    dt: Sequence[Scalar],
) -> tuple[list[Scalar], list[list[Scalar]]]:
    """Forces and moments of one element on its nodes, (force, moment) per node (paper 44–50, 67); and what derivatives
    are taken through: forces on directors, stresses.

    ``q0`` holds Δr = r1 − r0 in the place of r0. ``dt`` holds 2/Δt and 1/Δt. With ``rule.static`` only ``q1``
    is read.
    """
    parts = layout.split(p)
    step = [node[0] for node in q0]
    q0 = [[sub(b[0], a[0]), *a[1:]] for a, b in zip(q0, q1, strict=True)]
    middle = (
        q1
        if rule.static
        else [[scale(0.5, add(a, b)) for a, b in zip(*n, strict=True)] for n in zip(q0, q1, strict=True)]
    )
    total: list[list[Vector]] = [[(0.0, 0.0, 0.0)] * 4 for _ in range(layout.nn)]
    stresses: list[Scalar] = []
    for g, (w, n, dn) in enumerate(points(layout.nn, layout.points)):
        inverse_j, e0 = parts[2][g], parts[3][6 * g : 6 * g + 6]
        ends = [local(q, n, dn) for q in (q0, q1)]
        half = ends[1] if rule.static else halfway(*ends)
        at = [sub6(strains(point, inverse_j), e0) for point in (*ends, half)]
        s = algorithmic_stress(layout, rule, parts, g, at, dt)
        stresses += s
        force = internal(half, n, dn, w, s)
        total = [[add(a, b) for a, b in zip(*pair, strict=True)] for pair in zip(total, force, strict=True)]
    if layout.dragged:
        still, flow = [scale(0.0, s) for s in step], flow_of(layout, parts[9])
        moving = still if rule.static else [scale(dt[1], s) for s in step]
        past = flow[1] if rule.static else scale(0.5, add(*flow))
        for point in drag(layout, parts[9], [node[0] for node in middle], moving, past):
            for node, n in zip(total, point.shape, strict=True):
                node[0] = sub(node[0], scale(float(n), point.force))
    if layout.eccentric:
        for node, heavy in zip(total, weight(layout, parts, rule.static), strict=True):
            node[:3] = [sub(a, b) for a, b in zip(node[:3], heavy, strict=True)]
    if not rule.static and rule.inertia:
        # M (ẋ1 − ẋ0)/Δt with ẋ1 = (2/Δt)(x1 − x0) − ẋ0, by the very 2/Δt that updates ẋ: no bias in long runs
        rate = [
            [
                tuple(dt[1] * (dt[0] * d - 2.0 * c) for d, c in zip(delta, v, strict=True))
                for delta, v in zip([dr, *(sub(b, a) for a, b in zip(x0[1:], x1[1:], strict=True))], rates, strict=True)
            ]
            for dr, x0, x1, rates in zip(step, q0, q1, v0, strict=True)
        ]
        for node, inertia in zip(total, mass_times(layout, parts, rate), strict=True):
            node[:3] = [add(a, b) for a, b in zip(node[:3], inertia, strict=True)]
    return on_nodes(middle, total), [[c for node in total for v in node[1:] for c in v], stresses]


def on_nodes(q: Coordinates, f: Sequence[Sequence[Vector]]) -> list[Scalar]:
    """Π(d)ᵀ f: force and moment Σ d_i × f_i per node (paper 37, 55)."""
    out: list[Scalar] = []
    for x, part in zip(q, f, strict=True):
        out += [*part[0], *add(*(cross(x[i], part[i]) for i in (1, 2, 3)))]
    return out


def audit(layout: Layout, q: Coordinates, v: Coordinates, p: Sequence[Scalar]) -> list[Scalar]:
    """Books of one element: W, T, L (3), J (3), then per pair of neighbouring nodes Σ_i d_i·d_i,
    then per stress point Σ (d_i·d_j − δ_ij)² and the six strains ε."""
    parts = layout.split(p)
    stored: Scalar = 0.0
    tail: list[Scalar] = []
    for g, (w, n, dn) in enumerate(points(layout.nn, layout.points)):
        inverse_j, e0 = parts[2][g], parts[3][6 * g : 6 * g + 6]
        at = local(q, n, dn)
        e = sub6(strains(at, inverse_j), e0)
        stored = stored + w / inverse_j * layout.energy(layout.at(parts[1], g), _stressed(layout, parts, g, e))
        d = at.d
        gram = sum((dot(d[i], d[i]) - 1.0) * (dot(d[i], d[i]) - 1.0) for i in range(3))
        gram = gram + 2.0 * sum(dot(d[i], d[j]) * dot(d[i], d[j]) for i, j in ((0, 1), (0, 2), (1, 2)))
        tail += [gram, *e]
    momentum = mass_times(layout, parts, v)
    kinetic = 0.5 * sum(dot(m[i], rate[i]) for m, rate in zip(momentum, v, strict=True) for i in range(3))
    linear = add(*(m[0] for m in momentum))
    angular = add(*(cross(x[i], m[i]) for m, x in zip(momentum, q, strict=True) for i in range(3)))
    turn = [sum(dot(a[i], b[i]) for i in (1, 2, 3)) for a, b in itertools.pairwise(q)]
    return [stored, kinetic, *linear, *angular, *turn, *tail]


def _stressed(layout: Layout, parts: Sequence[Sequence[Scalar]], g: int, e: Sequence[Scalar]) -> Sequence[Scalar]:
    """The part of the strains ``e`` that is stressed at the end of a step."""
    return sub6(e, intrinsic(layout, parts[8], g)[1]) if layout.actuated else e


def flows(
    layout: Layout, rule: Rule, q1: Coordinates, q0: Coordinates, p: Sequence[Scalar], dt: Sequence[Scalar]
) -> list[Scalar]:
    """What a step takes from or brings into an element: dissipated by drag, work of the flow, force and moment about
    the origin of the drag; then nothing dissipated, and the work −S*·Δε̂ of actuation.

    ``q0`` holds Δr in the place of r0. Statics takes the mean of the stresses at both ends.
    """
    parts = layout.split(p)
    step = [node[0] for node in q0]
    outside: list[Scalar] = [0.0 * p[0]] * 8
    if layout.dragged:
        outside = drag_flows(layout, parts[9], [node[0] for node in q1], step, dt[1], rule.static)
    done: Scalar = 0.0 * p[0]
    q0 = [[sub(b[0], a[0]), *a[1:]] for a, b in zip(q0, q1, strict=True)]
    if layout.eccentric:
        outside = [a + b for a, b in zip(outside, _weight_flows(layout, rule, parts, q1, q0, step), strict=True)]
    if layout.actuated:
        middle: Any = [[scale(0.5, add(a, b)) for a, b in zip(*n, strict=True)] for n in zip(q0, q1, strict=True)]
        for g, (w, n, dn) in enumerate(points(layout.nn, layout.points)):
            inverse_j, e0 = parts[2][g], parts[3][6 * g : 6 * g + 6]
            e = [sub6(strains(local(q, n, dn), inverse_j), e0) for q in (q0, q1, middle)]
            before, after = intrinsic(layout, parts[8], g)
            if rule.static:
                at = [sub6(a, b) for a, b in zip(e, (before, after), strict=False)]
                pair = [layout.stress(layout.at(parts[1], g), a) for a in at]
                s = [0.5 * (a + b) for a, b in zip(*pair, strict=True)]
            else:
                s = elastic_stress(layout, rule, parts, g, e)
            done = done - w / inverse_j * sum(a * d for a, d in zip(s, sub6(after, before), strict=True))
    return [*outside, 0.0 * done, done]


def _weight_flows(
    layout: Layout, rule: Rule, parts: Sequence[Sequence[Scalar]], q1: Coordinates, q0: Coordinates,
    step: Sequence[Vector],
) -> list[Scalar]:  # fmt: skip
    """Nothing dissipated; work of the weight over a step, its force and its moment about the origin.

    Statics takes the mean over the step for the work, and the weight at its end.
    """
    heavy, mean = weight(layout, parts, rule.static), weight(layout, parts, False)
    done: Scalar = 0.0
    for a, f in enumerate(mean):
        moved = [step[a], sub(q1[a][1], q0[a][1]), sub(q1[a][2], q0[a][2])]
        done = done + sum(dot(f[i], moved[i]) for i in range(3))
    at = q1 if rule.static else [
        [scale(0.5, add(b, c)) for b, c in zip(*node, strict=True)] for node in zip(q0, q1, strict=True)
    ]  # fmt: skip
    force = add(*(f[0] for f in heavy))
    moment = add(*(cross(node[i], f[i]) for node, f in zip(at, heavy, strict=True) for i in range(3)))
    return [0.0 * done, done, *force, *moment]


def coordinates(layout: Layout, x: Sequence[Scalar], d0: Sequence[Scalar], first: int) -> list[Any]:
    """Director coordinates per node, from the values of the nodes that begin at ``first``: 0 x1, 12 x0, 24 ẋ."""
    return [place(x[PER_NODE * a + first : PER_NODE * a + first + 12], d0[9 * a : 9 * a + 9]) for a in range(layout.nn)]


def reference_strains(layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
    """Strains at the stress points of the reference coordinates ``q``."""
    at = zip(points(layout.nn, layout.points), inverse_j, strict=True)
    return [strains(local(q, n, dn), j) for (_, n, dn), j in at]


class DirectorElement:
    """What elements that interpolate directors share: no history, strains and books of the directors."""

    sampled = False

    def rows(self, layout: Layout) -> int:
        """No history."""
        return 0

    def reference(self, layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
        """See :func:`reference_strains`."""
        return reference_strains(layout, q, inverse_j)

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :func:`audit`."""
        d0 = layout.split(p)[0]
        return audit(layout, coordinates(layout, x, d0, 0), coordinates(layout, x, d0, 24), p)


@dataclass(frozen=True)
class DirectorStep(DirectorElement):
    """The director element under a rule of the midpoint family or in statics (an :class:`Element`)."""

    rule: Rule

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """Forces, and per node what moves and what turns with it."""
        d0 = layout.split(p)[0]
        q1, q0, v0 = (coordinates(layout, x, d0, first) for first in (0, 12, 24))
        forces, through = residual(layout, self.rule, q1, q0, v0, p, g)
        return Step(forces, [(a[0], b[0]) for a, b in zip(q1, q0, strict=True)], [a[1:] for a in q1], through)

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """See :func:`flows`."""
        d0 = layout.split(p)[0]
        q1, q0 = (coordinates(layout, x, d0, first) for first in (0, 12))
        return flows(layout, self.rule, q1, q0, p, g)
