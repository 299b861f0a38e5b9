"""From checked tables to a Model, entry by entry, so that what the model refuses is shown at its line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import radians

import numpy as np
from numpy.typing import ArrayLike

from directrix.curves import Curve, arc, helix, line, polyline, spline
from directrix.errors import InputError, ModelError
from directrix.model import Model
from directrix.schema import models as m
from directrix.schema.functions import Ramp, Rotated, Scaled, Vec, VectorTable
from directrix.schema.messages import Source
from directrix.section import Section

__all__ = ["build_model"]

Value = Vec | Callable[[float], ArrayLike]


def build_model(tables: m.CaseFile, title: str, source: Source) -> Model:
    """The Model that the tables describe. Raises InputError at the entry that cannot be."""
    sections: dict[str, Section] = {}
    for name, section in tables.section.items():
        with _at(source, "section", name):
            sections[name] = _section(section)
    model = Model().named(title)
    for k, rod in enumerate(tables.rod):
        with _at(source, "rod", k):
            model = _add_rod(model, rod, sections)
    for k, support in enumerate(tables.support):
        with _at(source, "support", k):
            match support.type:
                case "clamp":
                    model = model.clamp(support.node)
                case "pin":
                    model = model.pin(support.node)
                case None:
                    model = model.fix(support.node, *(support.dofs or ()))
    for k, moved in enumerate(tables.prescribe):
        with _at(source, "prescribe", k):
            model = _prescribe(model, moved, static=tables.statics is not None)
    for k, load in enumerate(tables.force):
        with _at(source, "force", k):
            model = model.force(load.node, _timed(load), constant=load.constant)
    for k, load in enumerate(tables.moment):
        with _at(source, "moment", k):
            model = model.moment(load.node, _timed(load), constant=load.constant)
    for k, load in enumerate(tables.distributed):
        with _at(source, "distributed", k):
            model = model.distributed(load.rod, _timed(load), constant=load.constant)
    if tables.gravity is not None:
        with _at(source, "gravity"):
            model = model.gravity(_timed(tables.gravity), constant=tables.gravity.constant)
    for k, start in enumerate(tables.velocity):
        with _at(source, "velocity", k):
            model = model.velocity(start.node, start.v, omega=start.omega)
    if tables.rigid_velocity is not None:
        with _at(source, "rigid_velocity"):
            start = tables.rigid_velocity
            model = model.rigid_velocity(start.v, omega=start.omega, about=start.about)
    return model


@contextmanager
def _at(source: Source, *loc: str | int) -> Iterator[None]:
    try:
        yield
    except ModelError as error:
        raise InputError(error.what, error.fix, source.where(loc)) from None


def _section(table: m.Section) -> Section:
    match table:
        case m.Circle():
            return Section.circle(**_given(table))
        case m.Rectangle():
            return Section.rectangle(**_given(table))
        case m.Tube():
            return Section.tube(**_given(table))
        case m.Moduli():
            return Section.from_moduli(**_given(table))
        case m.Properties():
            shear = table.E / (2.0 * (1.0 + table.nu))
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
            )
        case m.Matrix():
            return Section(
                stiffness=np.array(table.stiffness),
                order=table.order,
                A_rho=table.A_rho,
                I_rho=np.zeros((2, 2)) if table.I_rho is None else np.array(table.I_rho),
            )


def _given(table: m.Strict) -> Mapping[str, float]:
    """What the file says and nothing else, so that the constructor's own defaults hold."""
    return table.model_dump(exclude={"kind"}, exclude_unset=True)


def _curve(rod: m.Rod) -> Curve:
    if rod.line is not None:
        return line(*rod.line, directors=rod.directors, d1=rod.d1)
    if rod.arc is not None:
        return arc(rod.arc.start, rod.arc.through, rod.arc.end, directors=rod.directors, d1=rod.d1)
    if rod.helix is not None:
        return helix(**rod.helix.model_dump(), directors=rod.directors, d1=rod.d1)
    if rod.polyline is not None:
        return polyline(rod.polyline, directors=rod.directors, d1=rod.d1)
    return spline(rod.spline or (), directors=rod.directors, d1=rod.d1)


def _add_rod(model: Model, rod: m.Rod, sections: Mapping[str, Section]) -> Model:
    if rod.section not in sections:
        raise ModelError(
            f"rod {rod.name!r} has the section {rod.section!r}, which the file does not define",
            f"sections of this file: {', '.join(sections)}",
        )
    return model.rod(
        _curve(rod),
        sections[rod.section],
        name=rod.name,
        ends=rod.ends,
        elements=rod.elements,
        order=rod.order,
        points=rod.points,
        nodes=rod.nodes,
    )


def _timed(load: m.Load) -> Value:
    return load.value if load.time is None else Scaled(load.value, load.time)


def _prescribe(model: Model, moved: m.Prescribe, static: bool) -> Model:
    displacement, rotation = (_moving(v, moved) for v in (moved.displacement, moved.rotation))
    turn = moved.turn
    if turn is None:
        return model.prescribe(moved.node, displacement=displacement, rotation=rotation)
    if turn.time is None and not static:
        raise ModelError(
            f"the turn of node {moved.node!r} has no time", 'say how it goes, e.g. time = { kind = "ramp", until = 1 }'
        )
    axis = np.array(turn.axis) / np.linalg.norm(turn.axis)
    vector = _vec(radians(turn.degrees) * axis)
    rotation = Scaled(vector, turn.time or Ramp(until=1.0))
    displacement = displacement or (0.0, 0.0, 0.0)
    if static and isinstance(displacement, tuple):  # a plain value ramps, as the model would do with it
        displacement = Scaled(displacement, Ramp(until=1.0))
    carried = Rotated(model.position(moved.node), turn.about, rotation, displacement)
    return model.prescribe(moved.node, displacement=carried, rotation=rotation)


def _moving(value: Vec | VectorTable | None, moved: m.Prescribe) -> Vec | VectorTable | Scaled | None:
    return Scaled(value, moved.time) if isinstance(value, tuple) and moved.time is not None else value


def _vec(v: ArrayLike) -> Vec:
    x, y, z = np.asarray(v, float).tolist()
    return (x, y, z)
