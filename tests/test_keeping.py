"""A run that is killed goes on and ends with the same file; whatever fails, there is something to go on from."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from itertools import groupby
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from case_texts import swing_case
from kept_loads import IN_JOINTS, ON_THE_ARM
from kept_runs import FEW, Solve, every, flying
from typer.testing import CliRunner

import directrix as dx
from directrix.cli import app
from directrix.keeping import Keeper, RunFolder, disk
from directrix.keeping.store import Store

ALL = every()
KILLS = int(os.environ.get("DIRECTRIX_KILLS", "1"))
"""Of every model; more of them in CI, 200 in all among the long checks."""
END = -1
bent = FEW["load control"]


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test here pulls the plug: nobody has to wait for the disk."""
    monkeypatch.setattr(disk, "sync", lambda descriptor: None)


def frozen_at(
    solve: Solve, steps: Callable[[int], bool], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[bytes, dict[int, Path]]:
    """The file that a run ends with, and its folder as it was when it had checkpoints after some ``steps`` and, without
    the file, at its end."""
    copies: dict[int, Path] = {}
    keep = Keeper.keep

    def copying(
        self: Keeper, taken: int, t: float, memory: Callable[[], Mapping[str, Any]], *, done: bool = False
    ) -> None:
        keep(self, taken, t, memory, done=done)
        if self.folder is not None:
            taken = END if done else taken
            copies[taken] = folder / f"after {taken}"
            shutil.copytree(folder / "run", copies[taken])

    with monkeypatch.context() as patched:
        patched.setattr(Keeper, "keep", copying)
        patched.setattr(Keeper, "due", lambda self, taken: self.folder is not None and taken > self.at and steps(taken))
        patched.setattr(Keeper, "room", lambda self, taken: 1)
        solve(folder=folder / "run")
    return (folder / "run" / "result.vtkhdf").read_bytes(), copies


def gone_on(solve: Solve, folder: Path) -> bytes:
    solve(folder=dx.Folder(folder, resume=True))
    return (folder / "result.vtkhdf").read_bytes()


@pytest.mark.parametrize("name", [*FEW, "a form that is left"])
def test_a_run_goes_on_to_the_same_file(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, copies = frozen_at(ALL[name], lambda n: n in (5, 15), tmp_path, monkeypatch)
    assert END in copies and len(copies) > 1
    for copy in copies.values():
        assert gone_on(ALL[name], copy) == whole


def test_there_is_a_run_with_everything_that_acts() -> None:
    made = {name: getattr(what, "__annotations__", {}).get("return") for name, what in vars(dx.Model).items()}
    known = {name for name, what in made.items() if what == "Self" and not name.startswith("_")}
    describes = {"rod", "add_rods", "node", "split", "named", "velocity", "rigid_velocity"}
    acts = {name.split(",")[0] for name in (*ON_THE_ARM, *IN_JOINTS)}
    assert acts == known - describes


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_every_run_goes_on_from_any_step(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    frozen_at(ALL[name], lambda n: bool(seen.append(n)), tmp_path / "first", monkeypatch)
    chosen = Random(name).sample(seen, min(20, len(seen)))
    whole, copies = frozen_at(ALL[name], lambda n: n in chosen, tmp_path / "second", monkeypatch)
    assert len(chosen) >= 2 and set(chosen) == copies.keys() - {END}
    assert (END in copies) == dx.load(tmp_path / "second" / "run" / "result.vtkhdf").success
    assert [n for n, copy in copies.items() if gone_on(ALL[name], copy) != whole] == []


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
    assert killed_often(name, KILLS, tmp_path) >= 1


@pytest.mark.slow
@pytest.mark.parametrize("name", list(FEW)[:4])
def test_runs_killed_fifty_times(name: str, tmp_path: Path) -> None:
    killed_often(name, 50, tmp_path)


class Faulty:
    """The calls of the disk, counted; from number ``first`` on, ``many`` of them fail."""

    def __init__(self, patched: pytest.MonkeyPatch, first: int = 10**9, many: int = 1) -> None:
        self.first, self.many, self.calls, self.number = first, many, list[str](), errno.ENOSPC
        for name in ("write", "flush", "sync", "replace"):
            patched.setattr(disk, name, partial(self.call, name, getattr(disk, name)))

    def call(self, name: str, does: Callable[..., Any], *args: Any) -> Any:
        self.calls.append(name)
        if self.first < len(self.calls) <= self.first + self.many:
            raise OSError(self.number, os.strerror(self.number))
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
    assert {counted.calls[k] for k in places} == {"write", "flush", "sync", "replace"} or every > 1
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
    assert survived(tmp_path, monkeypatch, 17) > 5


@pytest.mark.slow
def test_after_any_fault_there_is_something_to_go_on_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert survived(tmp_path, monkeypatch, 1) > 60


@pytest.mark.parametrize(
    ("number", "says", "fix"),
    [
        (errno.ENOSPC, r"No space left on device; [\d.e+-]+ MB are needed, [\d.e+-]+ (MB|GB) are free", "make room"),
        (errno.EDQUOT, r"quota exceeded; [\d.e+-]+ MB are needed", "make room"),
        (errno.EROFS, "Read-only file system", "make the disk writable"),
        (errno.EACCES, "Permission denied", "check free space and permissions"),
    ],
)
def test_a_disk_that_takes_nothing_more_is_said(
    number: int, says: str, fix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        faulty = Faulty(patched, 10**9, 10**9)
        faulty.number = number
        keep, left = Store.keep, [2]

        def until_full(self: Store, serial: int, values: Mapping[str, Any]) -> int:
            left[0] -= 1
            if left[0] == 0:
                faulty.first = len(faulty.calls)
            return keep(self, serial, values)

        patched.setattr(Store, "keep", until_full)
        with pytest.raises(dx.InputError, match=says) as error:
            swing(folder=dx.Folder(tmp_path / "run", steps=1))
    assert error.value.fix.startswith(f"{fix}") and "then go on from the last checkpoint with: " in error.value.fix
    assert f"dx.Folder({str(tmp_path / 'run')!r}, resume=True)" in error.value.fix
    newest = Store(tmp_path / "run").newest()
    assert newest is not None and newest["serial"] == 1
    assert gone_on(swing, tmp_path / "run")


@pytest.mark.parametrize("name", FEW)
def test_what_is_kept_and_watched_changes_nothing(name: str, tmp_path: Path) -> None:
    often = FEW[name](save_every=1)
    rarely = FEW[name](save_every=3, progress=lambda done, line: None, folder=tmp_path / "run")
    again = FEW[name](save_every=1)
    assert often.audit == rarely.audit == again.audit
    np.testing.assert_array_equal(often.iterations, rarely.iterations)
    at = np.searchsorted(often.t, rarely.t) if often.t[-1] == often.t.max() else np.array([0, len(often.t) - 1])
    if name in (
        "a path",
        "a family of models",
    ):  # where the load factor turns back, instants are told apart by their place
        at = np.array([int(np.flatnonzero(often.t == t)[0]) for t in rarely.t])
    for field in ("t", "r", "R", "v", "Rdot", "strain", "force", "reaction", "joints", "history"):
        a, b, c = (getattr(run, field) for run in (often, rarely, again))
        assert a[at].tobytes() == b.tobytes() and a.tobytes() == c.tobytes(), field
    for field in ("kinetic", "stored", "work", "dissipated", "residual"):
        assert getattr(often.energy, field)[at].tobytes() == getattr(rarely.energy, field).tobytes(), field


# --- the command line

CASE = swing_case(radius=0.02, elements=4, ends=("A", "B")) + "[output]\nsave_every = 3\ncheckpoint_steps = 4\n"
BLIND = "--no-view", "-q"


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "swing.toml"
    path.write_text(CASE)
    return path


def command(*args: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, [str(a) for a in args])
    return done.exit_code, done.stdout + done.stderr


def stopped(case: Path, monkeypatch: pytest.MonkeyPatch, what: Callable[[], object], calls: int = 2) -> tuple[int, str]:
    """Run a case; at the given checkpoint something happens."""
    keep, left = Keeper.keep, [calls]

    def bad(self: Keeper, *args: Any, **options: Any) -> None:
        keep(self, *args, **options)
        left[0] -= 1
        if left[0] == 0:
            what()

    with monkeypatch.context() as patched:
        patched.setattr(Keeper, "keep", bad)
        return command("run", case, *BLIND)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_run_that_can_be_gone_on_with(
    case: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    assert command("run", case, *BLIND, "--out", case.parent / "whole")[0] == 0
    before = signal.getsignal(number)
    code, said = stopped(case, monkeypatch, lambda: os.kill(os.getpid(), number))
    folder = case.with_suffix(".run")
    assert code == 130 and f"Go on with directrix resume {folder}." in said
    assert signal.getsignal(number) is before
    assert dx.load(folder / "result.vtkhdf").t[-1] == pytest.approx(0.08)
    code, said = command("run", case, *BLIND)
    assert code == 2 and "interrupted at t = 0.08" in said and f"directrix resume {folder}" in said
    code, said = command("info", folder)
    assert code == 0 and "interrupted at t = 0.08" in said and "directrix resume" in said
    assert command("resume", folder, *BLIND)[0] == 0
    whole = case.parent / "whole"
    assert (folder / "result.vtkhdf").read_bytes() == (whole / "result.vtkhdf").read_bytes()
    assert (folder / "monitor.csv").read_bytes() == (whole / "monitor.csv").read_bytes()
    code, said = command("resume", folder, *BLIND)
    assert code == 2 and "has finished" in said and "--until" in said


LONG_STEP = """
import sys, time
from directrix import cli
from directrix.steplog import Log

took, left = Log.took, [7]

def slow(*args):
    left[0] -= 1
    if left[0] == 0:
        print("in a step", flush=True)
        for _ in range(3000):
            time.sleep(0.01)
    return took(*args)

Log.took = slow
cli.main()
"""
"""The command line, with one step that takes half a minute."""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_a_process_at_once(case: Path, number: signal.Signals) -> None:
    assert command("run", case, *BLIND, "--out", case.parent / "whole")[0] == 0
    with subprocess.Popen(
        [sys.executable, "-c", LONG_STEP, "run", str(case), *BLIND], stdout=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout is not None and run.stdout.readline() == "in a step\n"
        run.send_signal(number)
        with pytest.raises(subprocess.TimeoutExpired):
            run.wait(0.3)  # it finishes its step
        run.send_signal(number)
        assert run.wait(10) == -number
    folder = case.with_suffix(".run")
    assert not (folder / "result.vtkhdf").exists() and "last checkpoint at 0.04" in command("info", folder)[1]
    assert command("resume", folder, *BLIND)[0] == 0
    assert (folder / "result.vtkhdf").read_bytes() == (case.parent / "whole" / "result.vtkhdf").read_bytes()


def test_a_path_that_was_killed_goes_on(tmp_path: Path) -> None:
    case = tmp_path / "path.toml"
    known = (Path(__file__).parent / "good_cases" / "path.toml").read_text()
    small = known.replace("ds = 2", "ds = 0.1")
    assert small != known
    case.write_text(small + "[output]\ncheckpoint_steps = 1\n")
    assert command("run", case, *BLIND, "--out", tmp_path / "whole")[0] == 0
    folder = tmp_path / "path.run"
    with subprocess.Popen([sys.executable, "-m", "directrix", "run", str(case), *BLIND]) as run:
        while not Store(folder).segment(3).exists() and run.poll() is None:
            time.sleep(0.001)
        run.kill()
        assert run.wait() == -signal.SIGKILL
    assert json.loads((folder / "run.json").read_text())["status"]["code"] == "running"
    code, said = command("resume", folder, *BLIND)
    assert code == 0 and "begins anew" not in said
    for name in ("result.vtkhdf", "monitor.csv"):
        assert (folder / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_what_is_recorded_and_how_steps_adapt_go_on_too(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (case.parent / "line.csv").write_text("x,y,z\n0,0,0\n0.5,0,0\n1,0,0\n")
    text = CASE.replace("line = [[0, 0, 0], [1, 0, 0]]", 'centreline = { file = "line.csv" }')
    assert text != CASE
    case.write_text(text + '[[record]]\nrod = "rod"\ns = 0.4\nname = "middle"\n')
    adapt = "--adaptive", "1e-4"
    assert command("run", case, *BLIND, *adapt, "--out", case.parent / "whole")[0] == 0
    command_run = [str(a) for a in ("run", case, *BLIND, *adapt)]
    keep, left = Keeper.keep, [2]

    def bad(self: Keeper, *args: Any, **options: Any) -> None:
        keep(self, *args, **options)
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGTERM)

    with monkeypatch.context() as patched:
        patched.setattr(Keeper, "keep", bad)
        assert command(*command_run)[0] == 130
    folder, whole = case.with_suffix(".run"), case.parent / "whole"
    monkeypatch.chdir(folder)  # the case is not looked for where the command is
    code, said = command("resume", folder, *BLIND)
    assert code == 0, said
    for name in ("result.vtkhdf", "monitor.csv", "record-middle.csv"):
        assert (folder / name).read_bytes() == (whole / name).read_bytes(), name
    code, said = command("resume", folder, *BLIND, "--until", "2")
    assert code == 2 and "adapt" in said


def test_a_run_that_has_ended_goes_on_until_later(case: Path) -> None:
    assert command("run", case, *BLIND)[0] == 0
    folder = case.with_suffix(".run")
    assert command("export", folder, "--to", "csv")[0] == 0  # beside the result, where it does no harm
    assert command("resume", folder, "--until", 0.31, *BLIND)[0] == 0
    assert (folder / "result-csv" / "energy.csv").is_file()
    longer = case.with_name("longer.toml")
    longer.write_text('title = "swing"\n' + CASE.replace("0.2\n", "0.31\n"))
    assert command("run", longer, *BLIND)[0] == 0
    assert (folder / "result.vtkhdf").read_bytes() == (longer.with_suffix(".run") / "result.vtkhdf").read_bytes()
    code, said = command("resume", folder, "--until", 0.1, *BLIND)
    assert code == 2 and "has reached t = 0.31 already" in said


def test_our_own_fault_loses_nothing(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fault() -> None:
        raise ZeroDivisionError("float division")

    assert stopped(case, monkeypatch, fault)[0] == 1
    folder = case.with_suffix(".run")
    code, said = command("run", case, *BLIND)
    assert code == 2 and "was killed, or failed, after it had reached 0.08 in 8 steps" in said
    assert "--overwrite" in said and "directrix resume" in said
    code, said = command("plot", folder, "energy")
    assert code == 2 and "has not finished" in said
    assert "last checkpoint at 0.08" in command("info", folder)[1]
    assert command("run", case, *BLIND, "--overwrite")[0] == 0


def test_changed_input_is_refused_and_another_machine_is_warned_of(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert stopped(case, monkeypatch, lambda: os.kill(os.getpid(), signal.SIGINT))[0] == 130
    folder = case.with_suffix(".run")
    case.write_text(CASE.replace("9.81", "9.8"))
    code, said = command("resume", folder, *BLIND)
    assert code == 2 and "has changed since the run began" in said and "--force" in said
    case.write_text(CASE)
    (folder / "input.toml").write_text(CASE.replace("9.81", "9.8"))
    assert command("resume", folder, *BLIND)[0] == 2
    said = json.loads((folder / "run.json").read_text())
    said["environment"]["cpu"] = "abacus"
    (folder / "run.json").write_text(json.dumps(said))
    code, said = command("resume", folder, *BLIND, "--force")
    assert code == 0 and "cpu was abacus" in said and "has changed" in said


def test_damaged_checkpoints_and_segments_are_noticed(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert stopped(case, monkeypatch, lambda: os.kill(os.getpid(), signal.SIGINT), 3)[0] == 130
    folder = case.with_suffix(".run")
    store = Store(folder)
    newest = store.newest()
    assert newest is not None
    slot = store.slot(newest["serial"])
    data = slot.read_bytes()
    slot.write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
    older = store.newest()
    assert older is not None and older["serial"] == newest["serial"] - 1
    segment = store.segment(older["segments"] - 1)
    segment.write_bytes(segment.read_bytes()[:-8])
    assert store.newest() is None
    code, said = command("resume", folder, *BLIND)
    assert code == 0 and "begins anew" in said
    assert dx.load(folder / "result.vtkhdf").success


def test_two_runs_do_not_share_a_folder(tmp_path: Path) -> None:
    claimed = RunFolder.claim(dx.Folder(tmp_path / "run"))
    with pytest.raises(dx.InputError, match="belongs to a run that is on"):
        RunFolder.claim(dx.Folder(tmp_path / "run"))
    claimed.close()
    RunFolder.claim(dx.Folder(tmp_path / "run")).close()


def test_another_model_does_not_go_on_with_a_run(tmp_path: Path) -> None:
    bent(folder=tmp_path / "run")
    with pytest.raises(dx.InputError, match="another model, or with other arguments"):
        bent(folder=dx.Folder(tmp_path / "run", resume=True), tolerance=1e-8)


# --- what is kept


def test_parts_are_those_of_the_whole(tmp_path: Path) -> None:
    solve = FEW["a frame with joints"]
    whole = solve()
    part = solve(keep=dx.Keep(("top", "F"), ("velocity", "force")), folder=tmp_path / "run")
    assert [rod.name for rod in part.mesh.rods] == ["top"] and set(part.mesh.node_names) == {"C", "D", "F"}
    assert part.mesh.joints == ("joint2",) or len(part.mesh.joints) == 1
    for name in ("C", "D", "F"):
        for field in ("r", "R", "v", "displacement"):
            a, b = (getattr(run.node(name), field) for run in (whole, part))
            np.testing.assert_array_equal(a, b)
        assert np.isnan(part.node(name).reaction).all()
    np.testing.assert_array_equal(part.rod("top").force, whole.rod("top").force)
    (joint,) = part.mesh.joints
    np.testing.assert_array_equal(part.joint(joint).force, whole.joint(joint).force)
    np.testing.assert_array_equal(part.joint(joint).coordinate, whole.joint(joint).coordinate)
    assert part.audit == whole.audit
    np.testing.assert_array_equal(part.energy.total, whole.energy.total)
    again = dx.load(tmp_path / "run" / "result.vtkhdf")
    np.testing.assert_array_equal(again.r, part.r)
    assert again.view(tmp_path / "view.html")


@pytest.mark.parametrize(
    ("keep", "names"),
    [
        (lambda: dx.Keep("top"), "one text"),
        (lambda: dx.Keep(("nobody",)), "nobody"),
        (lambda: dx.Keep((), ()), "nothing is to be kept"),
        (lambda: dx.Keep(fields=("colour",)), "colour"),
        (lambda: dx.Keep(parts=3), "no names"),
    ],
)
def test_what_cannot_be_kept(keep: Callable[[], dx.Keep], names: str) -> None:
    with pytest.raises(dx.ModelError, match=names):
        FEW["a frame with joints"](keep=keep())
