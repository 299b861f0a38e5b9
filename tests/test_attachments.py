"""Springs, dashpots, cables, masses and rigid bodies: exact work, known motions, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx
from directrix.formulations.attached import AttachedLayout, BodyElement, LinkElement
from directrix.formulations.conformance import check_formulation
from directrix.scheme import Rates

SECTION = dx.Section.from_moduli(EA=2500, GA1=950, GA2=900, EI1=10, EI2=12, GJ=8, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)
INERTIA = np.array([[0.3, 0.02, 0.0], [0.02, 0.2, 0.01], [0.0, 0.01, 0.25]])
LINK = np.array([0.1, 0.2, -0.1, 0.0, 0.3, 0.2, 5.0, 0.7, 0.4, 0.05])
BODY = np.array([2.0, 0.5, 0.1, 0.0, 0.4, 0.05, 0.6])


def two_rods(order: int = 1) -> dx.Model:
    model = dx.Model(name="two rods").rod(
        dx.line((0, 0, 0), (2, 0, 0)), SECTION, name="one", ends=("a", "b"), elements=3, order=order
    )
    return model.rod(dx.line((3, 0, 1), (5, 1, 1)), SECTION, name="two", ends=("c", "d"), elements=3, order=order)


def machine(order: int = 1, damping: float = 0.0) -> dx.Model:
    """Two rods that only links join, with bodies, in free flight."""
    return (
        two_rods(order)
        .spring("b", "c", 50.0, damping=damping, offset_b=(0, 0, 0.2), name="spring")
        .cable("a", "d", 30.0, length=4.8, width=0.05, name="cable")
        .rigid_body("b", 1.0, INERTIA)
        .point_mass("d", 2.0)
        .velocity("a", (0, 1, 0.5))
        .velocity("c", (0, 0, -2), omega=(0, 1, 0))
    )


@pytest.mark.parametrize("rates", [Rates.NONE, Rates.MIDPOINT, Rates.ALPHA], ids=lambda r: r.name)
@pytest.mark.parametrize("cable", [False, True], ids=["spring", "cable"])
@pytest.mark.parametrize("nn", [1, 2])
def test_a_link_is_an_element_like_any_other(nn: int, cable: bool, rates: Rates) -> None:
    """Tangent of the machine code, work of the energy, no net force between two nodes."""
    layout = AttachedLayout(nn, 0, True, parameters=len(LINK))
    parameters = LINK.copy()
    static = rates is not Rates.MIDPOINT
    parameters[8] = 0.0  # a dashpot's work is not that of the energy
    found = check_formulation(LinkElement(rates, cable), layout, static=static, largest=3.0, parameters=parameters)
    assert found.tangent <= 1e-10 and found.work <= 1e-12
    if nn == 2:
        assert found.objectivity <= 1e-12 and found.rigid_motion <= 1e-12
    damped = check_formulation(LinkElement(rates, cable), layout, static=static, states=1, parameters=LINK)
    assert damped.tangent <= 1e-10


@pytest.mark.parametrize("rates", [Rates.MIDPOINT, Rates.ALPHA], ids=lambda r: r.name)
def test_the_tangent_of_a_body(rates: Rates) -> None:
    layout = AttachedLayout(1, 0, True, parameters=len(BODY))
    assert check_formulation(BodyElement(rates), layout, static=False, states=1, parameters=BODY).tangent <= 1e-10


@pytest.mark.parametrize(
    "integrator", [dx.EnergyMomentum(), dx.EnergyDissipating(0.3), dx.EnergyDissipating(0.2, 0.2)], ids=repr
)
@pytest.mark.parametrize("order", [1, 2])
def test_the_ledger_closes_with_what_is_attached(integrator, order: int) -> None:
    for model in (machine(order), machine(order, 0.3), machine(order, 0.3).spring("d", (6, 1, 3), 12.0, damping=0.1)):
        result = dx.simulate(model, t_end=5.0, dt=0.05, integrator=integrator)
        assert result.success
        assert all(entry.claimed and entry.value <= 1e-12 for entry in result.audit.entries)


@pytest.mark.parametrize("steps", [1000, pytest.param(10_000, marks=pytest.mark.slow)])
def test_many_steps_of_a_machine(steps: int) -> None:
    result = dx.simulate(machine(), t_end=0.05 * steps, dt=0.05, save_every=100)
    assert result.success
    assert all(entry.value <= 1e-11 for entry in result.audit.entries)


def test_schemes_agree_on_a_machine_as_the_step_shrinks() -> None:
    ends = [
        dx.simulate(machine(), 0.5, 0.5 / 1024, integrator=i).r[-1]
        for i in (dx.EnergyMomentum(), dx.Newmark(), dx.GeneralizedAlpha(0.8))
    ]
    assert np.abs(ends[1] - ends[0]).max() <= 1e-5 and np.abs(ends[2] - ends[0]).max() <= 1e-5


def stiff_light_rod() -> dx.Model:
    """A rod that is next to nothing beside what hangs on it."""
    section = dx.Section.from_moduli(
        EA=1e4, GA1=1e4, GA2=1e4, EI1=1e3, EI2=1e3, GJ=1e3, A_rho=1e-6, I_rho1=1e-8, I_rho2=1e-8
    )
    return dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), section, name="rod", ends=("a", "b"), elements=1, order=1)


def test_a_mass_on_a_spring_oscillates_with_its_period() -> None:
    """T = 2π √(m/k), released from rest, along the spring; the ledger takes the ground in."""
    k, m = 40.0, 2.0
    model = stiff_light_rod().fix("a", "y", "z", "rx", "ry", "rz").point_mass("a", m)
    model = model.spring("a", (-2, 0, 0), k, length=1.9, name="spring")
    period = 2.0 * np.pi * np.sqrt(m / k)
    result = dx.simulate(model, t_end=period, dt=period / 400)
    u = result.node("a").displacement[:, 0]
    assert u.min() == pytest.approx(-0.2, rel=1e-3) and abs(u[-1]) <= 1e-4
    tension = result.link("spring").tension
    np.testing.assert_allclose(tension, k * (0.1 + u), atol=1e-10)


def test_a_dashpot_takes_what_its_formula_says() -> None:
    c, dt = 3.0, 0.01
    model = two_rods().dashpot("b", "c", c, name="dashpot").velocity("b", (1, 0, 0))
    result = dx.simulate(model, t_end=1.0, dt=dt)
    taken = np.cumsum(c * np.diff(result.link("dashpot").length) ** 2 / dt)
    np.testing.assert_allclose(result.energy.dissipated[1:], taken, rtol=1e-9)


def test_a_free_rigid_body_turns_as_euler_says() -> None:
    """Spin about the middle axis tips over; energy and spin momentum stay, and a fine step meets Euler's equations."""
    from scipy.integrate import solve_ivp

    J = np.diag([1.0, 2.0, 2.8])
    omega0 = np.array([1e-2, 2.0, 1e-2])
    model = stiff_light_rod().rigid_body("a", 1.0, J).velocity("a", (0, 0, 0), omega=omega0)
    model = model.velocity("b", np.cross(omega0, (1, 0, 0)), omega=omega0)
    result = dx.simulate(model, t_end=6.0, dt=0.002, save_every=100)
    euler = solve_ivp(lambda _, w: np.linalg.solve(J, np.cross(J @ w, w)), (0, 6), omega0, rtol=1e-10, atol=1e-12)
    R, rate = result.R[-1, 0], result.Rdot[-1, 0]
    skew = R.T @ rate
    omega = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    assert np.abs(omega0[1] - omega[1]) > 0.5  # it has tipped
    np.testing.assert_allclose(omega, euler.y[:, -1], atol=2e-2)
    assert result.audit.passed, result.audit


