"""Example 1, Figure 2: reactions at A while the deformed rod is turned as a whole."""

from __future__ import annotations

import numpy as np

import directrix as dx
from directrix.integrators import Formulation
from directrix.paper.printed import FIGURE_2
from directrix.paper.record import Curve, Figure, Panel, Row, Table, ten
from directrix.verification.objectivity import reactions, spread

COMPONENTS = ("shear force 1", "shear force 2", "axial force", "bending moment 1", "bending moment 2", "torque")
FORMULATIONS: dict[str, Formulation] = {
    "directors": dx.Directors(),
    "Simo & Vu-Quoc": dx.SimoVuQuoc(),
    "Crisfield & Jelenić": dx.CrisfieldJelenic(),
}


def figure_2() -> Figure:
    """Section force and moment at A over the angle, in the ranges of the paper's axes."""
    # what the rod exerts on the support is the section force at its start
    found = {name: -reactions(formulation=formulation) for name, formulation in FORMULATIONS.items()}
    styles = {"Simo & Vu-Quoc": "rival", "Crisfield & Jelenić": "dashed"}
    angles = 10.0 * np.arange(7.0)
    panels = tuple(
        Panel(
            f"{COMPONENTS[k]}\n(printed: {label})", "angle [°]", "",
            tuple(Curve(name, angles, forces[:, k], styles.get(name, "line")) for name, forces in found.items()),
            (0.0, 60.0), limits,
        )
        for label, k, limits in FIGURE_2
    )  # fmt: skip
    changes = {name: spread(forces) for name, forces in found.items()}
    rows = [
        Row(name, (changes[name], *(np.ptp(forces, axis=0)[[0, 1, 2, 5]].tolist()))) for name, forces in found.items()
    ]
    table = Table(
        "Figure 2, numbers", "Change over 0 … 60°: relative to the size of the reactions, and of single components",
        ("relative", "shear force 1", "shear force 2", "axial force", "torque"), tuple(rows), ".1e", "",
    )  # fmt: skip
    return Figure(
        "Figure 2",
        "Objectivity: a deformed rod turned as a whole",
        panels,
        f"Simo–Vu-Quoc reactions change by {ten(changes['Simo & Vu-Quoc'])} of their size over 60°, those of "
        "directors by "
        f"{ten(changes['directors'])}, of Crisfield–Jelenić by {ten(changes['Crisfield & Jelenić'])}.",
        (
            "Nine linear elements, one Gauss point, shear factor 1. Crisfield–Jelenić starts from the same "
            "forces as Simo–Vu-Quoc and keeps "
            "them. How far Simo–Vu-Quoc drifts depends on the iterations, which it remembers.",
        ),
        (table,),
    )
