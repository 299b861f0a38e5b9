"""The curve of a chain that hangs between two points: y = c cosh(x/c), by arclength."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import Vec, number, vector
from directrix.curves import DirectorRule, first_frame
from directrix.errors import ModelError

Array = NDArray[np.float64]

__all__ = ["Catenary", "catenary"]


@dataclass(frozen=True)
class Catenary:
    """A chain of ``total`` length from ``start`` to ``end`` that hangs in the direction ``down``."""

    start: Vec
    end: Vec
    total: float
    down: Vec = (0.0, 0.0, -1.0)
    directors: str = "tangent"
    d1: Vec | None = None

    @cached_property
    def _axes(self) -> tuple[Array, Array, float, float]:
        """Unit vectors up and across, and how far the end is in these directions."""
        g, way = np.array(self.down), np.subtract(self.end, self.start)
        up = -g / np.linalg.norm(g)
        rise = float(way @ up)
        flat = way - rise * up
        span = float(np.linalg.norm(flat))
        return up, flat / span, rise, span

    @cached_property
    def parameter(self) -> float:
        """c of y = c cosh(x/c): horizontal tension over weight per length."""
        from scipy.optimize import brentq  # pyright: ignore[reportUnknownVariableType]

        _, _, rise, span = self._axes
        # √(L² − h²) = 2 c sinh(a/2c); q = a/2c
        ratio = float(np.sqrt(self.total**2 - rise**2)) / span
        high = 1.0
        while np.sinh(high) / high < ratio:
            high *= 2.0

        def excess(v: float) -> float:
            return float(np.sinh(v)) / v - ratio

        q = float(cast("float", brentq(excess, 1e-12, high, xtol=1e-15, rtol=np.float64(1e-15))))
        return 0.5 * span / q

    @cached_property
    def _lowest(self) -> float:
        """Arclength from the lowest point to the start: c sinh(x/c)."""
        _, _, rise, span = self._axes
        c = self.parameter
        x = c * np.arctanh(rise / self.total) - 0.5 * span
        return float(c * np.sinh(x / c))

    @property
    def length(self) -> float:
        """Of the chain."""
        return self.total

    @property
    def breaks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def position(self, s: ArrayLike) -> Array:
        """Points (…, 3)."""
        up, across, _, _ = self._axes
        c, first = self.parameter, self._lowest
        t = first + np.asarray(s, float)
        x = c * (np.arcsinh(t / c) - np.arcsinh(first / c))
        y = np.hypot(c, t) - np.hypot(c, first)
        return np.asarray(self.start) + x[..., None] * across + y[..., None] * up

    def frames(self, s: ArrayLike, inside: ArrayLike) -> Array:
        """Frames (…, 3, 3): the one at the start, turned in the plane of the chain."""
        up, across, _, _ = self._axes
        t = self._lowest + np.asarray(s, float)
        tangents = (self.parameter * across + t[..., None] * up) / np.hypot(self.parameter, t)[..., None]
        start = (self.parameter * across + self._lowest * up) / np.hypot(self.parameter, self._lowest)
        side = np.cross(across, up)
        first = first_frame(start, self.d1)

        def basis(tangent: Array) -> Array:
            return np.stack([np.broadcast_to(side, tangent.shape), np.cross(tangent, side), tangent], -1)

        return basis(tangents) @ (basis(start).T @ first)


def catenary(
    start: ArrayLike, end: ArrayLike, *, length: float, down: ArrayLike = (0, 0, -1),
    directors: DirectorRule = "tangent", d1: ArrayLike | None = None,
) -> Catenary:  # fmt: skip
    """The axis of a chain of ``length`` that hangs between two points under gravity in the direction ``down``.

    √(L² − h²) = 2c sinh(a/2c) with span a and rise h has one solution c, found to round-off. Raises ModelError when the
    length is not more than the distance of the points, or one is above the other.
    """
    a, b, g = vector(start, "start"), vector(end, "end"), vector(down, "down")
    if not any(g):
        raise ModelError("down = (0, 0, 0) has no direction", "give the direction of gravity")
    way, total = np.subtract(b, a), number(length, "length", above=0.0)
    if not total > (1.0 + 1e-9) * float(np.linalg.norm(way)):
        raise ModelError(
            f"a chain {total:g} long does not hang between points {np.linalg.norm(way):g} apart", "give more length"
        )
    flat = way - (way @ np.array(g)) / (np.array(g) @ np.array(g)) * np.array(g)
    if not np.linalg.norm(flat) > 1e-6 * total:
        raise ModelError("one end of the catenary is above the other", "use two lines")
    curve = Catenary(a, b, total, g, directors, None if d1 is None else vector(d1, "d1"))
    curve.frames(0.0, 0.0)
    return curve
