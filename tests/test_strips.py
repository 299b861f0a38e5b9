"""The fast way through a motion computes what the general way computes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import directrix as dx
from directrix import dynamics, strips
from directrix.discretisation import discretise
from directrix.kernels.compile import LANES
from directrix.kernels.rows import ROW
from directrix.kernels.strip_steps import RESULTS, TANGENTS
from directrix.kernels.team import Team
from directrix.newton import Newton, Settings
from directrix.state import initial_state
from directrix.strips import strips_for
from directrix.telling import now_and_then

RUBBER = dx.Section.circle(radius=0.02, E=5e6, nu=0.5, rho=1100)
LINE = dx.line((0, 0, 0), (1, 0, 0))
CHORDS = dx.arc((0, 0, 0), (1, 1, 0), (2, 0, 0), directors="chord")


@pytest.fixture(autouse=True)
def short_chains_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strips, "FEWEST", 0)


def rod(curve: dx.Curve = LINE, elements: int = 21, order: int = 1, **more: Any) -> dx.Model:
    return dx.Model().rod(curve, RUBBER, name="rod", ends=("A", "B"), elements=elements, order=order, **more)


def flight(elements: int) -> dx.Model:
    return rod(elements=elements).velocity("A", (0, 0, -1)).velocity("B", (0, 0.5, 1), (3, 0, 1))


def corner() -> dx.Model:
    model = rod(elements=9).rod(dx.line((1, 0, 0), (1, 1, 0)), RUBBER, ends=("B", "C"), elements=8, order=1)
    return model.clamp("A").gravity((0, 0, -9.81)).moment("C", (0, 0.02, 0.01))


CASES = {
    "flight, five lanes long and one left over": flight(21),
    "nothing left over": flight(24),
    "swing": rod().pin("A").gravity((0, 0, -9.81)),
    "held inside": rod(elements=20).pin("A").clamp("B").force("A", (1, 0, 0)).gravity((0, -9.81, 0)),
    "held between its ends": rod(elements=20, nodes={"P": 0.1, "Q": 0.6}).pin("P").fix("Q", "x", "y")
    .gravity((0, 0, -9.81)).velocity("B", (0, 0.3, 0.5)),
    "quadratic and held between its ends": rod(elements=10, order=2, nodes={"P": 0.1, "Q": 0.35}).pin("P")
    .fix("Q", "z", "rx", "ry").gravity((0, 0, -9.81)).velocity("B", (0, 0.3, 0.5)),
    "directors along chords": rod(CHORDS).pin("A").gravity((0, 0, -9)),
    "a corner": corner(),
    "quadratic": rod(elements=9, order=2).pin("A").gravity((0, -2, -9.81)).moment("B", (0, 0.02, 0.01)),
    "quadratic and bent": rod(dx.arc((0, 0, 0), (1, 1, 0), (2, 0, 0)), 8, 2).velocity("A", (0, 0, -1)),
    "a load that changes": rod().clamp("A").force("B", lambda t: (0.0, 0.0, 5.0 * np.sin(9 * t))),
    "against the chain": dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), RUBBER, ends=("B", "A"), elements=9, order=1)
    .rod(dx.line((-1, 0, 0), (0, 0, 0)), RUBBER, ends=("C", "B"), elements=9, order=1).pin("C").gravity((0, 0, -9)),
}  # fmt: skip


def both(model: dx.Model, monkeypatch: pytest.MonkeyPatch, **options: object) -> tuple[dx.Result, dx.Result]:
    """The second one in the general way."""
    fast = dx.simulate(model, **options)
    with monkeypatch.context() as patched:
        patched.setattr(dynamics, "fast_for", lambda *_: None)
        return fast, dx.simulate(model, **options)


def qualifies(model: dx.Model, integrator: dx.Integrator | None = None) -> bool:
    scheme = (integrator or dx.EnergyMomentum()).scheme(0.01)
    disc = discretise(model, scheme)
    newton = Newton(disc, scheme, Settings())
    return strips_for(disc, scheme, newton.tables.damping.size > 0, newton.options) is not None


@pytest.mark.parametrize("name", CASES)
def test_it_computes_what_the_general_way_computes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model, general = CASES[name], list[object]()
    assert qualifies(model)
    solve = Newton.solve
    monkeypatch.setattr(Newton, "solve", lambda self, *about: general.append(self) or solve(self, *about))
    fast, slow = both(model, monkeypatch, t_end=0.3, dt=0.01, save_every=7)
    assert len(general) == len(slow.iterations), "steps in lanes failed, and were taken again in the general way"
    assert fast.success and slow.success and fast.audit.passed
    assert np.all(fast.trail.rows[:, 4] == -1.0)  # no step was left to the general way
    assert np.array_equal(fast.t, slow.t)
    for quantity in ("r", "R", "v", "Rdot", "strain", "reaction"):
        a, b = (np.asarray(getattr(run, quantity)) for run in (fast, slow))
        assert np.abs(a - b).max() <= 2e-9 * max(1.0, np.abs(b).max()), quantity
    for quantity in ("kinetic", "stored", "work"):
        a, b = (getattr(run.energy, quantity) for run in (fast, slow))
        assert np.abs(a - b).max() <= 1e-11 * np.abs(slow.energy.total).max() + 1e-12, quantity
    for quantity in ("linear", "angular"):
        a, b = (getattr(run.momentum, quantity) for run in (fast, slow))
        assert np.abs(a - b).max() <= 1e-11 * max(1.0, np.abs(b).max()), quantity
    assert fast.audit.largest_turn == pytest.approx(slow.audit.largest_turn, rel=1e-9)
    assert fast.audit.largest_turn_where == slow.audit.largest_turn_where
    assert fast.audit.director_loss == pytest.approx(slow.audit.director_loss, rel=1e-6)
    for a, b in zip(fast.audit.entries, slow.audit.entries, strict=True):
        assert a.law == b.law and a.value <= 1e-12
        assert float(a.relative_to) == pytest.approx(float(b.relative_to), rel=1e-5)
    # an elimination that is a little wrong would still converge, but slowly
    assert fast.iterations.mean() <= slow.iterations.mean() + 2.5


SHARED = {
    "flight": flight(75),
    "a load that changes": rod(elements=70).clamp("A").force("B", lambda t: (0.0, 0.0, 5.0 * np.sin(9 * t))),
    "quadratic": rod(elements=70, order=2, nodes={"P": 0.3}).pin("P").gravity((0, -2, -9.81)),
}


@pytest.mark.parametrize("name", SHARED)
def test_threads_share_a_long_chain_and_change_no_bit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strips, "SHARED", 9)
    options = {"t_end": 0.3, "dt": 0.01, "save_every": 2}
    one, general = both(SHARED[name], monkeypatch, **options)
    assert one.success and one.audit.passed and np.all(one.trail.rows[:, 4] == -1.0)
    assert np.abs(one.r - general.r).max() <= 2e-9 and np.abs(one.energy.work - general.energy.work).max() <= 1e-11
    assert np.abs(one.reaction - general.reaction).max() <= 2e-9 * max(1.0, np.abs(general.reaction).max())
    for threads in (2, 3, 9):
        many = dx.simulate(SHARED[name], **options, threads=threads)
        for quantity in ("t", "r", "R", "v", "strain", "reaction", "iterations"):
            assert np.array_equal(getattr(many, quantity), getattr(one, quantity)), (threads, quantity)
        assert many.audit == one.audit and np.array_equal(many.energy.total, one.energy.total)


def test_a_step_that_fails_fails_for_all_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strips, "SHARED", 9)
    hit = rod(elements=75).moment("B", lambda t: (0.0, 1e7 if t > 0.045 else 0.0, 0.0))
    one, two = (dx.simulate(hit, t_end=0.1, dt=0.01, threads=threads) for threads in (1, 2))
    assert not two.success and one.status == two.status and np.array_equal(one.r, two.r)


def test_a_thread_that_waits_in_vain_touches_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt may come between the start of the other threads and that of the first."""
    monkeypatch.setattr(strips, "SHARED", 9)
    chain, results = strips_of(flight(75), 0.01, threads=2), np.zeros((3, RESULTS))
    chain.run(results[:1])
    before = [part.strip.x.copy() for part in chain.parts]
    take = strips.Strips._take

    def stopped(self: strips.Strips, team: Team, *about: Any) -> None:
        if team is self.team[0]:
            raise KeyboardInterrupt
        take(self, team, *about)

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(strips.Strips, "_take", stopped)
        chain.run(results)
    assert all(np.array_equal(part.strip.x, x) for part, x in zip(chain.parts, before, strict=True))
    chain.run(results)
    assert np.all(results[:, 0] > 0.0)


