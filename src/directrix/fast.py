"""Many steps a call: the bridge between the loop over time and :mod:`directrix.strips`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.audit import DynamicBooks
from directrix.keeping.memory import recall, remember
from directrix.kernels.strips import MOVES, RESULTS, SHOWN
from directrix.newton import Books, Newton
from directrix.strips import Strips, strips_for

Array = NDArray[np.float64]

__all__ = ["FOLLOW", "Fast", "fast_for"]

CARRIED = ("x", "res", "turn")
"""What a strip keeps from step to step."""
FOLLOW = 64
"""The origin of a free model goes along after so many steps, counted from its start: when must not depend on how many
are taken in a call, since it changes the rounding of those that follow."""


def fast_for(newton: Newton, dt: float) -> Fast | None:
    """The fast way for what ``newton`` solves in steps ``dt``, or None; see :func:`directrix.strips.strips_for`."""
    strips = strips_for(newton.disc, newton.scheme, newton.tables.damping.size > 0, newton.options)
    return None if strips is None else Fast(newton, strips, dt)


class Fast:
    """Takes steps in lanes for a loop that keeps its state in ``x``: the state moves to the lanes when steps are taken
    and comes back when it is asked for."""

    def __init__(self, newton: Newton, strips: Strips, dt: float) -> None:
        self.newton, self.strips, self.dt = newton, strips, dt
        self.inside = False  # the state is in the lanes
        self.loaded: Array | None = None
        self.results = np.zeros((0, RESULTS))
        self.moves = np.zeros((0, SHOWN, 2))
        """Displacement and turn in the first iterations of the steps that were booked last."""
        self.energy = self.loss = 0.0
        self.before = 0

    def take(self, x: Array, external: Array, count: int, ledger: DynamicBooks, before: int) -> list[int]:
        """Take up to ``count`` steps and book them, ``before`` having been taken; the iterations of those that
        converged."""
        count, self.before = min(count, FOLLOW - before % FOLLOW), before
        if not self.inside:
            self.strips.pack(x)
            self.inside = True
        if external is not self.loaded:
            self.strips.set_load(external)
            self.loaded = external
        # a signal may come in between: what was computed is in here all the same
        self.results = np.zeros((min(count, self.strips.many), RESULTS))
        self.strips.run(self.results)
        return self.settle(ledger)

    def settle(self, ledger: DynamicBooks) -> list[int]:
        """Book the steps that were taken since this was last done."""
        rows, self.results = self.results[self.results[:, 0] > 0.0], self.results[:0]
        self.moves = rows[:, MOVES:].reshape(len(rows), SHOWN, 2)
        if len(rows):
            flow, totals = np.zeros((len(rows), 10)), rows[:, 8:16]
            flow[:, 0], flow[:, 2:8] = rows[:, 1], rows[:, 2:8]
            if self.newton.free and self.newton.origin.any():
                flow[:, 5:8] += np.cross(self.newton.origin, flow[:, 2:5])
                totals[:, 5:8] += np.cross(self.newton.origin, totals[:, 2:5])
            self.before += len(rows)
            if self.newton.free and self.before % FOLLOW == 0:
                self._follow()
            force, moment = np.linalg.norm(flow[:, 2:5], axis=1), np.linalg.norm(flow[:, 5:8], axis=1)
            acting = np.stack([np.maximum(force, np.sqrt(rows[:, 17])), moment], -1)
            ledger.add_steps(totals, flow, acting, self.dt)
            self.energy = float(totals[-1, 0] + totals[-1, 1])
            self.loss = max(self.loss, float(rows[:, 16].max()))
        return [int(n) for n in rows[:, 0]]

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

    def _follow(self) -> None:
        """See :meth:`Newton.follow`."""
        shift = self.newton.shift(self.strips.first_position())
        if shift is not None:
            self.strips.shift(shift)
