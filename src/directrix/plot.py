"""Pictures of a result with matplotlib: ``ax=`` in, the axes out. Lengths and times carry the model's units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix.basis import lagrange
from directrix.errors import ModelError
from directrix.result import Result, RodMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

__all__ = ["Plots", "compare_energy_momentum"]

INK, GREY, GHOST, BLUE, ORANGE = "#1b2733", "#7d8791", "#c3c9cf", "#1f6fb4", "#d2601a"
XYZ = ("#c0392f", "#2b8a4b", "#2463ab")
FAILING = ("#c0392f", "#8a3fa0", "#b8860b")
NAMES_AT_MOST = 40  # node names beyond this many only hide the picture
Quantity = Literal["displacement", "r", "v", "reaction"]


@dataclass(frozen=True)
class Plots:
    """The pictures of one result. Every method draws into ``ax`` or makes a figure, and returns the axes.

    Shapes lie in a 3-D axes (``projection="3d"``); a result that stays in a coordinate plane is drawn in
    that plane unless a 3-D axes is given. Each method raises ModelError when matplotlib is missing.
    """

    result: Result

    def shape(self, at: int = -1, ax: Axes | None = None) -> Axes:
        """Deformed axis at saved instant ``at`` (negative counts from the end) over the undeformed one.

        Raises ModelError when there is no such instant.
        """
        result = self.result
        count = len(result.t)
        if not -count <= at < count:
            raise ModelError(f"there is no saved instant {at}", f"instants are 0 … {count - 1}, or −1 for the last")
        stage = _stage(result, ax)
        _ghost(stage, result)
        for rod in result.mesh.rods:
            stage.line(_axis(rod, result.r[at]), color=BLUE, lw=2.2, solid_capstyle="round")
            stage.line(result.r[at, rod.nodes], ls="", marker="o", ms=2.5, color=INK)
        _names(stage, result, at)
        stage.finish(f"{result.name}, {_clock(result)} = {result.t[at]:.4g}")
        return stage.ax

    def motion(self, frames: int = 12, ax: Axes | None = None) -> Axes:
        """``frames`` deformed shapes spread evenly over the saved instants, coloured by time.

        Raises ModelError when ``frames`` is not a positive whole number.
        """
        result = self.result
        if frames < 1 or frames != int(frames):
            raise ModelError(f"frames = {frames} is not a positive whole number", "ask for 1, 2, … shapes")
        stage = _stage(result, ax)
        from matplotlib import colormaps, colors
        from matplotlib.cm import ScalarMappable

        # viridis without its pale end, which vanishes on white paper
        hues: Any = colors.ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
        last = len(result.t) - 1
        picked = np.unique(np.linspace(0, last, min(frames, last + 1)).round().astype(int))
        lo, hi = float(result.t.min()), float(result.t.max())
        norm: Any = colors.Normalize(lo, hi if hi > lo else lo + 1.0)
        _ghost(stage, result)
        for k in picked:
            for rod in result.mesh.rods:
                stage.line(_axis(rod, result.r[k]), color=hues(norm(result.t[k])), lw=1.8)
        _names(stage, result, int(picked[-1]))
        stage.finish(result.name)
        stage.ax.figure.colorbar(
            ScalarMappable(norm, hues), ax=stage.ax, label=_clock(result), shrink=0.7, pad=0.1
        )
        return stage.ax

    def energy(self, ax: Axes | None = None, residual: bool = False) -> Axes:
        """Kinetic, stored and total energy, and what the ledger says the total should be when work is done.

        ``residual=True`` adds, on a second scale, what the ledger does not explain. In statics stored energy
        and the work done on the model.
        """
        result, energy = self.result, self.result.energy
        pen = _curves(result, ax)
        if result.kind == "static":
            pen.plot(result.t, energy.stored, color=BLUE, lw=1.8, label="stored", **_dots(result))
            pen.plot(result.t, energy.work, color=GREY, lw=1.6, ls="--", label="work done on it")
        else:
            _energies(pen, result)
            if np.any(energy.work) or np.any(energy.dissipated):
                due = energy.total[0] + energy.work - energy.dissipated
                pen.plot(result.t, due, color=GREY, lw=1.4, ls=":", label="start + work − dissipated")
        if residual:
            _label(pen.twinx(), energy.residual, result)
        return _labelled(pen, "energy", result.name, extra=residual)

    def momentum(self, ax: Axes | None = None) -> Axes:
        """Components of linear momentum (full lines) and of angular momentum about the origin (dashed).

        Raises ModelError for a static result, which has none.
        """
        result = self.result
        if result.kind == "static":
            raise ModelError("a static result has no momentum", "plot energy, or simulate the motion")
        pen = _curves(result, ax)
        _components(pen, result, result.momentum.linear, "L", "-")
        _components(pen, result, result.momentum.angular, "J", "--")
        return _labelled(pen, "linear L, angular J", result.name)

    def history(self, node: str | int, quantity: Quantity = "displacement", ax: Axes | None = None) -> Axes:
        """Components of one node's ``displacement``, position ``r``, velocity ``v`` or ``reaction`` in time.

        A reaction shows force (full lines) and moment (dashed). Raises ModelError for an unknown node or
        quantity.
        """
        result = self.result
        words = {"displacement": "u", "r": "", "v": "v", "reaction": "F"}
        if quantity not in words:
            raise ModelError(f"there is no history of {quantity!r}", f"quantities: {', '.join(words)}")
        values: Array = getattr(result.node(node), quantity)
        pen = _curves(result, ax)
        _components(pen, result, values[:, :3], words[quantity], "-")
        if quantity == "reaction":
            _components(pen, result, values[:, 3:], "M", "--")
        name = {"r": "position", "v": "velocity"}.get(quantity, quantity)
        return _labelled(pen, name, f"{result.name}: {result.mesh.label(result.mesh.node(node))}")


def compare_energy_momentum(
    results: Mapping[str, Result], path: str | PathLike[str], snapshots: int = 7
) -> str:
    """Write one picture (PNG, PDF or SVG by its ending): momenta, total energy and snapshots; returns its path.

    ``results`` maps a label to a dynamic result. The first is the conserving one: it gives the energy's
    scale, its kinetic and stored parts, and the snapshots. A run that did not reach its end is marked with
    × and the time. After Figures 7-9 of Romero and Armero, IJNME 54 (2002) 1683-1716.
    Raises ModelError when there is nothing to compare, for a static result, and when the folder is missing.
    """
    if not results:
        raise ModelError("there is no result to compare", "give at least one, such as {'energy-momentum': result}")
    for label, result in results.items():
        if result.kind == "static":
            raise ModelError("a static result has no momentum", "give results of simulate", f"results[{label!r}]")
    if not Path(path).resolve().parent.is_dir():
        raise ModelError(f"the folder of {fspath(path)} does not exist", "make it first, or choose another path")
    _matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(12.0, 6.2), layout="constrained")
    FigureCanvasAgg(figure)
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.45, 1.0))
    panels = upper.subplots(1, 3)
    (first_label, first), *others = results.items()
    for pen, history, letter, title in (
        (panels[0], "linear", "L", "linear momentum"),
        (panels[1], "angular", "J", "angular momentum"),
    ):
        _components(pen, first, getattr(first.momentum, history), letter, "-")
        for k, (_, result) in enumerate(others):
            values = getattr(result.momentum, history)
            pen.plot(result.t, values, color=FAILING[k % 3], lw=1.0, ls=(0, (4, 3)))
            if not result.success:
                pen.plot(np.full(3, result.t[-1]), values[-1], ls="", marker="x", ms=7, mew=2, color=FAILING[k % 3])
        _labelled(pen, title, title)
    _total_energies(panels[2], first_label, first, others)
    for pen in panels:
        _dress(pen)
    _snapshots(lower, first_label, first, snapshots)
    figure.savefig(fspath(path), dpi=160)
    return fspath(path)


def _total_energies(pen: Any, label: str, first: Result, others: list[tuple[str, Result]]) -> None:
    _energies(pen, first, f"total, {label}")
    peak = max([float(first.energy.total.max())] + [float(r.energy.total.max()) for _, r in others])
    # a run that blew up by orders of magnitude must not flatten the conserving curve
    top = min(peak, 4.0 * float(first.energy.total.max())) * 1.12 or 1.0
    for k, (name, result) in enumerate(others):
        colour, total = FAILING[k % 3], result.energy.total
        pen.plot(result.t, total, color=colour, lw=1.6, ls="-.", label=f"total, {name}")
        if not result.success:
            end, height = float(result.t[-1]), min(float(total[-1]), 0.96 * top)
            pen.plot([end], [height], ls="", marker="x", ms=10, mew=2.6, color=colour)
            left = end > 0.5 * float(first.t[-1])
            text = f"stops at {_clock(result)} = {end:.4g}" + (f"\n(energy {total[-1]:.3g})" if total[-1] > top else "")
            pen.annotate(
                text, (end, height), (-9 if left else 9, 0), textcoords="offset points", color=colour,
                ha="right" if left else "left", va="center", fontsize=9,
            )  # fmt: skip
    _labelled(pen, "energy", "energy")
    pen.set_ylim(0.0, top)


def _snapshots(figure: Any, label: str, result: Result, count: int) -> None:
    """Shapes side by side at one scale, each about its own centre, since a free body wanders off."""
    picked = np.unique(np.linspace(0, len(result.t) - 1, count).round().astype(int))
    centres = result.r[picked].mean(axis=1)
    reach = float(np.abs(result.r[picked] - centres[:, None]).max()) or 1.0
    figure.suptitle(f"snapshots of the motion, {label}", fontsize=10, color=INK)
    axes = figure.subplots(1, len(picked), subplot_kw={"projection": "3d"}, squeeze=False)[0]
    for pen, k, centre in zip(axes, picked, centres, strict=True):
        stage = _Stage(pen, (0, 1, 2))
        for rod, colour in zip(result.mesh.rods, (BLUE, INK, ORANGE) * len(result.mesh.rods), strict=False):
            stage.line(_axis(rod, result.r[k]), color=colour, lw=2.4, solid_capstyle="round")
        for limits, middle in zip((pen.set_xlim, pen.set_ylim, pen.set_zlim), centre, strict=True):
            limits(middle - reach, middle + reach)
        pen.set_box_aspect((1, 1, 1), zoom=1.45)
        pen.set_axis_off()
        pen.set_title(f"{_clock(result)} = {result.t[k]:.4g}", fontsize=9, y=-0.06, color=INK)


@dataclass(frozen=True)
class _Stage:
    """An axes and which coordinates it shows: three, or the two of a planar result."""

    ax: Any  # matplotlib's own types know neither the 3-D methods nor the style keywords
    shown: tuple[int, ...]

    def line(self, points: Array, **style: Any) -> None:
        """Draw (k, 3) points."""
        self.ax.plot(*(points[:, i] for i in self.shown), **style)

    def finish(self, title: str) -> None:
        """Names of the axes, and one scale for all of them."""
        names = ["xyz"[i] for i in self.shown]
        for setter, name in zip((f"set_{a}label" for a in "xyz"), names, strict=False):
            getattr(self.ax, setter)(name)
        self.ax.set_title(title, fontsize=11)
        if len(self.shown) == 2:
            self.ax.set_aspect("equal", adjustable="datalim")
            return
        limits = np.array([self.ax.get_xlim(), self.ax.get_ylim(), self.ax.get_zlim()])
        span = limits[:, 1] - limits[:, 0]
        span = np.maximum(span, 0.3 * span.max())  # a flat box cannot be read in perspective
        middle = limits.mean(axis=1)
        for setter, m, w in zip((self.ax.set_xlim, self.ax.set_ylim, self.ax.set_zlim), middle, span, strict=True):
            setter(m - 0.5 * w, m + 0.5 * w)
        self.ax.set_box_aspect(span, zoom=0.9)


def _stage(result: Result, ax: Any) -> _Stage:
    """The axes to draw a shape in; refuses a flat axes for a motion in space."""
    plane = _plane(result)
    if ax is None:
        figure: Any = _pyplot().figure(figsize=(7.0, 5.6), layout="constrained")
        if plane is not None:
            ax = figure.add_subplot()
            _dress(ax)
        else:
            ax = figure.add_subplot(projection="3d")
            for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
                axis.pane.set_facecolor("white")
                axis.pane.set_edgecolor(GHOST)
                axis._axinfo["grid"].update(color="#e3e7ea", linewidth=0.7)
        return _Stage(ax, plane or (0, 1, 2))
    if ax.name == "3d":
        return _Stage(ax, (0, 1, 2))
    if plane is None:
        raise ModelError("the motion leaves every plane, the axes given is flat", 'give add_subplot(projection="3d")')
    return _Stage(ax, plane)


def _plane(result: Result) -> tuple[int, ...] | None:
    """The two coordinates of the plane that the model stays in, or None."""
    points = np.concatenate([result.mesh.r0[None], result.r]).reshape(-1, 3)
    span = np.ptp(points, axis=0)
    flat = [i for i in (2, 1, 0) if span[i] <= 1e-9 * max(float(span.max()), 1e-300)]
    return tuple(i for i in range(3) if i != flat[0]) if flat else None


def _axis(rod: RodMesh, r: Array) -> Array:
    """The rod's axis (k, 3) through nodes ``r`` (n, 3) as its elements interpolate it."""
    cuts = 1 if rod.order == 1 else 8
    shape = lagrange(rod.order, np.linspace(-1.0, 1.0, cuts + 1)[:-1])[0]
    nodal = r[rod.nodes]
    local = np.arange(0, len(nodal) - 1, rod.order)[:, None] + np.arange(rod.order + 1)
    return np.concatenate([(shape @ nodal[local]).reshape(-1, 3), nodal[-1:]])


