"""Contact: exact work of the elements, known motions with and without friction, rods that hit, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import directrix as dx
from directrix.formulations.attached import AttachedLayout
from directrix.formulations.conformance import check_formulation
from directrix.formulations.contact import ObstacleElement, PairElement
from directrix.schema import load_case
from directrix.scheme import Rates

SECTION = dx.Section.circle(radius=0.02, E=5e6, nu=0.3, rho=1100)
FLOOR = dx.Plane((0, 0, 0), (0, 0, 1))
G = 9.81

SURFACES = {
    "plane": (True, (0, 0, 1), 1),
    "sphere": (False, (0, 0, 0), 1),
    "in a sphere": (False, (0, 0, 0), -1),
    "cylinder": (False, (0.6, 0, 0.8), 1),
    "in a pipe": (False, (0.6, 0, 0.8), -1),
}


def surface(axis, side: float, friction: float = 0.0) -> np.ndarray:
    """Parameters with a reach so large that random nodes touch."""
    far = 5.0 if side > 0 else 0.1
    return np.array([0.1, 0.2, -0.3, *axis, far if any(axis) else 5.0 * side + 5.1, side, 3.0, 7.0, 0.3, friction, 0.5])


@pytest.mark.parametrize("rates", [Rates.NONE, Rates.MIDPOINT, Rates.ALPHA], ids=lambda r: r.name)
@pytest.mark.parametrize(("flat", "axis", "side"), SURFACES.values(), ids=list(SURFACES))
def test_a_surface_is_an_element_like_any_other(flat: bool, axis, side: int, rates: Rates) -> None:
    """Tangent of the machine code, work of the energy."""
    layout = AttachedLayout(1, 0, True, parameters=13)
    static = rates is not Rates.MIDPOINT
    found = check_formulation(
        ObstacleElement(rates, flat), layout, static=static, states=300, parameters=surface(axis, side)
    )
    assert found.tangent <= 1e-10 and found.work <= 1e-12
    if not static:
        rough = check_formulation(
            ObstacleElement(rates, flat, True), layout, static=False, states=1, parameters=surface(axis, side, 0.4)
        )
        assert rough.tangent <= 1e-10


@pytest.mark.parametrize("rates", [Rates.NONE, Rates.MIDPOINT], ids=lambda r: r.name)
@pytest.mark.parametrize("end", [0, 1])
def test_a_pair_is_an_element_like_any_other(end: int, rates: Rates) -> None:
    """Tangent, work of the energy, no resultant and no moment, also where the nearest places slide in the step."""
    layout, static = AttachedLayout(4, 0, True, parameters=8), rates is Rates.NONE
    parameters = np.array([0.3, 5.0, 9.0, 0.4, 0.4, end, 0.0, 0.2])
    found = check_formulation(
        PairElement(rates), layout, static=static, states=2000, largest=3.0, parameters=parameters
    )
    assert found.tangent <= 1e-10
    if end == 0:  # with an end taken off next to nothing may be left, to which these are relative
        assert found.work <= 1e-12 and found.rigid_motion <= 1e-12 and found.objectivity <= 1e-11
    if not static:
        parameters[6] = 0.5
        rough = check_formulation(
            PairElement(rates, True), layout, static=False, states=50, largest=3.0, parameters=parameters
        )
        assert rough.tangent <= 1e-10 and rough.rigid_motion <= 1e-12


def closes(result: dx.Result, limit: float = 1e-10) -> bool:
    """Ledger of the whole run, to its largest term."""
    energy = result.energy
    terms = max(np.abs(t).max() for t in (energy.total, energy.work, energy.dissipated))
    return result.success and result.audit.passed and bool(np.abs(energy.residual).max() <= limit * terms)


def bouncing(order: int, **friction: float) -> dx.Model:
    model = dx.Model().rod(dx.line((0, 0, 0.1), (1, 0, 0.15)), SECTION, name="rod", elements=4, order=order)
    return model.gravity((0, 0, -G)).rigid_velocity((0.5, 0, 0)).contact(FLOOR, stiffness=2e5, name="floor", **friction)


@pytest.mark.parametrize(
    "integrator", [dx.EnergyMomentum(), dx.EnergyDissipating(0.3), dx.EnergyDissipating(0.2, 0.2)], ids=repr
)
def test_bouncing_keeps_the_ledger(integrator) -> None:
    """Interior nodes of the elements touch as well, and the system stays a chain."""
    for friction in ({}, {"friction": 0.4, "slip_speed": 0.01}):
        result = dx.simulate(bouncing(2, **friction), t_end=0.6, dt=0.002, integrator=integrator)
        assert closes(result) and result.info["solver"] == "chain"
        assert result.contact("floor").gap.min() < 0.0 and result.contact("floor").force.max() > 100.0
        assert (result.energy.dissipated[-1] > 1e-3) == bool(friction or integrator != dx.EnergyMomentum())


def test_many_bounces_keep_the_energy() -> None:
    """A level rod on a level floor: without friction the total energy with gravity's is that of the start."""
    model = dx.Model().rod(dx.line((0, 0, 0.05), (0.5, 0, 0.05)), SECTION, name="rod", elements=2)
    model = model.gravity((0, 0, -G)).contact(FLOOR, stiffness=1e6, name="floor")
    result = dx.simulate(model, t_end=5.0, dt=0.001)
    touching = result.contact("floor").force > 0.0
    assert np.count_nonzero(np.diff(touching.astype(int)) == 1) >= 25
    assert closes(result, 1e-11) and not result.energy.dissipated.any()


