"""1.1 Objectivity (Crisfield & Jelenić 1999; Romero & Armero 2002, example 1)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.integrators import Formulation
from directrix.paper.models import two_ends
from directrix.verification.record import Case, Check, Provenance, Values

Array = NDArray[np.float64]

SOURCE = "director elements, independent program"
# elements, order, shear factor: |Fx| = |Fy|, |Fz|, |Mx| = |My| at A; there is no torque
REACTIONS: dict[tuple[int, int, float], Values] = {
    (9, 1, 1.0): (21457.658, 160654.31, 3786.550),
    (9, 1, 5 / 6): (21440.513, 160593.672, 3771.551),
    (36, 1, 1.0): (24169.156, 173374.484, 5605.165),
    (9, 2, 1.0): (24234.11, 173573.786, 5667.365),
    (18, 2, 1.0): (24323.644, 174037.305, 5719.727),
}
TAG: Provenance = "C-FE"


def reactions(
    elements: int = 9, order: int = 1, shear_factor: float = 1.0, formulation: Formulation | None = None
) -> Array:
    """Force and moment at A in the turning frame, one row a stage, (7, 6)."""
    model, frames = two_ends(elements=elements, order=order, shear_factor=shear_factor)
    result = dx.solve_static(model, steps=len(frames), formulation=formulation, raise_on_failure=True)
    reaction = result.node("A").reaction[1:].reshape(-1, 2, 3)
    return np.asarray(np.einsum("tji,tkj->tki", frames, reaction).reshape(-1, 6), float)


def spread(forces: Array) -> float:
    """Largest change of forces and moments (k, 6), relative to the largest of the first row."""
    size = np.abs(forces[0].reshape(2, 3)).max(axis=1).repeat(3)
    return float((np.abs(forces - forces[0]) / size).max())


def _run() -> Iterator[Check]:
    for (elements, order, k), known in REACTIONS.items():
        mesh = f"{elements} {'linear' if order == 1 else 'quadratic'}, k = {k:.4g}"
        local = reactions(elements, order, k)
        yield Check.law(f"{mesh}: change under 0 … 60°", "a rigid turn changes no reaction", spread(local), 1e-10)
        got = np.abs(local[0])
        yield Check.of(f"{mesh}: |Fx|, |Fz|, |Mx|", SOURCE, TAG, known, got[[0, 2, 3]], 1e-8)
        yield Check.of(f"{mesh}: |Fy|, |My|, |T|", SOURCE, TAG, (known[0], known[2], 0.0), got[[1, 4, 5]], 1e-7)


def _others() -> Iterator[Check]:
    law = "a rigid turn changes no reaction"
    for order, name in ((1, "9 linear"), (2, "9 quadratic")):
        change = spread(reactions(order=order, formulation=dx.CrisfieldJelenic()))
        yield Check.law(f"Crisfield–Jelenić, {name}: change under 0 … 60°", law, change, 1e-10)
    drift = spread(reactions(formulation=dx.SimoVuQuoc()))
    yield Check.control("Simo–Vu-Quoc, 9 linear: changes by more than 10⁻⁴", "not objective", drift > 1e-4)


CASES = (
    Case("objectivity", "1.1", "Reactions under superposed rigid turns", _run),
    Case("objectivity-others", "1.1", "The same of other formulations", _others),
)
