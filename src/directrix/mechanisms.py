"""Which parts of a model can move: mechanisms, found on rigid motions and the tangents of what holds them.

Rods cannot deform without force, so what moves freely is made of rods that move as rigid bodies: six unknowns for each
part of rigidly joined rods, whatever the mesh, the stiffness or the units. Supports and the tangents of what is
attached (links, joints) at a state are the equations; a stressed state adds the tangent of the rods. Rows of unknowns
behind the nodes are multipliers: their equations are constraints.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation
from directrix.motions import Part
from directrix.newton import Newton
from directrix.tangents import group_tangents

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
FEW = 200  # unknowns up to which singular values are asked, beyond them their squares
SQUARED = 1e-12  # as NOTHING, of squares, which tell less
NOTHING = 1e-9  # of what an equation can be: below it nothing is held

__all__ = ["Cluster", "Equations", "clusters", "equations_of", "parts_of", "stress_equations"]


@dataclass(frozen=True, eq=False)
class Cluster:
    """Parts that move together: ``free`` (6 parts, k) are their independent motions that nothing holds; ``ties`` name
    what is attached between them or to the ground."""

    parts: tuple[Part, ...]
    free: Array
    ties: tuple[str, ...]

    def nodal(self, rows: int) -> Array:
        """(rows, 6, k): displacement and turn of every node of the model in the free motions, and behind them nothing
        of the multipliers."""
        out = np.zeros((rows, 6, self.free.shape[1]))
        for part, q in zip(self.parts, np.split(self.free, len(self.parts)), strict=True):
            out[part.nodes] = part.moved() @ q
            out[part.nodes, 3:] /= part.size
        return out


@dataclass(frozen=True, eq=False)
class Equations:
    """Rows that motions must satisfy: ``rows`` (m, 6 parts of ``parts``), indices into all parts."""

    parts: tuple[int, ...]
    rows: Array
    name: str = ""


def parts_of(disc: Discretisation, x: Array) -> tuple[Part, ...]:
    """The rigidly joined parts at the state ``x``."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = [np.zeros((0, 2), np.int64)]
    pairs += [g.conn[:, [a, a + 1]] for g in disc.groups if not g.names for a in range(g.layout.nn - 1)]
    i, j = np.concatenate(pairs).T
    n = disc.nodes
    _, label = connected_components(coo_matrix((np.ones(len(i)), (i, j)), shape=(n, n)), directed=False)
    members: dict[int, list[str]] = {}
    nodes: dict[int, list[Ints]] = {}
    for rod in disc.mesh.rods:
        at = int(label[rod.nodes[0]])
        members.setdefault(at, []).append(rod.name)
        nodes.setdefault(at, []).append(rod.nodes)
    out: list[Part] = []
    for at, names in members.items():
        own = np.unique(np.concatenate(nodes[at]))
        r = x[own, :3].copy()
        low, high = r.min(axis=0), r.max(axis=0)
        out.append(Part(tuple(names), own, r, 0.5 * (low + high), float(np.linalg.norm(high - low))))
    for node in disc.model.nodes:
        own = np.array([disc.mesh.node_names[node.name]])
        if int(label[own[0]]) not in members:
            out.append(Part((node.name,), own, x[own, :3].copy(), x[own[0], :3].copy(), disc.length, alone=True))
    return tuple(out)