def block(alpha: float, **contact: float) -> tuple[dx.Model, np.ndarray]:
    """A rod along a slope, pressed in as its weight presses it, and the way down."""
    down, normal = np.array([np.cos(alpha), 0, -np.sin(alpha)]), np.array([np.sin(alpha), 0, np.cos(alpha)])
    k, w = 1e5, 1e-4
    need = SECTION.A_rho * G * np.cos(alpha) / k
    p = need
    for _ in range(50):
        p -= (0.5 * p * p * (2 * p + 3 * w) / (p + w) ** 2 - need) / 1.0
    start = -p * normal
    model = dx.Model().rod(dx.line(start, start + 0.4 * down), SECTION, name="rod", ends=("a", "b"), elements=3)
    model = model.gravity((0, 0, -G)).contact(
        dx.Plane((0, 0, 0), normal), stiffness=k, width=w, radius=0.0, name="slope", **contact
    )
    return model, down


@pytest.mark.parametrize("mu", [0.0, 0.2, 0.4])
def test_a_block_slides_down_a_slope(mu: float) -> None:
    """a = g (sin α − μ cos α); what friction takes is μ N times the way."""
    alpha, t = np.radians(30), 1.0
    model, down = block(alpha, friction=mu, slip_speed=1e-5)
    speed = 0.1
    result = dx.simulate(model.rigid_velocity(speed * down), t_end=t, dt=0.01, tolerance=1e-11)
    a = G * (np.sin(alpha) - mu * np.cos(alpha))
    way = (result.node("a").r - result.node("a").r[0]) @ down
    np.testing.assert_allclose(way[-1], speed * t + 0.5 * a * t * t, rtol=1e-7)
    assert closes(result)
    weight = SECTION.A_rho * 0.4 * G
    np.testing.assert_allclose(result.energy.dissipated[-1], mu * weight * np.cos(alpha) * way[-1], rtol=1e-6)


