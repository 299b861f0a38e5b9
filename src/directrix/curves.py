"""Axes of rods: position and frame by arclength.

A frame has the columns d1, d2, d3; d3 is the tangent and the frame is rotation-minimising (it never turns about
the tangent). At the start d1 is the part of ``d1=`` normal to the tangent; its default is the Cartesian axis least
aligned with the tangent, ties to the lowest index.
"""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import Vec, choice, number, vector
from directrix.errors import ModelError
from directrix.rotations import exp, smallest_rotation

Array = NDArray[np.float64]
DirectorRule = Literal["tangent", "chord"]

__all__ = [
    "Arc", "Curve", "Helix", "Polyline", "Spline", "Twisted", "arc", "helix", "line", "polyline", "spline", "twisted",
]  # fmt: skip


class Curve(Protocol):
    """What the mesh asks of an axis.

    ``length``; ``breaks``, the arclengths of its kinks; ``directors``, "tangent" (the frame of the curve at each
    node) or "chord" (constant along each, straight, element).
    """

    @property
    def length(self) -> float: ...
    @property
    def breaks(self) -> tuple[float, ...]: ...
    @property
    def directors(self) -> str: ...
    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3) at arclengths (…)."""
        ...

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3) at arclengths ``s``; ``inside``, of the same shape, says on which side of a kink."""
        ...


def first_frame(tangent: Array, d1: Vec | None) -> Array:
    """Frame (3, 3) at the start of a curve; raises ModelError when d1 is along the tangent."""
    wanted = np.eye(3)[np.argmin(np.round(np.abs(tangent), 12))] if d1 is None else np.asarray(d1)
    normal = wanted - (wanted @ tangent) * tangent
    size = np.linalg.norm(normal)
    if size <= 1e-9 * np.linalg.norm(wanted):
        raise ModelError(f"d1 = {d1} is along the rod at its start", "give a vector that is not parallel to the axis")
    normal = normal / size
    return np.stack([normal, np.cross(tangent, normal), tangent], -1)


def _options(directors: str, d1: Any) -> tuple[str, Vec | None]:
    choice(directors, "rule for directors", ("tangent", "chord"))
    if d1 is not None:
        d1 = vector(d1, "d1")
        if not any(d1):
            raise ModelError("d1 = (0, 0, 0) has no direction", "give a vector normal to the axis at the start")
    return directors, d1


FAR = 1e60  # coordinates whose squares, and the squares of those, are finite


def _points(points: Any, what: str, least: int) -> tuple[Vec, ...]:
    try:
        given = tuple(vector(p, f"point {k} of the {what}") for k, p in enumerate(points))
    except (TypeError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError(f"the points of a {what} are not a list of points", "give [(x, y, z), …]") from error
    if len(given) < least:
        raise ModelError(f"a {what} needs {least} points or more, {len(given)} given", "add points")
    if (far := float(np.abs(given).max())) > FAR:
        raise ModelError(f"a point of the {what} is {far:.3g} away", "give points of a size that can be computed with")
    for k, (a, b) in enumerate(pairwise(given)):
        if np.linalg.norm(np.subtract(b, a)) <= 1e-12 * np.abs(given).max():
            raise ModelError(f"points {k} and {k + 1} of the {what} are the same, {a}", "remove one of them")
    return given


@dataclass(frozen=True)
class Polyline:
    """Straight parts between points; a line is the one with two points."""

    points: tuple[Vec, ...]
    directors: str = "tangent"
    d1: Vec | None = None

    @cached_property
    def _corners(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))])

    @cached_property
    def _frames(self) -> Array:
        parts = np.diff(self.points, axis=0)
        tangents = parts / np.linalg.norm(parts, axis=1, keepdims=True)
        out = [first_frame(tangents[0], self.d1)]
        for a, b in pairwise(tangents):
            out.append(smallest_rotation(a, b) @ out[-1])
        return np.array(out)

    @property
    def length(self) -> float:
        """Sum of the parts."""
        return float(self._corners[-1])

    @property
    def breaks(self) -> tuple[float, ...]:
        """The corners."""
        return tuple(float(s) for s in self._corners[1:-1])

    def _part(self, s: ArrayLike) -> NDArray[np.int64]:
        return np.clip(np.searchsorted(self._corners, s, side="right") - 1, 0, len(self.points) - 2)

    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3)."""
        k = self._part(s)
        p = np.asarray(self.points)
        share = (np.asarray(s, float) - self._corners[k]) / np.diff(self._corners)[k]
        return p[k] * (1.0 - share[..., None]) + p[k + 1] * share[..., None]

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3), constant along each part."""
        return self._frames[self._part(inside)]


