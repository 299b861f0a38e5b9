"""Roll-up of a cantilever by an end moment: what its numbers (in the suite, ``roll-up``) do not say.

Linear elements have no equilibrium for n < 4πλ elements (λ turns): the run has to fail, and to say why.
"""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx
from directrix.basis import lagrange
from directrix.verification.models import cantilever, equilibrium
from directrix.verification.roll_up import LENGTH, SECTION, exact, rolled


def test_twelve_linear_elements_have_no_full_turn_and_the_status_says_why() -> None:
    result = dx.solve_static(rolled(1.0, 12, 1), steps=1)
    assert not result.success
    assert 0.94 < result.load_factor[-1] < 12 / (4 * np.pi)
    assert "turns by 4" in result.status.sentence and "refine or raise the order" in result.status.sentence
    assert "rod 'rod', element" in result.status.sentence


def test_a_full_turn_of_linear_elements_takes_one_requested_step() -> None:
    result = dx.solve_static(rolled(1.0, 13, 1), steps=1)
    assert result.success and result.audit.passed


def test_cayley_and_exponential_updates_reach_the_same_state() -> None:
    model = cantilever(SECTION, LENGTH, 8).force("tip", (0, 3, 4)).moment("tip", (5, 0, 6))
    one, two = (equilibrium(model, rotation=kind) for kind in ("exponential", "cayley"))
    np.testing.assert_allclose(one.r[-1], two.r[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(one.R[-1], two.R[-1], rtol=0, atol=1e-9)


def field_error(result: dx.Result, order: int, elements: int, turns: float) -> float:
    """L² norm of the error of the interpolated axis over the length."""
    xi, w = np.polynomial.legendre.leggauss(order + 3)
    shape, _ = lagrange(order, xi)
    nodes = np.arange(elements)[:, None] * order + np.arange(order + 1)
    r = np.einsum("ga,eak->egk", shape, result.r[-1][nodes])[..., :2]
    h = LENGTH / elements
    s = h * (np.arange(elements)[:, None] + 0.5 * (xi + 1.0))
    return float(np.sqrt(np.einsum("g,egk->", 0.5 * h * w, (r - exact(turns, s)) ** 2)))


@pytest.mark.parametrize(("order", "meshes"), [(1, (64, 128, 256)), (2, (32, 64, 128)), (3, (16, 32, 64))])
def test_the_displacement_converges_with_order_p_plus_one(order: int, meshes: tuple[int, ...]) -> None:
    turns = 0.5
    errors = [field_error(equilibrium(rolled(turns, n, order)), order, n, turns) for n in meshes]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    print(order, errors, rates)
    assert abs(rates[-1] - (order + 1)) <= 0.1