def test_a_block_sticks_below_the_angle_of_friction() -> None:
    """It creeps at the speed where the regularised friction holds it: v = v0 t/√(μ² − t²), t = tan α."""
    alpha, mu, slow = np.radians(15), 0.5, 1e-4
    model, down = block(alpha, friction=mu, slip_speed=slow)
    result = dx.simulate(model, t_end=0.5, dt=0.01, tolerance=1e-11)
    ratio = np.tan(alpha) / mu
    creep = (result.node("a").r[-1] - result.node("a").r[-21]) @ down / 0.2
    np.testing.assert_allclose(creep, slow * ratio / np.sqrt(1 - ratio**2), rtol=1e-3)
    assert closes(result)


def test_a_rod_rolls_down_a_slope() -> None:
    """Across the slope a round rod rolls: a = ⅔ g sin α, and turns by its way over the radius."""
    alpha, t, r = np.radians(20), 0.5, 0.02
    down, normal = np.array([np.cos(alpha), 0, -np.sin(alpha)]), np.array([np.sin(alpha), 0, np.cos(alpha)])
    model = dx.Model().rod(
        dx.line(r * normal, r * normal + (0, 0.2, 0)), SECTION, name="rod", ends=("a", "b"), elements=2
    )
    model = model.gravity((0, 0, -G)).contact(
        dx.Plane((0, 0, 0), normal), stiffness=1e7, width=1e-4, friction=0.6, slip_speed=1e-4, name="slope"
    )
    result = dx.simulate(model, t_end=t, dt=0.001)
    way = (result.node("a").r[-1] - result.node("a").r[0]) @ down
    assert way == pytest.approx(0.5 * 2.0 / 3.0 * G * np.sin(alpha) * t * t, rel=2e-3)
    turned = np.arccos(np.clip(result.node("a").R[-1, 0, 0], -1, 1))
    assert np.cos(turned) == pytest.approx(np.cos(way / r), abs=0.05)
    assert closes(result)


@pytest.mark.parametrize(
    ("obstacle", "bottom"),
    [
        (dx.Sphere((0, 0, 0), 1.0, inside=True), 0.98),
        (dx.Cylinder((0, 0, 0), (0, 1, 0), 1.0, inside=True), 0.98),
    ],
    ids=["bowl", "pipe"],
)
def test_what_slides_in_a_bowl_is_a_pendulum(obstacle, bottom: float) -> None:
    """A short rod along y at the bottom of a pipe or bowl swings with T = 2π √(ρ/g), ρ = R − r."""
    angle = 0.02
    at = bottom * np.array([np.sin(angle), 0, -np.cos(angle)])
    axis = dx.line(np.subtract(at, (0, 0.005, 0)), np.add(at, (0, 0.005, 0)))
    model = dx.Model().rod(axis, SECTION, name="rod", ends=("a", "b"), elements=1)
    model = model.gravity((0, 0, -G)).contact(obstacle, stiffness=1e6, width=1e-3, name="bowl")
    period = 2 * np.pi * np.sqrt(bottom / G)
    result = dx.simulate(model, t_end=period, dt=period / 200, tolerance=1e-11)
    x = result.node("a").r[:, 0] + result.node("b").r[:, 0]
    assert x[100] / x[0] == pytest.approx(-1.0, abs=0.01) and x[-1] / x[0] == pytest.approx(1.0, abs=0.02)
    assert closes(result)


@pytest.mark.parametrize("order", [1, 2])
def test_an_arm_that_lies_down(order: int) -> None:
    """Statics: what the floor under a soft arm does not carry hangs on its clamp."""
    soft = dx.Section.circle(radius=0.02, E=2e5, nu=0.3, rho=1100)
    model = dx.Model().rod(
        dx.line((0, 0, 0.1), (1, 0, 0.1)), soft, name="arm", ends=("a", "b"), elements=8, order=order
    )
    model = model.clamp("a").gravity((0, 0, -G)).contact(FLOOR, stiffness=1e5, name="floor")
    result = dx.solve_static(model, steps=4)
    assert result.success and result.audit.passed
    carried = result.contact("floor").force[-1]
    assert carried > 5.0 and carried + result.node("a").reaction[-1, 2] == pytest.approx(soft.A_rho * G, rel=1e-8)


