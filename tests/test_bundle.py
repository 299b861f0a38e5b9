"""Members of an ensemble side by side compute what they compute alone, whoever is beside them."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import directrix as dx
from directrix import bundle, ensembles
from directrix.bundle import fit_of
from directrix.kernels.compile import LANES
from directrix.motion import Asked, Motion

LINE = dx.line((0, 0, 0), (1, 0, 0))
FIELDS = ("r", "R", "v", "Rdot", "strain", "force", "reaction")


def rod(k: float, elements: int = 12, order: int = 1, curve: dx.Curve = LINE, **more: Any) -> dx.Model:
    """Thicker with ``k``."""
    section = dx.Section.circle(radius=0.02 * (1 + 0.05 * k), E=5e6, nu=0.5, rho=1100)
    return dx.Model().rod(curve, section, name="rod", ends=("A", "B"), elements=elements, order=order, **more)


def flight(k: float) -> dx.Model:
    model = rod(k).velocity("A", (0, 0, -1 - 0.1 * k)).velocity("B", (0, 0.5, 1), (3, 0, 1))
    return model.rigid_velocity((4.0, 0, 0.5), (0, 0, 0), about=(0, 0, 0))


def swing(k: float) -> dx.Model:
    return rod(k).pin("A").gravity((0, 0, -9.81))


def cantilever(k: float) -> dx.Model:
    return rod(k).clamp("A").force("B", lambda t: (0.0, 0.0, 5.0 * np.sin((9 + k) * t)))


def held(k: float) -> dx.Model:
    model = rod(k, 10, 2, nodes={"P": 0.1, "Q": 0.35}).pin("P").fix("Q", "z", "rx", "ry")
    return model.gravity((0, 0, -9.81)).velocity("B", (0, 0.3, 0.5))


def bent(k: float) -> dx.Model:
    curve = dx.arc((0, 0, 0), (1, 1, 0), (2, 0, 0.1 * k), directors="chord")
    return rod(k, 9, 2, curve).velocity("A", (0, 0, -1)).moment("B", (0, 0.02, 0.01))


def stub(k: float) -> dx.Model:
    return rod(k, 1).clamp("A").gravity((0, 0, -1.0))


KINDS: dict[str, Callable[[float], dx.Model]] = {f.__name__: f for f in (flight, swing, cantilever, held, bent, stub)}


def same(a: dx.Result, b: dx.Result) -> bool:
    """To the last bit."""
    fields = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in (*FIELDS, "t", "iterations"))
    sums = np.array_equal(a.energy.total, b.energy.total) and np.array_equal(a.energy.work, b.energy.work)
    return fields and sums and np.array_equal(a.momentum.angular, b.momentum.angular) and a.audit == b.audit


@pytest.mark.parametrize("name", KINDS)
def test_a_member_computes_what_simulate_computes(name: str) -> None:
    make, options = KINDS[name], {"t_end": 1.0, "dt": 0.01, "save_every": 7}
    runs = dx.ensemble([make(k) for k in range(LANES + 1)], **options)
    assert runs.success
    for k in (0, LANES):
        one, alone = runs[k], dx.simulate(make(k), **options)
        assert np.array_equal(one.t, alone.t) and one.status == alone.status and one.audit.passed
        for field in FIELDS:
            a, b = getattr(one, field), getattr(alone, field)
            assert np.abs(a - b).max() <= 1e-9 * max(1.0, np.abs(b).max()), field
        whole = np.abs(alone.energy.total).max()
        for quantity in ("kinetic", "stored", "work"):
            a, b = getattr(one.energy, quantity), getattr(alone.energy, quantity)
            assert np.abs(a - b).max() <= 1e-11 * whole, quantity
        assert np.abs(one.energy.residual).max() <= 1e-12 * whole
        for quantity in ("linear", "angular"):
            a, b = getattr(one.momentum, quantity), getattr(alone.momentum, quantity)
            assert np.abs(a - b).max() <= 1e-11 * max(1.0, np.abs(b).max()), quantity
        assert one.audit.largest_turn == pytest.approx(alone.audit.largest_turn, rel=1e-9)
        assert one.audit.largest_turn_where == alone.audit.largest_turn_where
        # an elimination that is a little wrong would still converge, but slowly
        assert one.iterations.mean() <= alone.iterations.mean() + 1.5
        assert one.info.keys() == alone.info.keys() and one.links.keys() == alone.links.keys()


def thrown(model: dx.Model, by: float) -> dx.Model:
    """A member that needs more iterations, more new tangents and large turns."""
    return model.moment("B", lambda t: (0.0, by * np.sin(40.0 * t), 0.5 * by))


@pytest.mark.parametrize("name", ["flight", "held"])
def test_no_bit_depends_on_who_is_beside_a_member(name: str) -> None:
    make, options = KINDS[name], {"t_end": 0.7, "dt": 0.02}
    alone = [dx.ensemble([thrown(make(1.0), by)], **options)[0] for by in (0.0, 0.1, 0.3)]
    beside = dx.ensemble([thrown(make(1.0), by) for by in (0.1, 0.2, 0.0, 0.3)], **options)
    assert beside.success and np.any(beside[3].iterations > beside[2].iterations)
    with ThreadPoolExecutor(2) as pool:
        models = [make(5.0), thrown(make(1.0), 0.1), make(1.0)]
        elsewhere = dx.ensemble(models, **options, batch=2, executor=pool)
    for one, k in ((beside[2], 0), (beside[0], 1), (beside[3], 2), (elsewhere[1], 1), (elsewhere[2], 0)):
        assert same(one, alone[k])
        assert not same(one, alone[k - 1])


def test_a_member_that_does_not_converge_is_run_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"t_end": 0.5, "dt": 0.02}
    blow = swing(0.0).moment("B", lambda t: (0.0, 3.0 if 0.2 < t < 0.26 else 0.0, 0.0))
    never = swing(2.0).moment("B", (0.0, 1e7, 0.0))
    seen: list[dx.Model] = []
    monkeypatch.setattr(ensembles, "simulate", lambda m, **more: (seen.append(m), dx.simulate(m, **more))[1])
    runs = dx.ensemble([swing(0.0), blow, never, swing(1.0)], **options)
    assert seen == [blow, never]
    assert runs.complete == (0, 1, 3) and "did not converge" in runs.failures[2]
    assert runs[1].cuts.sum() > 0 and same(runs[1], dx.simulate(blow, **options))
    assert same(runs[0], dx.ensemble([swing(0.0)], **options)[0])
    assert same(runs[3], dx.ensemble([swing(1.0)], **options)[0])


def test_a_load_that_fails_on_the_way_is_the_failure_of_its_member() -> None:
    def until(t: float) -> tuple[float, float, float]:
        if t > 0.3:
            raise ValueError("no more")
        return 0.0, 0.0, t

    runs = dx.ensemble([cantilever(0.0), rod(1.0).clamp("A").force("B", until)], t_end=0.5, dt=0.02)
    assert runs.complete == (0,) and "no more" in runs.failures[1] and runs[1].t[-1] == pytest.approx(0.3)


def test_what_does_not_lie_side_by_side_runs_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []
    run = bundle.run
    monkeypatch.setattr(ensembles, "run", lambda fits: (sizes.append(len(fits)), run(fits))[1])
    damped = dx.Section.circle(radius=0.02, E=5e6, nu=0.5, rho=1100, damping=0.01)
    frame = rod(0.0).rod(dx.line((1, 0, 0), (1, 1, 0)), damped, ends=("B", "C"), elements=4).clamp("A")
    models = [swing(0.0), frame, rod(0.0).clamp("A"), swing(1.0), held(0.0), swing(2.0), rod(1.0, 13).pin("A")]
    options = {"t_end": 0.2, "dt": 0.02}
    runs = dx.ensemble(models, **options, batch=len(models))
    assert runs.success and sorted(sizes) == [1, 1, 1, 3]
    for k, model in enumerate(models):
        alone = dx.simulate(model, **options)
        assert np.abs(runs[k].r - alone.r).max() < 1e-11, k
    assert same(runs[1], dx.simulate(frame, **options))


def test_who_looks_on_while_a_motion_goes_on_is_not_put_in_a_lane() -> None:
    asked = Asked(t_end=0.1, dt=0.01)
    assert fit_of(Motion(swing(0.0), asked)) is not None
    assert fit_of(Motion(swing(0.0), Asked(t_end=0.1, dt=0.01, progress=lambda f, s: None))) is None
    assert fit_of(Motion(swing(0.0), Asked(t_end=0.1, dt=dx.Adaptive()))) is None
    assert fit_of(Motion(swing(0.0), Asked(t_end=0.1, dt=0.01, integrator=dx.Newmark()))) is None


def test_an_interrupt_keeps_what_the_members_have(monkeypatch: pytest.MonkeyPatch) -> None:
    settle, left = bundle.Bundle.run, [2]

    def interrupted(self: bundle.Bundle, results: Any, before: int) -> None:
        settle(self, results, before)
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(bundle.Bundle, "run", interrupted)
    options = {"t_end": 3.0, "dt": 0.01, "save_every": 1000}
    runs = dx.ensemble([swing(0.0), swing(1.0), held(0.0)], **options)
    assert runs.complete == () and "interrupted at t = 1.28" in runs.failures[0] and "not run" in runs.failures[2]
    monkeypatch.undo()
    part = dx.ensemble([swing(1.0)], **{**options, "t_end": 1.28})[0]
    assert runs[1].t.tolist() == part.t.tolist() and np.array_equal(runs[1].r, part.r)
