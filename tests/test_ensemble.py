"""Ensembles: the members' own results, whoever runs them; failures stay where they are."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import directrix as dx

RUBBER = dx.Section.circle(radius=0.02, E=5e6, nu=0.5, rho=1100)


def swing(angle: float) -> dx.Model:
    if angle < 0.0:
        raise ValueError("below the horizon")
    end = (float(np.cos(angle)), 0.0, float(-np.sin(angle)))
    model = dx.Model().rod(dx.line((0, 0, 0), end), RUBBER, name="rod", ends=("pin", "tip"), elements=10, order=1)
    return model.pin("pin").gravity((0, 0, -9.81))


ANGLES = {"flat": 0.0, "low": 0.3, "steep": 1.0}
SHORT = {"t_end": 0.1, "dt": 0.02}


def test_members_are_what_they_are_alone() -> None:
    seen: list[tuple[float, str]] = []
    runs = dx.ensemble(
        {k: swing(a) for k, a in ANGLES.items()}, **SHORT, batch=2, progress=lambda f, s: seen.append((f, s))
    )
    assert runs.success and tuple(runs) == tuple(ANGLES) == runs.complete and len(runs) == 3
    exactly = dx.ensemble(ANGLES, **SHORT, build=swing, bundle=False)
    for label, angle in ANGLES.items():
        alone = dx.simulate(swing(angle), **SHORT)
        assert np.array_equal(exactly[label].r, alone.r) and np.abs(runs[label].r - alone.r).max() < 1e-13
    tips = runs.stack(lambda run: run.node("tip").r)
    assert tips.shape == (3, 6, 3) and np.array_equal(tips[1], runs["low"].node("tip").r)
    assert seen == [(2 / 3, "2 of 3 members"), (1.0, "3 of 3 members")]


@pytest.mark.parametrize("executor", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_an_executor_changes_no_bit(executor: type[ThreadPoolExecutor]) -> None:
    alone = dx.ensemble(ANGLES, **SHORT, build=swing)
    with executor(2) as pool:
        runs = dx.ensemble(ANGLES, **SHORT, build=swing, executor=pool, batch=1)
    assert runs.labels == alone.labels
    for label in ANGLES:
        assert np.array_equal(runs[label].r, alone[label].r) and np.array_equal(runs[label].v, alone[label].v)


def test_a_failure_is_kept_with_its_member() -> None:
    loose = swing(0.0).moment("tip", (0, 1e7, 0))
    runs = dx.ensemble([swing(0.0), loose, swing(1.0)], **SHORT)
    assert not runs.success and runs.complete == (0, 2) and "did not converge" in runs.failures[1]
    assert runs[1].t[-1] < 0.1 and runs.stack(lambda run: run.t).shape == (2, 6)
    built = dx.ensemble([0.0, -1.0], **SHORT, build=swing)
    assert "below the horizon" in built.failures[1] and built.complete == (0,)
    with pytest.raises(dx.ModelError, match="no result"):
        built[1]
    with pytest.raises(dx.ModelError, match="no member 7"):
        built[7]


def test_a_run_that_is_stopped_keeps_what_it_has() -> None:
    def stop(fraction: float, line: str) -> None:
        if fraction > 0.5:
            raise KeyboardInterrupt

    runs = dx.ensemble(ANGLES, **SHORT, build=swing, batch=1, progress=stop)
    assert runs.complete == ("flat", "low") and "interrupted" in runs.failures["steep"]


@pytest.mark.parametrize(
    ("members", "options", "says"),
    [
        ([], {}, "needs a member"),
        ("models", {}, "are not members"),
        ([1.0], {}, "is not a model"),
        ([1.0], {"build": 3}, "cannot be called"),
        ([0.0], {"build": swing, "executor": 3}, "is not an executor"),
        ([0.0], {"build": swing, "batch": 0}, "batch"),
    ],
)
def test_what_cannot_be_is_refused(members: list[float], options: dict[str, object], says: str) -> None:
    with pytest.raises(dx.ModelError, match=says):
        dx.ensemble(members, **SHORT, **options)


def test_what_cannot_travel_is_refused() -> None:
    moved = swing(0.0).force("tip", lambda t: (0.0, 0.0, t))
    with ProcessPoolExecutor(1) as pool, pytest.raises(dx.ModelError, match="another process"):
        dx.ensemble([moved], **SHORT, executor=pool)
