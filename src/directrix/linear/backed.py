"""A solver that may give up, and SuperLU behind it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from directrix.linear.conformance import LinearSolver
from directrix.linear.sparse import BlockSparse

Array = NDArray[np.float64]

__all__ = ["Backed"]


class Backed:
    """As :class:`BlockSparse`, with another solver for the same pattern that is asked first.

    At a limit SuperLU alone is asked: there only the direction of a solution counts, and its residual is not small.
    """

    def __init__(self, first: LinearSolver, last: BlockSparse) -> None:
        self.first, self.last = first, last
        self.asked: LinearSolver = last  # whose factors are there

    def solve(self, blocks: Array, rhs: Array, *, at_limit: bool = False) -> Array | None:
        """See :meth:`BlockSparse.solve`."""
        if not at_limit:
            found = [self.first.solve(blocks, b) for b in rhs.reshape(-1, *rhs.shape[-2:])]
            if all(x is not None for x in found):
                self.asked = self.first
                return np.array(found).reshape(rhs.shape)
        self.asked = self.last
        return self.last.solve(blocks, rhs, at_limit=at_limit)

    def again(self, rhs: Array) -> Array | None:
        """See :meth:`LinearSolver.again`."""
        return self.asked.again(rhs)
