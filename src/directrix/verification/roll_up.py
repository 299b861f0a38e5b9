"""2.1 Roll-up and un-rolling by an end moment: closed forms of the rod, and of the discrete rod.

x = (EI/M) sin(MS/EI), y = (EI/M)(1 − cos(MS/EI)) is the rod. The two-node one-point director element has a closed form
of its own: nodal turn δ = ½ asin(4πλ/n), chords h/cos(δ/2) at the angles (e − ½)δ, and no equilibrium for n < 4πλ
elements (λ turns).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.verification.models import cantilever, equilibrium, plane_section
from directrix.verification.record import Case, Check, Values

Array = NDArray[np.float64]

LENGTH, EI = 10.0, 100.0
SECTION = plane_section(EI, 1e4, 1e4)
# turns: displacement of the tip
ROD: dict[float, Values] = {
    0.125: (-0.9968368384289394, 3.729232285780566),
    0.25: (-3.633802276324186, 6.366197723675812),
    0.5: (-10.0, 6.366197723675814),
    1.0: (-10.0, 0.0),
    1.5: (-10.0, 2.1220659078919377),
}
# turns, linear elements: displacement and rotation of the tip
DISCRETE: dict[tuple[float, int], Values] = {
    (1.0, 13): (-9.013419420784972, 2.0471577370562306, 8.526608057252915),
    (1.0, 16): (-8.840646553663454, 0.591486811148336, 7.226712886132102),
    (1.0, 20): (-9.266505165021634, 0.1914832603442162, 6.793899267509509),
    (1.0, 32): (-9.73028881832737, 0.023503655464605, 6.457033710797846),
    (1.0, 64): (-9.93494107223423, 0.001336813585411, 6.324274994345922),
    (1.0, 128): (-9.983885888695543, 0.0000816768314, 6.293322525478201),
    (0.25, 8): (-3.7688563007576885, 6.508022753848089, 1.6142584276994614),
    (0.125, 2): (-1.002803513186283, 4.364682735052675, 0.9033391107665127),
    (0.125, 4): (-0.9899216448905612, 3.8473158346422647, 0.8071292138497307),
    (0.125, 8): (-0.9948597625405604, 3.7571740985599376, 0.7905343742932402),
}
ASTER = {0.4: -0.30645, 0.6: -0.69355, 1.0: -1.0}  # full circle: S/L, u/L


def rolled(turns: float, elements: int, order: int) -> dx.Model:
    """The cantilever with the end moment for so many turns."""
    model = cantilever(SECTION, LENGTH, elements, order)
    return model.moment("tip", (0, 0, 2 * np.pi * turns * EI / LENGTH))


def exact(turns: float, s: Array | float = LENGTH) -> Array:
    """Displaced axis (…, 2) of the rod."""
    k = 2 * np.pi * turns / LENGTH
    return np.stack([np.sin(k * np.asarray(s)) / k, (1.0 - np.cos(k * np.asarray(s))) / k], -1)


def discrete(turns: float, n: int) -> Array:
    """Displacement (2) and rotation of the tip of n linear elements."""
    delta = 0.5 * np.arcsin(4 * np.pi * turns / n)
    angles = (np.arange(1, n + 1) - 0.5) * delta
    chord = LENGTH / n / np.cos(0.5 * delta)
    return np.array([np.cos(angles).sum() * chord - LENGTH, np.sin(angles).sum() * chord, n * delta])


def _linear() -> Iterator[Check]:
    for (turns, n), known in DISCRETE.items():
        name, form = f"λ = {turns:g}, {n} linear", discrete(turns, n)
        yield Check.of(f"{name}: closed form", "discrete roll-up", "C", known, form, 1e-12)
        tip = equilibrium(rolled(turns, n, 1)).node("tip")
        yield Check.of(f"{name}: u, v, w", "discrete roll-up", "A", (*form[:2], 0.0), tip.displacement[-1], 1e-9)
        turn = (np.cos(form[2]), np.sin(form[2]))
        yield Check.of(f"{name}: cos θ, sin θ", "discrete roll-up", "A", turn, tip.R[-1, :2, 0], 1e-9)


def _quadratic() -> Iterator[Check]:
    for turns, known in ROD.items():
        form = exact(turns) - (LENGTH, 0.0)
        yield Check.of(f"λ = {turns:g}: closed form", "circle", "A", known, form, 1e-12, scale=LENGTH)
        got = equilibrium(rolled(turns, 96, 2)).node("tip").displacement[-1]
        yield Check.of(f"λ = {turns:g}, 96 quadratic: u, v, w", "circle", "A", (*form, 0.0), got, 1e-5, scale=LENGTH)
    result = equilibrium(rolled(1.0, 100, 2))
    for place, known in ASTER.items():
        node = result.mesh.rod("rod").nodes[round(200 * place)]
        got = result.node(int(node)).displacement[-1, 0] / LENGTH
        yield Check.printed(f"full circle, S/L = {place:g}: u/L", "code_aster V6.02.103", "F", known, got, 5)


def _geodesic() -> Iterator[Check]:
    for turns, n in ((0.125, 1), (0.5, 2), (1.0, 4), (1.5, 8)):
        tip = equilibrium(rolled(turns, n, 1), 4, formulation=dx.CrisfieldJelenic()).node("tip")
        # the rotations are exact on any mesh; a chord stands for each arc
        half = np.pi * turns / n
        form = exact(turns) * half / np.sin(half) - (LENGTH, 0.0)
        turn = (np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns))
        yield Check.of(
            f"λ = {turns:g}, {n} linear: u, v", "geodesic element", "A", form, tip.displacement[-1, :2], 1e-9
        )
        yield Check.of(f"λ = {turns:g}, {n} linear: cos θ, sin θ", "circle", "A", turn, tip.R[-1, :2, 0], 1e-9)


def _unrolled() -> Iterator[Check]:
    """A closed circle of length 10, cut and clamped at one side, opened by an end moment."""
    radius = LENGTH / (2 * np.pi)
    for moment, known in ((10 * np.pi, (0.0, 6.366, -3.1416)), (20 * np.pi, (10.0, 0.0, -6.2832))):
        turns = 1.0 - moment / (20 * np.pi)
        form = exact(turns) if turns else np.array([LENGTH, 0.0])
        section, model = plane_section(EI, 1200.0, 600.0), dx.Model(name="un-rolling")
        for name, ends, side in (("a", ("root", "top"), 1), ("b", ("top", "tip"), -1)):
            start, stop = ((0, 0, 0), (0, 2 * radius, 0))[::side]
            curve = dx.arc(start, (side * radius, radius, 0), stop)
            model = model.rod(curve, section, name=name, ends=ends, elements=24)
        node = equilibrium(model.clamp("root").moment("tip", (0, 0, -moment)), 4).node("tip")
        name = f"un-rolled by M = {moment / np.pi:g}π"
        yield Check.of(f"{name}: x, y, z", "circle", "A", (*form, 0.0), node.r[-1], 1e-5, scale=LENGTH)
        yield Check.of(f"{name}: turn of the tip", "circle", "A", np.cos(known[2]), node.R[-1, 0, 0], 1e-5)
        yield Check.printed(f"{name}: x, y", "Ibrahimbegović 1995, exact", "F", known[:2], node.r[-1, :2], 3)


CASES = (
    Case("roll-up-linear", "2.1", "Roll-up by linear elements: their own closed form", _linear),
    Case("roll-up", "2.1", "Roll-up by quadratic elements", _quadratic),
    Case("roll-up-geodesic", "2.1", "Roll-up by linear elements of Crisfield and Jelenić", _geodesic),
    Case("un-rolling", "2.1", "A closed circle opened by an end moment", _unrolled),
)
