"""Functions of time that a case file can name: frozen values that print, compare and pickle.

In statics the argument is the load factor instead of the time.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import pi, sin
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from directrix import functions
from directrix.schema.base import (
    ANGLE,
    FREQUENCY,
    TIME,
    Numbers,
    Places,
    Positive,
    Strict,
    Times,
    Vectors,
    refuse,
)

Array = NDArray[np.float64]
Vec = tuple[float, float, float]
_A = Annotated[float, ANGLE]
Angles = Annotated[tuple[_A, _A, _A], Field(strict=False)]

__all__ = [
    "AlongRod",
    "Pulse",
    "Ramp",
    "Rotated",
    "Scaled",
    "ScaledNumber",
    "Sine",
    "Table",
    "Time",
    "VectorTable",
    "timed",
]


class Table(Strict):
    """Piecewise linear through (t, value); constant before the first and after the last point."""

    kind: Literal["table"] = "table"
    t: Times
    value: Numbers

    @model_validator(mode="after")
    def _table(self) -> Self:
        check_table(self.t, self.value)
        return self

    def __call__(self, t: float) -> float:
        return float(np.interp(t, self.t, self.value))


class Ramp(Strict):
    """0 until ``start``, then linear, 1 from ``until`` on."""

    kind: Literal["ramp"] = "ramp"
    until: Annotated[float, TIME]
    start: Annotated[float, TIME] = 0.0

    @model_validator(mode="after")
    def _order(self) -> Self:
        if self.until <= self.start:
            raise refuse(f"until = {self.until:g} is not after start = {self.start:g}", "give a later until", "until")
        return self

    def __call__(self, t: float) -> float:
        return min(1.0, max(0.0, (t - self.start) / (self.until - self.start)))


class Sine(Strict):
    """mean + amplitude · sin(2π · frequency · t + phase)."""

    kind: Literal["sine"] = "sine"
    frequency: Annotated[Positive, FREQUENCY]
    """Cycles per unit of time."""
    amplitude: float = 1.0
    phase: Annotated[float, ANGLE] = 0.0
    """In radians."""
    mean: float = 0.0

    def __call__(self, t: float) -> float:
        return self.mean + self.amplitude * sin(2.0 * pi * self.frequency * t + self.phase)


class Pulse(Strict):
    """Zero before ``start`` and after ``end``, 1 at its highest.

    ``triangle`` rises to ``peak`` and falls to ``end``; with ``peak = end`` it is still 1 at ``end`` and gone
    after it. ``half-sine`` and ``rectangle`` have their shape over the whole span.
    """

    kind: Literal["pulse"] = "pulse"
    start: Annotated[float, TIME] = 0.0
    end: Annotated[float, TIME]
    peak: Annotated[float, TIME] | None = None
    """Time of the highest point of a triangle, ``start`` and ``end`` included; the middle unless given."""
    shape: Literal["triangle", "half-sine", "rectangle"] = "triangle"

    @model_validator(mode="after")
    def _order(self) -> Self:
        if self.end <= self.start:
            raise refuse(f"end = {self.end:g} is not after start = {self.start:g}", "give a later end", "end")
        if self.peak is not None and self.shape != "triangle":
            raise refuse(f"a {self.shape} has no peak to place", "leave peak out", "peak")
        if self.peak is not None and not self.start <= self.peak <= self.end:
            raise refuse(
                f"peak = {self.peak:g} is outside {self.start:g} … {self.end:g}",
                "put it between start and end",
                "peak",
            )
        return self

    def __call__(self, t: float) -> float:
        span = self.end - self.start
        s = (t - self.start) / span
        # the ends belong to the pulse, also when a sum of steps misses them by a rounding
        if not -1e-9 <= s <= 1.0 + 1e-9:
            return 0.0
        if self.shape == "rectangle":
            return 1.0
        if self.shape == "half-sine":
            return max(0.0, sin(pi * s))
        peak = 0.5 if self.peak is None else (self.peak - self.start) / span
        up = s / peak if peak > 0.0 else 1.0
        down = (1.0 - s) / (1.0 - peak) if peak < 1.0 else 1.0
        return min(1.0, max(0.0, min(up, down)))


Time = Annotated[Table | Ramp | Sine | Pulse, Field(discriminator="kind")]


class VectorTable(Strict):
    """Vectors at given times, piecewise linear between them, constant outside."""

    t: Times
    value: Vectors

    @model_validator(mode="after")
    def _table(self) -> Self:
        check_table(self.t, self.value)
        return self

    def __call__(self, t: float) -> Array:
        return np.array([np.interp(t, self.t, column) for column in zip(*self.value, strict=True)])


class PlaceTable(VectorTable):
    """Displacements at given times, piecewise linear between them, constant outside."""

    value: Places


class TurnTable(VectorTable):
    """Rotation vectors at given times, piecewise linear between them, constant outside."""

    value: Annotated[tuple[Angles, ...], Field(strict=False, min_length=2)]


def check_table(t: tuple[float, ...], value: tuple[Any, ...], key: str = "t", other: str = "value") -> None:
    """Refuse a table whose columns have not the same length, or whose first one does not increase."""
    if len(t) != len(value):
        raise refuse(f"{key} has {len(t)} entries and {other} has {len(value)}", f"give one {other} for every {key}")
    for k, (a, b) in enumerate(pairwise(t), 1):
        if b <= a:
            raise refuse(
                f"{key} must increase, but {b:g} follows {a:g}", "sort the table, drop what is repeated", key, k
            )


@dataclass(frozen=True)
class AlongRod:
    """A number or a vector times a factor of the arclength and one of time, as ``Model.actuate`` calls it."""

    value: float | tuple[float, ...]
    s: tuple[float, ...]
    along: tuple[float, ...]
    factor: Time | None

    def __call__(self, t: float, s: float) -> Array:
        there = float(np.interp(s, self.s, self.along))
        return (1.0 if self.factor is None else self.factor(t)) * there * np.array(self.value)


@dataclass(frozen=True)
class Route:
    """Where a tendon runs (2,), by the fraction of arclength."""

    fraction: tuple[float, ...]
    offset: tuple[tuple[float, float], ...]

    def __call__(self, fraction: float) -> Array:
        return np.array([np.interp(fraction, self.fraction, column) for column in zip(*self.offset, strict=True)])


@dataclass(frozen=True)
class Scaled:
    """A number or a vector times a factor of time."""

    value: float | tuple[float, ...]
    factor: Time

    def __call__(self, t: float) -> Array:
        return self.factor(t) * np.array(self.value)


def timed(value: float | tuple[float, ...], factor: Time | None) -> Any:
    """A value times a factor of time: what ``dx.ramp``, ``dx.harmonic`` and ``dx.table`` give, where they do."""
    given = np.array(value)
    match factor:
        case None:
            return value
        case Ramp():
            return functions.ramp(given, factor.start, factor.until)
        case Sine():
            mean = factor.mean * given if factor.mean else 0.0
            return functions.harmonic(factor.amplitude * given, factor.frequency, factor.phase, mean=mean)
        case Table():
            return functions.table(factor.t, [v * given for v in factor.value])
        case Pulse():
            return Scaled(value, factor)


@dataclass(frozen=True)
class ScaledNumber:
    """A number times a factor of time."""

    value: float
    factor: Time

    def __call__(self, t: float) -> float:
        return self.factor(t) * self.value


@dataclass(frozen=True)
class Rotated:
    """Displacement (3,) of a point that is carried along by a turn.

    The point starts at ``position``, is moved by ``displacement`` and then turned about the line through
    ``about`` by the rotation vector ``turn(t)``.
    """

    position: Vec
    about: Vec
    turn: Scaled
    displacement: Vec | Scaled | VectorTable = (0.0, 0.0, 0.0)

    def __call__(self, t: float) -> Array:
        start, about = np.array(self.position), np.array(self.about)
        by = self.displacement
        moved = start + (np.array(by) if isinstance(by, tuple) else by(t))
        return about + _turned(self.turn(t), moved - about) - start


def _turned(rotation: Array, v: Array) -> Array:
    """exp(rotation) v by Rodrigues' formula."""
    angle = float(np.linalg.norm(rotation))
    cross = np.cross(rotation, v)
    # numpy's sinc(x) is sin(πx)/(πx); it keeps both quotients regular at zero
    return v + np.sinc(angle / pi) * cross + 0.5 * np.sinc(0.5 * angle / pi) ** 2 * np.cross(rotation, cross)
