"""Cantilever under a dead tip load: order of convergence (its numbers are in the suite, ``elastica``).

Measured on the Simo–Reissner rod itself, integrated with DOP853.
"""

from __future__ import annotations

import numpy as np
import pytest

from directrix.basis import lagrange
from directrix.verification.elastica import exact_axis, loaded
from directrix.verification.models import equilibrium


@pytest.mark.parametrize(("order", "meshes"), [(1, (32, 64, 128)), (2, (16, 32, 64)), (3, (8, 16, 32))])
def test_the_displacement_converges_with_order_p_plus_one(order: int, meshes: tuple[int, ...]) -> None:
    a, EA, GA = 3.0, 100.0, 100.0
    exact = exact_axis(a, EA, GA)
    xi, w = np.polynomial.legendre.leggauss(order + 3)
    shape, _ = lagrange(order, xi)
    errors = []
    for n in meshes:
        result = equilibrium(loaded(a, n, order, EA, GA))
        nodes = np.arange(n)[:, None] * order + np.arange(order + 1)
        r = np.einsum("ga,eak->egk", shape, result.r[-1][nodes])
        s = (np.arange(n)[:, None] + 0.5 * (xi + 1.0)) / n
        errors.append(np.sqrt(np.einsum("g,egk->", 0.5 / n * w, (r - exact(s)) ** 2)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    print(order, errors, rates)
    assert abs(rates[-1] - (order + 1)) <= 0.1
