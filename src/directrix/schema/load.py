"""Read a case file: text → data → checked tables → Model, each step with the place of what is wrong."""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from pydantic import ValidationError

from directrix import checks, controls
from directrix.errors import InputError, ModelError
from directrix.schema.build import build_control, build_model, placed
from directrix.schema.messages import Source, explain
from directrix.schema.models import (
    PARAMETERS,
    ArcLength,
    CaseFile,
    DisplacementControl,
    Dynamics,
    Output,
    Scheme,
    Statics,
)  # fmt: skip
from directrix.schema.places import json_places, toml_places

if TYPE_CHECKING:
    from directrix.controls import Control
    from directrix.discretisation import Discretisation
    from directrix.findings import Finding
    from directrix.integrators import Formulation, Integrator
    from directrix.keeping import Folder, RunFolder
    from directrix.model import Model
    from directrix.result import Result

__all__ = ["Case", "json_schema", "load_case"]


@dataclass(frozen=True)
class Case:
    """A case file, read and checked: a model, one analysis, and where they came from.

    Attributes
    ----------
    title : from the file, or the file's name
    description : from the file
    model : rods, supports, loads
    analysis : the ``[statics]`` or ``[dynamics]`` table
    output : the ``[output]`` table
    source : the file
    sha256 : of the file's bytes
    raw : these bytes
    """

    title: str
    description: str
    model: Model
    analysis: Statics | Dynamics
    output: Output
    source: Path
    sha256: str
    raw: bytes = b""

    def check(self) -> Discretisation:
        """Check everything that can be checked without solving; returns the mesh. Raises ModelError."""
        from directrix.diagnosis import examine, refuse
        from directrix.discretisation import discretise
        from directrix.dynamics import refuse_damping
        from directrix.statics import static_scheme

        self.model.check()
        do = self.analysis
        if isinstance(do, Statics):
            scheme = static_scheme(self.model, self._formulation(do))
            disc = discretise(self.model, scheme)
            refuse(examine(disc, scheme))
            return disc
        refuse_damping(self.model, self._integrator(do))
        return discretise(self.model, self._integrator(do).scheme(do.dt))

    def kept_in(self, path: Path, **options: bool) -> Folder:
        """A folder to run it in, with checkpoints as the case asks for them."""
        from directrix.keeping import Folder

        out = self.output
        return Folder(path, seconds=out.checkpoint_seconds, steps=out.checkpoint_steps, **options)

    def until(self, t_end: float) -> Case:
        """The same case with another end. Raises InputError for a static one."""
        if isinstance(self.analysis, Statics):
            raise InputError("a static case has no end in time", "leave --until out", str(self.source))
        return replace(self, analysis=self.analysis.model_copy(update={"t_end": checks.number(t_end, "--until")}))

    def findings(self) -> tuple[Finding, ...]:
        """What may be wrong with the case, though it can be run. Raises ModelError."""
        static = isinstance(self.analysis, Statics)
        return self.model.check(static=static, dynamic=not static)

    @property
    def control(self) -> Control | None:
        """What drives a static path; None is load control. Raises ModelError."""
        return build_control(self.analysis.control) if isinstance(self.analysis, Statics) else None

    def run(
        self,
        progress: Callable[[float, str], None] | None = None,
        threads: int = 1,
        folder: Folder | RunFolder | str | PathLike[str] | None = None,
    ) -> Result:
        """Solve it, a frame with so many ``threads``, in a ``folder`` if there is one.

        Raises ModelError; a run that fails on the way is a Result with ``success`` False.
        """
        from directrix.dynamics import simulate
        from directrix.statics import solve_static

        do, save_every = self.analysis, self.output.save_every
        if isinstance(do, Statics):
            return solve_static(
                self.model,
                None if do.control is not None else do.steps,
                control=self.control,
                formulation=self._formulation(do),
                tolerance=do.tolerance,
                threads=threads,
                save_every=save_every,
                keep=self.output.keeps,
                folder=folder,
                progress=progress,
            )
        return simulate(
            self.model,
            do.t_end,
            do.dt,
            integrator=self._integrator(do),
            load_rule=do.load_rule,
            tolerance=do.tolerance,
            threads=threads,
            save_every=save_every,
            keep=self.output.keeps,
            folder=folder,
            progress=progress,
        )

    @staticmethod
    def _formulation(do: Statics) -> Formulation:
        from directrix.formulations import BY_NAME

        return BY_NAME[do.formulation]()

    @staticmethod
    def _integrator(do: Dynamics) -> Integrator:
        from directrix.integrators import BY_NAME

        return BY_NAME[do.integrator](**do.parameters)

    @property
    def scheme(self) -> str:
        """Name of the time step; empty for a static case."""
        return self.analysis.integrator if isinstance(self.analysis, Dynamics) else ""

    def stepped_by(self, integrator: Scheme) -> Case:
        """The same case under another time step. Raises InputError for a static one, and when it is its own."""
        if isinstance(self.analysis, Statics):
            raise InputError(
                "a static case has no time step", "compare schemes on a case with [dynamics]", str(self.source)
            )
        if integrator == self.scheme:
            raise InputError(f"the case runs under {integrator} already", "name another scheme", str(self.source))
        own: dict[str, Any] = {name: None for names in PARAMETERS.values() for name in names}
        return replace(self, analysis=self.analysis.model_copy(update={**own, "integrator": integrator}))


