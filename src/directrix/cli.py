"""The command line: reads cases, calls the solvers, shows and keeps what they return. No mechanics here.

Exit codes: 0 done, 1 a fault of directrix, 2 bad input, 3 not converged, 4 the audit failed, 130 interrupted.
Whatever is slow to import is imported by the command that needs it.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from enum import StrEnum
from functools import wraps
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ParamSpec

import typer

from directrix.errors import InputError, ModelError

if TYPE_CHECKING:
    from directrix.keeping import RunFolder
    from directrix.result import Result
    from directrix.schema import Case

__all__ = ["app", "main"]

P = ParamSpec("P")
TRACEBACK = "DIRECTRIX_TRACEBACK"

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Geometrically exact rods and frames: run a case, look at what came out, see what it conserved.",
    epilog="Exit codes: 0 done, 1 our fault, 2 bad input, 3 not converged, 4 audit failed, 130 interrupted",
)

CaseFile = Annotated[Path, typer.Argument(metavar="CASE", help="A case file, .toml or .json.", show_default=False)]
ResultFile = Annotated[
    Path, typer.Argument(metavar="RESULT", help="A result file, or the folder of a run.", show_default=False)
]


Threads = Annotated[
    int, typer.Option(min=1, help="Threads that share the work on a frame; no bit of the result depends on it.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only what went wrong.")]


class Scheme(StrEnum):
    """What ``run --beside`` can run."""

    midpoint = "midpoint"
    energy_momentum = "energy-momentum"
    energy_dissipating = "energy-dissipating"
    generalized_alpha = "generalized-alpha"
    hilber_hughes_taylor = "hilber-hughes-taylor"
    newmark = "newmark"
    simo_tarnow_doblare = "simo-tarnow-doblare"


class Picture(StrEnum):
    """What ``plot`` can draw."""

    shape = "shape"
    motion = "motion"
    energy = "energy"
    momentum = "momentum"
    history = "history"
    path = "path"
    branches = "branches"


class Quantity(StrEnum):
    """What ``plot … history`` can draw of a node."""

    displacement = "displacement"
    r = "r"
    v = "v"
    reaction = "reaction"


class Component(StrEnum):
    """What ``plot … path`` can draw a load factor over."""

    x = "x"
    y = "y"
    z = "z"


def main() -> None:
    """The command ``directrix``; ``--traceback`` may stand anywhere."""
    if "--traceback" in sys.argv:
        sys.argv = [a for a in sys.argv if a != "--traceback"]
        os.environ[TRACEBACK] = "1"
    app()


def _guarded(command: Callable[P, int | None]) -> Callable[P, None]:
    """Turn what a command returns or raises into an exit code and one message."""

    @wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            code = command(*args, **kwargs) or 0
        except (typer.Exit, typer.Abort, BrokenPipeError):
            raise
        except ModelError as error:
            code = _failed(2, f"error: {error}")
        except KeyboardInterrupt:
            code = _failed(130, "interrupted: nothing was saved")
        except OSError as error:
            code = _failed(2, f"error: {error.filename or 'the system'}: {error.strerror or error}")
        except Exception as error:
            code = _failed(
                1,
                f"internal error: {type(error).__name__}: {error}\n"
                "  This is a fault of directrix, not of your input. Please report it, with the case file,\n"
                f"  what 'directrix doctor' prints, and the traceback of --traceback (or {TRACEBACK}=1).",
            )
        raise typer.Exit(code)

    return run


def _failed(code: int, message: str) -> int:
    """Say what went wrong, with the traceback of the error at hand when it was asked for."""
    _say(message)
    if os.environ.get(TRACEBACK):
        traceback.print_exc()
    return code


def _print_version(wanted: bool) -> None:
    if wanted:
        from directrix import __version__

        print(f"directrix {__version__}")
        raise typer.Exit


Version = Annotated[
    bool,
    typer.Option("--version", is_eager=True, callback=_print_version, help="Print the version and leave."),
]
Traceback = Annotated[bool, typer.Option("--traceback", help="Show the traceback of an error as well.")]


@app.callback()
def _options(version: Version = False, traceback: Traceback = False) -> None:  # pyright: ignore[reportUnusedFunction]
    if traceback:
        os.environ[TRACEBACK] = "1"


@app.command()
@_guarded
def run(
    case_file: CaseFile,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for what comes out; default CASE.run.")
    ] = None,
    no_view: Annotated[bool, typer.Option("--no-view", help="Leave out the HTML animation and the pictures.")] = False,
    beside: Annotated[Scheme | None, typer.Option(help="Run this scheme too and draw both in one picture.")] = None,
    threads: Threads = 1,
    quiet: Quiet = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Throw away an unfinished run in the folder.")] = False,
) -> int:
    """Solve a case; write the result, run.json, monitor.csv, pictures and an HTML animation."""
    from directrix.keeping import RunFolder, Source
    from directrix.schema import load_case

    case = load_case(case_file)
    rival = case.stepped_by(beside.value) if beside else None
    folder = RunFolder.claim(
        case.kept_in(out or case_file.with_suffix(".run"), overwrite=overwrite),
        Source(case.title, case_file, case.raw, case.sha256), command=True,
    )  # fmt: skip
    return _solve(case, rival, folder, f"{case.title}  ({case_file})", no_view, threads, quiet)


@app.command()
@_guarded
def resume(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.", show_default=False)],
    until: Annotated[float | None, typer.Option(metavar="T", help="Go on to this time, also after the end.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Go on though the input has changed.")] = False,
    no_view: Annotated[bool, typer.Option("--no-view", help="Leave out the HTML animation and the pictures.")] = False,
    threads: Threads = 1,
    quiet: Quiet = False,
) -> int:
    """Go on with a run that was killed or interrupted, to the same digits; --until goes on with one that has ended."""
    from directrix.keeping import RunFolder
    from directrix.keeping.resuming import frozen
    from directrix.schema import load_case

    found = frozen(run_folder, force=force, until=until)
    for line in found.warnings:
        _say(f"warning: {line}")
    case = load_case(found.path, found.title)
    case = case if found.until is None else case.until(found.until)
    folder = RunFolder.claim(case.kept_in(run_folder, resume=True, force=force), command=True)
    folder.more = {} if found.until is None else {"until": found.until}
    return _solve(case, None, folder, f"{case.title}  ({run_folder})", no_view, threads, quiet)


def _solve(
    case: Case, rival: Case | None, folder: RunFolder, heading: str, no_view: bool, threads: int, quiet: bool
) -> int:
    """Run a case in its folder, and its rival beside it; show and draw what came out."""
    from rich.console import Console

    from directrix.console import live, show
    from directrix.runs import can_draw, draw_all, exit_code, written

    console = Console(quiet=quiet, highlight=False)

    def solve(case: Case, heading: str, folder: RunFolder | None = None) -> Result:
        console.print(heading, style="bold", markup=False, soft_wrap=True)
        with live(console) as progress:
            return case.run(progress, threads, folder)

    try:
        # written before anything is shown: what was computed is not lost to a fault further on
        result = solve(case, heading, folder)
    finally:
        folder.close()
    show(console, result)
    both: dict[str, Result] = {}
    if rival is not None and result.status.code != "interrupted":
        both = {case.scheme: result, rival.scheme: solve(rival, f"\nThe same under {rival.scheme}")}
        show(console, both[rival.scheme])
    no_view = no_view or result.status.code == "interrupted"
    for path in chain(written(folder.path), () if no_view else draw_all(folder.path, result, both)):
        console.print(f"wrote {path}", markup=False, soft_wrap=True)
    if not no_view and not can_draw():
        console.print('no pictures: matplotlib is missing; pip install "directrix[plot]"', markup=False)
    code = exit_code(result)
    if code and quiet:
        _say(f"{folder.path}: {result.status} audit {result.audit.verdict}")
    return code


@app.command()
@_guarded
def check(case_file: CaseFile) -> None:
    """Check a case without solving it; print what would be solved, with every default and convention."""
    from directrix.schema import load_case
    from directrix.schema.describe import describe

    print(describe(load_case(case_file)))


@app.command()
@_guarded
def info(result_file: ResultFile) -> None:
    """Print what a result holds: how it ended, its audit, its names, the largest force and moment of every joint.

    Of a run that is on, or has not finished, print how far it is and how to go on."""
    import numpy as np

    from directrix.keeping.folder import about, summary_of, unfinished

    said = summary_of(result_file) if result_file.is_dir() else None
    if said is not None and unfinished(said):
        for line in about(result_file):
            print(line)
        return
    result, path = _load(result_file)
    print(result)
    print(f"  file {path}")
    print(f"  {len(result.t)} saved instants; rods: {', '.join(r.name for r in result.mesh.rods) or 'none'}")
    print(f"  named nodes: {', '.join(result.mesh.node_names)}")
    for name in result.mesh.joints:
        joint = result.joint(name)
        force, moment = (np.linalg.norm(part, axis=1).max() for part in (joint.force, joint.moment))
        print(f"  joint {name}: force up to {force:.6g}, moment up to {moment:.6g}")
    for key, value in result.info.items():
        print(f"  {key} = {value}")


@app.command()
@_guarded
def plot(
    result_file: ResultFile,
    what: Annotated[Picture, typer.Argument(help="What to draw.", show_default=False)],
    node: Annotated[str | None, typer.Option(help="history, path, branches: the node.")] = None,
    quantity: Annotated[Quantity, typer.Option(help="history: what of it.")] = Quantity.displacement,
    component: Annotated[Component, typer.Option(help="path, branches: which displacement of it.")] = Component.y,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Picture file; default beside the result.")] = None,
) -> None:
    """Draw a picture of a result: the last shape, the motion, energy, momentum, a node's history or path under load."""
    from directrix.runs import draw

    result, path = _load(result_file)
    options: dict[str, str] = {}
    if what in (Picture.history, Picture.path, Picture.branches):
        if node is None:
            raise ModelError(
                f"a {what.value} is that of a node", f"add --node; nodes: {', '.join(result.mesh.node_names)}"
            )
        more = {"quantity": quantity.value} if what is Picture.history else {"component": component.value}
        options = {"node": node, **more}
    elif node is not None:
        raise ModelError(f"{what.value} takes no node", "leave --node out, or draw history or path")
    name = "-".join([what.value, *options.values()])
    print(f"wrote {draw(result, what.value, out or path.with_name(f'{name}.png'), **options)}")


