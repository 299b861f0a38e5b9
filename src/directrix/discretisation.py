"""From a model to arrays: mesh, numbering, reference directors, pattern of the matrix, supports and loads.

The numbering follows the shape of the graph: rods that only ever meet end to end are a chain (block
tridiagonal); anything else is a general frame (sparse blocks). Interior nodes of elements are condensed.
"""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.actuators import value_at
from directrix.basis import gauss, lagrange
from directrix.checks import number, shown, vector
from directrix.contact_groups import Near, Pairs, contact_states, near_of, obstacle_groups
from directrix.drives import Drive, driven, drives_of
from directrix.errors import ModelError
from directrix.formulations.contact import PairElement
from directrix.formulations.layout import Layout
from directrix.free_nodes import idle_rotations, refuse_loose
from directrix.groups import (
    Group,
    attached_groups,
    layout_of,
    lumped_at_nodes,
    mesh_rod,
    parameters_of,
)
from directrix.joint_groups import joint_ends, joint_groups, unused
from directrix.model import Distributed, Force, Gravity, Model, Pressure, RigidVelocity, Vec
from directrix.result import Mesh, RodMesh
from directrix.rotations import hat
from directrix.routes import refuse_driven, routes_of
from directrix.scheme import Scheme
from directrix.section import Section
from directrix.sources import Sources, sources_of

Array = NDArray[np.float64]
Prescribed = tuple[int, Callable[[float], Array] | None, Callable[[float], Array] | None]
Ints = NDArray[np.int64]

__all__ = ["Discretisation", "LoadTerm", "Pattern", "discretise"]


@dataclass(frozen=True)
class LoadTerm:
    """A load as the solvers see it: ``value(t)`` times ``weights`` on ``nodes``, from column ``first`` on of the loads:
    0 force, 3 moment, 6 following force, 9 following moment. ``weights`` are (nodes, 1) for a vector, (nodes, 3) for a
    number that acts in directions of their own."""

    first: int
    nodes: Ints
    weights: Array
    value: Callable[[float], Array]
    constant: bool
    varies: bool
    label: str


class Pattern(NamedTuple):
    """Block rows of the condensed system. ``row`` (n,) of every node, −1 for interior ones; the blocks of a
    row are ``rowptr[row] : rowptr[row + 1]`` with block columns ``column``; ``dest`` are, element by element,
    the blocks (a, b) of its nodes in the pattern, a fastest; ``first`` is where each group of elements begins there."""

    chain: bool
    row: Ints
    node_of_row: Ints
    rowptr: Ints
    column: Ints
    diagonal: Ints
    dest: Ints
    first: tuple[int, ...]


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
    sections: tuple[Section, ...]
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
        return replace(self, groups=groups, pattern=_pattern(self.rows, groups), sources=sources)

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
        parts = [
            section.forces(strain[..., r.first_station : r.first_station + len(r.stations), :])
            for r, section in zip(self.mesh.rods, self.sections, strict=True)
        ]
        return np.concatenate([strain[..., :0, :], *parts], axis=-2)

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


def _as_function(value: Vec | Callable[[float], object], ramp: bool, what: str) -> Callable[[float], Array]:
    if not callable(value):
        given = np.asarray(value, float)
        return (lambda t: t * given) if ramp else (lambda t: given)

    def checked(t: float) -> Array:
        try:
            out = value(t)
        except Exception as error:  # whatever a user's function raises
            raise ModelError(f"{what} fails at t = {t:.6g}: {error!r}", "return three numbers for every t") from error
        return np.array(vector(out, f"{what} at t = {t:.6g}"))

    return checked


def _number_function(value: float | Callable[[float], ArrayLike], what: str) -> Callable[[float], Array]:
    if not callable(value):
        given = np.array([value])
        return lambda t: given
    return lambda t: value_at(value, 1, what, t)


