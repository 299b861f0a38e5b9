"""Sections given by a stored energy: derived stress and tangent, exact energy, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx
from directrix.formulations.directors import discrete_gradient
from directrix.formulations.layout import Layout
from directrix.laws import Law, stiffening_bending, tension_only

MODULI = dict(EA=2500.0, GA1=950.0, GA2=900.0, EI1=10.0, EI2=12.0, GJ=8.0)
MASS = dict(A_rho=2.5, I_rho=np.diag([0.012, 0.01]))


def linear(e):
    return 0.5 * sum(k * x**2 for k, x in zip((950.0, 900.0, 2500.0, 10.0, 12.0, 8.0), e, strict=True))


def hardening(e):
    """A user's own: coupled, not symmetric in its signs, with powers, a root and tanh."""
    bend = np.sqrt(1.0 + e[3] ** 2 + e[4] ** 2) - 1.0
    return linear(e) + 4.0 * bend**2 + 300.0 * np.tanh(e[2]) ** 2 * e[3] + 5.0 * e[5] ** 4


LAWS = {
    "stiffening": stiffening_bending(**MODULI, onset=0.8),
    "tension only": tension_only(**MODULI, width=0.01),
    "hardening": hardening,
}


def flying(energy, order: int = 1) -> dx.Model:
    section = dx.Section.hyperelastic(energy, **MASS)
    return (
        dx.Model(name="flying")
        .rod(dx.line((0, 0, 0), (3, 0, 1)), section, name="rod", ends=("a", "b"), elements=5, order=order)
        .velocity("a", (0.3, 1.0, -2.0), omega=(1.0, 0.5, 2.0))
        .velocity("b", (0.0, -1.0, 1.0))
    )


@pytest.mark.parametrize("name", LAWS)
def test_stress_and_stiffness_are_the_derivatives_of_the_energy(name: str) -> None:
    law, rng, h = Law.record(LAWS[name]), np.random.default_rng(0), 1e-30
    for e in 0.3 * rng.standard_normal((20, 6)):
        slope = [np.imag(law.energy((e + 1j * h * d).tolist())) / h for d in np.eye(6)]
        np.testing.assert_allclose(law.stress(e.tolist()), slope, rtol=1e-12, atol=1e-12)
    columns = [np.imag(law.stress((1j * h * d).tolist())) / h for d in np.eye(6)]
    np.testing.assert_allclose(law.hessian, np.array(columns, float).T, atol=1e-10)


def test_forces_of_a_result_follow_the_law() -> None:
    result = dx.simulate(flying(LAWS["hardening"]), 1.0, 0.05)
    law = Law.record(LAWS["hardening"])
    np.testing.assert_allclose(result.force[-1, 2], law.stress(result.strain[-1, 2].tolist()), rtol=1e-12)
    stored = sum(law.energy(e.tolist()) for e in result.strain[-1]) * np.sqrt(10.0) / 5
    assert abs(stored - result.energy.stored[-1]) <= 1e-12 * stored


