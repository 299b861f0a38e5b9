"""The fast way through a motion: chains of equal elements, solved in SIMD lanes, many steps a call.

What it computes is what :mod:`directrix.newton` computes, up to rounding; which models qualify says :func:`strips_for`.
Everything else, and every step that does not converge here, takes the general way.
"""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation
from directrix.formulations.directors import DirectorStep
from directrix.formulations.layout import PER_NODE
from directrix.groups import Group
from directrix.kernels import rows
from directrix.kernels import strips as kernel
from directrix.kernels.compile import LANES
from directrix.kernels.strip_steps import pack, unpack
from directrix.scheme import Rates, Scheme
from directrix.strip import Loads, Shots, Strip, code_of, largest_of, steps_at_once, strip_of, work_for

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Strips", "chain_of", "frames_of", "nodes_of", "parameters_of", "strips_for"]

FEWEST = 8
"""Elements from which on lanes are used."""
ALIGNED = 1e-14  # directors of neighbouring elements that differ by less are one frame


class Part(NamedTuple):
    """Where the lanes of a strip come from: ``nodes`` (stride · elements + 1, LANES), ``members`` (elements, LANES)."""

    strip: Strip
    nodes: Ints
    members: Ints


def chain_of(disc: Discretisation, scheme: Scheme, damped: bool) -> Ints | None:
    """The elements of a model in the order of its chain, or None where it does not go through lanes.

    That takes one chain of linear or quadratic elements of one kind that all point one way, a midpoint step without
    damping, supports that stay and loads that keep their direction."""
    if scheme.rates is not Rates.MIDPOINT or damped or disc.prescribed or disc.drives or disc.near is not None:
        return None
    if not disc.pattern.chain or len(disc.groups) != 1 or disc.groups[0].names:
        return None
    group = disc.groups[0]
    if not isinstance(group.element, DirectorStep) or group.layout.nn > 3:
        return None
    if any(load.first >= 6 for load in disc.loads):
        return None
    ends = disc.pattern.row[group.conn[:, [0, -1]]]
    steps = ends[:, 1] - ends[:, 0]
    if np.all(steps == 1):
        return np.argsort(ends[:, 0])
    return np.argsort(-ends[:, 0]) if np.all(steps == -1) else None


def strips_for(disc: Discretisation, scheme: Scheme, damped: bool, options: Array, every: int = 1) -> Strips | None:
    """The fast way for a model whose chain (:func:`chain_of`) has FEWEST elements at least, or None. Every
    ``every``-th state is kept."""
    order = chain_of(disc, scheme, damped)
    if order is None or len(order) < max(FEWEST, 2 * LANES):
        return None
    return Strips(disc, scheme, order, options, every)


def nodes_of(group: Group, order: Ints) -> Ints:
    """The nodes of a chain, one after the other."""
    conn = group.conn[order]
    return np.append(conn[:, :-1].ravel(), conn[-1, -1])


def parameters_of(group: Group, order: Ints, aligned: bool) -> Array:
    """(elements, …) parameters of the elements of a chain; of ``aligned`` ones without their directors."""
    return group.parameters[order][:, 9 * group.layout.nn if aligned else 0 :]


def frames_of(group: Group, nodes: int) -> tuple[Array, bool]:
    """(nodes, 3, 3) reference directors of the nodes as columns where all elements at a node agree (and any are not
    the axes: such elements are aligned), else the identity everywhere."""
    nn = group.layout.nn
    directors = group.parameters[:, : 9 * nn].reshape(-1, nn, 3, 3).transpose(0, 1, 3, 2)
    out = np.zeros((nodes, 3, 3))
    out[group.conn] = directors
    if np.abs(out[group.conn] - directors).max() > ALIGNED:
        out[:] = np.eye(3)
    return out, not np.array_equal(out, np.broadcast_to(np.eye(3), out.shape))


