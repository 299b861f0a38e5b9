"""What is remembered of Newton's iterations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import directrix as dx
from directrix.result import Result
from directrix.trail import LAST, Trail

RUBBER = dx.Section.circle(radius=0.01, E=2e9, nu=0.3, rho=1000.0)


def arm(elements: int = 2) -> dx.Model:
    model = dx.Model(name="arm").rod(
        dx.line((0, 0, 0), (1, 0, 0)), RUBBER, name="arm", ends=("root", "tip"), elements=elements
    )
    return model.clamp("root")


@pytest.fixture(scope="module")
def static() -> Result:
    return dx.solve_static(arm().force("tip", (0.0, 0.0, -1.0)), steps=2)


def test_a_row_says_what_was_out_of_balance_and_what_moved(static: Result) -> None:
    trail = static.trail
    assert trail.step.tolist() == [0, 1] and trail.solved.all()
    assert trail.count.tolist() == static.iterations.tolist()
    tip = static.mesh.node("tip")
    for k in range(2):
        rows = trail.of(k)
        assert rows[0, 0] == pytest.approx(0.5) and rows[0, 4] == tip  # half of the load is new in each step
        assert rows[-1, 2] <= 1e-9 and rows[-1, 3] <= 1e-9
    # what the increments asked for is where it went, when all of them are small
    assert trail.of(0)[:, 2].max() == pytest.approx(np.abs(static.node("tip").displacement[1, 2]), rel=1e-2)


def test_steps_that_fail_are_there(static: Result, tmp_path: Path) -> None:
    failed = dx.solve_static(arm(1).moment("tip", (0.0, 500.0, 0.0)), steps=2)
    trail = failed.trail
    assert not failed.success and not trail.solved[-1] and (~trail.solved).sum() == failed.info["cuts"] > 0
    assert trail.count.tolist() == failed.iterations.tolist()
    for result in (failed, static):
        read = dx.load(result.save(tmp_path / "r.vtkhdf")).trail
        for name, value in vars(result.trail).items():
            np.testing.assert_array_equal(getattr(read, name), value)


def test_paths_and_motions_say_it_too() -> None:
    path = dx.solve_static(arm().force("tip", (0, 0, -1)), control=dx.DisplacementControl("tip", "z", -0.1, steps=2))
    assert path.trail.count.tolist() == path.iterations.tolist() and path.trail.of(-1)[-1, 2] <= 1e-9
    free = arm().gravity((0, 0, -9.81))
    slow = dx.simulate(free, 0.02, 0.01)
    assert slow.trail.count.tolist() == slow.iterations.tolist() and np.isfinite(slow.trail.rows).all()
    lanes = dx.simulate(arm(16).gravity((0, 0, -9.81)), 0.02, 0.01)
    assert lanes.trail.count.tolist() == lanes.iterations.tolist()
    for k in range(2):
        rows = lanes.trail.of(k)
        assert np.isnan(rows[:, :2]).all() and (np.diff(rows[:, 2]) < 0.0).all()
        assert rows[0, 2] == pytest.approx(slow.trail.of(k)[0, 2], rel=0.05)


@pytest.mark.parametrize("block", [1, 7, LAST, 3 * LAST])
def test_the_last_tries_stay_however_they_came(block: int) -> None:
    counts = [1 + k % 5 for k in range(3 * LAST)]
    trail = Trail()
    for first in range(0, len(counts), block):
        few = counts[first : first + block]
        moves = np.zeros((len(few), 6, 2))
        moves[:, :, 0] = np.arange(first, first + len(few))[:, None]
        trail.took(first, few, moves)
    again = Trail()
    again.recall(trail.remember())
    for one in (trail.iterations(), again.iterations()):
        assert one.step.tolist() == list(range(2 * LAST, 3 * LAST))
        assert one.count.tolist() == counts[2 * LAST :]
        np.testing.assert_array_equal(one.rows[:, 2], np.repeat(one.step, one.count))
    assert sum(len(counts) for _, _, counts, _ in trail.blocks) < LAST + block + 1