def test_couplings_that_have_faded_out_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """In steps so short that a wave crosses part of an element, a node feels nothing of one some elements away."""
    model, dt = flight(160), 2e-5
    fast, slow = both(model, monkeypatch, t_end=10 * dt, dt=dt, save_every=5)
    assert fast.success and fast.audit.passed
    assert np.abs(fast.r - slow.r).max() <= 1e-12 and np.abs(fast.v - slow.v).max() <= 2e-9 * np.abs(slow.v).max()
    assert fast.iterations.mean() <= slow.iterations.mean() + 2.5
    chain = strips_of(model, dt)
    chain.run(np.zeros((1, RESULTS)))
    row = chain.parts[0].strip.row.reshape(-1, ROW, LANES)
    first, last = (np.abs(row[k, 144:180]).max() for k in (4, 39))  # D⁻¹F
    assert first > 0.0 and last == 0.0 and np.abs(row[39, :36]).max() > 0.0


def strips_of(model: dx.Model, dt: float, threads: int = 1) -> strips.Strips:
    """With the first state of the model in them."""
    scheme = dx.EnergyMomentum().scheme(dt)
    disc = discretise(model, scheme)
    chain = strips_for(disc, scheme, False, Newton(disc, scheme, Settings()).options, threads=threads)
    assert chain is not None
    chain.pack(initial_state(disc, None, scheme))
    return chain