def test_statics_with_springs_and_cables() -> None:
    """A cantilever held up by a spring: balance of forces and moments, with the ground; the cable goes slack."""
    model = (
        two_rods()
        .clamp("a")
        .clamp("d")
        .spring("b", (2, 0, 3), 20.0, name="spring")
        .cable("b", "c", 1e3, length=2.5, name="slack")
        .force("b", (0, 0, -6))
    )
    result = dx.solve_static(model)
    assert result.success and result.audit.passed
    spring = result.link("spring")
    assert spring.tension[-1] == pytest.approx(20.0 * (spring.length[-1] - 3.0))
    assert 0.0 <= result.link("slack").tension[-1] < 1e-2


def test_links_survive_saving(tmp_path) -> None:
    result = dx.simulate(machine(), 1.0, 0.05)
    loaded = dx.load(result.save(tmp_path / "machine.vtkhdf"))
    assert list(loaded.links) == ["spring", "cable"]
    np.testing.assert_array_equal(loaded.link("cable").tension, result.link("cable").tension)


def test_an_early_force_free_link_far_from_the_origin() -> None:
    """A machine that flies away and one on the ground: positions are measured from a point that goes along only
    where nothing is tied to the ground."""
    free = dx.simulate(machine().rigid_velocity((50, 0, 0)), t_end=5.0, dt=0.05)
    tied = dx.simulate(machine().spring("a", (0, 0, 1), 1.0).rigid_velocity((5, 0, 0)), t_end=5.0, dt=0.05)
    assert free.audit.passed and tied.audit.passed


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: two_rods().spring("b", "z", 1.0).check(), "no node 'z' for the link 'link1'"),
        (lambda: two_rods().spring("b", "b", 1.0), "joins node 'b' to itself"),
        (lambda: two_rods().spring("b", "c", -1.0), "stiffness"),
        (lambda: two_rods().spring("b", "c", 0.0), "neither stiffness nor damping"),
        (lambda: two_rods().spring("b", (0, 0), 1.0), "three numbers"),
        (lambda: two_rods().spring("b", "c", 1.0, name="x").cable("b", "c", 1.0, name="x"), "two links called 'x'"),
        (lambda: two_rods().cable("b", "c", 1.0, width=0.0), "width"),
        (lambda: two_rods().point_mass("b", 0.0), "mass"),
        (lambda: two_rods().point_mass("z", 1.0).check(), "no node 'z' for the body"),
        (lambda: two_rods().point_mass("b", 1.0).point_mass("b", 1.0), "two bodies"),
        (lambda: two_rods().rigid_body("b", 1.0, np.diag([1.0, 1.0, 3.0])), "exceeds the sum"),
        (lambda: two_rods().rigid_body("b", 1.0, [[1, 2], [3, 4]]), "3×3"),
        (lambda: dx.simulate(machine(damping=1.0), 1.0, 0.1, integrator=dx.Newmark()), "link 'spring' is damped"),
        (lambda: dx.simulate(machine(), 1.0, 0.1, integrator=dx.SimoTarnowDoblare()), "body on node 'b'"),
        (lambda: dx.simulate(machine(), 1.0, 0.1).link("x"), "no link 'x'"),
    ],
)
def test_what_cannot_be_attached_is_refused(make, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        make()
    assert error.value.fix
