"""From a model to arrays: mesh, numbering, reference directors, pattern of the matrix, supports and loads.

The numbering follows the shape of the graph: rods that only ever meet end to end are a chain (block
tridiagonal); anything else is a general frame (sparse blocks). Interior nodes of elements are condensed.
"""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from directrix.basis import at_gauss
from directrix.checks import shown
from directrix.contact_groups import Near, Pairs, contact_states, near_of, obstacle_groups
from directrix.drives import Drive, driven, drives_of
from directrix.errors import ModelError
from directrix.formulations.contact import PairElement
from directrix.formulations.directors import DirectorElement
from directrix.formulations.layout import Layout
from directrix.free_nodes import idle_rotations, refuse_loose
from directrix.groups import (
    Group,
    RodArrays,
    attached_groups,
    layout_of,
    lumped_at_nodes,
    mesh_rods,
    parameters_of,
)
from directrix.joint_groups import joint_ends, joint_groups, unused
from directrix.loads import LoadTerm, Prescribed, driven_joints, drives_as_loads, loads_of, supports_of
from directrix.marks import marks_of
from directrix.model import Gravity, Model, RigidVelocity, Rod, Vec
from directrix.numbering import Pattern, pattern_of
from directrix.result import Mesh, RodMesh
from directrix.rotations import hat
from directrix.routes import refuse_driven, routes_of
from directrix.scheme import Rates, Scheme
from directrix.section import Stressed
from directrix.sources import Sources, sources_of

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Discretisation", "discretise", "rates_of"]