@app.command()
@_guarded
def view(
    result_file: ResultFile,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Where to write; default beside the result.")] = None,
) -> None:
    """Write one HTML page that shows the motion: orbit, time slider, directors; needs no network."""
    result, path = _load(result_file)
    print(f"wrote {result.view(out or path.with_name('view.html'))}")


@app.command()
@_guarded
def examples(
    name: Annotated[str | None, typer.Argument(help="Print this example.", show_default=False)] = None,
    copy: Annotated[Path | None, typer.Option("--copy", metavar="DIR", help="Copy it, or all of them, there.")] = None,
) -> None:
    """List the cases that come along, print one, or copy them out."""
    import tomllib
    from importlib.resources import files

    cases = {
        f.name.removesuffix(".toml"): f.read_text("utf-8")
        for f in files("directrix.cases").iterdir()
        if f.name.endswith(".toml")
    }
    if name is not None and name.removesuffix(".toml") not in cases:
        raise ModelError(f"there is no example {name!r}", f"examples: {', '.join(sorted(cases))}")
    chosen = {name.removesuffix(".toml"): cases[name.removesuffix(".toml")]} if name else dict(sorted(cases.items()))
    if copy is not None:
        _copy(chosen, copy)
    elif name:
        print(chosen.popitem()[1], end="")
    else:
        for key, text in chosen.items():
            print(f"{key:<20} {tomllib.loads(text)['title']}")
        print("\ndirectrix examples NAME prints one, --copy DIR copies it (without NAME: all)")


