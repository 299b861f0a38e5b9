"""Example 2, Table I: one element, its ends turned on two paths to the same rotations."""

from __future__ import annotations

from directrix.paper.printed import TABLE_I
from directrix.paper.record import Row, Table, agrees, ten
from directrix.verification.path_independence import closed_form, end_state


def table_1() -> Table:
    """Curvature and displacement of B at the end of both paths."""
    rows: list[Row] = []
    for path in ("I", "II"):
        curvature, tip = end_state(path)
        name = f"current, path {path}"
        rows.append(Row(name, (*curvature.tolist(), *tip.tolist()), TABLE_I[name]))
    curvature, tip = closed_form()
    exact = Row("closed form of the element", (*curvature.tolist(), *tip.tolist()))
    signed = [
        Row(r.label, tuple(abs(v or 0.0) for v in r.ours), tuple(abs(v or 0.0) for v in r.printed or ())) for r in rows
    ]
    gap = max(abs((a or 0.0) - (b or 0.0)) for a, b in zip(rows[0].ours, rows[1].ours, strict=True))
    good = sum(agrees(r, 5, cut=True) for r in signed)
    return Table(
        "Table I",
        "Path independence: one element, two paths",
        ("κ1", "κ2", "κ3", "u1", "u2", "u3"),
        (*rows, exact),
        ".5f",
        f"{good} of 2 rows of the current element agree in all printed digits, but for the sign of κ3; "
        f"the difference of its paths is {ten(gap)}.",
        notes=("κ3 of the current element is printed without its minus (see the errata).",),
        printed=".5f",
    )
