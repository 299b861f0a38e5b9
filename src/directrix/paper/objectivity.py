"""Example 1, Figure 2: reactions at A while the deformed rod is turned as a whole."""

from __future__ import annotations

import numpy as np

import directrix as dx
from directrix.paper.models import two_ends
from directrix.paper.printed import FIGURE_2
from directrix.paper.record import Array, Curve, Figure, Panel, Row, Table, ten

COMPONENTS = ("shear force 1", "shear force 2", "axial force", "bending moment 1", "bending moment 2", "torque")


def end_forces(elements: int = 9, order: int = 1) -> tuple[Array, Array]:
    """Angles [°] (7,) and the section force and moment at A in the turning frame, (7, 6)."""
    model, frames = two_ends(elements=elements, order=order)
    result = dx.solve_static(model, steps=len(frames), raise_on_failure=True)
    reaction = result.node("A").reaction[1:].reshape(-1, 2, 3)
    return 10.0 * np.arange(float(len(frames))), -np.einsum("tji,tkj->tki", frames, reaction).reshape(-1, 6)


def spread(forces: Array) -> float:
    """Largest change over the turn, relative to the largest force, respectively moment."""
    size = np.abs(forces[0].reshape(2, 3)).max(axis=1).repeat(3)
    return float((np.abs(forces - forces[0]) / size).max())


def figure_2() -> Figure:
    """Section force and moment at A over the angle, in the ranges of the paper's axes."""
    angles, found = end_forces()
    curves = {"directors": found}
    panels = tuple(
        Panel(
            f"{COMPONENTS[k]}\n(printed: {label})", "angle [°]", "",
            tuple(Curve(name, angles, forces[:, k]) for name, forces in curves.items()),
            (0.0, 60.0), limits,
        )
        for label, k, limits in FIGURE_2
    )  # fmt: skip
    rows = tuple(Row(f"{name}: largest change", (spread(forces),)) for name, forces in curves.items())
    table = Table(
        "Figure 2, numbers",
        "Change of the reactions over 0 … 60°, relative to their size",
        ("change",),
        rows,
        ".1e",
        "",
    )
    return Figure(
        "Figure 2",
        "Objectivity: a deformed rod turned as a whole",
        panels,
        f"Directors: constant to {ten(spread(found))} of their size.",
        ("Nine linear elements, one Gauss point, shear factor 1.",),
        (table,),
    )
