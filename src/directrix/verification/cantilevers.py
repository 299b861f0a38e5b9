"""2.5 Straight cantilevers of general stiffness, as other programs publish them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import directrix as dx
from directrix.verification.models import cantilever, equilibrium
from directrix.verification.record import Case, Check, Values, rotation_angle
from directrix.verification.references import shoot

PALACIOS: Values = (-0.5964712722, -2.1596938945, 0.6720060638)
SHARPY: Values = (-0.596, -2.159, 0.6720)
# load / h³: displacement by shooting, of EXUDYN with 1024 elements
NACHBAGAUER: dict[float, tuple[Values, Values]] = {
    5e8: ((-0.1509711442, 0.7105685979), (-0.15097103, 0.71056837)),
    5e5: ((-1.8884916342e-7, 8.0990325398e-4), (-1.88847418e-7, 8.09900305e-4)),
}
BENDING_TORSION: Values = (-1.09438e-4, -1.864365e-4, -1.81174027e-2)
ANSYS: Values = (-1.0939e-4, -1.8646e-4, -1.8117e-2)


def _palacios() -> Iterator[Check]:
    GA, EA, GJ, EI, length, force = 3.231e8, 4.8e8, 1e6, 9.346e6, 5.0, (0.0, -600e3, 0.0)
    shot = shoot((GA, GA, EA, EI, EI, GJ), length, force=force)
    turn = np.arctan2(-shot.directors[1, 2], shot.directors[0, 2])
    form = (*(shot.r[:2] - (length, 0.0)), turn)
    yield Check.printed("u, v, θ: shooting", "Palacios & Cesnik, data", "C", PALACIOS, form, 9)
    section = dx.Section.from_moduli(EA=EA, GA1=GA, GA2=GA, EI1=EI, EI2=EI, GJ=GJ)
    tip = equilibrium(cantilever(section, length, 32).force("tip", force)).node("tip")
    got = (*tip.displacement[-1, :2], -rotation_angle(tip.R[-1]))
    yield Check.of("32 quadratic: u, v, θ", "Palacios & Cesnik, data", "C", form, got, 1e-5)
    yield Check.of("32 quadratic: u, v, θ", "SHARPy", "F", SHARPY, got, 0.01)


def _nachbagauer() -> Iterator[Check]:
    length, b, h, E, nu = 2.0, 0.1, 0.5, 2.07e11, 0.3
    section = dx.Section.rectangle(width=h, height=b, E=E, nu=nu)  # d1 = y is the direction of the load
    for size, (known, other) in NACHBAGAUER.items():
        force, name = (0.0, size * h**3, 0.0), f"F = {size:g} h³"
        form = shoot(np.diag(section.stiffness), length, force=force).r[:2] - (length, 0.0)
        yield Check.of(f"{name}, u, v: shooting", "Nachbagauer 2011, data", "C", known, form, 1e-9)
        got = equilibrium(cantilever(section, length, 32).force("tip", force)).node("tip").displacement[-1, :2]
        yield Check.of(f"{name}, 32 quadratic: u, v", "Nachbagauer 2011, data", "C", form, got, 1e-5)
        yield Check.of(f"{name}, 32 quadratic: u, v", "EXUDYN, 1024 elements", "F", other, got, 0.01)


def _bending_torsion() -> Iterator[Check]:
    length, h, w, E, nu = 2.0, 0.2, 0.4, 2.07e11, 0.3
    G, moment = E / (2.0 * (1.0 + nu)), (0.5e6, 2e6, 0.0)
    I_y, I_z = h * w**3 / 12.0, w * h**3 / 12.0
    stiffness = (
        0.8331 * G * w * h, 0.7961 * G * w * h, E * w * h, E * I_y, E * I_z, 0.5768 * G * (I_y + I_z),
    )  # fmt: skip
    form = shoot(stiffness, length, moment=moment).r - (length, 0.0, 0.0)
    yield Check.of("bending and torsion: shooting", "Nachbagauer 2013, data", "C", BENDING_TORSION, form, 1e-6)
    model = cantilever(dx.Section(np.diag(stiffness), order="shear-axial"), length, 32).moment("tip", moment)
    got = equilibrium(model).node("tip").displacement[-1]
    yield Check.of("bending and torsion, 32 quadratic", "Nachbagauer 2013, data", "C", form, got, 1e-5)
    yield Check.of("bending and torsion, 32 quadratic", "Nachbagauer 2013, ANSYS", "F", ANSYS, got, 0.01)


def _small() -> Iterator[Check]:
    """The published loads, reduced until v = FL³/3EI + FL/GA holds."""
    cases = {
        # length, E, G, area, moment of inertia, force
        "projectchrono IGA beam": (0.4, 0.02e10, 0.38 * 0.02e10, 0.012 * 0.025, 0.025 * 0.012**3 / 12.0, -10.0),
        "PyElastica Timoshenko": (3.0, 1e6, 1e4, np.pi / 16.0, np.pi / 4.0**5, -15.0),
    }
    for name, (length, E, G, A, inertia, F) in cases.items():
        EI, GA = E * inertia, 27.0 / 28.0 * G * A
        small = 1e-4 * EI / length**2
        F = np.sign(F) * min(abs(F), small)
        section = dx.Section.from_moduli(EA=E * A, GA1=GA, GA2=GA, EI1=EI, EI2=EI, GJ=EI)
        got = equilibrium(cantilever(section, length, 8).force("tip", (0, F, 0))).node("tip").displacement[-1, 1]
        form = F * length**3 / (3 * EI) + F * length / GA
        yield Check.of(f"{name}, 8 quadratic: v", "Timoshenko", "A", form, got, 1e-4)


CASES = (
    Case("cantilever-palacios", "2.5", "A long stiff wing", _palacios),
    Case("cantilever-nachbagauer", "2.5", "Deep cantilever, large and small load", _nachbagauer),
    Case("cantilever-torsion", "2.5", "Bending and torsion by an end moment", _bending_torsion),
    Case("cantilever-small", "2.5", "Small loads: Timoshenko's formula", _small),
)
