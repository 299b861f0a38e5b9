"""What is likely not meant in a case, though it can be computed: warnings of ``check`` and ``run``, none an error."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt
from typing import Any, cast

import numpy as np

from directrix.findings import Finding
from directrix.model import Gravity, Model, Vec
from directrix.schema import functions as f
from directrix.schema import models as m
from directrix.schema.joints import Driven, Hinge
from directrix.schema.sections import Material
from directrix.schema.units import UnitSet

__all__ = ["plausible"]

STANDARD = 9.81  # m/s²
THICK = 5.0  # length over radius of gyration below which a rod is none
LARGEST_STRAIN = 0.5  # that forces should cause, EA taken as it is
COARSE = 8  # nodes of a turn of a helix below which it is coarse


def plausible(tables: m.CaseFile, model: Model, units: UnitSet) -> tuple[Finding, ...]:
    """Warnings about numbers that look like other units, bodies that are no rods, and times that do not fit."""
    found = [*_materials(tables, units), *_gravity(model, units), *_shapes(model), *_meshes(tables)]
    found += [*_angles(tables), *_forces(tables, model)]
    if tables.dynamics is not None:
        found += [*_steps(tables, model, tables.dynamics), *_late(tables, tables.dynamics.t_end)]
    return tuple(found)


def _warn(code: str, what: str, fix: str) -> Finding:
    return Finding(code, False, what, fix)


def _materials(tables: m.CaseFile, units: UnitSet) -> Iterator[Finding]:
    for name, section in tables.section.items():
        if not isinstance(section, Material) or section.rho == 0.0:
            continue
        stress, density = section.E * units.size((-1, 1, -2)), section.rho * units.size((-3, 1, 0))
        if 1e9 <= stress <= 1e12 and 0.5 <= density <= 30.0:
            yield _warn(
                "density",
                f"section {name!r}: a material with E = {stress:.3g} Pa has hardly {density:.3g} kg/m³; that looks "
                "like g/cm³",
                f"write rho = {1000.0 * section.rho:g} if that is what is meant",
            )
        elif 300.0 <= density <= 25e3 and 1.0 <= stress <= 1e3:
            yield _warn(
                "stiffness",
                f"section {name!r}: with {density:.3g} kg/m³, E = {stress:.3g} Pa is softer than any jelly; that looks "
                "like GPa",
                f"write E = {1e9 * section.E:g} if that is what is meant",
            )
        elif 300.0 <= density <= 25e3 and not units.names and 1e4 < stress <= 5e5 and density > 2000.0:
            yield _warn(
                "stiffness",
                f"section {name!r}: with {density:.3g} kg/m³, E = {stress:.3g} Pa is that of a gel; that looks like "
                "MPa",
                f"write E = {1e6 * section.E:g} if that is what is meant",
            )


def _gravity(model: Model, units: UnitSet) -> Iterator[Finding]:
    for load in model.loads:
        if isinstance(load, Gravity) and not callable(load.value):
            g = float(np.linalg.norm(np.array(cast("Vec", cast("Any", load).value)))) * units.size((1, 0, -2))
            for factor, said in ((1e-3, "a thousandth"), (1e3, "a thousand times")):
                if abs(g - factor * STANDARD) < 0.02 * factor * STANDARD:
                    yield _warn(
                        "gravity",
                        f"gravity is {g:.3g} m/s², {said} of what it is on Earth",
                        f"write {STANDARD / units.size((1, 0, -2)):g} if that is what is meant",
                    )


def _shapes(model: Model) -> Iterator[Finding]:
    for rod in model.rods:
        c = np.diag(rod.section.stiffness)
        gyration = sqrt(float(max(c[3], c[4]) / c[2]))
        outline = rod.section.outline
        depth = float(np.ptp(outline, axis=0).max()) if len(outline) else sqrt(12.0) * gyration
        length = rod.curve.length
        if depth > length:
            yield _warn(
                "thick",
                f"rod {rod.name!r} is {depth:.3g} thick and {length:.3g} long",
                "check the units of its section and its axis",
            )
        elif length < THICK * gyration:
            yield _warn(
                "thick",
                f"rod {rod.name!r} has a slenderness of {length / gyration:.3g} (length over radius of gyration): "
                "rod theory does not hold for it",
                "check the units, or take the rod for a rigid body",
            )


def _meshes(tables: m.CaseFile) -> Iterator[Finding]:
    for rod in tables.rod:
        if rod.helix is not None and abs(rod.helix.turns) >= 1.0:
            per_turn = rod.elements * rod.order / abs(rod.helix.turns)
            if per_turn < COARSE:
                needed = int(np.ceil(COARSE * abs(rod.helix.turns) / rod.order))
                yield _warn(
                    "coarse",
                    f"rod {rod.name!r} has {per_turn:.3g} nodes a turn of its helix",
                    f"give it {needed} elements or more",
                )


def _angles(tables: m.CaseFile) -> Iterator[Finding]:
    """Angles in radians that look like degrees."""
    seen: list[tuple[str, float]] = []
    for moved in tables.prescribe:
        if isinstance(moved.rotation, tuple):
            seen.append((f"the rotation of node {moved.node!r}", float(np.linalg.norm(moved.rotation))))
    for k, joint in enumerate(tables.joint):
        if isinstance(joint, Driven) and isinstance(joint, Hinge):
            name = joint.name or f"joint{k + 1}"
            if isinstance(joint.prescribed, float):
                seen.append((f"the angle prescribed at joint {name!r}", joint.prescribed))
            seen += [(f"a stop of joint {name!r}", stop) for stop in joint.stops or ()]
    for where, time in _times(tables):
        if isinstance(time, f.Sine):
            seen.append((f"the phase of {where}", time.phase))
    for what, angle in seen:
        if abs(angle) >= 10.0 and abs(angle / 5.0 - round(angle / 5.0)) < 1e-9:
            yield _warn(
                "degrees",
                f"{what} is {angle:g} radians, {abs(angle) / (2.0 * pi):.3g} turns; that looks like degrees",
                f"write {angle * pi / 180.0:.6g} if that is what is meant",
            )


def _forces(tables: m.CaseFile, model: Model) -> Iterator[Finding]:
    if not model.rods or (tables.statics is not None and tables.statics.control is not None):
        return
    stiffest = max(float(rod.section.stiffness[2, 2]) for rod in model.rods)
    for force in tables.force:
        size = float(np.linalg.norm(force.value))
        if size > LARGEST_STRAIN * stiffest:
            yield _warn(
                "large_force",
                f"the force on node {force.node!r} is {size:.3g}, and the largest EA of the rods {stiffest:.3g}: it "
                f"would stretch them by {100.0 * size / stiffest:.3g} %",
                "check the units of the force and of E",
            )


def _steps(tables: m.CaseFile, model: Model, do: m.Dynamics) -> Iterator[Finding]:
    periods: list[float] = []
    for rod in model.rods:
        softest = float(min(rod.section.stiffness[3, 3], rod.section.stiffness[4, 4]))
        periods.append(2.0 * pi / 3.516 * rod.curve.length**2 * sqrt(rod.section.A_rho / softest))
    if periods and not tables.rigid_body and not tables.point_mass and 0.0 < max(periods) < do.dt:
        yield _warn(
            "long_step",
            f"dt = {do.dt:g} is longer than the longest bending period of a single rod, about {max(periods):.3g} "
            "(clamped at one end): its vibration is not resolved",
            f"take dt = {max(periods) / 20.0:.2g} or less, or see it as rigid",
        )
    for where, time in _times(tables):
        if isinstance(time, f.Sine) and time.frequency * do.dt > 0.25:
            yield _warn(
                "long_step",
                f"{where} has a period of {1.0 / time.frequency:.3g}, less than four steps of dt = {do.dt:g}",
                f"take dt = {0.05 / time.frequency:.2g} or less",
            )


def _late(tables: m.CaseFile, t_end: float) -> Iterator[Finding]:
    for where, time in _times(tables):
        start = time.start if isinstance(time, f.Ramp | f.Pulse) else None
        if start is not None and start >= t_end:
            yield _warn(
                "late",
                f"{where} begins at t = {start:g}, and the motion is computed to t = {t_end:g}: it never acts",
                "check the units of the times, or give a later t_end",
            )


def _times(tables: m.CaseFile) -> Iterator[tuple[str, f.Time]]:
    """Every factor of time, and what it belongs to."""
    for key in ("force", "moment", "distributed", "pressure", "prescribe", "actuate", "tendon", "drag", "joint"):
        for k, entry in enumerate(getattr(tables, key)):
            if getattr(entry, "time", None) is not None:
                name = next((v for a in ("name", "node", "rod", "a") if (v := getattr(entry, a, None))), f"#{k + 1}")
                yield f"{key} {name!r}", entry.time
    if tables.gravity is not None and tables.gravity.time is not None:
        yield "gravity", tables.gravity.time
