"""2.4 The 45° bend (Bathe & Bolourchi 1979; Romero & Armero 2002, example 4 and Table II).

Components are (x, y, z) of the paper's model: x along the tangent at the root, y along the load, z towards the centre.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.paper.models import bend
from directrix.paper.printed import LOADS, TABLE_II
from directrix.verification.models import equilibrium
from directrix.verification.record import Case, Check, Values
from directrix.verification.references import shoot

Array = NDArray[np.float64]

POLAR, SAINT_VENANT = 1.0 / 6.0, 0.1406
START = np.array([70.71067811865476, 0.0, 29.289321881345254])
ROD = "Simo–Reissner rod"
# shear factor, torsion constant, force: displacement of the tip of the exact rod
EXACT: dict[tuple[float, float, float], Values] = {
    (1.0, SAINT_VENANT, 300.0): (-12.174496, 40.479964, -7.176564),
    (1.0, SAINT_VENANT, 450.0): (-18.740686, 48.704580, -10.919895),
    (1.0, SAINT_VENANT, 600.0): (-23.818489, 53.607232, -13.731397),
    (1.0, POLAR, 300.0): (-11.931556, 40.191892, -7.044541),
    (1.0, POLAR, 450.0): (-18.472120, 48.502927, -10.781143),
    (1.0, POLAR, 600.0): (-23.560240, 53.474859, -13.604521),
    (5 / 6, SAINT_VENANT, 300.0): (-12.174719, 40.480460, -7.176665),
    (5 / 6, SAINT_VENANT, 450.0): (-18.740979, 48.705141, -10.920008),
    (5 / 6, SAINT_VENANT, 600.0): (-23.818828, 53.607850, -13.731507),
    (5 / 6, POLAR, 300.0): (-11.931781, 40.192392, -7.044642),
    (5 / 6, POLAR, 450.0): (-18.472416, 48.503492, -10.781257),
    (5 / 6, POLAR, 600.0): (-23.560582, 53.475478, -13.604632),
    (1.0, SAINT_VENANT, 3000.0): (-47.75189, 68.522895, -25.075308),
    (1.0, POLAR, 3000.0): (-47.68637, 68.539089, -25.056446),
}
# directors, torsion constant: position of the tip under the paper's loads, eight linear elements
REBUILT: dict[tuple[str, float], tuple[Values, Values, Values]] = {
    ("chord", POLAR): ((58.6536, 40.6636, 22.1323), (51.8313, 49.3280, 18.2244), (46.4612, 54.5543, 15.2477)),
    ("chord", SAINT_VENANT): ((58.4055, 40.9547, 21.9974), (51.5539, 49.5298, 18.0819), (46.1938, 54.6830, 15.1180)),
    ("tangent", POLAR): ((58.4631, 40.6873, 22.4312), (51.5801, 49.3224, 18.6701), (46.1815, 54.5246, 15.7965)),
    ("tangent", SAINT_VENANT): ((58.2047, 40.9936, 22.2979), (51.2848, 49.5454, 18.5244), (45.8904, 54.6767, 15.6594)),
}
# order, elements: position of the tip at 600
MESHES: dict[tuple[int, int], Values] = {
    (1, 4): (41.2965, 61.0714, 12.3285),
    (1, 16): (46.9931, 53.7268, 15.5837),
    (1, 32): (47.1119, 53.5369, 15.6600),
    (2, 2): (45.3314, 55.7380, 15.6131),
    (2, 4): (47.0885, 53.5711, 15.6824),
    (2, 8): (47.1470, 53.4805, 15.6847),
}
# source, shear factor, torsion constant, displacement at 600
OTHERS: tuple[tuple[str, float, float, Values], ...] = (
    ("Bathe & Bolourchi 1979", 1.0, SAINT_VENANT, (-23.5, 53.4, -13.4)),
    ("Ibrahimbegović 1995, 8 × 3-node", 1.0, SAINT_VENANT, (-23.814, 53.605, -13.729)),
    ("Ibrahimbegović 1995, 8 × 2-node", 1.0, SAINT_VENANT, (-23.746, 53.407, -13.601)),
    ("4C beam3r_line3, 5 elements", 1.0, SAINT_VENANT, (-23.816476, 53.603919, -13.729866)),
    ("4C beam3r_herm2line3, 5 elements", 5 / 6, SAINT_VENANT, (-23.821110, 53.610991, -13.733341)),
    ("GXBeam, 16 elements", 1.0, POLAR, (-23.545303336988038, 53.45800757548929, -13.577383726758564)),
    ("Abaqus 3DNLG-5, B32", 1.0, SAINT_VENANT, (-23.81, 53.60, -13.73)),
)
CARDONA: dict[float, Values] = {
    300.0: (58.64, 40.35, 22.14),
    450.0: (52.11, 48.59, 18.38),
    600.0: (47.04, 53.50, 15.55),
}
SLENDERNESS = (1e1, 1e2, 1e3, 1e4)


def exact(force: float, shear_factor: float = 1.0, J: float = POLAR, side: float = 1.0) -> Array:
    """Displacement (3,) of the tip of the exact rod, by shooting."""
    A, inertia = side**2, side**4 / 12.0
    GA = shear_factor * 5e6 * A
    frame = np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]])  # d1 to the centre, d3 along x
    shot = shoot(
        (GA, GA, 1e7 * A, 1e7 * inertia, 1e7 * inertia, 5e6 * J * side**4), 25.0 * np.pi,
        force=(0, force, 0), directors=frame, curvature=(0, 0.01, 0), ramp=max(4, round(force / side**4 / 100)),
    )  # fmt: skip
    return shot.r - START


def _tip(*args: float, **options: float | str) -> Array:
    return equilibrium(bend(*args, **options)).node("tip").r[-1]  # pyright: ignore[reportArgumentType]


def _exact() -> Iterator[Check]:
    for (k, J, force), known in EXACT.items():
        name = f"F = {force:g}, k = {k:.3g}, J = {J:.4g}"
        form = exact(force, k, J)
        yield Check.of(f"{name}: shooting", ROD, "C", known, form, 1e-6 / 50)
        got = _tip(force, 40, 2, shear_factor=k, J=J) - START
        yield Check.of(f"{name}, 40 quadratic: displacement", ROD, "C", form, got, 1e-5)


def _table_2() -> Iterator[Check]:
    for k, (force, printed) in enumerate(zip(LOADS, TABLE_II["current"], strict=True)):
        tips = {key: _tip(force, directors=key[0], J=key[1]) for key in REBUILT}
        name = f"F = {force:g}, 8 linear"
        yield Check.printed(name, "Romero & Armero 2002, Table II", "S", printed, tips["chord", POLAR], 2, ulps=1)
        for key, tip in tips.items():
            what = f"{name}, directors along the {key[0]}, J = {key[1]:.4g}"
            yield Check.printed(what, "independent program", "C-FE", REBUILT[key][k], tip, 4, ulps=1)
        quadratic = _tip(force, 8, 2)
        yield Check.of(f"F = {force:g}, 8 quadratic", "Cardona & Géradin", "F", CARDONA[force], quadratic, 0.01)


def _meshes() -> Iterator[Check]:
    for (order, elements), known in MESHES.items():
        name = f"F = 600, {elements} {'linear' if order == 1 else 'quadratic'}"
        yield Check.printed(name, "independent program", "C-FE", known, _tip(600.0, elements, order), 4, ulps=1)
    end = exact(600.0) + START
    for order, meshes in ((1, (16, 32, 64)), (2, (8, 16, 32))):
        errors = [float(np.linalg.norm(_tip(600.0, n, order) - end)) for n in meshes]
        yield Check.of(
            f"order of the tip, {('linear', 'quadratic')[order - 1]}, {meshes[1]} → {meshes[2]}", "element theory", "A",
            2.0 * order, np.log2(errors[1] / errors[2]), 0.05,
        )  # fmt: skip


def _formulations() -> Iterator[Check]:
    paper = "Romero & Armero 2002, Table II"
    for force, printed in zip(LOADS, TABLE_II["Simo & Vu-Quoc 1986"], strict=True):
        tip = equilibrium(bend(force), formulation=dx.SimoVuQuoc()).node("tip").r[-1]
        assert printed is not None
        name = f"Simo–Vu-Quoc, F = {force:g}, 8 linear"
        if force < 600.0:
            yield Check.printed(name, paper, "S", printed, tip, 2)
        else:  # the element remembers its iterations, which moves the third number by some thousandths
            yield Check.printed(f"{name}: x, y", paper, "S", printed[:2], tip[:2], 2)
            yield Check.of(f"{name}: z", paper, "S", printed[2], tip[2])
    end = exact(600.0) + START
    for formulation, name in ((dx.SimoVuQuoc(), "Simo–Vu-Quoc"), (dx.CrisfieldJelenic(), "Crisfield–Jelenić")):
        for order, mesh in ((1, "linear"), (2, "quadratic")):
            tips = [equilibrium(bend(600.0, n, order), formulation=formulation).node("tip").r[-1] for n in (16, 32)]
            rate = np.log2(np.linalg.norm(tips[0] - end) / np.linalg.norm(tips[1] - end))
            what = f"{name}: order of the tip, {mesh}, 16 → 32"
            yield Check.of(what, "element theory", "A", 2.0 * order, rate, 0.1)


def _others() -> Iterator[Check]:
    for source, k, J, known in OTHERS:
        got = _tip(600.0, 16, 2, shear_factor=k, J=J) - START
        yield Check.of(f"F = 600, k = {k:.3g}, J = {J:.4g}: displacement", source, "F", known, got, 0.01)


def _slender() -> Iterator[Check]:
    for slenderness in SLENDERNESS:
        side = 100.0 / slenderness
        force = 600.0 * side**4
        form = exact(force, side=side)
        got = _tip(force, 32, 2, side=side) - START
        yield Check.of(f"R/w = {slenderness:g}, 32 quadratic: displacement", ROD, "C", form, got, 1e-5)


CASES = (
    Case("bend", "2.4", "45° bend: two shear factors, two torsion constants, four loads", _exact),
    Case("bend-table-2", "2.4", "45° bend: the paper's Table II, and what it depends on", _table_2),
    Case("bend-meshes", "2.4", "45° bend: meshes and orders of convergence", _meshes),
    Case("bend-formulations", "2.4", "45° bend: Simo–Vu-Quoc and Crisfield–Jelenić", _formulations),
    Case("bend-others", "2.4", "45° bend: other programs", _others),
    Case("bend-slender", "2.4", "45° bend: slenderness 10 to 10 000 (locking)", _slender),
)
