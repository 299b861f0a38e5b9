"""5.4 Flying spaghetti (Simo & Vu-Quoc 1986, 1988): a free rod thrown by a force and a moment on its lower end.

The rod runs from the height 8 over the origin to (6, 0), in the x–z plane, the kayak's in the x–y plane; the loaded end
is the lower one. The moment of the plane cases turns z towards x.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.result import Result
from directrix.verification.record import Case, Check, Values

Array = NDArray[np.float64]

PROGRAM = "same scheme, independent program"
# (a): elements, Δt: position of the loaded end at times, energy after release
VERY_FLEXIBLE: dict[tuple[int, float], tuple[dict[float, Values], float]] = {
    (20, 0.01): (
        {0.5: (5.42708, -0.13084), 1.0: (4.27064, 0.48784), 2.5: (5.56801, 4.40774), 5.0: (11.54371, 8.41384)},
        423.414855,
    ),
    (40, 0.02): (
        {0.5: (5.44505, -0.11693), 1.0: (4.31564, 0.42352), 2.5: (5.09050, 4.48418), 5.0: (10.12536, 8.30150)},
        388.691149,
    ),
    (80, 0.02): (
        {0.5: (5.44846, -0.11347), 1.0: (4.32490, 0.41209), 2.5: (4.99489, 4.47981), 5.0: (9.86845, 8.23094)},
        381.816034,
    ),
}
# (b): 20 elements, Δt = 0.02
FLEXIBLE: dict[float, Values] = {
    2.5: (4.42953, -0.78766),
    5.0: (5.61924, 4.76601),
    7.5: (15.53104, 8.99616),
    13.0: (26.20967, -0.95143),
}
FLEXIBLE_OTHER_END: Values = (27.76557, 8.71955)
FLEXIBLE_ENERGY, FLEXIBLE_SPIN = 93.31694915, 189.24311195
# (c): elements: displacement of the loaded end at t = 3.5, Δt = 0.01
SPATIAL: dict[int, Values] = {
    10: (-0.54516, -3.12317, 1.73681),
    20: (-0.66268, -3.06579, 1.82663),
    40: (-0.68469, -3.05224, 1.84137),
}
SPATIAL_ENERGY = 518.1813  # 40 elements, t = 3.5
SPATIAL_LIMIT: Values = (-0.692, -3.048, 1.846)
SPATIAL_EARLY: tuple[Values, float] = ((3.60505, -0.43089, 0.04675), 305.4411)  # 40 elements, t = 2.5
AEROBEAMS: Values = (-0.5864710, -3.1154767, 1.8241374)


def thrown(
    EI: float, elements: int, history: Callable[[float], float], force: Values, moment: Values, up: Values = (0, 0, 1)
) -> dx.Model:
    """Force and moment times ``history`` on the lower end; linear elements, GJ = EI; ``up`` is z or y."""
    section = dx.Section.from_moduli(
        EA=1e4, GA1=1e4, GA2=1e4, EI1=EI, EI2=EI, GJ=EI, A_rho=1.0, I_rho1=10.0, I_rho2=10.0
    )
    model = dx.Model(name="flying spaghetti")
    axis = dx.line((6, 0, 0), 8.0 * np.array(up))
    model = model.rod(axis, section, name="rod", ends=("loaded", "other"), elements=elements, order=1)

    def times(vector: Values, t: float) -> Array:
        return history(t) * np.array(vector)

    return model.force("loaded", partial(times, force)).moment("loaded", partial(times, moment))


def block(t: float) -> float:
    """1 until t = 2.5."""
    return float(t <= 2.5)


def triangle(t: float) -> float:
    """Up to 1 at t = 2.5 and down to nothing at t = 5."""
    return max(0.0, 1.0 - abs(t / 2.5 - 1.0))


def _laws(name: str, result: Result, release: float, impulse: Values) -> Iterator[Check]:
    after = result.t >= release - 1e-9
    energy, spin = result.energy.total[after], result.momentum.angular[after]
    yield Check.of(f"{name}: linear momentum", "impulse of the force", "A", impulse, result.momentum.linear[-1], 1e-11)
    yield Check.law(f"{name}: energy after release", "conserved", float(np.ptp(energy) / energy[0]), 1e-9)
    turned = float(np.abs(spin - spin[0]).max() / np.linalg.norm(spin[0]))
    yield Check.law(f"{name}: angular momentum after release", "conserved", turned, 1e-9)


def _at(result: Result, t: float) -> int:
    return int(np.argmin(np.abs(result.t - t)))


def _very_flexible() -> Iterator[Check]:
    for (elements, dt), (places, level) in VERY_FLEXIBLE.items():
        name = f"EI = 100, {elements} linear, Δt = {dt:g}"
        result = dx.simulate(thrown(100.0, elements, block, (8, 0, 0), (0, 80, 0)), 5.0, dt, raise_on_failure=True)
        for t, place in places.items():
            got = result.node("loaded").r[_at(result, t)][[0, 2]]
            yield Check.printed(f"{name}: x, z at t = {t:g}", PROGRAM, "C-FE", place, got, 5, ulps=1)
        yield Check.printed(f"{name}: energy", PROGRAM, "C-FE", level, result.energy.total[-1], 6, ulps=1)
        yield from _laws(name, result, 2.5, (20, 0, 0))


def _flexible() -> Iterator[Check]:
    name = "EI = 500, 20 linear, Δt = 0.02"
    result = dx.simulate(thrown(500.0, 20, block, (8, 0, 0), (0, 80, 0)), 13.0, 0.02, raise_on_failure=True)
    for t, place in FLEXIBLE.items():
        got = result.node("loaded").r[_at(result, t)][[0, 2]]
        yield Check.printed(f"{name}: x, z at t = {t:g}", PROGRAM, "C-FE", place, got, 5, ulps=1)
    other = result.node("other").r[-1][[0, 2]]
    yield Check.printed(f"{name}: other end at 13", PROGRAM, "C-FE", FLEXIBLE_OTHER_END, other, 5, ulps=1)
    yield Check.of(f"{name}: energy", PROGRAM, "C-FE", FLEXIBLE_ENERGY, result.energy.total[-1], 1e-9)
    spin = result.momentum.angular[-1, 1]
    yield Check.of(f"{name}: angular momentum", PROGRAM, "C-FE", FLEXIBLE_SPIN, spin, 1e-9)
    yield from _laws(name, result, 2.5, (20, 0, 0))


def _spatial() -> Iterator[Check]:
    for elements, known in SPATIAL.items():
        name = f"in space, {elements} linear, Δt = 0.01"
        model = thrown(500.0, elements, triangle, (20, 0, 0), (0, 200, 100))
        result = dx.simulate(model, 6.0, 0.01, raise_on_failure=True)
        loaded = result.node("loaded")
        got = loaded.displacement[_at(result, 3.5)]
        yield Check.printed(f"{name}: displacement at t = 3.5", PROGRAM, "C-FE", known, got, 5, ulps=1)
        if elements == 10:
            yield Check.of(f"{name}: displacement at t = 3.5", "AeroBeams, 10 el.", "F", AEROBEAMS, got, None)
        if elements == 40:
            yield Check.of(f"{name}: displacement at t = 3.5", "extrapolated", "C-FE", SPATIAL_LIMIT, got, 0.01)
            place, early = SPATIAL_EARLY
            at = _at(result, 2.5)
            yield Check.printed(f"{name}: place at t = 2.5", PROGRAM, "C-FE", place, loaded.r[at], 5, ulps=1)
            yield Check.printed(f"{name}: energy, t = 2.5", PROGRAM, "C-FE", early, result.energy.total[at], 4)
            then = result.energy.total[_at(result, 3.5)]
            yield Check.printed(f"{name}: energy, t = 3.5", PROGRAM, "C-FE", SPATIAL_ENERGY, then, 4)
        yield from _laws(name, result, 5.0, (50, 0, 0))


def _kayak(t_end: float) -> Iterator[Check]:
    half = 40.0 * np.sqrt(2.0)
    model = thrown(500.0, 10, block, (8, 0, 0), (half, half, 0), up=(0, 1, 0))
    result = dx.simulate(model, t_end, 0.01, save_every=25, raise_on_failure=True)
    yield from _laws(f"kayak, 10 linear, to t = {t_end:g}", result, 2.5, (20, 0, 0))


CASES = (
    Case("spaghetti-very-flexible", "5.4", "Flying spaghetti in a plane, EI = 100", _very_flexible),
    Case("spaghetti-flexible", "5.4", "Flying spaghetti in a plane, EI = 500", _flexible),
    Case("spaghetti-spatial", "5.4", "Flying spaghetti in space", _spatial),
    Case("kayak", "5.4", "Kayak rowing to t = 40", lambda: _kayak(40.0)),
    Case("kayak-long", "5.4", "Kayak rowing to t = 1000", lambda: _kayak(1000.0), "long"),
)
