"""What ``directrix check`` prints: the whole case in words, with every default and convention."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from directrix import functions
from directrix.contacts import Contact, Cylinder, Plane, RodContact, Sphere
from directrix.discretisation import Discretisation
from directrix.estimate import cost
from directrix.findings import Finding
from directrix.joints import KINDS, Joint
from directrix.model import DOFS, Distributed, Force, Gravity, Model, Moment, Pressure, RigidVelocity, Rod
from directrix.schema.functions import Pulse, Ramp, Rotated, Scaled, ScaledNumber, Sine, Table, VectorTable
from directrix.schema.load import Case
from directrix.schema.models import ArcLength, DisplacementControl, Dynamics, Statics
from directrix.section import Section

Array = NDArray[np.float64]

__all__ = ["describe"]

CONVENTIONS = (
    "components of strain and section force: shear 1, shear 2, axial, bending 1, bending 2, torsion",
    "EI1 is bending about d1; I_rho1 = ∫ρ ξ1² dA sits on d1 and belongs with EI2",
    "forces, moments, rotation vectors (rad, applied on the left) are in the global frame; forces keep their direction "
    "unless they are followers",
    "angular momentum is about the origin; units are yours, as long as they are consistent",
)


def describe(case: Case) -> str:
    """The case in lines of text. Raises ModelError when it cannot be solved."""
    disc = case.check()
    return "\n".join([f"{case.title}  ({case.source})", *_lines(case, disc), "this case can be run"])


def _lines(case: Case, disc: Discretisation) -> Iterator[str]:
    yield from (f"  {line}" for line in case.description.strip().splitlines())
    yield f"  units: {case.units}"
    yield from _analysis(case, disc)
    kept = -(-case.steps // case.output.save_every) + 1
    yield f"  {cost(disc, case.steps, kept, static=isinstance(case.analysis, Statics))}"
    yield from _totals(disc)
    if disc.mesh.rods:
        yield "rods"
    for rod, mesh in zip(disc.model.rods, disc.mesh.rods, strict=True):
        d1, d3 = mesh.directors[0, :, 0], mesh.directors[0, :, 2]
        count, points = (len(mesh.s) - 1) // rod.order, rod.points or rod.order
        yield f"  {rod.name}: {rod.ends[0]} → {rod.ends[1]}, length {rod.curve.length:.6g}{_slenderness(rod)}"
        yield f"    at its start d1 = {_vector(d1)}, d3 = {_vector(d3)}"
        yield f"    {count} elements of order {rod.order}, {points} stress point{'s' * (points > 1)} each"
        yield from _section(rod.section)
    yield "named nodes"
    for name, k in disc.mesh.node_names.items():
        held = [dof for dof, fixed in zip(DOFS, disc.fixed[k], strict=True) if fixed]
        moved = " (moves as prescribed)" if any(p[0] == k for p in disc.prescribed) else ""
        yield f"  {name} at {_vector(disc.mesh.r0[k])}" + (f", held: {' '.join(held)}{moved}" if held else "")
    yield from _attached(disc)
    yield from _joints(disc, isinstance(case.analysis, Statics))
    yield from _touching(disc.model)
    yield from _moving(found := case.findings())
    yield from _loads(disc, isinstance(case.analysis, Statics))
    assumed = {a for rod in disc.model.rods for a in rod.section.assumptions}
    if notes := [n for n in (*disc.model.notes(), *disc.mesh.notes) if n not in assumed]:
        yield "notes"
        yield from (f"  {note}" for note in notes)
    if found:
        yield "findings"
        yield from (f"  {f.what}\n    fix: {f.fix}" for f in found)
    yield "conventions"
    yield from (f"  {line}" for line in CONVENTIONS)


def _moving(findings: Sequence[Finding]) -> Iterator[str]:
    """Mechanisms: what is an error has been refused, so what is left moves under conditions, or not at all."""
    loose = [f for f in findings if f.code in ("free", "loads_hold", "slack")]
    yield f"mechanisms: {len(loose) or 'none'}{', see findings' if loose else ''}"


def _slenderness(rod: Rod) -> str:
    """Length over the radius of gyration in the stiffer direction, √(EI/EA)."""
    c = np.diag(rod.section.stiffness)
    mass = f", mass {rod.section.A_rho * rod.curve.length:.6g}" if rod.section.A_rho else ""
    return f", slenderness {rod.curve.length / np.sqrt(max(c[3], c[4]) / c[2]):.4g}{mass}"


def _totals(disc: Discretisation) -> Iterator[str]:
    model = disc.model
    rods = sum(rod.section.A_rho * rod.curve.length for rod in model.rods)
    bodies = sum(body.mass for body in model.bodies)
    length = sum(rod.curve.length for rod in model.rods)
    low, high = disc.mesh.r0.min(axis=0), disc.mesh.r0.max(axis=0)
    yield f"  mass {rods + bodies:.6g} ({rods:.6g} of rods, {bodies:.6g} of bodies), {length:.6g} of rod"
    yield f"  from {_vector(low)} to {_vector(high)}"
    counts = {
        "support": len(model.supports), "prescribed motion": len(model.prescribed), "joint": len(model.joints),
        "link": len(model.links), "body": len(model.bodies), "load": len(model.loads),
        "contact": len(model.contacts) + len(model.rod_contacts),
    }  # fmt: skip
    many = {"body": "bodies"}
    yield "  " + ", ".join(f"{n} {k if n == 1 else many.get(k, f'{k}s')}" for k, n in counts.items() if n)


def _analysis(case: Case, disc: Discretisation) -> Iterator[str]:
    do, every = case.analysis, case.output.save_every
    if isinstance(do, Statics):
        yield from _drive(do)
        if do.formulation != "directors":
            yield f"  formulation {do.formulation}"
    else:
        yield f"dynamics: t = 0 → {do.t_end:g} {_steps(do)}"
        given = "".join(f", {k} = {v:g}" for k, v in do.parameters.items())
        yield f"  {do.integrator} step{given}, loads by the {do.load_rule} rule"
    kept = "every step" if every == 1 else f"every {every} steps and the last"
    yield f"  tolerance {do.tolerance:g}; kept: {kept}"
    if do.linear is not None:
        yield f"  frames solved by {do.linear}"
    free = 6 * disc.nodes - int(disc.fixed.sum())
    shape = "a chain" if disc.pattern.chain else "a general frame"
    rods, nodes = len(disc.mesh.rods), disc.nodes
    size = f"{rods} rod{'s' * (rods != 1)}, {disc.elements} elements, {nodes} node{'s' * (nodes != 1)}, {free} unknowns"
    if multipliers := int((~disc.held[disc.nodes :]).sum()):
        size += f" and {multipliers} multipliers of joints"
    yield f"  {size}, {shape}"


def _steps(do: Dynamics) -> str:
    if do.adaptive is None:
        return f"in {round(do.t_end / do.dt)} steps of {do.dt:g}, cut when needed"
    ends = "" if do.adaptive.save_at is None else f", ending at multiples of {do.adaptive.save_at:g}"
    return f"in steps with an error of {do.adaptive.tolerance:g} at most, {do.dt:g} at first{ends}"


def _drive(do: Statics) -> Iterator[str]:
    match do.control:
        case None:
            yield f"statics: load factor 0 → 1 in {do.steps} steps, cut when needed"
        case DisplacementControl() as to:
            yield f"statics: {to.component} displacement of {to.node} → {to.to:g} in {to.steps} steps, cut when needed"
        case ArcLength() as arc:
            yield f"statics: along the path in steps of ds = {arc.ds:g}, {arc.max_steps} at most"
            yield "  steps grow up to 4 ds, and are cut down to ds/4096 when needed"
            bounds = {"or more": arc.max_load_factor, "or less": arc.min_load_factor}
            ends = [f"the load factor is {value:g} {side}" for side, value in bounds.items() if value is not None]
            if (far := arc.until) is not None:
                side = "or more" if far.displacement > 0.0 else "or less"
                ends.append(f"{far.component} of {far.node} has moved {far.displacement:g} {side}")
            if ends:
                yield f"  until {', or '.join(ends)}"
            if arc.load_step is not None:
                yield f"  the load factor changes by {arc.load_step:g} at most in a step"
            for turn in arc.branch if isinstance(arc.branch, tuple) else (arc.branch,):
                yield f"  leaves the path at bifurcation {abs(turn)}, to {'one' if turn > 0 else 'the other'} side"
    if do.control is not None and do.control.load_factors:
        yield f"  stops on the way at load factors {', '.join(f'{f:g}' for f in do.control.load_factors)}"


def _section(section: Section) -> Iterator[str]:
    c = section.stiffness
    names = ("GA1", "GA2", "EA", "EI1", "EI2", "GJ")
    yield "    " + ", ".join(f"{n} = {k:.6g}" for n, k in zip(names, np.diag(c), strict=True))
    if np.any(c - np.diag(np.diag(c))):
        yield "    coupled: the stiffness matrix has entries off its diagonal"
    inertia = section.I_rho
    inertias = {"I_rho1": inertia[0, 0], "I_rho2": inertia[1, 1], "I_rho12": inertia[0, 1]}
    yield "    " + ", ".join(f"{k} = {v:.6g}" for k, v in {"A_rho": section.A_rho, **inertias}.items())
    if np.any(section.damping):
        yield "    viscous, diagonal: " + ", ".join(f"{v:.6g}" for v in np.diag(section.damping))
    yield from (f"    assumed: {sentence}" for sentence in section.assumptions)


def _attached(disc: Discretisation) -> Iterator[str]:
    model = disc.model
    places = {name: disc.mesh.r0[k] for name, k in disc.mesh.node_names.items()}
    if model.links or model.bodies:
        yield "attached"
    for link in model.links:
        rest, _ = link.measures(places)
        to = link.b if isinstance(link.b, str) else f"ground at {_vector(np.array(link.b))}"
        what = "cable" if link.cable else "spring" if link.stiffness else "dashpot"
        damped = f", damping {link.damping:.6g}" if link.damping else ""
        yield f"  {what} {link.name}: {link.a} – {to}, stiffness {link.stiffness:.6g}, length {rest:.6g}{damped}"
    for body in model.bodies:
        yield f"  body on {body.node}: mass {body.mass:.6g}, moments {_vector(np.diag(body.inertia))}"


FREE = {
    "rigid": "nothing",
    "spherical": "all turning",
    "hinge": "turning about {axis}",
    "universal": "turning about {axis} of {a} and {second} of {b}",
    "cylindrical": "sliding along and turning about {axis}",
    "slider": "sliding along {axis}",
    "planar": "sliding across and turning about {axis}",
}


def _joints(disc: Discretisation, static: bool) -> Iterator[str]:
    places = {name: disc.mesh.r0[k] for name, k in disc.mesh.node_names.items()}
    if disc.model.joints:
        yield "joints"
    for joint in disc.model.joints:
        to = joint.b or "ground"
        base = joint.a if joint.b else "ground"
        axis, second = (_vector(np.array(u if u is not None else (0, 0, 0), float)) for u in (joint.axis, joint.second))
        free = FREE[joint.kind].format(axis=axis, second=second, a=base, b=joint.nodes[-1])
        yield f"  {joint.kind} {joint.name}: {joint.a} – {to}, at {_vector(joint.place(places))}, leaves free: {free}"
        if acting := list(_acting(joint, static)):
            yield f"    on its {KINDS[joint.kind].free.replace('ball', 'relative rotation')}: {', '.join(acting)}"


def _acting(joint: Joint, static: bool) -> Iterator[str]:
    if joint.stiffness:
        yield f"stiffness {joint.stiffness:.6g}" + (f" from {joint.rest:.6g} on" if joint.rest else "")
    if joint.damping:
        yield f"damping {joint.damping:.6g}"
    if joint.drive is not None:
        yield f"drive {_text(joint.drive)}" + (" (times the load factor)" if static else "")
    if joint.prescribed is not None:
        ramps = static and isinstance(joint.prescribed, float)
        yield f"prescribed {_text(joint.prescribed)}" + (" (ramps with the load factor)" if ramps else "")
    if joint.stops is not None:
        low, high = joint.stops
        yield f"stops at {low:.6g} and {high:.6g} of stiffness {joint.stop_stiffness:.6g}"


def _touching(model: Model) -> Iterator[str]:
    if model.contacts or model.rod_contacts:
        yield "contacts"
    for touch in (*model.contacts, *model.rod_contacts):
        rods = "all rods" if touch.rods is None else ", ".join(touch.rods)
        match touch:
            case Contact(obstacle=Plane() as plane):
                to = f"a plane through {_vector(np.array(plane.point))}, normal {_vector(np.array(plane.normal))}"
            case Contact(obstacle=Sphere() as ball):
                to = f"{'the inside of ' if ball.inside else ''}a sphere at {_vector(np.array(ball.center))}, radius "
                to += f"{ball.radius:.6g}"
            case Contact(obstacle=Cylinder() as pipe):
                to = f"{'the inside of ' if pipe.inside else ''}a cylinder through {_vector(np.array(pipe.point))} "
                to += f"along {_vector(np.array(pipe.axis))}, radius {pipe.radius:.6g}"
            case RodContact(others=None):
                to = "one another and themselves"
            case _:
                to = ", ".join(getattr(touch, "others", ()))
        rough = f", friction {touch.friction:.6g} from {touch.slip_speed:.6g} on" if touch.friction else ""
        yield f"  {touch.name}: {rods} against {to}, stiffness {touch.stiffness:.6g} per length{rough}"


def _loads(disc: Discretisation, static: bool) -> Iterator[str]:
    model = disc.model
    if model.loads:
        yield "loads" + (" (times the load factor unless constant)" if static else "")
    for load in model.loads:
        match load:
            case Force():
                what = f"force on {load.node}"
            case Moment():
                what = f"moment on {load.node}"
            case Distributed():
                what = f"force per length along {load.rod}"
            case Pressure():
                what = f"pressure on {load.rod}, {load.width:.6g} wide, along {load.along}"
            case Gravity():
                what = "gravity"
        yield f"  {what}: {_text(load.value)}{', constant' if load.constant else ''}" + (
            ", turns with the node" if isinstance(load, Force | Moment | Distributed) and load.follower else ""
        )
    yield from _driven(model)
    if model.prescribed:
        yield "prescribed motion" + (" (plain values ramp with the load factor)" if static else "")
    for p in model.prescribed:
        yield f"  {p.node}: displacement {_text(p.displacement)}; rotation {_text(p.rotation)}"
    if model.velocities:
        yield "initial velocities"
    for start in model.velocities:
        where = "all" if isinstance(start, RigidVelocity) else start.node
        yield f"  {where}: v = {_text(start.v)}, omega = {_text(start.omega)}" + (
            f" about {_text(start.about)}" if isinstance(start, RigidVelocity) else ""
        )


def _driven(model: Model) -> Iterator[str]:
    for a in model.actuations:
        parts = {"curvature": a.curvature, "twist": a.twist, "elongation": a.elongation, "strain": a.strain}
        yield f"actuation of {a.rod}: " + "; ".join(f"{k} {_text(v)}" for k, v in parts.items() if v is not None)
    for t in model.tendons:
        along = f"along {t.along}" if isinstance(t.along, str) else f"through {' – '.join(t.along)}"
        offset = repr(t.offset) if callable(t.offset) else ", ".join(_vector(o) for o in np.atleast_2d(t.offset))
        yield f"tendon {t.name}: {along}, offset {offset}, tension {_text(t.tension)}{', constant' * t.constant}"
    for d in model.drags:
        flow = f", flow {_text(d.flow)}{', constant' * d.constant}"
        yield f"drag on {d.rod}: normal {d.normal:.6g}, tangential {d.tangential:.6g}{flow}"


def _text(value: object) -> str:
    """A vector or a function of time in words."""
    match value:
        case None:
            return "–"
        case float():
            return f"{value:.6g}"
        case tuple():
            return _vector(np.array(value, float))
        case functions.Ramp():
            return f"{_text(value.value)} × ramp, t = {value.t0:g} … {value.t1:g}"
        case functions.Harmonic():
            wave = f"{_text(value.value)} × sin, frequency {value.frequency:g}, phase {value.phase:g}"
            return wave + (f", about {_text(value.mean)}" if value.mean != 0.0 else "")
        case functions.Table():
            return f"table of {len(value.times)} values, t = {value.times[0]:g} … {value.times[-1]:g}"
        case ScaledNumber():
            return f"{value.value:.6g} × {_text(value.factor)}"
        case Scaled():
            return f"{_text(value.value)} × {_text(value.factor)}"
        case Rotated():
            return f"{_text(value.displacement)}, then turned about {_text(value.about)} by {_text(value.turn)}"
        case Table() | VectorTable():
            return f"table of {len(value.t)} values, t = {value.t[0]:g} … {value.t[-1]:g}"
        case Ramp() | Sine() | Pulse():
            given = value.model_dump(exclude={"kind"}, exclude_none=True)
            return f"{value.kind}({', '.join(f'{k} = {v}' for k, v in given.items())})"
        case _:
            return repr(value)


def _vector(v: Array) -> str:
    # adding zero turns −0 into 0
    return "(" + ", ".join(f"{x + 0.0:.6g}" for x in np.round(v, 12)) + ")"
