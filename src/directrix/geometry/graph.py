"""Rods from a graph: nodes with places, edges that become rods."""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np

from directrix.checks import file, number, shown, vector
from directrix.curves import line, polyline
from directrix.errors import InputError, ModelError
from directrix.geometry.pieces import Piece, Sections, assemble, extra, section_for
from directrix.model import Model
from directrix.section import Section

__all__ = ["from_graph"]

OPTIONS = ("elements", "order", "points", "nodes", "twist")
KNOWN = ("section", "name", "curve", *OPTIONS)


def from_graph(
    graph: Any, *, section: Sections | None = None, snap: float = 0.0, scale: float = 1.0, model: Model | None = None,
    pos: str = "pos", strict: bool = True, **options: Any,
) -> Model:  # fmt: skip
    """Rods for the edges of a networkx graph, whose nodes have a place as attribute ``pos``, (x, y, z) or (x, y).

    Parameters
    ----------
    graph
        Or a file of one: GraphML, GML, or JSON as ``networkx.node_link_data`` has it; there a node may have ``x``,
        ``y`` (and ``z``) in place of ``pos``. Nodes are named by ``str(node)``. An edge may have ``section`` (a
        Section, or a key of ``section=``, whose key None is for edges without), ``name`` ("u-v" unless given),
        ``curve`` (a curve, or the points between the ends) and ``elements``, ``order``, ``points``, ``nodes``,
        ``twist`` as in ``Model.rod``.
    section
        Of edges without one: a Section; or a table of sections for names.
    snap
        Nodes nearer to one another than this are merged onto the first; reported in ``model.imported``.
    scale
        A length of the graph in lengths of the model; ``curve`` of an edge as points is scaled too.
    model
        What to add to; nodes of one name are joined.
    strict
        Refuse other attributes of edges, which may be mistyped ones.
    options
        Of all rods, e.g. ``elements=4``.

    Raises ModelError when networkx is missing and the graph is none, a node has no place or an edge no section,
    InputError for a file that is no graph.
    """
    scale = number(scale, "scale", above=0.0)
    if isinstance(graph, (str, PathLike)):
        graph = _read(file(cast("str", graph), "graph"), pos)
    if not all(hasattr(graph, a) for a in ("nodes", "edges", "is_multigraph")):
        extra("networkx", "a graph")
        raise ModelError(f"{shown(graph)} is not a graph", "give a networkx.Graph")
    places: dict[Any, tuple[float, float, float]] = {}
    for node, data in graph.nodes(data=True):
        if pos not in data:
            raise ModelError(f"node {str(node)!r} of the graph has no {pos!r}", f"give it {pos}=(x, y, z)")
        at = list(data[pos])
        at = vector([*at, 0.0] if len(at) == 2 else at, f"{pos} of node {str(node)!r}")
        places[node] = (scale * at[0], scale * at[1], scale * at[2])
    names = [str(node) for node in places]
    if len(set(names)) != len(names):
        raise ModelError("two nodes of the graph have one name as text", "give nodes names that differ")
    keyed = graph.is_multigraph()
    pieces: list[Piece] = []
    for edge in graph.edges(keys=True, data=True) if keyed else graph.edges(data=True):
        u, v, data = edge[0], edge[1], edge[-1]
        name = str(data.get("name", f"{u}-{v}-{edge[2]}" if keyed and edge[2] else f"{u}-{v}"))
        if strict and (other := [k for k in data if k not in (*KNOWN, "weight")]):
            raise ModelError(f"edge {name!r} has {other[0]!r}", f"use {', '.join(KNOWN)}, or strict=False")
        own = data.get("section")
        if not isinstance(own, Section):
            none = own is None and not isinstance(section, Section) and None not in (section or ())
            if none or section is None or (own is not None and isinstance(section, Section)):
                said = f"edge {name!r} has no section" + (f" {own!r}" if own else "")
                raise ModelError(said, "give it one, or section=")
            own = section_for(section, own, f"edge {name!r}")
        curve = data.get("curve")
        if curve is None:
            curve = line(places[u], places[v])
        elif not hasattr(curve, "frames"):
            curve = polyline([places[u], *(scale * np.asarray(curve, float)), places[v]])
        given = {**options, **{k: data[k] for k in OPTIONS if k in data}}
        pieces.append(Piece(curve, own, name, (str(u), str(v)), given))
    return assemble(pieces, snap=snap, model=model, source="graph")


def _read(path: Path, pos: str) -> Any:
    """The graph of a file, its nodes with ``pos``. Raises InputError."""
    networkx, where = extra("networkx", "a graph"), str(path)
    readers = {".graphml": networkx.read_graphml, ".gml": networkx.read_gml, ".json": _node_link}
    if path.suffix.lower() not in readers:
        raise InputError("is no file of a graph by its ending", f"use one of {', '.join(readers)}", where)
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", "check the path and the permissions", where) from None
    try:
        graph = readers[path.suffix.lower()](path)
        for _, data in graph.nodes(data=True):
            if pos not in data and "x" in data and "y" in data:
                data[pos] = [float(data.pop(c)) for c in "xyz" if c in data]
    except Exception as error:  # readers of networkx raise what they like
        raise InputError(f"is no graph that networkx reads: {error}", "write it with networkx", where) from None
    return graph


def _node_link(path: Path) -> Any:
    from networkx import node_link_graph

    data = json.loads(path.read_text("utf-8"))
    return node_link_graph(data, edges="edges" if "edges" in data else "links")
