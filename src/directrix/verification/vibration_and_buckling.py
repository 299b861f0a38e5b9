"""3.3, 3.4, 3.6 Buckling of frames, cantilevers and columns; 4.1, 4.2 Frequencies of rods, at rest and turning."""

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


def right_angle(sense: float = 1.0) -> dx.Model:
    """Legs of 240 in the x–y plane, clamped at a, the end b pushed along x."""
    E, b, h, leg = 71240.0, 0.6, 30.0, 240.0
    G, A = E / 2.62, b * h
    section = dx.Section.from_moduli(
        EA=E * A, GA1=G * A, GA2=G * A, EI1=E * b * h**3 / 12.0, EI2=E * h * b**3 / 12.0, GJ=G * 2.16
    )
    one, two = dx.line((0, 0, 0), (leg, 0, 0), d1=(0, 0, 1)), dx.line((leg, 0, 0), (leg, -leg, 0), d1=(0, 0, 1))
    model = dx.Model(name="right angle").rod(one, section, name="one", ends=("a", "c"), elements=16)
    model = model.rod(two, section, name="two", ends=("c", "b"), elements=16)
    return model.clamp("a").force("b", (sense, 0, 0))


def _right_angle() -> Iterator[Check]:
    model = right_angle()
    factors = np.sort(np.abs(dx.buckling(model, count=2).factors))
    source = "Simo–Reissner frame with its bending before buckling"
    for name, known, got in zip(("one way", "the other"), (0.68042741, 1.08751795), factors, strict=True):
        yield Check.of(f"16 + 16 quadratic, linearised: load, {name}", source, "C", known, float(got), 3e-3)
    for sense in (1.0, -1.0):
        control = dx.ArcLength(ds=2.0, load_step=0.1, until=lambda s: s.load_factor > 1.2)
        path = dx.solve_static(right_angle(sense), control=control, raise_on_failure=True).stability
        assert path is not None
        got = path.bifurcations[0].load_factor
        known = min((0.68042741, 1.08751795), key=lambda load: abs(load - got))
        name = "one way" if known < 1.0 else "the other"
        yield Check.of(f"16 + 16 quadratic, bifurcation of the path: load, {name}", source, "C", known, got, 1e-4)


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
    free = dx.modes(_rod(), count=7).squares
    still = float(np.abs(free[:6]).max() / free[6])
    yield Check.law("free: six modes of no frequency, ω² over that of the seventh", "rigid motion", still, 1e-8)


# Ω̄: flap 1, 2, 3 and lag 1 without a hub; flap 1 and 2 with a hub as long as the blade
TURNING: dict[int, tuple[float, ...]] = {
    0: (3.51602, 22.03449, 61.69721, 3.51602, 3.51602, 22.03449),
    1: (3.68165, 22.18101, 61.84176, 3.54324, 3.88882, 22.37501),
    2: (4.13732, 22.61492, 62.27318, 3.62180, 4.83369, 23.36604),
    3: (4.79728, 23.32026, 62.98497, 3.74351, 6.08175, 24.92775),
    4: (5.58500, 24.27335, 63.96676, 3.89772, 7.47505, 26.95726),
    5: (6.44954, 25.44608, 65.20504, 4.07390, 8.94036, 29.35284),
    6: (7.36037, 26.80908, 66.68391, 4.26323, 10.44387, 32.02724),
    7: (8.29964, 28.33408, 68.38595, 4.45914, 11.96907, 34.91158),
    8: (9.25684, 29.99538, 70.29296, 4.65715, 13.50739, 37.95379),
    9: (10.22569, 31.77051, 72.38668, 4.85434, 15.05408, 41.11541),
    10: (11.20233, 33.64037, 74.64929, 5.04897, 16.60636, 44.36822),
    11: (12.18434, 35.58897, 77.06384, 5.24005, 18.16255, 47.69155),
    12: (13.17015, 37.60311, 79.61448, 5.42705, 19.72154, 51.07013),
}
LAG_WITH_HUB = 15.65053  # lag 1 at Ω̄ = 12


def _families(spin: float, hub: float, count: int) -> tuple[list[float], list[float]]:
    """Frequencies of a turning cantilever of slenderness above 10³, along the axis of the spin (flap) and across it."""
    blade = _rod(20, EA=1e8, GA1=1e8, GA2=1e8, GJ=10.0).clamp("a")
    if spin:
        found = dx.modes(blade, count=count, spin=(0, 0, spin), centre=(-hub, 0, 0))
    else:
        found = dx.modes(blade, count=count)
    size = np.abs(found.shapes).max(axis=1)
    flaps = size[:, 2] > size[:, 1]
    if not spin:  # flap and lag are the same, and their shapes lie in any plane
        flaps = np.arange(count) % 2 == 0
    omega = 2.0 * np.pi * found.frequencies
    return omega[flaps].tolist(), omega[~flaps].tolist()


def _turning() -> Iterator[Check]:
    source = "Ritz, Euler–Bernoulli"
    for spin, known in TURNING.items():
        flap, lag = _families(float(spin), 0.0, 6)
        with_hub, lag_with_hub = _families(float(spin), 1.0, 4)
        got = (*flap[:3], lag[0], *with_hub[:2])
        names = ("flap 1", "flap 2", "flap 3", "lag 1", "hub = L, flap 1", "hub = L, flap 2")
        for name, expected, value in zip(names, known, got, strict=True):
            yield Check.of(f"Ω̄ = {spin}, 20 quadratic: {name}", source, "C", expected, value, 1e-4)
        if spin == 12:
            what = f"Ω̄ = {spin}, 20 quadratic: hub = L, lag 1"
            yield Check.of(what, source, "C", LAG_WITH_HUB, lag_with_hub[0], 1e-4)


CASES = (
    Case("right-angle-buckling", "3.3", "Right-angle cantilever, lateral buckling", _right_angle),
    Case("narrow-cantilever", "3.4", "Narrow cantilever, lateral buckling", _narrow),
    Case("column", "3.6", "Column with shear and axial flexibility", _column),
    Case("frequencies", "4.1", "Frequencies of straight rods", _frequencies),
    Case("turning-cantilever", "4.2", "Turning cantilever, with and without a hub", _turning),
)
