"""Joints: what they hold and leave free, exact work and momenta, known motions, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx
from directrix.formulations.conformance import check_tangent
from directrix.formulations.joint import JointElement, JointLayout
from directrix.joints import KINDS, Joint
from directrix.rotations import exp
from directrix.scheme import Rates

SECTION = dx.Section.rectangle(0.1, 0.12, E=1e6, nu=0.3, rho=1000)
STIFF = dx.Section.rectangle(0.1, 0.12, E=1e9, nu=0.3, rho=1000)
PLACES = {"B": (1.0, 0.0, 0.0), "C": (1.1, 0.0, 0.0)}
AXES = {
    "hinge": {"axis": (0.0, 0.3, 1.0)},
    "universal": {"axes": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))},
    "cylindrical": {"axis": (1.0, 0.0, 0.0)},
    "slider": {"axis": (1.0, 0.2, 0.0)},
    "planar": {"normal": (0.0, 0.0, 1.0)},
}


def two_rods(section: dx.Section = SECTION) -> dx.Model:
    model = dx.Model(name="two rods").rod(
        dx.line((0, 0, 0), (1, 0, 0)), section, name="one", ends=("A", "B"), elements=2, order=1
    )
    return model.rod(dx.line((1.1, 0, 0), (1.1, 1, 0)), section, name="two", ends=("C", "D"), elements=2, order=1)


def joined(kind: str, section: dx.Section = SECTION, **options) -> dx.Model:
    return getattr(two_rods(section), kind)("B", "C", **AXES.get(kind, {}), name="joint", **options)


def pushed(model: dx.Model) -> dx.Model:
    """In flight, pushed at both ends for a while."""
    return (
        model.rigid_velocity((0.1, 0, 0), (0.3, 0.5, 2.0))
        .moment("D", lambda t: (2, 3, -1) if t < 0.2 else (0, 0, 0))
        .force("A", lambda t: (1, 5, 3) if t < 0.2 else (0, 0, 0))
    )


def apart(result: dx.Result, kind: str) -> float:
    """Largest violation of what a joint of this kind holds, in the saved states."""
    joint = Joint("joint", kind, "B", "C", **_plain(AXES.get(kind, {})))
    base, mover = joint.axes()
    mesh, worst = result.mesh, 0.0
    at = joint.place({name: mesh.r0[k] for name, k in mesh.node_names.items()})
    B, C = result.node("B"), result.node("C")
    pb = B.r + B.R @ (at - mesh.r0[mesh.node("B")])
    pc = C.r + C.R @ (at - mesh.r0[mesh.node("C")])
    held = KINDS[kind]
    if held.point:
        worst = float(np.abs(pc - pb).max())
    for k in held.along:
        worst = max(worst, float(np.abs(np.einsum("ti,ti->t", pc - pb, B.R @ base[k])).max()))
    for i, j in held.across:
        worst = max(worst, float(np.abs(np.einsum("ti,ti->t", B.R @ base[i], C.R @ mover[j])).max()))
    return worst


def _plain(axes: dict) -> dict:
    if "axes" in axes:
        return {"axis": axes["axes"][0], "second": axes["axes"][1]}
    return {"axis": next(iter(axes.values()))} if axes else {}


@pytest.mark.parametrize("rates", [Rates.NONE, Rates.MIDPOINT], ids=lambda r: r.name)
@pytest.mark.parametrize("kind", KINDS)
def test_the_tangent_of_a_joint(kind: str, rates: Rates) -> None:
    """Machine code against the complex step: free, on the ground, with springs and stops, prescribed."""
    single = KINDS[kind].free in ("angle", "displacement")
    acting = {"stiffness": 3.0, "damping": 0.7} if KINDS[kind].free else {}
    if single:
        acting |= {"rest": 0.1, "stops": (-0.2, 0.3), "stop_stiffness": 40.0, "stop_width": 0.1}
    cases = [{"b": "C"}, {"b": None}, {"b": "C", **acting}] + [{"b": "C", "prescribed": 1.0}] * single
    axes = _plain(AXES.get(kind, {}))
    for given in cases:
        joint = Joint("joint", kind, "B", axis=axes.get("axis", (0, 0, 1)), second=axes.get("second"), **given)
        element = JointElement(rates, kind, joint.b is None, joint.prescribed is not None, joint.active)
        parameters = np.array(joint.parameters(PLACES))
        layout = JointLayout(2 + (joint.b is not None), 0, True, parameters=len(parameters))
        assert check_tangent(element, layout, np.random.default_rng(4), parameters) <= 1e-11


@pytest.mark.parametrize("kind", [kind for kind in KINDS if KINDS[kind].free])
def test_the_virtual_work_of_a_joint_is_the_derivative_of_its_potential(kind: str) -> None:
    """Springs and stops in statics, complex step; constraint forces are λ times the derivative of the constraints."""
    rng, axes = np.random.default_rng(7), _plain(AXES.get(kind, {}))
    acting: dict = {"stiffness": 3.0}
    if KINDS[kind].free != "ball":
        acting |= {"rest": 0.1, "stops": (-0.2, 0.3), "stop_stiffness": 40.0, "stop_width": 0.1}
    joint = Joint("joint", kind, "B", "C", axis=axes.get("axis", (0, 0, 1)), second=axes.get("second"), **acting)
    element = JointElement(Rates.NONE, kind, active=True)
    parameters = joint.parameters(PLACES)
    layout = JointLayout(3, 0, True, parameters=len(parameters))
    # the angle of a hinge is that of the section frames where its constraints hold: turn C about the axis of B
    turned = exp(0.4 * rng.standard_normal(3))
    u = turned @ (np.array(joint.axis) / np.linalg.norm(joint.axis))
    spun = exp(0.5 * u) @ turned
    x = np.zeros((3, 40))
    for row, R in ((x[0], turned), (x[1], spun)):
        row[:3] = rng.standard_normal(3)
        row[3:12] = R.T.ravel()
        row[15:24] = R.T.ravel()
    x[2, 6] = 0.5 if KINDS[kind].free == "angle" else 0.0
    step = element.step(layout, x.ravel().tolist(), parameters, [0.0] * 8)[0]
    for lam in range(6):
        x[2, :6] = 0.0
        x[2, lam] = 1.0
        held = np.array(element.step(layout, x.ravel().tolist(), parameters, [0.0] * 8)[0], float) - np.array(
            step, float
        )
        for column in range(12):
            y = x.astype(complex)
            node, k = divmod(column, 6)
            if k < 3:
                y[node, k] += 1e-30j
            else:
                y[node, 3:12] += 1e-30j * np.cross(np.eye(3)[k - 3], x[node, 3:12].reshape(3, 3)).ravel()
            rows = element.step(layout, y.ravel().tolist(), parameters, [0.0] * 8)[0][12:]
            assert held[column] == pytest.approx(np.imag(complex(rows[lam])) / 1e-30, abs=1e-13)
            if lam == 0:
                stored = element.audit(layout, y.ravel().tolist(), parameters)[0]
                assert float(step[column]) == pytest.approx(np.imag(complex(stored)) / 1e-30, abs=1e-12)
    assert np.abs(np.array(step[:12], float)).max() > 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_an_inner_joint_conserves(kind: str) -> None:
    options = {"stiffness": 20.0, "damping": 0.3} if KINDS[kind].free else {}
    for given in ({}, options):
        result = dx.simulate(pushed(joined(kind, **given)), t_end=3.0, dt=0.03)
        assert result.success
        assert all(entry.claimed and entry.value <= 1e-12 for entry in result.audit.entries)
        assert apart(result, kind) <= 1e-11
    assert not options or result.energy.dissipated[-1] > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_ten_thousand_steps_where_generalised_alpha_drifts(kind: str) -> None:
    model = pushed(joined(kind))
    result = dx.simulate(model, t_end=400.0, dt=0.04, save_every=50)
    assert result.success
    # what slides on a plane is 650 lengths apart in the end, where positions have three digits less
    allowed = 1e-10 if kind == "planar" else 1e-11
    assert all(entry.claimed and entry.value <= allowed for entry in result.audit.entries)
    assert apart(result, kind) <= 1e-11
    other = dx.simulate(model, t_end=400.0, dt=0.04, save_every=50, integrator=dx.GeneralizedAlpha(1.0))
    assert not other.success or other.audit.entries[0].value > 1e-3


@pytest.mark.parametrize(
    "integrator",
    [dx.Midpoint(), dx.EnergyDissipating(0.3), dx.EnergyDissipating(0.1, 0.2), dx.SimoTarnowDoblare()],
    ids=repr,
)
def test_other_steps_keep_what_they_claim(integrator) -> None:
    model = pushed(joined("hinge", stiffness=10.0)).gravity((0, 0, -1))
    result = dx.simulate(model, t_end=1.0, dt=0.02, integrator=integrator)
    assert result.success and result.audit.passed
    assert apart(result, "hinge") <= 1e-11


def test_generalised_alpha_is_of_second_order_with_joints_and_near_the_other() -> None:
    model = joined("hinge", stiffness=10.0).gravity((0, 0, -9.81)).pin("A")

    def end(dt: float, scheme: dx.GeneralizedAlpha | dx.EnergyMomentum) -> np.ndarray:
        return dx.simulate(model, 0.2, dt, integrator=scheme, save_every=1000).node("D").r[-1]

    alpha = dx.GeneralizedAlpha(0.8)
    fine = end(2.5e-4, alpha)
    errors = [np.linalg.norm(end(dt, alpha) - fine) for dt in (8e-3, 4e-3)]
    assert 3.5 <= errors[0] / errors[1] <= 4.6
    assert np.linalg.norm(fine - end(5e-4, dx.EnergyMomentum())) <= 2e-5  # they spread rotary inertia differently


def test_a_hinged_pendulum_hangs_and_its_joint_carries_it() -> None:
    rod = dx.Model().rod(dx.line((0, 0, 0), (0, 0, -1)), SECTION, name="rod", ends=("A", "B"), elements=4)
    model = rod.hinge("A", axis=(0, 1, 0), name="pin").gravity((0, 0, -9.81)).force("B", (0, 0, -3.0))
    result = dx.solve_static(model, steps=2)
    weight = SECTION.A_rho * 9.81 + 3.0
    assert result.success and result.audit.passed
    np.testing.assert_allclose(result.joint("pin").force[-1], (0, 0, weight), atol=1e-7 * weight)
    assert result.joint("pin").coordinate[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_spring_turns_by_what_its_moment_says_and_statics_balance() -> None:
    """A stiff arm on a torsion spring: k φ = F ℓ cos φ."""
    rigid = dx.Section.rectangle(0.1, 0.12, E=1e12, nu=0.3)
    arm = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), rigid, name="arm", ends=("A", "B"), elements=4)
    result = dx.solve_static(arm.hinge("A", axis=(0, -1, 0), stiffness=40.0, name="pin").force("B", (0, 0, 60.0)))
    angle = result.joint("pin").coordinate[-1]
    assert result.success and result.audit.passed
    assert 40.0 * angle == pytest.approx(60.0 * np.cos(angle), rel=1e-4)
    # what the spring stores is half of k φ²
    stored = result.energy.stored[-1]
    assert stored == pytest.approx(0.5 * 40.0 * angle**2, rel=1e-4)


def test_a_mass_on_a_slider_swings_with_its_period_and_past_several_turns_an_angle_counts_on() -> None:
    k, m = 30.0, 2.0
    body = dx.Model().node("P", (0, 0, 0)).rigid_body("P", m, np.eye(3) * 0.1)
    model = body.slider("P", axis=(0, 0, 1), stiffness=k, name="rail").velocity("P", (0, 0, 1))
    period = 2 * np.pi * np.sqrt(m / k)
    result = dx.simulate(model, t_end=period, dt=period / 2000)
    assert result.node("P").r[-1, 2] == pytest.approx(0.0, abs=1e-5)
    assert np.abs(result.joint("rail").coordinate).max() == pytest.approx(np.sqrt(m / k), rel=1e-5)

    wheel = body.hinge("P", axis=(0, 0, 1), name="axle").velocity("P", (0, 0, 0), (0, 0, 5.0))
    turned = dx.simulate(wheel, t_end=10.0, dt=0.05)
    # a step of the Cayley kind turns by 2 atan(ω Δt / 2) where ω is that of the momentum
    assert turned.joint("axle").coordinate[-1] == pytest.approx(200 * 2 * np.arctan(5.0 * 0.05 / 2), rel=2e-3)
    assert turned.joint("axle").coordinate[-1] > 40.0


def test_a_damper_takes_what_its_formula_says() -> None:
    J, c, omega = 0.1, 0.02, 3.0
    wheel = dx.Model().node("P", (0, 0, 0)).rigid_body("P", 1.0, np.eye(3) * J)
    model = wheel.hinge("P", axis=(0, 0, 1), damping=c, name="axle").velocity("P", (0, 0, 0), (0, 0, omega))
    result = dx.simulate(model, t_end=5.0, dt=0.005)
    left = omega * np.exp(-c * 5.0 / J)
    assert result.energy.total[-1] == pytest.approx(0.5 * J * left**2, rel=1e-4)
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * J * (omega**2 - left**2), rel=1e-4)
    assert np.abs(result.energy.residual).max() <= 1e-12


@pytest.mark.parametrize("kind", ["hinge", "slider", "cylindrical"])
def test_a_prescribed_coordinate_is_met_and_its_work_is_booked(kind: str) -> None:
    model = joined(kind, STIFF, prescribed=lambda t: 0.4 * np.sin(3 * t)).clamp("A").gravity((0, 0, -9.81))
    result = dx.simulate(model, t_end=2.0, dt=0.02)
    assert result.success
    np.testing.assert_allclose(result.joint("joint").coordinate, 0.4 * np.sin(3 * result.t), atol=1e-11)
    assert all(entry.claimed and entry.value <= 1e-11 for entry in result.audit.entries)
    assert np.abs(result.energy.prescribed).max() > 0.1


@pytest.mark.parametrize("kind", ["hinge", "slider", "cylindrical"])
def test_a_drive_does_its_work(kind: str) -> None:
    result = dx.simulate(joined(kind, STIFF, drive=lambda t: 5.0 * np.cos(2 * t)), t_end=1.0, dt=0.01)
    assert result.success
    t = 0.5 * (result.t[1:] + result.t[:-1])
    work = np.cumsum(5.0 * np.cos(2 * t) * np.diff(result.joint("joint").coordinate))
    np.testing.assert_allclose(result.energy.work[1:], work, rtol=1e-10, atol=1e-12)
    # it acts in pairs: momenta stay what they were
    assert np.abs(result.momentum.linear).max() <= 1e-11 and np.abs(result.momentum.angular).max() <= 1e-11
    assert result.energy.work[-1] > 0.1


def test_stops_hold_a_pendulum_back_and_lose_nothing() -> None:
    arm = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), STIFF, name="arm", ends=("A", "B"), elements=2)
    model = arm.hinge("A", axis=(0, 1, 0), stops=(-1.0, 0.8), stop_stiffness=5e4, stop_width=0.01, name="pin")
    result = dx.simulate(model.gravity((0, 0, -9.81)), t_end=4.0, dt=0.005)
    angle = result.joint("pin").coordinate
    assert result.success and 0.8 < angle.max() < 0.9
    assert np.abs(result.energy.residual).max() <= 1e-11 * result.energy.total.max()


def test_a_state_with_joints_is_gone_on_from() -> None:
    """To round-off: a result has the state, and not the factors that the next step of its run would have begun with."""
    model = pushed(joined("hinge", stiffness=10.0))
    whole = dx.simulate(model, t_end=1.0, dt=0.02)
    half = dx.simulate(model, t_end=0.5, dt=0.02)
    rest = dx.simulate(model, t_end=1.0, dt=0.02, start=half)
    np.testing.assert_allclose(rest.r[-1], whole.r[-1], rtol=0, atol=1e-13)
    angles = [result.joint("joint").coordinate[-1] for result in (rest, whole)]
    assert abs(angles[0] - angles[1]) <= 1e-12


def test_joints_survive_saving(tmp_path) -> None:
    result = dx.simulate(pushed(joined("hinge")), t_end=0.1, dt=0.02)
    again = dx.load(result.save(tmp_path / "joints.vtkhdf"))
    assert again.mesh.joints == ("joint",)
    np.testing.assert_array_equal(again.joint("joint").moment, result.joint("joint").moment)
    with pytest.raises(dx.ModelError, match="no joint 'hinge'"):
        again.joint("hinge")


def test_a_path_is_followed_through_a_hinge() -> None:
    model = joined("hinge", STIFF, stiffness=100.0).clamp("A").force("D", (0, 0, 50.0))
    along = dx.solve_static(model, control=dx.ArcLength(ds=0.05, until=lambda s: s.load_factor > 1.0))
    straight = dx.solve_static(model, steps=10)
    at = np.interp(along.load_factor[-1], [0, 1], [0, 1])
    assert along.success and at == 1.0
    on = dx.solve_static(model.force("D", (0, 0, 50.0 * (along.load_factor[-1] - 1.0))), steps=10)
    np.testing.assert_allclose(along.node("D").r[-1], on.node("D").r[-1], atol=1e-8)
    assert straight.success


def test_a_body_off_its_node_is_a_body_on_a_rigid_arm() -> None:
    """A pendulum of a body 0.5 below its pin: period of small swings 2π √((J + m ℓ²)/(m g ℓ))."""
    m, arm, J = 2.0, 0.5, 0.1
    model = dx.Model().node("P", (0, 0, 0)).rigid_body("P", m, np.eye(3) * J, offset=(0, 0, -arm))
    model = model.hinge("P", axis=(0, 1, 0), name="pin").gravity((0, 0, -9.81))
    omega = 0.01
    period = 2 * np.pi * np.sqrt((J + m * arm**2) / (m * 9.81 * arm))
    spun = model.rigid_velocity((0, 0, 0), (0, omega, 0))
    result = dx.simulate(spun, t_end=period, dt=period / 1000)
    angle = result.joint("pin").coordinate
    assert angle.max() == pytest.approx(omega * period / (2 * np.pi), rel=1e-3)
    assert abs(angle[-1]) <= 1e-4 * angle.max()


def test_a_heavy_top_turns_as_others_computed() -> None:
    """Displacement at t = 2 of the top of validation 5.7 (kynema), extrapolated from two steps of order 2."""
    J = np.diag([0.234375, 0.46875, 0.234375])
    spin = (0, 150, -4.61538)
    top = dx.Model().node("P", (0, 1, 0)).rigid_body("P", 15, J).spherical("P", at=(0, 0, 0)).gravity((0, 0, -9.81))
    top = top.velocity("P", np.cross(spin, (0, 1, 0)), spin)
    coarse, fine = (dx.simulate(top, 2.0, dt, save_every=10000).node("P").displacement[-1] for dt in (1e-3, 5e-4))
    expected = (-0.150416985652933, -1.724164450779749, -0.673023460701136)
    np.testing.assert_allclose((4 * fine - coarse) / 3, expected, atol=2e-6)
    assert np.abs(fine - expected).max() > 5e-5


def test_redundant_joints_are_named() -> None:
    twice = joined("hinge").hinge("B", "C", axis=(0, 0.3, 1), at=(1, 0, 0.1), name="again")
    with pytest.raises(dx.ModelError, match=r"joints 'joint', 'again': together"):
        dx.simulate(twice, 0.1, 0.1)
    both_held = joined("spherical").rigid("A", "D", name="bar").clamp("A").clamp("D")
    with pytest.raises(dx.ModelError, match=r"joint 'bar': it holds what supports hold"):
        dx.solve_static(both_held)
    # a loop of flexible rods is not redundant
    loop = dx.Model()
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    for k in range(4):
        loop = loop.rod(dx.line(corners[k], corners[(k + 1) % 4]), SECTION, name=f"r{k}", elements=2)
    for k in range(4):
        loop = loop.hinge(f"r{k}.end", f"r{(k + 1) % 4}.start", axis=(0, 0, 1))
    result = dx.simulate(loop.velocity("r0.start", (0, 0, 0)).rigid_velocity((0, 0, 1), (1, 2, 3)), 0.5, 0.05)
    assert result.success and result.audit.passed


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda m: m.hinge("A", axis=(0, 0, 0)), "axis = .* no direction"),
        (lambda m: m.hinge("A", "A", axis=(0, 0, 1)), "joins node 'A' to itself"),
        (lambda m: m.hinge("B", "C", axis=(0, 0, 1), name="x").spherical("A", name="x"), "two joints called 'x'"),
        (lambda m: m.hinge("B", "C", axis=(0, 0, 1), stops=(1, 0), stop_stiffness=1.0), "leave no room"),
        (lambda m: m.hinge("B", "C", axis=(0, 0, 1), stops=(0, 1)), "stop_stiffness"),
        (lambda m: m.hinge("B", "C", axis=(0, 0, 1), prescribed=1.0, damping=1.0), "prescribed, damping would do"),
        (lambda m: m.spherical("B", "C", drive=1.0), "no single coordinate that drive"),
        (lambda m: m.universal("B", "C", axes=((1, 0, 0), (1, 1, 0))), "not perpendicular"),
        (lambda m: m.spherical("B", "Q").check(), "no node 'Q' for the joint"),
        (lambda m: dx.simulate(m.rigid_velocity((1, 0, 0)).hinge("A", axis=(0, 0, 1)), 1, 0.1), "pull joint .* apart"),
        (lambda m: dx.simulate(m.hinge("B", "C", axis=(0, 0, 1), prescribed=lambda t: t + 1), 1, 0.1), "not together"),
        (
            lambda m: dx.simulate(
                m.hinge("B", "C", axis=(0, 0, 1), damping=1.0), 1, 0.1, integrator=dx.GeneralizedAlpha(0.8)
            ),
            "generalised-α family has no form",
        ),
        (lambda m: dx.solve_static(m.clamp("A").rigid("B", "C"), formulation=dx.SimoVuQuoc()), "SimoVuQuoc"),
        (lambda m: dx.simulate(m.hinge("B", "C", axis=(0, 0, 1), drive=lambda t: "x"), 1, 0.1), "drive of joint"),
    ],
)
def test_what_cannot_be_a_joint_is_refused(make, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names):
        make(two_rods())
