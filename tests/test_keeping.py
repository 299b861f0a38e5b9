"""A run that is killed goes on and ends with the same file; whatever fails, there is something to go on from."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from kept_runs import FEW, Solve, every

import directrix as dx
from directrix.keeping import Keeper, disk

ALL = every()


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test here pulls the plug: nobody has to wait for the disk."""
    monkeypatch.setattr(disk, "sync", lambda descriptor: None)


def frozen_at(
    solve: Solve, steps: Callable[[int], bool], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[bytes, dict[int, Path]]:
    """The file that a run ends with, and its folder as it was after some steps."""
    copies: dict[int, Path] = {}
    keep = Keeper.keep

    def copying(self: Keeper, taken: int, t: float, memory: Mapping[str, Any], *, done: bool = False) -> None:
        keep(self, taken, t, memory, done=done)
        if not done and steps(taken):
            copies[taken] = folder / f"after {taken}"
            shutil.copytree(folder / "run", copies[taken])

    with monkeypatch.context() as patched:
        patched.setattr(Keeper, "keep", copying)
        solve(folder=dx.Folder(folder / "run", steps=1))
    return (folder / "run" / "result.vtkhdf").read_bytes(), copies


def gone_on(solve: Solve, folder: Path) -> bytes:
    solve(folder=dx.Folder(folder, resume=True))
    return (folder / "result.vtkhdf").read_bytes()


@pytest.mark.parametrize("name", FEW)
def test_a_run_goes_on_to_the_same_file(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, copies = frozen_at(FEW[name], lambda n: n in (3, 10), tmp_path, monkeypatch)
    assert len(copies) == 2
    for copy in copies.values():
        assert gone_on(FEW[name], copy) == whole


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_every_run_goes_on_from_any_step(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    random = Random(name)
    whole, copies = frozen_at(ALL[name], lambda n: True, tmp_path, monkeypatch)
    assert len(copies) >= 2
    chosen = random.sample(sorted(copies), min(20, len(copies)))
    assert [n for n in chosen if gone_on(ALL[name], copies[n]) != whole] == []


@pytest.mark.parametrize("name", FEW)
def test_what_is_kept_and_watched_changes_nothing(name: str, tmp_path: Path) -> None:
    often = FEW[name](save_every=1)
    rarely = FEW[name](save_every=3, progress=lambda done, line: None, folder=tmp_path / "run")
    again = FEW[name](save_every=1)
    assert often.audit == rarely.audit == again.audit
    np.testing.assert_array_equal(often.iterations, rarely.iterations)
    at = np.searchsorted(often.t, rarely.t) if often.t[-1] == often.t.max() else np.array([0, len(often.t) - 1])
    if name == "a path":  # where the load factor turns back, instants are told apart by their place
        at = np.array([int(np.flatnonzero(often.t == t)[0]) for t in rarely.t])
    for field in ("t", "r", "R", "v", "Rdot", "strain", "force", "reaction", "joints", "history"):
        a, b, c = (getattr(run, field) for run in (often, rarely, again))
        assert a[at].tobytes() == b.tobytes() and a.tobytes() == c.tobytes(), field
    for field in ("kinetic", "stored", "work", "dissipated", "residual"):
        assert getattr(often.energy, field)[at].tobytes() == getattr(rarely.energy, field).tobytes(), field
