"""Cantilever under a dead tip load: the elastica (Mattiasson 1981; elliptic integrals) and its shear-flexible form.

a = PL²/EI. Reference values: elliptic integrals, inextensible and unshearable; the rod is given EA = GA = 10⁷ EI/L².
The convergence is measured on the Simo–Reissner rod itself, integrated with DOP853.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import directrix as dx
from directrix.basis import lagrange

# a: transverse deflection w/L, shortening u/L, slope of the tip
ELASTICA = {
    1.0: (0.3017207738, 0.0564332362834, 0.461351949712),
    2.0: (0.493457480397, 0.160641720825, 0.781749831557),
    5.0: (0.713791523612, 0.387628360724, 1.21536811761),
    10.0: (0.81060902488, 0.554995597754, 1.4302855388),
}


def cantilever(a: float, elements: int, order: int, EA: float, GA: float) -> dx.Result:
    """L = EI = 1, load a along y."""
    section = dx.Section.from_moduli(EA=EA, GA1=GA, GA2=GA, EI1=1.0, EI2=1.0, GJ=1.0)
    model = (
        dx.Model(name="elastica")
        .rod(
            dx.line((0, 0, 0), (1, 0, 0)),
            section,
            name="rod",
            ends=("root", "tip"),
            elements=elements,
            order=order,
        )
        .clamp("root")
        .force("tip", (0, a, 0))
    )
    return dx.solve_static(model, steps=1)


@pytest.mark.parametrize("a", ELASTICA)
def test_32_quadratic_elements_meet_the_elastica(a: float) -> None:
    result = cantilever(a, 32, 2, 1e7, 1e7)
    assert result.success and result.audit.passed
    w, u, slope = ELASTICA[a]
    tip = result.node("tip")
    np.testing.assert_allclose(tip.displacement[-1], [-u, w, 0.0], rtol=0, atol=1e-5)
    assert abs(np.arctan2(tip.R[-1, 1, 0], tip.R[-1, 0, 0]) - slope) <= 1e-5


@pytest.mark.parametrize(
    ("GA", "tip", "slope"),
    [(50.0, (-0.06131563, 0.31781389), 0.4584095513), (1.0, (-0.25213659, 1.16709589), 0.3428232123)],
)
def test_with_shear_the_closed_form_of_batista_is_met(GA: float, tip: tuple[float, float], slope: float) -> None:
    """Data of the source: L = 1, EI = 10, EA = 10⁸, F = 10, GA = 500 and 10; here divided by EI."""
    result = cantilever(1.0, 32, 2, 1e7, GA)
    np.testing.assert_allclose(result.node("tip").displacement[-1, :2], tip, rtol=0, atol=1e-6)
    R = result.node("tip").R[-1]
    assert abs(np.arctan2(R[1, 0], R[0, 0]) - slope) <= 1e-6


def exact_axis(a: float, EA: float, GA: float):
    """(x, y) of the plane Simo–Reissner cantilever as a function of S."""

    def slope(_: float, y: np.ndarray) -> list[float]:
        c, s = np.cos(y[2]), np.sin(y[2])
        axial, shear = 1.0 + a * s / EA, a * c / GA
        return [c * axial - s * shear, s * axial + c * shear, y[3], -(c * axial - s * shear) * a]

    def integrate(k: float):
        return solve_ivp(slope, (0, 1), [0, 0, 0, k], method="DOP853", rtol=1e-12, atol=1e-13, dense_output=True)

    root = brentq(lambda k: integrate(k).y[3, -1], 0.0, 2.0 * a, xtol=1e-14)
    return integrate(root).sol


@pytest.mark.parametrize(("order", "meshes"), [(1, (32, 64, 128)), (2, (16, 32, 64)), (3, (8, 16, 32))])
def test_the_displacement_converges_with_order_p_plus_one(order: int, meshes: tuple[int, ...]) -> None:
    a, EA, GA = 3.0, 100.0, 100.0
    exact = exact_axis(a, EA, GA)
    xi, w = np.polynomial.legendre.leggauss(order + 3)
    shape, _ = lagrange(order, xi)
    errors = []
    for n in meshes:
        result = cantilever(a, n, order, EA, GA)
        nodes = np.arange(n)[:, None] * order + np.arange(order + 1)
        r = np.einsum("ga,eak->egk", shape, result.r[-1][nodes])
        s = (np.arange(n)[:, None] + 0.5 * (xi + 1.0)) / n
        reference = exact(s.ravel())[:2].T.reshape(*s.shape, 2)
        errors.append(np.sqrt(np.einsum("g,egk->", 0.5 / n * w, (r[..., :2] - reference) ** 2)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    print(order, errors, rates)
    assert abs(rates[-1] - (order + 1)) <= 0.1
