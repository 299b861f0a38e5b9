"""Section forces and strains: along the arclength, and on the deformed axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix import drawing as draw
from directrix.basis import lagrange
from directrix.checks import choice, flag, number, shown
from directrix.errors import ModelError
from directrix.pictures.curves import STYLES, Others, several
from directrix.quantities import FORCES, QUANTITIES, STRAINS, labelled
from directrix.result import Result, RodMesh

Array = NDArray[np.float64]

__all__ = ["along", "diagram"]

COLOURS: Mapping[str, str] = dict(zip((*FORCES, *STRAINS), (*draw.XYZ, *draw.XYZ, *draw.XYZ, *draw.XYZ), strict=True))
SIGNS: Mapping[str, str] = {
    **{name: f"${name[0]}_{name[1]}$" if len(name) > 1 else f"${name}$" for name in FORCES},
    **{name: rf"$\{name[:-1]}_{name[-1]}$" for name in STRAINS},
}
REACH = 0.15  # of the model's size: the largest ordinate on the deformed axis


def along(
    result: Result, rods: Sequence[str] | str | None, components: Sequence[str] | str, at: int, envelope: bool,
    others: Others, ax: Any,
) -> Any:  # fmt: skip
    """See :meth:`directrix.plot.Plots.section_forces`."""
    wanted = _components(components)
    dimensions = list(dict.fromkeys(_dimension(c) for c in wanted))
    if len(dimensions) > 2:
        raise ModelError("these components have more than two units", "draw strains and forces apart")
    runs = list(several(result, others))
    flag(envelope, "envelope")
    pen = draw.curves(result, ax)
    pens = {dimensions[0]: pen}
    if len(dimensions) > 1:
        pens[dimensions[1]] = pen.twinx()
    for number_of, (label, one) in enumerate(runs):
        instant, start = draw.instant(one, at), 0.0
        for rod in _rods(one, rods):
            for name in wanted:
                s, now, low, high = _values(one, rod, name, instant)
                axes, colour = pens[_dimension(name)], COLOURS[name]
                style = STYLES[number_of % len(STYLES)] if _dimension(name) == dimensions[0] else "--"
                said = None if start else f"{draw.plain(label)}, {SIGNS[name]}" if label else SIGNS[name]
                if envelope:
                    axes.fill_between(start + s, low, high, color=colour, alpha=0.16, lw=0)
                width = 1.8 if len(runs) == 1 else 1.3 + 0.5 * (number_of == 0)
                axes.plot(start + s, now, color=colour, lw=width, ls=style, label=said)
            start += float(rod.s[-1])
    listed, start = _rods(result, rods), 0.0
    if len(listed) > 1:
        for rod in listed:
            pen.text(start + 0.5 * rod.s[-1], 1.0, draw.plain(rod.name), transform=pen.get_xaxis_transform(),
                     ha="center", va="bottom", fontsize=8, color=draw.GREY)  # fmt: skip
            start += float(rod.s[-1])
            pen.axvline(start, color=draw.GHOST, lw=0.8)
    pen.axhline(0.0, color=draw.GREY, lw=0.8)
    title = f"{result.name}, {draw.clock(result)} = {result.t[draw.instant(result, at)]:.4g}"
    title += ", and the range over the run" if envelope else ""
    if len(dimensions) > 1:  # the zeros of both scales at one height
        for one in pens.values():
            low, high = one.get_ylim()
            reach = max(-low, high)
            one.set_ylim(-reach, reach)
        twin = pens[dimensions[1]]
        twin.set_ylabel(labelled(result, _words(dimensions[1]) + " (dashed)", dimensions[1]))
        twin.spines[["top"]].set_visible(False)
        for line in twin.lines:  # one legend for both
            if not str(line.get_label()).startswith("_"):
                pen.plot([], [], color=line.get_color(), lw=1.8, ls="--", label=line.get_label())
    draw.finish(pen, labelled(result, _words(dimensions[0]), dimensions[0]), "", below=ax is None)
    pen.set_title(draw.plain(title), fontsize=11, pad=16 if len(listed) > 1 else 6)
    pen.set_xlabel(labelled(result, "s", "length"))
    return pen


def diagram(result: Result, component: str, at: int, scale: float | None, ax: Any) -> Any:
    """See :meth:`directrix.plot.Plots.diagram`."""
    (name,) = _components((component,))
    instant = draw.instant(result, at)
    stage = draw.stage(result, ax)
    size = float(np.linalg.norm(np.ptp(np.append(result.r[instant], result.mesh.r0, axis=0), axis=0))) or 1.0
    drawn = [(rod, *_values(result, rod, name, instant)[:2]) for rod in result.mesh.rods]
    if not drawn:
        raise ModelError("there is no rod to draw", "draw a history of a joint or a link")
    largest = max(float(np.abs(now).max()) for _, _, now in drawn)
    usual = REACH * size / largest if largest else 0.0
    scale = usual if scale is None else number(scale, "scale")
    peak: tuple[float, Array] = (0.0, result.r[instant, 0])
    for rod, s, now in drawn:
        stage.line(draw.axis_line(rod, result.r[instant]), color=draw.INK, lw=2.0, solid_capstyle="round")
        places, sideways = _sideways(result, rod, name, instant, s, stage.shown)
        tips = places + scale * now[:, None] * sideways
        for foot, tip in zip(places, tips, strict=True):
            stage.line(np.stack([foot, tip]), color=COLOURS[name], lw=0.6, alpha=0.6)
        stage.line(np.concatenate([places[:1], tips, places[-1:]]), color=COLOURS[name], lw=1.6)
        k = int(np.abs(now).argmax())
        if abs(now[k]) > abs(peak[0]):
            peak = float(now[k]), tips[k]
    draw.names(stage, result, instant)
    if peak[0]:
        spot = [float(peak[1][i]) for i in stage.shown]
        stage.ax.text(*spot, f" {peak[0]:.4g}", color=COLOURS[name], fontsize=9, va="center")
    what = labelled(result, SIGNS[name], _dimension(name))
    stage.finish("")
    stage.ax.set_title(
        f"{what}: {draw.plain(result.name)}, {draw.clock(result)} = {result.t[instant]:.4g}", fontsize=11
    )
    return stage.ax


def _components(given: Any) -> tuple[str, ...]:
    names = (given,) if isinstance(given, str) else given
    if not isinstance(names, Sequence) or not names:
        raise ModelError(f"components = {shown(given)} names nothing", f"name some of {', '.join(FORCES)}")
    return tuple(choice(name, "component of a section", (*FORCES, *STRAINS)) for name in names)  # pyright: ignore


def _rods(result: Result, rods: Sequence[str] | str | None) -> list[RodMesh]:
    if rods is None:
        found = list(result.mesh.rods)
    else:
        found = [result.mesh.rod(name) for name in ((rods,) if isinstance(rods, str) else rods)]
    if not found:
        raise ModelError("there is no rod to draw", "draw a history of a joint or a link")
    return found


def _kind(name: str) -> tuple[str, int]:
    return ("force", FORCES.index(name)) if name in FORCES else ("strain", STRAINS.index(name))


def _dimension(name: str) -> str:
    kind, k = _kind(name)
    return QUANTITIES[kind].dimension(k)


def _words(dimension: str) -> str:
    return {"force": "section force", "force·length": "section moment", "": "strain"}.get(dimension, "curvature, twist")


def _values(result: Result, rod: RodMesh, name: str, at: int) -> tuple[Array, Array, Array, Array]:
    """Arclengths, values at the instant, least and largest over the run: at the ends of every element and between.

    An element draws the polynomial through its stress points; where neighbours differ, the curve jumps.
    """
    kind, k = _kind(name)
    values = getattr(result, kind)[:, rod.first_station : rod.first_station + len(rod.stations), k]
    ends = rod.s[:: rod.order]
    elements = len(ends) - 1
    many = len(rod.stations) // elements
    places = np.linspace(-1.0, 1.0, 2 if many <= 2 else 7)
    s = ends[:-1, None] + 0.5 * (places + 1.0) * np.diff(ends)[:, None]
    own = rod.stations.reshape(elements, many)
    weights = np.ones((elements, len(places), many))
    for q in range(many):
        for p in range(many):
            if p != q:
                weights[:, :, q] *= (s - own[:, p, None]) / (own[:, q, None] - own[:, p, None])
    lines = np.einsum("exq,teq->tex", weights, values.reshape(len(values), elements, many)).reshape(len(values), -1)
    return s.ravel(), lines[at], lines.min(axis=0), lines.max(axis=0)


def _sideways(
    result: Result, rod: RodMesh, name: str, at: int, s: Array, plane: tuple[int, ...]
) -> tuple[Array, Array]:
    """Places on the deformed axis (k, 3) and the director that ordinates go along: in the plane of bending.

    In a plane picture it is the one that lies in the plane.
    """
    ends = rod.s[:: rod.order]
    e = np.repeat(np.arange(len(ends) - 1), len(s) // (len(ends) - 1))
    shape = lagrange(rod.order, 2.0 * (s - ends[e]) / (ends[e + 1] - ends[e]) - 1.0)[0]
    local = e[:, None] * rod.order + np.arange(rod.order + 1)
    places = np.einsum("ka,kai->ki", shape, result.r[at, rod.nodes][local])
    directors = np.einsum("ka,kaij->kij", shape, result.directors(rod.name)[at][local])
    column = 1 if name in ("M1", "Omega1", "V2", "Gamma2") else 0
    if len(plane) == 2:
        (out,) = set(range(3)) - set(plane)
        column = int(np.abs(directors[0, out, :2]).argmin())
    return places, directors[:, :, column]