def load_case(path: str | PathLike[str], title: str = "") -> Case:
    """Read a TOML or JSON case file; one that gives itself no title has ``title``, or the name of the file.

    Raises InputError, with file, line and key, for anything that cannot be right in the file or the model.
    """
    file = checks.file(path, "path")
    raw = _read(file)
    source = _parse(file, raw)
    try:
        tables = CaseFile.model_validate(source.data)
    except ValidationError as error:
        raise explain(error.errors(include_url=False), source, CaseFile) from None
    title = tables.title or title or file.stem
    model = build_model(tables, title, source)
    analysis = tables.statics or tables.dynamics
    assert analysis is not None  # one of them, says the schema
    case = Case(title, tables.description, model, analysis, tables.output, file, hashlib.sha256(raw).hexdigest(), raw)
    try:
        disc = case.check()
    except ModelError as error:
        build_model(tables, title, source, check_each=True)
        # no entry is to blame alone: name the rod, node or joint that is spoken of, or the analysis
        spoken = [
            (key, k)
            for key in ("rod", "joint", "node")
            for k, entry in enumerate(getattr(tables, key))
            if repr(entry.name) in error.what
        ]
        with placed(source, spoken[0] if spoken else ("statics" if tables.statics else "dynamics",)):
            raise
    if tables.statics is not None and tables.statics.control is not None:
        with placed(source, ("statics", "control")):
            _check_control(case.control, disc, tables.statics.control)
    return case


def _check_control(control: Control | None, disc: Discretisation, table: ArcLength | DisplacementControl) -> None:
    """Look for the nodes that a control names."""
    from directrix.gauge import driven

    if isinstance(control, controls.DisplacementControl):
        driven(control, disc)
    elif isinstance(table, ArcLength) and table.until is not None:
        disc.mesh.node(table.until.node)


def json_schema() -> dict[str, Any]:
    """The JSON schema of a case file, for editors and for other programs."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **CaseFile.model_json_schema()}


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except FileNotFoundError:
        raise InputError(
            "there is no such file", "check the path; directrix examples lists ready cases", str(file)
        ) from None
    except IsADirectoryError:
        raise InputError("this is a folder, not a case file", "name the .toml or .json file in it", str(file)) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", "check the permissions", str(file)) from None


def _parse(file: Path, raw: bytes) -> Source:
    if file.suffix.lower() not in (".toml", ".json"):
        raise InputError(
            f"{file.suffix or 'no'} ending: not a case file", "case files end in .toml or .json", str(file)
        )
    try:
        text = raw.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError("is not UTF-8 text", "save the file as UTF-8", f"{file}:{line}") from None
    data: Any
    try:
        if file.suffix.lower() == ".toml":
            data, places = tomllib.loads(text), toml_places
        else:
            data, places = json.loads(text if text.strip() else "{}", object_pairs_hook=_unique), json_places
    except tomllib.TOMLDecodeError as error:
        raise _syntax(file, text, str(error)) from None
    except json.JSONDecodeError as error:
        raise InputError(
            f"not valid JSON: {error.msg}", "mend the syntax near this place", f"{file}:{error.lineno}"
        ) from None
    except _TwiceError as twice:
        raise InputError(f"the key {twice} is given twice", "keep one of them", str(file)) from None
    except ValueError:  # Python's own limit on the digits of a whole number
        raise InputError("holds a number of thousands of digits", "shorten it", str(file)) from None
    except RecursionError:
        raise InputError("is nested too deeply", "a case file needs no such nesting", str(file)) from None
    if data == {}:
        raise InputError(
            "the case is empty",
            "describe a section, a rod and an analysis; directrix examples prints cases to begin with",
            f"{file}:1",
        )
    if not isinstance(data, dict):
        raise InputError("the top of the file is not a table", "write an object in braces { … }", f"{file}:1")
    return Source(str(file), cast("dict[str, Any]", data), places(text))


def _syntax(file: Path, text: str, message: str) -> InputError:
    """The parser's sentence carries the place; at the end of the file it says so in words."""
    at = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    line = at[1] if at and at[1] else str(len(text.splitlines()) or 1)
    reason = message[: at.start()] if at else message
    fix = "mend the syntax at this place; texts stand in quotes, lists in brackets"
    if at and at[2]:
        fix += f" (column {at[2]})"
    return InputError(f"not valid TOML: {reason}", fix, f"{file}:{line}")


class _TwiceError(Exception):
    pass


def _unique(pairs: list[tuple[str, Any]]) -> Mapping[str, Any]:
    out: dict[str, Any] = {}
    for key, value in pairs:
        if key in out:
            raise _TwiceError(repr(key))
        out[key] = value
    return out
