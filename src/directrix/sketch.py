"""A picture of a model before anything is computed: rods, names, supports, joints, loads, gravity."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.discretisation import Discretisation
from directrix.drawing import BLUE, GREY, INK, NAMES_AT_MOST, ORANGE, XYZ, Stage, axis_line, plain, pyplot, space_in
from directrix.errors import InputError
from directrix.model import DOFS, Distributed, Force, Gravity, Model, Moment, Pressure
from directrix.result import RodMesh

Array = NDArray[np.float64]

__all__ = ["sketch"]

LOAD, MOMENT, MOVED = XYZ[0], "#a02c8c", XYZ[1]
NAMED_AT = 0.4  # of its axis: in the middle there may be a node
COMB = 9  # arrows of a load along a rod
SIDES = {"d1": (0, 1.0), "d2": (1, 1.0), "-d1": (0, -1.0), "-d2": (1, -1.0)}


def sketch(disc: Discretisation, path: Path, t_end: float = 1.0) -> Path:
    """Draw the model into a picture file; loads that vary are drawn at their largest up to ``t_end``.

    Raises ModelError when matplotlib is missing or the picture cannot be written.
    """
    plt = pyplot()
    formats: Any = import_module("matplotlib.backend_bases").FigureCanvasBase.get_supported_filetypes()
    if path.suffix.lstrip(".").lower() not in formats:
        raise InputError("is no picture that can be written", f"use one of the endings {', '.join(formats)}", str(path))
    stage = _stage(disc, plt)
    try:
        _Sketch(disc, stage, t_end).draw()
        stage.finish(disc.model.name)
        stage.ax.figure.savefig(path, dpi=130)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", "name another file", str(path)) from None
    finally:
        plt.close(stage.ax.figure)
    return path


def _stage(disc: Discretisation, plt: Any) -> Stage:
    """Flat where the model and all that acts on it lie in a coordinate plane, else in space."""
    figure = plt.figure(figsize=(8.4, 6.2), layout="constrained")
    points = [disc.mesh.r0, *(_ground(disc.model))]
    span = np.ptp(np.concatenate(points), axis=0)
    acts = np.array([v for v in _directions(disc.model) if v.shape == (3,)]).reshape(-1, 3)
    for out in (2, 1, 0):
        flat = span[out] <= 1e-9 * max(float(span.max()), 1e-300)
        if flat and not np.any(acts[:, out]):
            pen = figure.add_subplot()
            pen.grid(color="#e8ebee", lw=0.7)
            pen.set_axisbelow(True)
            return Stage(pen, tuple(i for i in range(3) if i != out))
    return space_in(figure)


def _ground(model: Model) -> Iterator[Array]:
    for link in model.links:
        if not isinstance(link.b, str):
            yield np.array([link.b], float)


def _directions(model: Model) -> Iterator[Array]:
    for load in model.loads:
        if not isinstance(load, Moment | Pressure):
            yield _largest(load.value, 3, 1.0)


def _largest(value: float | ArrayLike | Callable[[float], ArrayLike], count: int, t_end: float) -> Array:
    """A value, or what a function of time gives where that is largest."""
    if not callable(value):
        return np.array(value, float).reshape(count)
    seen = [np.array(value(t), float).reshape(count) for t in np.linspace(0.0, t_end, 41)]
    return max(seen, key=lambda v: float(np.abs(v).max()))


class _Sketch:
    """One picture while it is drawn."""

    def __init__(self, disc: Discretisation, stage: Stage, t_end: float) -> None:
        self.disc, self.stage, self.t_end = disc, stage, t_end
        self.r0 = disc.mesh.r0
        self.size = max(float(np.ptp(self.r0, axis=0).max()), 1e-300)
        self.places = {name: self.r0[k] for name, k in disc.mesh.node_names.items()}
        self.said: set[str] = set()

    def draw(self) -> None:
        """All of it, and a legend of the signs that are in it."""
        for rod in self.disc.mesh.rods:
            self.stage.line(axis_line(rod, self.r0), color=BLUE, lw=2.2, solid_capstyle="round", zorder=2)
            ends = self.r0[rod.nodes][:: rod.order]
            self.stage.line(ends, ls="", marker="|" if len(self.stage.shown) == 2 else ".", ms=4, color=INK, zorder=3)
        self.links()
        self.supports()
        self.attached()
        self.loads()
        self.names()
        if self.said:
            self.stage.ax.figure.legend(loc="outside right upper", fontsize=8, frameon=False, handlelength=1.4)

    def mark(self, points: Array, label: str, **style: Any) -> None:
        """A sign at (k, 3) points, in the legend once."""
        once = {} if label in self.said else {"label": label}
        self.said.add(label)
        self.stage.line(np.atleast_2d(points), **{"ls": "", "zorder": 6, **style, **once})

    def arrows(self, tips: Array, vectors: Array, colour: str, label: str) -> None:
        """Arrows (k, 3) that end at their tips."""
        if not np.any(vectors):
            return
        tails = [(tips - vectors)[:, i] for i in self.stage.shown]
        along = [vectors[:, i] for i in self.stage.shown]
        pen = self.stage.ax
        if len(self.stage.shown) == 3:
            pen.quiver(*tails, *along, color=colour, lw=1.6, arrow_length_ratio=0.28, zorder=7)
            self.stage.line(tips - vectors, ls="", marker="", color=colour)  # quivers do not widen the axes
        else:
            pen.quiver(
                *tails, *along, color=colour, angles="xy", scale_units="xy", scale=1, width=0.006, zorder=7, headwidth=4
            )
            pen.plot(*tails, ls="", marker="")
        self.mark(tips[:1] * np.nan, label, marker=r"$\rightarrow$", ms=11, color=colour)

    def supports(self) -> None:
        held: dict[str, set[str]] = {}
        for support in self.disc.model.supports:
            held.setdefault(support.node, set()).update(support.dofs)
        for node, dofs in held.items():
            at = self.places[node]
            if dofs == set(DOFS):
                self.mark(at, "clamp", marker="s", ms=11, mfc=GREY, mec=INK)
            elif dofs == set(DOFS[:3]):
                self.mark(at, "pin", marker="^", ms=12, mfc="white", mec=INK, mew=1.5)
            else:
                label = f"held: {' '.join(d for d in DOFS if d in dofs)}"
                self.mark(at, label, marker="D", ms=9, mfc="white", mec=INK, mew=1.5)
        for moved in self.disc.model.prescribed:
            self.mark(self.places[moved.node], "prescribed motion", marker="s", ms=12, mfc="none", mec=MOVED, mew=2)
        for joint in self.disc.model.joints:
            at = np.array(joint.place(self.places), float)
            ground = "" if joint.b else ", on the ground"
            self.mark(at, f"{joint.kind}{ground}", marker="o", ms=9, mfc="white", mec=ORANGE, mew=2)
            self.write(at - 0.05 * self.size * np.array([0.0, 1.0, 1.0]), joint.name, ORANGE)

    def links(self) -> None:
        for link in self.disc.model.links:
            ends = np.array(link.ends(self.places), float)
            what = "cable" if link.cable else "spring" if link.stiffness else "dashpot"
            style = {"cable": "-", "spring": "--", "dashpot": ":"}[what]
            self.mark(ends, what, ls=style, lw=1.4, color=MOVED, zorder=1)
            if not isinstance(link.b, str):
                self.mark(ends[1], "ground", marker="x", ms=7, color=INK)
        rods = {rod.name: rod for rod in self.disc.mesh.rods}
        for tendon in self.disc.model.tendons:
            if isinstance(tendon.along, str):
                rod = rods[tendon.along]
                s = np.asarray(rod.s)
                across = np.array([tendon.across(f) for f in s / max(float(s[-1]), 1e-300)])
                line = self.r0[rod.nodes] + np.einsum("nic,nc->ni", rod.directors[:, :, :2], across)
            else:
                line = np.array(
                    [self.places[n] + np.array(o) for n, o in zip(tendon.along, tendon.offset, strict=True)]
                )
            self.mark(line, "tendon", ls="-", lw=1.1, color=ORANGE, zorder=3)

    def attached(self) -> None:
        for body in self.disc.model.bodies:
            self.mark(self.places[body.node], "mass", marker="o", ms=11, mfc=INK, mec=INK)

    def loads(self) -> None:
        """Arrows of one length for the largest load of each kind, shorter in proportion but never too short to see."""
        model, rods = self.disc.model, {rod.name: rod for rod in self.disc.mesh.rods}
        kinds: dict[type, list[tuple[Array, Array]]] = {}
        for load in model.loads:
            match load:
                case Force() | Moment():
                    feet, v = self.places[load.node][None], _largest(load.value, 3, self.t_end)
                    kinds.setdefault(type(load), []).append((feet, v[None]))
                case Distributed():
                    feet = self._comb(rods[load.rod])[0]
                    v = _largest(load.value, 3, self.t_end)
                    kinds.setdefault(Distributed, []).append((feet, np.tile(v, (len(feet), 1))))
                case Pressure():
                    feet, frames = self._comb(rods[load.rod])
                    column, sign = SIDES[load.along]
                    size = float(_largest(load.value, 1, self.t_end)[0]) * load.width * sign
                    kinds.setdefault(Pressure, []).append((feet, size * frames[:, :, column]))
                case Gravity():
                    g = _largest(load.value, 3, self.t_end)
                    top = self.r0.max(axis=0) + 0.12 * self.size
                    if np.any(g):
                        self.arrows(top[None], 0.14 * self.size * _unit(g)[None], GREY, "gravity")
        looks = {
            Force: (LOAD, "force", 0.2), Moment: (MOMENT, "moment (about its arrow)", 0.16),
            Distributed: ("#e2837c", "load along a rod", 0.1), Pressure: (ORANGE, "pressure", 0.1),
        }  # fmt: skip
        for kind, drawn in kinds.items():
            colour, label, length = looks[kind]
            largest = max(float(np.linalg.norm(v, axis=1).max()) for _, v in drawn)
            for feet, v in drawn:
                sizes = np.linalg.norm(v, axis=1, keepdims=True)
                scale = length * self.size * (0.3 + 0.7 * sizes / max(largest, 1e-300))
                arrows = np.where(sizes > 0.0, v / np.maximum(sizes, 1e-300) * scale, 0.0)
                out = [i for i in range(3) if i not in self.stage.shown]
                if kind is Moment and out and not np.any(arrows[:, list(self.stage.shown)]):
                    sense = (v[0, out[0]] > 0.0) != (out[0] == 1)  # x to the right, z up: y points into the page
                    self.mark(feet, "moment", marker=r"$\circlearrowleft$" if sense else r"$\circlearrowright$", ms=18,
                              color=MOMENT)  # fmt: skip
                else:  # forces push at their node, moments start from it, so that both can be seen
                    self.arrows(feet + arrows if kind is Moment else feet, arrows, colour, label)

    def _comb(self, rod: RodMesh) -> tuple[Array, Array]:
        """Points along a rod and their frames."""
        at = np.linspace(0.0, float(rod.s[-1]), COMB)
        nodal: Array = self.r0[rod.nodes]
        points = np.stack([np.interp(at, rod.s, nodal[:, i]) for i in range(3)], axis=1)
        return points, rod.directors[np.abs(np.subtract.outer(at, rod.s)).argmin(axis=1)]

    def names(self) -> None:
        if len(self.places) <= NAMES_AT_MOST:
            there: list[tuple[Array, list[str]]] = []  # nodes at one place, as those of a joint, share a label
            for name, place in self.places.items():
                shared = [label for other, label in there if np.abs(other - place).max() <= 1e-6 * self.size]
                if shared:
                    shared[0].append(name)
                else:
                    there.append((place, [name]))
            for place, label in there:
                self.mark(place, "node", marker="o", ms=4, color=INK)
                self.write(place, ", ".join(label), INK, weight="bold")
        if len(self.disc.mesh.rods) <= NAMES_AT_MOST:
            for rod in self.disc.mesh.rods:
                axis = axis_line(rod, self.r0)
                self.write(axis[int(NAMED_AT * (len(axis) - 1))], rod.name, BLUE, style="italic")

    def write(self, place: Array, text: str, colour: str, **style: Any) -> None:
        spot = [float(place[i]) for i in self.stage.shown]
        self.stage.ax.text(*spot, f"  {plain(text)}", color=colour, fontsize=9, va="bottom", zorder=8, **style)


def _unit(v: Array) -> Array:
    return v / max(float(np.linalg.norm(v)), 1e-300)
