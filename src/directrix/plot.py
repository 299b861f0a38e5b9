"""Pictures of a result with matplotlib: ``ax=`` in, the axes out. All numbers carry the model's units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix import drawing as draw
from directrix.checks import choice, flag, whole
from directrix.errors import ModelError
from directrix.pictures import convergence, curves, ledger, sections
from directrix.pictures.curves import Others
from directrix.quantities import FORCES, Of, labelled, unit
from directrix.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

__all__ = ["Plots"]

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
        at = draw.instant(result, at)
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
        return draw.finish(pen, labelled(result, "energy", "force·length"), result.name, below=ax is None)

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
        units = [unit(result, f"force·{x}time") for x in ("", "length·")]
        return draw.finish(pen, f"linear L [{units[0]}], angular J [{units[1]}]", result.name, below=ax is None)

    def history(
        self, of: Of = None, quantity: str = "displacement", component: str | None = None, others: Others = (),
        ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """A quantity in time; its components, or one ``component`` of it.

        ``of`` is a node by name or index, a point of a rod as (rod, arclength), the name of a link, contact or joint,
        or nothing for energies and momenta. ``quantity`` has the name that it has in ``result.to_pandas``, without the
        component; "N", "M1" and the like are components by themselves. ``others`` are results to draw beside, by label
        or one after the other. Raises ModelError for what there is not.
        """
        return curves.history(self.result, of, quantity, component, others, ax)

    def orbit(
        self, of: Of, x: str | tuple[str, str] = ("r", "x"), y: str | tuple[str, str] = ("r", "y"),
        others: Others = (), ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """One quantity over another, as ("r", "x") and ("r", "y") for an orbit; the start is open, the end full.

        ("displacement", "x") over ("v", "x") is a phase plot. Quantities and ``of`` as in :meth:`history`; what the
        whole run has goes with any. Raises ModelError for what there is not, and for more than one component.
        """
        return curves.orbit(self.result, of, x, y, others, ax)

    def section_forces(
        self, rods: Sequence[str] | str | None = None, components: Sequence[str] | str = FORCES, at: int = -1,
        envelope: bool = False, others: Others = (), ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """Section forces or strains along the arclength at one instant: N, V1, V2, M1, M2, T.

        Moments are dashed and have a scale of their own. Several rods (all, unless named) follow one another.
        ``envelope=True`` fills what every component goes through in the run. An element draws the polynomial through
        its stress points. Raises ModelError for an unknown rod, component or instant.
        """
        return sections.along(self.result, rods, components, at, envelope, others, ax)

    def diagram(self, component: str = "M1", at: int = -1, scale: float | None = None, ax: Axes | None = None) -> Axes:
        """One component of the section forces (or strains) on the deformed axis, ordinates along a director.

        V2 and M1 go along d2, others along d1; in a plane picture along the one in the plane. ``scale`` is length per
        force, such that the largest has 15 % of the model's size unless given. Raises ModelError as above.
        """
        return sections.diagram(self.result, component, at, scale, ax)

    def ledger(self, ax: Axes | None = None) -> Axes:
        """The energy by its sources: below what came in and from where, above what became of it.

        Both sides are equal but for the residual, whose largest value the legend says.
        """
        return ledger.ledger(self.result, ax)

    def newton(self, others: Others = (), ax: Axes | None = None) -> Axes:
        """Newton iterations of every step taken."""
        return convergence.newton(self.result, others, ax)

    def convergence(
        self, of: Literal["force", "moment", "displacement", "turn"] | None = None, tries: int = 8,
        ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """How the iterations of the last ``tries`` went, failed ones too: the largest "turn" or "displacement" that
        each asked for, or the largest unbalanced "moment" or "force" before it; the first of them that is known.

        After a large turn the positions are solved for by themselves: forces jump there, and nothing turns.

        Raises ModelError when nothing of that is known.
        """
        return convergence.convergence(self.result, of, tries, ax)

    def refinement(
        self, others: Sequence[Result], of: Of = None, quantity: str | Callable[[Result], Any] = "displacement",
        component: str | None = None, exact: float | None = None, by: Literal["elements", "dt"] | None = None,
        ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """Error at the last instant over the number of elements or the time step, both logarithmic, and its order.

        The error is the distance from ``exact``, or from the finest of the results. ``quantity`` as in :meth:`history`,
        or a function of a result. Raises ModelError for results that show no convergence.
        """
        return convergence.refinement((self.result, *others), of, quantity, component, exact, by, ax)

    def path(self, node: str | int, component: Component, others: Others = (), ax: Axes | None = None) -> Axes:
        """Load factor over one displacement of one node, with the limit points marked; ``others`` drawn beside.

        Raises ModelError for an unknown node or component, and for a motion.
        """
        result, runs = self.result, list(curves.several(self.result, others))
        if any(one.kind != "static" for _, one in runs):
            raise ModelError("a motion has no load factor to draw", "plot history, or follow a path with solve_static")
        choice(component, "component", COMPONENTS)
        k = COMPONENTS.index(component)
        moves = [one.node(node).displacement[:, k] for _, one in runs]
        pen = draw.curves(result, ax)
        for number, ((label, one), moved) in enumerate(zip(runs, moves, strict=True)):
            style: dict[str, Any] = {"color": draw.PALETTE[number % len(draw.PALETTE)], "lw": 1.8, **draw.dots(one)}
            pen.plot(moved, one.load_factor, label=draw.plain(label) or None, **style)
        if len(runs) > 1:
            pen.legend(frameon=False, fontsize=9)
        for point in result.turning_points:
            at = float(moves[0][point.index]), point.load_factor
            pen.plot(*at, ls="", marker="o", ms=6, color=draw.ORANGE)
            pen.annotate(
                f"{point.load_factor:.6g}", at, (0, 7 if "maximum" in point.kind else -15), textcoords="offset points",
                color=draw.ORANGE, ha="center", fontsize=9,
            )  # fmt: skip
        label = draw.plain(result.mesh.label(result.mesh.node(node)))
        pen.set_xlabel(labelled(result, f"$u_{component}$ of {label}", "length"))
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
            colour = draw.PALETTE[k % len(draw.PALETTE)]
            draw.branch(pen, result, result.node(node).displacement[:, COMPONENTS.index(component)], colour)
        pen.plot([], [], color=draw.GREY, lw=1.8, label="stable")
        pen.plot([], [], color=draw.GREY, lw=1.4, ls=(0, (4, 3)), label="unstable")
        pen.legend(frameon=False, loc="best")
        label = draw.plain(self.result.mesh.label(self.result.mesh.node(node)))
        pen.set_xlabel(labelled(self.result, f"$u_{component}$ of {label}", "length"))
        pen.set_ylabel(draw.clock(self.result))
        pen.set_title(draw.plain(self.result.name), fontsize=11)
        pen.margins(y=0.08)
        return pen
