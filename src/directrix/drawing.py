"""What the pictures of ``plot`` are drawn with: axes in two or three dimensions, rod axes, curves in time."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.basis import lagrange
from directrix.checks import shown
from directrix.errors import ModelError
from directrix.quantities import labelled
from directrix.result import Result, RodMesh

Array = NDArray[np.float64]

INK, GREY, GHOST, BLUE, ORANGE = "#1b2733", "#7d8791", "#c3c9cf", "#1f6fb4", "#d2601a"
OTHERS = ("#a02c8c", "#b8860b", "#00808a")
XYZ = ("#c0392f", "#2b8a4b", "#2463ab")
PALETTE = (BLUE, ORANGE, *OTHERS, "#2b8a4b")
NAMES_AT_MOST = 40  # node names beyond this many only hide the picture


@dataclass(frozen=True)
class Stage:
    """An axes and which coordinates it shows: three, or the two of a planar result."""

    ax: Any  # here and below: matplotlib's types know neither the 3-D methods nor the style keywords
    shown: tuple[int, ...]

    def line(self, points: Array, **style: Any) -> None:
        """Draw (k, 3) points."""
        self.ax.plot(*(points[:, i] for i in self.shown), **style)

    def coloured(self, points: Array, colours: Array, lw: float) -> None:
        """Draw (k, 3) points with a colour (k − 1, 4) for every piece."""
        from matplotlib.collections import LineCollection

        pieces = np.stack([points[:-1], points[1:]], axis=1)[..., list(self.shown)]
        if len(self.shown) == 2:
            self.ax.add_collection(LineCollection(list(pieces), colors=list(colours), linewidths=lw, capstyle="round"))
            return
        from mpl_toolkits.mplot3d.art3d import Line3DCollection

        self.ax.add_collection(Line3DCollection(list(pieces), colors=list(colours), linewidths=lw, capstyle="round"))

    def finish(self, title: str, zoom: float = 0.95) -> None:
        """Names of the axes, and one scale for all of them."""
        letters = ["xyz"[i] for i in self.shown]
        for setter, name in zip((f"set_{a}label" for a in "xyz"), letters, strict=False):
            getattr(self.ax, setter)(name)
        self.ax.set_title(plain(title), fontsize=11)
        if len(self.shown) == 2:
            self.ax.set_aspect("equal", adjustable="datalim")
            return
        limits = np.array([self.ax.get_xlim(), self.ax.get_ylim(), self.ax.get_zlim()])
        span = limits[:, 1] - limits[:, 0]
        span = np.maximum(span, 0.3 * span.max())  # a flat box cannot be read in perspective
        middle = limits.mean(axis=1)
        for setter, m, w in zip((self.ax.set_xlim, self.ax.set_ylim, self.ax.set_zlim), middle, span, strict=True):
            setter(m - 0.5 * w, m + 0.5 * w)
        self.ax.set_box_aspect(span, zoom=zoom)


def stage(result: Result, ax: Any) -> Stage:
    """The axes to draw a shape in; refuses a flat axes for a motion in space."""
    flat = plane(result)
    if ax is None:
        return stage_in(pyplot().figure(figsize=(6.4, 5.8), layout="constrained"), result)
    if _axes(ax).name == "3d":
        return Stage(ax, (0, 1, 2))
    if flat is None:
        raise ModelError("the motion leaves every plane, the axes given is flat", 'give add_subplot(projection="3d")')
    return Stage(ax, flat)


def stage_in(figure: Any, result: Result) -> Stage:
    """A new axes of a figure, flat for a plane motion."""
    flat = plane(result)
    if flat is not None:
        ax = figure.add_subplot()
        dress(ax)
        return Stage(ax, flat)
    return space_in(figure)


def space_in(figure: Any) -> Stage:
    """A new axes of a figure in three dimensions."""
    from matplotlib import rc_context  # pyright: ignore[reportUnknownVariableType]
    from matplotlib.ticker import MaxNLocator

    with rc_context({"grid.color": "#d5dade", "grid.linewidth": 0.7}):
        ax = figure.add_subplot(projection="3d")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.pane.set_facecolor("white")
        axis.pane.set_edgecolor(GHOST)
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    return Stage(ax, (0, 1, 2))


def _axes(ax: Any) -> Any:
    need_matplotlib()
    from matplotlib.axes import Axes

    if not isinstance(ax, Axes):
        raise ModelError(
            f"ax = {shown(ax)} is not one axes of matplotlib", "give what add_subplot() returns, or leave it out"
        )
    return ax


def plane(result: Result) -> tuple[int, ...] | None:
    """The two coordinates of the plane that the model stays in, or None."""
    points = np.concatenate([result.mesh.r0[None], result.r]).reshape(-1, 3)
    span = np.ptp(points, axis=0)
    flat = [i for i in (2, 1, 0) if span[i] <= 1e-9 * max(float(span.max()), 1e-300)]
    return tuple(i for i in range(3) if i != flat[0]) if flat else None


def instant(result: Result, at: int) -> int:
    """The saved instant ``at``, counted from 0; raises ModelError when there is none."""
    count = len(result.t)
    if not isinstance(at, (int, np.integer)) or isinstance(at, bool) or not -count <= at < count:  # pyright: ignore
        raise ModelError(f"there is no saved instant {shown(at)}", f"instants are 0 … {count - 1}, or -1 for the last")
    return int(at) % count


def axis_line(rod: RodMesh, r: Array) -> Array:
    """The rod's axis (k, 3) through nodes ``r`` (n, 3) as its elements interpolate it."""
    cuts = 1 if rod.order == 1 else 8
    shape = lagrange(rod.order, np.linspace(-1.0, 1.0, cuts + 1)[:-1])[0]
    nodal = r[rod.nodes]
    local = np.arange(0, len(nodal) - 1, rod.order)[:, None] + np.arange(rod.order + 1)
    return np.concatenate([(shape @ nodal[local]).reshape(-1, 3), nodal[-1:]])


