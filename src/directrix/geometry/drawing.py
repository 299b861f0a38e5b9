"""Rods from a DXF drawing (ezdxf): lines, arcs, circles, polylines with bulges, splines; layers say the section."""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.checks import file, number
from directrix.curves import Curve, Polyline, arc, line, polyline, spline
from directrix.errors import ModelError
from directrix.geometry.pieces import Piece, Sections, assemble, extra, section_for
from directrix.model import Model

Array = NDArray[np.float64]

__all__ = ["from_dxf"]

UNITS = {0: "no unit", 1: "inches", 2: "feet", 4: "millimetres", 5: "centimetres", 6: "metres"}
READ = ("LINE", "ARC", "CIRCLE", "LWPOLYLINE", "POLYLINE", "SPLINE")


def from_dxf(
    path: str | PathLike[str], section: Sections, *, snap: float | None = None, scale: float = 1.0,
    layers: Iterable[str] | None = None, model: Model | None = None, **options: Any,
) -> Model:  # fmt: skip
    """Rods from the model space of a DXF drawing.

    A line, an arc, each straight stretch or bulge of a polyline, and a spline become a rod, a circle two; rods are
    "LAYER.1", "LAYER.2", … in the order of the drawing, nodes "n1", "n2", …. A spline of the drawing becomes a cubic
    spline through points of it; how far it is off is said. What is on other layers or no curve is left out, and said.

    Parameters
    ----------
    section
        A Section, or a table of sections for the layers.
    layers
        Which to read; all for which there is a section unless given.
    scale
        A length of the drawing in lengths of the model. The unit that the drawing says is reported, not used.
    snap, model, options
        As for ``directrix.geometry.assemble`` and ``Model.rod``; all snapping is reported in ``model.imported``.

    Raises ModelError when ezdxf is missing, the file is no drawing, or holds no curve on these layers.
    """
    ezdxf = extra("ezdxf", "a drawing")
    name = file(path, "drawing")
    try:
        drawing = ezdxf.readfile(name)
    except OSError as error:
        raise ModelError(f"{name} cannot be read: {error.strerror or error}", "give a DXF file") from None
    except Exception as error:  # whatever a reader of ezdxf raises
        raise ModelError(f"{name} is no drawing: {error}", "save it as DXF again") from None
    number(scale, "scale", above=0.0)
    chosen = None if layers is None else {layers} if isinstance(layers, str) else set(layers)
    if chosen is None and not hasattr(section, "stiffness"):
        chosen = set(section)  # type: ignore[arg-type]
    counts: Counter[str] = Counter()
    left: Counter[str] = Counter()
    pieces: list[Piece] = []
    said = [
        f"the drawing is in {UNITS.get(drawing.header.get('$INSUNITS', 0), 'a unit of its own')}, scale = {scale:g}"
    ]
    for entity in drawing.modelspace():
        kind, layer = entity.dxftype(), entity.dxf.layer
        if kind not in READ or (chosen is not None and layer not in chosen):
            left[f"{kind} on layer {layer!r}"] += 1
            continue
        for curve, gap in _curves(entity, kind, scale):
            counts[layer] += 1
            rod = f"{layer}.{counts[layer]}"
            if gap:
                said.append(f"rod {rod!r}: a spline within {gap:.3g} of that of the drawing")
            pieces.append(Piece(curve, section_for(section, layer, f"rod {rod!r}"), rod, options=options))
    said += [f"left out: {count} {what}" for what, count in left.items()]
    if not pieces:
        raise ModelError(f"{name} holds no curve on these layers", "; ".join(said[1:]) or "the model space is empty")
    made = assemble(pieces, snap=snap, model=model, source=name.name)
    return replace(made, imported=(*made.imported, *said))


def _curves(entity: Any, kind: str, scale: float) -> Iterator[tuple[Curve, float]]:
    """The curves of an entity, and how far they are off it."""

    def at(point: Any) -> Array:
        return scale * np.array([point[0], point[1], point[2] if len(point) > 2 else 0.0])

    if kind == "LINE":
        if entity.dxf.start.distance(entity.dxf.end) > 0.0:
            yield line(at(entity.dxf.start), at(entity.dxf.end)), 0.0
    elif kind in ("ARC", "CIRCLE"):
        first, turn = (entity.dxf.start_angle, entity.dxf.end_angle) if kind == "ARC" else (0.0, 360.0)
        turn = (turn - first) % 360.0 or 360.0
        parts = 2 if turn > 359.0 else 1
        angles = first + np.linspace(0.0, turn, 2 * parts + 1)
        points = [at(p) for p in entity.vertices(angles.tolist())]
        if parts == 2 and turn == 360.0:
            points[-1] = points[0]
        for k in range(parts):
            yield arc(*points[2 * k : 2 * k + 3]), 0.0
    elif kind == "SPLINE":
        tool = entity.construction_tool()
        count = max(9, 4 * len(tool.control_points) + 1)
        u = np.linspace(tool.knots()[0], tool.knots()[-1], count)
        points = np.array([at(p) for p in tool.points(u.tolist())])
        closed = np.linalg.norm(points[0] - points[-1]) <= 1e-9 * np.ptp(points)
        for part in (points[: count // 2 + 1], points[count // 2 :]) if closed else (points,):
            yield spline(part.tolist()), _off(spline(part.tolist()), tool, scale)
    else:
        straight: list[Array] = []
        for piece in entity.virtual_entities():
            for curve, gap in _curves(piece, piece.dxftype(), scale):
                if isinstance(curve, Polyline):
                    straight += [np.array(p) for p in (curve.points if not straight else curve.points[1:])]
                    continue
                yield from _stretch(straight)
                straight = []
                yield curve, gap
        yield from _stretch(straight)


def _stretch(points: list[Array]) -> Iterator[tuple[Curve, float]]:
    """A polyline; two where it closes on itself."""
    if not points:
        return
    if len(points) > 3 and np.linalg.norm(points[0] - points[-1]) <= 1e-12 * np.abs(points).max():
        middle = (len(points) - 1) // 2
        yield polyline(points[: middle + 1]), 0.0
        yield polyline(points[middle:]), 0.0
    else:
        yield polyline(points), 0.0


def _off(curve: Any, tool: Any, scale: float) -> float:
    from scipy.spatial import KDTree

    u = np.linspace(tool.knots()[0], tool.knots()[-1], 200)
    dense = curve.position(np.linspace(0.0, curve.length, 4001))
    exact = scale * np.array([tuple(p) for p in tool.points(u.tolist())])
    return float(KDTree(dense).query(exact)[0].max())
