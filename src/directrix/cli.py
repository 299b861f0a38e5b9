"""The command line: reads cases, calls the solvers, shows and keeps what they return. No mechanics here.

Exit codes: 0 done, 1 a fault of directrix, 2 bad input, 3 not converged, 4 the audit failed, 130 interrupted.
Whatever is slow to import is imported by the command that needs it.
"""

from __future__ import annotations

import gc
import os
import sys
import traceback
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import replace
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
_traceback_wanted: ContextVar[bool] = ContextVar("traceback_wanted")  # said anew by every call of the command

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
    int,
    typer.Option(
        min=1, help="Threads that share the work on a frame or a long chain; no bit of the result depends on it."
    ),
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
    ledger = "ledger"
    momentum = "momentum"
    history = "history"
    orbit = "orbit"
    section_forces = "section_forces"
    diagram = "diagram"
    path = "path"
    branches = "branches"
    newton = "newton"
    convergence = "convergence"


class Format(StrEnum):
    """What ``export`` can write."""

    csv = "csv"
    npz = "npz"
    mat = "mat"
    gltf = "gltf"
    xlsx = "xlsx"


def main() -> None:
    """The command ``directrix``; ``--traceback`` may stand anywhere."""
    # importing makes objects that stay; looking for plugins of pydantic reads the entries of all packages installed
    gc.set_threshold(50_000)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    if "--traceback" in sys.argv:
        program, *rest = sys.argv
        sys.argv = [program, "--traceback", *(a for a in rest if a != "--traceback")]
    app()


def _guarded(command: Callable[P, int | None]) -> Callable[P, None]:
    """Turn what a command returns or raises into an exit code and one message."""

    @wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            code = command(*args, **kwargs) or 0
        except (typer.Exit, typer.Abort, BrokenPipeError):
            raise
        except InputError as error:
            code = _failed(2, f"error: {error}")
        except ModelError as error:
            first, *rest = str(error).split("\n")
            code = _failed(2, "\n".join([f"error: {first} [{error.code}]", *rest]))
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
    if _traceback_wanted.get():
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
    _traceback_wanted.set(traceback or bool(os.environ.get(TRACEBACK)))


@app.command(epilog="Example: directrix run cantilever.toml --no-view")
@_guarded
def run(
    case_file: CaseFile,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for what comes out; default CASE.run.")
    ] = None,
    no_view: Annotated[bool, typer.Option("--no-view", help="Leave out the HTML animation and the pictures.")] = False,
    beside: Annotated[Scheme | None, typer.Option(help="Run this scheme too and draw both in one picture.")] = None,
    adaptive: Annotated[
        float | None, typer.Option(metavar="TOL", help="Time steps as long as this local error allows.")
    ] = None,
    threads: Threads = 1,
    quiet: Quiet = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Throw away an unfinished run in the folder.")] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Open a page that shows the motion while it runs.")] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="--watch: port of this machine; 0 takes a free one.")] = 0,
) -> int:
    """Solve a case; write the result, run.json, monitor.csv, pictures and an HTML animation."""
    from directrix.keeping import RunFolder, Source
    from directrix.schema import load_case

    case = load_case(case_file)
    case = case if adaptive is None else case.adapted(adaptive)
    rival = case.stepped_by(beside.value) if beside else None
    folder = RunFolder.claim(
        case.kept_in(out or case_file.with_suffix(".run"), overwrite=overwrite),
        Source(case.title, case_file, case.raw, case.sha256), command=True,
    )  # fmt: skip
    folder.more = {} if adaptive is None else {"adaptive": adaptive}
    heading = f"{case.title}  ({case_file})"
    return _solve(case, rival, folder, heading, no_view, threads, quiet, port if watch else None)


@app.command(epilog="Example: directrix resume swing.run --until 2.1")
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
    case = load_case(found.path, found.title, found.beside)
    case = case if found.adaptive is None else case.adapted(found.adaptive)
    case = case if found.until is None else case.until(found.until)
    folder = RunFolder.claim(case.kept_in(run_folder, resume=True, force=force), command=True)
    folder.more = {k: v for k, v in (("until", found.until), ("adaptive", found.adaptive)) if v is not None}
    return _solve(case, None, folder, f"{case.title}  ({run_folder})", no_view, threads, quiet)


