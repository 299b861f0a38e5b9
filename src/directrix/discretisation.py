"""From a model to arrays: mesh, numbering, reference directors, pattern of the matrix, supports and loads.

The numbering follows the shape of the graph: rods that only ever meet end to end are a chain (block
tridiagonal); anything else is a general frame (sparse blocks). Interior nodes of elements are condensed.
"""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss, lagrange
from directrix.checks import shown, vector
from directrix.errors import ModelError
from directrix.formulations.attached import AttachedLayout, BodyElement, LinkElement
from directrix.formulations.element import Committed, Element
from directrix.formulations.layout import Layout
from directrix.model import Distributed, Force, Gravity, Model, RigidVelocity, Rod, Vec
from directrix.result import Mesh, RodMesh
from directrix.rotations import hat, smallest_rotation
from directrix.scheme import Rates, Scheme
from directrix.section import Section

Array = NDArray[np.float64]
Prescribed = tuple[int, Callable[[float], Array] | None, Callable[[float], Array] | None]
Ints = NDArray[np.int64]

__all__ = ["Discretisation", "Group", "LoadTerm", "Pattern", "discretise"]


@dataclass(frozen=True)
class Group:
    """Elements that share one kernel: ``conn`` (ne, nn) nodes, ``parameters`` (ne, size),
    ``station`` (ne,) index of their first stress point, ``history`` (ne, 12 rows) in the reference.

    What is attached to rods has ``names``; it is ``lossy`` when it dissipates by itself, ``grounded`` when the ground
    holds its other end.
    """

    element: Element
    layout: Layout
    conn: Ints
    parameters: Array
    station: Ints
    history: Array
    names: tuple[str, ...] = ()
    lossy: bool = False
    grounded: bool = False


@dataclass(frozen=True)
class LoadTerm:
    """A load as the solvers see it: ``value(t)`` times ``weights`` on ``nodes``, from column ``first`` on of the loads:
    0 force, 3 moment, 6 following force, 9 following moment."""

    first: int
    nodes: Ints
    weights: Array
    value: Callable[[float], Array]
    constant: bool
    varies: bool
    label: str


class Pattern(NamedTuple):
    """Block rows of the condensed system. ``row`` (n,) of every node, −1 for interior ones; the blocks of a
    row are ``rowptr[row] : rowptr[row + 1]`` with block columns ``column``; ``dest`` (elements, 4) are the
    blocks (a, a), (b, a), (a, b), (b, b) of an element's ends."""

    chain: bool
    row: Ints
    node_of_row: Ints
    rowptr: Ints
    column: Ints
    diagonal: Ints
    dest: Ints


@dataclass(frozen=True)
class Discretisation:
    """Everything the solvers read. ``fixed`` (n, 6) marks components held by supports or prescribed motion;
    ``prescribed`` pairs a node with its displacement and rotation functions."""

    model: Model
    mesh: Mesh
    groups: tuple[Group, ...]
    pattern: Pattern
    fixed: NDArray[np.bool_]
    prescribed: tuple[Prescribed, ...]
    loads: tuple[LoadTerm, ...]
    sections: tuple[Section, ...]
    lumped: Array
    """(n, 13): mass, principal values (3) and vectors (9) of the Euler dyadic of every node, all of it lumped there."""

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.mesh.r0)

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
        """Size of the model, the diagonal of its box."""
        return float(np.linalg.norm(np.ptp(self.mesh.r0, axis=0)))

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
        """Loads (n, 12) at time t: forces and moments, then those that turn with their node, in its frame.

        Those not marked constant are multiplied by ``factor``.
        """
        out = np.zeros((self.nodes, 12))
        for load in self.loads:
            value = load.value(t) * (1.0 if load.constant else factor)
            np.add.at(out[:, load.first : load.first + 3], load.nodes, load.weights[:, None] * value)
        return out

    def section_force(self, strain: Array) -> Array:
        """Section forces (…, stations, 6) from strains (…, stations, 6)."""
        parts = [
            section.forces(strain[..., r.first_station : r.first_station + len(r.stations), :])
            for r, section in zip(self.mesh.rods, self.sections, strict=True)
        ]
        return np.concatenate(parts, axis=-2)

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
        return v, omega


def rates_of(rotation: Array, omega: Array) -> Array:
    """dR/dt = ω̂ R, (n, 3, 3)."""
    return hat(omega) @ rotation


