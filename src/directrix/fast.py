"""Many steps a call: the bridge between the loop over time and :mod:`directrix.strips`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.audit import DynamicBooks
from directrix.keeping.memory import recall, remember
from directrix.kernels.strips import MOVES, RESULTS, SHOWN
from directrix.newton import Books, Newton
from directrix.recorder import Instants
from directrix.stepping import Fixed
from directrix.strips import Strips, strips_for

Array = NDArray[np.float64]

__all__ = ["FOLLOW", "Fast", "Taken", "fast_for"]

CARRIED = ("x", "res", "turn")
"""What a strip keeps from step to step."""
FOLLOW = 64
"""The origin of a free model goes along after so many steps, counted from its start: when must not depend on how many
are taken in a call, since it changes the rounding of those that follow."""


class Taken(NamedTuple):
    """Steps that were taken and booked: their ``iterations``; ``moves`` (steps, SHOWN, 2), displacement and turn in the
    first of them; what is to be saved of them, and behind which step the last of that is."""

    iterations: list[int]
    moves: Array
    instants: Instants | None
    saved: int


def fast_for(newton: Newton, pace: Fixed, every: int) -> Fast | None:
    """The fast way for what ``newton`` solves in steps of ``pace``, every ``every``-th of which is saved, or None; see
    :func:`directrix.strips.strips_for`."""
    strips = strips_for(newton.disc, newton.scheme, newton.tables.damping.size > 0, newton.options, every)
    return None if strips is None else Fast(newton, strips, pace)


class Fast:
    """Takes steps in lanes for a loop that keeps its state in ``x``: the state moves to the lanes when steps are taken
    and comes back when it is asked for."""

    def __init__(self, newton: Newton, strips: Strips, pace: Fixed) -> None:
        self.newton, self.strips, self.pace = newton, strips, pace
        self.inside = False  # the state is in the lanes
        self.loaded: Array | None = None
        self.results = np.zeros((0, RESULTS))
        self.energy = self.loss = 0.0
        self.before = 0

    def room(self, before: int) -> int:
        """Steps that are taken at once, ``before`` having been taken."""
        return min(self.strips.many, FOLLOW - before % FOLLOW)

    def take(self, x: Array, external: Array, count: int, ledger: DynamicBooks, before: int) -> Taken:
        """Take ``count`` steps, as far as there is :meth:`room`, under loads (count, n, 12), or (1, n, 12) that are
        steady; book those that converged."""
        self.before = before
        if not self.inside:
            self.strips.pack(x)
            self.inside = True
        if external is not self.loaded:
            self.strips.set_loads(external)
            self.loaded = external
        # a signal may come in between: what was computed is in here all the same
        self.results = np.zeros((min(count, self.room(before)), RESULTS))
        self.strips.run(self.results, before)
        return self.settle(ledger)

    def settle(self, ledger: DynamicBooks) -> Taken:
        """Book the steps that were taken since this was last done."""
        rows, self.results = self.results[self.results[:, 0] > 0.0], self.results[:0]
        instants, first = None, self.before
        if len(rows):
            flow, totals = np.zeros((len(rows), 10)), rows[:, 8:16]
            flow[:, 0], flow[:, 2:8] = rows[:, 1], rows[:, 2:8]
            if self.newton.free and self.newton.origin.any():
                flow[:, 5:8] += np.cross(self.newton.origin, flow[:, 2:5])
                totals[:, 5:8] += np.cross(self.newton.origin, totals[:, 2:5])
            self.before += len(rows)
            force, moment = np.linalg.norm(flow[:, 2:5], axis=1), np.linalg.norm(flow[:, 5:8], axis=1)
            acting = np.stack([np.maximum(force, np.sqrt(rows[:, 17])), moment], -1)
            booked = ledger.add_steps(totals, flow, acting, self.pace.dt)
            self.energy = float(totals[-1, 0] + totals[-1, 1])
            self.loss = max(self.loss, float(rows[:, 16].max()))
            instants = self._instants(first, booked, ledger)
        moves = rows[:, MOVES:].reshape(len(rows), SHOWN, 2)
        every = self.strips.shots.every
        return Taken([int(n) for n in rows[:, 0]], moves, instants, self.before // every * every)

    def _instants(self, first: int, booked: list[tuple[float, ...]], ledger: DynamicBooks) -> Instants | None:
        """What is to be saved of the steps behind the ``first`` ones; the origin goes along after the last."""
        every, n = self.strips.shots.every, self.newton.disc.nodes
        steps = np.arange(first // every + 1, self.before // every + 1) * every
        x, reaction = (values[: len(steps)] for values in (self.strips.shots.x, self.strips.shots.reaction))
        origins = np.tile(self.newton.origin, (len(steps), 1))
        if self.newton.free and self.before % FOLLOW == 0:
            shift = self._follow()
            if shift is not None and self.before % every == 0:
                x[-1, :n, :3] -= shift
                origins[-1] = self.newton.origin
        if not len(steps):
            return None
        by_source = ledger.flows[3:]
        flows = np.array([(*booked[k - first - 1], *by_source) for k in steps.tolist()])
        joints = np.zeros((len(steps), *self.newton.work.joints.shape))
        clock = self.pace.times(steps)
        return Instants(
            clock, np.ones(len(steps)), x[:, :n, :3] + origins[:, None], x, *self.newton.books_of(x, origins), reaction,
            joints, flows,
        )  # fmt: skip

    def close(self, ledger: DynamicBooks) -> None:
        """Book what is known only at the end: the largest turn and loss of orthonormality of all steps."""
        dots, element = self.strips.largest_turn()
        ledger.turn.add(np.array([*[0.0] * 8, dots, element, self.loss]))

    def remember(self) -> dict[str, Any]:
        """What is in the lanes, digit by digit: a state that leaves them is rounded."""
        lanes = [remember(part.strip, *CARRIED) for part in self.strips.parts]
        return {"own": remember(self, "inside", "energy", "loss"), "lanes": lanes}

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        recall(self, memory["own"])
        for part, lanes in zip(self.strips.parts, memory["lanes"], strict=True):
            recall(part.strip, lanes)

    def give(self, x: Array) -> None:
        """Write the state into ``x`` and leave the lanes."""
        if self.inside:
            self.strips.unpack(x)
            self.inside = False

    def books(self, x: Array) -> Books:
        """The books of the last step, with the state in ``x`` as well."""
        self.strips.unpack(x)
        books = self.newton.books(x)
        self.strips.reaction(books.reaction)
        return books

    def _follow(self) -> Array | None:
        """See :meth:`Newton.shift`."""
        shift = self.newton.shift(self.strips.first_position())
        if shift is not None:
            self.strips.shift(shift)
        return shift
