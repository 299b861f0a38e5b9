"""From checked tables to a Model, entry by entry, so that what the model refuses is shown at its line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from math import radians
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from directrix.actuators import PARTS
from directrix.chains import catenary
from directrix.checks import nearest
from directrix.contacts import Cylinder, Plane, Sphere
from directrix.controls import ArcLength, Control, DisplacementControl, Snapshot
from directrix.curves import Curve, arc, helix, line, polyline, spline
from directrix.errors import ModelError
from directrix.laws import stiffening_bending, tension_only
from directrix.model import Model, Vec
from directrix.points import Recorder, place
from directrix.schema import joints as j
from directrix.schema import models as m
from directrix.schema import sections as sec
from directrix.schema.base import Strict
from directrix.schema.blame import Add, Blame, placed
from directrix.schema.functions import AlongRod, Ramp, Rotated, Route, Scaled, ScaledNumber, VectorTable, timed
from directrix.schema.geometry import build_geometry
from directrix.schema.messages import Source
from directrix.schema.places import Path
from directrix.section import Section
from directrix.tapered import taper

if TYPE_CHECKING:
    from directrix.result import Mesh

__all__ = ["build_control", "build_model", "build_records", "entries_of"]


def build_model(tables: m.CaseFile, title: str, blame: Blame) -> Model:
    """The Model that the tables describe, without the entries that cannot be, which ``blame`` notes."""
    model = Model(name=title)
    for loc, add in entries_of(tables, blame):
        try:
            model = add(model)
        except ModelError as error:
            blame.note(loc, error)
    return model


@dataclass(frozen=True)
class Passed:
    """``until`` of a case file: true when one of the ends it asks for is reached."""

    most: float | None = None
    least: float | None = None
    reach: m.Reach | None = None

    def __call__(self, snapshot: Snapshot) -> bool:
        """Ask a state."""
        factor, far = snapshot.load_factor, False
        if self.reach is not None:
            goal = self.reach.displacement
            moved = float(snapshot.node(self.reach.node).displacement["xyz".index(self.reach.component)])
            far = moved >= goal if goal > 0.0 else moved <= goal
        return (
            far or (self.most is not None and factor >= self.most) or (self.least is not None and factor <= self.least)
        )


def build_control(table: m.ArcLength | m.DisplacementControl | None) -> Control | None:
    """The control that the table describes; None is load control. Raises ModelError."""
    match table:
        case None:
            return None
        case m.DisplacementControl():
            return DisplacementControl(**_given(table))
        case m.ArcLength():
            ends = tuple(f for f in (table.max_load_factor, table.min_load_factor) if f is not None)
            until = Passed(table.max_load_factor, table.min_load_factor, table.until)
            return ArcLength(
                table.ds,
                until if ends or table.until is not None else None,
                table.max_steps,
                load_factors=(*table.load_factors, *ends),
                load_step=table.load_step,
                branch=table.branch,
            )


def build_records(tables: m.CaseFile, source: Source, mesh: Mesh) -> tuple[Recorder, ...]:
    """The recorders of a case, with names of files in no folder. Raises InputError for a place that is not there."""
    out: list[Recorder] = []
    for k, table in enumerate(tables.record):
        with placed(source, ("record", k)):
            place(mesh, table.rod, table.s)
            one = Recorder(table.rod, table.s, table.quantities)
            one = Recorder(table.rod, table.s, table.quantities, f"record-{table.name or one.name}.csv")
            if one.file in (other.file for other in out):
                raise ModelError(f"another record writes {one.file} too", "give it a name of its own")
            out.append(one)
    return tuple(out)


def entries_of(tables: m.CaseFile, blame: Blame) -> Iterator[tuple[Path, Add]]:
    """Every entry of the file in the order of the model: its place, and what adds it."""
    sections: dict[str, Section] = {}
    for name, table in tables.section.items():
        try:
            sections[name] = _section(table, sections)
        except ModelError as error:
            blame.note(("section", name), error)
    folder = blame.source.folder
    for k, rod in enumerate(tables.rod):
        yield ("rod", k), partial(_rod, rod, sections, folder)
    for k, made in enumerate(tables.geometry):
        yield ("geometry", k), partial(build_geometry, made, sections, folder)
    for k, node in enumerate(tables.node):
        yield ("node", k), partial(_node, node)
    for k, support in enumerate(tables.support):
        yield ("support", k), partial(_support, support)
    for k, moved in enumerate(tables.prescribe):
        yield ("prescribe", k), partial(_prescribe, moved, tables.statics is not None)
    for key in ("force", "moment", "distributed"):
        for k, load in enumerate(getattr(tables, key)):
            yield (key, k), partial(_load, load)
    for k, pressed in enumerate(tables.pressure):
        yield ("pressure", k), partial(_pressure, pressed)
    if tables.gravity is not None:
        yield ("gravity",), partial(_load, tables.gravity)
    for key in ("spring", "cable", "dashpot", "point_mass", "rigid_body"):
        for k, table in enumerate(getattr(tables, key)):
            yield (key, k), partial(_attach, key, table)
    for k, actuated in enumerate(tables.actuate):
        yield ("actuate", k), partial(_actuate, actuated, tables.statics is not None)
    for k, tendon in enumerate(tables.tendon):
        yield ("tendon", k), partial(_tendon, tendon)
    for k, dragged in enumerate(tables.drag):
        yield ("drag", k), partial(_drag, dragged)
    for k, joint in enumerate(tables.joint):
        yield ("joint", k), partial(_joint, joint)
    for key in ("contact", "self_contact", "contact_between"):
        for k, table in enumerate(getattr(tables, key)):
            yield (key, k), partial(_touch, key, table)
    for k, start in enumerate(tables.velocity):
        yield ("velocity", k), partial(_velocity, start)
    if tables.rigid_velocity is not None:
        yield ("rigid_velocity",), partial(_rigid_velocity, tables.rigid_velocity)


def _section(table: sec.Section, known: Mapping[str, Section]) -> Section:
    if isinstance(table, sec.Taper):
        for name in table.sections:
            if name not in known:
                raise ModelError(
                    f"there is no section {name!r} above this one", f"above it are {', '.join(known) or 'none'}"
                )
        return taper(list(zip(table.at, (known[name] for name in table.sections), strict=True)))
    made = _as_it_is(table)
    if table.turn:
        made = made.turned(table.turn)
    return made.offset(*table.offset) if any(table.offset) else made


def _as_it_is(table: sec.Plain) -> Section:
    given = dict(_given(table))
    if table.viscous is not None:
        given["damping"] = np.array(given.pop("viscous"))
    damping = given.get("damping", 0.0)
    match table:
        case sec.Profile():
            given["unit"] = table.unit or 1e-3
            return Section.profile(**given)
        case sec.Circle():
            return Section.circle(**given)
        case sec.Rectangle():
            return Section.rectangle(**given)
        case sec.Tube():
            return Section.tube(**given)
        case sec.Polygon():
            return Section.polygon(**given)
        case sec.StiffeningBending() | sec.TensionOnly():
            moduli = {key: given[key] for key in ("EA", "GA1", "GA2", "EI1", "EI2", "GJ")}
            if isinstance(table, sec.TensionOnly):
                energy = tension_only(**moduli, width=table.width)
            else:
                energy = stiffening_bending(**moduli, onset=table.onset)
            inertia = np.diag([table.I_rho1, table.I_rho2])
            return Section.hyperelastic(energy, A_rho=table.A_rho, I_rho=inertia, damping=damping)
        case sec.Moduli():
            return Section.from_moduli(**given)
        case sec.Properties():
            shear = table.shear_modulus
            return Section.from_moduli(
                EA=table.E * table.A,
                GA1=table.shear_factor * shear * table.A,
                GA2=table.shear_factor * shear * table.A,
                EI1=table.E * table.I1,
                EI2=table.E * table.I2,
                GJ=shear * table.J,
                A_rho=table.rho * table.A,
                I_rho1=table.rho * table.I2,
                I_rho2=table.rho * table.I1,
                damping=damping,
            )
        case sec.Matrix():
            inertia = np.zeros((2, 2)) if table.I_rho is None else np.array(table.I_rho)
            return Section(
                np.array(table.stiffness), table.A_rho, inertia, order=table.order, damping=np.array(damping),
                S_rho=np.array(table.S_rho),
            )  # fmt: skip


def _given(table: Strict) -> Mapping[str, Any]:
    """What the file says and nothing else, so that the constructor's own defaults hold."""
    return table.model_dump(
        exclude={"kind", "turn", "offset"} if isinstance(table, sec.Damped) else {"kind"}, exclude_unset=True
    )