def clusters(parts: tuple[Part, ...], equations: Sequence[Equations]) -> list[Cluster]:
    """Parts that can move, with their free motions; those that equations tie together are one cluster."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    held = _settled(parts, equations)
    loose = [k for k in range(len(parts)) if not held[k]]
    place = {part: k for k, part in enumerate(loose)}
    left = [e for e in equations if any(p in place for p in e.parts)]
    pairs = [(place[a], place[b]) for e in left for a in e.parts for b in e.parts if a in place and b in place]
    i, j = np.array(pairs, np.int64).reshape(-1, 2).T
    count, label = connected_components(
        coo_matrix((np.ones(len(i)), (i, j)), shape=(len(loose), len(loose))), directed=False
    )
    out: list[Cluster] = []
    for c in range(count):
        own = [k for k in loose if label[place[k]] == c]
        at = {part: k for k, part in enumerate(own)}
        mine = [e for e in left if any(p in at for p in e.parts)]
        free = _null_space(_stacked(mine, at))
        if free.shape[1]:
            moving = [k for k in range(len(own)) if np.abs(free[6 * k : 6 * k + 6]).max() > 1e-6]
            rows = (6 * np.array(moving)[:, None] + np.arange(6)).ravel()
            ties = tuple(dict.fromkeys(e.name for e in mine if e.name))
            out.append(Cluster(tuple(parts[own[k]] for k in moving), free[rows], ties))
    return out


def _settled(parts: tuple[Part, ...], equations: Sequence[Equations]) -> list[bool]:
    """Parts that supports, and what ties them to parts so held, hold by themselves: most of them in most models."""
    held = [False] * len(parts)
    of: dict[int, list[Equations]] = {k: [] for k in range(len(parts))}
    for e in equations:
        for p in e.parts:
            of[p].append(e)
    again = set(range(len(parts)))
    while again:
        k = again.pop()
        mine = [e for e in of[k] if all(p == k or held[p] for p in e.parts)]
        if held[k] or not mine:
            continue
        s = np.linalg.svd(_stacked(mine, {k: 0}), compute_uv=False)
        if len(s) >= 6 and s[5] > 1e-3:
            held[k] = True
            again |= {p for e in of[k] for p in e.parts if not held[p]}
    return held


def _stacked(equations: Sequence[Equations], at: dict[int, int]) -> Array:
    """The equations (rows, 6 parts) on the parts ``at`` has a place for; the others stay where they are."""
    out = np.zeros((max(1, sum(len(e.rows) for e in equations)), 6 * len(at)))
    first = 0
    for e in equations:
        last = first + len(e.rows)
        for k, part in enumerate(e.parts):
            if part in at:
                out[first:last, 6 * at[part] : 6 * at[part] + 6] += e.rows[:, 6 * k : 6 * k + 6]
        first = last
    return out


def _null_space(rows: Array) -> Array:
    """Orthonormal motions (columns) that satisfy ``rows`` (m, n)."""
    from scipy.sparse import csc_matrix, identity
    from scipy.sparse.linalg import splu

    n = rows.shape[1]
    if n <= FEW:
        _, s, vt = np.linalg.svd(_triangle(rows))
        return vt[int(np.sum(s > NOTHING)) :].T
    sparse = csc_matrix(rows)
    gram = csc_matrix(sparse.T @ sparse)
    factored, random, count = splu(csc_matrix(gram + 1e-15 * identity(n))), np.random.default_rng(0), 8
    while True:  # the smallest eigenvalues, by inverse iteration, until one of them is none
        block = random.standard_normal((n, count))
        for _ in range(6):
            block = np.linalg.qr(factored.solve(block))[0]
        values, vectors = np.linalg.eigh(block.T @ (gram @ block))
        if values[-1] > SQUARED or count == n:
            return block @ vectors[:, values <= SQUARED]
        count = min(2 * count, n)


def equations_of(newton: Newton, x: Array, parts: tuple[Part, ...]) -> list[Equations]:
    """Everything that holds parts, each row about as large as one at most."""
    disc = newton.disc
    moved, owner, size = _motions(disc, parts)
    out: list[Equations] = []
    held = np.array(np.nonzero(disc.fixed)).T
    for k in range(len(parts)):
        mine = held[owner[held[:, 0]] == k]
        if len(mine):
            out.append(Equations((k,), _triangle(moved[mine[:, 0], mine[:, 1]])))
    for g, group in enumerate(disc.groups):
        if group.names:
            least = _least(disc) if group.jointed else 0.0  # multipliers that are round-off hold nothing
            tangents = group_tangents(newton, x, g, symmetric=False)
            for e, (conn, tangent) in enumerate(zip(group.conn, tangents, strict=True)):
                rows, at = _tie(conn, tangent, moved, owner, size, least)
                if len(rows):
                    out.append(Equations(at, rows, group.names[e]))
    return out


def _motions(disc: Discretisation, parts: tuple[Part, ...]) -> tuple[Array, Ints, Array]:
    """For every row: (rows, 6, 6) displacement and scaled turn in the motions of its part, the part (−1: multipliers),
    and the size that its turns are scaled with."""
    n = disc.rows
    moved, owner, size = np.zeros((n, 6, 6)), np.full(n, -1), np.ones(n)
    for k, part in enumerate(parts):
        moved[part.nodes], owner[part.nodes], size[part.nodes] = part.moved(), k, part.size
    return moved, owner, size


def _triangle(rows: Array) -> Array:
    """Rows that say the same, no more of them than columns."""
    return np.asarray(np.linalg.qr(rows, mode="r")) if len(rows) > rows.shape[1] else rows


def _least(disc: Discretisation) -> float:
    axial = max((float(section.stiffness[2, 2]) for section in disc.sections), default=0.0)
    return 1e-13 * axial / disc.length


def _tie(
    conn: Ints, tangent: Array, moved: Array, owner: Ints, size: Array, least: float
) -> tuple[Array, tuple[int, ...]]:
    """Rows (m, 6 parts) of one attached element, and the parts: it does not resist motions that they vanish for.

    Forces and moments are measured by the largest stiffness of the element, if that is more than ``least``,
    constraints by their largest entry.
    """
    nn = len(conn)
    turns = np.concatenate([np.ones((nn, 3)), np.repeat(1.0 / size[conn][:, None], 3, axis=1)], axis=1).ravel()
    real = np.repeat(owner[conn] >= 0, 6)
    forces = (0.5 * (tangent + tangent.T) * turns[:, None] * turns)[real][:, real]
    largest = np.abs(forces).max(initial=0.0)
    stacked = _constraints(conn, tangent, owner, size)
    if largest > least:
        stacked = np.concatenate([stacked, forces / largest])
    at = tuple(dict.fromkeys(int(p) for p in owner[conn] if p >= 0))
    out = np.zeros((len(stacked), 6 * len(at)))
    for a, node in enumerate(conn[owner[conn] >= 0]):
        k = at.index(int(owner[node]))
        out[:, 6 * k : 6 * k + 6] += stacked[:, 6 * a : 6 * a + 6] @ moved[node]
    return _triangle(out), at


def _constraints(conn: Ints, tangent: Array, owner: Ints, size: Array) -> Array:
    """Rows (m, 6 places) of the multipliers of an element over the unknowns of its places, largest entry one."""
    real = owner[conn] >= 0
    turns = np.ones((int(real.sum()), 6))
    turns[:, 3:] /= size[conn[real]][:, None]
    rows = tangent[np.repeat(~real, 6)][:, np.repeat(real, 6)] * turns.ravel()
    scale = np.abs(rows).max(axis=1, initial=0.0)
    return rows[scale > 0.0] / scale[scale > 0.0, None]


def stress_equations(newton: Newton, x: Array, parts: tuple[Part, ...]) -> list[Equations]:
    """What the forces in the rods resist: the assembled tangent on the free components of their nodes."""
    disc = newton.disc
    moved, owner, size = _motions(disc, parts)
    n = len(owner)
    force, scale = np.zeros((n, 6, 6)), np.zeros(n)
    for g, group in enumerate(disc.groups):
        if group.names:
            continue
        tangents = group_tangents(newton, x, g)
        nn = group.layout.nn
        given = moved[group.conn].copy()
        given[:, :, 3:] /= size[group.conn][:, :, None, None]
        pushed = (tangents @ given.reshape(len(given), 6 * nn, 6)).reshape(-1, nn, 6, 6)
        np.add.at(force, group.conn, pushed)
        largest = np.abs(tangents.reshape(-1, nn, 6, nn, 6)[:, :, :3, :, :3]).max(axis=(1, 2, 3, 4))
        np.maximum.at(scale, group.conn, largest[:, None])
    force[:, 3:] /= size[:, None, None]
    out: list[Equations] = []
    for k, part in enumerate(parts):
        rows = force[part.nodes] / scale[part.nodes, None, None]
        out.append(Equations((k,), _triangle(rows[~disc.fixed[part.nodes]])))
    return out