def test_a_step_begins_with_the_factors_of_the_last_one() -> None:
    chain, results = strips_of(flight(40), 0.005), np.zeros((20, RESULTS))
    chain.run(results)
    assert results[0, TANGENTS] >= 2 and np.all(results[1:, TANGENTS] == 1)
    after, state = results[-1].copy(), np.zeros((41, 40))
    assert chain.keeps
    chain.unpack(state)
    chain.pack(state)
    assert not chain.keeps  # another state: its first step has tangents of its own
    chain.run(results[:2])
    assert results[0, TANGENTS] >= 2 and results[1, TANGENTS] == 1
    assert np.abs(results[0, 8:10] - after[8:10]).max() < 0.1 * after[8:10].sum()
    wheel = strips_of(rod(elements=40).rigid_velocity((0, 0, 0), (0, 0, 60), about=(0, 0, 0)), 0.005)
    wheel.run(results)
    assert np.all(results[:, TANGENTS] >= 2) and not wheel.keeps  # a step turns it by 0.3 rad


def test_energy_and_momenta_hold_over_a_long_flight() -> None:
    away = flight(21).rigid_velocity((2.0, 0.0, 0.5), (0, 0, 0), about=(0, 0, 0))
    result = dx.simulate(away, t_end=20.0, dt=0.01, save_every=500)
    assert result.success
    assert all(entry.value <= 1e-11 for entry in result.audit.entries)
    assert result.r[-1, :, 0].min() > 35.0  # the origin has gone along


def test_a_step_that_does_not_converge_takes_the_general_way(monkeypatch: pytest.MonkeyPatch) -> None:
    # a blow in the middle of a chunk: the step fails in lanes and outside
    hit = rod().moment("B", lambda t: (0.0, 1e7 if t > 0.045 else 0.0, 0.0))
    fast, slow = both(hit, monkeypatch, t_end=0.1, dt=0.01)
    assert not fast.success and not slow.success
    assert fast.status.code == slow.status.code and fast.t[-1] == slow.t[-1]
    assert np.abs(fast.r[-1] - slow.r[-1]).max() < 1e-9


