"""Sections against closed forms and integrals over the area."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx


def test_a_circle_by_its_formulas() -> None:
    s = dx.Section.circle(radius=0.01, E=2e11, nu=0.3, rho=7800)
    A, inertia, k = np.pi * 1e-4, np.pi * 1e-8 / 4, 6 * 1.3 / 8.8
    G = 2e11 / 2.6
    np.testing.assert_allclose(
        np.diag(s.stiffness),
        [k * G * A, k * G * A, 2e11 * A, 2e11 * inertia, 2e11 * inertia, 2 * G * inertia],
    )
    assert s.A_rho == pytest.approx(7800 * A)
    np.testing.assert_allclose(s.I_rho, 7800 * inertia * np.eye(2))
    assert any("shear factor 0.886364" in a for a in s.assumptions)


def test_bending_about_d1_feels_the_height_and_I_rho2_sits_on_d2() -> None:
    s = dx.Section.rectangle(width=0.1, height=0.3, E=1.0, nu=0.0, rho=1.0)
    assert s.stiffness[3, 3] == pytest.approx(0.1 * 0.3**3 / 12)
    assert s.stiffness[4, 4] == pytest.approx(0.3 * 0.1**3 / 12)
    assert s.I_rho[1, 1] == pytest.approx(0.1 * 0.3**3 / 12)
    assert s.I_rho[0, 0] == pytest.approx(0.3 * 0.1**3 / 12)


@pytest.mark.parametrize(("ratio", "known"), [(1.0, 0.1405770), (2.0, 0.2286818), (10.0, 0.3123250)])
def test_torsion_of_a_rectangle(ratio: float, known: float) -> None:
    """J/(long·short³): Timoshenko & Goodier, section 109, here to seven digits by Prandtl's series."""
    s = dx.Section.rectangle(width=1.0, height=ratio, E=2.0, nu=0.0)
    assert s.stiffness[5, 5] / ratio == pytest.approx(known, rel=2e-6)


def test_a_thin_tube_tends_to_the_ring_and_a_thick_one_to_the_circle() -> None:
    thin = dx.Section.tube(outer=1.0, wall=1e-6, E=1.0, nu=0.3)
    assert thin.stiffness[0, 0] / thin.stiffness[2, 2] == pytest.approx(
        2 * 1.3 / (4 + 3 * 0.3) / 2.6, rel=1e-5
    )  # Cowper
    full = dx.Section.tube(outer=1.0, wall=1 - 1e-9, E=1.0, nu=0.3)
    np.testing.assert_allclose(full.stiffness, dx.Section.circle(radius=1.0, E=1.0, nu=0.3).stiffness, rtol=1e-8)


def test_a_6x6_in_either_order_is_the_same_section() -> None:
    rng = np.random.default_rng(0)
    a = rng.standard_normal((6, 6))
    c = a @ a.T + np.eye(6)
    order = [2, 0, 1, 5, 3, 4]  # axial-first rows in terms of shear-axial
    one = dx.Section(stiffness=c, order="shear-axial")
    two = dx.Section(stiffness=c[np.ix_(order, order)], order="axial-first")
    np.testing.assert_allclose(one.stiffness, two.stiffness, atol=1e-15)
    assert one == dx.Section(stiffness=c, order="shear-axial") and hash(one) == hash(
        dx.Section(stiffness=c, order="shear-axial")
    )


def test_a_section_cannot_be_changed() -> None:
    s = dx.Section.circle(radius=1.0, E=1.0, nu=0.3)
    with pytest.raises(ValueError):
        s.stiffness[0, 0] = 2.0
    with pytest.raises(AttributeError):
        s.A_rho = 2.0  # type: ignore[misc]


GOOD = dict(EA=1.0, GA1=1.0, GA2=1.0, EI1=1.0, EI2=1.0, GJ=1.0)


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: dx.Section.circle(radius=-1.0, E=1.0, nu=0.3), "radius"),
        (lambda: dx.Section.circle(radius=1.0, E=float("nan"), nu=0.3), "E"),
        (lambda: dx.Section.circle(radius=1.0, E=1.0), "nu or G"),
        (lambda: dx.Section.circle(radius=1.0, E=1.0, nu=0.3, G=1.0), "nu or G"),
        (lambda: dx.Section.circle(radius=1.0, E=1.0, nu=0.6), "nu"),
        (lambda: dx.Section.circle(radius=1.0, E=1.0, G=0.1), "shear factor"),
        (lambda: dx.Section.circle(radius=1.0, E=1.0, nu=0.3, rho=-1.0), "rho"),
        (lambda: dx.Section.tube(outer=1.0, wall=2.0, E=1.0, nu=0.3), "wall"),
        (lambda: dx.Section.rectangle(width=0.0, height=1.0, E=1.0, nu=0.3), "width"),
        (lambda: dx.Section.from_moduli(**{**GOOD, "EI1": 0.0}), "EI1"),
        (lambda: dx.Section.from_moduli(**{**GOOD, "GJ": True}), "GJ"),
        (lambda: dx.Section(stiffness=np.eye(5), order="shear-axial"), "6×6"),
        (
            lambda: dx.Section(stiffness=np.diag([1, 1, 1, 1, 1, -1]), order="shear-axial"),
            "positive definite",
        ),
        (lambda: dx.Section(stiffness=np.triu(np.ones((6, 6))), order="shear-axial"), "symmetric"),
        (lambda: dx.Section(stiffness=np.eye(6), order="axial first"), "order"),
        (lambda: dx.Section(stiffness=np.eye(6), I_rho=-np.eye(2), order="shear-axial"), "I_rho"),
    ],
)
def test_sections_that_cannot_be_are_refused_by_name(make, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        make()
    assert error.value.fix
