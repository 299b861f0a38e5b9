"""Roll-up of a cantilever by an end moment: closed forms, of the rod and of the discrete rod.

x(S) = (EI/M) sin(MS/EI), y(S) = (EI/M)(1 − cos(MS/EI)) is the rod. The two-node one-point director element has
its own closed form: nodal turn δ = ½ asin(4πλ/n), chords h/cos(δ/2) at the angles (e − ½)δ, and no equilibrium for
n < 4πλ elements (λ turns).
"""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx
from directrix.basis import lagrange

LENGTH, EI = 10.0, 100.0


def roll_up(turns: float, elements: int, order: int, steps: int = 1) -> dx.Result:
    section = dx.Section.from_moduli(EA=1e4, GA1=1e4, GA2=1e4, EI1=EI, EI2=EI, GJ=EI)
    model = (
        dx.Model(name="roll-up")
        .rod(
            dx.line((0, 0, 0), (LENGTH, 0, 0)),
            section,
            name="rod",
            ends=("root", "tip"),
            elements=elements,
            order=order,
        )
        .clamp("root")
        .moment("tip", (0, 0, 2 * np.pi * turns * EI / LENGTH))
    )
    return dx.solve_static(model, steps=steps)


def discrete(turns: float, n: int) -> np.ndarray:
    delta = 0.5 * np.arcsin(4 * np.pi * turns / n)
    angles = (np.arange(1, n + 1) - 0.5) * delta
    chord = LENGTH / n / np.cos(0.5 * delta)
    return np.array([np.cos(angles).sum() * chord - LENGTH, np.sin(angles).sum() * chord, n * delta])


@pytest.mark.parametrize(
    ("turns", "n", "known"),
    [
        (1.0, 13, (-9.013419420784972, 2.0471577370562306, 8.526608057252915)),
        (1.0, 16, (-8.840646553663454, 0.591486811148336, 7.226712886132102)),
        (1.0, 32, (-9.73028881832737, 0.023503655464605, 6.457033710797846)),
        (1.0, 128, (-9.983885888695543, 0.0000816768314, 6.293322525478201)),
        (0.25, 8, (-3.7688563007576885, 6.508022753848089, 1.6142584276994614)),
        (0.125, 2, (-1.002803513186283, 4.364682735052675, 0.9033391107665127)),
    ],
)
def test_linear_elements_give_their_closed_form_from_one_requested_step(turns: float, n: int, known: tuple) -> None:
    result = roll_up(turns, n, 1)
    assert result.success and result.audit.passed
    exact = discrete(turns, n)
    np.testing.assert_allclose(exact, known, rtol=0, atol=1e-9)
    tip = result.node("tip")
    np.testing.assert_allclose(tip.displacement[-1], [exact[0], exact[1], 0.0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(tip.R[-1, :2, 0], [np.cos(exact[2]), np.sin(exact[2])], rtol=0, atol=1e-9)


def test_twelve_linear_elements_have_no_full_turn_and_the_status_says_why() -> None:
    result = roll_up(1.0, 12, 1)
    assert not result.success
    assert 0.94 < result.load_factor[-1] < 12 / (4 * np.pi)
    assert "turns by 4" in result.status.sentence and "refine or raise the order" in result.status.sentence
    assert "rod 'rod', element" in result.status.sentence


def test_cayley_and_exponential_updates_reach_the_same_state() -> None:
    section = dx.Section.from_moduli(EA=1e4, GA1=1e4, GA2=1e4, EI1=EI, EI2=EI, GJ=EI)
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (LENGTH, 0, 0)), section, name="rod", ends=("root", "tip"), elements=8)
        .clamp("root")
        .force("tip", (0, 3, 4))
        .moment("tip", (5, 0, 6))
    )
    one, two = (dx.solve_static(model, steps=1, rotation=kind) for kind in ("exponential", "cayley"))
    assert one.success and two.success
    np.testing.assert_allclose(one.r[-1], two.r[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(one.R[-1], two.R[-1], rtol=0, atol=1e-9)


def field_error(result: dx.Result, order: int, elements: int, turns: float) -> float:
    """L² norm of the error of the interpolated axis over the length."""
    xi, w = np.polynomial.legendre.leggauss(order + 3)
    shape, _ = lagrange(order, xi)
    nodes = np.arange(elements)[:, None] * order + np.arange(order + 1)
    r = np.einsum("ga,eak->egk", shape, result.r[-1][nodes])
    h = LENGTH / elements
    s = h * (np.arange(elements)[:, None] + 0.5 * (xi + 1.0))
    k = 2 * np.pi * turns / LENGTH
    exact = np.stack([np.sin(k * s) / k, (1 - np.cos(k * s)) / k, 0 * s], -1)
    return float(np.sqrt(np.einsum("g,egk->", 0.5 * h * w, (r - exact) ** 2)))


@pytest.mark.parametrize(("order", "meshes"), [(1, (64, 128, 256)), (2, (32, 64, 128)), (3, (16, 32, 64))])
def test_the_displacement_converges_with_order_p_plus_one(order: int, meshes: tuple[int, ...]) -> None:
    turns = 0.5
    errors = [field_error(roll_up(turns, n, order), order, n, turns) for n in meshes]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    print(order, errors, rates)
    assert abs(rates[-1] - (order + 1)) <= 0.1


@pytest.mark.parametrize(
    ("turns", "known"),
    [
        (0.125, (-0.9968368384289394, 3.729232285780566)),
        (0.25, (-3.633802276324186, 6.366197723675812)),
        (1.0, (-10.0, 0.0)),
        (1.5, (-10.0, 2.1220659078919377)),
    ],
)
def test_quadratic_elements_meet_the_rod(turns: float, known: tuple[float, float]) -> None:
    result = roll_up(turns, 96, 2)
    assert result.success
    np.testing.assert_allclose(result.node("tip").displacement[-1], [*known, 0.0], rtol=0, atol=2e-6 * LENGTH)