def _solve(
    case: Case, rival: Case | None, folder: RunFolder, heading: str, no_view: bool, threads: int, quiet: bool,
    port: int | None = None,
) -> int:  # fmt: skip
    """Run a case in its folder, and its rival beside it; show and draw what came out. With a ``port`` a page shows the
    motion while it runs."""
    from rich.console import Console

    from directrix.console import live, opened, show
    from directrix.runs import can_draw, draw_all, exit_code, written

    console = Console(quiet=quiet, highlight=False)
    for warning in case.warnings:
        console.print(f"warning: {warning}", style="yellow", markup=False, soft_wrap=True)

    def solve(case: Case, heading: str, folder: RunFolder | None = None, watched: bool = False) -> Result:
        console.print(heading, style="bold", markup=False, soft_wrap=True)
        if not watched:
            with live(console) as progress:
                return case.run(progress, threads, folder)
        assert port is not None
        with opened(port) as page, live(console) as progress:
            page.then = progress
            result = case.run(page, threads, folder)
            page.finish(result)
            return result

    try:
        # written before anything is shown: what was computed is not lost to a fault further on
        result = solve(replace(case, record_in=folder.path), heading, folder, port is not None)
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


@app.command(epilog="Example: directrix refine cantilever.toml --quantity node:tip:displacement:z --levels 2")
@_guarded
def refine(
    case_file: CaseFile,
    quantity: Annotated[
        str, typer.Option("--quantity", help="E.g. node:tip:displacement:y, rod:mid:force:axial:max, energy:stored.")
    ],
    levels: Annotated[int, typer.Option(help="Meshes and steps to compare; two cannot tell the order.")] = 3,
) -> None:
    """Run a case on finer meshes and in shorter steps; print how far a quantity is from its limit."""
    from directrix.schema import load_case

    print(load_case(case_file).refine(quantity, levels))


@app.command(epilog="Example: directrix check cantilever.toml --picture model.png")
@_guarded
def check(
    case_file: CaseFile,
    picture: Annotated[
        Path | None, typer.Option(help="Where to draw the model; default beside the case.", show_default=False)
    ] = None,
    no_picture: Annotated[bool, typer.Option("--no-picture", help="Draw no picture.")] = False,
) -> None:
    """Check a case without solving it; print and draw what would be solved, with every default and convention."""
    from directrix.schema import load_case

    case = load_case(case_file)  # what is refused is refused before the solvers are imported
    from directrix.runs import can_draw
    from directrix.schema.describe import describe

    print(describe(case))
    if no_picture:
        return
    if picture is not None or can_draw():
        from directrix.sketch import sketch

        try:
            print(f"wrote {sketch(case.check(), picture or case_file.with_suffix('.png'), case.duration)}")
        except InputError as error:
            if picture is not None:
                raise
            print(f"no picture: {error.what}")  # a folder where nothing may be written is no fault of the case
    else:
        print('no picture: matplotlib is missing; pip install "directrix[plot]"')


@app.command(epilog="Example: directrix new mast --template cantilever")
@_guarded
def new(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="Name of the case; default that of the template.")
    ] = None,
    template: Annotated[
        str | None, typer.Option("--template", "-t", help="What to begin with; asked if left out.")
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="Print the templates and write nothing.")] = False,
) -> None:
    """Write a case to begin with: commented, with a schema for editors beside it, ready to run."""
    import tomllib

    from directrix.starting import begin, templates

    known = templates()
    if listed:
        for key, text in known.items():
            print(f"{key:<12} {tomllib.loads(text)['title']}: {text.splitlines()[0].lstrip('# ')}")
        return
    if template is None:
        if not asks():
            raise ModelError(
                "there is no terminal to ask which template to begin with",
                f"add --template, one of {', '.join(known)}",
                code="DX503",
            )
        for key, text in known.items():
            print(f"{key:<12} {text.splitlines()[0].lstrip('# ')}")
        template = str(typer.prompt("template", default="cantilever"))
        name = name or str(typer.prompt("name of the case", default=template))
    path, beside = begin(name or template, template)
    print(f"wrote {path}")
    print(f"wrote {beside}, which editors complete keys from")
    print(f"next: directrix check {path}, directrix run {path}")


