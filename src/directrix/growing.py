"""Columns of rows that come a block at a time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

__all__ = ["Growing"]

AT_ONCE = 32_000_000  # bytes: for rows beyond, room is made when they come


class Growing:
    """Arrays by name, all of them ``count`` rows long; with room from the start for as many rows as are expected."""

    def __init__(self, expected: int) -> None:
        self.expected, self.count = expected, 0
        self.columns: dict[str, Array] = {}

    def add(self, block: Mapping[str, Array]) -> int:
        """Copy rows; their size in bytes."""
        more, size = len(next(iter(block.values()))), sum(values.nbytes for values in block.values())
        end = self.count + more
        room = max(end, min(self.expected, AT_ONCE * more // max(size, 1)))
        for name, values in block.items():
            column = self.columns.get(name)
            if column is None or len(column) < end:
                room = room if column is None else 2 * end
                self.columns[name] = wider = np.empty((room, *values.shape[1:]))
                if column is not None:
                    wider[: self.count] = column[: self.count]
            self.columns[name][self.count : end] = values
        self.count = end
        return size

    def rows(self) -> dict[str, Array]:
        """All of them; the next block after :meth:`clear` goes into the same place."""
        return {name: column[: self.count] for name, column in self.columns.items()} if self.count else {}

    def clear(self) -> None:
        """Begin again."""
        self.count = 0