def _curve(rod: m.Rod, folder: FilePath) -> Curve:
    key = next(key for key in m.CURVES if getattr(rod, key) is not None)
    value = getattr(rod, key)
    if rod.centreline is not None:  # a file may change, so it is read every time
        from directrix.geometry.tables import centreline

        table = dict(_given(rod.centreline))
        return centreline(folder / table.pop("file"), **table, directors=rod.directors, d1=rod.d1)
    given = tuple(_given(value).items()) if isinstance(value, Strict) else value
    return _made(key, given, rod.directors, rod.d1)


@lru_cache(maxsize=256)  # the entries of a file are built again where one is looked for that does not fit
def _made(key: str, given: Any, directors: Literal["tangent", "chord"], d1: Vec | None) -> Curve:
    match key:
        case "line":
            return line(*given, directors=directors, d1=d1)
        case "arc":
            return arc(**dict(given), directors=directors, d1=d1)
        case "helix":
            return helix(**dict(given), directors=directors, d1=d1)
        case "polyline":
            return polyline(given, directors=directors, d1=d1)
        case "catenary":
            return catenary(**dict(given), directors=directors, d1=d1)
        case _:
            return spline(given, directors=directors, d1=d1)


def _rod(rod: m.Rod, sections: Mapping[str, Section], folder: FilePath, model: Model) -> Model:
    if rod.section not in sections:
        raise ModelError(
            f"rod {rod.name!r} has the section {rod.section!r}, which the file does not define",
            f"{nearest(rod.section, sections)}sections of this file: {', '.join(sections) or 'none'}",
            code="DX421",
        )
    return model.rod(
        _curve(rod, folder),
        sections[rod.section],
        name=rod.name,
        ends=rod.ends,
        elements=rod.elements,
        order=rod.order,
        points=rod.points,
        nodes=rod.nodes,
        twist=rod.twist,
    )


