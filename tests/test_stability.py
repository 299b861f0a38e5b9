"""Vibration and buckling: what defines them; published values are in the validation suite."""

from __future__ import annotations

from pathlib import Path

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


def corner(EA: float = 1e4) -> dx.Model:
    """Two rods at a right angle, free."""
    s = section(EA=EA, GA1=EA, GA2=EA, I_rho1=1e-4, I_rho2=1e-4)
    model = dx.Model(name="corner").rod(dx.line((0, 0, 0), (1, 0, 0)), s, name="one", ends=("a", "b"), elements=6)
    return model.rod(dx.line((1, 0, 0), (1, 1, 0)), s, name="two", ends=("b", "c"), elements=6)


def test_shapes_solve_the_eigenproblem_and_rigid_motions_are_zeros() -> None:
    from directrix.equilibrium import Linearised

    found, system = dx.modes(corner(), count=12), Linearised(corner(), None, dynamic=True)
    K, M = system.stiffness(), system.mass
    vectors = found.shapes.reshape(12, -1)[:, system.free].T
    assert np.array_equal(found.squares[:6], np.zeros(6)) and found.squares[6] > 1.0
    np.testing.assert_allclose(vectors.T @ (M @ vectors), np.eye(12), atol=1e-9)
    for square, v in zip(found.squares.tolist(), vectors.T, strict=True):
        size = np.linalg.norm(M @ v) * max(square, found.squares[6])
        assert np.linalg.norm(K @ v - square * (M @ v)) <= 1e-9 * size
    np.testing.assert_allclose(found.participation[:6].sum(axis=0), 1.0, rtol=1e-9)
    assert np.abs(found.participation[6:]).max() < 1e-12
    pinned = dx.modes(corner().pin("b"), count=4).squares
    assert np.array_equal(pinned[:3], np.zeros(3)) and pinned[3] > 1.0


def test_every_unstable_motion_is_found() -> None:
    """A column far beyond its third buckling load: the lowest ω² first, as many negative ones as pivots."""
    model = rod(EA=1e5, GA1=1e5, GA2=1e5, elements=16, EI2=50.0).clamp("a")
    pushed = dx.solve_static(model.force("b", (-70.0, 0, 0)), steps=2, stability=True)
    found = dx.modes(model, about=pushed, count=4)
    assert pushed.stability is not None and not found.stable
    assert int(np.sum(found.squares < 0.0)) == pushed.stability.negative[-1] >= 3


def test_damping_ratios() -> None:
    """Stiffness-proportional damping η: ζ = ½ η ω; a dashpot beside a spring: ζ = c/(2 √(k m))."""
    eta = 2e-3
    damped = dx.Model(name="damped").rod(
        dx.line((0, 0, 0), (1, 0, 0)), section().damped(eta * section().stiffness), ends=("a", "b"), elements=8
    )
    found = dx.modes(damped.clamp("a"), count=4)
    np.testing.assert_allclose(found.damping_ratios, 0.5 * eta * np.abs(found.eigenvalues), rtol=1e-6)
    assert found.stable and np.all(found.eigenvalues.real < 0.0)
    model = rod(1, 1, A_rho=1e-9, I_rho1=1e-9, I_rho2=1e-9, EI1=1e6, EI2=1e6, GJ=1e6)
    model = model.fix("a", "y", "z", "rx", "ry", "rz").point_mass("b", 3.0).spring("a", (-1, 0, 0), 12.0, damping=1.2)
    assert dx.modes(model, count=1).damping_ratios[0] == pytest.approx(0.1, rel=1e-5)


def test_a_shaft_that_turns_about_its_axis_splits_its_frequencies() -> None:
    """Seen from the turning frame a round shaft bends at |ω ± Ω|: gyroscopic and centrifugal terms together."""
    shaft, omega, spin = rod(elements=10).clamp("a"), 3.51602, 1.5
    found = dx.modes(shaft, count=2, spin=(spin, 0, 0))
    np.testing.assert_allclose(2.0 * np.pi * found.frequencies, [omega - spin, omega + spin], rtol=1e-4)
    assert np.iscomplexobj(found.shapes)
    weighted = rod(elements=10).clamp("a").rigid_body("b", 2.0, np.diag([0.0, 0.0, 0.0]))
    still = 2.0 * np.pi * dx.modes(weighted, count=1).frequencies[0]
    turned = 2.0 * np.pi * dx.modes(weighted, count=2, spin=(0.5, 0, 0)).frequencies
    np.testing.assert_allclose(turned, [still - 0.5, still + 0.5], rtol=1e-6)


def test_a_turning_ring_is_as_wide_as_it_should_be() -> None:
    """λ = 1/(1 − A_ρ Ω² R²/EA) of a ring that turns about its axis: the steady state that modes are about."""
    s = section(EA=100.0, GA1=100.0, GA2=100.0, EI1=1e-2, EI2=1e-2, GJ=1e-2)
    half = dx.Model(name="ring").rod(dx.arc((1, 0, 0), (0, 1, 0), (-1, 0, 0)), s, ends=("a", "b"), elements=16)
    ring = half.rod(dx.arc((-1, 0, 0), (0, -1, 0), (1, 0, 0)), s, ends=("b", "a"), elements=16)
    ring = ring.fix("a", "y", "z", "rx", "ry", "rz").fix("b", "y", "z", "rx", "ry", "rz")
    found = dx.modes(ring, count=1, spin=(0, 0, 2.0))
    radius = np.linalg.norm(found.state[0], axis=1)
    np.testing.assert_allclose(radius, 1.0 / (1.0 - 4.0 / 100.0), rtol=1e-4)


def test_links_take_their_load_into_buckling() -> None:
    """A strut that is a spring, held aside by another one of stiffness k: it buckles at k ℓ."""
    strut = (
        dx.Model(name="strut")
        .rod(dx.line((0, 1, 0), (0.2, 1, 0)), section(), ends=("t", "u"), elements=1)
        .fix("t", "z", "rx", "ry", "rz")
        .fix("u", "z", "rx", "ry", "rz")
    )
    strut = strut.spring("t", (0, 0, 0), 1e5).spring("t", (-1, 1, 0), 3.0).force("t", (0, -1, 0))
    assert dx.buckling(strut, count=1).factors[0] == pytest.approx(3.0, rel=1e-3)


def test_a_mode_can_be_watched(tmp_path: Path) -> None:
    found = dx.modes(rod(elements=4).clamp("a"), count=2)
    swing = found.motion(2, amplitude=0.2)
    assert float(np.linalg.norm(swing.r - swing.mesh.r0, axis=2).max()) == pytest.approx(0.2)
    np.testing.assert_allclose(swing.r[0], swing.r[-1], atol=1e-12)
    assert swing.t[-1] == pytest.approx(1.0 / found.frequencies[1])
    page = Path(found.view(tmp_path / "mode.html", mode=1)).read_text()
    assert "mode 1" in page and "does not swing" not in page
    with pytest.raises(dx.ModelError, match="mode"):
        found.view(tmp_path / "mode.html", mode=3)


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
        (lambda: dx.modes(loaded, spin=(0, 0, 1.0)), "away from the axis"),
        (lambda: dx.modes(rod(), spin=(0, 0, 0)), "is none"),
    ]
    for make, reason in cases:
        with pytest.raises(dx.ModelError, match=reason) as error:
            make()
        assert error.value.fix
