"""Example 4, Table II: the tip of the 45° bend."""

from __future__ import annotations

import numpy as np

import directrix as dx
from directrix.integrators import Formulation
from directrix.paper.models import bend
from directrix.paper.printed import LOADS, TABLE_II
from directrix.paper.record import Array, Numbers, Row, Table, agrees
from directrix.verification.bend45 import START, exact
from directrix.verification.models import equilibrium

MESHES = (8, 16, 32)


def tips(elements: int = 8, order: int = 1, formulation: Formulation | None = None) -> Array:
    """Positions of the tip under the three loads, one after the other (9,)."""
    found = [equilibrium(bend(f, elements, order), formulation=formulation).node("tip").r[-1] for f in LOADS]
    return np.concatenate(found)


def printed(label: str) -> Numbers:
    """A row of the paper's table."""
    return tuple(v for part in TABLE_II[label] for v in (part or (None, None, None)))


def table_2() -> Table:
    """The three formulations on the paper's mesh, and the exact rod."""
    reference = np.concatenate([exact(force) + START for force in LOADS])
    simo = Row("Simo & Vu-Quoc, 8 linear", _numbers(tips(formulation=dx.SimoVuQuoc())), printed("Simo & Vu-Quoc 1986"))
    current = Row("current, 8 linear", _numbers(tips()), printed("current"))
    rows = (
        simo,
        current,
        Row("Crisfield & Jelenić, 8 linear", _numbers(tips(formulation=dx.CrisfieldJelenic()))),
        Row("current, 8 quadratic", _numbers(tips(8, 2))),
        Row("exact rod (shooting), beside Bathe & Bolourchi", _numbers(reference), printed("Bathe & Bolourchi 1979")),
    )
    word = "agrees" if agrees(current, 2, cut=True) else "does NOT agree"
    met = sum(d is not None and abs(d) <= 0.0051 for d in simo.difference)
    off = float(np.abs(tips() - reference)[6:].max())
    return Table(
        "Table II",
        "45° bend: position of the tip",
        ("φ1", "φ2", "φ3") * len(LOADS),
        rows,
        ".4f",
        f"The row of the current element {word} in all printed digits, which are cut off; of Simo–Vu-Quoc {met} "
        "of 9 numbers do. "
        f"On this mesh the current element is {off:.2f} away from the exact rod at F = 600.",
        (
            "Not printed, and needed: elements are straight with directors along each chord, the shear factor "
            "is 1, J = 1/6.",
            "Linear elements are too flexible where a rod is curved, a known price of interpolating directors.",
            "The last number of Simo–Vu-Quoc depends on the iterations, which it remembers.",
        ),
        groups=tuple(f"F = {force:g}" for force in LOADS),
    )


def convergence() -> Table:
    """Distance of the tip from the exact one at F = 600, and the order it falls with."""
    end = exact(600.0) + START
    rows: list[Row] = []
    formulations: dict[str, Formulation] = {
        "current": dx.Directors(), "Simo & Vu-Quoc": dx.SimoVuQuoc(), "Crisfield & Jelenić": dx.CrisfieldJelenic(),
    }  # fmt: skip
    for order, mesh in ((1, "linear"), (2, "quadratic")):
        for name, formulation in formulations.items():
            models = [bend(600.0, n, order) for n in MESHES]
            found = [equilibrium(m, formulation=formulation).node("tip").r[-1] for m in models]
            errors = [float(np.linalg.norm(tip - end)) for tip in found]
            rows.append(Row(f"{name}, {mesh}", (*errors, float(np.log2(errors[-2] / errors[-1])))))
    orders = [row.ours[-1] or 0.0 for row in rows]
    return Table(
        "Table II, convergence",
        "45° bend, F = 600: distance of the tip from the exact one",
        (*(f"{n} elements" for n in MESHES), "order"),
        tuple(rows),
        ".3g",
        f"All converge to the exact rod, with orders {min(orders[:3]):.2f} … {max(orders[:3]):.2f} (linear) and "
        f"{min(orders[3:]):.2f} … {max(orders[3:]):.2f} (quadratic elements).",
    )


def _numbers(values: Array) -> Numbers:
    return tuple(float(v) for v in values)