@app.command()
@_guarded
def schema(
    out: Annotated[Path | None, typer.Option("--out", "-o", help="File to write; default: print.")] = None,
) -> None:
    """The JSON schema of case files: every key, its type, its default, what it means."""
    import json

    from directrix.schema import json_schema

    text = json.dumps(json_schema(), indent=2, ensure_ascii=False)
    if out is None:
        print(text)
    else:
        out.write_text(text + "\n", encoding="utf-8")
        print(f"wrote {out}")


@app.command()
@_guarded
def doctor() -> int:
    """Look at this installation: versions, compiler, cache, extras, and a small run whose audit must pass."""
    from directrix.doctor import facts, self_test

    for key, value in facts():
        print(f"{key:<18} {value}")
    passed, sentence = self_test()
    print(f"{'self test':<18} {sentence}")
    return 0 if passed else 4


@app.command()
@_guarded
def verify(
    everything: Annotated[bool, typer.Option("--all", help="The long cases as well.")] = False,
    only: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A name or a section; * and ? match; may be repeated.")
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="Print the cases and run none.")] = False,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Write every row with all its digits.")] = None,
) -> int:
    """Run the validation suite: published and exact values beside what is computed here, with sources."""
    from rich.console import Console

    from directrix.verification import report
    from directrix.verification.suite import select

    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    cases = select(tuple(only or ()), everything or (listed and not only))
    if listed:
        report.listing(console, cases)
        return 0
    outcomes = report.run(console, cases)
    if json is not None:
        report.write_json(json, outcomes)
        console.print(f"wrote {json}", markup=False, soft_wrap=True)
    return 0 if all(o.passed for o in outcomes) else 4