@dataclass(frozen=True)
class Discretisation:
    """Everything the solvers read. ``fixed`` (n, 6) marks components held by supports or prescribed motion;
    ``prescribed`` pairs a node with its displacement and rotation functions, ``driven`` a joint with that of its
    coordinate. Behind the nodes the unknowns have a row for every joint."""

    model: Model
    mesh: Mesh
    groups: tuple[Group, ...]
    pattern: Pattern
    fixed: NDArray[np.bool_]
    prescribed: tuple[Prescribed, ...]
    driven: tuple[tuple[int, Callable[[float], float]], ...]
    loads: tuple[LoadTerm, ...]
    sections: tuple[Stressed, ...]
    lumped: Array
    """(n, 13): mass, principal values (3) and vectors (9) of the Euler dyadic of every node, all of it lumped there."""
    spread: Mapping[str, tuple[Ints, Array]]
    """Nodes of every rod, element by element, and the lengths that they stand for."""
    near: Near | None
    """Finds what rods may touch; the elements for it come and go."""
    sources: Sources
    drives: tuple[Drive, ...]

    def touching(self, pairs: Pairs, scheme: Scheme) -> Discretisation:
        """The same with these pairs of rods in contact; then all nodes are unknowns of the system, to be coupled."""
        assert self.near is not None
        pushing = self.near.groups(pairs)
        others = (g for g in self.groups if not isinstance(g.element, PairElement))
        # whether interior nodes are condensed is a matter of rods, and of what sits on their interior nodes
        kept = (replace(g, condensed=not pushing) if g.inside or not g.names else g for g in others)
        groups = (*kept, *pushing)
        sources = sources_of(self.model, groups, scheme)
        return replace(self, groups=groups, pattern=pattern_of(self.rows, groups), sources=sources)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.mesh.r0)

    @property
    def rows(self) -> int:
        """Number of nodes and joints."""
        return self.nodes + len(self.model.joints)

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """(rows, 6) components that are no unknowns: fixed ones, and multipliers that a joint does not have."""
        return np.concatenate([self.fixed, unused(self.model.joints)])

    @property
    def elements(self) -> int:
        """Number of elements of the rods."""
        return sum(len(g.conn) for g in self.groups if not g.names)

    @property
    def stations(self) -> int:
        """Number of stress points."""
        return sum(len(rod.stations) for rod in self.mesh.rods)

    @cached_property
    def length(self) -> float:
        """Size of the model, the diagonal of its box; joints on the ground count where there are nodes alone."""
        places = {name: self.mesh.r0[k] for name, k in self.mesh.node_names.items()}
        grounded = [joint.place(places) for joint in self.model.joints if joint.b is None and not self.model.rods]
        return float(np.linalg.norm(np.ptp([*self.mesh.r0, *grounded], axis=0))) or 1.0

    def element_place(self, element: int) -> str:
        """ "rod 'mid', element 3": where an element (numbered through the groups) is."""
        for group in self.groups:
            if element < len(group.conn):
                if group.names:
                    return group.names[element]
                station = group.station[element]
                for rod in self.mesh.rods:
                    local = (station - rod.first_station) // group.layout.points
                    if 0 <= station - rod.first_station < len(rod.stations):
                        return f"rod '{rod.name}', element {local + 1}"
            element -= len(group.conn)
        return f"element {element}"

    def external(self, t: float, factor: float = 1.0) -> Array:
        """Loads (rows, 12) at time t: forces and moments, then those that turn with their node, in its frame, or the
        drive of a joint.

        Those not marked constant are multiplied by ``factor``.
        """
        out = np.zeros((self.rows, 12))
        for load in self.loads:
            value = load.value(t) * (1.0 if load.constant else factor)
            np.add.at(out[:, load.first : load.first + 3], load.nodes, load.weights * value)
        return out

    def driven_at(self, t: float, factor: float) -> Discretisation:
        """The same with intrinsic strains, tensions of tendons and flows as they are at ``t``."""
        return replace(self, groups=driven(self.groups, self.drives, t, factor))

    def intrinsic(self, t: float, factor: float) -> Array:
        """Strains (stations, 6) without stress at ``t``."""
        out = np.zeros((self.stations, 6))
        for actuation in self.model.actuations:
            rod = self.mesh.rod(actuation.rod)
            out[rod.first_station : rod.first_station + len(rod.stations)] = actuation.at(t, factor, rod.stations)
        return out

    def section_force(self, strain: Array) -> Array:
        """Section forces (…, stations, 6) from strains (…, stations, 6) that are stressed."""
        parts = [section.forces(part) for section, part in self._by_section(strain)]
        return np.concatenate([strain[..., :0, :], *parts], axis=-2)

    def stored_density(self, strain: Array) -> Array:
        """Stored energy per unit length (…, stations) at strains (…, stations, 6) that are stressed."""
        parts = [section.stored(part) for section, part in self._by_section(strain)]
        return np.concatenate([strain[..., :0, 0], *parts], axis=-1)

    def _by_section(self, strain: Array) -> list[tuple[Stressed, Array]]:
        return [
            (section, strain[..., rod.first_station : rod.first_station + len(rod.stations), :])
            for rod, section in zip(self.mesh.rods, self.sections, strict=True)
        ]

    def link_states(self, r: Array, R: Array) -> dict[str, Array]:
        """Length and elastic tension (nt, 2) of every link, from positions (nt, n, 3) and rotations (nt, n, 3, 3)."""
        index = self.mesh.node_names
        places = {name: self.mesh.r0[k] for name, k in index.items()}
        out: dict[str, Array] = {}
        for link in self.model.links:

            def point(node: str, offset: Vec) -> Array:
                return r[:, index[node]] + R[:, index[node]] @ np.array(offset)

            first = point(link.a, link.offset_a)
            second = point(link.b, link.offset_b) if isinstance(link.b, str) else np.array(link.b)
            length = np.linalg.norm(second - first, axis=1)
            out[link.name] = np.stack([length, link.tension(length, *link.measures(places))], -1)
        return out

    def contact_states(self, r: Array) -> dict[str, Array]:
        """Smallest gap and sum of normal forces (nt, 2) of every contact, from positions (nt, n, 3)."""
        return contact_states(self.model.contacts, self.model, self.spread, self.near, r)

    def initial_rates(self) -> tuple[Array, Array]:
        """Nodal velocities (n, 3) and angular velocities (n, 3) that the model asks for."""
        v, omega = np.zeros((self.nodes, 3)), np.zeros((self.nodes, 3))
        for given in self.model.velocities:
            if isinstance(given, RigidVelocity):
                v += given.v + np.cross(given.omega, self.mesh.r0 - np.asarray(given.about))
                omega += given.omega
            else:
                k = self.mesh.node_names[given.node]
                v[k] += given.v
                omega[k] += given.omega
        for name in idle_rotations(self.model, False):
            omega[self.mesh.node_names[name]] = 0.0
        return v, omega


