"""One picture of several runs side by side: momenta, energy, snapshots."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np

from directrix import checks
from directrix import drawing as draw
from directrix.checks import whole
from directrix.drawing import OTHERS
from directrix.errors import ModelError
from directrix.result import Result

__all__ = ["compare_energy_momentum"]


def compare_energy_momentum(results: Mapping[str, Result], path: str | PathLike[str], snapshots: int = 7) -> str:
    """Write one picture (PNG, PDF, SVG by its ending): momenta, energy and snapshots; returns its path.

    ``results`` maps a label to a dynamic result. The first is the conserving one: it gives the energy's
    scale, its kinetic and stored parts, and the snapshots. A run that did not reach its end is marked with
    a cross and the time. After Figures 7-9 of Romero and Armero, IJNME 54 (2002) 1683-1716.
    Raises ModelError when there is nothing to compare, for a static result, and when the file cannot be
    written.
    """
    snapshots, file = whole(snapshots, "snapshots", 1), checks.file(path, "path")
    if not results:
        raise ModelError("there is no result to compare", "give at least one, such as {'energy-momentum': result}")
    for label, result in results.items():
        if result.kind == "static":
            raise ModelError("a static result has no momentum", "give results of simulate", f"results[{label!r}]")
    draw.need_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(12.0, 7.2), layout="constrained")
    FigureCanvasAgg(figure)
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.5, 1.0))
    panels = upper.subplots(1, 3)
    (first_label, first), *others = results.items()
    for pen, history, letter in ((panels[0], "linear", "L"), (panels[1], "angular", "J")):
        title = f"{history} momentum"
        draw.components(pen, first, getattr(first.momentum, history), letter, "-")
        for k, (label, result) in enumerate(others):
            values, colour = getattr(result.momentum, history), OTHERS[k % 3]
            pen.plot(result.t, values, color=colour, lw=1.6, ls=(0, (3, 4)), label=[draw.plain(label), None, None])
            if not result.success:
                pen.plot(np.full(3, result.t[-1]), values[-1], ls="", marker="x", ms=8, mew=2.2, color=colour)
        draw.finish(pen, title, title, below=True)
    _total_energies(panels[2], first_label, first, others)
    for pen in panels:
        pen.set_xlabel("t")
        draw.dress(pen)
    _snapshots(lower, first_label, first, snapshots)
    if file.suffix[1:] not in figure.canvas.get_supported_filetypes():
        raise ModelError(f"{file} names no known kind of picture", "end it in .png, .pdf or .svg")
    try:
        figure.savefig(file, dpi=160)
    except OSError as error:
        raise ModelError(f"cannot write {file}: {error.strerror}", "choose a file in a folder that exists") from None
    return str(file)


def _total_energies(pen: Any, label: str, first: Result, others: list[tuple[str, Result]]) -> None:
    draw.energies(pen, first, f"total, {draw.plain(label)}")
    peak = max([float(first.energy.total.max())] + [float(r.energy.total.max()) for _, r in others])
    # a run that blew up by orders of magnitude must not flatten the conserving curve
    top = min(peak, 4.0 * float(first.energy.total.max())) * 1.12 or 1.0
    for k, (name, result) in enumerate(others):
        colour, total = OTHERS[k % 3], result.energy.total
        pen.plot(result.t, total, color=colour, lw=1.6, ls="-.", label=f"total, {draw.plain(name)}")
        if not result.success:
            end, height = float(result.t[-1]), min(float(total[-1]), 0.96 * top)
            pen.plot([end], [height], ls="", marker="x", ms=10, mew=2.6, color=colour)
            off = float(total[-1]) > top  # the curve has left the panel before it stopped
            pen.annotate(
                f"stops at {draw.clock(result)} = {end:.4g}" + (f"\n(energy {total[-1]:.3g})" if off else ""),
                (end, height), (0, -10) if off else (-9, 0), textcoords="offset points", color=colour,
                ha="center" if off else "right", va="top" if off else "center", fontsize=9,
            )  # fmt: skip
    draw.finish(pen, "energy", "energy", below=True)
    pen.set_ylim(0.0, top)


def _snapshots(figure: Any, label: str, result: Result, count: int) -> None:
    """Shapes side by side at one scale, each about its own centre, since a free body wanders off."""
    picked = draw.evenly(count, len(result.t))
    centres = result.r[picked].mean(axis=1)
    reach = float(np.abs(result.r[picked] - centres[:, None]).max()) or 1.0
    figure.suptitle(f"snapshots of the motion, {draw.plain(label)}", fontsize=10, color=draw.INK)
    axes = figure.subplots(1, len(picked), subplot_kw={"projection": "3d"}, squeeze=False)[0]
    for pen, k, centre in zip(axes, picked, centres, strict=True):
        stage = draw.Stage(pen, (0, 1, 2))
        for rod, colour in zip(
            result.mesh.rods, (draw.BLUE, draw.INK, draw.ORANGE) * len(result.mesh.rods), strict=False
        ):
            stage.line(draw.axis_line(rod, result.r[k]), color=colour, lw=2.4, solid_capstyle="round")
        for limits, middle in zip((pen.set_xlim, pen.set_ylim, pen.set_zlim), centre, strict=True):
            limits(middle - reach, middle + reach)
        pen.set_box_aspect((1, 1, 1), zoom=1.6)
        pen.set_axis_off()
        pen.set_title(f"t = {result.t[k]:.4g}", fontsize=9, y=-0.1, color=draw.INK)
