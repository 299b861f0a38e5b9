"""Read a case file: text → data → checked tables → Model, each step with the place of what is wrong."""

from __future__ import annotations

import hashlib
import pathlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from directrix import checks, controls
from directrix.errors import InputError, ModelError
from directrix.findings import Finding
from directrix.model import Model
from directrix.schema import models
from directrix.schema.blame import Blame, at_entry, placed
from directrix.schema.build import build_control, build_model, build_records, entries_of
from directrix.schema.messages import Source, explain, together
from directrix.schema.models import (
    PARAMETERS,
    ArcLength,
    CaseFile,
    DisplacementControl,
    Dynamics,
    Output,
    Scheme,
    Statics,
    Units,
)  # fmt: skip
from directrix.schema.places import Path
from directrix.schema.plausible import plausible
from directrix.schema.text import parse, read
from directrix.schema.units import SI, UnitSet, unit
from directrix.schema.versions import FORMAT, migrated

if TYPE_CHECKING:
    from directrix.controls import Control
    from directrix.discretisation import Discretisation
    from directrix.integrators import Formulation, Integrator
    from directrix.keeping import Folder, RunFolder
    from directrix.points import Recorder
    from directrix.refinement import Refined
    from directrix.result import Result
    from directrix.stepping import Adaptive

__all__ = ["SCHEMA_ID", "Case", "json_schema", "load_case"]