@app.command(epilog="Example: directrix convert cantilever.toml cantilever.json")
@_guarded
def convert(
    case_file: CaseFile,
    target: Annotated[
        Path, typer.Argument(metavar="TARGET", help="The file to write: .json, or .toml.", show_default=False)
    ],
) -> None:
    """Write a case in the other language, TOML or JSON; comments are lost, and it is said."""
    from directrix.schema.convert import convert as to

    lost = to(case_file, target)
    print(f"wrote {target}{'; the comments of ' + str(case_file) + ' are lost in it' if lost else ''}")


@app.command(epilog="Example: directrix info cantilever.run")
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


@app.command(epilog="Example: directrix plot cantilever.run history --node tip --quantity r")
@_guarded
def plot(
    result_file: ResultFile,
    picture: Annotated[Picture | None, typer.Argument(metavar="WHAT", help="What to draw.", show_default=False)] = None,
    what: Annotated[Picture | None, typer.Option(help="The same, by name.", show_default=False)] = None,
    node: Annotated[str | None, typer.Option(help="A node, link, contact or joint.", show_default=False)] = None,
    rod: Annotated[str | None, typer.Option(help="A rod; with --s a point of it.", show_default=False)] = None,
    s: Annotated[float | None, typer.Option("--s", help="Arclength of that point.", show_default=False)] = None,
    quantity: Annotated[str | None, typer.Option(help="history, orbit: what of it; names as in tables.")] = None,
    over: Annotated[str | None, typer.Option(help="orbit: what it is drawn over, such as r.x.")] = None,
    component: Annotated[str | None, typer.Option(help="Which component.", show_default=False)] = None,
    at: Annotated[int | None, typer.Option(help="Saved instant; -1 is the last.", show_default=False)] = None,
    envelope: Annotated[bool, typer.Option("--envelope", help="section_forces: the range over the run.")] = False,
    beside: Annotated[
        list[Path] | None, typer.Option(metavar="RESULT", help="Another result in the same picture; may be repeated.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Picture file, .png, .svg or .pdf; default beside the result.")
    ] = None,
) -> None:
    """Draw a picture of a result: shapes, energy, histories, orbits, section forces, paths, iterations."""
    from directrix.pictures.command import options_of
    from directrix.runs import draw

    chosen = picture or what
    if chosen is None or (picture is not None and what is not None):
        raise ModelError(
            "what to draw has to be said once",
            f"behind the result give one of {', '.join(Picture)}, by itself or with --what",
        )
    result, path = _load(result_file)
    others: dict[str, Result] = {}
    for file in beside or ():
        other, where = _load(file)
        label = file.stem if file.is_dir() else where.stem
        others[str(file) if label in others else label] = other
    given = {
        "node": node, "rod": rod, "s": s, "quantity": quantity, "over": over, "component": component, "at": at,
        "envelope": envelope or None, "others": others or None,
    }  # fmt: skip
    options, name = options_of(chosen.value, {key: value for key, value in given.items() if value is not None}, result)
    print(f"wrote {draw(result, chosen.value, out or path.with_name(f'{name}.png'), **options)}")


@app.command(epilog="Example: directrix export cantilever.run --to csv")
@_guarded
def export(
    result_file: ResultFile,
    to: Annotated[Format, typer.Option("--to", help="What for.", show_default=False)],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="File (csv: folder) to write; default beside the result.")
    ] = None,
) -> None:
    """Write a result for other programs: CSV tables, NumPy, MATLAB, Excel, or a glTF animation."""
    from directrix.exports import FORMATS

    result, path = _load(result_file)
    write, ending = FORMATS[to.value]
    print(f"wrote {write(result, out or path.with_name(path.stem + ending))}")