def _boundaries(rod: Rod) -> tuple[Array, list[str]]:
    """Arclengths of the element ends; kinks and named nodes get one, and the sentence that says so."""
    length = rod.curve.length
    wanted = sorted({*rod.curve.breaks, *(f * length for _, f in rod.nodes)})
    uniform = np.linspace(0.0, length, rod.elements + 1)
    if all(np.min(np.abs(uniform - s)) <= 1e-9 * length for s in wanted):
        return uniform, []
    cuts = np.array([0.0, *wanted, length])
    cuts = cuts[np.concatenate(([True], np.diff(cuts) > 1e-9 * length))]
    spans = np.diff(cuts)
    share = spans / length * rod.elements
    counts = np.maximum(1, np.floor(share).astype(int))
    while counts.sum() < rod.elements:
        counts[np.argmax(share - counts)] += 1
    ends = zip(cuts[:-1].tolist(), cuts[1:].tolist(), counts.tolist(), strict=True)
    s = np.concatenate([np.linspace(a, b, k, endpoint=False) for a, b, k in ends])
    lengths = spans / counts
    note = (
        f"rod '{rod.name}': the mesh was fitted to {len(wanted)} kinks or named nodes; "
        f"{counts.sum()} elements between {lengths.min():.4g} and {lengths.max():.4g} long"
    )
    return np.append(s, length), [note]


class _RodArrays(NamedTuple):
    s: Array  # (m,)
    r: Array  # (m, 3)
    directors: Array  # (ne, nn, 3, 3)
    notes: list[str]


def _mesh_rod(rod: Rod) -> _RodArrays:
    ends, notes = _boundaries(rod)
    p, ne = rod.order, len(ends) - 1
    xi = np.linspace(0.0, 1.0, p + 1)
    s = ends[:-1, None] + xi * np.diff(ends)[:, None]
    middle = np.broadcast_to(0.5 * (ends[:-1] + ends[1:])[:, None], s.shape)
    r = rod.curve.position(s)
    directors = rod.curve.frames(s, middle)
    if rod.curve.directors == "chord":
        chord = r[:, -1] - r[:, 0]
        r = r[:, :1] + xi[:, None] * chord[:, None]
        frame = rod.curve.frames(middle[:, 0], middle[:, 0])
        unit = chord / np.linalg.norm(chord, axis=1, keepdims=True)
        frame = smallest_rotation(frame[:, :, 2], unit) @ frame
        directors = np.broadcast_to(frame[:, None], (ne, p + 1, 3, 3))
    nodes = np.append(r[:, :-1].reshape(-1, 3), r[-1, -1:], axis=0)
    return _RodArrays(np.append(s[:, :-1].ravel(), s[-1, -1]), nodes, directors, notes)


def _parameters(
    rod: Rod, layout: Layout, element: Element, r: Array, directors: Array, lumped: bool
) -> tuple[Array, Array, Array]:
    """Element parameters (ne, size) in the order of :class:`Layout`, ∫N_a dS (ne, nn), history (ne, 12 rows).

    ``r`` (ne, nn, 3) reference positions, ``directors`` (ne, nn, 3, 3) with columns d1, d2, d3.
    """
    ne, nn, order = len(r), layout.nn, layout.nn - 1
    section = rod.section

    def speed(points: int) -> tuple[Array, Array, Array]:
        xi, w = gauss(points)
        n, dn = lagrange(order, xi)
        return w, n, np.linalg.norm(np.einsum("ga,eai->egi", dn, r), axis=2)

    _, _, j = speed(layout.points)
    w, n, jm = speed(order + 1)
    weights = np.einsum("g,eg,ga->ea", w, jm, n)
    mass = np.einsum("ea,ab->eab", weights, np.eye(nn)) if lumped else np.einsum("g,eg,ga,gb->eab", w, jm, n, n)
    pairs = mass[:, *np.triu_indices(nn)]
    q = [[list(r[:, a].T)] + [list(directors[:, a, :, i].T) for i in range(3)] for a in range(nn)]
    e0 = element.reference(layout, q, list(1.0 / j.T))
    history = np.zeros((ne, 0))
    if element.rows(layout):
        history = np.stack(cast(Committed, element).initial(layout, q), -1)
    c, inertia = section.stiffness, section.I_rho
    stiff = np.diag(c) if layout.principal else c[np.triu_indices(6)]
    masses = [section.A_rho, inertia[0, 0], inertia[1, 1]] + ([] if layout.principal else [inertia[0, 1]])
    viscous = section.damping
    damping = {"none": np.zeros(0), "principal": np.diag(viscous), "full": viscous[np.triu_indices(6)]}[layout.damping]
    table = [
        # place() reads the components of d_i one director after the other
        directors.transpose(0, 1, 3, 2).reshape(ne, 9 * nn),
        np.broadcast_to(stiff, (ne, len(stiff))),
        1.0 / j,
        np.stack([np.stack(e, -1) for e in e0], 1).reshape(ne, -1),
        pairs,
        np.broadcast_to(masses, (ne, len(masses))),
        np.broadcast_to(damping, (ne, len(damping))),
        jm if layout.sampled else np.zeros((ne, 0)),
    ]
    return np.concatenate(table, axis=1), weights, history


