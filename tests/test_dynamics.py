"""What a motion must keep, whatever the step: laws, reversibility, order, and how it ends when it cannot go on."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx


def section() -> dx.Section:
    """A soft section."""
    return dx.Section.from_moduli(EA=2500, GA1=950, GA2=950, EI1=10, EI2=12, GJ=8, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)


def flying(order: int = 1, elements: int = 6) -> dx.Model:
    return (
        dx.Model(name="flying rod")
        .rod(
            dx.line((1, 0, 0), (4, 0, 1)),
            section(),
            name="rod",
            ends=("a", "b"),
            elements=elements,
            order=order,
        )
        .velocity("a", (0.3, 1.0, -2.0), omega=(1.0, 0.5, 2.0))
        .velocity("b", (0.0, -1.0, 1.0))
    )


def tripod(order: int = 1) -> dx.Model:
    """Three rods on one node: not a chain."""
    model = dx.Model(name="tripod")
    for k, tip in enumerate([(2, 0, 0), (0, 2, 0), (-1, -1, 1)]):
        model = model.rod(
            dx.line((0, 0, 0), tip),
            section(),
            name=f"leg{k}",
            ends=("hub", f"tip{k}"),
            elements=3,
            order=order,
        )
    return model.velocity("tip0", (0, 0, 2)).velocity("tip1", (1, 0, 0)).velocity("hub", (0, 0, -0.5), omega=(0, 1, 1))


@pytest.mark.parametrize("model", [flying(1), flying(2), flying(3), tripod(1), tripod(2)], ids=lambda m: m.name)
def test_free_flight_conserves_for_every_order_and_solver(model: dx.Model) -> None:
    result = dx.simulate(model, t_end=5.0, dt=0.05)
    assert result.success and result.audit.passed
    assert result.info["solver"] == ("sparse" if model.name == "tripod" else "chain")
    assert np.abs(result.energy.residual).max() <= 1e-12 * result.energy.total[0]
    for momentum in (result.momentum.linear, result.momentum.angular):
        assert np.abs(momentum - momentum[0]).max() <= 1e-11 * np.abs(momentum[0]).max()


def test_loads_and_moving_supports_are_booked() -> None:
    model = (
        dx.Model(name="driven")
        .rod(dx.line((0, 0, 0), (3, 0, 0)), section(), name="rod", ends=("a", "b"), elements=6)
        .prescribe(
            "a",
            displacement=lambda t: (0.2 * np.sin(2 * t), 0.1 * t, 0.0),
            rotation=lambda t: (0.3 * np.sin(t), 0.0, 0.4 * (1 - np.cos(3 * t))),
        )
        .force("b", lambda t: (0.0, 2.0 * np.sin(3 * t), 1.0))
        .moment("b", (1.0, 0.0, 0.5))
        .distributed("rod", (0.0, 0.0, -1.0))
        .gravity((0, 0, -2.0))
    )
    result = dx.simulate(model, t_end=4.0, dt=0.05)
    assert result.success and result.audit.passed
    turnover = np.abs(np.diff(result.energy.work)).sum()
    assert np.abs(result.energy.residual).max() <= 1e-11 * turnover
    assert np.ptp(result.energy.prescribed) > 0.1  # J
    assert np.ptp(result.energy.work - result.energy.prescribed) > 0.1  # J
    np.testing.assert_allclose(result.node("a").displacement[-1], [0.2 * np.sin(8.0), 0.4, 0.0], atol=1e-14)


@pytest.mark.parametrize("integrator", [dx.EnergyMomentum(), dx.EnergyDissipating(0.3)], ids=repr)
def test_a_support_that_begins_elsewhere_has_done_no_work(integrator) -> None:
    """It is there at t = 0: the energy of that is what the run begins with, not what the first step brings in."""
    model = dx.Model().rod(dx.line((0, 0, 0), (3, 0, 0)), section(), name="rod", ends=("a", "b"), elements=6, order=1)
    model = model.clamp("a").prescribe("b", displacement=(0.0, 0.2, 0.1), rotation=(0.2, 0.1, 0.0))
    result = dx.simulate(model, t_end=0.5, dt=0.05, integrator=integrator)
    assert result.success and result.audit.passed and result.energy.stored[0] > 0.1
    assert np.abs(result.energy.residual).max() <= 1e-11 * result.energy.total[0]
    np.testing.assert_allclose(result.energy.work, 0.0, atol=1e-12 * result.energy.total[0])


def test_going_on_from_a_result_is_the_same_motion() -> None:
    whole = dx.simulate(flying(), t_end=2.0, dt=0.05)
    half = dx.simulate(flying(), t_end=1.0, dt=0.05)
    rest = dx.simulate(flying(), t_end=2.0, dt=0.05, start=half)
    np.testing.assert_allclose(rest.r[-1], whole.r[-1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(rest.v[-1], whole.v[-1], rtol=0, atol=1e-11)


@pytest.mark.parametrize("steps", [10_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_many_steps(steps: int) -> None:
    result = dx.simulate(flying(), t_end=steps * 0.05, dt=0.05, save_every=1000)
    assert result.success and len(result.iterations) == steps
    scale = np.linalg.norm(result.momentum.linear[0])
    assert np.abs(result.momentum.linear - result.momentum.linear[0]).max() <= 1e-11 * scale
    assert np.abs(result.energy.residual).max() <= 1e-10 * result.energy.total[0]


def test_a_value_that_is_not_finite_stops_the_run_and_names_the_node() -> None:
    """Kinetic energy beyond what a double holds."""
    result = dx.simulate(_too_fast(), t_end=1.0, dt=0.5)
    assert not result.success
    assert result.status.code == "non_finite"
    assert "'b'" in result.status.sentence or " b" in result.status.sentence


def _too_fast() -> dx.Model:
    return (
        dx.Model()
        .rod(dx.line((0, 0, 0), (3, 0, 0)), section(), name="rod", ends=("a", "b"), elements=1, order=1)
        .clamp("a")
        .velocity("b", (1e200, 0, 0))
    )


def test_a_step_that_does_not_converge_gives_what_there_is() -> None:
    model = flying().force("b", lambda t: (0.0, 0.0, 0.0 if t < 0.5 else 1e7))
    result = dx.simulate(model, t_end=2.0, dt=0.1)
    assert not result.success and 0.3 < result.t[-1] < 0.7
    assert len(result.r) == len(result.t) and np.all(np.isfinite(result.r))
    assert f"t = {result.t[-1]:g}" in result.status.sentence and result.status.advice
    with pytest.raises(dx.ConvergenceError) as error:
        dx.simulate(model, t_end=2.0, dt=0.1, raise_on_failure=True)
    assert error.value.result.t[-1] == result.t[-1]


@pytest.mark.parametrize("save_every", [1, 4, 100])
def test_the_last_state_is_kept_however_a_run_ends(save_every: int) -> None:
    """Interrupted after 7 of 20 steps, a load function that fails, a step that does not converge."""

    def interrupt(done: float, _: str) -> None:
        if done > 0.33:
            raise KeyboardInterrupt

    whole = dx.simulate(flying(), t_end=1.0, dt=0.05)
    runs = [
        dx.simulate(flying(), 1.0, 0.05, save_every=save_every, progress=interrupt),
        dx.simulate(flying().force("b", lambda t: (0, 0, 0) if t < 0.35 else None), 1.0, 0.05, save_every=save_every),
        dx.simulate(flying().force("b", lambda t: (0, 0, 0 if t < 0.35 else 1e200)), 1.0, 0.05, save_every=save_every),
    ]
    for result in runs:
        assert not result.success and result.t[-1] == pytest.approx(0.35)
        np.testing.assert_allclose(result.r[-1], whole.r[7], rtol=0, atol=1e-12)
        np.testing.assert_allclose(result.v[-1], whole.v[7], rtol=0, atol=1e-11)
        assert result.energy.total[-1] == pytest.approx(whole.energy.total[7], rel=1e-12)


def test_an_interruption_keeps_what_there_is() -> None:
    def stop(done: float, _: str) -> None:
        if done > 0.5:
            raise KeyboardInterrupt

    result = dx.simulate(flying(), t_end=1.0, dt=0.1, progress=stop)
    assert result.status.code == "interrupted" and not result.success
    assert 0.5 <= result.t[-1] < 1.0


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({"dt": 0.0}, "dt"),
        ({"dt": float("nan")}, "dt"),
        ({"t_end": -1.0}, "t_end"),
        ({"dt": 0.3}, "dt"),
        ({"load_rule": "end"}, "load_rule"),
        ({"save_every": 0}, "save_every"),
        ({"integrator": "midpoint"}, "integrator"),
        ({"formulation": "directors"}, "formulation"),
        ({"tolerance": -1.0}, "tolerance"),
    ],
)
def test_arguments_that_cannot_be_right_are_refused_by_name(change: dict, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        dx.simulate(flying(), **{"t_end": 1.0, "dt": 0.1, **change})
    assert error.value.fix


def test_a_step_that_the_first_damping_does_not_solve_is_tried_with_another() -> None:
    """A violent start on two elements: one step of it needs more than 50 iterations, and then it goes on exactly."""
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (2, 1, -2), d1=(0, 1, 0)), section(), name="rod", ends=("a", "b"), elements=2, order=1)
        .velocity("a", (0.390625, 0.0, -0.921875), omega=(1.0, 0.5, 0.0))
        .velocity("b", (0.0, 0.125, 0.9375))
        .force("b", (0, 1, 0))
    )
    result = dx.simulate(model, t_end=1.0, dt=0.05)
    assert result.success and result.audit.passed and result.iterations.max() > 50