def test_an_arm_on_a_drum_is_propped() -> None:
    """Modes know the stiffness of contact: the first frequency of a propped cantilever is 4.385 times a free one's."""
    stiff = dx.Section.circle(radius=0.02, E=5e9, nu=0.3, rho=1100)
    model = dx.Model().rod(dx.line((0, 0, 0.32), (1, 0, 0.32)), stiff, name="arm", ends=("a", "b"), elements=6)
    model = model.clamp("a").fix("b", "y").gravity((0, 0, -G))
    held = model.contact(dx.Cylinder((1, 0, 0), (0, 1, 0), 0.3), stiffness=1e9, width=1e-4, name="drum")
    found = [dx.modes(m, dx.solve_static(m, steps=1), count=1).frequencies[0] for m in (model, held)]
    assert found[1] / found[0] == pytest.approx((3.92660 / 1.87510) ** 2, rel=0.03)


def test_a_rod_on_the_axis_of_a_pipe_falls_to_its_wall() -> None:
    """On the axis there is no direction to the wall, and no force: no reason not to begin there."""
    model = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), SECTION, name="rod", ends=("a", "b"), elements=4, order=1)
    pipe = dx.Cylinder((0, 0, 0), (1, 0, 0), 0.2, inside=True)
    model = model.gravity((0, 0, -G)).contact(pipe, stiffness=2e5, friction=0.2, slip_speed=0.01, name="wall")
    result = dx.simulate(model, t_end=0.4, dt=0.002)
    assert closes(result) and result.contact("wall").force.max() > 100.0


def crossing(order: int, gap: float = 0.1, **contact: float) -> dx.Model:
    """Two rods in free flight that meet at an angle."""
    names = {f"b{k}": k / 6 for k in range(1, 6)}
    model = dx.Model().rod(dx.line((-0.5, 0, 0), (0.5, 0, 0)), SECTION, name="a", elements=6, order=order)
    model = model.rod(
        dx.line((0.1, -0.4, gap), (0.15, 0.5, gap)), SECTION, name="b", elements=6, order=order, nodes=names
    )
    for node in ("b.start", "b.end", *names):
        model = model.velocity(node, (0.3, 0.1, -2.0))
    return model.rigid_velocity((0, 0, 0.3), (0, 0, 0.5)).self_contact(stiffness=2e6, name="both", **contact)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_rods_that_hit_in_flight(order: int, friction: float) -> None:
    """Energy, momentum and angular momentum through the impact, with what friction takes."""
    result = dx.simulate(crossing(order, friction=friction, slip_speed=0.01), t_end=0.1, dt=0.001)
    both = result.contact("both")
    assert both.gap.min() < 0.0 and both.force.max() > 10.0 and np.isinf(both.gap[0])
    assert closes(result) and (result.energy.dissipated[-1] > 1e-4) == (friction > 0.0)
    assert list(result.energy.by_source) == (["contact 'both'"] if friction else [])
    for momentum in (result.momentum.linear, result.momentum.angular):
        assert np.abs(momentum - momentum[0]).max() <= 1e-11 * np.abs(momentum).max()


def test_what_drives_a_rod_goes_on_while_pairs_come_and_go() -> None:
    """A rod that curls by itself hits another, over a floor: the ledger closes, work and loss are booked by name."""
    model = crossing(2, friction=0.2, slip_speed=0.01).actuate("a", curvature=lambda t: (0.0, 500.0 * t * t))
    model = model.contact(dx.Plane((0, 0, -0.03), (0, 0, 1)), stiffness=1e5, name="floor", rods="b")
    result = dx.simulate(model, t_end=0.1, dt=0.001)
    assert closes(result) and result.contact("both").gap.min() < 0.0
    assert set(result.energy.by_source) == {"contact 'both'"} and result.energy.dissipated[-1] > 1e-3
    assert result.energy.work_by_source["actuation of rod 'a'"][-1] > 1.0


