"""1.2 Path independence (Jelenić & Crisfield 1999; Romero & Armero 2002, example 2 and Table I)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.integrators import Formulation
from directrix.paper.models import AT_A, AT_B, two_turns
from directrix.paper.printed import TABLE_I
from directrix.rotations import exp, log
from directrix.verification.record import Case, Check, Values

Array = NDArray[np.float64]

PAPER = "Romero & Armero 2002, Table I"
FORM = "mean and slope of the end directors"
PATHS = {"I": (0.5, 0.5), "II": (0.775, 0.4)}
# κ, u_B
CLOSED: tuple[Values, Values] = ((-0.66123659, 0.66499847, -0.22128391), (0.11369847, -0.40046749, 0.57033295))
RELATIVE: Values = (-1.26382527, 1.27101537, -0.4229412)  # of the ends, as a vector in the frame of A
# ends after a further turn by (0.2, 1.2, −0.5)
TURNED: tuple[Values, Values] = ((1.0015, 0.3468, -0.8372), (0.0885, 1.9332, -0.0819))
EXTRA = (0.2, 1.2, -0.5)


def closed_form() -> tuple[Array, Array]:
    """κ_i = ½(d_k·d_j' − d_j·d_k') of mean and slope of the end directors; force-free means D_mᵀ r' = e3."""
    a, b = exp(AT_A), exp(AT_B)
    mean, slope = 0.5 * (a + b), b - a
    g = mean.T @ slope
    curvature = 0.5 * np.array([g[2, 1] - g[1, 2], g[0, 2] - g[2, 0], g[1, 0] - g[0, 1]])
    e3 = np.array([0.0, 0.0, 1.0])
    return curvature, np.asarray(np.linalg.solve(mean.T, e3) - e3, float)


def end_state(path: str, formulation: Formulation | None = None) -> tuple[Array, Array]:
    """Curvature (3,) and displacement of B (3,) at the end of a path."""
    result = dx.solve_static(two_turns(*PATHS[path]), steps=2, formulation=formulation, raise_on_failure=True)
    return result.rod("rod").strain[-1, 0, 3:], result.node("B").displacement[-1]


def _run() -> Iterator[Check]:
    exact, states = closed_form(), {path: end_state(path) for path in PATHS}
    for k, name in enumerate(("κ", "u_B")):
        yield Check.printed(f"closed form of {name}", FORM, "C", CLOSED[k], exact[k], 8)
        for path, state in states.items():
            yield Check.of(f"{name}, path {path}", FORM, "A", exact[k], state[k], 1e-8)
            printed = np.array(TABLE_I[f"current, path {path}"][3 * k : 3 * k + 3]) * ((1, 1, -1) if name == "κ" else 1)
            what = f"{name}, path {path}" + (" (κ3 printed without its minus)" if name == "κ" else "")
            yield Check.printed(what, PAPER, "S", printed, state[k], 5, ulps=1)
        gap = float(np.abs(states["I"][k] - states["II"][k]).max())
        yield Check.law(f"{name}: path I − path II", "the end state is that of the end rotations", gap, 1e-13)
    yield Check.printed("relative rotation of the ends", FORM, "C", RELATIVE, log(exp(AT_A).T @ exp(AT_B)), 8, ulps=1)
    for known, end, name in zip(TURNED, (AT_A, AT_B), "AB", strict=True):
        got = log(exp(EXTRA) @ exp(end))
        yield Check.printed(f"end {name} turned further by {EXTRA}", "GeometricTransformations E10", "F", known, got, 4)


def _others() -> Iterator[Check]:
    relative = log(exp(AT_A).T @ exp(AT_B))
    states = {path: end_state(path, dx.CrisfieldJelenic()) for path in PATHS}
    for path, (curvature, _) in states.items():
        yield Check.of(
            f"Crisfield–Jelenić: κ, path {path}", "relative rotation of the ends", "A", relative, curvature, 1e-8
        )
    gap = max(float(np.abs(a - b).max()) for a, b in zip(*states.values(), strict=True))
    yield Check.law("Crisfield–Jelenić: path I − path II", "the end state is that of the end rotations", gap, 1e-13)
    for path in PATHS:
        curvature, tip = end_state(path, dx.SimoVuQuoc())
        printed = TABLE_I[f"Simo & Vu-Quoc, path {path}"]
        yield Check.printed(f"Simo–Vu-Quoc: κ, path {path}", PAPER, "S", printed[:3], curvature, 5)
        # nothing strains the rod there, so its end stays at the distance 1; the printed one is nearer
        yield Check.of(f"Simo–Vu-Quoc: u_B, path {path} (print not possible)", PAPER, "S", printed[3:], tip)
        length = float(np.linalg.norm(np.add(tip, (0, 0, 1))))
        yield Check.of(f"Simo–Vu-Quoc: |e3 + u_B|, path {path}", "no force, no strain", "A", 1.0, length, 1e-12)


CASES = (
    Case("path-independence", "1.2", "One element, two paths to the same end rotations", _run),
    Case("path-others", "1.2", "The same of other formulations", _others),
)
