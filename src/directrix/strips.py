"""The fast way through a motion: chains of equal elements, solved in SIMD lanes, many steps a call.

What it computes is what :mod:`directrix.newton` computes, up to rounding; which models qualify says :func:`strips_for`.
Everything else, and every step that does not converge here, takes the general way.
"""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
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
from directrix.kernels.team import STOP, Team, team_of
from directrix.scheme import Rates, Scheme
from directrix.strip import Loads, Shots, Strip, Work, code_of, largest_of, steps_at_once, strip_of, work_for

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Strips", "chain_of", "frames_of", "nodes_of", "parameters_of", "strips_for"]

FEWEST = 8
"""Elements from which on lanes are used."""
SHARED, MOST = 2048, 8
"""Elements a strip has at least where there are several, an even number of at most so many; which of them a node is
in decides about its last digits, so it does not depend on the threads."""
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


def strips_for(
    disc: Discretisation, scheme: Scheme, damped: bool, options: Array, every: int = 1, threads: int = 1
) -> Strips | None:
    """The fast way for a model whose chain (:func:`chain_of`) has FEWEST elements at least, or None. Every
    ``every``-th state is kept."""
    order = chain_of(disc, scheme, damped)
    if order is None or len(order) < max(FEWEST, 2 * LANES):
        return None
    return Strips(disc, scheme, order, options, every, threads)


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
    """A chain in lanes: its state is packed, taken through steps and unpacked, by so many ``threads``."""

    def __init__(
        self, disc: Discretisation, scheme: Scheme, order: Ints, options: Array, every: int, threads: int
    ) -> None:
        group = disc.groups[0]
        self.frames, aligned = frames_of(group, disc.nodes)
        self.code = code_of(group, aligned, whole=False)
        p = parameters_of(group, order, aligned)
        self.fixed = disc.fixed
        self.parts: list[Part] = []
        chain, cut = nodes_of(group, order), _cut(len(order))
        for begin, many in cut:
            self.parts.append(_part(group, chain, order, p, begin, many, disc.fixed, self.parts))
        self.joints = chain[:: group.layout.nn - 1][np.concatenate([*(begin for begin, _ in cut), [len(order)]])]
        strips = [part.strip for part in self.parts]
        self.team = team_of(strips, min(threads, len(strips)))
        self.works = [work_for(disc.fixed[self.joints].astype(np.uint8), 2) for _ in self.team]
        self.helpers: ThreadPoolExecutor | None = None
        self.g = np.array(scheme.common)
        self.options = np.array([*options[:6], options[7]])
        self.many = steps_at_once(len(order))
        rows = self.many if any(load.varies for load in disc.loads) else 1
        sizes = ((sum(strip.load.size for strip in strips),), (len(self.joints), 6), (2,))
        self.loads = Loads(*(np.zeros((rows, *size)) for size in sizes))
        room = -(-self.many // every)
        self.shots = Shots(
            every, np.zeros((room, disc.rows, PER_NODE)), np.zeros((room, disc.nodes, 6)), self.frames,
            disc.fixed.astype(np.uint8),
        )  # fmt: skip

    def set_loads(self, external: Array) -> None:
        """The loads (k, n, 12) of the next steps; where they are steady, of all (1, n, 12)."""
        dead = external[..., :6]
        for part in self.parts:
            own = dead[:, part.nodes].transpose(0, 1, 3, 2).reshape(len(dead), -1)
            self.loads.strips[: len(dead), part.strip.loaded : part.strip.loaded + part.strip.load.size] = own
        self.loads.joints[: len(dead)] = dead[:, self.joints]
        self.loads.largest[: len(dead)] = largest_of(dead)

    def pack(self, x: Array) -> None:
        """Take over a state (≥ n, 40)."""
        for work in self.works:
            work.kept[0] = 0
        for part in self.parts:
            pack(part.strip.x, part.nodes, self.frames, x)

    @property
    def keeps(self) -> bool:
        """Whether the next step begins with factors of the last one."""
        return bool(self.works[0].kept[0])

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
            unpack(part.strip.x, part.strip.nodes, self.frames, x)

    def shift(self, by: Array) -> None:
        """Move all positions by −``by`` (3,)."""
        for part in self.parts:
            part.strip.x.reshape(-1, rows.NODE, LANES)[:, :3] -= by[:, None]

    def run(self, results: Array, before: int = 0) -> None:
        """Take a step for every row of ``results``, or as many as converge, ``before`` having been taken; see
        :func:`kernels.strips.run`."""
        gate, waiting = self.team[0].gate, list[Future[None]]()
        if len(self.team) > 1 and self.helpers is None:
            self.helpers = ThreadPoolExecutor(len(self.team) - 1)
            self._take(team_of([self.parts[0].strip], 1)[0], self.works[0], results[:0], before)  # compiles
        gate[0] = gate[STOP] = 0
        try:
            for team, work in zip(self.team[1:], self.works[1:], strict=True):
                assert self.helpers is not None
                waiting.append(self.helpers.submit(self._take, team, work, np.zeros_like(results), before))
            self._take(self.team[0], self.works[0], results, before)
        finally:
            gate[STOP] = 1  # who came in vain need not wait
            for helper in waiting:
                helper.result()

    def _take(self, team: Team, work: Work, results: Array, before: int) -> None:
        team.met[0] = 0
        main = self.parts[0].strip
        kernel.run(self.code, team, main, self.g, work, self.options, results, self.loads, self.shots, before)

    def reaction(self, out: Array) -> Array:
        """The support forces of the last step (n, 6)."""
        out[:] = 0.0
        for part in self.parts:
            res = part.strip.res.reshape(-1, 6, LANES).transpose(0, 2, 1)[:, : part.strip.lanes]
            out[part.strip.nodes] = -res
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


def _cut(elements: int) -> list[tuple[Ints, int]]:
    """Where the lanes of each strip of a chain begin, and how long they are; the last strip, for what is left over, has
    lanes one element long."""
    strips = 1 if elements < 2 * SHARED else 2 * min(MOST // 2, elements // (2 * SHARED))
    length, more = divmod(elements // LANES, strips)
    out: list[tuple[Ints, int]] = []
    begin = 0
    for strip in range(strips):
        many = length + (strip < more)
        out.append((begin + many * np.arange(LANES), many))
        begin += many * LANES
    return [*out, (np.arange(begin, elements), 1)] if begin < elements else out


def _part(
    group: Group,
    chain: Ints,
    order: Ints,
    p: Array,
    begin: Ints,
    many: int,
    fixed: NDArray[np.bool_],
    before: list[Part],
) -> Part:
    stride, lanes = group.layout.nn - 1, len(begin)
    first = np.append(begin, np.full(LANES - lanes, begin[-1]))
    at = stride * first + np.arange(stride * many + 1)[:, None]
    nodes, members = chain[at], first + np.arange(many)[:, None]
    own = np.zeros((len(nodes), LANES))
    own[:-1, :lanes] = 1.0
    own[-1, lanes - 1] = float(at[-1, lanes - 1] == len(chain) - 1)
    parameters, held = p[members].transpose(0, 2, 1), fixed[nodes].transpose(0, 2, 1)
    loaded = sum(part.strip.load.size for part in before)
    strip = strip_of(
        stride, nodes[:, :lanes], parameters, held, own, whole=False, first=LANES * len(before), loaded=loaded
    )
    return Part(strip, nodes, order[members])
