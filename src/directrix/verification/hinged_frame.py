"""3.1 Hinged right-angle frame past both limit points (Lee et al. 1968; Romero & Armero 2002, example 3).

The element of the paper on the paper's mesh, 5 + 5, is 2.7·10⁻³ and 1.6·10⁻² below the exact limits: it turns by 32°
between its nodes. That is a property of interpolated directors (an error of order h⁴), so these rows, and the minimum
on 20 + 20, are shown; 10 + 10, 20 + 20 and 40 + 40 are judged by the suite's tolerances.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import directrix as dx
from directrix.integrators import Formulation
from directrix.paper.models import hinged_frame
from directrix.result import Result
from directrix.verification.frame_path import ExactFrame
from directrix.verification.record import Case, Check, Values

ROD = "Simo–Reissner rod"
EA, GA, EI = 7.2e6 * 6.0, 7.2e6 / 2.6 * 6.0, 7.2e6 * 2.0
RIGID = 1e6  # times the stiffness
LIMITS: Values = (18546.55874, -9396.14236)  # shear factor 1
AT_LIMITS: tuple[Values, Values] = ((26.8787013, 48.7510587), (90.1801142, 58.2235946))
REACTIONS: Values = (-3510.5085, -14193.5270)  # H and V at the first limit
# EA, GA: both limits
VARIANTS: dict[str, tuple[float, float, Values]] = {
    "k = 5/6": (EA, 5 / 6 * GA, (18544.52709, -9392.48964)),
    "shear-rigid": (EA, RIGID * GA, (18556.72754, -9414.43156)),
    "inextensible, shear-rigid": (RIGID * EA, RIGID * GA, (18558.74654, -9421.28745)),
}
# load and displacements of its node to the right and down, in the order of the path
PATH: tuple[Values, ...] = (
    (4852.92904, 0.28896787, 3.65757483),
    (9586.00712, 1.68582946, 9.92156210),
    (14151.40557, 6.37564752, 22.53127675),
    (18424.15765, 22.99449973, 45.55041854),
    (16685.46611, 44.02997564, 57.78878432),
    (12376.62938, 60.48166250, 60.99351504),
    (6848.07672, 72.64022482, 58.85520646),
    (976.15694, 78.70497774, 53.59001877),
    (-4437.33914, 81.24623593, 50.73816771),
    (-8685.01476, 86.52278674, 54.03204177),
    (-8073.40534, 93.90784720, 66.97091512),
    (-2403.92429, 91.87667400, 81.98001429),
    (6184.15074, 87.21209218, 89.64629584),
    (15633.57998, 85.96893511, 92.14035723),
    (25138.85816, 86.01585217, 93.23309069),
    (34664.29282, 86.40215076, 93.85622019),
)
DIGITISED: Values = (18.761e3, -9.466e3)


def trace(elements: int, to: float = 3e4, at: tuple[float, ...] = (), formulation: Formulation | None = None) -> Result:
    """The path by arc length until the load passes ``to``, with a state wherever it crosses a load of ``at``."""
    control = dx.ArcLength(ds=2.0, ds_max=2.0, until=lambda s: s.load_factor >= to, load_factors=(*at, to))
    return dx.solve_static(hinged_frame(elements), control=control, formulation=formulation, raise_on_failure=True)


def limits(result: Result) -> Values:
    """Load factors of the turning points."""
    return tuple(p.load_factor for p in result.turning_points)


def moved(result: Result) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Displacements of the loaded node to the right and down, (nt, 2)."""
    return result.node("P").displacement[:, :2] * (1.0, -1.0)


def _exact() -> Iterator[Check]:
    frame = ExactFrame(EA, GA, EI)
    path = frame.path(4e4)
    found = frame.limits(path)
    for k, name in enumerate(("maximum", "minimum")):
        yield Check.of(f"{name}: shooting", ROD, "C", LIMITS[k], found[k].load, 1e-9)
        yield Check.of(f"{name}, u, v: shooting", ROD, "C", AT_LIMITS[k], (found[k].u, found[k].v), 1e-6)
    yield Check.of("maximum, H, V: shooting", ROD, "C", REACTIONS, found[0].unknowns[:2], 1e-6)
    last = 0
    for load, u, v in PATH:
        last = min(range(last, len(path)), key=lambda k: abs(path[k].u - u) + abs(path[k].v - v))
        state = frame.at_load(load, path[last])
        yield Check.of(f"P = {load:g}, u, v: shooting", ROD, "C", (u, v), (state.u, state.v), 1e-7)


def _variants() -> Iterator[Check]:
    for name, (EA_, GA_, known) in VARIANTS.items():
        frame = ExactFrame(EA_, GA_, EI)
        found = [s.load for s in frame.limits(frame.path(2e4))]
        # rigid stands for a million times as stiff
        yield Check.of(f"{name}, maximum and minimum: shooting", ROD, "C", known, found, 1e-8)


def _limits() -> Iterator[Check]:
    runs = {n: limits(trace(n)) for n in (5, 10, 20, 40)}
    judged = {10: (1e-3, 1e-3), 20: (1e-5, None), 40: (1e-5, 1e-5)}
    for n, found in runs.items():
        for k, name in enumerate(("maximum", "minimum")):
            tolerance = judged.get(n, (None, None))[k]
            yield Check.of(f"{n} + {n} quadratic: {name}", ROD, "C", LIMITS[k], found[k], tolerance)
    for k, name in enumerate(("maximum", "minimum")):
        coarse, fine = (abs(runs[n][k] - LIMITS[k]) for n in (10, 20))
        rate = float(np.log2(coarse / fine))
        yield Check.of(f"order of the {name}, 10 → 20", "element theory", "A", 4.0, rate, 0.05)
    yield Check.of("20 + 20 quadratic: maximum, minimum", "Simo & Vu-Quoc 1986", "D", DIGITISED, runs[20], 0.05)


def _others() -> Iterator[Check]:
    judged = {5: (1e-3, None), 20: (1e-5, 1e-5)}
    for n, tolerances in judged.items():
        found = limits(trace(n, formulation=dx.CrisfieldJelenic()))
        for k, name in enumerate(("maximum", "minimum")):
            what = f"Crisfield–Jelenić, {n} + {n} quadratic: {name}"
            yield Check.of(what, ROD, "C", LIMITS[k], found[k], tolerances[k])


def _path() -> Iterator[Check]:
    result = trace(20, to=PATH[-1][0], at=tuple(p[0] for p in PATH))
    places, last = moved(result), -1
    for load, *place in PATH:
        later = [int(k) for k in np.flatnonzero(result.load_factor == load) if k > last]
        last = min(later, key=lambda k: float(np.abs(places[k] - place).max()))
        yield Check.of(f"P = {load:g}, 20 + 20 quadratic: u, v", ROD, "C", place, places[last], 1e-4)
    yield Check.control("the path goes on past 3·10⁴", "stiffening", bool(result.load_factor[-1] > 3e4))


CASES = (
    Case("hinged-frame-exact", "3.1", "Hinged frame: the exact path by shooting", _exact),
    Case("hinged-frame-variants", "3.1", "Hinged frame: the exact limits without shear or stretch", _variants, "long"),
    Case("hinged-frame", "3.1", "Hinged frame: limit loads", _limits),
    Case("hinged-frame-path", "3.1", "Hinged frame: the whole path", _path),
    Case("hinged-frame-others", "3.1", "Hinged frame: limit loads of Crisfield and Jelenić", _others),
)
