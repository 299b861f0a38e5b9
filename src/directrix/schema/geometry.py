"""Geometry from files and by rule in a case file: its tables, and the models that they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from directrix.errors import ModelError
from directrix.model import Model
from directrix.schema.base import LENGTH, Name, NotNegative, Place, Positive, Strict, Vector, refuse
from directrix.schema.units import SI
from directrix.section import Section

__all__ = ["AnyGeometry", "Catenary", "Centreline", "build_geometry"]

Count = Annotated[int, Field(ge=1, le=10_000)]
Elements = Annotated[int, Field(ge=1, le=1_000_000)]
Length = Annotated[Positive, LENGTH]
UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048}


class Catenary(Strict):
    """A chain that hangs between two points."""

    start: Place
    end: Place
    length: Length
    down: Vector = (0.0, 0.0, -1.0)
    """Direction of gravity."""


class Centreline(Strict):
    """A smooth axis from a table of points."""

    file: str
    """CSV file, beside the case."""
    smoothing: Annotated[NotNegative, LENGTH] = 0.0
    """Largest distance that the axis may have from the points."""
    columns: Annotated[tuple[Name | int, ...], Field(strict=False, min_length=3, max_length=4)] | None = None
    """Names or positions of x, y, z (and of a parameter that rises)."""
    unit: Positive | Literal["m", "mm", "cm", "um", "µm", "km", "in", "ft"] = 1.0
    """Of the coordinates, in lengths of the model, or by its name."""

    @field_validator("unit", mode="after")
    @classmethod
    def _named(cls, value: float | str, info: ValidationInfo) -> float | str:
        """A name as a number, where the lengths of the model are not metres."""
        metre = info.context["units"].length if info.context else 1.0
        return value if metre == 1.0 or not isinstance(value, str) else UNITS[value] / metre


class Many(Strict):
    """What all rods of it have."""

    elements: Elements | None = None
    """Of every rod."""
    order: Literal[1, 2, 3] = 2
    points: Annotated[int, Field(ge=1, le=4)] | None = None


class Read(Many):
    """Rods from a file."""

    file: str
    """Beside the case."""
    section: Name | dict[Name, Name]
    """A section of this case for all rods, or sections by group or layer."""
    scale: Positive = 1.0
    """A length of the file in lengths of the model."""
    snap: Annotated[NotNegative, LENGTH] | None = None
    """Ends nearer than this become one node; 1e-6 of the size unless given. All of it is reported."""


class MeshFile(Read):
    """Lines of a mesh file in a format of meshio."""

    kind: Literal["mesh"]
    by: Name | None = None
    """Cell data that holds the groups."""


class Drawing(Read):
    """Curves of a DXF drawing; groups are its layers."""

    kind: Literal["dxf"]
    layers: Annotated[tuple[Name, ...], Field(strict=False, min_length=1)] | None = None
    """Which to read; those with a section unless given."""


class Graph(Read):
    """A graph of networkx: nodes with places, edges that become rods."""

    kind: Literal["graph"]
    section: Name | dict[Name, Name] | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    """A section of this case for edges that name none, or sections for the names that edges have."""


class BeamDyn(Strict):
    """A blade of BeamDyn: one rod with its own sections."""

    kind: Literal["beamdyn"]
    file: str
    """Primary input file."""
    blade: str | None = None
    """Blade file; the one that the primary file names unless given."""
    name: Name = "blade"
    elements: Elements | None = None
    order: Literal[1, 2, 3] = 2

    @model_validator(mode="after")
    def _in_metres(self, info: ValidationInfo) -> Self:
        units = info.context["units"] if info.context else SI
        if (units.length, units.mass, units.time) != (SI.length, SI.mass, SI.time):
            raise refuse("a blade of BeamDyn is in metres, kilograms and seconds", "leave [units] out", "kind")
        return self


class Rule(Many):
    """Rods by rule."""

    section: Name


class Grid(Rule):
    """A flat grid."""

    kind: Literal["grid"]
    counts: Annotated[tuple[Count, Count], Field(strict=False)]
    """Cells along x and y."""
    cell: Annotated[tuple[Length, Length], Field(strict=False)]
    origin: Place = (0.0, 0.0, 0.0)


class Lattice(Rule):
    """A cubic lattice or an octet truss."""

    kind: Literal["cubic", "octet"]
    counts: Annotated[tuple[Count, Count, Count], Field(strict=False)]
    """Cells along x, y and z."""
    cell: Length
    """Edge of a cell."""
    origin: Place = (0.0, 0.0, 0.0)


class Ring(Rule):
    """A ring of arcs."""

    kind: Literal["ring"]
    radius: Length
    parts: Annotated[int, Field(ge=2, le=10_000)] = 4
    centre: Place = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)


class Spring(Rule):
    """A helix spring along z."""

    kind: Literal["spring"]
    radius: Length
    pitch: Length
    turns: float
    """Active coils; negative winds left-handed."""
    wire: Length | None = None
    """Diameter; that of a round section unless given."""
    end_coils: NotNegative = 0.0
    """Closed coils at each end."""
    elements_per_turn: Annotated[int, Field(ge=3, le=10_000)] = 12
    seats: bool = False
    """Nodes "base" and "head" on the axis, rigidly joined to the ends."""


class Weave(Rule):
    """A plain weave of wavy yarns."""

    kind: Literal["weave"]
    counts: Annotated[tuple[Count, Count], Field(strict=False)]
    """Warps and wefts."""
    spacing: Length
    amplitude: Length
    """Half of the distance of the axes where yarns cross."""
    weft: Name | None = None
    """Section of the wefts; that of the warps unless given."""
    elements_per_crossing: Count = 4


AnyGeometry = Annotated[
    MeshFile | Drawing | Graph | BeamDyn | Grid | Lattice | Ring | Spring | Weave, Field(discriminator="kind")
]


def build_geometry(table: AnyGeometry, sections: Mapping[str, Section], folder: Path, model: Model) -> Model:
    """The model with the rods of a table; files are looked for in ``folder``. Raises ModelError."""
    from directrix import generate
    from directrix.blades import beamdyn
    from directrix.geometry import from_dxf, from_graph, from_mesh

    given: dict[str, Any] = table.model_dump(exclude={"kind"}, exclude_unset=True)
    for key in ("section", "weft"):
        if key in given:
            given[key] = _sections(given[key], sections)
    if "file" in given:
        path = folder / given.pop("file")
        match table:
            case MeshFile():
                return from_mesh(path, model=model, **given)
            case Drawing():
                return from_dxf(path, model=model, **given)
            case Graph():
                own: Section | dict[str, Section] | None = given.pop("section", None)
                named: dict[Any, Section] = dict(sections)
                if isinstance(own, dict):
                    named |= own
                elif own is not None:
                    named[None] = own  # of edges that name none
                return from_graph(path, section=named, model=model, **given)
            case _:
                if "blade" in given:
                    given["blade"] = folder / given["blade"]
                made = beamdyn(path, **given)
    else:
        makers = {"grid": generate.grid, "cubic": generate.cubic, "octet": generate.octet, "ring": generate.ring,
                  "spring": generate.spring, "weave": generate.weave}  # fmt: skip
        made = makers[table.kind](**given)  # type: ignore[index]
    taken = {rod.name for rod in model.rods}
    for rod in made.rods:
        if rod.name in taken:
            raise ModelError(f"there are two rods called {rod.name!r}", "give each rod a name of its own", code="DX422")
    both = replace(model, rods=(*model.rods, *made.rods), imported=(*model.imported, *made.imported))
    return replace(both, nodes=(*both.nodes, *made.nodes), joints=(*both.joints, *made.joints))


def _sections(wanted: Any, sections: Mapping[str, Section]) -> Any:
    """A section, or a table of them, by names of the case."""
    if isinstance(wanted, dict):
        return {group: _sections(name, sections) for group, name in wanted.items()}  # pyright: ignore
    if wanted not in sections:
        raise ModelError(
            f"there is no section {wanted!r} in this file", f"sections of this file: {', '.join(sections) or 'none'}"
        )
    return sections[wanted]