@app.command()
@_guarded
def paper(
    out: Annotated[Path, typer.Option("--out", "-o", help="The HTML file to write.")] = Path("paper.html"),
    quick: Annotated[bool, typer.Option("--quick", help="Shorten the long motions.")] = False,
) -> None:
    """Recompute Section 5 of Romero and Armero (2002): one offline HTML page, printed values beside ours."""
    from directrix.paper.page import report

    if not out.parent.is_dir():
        raise InputError("there is no such folder", "make it, or name another file with --out", str(out.parent))
    out.write_text(report(quick, lambda title: print(title, flush=True)), encoding="utf-8")
    print(f"wrote {out}")


def _load(path: Path) -> tuple[Result, Path]:
    """A result file, or the one in the folder of a run."""
    from directrix.keeping.folder import how_far, summary_of
    from directrix.keeping.store import resume_command
    from directrix.runs import RESULT
    from directrix.storage import load

    said = summary_of(path) if path.is_dir() else None
    if said is not None and said["status"]["code"] == "running":  # a result that is there is that of an earlier run
        raise InputError(f"holds a run that has not finished: {how_far(path, said)}", resume_command(path), str(path))
    file = path / RESULT if path.is_dir() else path
    if not file.is_file():
        raise InputError("there is no such result", "name a .vtkhdf file or the folder that run wrote", str(file))
    return load(file), file


def _copy(texts: dict[str, str], folder: Path) -> None:
    """Write case files; one that is there with other content is left and refused."""
    targets = {folder / f"{name}.toml": text for name, text in texts.items()}
    for path, text in targets.items():
        if path.exists() and (not path.is_file() or path.read_text("utf-8") != text):
            raise InputError("exists and is different", "move it away or name another folder", str(path))
    folder.mkdir(parents=True, exist_ok=True)
    for path, text in targets.items():
        path.write_text(text, encoding="utf-8")
        print(f"wrote {path}")


def _say(text: str) -> None:
    print(text, file=sys.stderr)
