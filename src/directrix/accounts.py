"""Books of steps that were taken in lanes, many at a time, and what is to be saved of them."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from directrix.audit import DynamicBooks
from directrix.kernels.strip_steps import MOVES, SHOWN
from directrix.newton import Books, Newton
from directrix.recorder import Instants
from directrix.stepping import Fixed

Array = NDArray[np.float64]

__all__ = ["FOLLOW", "Accounts", "Chain", "Taken"]

FOLLOW = 64
"""The origin of a free model goes along after so many steps, counted from its start: when must not depend on how many
are taken in a call, since it changes the rounding of those that follow."""


class Chain(Protocol):
    """The lanes, as their books need them."""

    @property
    def every(self) -> int:
        """Of so many steps the state of one is there."""
        ...

    def states(self, count: int) -> tuple[Array, Array]:
        """The first states (count, ≥ n, 40) of the last call, and reactions (count, n, 6)."""
        ...

    def unpack(self, x: Array) -> None:
        """Write the state into ``x`` (≥ n, 40)."""
        ...

    def reaction(self, out: Array) -> Array:
        """The support forces of the last step (n, 6)."""
        ...

    def first_position(self) -> Array:
        """Position (3,) of the first node of the chain."""
        ...

    def shift(self, by: Array) -> None:
        """Move all positions by −``by`` (3,)."""
        ...

    def largest_turn(self) -> tuple[float, int]:
        """The least Σ d_i·d_i between the nodes of an element in all steps so far, and the element."""
        ...


class Taken(NamedTuple):
    """Steps that were taken and booked: their ``iterations``; ``moves`` (steps, SHOWN, 2), displacement and turn in the
    first of them; what is to be saved of them, and behind which step the last of that is."""

    iterations: list[int]
    moves: Array
    instants: Instants | None
    saved: int


class Accounts:
    """Books the steps of one motion."""

    def __init__(self, newton: Newton, chain: Chain, pace: Fixed) -> None:
        self.newton, self.chain, self.pace = newton, chain, pace
        self.energy = self.loss = 0.0

    def settle(self, results: Array, before: int, ledger: DynamicBooks) -> Taken:
        """Book what the kernel has left of steps (many, RESULTS) behind the first ``before``: those that converged."""
        rows, instants = results[results[:, 0] > 0.0], None
        after = before + len(rows)
        if len(rows):
            flow, totals = np.zeros((len(rows), 10)), rows[:, 8:16]
            flow[:, 0], flow[:, 2:8] = rows[:, 1], rows[:, 2:8]
            if self.newton.free and self.newton.origin.any():
                flow[:, 5:8] += np.cross(self.newton.origin, flow[:, 2:5])
                totals[:, 5:8] += np.cross(self.newton.origin, totals[:, 2:5])
            force, moment = np.linalg.norm(flow[:, 2:5], axis=1), np.linalg.norm(flow[:, 5:8], axis=1)
            acting = np.stack([np.maximum(force, np.sqrt(rows[:, 17])), moment], -1)
            booked = ledger.add_steps(totals, flow, acting, self.pace.dt)
            self.energy = float(totals[-1, 0] + totals[-1, 1])
            self.loss = max(self.loss, float(rows[:, 16].max()))
            instants = self._instants(before, after, booked, ledger)
        moves = rows[:, MOVES:].reshape(len(rows), SHOWN, 2)
        return Taken([int(n) for n in rows[:, 0]], moves, instants, after // self.chain.every * self.chain.every)

    def _instants(
        self, before: int, after: int, booked: list[tuple[float, ...]], ledger: DynamicBooks
    ) -> Instants | None:
        """What is to be saved of the steps in between; the origin goes along after the last."""
        every, n = self.chain.every, self.newton.disc.nodes
        steps = np.arange(before // every + 1, after // every + 1) * every
        x, reaction = self.chain.states(len(steps))
        origins = np.tile(self.newton.origin, (len(steps), 1))
        if self.newton.free and after % FOLLOW == 0:
            shift = self._follow()
            if shift is not None and after % every == 0:
                x[-1, :n, :3] -= shift
                origins[-1] = self.newton.origin
        if not len(steps):
            return None
        by_source = ledger.flows[3:]
        flows = np.array([(*booked[k - before - 1], *by_source) for k in steps.tolist()])
        joints = np.zeros((len(steps), *self.newton.work.joints.shape))
        return Instants(
            self.pace.times(steps), np.ones(len(steps)), x[:, :n, :3] + origins[:, None], x,
            *self.newton.books_of(x, origins), reaction, joints, flows,
        )  # fmt: skip

    def close(self, ledger: DynamicBooks) -> None:
        """Book what is known only at the end: the largest turn and loss of orthonormality of all steps."""
        dots, element = self.chain.largest_turn()
        ledger.turn.add(np.array([*[0.0] * 8, dots, element, self.loss]))

    def books(self, x: Array) -> Books:
        """The books of the last step, with the state in ``x`` as well."""
        self.chain.unpack(x)
        books = self.newton.books(x)
        self.chain.reaction(books.reaction)
        return books

    def _follow(self) -> Array | None:
        """See :meth:`Newton.shift`."""
        shift = self.newton.shift(self.chain.first_position())
        if shift is not None:
            self.chain.shift(shift)
        return shift