def test_a_step_that_fails_in_lanes_only_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    run, calls = strips.Strips.run, list[int]()

    def impatient(self: strips.Strips, results: np.ndarray, before: int) -> None:
        """Every third step gets one iteration."""
        calls.append(len(calls))
        allowed = self.options[5]
        self.options[5] = 1.0 if calls[-1] % 3 == 2 else allowed
        run(self, results, before)
        self.options[5] = allowed

    monkeypatch.setattr(strips.Strips, "run", impatient)
    fast, slow = both(corner(), monkeypatch, t_end=0.1, dt=0.01, progress=lambda done, line: None)
    assert fast.success and fast.audit.passed and len(calls) == len(fast.iterations) == 10
    for quantity in ("r", "R", "v", "Rdot", "strain", "reaction"):
        a, b = (np.asarray(getattr(way, quantity)) for way in (fast, slow))
        assert np.abs(a - b).max() <= 2e-9 * max(1.0, np.abs(b).max()), quantity


def test_what_it_cannot_do_is_left_to_the_general_way() -> None:
    assert not qualifies(rod().force("B", (0, 0, 1), follower=True))
    assert not qualifies(rod().prescribe("A", displacement=lambda t: (0, 0, t)))
    assert not qualifies(rod(elements=3))
    assert not qualifies(rod(order=3))
    assert not qualifies(rod(), dx.GeneralizedAlpha(0.8))
    assert not qualifies(rod(), dx.EnergyDissipating(0.5))


def test_a_short_chain_is_left_to_the_general_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strips, "FEWEST", 22)
    assert not qualifies(rod(elements=21))
    assert qualifies(rod(elements=22))


def test_an_interrupted_run_keeps_its_last_state() -> None:
    class Stop(KeyboardInterrupt):
        pass

    def stop(fraction: float, line: str) -> None:
        if fraction > 0.5:
            raise Stop

    result = dx.simulate(flight(21), t_end=0.2, dt=0.01, save_every=1000, progress=stop)
    assert result.status.code == "interrupted"
    assert result.t[-1] == pytest.approx(0.11) and len(result.iterations) == 11


def test_who_looks_on_changes_no_bit() -> None:
    """A user's progress is called after every step; what is our own after every call; nobody slows a run down least."""
    calls: dict[str, list[float]] = {"each": [], "some": []}
    options = {"t_end": 1.5, "dt": 0.01, "save_every": 2}
    whole = dx.simulate(flight(21), **options)
    each = dx.simulate(flight(21), **options, progress=lambda done, text: calls["each"].append(done))
    seldom = now_and_then(lambda done, text: calls["some"].append(done))
    some = dx.simulate(flight(21), **options, progress=seldom)
    assert calls["each"] == pytest.approx(np.arange(1, 151) / 150) and calls["some"] == [64 / 150, 128 / 150, 1.0]
    for run in (each, some):
        for name in ("t", "r", "R", "v", "strain", "reaction", "iterations"):
            assert np.array_equal(getattr(run, name), getattr(whole, name)), name
        assert np.array_equal(run.energy.work, whole.energy.work) and run.audit == whole.audit


def test_an_interrupt_within_a_call_keeps_what_was_saved_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    run = strips.Strips.run

    def interrupted(self: strips.Strips, results: Any, before: int = 0) -> None:
        run(self, results, before)
        if before:
            raise KeyboardInterrupt

    whole = dx.simulate(flight(21), t_end=2.0, dt=0.01, save_every=3)
    monkeypatch.setattr(strips.Strips, "run", interrupted)
    part = dx.simulate(flight(21), t_end=2.0, dt=0.01, save_every=3)
    assert part.status.code == "interrupted" and "t = 1.28" in part.status.sentence
    assert part.t[-1] == 1.28 and np.array_equal(part.t[:-1], whole.t[:43])
    assert np.array_equal(part.r[:-1], whole.r[:43]) and part.audit.passed