def _ghost(stage: _Stage, result: Result) -> None:
    for rod in result.mesh.rods:
        stage.line(_axis(rod, result.mesh.r0), color=GHOST, lw=2.0, zorder=1)


def _names(stage: _Stage, result: Result, at: int) -> None:
    """Mark the named nodes and write their names beside them."""
    if len(result.mesh.node_names) > NAMES_AT_MOST:
        return
    for name, k in result.mesh.node_names.items():
        stage.line(result.r[at, k : k + 1], ls="", marker="o", ms=5, color=INK)
        place = [float(result.r[at, k, i]) for i in stage.shown]
        stage.ax.text(*place, f"  {name}", color=INK, fontsize=10, fontweight="bold", va="bottom", parse_math=False)


def _energies(pen: Any, result: Result, total: str = "total") -> None:
    t, energy = result.t, result.energy
    pen.plot(t, energy.kinetic, color=ORANGE, lw=1.3, ls="--", label="kinetic")
    pen.plot(t, energy.stored, color=BLUE, lw=1.3, ls="-.", label="stored")
    pen.plot(t, energy.total, color=INK, lw=2.2, label=total, **_dots(result))


def _components(pen: Any, result: Result, values: Array, letter: str, style: str) -> None:
    """Three curves; ``values`` (nt, 3)."""
    for axis, colour, column in zip("xyz", XYZ, values.T, strict=True):
        name = f"${letter}_{axis}$" if letter else axis
        pen.plot(result.t, column, color=colour, lw=1.7, ls=style, label=name, **_dots(result))