def _support(support: m.Support, model: Model) -> Model:
    match support.type:
        case "clamp":
            return model.clamp(support.node)
        case "pin":
            return model.pin(support.node)
        case None:
            return model.fix(support.node, *(support.dofs or ()))


def _load(load: m.Load, model: Model) -> Model:
    value: Any = timed(load.value, load.time)
    match load:
        case m.Force():
            return model.force(load.node, value, constant=load.constant, follower=load.follower)
        case m.Moment():
            return model.moment(load.node, value, constant=load.constant, follower=load.follower)
        case m.Distributed():
            return model.distributed(load.rod, value, constant=load.constant, follower=load.follower)
        case _:
            return model.gravity(value, constant=load.constant)


def _pressure(load: m.Pressure, model: Model) -> Model:
    value = timed(load.value, load.time)
    return model.pressure(load.rod, value, width=load.width, along=load.along, constant=load.constant)


def _actuate(table: m.Actuate, static: bool, model: Model) -> Model:
    parts = [(key, v) for key in PARTS if (v := getattr(table, key)) is not None]
    if (along := table.along) is not None:
        # a function is taken as it is: in statics it has to ramp by itself
        time = table.time or (Ramp(until=1.0) if static else None)
        local = {key: AlongRod(v, along.s, along.factor, time) for key, v in parts}
        return model.actuate(table.rod, **local, along=True)
    return model.actuate(table.rod, **{key: timed(v, table.time) for key, v in parts})


