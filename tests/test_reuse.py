"""Factors that are kept: the same right-hand sides, the same states as with a new tangent in every iteration."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from test_contact import crossing

import directrix as dx
from directrix import motion, statics
from directrix.discretisation import discretise
from directrix.kernels import step
from directrix.kernels.elements import internal_forces, right_side
from directrix.linear.condensed import Condensed
from directrix.newton import Newton, Outcome, Settings
from directrix.result import Result, Status
from directrix.state import initial_state

SECTION = dx.Section.rectangle(0.04, 0.05, E=1e8, nu=0.3, rho=1000)


def star(order: int, elements: int = 2) -> dx.Model:
    """Three arms from a hub, two clamped outside; a hinge at the third, and a rod that hangs from it."""
    model = dx.Model(name="star")
    for name, end in (("a", (1, 0, 0)), ("b", (0, 1, 0.2)), ("c", (-1, -0.5, 0))):
        model = model.rod(
            dx.line((0, 0, 0), end), SECTION, name=name, ends=("hub", name), elements=elements, order=order
        )
    model = model.rod(
        dx.line((-1, -0.5, 0), (-1.5, -1, 0)), SECTION, name="d", ends=("d0", "d"), elements=elements, order=order
    )
    return model.clamp("a").clamp("b").hinge("c", "d0", axis=(0, 0, 1), name="hinge")


def busy(order: int) -> dx.Model:
    """With all that has forces of its own: a floor, a spring, a body, a follower."""
    model = star(order).gravity((0, 0, -9.81)).spring("hub", "d", 50.0, name="spring").point_mass("d", 0.5)
    floor = dx.Plane((0, 0, -0.001), (0, 0, 1))
    return model.force("d", (3.0, 0, 1.0), follower=True).contact(
        floor, stiffness=1e5, radius=0.0, width=1e-3, name="floor"
    )


@pytest.mark.parametrize(
    ("order", "integrator"),
    [(1, dx.EnergyMomentum()), (2, dx.EnergyDissipating(0.2)), (2, dx.GeneralizedAlpha(0.8)), (3, dx.EnergyMomentum())],
    ids=repr,
)
def test_a_right_hand_side_by_itself_is_that_of_the_assembly(order: int, integrator: dx.Integrator) -> None:
    """With nodes inside elements, that are condensed, multipliers, supports, and nodes that touch a floor."""
    scheme = integrator.scheme(0.01)
    disc = discretise(busy(order), scheme)
    newton, x = Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)
    rng, work = np.random.default_rng(1), newton.work
    x[: disc.nodes, :3] += 1e-3 * rng.standard_normal((disc.nodes, 3))
    x[disc.nodes : disc.rows, :6] += rng.standard_normal((disc.rows - disc.nodes, 6))
    external = disc.external(0.0)
    newton.begin(x)
    step.assemble(newton.tables, work, x, newton.globals, external, newton.mask, False)
    rhs, inside, blocks = work.rhs.copy(), work.back[:, 12].copy(), work.blocks.copy()
    work.rhs[:] = work.back[:, 12] = 0.0
    internal_forces(newton.tables, work, x, newton.globals, external)
    right_side(newton.tables, work, newton.mask)
    np.testing.assert_allclose(work.rhs, rhs, rtol=0, atol=1e-12 * np.abs(rhs).max())
    np.testing.assert_allclose(work.back[:, 12], inside, rtol=0, atol=1e-12 * np.abs(inside).max(initial=0.0))
    assert (inside.size > 0) == (order > 1) and work.blocks.tobytes() == blocks.tobytes()


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """How often the solver was asked for new factors, and to go through those that are there."""
    count = {"solve": 0, "again": 0}

    def counted(name: str) -> Callable[..., object]:
        plain = getattr(Condensed, name)

        def ask(self: Condensed, *given: object, **more: object) -> object:
            count[name] += 1
            return plain(self, *given, **more)

        return ask

    for name in count:
        monkeypatch.setattr(Condensed, name, counted(name))
    return count


def both(
    run: Callable[[], Result], asked: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> tuple[Result, Result, int]:
    """A run with a new tangent each time and one that keeps factors; how many factorizations more the first takes."""
    with monkeypatch.context() as patch:
        for module in (motion, statics):
            patch.setattr(module, "Settings", lambda *a, **k: Settings(*a, **{**k, "reuse": False}))
        fresh = run()
    assert asked["again"] == 0 and asked["solve"] >= fresh.iterations.sum()
    more = asked["solve"]
    asked.update(solve=0, again=0)
    kept = run()
    assert fresh.success and kept.success and kept.audit.passed
    return fresh, kept, more - asked["solve"]


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_motion_is_the_same_with_half_of_the_factorizations(
    order: int, asked: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    model = star(order).gravity((0, 0, -9.81))
    fresh, kept, saved = both(lambda: dx.simulate(model, 0.5, 0.01), asked, monkeypatch)
    assert asked["again"] > 0 and saved >= 0.3 * fresh.iterations.sum()
    np.testing.assert_allclose(kept.r, fresh.r, rtol=0, atol=1e-10)
    np.testing.assert_allclose(kept.R, fresh.R, rtol=0, atol=1e-10)
    worst = [max(entry.value for entry in run.audit.entries) for run in (fresh, kept)]
    assert worst[1] <= max(2.0 * worst[0], 1e-12)
    assert kept.trail.count.tolist() == kept.iterations.tolist() and np.isfinite(kept.trail.rows).all()


def test_load_steps_and_busy_motions_are_the_same(asked: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    model = star(2).gravity((0, 0, -9.81)).spring("hub", "d", 50.0, name="spring").pin("d")
    for run, least in (
        (lambda: dx.solve_static(model, steps=3), 0.1),
        (lambda: dx.simulate(busy(2), 0.2, 0.005), 0.1),
        (lambda: dx.simulate(star(1).gravity((0, 0, -9.81)), 0.2, 0.01, integrator=dx.GeneralizedAlpha(0.8)), 0.2),
    ):
        asked.update(solve=0, again=0)
        fresh, kept, saved = both(run, asked, monkeypatch)
        assert saved >= least * fresh.iterations.sum()
        np.testing.assert_allclose(kept.r, fresh.r, rtol=0, atol=1e-10)


def stepped(newton: Newton, x: np.ndarray, k: int) -> None:
    loads = newton.disc.external(0.002 * (k + 0.5))
    newton.begin(x)
    assert newton.solve(x, loads).status is None
    newton.finish(x)


def swung() -> tuple[Newton, np.ndarray]:
    model = star(2).gravity((0, 0, -9.81)).force("d", dx.ramp((2.0, 0, 0.5), 0.0, 0.1), follower=True)
    scheme = dx.EnergyMomentum().scheme(0.002)
    disc = discretise(model, scheme)
    return Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)


def test_factors_of_the_step_before_are_made_again_bit_by_bit(asked: dict[str, int]) -> None:
    """Of any step, though they are some steps old: what they were made of is remembered."""
    (newton, x), made = swung(), list[int]()
    for k in range(16):
        memory, start = copy.deepcopy(newton.remember()), x.copy()
        asked.update(solve=0, again=0)
        stepped(newton, x, k)
        made.append(asked["solve"])
        again, _ = swung()
        again.recall(memory)
        stepped(again, start, k)
        assert start.tobytes() == x.tobytes()
    assert made[0] == 2 and max(made[1:]) == 1 and 0 in made, made


def test_steps_of_another_length_and_after_failures_begin_anew(asked: dict[str, int]) -> None:
    newton, x = swung()
    for k in range(3):
        stepped(newton, x, k)
    assert newton._tangent is not None
    x = newton.retime(dx.EnergyMomentum().scheme(0.001), x)
    assert newton._tangent is None
    asked.update(solve=0, again=0)
    stepped(newton, x, 3)
    assert asked["solve"] >= 1 and newton._tangent is not None
    newton.begin(x)
    far = newton.disc.external(0.0)
    far[:, :3] += 1e12
    assert newton.solve(x, far).status is not None and newton._tangent is None


def test_a_step_that_fails_through_old_factors_is_taken_without(monkeypatch: pytest.MonkeyPatch) -> None:
    model = star(1).gravity((0, 0, -9.81))
    usual = dx.simulate(model, 0.05, 0.01)
    plain, failed = Newton._iterate, list[int]()

    def failing(self: Newton, tables: object, x: np.ndarray, external: np.ndarray, moved: bool, kept: bool = False):
        if not kept:
            return plain(self, tables, x, external, moved)
        x[:] = np.nan
        failed.append(1)
        return Outcome(1, Status("not_converged", "far away.", "None."))

    monkeypatch.setattr(Newton, "_iterate", failing)
    result = dx.simulate(model, 0.05, 0.01)
    assert result.success and len(failed) == 4 and result.info["cuts"] == 0
    np.testing.assert_allclose(result.r, usual.r, rtol=0, atol=1e-12)


def test_what_is_very_stiff_keeps_its_last_digits(asked: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    """What rounding leaves in its forces, an old tangent would turn out of balance."""
    stiff = dx.Section.rectangle(0.04, 0.05, E=1e16, nu=0.3, rho=1000)
    model = dx.Model(name="four-bar")
    for name, ends in (("crank", ((0, 0, 0), (0, 0, 0.1))), ("rod", ((0, 0, 0.1), (0.5, 0, 0.3)))):
        model = model.rod(dx.line(*ends), stiff, name=name, elements=2)
    model = model.rod(dx.line((0.5, 0, 0.3), (0.5, 0, 0)), stiff, name="rocker", elements=2)
    for a, b in (("crank.start", None), ("crank.end", "rod.start"), ("rod.end", "rocker.start")):
        model = model.hinge(a, *(() if b is None else (b,)), axis=(0, 1, 0))
    model = model.spherical("rocker.end").rigid_velocity((0, 0, 0), (0, 0, 0)).moment("crank.end", (0, 1.0, 0))
    fresh, kept, _ = both(lambda: dx.simulate(model, 0.1, 1e-3), asked, monkeypatch)
    worst = [max(entry.value for entry in run.audit.entries) for run in (fresh, kept)]
    assert worst[1] <= max(10.0 * worst[0], 1e-12), worst


@pytest.mark.parametrize("answer", ["none", "not finite"])
def test_factors_that_are_no_good_make_room_for_a_new_tangent(answer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model = star(1).gravity((0, 0, -9.81))
    usual = dx.simulate(model, 0.05, 0.01)
    monkeypatch.setattr(Condensed, "again", lambda self, rhs: None if answer == "none" else np.full_like(rhs, np.inf))
    result = dx.simulate(model, 0.05, 0.01)
    assert result.success and result.info["cuts"] == 0 and result.iterations.sum() > usual.iterations.sum()
    np.testing.assert_allclose(result.r, usual.r, rtol=0, atol=1e-12)


def test_rods_that_rub_have_a_new_tangent_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """From where they come near one another on; not while they fly."""
    rough, through = list[bool](), Newton._through

    def noticed(self: Newton) -> object:
        rough.append(self.rough)
        return through(self)

    monkeypatch.setattr(Newton, "_through", noticed)
    model = crossing(1, friction=0.3, slip_speed=0.01).spring("a.start", "b.start", 10.0).spring("a.end", "b3", 10.0)
    result = dx.simulate(model, 0.1, 2e-3)
    assert result.success and result.contact("both").force.max() > 0.0
    assert rough and not any(rough)


def test_where_a_tangent_is_new_each_time(asked: dict[str, int]) -> None:
    """Friction, and rotations that are carried from iteration to iteration."""
    rough = dataclasses.replace(busy(1), contacts=()).contact(
        dx.Plane((0, 0, -0.1), (0, 0, 1)), stiffness=1e5, friction=0.3, slip_speed=0.01, radius=0.02
    )
    assert dx.simulate(rough, 0.02, 0.005).success
    carried = dataclasses.replace(star(1), joints=()).clamp("d").gravity((0, 0, -1))
    assert dx.solve_static(carried, steps=1, formulation=dx.SimoVuQuoc()).success
    assert asked["solve"] > 0 and asked["again"] == 0
