"""Followers along a rod, pressure, intrinsic strain, tendons, drag: exact books, known shapes, and what is refused."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import directrix as dx
from directrix.formulations.attached import AttachedLayout, TendonElement
from directrix.formulations.conformance import check_formulation, random_parameters, random_states
from directrix.formulations.director_acceleration import DirectorAcceleration
from directrix.formulations.directors import DirectorStep, Rule
from directrix.formulations.element import COMMON
from directrix.formulations.layout import Layout
from directrix.rotations import cay
from directrix.schema import load_case
from directrix.scheme import Rates

STIFF = {"EA": 2500, "GA1": 950, "GA2": 900, "EI1": 10, "EI2": 12, "GJ": 8}
MASS = {"A_rho": 2.5, "I_rho1": 0.012, "I_rho2": 0.01}
PLAIN = dx.Section.from_moduli(**STIFF, **MASS)
DAMPED = dx.Section.from_moduli(**STIFF, **MASS, damping=0.01)
FUNG = dx.Section.hyperelastic(
    dx.laws.stiffening_bending(**STIFF, onset=2.0), A_rho=2.5, I_rho=np.diag([0.012, 0.01]), damping=0.01
)
TENDON = np.array([0.1, 0.2, -0.1, 0.0, 0.3, 0.2, 5.0, 7.0])
STEPS = {
    "statics": DirectorStep(Rule(static=True)),
    "energy-momentum": DirectorStep(Rule(w0=0.5, w1=0.5)),
    "midpoint": DirectorStep(Rule(w0=0.0, w1=0.0, wh=1.0)),
    "energy-dissipating": DirectorStep(Rule(w0=0.5, w1=0.5, dissipative=True)),
    "accelerations": DirectorAcceleration(),
}


def rod(section: dx.Section = PLAIN, order: int = 1, elements: int = 4) -> dx.Model:
    axis = dx.line((0, 0, 0), (2, 0, 0), d1=(0, 1, 0))
    return dx.Model(name="arm").rod(axis, section, name="arm", ends=("a", "b"), elements=elements, order=order)


# --- elements


@pytest.mark.parametrize("name", STEPS)
def test_the_tangents_of_what_is_driven(name: str) -> None:
    element = STEPS[name]
    layout = Layout(2, 1, True, actuated=True, dragged=name != "accelerations")
    assert check_formulation(element, layout, static=name == "statics", states=1).tangent <= 1e-9


@pytest.mark.parametrize("rates", [Rates.NONE, Rates.MIDPOINT], ids=lambda r: r.name)
@pytest.mark.parametrize("nn", [1, 2])
def test_the_tangent_of_a_tendon(nn: int, rates: Rates) -> None:
    layout = AttachedLayout(nn, 0, True, parameters=len(TENDON))
    found = check_formulation(TendonElement(rates), layout, static=rates is Rates.NONE, parameters=TENDON, states=9)
    assert found.tangent <= 1e-9
    if nn == 2:
        assert found.objectivity <= 1e-12 and found.rigid_motion <= 1e-12


@pytest.mark.parametrize("law", [None, FUNG.law], ids=["linear", "law"])
def test_what_an_actuated_element_does_is_its_energy_and_the_work_of_actuation(law) -> None:
    """f·Δx = ΔW − (work of actuation) for random states and any change of ε̂, to round-off."""
    layout = Layout(3, 2, True, law=law, actuated=True)
    rng = np.random.default_rng(1)
    element, nothing = STEPS["energy-momentum"], [0.0] * COMMON
    p = random_parameters(rng, layout)
    x = random_states(rng, element, layout, 1, turn=0.3)[0]
    end = sum(layout.sizes[:8])
    before = p.copy()
    before[end + 12 : end + 24] = p[end : end + 12]  # W at x0 is that of ε0 − ε̂0
    start = x.copy()
    start[:, :3] -= x[:, 12:15]
    start[:, 3:12] = x[:, 15:24]
    w = [element.audit(layout, y.ravel().tolist(), q.tolist())[0] for y, q in ((start, before), (x, p))]
    force = np.array(element.step(layout, x.ravel().tolist(), p.tolist(), nothing)[0]).reshape(3, 2, 3)
    turned = np.swapaxes(x[:, 3:12].reshape(-1, 3, 3), 1, 2) @ x[:, 15:24].reshape(-1, 3, 3)
    skew = turned - np.swapaxes(turned, 1, 2)
    theta = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], -1)
    theta *= 2.0 / (1.0 + np.trace(turned, axis1=1, axis2=2))[:, None]
    assert np.allclose(cay(theta), turned)
    work = float(np.sum(force[:, 0] * x[:, 12:15]) + np.sum(force[:, 1] * theta))
    done = element.lost(layout, x.ravel().tolist(), p.tolist(), nothing)[9]
    assert abs(done) > 0.1 * abs(w[1] - w[0])
    assert work == pytest.approx(w[1] - w[0] - done, abs=1e-11 * max(map(abs, w)))


# --- ledgers of motions


def soft_arm(section: dx.Section, order: int) -> dx.Model:
    """Everything at once, in three dimensions; eight linear elements with a stiffening law would fold."""
    return (
        rod(section, order, 12 // order)
        .clamp("a")
        .gravity((0, 0, -1))
        .actuate("arm", curvature=dx.harmonic((1.0, 0.5), 0.5), twist=lambda t: 0.2 * np.sin(t))
        .tendon("arm", lambda t: 10.0 * np.sin(t) ** 2, offset=((0.1, 0.0), (0.0, 0.05)), name="pull")
        .tendon(("a", "b"), dx.ramp(2.0, 0.5, 1.5), offset=((0, 0, 1), (0, 0, 0.2)), name="stay")
        .drag("arm", 1.0, 0.2, flow=dx.table((0, 2, 5), [(0, 0, 0), (1, 1, 0), (0, -1, 0)]))
        .distributed("arm", (0, 0, 0.3), follower=True)
        .pressure("arm", dx.harmonic(3.0, 1.0), width=0.1, along="-d2")
    )


@pytest.mark.parametrize(
    ("integrator", "section", "order"),
    [
        (dx.EnergyMomentum(), PLAIN, 1),
        (dx.EnergyMomentum(), DAMPED, 2),
        (dx.EnergyMomentum(), FUNG, 1),
        (dx.EnergyDissipating(0.2, 0.1), DAMPED, 1),
    ],
    ids=["conserving", "quadratic", "law", "dissipating"],
)
def test_the_ledger_closes_with_everything_that_drives(integrator, section: dx.Section, order: int) -> None:
    result = dx.simulate(soft_arm(section, order), 8.0, 0.02, integrator=integrator)
    assert result.success, result.status
    assert all(entry.claimed and entry.value <= 1e-11 for entry in result.audit.entries), result.audit.entries
    work, taken = result.energy.work_by_source, result.energy.by_source
    assert {"actuation of rod 'arm'", "tendon 'pull'", "tendon 'stay'", "fluid around rod 'arm'", "loads"} <= set(work)
    assert taken["fluid around rod 'arm'"][-1] > 0.0
    assert all(np.abs(work[name]).max() > 0.0 for name in work if name != "supports")
    np.testing.assert_allclose(sum(work.values()), result.energy.work, atol=1e-12)


def test_midpoint_books_the_same_and_drifts() -> None:
    result = dx.simulate(soft_arm(PLAIN, 1), 2.0, 0.02, integrator=dx.Midpoint())
    energy, *momenta = result.audit.entries[:3]
    assert not energy.claimed and energy.value > 1e-8 and all(e.value <= 1e-11 for e in momenta)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", [dx.EnergyMomentum(), dx.EnergyDissipating(0.2, 0.1)], ids=repr)
def test_ten_thousand_steps(integrator) -> None:
    result = dx.simulate(soft_arm(DAMPED, 1), 200.0, 0.02, integrator=integrator, save_every=100)
    assert result.success and all(entry.value <= 1e-11 for entry in result.audit.entries)


def test_what_the_fluid_takes_has_its_formula() -> None:
    """A rod that falls flat: every point has the same velocity, force −c_n |v| v."""
    result = dx.simulate(rod().drag("arm", 3.0).gravity((0, 0, -2.0)), 1.0, 0.02)
    v = np.diff(result.node("a").r[:, 2]) / 0.02
    taken = np.cumsum(2.0 * 3.0 * np.abs(v) ** 3 * 0.02)  # two long
    np.testing.assert_allclose(result.energy.by_source["fluid around rod 'arm'"][1:], taken, rtol=1e-11)
    assert result.energy.work_by_source["fluid around rod 'arm'"][-1] == 0.0
    # along its axis the other coefficient counts, and relative to a fluid that moves along nothing resists
    along = rod().drag("arm", 3.0, 1.5, flow=(1.0, 0, 0)).rigid_velocity((1.0, 0, 0))
    assert dx.simulate(along, 1.0, 0.1).energy.dissipated[-1] <= 1e-25
    slides = dx.simulate(rod().drag("arm", 3.0, 1.5).rigid_velocity((1.0, 0, 0)), 1.0, 0.001)
    assert slides.node("a").v[-1, 0] == pytest.approx(1.0 / (1.0 + 1.5 / 2.5), rel=1e-6)


def test_the_step_is_second_order_in_what_drives() -> None:
    """Actuation, tendon, flow and follower that vary: errors fall with Δt², and another scheme finds the same."""
    model = rod(DAMPED).clamp("a").actuate("arm", curvature=dx.harmonic((0.3, 0.2), 0.4, mean=(0.0, 0.0)))
    model = model.tendon("arm", lambda t: 3.0 * t**3, offset=(0.05, 0.1)).pressure("arm", lambda t: t**3)
    ends = [dx.simulate(model, 0.4, 0.4 / n).r[-1] for n in (80, 160, 320)]
    ratio = np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[2])
    assert 3.5 < ratio < 4.5
    plain = replace(model, rods=tuple(replace(r, section=PLAIN) for r in model.rods))
    ours, theirs = (dx.simulate(plain, 0.4, 0.001, integrator=i).r[-1] for i in (dx.EnergyMomentum(), dx.Newmark()))
    assert np.abs(ours - theirs).max() <= 1e-4 * np.abs(ours).max()


# --- equilibria


def test_an_actuated_rod_is_an_arc_without_stress() -> None:
    kappa, model = 1.2, rod(elements=8, order=2).clamp("a").actuate("arm", curvature=(1.2, 0.0))
    result = dx.solve_static(model, steps=3)
    assert result.success and result.audit.passed
    # bending about d1 = y turns d3 = x towards −d2 = −z
    tip = (np.sin(2 * kappa) / kappa, 0.0, -(1.0 - np.cos(2 * kappa)) / kappa)
    np.testing.assert_allclose(result.node("b").r[-1], tip, atol=2e-3)
    assert np.abs(result.rod("arm").force).max() <= 1e-8 and np.abs(result.node("a").reaction).max() <= 1e-8
    assert result.energy.stored[-1] <= 1e-15 and abs(result.energy.work[-1]) <= 1e-10
    assert result.rod("arm").strain[-1, :, 3] == pytest.approx(kappa, abs=1e-9)
    # it vibrates as one that was made curved
    made = dx.Model().rod(dx.arc((0, 0, 0), _on(kappa, 1.0), _on(kappa, 2.0), d1=(0, 1, 0)), PLAIN, ends=("a", "b"),
                          elements=8).clamp("a")  # fmt: skip
    ours, theirs = dx.modes(model, result, 4).frequencies, dx.modes(made, count=4).frequencies
    np.testing.assert_allclose(ours, theirs, rtol=2e-3)
    np.testing.assert_allclose(dx.modes(rod(elements=8, order=2).clamp("a"), count=1).frequencies[0], 0.5, rtol=0.6)


def _on(kappa: float, s: float) -> tuple[float, float, float]:
    return (float(np.sin(kappa * s) / kappa), 0.0, float(-(1.0 - np.cos(kappa * s)) / kappa))


def test_actuation_against_a_support_does_the_work_that_is_stored() -> None:
    """Elongation between two clamps: N = −EA ε̂, stored ½ EA ε̂² L, all of it the actuation's work."""
    model = rod(elements=2).clamp("a").clamp("b").actuate("arm", elongation=lambda t: 0.02 * t)
    result = dx.solve_static(model, steps=4)
    np.testing.assert_allclose(result.rod("arm").force[-1, :, 2], -2500 * 0.02, rtol=1e-12)
    np.testing.assert_allclose(result.energy.stored[-1], 0.5 * 2500 * 0.02**2 * 2, rtol=1e-12)
    assert result.energy.work_by_source["actuation of rod 'arm'"][-1] == pytest.approx(result.energy.stored[-1])


