"""A result for PyVista: the points, lines and data that ParaView shows."""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from typing import Any

import numpy as np

from directrix.checks import whole
from directrix.exports.labelled import needed
from directrix.result import Result
from directrix.storage.fields import cell_data, field_data, lines, point_data, points_of

__all__ = ["to_pyvista"]


def to_pyvista(result: Result, at: int | None = None) -> Any:
    """The saved instant ``at`` as PolyData (negative counts from the end), or all of them as a MultiBlock.

    One line cell an element through its nodes. Point data: displacement, velocity, directors ``d1``, ``d2``, ``d3``,
    arclength; cell data: mean section forces and strains; both: the number of the rod. Field data: energies, load
    factor, ``time``. The blocks are named "t = …". Raises ModelError without pyvista, and where there is no such
    instant.
    """
    pv: Any = needed("pyvista", "a scene")
    count = len(result.t)
    if at is not None:
        at = whole(at, "at", -count, count - 1) % count
    connectivity, offsets = lines(result.mesh)
    cells = np.insert(connectivity, offsets[:-1], np.diff(offsets))
    nodes = points_of(result.mesh)
    data = [list(make(result)) for make in (point_data, cell_data, field_data)]

    def block(k: int) -> Any:
        mesh = pv.PolyData(result.r[k, nodes], lines=cells)
        for target, arrays in zip((mesh.point_data, mesh.cell_data, mesh.field_data), data, strict=True):
            for name, values in arrays:
                target[name] = values[k if len(values) == count else 0]
        mesh.field_data["time"] = result.t[k : k + 1]
        return mesh

    if at is not None:
        return block(at)
    word = "t" if result.kind == "dynamic" else "load factor"
    blocks = pv.MultiBlock()
    for k in range(count):
        blocks.append(block(k), f"{word} = {result.t[k]:.9g}")
    return blocks
