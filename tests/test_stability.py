"""Vibration and buckling: what defines them; published values are in the validation suite."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx


def section(**changes: float) -> dx.Section:
    moduli = dict(EA=1e7, GA1=1e7, GA2=1e7, EI1=1.0, EI2=1.0, GJ=1.0, A_rho=1.0, I_rho1=1e-8, I_rho2=1e-8)
    return dx.Section.from_moduli(**{**moduli, **changes})


def rod(order: int = 2, elements: int = 32, **changes: float) -> dx.Model:
    """Unit length along x, d1 along y."""
    axis = dx.line((0, 0, 0), (1, 0, 0), d1=(0, 1, 0))
    return dx.Model(name="rod").rod(
        axis, section(**changes), name="rod", ends=("a", "b"), elements=elements, order=order
    )


def test_a_shape_has_unit_modal_mass() -> None:
    """A cantilever's first shape is 2 A_ρ^−½ at its tip, whatever the mode."""
    found = dx.modes(rod().clamp("a"), count=6)
    tip = found.mesh.node("b")
    assert found.stable
    np.testing.assert_allclose(np.linalg.norm(found.shapes[:, tip, 1:3], axis=1), 2.0, rtol=1e-4)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_axial_and_torsional_frequencies(order: int) -> None:
    """A clamped–free rod: ω = (k − ½) π √(EA/A_ρ), and √(GJ/J_ρ) for torsion, at any slenderness."""
    model = rod(order, 60 // order, EA=1.0, GA1=10.0, GA2=10.0, EI1=100.0, EI2=100.0, GJ=0.01, I_rho1=0.05, I_rho2=0.05)
    found = 2.0 * np.pi * dx.modes(model.clamp("a"), count=6).frequencies
    axial = (np.arange(1, 3) - 0.5) * np.pi
    torsion = axial * np.sqrt(0.01 / 0.1)
    for value in (*axial[:1], *torsion):
        assert np.abs(found / value - 1.0).min() <= (1e-3 if order == 1 else 1e-6)


def test_a_free_rod_has_six_modes_of_no_frequency_and_then_its_own() -> None:
    """(βL)² = 22.3733 of a free–free beam."""
    found = dx.modes(rod(), count=8)
    assert np.abs(found.squares[:6]).max() <= 1e-4
    np.testing.assert_allclose(2.0 * np.pi * found.frequencies[6:], 4.7300407449**2, rtol=2e-5)


def test_tension_stiffens_and_the_state_counts() -> None:
    """A taut string: ω = π √(T/A_ρ)/L for next to no bending stiffness; compression beyond buckling is unstable."""
    T = 50.0
    model = rod(EI1=3e-3, EI2=3e-3).fix("a", "x", "y", "z", "rx", "ry", "rz").fix("b", "y", "z", "rx", "ry", "rz")
    taut = dx.solve_static(model.force("b", (T, 0, 0)))
    found = dx.modes(model, about=taut, count=2)
    assert 2.0 * np.pi * found.frequencies[0] == pytest.approx(np.pi * np.sqrt(T), rel=2e-2)
    pushed = dx.solve_static(model.force("b", (-0.3, 0, 0)))
    assert not dx.modes(model, about=pushed, count=2).stable
    assert dx.modes(model, count=2).stable


def test_a_mass_on_the_tip_and_a_spring_take_part() -> None:
    """A stiff light rod on a spring: ω² = k/m along it."""
    model = rod(1, 1, A_rho=1e-9, I_rho1=1e-9, I_rho2=1e-9, EI1=1e6, EI2=1e6, GJ=1e6)
    model = model.fix("a", "y", "z", "rx", "ry", "rz").point_mass("b", 3.0).spring("a", (-1, 0, 0), 12.0)
    assert (2.0 * np.pi * dx.modes(model, count=1).frequencies[0]) ** 2 == pytest.approx(4.0, rel=1e-5)


def test_the_shape_of_a_buckled_column_is_a_quarter_wave() -> None:
    """1 − cos(πs/2L), largest displacement 1; the loads themselves are in the validation suite."""
    loads = dx.buckling(rod().clamp("a").force("b", (-1, 0, 0)), count=2)
    s = loads.mesh.rod("rod").s
    for shape in loads.shapes:
        sideways = np.linalg.norm(shape[:, 1:3], axis=1)
        assert np.abs(shape[:, :3]).max() == pytest.approx(1.0)
        np.testing.assert_allclose(sideways / sideways[-1], 1.0 - np.cos(0.5 * np.pi * s), atol=1e-5)


def test_what_cannot_be_asked_is_refused() -> None:
    loaded = rod().clamp("a").force("b", (-1, 0, 0))
    moving = dx.simulate(rod(), t_end=0.1, dt=0.1)
    cases = [
        (lambda: dx.modes(loaded, count=0), "count"),
        (lambda: dx.modes(loaded, about=moving), "not an equilibrium"),
        (lambda: dx.modes(loaded.force("b", (0, 1, 0), follower=True)), "turns with its node"),
        (lambda: dx.buckling(rod().clamp("a")), "no load that could buckle"),
        (lambda: dx.buckling(loaded, count=10**6), "count"),
        (lambda: dx.modes(dx.Model()), "no rod"),
    ]
    for make, reason in cases:
        with pytest.raises(dx.ModelError, match=reason) as error:
            make()
        assert error.value.fix
