"""Rods from the line cells of a mesh file (meshio): chains of them become one rod each."""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from directrix.checks import file, number
from directrix.curves import polyline, spline
from directrix.errors import ModelError
from directrix.geometry.pieces import Piece, Sections, assemble, extra, section_for
from directrix.model import Model

__all__ = ["from_mesh"]

TAGS = ("gmsh:physical", "cell_tags", "medit:ref", "region", "section")


class _Cell(NamedTuple):
    points: tuple[int, ...]  # in order along it, with the one in the middle
    group: Any


def from_mesh(
    path: str | PathLike[str], section: Sections, *, snap: float | None = None, by: str | None = None,
    scale: float = 1.0, elements: int | None = None, model: Model | None = None, **options: Any,
) -> Model:  # fmt: skip
    """Rods from the line and line3 cells of a mesh file in a format of meshio.

    Cells of one group that meet end to end, two at a point, become one rod, a closed chain two; rods are "GROUP.1",
    "GROUP.2", … ("rod.1" without groups), nodes "p7" by the index of their point. line3 cells become a spline
    through all their points.

    Parameters
    ----------
    section
        A Section, or a table of sections for the groups: names of physical groups, or values of the cell data.
    by
        The cell data that holds the groups; the usual tags unless given. Points in a physical group of vertices become
        nodes with its name.
    scale
        A length of the file in lengths of the model.
    elements
        Of every rod; one a cell unless given. ``options`` are others of ``Model.rod``.
    snap, model
        As for ``directrix.geometry.assemble``; all snapping is reported in ``model.imported``.

    Raises ModelError when meshio is missing, the file cannot be read, has no line cells, or a group has no section.
    """
    meshio = extra("meshio", "a mesh file")
    name = file(path, "mesh file")
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # meshio prints its warnings
            mesh = meshio.read(name)
    except (Exception, SystemExit) as error:  # whatever a reader of meshio raises
        raise ModelError(f"{name} cannot be read: {error}", "give a mesh file of a format that meshio knows") from None
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    points *= number(scale, "scale", above=0.0)
    if not np.all(np.isfinite(points)):
        raise ModelError(f"{name} has points that are not finite", "mend the mesh")
    cells, vertices = _cells(mesh, by, str(name))
    if not cells:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        raise ModelError(f"{name} has no line or line3 cells", f"its cells: {kinds}")
    counts: dict[str, int] = {}
    pieces: list[Piece] = []
    for group, chain, smooth in _chains(cells, set(vertices)):
        label = "rod" if group is None else str(group)
        counts[label] = counts.get(label, 0) + 1
        way = [tuple(points[k].tolist()) for k in chain]
        curve = spline(way) if smooth else polyline(way)
        parts = (len(chain) - 1) // (2 if smooth else 1)
        given = {"elements": elements or parts, **options}
        ends = tuple(vertices.get(k, f"p{k}") for k in (chain[0], chain[-1]))
        rod = f"{label}.{counts[label]}"
        pieces.append(Piece(curve, section_for(section, group, f"rod {rod!r}"), rod, (ends[0], ends[1]), given))
    return assemble(pieces, snap=snap, model=model, source=name.name)


def _cells(mesh: Any, by: str | None, name: str) -> tuple[list[_Cell], dict[int, str]]:
    """Line cells with their groups, and the names of points."""
    if by is not None and by not in mesh.cell_data:
        raise ModelError(f"{name} has no cell data {by!r}", f"it has {', '.join(mesh.cell_data) or 'none'}")
    key = by if by is not None else next((t for t in TAGS if t in mesh.cell_data), None)
    texts = {(int(v[1]), int(v[0])): k for k, v in mesh.field_data.items()}
    sets = {k: v for k, v in getattr(mesh, "cell_sets", {}).items() if not k.startswith("gmsh:")}
    cells: list[_Cell] = []
    named: dict[str, list[int]] = {}
    for b, block in enumerate(mesh.cells):
        if block.type not in ("line", "line3", "vertex"):
            continue
        tags = mesh.cell_data[key][b] if key is not None else [None] * len(block.data)
        groups = [t if t is None else texts.get((0 if block.type == "vertex" else 1, int(t)), _plain(t)) for t in tags]
        for text, members in sets.items() if key is None else ():
            for k in [] if members[b] is None else np.asarray(members[b], int).tolist():
                groups[k] = text
        for cell, group in zip(block.data.tolist(), groups, strict=True):
            if block.type == "vertex":
                if isinstance(group, str):
                    named.setdefault(group, []).append(cell[0])
                continue
            cells.append(_Cell((cell[0], cell[2], cell[1]) if len(cell) == 3 else tuple(cell), group))
    vertices: dict[int, str] = {}
    for group, members in named.items():
        for k, point in enumerate(sorted(set(members))):
            vertices[point] = group if len(set(members)) == 1 else f"{group}.{k + 1}"
    return cells, vertices


def _plain(tag: Any) -> Any:
    """A tag as a number of Python."""
    value = float(tag)
    return int(value) if value == int(value) else value


def _chains(cells: list[_Cell], stops: set[int]) -> Iterator[tuple[Any, list[int], bool]]:
    """Chains of cells between points where something else happens: group, points in order, smooth or not."""
    at: dict[int, list[int]] = {}
    for k, cell in enumerate(cells):
        for p in (cell.points[0], cell.points[-1]):
            at.setdefault(p, []).append(k)

    def goes_on(p: int) -> bool:
        if p in stops or len(at[p]) != 2:
            return False
        a, b = (cells[k] for k in at[p])
        return a.group == b.group and len(a.points) == len(b.points)

    used = [False] * len(cells)

    def walk(k: int, p: int) -> list[int]:
        """Points from ``p`` on along cell ``k`` until the chain ends or closes."""
        chain = [p]
        while True:
            used[k] = True
            way = cells[k].points if cells[k].points[0] == chain[-1] else cells[k].points[::-1]
            chain += way[1:]
            if not goes_on(chain[-1]):
                return chain
            k = next((other for other in at[chain[-1]] if not used[other]), -1)
            if k < 0:
                return chain

    for k, cell in enumerate(cells):
        for p in (cell.points[0], cell.points[-1]):
            if not used[k] and not goes_on(p):
                yield cell.group, walk(k, p), len(cell.points) == 3
    for k, cell in enumerate(cells):  # what is left is closed
        if not used[k]:
            chain, step = walk(k, cell.points[0]), len(cell.points) - 1
            middle = (len(chain) - 1) // (2 * step) * step
            yield cell.group, chain[: middle + 1], len(cell.points) == 3
            yield cell.group, chain[middle:], len(cell.points) == 3
