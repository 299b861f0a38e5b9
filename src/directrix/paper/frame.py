"""Example 3, Figures 3 and 4: the hinged frame past both limit points."""

from __future__ import annotations

from functools import cache

import numpy as np

import directrix as dx
from directrix.drawing import axis_line
from directrix.paper.printed import FIGURE_3, FIGURE_4
from directrix.paper.record import Curve, Figure, Panel, Row, Table
from directrix.result import Result
from directrix.verification.hinged_frame import AT_LIMITS, LIMITS, PATH, limits, moved, trace

MESHES = (5, 10, 20, 40)
# which crossing of a drawn load is meant: the first on the way up and down, the last after the minimum
CROSSING = {13600.0: 0, 17800.0: 0, -5800.0: 0, -7700.0: -1, 15600.0: -1}


@cache
def path(elements: int = 20) -> Result:
    """The whole path, up to the top of the paper's axis, with a state at each load of Figure 3."""
    return trace(elements, to=4.5e4, at=FIGURE_3)


def drawn(result: Result) -> dict[float, int]:
    """The saved instant of each load of Figure 3."""
    return {load: int(np.flatnonzero(result.load_factor == load)[CROSSING[load]]) for load in FIGURE_3}


def figure_3() -> Figure:
    """The frame unloaded and in five states."""
    result = path()
    panels: list[Panel] = []
    for load, k in {0.0: 0, **drawn(result)}.items():
        shapes = [("ghost", result.mesh.r0), ("ours", result.r[k])]
        curves = [
            Curve("", line[:, 0], line[:, 1], style)
            for style, r in shapes
            for line in (axis_line(rod, r) for rod in result.mesh.rods)
        ]
        panels.append(Panel(f"F = {load:g}", "", "", tuple(curves), (-15.0, 135.0), (-15.0, 135.0), picture=True))
    places = moved(result)
    rows = tuple(Row(f"F = {load:g}", tuple(places[k].tolist())) for load, k in drawn(result).items())
    table = Table("Figure 3, numbers", "Displacement of the loaded node", ("to the right", "down"), rows, ".4f", "")
    return Figure(
        "Figure 3",
        "Hinged frame: reference and deformed states",
        tuple(panels),
        "All five printed loads are on the path, which is followed by its own length.",
        (
            "20 + 20 quadratic elements. Whether −7700 is meant before or after the minimum is not said; after "
            "it is drawn.",
        ),
        (table,),
        columns=6,
        height=1.7,
    )


def figure_4() -> Figure:
    """Load over the displacements of its node, and the limit loads on four meshes."""
    result = path()
    places, exact = moved(result), np.array(PATH)
    curves = (
        Curve("vertical displacement", places[:, 1], result.load_factor),
        Curve("horizontal displacement", places[:, 0], result.load_factor),
        Curve("exact (shooting)", np.concatenate([exact[:, 2], exact[:, 1]]), np.tile(exact[:, 0], 2), "points"),
    )
    runs = {f"{n} + {n} elements": limits(trace(n)) for n in MESHES}
    runs["5 + 5, Crisfield & Jelenić"] = limits(trace(5, formulation=dx.CrisfieldJelenic()))
    rows = [
        Row(name, (*found, *(a / b - 1.0 for a, b in zip(found, LIMITS, strict=True)))) for name, found in runs.items()
    ]
    table = Table(
        "Figure 4, numbers", f"Limit loads; exact (shooting): {LIMITS[0]:.3f} and {LIMITS[1]:.3f}",
        ("maximum", "minimum", "maximum off by", "minimum off by"), tuple(rows), (".3f", ".3f", ".1e", ".1e"), "",
    )  # fmt: skip
    high, low = (rows[0].ours[k] or 0.0 for k in (2, 3))
    fine = max(abs(rows[2].ours[k] or 0.0) for k in (2, 3))
    return Figure(
        "Figure 4",
        "Hinged frame: load over displacement",
        (Panel("load over displacement of its node", "displacement", "F", curves, *FIGURE_4),),
        f"The path passes both limit points and goes on to F = {result.load_factor[-1]:.0f}. Limit loads on "
        "the paper's mesh, "
        f"5 + 5 elements, are off the exact ones by {100 * high:.2f} % and {100 * low:.1f} %, on 20 + 20 by "
        f"{100 * fine:.3f} %.",
        (
            f"The exact limits are at displacements {_pair(AT_LIMITS[0])} and {_pair(AT_LIMITS[1])} to the "
            "right and down. "
            "The paper prints no numbers for this example.",
            "Elements of the paper's mesh turn by 32°, where interpolated directors are less exact than "
            "interpolated rotations; the error "
            "falls with the fourth power of the element.",
        ),
        (table,),
        columns=1,
        height=4.2,
    )


def _pair(values: tuple[float, ...]) -> str:
    return f"({values[0]:.4f}, {values[1]:.4f})"
