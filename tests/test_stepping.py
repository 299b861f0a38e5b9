"""Steps of any length: what a scheme keeps it keeps, order 2 stays, and a step thrown away leaves no trace."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import directrix as dx
from directrix import motion, stepping
from directrix.cli import app
from directrix.integrators.conformance import _carried_rod, _flying_rod  # pyright: ignore[reportPrivateUsage]
from directrix.newton import Newton, Outcome
from directrix.result import Status
from directrix.schema import load_case

ORDER_TWO = [dx.EnergyMomentum(), dx.Midpoint(), dx.GeneralizedAlpha(0.6), dx.Newmark(), dx.SimoTarnowDoblare()]


class Given:
    """Steps of given lengths, whatever happens."""

    adaptive, on_time = True, False

    def __init__(self, lengths: list[float]) -> None:
        self.lengths = lengths

    def first(self) -> stepping.Beat:
        return stepping.Beat(0.0, self.lengths[0], self.lengths[0], True)

    def judge(self, beat: stepping.Beat, rates: object = None, length: float = 1.0) -> stepping.Judged:
        k, h = beat.k + 1, self.lengths[min(beat.k + 1, len(self.lengths) - 1)]
        return stepping.Judged(True, replace(beat, t=beat.to, to=beat.to + h, dt=h, k=k, done=k == len(self.lengths)))

    def shorter(self, beat: stepping.Beat) -> None:
        return None

    def fraction(self, beat: stepping.Beat) -> float:
        return beat.k / len(self.lengths)

    def why(self, beat: stepping.Beat) -> str:
        return "given"


def taken(monkeypatch: pytest.MonkeyPatch, lengths: list[float], model: dx.Model, **more: object) -> dx.Result:
    """A run in steps of these lengths."""
    with monkeypatch.context() as patched:
        patched.setattr(motion, "stepping", lambda *_: Given(lengths))
        return dx.simulate(model, sum(lengths), 1.0, **more)


@pytest.mark.parametrize("integrator", [*ORDER_TWO, dx.EnergyDissipating(0.3, 0.1)], ids=repr)
def test_what_a_scheme_keeps_it_keeps_in_steps_of_any_length(
    monkeypatch: pytest.MonkeyPatch, integrator: object
) -> None:
    lengths = np.random.default_rng(3).uniform(0.002, 0.1, 60).tolist()
    model = _flying_rod().force("b", lambda t: (0.0, np.sin(3 * t), 0.2))
    result = taken(monkeypatch, lengths, model, integrator=integrator)
    assert result.success and np.ptp(result.dt) > 0.09
    for entry in result.audit.entries:
        assert not entry.claimed or entry.value < 1e-12, entry
    assert sum(e.claimed for e in result.audit.entries) >= (0 if "Alpha" in repr(type(integrator)) else 2)


@pytest.mark.parametrize("integrator", ORDER_TWO, ids=repr)
def test_order_two_is_kept_when_steps_change_all_the_time(monkeypatch: pytest.MonkeyPatch, integrator: object) -> None:
    """Long, short, long …: an acceleration left at the instant of another Δt would make this order 1."""
    ends = [
        taken(monkeypatch, [0.3 / n, 0.1 / n] * (n // 2), _carried_rod(), integrator=integrator, tolerance=1e-12).r[-1]
        for n in (64, 128, 256)
    ]
    gaps = [np.linalg.norm(b - a) for a, b in pairwise(ends)]
    assert np.log2(gaps[0] / gaps[1]) > 1.9


def pushed() -> dx.Model:
    """Drifting, then pushed for a moment: steps can be long most of the time."""
    rod = dx.Section.from_moduli(EA=2500, GA1=950, GA2=950, EI1=10, EI2=12, GJ=8, A_rho=2.5, I_rho1=0.3, I_rho2=0.25)
    push = lambda t: (0.0, 0.0, 20.0 * np.exp(-(((t - 4.0) / 0.1) ** 2)))  # noqa: E731
    return (
        dx.Model(name="pushed")
        .rod(dx.line((0, 0, 0), (3, 0, 0)), rod, name="rod", ends=("a", "b"), elements=4, order=1)
        .rigid_velocity((0.2, 0, 0))
        .force("b", push)
    )


@pytest.fixture(scope="module")
def adapted() -> dx.Result:
    return dx.simulate(pushed(), 4.4, dx.Adaptive(tolerance=1e-5, dt_max=0.1))


def test_steps_are_long_where_little_happens_and_short_where_much_does(adapted: dx.Result) -> None:
    ends = np.cumsum(adapted.dt)
    assert adapted.success and adapted.audit.passed and ends[-1] == pytest.approx(4.4, abs=1e-12)
    assert len(adapted.dt) == len(adapted.iterations) == len(adapted.t) - 1
    np.testing.assert_allclose(adapted.t[1:], ends, rtol=1e-13)
    quiet, busy = adapted.dt[(ends > 3.0) & (ends < 3.5)], adapted.dt[(ends > 3.9) & (ends < 4.2)]
    assert quiet.min() > 3.0 * busy.max()
    truth = dx.simulate(pushed(), 4.4, 0.001, save_every=8000).r[-1]
    equal = dx.simulate(pushed(), 4.4, 4.4 / len(adapted.dt), save_every=1000).r[-1]
    assert np.abs(adapted.r[-1] - truth).max() < 0.5 * np.abs(equal - truth).max()


def test_the_error_follows_the_tolerance() -> None:
    """Ten times stricter: steps get shorter by the third root or so, and the error falls with their square."""
    truth = dx.simulate(pushed(), 4.4, 0.0005, save_every=10_000).r[-1]
    runs = [dx.simulate(pushed(), 4.4, dx.Adaptive(tolerance=tol, dt_max=0.1)) for tol in (1e-4, 1e-5, 1e-6)]
    errors = [np.abs(run.r[-1] - truth).max() for run in runs]
    counts = [len(run.dt) for run in runs]
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]
    assert all(1.5 < b / a < 2.4 for a, b in pairwise(counts))


def test_a_step_that_was_too_long_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first step is far too long; the same lengths without any trial give the same bits."""
    adaptive = dx.Adaptive(tolerance=1e-4, first=0.5, dt_max=0.5)
    for integrator in (dx.EnergyMomentum(), dx.GeneralizedAlpha(0.6)):
        tried = dx.simulate(_flying_rod(), 0.3, adaptive, integrator=integrator)
        assert tried.info["rejected"] > 0 and tried.cuts[0] > 0
        again = taken(monkeypatch, tried.dt.tolist(), _flying_rod(), integrator=integrator)
        if integrator == dx.EnergyMomentum():
            np.testing.assert_array_equal(tried.r, again.r)
        np.testing.assert_allclose(tried.r, again.r, rtol=0, atol=1e-9)
        np.testing.assert_allclose(tried.v, again.v, rtol=0, atol=1e-7)