@pytest.mark.parametrize("steps", [2000, pytest.param(10_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", LAWS)
def test_a_long_free_flight_keeps_its_energy(name: str, steps: int) -> None:
    result = dx.simulate(flying(LAWS[name]), t_end=0.05 * steps, dt=0.05, save_every=100)
    assert result.success, result.status
    assert np.abs(result.energy.residual).max() <= 1e-10 * result.energy.total[0]
    spin = result.momentum.angular
    assert np.abs(spin - spin[0]).max() <= 1e-10 * np.abs(spin[0]).max()


def test_without_the_discrete_gradient_the_energy_is_not_kept() -> None:
    """The control: the same law under the classical midpoint rule."""
    result = dx.simulate(flying(LAWS["stiffening"]), t_end=5.0, dt=0.05, integrator=dx.Midpoint())
    assert np.abs(result.energy.residual).max() >= 1e-4 * result.energy.total[0]


def test_a_quadratic_energy_is_the_linear_section() -> None:
    plain = dx.Section.from_moduli(**MODULI, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)
    law = dx.Section.hyperelastic(linear, **MASS)
    np.testing.assert_allclose(law.stiffness, plain.stiffness, rtol=1e-14)
    one, two = flying(linear), flying(linear)
    two = dx.Model().rod(one.rods[0].curve, plain, name="rod", ends=("a", "b"), elements=5, order=1)
    for given in one.velocities:
        two = two.velocity(given.node, given.v, given.omega)
    paths = [dx.simulate(m, 1.0, 0.05).r for m in (one, two)]
    np.testing.assert_allclose(*paths, rtol=0, atol=1e-9)
    held = [m.clamp("a").force("b", (0, 3.0, 1.0)) for m in (static(law), static(plain))]
    paths = [dx.solve_static(m).r[-1] for m in held]
    np.testing.assert_allclose(*paths, rtol=0, atol=1e-9)


def static(section: dx.Section) -> dx.Model:
    return dx.Model().rod(dx.line((0, 0, 0), (3, 0, 1)), section, name="rod", ends=("a", "b"), elements=5)


@pytest.mark.parametrize("name", LAWS)
def test_the_discrete_gradient_goes_over_into_the_stress(name: str) -> None:
    """Δε → 0: no jump, no 0/0, and S*·Δε = ΔW to round-off at every size on the way."""
    law, rng = Law.record(LAWS[name]), np.random.default_rng(3)
    layout = Layout(2, 1, True, law=law)
    for _ in range(20):
        e, d = 0.2 * rng.standard_normal(6), rng.standard_normal(6)
        at = np.array(law.stress(e.tolist()))
        for size in 10.0 ** -np.arange(0, 17):
            end = e + size * 0.1 * d
            s = np.array(discrete_gradient(layout, e.tolist(), end.tolist()))
            change = law.energy(end.tolist()) - law.energy(e.tolist())
            scale = abs(law.energy(e.tolist())) + abs(law.energy(end.tolist()))
            assert abs(s @ (end - e) - change) <= 1e-14 * scale
        assert np.abs(s - at).max() <= 1e-10 * np.abs(at).max()
    nothing = discrete_gradient(layout, [0.0] * 6, [0.0] * 6)
    np.testing.assert_allclose(nothing, law.stress([0.0] * 6), atol=1e-300)


def test_a_cable_carries_no_compression() -> None:
    """Pushed together it folds away under its own small bending stiffness instead of pushing back."""
    section = dx.Section.hyperelastic(tension_only(**MODULI, width=1e-3))
    pull, push = (
        dx.solve_static(static(section).clamp("a").prescribe("b", displacement=d, rotation=(0, 0, 0)), steps=5)
        for d in ((0.3, 0, 0.1), (-0.3, 0, -0.1))
    )
    assert pull.success and push.success
    assert pull.rod("rod").force[-1, 0, 2] == pytest.approx(250.0, rel=1e-3)
    assert 0.0 < push.rod("rod").force[-1, 0, 2] < 1e-2


@pytest.mark.parametrize(
    ("energy", "names"),
    [
        (lambda e: e[0] if e[0] > 0 else 0.0, "cannot be recorded"),
        (lambda e: abs(e[0]), "cannot be recorded"),
        (lambda e: 1.0, "does not depend on the strains"),
        (lambda e: None, "does not depend on the strains"),
        (lambda e: np.log(e[2]), "not finite at no strain"),
        (lambda e: e[6], "cannot be recorded"),
        (lambda e: linear(e) - 2000.0 * e[2] ** 2, "not positive definite"),
        (lambda e: e[2] ** 4 + linear(e) * 0.0, "not positive definite"),
    ],
)
def test_energies_that_cannot_be_are_refused(energy, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        dx.Section.hyperelastic(energy)
    assert error.value.fix


def test_a_law_without_stiffness_at_rest_takes_a_metric() -> None:
    def quartic(e):
        return linear([*e[:3], 0.0, 0.0, e[5]]) + 50.0 * (e[3] ** 2 + e[4] ** 2) ** 2

    section = dx.Section.hyperelastic(quartic, **MASS, metric=np.diag([950.0, 900.0, 2500.0, 10.0, 10.0, 8.0]))
    model = dx.Model().rod(dx.line((0, 0, 0), (3, 0, 1)), section, ends=("a", "b"), elements=5, order=1)
    result = dx.simulate(model.velocity("a", (0, 1, 0)), t_end=20.0, dt=0.05)
    assert result.success and np.abs(result.energy.residual).max() <= 1e-11 * result.energy.total[0]


def test_equal_laws_are_equal_sections() -> None:
    one, two = (dx.Section.hyperelastic(stiffening_bending(**MODULI, onset=o)) for o in (0.8, 0.9))
    again = dx.Section.hyperelastic(stiffening_bending(**MODULI, onset=0.8))
    assert one == again and hash(one) == hash(again) and one != two
    # kernels are kept by the record: laws of one stiffness are told apart by what they are beyond it
    quartic, sextic = (Law.record(lambda e, n=n: linear(e) + e[3] ** n) for n in (4, 6))
    np.testing.assert_array_equal(quartic.hessian, sextic.hessian)
    assert quartic != sextic and quartic == Law.record(lambda e: linear(e) + e[3] ** 4)
