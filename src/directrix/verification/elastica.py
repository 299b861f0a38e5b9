"""2.2 Cantilever under dead loads (Mattiasson 1981; Batista 2016): elliptic integrals, shear, several loads.

a = PL²/EI. The elastica is inextensible and unshearable: the rod is given EA = GA = 10⁷ EI/L².
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

import directrix as dx
from directrix.verification.models import cantilever, equilibrium, plane_section
from directrix.verification.record import Case, Check, Values, rotation_angle
from directrix.verification.references import elastica, shoot

Array = NDArray[np.float64]

# a: deflection w/L, shortening u/L, slope of the tip; twelve significant digits
ELASTICA: dict[float, Values] = {
    0.2: (0.0663644821448, 0.00264654834052, 0.0996361630374),
    0.4: (0.130975242085, 0.010353921549, 0.197154623703),
    0.5: (0.162143575658, 0.0159189624708, 0.244533647133),
    0.6: (0.192350279687, 0.022487667979, 0.290737766841),
    0.8: (0.249451542028, 0.0381656132405, 0.379063007613),
    1.0: (0.3017207738, 0.0564332362834, 0.461351949712),
    1.5: (0.410978211248, 0.107941500684, 0.639539826151),
    2.0: (0.493457480397, 0.160641720825, 0.781749831557),
    3.0: (0.60325344113, 0.254420184564, 0.986016946711),
    4.0: (0.669964181278, 0.328941242247, 1.12123934749),
    5.0: (0.713791523612, 0.387628360724, 1.21536811761),
    6.0: (0.74457114889, 0.434588828682, 1.2836972858),
    7.0: (0.76736909974, 0.472927428386, 1.33495985747),
    8.0: (0.784982374953, 0.504827732134, 1.3744315067),
    9.0: (0.799055527471, 0.531820562673, 1.40546533362),
    10.0: (0.81060902488, 0.554995597754, 1.4302855388),
    15.0: (0.847715674332, 0.635285780362, 1.50184015418),
    20.0: (0.868695898285, 0.683885567566, 1.5329349563),
}
# w/L, u/L as public programs quote the table
MATTIASSON: dict[float, Values] = {
    1.0: (0.30172, 0.05643),
    2.0: (0.49346, 0.16064),
    5.0: (0.71379, 0.38763),
    10.0: (0.81061, 0.55500),
}
CARDILLO_TIP: Values = (0.445004402246, 0.810609024880)  # a = 10, position
# L = 1, EI = 10, EA = 10⁸, F = 10; GA: displacement and slope of the tip
SHEAR: dict[float, Values] = {
    500.0: (-0.06131563, 0.31781389, 0.4584095513),
    10.0: (-0.25213659, 1.16709589, 0.3428232123),
}
# L = 2π, EI = 2, P = 10 EI/L² down and M = 2.5 P; EA: position of the tip
WITH_MOMENT: dict[float, Values] = {
    np.inf: (4.978534566947578, -3.46763570071549),
    5.0: (5.080381745525755, -3.9267324016462677),
}
# Cardona & Géradin: L = 102.75, EI = 5000, EA = GA = 2.3077e6, 0.85 at S = 52.03 and 1.35 at the tip
TWO_LOADS: Values = (-30.7457310, 66.9615085)
TWO_LOADS_ANALYTIC: Values = (-30.75, 66.96)
STIFF = 1e7


def loaded(a: float, elements: int = 32, order: int = 2, EA: float = STIFF, GA: float = STIFF) -> dx.Model:
    """L = EI = 1, load a along y."""
    return cantilever(plane_section(1.0, EA, GA), 1.0, elements, order).force("tip", (0, a, 0))


def exact_axis(a: float, EA: float, GA: float) -> Callable[[ArrayLike], Array]:
    """Axis of the shear-flexible cantilever: arclengths → (…, 3)."""
    return shoot((GA, GA, EA, 1.0, 1.0, 1.0), 1.0, force=(0, a, 0)).axis


def _table() -> Iterator[Check]:
    for a, known in ELASTICA.items():
        form = elastica(a)
        yield Check.of(f"a = {a:g}: elliptic integrals", "elastica", "C", known, form, 1e-11)
        tip = equilibrium(loaded(a)).node("tip")
        got = (tip.displacement[-1, 1], -tip.displacement[-1, 0], rotation_angle(tip.R[-1]))
        yield Check.of(f"a = {a:g}, 32 quadratic: w/L, u/L, θ", "elastica", "A", form, got, 1e-5)
        if a in MATTIASSON:
            yield Check.printed(f"a = {a:g}: w/L, u/L", "Mattiasson 1981", "F", MATTIASSON[a], got[:2], 5, ulps=1)
        if a == 10.0:
            yield Check.of("a = 10: position", "cardillo", "F", CARDILLO_TIP, tip.r[-1, :2], 1e-5)


def _shear() -> Iterator[Check]:
    for GA, known in SHEAR.items():
        shot = shoot((GA, GA, 1e8, 10.0, 10.0, 10.0), 1.0, force=(0, 10.0, 0))
        form = (shot.r[0] - 1.0, shot.r[1], np.arctan2(shot.directors[1, 2], shot.directors[0, 2]))
        yield Check.printed(f"GA = {GA:g}: shooting", "Batista 2016", "C", known, form, 8)
        tip = equilibrium(loaded(1.0, 32, 2, 1e7, GA / 10.0)).node("tip")
        got = (*tip.displacement[-1, :2], rotation_angle(tip.R[-1]))
        yield Check.of(f"GA = {GA:g}, 32 quadratic: u, v, θ", "Batista 2016", "C", form, got, 1e-5)


def _with_moment() -> Iterator[Check]:
    length, EI = 2.0 * np.pi, 2.0
    P = 10.0 * EI / length**2
    for EA, known in WITH_MOMENT.items():
        name, stiff = f"force and moment, EA = {EA:g}", 1e7 * P
        section = plane_section(EI, min(EA, stiff), stiff)
        model = cantilever(section, length, 32).force("tip", (0, -P, 0)).moment("tip", (0, 0, 2.5 * P))
        got = equilibrium(model).node("tip").r[-1, :2]
        # inextensible is a closed form there, extensible another discretisation
        yield Check.of(f"{name}, 32 quadratic: x, y", "cardillo", "F", known, got, 0.01 if np.inf > EA else 1e-5)


def _two_loads() -> Iterator[Check]:
    length, place, k, EI = 102.75, 52.03, 2.3077e6, 5e3
    shot = shoot((k, k, k, EI, EI, EI), length, force=(0, 1.35, 0), between=((place, (0, 0.85, 0)),))
    form = shot.r[:2] - (length, 0.0)
    yield Check.of("two loads: shooting", "Cardona & Géradin, data", "C", TWO_LOADS, form, 1e-6)
    model = cantilever(plane_section(EI, k, k), length, 32, nodes={"between": place / length})
    model = model.force("between", (0, 0.85, 0)).force("tip", (0, 1.35, 0))
    got = equilibrium(model).node("tip").displacement[-1, :2]
    yield Check.of("two loads, 32 quadratic: u, v", "Cardona & Géradin, data", "C", form, got, 1e-5)
    yield Check.printed("two loads, 32 quadratic: u, v", "Cardona & Géradin, analytic", "F", TWO_LOADS_ANALYTIC, got, 2)


CASES = (
    Case("elastica", "2.2", "Cantilever under a dead tip load, a = 0.2 … 20", _table),
    Case("elastica-shear", "2.2", "The same with shear", _shear),
    Case("elastica-moment", "2.2", "Tip force and tip moment", _with_moment),
    Case("elastica-two-loads", "2.2", "Two dead loads", _two_loads),
)
