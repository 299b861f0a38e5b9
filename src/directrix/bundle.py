"""Motions of one kind side by side: a lane each, many steps a call. The loop knows states, times and what to save."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.accounts import FOLLOW, Accounts
from directrix.errors import ModelError
from directrix.formulations.layout import PER_NODE
from directrix.keeping import Keeper
from directrix.kernels import bundle as kernel
from directrix.kernels import rows
from directrix.kernels.compile import LANES
from directrix.kernels.record import Record
from directrix.kernels.strip_steps import RESULTS, pack, unpack
from directrix.motion import Motion
from directrix.result import Result, Status
from directrix.stepping import Fixed
from directrix.strip import Loads, Shots, code_of, largest_of, steps_at_once, strip_of, work_for
from directrix.strips import chain_of, frames_of, nodes_of, parameters_of

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Fit", "fit_of", "run"]


class Fit(NamedTuple):
    """A motion that goes through a lane: the elements and nodes of its chain, the frames of the nodes, and whether they
    are aligned (:func:`directrix.strips.frames_of`). Those with the same ``key`` may lie side by side."""

    motion: Motion
    pace: Fixed
    order: Ints
    chain: Ints
    frames: Array
    aligned: bool
    key: Hashable


def fit_of(motion: Motion) -> Fit | None:
    """How a motion goes through a lane, or None: chains as :func:`directrix.strips.chain_of` takes them, of any length,
    in equal steps, that nobody looks at on the way."""
    disc, asked, pace = motion.disc, motion.asked, motion.pace
    order = chain_of(disc, motion.scheme, motion.newton.tables.damping.size > 0)
    if order is None or not isinstance(pace, Fixed) or asked.record or asked.progress is not None:
        return None
    group = disc.groups[0]
    chain, (frames, aligned) = nodes_of(group, order), frames_of(group, disc.nodes)
    held = disc.fixed[chain].tobytes()
    key = (len(order), f"{group.layout} {group.element}", aligned, held, motion.scheme, pace, motion.save_every)
    return Fit(motion, pace, order, chain, frames, aligned, key)


class Lanes(Record):
    """What every lane asks for and has found out in a step, see :mod:`directrix.kernels.bundle`; ``options`` (LANES, 7)
    are those of its Newton."""

    mode: Ints
    iteration: Ints
    before: Array
    kept: NDArray[np.uint8]
    good: NDArray[np.uint8]
    options: Array


class Bundle:
    """The arrays of up to LANES motions; lanes that are left are copies of the last."""

    def __init__(self, fits: Sequence[Fit]) -> None:
        first = fits[0].motion
        self.fits = [*fits, *[fits[-1]] * (LANES - len(fits))]
        group, order = first.disc.groups[0], fits[0].order
        self.n = n = first.disc.nodes
        self.code = code_of(group, fits[0].aligned, whole=True)
        self.nodes = np.stack([fit.chain + n * lane for lane, fit in enumerate(self.fits)], -1)
        self.frames = np.concatenate([fit.frames for fit in self.fits])
        p = [parameters_of(fit.motion.disc.groups[0], fit.order, fit.aligned) for fit in self.fits]
        held = np.stack([fit.motion.disc.fixed[fit.chain] for fit in self.fits], -1)
        own = np.ones((len(self.nodes), LANES))
        self.strip = strip_of(group.layout.nn - 1, self.nodes, np.stack(p, -1), held, own, whole=True)
        self.work = work_for(np.zeros((0, 6), np.uint8), 2 * LANES)
        options = [fit.motion.newton.options for fit in self.fits]
        self.lanes = Lanes(
            np.zeros(LANES, np.int64), np.zeros(LANES, np.int64), np.zeros(LANES), np.zeros(LANES, np.uint8),
            np.zeros(LANES, np.uint8), np.array([[*of[:6], of[7]] for of in options]),
        )  # fmt: skip
        self.g = np.array(first.scheme.common)
        self.many = steps_at_once(LANES * len(order))
        steady, every = all(fit.motion.steady for fit in fits), first.save_every
        count = 1 if steady else self.many
        sizes = ((self.strip.load.size,), (0, 6), (2 * LANES,))
        self.loads = Loads(*(np.zeros((count, *size)) for size in sizes))
        saved = -(-self.many // every)
        self.shots = Shots(
            every, np.zeros((saved, LANES * n, PER_NODE)), np.zeros((saved, LANES * n, 6)), self.frames,
            np.concatenate([fit.motion.disc.fixed for fit in self.fits]).astype(np.uint8),
        )  # fmt: skip
        pack(self.strip.x, self.nodes, self.frames, np.concatenate([fit.motion.x for fit in self.fits]))
        for lane, fit in enumerate(self.fits):
            self.load(lane, fit.motion.standing)

    def load(self, lane: int, external: Array) -> None:
        """The loads (k, n, 12) of a lane in the next steps, or (1, n, 12) in all."""
        dead = external[:, self.fits[lane].chain, :6]
        many = len(dead) if len(dead) > 1 else len(self.loads.strips)
        self.loads.strips[:many].reshape(many, -1, 6, LANES)[..., lane] = dead
        self.loads.largest[:many].reshape(many, 2, LANES)[..., lane] = largest_of(dead)

    def run(self, results: Array, before: int) -> None:
        """Take a step for every row of ``results`` (steps, LANES, RESULTS), see :mod:`directrix.kernels.bundle`."""
        kernel.run(self.code, self.strip, self.g, self.work, self.lanes, results, self.loads, self.shots, before)

    def drop(self, lane: int) -> None:
        """Nothing more is asked of a lane."""
        self.lanes.mode[lane] = kernel.FAILED


class Lane:
    """One lane, as :class:`directrix.accounts.Accounts` needs it."""

    def __init__(self, bundle: Bundle, lane: int) -> None:
        self.bundle, self.lane, self.every = bundle, lane, bundle.shots.every
        self.rows = slice(lane * bundle.n, (lane + 1) * bundle.n)

    def states(self, count: int) -> tuple[Array, Array]:
        """See :class:`directrix.accounts.Chain`; here and below."""
        shots = self.bundle.shots
        return shots.x[:count, self.rows].copy(), shots.reaction[:count, self.rows]

    def unpack(self, x: Array) -> None:
        """The state into ``x``."""
        of = self.bundle
        every = np.zeros((LANES * of.n, PER_NODE))
        unpack(of.strip.x, of.nodes, of.frames, every)
        x[: of.n] = every[self.rows]

    def reaction(self, out: Array) -> Array:
        """Support forces of the last step."""
        of, fit = self.bundle, self.bundle.fits[self.lane]
        out[:] = 0.0
        out[fit.chain] = -of.strip.res.reshape(-1, 6, LANES)[..., self.lane]
        out[~fit.motion.disc.fixed] = 0.0
        return out

    def _positions(self) -> Array:
        return self.bundle.strip.x.reshape(-1, rows.NODE, LANES)[:, :3, self.lane]

    def first_position(self) -> Array:
        """Of the first node of the chain."""
        return self._positions()[0]

    def shift(self, by: Array) -> None:
        """Move all positions."""
        self._positions()[:] -= by

    def largest_turn(self) -> tuple[float, int]:
        """The least Σ d_i·d_i so far and its element."""
        turn = -self.bundle.strip.turn.reshape(-1, LANES)[:, self.lane]
        return float(turn.min()), int(self.bundle.fits[self.lane].order[turn.argmin()])


class _Member:
    """One motion in its lane, and in the lanes that are copies of it: how far it is, what it has saved."""

    def __init__(self, bundle: Bundle, lane: int, lanes: range) -> None:
        fit = bundle.fits[lane]
        self.bundle, self.lane, self.lanes, self.motion, self.pace = bundle, lane, lanes, fit.motion, fit.pace
        self.accounts = Accounts(fit.motion.newton, Lane(bundle, lane), fit.pace)
        self.results = np.zeros((0, RESULTS))
        self.taken = self.saved = 0
        self.well = True

    def load(self, count: int) -> None:
        """The loads of the next steps. A member whose functions fail is none any more."""
        if self.motion.steady or not self.well:
            return
        try:
            external = self.motion.loads(self.pace, self.taken, count)
        except ModelError:
            external = self.motion.standing[:0]
        self.well = len(external) == count
        for lane in self.lanes:
            if self.well:
                self.bundle.load(lane, external)
            else:
                self.bundle.drop(lane)

    def settle(self) -> None:
        """Book and save the steps that were taken. A member of which one did not converge is none any more."""
        results, self.results = self.results, self.results[:0]
        if not self.well:
            return
        motion = self.motion
        taken = self.accounts.settle(results, self.taken, motion.ledger)
        self.well = len(taken.iterations) == len(results)
        motion.recorder.log.took(self.pace.dt, taken.iterations, taken.moves)
        self.taken += len(taken.iterations)
        if taken.instants is not None:
            motion.recorder.keep_all(taken.instants)
            self.saved = taken.saved

    def result(self, status: Status) -> Result:
        """What there is, at the end."""
        motion = self.motion
        self.accounts.close(motion.ledger)
        if self.well and self.saved < self.taken:
            books = self.accounts.books(motion.x)
            positions = motion.newton.positions(motion.x)
            motion.recorder.keep(self.t, 1.0, positions, motion.x, books, motion.ledger.flows)
        return motion.result(status)

    @property
    def t(self) -> float:
        """When the last step ended."""
        return float(self.pace.times(np.array(self.taken)))


def run(fits: Sequence[Fit]) -> list[Result | None]:
    """Take up to LANES motions of one key to their end, side by side; None for one that needs more than the lanes have:
    a step of it did not converge. No bit of a result depends on the others.

    A keyboard interrupt ends all of them; their results say so."""
    bundle, pace, last = Bundle(fits), fits[0].pace, len(fits) - 1
    members = [_Member(bundle, k, range(k, k + 1 if k < last else LANES)) for k in range(len(fits))]
    before = 0
    try:
        while before < pace.steps and any(member.well for member in members):
            count = min(bundle.many, FOLLOW - before % FOLLOW, pace.steps - before)
            results = np.zeros((count, LANES, RESULTS))
            for member in members:
                member.load(count)
                member.results = results[:, member.lane]
            bundle.run(results, before)
            for member in members:
                member.settle()
            before += count
    except KeyboardInterrupt:
        ended: list[Result | None] = []
        for member in members:
            member.settle()
            ended.append(member.result(Keeper(None, member.motion.recorder, "").interrupted(f"t = {member.t:g}")))
        return ended
    return [member.result(member.motion.done()) if member.well else None for member in members]