@dataclass(frozen=True)
class Arc:
    """Part of a circle from ``start`` through a point to ``end``."""

    start: Vec
    through: Vec
    end: Vec
    directors: str = "tangent"
    d1: Vec | None = None

    @cached_property
    def _circle(self) -> tuple[Array, Array, float, Array]:
        """Centre, axis of the turn, angle, frame at the start."""
        a, b, c = (np.asarray(p) for p in (self.start, self.through, self.end))
        u, v = b - a, c - a
        normal = np.cross(u, v)
        area = normal @ normal
        centre = a + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2.0 * area)
        axis = normal / np.sqrt(area)
        x = a - centre
        y = np.cross(axis, x)
        angle = np.arctan2((c - centre) @ y, (c - centre) @ x) % (2.0 * np.pi)
        return centre, axis, float(angle), first_frame(y / np.linalg.norm(y), self.d1)

    @property
    def length(self) -> float:
        """Radius times angle."""
        centre, _, angle, _ = self._circle
        return float(np.linalg.norm(np.subtract(self.start, centre)) * angle)

    @property
    def breaks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def _turn(self, s: ArrayLike) -> Array:
        _, axis, angle, _ = self._circle
        return exp((np.asarray(s, float) / self.length * angle)[..., None] * axis)

    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3)."""
        centre = self._circle[0]
        return centre + self._turn(s) @ (np.asarray(self.start) - centre)

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3): the one at the start, turned with the radius."""
        return self._turn(s) @ self._circle[3]


@dataclass(frozen=True)
class Helix:
    """Winds around an axis; ``turns`` < 0 is left-handed."""

    radius: float
    pitch: float
    turns: float
    origin: Vec
    axis: Vec
    toward: Vec | None
    directors: str = "tangent"
    d1: Vec | None = None

    @cached_property
    def _base(self) -> Array:
        """Columns: from the axis to the start, sideways, along the axis."""
        axis = np.asarray(self.axis)
        return first_frame(axis / np.linalg.norm(axis), self.toward)

    @property
    def _sense(self) -> tuple[float, float, float]:
        """Angle and climb per arclength, and the sine of the climb."""
        climb = self.pitch / (2.0 * np.pi)
        speed = float(np.hypot(self.radius, climb))
        return float(np.sign(self.turns)) / speed, climb / speed, climb

    @property
    def length(self) -> float:
        """Of the whole wire."""
        return float(2.0 * np.pi * abs(self.turns) * np.hypot(self.radius, self.pitch / (2.0 * np.pi)))

    @property
    def breaks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3)."""
        s = np.asarray(s, float)
        turn, climb, _ = self._sense
        local = np.stack([self.radius * np.cos(turn * s), self.radius * np.sin(turn * s), climb * s], -1)
        return np.asarray(self.origin) + local @ self._base.T

    def _frenet(self, s: Array) -> Array:
        turn, climb, _ = self._sense
        c, d, side = np.cos(turn * s), np.sin(turn * s), self.radius * turn
        tangent = np.stack([-side * d, side * c, np.full_like(s, climb)], -1)
        normal = np.stack([-c, -d, np.zeros_like(s)], -1)
        return self._base @ np.stack([normal, np.cross(tangent, normal), tangent], -1)

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3): Frenet's, turned back by the torsion that it has collected."""
        s = np.asarray(s, float)
        turn, climb, _ = self._sense
        start = self._frenet(np.zeros(()))
        first = first_frame(start[:, 2], self.d1)
        back = np.zeros((*s.shape, 3))
        back[..., 2] = -turn * climb * s
        return self._frenet(s) @ exp(back) @ (start.T @ first)