SCHEMA_ID = f"urn:directrix:case:{FORMAT}"


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
    units : what its plain numbers are in
    warnings : what is likely not meant
    records : the ``[[record]]`` tables
    record_in : the folder that their files go to; without one nothing is recorded
    raw : the file's bytes
    """

    title: str
    description: str
    model: Model
    analysis: Statics | Dynamics
    output: Output
    source: pathlib.Path
    sha256: str
    units: UnitSet = SI
    warnings: tuple[Finding, ...] = ()
    records: tuple[Recorder, ...] = ()
    record_in: pathlib.Path | None = None
    raw: bytes = b""

    @property
    def step(self) -> float | Adaptive:
        """``dt`` of a dynamic case as ``simulate`` takes it. Raises ModelError."""
        from directrix.stepping import Adaptive

        do = self.analysis
        assert isinstance(do, Dynamics)
        return do.dt if do.adaptive is None else Adaptive(first=do.dt, **do.adaptive.model_dump(exclude_unset=True))

    def adapted(self, tolerance: float) -> Case:
        """The same case with steps as long as this error allows. Raises ModelError."""
        if isinstance(self.analysis, Statics):
            raise InputError("a static case has no time step", "leave --adaptive out", str(self.source))
        given = self.analysis.adaptive or models.Adaptive()
        table = given.model_copy(update={"tolerance": tolerance})
        case = replace(self, analysis=self.analysis.model_copy(update={"adaptive": table}))
        case.check()
        return case

    def check(self) -> Discretisation:
        """Check everything that can be checked without solving; returns the mesh. Raises ModelError."""
        self.model.check()  # before the solvers are imported, which takes longer
        from directrix.discretisation import discretise

        do = self.analysis
        if isinstance(do, Statics):
            from directrix.diagnosis import examine, refuse
            from directrix.statics import static_scheme

            scheme = static_scheme(self.model, self._formulation(do))
            disc = discretise(self.model, scheme)
            refuse(examine(disc, scheme))
            return disc
        from directrix.motion import refuse_damping
        from directrix.stepping import stepping

        refuse_damping(self.model, self._integrator(do))
        stepping(self.step, 0.0, do.t_end, self._integrator(do))
        return discretise(self.model, self._integrator(do).scheme(do.dt))

    def kept_in(self, path: pathlib.Path, **options: bool) -> Folder:
        """A folder to run it in, with checkpoints as the case asks for them."""
        from directrix.keeping import Folder

        out = self.output
        return Folder(path, seconds=out.checkpoint_seconds, steps=out.checkpoint_steps, **options)

    def until(self, t_end: float) -> Case:
        """The same case with another end. Raises InputError for a static one."""
        if isinstance(self.analysis, Statics):
            raise InputError("a static case has no end in time", "leave --until out", str(self.source))
        if self.analysis.adaptive is not None:
            raise InputError("steps that adapt depend on the end", "leave --until out", str(self.source))
        return replace(self, analysis=self.analysis.model_copy(update={"t_end": checks.number(t_end, "--until")}))

    def findings(self) -> tuple[Finding, ...]:
        """What may be wrong with the case, though it can be run. Raises ModelError."""
        static = isinstance(self.analysis, Statics)
        return *self.warnings, *self.model.check(static=static, dynamic=not static)

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
                rotation=do.rotation,
                stability=do.stability,
                threads=threads,
                linear=do.linear,
                save_every=save_every,
                record=self._recorders(),
                keep=self.output.keeps,
                folder=folder,
                progress=progress,
            )
        return simulate(
            self.model,
            do.t_end,
            self.step,
            integrator=self._integrator(do),
            load_rule=do.load_rule,
            tolerance=do.tolerance,
            threads=threads,
            linear=do.linear,
            save_every=save_every,
            record=self._recorders(),
            keep=self.output.keeps,
            folder=folder,
            progress=progress,
        )

    def _recorders(self) -> list[Recorder]:
        folder = self.record_in
        return [] if folder is None else [replace(one, path=folder / one.file) for one in self.records]

    def refine(self, what: str, levels: int = 3) -> Refined:
        """What a finer mesh and shorter steps would change of a quantity; see ``dx.refine``. Raises ModelError."""
        from directrix.refinement import refine

        do = self.analysis
        if isinstance(do, Statics):
            steps = {} if do.control is not None else {"steps": do.steps}
            more: dict[str, Any] = {
                "control": self.control,
                "formulation": self._formulation(do),
                "tolerance": do.tolerance,
                **steps,
            }
            return refine(self.model, what, levels=levels, **more)
        if do.adaptive is not None:
            raise InputError("steps that adapt cannot be halved", "leave adaptive out", str(self.source))
        options: dict[str, Any] = {
            "integrator": self._integrator(do),
            "load_rule": do.load_rule,
            "tolerance": do.tolerance,
        }
        return refine(self.model, what, levels=levels, t_end=do.t_end, dt=do.dt, **options)

    @staticmethod
    def _formulation(do: Statics) -> Formulation:
        from directrix.formulations import BY_NAME

        return BY_NAME[do.formulation]()

    @staticmethod
    def _integrator(do: Dynamics) -> Integrator:
        from directrix.integrators import BY_NAME

        return BY_NAME[do.integrator](**do.parameters)

    @property
    def duration(self) -> float:
        """Time, or load factor, up to which its loads are followed."""
        return self.analysis.t_end if isinstance(self.analysis, Dynamics) else 1.0

    @property
    def steps(self) -> int:
        """Steps asked for; of a path followed by its length, the most that it may take."""
        do = self.analysis
        if isinstance(do, Dynamics):
            return round(do.t_end / do.dt)
        if do.control is None:
            return do.steps
        return do.control.max_steps if isinstance(do.control, ArcLength) else do.control.steps

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


def load_case(path: str | PathLike[str], title: str = "", beside: pathlib.Path | None = None) -> Case:
    """Read a TOML or JSON case file; one that gives itself no title has ``title``, or the name of the file.

    Files that it names are looked for in the folder ``beside``; its own unless given.

    Raises InputError for anything that cannot be right in the file or the model: all that is wrong at once, each with
    file, line, column and key in its ``mistakes``.
    """
    with np.errstate(all="ignore"):  # what overflows is refused for what comes of it
        return _load(checks.file(path, "path"), title, beside)


def _load(file: pathlib.Path, title: str, beside: pathlib.Path | None) -> Case:
    raw = read(file)
    source, noted = parse(file, raw)
    source = replace(source, data=migrated(source), folder=beside or file.parent)
    units = _units(source)
    tables, wrong = _tables(source, units)
    blame = Blame(source, wrong.left)
    found = [*noted, *wrong.found]
    if tables is None:
        raise together(found)
    title = tables.title or title or file.stem
    model = build_model(tables, title, blame)
    static = tables.statics is not None
    if not found and not blame.found:
        analysis = tables.statics or tables.dynamics
        assert analysis is not None  # one of them, says the schema
        sha = hashlib.sha256(raw).hexdigest()
        case = Case(
            title,
            tables.description,
            model,
            analysis,
            tables.output,
            file,
            sha,
            units,
            plausible(tables, model, units),
            raw=raw,
        )
        try:
            disc = case.check()
        except ModelError as error:
            blame = _blame_entries(tables, title, Blame(source), static)
            if not blame.found:
                raise _whole(tables, source, error) from None
        else:
            if tables.statics is not None and tables.statics.control is not None:
                with placed(source, ("statics", "control")):
                    _check_control(case.control, disc, tables.statics.control)
            return replace(case, records=build_records(tables, source, disc.mesh))
    else:
        blame = _blame_entries(tables, title, Blame(source, wrong.left), static)
    raise together([*found, *blame.found])


@dataclass(frozen=True)
class _Wrong:
    """What the schema found, and the entries that are left out because of it."""

    found: tuple[InputError, ...] = ()
    left: tuple[Path, ...] = ()


def _tables(source: Source, units: UnitSet) -> tuple[CaseFile | None, _Wrong]:
    """The tables; where some are wrong those that are left, so that the model can be looked at as well."""
    context = {"units": units}
    try:
        return CaseFile.model_validate(source.data, context=context), _Wrong()
    except ValidationError as error:
        errors = error.errors(include_url=False)
    said = explain(errors, source, CaseFile)
    left = tuple({_entry(e["loc"]): None for e in errors})
    rest = _without(source.data, left)
    try:
        return CaseFile.model_validate(rest, context=context), _Wrong((said,), left)
    except ValidationError as error:
        again = [e for e in error.errors(include_url=False) if e.get("ctx", {}).get("code") == "DX218"]
        known = any(loc in ((), ("statics",), ("dynamics",)) for loc in left)
        more = () if known or not again else (explain(again, source, CaseFile),)
        return None, _Wrong((said, *more), left)


def _entry(loc: tuple[str | int, ...]) -> Path:
    """One of several tables, or the only one."""
    several = len(loc) > 1 and (isinstance(loc[1], int) or loc[0] == "section")
    return loc[:2] if several else loc[:1]


def _without(data: Mapping[str, Any], left: Sequence[Path]) -> Mapping[str, Any]:
    """The data without some entries; an analysis that is left out becomes the plainest of its kind."""
    out: dict[str, Any] = dict(data)
    for key in {str(loc[0]) for loc in left if loc}:
        gone = {loc[1] for loc in left if loc[0] == key and len(loc) > 1}
        value = out.get(key)
        if isinstance(value, list) and gone:
            out[key] = [item for k, item in enumerate(cast("list[Any]", value)) if k not in gone]
        elif isinstance(value, dict) and gone:
            out[key] = {k: item for k, item in cast("dict[str, Any]", value).items() if k not in gone}
        else:
            out.pop(key, None)
    for key, plain in (("statics", {}), ("dynamics", {"t_end": 1.0, "dt": 1.0})):
        if key in data and key not in out:
            out[key] = plain
    return out


def _blame_entries(tables: CaseFile, title: str, blame: Blame, static: bool) -> Blame:
    """Look for every entry that does not fit the others."""
    entries = list(entries_of(tables, blame))
    # gravity asks whether anything has mass, so it comes when all is there
    entries.sort(key=lambda entry: entry[0][0] == "gravity")
    blame.absorb(Model(name=title), entries, lambda model: model.check(dynamic=not static))
    return blame


def _whole(tables: CaseFile, source: Source, error: ModelError) -> InputError:
    """No entry is to blame alone: name the rod, node or joint that is spoken of, or the analysis."""
    spoken = [
        (key, k)
        for key in ("rod", "joint", "node")
        for k, entry in enumerate(getattr(tables, key))
        if repr(entry.name) in error.what
    ]
    return at_entry(source, spoken[0] if spoken else ("statics" if tables.statics else "dynamics",), error)


def _units(source: Source) -> UnitSet:
    """The set of units of the file. Raises InputError."""
    try:
        given = Units.model_validate(source.data.get("units", {}))
    except ValidationError as error:
        errors = [{**e, "loc": ("units", *e["loc"])} for e in error.errors(include_url=False)]
        raise explain(errors, source, CaseFile) from None
    if not given.model_fields_set:
        return SI
    sizes: dict[str, float] = {}
    wanted = {"length": (1, 0, 0), "time": (0, 0, 1), "mass": (0, 1, 0), "force": (1, 1, -2)}
    for key, powers in wanted.items():
        name = getattr(given, key)
        if name is None:
            continue
        try:
            sizes[key], found = unit(name)
        except PydanticCustomError as error:
            said = error.context or {}
            raise InputError(said["what"], said["fix"], source.where(("units", key)), said["code"]) from None
        if found != powers:
            raise InputError(
                f"{name!r} is no unit of {key}",
                'e.g. length = "mm", force = "N"',
                source.where(("units", key)),
                "DX304",
            )
    mass = sizes.get("mass", 1.0)
    if "force" in sizes:
        mass = sizes["force"] * sizes["time"] ** 2 / sizes["length"]
    names = tuple((key, getattr(given, key)) for key in wanted if getattr(given, key) is not None)
    return UnitSet(mass, sizes["length"], sizes["time"], names)


def _check_control(control: Control | None, disc: Discretisation, table: ArcLength | DisplacementControl) -> None:
    """Look for the nodes that a control names."""
    from directrix.gauge import driven

    if isinstance(control, controls.DisplacementControl):
        driven(control, disc)
    elif isinstance(table, ArcLength) and table.until is not None:
        disc.mesh.node(table.until.node)


def json_schema() -> dict[str, Any]:
    """The JSON schema of a case file, for editors and for other programs."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA_ID}
    return {**head, **CaseFile.model_json_schema()}