def rates_of(rotation: Array, omega: Array) -> Array:
    """dR/dt = ω̂ R, (n, 3, 3)."""
    return hat(omega) @ rotation


def discretise(model: Model, scheme: Scheme) -> Discretisation:
    """Mesh the model and number its unknowns; raises ModelError for a model that cannot be solved."""
    if not isinstance(model, Model):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"{shown(model)} is not a model", "start from dx.Model() and add rods")
    element, dynamic = scheme.element, not scheme.static
    model.check(static=not dynamic, dynamic=dynamic, meshed=False)
    refuse_driven(model, scheme)
    positions: list[Array] = [np.array(node.at) for node in model.nodes]
    names = {node.name: k for k, node in enumerate(model.nodes)}
    rods: list[RodMesh] = []
    notes: list[str] = []
    by_layout: dict[Layout, list[int]] = {}
    station = 0
    firsts: list[int] = []
    locals_: list[Ints] = []
    meshes = mesh_rods(model.rods)
    kinds: dict[tuple[object, ...], Layout] = {}
    special = {a.rod for a in model.actuations} | {drag.rod for drag in model.drags}
    shapes: dict[tuple[int, int], Array] = {}
    for number, (rod, mesh) in enumerate(zip(model.rods, meshes, strict=True)):
        notes += mesh.notes
        index = _numbered(rod, mesh, names, positions)
        ne, nn = mesh.directors.shape[:2]
        local: Ints = np.arange(ne)[:, None] * rod.order + np.arange(nn)
        kind = (id(rod.section), rod.order, rod.points, rod.name if rod.name in special else None)
        layout = kinds.get(kind) or layout_of(rod, nn, element, model)
        kinds[kind] = layout
        if layout.eccentric:
            _refuse_eccentric(rod.name, scheme, any(isinstance(load, Gravity) for load in model.loads))
        points = layout.points
        by_layout.setdefault(layout, []).append(number)
        firsts.append(station)
        locals_.append(local)
        if (rod.order, points) not in shapes:
            shapes[rod.order, points] = at_gauss(rod.order, points)[0]
        at_nodes = np.concatenate([mesh.directors[:, :-1].reshape(-1, 3, 3), mesh.directors[-1, -1:]])
        stations = np.einsum("ga,ea->eg", shapes[rod.order, points], mesh.s[local]).ravel()
        outline = rod.section.outline
        rods.append(RodMesh(rod.name, index, mesh.s, at_nodes, rod.order, stations, station, outline))
        station += points * ne
    spread: dict[str, tuple[Ints, Array, Array, Array]] = {}
    found: list[Group] = []
    drags = {drag.rod: drag for drag in model.drags}
    for layout, which in by_layout.items():
        chosen = [(model.rods[k], meshes[k], locals_[k], rods[k].nodes) for k in which]
        directors = np.concatenate([mesh.directors for _, mesh, _, _ in chosen])
        made = parameters_of(
            [rod for rod, _, _, _ in chosen], layout, element, [mesh.s[at] for _, mesh, at, _ in chosen],
            np.concatenate([mesh.r[at] for _, mesh, at, _ in chosen]), directors, scheme.lumped, drags,
        )  # fmt: skip
        counts = [len(at) for _, _, at, _ in chosen]
        conns = [index[at] for _, _, at, index in chosen]
        at_stress = [firsts[k] + layout.points * np.arange(n) for k, n in zip(which, counts, strict=True)]
        own_weight = layout.eccentric and isinstance(element, DirectorElement)  # others are refused where there is any
        begin = 0
        for (rod, mesh, _, _), conn, n in zip(chosen, conns, counts, strict=True):
            part, begin = slice(begin, begin + n), begin + n
            lengths, masses = (a[part].reshape(-1, 1) for a in (made.lengths, made.masses))
            if layout.eccentric:  # such a rod carries its weight by itself
                masses = 0.0 * masses
            spread[rod.name] = conn.ravel(), lengths, mesh.directors.reshape(-1, 3, 3), masses
        found.append(
            Group(
                element, layout, np.concatenate(conns), made.table, np.concatenate(at_stress), made.history,
                lossy=layout.dragged and dynamic, works=layout.dragged or layout.actuated or own_weight,
                owners=tuple(name for (rod, *_), n in zip(chosen, counts, strict=True) for name in [rod.name] * n),
            )
        )  # fmt: skip
    spread = {rod.name: spread[rod.name] for rod in model.rods}
    groups = tuple(found)
    lumped = lumped_at_nodes(len(positions), groups, model, names) if scheme.lumped else np.zeros((0, 13))
    carried = scheme.static and any(g.element.rows(g.layout) for g in groups)
    r0 = np.array(positions)
    groups += attached_groups(model, scheme, names, r0, routes_of(model, names, rods))
    groups += joint_groups(model.joints, scheme, names, r0, carried)
    ends = np.unique(np.concatenate([np.zeros(0, np.int64), *(group.in_pattern.ravel() for group in groups)]))
    lengths = {name: (nodes, share[:, 0]) for name, (nodes, share, _, _) in spread.items()}
    groups = tuple(sorted((*groups, *obstacle_groups(model, scheme, lengths, ends)), key=lambda g: not g.inside))
    joints = tuple(joint.name for joint in model.joints)
    marks = marks_of(model, names, tuple(rods))
    mesh = Mesh(tuple(rods), names, r0, tuple(notes), joints, *joint_ends(model.joints, names, r0), marks=marks)
    n = len(positions)
    fixed, prescribed = supports_of(model, names, n, dynamic)
    idle = [names[name] for name in idle_rotations(model, scheme.static)]
    fixed[idle, 3:] = True
    refuse_loose(model, names, groups, fixed)
    return Discretisation(
        model,
        mesh,
        groups,
        pattern_of(n + len(model.joints), groups),
        fixed,
        prescribed,
        driven_joints(model, dynamic),
        (*loads_of(model, names, spread), *drives_as_loads(model, n)),
        tuple(
            rod.section.along(mesh.stations / rod.curve.length) if rod.section.varies else rod.section
            for rod, mesh in zip(model.rods, rods, strict=True)
        ),
        lumped,
        lengths,
        near_of(model, mesh, scheme),
        sources_of(model, groups, scheme),
        drives_of(model, groups, rods),
    )


def _numbered(rod: Rod, mesh: RodArrays, names: dict[str, int], positions: list[Array]) -> Ints:
    """Numbers of the nodes of a rod; those that are new get a name and a position."""
    given = {0: rod.ends[0], len(mesh.s) - 1: rod.ends[1]}
    for name, fraction in rod.nodes:
        given[int(np.argmin(np.abs(mesh.s - fraction * rod.curve.length)))] = name
    index: list[int] = []
    for k, r in enumerate(mesh.r):
        known = names.get(given[k]) if k in given else None
        if known is None:
            known = len(positions)
            positions.append(r)
            if k in given:
                names[given[k]] = known
        index.append(known)
    return np.array(index, np.int64)


def _refuse_eccentric(rod: str, scheme: Scheme, heavy: bool) -> None:
    """Raises ModelError where mass off the axis has no form."""
    if scheme.lumped or scheme.rates is Rates.SPIN or not isinstance(scheme.element, DirectorElement):
        if scheme.static and not heavy:
            return
        raise ModelError(
            f"the mass of rod {rod!r} is off its axis, for which this scheme has no form",
            "use dx.Directors() or dx.EnergyMomentum(), or put the axis through the centres of mass",
        )
