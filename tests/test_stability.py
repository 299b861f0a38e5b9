"""Frequencies and buckling loads against closed forms and published values."""

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


def test_a_cantilever_has_the_frequencies_of_euler_and_bernoulli() -> None:
    """(βL)² = 3.516, 22.03, 61.70 in both planes; the slender rod meets them to 1e-5 (validation 4.1)."""
    found = dx.modes(rod().clamp("a"), count=6)
    exact = np.repeat(np.array([1.8751040687, 4.6940911330, 7.8547574382]) ** 2, 2)
    np.testing.assert_allclose(2.0 * np.pi * found.frequencies, exact, rtol=2e-5)
    assert found.stable
    tip = found.mesh.node("b")
    assert np.all(np.abs(found.shapes[:, tip, 1:3]).max(axis=1) > 1.0)


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
    model = rod(EI1=1e-3, EI2=1e-3).fix("a", "x", "y", "z", "rx", "ry", "rz").fix("b", "y", "z", "rx", "ry", "rz")
    taut = dx.solve_static(model.force("b", (T, 0, 0)))
    found = dx.modes(model, about=taut, count=2)
    assert 2.0 * np.pi * found.frequencies[0] == pytest.approx(np.pi * np.sqrt(T), rel=2e-2)
    pushed = dx.solve_static(model.force("b", (-0.1, 0, 0)))
    assert not dx.modes(model, about=pushed, count=2).stable
    assert dx.modes(model, count=2).stable


def test_a_mass_on_the_tip_and_a_spring_take_part() -> None:
    """A stiff light rod on a spring: ω² = k/m along it."""
    model = rod(1, 1, A_rho=1e-9, I_rho1=1e-9, I_rho2=1e-9, EI1=1e6, EI2=1e6, GJ=1e6)
    model = model.fix("a", "y", "z", "rx", "ry", "rz").point_mass("b", 3.0).spring("a", (-1, 0, 0), 12.0)
    assert (2.0 * np.pi * dx.modes(model, count=1).frequencies[0]) ** 2 == pytest.approx(4.0, rel=1e-5)


@pytest.mark.parametrize("times", [10.0, 1e2, 1e3, 1e4])
def test_a_column_with_shear_buckles_as_haringx_says(times: float) -> None:
    """P (1 + P (1/GA − 1/EA)) = π² EI/4L², the exact bifurcation of the Simo–Reissner column (validation 3.6)."""
    euler = np.pi**2 / 4.0
    GA, EA = times * euler, 1e9
    loads = dx.buckling(rod(GA1=GA, GA2=GA, EA=EA).clamp("a").force("b", (-1, 0, 0)), count=2)
    P = loads.factors
    np.testing.assert_allclose(P * (1.0 + P * (1.0 / GA - 1.0 / EA)), euler, rtol=1e-6)
    tip = loads.mesh.node("b")
    assert np.abs(loads.shapes[:, tip, 1:3]).max() == pytest.approx(1.0)


def test_a_narrow_cantilever_buckles_sideways() -> None:
    """4.0126 √(EI GJ)/L² under a dead tip force, in both senses (validation 3.4)."""
    loads = dx.buckling(rod(EI1=1e5, GJ=0.7).clamp("a").force("b", (0, 0, -1)), count=2)
    np.testing.assert_allclose(np.sort(loads.factors), np.array([-1, 1]) * 4.0125993436 * np.sqrt(0.7), rtol=1e-5)


def test_a_right_angle_frame_buckles_sideways() -> None:
    """Legs 240, section 30 × 0.6 (Argyris 1979): 1.08751795 one way, 0.68042741 the other (validation 3.3)."""
    E, nu, b, h = 71240.0, 0.31, 0.6, 30.0
    G, A = E / (2 * (1 + nu)), b * h
    thin = dx.Section.from_moduli(
        EA=E * A, GA1=G * A, GA2=G * A, EI1=E * b * h**3 / 12, EI2=E * h * b**3 / 12, GJ=G * 2.16
    )
    model = (
        dx.Model(name="right angle")
        .rod(dx.line((0, 0, 0), (240, 0, 0), d1=(0, 0, 1)), thin, name="one", ends=("a", "c"), elements=16)
        .rod(dx.line((240, 0, 0), (240, -240, 0), d1=(0, 0, 1)), thin, name="two", ends=("c", "b"), elements=16)
        .clamp("a")
        .force("b", (1, 0, 0))
    )
    factors = np.sort(dx.buckling(model, count=2).factors)
    np.testing.assert_allclose(np.sort(np.abs(factors)), [0.68042741, 1.08751795], rtol=3e-3)
    assert factors[0] < 0.0 < factors[1]


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