def _label(twin: Any, residual: Array, result: Result) -> None:
    twin.plot(result.t, residual, color=XYZ[0], lw=1.0, label="residual")
    twin.set_ylabel("residual of the ledger", color=XYZ[0])
    twin.tick_params(axis="y", colors=XYZ[0])
    twin.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))


def _curves(result: Result, ax: Any) -> Any:
    if ax is None:
        ax = _pyplot().figure(figsize=(7.0, 4.2), layout="constrained").add_subplot()
        _dress(ax)
    ax.set_xlabel(_clock(result))
    return ax


def _labelled(pen: Any, quantity: str, title: str, extra: bool = False) -> Axes:
    pen.set_ylabel(quantity)
    pen.set_title(title, fontsize=11)
    pen.legend(frameon=False, fontsize=9, ncols=2)
    return pen


def _dress(pen: Any) -> None:
    pen.spines[["top", "right"]].set_visible(False)
    pen.grid(color="#e8ebee", lw=0.7)
    pen.set_axisbelow(True)


def _dots(result: Result) -> dict[str, Any]:
    """Few instants are shown as what they are: points."""
    return {"marker": "o", "ms": 3.0} if len(result.t) <= 25 else {}


def _clock(result: Result) -> str:
    return "t" if result.kind == "dynamic" else "load factor"


def _matplotlib() -> None:
    try:
        import matplotlib as _  # noqa: F401
    except ModuleNotFoundError:
        raise ModelError("pictures need matplotlib, which is not installed", 'pip install "directrix[plot]"') from None


def _pyplot() -> Any:
    _matplotlib()
    from matplotlib import pyplot

    return pyplot