def _tendon(table: m.Tendon, model: Model) -> Model:
    tension = timed(table.tension, table.time)
    if table.nodes is not None:
        offset = table.offsets or ((0.0, 0.0, 0.0),) * len(table.nodes)
        return model.tendon(table.nodes, tension, offset=offset, name=table.name, constant=table.constant)
    if table.route is not None:
        route = Route(table.route.fraction, table.route.offset)
        return model.tendon(table.rod or "", tension, offset=route, name=table.name, constant=table.constant)
    offset = table.offset if table.offset_end is None else (table.offset, table.offset_end)
    return model.tendon(table.rod or "", tension, offset=offset, name=table.name, constant=table.constant)


def _drag(table: m.Drag, model: Model) -> Model:
    flow = timed(table.flow, table.time)
    return model.drag(table.rod, table.normal, table.tangential, flow=flow, constant=table.constant)


def _attach(kind: str, table: m.Link | m.PointMass, model: Model) -> Model:
    """The method of the model has the name of the table, and its arguments the names of the keys."""
    given = dict(_given(table))
    if "mass" in given and kind == "point_mass":
        given["m"] = given.pop("mass")
    return getattr(model, kind)(**given)


def _node(node: j.Node, model: Model) -> Model:
    return model.node(node.name, node.at)


def _joint(joint: j.AnyJoint, model: Model) -> Model:
    """The method of the model has the name of the kind, and its arguments the names of the keys."""
    given = dict(joint.model_dump(exclude={"kind", "time"}, exclude_unset=True))
    if isinstance(joint, j.Driven):
        for key in ("prescribed", "drive"):
            value = getattr(joint, key)
            if isinstance(value, float) and joint.time is not None:
                value = ScaledNumber(value, joint.time)
            if value is not None:
                given[key] = value
    return getattr(model, joint.kind)(**given)


def _touch(kind: str, table: m.Touch, model: Model) -> Model:
    given = dict(_given(table))
    if isinstance(table, m.Contact):
        surface = {"plane": Plane, "sphere": Sphere, "cylinder": Cylinder}[table.obstacle.kind]
        given["obstacle"] = surface(**_given(table.obstacle))
    return getattr(model, kind)(**given)


def _velocity(start: m.Velocity, model: Model) -> Model:
    return model.velocity(start.node, start.v, start.omega)


def _rigid_velocity(start: m.RigidVelocity, model: Model) -> Model:
    return model.rigid_velocity(start.v, start.omega, start.about)


def _prescribe(moved: m.Prescribe, static: bool, model: Model) -> Model:
    displacement, rotation = (_moving(v, moved) for v in (moved.displacement, moved.rotation))
    turn = moved.turn
    if turn is None:
        return model.prescribe(moved.node, displacement=displacement, rotation=rotation)
    if turn.time is None and not static:
        raise ModelError(
            f"the turn of node {moved.node!r} has no time",
            'say how it goes, e.g. time = { kind = "ramp", until = 1 }',
        )
    x, y, z = (radians(turn.degrees) * np.array(turn.axis) / np.linalg.norm(turn.axis)).tolist()
    rotation = Scaled((x, y, z), turn.time or Ramp(until=1.0))
    displacement = displacement or (0.0, 0.0, 0.0)
    if static and isinstance(displacement, tuple):  # a plain value ramps, as the model would do with it
        displacement = Scaled(displacement, Ramp(until=1.0))
    carried = Rotated(_position(moved.node, model), turn.about, rotation, displacement)
    return model.prescribe(moved.node, displacement=carried, rotation=rotation)


def _moving(value: Vec | VectorTable | None, moved: m.Prescribe) -> Vec | VectorTable | Scaled | None:
    return Scaled(value, moved.time) if isinstance(value, tuple) and moved.time is not None else value


def _position(node: str, model: Model) -> Vec:
    """Where a named node is in the reference."""
    for free in model.nodes:
        if free.name == node:
            return free.at
    for rod in model.rods:
        for name, fraction in ((rod.ends[0], 0.0), (rod.ends[1], 1.0), *rod.nodes):
            if name == node:
                x, y, z = rod.curve.position(fraction * rod.curve.length).tolist()
                return (x, y, z)
    known = [name for rod in model.rods for name in rod.names] + [free.name for free in model.nodes]
    raise ModelError(f"there is no node {node!r} to turn", f"nodes are {', '.join(known)}", code="DX420")
