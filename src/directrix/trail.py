"""How Newton's iteration went: what was out of balance, and how far it moved, in every iteration of the last tries."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

__all__ = ["LAST", "Iterations", "Trail"]

LAST = 500
"""Tries that are remembered: a run may be long, and how it ended is what is asked."""
COLUMNS = 5


@dataclass(frozen=True)
class Iterations:
    """Newton's iterations in the last tries of a run, those that failed among them.

    Attributes
    ----------
    step : (tries,) how many entries ``result.iterations`` had before the try
    solved : (tries,) whether its equations were solved; a step that was solved and too inaccurate is tried again too
    count : (tries,) rows of the try
    rows : (Σ count, 5) largest unbalanced force and moment before the iteration, largest displacement and turn [rad]
        that it asked for, and the node that was furthest from balance. Steps of a chain that are taken many a call say
        the third and fourth alone, of their first iterations; the others are NaN there, the node −1.
    """

    step: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    solved: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    count: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    rows: Array = field(default_factory=lambda: np.zeros((0, COLUMNS)))

    def of(self, k: int) -> Array:
        """Rows (iterations, 5) of try ``k``, which may count from the end."""
        first = np.concatenate([[0], np.cumsum(self.count)])
        k = range(len(self.count))[k]
        return self.rows[first[k] : first[k + 1]]


class Trail:
    """Collects them while a run goes on: blocks of tries, the last ``LAST`` tries at least."""

    def __init__(self) -> None:
        self.blocks: deque[tuple[int, bool, list[int], Array]] = deque()
        self.tries = 0

    def tried(self, step: int, solved: bool, rows: Array) -> None:
        """Book one try."""
        self._add(step, solved, [len(rows)], rows)

    def took(self, step: int, counts: list[int], moves: Array) -> None:
        """Book steps that were taken in one call: their iterations, and the moves (steps, room, 2) of the first."""
        self._add(step, True, counts, moves)

    def _add(self, step: int, solved: bool, counts: list[int], rows: Array) -> None:
        self.blocks.append((step, solved, counts, rows))
        self.tries += len(counts)
        while self.tries - len(self.blocks[0][2]) >= LAST:
            self.tries -= len(self.blocks.popleft()[2])

    def iterations(self) -> Iterations:
        """The last tries."""
        parts = [_laid_out(counts, rows) for _, _, counts, rows in self.blocks]
        step = [s + k for s, _, counts, _ in self.blocks for k in range(len(counts))]
        solved = [ok for _, ok, counts, _ in self.blocks for _ in counts]
        count = np.array([n for counts, _ in parts for n in counts], np.int64)
        rows = np.concatenate([np.zeros((0, COLUMNS)), *(rows for _, rows in parts)])
        kept = int(count[-LAST:].sum())
        return Iterations(
            np.array(step[-LAST:], np.int64), np.array(solved[-LAST:], bool), count[-LAST:], rows[len(rows) - kept :]
        )

    def remember(self) -> dict[str, Any]:
        """What :meth:`recall` goes on from."""
        return dict(vars(self.iterations()))

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        past = Iterations(**{name: np.array(value) for name, value in memory.items()})
        self.blocks.clear()
        self.tries = 0
        for k, step in enumerate(past.step.tolist()):
            self.tried(step, bool(past.solved[k]), past.of(k))


def _laid_out(counts: list[int], rows: Array) -> tuple[list[int], Array]:
    if rows.ndim == 2:
        return counts, rows
    room = rows.shape[1]
    counts = [min(n, room) for n in counts]
    out = np.full((sum(counts), COLUMNS), np.nan)
    out[:, 2:4] = rows[np.arange(room) < np.array(counts)[:, None]]
    out[:, 4] = -1.0
    return counts, out