def test_instants_that_are_asked_for_are_met() -> None:
    result = dx.simulate(pushed(), 3.0, dx.Adaptive(tolerance=1e-4, save_at=0.25))
    np.testing.assert_allclose(result.t, 0.25 * np.arange(13), rtol=0, atol=1e-14)
    assert result.success and len(result.dt) > 12
    ends = np.cumsum(result.dt)
    assert all(np.abs(ends - t).min() < 1e-12 for t in result.t[1:])
    # no crumbs: a step is not much shorter than both its neighbours
    assert np.all(result.dt[1:-1] > 0.2 * np.minimum(result.dt[:-2], result.dt[2:]))


@pytest.fixture
def stubborn(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Newton's iteration fails in steps longer than the number in the list."""
    longest, solve = [np.inf], Newton.solve

    def balks(self: Newton, x: np.ndarray, external: np.ndarray, moved: bool = False) -> Outcome:
        outcome = solve(self, x, external, moved)
        if 1.0 / self.scheme.common[1] > longest[0] * (1 + 1e-9):
            return Outcome(outcome.iterations, Status("not_converged", "it balks.", "Shorter."))
        return outcome

    monkeypatch.setattr(Newton, "solve", balks)
    return longest


@pytest.mark.parametrize("integrator", [dx.EnergyMomentum(), dx.EnergyDissipating(0.3, 0.1)], ids=repr)
def test_a_step_that_is_not_solved_is_cut_and_steps_grow_again(stubborn: list[float], integrator: object) -> None:
    def ease(done: float, _: str) -> None:
        stubborn[0] = 0.02 if 0.3 <= done < 0.6 else np.inf

    result = dx.simulate(_flying_rod(), 2.0, 0.1, integrator=integrator, progress=ease)
    assert result.success and result.audit.passed
    assert all(e.value < 1e-12 for e in result.audit.entries if e.claimed)
    np.testing.assert_allclose(result.t, 0.1 * np.arange(21), rtol=0, atol=1e-14)
    assert result.dt.sum() == pytest.approx(2.0) and result.dt.min() == 0.0125 and result.dt[-1] == 0.1
    assert result.cuts.sum() == result.info["cuts"] and 3 <= result.info["cuts"] <= 12
    assert np.all(result.dt[result.t[np.searchsorted(result.t, np.cumsum(result.dt) - 1e-9)] > 1.5] == 0.1)
    assert "times cut because Newton failed" in str(result) and "times cut" in str(result.status)


def test_cuts_of_a_step_are_bounded_and_the_end_is_named(stubborn: list[float]) -> None:
    stubborn[0] = 1e-9
    result = dx.simulate(_flying_rod(), 1.0, 0.1)
    assert result.status.code == "not_converged" and "cut 12 times" in result.status.sentence
    assert len(result.t) == 1 and result.info["cuts"] == 13
    adaptive = dx.simulate(_flying_rod(), 1.0, dx.Adaptive(dt_min=1e-4, first=0.1))
    assert adaptive.status.code == "not_converged" and "dt_min = 0.0001" in adaptive.status.sentence


def test_a_run_that_would_need_steps_too_short_says_so() -> None:
    result = dx.simulate(_flying_rod(), 1.0, dx.Adaptive(tolerance=1e-6, dt_min=0.01))
    assert result.status.code == "inaccurate" and "dt_min = 0.01" in result.status.sentence
    assert result.status.advice and not result.success


def test_steps_are_saved_and_in_the_folder_of_a_run(adapted: dx.Result, tmp_path: Path) -> None:
    again = dx.load(adapted.save(tmp_path / "a.vtkhdf"))
    np.testing.assert_array_equal(again.dt, adapted.dt)
    np.testing.assert_array_equal(again.cuts, adapted.cuts)
    CliRunner().invoke(app, ["examples", "free_flight", "--copy", str(tmp_path)])
    file = tmp_path / "free_flight.toml"
    text = file.read_text("utf-8").replace("t_end = 30", "t_end = 1")
    file.write_text(text.replace("dt = 0.2", "dt = 0.2\nadaptive = { tolerance = 0.01, save_at = 0.25 }"), "utf-8")
    run = CliRunner().invoke(app, ["run", str(file), "--no-view", "--adaptive", "0.02"])
    assert run.exit_code == 0, run.output
    assert "steps of" in run.output
    folder = tmp_path / "free_flight.run"
    summary = json.loads((folder / "run.json").read_text("utf-8"))
    rows = list(csv.DictReader((folder / "monitor.csv").open(encoding="utf-8")))
    assert [float(row["t"]) for row in rows] == [0.0, 0.25, 0.5, 0.75, 1.0]
    result = dx.load(folder / "result.vtkhdf")
    assert "tolerance=0.02" in result.info["dt"]
    assert float(rows[-1]["dt"]) == result.dt[-1]
    assert int(rows[-1]["cuts"]) == result.cuts.sum() == summary["steps"]["cuts"] + summary["steps"]["rejected"]
    assert summary["steps"]["shortest"] == result.dt.min()
    assert load_case(file).step == dx.Adaptive(tolerance=0.01, first=0.2, save_at=0.25)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"dt": dx.Adaptive(), "integrator": dx.EnergyDissipating()}, "of order 1"),
        ({"dt": dx.Adaptive(save_at=0.1), "save_every": 2}, "save_at and save_every"),
        ({"dt": dx.Adaptive(save_at=0.3)}, "save_at = 0.3"),
        ({"dt": dx.Adaptive(), "t_end": -1.0}, "not after the start"),
        ({"dt": dx.Adaptive}, "not a number"),
    ],
)
def test_what_cannot_be_adapted_is_refused(change: dict[str, object], says: str) -> None:
    with pytest.raises(dx.ModelError, match=says) as error:
        dx.simulate(_flying_rod(), **{"t_end": 1.0, **change})
    assert error.value.fix


@pytest.mark.parametrize("bad", [{"tolerance": 0.0}, {"tolerance": 2.0}, {"dt_min": -1.0}, {"save_at": float("nan")},
                                 {"dt_min": 2.0, "dt_max": 1.0}, {"first": 2.0, "dt_max": 1.0}])  # fmt: skip
def test_bounds_that_cannot_be_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(dx.ModelError):
        dx.Adaptive(**bad)