class Strips:
    """A chain in lanes: its state is packed, taken through steps and unpacked."""

    def __init__(self, disc: Discretisation, scheme: Scheme, order: Ints, options: Array, every: int) -> None:
        group = disc.groups[0]
        self.frames, aligned = frames_of(group, disc.nodes)
        self.code = code_of(group, aligned, whole=False)
        chain, stride = nodes_of(group, order), group.layout.nn - 1
        length = len(order) // LANES
        left = len(order) - length * LANES
        first = length * np.arange(LANES)
        more = length * LANES + np.minimum(np.arange(LANES), max(left - 1, 0)) - (0 if left else 1)
        p = parameters_of(group, order, aligned)
        self.fixed = disc.fixed
        self.parts = [
            _part(chain, order, group, p, begin, many, lanes, disc.fixed)
            for begin, many, lanes in ((first, length, LANES), (more, 1, left))
        ]
        self.joints = chain[::stride][np.append(first, np.arange(length * LANES, len(order) + 1))]
        self.work = work_for(disc.fixed[self.joints].astype(np.uint8), 2)
        self.g = np.array(scheme.common)
        self.options = np.array([*options[:6], options[7]])
        self.many = steps_at_once(len(order))
        rows = self.many if any(load.varies for load in disc.loads) else 1
        sizes = [(part.strip.load.size,) for part in self.parts]
        self.loads = Loads(*(np.zeros((rows, *size)) for size in (*sizes, (len(self.joints), 6), (2,))))
        room = -(-self.many // every)
        self.shots = Shots(
            every, np.zeros((room, disc.rows, PER_NODE)), np.zeros((room, disc.nodes, 6)), self.frames,
            disc.fixed.astype(np.uint8), *(part.nodes[:, : part.strip.lanes].copy() for part in self.parts),
        )  # fmt: skip

    def set_loads(self, external: Array) -> None:
        """The loads (k, n, 12) of the next steps; where they are steady, of all (1, n, 12)."""
        dead = external[..., :6]
        for part, out in zip(self.parts, (self.loads.main, self.loads.rest), strict=True):
            out[: len(dead)] = dead[:, part.nodes].transpose(0, 1, 3, 2).reshape(len(dead), -1)
        self.loads.joints[: len(dead)] = dead[:, self.joints]
        self.loads.largest[: len(dead)] = largest_of(dead)

    def pack(self, x: Array) -> None:
        """Take over a state (≥ n, 40)."""
        self.work.kept[0] = 0
        for part in self.parts:
            pack(part.strip.x, part.nodes, self.frames, x)

    @property
    def keeps(self) -> bool:
        """Whether the next step begins with factors of the last one."""
        return bool(self.work.kept[0])

    @property
    def every(self) -> int:
        """Of so many steps one is saved."""
        return self.shots.every

    def states(self, count: int) -> tuple[Array, Array]:
        """The first states (count, ≥ n, 40) of the last call that are to be saved, and reactions (count, n, 6)."""
        return self.shots.x[:count], self.shots.reaction[:count]

    def unpack(self, x: Array) -> None:
        """Write the state into ``x`` (≥ n, 40)."""
        for part in reversed(self.parts):
            unpack(part.strip.x, part.nodes[:, : part.strip.lanes], self.frames, x)

    def shift(self, by: Array) -> None:
        """Move all positions by −``by`` (3,)."""
        for part in self.parts:
            part.strip.x.reshape(-1, rows.NODE, LANES)[:, :3] -= by[:, None]

    def run(self, results: Array, before: int = 0) -> None:
        """Take a step for every row of ``results``, or as many as converge, ``before`` having been taken; see
        :func:`kernels.strips.run`."""
        main, rest = (part.strip for part in self.parts)
        kernel.run(self.code, main, rest, self.g, self.work, self.options, results, self.loads, self.shots, before)

    def reaction(self, out: Array) -> Array:
        """The support forces of the last step (n, 6)."""
        out[:] = 0.0
        for part in self.parts:
            res = part.strip.res.reshape(-1, 6, LANES).transpose(0, 2, 1)[:, : part.strip.lanes]
            out[part.nodes[:, : part.strip.lanes]] = -res
        out[~self.fixed] = 0.0
        return out

    def first_position(self) -> Array:
        """Position (3,) of the first node of the chain."""
        return self.parts[0].strip.x.reshape(-1, rows.NODE, LANES)[0, :3, 0]

    def largest_turn(self) -> tuple[float, int]:
        """The least Σ d_i·d_i between the nodes of an element in all steps so far, and the element."""
        worst, where = 3.0, 0
        for part in self.parts:
            turn = -part.strip.turn.reshape(-1, LANES)[:, : part.strip.lanes]
            if turn.size and turn.min() < worst:
                worst, where = float(turn.min()), int(part.members[:, : part.strip.lanes].ravel()[turn.argmin()])
        return worst, where


def _part(
    chain: Ints, order: Ints, group: Group, p: Array, first: Ints, many: int, lanes: int, fixed: NDArray[np.bool_]
) -> Part:
    stride = group.layout.nn - 1
    at = stride * first + np.arange(stride * many + 1)[:, None]
    nodes, members = chain[at], first + np.arange(many)[:, None]
    own = np.zeros((len(nodes), LANES))
    own[:-1, :lanes] = 1.0
    if lanes:
        own[-1, lanes - 1] = float(at[-1, lanes - 1] == len(chain) - 1)
    strip = strip_of(stride, lanes, p[members].transpose(0, 2, 1), fixed[nodes].transpose(0, 2, 1), own, whole=False)
    return Part(strip, nodes, order[members])
