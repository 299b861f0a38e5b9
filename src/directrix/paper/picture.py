"""Figures as pictures that stand inside the page."""

from __future__ import annotations

import base64
import io
from importlib import import_module
from typing import Any

from directrix.drawing import BLUE, GHOST, INK, ORANGE, XYZ, dress, need_matplotlib
from directrix.paper.record import Curve, Figure, Panel, minus

__all__ = ["data_uri"]

WIDTH = 10.0  # inches
COLOURS = (BLUE, ORANGE, XYZ[1], "#a02c8c", "#b8860b", "#00808a", XYZ[0])
STYLES: dict[str, dict[str, Any]] = {
    "dashed": {"ls": (0, (4, 3)), "lw": 1.5},
    "ours": {"color": INK, "lw": 2.0},
    "rival": {"lw": 1.4},
    "ghost": {"color": GHOST, "lw": 1.5},
}


def data_uri(figure: Figure) -> str:
    """The figure as an SVG picture in a ``data:`` address. Raises ModelError without matplotlib."""
    need_matplotlib()
    canvas: Any = import_module("matplotlib.figure")
    backend: Any = import_module("matplotlib.backends.backend_svg")
    rows = -(-len(figure.panels) // figure.columns)
    rc: Any = import_module("matplotlib").rc_context({"font.size": 9.0, "svg.hashsalt": figure.name})
    with rc:
        drawn = canvas.Figure(figsize=(WIDTH, figure.height * rows), layout="constrained")
        backend.FigureCanvasSVG(drawn)
        grid = drawn.subplots(rows, figure.columns, squeeze=False).ravel()
        labels = {tuple(c.label for c in panel.curves) for panel in figure.panels}
        shared = len(figure.panels) > 1 and len(labels) == 1 and not figure.panels[0].picture
        for pen, panel in zip(grid, figure.panels, strict=False):
            _draw(pen, panel, legend=not shared)
        if shared:
            drawn.legend(*grid[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
        for pen in grid[len(figure.panels) :]:
            pen.remove()
        file = io.BytesIO()
        drawn.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def _draw(pen: Any, panel: Panel, legend: bool) -> None:
    colours = iter(COLOURS * len(panel.curves))
    for curve in panel.curves:
        _curve(pen, curve, next(colours), panel)
    if panel.x_range:
        pen.set_xlim(*panel.x_range)
    if panel.y_range:
        pen.set_ylim(*panel.y_range)
    pen.set_title(minus(panel.title), fontsize=8.5)
    if panel.picture:
        pen.set_aspect("equal")
        for line in pen.lines:
            line.set_clip_on(False)
        pen.set_axis_off()
        return
    dress(pen)
    pen.set_xlabel(panel.x)
    pen.set_ylabel(panel.y)
    pen.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4), useMathText=True)
    if legend and any(c.label for c in panel.curves):
        pen.legend(frameon=False, fontsize=8, ncols=1 if len(panel.curves) < 4 else 2)


def _curve(pen: Any, curve: Curve, colour: str, panel: Panel) -> None:
    style: dict[str, Any] = {"color": colour, "lw": 1.7} | STYLES.get(curve.style, {})
    if len(curve.x) <= 16 and not panel.picture:
        style |= {"marker": "o", "ms": 3.0}
    if curve.style == "points":
        style |= {"ls": "", "marker": "o", "ms": 4.0}
    pen.plot(curve.x, curve.y, label=curve.label or None, **style)
    if curve.ends:
        top = panel.y_range[1] if panel.y_range else float("inf")
        pen.plot(
            curve.x[-1:], [min(float(curve.y[-1]), 0.98 * top)], ls="", marker="x", ms=8, mew=2, color=style["color"]
        )
