"""Time steps: order, what each keeps and what it does not, what goes together and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import directrix as dx
from directrix.integrators.conformance import check_integrator

MODULI = dict(EA=2500.0, GA1=950.0, GA2=900.0, EI1=10.0, EI2=12.0, GJ=8.0, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)
DISSIPATIVE = [dx.EnergyDissipating(0.5), dx.EnergyDissipating(0.0, 0.2), dx.EnergyDissipating(0.3, 0.2)]
ALL = [
    dx.EnergyMomentum(), dx.Midpoint(), *DISSIPATIVE, dx.SimoTarnowDoblare(), dx.Newmark(), dx.GeneralizedAlpha(0.8),
    dx.HilberHughesTaylor(0.1),
]  # fmt: skip


def rod(order: int = 1, elements: int = 6, damping: float = 0.0) -> dx.Model:
    section = dx.Section.from_moduli(**MODULI, damping=damping)
    axis = dx.line((0, 0, 0), (3, 0, 0))
    return dx.Model(name="rod").rod(axis, section, name="rod", ends=("a", "b"), elements=elements, order=order)


def bent(order: int = 1, damping: float = 0.0) -> dx.Model:
    """Three rods on one node: corners, and no chain."""
    model = rod(order, 4, damping)
    section = model.rods[0].section
    model = model.rod(dx.line((3, 0, 0), (3, 2, 0)), section, name="up", ends=("b", "c"), elements=3, order=order)
    return model.rod(dx.line((3, 0, 0), (3, 0, 2)), section, name="out", ends=("b", "d"), elements=3, order=order)


@pytest.mark.parametrize("integrator", ALL, ids=repr)
def test_every_integrator_keeps_what_it_claims_and_only_that(integrator) -> None:
    found = check_integrator(integrator)
    assert integrator.order == (1 if integrator in DISSIPATIVE else 2)
    assert abs(found.order - integrator.order) <= 0.05
    for law, claimed, deviation in found.laws:
        if claimed:
            assert deviation <= 1e-11, law
        elif law != "linear momentum":  # the α family keeps it while nothing acts
            assert deviation >= 1e-4, f"{law} is not claimed and yet kept: claim it"


@pytest.mark.parametrize("integrator", ALL, ids=repr)
@pytest.mark.parametrize("order", [1, 2, pytest.param(3, marks=pytest.mark.slow)])  # compiling is what takes long
def test_the_ledger_of_a_driven_frame(integrator, order: int) -> None:
    """Loads that keep and that change their direction, a support that moves, corners: every order, every scheme."""
    model = (
        bent(order)
        .prescribe("a", displacement=lambda t: (0.1 * t, 0, 0), rotation=lambda t: (0, 0, 0.2 * t))
        .force("c", (0, 0.5, 1.0), follower=True)
        .moment("d", (0.3, 0.0, 0.2), follower=True)
        .force("d", lambda t: (0.0, np.sin(3.0 * t), 0.0))
        .gravity((0, 0, -1))
    )
    result = dx.simulate(model, t_end=1.0, dt=0.05, integrator=integrator)
    assert result.success and result.info["solver"] == "sparse"
    for entry in result.audit.entries:
        assert not entry.claimed or entry.value <= 1e-11, entry.law


@pytest.mark.parametrize("integrator", [dx.EnergyMomentum(), dx.Newmark()], ids=repr)
def test_loads_that_turn_have_their_tangent(integrator) -> None:
    """At half a step and at its end: a strong follower costs no more iterations than a strong load that does not."""
    model = rod(2, 4).clamp("a")
    still, turning = (
        model.force("b", (0, 8.0, 4.0), follower=f).moment("b", (2.0, 1.0, 4.0), follower=f) for f in (False, True)
    )
    counts = [dx.simulate(m, 1.0, 0.1, integrator=integrator).iterations.sum() for m in (still, turning)]
    assert counts[1] <= 1.1 * counts[0]


def test_schemes_agree_as_the_step_shrinks() -> None:
    model = rod(2, 4).clamp("a").force("b", (0, 1.0, 0.5)).moment("b", (0.4, 0, 0))
    exact = dx.simulate(model, t_end=0.5, dt=0.5 / 1024).r[-1]
    for integrator in ALL:
        lumped = getattr(integrator, "chi_velocity", 0.0) > 0.0  # another mass matrix: another semi-discrete solution
        result = dx.simulate(model, t_end=0.5, dt=0.5 / 1024, integrator=integrator)
        scale = np.abs(exact - result.mesh.r0).max()
        # Gauss points that carry rotations are another discretisation in space as well
        near = 1e-4 if isinstance(integrator, (dx.Midpoint, dx.EnergyMomentum)) else 2e-3
        near = 2e-2 if lumped or isinstance(integrator, (dx.SimoTarnowDoblare, dx.EnergyDissipating)) else near
        assert np.abs(result.r[-1] - exact).max() <= near * scale, integrator


def test_no_dissipation_is_energy_momentum() -> None:
    model = rod().velocity("b", (0, 1, 2))
    one, two = (dx.simulate(model, 1.0, 0.05, integrator=i) for i in (dx.EnergyMomentum(), dx.EnergyDissipating(0, 0)))
    np.testing.assert_allclose(two.r, one.r, rtol=0, atol=1e-13)


@pytest.mark.parametrize("integrator", DISSIPATIVE, ids=repr)
def test_a_spinning_rod_is_left_alone(integrator) -> None:
    """Relative equilibrium: strains and speeds stay, so nothing is dissipated."""
    model = rod().rigid_velocity(omega=(4.0, 0, 0))
    result = dx.simulate(model, t_end=20.0, dt=0.1, integrator=integrator)
    assert np.abs(result.energy.total - result.energy.total[0]).max() <= 1e-12 * result.energy.total[0]


@pytest.mark.parametrize("integrator", [i for i in DISSIPATIVE if i.chi_stress], ids=repr)
def test_a_turning_rod_comes_to_a_steady_state_and_keeps_it(integrator) -> None:
    """Stretched by its rotation; vibrations die out, momentum stays, and then the energy does."""
    model = rod().rigid_velocity(omega=(0, 0, 3.0), about=(1.5, 0, 0))
    result = dx.simulate(model, t_end=200.0, dt=0.05, integrator=integrator)
    assert result.audit.passed
    energy, spin = result.energy.total, result.momentum.angular[:, 2]
    assert np.ptp(spin) <= 1e-11 * spin[0]
    assert energy[0] - energy[-1] > 1e-3 * energy[0]
    assert np.ptp(energy[-200:]) <= 1e-9 * energy[0] and energy[-1] > 0.5 * energy[0]


def random_model(seed: int) -> dx.Model:
    """A frame with random sections, shape and velocities."""
    rng = np.random.default_rng(seed)
    moduli = {k: v * 10.0 ** rng.uniform(-0.5, 0.5) for k, v in MODULI.items()}
    section = dx.Section.from_moduli(**moduli, damping=rng.choice([0.0, 0.01]))
    corner = np.array([2.0, 0, 0])
    order = int(rng.integers(1, 3))
    model = dx.Model(name=f"random {seed}").rod(
        dx.line((0, 0, 0), corner), section, name="one", ends=("a", "b"), elements=3, order=order
    )
    model = model.rod(
        dx.line(corner, corner + rng.standard_normal(3)), section, name="two", ends=("b", "c"), elements=3, order=order
    )
    for node in "abc":
        model = model.velocity(node, 0.5 * rng.standard_normal(3))
    return model


def decays(seed: int, steps: int) -> None:
    rng = np.random.default_rng(seed)
    integrator = dx.EnergyDissipating(*rng.uniform(0.0, [1.0, 0.2]))
    result = dx.simulate(random_model(seed), t_end=0.05 * steps, dt=0.05, integrator=integrator)
    assert result.success, result.status
    energy, spin = result.energy.total, result.momentum.angular
    assert np.diff(energy).max() <= 1e-13 * energy[0]
    assert np.abs(result.energy.residual).max() <= 1e-11 * energy[0]
    assert np.abs(spin - spin[0]).max() <= 1e-11 * max(np.abs(spin).max(), 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_dissipative_steps_never_give_energy(seed: int) -> None:
    decays(seed, 500)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(50))
def test_dissipative_steps_never_give_energy_in_ten_thousand_steps(seed: int) -> None:
    decays(seed, 10_000)


def test_kelvin_voigt_takes_what_its_formula_says() -> None:
    """Σ Δε·C_v Δε/Δt over steps and stress points, booked step by step."""
    eta, dt = 0.02, 0.05
    result = dx.simulate(rod(damping=eta).clamp("a").velocity("b", (0, 1, 2)), t_end=2.0, dt=dt)
    stiffness = np.array([MODULI[k] for k in ("GA1", "GA2", "EA", "EI1", "EI2", "GJ")])
    change = np.diff(result.strain, axis=0)
    length = 3.0 / 6
    taken = np.cumsum((change**2 * eta * stiffness).sum(axis=(1, 2)) * length / dt)
    np.testing.assert_allclose(result.energy.dissipated[1:], taken, rtol=1e-10)
    assert result.audit.passed and taken[-1] > 0.1 * result.energy.total[0]


def test_kelvin_voigt_damps_an_axial_vibration_as_it_should() -> None:
    """u'' = −ω² (u + η u'): the first axial mode decays with ½ η ω²."""
    eta, length = 0.01, 3.0
    model = rod(2, 8, eta).fix("a", "x", "y", "z", "rx", "ry", "rz").velocity("b", (1e-3, 0, 0))
    result = dx.simulate(model, t_end=8.0, dt=0.002)
    omega = 0.5 * np.pi / length * np.sqrt(MODULI["EA"] / MODULI["A_rho"])
    late = result.t > 4.0  # by now the higher modes, which decay with ω², are gone
    rate = -np.polyfit(result.t[late], np.log(result.energy.total[late]), 1)[0]
    assert abs(rate - eta * omega**2) <= 2e-3 * rate


def test_newmark_starts_from_balanced_accelerations() -> None:
    """A heavy rod that is let go: the first step of a scheme with accelerations knows g."""
    model = rod().gravity((0, 0, -9.81))
    result = dx.simulate(model, t_end=0.1, dt=0.05, integrator=dx.Newmark())
    np.testing.assert_allclose(result.node("a").displacement[:, 2], -0.5 * 9.81 * result.t**2, atol=1e-12)
    assert result.history.shape[1:] == (7, 12)


@pytest.mark.parametrize("integrator", [dx.GeneralizedAlpha(0.6), dx.SimoTarnowDoblare(), *DISSIPATIVE], ids=repr)
def test_going_on_is_the_same_motion(integrator, tmp_path) -> None:
    model = bent(2).velocity("c", (0, 0, 1)).clamp("a")
    whole = dx.simulate(model, 1.0, 0.05, integrator=integrator)
    half = dx.simulate(model, 0.5, 0.05, integrator=integrator)
    stored = dx.load(half.save(tmp_path / "half.vtkhdf"))
    rest = dx.simulate(model, 1.0, 0.05, integrator=integrator, start=stored)
    np.testing.assert_allclose(rest.r[-1], whole.r[-1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(rest.v[-1], whole.v[-1], rtol=0, atol=1e-10)


def test_pairs_that_cannot_work_are_refused_with_the_reason() -> None:
    cases = [
        (lambda: dx.simulate(rod(), 1, 0.1, formulation=dx.SimoVuQuoc()), "quadratic in the nodal unknowns"),
        (lambda: dx.simulate(rod(), 1, 0.1, formulation=dx.CrisfieldJelenic()), "quadratic in the nodal unknowns"),
        (
            lambda: dx.simulate(rod(), 1, 0.1, integrator=dx.SimoTarnowDoblare(), formulation=dx.Directors()),
            "carries rotations at the Gauss points",
        ),
        (lambda: dx.simulate(rod(damping=0.1), 1, 0.1, integrator=dx.Newmark()), "rod 'rod' is damped"),
        (lambda: dx.EnergyDissipating(chi_velocity=0.4), "several velocities"),
        (lambda: dx.EnergyDissipating(chi_stress=-1), "chi_stress"),
        (lambda: dx.GeneralizedAlpha(1.5), "rho_inf"),
        (lambda: dx.HilberHughesTaylor(0.5), "alpha"),
        (lambda: dx.Newmark(beta=0.0), "beta"),
        (lambda: dx.solve_static(rod(3).clamp("a"), formulation=dx.CrisfieldJelenic()), "order 3"),
        (lambda: dx.solve_static(rod().clamp("a"), formulation="rods"), "not a formulation"),
        (
            lambda: dx.solve_static(rod().clamp("a"), control=dx.ArcLength(ds=0.1), formulation=dx.SimoVuQuoc()),
            "where its step began",
        ),
    ]
    for make, reason in cases:
        with pytest.raises(dx.ModelError, match=reason) as error:
            make()
        assert error.value.fix


def test_a_start_without_history_is_refused() -> None:
    model = rod().clamp("a").force("b", (0, 1, 0))
    plain = dx.solve_static(model)
    with pytest.raises(dx.ModelError, match="another formulation"):
        dx.solve_static(model, formulation=dx.SimoVuQuoc(), start=plain)
    carried = dx.solve_static(model, formulation=dx.SimoVuQuoc())
    again = dx.solve_static(model, steps=1, formulation=dx.SimoVuQuoc(), start=replace(carried))
    assert again.success