@dataclass(frozen=True)
class Spline:
    """Cubic spline through points, twice continuously differentiable, by arclength."""

    points: tuple[Vec, ...]
    directors: str = "tangent"
    d1: Vec | None = None

    @cached_property
    def _table(self) -> tuple[Any, Array, Array, Array]:
        """The spline by its own parameter, a fine grid of that, arclength and frame there."""
        p = np.asarray(self.points)
        knots: Array = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1)))
        from scipy.interpolate import CubicSpline  # takes as long to load as all the rest

        spline = CubicSpline(knots, p)
        fine = max(64, 2048 // (len(p) - 1))
        spans = [np.linspace(a, b, fine, endpoint=False) for a, b in pairwise(knots.tolist())]
        u: Array = np.append(np.concatenate(spans), knots[-1])
        s: Array = np.append(0.0, np.cumsum(_arclength(spline, u[:-1], u[1:])))
        r, slope = spline(u), spline(u, 1)
        t = slope / np.linalg.norm(slope, axis=1, keepdims=True)
        frames = [first_frame(t[0], self.d1)]
        for k in range(len(u) - 1):
            frames.append(_carried(frames[-1], r[k + 1] - r[k], t[k + 1]))
        return spline, u, s, np.array(frames)

    @property
    def length(self) -> float:
        """Arclength of the whole spline."""
        return float(self._table[2][-1])

    @property
    def breaks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def _parameter(self, s: Array) -> tuple[Array, NDArray[np.int64]]:
        spline, grid, lengths, _ = self._table
        k = np.clip(np.searchsorted(lengths, s, side="right") - 1, 0, len(grid) - 2)
        u = grid[k] + (s - lengths[k]) / np.diff(lengths)[k] * np.diff(grid)[k]
        for _ in range(4):
            miss = lengths[k] + _arclength(spline, grid[k], u) - s
            u = u - miss / np.linalg.norm(spline(u, 1), axis=-1)
        return u, k

    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3)."""
        return self._table[0](self._parameter(np.asarray(s, float))[0])

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3), carried from the nearest of the table."""
        s = np.asarray(s, float)
        spline, grid, _, frames = self._table
        u, k = self._parameter(s)
        slope = spline(u, 1)
        t = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
        step = spline(u) - spline(grid[k])
        out = np.empty((*s.shape, 3, 3))
        for index in np.ndindex(s.shape):
            out[index] = _carried(frames[k[index]], step[index], t[index])
        return out


def _arclength(spline: Any, a: Array, b: Array) -> Array:
    xi, w = np.polynomial.legendre.leggauss(5)
    half = 0.5 * (b - a)
    u = 0.5 * (a + b)[..., None] + half[..., None] * xi
    return half * np.sum(w * np.linalg.norm(spline(u, 1), axis=-1), -1)


def _carried(frame: Array, step: Array, tangent: Array) -> Array:
    """Rotation-minimising frame at the next point: double reflection (Wang, Jüttler, Zheng & Liu 2008), order 4."""
    square = step @ step
    if square == 0.0:
        return smallest_rotation(frame[:, 2], tangent) @ frame
    moved = frame - np.outer(step, 2.0 / square * (step @ frame))
    gap = tangent - moved[:, 2]
    width = gap @ gap
    if width > 0.0:
        moved = moved - np.outer(gap, 2.0 / width * (gap @ moved))
    d1 = moved[:, 0] - (moved[:, 0] @ tangent) * tangent
    d1 = d1 / np.linalg.norm(d1)
    return np.stack([d1, np.cross(tangent, d1), tangent], -1)


def line(
    start: ArrayLike, end: ArrayLike, *, directors: DirectorRule = "tangent", d1: ArrayLike | None = None
) -> Polyline:
    """A straight axis between two points; raises ModelError when they coincide."""
    curve = Polyline(_points([start, end], "line", 2), *_options(directors, d1))
    curve.frames(0.0, 0.0)
    return curve