def test_a_travelling_wave_of_curvature_reaches_every_station() -> None:
    model = rod(elements=6).clamp("a").actuate("arm", curvature=lambda t, s: (t * np.sin(s), 0.0), along=True)
    result = dx.solve_static(model, steps=1)
    arm = result.rod("arm")
    np.testing.assert_allclose(arm.strain[-1, :, 3], np.sin(arm.s), atol=1e-9)


def test_a_tendon_bends_and_shortens_as_its_energy_says() -> None:
    """Parallel to the axis at ξ: κ = T ξ/EI and Γ3 = −T/EA all along; straight between the ends of linear elements it
    adds T h²/4 to EI."""
    T, xi = 20.0, 0.1
    gaps: list[float] = []
    for elements in (8, 16):
        model = rod(elements=elements).clamp("a").tendon("arm", T, offset=(0.0, xi))
        result = dx.solve_static(model, steps=2)
        assert result.success and result.audit.passed
        strain = result.rod("arm").strain[-1].mean(axis=0)
        expected = np.array([0, 0, -T / 2500, -T * xi / 10, 0, 0])
        gaps.append(float(np.abs(strain - expected).max()))
        assert result.energy.work_by_source["tendon 'tendon1'"][-1] == pytest.approx(result.energy.stored[-1], rel=0.02)
        free = dx.solve_static(model, control=dx.ArcLength(ds=0.2, load_factors=(1.0,), until=_at_one))
        np.testing.assert_allclose(free.r[-1], result.r[-1], atol=1e-7)
    assert gaps[0] <= 1.05 * (T * xi / 10) * (T * 0.25**2 / 4) / 10 and gaps[0] / gaps[1] > 3.5


