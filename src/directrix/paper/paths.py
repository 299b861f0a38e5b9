"""Example 2, Table I: one element, its ends turned on two paths to the same rotations."""

from __future__ import annotations

import numpy as np

import directrix as dx
from directrix.integrators import Formulation
from directrix.paper.printed import TABLE_I
from directrix.paper.record import Numbers, Row, Table, agrees, ten
from directrix.verification.path_independence import closed_form, end_state

FORMULATIONS: dict[str, Formulation] = {
    "Simo & Vu-Quoc": dx.SimoVuQuoc(),
    "current": dx.Directors(),
    "Crisfield & Jelenić": dx.CrisfieldJelenic(),
}


def table_1() -> Table:
    """Curvature and displacement of B at the end of both paths."""
    rows: list[Row] = []
    gaps: dict[str, float] = {}
    for name, formulation in FORMULATIONS.items():
        ends = [np.concatenate(end_state(path, formulation)) for path in ("I", "II")]
        gaps[name] = float(np.abs(ends[1] - ends[0])[:3].max())
        for path, end in zip(("I", "II"), ends, strict=True):
            label = f"{name}, path {path}"
            rows.append(Row(label, tuple(end.tolist()), TABLE_I.get(label)))
    exact = np.concatenate(closed_form())
    rows.append(Row("closed form of the current element", tuple(exact.tolist())))
    by_name = {row.label: row for row in rows}
    simo = sum(agrees(_part(by_name[f"Simo & Vu-Quoc, path {p}"], 0, 3), 5) for p in ("I", "II"))
    current = sum(agrees(_unsigned(by_name[f"current, path {p}"]), 5, cut=True) for p in ("I", "II"))
    one, two = (TABLE_I[f"Simo & Vu-Quoc, path {path}"][:3] for path in ("I", "II"))
    printed = max(abs(b - a) for a, b in zip(one, two, strict=True))
    return Table(
        "Table I",
        "Path independence: one element, two paths",
        ("κ1", "κ2", "κ3", "u1", "u2", "u3"),
        tuple(rows),
        ".5f",
        f"Curvatures of both formulations agree in all printed digits ({simo + current} of 4 rows), but for the sign "
        f"of one κ3. Between the paths they change by {gaps['Simo & Vu-Quoc']:.5f} (Simo–Vu-Quoc; "
        f"printed: {printed:.5f}), "
        f"{ten(gaps['current'])} (current), {ten(gaps['Crisfield & Jelenić'])} (Crisfield–Jelenić).",
        (
            "κ3 of the current element is printed without its minus (see the errata); its digits are cut off, "
            "not rounded.",
            "The printed tips of Simo–Vu-Quoc are not reproduced: they are not at the distance 1 of A that a "
            "rod without strain keeps "
            "(see the errata).",
        ),
        printed=".5f",
    )


def _part(row: Row, first: int, last: int) -> Row:
    """Some numbers of a row."""
    return Row(row.label, row.ours[first:last], row.printed and row.printed[first:last])


def _unsigned(row: Row) -> Row:
    """A row without signs."""

    def size(values: Numbers) -> Numbers:
        return tuple(v and abs(v) for v in values)

    return Row(row.label, size(row.ours), row.printed and size(row.printed))