def _layout(rod: Rod, nn: int, element: Element) -> Layout:
    section = rod.section
    c, viscous, inertia = section.stiffness, section.damping, section.I_rho
    principal = not np.any(c - np.diag(np.diag(c))) and inertia[0, 1] == 0.0
    damping = "none"
    if np.any(viscous):
        damping = "full" if np.any(viscous - np.diag(np.diag(viscous))) else "principal"
    return Layout(nn, rod.points or rod.order, principal, damping, section.law, element.sampled)


def _lumped(n: int, groups: Sequence[Group], model: Model, names: dict[str, int]) -> Array:
    """See :class:`Discretisation`; the mass of the groups must be lumped."""
    out, dyadic = np.zeros((n, 13)), np.zeros((n, 3, 3))
    for group in groups:
        columns: Any = group.parameters.T
        nn = group.layout.nn
        parts: list[Array] = [np.asarray(p).T for p in group.layout.split(columns)]
        directors = parts[0].reshape(-1, nn, 3, 3)  # [element, node, director, component]
        for a in range(nn):
            weight = parts[4][:, a * nn - a * (a - 1) // 2]
            np.add.at(out[:, 0], group.conn[:, a], weight * parts[5][:, 0])
            euler = np.zeros((len(weight), 2, 2))
            euler[:, 0, 0], euler[:, 1, 1] = parts[5][:, 1], parts[5][:, 2]
            if parts[5].shape[1] > 3:
                euler[:, 0, 1] = euler[:, 1, 0] = parts[5][:, 3]
            d = directors[:, a, :2]
            np.add.at(dyadic, group.conn[:, a], np.einsum("e,epq,epi,eqj->eij", weight, euler, d, d))
    for body in model.bodies:
        out[names[body.node], 0] += body.mass
        dyadic[names[body.node]] += body.euler
    values, vectors = np.linalg.eigh(dyadic)
    small = values.max(axis=1, initial=0.0, keepdims=True) * 1e-14
    out[:, 1:4] = np.where(values > small, values, 0.0)
    out[:, 4:] = vectors.transpose(0, 2, 1).reshape(n, 9)
    return out


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


def _pattern(n: int, elements: Sequence[tuple[int, int]]) -> Pattern:
    """Numbering and blocks for elements that join the nodes (a, b)."""
    ends = np.unique(np.array(elements, np.int64).ravel())
    near: dict[int, list[int]] = {int(k): [] for k in ends}
    for a, b in elements:
        if a != b:
            near[a].append(b)
            near[b].append(a)
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
        (at[ra][ra], at[rb][ra], at[ra][rb], at[rb][rb]) for ra, rb in ((int(row[a]), int(row[b])) for a, b in elements)
    ]
    return Pattern(
        chain,
        row,
        np.array(order, np.int64),
        rowptr.astype(np.int64),
        np.array([c for r in rows for c in r], np.int64),
        np.array([at[i][i] for i in range(len(rows))], np.int64),
        np.array(dest, np.int64),
    )


def discretise(model: Model, scheme: Scheme) -> Discretisation:
    """Mesh the model and number its unknowns; raises ModelError for a model that cannot be solved."""
    if not isinstance(model, Model):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"{shown(model)} is not a model", "start from dx.Model() and add rods")
    element, dynamic = scheme.element, not scheme.static
    model.check(**({"dynamic": True} if dynamic else {"static": True}))
    names: dict[str, int] = {}
    positions: list[Array] = []
    rods: list[RodMesh] = []
    notes: list[str] = []
    by_layout: dict[Layout, list[tuple[Ints, Array, Ints, Array]]] = {}
    spread: dict[str, tuple[Ints, Array]] = {}
    station = 0
    for rod in model.rods:
        mesh = _mesh_rod(rod)
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
        layout = _layout(rod, nn, element)
        points = layout.points
        parameters, weights, history = _parameters(rod, layout, element, mesh.r[local], mesh.directors, scheme.lumped)
        first: Ints = station + points * np.arange(ne)
        by_layout.setdefault(layout, []).append((conn, parameters, first, history))
        spread[rod.name] = conn.ravel(), weights.ravel()
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
        Group(element, layout, *(np.concatenate([part[k] for part in parts]) for k in range(4)))  # type: ignore[arg-type]
        for layout, parts in by_layout.items()
    )
    lumped = _lumped(len(positions), groups, model, names) if scheme.lumped else np.zeros((0, 13))
    groups += attached_groups(model, scheme, names, np.array(positions))
    mesh = Mesh(tuple(rods), names, np.array(positions), tuple(notes))
    n = len(positions)
    fixed, prescribed = _supports(model, names, n, dynamic)
    return Discretisation(
        model,
        mesh,
        groups,
        _pattern(n, [(int(c[0]), int(c[-1])) for g in groups for c in g.conn]),
        fixed,
        prescribed,
        _loads(model, names, spread),
        tuple(rod.section for rod in model.rods),
        lumped,
    )