def _at_one(snapshot: dx.Snapshot) -> bool:
    return snapshot.load_factor >= 1.0


def test_a_ring_under_pressure_has_the_hoop_force() -> None:
    radius, p, width = 2.0, 3.0, 0.5
    model = dx.Model()
    for name, ends, points in (
        ("one", ("A", "B"), ((radius, 0, 0), (0, radius, 0), (-radius, 0, 0))),
        ("two", ("B", "A"), ((-radius, 0, 0), (0, -radius, 0), (radius, 0, 0))),
    ):
        model = model.rod(dx.arc(*points, d1=points[0]), PLAIN, name=name, ends=ends, elements=12, order=2)
        model = model.pressure(name, p, width=width, along="d1")
    result = dx.solve_static(model.clamp("A"), steps=2)
    assert result.success
    np.testing.assert_allclose(result.rod("one").force[-1, :, 2], p * width * radius, rtol=1e-3)
    assert np.abs(result.node("A").reaction[-1]).max() <= 1e-6


def test_a_pressure_is_a_follower_along_a_director() -> None:
    one = dx.solve_static(rod().clamp("a").pressure("arm", 20.0, width=0.5, along="-d1"), steps=3)
    two = dx.solve_static(rod().clamp("a").distributed("arm", (0, -10.0, 0), follower=True), steps=3)
    np.testing.assert_allclose(one.r[-1], two.r[-1], atol=1e-12)
    dead = dx.solve_static(rod().clamp("a").distributed("arm", (0, -10.0, 0)), steps=3)
    assert np.abs(one.r[-1] - dead.r[-1]).max() > 1e-2