def ghost(stage: Stage, result: Result) -> None:
    for rod in result.mesh.rods:
        stage.line(axis_line(rod, result.mesh.r0), color=GHOST, lw=2.0, zorder=1)


def names(stage: Stage, result: Result, at: int) -> None:
    """Mark the named nodes and write their names beside them."""
    if len(result.mesh.node_names) > NAMES_AT_MOST:
        return
    near = 1e-6 * float(np.ptp(result.r[at], axis=0).max())
    labels: list[tuple[Array, list[str]]] = []  # nodes at one place, as those of a hinge, share a label
    for name, k in result.mesh.node_names.items():
        place = result.r[at, k]
        stage.line(place[None], ls="", marker="o", ms=5, color=INK)
        shared = next((label for other, label in labels if np.abs(other - place).max() <= near), None)
        if shared is None:
            labels.append((place, [name]))
        else:
            shared.append(name)
    for place, label in labels:
        spot, text = [float(place[i]) for i in stage.shown], plain(", ".join(label))
        stage.ax.text(*spot, f"  {text}", color=INK, fontsize=10, fontweight="bold", va="bottom")


def arms(stage: Stage, result: Result, at: int, **style: Any) -> None:
    """Thin lines from nodes to the joints they hold away from themselves: rigid arms of bodies."""
    for points in result.joint_ends(at).reshape(-1, 2, 3):
        if np.any(points[0] != points[1]):
            stage.line(points, lw=1.0, **style)


def joints(stage: Stage, result: Result, at: int) -> None:
    """Small open circles where joints are, on what they move, and dots for nodes on no rod."""
    loose = result.r[at, result.mesh.loose]
    if len(loose):
        stage.line(loose, ls="", marker="o", ms=5, color=INK)
    places = result.joint_ends(at)[:, 1, 1]
    if len(places):
        stage.line(places, ls="", marker="o", ms=5.5, mfc="white", mec=INK, mew=1.2, zorder=5)


def energies(pen: Any, result: Result, total: str = "total") -> None:
    t, energy = abscissa(result), result.energy
    pen.plot(t, energy.kinetic, color=ORANGE, lw=1.3, ls="--", label="kinetic")
    pen.plot(t, energy.stored, color=BLUE, lw=1.3, ls="-.", label="stored")
    pen.plot(t, energy.total, color=INK, lw=2.2, label=total, **dots(result))


