"""Runs that belong together are kept in one folder: what is done is not run again, what was killed goes on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kept_runs import pushed_column
from test_bifurcations import along, column
from test_ensemble import ANGLES, SHORT, swing

import directrix as dx
from directrix.keeping import Keeper, Many, disk

WAY = dx.ArcLength(ds=0.05, load_step=0.05, direction="backward", max_steps=5)


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody has to wait for the disk."""
    monkeypatch.setattr(disk, "sync", lambda descriptor: None)


def steps_taken(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many steps each run takes from here on."""
    taken: list[int] = []
    keep, finish = Keeper.keep, Keeper.finish

    def finishing(self: Keeper, result: dx.Result) -> dx.Result:
        first = 0 if self.memory is None else begun.pop()
        taken.append(len(result.iterations) - first)
        return finish(self, result)

    begun: list[int] = []
    begin = Keeper._begin

    def beginning(self: Keeper, folder: Any) -> None:
        begin(self, folder)
        if self.memory is not None:
            begun.append(len(self.recorder.iterations))

    monkeypatch.setattr(Keeper, "finish", finishing)
    monkeypatch.setattr(Keeper, "_begin", beginning)
    assert keep is Keeper.keep
    return taken


def test_members_that_are_done_are_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, whole = tmp_path / "many", dx.ensemble(ANGLES, **SHORT, build=swing, bundle=False)

    def stop(fraction: float, line: str) -> None:
        if fraction > 0.5:
            raise KeyboardInterrupt

    runs = dx.ensemble(ANGLES, **SHORT, build=swing, batch=1, progress=stop, folder=folder)
    assert runs.complete == ("flat", "low") and f"dx.Folder({str(folder)!r}, resume=True)" in runs.failures["steep"]
    assert sorted(p.name for p in folder.iterdir()) == ["flat", "low", "runs.json"]
    assert json.loads((folder / "runs.json").read_text())["runs"]["steep"] == "'steep'"
    with pytest.raises(dx.InputError, match="not all have finished"):
        dx.ensemble(ANGLES, **SHORT, build=swing, folder=folder)
    taken = steps_taken(monkeypatch)
    more = {**ANGLES, "a new one": 0.5}
    runs = dx.ensemble(more, **SHORT, build=swing, folder=dx.Folder(folder, resume=True))
    assert runs.success and taken == [0, 0, 5, 5]
    for label in ANGLES:
        for name in ("r", "R", "v", "force"):
            assert getattr(runs[label], name).tobytes() == getattr(whole[label], name).tobytes()
        assert runs[label].audit == whole[label].audit
    (new,) = folder.glob("a_new_one-*")
    assert dx.load(new / "result.vtkhdf").r.tobytes() == runs["a new one"].r.tobytes()
    changed = dx.ensemble({**ANGLES, "low": 0.31}, **SHORT, build=swing, folder=dx.Folder(folder, resume=True))
    assert list(changed.failures) == ["low"] and "another model" in changed.failures["low"]
    assert dx.ensemble(ANGLES, **SHORT, build=swing, folder=folder).success  # all had finished: begun anew


def test_other_processes_keep_their_members_too(tmp_path: Path) -> None:
    alone = dx.ensemble(ANGLES, **SHORT, build=swing, bundle=False)
    with ProcessPoolExecutor(2) as pool:
        dx.ensemble(ANGLES, **SHORT, build=swing, executor=pool, batch=1, folder=tmp_path / "many")
    for label in ANGLES:
        assert dx.load(tmp_path / "many" / label / "result.vtkhdf").r.tobytes() == alone[label].r.tobytes()


MANY = """
import sys
sys.path.insert(0, {here!r})
import directrix as dx
from test_ensemble import swing
dx.ensemble([0.1 * k for k in range(5)], 2.0, 0.01, build=swing, batch=5, folder=dx.Folder({folder!r}, steps=10))
"""


def test_an_ensemble_that_was_killed_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, members = tmp_path / "many", [0.1 * k for k in range(5)]
    code = MANY.format(here=str(Path(__file__).parent), folder=str(folder))
    with subprocess.Popen([sys.executable, "-c", code]) as run:
        while not (folder / "2" / "parts" / "segment-000002").exists() and run.poll() is None:
            time.sleep(0.001)
        run.kill()
        assert run.wait() == -signal.SIGKILL
    taken = steps_taken(monkeypatch)
    runs = dx.ensemble(members, 2.0, 0.01, build=swing, folder=dx.Folder(folder, resume=True))
    assert runs.success and taken[:2] == [0, 0] and 0 <= taken[2] < 200 and taken[3:] == [200, 200]
    for k in (0, 2, 4):
        assert runs[k].r.tobytes() == dx.simulate(swing(members[k]), 2.0, 0.01).r.tobytes()


@pytest.fixture
def interruptible() -> Iterator[None]:
    """A shell has the programs that it runs behind a script ignore SIGINT; tests that send it want it heard."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(("after", "kept"), [(0.05, False), (0.05, True), (0.08, True)])
def test_a_signal_ends_the_ensemble_and_not_a_member_alone(after: float, kept: bool, tmp_path: Path) -> None:
    late: list[float] = []

    def pull(t: float) -> tuple[float, float, float]:
        if t > after and not late:
            late.append(t)
            os.kill(os.getpid(), signal.SIGINT)
        return (0.0, 0.0, t)

    where = {"folder": dx.Folder(tmp_path / "many", steps=1)} if kept else {"bundle": False}
    runs = dx.ensemble([swing(0.1).force("tip", pull), swing(0.2)], **SHORT, **where)
    assert "was not run" in runs.failures[1] and runs.results[1] is None
    if after == 0.05:
        assert "interrupted at" in runs.failures[0]
    else:  # its last step was on: it has ended, and there is no other that would see to the signal
        assert dx.load(tmp_path / "many" / "0" / "result.vtkhdf").success


def test_members_before_an_interruption_are_there() -> None:
    def build(angle: float) -> dx.Model:
        if angle == 0.2:
            raise KeyboardInterrupt
        return swing(angle)

    runs = dx.ensemble([0.1, 0.2, 0.3], **SHORT, build=build, batch=3, bundle=False)
    assert runs.complete == (0,) and all("was not run" in runs.failures[k] for k in (1, 2))


@pytest.mark.parametrize(
    ("labels", "says"),
    [
        ([1, "1"], "same name"),
        (["a", "A"], "same name"),
        ([object()], "no name that lasts"),
    ],
)
def test_labels_that_name_no_folder(labels: list[Any], says: str, tmp_path: Path) -> None:
    with pytest.raises(dx.ModelError, match=says):
        dx.ensemble({label: swing(0.0) for label in labels}, **SHORT, folder=tmp_path / "many")


def test_folders_are_named_after_labels(tmp_path: Path) -> None:
    labels = ["E = 1e7", (1, 2.5), "../up", 1e7, np.float64(0.3), "low"]
    many = Many.claim(tmp_path / "many", labels)
    names = [Path(many.of(label).path) for label in labels]
    assert all(path.parent == tmp_path / "many" for path in names) and len(set(names)) == len(labels)
    assert [path.name for path in names[3:]] == ["10000000.0", "0.3", "low"]
    (tmp_path / "else").mkdir()
    (tmp_path / "else" / "letter.txt").write_text("dear")
    with pytest.raises(dx.InputError, match=r"holds letter\.txt"):
        Many.claim(tmp_path / "else", labels)
    with pytest.raises(dx.InputError, match="no runs to go on with"):
        Many.claim(dx.Folder(tmp_path / "none", resume=True), labels)
    with pytest.raises(dx.InputError, match="is a file"):
        Many.claim(tmp_path / "else" / "letter.txt", labels)


def test_branches_and_refined_runs_are_kept_side_by_side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = dx.branches(column(), control=along(to=4.0), count=1, folder=tmp_path / "paths")
    loads = {"t_end": 0.04, "dt": 0.02, "levels": 2}
    model = swing(0.2).velocity("tip", (0, 0, 1.0))
    error = dx.refine(model, "node:tip:displacement:z", **loads, folder=tmp_path / "finer")
    taken = steps_taken(monkeypatch)
    again = dx.branches(column(), control=along(to=4.0), count=1, folder=dx.Folder(tmp_path / "paths", resume=True))
    assert taken == [0, 0, 0] and [a.r.tobytes() for a in again] == [b.r.tobytes() for b in found]
    folder = dx.Folder(tmp_path / "finer", resume=True)
    assert dx.refine(model, "node:tip:displacement:z", **loads, folder=folder) == error and set(taken) == {0}
    assert {p.name for p in (tmp_path / "paths").iterdir()} == {"path", "1+", "1-", "runs.json"}


def test_a_path_that_has_ended_goes_on_when_until_asks_for_more(tmp_path: Path) -> None:
    def path(to: float, **options: Any) -> dx.Result:
        way = dx.ArcLength(ds=0.02, until=lambda s: s.arc_length >= to)
        return dx.solve_static(column().force("b", (0, 0.01, 0)), control=way, **options)

    first = path(0.1, folder=tmp_path / "run")
    again = path(0.1, folder=dx.Folder(tmp_path / "run", resume=True))
    assert again.r.tobytes() == first.r.tobytes() and again.status == first.status
    on, whole = path(0.2, folder=dx.Folder(tmp_path / "run", resume=True)), path(0.2)
    assert on.r.tobytes() == whole.r.tobytes() and on.status == whole.status and len(on.t) > len(first.t)


def test_another_family_does_not_go_on_with_a_path(tmp_path: Path) -> None:
    dx.continuation(pushed_column, 1.0, control=WAY, folder=tmp_path / "run")
    with pytest.raises(dx.InputError, match="another model, or with other arguments"):
        dx.continuation(
            lambda p: pushed_column(p**2), 1.0, control=WAY, folder=dx.Folder(tmp_path / "run", resume=True)
        )