def test_a_reed_in_a_current_bends_by_q_over_8() -> None:
    """A small steady deflection q L⁴/8EI + shear, q = c_n U²; along the axis the current only pulls."""
    c, u = 0.02, 0.3
    model = rod(elements=16).clamp("a").drag("arm", c, flow=(0, u, 0))
    result = dx.solve_static(model, steps=2)
    q = c * u * u
    assert result.node("b").displacement[-1, 1] == pytest.approx(q * 2**4 / (8 * 12) + q * 2**2 / (2 * 950), rel=5e-3)
    np.testing.assert_allclose(result.node("a").reaction[-1, :3], (0, -q * 2, 0), atol=1e-3 * q)
    assert result.audit.passed and result.energy.work_by_source["fluid around rod 'arm'"][-1] > 0.0


def test_a_chain_with_a_tendon_is_still_a_chain() -> None:
    result = dx.solve_static(rod().clamp("a").tendon("arm", 1.0), steps=1)
    assert result.info["solver"] == "chain"


# --- functions of time


def test_functions_of_time_print_compare_and_pickle() -> None:
    ramp, wave = dx.ramp((0, 0, 2), 1.0, 3.0), dx.harmonic(2.0, 0.25, np.pi / 2)
    table = dx.table((0, 1, 3), [(0, 0, 0), (2, 0, 0), (2, 4, 0)])
    np.testing.assert_allclose([ramp(t)[2] for t in (0, 1, 2, 3, 9)], [0, 0, 1, 2, 2])
    np.testing.assert_allclose([wave(t) for t in (0, 1, 2)], [2, 0, -2], atol=1e-15)
    np.testing.assert_allclose(table(2.0), (2, 2, 0))
    np.testing.assert_allclose(dx.table((0, 1), (1, 3))(0.5), 2.0)
    for function in (ramp, wave, table):
        assert pickle.loads(pickle.dumps(function)) == function and "t0" in repr(ramp)
    assert ramp == dx.ramp([0.0, 0.0, 2.0], 1, 3) and ramp != dx.ramp((0, 0, 2))
    for bad in (
        lambda: dx.ramp(1.0, 2.0, 1.0),
        lambda: dx.harmonic(1.0, 0.0),
        lambda: dx.table((0, 0), (1, 2)),
        lambda: dx.table((0, 1), (1,)),
        lambda: dx.table(1, 2),
        lambda: dx.ramp("x"),
        lambda: dx.harmonic((1, 2), 1.0, mean=(1, 2, 3)),
    ):
        with pytest.raises(dx.ModelError):
            bad()