def lines(starts: ArrayLike, ends: ArrayLike) -> list[Polyline]:
    """Many straight axes at once, from ``starts`` (k, 3) to ``ends`` (k, 3): each is :func:`line` of its points.

    Raises ModelError where points are no numbers or coincide.
    """
    a, b = (np.asarray(points, float) for points in (starts, ends))
    if a.shape != b.shape or a.ndim != 2 or a.shape[1] != 3 or not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ModelError("the ends of lines are not finite points (k, 3)", "give as many starts as ends")
    parts = b - a
    lengths = np.linalg.norm(parts, axis=1)
    size = np.maximum(np.abs(a).max(axis=1, initial=0.0), np.abs(b).max(axis=1, initial=0.0))
    for k in np.flatnonzero(lengths <= 1e-12 * size):
        raise ModelError(f"points 0 and 1 of line {k} are the same, {tuple(a[k].tolist())}", "remove one of them")
    tangents = parts / lengths[:, None]
    wanted = np.eye(3)[np.argmin(np.round(np.abs(tangents), 12), axis=1)]
    normal = wanted - np.einsum("ki,ki->k", wanted, tangents)[:, None] * tangents
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    frames = np.stack([normal, np.cross(tangents, normal), tangents], -1)
    made: list[Polyline] = []
    for first, last, length, frame in zip(a.tolist(), b.tolist(), lengths.tolist(), frames, strict=True):
        curve = Polyline((tuple(first), tuple(last)))
        # what the curve would work out for itself, one by one
        curve.__dict__.update(_corners=np.array([0.0, length]), _frames=frame[None])
        made.append(curve)
    return made


def polyline(points: ArrayLike, *, directors: DirectorRule = "tangent", d1: ArrayLike | None = None) -> Polyline:
    """Straight parts between points (k, 3); every corner gets a node. The frame turns least at a corner.

    Raises ModelError for fewer than two points, coincident neighbours or a corner that turns back on itself.
    """
    curve = Polyline(_points(points, "polyline", 2), *_options(directors, d1))
    if not np.all(np.isfinite(curve.frames(0.0, 0.0))) or not np.all(np.isfinite(curve._frames)):  # pyright: ignore[reportPrivateUsage]
        raise ModelError("a corner of the polyline turns back on itself", "insert a point or end the rod there")
    return curve


def arc(
    start: ArrayLike,
    through: ArrayLike,
    end: ArrayLike,
    *,
    directors: DirectorRule = "tangent",
    d1: ArrayLike | None = None,
) -> Arc:
    """Part of a circle through three points; raises ModelError when they lie on a line."""
    a, b, c = _points([start, through, end], "arc", 3)
    u, v = np.subtract(b, a), np.subtract(c, a)
    if np.linalg.norm(np.cross(u, v)) <= 1e-9 * np.linalg.norm(u) * np.linalg.norm(v):
        raise ModelError(f"the points {a}, {b}, {c} of an arc lie on a line", "use line, or move a point off it")
    curve = Arc(a, b, c, *_options(directors, d1))
    curve.frames(0.0, 0.0)
    return curve


def helix(
    *, radius: float, pitch: float, turns: float, origin: ArrayLike = (0, 0, 0), axis: ArrayLike = (0, 0, 1),
    toward: ArrayLike | None = None, directors: DirectorRule = "tangent", d1: ArrayLike | None = None,
) -> Helix:  # fmt: skip
    """A helix around ``axis`` through ``origin``, climbing ``pitch`` a turn; ``turns`` < 0 winds left-handed.

    It starts at ``origin`` + ``radius`` in the direction ``toward`` (its part normal to the axis; default: the
    Cartesian axis least aligned with ``axis``). Raises ModelError for a radius or number of turns of zero.
    """
    r, p, n = number(radius, "radius", above=0.0), number(pitch, "pitch"), number(turns, "turns")
    if n == 0.0:
        raise ModelError("turns = 0 is no helix", "give a number of turns, < 0 for a left-handed one")
    along = vector(axis, "axis")
    if not any(along):
        raise ModelError("axis = (0, 0, 0) has no direction", "give a vector")
    aside = None if toward is None else vector(toward, "toward")
    curve = Helix(r, p, n, vector(origin, "origin"), along, aside, *_options(directors, d1))
    curve.frames(0.0, 0.0)
    return curve


