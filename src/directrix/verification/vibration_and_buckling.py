"""3.3, 3.4, 3.6 Buckling of frames, cantilevers and columns; 4.1 Natural frequencies of straight rods."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import directrix as dx
from directrix.verification.record import Case, Check

NARROW = 4.0125993436  # 2 j_{−1/4,1}


def _rod(elements: int = 32, **changes: float) -> dx.Model:
    """Unit length along x, d1 along y; slender unless told otherwise."""
    moduli = {"EA": 1e7, "GA1": 1e7, "GA2": 1e7, "EI1": 1.0, "EI2": 1.0, "GJ": 1.0, **changes}
    section = dx.Section.from_moduli(**moduli, A_rho=1.0, I_rho1=1e-8, I_rho2=1e-8)
    axis = dx.line((0, 0, 0), (1, 0, 0), d1=(0, 1, 0))
    return dx.Model(name="rod").rod(axis, section, name="rod", ends=("a", "b"), elements=elements)


def _right_angle() -> Iterator[Check]:
    E, b, h, leg = 71240.0, 0.6, 30.0, 240.0
    G, A = E / 2.62, b * h
    section = dx.Section.from_moduli(
        EA=E * A, GA1=G * A, GA2=G * A, EI1=E * b * h**3 / 12.0, EI2=E * h * b**3 / 12.0, GJ=G * 2.16
    )
    one, two = dx.line((0, 0, 0), (leg, 0, 0), d1=(0, 0, 1)), dx.line((leg, 0, 0), (leg, -leg, 0), d1=(0, 0, 1))
    model = dx.Model(name="right angle").rod(one, section, name="one", ends=("a", "c"), elements=16)
    model = model.rod(two, section, name="two", ends=("c", "b"), elements=16).clamp("a").force("b", (1, 0, 0))
    factors = np.sort(np.abs(dx.buckling(model, count=2).factors))
    source = "Simo–Reissner frame with its bending before buckling"
    for name, known, got in zip(("one way", "the other"), (0.68042741, 1.08751795), factors, strict=True):
        yield Check.of(f"16 + 16 quadratic, linearised: load, {name}", source, "C", known, float(got), 3e-3)


def _narrow() -> Iterator[Check]:
    model = _rod(EI1=1e5, GJ=0.7).clamp("a").force("b", (0, 0, -1))
    known = NARROW * np.sqrt(0.7)
    factors = np.sort(dx.buckling(model, count=2).factors)
    yield Check.of("32 quadratic: both senses", "closed form", "A", (-known, known), factors, 1e-5)


def _column() -> Iterator[Check]:
    euler = np.pi**2 / 4.0
    for times in (10.0, 1e2, 1e3, 1e4):
        GA, EA = times * euler, 1e9
        compliance = 1.0 / GA - 1.0 / EA
        known = (np.sqrt(1.0 + 4.0 * compliance * euler) - 1.0) / (2.0 * compliance)
        model = _rod(GA1=GA, GA2=GA, EA=EA).clamp("a").force("b", (-1, 0, 0))
        got = float(dx.buckling(model, count=2).factors[0])
        yield Check.of(f"32 quadratic, GA = {times:g} P_E", "P (1 + P (1/GA − 1/EA)) = P_E", "A", known, got, 1e-6)


def _frequencies() -> Iterator[Check]:
    clamped = (1.8751040687, 4.6940911330, 7.8547574382)
    got = 2.0 * np.pi * dx.modes(_rod().clamp("a"), count=6).frequencies[::2]
    for k, (beta, omega) in enumerate(zip(clamped, got, strict=True), 1):
        yield Check.of(f"cantilever, 32 quadratic: mode {k}", "Euler–Bernoulli", "A", beta**2, float(omega), 1e-4)
    both = _rod().clamp("a").clamp("b")
    got = 2.0 * np.pi * dx.modes(both, count=4).frequencies[::2]
    for k, (beta, omega) in enumerate(zip((4.7300407, 7.8532046), got, strict=True), 1):
        yield Check.of(f"clamped–clamped, 32 quadratic: mode {k}", "Euler–Bernoulli", "A", beta**2, float(omega), 1e-4)
    still = float(np.abs(dx.modes(_rod(), count=6).squares).max())
    yield Check.law("free: six modes of no frequency, ω² over that of the seventh", "rigid motion", still / 500.0, 1e-6)


CASES = (
    Case("right-angle-buckling", "3.3", "Right-angle cantilever, lateral buckling", _right_angle),
    Case("narrow-cantilever", "3.4", "Narrow cantilever, lateral buckling", _narrow),
    Case("column", "3.6", "Column with shear and axial flexibility", _column),
    Case("frequencies", "4.1", "Frequencies of straight rods", _frequencies),
)