def components(pen: Any, result: Result, values: Array, letter: str, style: str) -> None:
    """Three curves; ``values`` (nt, 3)."""
    for axis, colour, column in zip("xyz", XYZ, values.T, strict=True):
        name = f"${letter}_{axis}$" if letter else axis
        pen.plot(abscissa(result), column, color=colour, lw=1.7, ls=style, label=name, **dots(result))


def residual(twin: Any, residual: Array, result: Result) -> None:
    twin.plot(abscissa(result), residual, color=XYZ[0], lw=1.0, label="residual")
    twin.set_ylabel("residual of the ledger", color=XYZ[0])
    twin.tick_params(axis="y", colors=XYZ[0])
    twin.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))


def curves(result: Result, ax: Any) -> Any:
    if ax is None:
        ax = pyplot().figure(figsize=(7.0, 4.2), layout="constrained").add_subplot()
        dress(ax)
    elif _axes(ax).name == "3d":
        raise ModelError("the axes given is in space, the curves are flat", "give add_subplot()")
    ax.set_xlabel(over(result))
    return ax


def over(result: Result) -> str:
    """What :func:`abscissa` is, with its unit."""
    if not rises(result):
        return labelled(result, "arc length of the path", "length")
    return labelled(result, "t", "time") if result.kind == "dynamic" else "load factor"


def branch(pen: Any, result: Result, values: Array, colour: str) -> None:
    """Load factor over ``values`` (nt,): full where stable, dashed where not, critical points marked."""
    of = result.stability
    if of is None:
        return
    sure = of.stable | of.critical  # a critical point ends a piece of either kind
    good = sure[:-1] & sure[1:] & (of.stable[:-1] | of.stable[1:])
    ends = np.flatnonzero(np.diff(good)) + 1
    for first, last in zip((0, *ends), (*ends, len(good)), strict=True):
        style: dict[str, Any] = {"lw": 1.8} if len(good) and good[first] else {"lw": 1.4, "ls": (0, (4, 3))}
        pen.plot(values[first : last + 1], result.load_factor[first : last + 1], color=colour, **style)
    for point in of.points:
        mark = "o" if point.bifurcation else "s"
        pen.plot(values[point.index], point.load_factor, ls="", marker=mark, ms=5, mfc="white", color=colour)


def finish(pen: Any, quantity: str, title: str, below: bool) -> Any:
    """Label, title and legend: below the axes where the layout is ours, else where it covers least."""
    pen.set_ylabel(quantity)
    pen.set_title(plain(title), fontsize=11)
    place: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14)} if below else {"loc": "best"}
    entries = len(pen.get_legend_handles_labels()[1])
    pen.legend(frameon=False, fontsize=9, ncols=3 if entries > 4 else entries if entries < 4 else 2, **place)
    return pen


def dress(pen: Any) -> None:
    pen.spines[["top", "right"]].set_visible(False)
    pen.grid(color="#e8ebee", lw=0.7)
    pen.set_axisbelow(True)


def plain(text: str) -> str:
    """A user's text as it is: matplotlib would read dollars as mathematics."""
    return text.replace("$", r"\$")


def dots(result: Result) -> dict[str, Any]:
    """Few instants are shown as what they are: points."""
    return {"marker": "o", "ms": 3.0} if len(result.t) <= 25 else {}


def evenly(count: int, of: int) -> NDArray[np.int64]:
    """At most ``count`` of the indices 0 … of - 1, evenly spread, first and last among them."""
    return np.unique(np.rint(np.linspace(0.0, of - 1.0, min(count, of))).astype(np.int64))


def clock(result: Result) -> str:
    return "t" if result.kind == "dynamic" else "load factor"


def rises(result: Result) -> bool:
    """False when the load factor turns back, so that it does not tell one saved instant from another."""
    return bool(np.all(np.diff(result.t) > 0.0))


def abscissa(result: Result) -> Array:
    """What the saved instants (nt,) are drawn over: time, load factor, or the arc length of a path that turns back."""
    return result.t if rises(result) else result.arc_length


def need_matplotlib() -> None:
    try:
        import_module("matplotlib")
    except ModuleNotFoundError:
        raise ModelError("pictures need matplotlib, which is not installed", 'pip install "directrix[plot]"') from None


def pyplot() -> Any:
    need_matplotlib()
    return import_module("matplotlib.pyplot")