def test_other_steps_carry_an_impact_too() -> None:
    for integrator in (dx.Midpoint(), dx.EnergyDissipating(0.2), dx.GeneralizedAlpha(0.8)):
        result = dx.simulate(crossing(1), t_end=0.06, dt=0.0005, integrator=integrator)
        assert result.success and result.audit.passed and result.contact("both").gap.min() < 0.0
        angular = result.momentum.angular
        if integrator != dx.GeneralizedAlpha(0.8):
            assert np.abs(angular - angular[0]).max() <= 1e-11 * np.abs(angular).max()


def test_every_point_counts_once_beside_corners() -> None:
    """Two parallel rods, one lying along the other: the force per length is that of the law, whatever the mesh."""
    for first, second in ((3, 3), (4, 7)):
        model = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), SECTION, name="a", elements=first)
        model = model.rod(dx.line((0, 0, 0.038), (1, 0, 0.038)), SECTION, name="b", elements=second)
        model = model.contact_between("a", "b", stiffness=1e6, width=1e-3, name="ab")
        result = dx.simulate(model, t_end=1e-9, dt=1e-9)
        p, w = 0.002, 1e-3
        per_length = 0.5 * 1e6 * p * p * (2 * p + 3 * w) / (p + w) ** 2
        assert result.contact("ab").force[0] == pytest.approx(per_length, rel=1e-9)
        energy = 0.5 * 1e6 * p**3 / (p + w)
        assert result.energy.stored[0] == pytest.approx(energy, rel=1e-9)


def test_neighbours_of_one_rod_do_not_touch() -> None:
    """A bend as tight as a rod can have, and rods that meet in a node, are at rest."""
    model = dx.Model().rod(
        dx.arc((0.02, 0, 0), (0, 0, 0.02), (-0.02, 0, 0)), SECTION, name="bend", ends=("a", "b"), elements=8
    )
    model = model.rod(dx.line((-0.02, 0, 0), (-0.02, 0.3, -0.1)), SECTION, name="arm", ends=("b", "c"), elements=9)
    result = dx.simulate(model.self_contact(stiffness=1e6), t_end=0.01, dt=0.005)
    assert result.energy.stored.max() <= 1e-20