def _pattern(n: int, groups: Sequence[Group]) -> Pattern:
    """Numbering and blocks for the elements of ``groups``."""
    conn = [group.in_pattern for group in groups]
    joined = conn[0]
    in_line = len(conn) == 1 and joined.shape[1] == 2 and np.array_equal(joined[1:, 0], joined[:-1, 1])
    if in_line and len(np.unique(joined)) == len(joined) + 1:
        return _in_line(n, np.append(joined[:, 0], joined[-1, 1]))
    ends = np.unique(np.concatenate([c.ravel() for c in conn]))
    near: dict[int, list[int]] = {int(k): [] for k in ends}
    for elements in conn:
        for a, b in itertools.permutations(range(elements.shape[1]), 2):
            for here, there in elements[:, [a, b]].tolist():
                if there not in near[here]:  # a tendon beside a rod joins no more than the rod does
                    near[here].append(there)
    order: list[int] = []
    seen: set[int] = set()
    for start in [k for k in near if len(near[k]) == 1]:
        k: int | None = start
        while k is not None and k not in seen:
            seen.add(k)
            order.append(k)
            k = next((m for m in near[k] if m not in seen), None)
    chain = len(order) == len(near) and all(len(m) <= 2 for m in near.values())
    if not chain:
        order = [int(k) for k in ends]
    row = np.full(n, -1, np.int64)
    row[order] = np.arange(len(order))
    if chain:
        rows = [[i - 1, i, i + 1] for i in range(len(order))]
    else:
        rows = [sorted({i, *(int(row[m]) for m in near[k])}) for i, k in enumerate(order)]
    rowptr = np.cumsum([0, *(len(r) for r in rows)])
    at = [{c: int(rowptr[i]) + j for j, c in enumerate(r)} for i, r in enumerate(rows)]
    dest = [
        [at[force][increment] for nodes in row[elements].tolist() for increment in nodes for force in nodes]
        for elements in conn
    ]
    return Pattern(
        chain,
        row,
        np.array(order, np.int64),
        rowptr.astype(np.int64),
        np.array([c for r in rows for c in r], np.int64),
        np.array([at[i][i] for i in range(len(rows))], np.int64),
        np.concatenate([np.array(d, np.int64) for d in dest]),
        tuple(itertools.accumulate((len(d) for d in dest[:-1]), initial=0)),
    )


def _in_line(n: int, order: Ints) -> Pattern:
    """The pattern of elements that follow one another along the nodes ``order``."""
    rows = np.arange(len(order))
    row = np.full(n, -1, np.int64)
    row[order] = rows
    own = 3 * rows + 1
    return Pattern(
        True, row, order, np.append(3 * rows, 3 * len(rows)), (rows[:, None] + np.arange(-1, 2)).ravel(), own,
        np.stack([own[:-1], own[:-1] + 2, own[:-1] + 1, own[1:]], -1).ravel(), (0,),
    )  # fmt: skip


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
    by_layout: dict[Layout, list[tuple[Ints, Array, Ints, Array]]] = {}
    owners: dict[Layout, list[str]] = {}
    spread: dict[str, tuple[Ints, Array, Array]] = {}
    drags = {drag.rod: drag for drag in model.drags}
    station = 0
    for rod in model.rods:
        mesh = mesh_rod(rod)
        notes += mesh.notes
        index = np.empty(len(mesh.s), np.int64)
        given = {0: rod.ends[0], len(mesh.s) - 1: rod.ends[1]}
        for name, fraction in rod.nodes:
            given[int(np.argmin(np.abs(mesh.s - fraction * rod.curve.length)))] = name
        for k, r in enumerate(mesh.r):
            known = names.get(given[k]) if k in given else None
            if known is None:
                known = len(positions)
                positions.append(r)
                if k in given:
                    names[given[k]] = known
            index[k] = known
        ne, nn = mesh.directors.shape[:2]
        local: Ints = np.arange(ne)[:, None] * rod.order + np.arange(nn)
        conn = index[local]
        layout = layout_of(rod, nn, element, model)
        points = layout.points
        parameters, weights, history = parameters_of(
            rod, layout, element, mesh.r[local], mesh.directors, scheme.lumped, drags.get(rod.name)
        )
        first: Ints = station + points * np.arange(ne)
        by_layout.setdefault(layout, []).append((conn, parameters, first, history))
        owners.setdefault(layout, []).extend([rod.name] * ne)
        spread[rod.name] = conn.ravel(), weights.reshape(-1, 1), mesh.directors.reshape(-1, 3, 3)
        shape = lagrange(rod.order, gauss(points)[0])[0]
        at_nodes = np.concatenate([mesh.directors[:, :-1].reshape(-1, 3, 3), mesh.directors[-1, -1:]])
        rods.append(
            RodMesh(
                rod.name, index, mesh.s, at_nodes, rod.order,
                np.einsum("ga,ea->eg", shape, mesh.s[local]).ravel(), station, rod.section.outline,
            )
        )  # fmt: skip
        station += points * ne
    groups = tuple(
        Group(
            element,
            layout,
            *(np.concatenate([part[k] for part in parts]) for k in range(4)),  # type: ignore[arg-type]
            lossy=layout.dragged and dynamic,
            works=layout.dragged or layout.actuated,
            owners=tuple(owners[layout]),
        )
        for layout, parts in by_layout.items()
    )
    lumped = lumped_at_nodes(len(positions), groups, model, names) if scheme.lumped else np.zeros((0, 13))
    carried = scheme.static and any(g.element.rows(g.layout) for g in groups)
    r0 = np.array(positions)
    groups += attached_groups(model, scheme, names, r0, routes_of(model, names, rods))
    groups += joint_groups(model.joints, scheme, names, r0, carried)
    ends = np.unique(np.concatenate([group.in_pattern.ravel() for group in groups]))
    lengths = {name: (nodes, share[:, 0]) for name, (nodes, share, _) in spread.items()}
    groups = tuple(sorted((*groups, *obstacle_groups(model, scheme, lengths, ends)), key=lambda g: not g.inside))
    joints = tuple(joint.name for joint in model.joints)
    mesh = Mesh(tuple(rods), names, r0, tuple(notes), joints, *joint_ends(model.joints, names, r0))
    n = len(positions)
    fixed, prescribed = _supports(model, names, n, dynamic)
    idle = [names[name] for name in idle_rotations(model, scheme.static)]
    fixed[idle, 3:] = True
    refuse_loose(model, names, groups, fixed)
    return Discretisation(
        model,
        mesh,
        groups,
        _pattern(n + len(model.joints), groups),
        fixed,
        prescribed,
        _driven(model, dynamic),
        (*_loads(model, names, spread), *_drives(model, n)),
        tuple(rod.section for rod in model.rods),
        lumped,
        lengths,
        near_of(model, mesh, scheme),
        sources_of(model, groups, scheme),
        drives_of(model, groups, rods),
    )


