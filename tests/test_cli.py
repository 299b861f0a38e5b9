"""The command line: exit codes, what is written and what is left alone, and two real runs."""

from __future__ import annotations

import csv
import dataclasses
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from fake_result import fake_result
from typer.testing import CliRunner

import directrix.cli
from directrix import runs
from directrix.audit import Audit, Entry
from directrix.cli import app
from directrix.keeping import RunFolder
from directrix.result import Result, Status
from directrix.schema import Case, load_case
from directrix.storage import load

HERE = Path(__file__).parent
COMMANDS = {
    "bench", "new", "convert", "export", "verify", "movie", "paper", "run", "resume", "refine", "check", "info", "plot",
    "view", "examples", "schema", "doctor",
}  # fmt: skip
ALWAYS = {"result.vtkhdf", "run.json", "monitor.csv"}
BESIDE = {"input.toml", "log.jsonl", ".lock", "parts"}
SAFE = "-m", "directrix"


@pytest.fixture(autouse=True)
def _no_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DIRECTRIX_TRACEBACK", raising=False)


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A copy of the free flight to run."""
    done = CliRunner().invoke(app, ["examples", "free_flight", "--copy", str(tmp_path)])
    assert done.exit_code == 0
    return tmp_path / "free_flight.toml"


def run(*args: object) -> tuple[int, str, str]:
    """Exit code, output and errors of a command."""
    done = CliRunner().invoke(app, [str(a) for a in args])
    return done.exit_code, done.stdout, done.stderr


def pretend(monkeypatch: pytest.MonkeyPatch, end: Result | BaseException) -> None:
    """Let every case end like this at once."""

    def fake(
        self: Case,
        progress: Callable[[float, str], None] | None = None,
        threads: int = 1,
        folder: RunFolder | None = None,
    ) -> Result:
        if isinstance(end, BaseException):
            raise end
        assert progress is not None
        progress(0.5, "t = 1  H = 2.5  3 iterations")
        progress(1.0, "t = 2  H = 2.5  3 iterations")
        if folder is not None:
            folder.begin("")
            folder.write(end)
        return end

    monkeypatch.setattr(Case, "run", fake)


def left(folder: Path) -> set[str]:
    """What a run leaves beside the things to go on with it."""
    return {p.name for p in folder.iterdir()} - BESIDE


def failed_audit() -> Audit:
    return Audit((Entry("energy", 1e-3, 1e-9, "2.5"),))


# --- how a run ends


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({}, 0),
        ({"status": Status("stopped", "the stop asked for was reached.")}, 0),
        ({"status": Status("not_converged", "stopped at t = 1.", "Take smaller steps.")}, 3),
        ({"status": Status("non_finite", "node B is not finite.", "Look at the loads.")}, 3),
        ({"status": Status("singular", "nothing holds the rod.", "Add a support.")}, 3),
        ({"audit": failed_audit()}, 4),
        ({"status": Status("not_converged", "stopped.", ""), "audit": failed_audit()}, 3),
        ({"status": Status("interrupted", "interrupted at t = 1.", "Go on with start=.")}, 130),
    ],
)
def test_exit_codes_and_the_results_so_far(
    monkeypatch: pytest.MonkeyPatch, case: Path, change: dict[str, object], code: int
) -> None:
    result = dataclasses.replace(fake_result(), **change)  # type: ignore[arg-type]
    pretend(monkeypatch, result)
    got, out, _ = run("run", case, "--no-view")
    assert got == code
    assert result.status.sentence in out and result.audit.verdict in out
    folder = case.with_suffix(".run")
    assert left(folder) == ALWAYS
    assert all(f"wrote {folder / name}" in out for name in ALWAYS)
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"]["code"] == result.status.code
    assert summary["status"]["exit_code"] == code
    assert summary["audit"]["passed"] is result.audit.passed
    np.testing.assert_array_equal(load(folder / "result.vtkhdf").r, result.r)


def test_what_is_written(monkeypatch: pytest.MonkeyPatch, case: Path, tmp_path: Path) -> None:
    result = fake_result()
    pretend(monkeypatch, result)
    out = tmp_path / "deep" / "there"
    assert run("run", case, "--out", out)[0] == 0
    pictures = {"energy.png", "momentum.png", "motion.png"} if runs.can_draw() else set()
    assert left(out) == {*ALWAYS, "view.html", *pictures}
    assert all((out / name).stat().st_size > 1000 for name in left(out))
    assert (out / "input.toml").read_bytes() == case.read_bytes()
    summary = json.loads((out / "run.json").read_text())
    assert summary["input"]["sha256"] == load_case(case).sha256
    assert summary["energy"]["total"]["first"] == result.energy.total[0]
    assert [law["law"] for law in summary["audit"]["laws"]] == [e.law for e in result.audit.entries]
    with (out / "monitor.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(result.t)
    # full precision: what is read back is what was written
    assert [float(row["kinetic"]) for row in rows] == result.energy.kinetic.tolist()
    assert [float(row["residual"]) for row in rows] == result.energy.residual.tolist()
    assert [float(row["Jz"]) for row in rows] == result.momentum.angular[:, 2].tolist()


def test_another_scheme_beside_it(case: Path) -> None:
    code, out, _ = run("run", case, "--beside", "midpoint")
    folder = case.with_suffix(".run")
    assert code == 0 and "The same under midpoint" in out and "not claimed" in out
    assert (folder / "comparison.png").exists() is runs.can_draw()
    # what is kept is the run that was asked for
    assert "EnergyMomentum" in load(folder / "result.vtkhdf").info["integrator"]


@pytest.mark.parametrize(("name", "scheme", "part"), [("free_flight", "energy-momentum", "already"),
                                                      ("bend45", "midpoint", "no time step")])  # fmt: skip
def test_a_scheme_that_cannot_run_beside_it(tmp_path: Path, name: str, scheme: str, part: str) -> None:
    assert run("examples", name, "--copy", tmp_path)[0] == 0
    code, _, err = run("run", tmp_path / f"{name}.toml", "--beside", scheme)
    assert code == 2 and part in err and f"{name}.toml" in err
    assert not (tmp_path / f"{name}.run").exists()


def test_a_static_run_has_no_momentum_to_draw(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, fake_result("static"))
    assert run("run", case)[0] == 0
    assert not (case.with_suffix(".run") / "momentum.png").exists()
    header = (case.with_suffix(".run") / "monitor.csv").read_text().split(",")[0]
    assert header == "load_factor"


def test_nan_in_a_result_leaves_valid_json(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    result = fake_result(fails=True)
    result.energy.kinetic[-1] = np.nan
    pretend(monkeypatch, result)
    assert run("run", case, "--no-view")[0] == 3

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is not JSON")

    text = (case.with_suffix(".run") / "run.json").read_text()
    assert json.loads(text, parse_constant=refuse)["energy"]["kinetic"]["last"] is None


def test_quiet_prints_only_what_went_wrong(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, fake_result())
    assert run("run", case, "--quiet", "--no-view") == (0, "", "")
    pretend(monkeypatch, fake_result(fails=True))
    code, out, err = run("run", case, "--quiet", "--no-view")
    assert (code, out) == (3, "") and "Newton found no solution" in err


# --- whose folder is it


def test_an_earlier_run_is_replaced_whole(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, fake_result())
    assert run("run", case)[0] == 0
    pretend(monkeypatch, fake_result(instants=7))
    assert run("run", case, "--no-view")[0] == 0
    folder = case.with_suffix(".run")
    assert left(folder) == ALWAYS  # no animation of the earlier run is left
    assert len(load(folder / "result.vtkhdf").t) == 7


@pytest.mark.parametrize("name", ["notes.txt", "result.vtkhdf", "run.json"])
def test_a_folder_with_other_files_is_left_alone(monkeypatch: pytest.MonkeyPatch, case: Path, name: str) -> None:
    pretend(monkeypatch, AssertionError("must not be run"))
    folder = case.with_suffix(".run")
    folder.mkdir()
    (folder / name).write_text("mine")
    code, _, err = run("run", case)
    assert code == 2 and name in err and "--out" in err
    assert [p.name for p in folder.iterdir()] == [name]
    assert (folder / name).read_text() == "mine"


def test_a_file_in_the_place_of_the_folder(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, AssertionError("must not be run"))
    case.with_suffix(".run").write_text("mine")
    code, _, err = run("run", case)
    assert code == 2 and "is a file, not a folder" in err


# --- whose fault is it


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_wrong_case_is_two_lines_and_code_2(command: str, tmp_path: Path) -> None:
    path = HERE / "bad_cases" / "unknown_key.toml"
    args = [command, path, *(["--out", tmp_path / "out"] if command == "run" else [])]
    code, out, err = run(*args)
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {path}:18:1: rod[arm].elemnts: unknown key") and "fix: did you mean" in err
    assert "Traceback" not in err
    assert not (tmp_path / "out").exists()


def test_our_own_fault_is_code_1(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, ZeroDivisionError("float division"))
    code, _, err = run("run", case)
    assert code == 1 and "ZeroDivisionError" in err and "report" in err and "Traceback" not in err
    code, _, err = run("--traceback", "run", case)
    assert code == 1 and "Traceback" in err and "in fake" in err
    assert "Traceback" not in run("run", case)[2]  # asked for once, not for ever


def test_interrupted_before_the_first_step(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, KeyboardInterrupt())
    code, _, err = run("run", case)
    assert code == 130 and "interrupted" in err


def test_a_full_disk_is_not_our_fault(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, OSError(28, "No space left on device", "result.vtkhdf"))
    code, _, err = run("run", case)
    assert code == 2 and "result.vtkhdf: No space left on device" in err


def test_usage_errors_are_bad_input() -> None:
    assert run("run")[0] == 2
    assert run("dance")[0] == 2


# --- looking at results


@pytest.fixture
def finished(monkeypatch: pytest.MonkeyPatch, case: Path) -> Path:
    """The folder of a run."""
    pretend(monkeypatch, fake_result())
    assert run("run", case, "--no-view")[0] == 0
    return case.with_suffix(".run")


def test_info(finished: Path) -> None:
    by_folder, by_file = run("info", finished), run("info", finished / "result.vtkhdf")
    assert by_folder == by_file
    code, out, _ = by_folder
    assert code == 0
    for word in ("audit passed", "left, mid, right", "A, O, B, C", "40 saved instants", "EnergyMomentum()"):
        assert word in out


def test_no_such_result(tmp_path: Path) -> None:
    for command in (["info", tmp_path], ["view", tmp_path / "x.vtkhdf"], ["plot", tmp_path, "energy"]):
        code, _, err = run(*command)
        assert code == 2 and "no such result" in err


def test_view(finished: Path, tmp_path: Path) -> None:
    assert run("view", finished)[0] == 0
    assert "<html" in (finished / "view.html").read_text()
    assert run("view", finished, "--out", tmp_path / "other.html")[0] == 0
    assert (tmp_path / "other.html").exists()


@pytest.mark.skipif(not runs.can_draw(), reason="matplotlib is not installed")
@pytest.mark.parametrize("what", ["shape", "motion", "energy", "momentum"])
def test_plot(finished: Path, what: str) -> None:
    code, out, _ = run("plot", finished, what)
    assert (code, out) == (0, f"wrote {finished / what}.png\n")
    assert (finished / f"{what}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not runs.can_draw(), reason="matplotlib is not installed")
def test_plot_of_a_history(finished: Path, tmp_path: Path) -> None:
    assert run("plot", finished, "history", "--node", "B", "--quantity", "v", "--out", tmp_path / "b.svg")[0] == 0
    assert "<svg" in (tmp_path / "b.svg").read_text()
    for args, says in (
        (["history"], "nodes: A, O, B, C"),
        (["history", "--node", "Q"], "no node 'Q'"),
        (["energy", "--node", "B"], "takes no --node"),
        (["energy", "--out", tmp_path / "x.docx"], "endings"),
        (["energy", "--out", tmp_path / "nowhere" / "x.png"], "nowhere"),
    ):
        code, _, err = run("plot", finished, *args)
        assert code == 2 and says in err


def test_without_matplotlib_a_run_says_what_is_missing(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    pretend(monkeypatch, fake_result())
    monkeypatch.setattr(runs, "can_draw", lambda: False)
    code, out, _ = run("run", case)
    assert code == 0 and "directrix[plot]" in out
    assert left(case.with_suffix(".run")) == {*ALWAYS, "view.html"}


# --- the rest


def test_check_says_what_would_be_solved(case: Path) -> None:
    code, out, _ = run("check", case)
    assert code == 0
    for word in (
        "150 steps of 0.2", "3 rods, 15 elements, 16 nodes, 96 unknowns", "B at (3, 0, 0)",
        "GA1 = 961.538, GA2 = 961.538, EA = 2500", "A_rho = 2.5", "d1 = (1, 0, 0), d3 = (0, -1, 0)",
        "v = (0, 0, 2)", "bending about d1", "can be run",
    ):  # fmt: skip
        assert word in out, word


def test_examples_are_listed_printed_and_copied(tmp_path: Path) -> None:
    names = ["bend45", "cantilever_pulse", "free_flight", "hinged_frame", "objectivity", "swinging_rod"]
    out = run("examples")[1]
    assert [line.split()[0] for line in out.split("\n")[: len(names)]] == names
    assert run("examples", "--copy", tmp_path)[0] == 0
    assert sorted(p.stem for p in tmp_path.iterdir()) == names
    assert run("examples", "bend45")[1] == (tmp_path / "bend45.toml").read_text("utf-8")
    assert run("examples", "bend45.toml", "--copy", tmp_path)[0] == 0  # the same again does no harm
    (tmp_path / "bend45.toml").write_text("mine")
    code, _, err = run("examples", "bend45", "--copy", tmp_path)
    assert code == 2 and "different" in err and (tmp_path / "bend45.toml").read_text() == "mine"
    assert run("examples", "no_such")[0] == 2


def test_schema(tmp_path: Path) -> None:
    printed = json.loads(run("schema")[1])
    assert run("schema", "--out", tmp_path / "schema.json")[0] == 0
    assert json.loads((tmp_path / "schema.json").read_text()) == printed
    assert printed["properties"]["rod"]


def test_help_names_the_commands_of_this_release_and_no_others() -> None:
    assert {
        command.name or command.callback.__name__ for command in app.registered_commands if command.callback
    } == COMMANDS
    out = run("--help")[1]
    assert all(name in out for name in COMMANDS)


def test_version() -> None:
    assert run("--version") == (0, f"directrix {directrix.__version__}\n", "")


def test_help_loads_no_compiler() -> None:
    code = (
        "import sys; sys.argv = ['directrix', '--help']\n"
        "from directrix.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "slow = {'llvmlite', 'scipy', 'numpy', 'h5py', 'matplotlib'} & set(sys.modules)\n"
        "assert not slow, slow"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


# --- with the real solvers


def test_doctor() -> None:
    code, out, _ = run("doctor")
    assert code == 0 and "passed: energy, linear momentum, angular momentum" in out and "compiled kernels" in out


def test_free_flight_from_its_file(case: Path) -> None:
    code, out, err = run("run", case)
    assert code == 0, out + err
    result = load(case.with_suffix(".run") / "result.vtkhdf")
    assert result.t[-1] == pytest.approx(30.0) and len(result.t) == 151
    np.testing.assert_allclose(result.energy.total, 2.5, rtol=1e-11)
    np.testing.assert_allclose(result.momentum.linear, np.tile((0, -0.75, 2.25), (151, 1)), atol=1e-11)
    summary = json.loads((case.with_suffix(".run") / "run.json").read_text())
    assert summary["audit"]["passed"] and summary["steps"]["taken"] == 150


def test_what_was_computed_before_an_interruption_is_kept(monkeypatch: pytest.MonkeyPatch, case: Path) -> None:
    @contextmanager
    def live(_: object) -> Iterator[Callable[[float, str], None]]:
        def progress(done: float, text: str) -> None:
            assert "iterations" in text
            if done > 0.1:
                raise KeyboardInterrupt

        yield progress

    monkeypatch.setattr("directrix.console.live", live)
    code, out, _ = run("run", case, "--no-view")
    assert code == 130 and "interrupted at t = " in out
    result = load(case.with_suffix(".run") / "result.vtkhdf")
    assert 3.0 <= result.t[-1] <= 3.4 and result.status.code == "interrupted"
    assert json.loads((case.with_suffix(".run") / "run.json").read_text())["status"]["exit_code"] == 130


ROLL_UP = """
[section.unit]
kind = "moduli"
EA = 1e4
GA1 = 1e4
GA2 = 1e4
EI1 = 100
EI2 = 100
GJ = 100
[[rod]]
name = "rod"
section = "unit"
line = [[0, 0, 0], [10, 0, 0]]
ends = ["root", "tip"]
elements = 8
order = 1
[[support]]
node = "root"
type = "clamp"
[[moment]]
node = "tip"
value = [0, 0, 62.83185307179586]
[statics]
"""


def test_a_run_that_cannot_converge_keeps_what_it_has(tmp_path: Path) -> None:
    # eight linear elements carry no more than n/(4π) = 0.6366 of a full turn
    path = tmp_path / "roll.toml"
    path.write_text(ROLL_UP)
    code, out, _ = run("run", path, "--no-view")
    assert code == 3 and "stopped at load factor 0.63" in out and "refine or raise the order" in out
    result = load(tmp_path / "roll.run" / "result.vtkhdf")
    assert 0.63 < result.t[-1] < 0.6367 and np.isfinite(result.r).all()
    assert json.loads((tmp_path / "roll.run" / "run.json").read_text())["status"]["code"] == "not_converged"


def test_bend_from_its_file(tmp_path: Path) -> None:
    assert run("examples", "bend45", "--copy", tmp_path)[0] == 0
    command = [sys.executable, *SAFE, "run", str(tmp_path / "bend45.toml"), "--no-view"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    tip = load(tmp_path / "bend45.run" / "result.vtkhdf").node("tip").r[-1]
    np.testing.assert_allclose(tip, (47.150439, 53.474859, 15.684801), rtol=1e-4)


def test_the_turned_rod_keeps_its_reactions(tmp_path: Path) -> None:
    assert run("examples", "objectivity", "--copy", tmp_path)[0] == 0
    assert run("run", tmp_path / "objectivity.toml", "--no-view")[0] == 0
    result = load(tmp_path / "objectivity.run" / "result.vtkhdf")
    at_a = result.node("A")
    for k in range(4, 11):
        seen = np.concatenate([at_a.R[k].T @ at_a.reaction[k, :3], at_a.R[k].T @ at_a.reaction[k, 3:]])
        wanted = (-21457.6583, 21457.6583, -160654.3099, -3786.5495, -3786.5495, 0.0)
        np.testing.assert_allclose(seen, wanted, rtol=1e-8, atol=1e-4)


MACHINE = """
[section.s]
kind = "moduli"
EA = 1e4
GA1 = 1e4
GA2 = 1e4
EI1 = 100
EI2 = 100
GJ = 100
A_rho = 1
I_rho1 = 0.01
I_rho2 = 0.01
{damping}
[[rod]]
name = "r"
section = "s"
line = [[0, 0, 0], [2, 0, 0]]
ends = ["a", "b"]
elements = 4
[[force]]
node = "b"
value = [0, 1, 0]
follower = true
{attached}
[dynamics]
t_end = 0.5
dt = 0.05
integrator = "{scheme}"
"""
ATTACHED = """
[[spring]]
name = "spring"
a = "a"
b = [0, 0, 1]
stiffness = 50
{link_damping}
[[cable]]
a = "b"
b = [2, 0, 1]
stiffness = 500
length = 0.9
"""
BODIES = """
[[rigid_body]]
node = "b"
mass = 2
inertia = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
[[point_mass]]
node = "a"
mass = 1
"""


@pytest.mark.parametrize(
    ("scheme", "damped", "bodies"),
    [
        ("energy-momentum", True, True),
        ("midpoint", True, True),
        ("energy-dissipating", True, True),
        ("generalized-alpha", False, True),
        ("hilber-hughes-taylor", False, True),
        ("newmark", False, True),
        ("simo-tarnow-doblare", False, False),
    ],
)
def test_every_scheme_runs_a_machine_from_its_case_file(
    tmp_path: Path, scheme: str, damped: bool, bodies: bool
) -> None:
    attached = ATTACHED.format(link_damping="damping = 0.5" if damped else "") + (BODIES if bodies else "")
    text = MACHINE.format(damping="damping = 0.01" if damped else "", attached=attached, scheme=scheme)
    file = tmp_path / "machine.toml"
    file.write_text(text, "utf-8")
    code, out, _ = run("check", file)
    assert code == 0 and "spring spring: a – ground at (0, 0, 1)" in out and "turns with the node" in out
    code, _, err = run("run", file, "--no-view", "--quiet")
    assert code == 0, err
    summary = json.loads((tmp_path / "machine.run" / "run.json").read_text())
    laws = {law["law"]: law for law in summary["audit"]["laws"]}
    assert ("dissipation" in laws) == (damped or scheme == "energy-dissipating")
    assert summary["energy"]["dissipated"]["last"] >= 0.0
