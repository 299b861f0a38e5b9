"""Gauss points and Lagrange shape functions on [−1, 1]; nodes equispaced, in order along the element."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

__all__ = ["at_gauss", "gauss", "lagrange", "nodes"]


@cache
def gauss(points: int) -> tuple[Array, Array]:
    """Points and weights (points,), exact for polynomials of degree 2·points − 1; weights sum to 2."""
    xi, w = np.polynomial.legendre.leggauss(points)
    return 0.5 * (xi - xi[::-1]), 0.5 * (w + w[::-1])


def nodes(order: int) -> Array:
    """Places of the order + 1 nodes in [−1, 1]."""
    return np.linspace(-1.0, 1.0, order + 1)


def lagrange(order: int, xi: Array | float) -> tuple[Array, Array]:
    """Shape functions and their derivatives d/dξ at ``xi`` (...,): two arrays (..., order + 1)."""
    x, at = nodes(order), np.asarray(xi, float)[..., None]
    values: list[Array] = []
    slopes: list[Array] = []
    for a in range(order + 1):
        others = np.delete(x, a)
        scale = float(np.prod(x[a] - others))
        factors = at - others
        values.append(np.prod(factors, axis=-1) / scale)
        partial = [np.prod(np.delete(factors, k, axis=-1), axis=-1) for k in range(order)]
        slopes.append(np.sum(partial, axis=0) / scale)
    return np.stack(values, -1), np.stack(slopes, -1)


@cache
def at_gauss(order: int, points: int) -> tuple[Array, Array]:
    """Shape functions and their derivatives at the Gauss points: two arrays (points, order + 1), to be read only."""
    return lagrange(order, gauss(points)[0])
