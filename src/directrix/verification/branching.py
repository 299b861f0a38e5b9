"""Bifurcations and the branches behind them: 3.5 twisted rods, Michell's ring, Euler's column; 3.3 end moments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import directrix as dx
from directrix.verification.record import Case, Check

# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

Array = NDArray[np.float64]

__all__ = ["CASES", "bent_to_a_ring", "elastica_branch", "greenhill", "held_at_its_start", "ring", "twisted_rod"]

TAN = 4.49340945790906  # tan x = x


def column(elements: int = 48, EA: float = 1e6, out_of_plane: float = 1e3) -> dx.Model:
    """A clamped column of unit length along x under P = 1, EI = 1 in the x–z plane."""
    section = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=1.0, EI2=out_of_plane, GJ=out_of_plane)
    axis = dx.line((0, 0, 0), (1, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="column").rod(axis, section, name="column", ends=("a", "b"), elements=elements)
    return model.clamp("a").force("b", (-1, 0, 0))


def elastica_branch(mode: int, turn: float) -> tuple[float, float, float]:
    """Load, end shortening and deflection of a clamped inextensible column, EI = L = 1, on branch ``mode``.

    Its end has turned by ``turn``: a quarter wave of the elastica, repeated 2·mode − 1 times.
    """
    quarters = 2 * mode - 1
    k = float(np.sin(0.5 * turn))
    K, E = float(ellipk(k * k)), float(ellipe(k * k))
    return (quarters * K) ** 2, 2.0 - 2.0 * E / K, 2.0 * k / (quarters * K)


def ring(elements: int, B: float, C: float, stiff: float = 1e6) -> dx.Model:
    """A straight rod of unit length from A to B, M midway, with bending stiffness ``B`` and torsional ``C``."""
    section = dx.Section.from_moduli(EA=stiff, GA1=stiff, GA2=stiff, EI1=B, EI2=B, GJ=C)
    axis = dx.line((0, 0, 0), (1, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="ring").rod(axis, section, name="rod", ends=("A", "B"), elements=elements, nodes={"M": 0.5})
    return model.clamp("A")


def _end(part: float) -> Array:
    """Displacement of the end of the rod when it is bent to ``part`` of a full circle."""
    angle = 2.0 * np.pi * part
    return np.array([np.sinc(angle / np.pi) - 1.0, (1.0 - np.cos(angle)) / angle if angle else 0.0, 0.0])


def held_at_its_start(result: dx.Result) -> dx.Result:
    """The last state alone, as a start at load factor 0."""
    zero = np.zeros(1)
    return replace(result, t=zero, load_factor=zero, r=result.r[-1:], R=result.R[-1:])


def bent_to_a_ring(elements: int, B: float, C: float) -> tuple[dx.Model, dx.Result]:
    """A ring that was a straight rod, closed where A and B meet, and the model whose load factor is its twist there.

    Clamping the ends where they meet takes away the rigid motions of a closed ring and nothing else. A round ring can
    also turn about its tangent at A, and shift along itself: M, which stays on the axis of symmetry, is held off it.
    """
    bending = ring(elements, B, C).fix("M", "z").prescribe("B", displacement=_end, rotation=(0, 0, 2.0 * np.pi))
    control = dx.ArcLength(ds=0.02, load_factors=(1.0,), until=lambda s: s.load_factor >= 1.0)
    bent = dx.solve_static(bending, control=control, raise_on_failure=True)
    closed = _end(1.0)

    def stay(_: float) -> Array:
        return closed

    def turn(twist: float) -> Array:
        return np.array([twist, 0.0, 0.0])

    twisting = ring(elements, B, C).fix("M", "x", "z")
    twisting = twisting.prescribe("B", displacement=stay, rotation=turn)
    return twisting, held_at_its_start(bent)


def twisted_rod(elements: int, tension: float, C: float, stiff: float = 1e5) -> dx.Model:
    """A straight rod of unit length and unit bending stiffness; its end B is free along x, pulled, and turned by λ."""
    section = dx.Section.from_moduli(EA=stiff, GA1=stiff, GA2=stiff, EI1=1.0, EI2=1.0, GJ=C)
    axis = dx.line((0, 0, 0), (1, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="twisted rod").rod(
        axis, section, name="rod", ends=("A", "B"), elements=elements, nodes={"M": 0.5}
    )
    model = model.clamp("A").fix("B", "y", "z").fix("M", "z").prescribe("B", rotation=(1, 0, 0))
    return model.force("B", (tension, 0, 0), constant=True) if tension else model


def greenhill(tension: float) -> float:
    """Critical moment of a clamped rod, B = L = 1, under tension T: where w'''' − i M w''' − T w'' = 0 has a solution
    with w = w' = 0 at both ends, by the determinant of these four conditions.
    """
    if tension == 0.0:
        return 2.0 * TAN

    def determinant(M: float) -> float:
        a = 0.5 * np.sqrt(complex(M * M - 4.0 * tension))
        roots = 0.5j * M + np.array([1j * a, -1j * a])
        rows = np.array(
            [
                [1.0, 0.0, 1.0, 1.0],
                [0.0, 1.0, roots[0], roots[1]],
                [1.0, 1.0, *np.exp(roots)],
                [0.0, 1.0, *(roots * np.exp(roots))],
            ]
        )
        # imaginary but for the phase, and odd in a
        return float(np.imag(np.linalg.det(rows) * np.exp(-0.5j * M) / a))

    start = np.sqrt(4.0 * tension) + 1e-3
    grid = start + np.linspace(0.0, 20.0, 400)
    values = [determinant(M) for M in grid]
    k = next(k for k in range(1, len(grid)) if values[k - 1] * values[k] < 0.0)
    return float(cast("float", brentq(determinant, grid[k - 1], grid[k], xtol=1e-13)))


def _column() -> Iterator[Check]:
    model = column()
    found = dx.solve_static(
        model, control=dx.ArcLength(ds=0.02, load_step=4.0, until=lambda s: s.load_factor > 65.0), raise_on_failure=True
    )
    assert found.stability is not None
    points = found.stability.points
    yield Check.control(
        "48 quadratic, no imperfection: three simple bifurcations",
        "Euler",
        [p.kind for p in points] == 3 * ["simple bifurcation"],
    )
    for mode, point in enumerate(points, 1):
        known = (mode - 0.5) ** 2 * np.pi**2  # GA = EA: their compliances cancel
        yield Check.of(
            f"48 quadratic: bifurcation {mode}", "Euler", "A", known, point.load_factor, 1e-4 if mode == 3 else 1e-5
        )
    for mode in (1, 2, 3):
        load, short, aside = elastica_branch(mode, np.pi / 3)
        places: list[Array] = []
        for side in (1, -1):
            control = dx.ArcLength(
                ds=0.02, ds_max=0.04, load_step=4.0, branch=side * mode, load_factors=(load,),
                until=lambda s, load=load: s.load_factor >= load,
            )  # fmt: skip
            branch = dx.solve_static(model, control=control, raise_on_failure=True)
            turned = float(np.arccos(branch.node("b").R[-1, 0, 0]))
            what = f"branch {mode}, side {side:+d}, at the load of 60°"
            yield Check.of(f"{what}: end rotation", "elastica", "A", np.pi / 3, turned, 1e-3)
            places.append(branch.node("b").displacement[-1])
            got = (-places[-1][0], abs(places[-1][2]))
            yield Check.of(f"{what}: shortening, deflection", "elastica", "A", (short, aside), got, 1e-3)
        yield Check.law(
            f"branch {mode}: its sides mirror each other", "symmetry", float(abs(places[0][2] + places[1][2])), 1e-6
        )


def _hockling() -> Iterator[Check]:
    E, G, A, I, J, L = 71240.0, 27190.0, 10.0, 0.0833, 2.16, 240.0
    section = dx.Section.from_moduli(EA=E * A, GA1=G * A, GA2=G * A, EI1=E * I, EI2=E * I, GJ=G * J)
    model = dx.Model(name="hockling").rod(
        dx.line((0, 0, 0), (L, 0, 0)), section, name="rod", ends=("a", "b"), elements=40
    )
    model = model.clamp("a").fix("b", "y", "z", "ry", "rz").moment("b", (1, 0, 0))
    control = dx.ArcLength(ds=5.0, load_step=20.0, until=lambda s: s.load_factor > 250.0)
    result = dx.solve_static(model, control=control, raise_on_failure=True)
    assert result.stability is not None
    point = result.stability.points[0]
    yield Check.of(
        "40 quadratic: torque at the bifurcation", "tan x = x", "A", 222.210031656617, point.load_factor, 1e-3
    )
    yield Check.of("modes there: any plane", "symmetry", "A", 2.0, float(len(point.modes)), 0.0)
    for tension in (0.0, 100.0):
        model = twisted_rod(48, tension, 0.8)
        control = dx.ArcLength(ds=0.02, load_step=2.0, until=lambda s: s.load_factor * 0.8 > 24.0)
        start = pulled(model, tension)
        found = dx.solve_static(model, control=control, start=start, raise_on_failure=True).stability
        assert found is not None
        got = 0.8 * found.points[0].load_factor
        yield Check.of(
            f"48 quadratic, tension {tension:g}: M", "Greenhill, clamped", "A", greenhill(tension), got, 1e-3
        )


def pulled(model: dx.Model, tension: float) -> dx.Result | None:
    """The rod under its tension alone."""
    if not tension:
        return None
    still = replace(model, prescribed=()).fix("B", "rx", "ry", "rz")
    return held_at_its_start(dx.solve_static(still, steps=1, raise_on_failure=True))


def _ring() -> Iterator[Check]:
    B, C = 1.0, 0.8
    known = 2.0 * np.sqrt(3.0) * np.pi * B / C
    model, start = bent_to_a_ring(48, B, C)
    control = dx.ArcLength(ds=0.02, load_step=2.0, branch=1, max_steps=40)
    result = dx.solve_static(model, start=start, control=control, raise_on_failure=True)
    assert result.stability is not None
    point = result.stability.points[0]
    yield Check.of(
        "48 quadratic: total twist at the bifurcation", "Michell 1890: 2π√3 B/C", "A", known, point.load_factor, 1e-4
    )
    yield Check.control("behind it the ring leaves its plane", "Michell", bool(np.ptp(result.r[-1, :, 2]) > 0.1))
    held = float(np.abs(result.node("M").reaction).max())
    yield Check.law("what holds M does not act", "symmetry", held / float(np.abs(result.reaction).max()), 1e-6)


def _end_moments() -> Iterator[Check]:
    E, b, h, leg = 71240.0, 0.6, 30.0, 240.0
    G, A = E / 2.62, b * h
    section = dx.Section.from_moduli(
        EA=E * A, GA1=G * A, GA2=G * A, EI1=E * b * h**3 / 12.0 * 1e4, EI2=E * h * b**3 / 12.0, GJ=G * 2.16
    )
    half = np.sqrt(0.5)
    model = dx.Model(name="hinged right angle")
    model = model.rod(
        dx.line((0, 0, 0), (leg * half, leg * half, 0), d1=(0, 0, 1)), section, name="one", ends=("a", "c"), elements=16
    )
    model = model.rod(
        dx.line((leg * half, leg * half, 0), (2 * leg * half, 0, 0), d1=(0, 0, 1)),
        section,
        name="two",
        ends=("c", "b"),
        elements=16,
    )
    model = model.fix("a", "y", "z", "rx", "ry").fix("b", "x", "y", "z", "rx", "ry")
    model = model.moment("a", (0, 0, 1)).moment("b", (0, 0, -1))
    factors = np.sort(np.abs(dx.buckling(model, count=2).factors))
    known = np.pi * np.sqrt(E * h * b**3 / 12.0 * G * 2.16) / leg
    yield Check.of("closed form", "Argyris", "F", 622.2080872, known, 1e-6)
    yield Check.of("16 + 16 quadratic: smallest moment", "π √(EI GJ)/L", "A", known, float(factors[0]), 1e-3)


CASES = (
    Case("right-angle-moments", "3.3", "Hinged right-angle frame under end moments", _end_moments),
    Case("twisted-rods", "3.5", "Hockling, and twisted rods under tension", _hockling),
    Case("michell-ring", "3.5", "Michell's ring", _ring),
    Case("column-branches", "3.6", "Branches of Euler's column", _column),
)