@app.command(epilog="Example: directrix view cantilever.run --out motion.html")
@_guarded
def view(
    result_files: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Result files, or folders of runs.", show_default=False),
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Where to write; default beside the first.")] = None,
    label: Annotated[list[str] | None, typer.Option(help="What to call a result; once for each.")] = None,
) -> None:
    """Write one HTML page that shows the motion, of several results over one another; needs no network."""
    from directrix.viewer import view as write

    loaded = [_load(file) for file in result_files]
    results, paths = [result for result, _ in loaded], [path for _, path in loaded]
    names = label or ([_short(path) for path in paths] if len(paths) > 1 else None)
    page = Path(
        write(results, out or paths[0].with_name("view.html" if len(paths) == 1 else "views.html"), labels=names)
    )
    print(f"wrote {page}, {page.stat().st_size / 1e6:.2g} MB")


@app.command(epilog="Example: directrix movie cantilever.run --out motion.gif")
@_guarded
def movie(
    result_file: ResultFile,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="A .gif or .mp4 file; default beside the result.")
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(help="How long it lasts; default the time of the run, 4 to 12.")
    ] = None,
    fps: Annotated[int, typer.Option(help="Pictures per second.")] = 25,
    field: Annotated[str | None, typer.Option(help="Colour by this, e.g. bending; see docs/viewer.md.")] = None,
) -> None:
    """Write the motion as an animation, GIF or MP4."""
    result, path = _load(result_file)
    print(f"wrote {result.movie(out or path.with_name('movie.gif'), seconds=seconds, fps=fps, field=field)}")


@app.command(epilog="Example: directrix examples bend45 --copy .")
@_guarded
def examples(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Print this example.", show_default=False)] = None,
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


@app.command(epilog="Example: directrix schema --out directrix.schema.json")
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


@app.command(epilog="Example: directrix doctor")
@_guarded
def doctor() -> int:
    """Look at this installation: versions, compiler, cache, extras, and a small run whose audit must pass."""
    from directrix.doctor import facts, self_test

    for key, value in facts():
        print(f"{key:<18} {value}")
    passed, sentence = self_test()
    print(f"{'self test':<18} {sentence}")
    return 0 if passed else 4


@app.command(epilog="Example: directrix bench")
@_guarded
def bench() -> int:
    """Measure how fast this machine takes steps of rods of 20, 100 and 1000 elements."""
    from directrix.bench import measured

    print("elements  ns per element and iteration  µs per element and step")
    good = True
    for speed in measured():
        print(f"{speed.elements:>8}  {1e9 * speed.iteration:>28.0f}  {1e6 * speed.step:>23.2f}")
        good = good and speed.good
    return 0 if good else 4


@app.command(epilog="Example: directrix verify --list")
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


@app.command(epilog="Example: directrix paper --quick --out paper.html")
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


def asks() -> bool:
    """True where somebody can answer."""
    return sys.stdin.isatty()


def _load(path: Path) -> tuple[Result, Path]:
    """A result file, or the one in the folder of a run."""
    from directrix.keeping.folder import how_far, summary_of, typed
    from directrix.keeping.store import resume_command
    from directrix.runs import RESULT
    from directrix.storage import load

    said = summary_of(path) if path.is_dir() else None
    if said is not None and said["status"]["code"] == "running":  # a result that is there is that of an earlier run
        how = resume_command(path, typed(said))
        raise InputError(f"holds a run that has not finished: {how_far(path, said)}", f"go on with: {how}", str(path))
    file = path / RESULT if path.is_dir() else path
    if not file.is_file():
        raise InputError("there is no such result", "name a .vtkhdf file or the folder that run wrote", str(file))
    return load(file), file


def _short(path: Path) -> str:
    """What a file of results is called: by its folder, if it is that of a run."""
    return path.parent.name.removesuffix(".run") if path.parent.name.endswith(".run") else path.stem


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
