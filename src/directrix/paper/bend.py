"""Example 4, Table II: the tip of the 45° bend."""

from __future__ import annotations

import numpy as np

from directrix.paper.models import bend
from directrix.paper.printed import LOADS, TABLE_II
from directrix.paper.record import Numbers, Row, Table, agrees
from directrix.verification.bend45 import START, exact
from directrix.verification.models import equilibrium


def tips(elements: int = 8, order: int = 1) -> Numbers:
    """Positions of the tip under the three loads, one after the other."""
    found = [equilibrium(bend(force, elements, order)).node("tip").r[-1] for force in LOADS]
    return tuple(np.concatenate(found).tolist())


def printed(label: str) -> Numbers:
    """A row of the paper's table."""
    return tuple(v for part in TABLE_II[label] for v in (part or (None, None, None)))


def table_2() -> Table:
    """The row "current" on the paper's mesh, what finer interpolation gives, and the exact rod."""
    current = Row("current: 8 linear elements", tips(), printed("current"))
    reference = tuple(np.concatenate([exact(force) + START for force in LOADS]).tolist())
    rows = (
        current,
        Row("8 quadratic elements", tips(8, 2)),
        Row("exact rod (shooting)", reference),
        Row("Bathe & Bolourchi 1979, beside the exact rod", reference, printed("Bathe & Bolourchi 1979")),
    )
    word = "agrees" if agrees(current, 2, cut=True) else "does NOT agree"
    off = max(abs((a or 0.0) - b) for a, b in zip(current.ours[6:], reference[6:], strict=True))
    return Table(
        "Table II",
        "45° bend: position of the tip",
        ("φ1", "φ2", "φ3") * len(LOADS),
        rows,
        ".4f",
        f"The row of the current element {word} in all printed digits, which are cut off; on this mesh it is "
        f"{off:.2f} "
        "away from the exact rod at F = 600.",
        (
            "Not printed, and needed: elements are straight with directors along each chord, the shear factor is "
            "1, J = 1/6.",
            "Linear elements are too flexible where a rod is curved, a known price of interpolating directors.",
        ),
        groups=tuple(f"F = {force:g}" for force in LOADS),
    )
