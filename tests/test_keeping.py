"""A run that is killed goes on and ends with the same file; whatever fails, there is something to go on from."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import time
from collections.abc import Callable, Mapping
from functools import partial
from itertools import groupby
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from kept_runs import FEW, Solve, every, flying

import directrix as dx
from directrix.keeping import Keeper, disk
from directrix.keeping.store import Store

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


def kill(solve: Solve, folder: Path, delay: float) -> bool:
    """Go on in a process of its own and kill it after a while; whether it was at work then."""
    pid = os.fork()
    if pid == 0:
        try:
            solve(folder=dx.Folder(folder, resume=(folder / "run.json").exists(), seconds=0.0))
        finally:
            os._exit(0)
    time.sleep(delay)
    os.kill(pid, signal.SIGKILL)
    return os.WIFSIGNALED(os.waitpid(pid, 0)[1])


def killed_often(name: str, kills: int, folder: Path) -> int:
    """How many of ``kills`` hit a run that was on; each run is killed till it is through, and compared."""
    solve, random, hits, rounds = FEW[name], Random(name), 0, 0
    started = time.monotonic()
    solve(folder=dx.Folder(folder / "whole", seconds=0.0))
    lasts = time.monotonic() - started
    whole = (folder / "whole" / "result.vtkhdf").read_bytes()
    while hits < kills:
        rounds += 1
        run = folder / f"round {rounds}"
        while hits < kills and kill(solve, run, random.uniform(0.05, 0.6) * lasts):
            hits += 1
        if (
            not (run / "result.vtkhdf").exists()
            or json.loads((run / "run.json").read_text())["status"]["code"] == "running"
        ):
            solve(folder=dx.Folder(run, resume=(run / "run.json").exists()))
        assert (run / "result.vtkhdf").read_bytes() == whole
        assert rounds <= 4 * kills, "no kill meets the run"
    return rounds


@pytest.mark.parametrize("name", list(FEW)[:4])
def test_killed_runs_end_with_the_same_file(name: str, tmp_path: Path) -> None:
    assert killed_often(name, 2, tmp_path) >= 1


@pytest.mark.slow
@pytest.mark.parametrize("name", list(FEW)[:4])
def test_runs_killed_fifty_times(name: str, tmp_path: Path) -> None:
    killed_often(name, 50, tmp_path)


class Faulty:
    """The calls of the disk, counted; from number ``first`` on, ``many`` of them fail."""

    def __init__(self, patched: pytest.MonkeyPatch, first: int = 10**9, many: int = 1) -> None:
        self.first, self.many, self.calls = first, many, list[str]()
        for name in ("write", "flush", "sync", "replace"):
            patched.setattr(disk, name, partial(self.call, name, getattr(disk, name)))

    def call(self, name: str, does: Callable[..., Any], *args: Any) -> Any:
        self.calls.append(name)
        if self.first < len(self.calls) <= self.first + self.many:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return does(*args)


def swing(**options: Any) -> dx.Result:
    return dx.simulate(flying(), 0.03, 0.01, **options)


def survived(folder: Path, patch: pytest.MonkeyPatch, every: int) -> int:
    """Let every so-manieth call fail, alone and with all after it; how many places were tried."""
    firsts: list[int] = []
    keep = Store.keep

    def noting(self: Store, serial: int, values: Mapping[str, Any]) -> int:
        size = keep(self, serial, values)
        firsts.append(len(counted.calls))
        return size

    with patch.context() as patched:
        counted = Faulty(patched)
        patched.setattr(Store, "keep", noting)
        swing(folder=dx.Folder(folder / "whole", steps=1))
    whole = (folder / "whole" / "result.vtkhdf").read_bytes()
    # the result file is one long row of writes; a few of them stand for all
    runs = [(name, list(group)) for name, group in groupby(range(len(counted.calls)), key=counted.calls.__getitem__)]
    few = (group if len(group) < 10 else [*group[:2], group[len(group) // 2], group[-1]] for _, group in runs)
    places = [k for group in few for k in group][::every]
    assert {counted.calls[k] for k in places} == {"write", "flush", "sync", "replace"}
    for place in places:
        for many in (1, 10**9):
            run = folder / f"{place} {many}"
            with patch.context() as patched:
                Faulty(patched, place, many)
                try:
                    result = swing(folder=dx.Folder(run, steps=1))
                    assert result.success or result.status.code == "interrupted"
                    assert result.success or "No space left on device; " in result.status.sentence
                except dx.InputError as error:
                    assert "No space left on device; " in error.what and "are needed" in error.what
            assert Store(run).newest() is not None or place < firsts[0]
            swing(folder=dx.Folder(run, resume=(run / "run.json").exists(), steps=1))
            assert (run / "result.vtkhdf").read_bytes() == whole, (place, many)
            shutil.rmtree(run)
    return len(places)


def test_after_a_fault_there_is_something_to_go_on_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert survived(tmp_path, monkeypatch, 11) > 5


@pytest.mark.slow
def test_after_any_fault_there_is_something_to_go_on_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert survived(tmp_path, monkeypatch, 1) > 60


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