def test_rods_that_would_pass_through_one_another_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The step is cut, and then they bounce; where it may not be cut, the run ends."""
    model = crossing(1, gap=0.1)
    result = dx.simulate(model, t_end=0.2, dt=0.1)
    assert closes(result) and result.cuts.sum() > 0
    assert result.node("b3").v[-1, 2] > result.node("b3").v[0, 2] + 0.5 and result.contact("both").gap.min() < 0.0
    monkeypatch.setattr("directrix.stepping.MOST_CUTS", 0)
    result = dx.simulate(model, t_end=0.2, dt=0.1)
    assert not result.success and "passed through one another" in result.status.sentence
    assert "smaller steps" in result.status.advice


def test_a_step_that_reaches_what_was_far_is_taken_again() -> None:
    """Nothing is near at the start of the step in which the rods come to touch."""
    fast = dx.simulate(crossing(1, gap=0.09), t_end=0.06, dt=0.012)
    assert closes(fast) and fast.contact("both").gap.min() < 0.0


@pytest.mark.parametrize(
    ("say", "add"),
    [
        ("is no surface", lambda m: m.contact("floor", stiffness=1.0)),
        ("speed", lambda m: m.contact(FLOOR, stiffness=1.0, friction=0.3)),
        ("stiffness", lambda m: m.contact(FLOOR, stiffness=0.0)),
        ("two contacts", lambda m: m.contact(FLOOR, stiffness=1.0, name="x").self_contact(stiffness=1.0, name="x")),
        ("both sides", lambda m: m.contact_between("a", ["b", "a"], stiffness=1.0)),
        ("not names of rods", lambda m: m.contact(FLOOR, stiffness=1.0, rods=3)),
        ("no rod 'c'", lambda m: m.contact(FLOOR, stiffness=1.0, rods="c").check()),
        ("not known to be round", lambda m: m.self_contact(stiffness=1.0, rods="flat").check()),
        ("no radius", lambda m: m.self_contact(stiffness=1.0, radius=0.0, width=1.0).check()),
        ("needs|no width", lambda m: m.contact(FLOOR, stiffness=1.0, radius=0.0).check()),
        ("no length", lambda m: m.contact(dx.Plane((0, 0, 0), (0, 0, 0)), stiffness=1.0)),
        ("generalised-α", lambda m: dx.simulate(
            m.contact(FLOOR, stiffness=1.0, friction=0.1, slip_speed=1.0, radius=1), 1, 0.1, integrator=dx.Newmark())),
        ("brings rods together", lambda m: dx.modes(m.clamp("a.start").self_contact(stiffness=1.0, rods="a"), count=1)),
        ("brings rods together", lambda m: dx.solve_static(
            m.clamp("a.start").self_contact(stiffness=1.0, rods="a"), control=dx.ArcLength(ds=1.0))),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(say: str, add) -> None:
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 1), (1, 0, 1)), SECTION, name="a")
        .rod(dx.line((0, 1, 1), (1, 1, 1)), SECTION, name="b")
    )
    flat = dx.Section.rectangle(0.1, 0.2, E=1e6, nu=0.3, rho=1000)
    model = model.rod(dx.line((0, 2, 1), (1, 2, 1)), flat, name="flat")
    with pytest.raises(dx.ModelError, match=say):
        add(model)


CASE = """
[section.s]
kind = "circle"
radius = 0.02
E = 5e6
nu = 0.3
rho = 1100

[[rod]]
name = "a"
section = "s"
line = [[-0.5, 0, 0.1], [0.5, 0, 0.1]]
elements = 2

[[rod]]
name = "b"
section = "s"
line = [[0, -0.5, 0.2], [0, 0.5, 0.2]]
elements = 2

[[contact]]
name = "floor"
obstacle = { kind = "plane", point = [0, 0, 0], normal = [0, 0, 2] }
stiffness = 2e5
friction = 0.3
slip_speed = 0.01

[[contact]]
obstacle = { kind = "cylinder", point = [0, 0, 0], axis = [0, 1, 0], radius = 2, inside = true }
stiffness = 2e5
rods = ["a"]

[[self_contact]]
stiffness = 1e6

[[contact_between]]
rods = ["a"]
others = ["b"]
stiffness = 1e6
points = 3

[dynamics]
t_end = 0.01
dt = 0.005
"""


def test_contacts_in_a_case_file(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE, "utf-8")
    case = load_case(path)
    assert case.model.contacts == (
        dx.Model().contact(FLOOR, stiffness=2e5, friction=0.3, slip_speed=0.01, name="floor")
        .contact(dx.Cylinder((0, 0, 0), (0, 1, 0), 2, inside=True), stiffness=2e5, rods=["a"], name="contact2").contacts
    )  # fmt: skip
    assert case.model.rod_contacts == (
        dx.Model().self_contact(stiffness=1e6, name="contact3")
        .contact_between("a", "b", stiffness=1e6, points=3, name="contact4").rod_contacts
    )  # fmt: skip


def test_contacts_are_stored(tmp_path: Path) -> None:
    result = dx.simulate(bouncing(1), t_end=0.02, dt=0.002)
    result.save(tmp_path / "r.vtkhdf")
    again = dx.load(tmp_path / "r.vtkhdf")
    np.testing.assert_array_equal(again.contact("floor").gap, result.contact("floor").gap)
    with pytest.raises(dx.ModelError, match="no contact"):
        again.contact("roof")
