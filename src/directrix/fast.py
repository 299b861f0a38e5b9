"""Many steps a call: the bridge between the loop over time and :mod:`directrix.strips`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.accounts import FOLLOW, Accounts, Taken
from directrix.audit import DynamicBooks
from directrix.keeping.memory import recall, remember
from directrix.kernels.strip_steps import RESULTS
from directrix.newton import Books, Newton
from directrix.stepping import Fixed
from directrix.strips import Strips, strips_for

Array = NDArray[np.float64]

__all__ = ["Fast", "fast_for"]

CARRIED, FACTORS = ("x", "res", "turn"), ("row", "within", "far")
"""What a strip keeps from step to step; and if factors are kept."""
JOINED = ("kept", "blocks")
"""The same of the nodes where parts meet."""


def fast_for(newton: Newton, pace: Fixed, every: int) -> Fast | None:
    """The fast way for what ``newton`` solves in steps of ``pace``, every ``every``-th of which is saved, or None; see
    :func:`directrix.strips.strips_for`."""
    damped, threads = newton.tables.damping.size > 0, newton.settings.threads
    strips = strips_for(newton.disc, newton.scheme, damped, newton.options, every, threads)
    return None if strips is None else Fast(newton, strips, pace)


class Fast:
    """Takes steps in lanes for a loop that keeps its state in ``x``: the state moves to the lanes when steps are taken
    and comes back when it is asked for."""

    def __init__(self, newton: Newton, strips: Strips, pace: Fixed) -> None:
        self.strips, self.accounts = strips, Accounts(newton, strips, pace)
        self.inside = False  # the state is in the lanes
        self.loaded: Array | None = None
        self.results = np.zeros((0, RESULTS))
        self.before = 0

    @property
    def energy(self) -> float:
        """After the last step."""
        return self.accounts.energy

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
        results, self.results = self.results, self.results[:0]
        return self.accounts.settle(results, self.before, ledger)

    def close(self, ledger: DynamicBooks) -> None:
        """See :meth:`Accounts.close`."""
        self.accounts.close(ledger)

    def remember(self) -> dict[str, Any]:
        """What is in the lanes, digit by digit: a state that leaves them is rounded."""
        kept = self.strips.keeps
        names = (*CARRIED, *FACTORS) if kept else CARRIED
        lanes = [remember(part.strip, *names) for part in self.strips.parts]
        joints = remember(self.strips.works[0], *JOINED) if kept else {}
        booked = remember(self.accounts, "energy", "loss")
        return {"inside": self.inside, "booked": booked, "lanes": lanes, "joints": joints}

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        self.inside = memory["inside"]
        recall(self.accounts, memory["booked"])
        for part, lanes in zip(self.strips.parts, memory["lanes"], strict=True):
            recall(part.strip, lanes)
        for work in self.strips.works:
            recall(work, memory["joints"])

    def give(self, x: Array) -> None:
        """Write the state into ``x`` and leave the lanes."""
        if self.inside:
            self.strips.unpack(x)
            self.inside = False

    def books(self, x: Array) -> Books:
        """See :meth:`Accounts.books`."""
        return self.accounts.books(x)