def _supports(
    model: Model, names: dict[str, int], n: int, dynamic: bool
) -> tuple[NDArray[np.bool_], tuple[Prescribed, ...]]:
    fixed = np.zeros((n, 6), bool)
    for support in model.supports:
        for dof in support.dofs:
            fixed[names[support.node], ("x", "y", "z", "rx", "ry", "rz").index(dof)] = True
    prescribed: list[Prescribed] = []
    for given in model.prescribed:
        k = names[given.node]
        functions: list[Callable[[float], Array] | None] = []
        for part, value in ((slice(0, 3), given.displacement), (slice(3, 6), given.rotation)):
            if value is not None:
                fixed[k, part] = True
            what = f"the prescribed {'displacement' if part.start == 0 else 'rotation'} of node {given.node!r}"
            functions.append(None if value is None else _as_function(value, not dynamic, what))
        prescribed.append((k, functions[0], functions[1]))
    return fixed, tuple(prescribed)


def _driven(model: Model, dynamic: bool) -> tuple[tuple[int, Callable[[float], float]], ...]:
    out: list[tuple[int, Callable[[float], float]]] = []
    for j, joint in enumerate(model.joints):
        if joint.prescribed is not None:
            out.append(
                (j, _scalar(joint.prescribed, not dynamic, f"the prescribed coordinate of joint {joint.name!r}"))
            )
    return tuple(out)


def _scalar(value: float | Callable[[float], object], ramp: bool, what: str) -> Callable[[float], float]:
    if not callable(value):
        given = number(value, what)
        return (lambda t: t * given) if ramp else (lambda t: given)

    def checked(t: float) -> float:
        try:
            out = value(t)
        except Exception as error:  # whatever a user's function raises
            raise ModelError(f"{what} fails at t = {t:.6g}: {error!r}", "return a number for every t") from error
        return number(out, f"{what} at t = {t:.6g}")

    return checked


def _drives(model: Model, n: int) -> list[LoadTerm]:
    """Drives of joints as loads in the first column of the followers."""
    terms: list[LoadTerm] = []
    for j, joint in enumerate(model.joints):
        if joint.drive is None:
            continue
        what = f"the drive of joint {joint.name!r}"
        value = _scalar(joint.drive, False, what)
        terms.append(
            LoadTerm(
                6, np.array([n + j]), np.ones((1, 1)), lambda t, f=value: np.array([f(t), 0.0, 0.0]), False,
                callable(joint.drive), what,
            )
        )  # fmt: skip
    return terms


def _loads(model: Model, names: dict[str, int], spread: dict[str, tuple[Ints, Array, Array]]) -> tuple[LoadTerm, ...]:
    terms: list[LoadTerm] = []
    for load in model.loads:
        if isinstance(load, Pressure):
            nodes, weights, directors = spread[load.rod]
            side = directors[:, :, int(load.along[-1]) - 1] * (-1.0 if load.along.startswith("-") else 1.0)
            what = f"the pressure on rod {load.rod!r}"
            value = _number_function(load.value, what)
            terms.append(
                LoadTerm(6, nodes, load.width * weights * side, value, load.constant, callable(load.value), what)
            )
            continue
        if isinstance(load, Gravity):
            over = [(spread[rod.name][0], rod.section.A_rho * spread[rod.name][1]) for rod in model.rods]
            over += [(np.array([names[body.node]]), np.array([[body.mass]])) for body in model.bodies]
            what, first = "gravity", 0
        elif isinstance(load, Distributed):
            over, what = [spread[load.rod][:2]], f"the distributed load on rod {load.rod!r}"
            first = 6 if load.follower else 0
        else:
            kind = "force" if isinstance(load, Force) else "moment"
            over, what = [(np.array([names[load.node]]), np.ones((1, 1)))], f"the {kind} on node {load.node!r}"
            first = (0 if kind == "force" else 3) + (6 if load.follower else 0)
        value = _as_function(load.value, False, what)
        terms += [LoadTerm(first, nodes, w, value, load.constant, callable(load.value), what) for nodes, w in over]
    return tuple(terms)
