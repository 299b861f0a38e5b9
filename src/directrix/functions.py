"""Functions of time as frozen values: they print, compare and pickle. In statics the argument is the load factor.

A value may be a number, a vector or any sequence of numbers; what comes out has its shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import pi, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import number, shown
from directrix.errors import ModelError

Array = NDArray[np.float64]
Value = float | tuple[float, ...]

__all__ = ["Harmonic", "Ramp", "Table", "Value", "harmonic", "ramp", "table"]


def _value(value: Any, what: str) -> Value:
    try:
        given = np.asarray(value, float)
    except (TypeError, ValueError):
        given = np.array(np.nan)
    if given.ndim > 1 or given.size == 0 or not np.all(np.isfinite(given)):
        raise ModelError(f"{what} = {shown(value)} is neither a number nor numbers", "give finite numbers")
    return float(given) if given.ndim == 0 else tuple(given.tolist())


@dataclass(frozen=True)
class Ramp:
    """0 until ``t0``, then linear, ``value`` from ``t1`` on."""

    value: Value
    t0: float = 0.0
    t1: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", _value(self.value, "value of a ramp"))
        if number(self.t1, "t1 of a ramp") <= number(self.t0, "t0 of a ramp"):
            raise ModelError(f"t1 = {self.t1:g} is not after t0 = {self.t0:g}", "give a later t1")

    def __call__(self, t: float) -> Any:
        """Its value at ``t``."""
        return min(1.0, max(0.0, (t - self.t0) / (self.t1 - self.t0))) * _plain(self.value)


@dataclass(frozen=True)
class Harmonic:
    """mean + value · sin(2π · frequency · t + phase); ``frequency`` in cycles per unit of time, ``phase`` in rad."""

    value: Value
    frequency: float
    phase: float = 0.0
    mean: Value = 0.0

    def __post_init__(self) -> None:
        for name in ("value", "mean"):
            object.__setattr__(self, name, _value(getattr(self, name), f"{name} of a harmonic"))
        number(self.frequency, "frequency", above=0.0)
        number(self.phase, "phase")
        if isinstance(self.mean, tuple) and np.shape(self.mean) != np.shape(self.value):
            raise ModelError(f"mean = {self.mean} has not the shape of value = {self.value}", "give as many numbers")

    def __call__(self, t: float) -> Any:
        """Its value at ``t``."""
        return _plain(self.mean) + sin(2.0 * pi * self.frequency * t + self.phase) * _plain(self.value)


@dataclass(frozen=True)
class Table:
    """Piecewise linear through (time, value), constant before the first and after the last of the ``times``."""

    times: tuple[float, ...]
    values: tuple[Value, ...]

    def __post_init__(self) -> None:
        values = tuple(_value(v, "value of a table") for v in self.values)
        times = tuple(number(t, "time of a table") for t in self.times)
        if not times or len(times) != len(values) or len({np.shape(v) for v in values}) != 1:
            raise ModelError(
                f"a table has {len(times)} times and {len(values)} values, all of one shape is what it needs",
                "give one value for every time",
            )
        for a, b in pairwise(times):
            if b <= a:
                raise ModelError(f"the times of a table must increase, but {b:g} follows {a:g}", "sort them")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def __call__(self, t: float) -> Any:
        """Its value at ``t``."""
        if isinstance(self.values[0], float):
            return float(np.interp(t, self.times, self.values))  # type: ignore[arg-type]
        columns: Any = np.transpose(self.values)
        return np.array([np.interp(t, self.times, list(column)) for column in columns])


def _plain(value: Value) -> Any:
    return value if isinstance(value, float) else np.array(value)


def ramp(value: ArrayLike, t0: float = 0.0, t1: float = 1.0) -> Ramp:
    """A function of time: 0 until ``t0``, then linear, ``value`` from ``t1`` on. Raises ModelError unless t0 < t1."""
    return Ramp(_value(value, "value of a ramp"), t0, t1)


def harmonic(value: ArrayLike, frequency: float, phase: float = 0.0, *, mean: ArrayLike = 0.0) -> Harmonic:
    """A function of time: mean + value · sin(2π frequency t + phase). Raises ModelError for what is not finite."""
    return Harmonic(_value(value, "value of a harmonic"), frequency, phase, _value(mean, "mean of a harmonic"))


def table(times: ArrayLike, values: ArrayLike) -> Table:
    """A function of time: linear between the ``values`` at the ``times``, constant outside them.

    Raises ModelError unless the times increase and there is one value for each.
    """
    at: Any = times
    given: Any = values
    try:
        return Table(tuple(at), tuple(given))
    except TypeError:
        raise ModelError(f"{shown(times)}, {shown(values)} are no table", "give times and a value for each") from None