# --- what is refused


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: rod().actuate("arm"), "nothing actuates"),
        (lambda: rod().actuate("leg", twist=1.0).check(), "no rod 'leg'"),
        (lambda: rod().actuate("arm", curvature=(1, 2, 3)), "not 2 finite numbers"),
        (lambda: rod().actuate("arm", twist=1.0).actuate("arm", twist=1.0), "actuated twice"),
        (lambda: rod().actuate("arm", strain=lambda t: (1, 2)).check(), "not 6 finite numbers"),
        (lambda: rod().tendon("arm", -1.0), "tension"),
        (lambda: rod().tendon(("a",), 1.0), "node to node"),
        (lambda: rod().tendon(("a", "z"), 1.0).check(), "no node 'z'"),
        (lambda: rod().tendon("arm", 1.0, offset=(1, 2, 3)), "two pairs"),
        (lambda: rod().tendon(("a", "b"), 1.0, offset=((0, 0, 1),)), "one offset for each"),
        (lambda: rod().tendon("arm", 1.0, name="x").tendon("arm", 1.0, name="x"), "two tendons"),
        (lambda: rod().tendon("arm", lambda t: -1.0).check(), "does not push"),
        (lambda: rod().drag("arm", 0.0), "no coefficient"),
        (lambda: rod().drag("arm", 1.0).drag("arm", 1.0), "two drags"),
        (lambda: rod().pressure("arm", 1.0, along="d3"), "direction of a pressure"),
        (lambda: rod().pressure("arm", (1, 2, 3)), "not a number"),
        (lambda: dx.simulate(rod().drag("arm", 1.0), 1, 0.1, integrator=dx.Newmark()), "drag on rod 'arm' has no form"),
        (
            lambda: dx.simulate(rod().tendon("arm", 1.0), 1, 0.1, integrator=dx.SimoTarnowDoblare()),
            "tendon 'tendon1' has no form",
        ),
        (
            lambda: dx.solve_static(rod().clamp("a").actuate("arm", twist=1), formulation=dx.SimoVuQuoc()),
            "rotations of its own",
        ),
        (lambda: dx.buckling(rod().clamp("a").force("b", (-1, 0, 0)).tendon("arm", 1.0)), "linearised buckling"),
    ],
)
def test_what_cannot_drive_is_refused(make, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        make()
    assert error.value.fix


def test_a_function_that_fails_on_the_way_keeps_what_there_is() -> None:
    model = rod().clamp("a").tendon("arm", lambda t: 1.0 - t)
    result = dx.simulate(model, 2.0, 0.1)
    assert result.status.code == "bad_input" and "does not push" in result.status.sentence and result.t[-1] > 0.9


# --- case files


def test_a_case_file_says_all_of_it(tmp_path) -> None:
    text = """
    [section.soft]
    kind = "moduli"
    EA = 2500
    GA1 = 950
    GA2 = 900
    EI1 = 10
    EI2 = 12
    GJ = 8
    A_rho = 2.5
    I_rho1 = 0.012
    I_rho2 = 0.01
    [[rod]]
    name = "arm"
    section = "soft"
    line = [[0, 0, 0], [2, 0, 0]]
    d1 = [0, 1, 0]
    ends = ["a", "b"]
    elements = 4
    order = 1
    [[support]]
    node = "a"
    type = "clamp"
    [[distributed]]
    rod = "arm"
    value = [0, 0, 0.3]
    follower = true
    [[pressure]]
    rod = "arm"
    value = 3
    width = 0.1
    along = "-d2"
    time = { kind = "sine", frequency = 1 }
    [[actuate]]
    rod = "arm"
    curvature = [1, 0.5]
    twist = 0.1
    time = { kind = "ramp", until = 2 }
    [[tendon]]
    name = "pull"
    rod = "arm"
    tension = 4
    offset = [0.1, 0]
    offset_end = [0, 0.05]
    time = { kind = "table", t = [0, 1], value = [0, 1] }
    [[tendon]]
    nodes = ["a", "b"]
    tension = 2
    [[drag]]
    rod = "arm"
    normal = 1
    tangential = 0.2
    flow = [1, 0, 0]
    time = { kind = "pulse", end = 1 }
    [dynamics]
    t_end = 0.1
    dt = 0.02
    """
    (tmp_path / "case.toml").write_text(text)
    case = load_case(tmp_path / "case.toml")
    model = (
        rod()
        .clamp("a")
        .distributed("arm", (0, 0, 0.3), follower=True)
        .pressure("arm", dx.harmonic(3.0, 1.0), width=0.1, along="-d2")
        .actuate("arm", curvature=dx.ramp((1, 0.5), 0, 2), twist=dx.ramp(0.1, 0, 2))
        .tendon("arm", dx.table((0, 1), (0, 4)), offset=((0.1, 0), (0, 0.05)), name="pull")
        .tendon(("a", "b"), 2.0)
    )
    assert case.model.loads == model.loads and case.model.tendons == model.tendons
    assert case.model.actuations == model.actuations
    assert case.model.drags[0].tangential == 0.2 and tuple(case.model.drags[0].flow(0.5)) == (1.0, 0.0, 0.0)
    assert case.run().success
    from directrix.schema.describe import describe

    page = describe(case)
    words = ("pressure on arm", "actuation of arm: curvature", "tendon pull: along arm", "through a – b", "drag on")
    assert [word for word in words if word not in page] == []
