"""Pictures of a result with matplotlib: ``ax=`` in, the axes out. All numbers carry the model's units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix import checks
from directrix import drawing as draw
from directrix.checks import choice, flag, shown, whole
from directrix.errors import ModelError
from directrix.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

__all__ = ["Plots", "compare_energy_momentum"]

OTHERS = ("#a02c8c", "#b8860b", "#00808a")
Quantity = Literal["displacement", "r", "v", "reaction"]
Component = Literal["x", "y", "z"]
COMPONENTS = ("x", "y", "z")


@dataclass(frozen=True)
class Plots:
    """The pictures of one result. Every method draws into ``ax`` or makes a figure, and returns the axes.

    Shapes lie in a 3-D axes (``projection="3d"``); a result that stays in a coordinate plane is drawn in
    that plane unless a 3-D axes is given. Each method raises ModelError when matplotlib is missing.
    """

    result: Result

    def shape(self, at: int = -1, ax: Axes | None = None) -> Axes:
        """Deformed axis at saved instant ``at`` (negative counts from the end) over the undeformed one; rigid arms of
        bodies are thin lines, joints small open circles.

        Raises ModelError when there is no such instant.
        """
        result = self.result
        count = len(result.t)
        if not isinstance(at, (int, np.integer)) or isinstance(at, bool) or not -count <= at < count:  # pyright: ignore
            raise ModelError(
                f"there is no saved instant {shown(at)}", f"instants are 0 … {count - 1}, or -1 for the last"
            )
        stage = draw.stage(result, ax)
        draw.ghost(stage, result)
        for rod in result.mesh.rods:
            stage.line(draw.axis_line(rod, result.r[at]), color=draw.BLUE, lw=2.2, solid_capstyle="round")
            stage.line(result.r[at, rod.nodes], ls="", marker="o", ms=2.5, color=draw.INK)
        draw.arms(stage, result, at, color=draw.GREY)
        draw.names(stage, result, at)
        draw.joints(stage, result, at)
        stage.finish(f"{result.name}, {draw.clock(result)} = {result.t[at]:.4g}")
        return stage.ax

    def motion(self, frames: int = 12, ax: Axes | None = None) -> Axes:
        """``frames`` deformed shapes spread evenly over the saved instants, coloured by time.

        Raises ModelError when ``frames`` is not a positive whole number.
        """
        result = self.result
        frames = whole(frames, "frames", 1)
        stage = draw.stage(result, ax)
        from matplotlib import colormaps, colors
        from matplotlib.cm import ScalarMappable

        # viridis without its pale end, which vanishes on white paper
        hues: Any = colors.ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
        picked = draw.evenly(frames, len(result.t))
        order = draw.abscissa(result)
        lo, hi = float(order.min()), float(order.max())
        norm: Any = colors.Normalize(lo, hi if hi > lo else lo + 1.0)
        draw.ghost(stage, result)
        for k in picked:
            for rod in result.mesh.rods:
                stage.line(draw.axis_line(rod, result.r[k]), color=hues(norm(order[k])), lw=1.8)
            draw.arms(stage, result, int(k), color=hues(norm(order[k])))
        draw.names(stage, result, int(picked[-1]))
        draw.joints(stage, result, int(picked[-1]))
        stage.finish(result.name)
        label = draw.clock(result) if draw.rises(result) else "arc length of the path"
        stage.ax.figure.colorbar(ScalarMappable(norm, hues), ax=stage.ax, label=label, shrink=0.7, pad=0.1)
        return stage.ax

    def energy(self, ax: Axes | None = None, residual: bool = False) -> Axes:
        """Kinetic, stored and total energy, and what the ledger says the total should be when work is done.

        ``residual=True`` adds, on a second scale, what the ledger does not explain. In statics stored energy
        and the work done on the model.
        """
        result, energy, residual = self.result, self.result.energy, flag(residual, "residual")
        pen = draw.curves(result, ax)
        if result.kind == "static":
            order = draw.abscissa(result)
            pen.plot(order, energy.stored, color=draw.BLUE, lw=1.8, label="stored", **draw.dots(result))
            pen.plot(order, energy.work, color=draw.GREY, lw=1.6, ls="--", label="work done on it")
        else:
            draw.energies(pen, result)
            if np.any(energy.work) or np.any(energy.dissipated):
                due = energy.total[0] + energy.work - energy.dissipated
                pen.plot(result.t, due, color=draw.GREY, lw=1.4, ls=":", label="start + work - dissipated")
        if residual:
            draw.residual(pen.twinx(), energy.residual, result)
        return draw.finish(pen, "energy", result.name, below=ax is None)

    def momentum(self, ax: Axes | None = None) -> Axes:
        """Components of linear momentum (full lines) and of angular momentum about the origin (dashed).

        Raises ModelError for a static result, which has none.
        """
        result = self.result
        if result.kind == "static":
            raise ModelError("a static result has no momentum", "plot energy, or simulate the motion")
        pen = draw.curves(result, ax)
        draw.components(pen, result, result.momentum.linear, "L", "-")
        draw.components(pen, result, result.momentum.angular, "J", "--")
        return draw.finish(pen, "linear L, angular J", result.name, below=ax is None)

    def history(self, node: str | int, quantity: Quantity = "displacement", ax: Axes | None = None) -> Axes:
        """Components of one node's ``displacement``, position ``r``, velocity ``v`` or ``reaction`` in time.

        A reaction shows force (full lines) and moment (dashed). Raises ModelError for an unknown node or
        quantity.
        """
        result = self.result
        words = {"displacement": "u", "r": "", "v": "v", "reaction": "F"}
        choice(quantity, "history of", words)
        values: Array = getattr(result.node(node), quantity)
        pen = draw.curves(result, ax)
        draw.components(pen, result, values[:, :3], words[quantity], "-")
        if quantity == "reaction":
            draw.components(pen, result, values[:, 3:], "M", "--")
        name = {"r": "position", "v": "velocity"}.get(quantity, quantity)
        title = f"{result.name}: {result.mesh.label(result.mesh.node(node))}"
        return draw.finish(pen, name, title, below=ax is None)

    def path(self, node: str | int, component: Component, ax: Axes | None = None) -> Axes:
        """Load factor over one displacement of one node, with the limit points marked.

        Raises ModelError for an unknown node or component, and for a motion.
        """
        result = self.result
        if result.kind != "static":
            raise ModelError("a motion has no load factor to draw", "plot history, or follow a path with solve_static")
        choice(component, "component", COMPONENTS)
        moved = result.node(node).displacement[:, COMPONENTS.index(component)]
        pen = draw.curves(result, ax)
        pen.plot(moved, result.load_factor, color=draw.BLUE, lw=1.8, **draw.dots(result))
        for point in result.turning_points:
            at = float(moved[point.index]), point.load_factor
            pen.plot(*at, ls="", marker="o", ms=6, color=draw.ORANGE)
            pen.annotate(
                f"{point.load_factor:.6g}", at, (0, 7 if "maximum" in point.kind else -15), textcoords="offset points",
                color=draw.ORANGE, ha="center", fontsize=9,
            )  # fmt: skip
        label = draw.plain(result.mesh.label(result.mesh.node(node)))
        pen.set_xlabel(f"$u_{component}$ of {label}")
        pen.set_ylabel(draw.clock(result))
        pen.set_title(draw.plain(result.name), fontsize=11)
        pen.margins(y=0.12)
        return pen

    def branches(
        self, node: str | int, component: Component, others: Sequence[Result] = (), ax: Axes | None = None
    ) -> Axes:
        """Load factor over one displacement of one node, stable states full and unstable ones dashed.

        ``others`` are further paths of the same model, such as ``dx.branches`` returns. Bifurcations are round, limit
        points square. Raises ModelError for an unknown node or component, and for a result without stability.
        """
        choice(component, "component", COMPONENTS)
        every = (self.result, *others)
        for result in every:
            if result.stability is None:
                raise ModelError(
                    f"{result.name}: nobody looked at the stability of this result",
                    "follow the path with a control, or ask for stability=True",
                )
        pen = draw.curves(self.result, ax)
        for k, result in enumerate(every):
            colour = (draw.BLUE, draw.ORANGE, *OTHERS)[k % 5]
            draw.branch(pen, result, result.node(node).displacement[:, COMPONENTS.index(component)], colour)
        pen.plot([], [], color=draw.GREY, lw=1.8, label="stable")
        pen.plot([], [], color=draw.GREY, lw=1.4, ls=(0, (4, 3)), label="unstable")
        pen.legend(frameon=False, loc="best")
        label = draw.plain(self.result.mesh.label(self.result.mesh.node(node)))
        pen.set_xlabel(f"$u_{component}$ of {label}")
        pen.set_ylabel(draw.clock(self.result))
        pen.set_title(draw.plain(self.result.name), fontsize=11)
        pen.margins(y=0.08)
        return pen


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
