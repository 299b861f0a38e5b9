"""Where the paper's print and what follows from its own equations and data differ."""

from __future__ import annotations

import numpy as np

from directrix.paper.printed import TABLE_I, TABLE_III_CURRENT
from directrix.paper.record import Erratum

__all__ = ["ERRATA"]


def _length(row: str) -> float:
    """|e3 + u_B| of a row of Table I."""
    return float(np.linalg.norm(np.add((0.0, 0.0, 1.0), TABLE_I[row][3:])))


ERRATA = (
    Erratum(
        "Table I, κ3 of the current element",
        "+0.22128",
        "−0.22128. The paper's own (34) gives the minus; all other digits agree.",
    ),
    Erratum(
        "Table I, tip of the Simo–Vu-Quoc element",
        "u_B = (−0.02009, 0.18605, −0.07187) and (−0.01701, 0.16401, −0.08261)",
        "Not reproduced. Nothing loads B, so there is no strain Γ and the rod keeps its length: |e3 + u_B| = 1 "
        "for orthonormal "
        f"frames. The printed values give {_length('Simo & Vu-Quoc, path I'):.3f} and "
        f"{_length('Simo & Vu-Quoc, path II'):.3f}. The curvatures of the same rows are reproduced.",
    ),
    Erratum(
        "Figure 2, labels of the force axes",
        "“Axial force” 2.1…2.5·10⁴, “Shear force (1)” −2.45…−2.1·10⁴, “Shear force (2)” 1.6…1.75·10⁵",
        "Permuted: the curve near 1.6·10⁵ is the axial force, the two near ±2.1·10⁴ are the shear forces.",
    ),
    Erratum("Figure 2, abscissa", "“Rotation angle (rad)”, 0…60", "Degrees: six turns of π/18."),
    Erratum(
        "Table II, the mesh",
        "“eight 2-noded linear elements”, unit square section",
        "The digits of the row “Current” need straight elements with one frame along each chord, shear factor 1 "
        "and the polar J = 1/6 "
        "(the torsion constant of a square is 0.1406). They are cut off, not rounded.",
    ),
    Erratum(
        "Example 3, the load",
        "not given in words",
        "Downwards on the beam, 24 from the corner, as in the sources of the problem.",
    ),
    Erratum(
        "Example 5, geometry and velocities",
        "a drawing; “initial velocities v_A, v_B, v_C of points A, B and C”",
        "Velocities of three nodes alone, carried on by the shape functions: with A (0, 3, 0), corner (0, 0, 0), "
        "B (3, 0, 0), "
        "C (3, 0, 3) this gives H = 2.5 and L = (0, −0.75, 2.25), which fit Figure 7.",
    ),
    Erratum(
        "Table III, level of the energy",
        f"{TABLE_III_CURRENT}",
        "Not reproduced from the printed data (moment of inertia 12·10⁻⁷ as far as it can be read, load of the "
        "step from 6 to 7 not "
        "defined). What the table is for, constancy, is.",
    ),
)