def attached_groups(model: Model, scheme: Scheme, names: dict[str, int], r0: Array) -> tuple[Group, ...]:
    """Links and bodies as elements of their own; raises ModelError for what the scheme has no form for."""
    groups: list[Group] = []
    places = {name: r0[k] for name, k in names.items()}
    for grounded, cable in ((True, False), (False, False), (True, True), (False, True)):
        links = [k for k in model.links if k.cable == cable and isinstance(k.b, str) != grounded]
        if not links:
            continue
        rows: list[list[float]] = []
        for link in links:
            if link.damping and scheme.rates is Rates.ALPHA:
                raise ModelError(
                    f"link {link.name!r} is damped, and the generalised-α family has no form for that",
                    "use a step of the midpoint family, e.g. dx.EnergyMomentum(), or leave damping= out",
                )
            rest, width = link.measures(places)
            other = link.offset_b if isinstance(link.b, str) else link.b
            rows.append([*link.offset_a, *other, link.stiffness, rest, link.damping, width])
        ends = [[names[k.a]] if grounded else [names[k.a], names[str(k.b)]] for k in links]
        groups.append(
            _attached(
                LinkElement(scheme.rates, cable), np.array(ends), np.array(rows),
                tuple(f"link {k.name!r}" for k in links),
                not scheme.static and scheme.rates is not Rates.ALPHA and any(k.damping for k in links), grounded,
            )
        )  # fmt: skip
    if model.bodies and scheme.rates is Rates.SPIN:
        raise ModelError(
            f"the body on node {model.bodies[0].node!r} has no form in SimoTarnowDoblare()",
            "use another step, e.g. dx.EnergyMomentum()",
        )
    if model.bodies and not scheme.static:
        rows = [[body.mass, *body.euler[np.triu_indices(3)]] for body in model.bodies]
        ends = np.array([[names[body.node]] for body in model.bodies])
        labels = tuple(f"the body on node {body.node!r}" for body in model.bodies)
        groups.append(_attached(BodyElement(scheme.rates), ends, np.array(rows), labels))
    return tuple(groups)


def _attached(
    element: LinkElement | BodyElement, conn: Ints, parameters: Array, names: tuple[str, ...], lossy: bool = False,
    grounded: bool = False,
) -> Group:  # fmt: skip
    count = len(conn)
    layout = AttachedLayout(conn.shape[1], 0, True, parameters=parameters.shape[1])
    nothing: Ints = np.zeros(count, np.int64)
    return Group(element, layout, conn, parameters, nothing, np.zeros((count, 0)), names, lossy, grounded)


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


def _loads(model: Model, names: dict[str, int], spread: dict[str, tuple[Ints, Array]]) -> tuple[LoadTerm, ...]:
    terms: list[LoadTerm] = []
    for load in model.loads:
        if isinstance(load, Gravity):
            over = [(spread[rod.name][0], rod.section.A_rho * spread[rod.name][1]) for rod in model.rods]
            over += [(np.array([names[body.node]]), np.array([body.mass])) for body in model.bodies]
            what, first = "gravity", 0
        elif isinstance(load, Distributed):
            over, what, first = [spread[load.rod]], f"the distributed load on rod {load.rod!r}", 0
        else:
            kind = "force" if isinstance(load, Force) else "moment"
            over, what = [(np.array([names[load.node]]), np.ones(1))], f"the {kind} on node {load.node!r}"
            first = (0 if kind == "force" else 3) + (6 if load.follower else 0)
        value = _as_function(load.value, False, what)
        terms += [LoadTerm(first, nodes, w, value, load.constant, callable(load.value), what) for nodes, w in over]
    return tuple(terms)
