"""Curves from a file become rods that meet: ends near one another are snapped onto one node, and all of it is said."""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

import importlib
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.checks import nearest, number, shown
from directrix.curves import Arc, Curve, Polyline, Spline
from directrix.errors import ModelError
from directrix.model import Model
from directrix.section import Section

Array = NDArray[np.float64]
Sections = Section | Mapping[Any, Section]

__all__ = ["NearMissWarning", "Piece", "Sections", "assemble", "extra", "section_for"]

SNAP = 1e-6  # of the size of what is read
NEAR = 10.0  # times the tolerance: ends that near are likely meant to meet


class NearMissWarning(UserWarning):
    """Ends that nearly meet and were not joined."""


@dataclass(frozen=True)
class Piece:
    """A curve that becomes a rod: its name, section, wanted names of its ends, and other arguments of ``Model.rod``."""

    curve: Curve
    section: Section
    name: str
    ends: tuple[str | None, str | None] = (None, None)
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])


def extra(module: str, what: str) -> Any:
    """An optional package; raises ModelError with the line that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.split(".")[0]
        group = "sections" if name in ("sectionproperties", "shapely") else "geometry"
        raise ModelError(f"{what} needs {name}, which is not installed", f"pip install 'directrix[{group}]'") from None


def section_for(sections: Sections, key: Any, where: str) -> Section:
    """The section of a group, layer or name; raises ModelError with those there are."""
    if isinstance(sections, Section):
        return sections
    if not isinstance(sections, Mapping):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"sections = {shown(sections)} are neither a section nor a table of them", "use dx.Section")
    for known in (key, str(key)):  # keys of a case are text, tags of a mesh numbers
        if known in sections:
            return sections[known]
    names = [str(k) for k in sections]
    raise ModelError(
        f"{where} is of {key!r}, for which there is no section",
        f"{nearest(str(key), names)}sections are given for {', '.join(names) or 'nothing'}",
    )


def assemble(
    pieces: Sequence[Piece], *, snap: float | None = None, model: Model | None = None, source: str = "geometry"
) -> Model:
    """A model of rods from ``pieces``, whose ends within ``snap`` of one another become one node.

    The first of the ends, in the order of the pieces, stays where it is; ``snap`` is 1e-6 of the size unless given, 0
    joins what has one name and nothing else. Nodes without a name are "n1", "n2", …. A polyline is split where an end
    lies on one of its corners. What was moved, merged and split is in ``model.imported`` and in ``model.notes()``; ends
    nearer than ten times ``snap`` that were not joined, and ends that lie on the inside of a straight part, are said
    there and warned of (:class:`NearMissWarning`).

    Raises ModelError when there is nothing, two rods have one name, or a curve would vanish by snapping.
    """
    if not pieces:
        raise ModelError(f"{source} holds no curve that could become a rod", "check what it holds")
    points = np.array([p.curve.position(f * p.curve.length) for p in pieces for f in (0.0, 1.0)])
    size = float(max(np.ptp(points, axis=0).max(), max(p.curve.length for p in pieces)))
    reach = SNAP * size if snap is None else number(snap, "snap", least=0.0)
    said: list[str] = []
    pieces = _split(pieces, points, reach, said)
    points = np.array([p.curve.position(f * p.curve.length) for p in pieces for f in (0.0, 1.0)])
    wanted = [name for p in pieces for name in p.ends]
    taken = {w for w in wanted if w} | {n for rod in (model.rods if model else ()) for n in rod.names}
    node, names, places = _nodes(points, wanted, reach, taken, said, pieces)
    rods: list[dict[str, Any]] = []
    for k, piece in enumerate(pieces):
        a, b = node[2 * k], node[2 * k + 1]
        if a == b:
            raise ModelError(
                f"both ends of rod {piece.name!r} are at node {names[a]!r}",
                "a closed curve needs two rods; a short one a smaller snap",
            )
        curve = piece.curve
        for end, at in ((0, a), (1, b)):
            moved = float(np.linalg.norm(points[2 * k + end] - places[at]))
            if moved > 1e-12 * size:
                curve = _moved(curve, end, places[at], piece.name)
                which = ("first", "second")[end]
                said.append(f"rod {piece.name!r}: its {which} end moved by {moved:.4g} onto node {names[at]!r}")
        rods.append(
            {
                **piece.options,
                "curve": curve,
                "section": piece.section,
                "name": piece.name,
                "ends": (names[a], names[b]),
            }
        )
    misses = _misses(pieces, places, names, node, reach)
    for miss in misses:
        warnings.warn(f"{source}: {miss}", NearMissWarning, stacklevel=3)
    base = Model(name=source) if model is None else model
    return replace(base.add_rods(rods), imported=(*base.imported, *said, *misses))


def _tree(points: Array) -> Any:
    from scipy.spatial import KDTree  # slow to import, and few models need it

    return KDTree(points)


def _split(pieces: Sequence[Piece], points: Array, reach: float, said: list[str]) -> list[Piece]:
    """Polylines with an end of another piece on a corner become two rods there."""
    tree = _tree(points)
    out: list[Piece] = []
    for piece in pieces:
        curve = piece.curve
        inner = curve.points[1:-1] if isinstance(curve, Polyline) else ()
        if not inner:
            out.append(piece)
            continue
        assert isinstance(curve, Polyline)
        hit = [k + 1 for k, p in enumerate(inner) if tree.query_ball_point(p, reach)]
        cuts = [0, *hit, len(curve.points) - 1]
        if not hit:
            out.append(piece)
            continue
        said.append(f"rod {piece.name!r}: split at {len(hit)} of its corners, where other rods end")
        counts = piece.options.get("elements")
        for j, (a, b) in enumerate(pairwise(cuts)):
            part = replace(curve, points=curve.points[a : b + 1])
            options = dict(piece.options)
            if counts is not None:
                options["elements"] = max(1, round(counts * part.length / curve.length))
            ends = (piece.ends[0] if j == 0 else None, piece.ends[1] if j == len(hit) else None)
            out.append(replace(piece, curve=part, name=f"{piece.name}.{j + 1}", ends=ends, options=options))
    return out


def _nodes(
    points: Array, wanted: Sequence[str | None], reach: float, taken: set[str], said: list[str], pieces: Sequence[Piece]
) -> tuple[list[int], list[str], list[Array]]:
    """Node of every end, names and places of the nodes."""
    node, names, places = [-1] * len(points), [], []
    known: dict[str, int] = {}
    tree = _tree(points) if reach > 0.0 else None
    for k, point in enumerate(points):
        name = wanted[k]
        if node[k] < 0 and name in known:
            node[k] = known[name]
            if (gap := float(np.linalg.norm(point - places[node[k]]))) > reach and gap > 0.0:
                raise ModelError(
                    f"node {name!r} is at two places, {gap:.3g} apart (rod {pieces[k // 2].name!r})",
                    "give the ends one position, a larger snap, or different names",
                )
        if node[k] < 0:
            node[k] = len(places)
            places.append(point)
            names.append(name or _free("n", len(places), taken))
        here = node[k]
        if name and name not in known:
            known[name] = here
            if names[here] != name:
                said.append(f"node {name!r} was merged onto node {names[here]!r}")
        for other in tree.query_ball_point(point, reach) if tree and places[here] is point else ():
            if node[other] < 0:
                node[other] = here
    return node, names, places


def _free(prefix: str, first: int, taken: set[str]) -> str:
    while f"{prefix}{first}" in taken:
        first += 1
    taken.add(f"{prefix}{first}")
    return f"{prefix}{first}"


def _moved(curve: Curve, end: int, place: Array, name: str) -> Curve:
    """The curve with an end at ``place``."""
    x, y, z = place.tolist()
    match curve:
        case Polyline() | Spline():
            points = (((x, y, z), *curve.points[1:]), (*curve.points[:-1], (x, y, z)))[end]
            return replace(curve, points=points)
        case Arc():
            return replace(curve, **{("start", "end")[end]: (x, y, z)})
        case _:
            raise ModelError(
                f"rod {name!r} would be moved onto a node, and its {type(curve).__name__} cannot be",
                "end it at the node, or give a smaller snap",
            )


def _misses(
    pieces: Sequence[Piece], places: Sequence[Array], names: Sequence[str], node: Sequence[int], reach: float
) -> list[str]:
    """Nodes that nearly meet, and nodes on the inside of straight parts."""
    if reach == 0.0:
        return []
    at = np.array(places)
    out = [
        f"nodes {names[a]!r} and {names[b]!r} are {np.linalg.norm(at[a] - at[b]):.4g} apart and were not joined "
        f"(snap = {reach:.4g})"
        for a, b in sorted(_tree(at).query_pairs(NEAR * reach))
    ]
    tree = _tree(at)
    for k, piece in enumerate(pieces):
        if not isinstance(piece.curve, Polyline):
            continue
        for a, b in pairwise(np.array(piece.curve.points)):
            way = b - a
            near = np.array(tree.query_ball_point(0.5 * (a + b), 0.5 * np.linalg.norm(way) + reach), int)
            if not near.size:
                continue
            along = (at[near] - a) @ way / (way @ way)
            gap = np.linalg.norm(at[near] - a - along[:, None] * way, axis=1)
            inside = (gap <= reach) & (along > 0.0) & (along < 1.0)
            for hit in near[inside].tolist():
                if hit not in (node[2 * k], node[2 * k + 1]):
                    out.append(f"node {names[hit]!r} lies on rod {piece.name!r} between its ends and was not joined")
    return out