def spline(points: ArrayLike, *, directors: DirectorRule = "tangent", d1: ArrayLike | None = None) -> Spline:
    """A smooth axis through points (k, 3), k ≥ 3: cubic spline by chord length.

    Raises ModelError for fewer than three points, coincident neighbours or a point where the axis turns back.
    """
    curve = Spline(_points(points, "spline", 3), *_options(directors, d1))
    with np.errstate(all="ignore"):
        frames = curve._table[3]  # pyright: ignore[reportPrivateUsage]
    if not np.all(np.isfinite(frames)):
        raise ModelError("the spline turns back on itself in a point", "insert a point there or end the rod there")
    return curve


@dataclass(frozen=True)
class Twisted:
    """A curve whose directors are turned about the tangent by an angle that is linear between ``fractions``."""

    curve: Curve
    fractions: tuple[float, ...]
    angles: tuple[float, ...]
    function: Callable[[float], float] | None = None

    @property
    def length(self) -> float:
        """Of the curve."""
        return self.curve.length

    @property
    def breaks(self) -> tuple[float, ...]:
        """Of the curve, and where the rate of twist changes."""
        inner = () if self.function is not None else tuple(f * self.length for f in self.fractions[1:-1])
        return tuple(sorted({*self.curve.breaks, *inner}))

    @property
    def directors(self) -> str:
        """Rule of the curve."""
        return self.curve.directors

    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3)."""
        return self.curve.position(s)

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3) of the curve, turned about d3."""
        at = np.asarray(s, float) / self.length
        if self.function is None:
            angle = np.interp(at, self.fractions, self.angles)
        else:
            angle = np.array([number(self.function(f), "twist") for f in at.ravel().tolist()]).reshape(at.shape)
        turn = np.zeros((*at.shape, 3))
        turn[..., 2] = angle
        return self.curve.frames(s, inside) @ exp(turn)


def twisted(curve: Curve, twist: Any) -> Twisted:
    """A curve whose sections are twisted about it in the reference, without stress.

    ``twist`` [rad], from d1 towards d2: the angle at the end of the curve, to which it grows with arclength; pairs
    (fraction of the arclength, angle) from 0 to 1, linear between them; or a function of the fraction. A twisted rod
    wants elements that turn by less than about half a radian. Raises ModelError for anything else.
    """
    if callable(twist):
        turn = cast("Callable[[float], float]", twist)
        for f in (0.0, 0.5, 1.0):
            try:
                number(turn(f), f"twist at fraction {f:g}")
            except ModelError:
                raise
            except Exception as error:  # whatever a user's function raises
                raise ModelError(
                    f"the twist as a function fails at {f:g}: {error!r}", "return an angle for 0 … 1"
                ) from error
        return Twisted(curve, (0.0, 1.0), (0.0, 0.0), turn)
    if isinstance(twist, (int, float)) and not isinstance(twist, bool):
        return Twisted(curve, (0.0, 1.0), (0.0, number(twist, "twist")))
    rows: Any = twist
    try:
        pairs = [(number(f, "fraction of a twist"), number(a, "angle of a twist")) for f, a in rows]
    except (TypeError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError("twist is neither an angle nor pairs of them", "give [(0, 0.0), (1, 0.3)]") from None
    fractions = tuple(f for f, _ in pairs)
    if len(pairs) < 2 or fractions[0] != 0.0 or fractions[-1] != 1.0 or np.any(np.diff(fractions) <= 0.0):
        raise ModelError("the fractions of a twist do not rise from 0 to 1", "give [(0, 0.0), …, (1, 0.3)]")
    return Twisted(curve, fractions, tuple(a for _, a in pairs))
