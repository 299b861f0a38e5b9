"""What a linear solver has to show before it is finished."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["LinearSolver", "check_linear"]


class LinearSolver(Protocol):
    """Analysed for a block pattern."""

    def solve(self, blocks: Array, rhs: Array) -> Array | None:
        """x (n, 6) with K x = rhs, good to round-off, or None for a singular matrix. The factors are kept."""
        ...

    def again(self, rhs: Array) -> Array | None:
        """x for another right-hand side through the factors of the last :meth:`solve`, which must have found one; None
        where they lead to none. It is not corrected: who asks finds out whether the factors are good enough."""
        ...


def check_linear(
    make: Callable[[Ints, Ints], LinearSolver], *, sizes: tuple[int, ...] = (1, 2, 7, 40), seed: int = 0
) -> float:
    """Largest residual |K x − b| / |b| over random connected frames, indefinite and unsymmetric ones among them, for
    one right-hand side with the matrix and two more through its factors."""
    rng = np.random.default_rng(seed)
    worst = 0.0
    for n in sizes:
        near = [{i} for i in range(n)]
        for i in range(1, n):
            for j in {i - 1, *rng.integers(0, i, 2).tolist()}:
                near[i].add(j)
                near[j].add(i)
        column = np.array([j for row in near for j in sorted(row)])
        rowptr = np.cumsum([0, *(len(row) for row in near)])
        solver = make(rowptr, column)
        for shift in (20.0, -20.0, 0.0):
            blocks = rng.standard_normal((len(column) + 1, 6, 6))
            dense = np.zeros((6 * n, 6 * n))
            for i in range(n):
                for b in range(rowptr[i], rowptr[i + 1]):
                    if column[b] == i:
                        blocks[b] += shift * np.diag([1, 1, -1, 1, 1, 1])
                    dense[6 * i : 6 * i + 6, 6 * column[b] : 6 * column[b] + 6] = blocks[b]
            kept = blocks.copy()
            for turn in range(3):
                rhs = 10.0 ** (4 * turn) * rng.standard_normal((n, 6))
                x = solver.again(rhs) if turn else solver.solve(kept, rhs)
                if x is None:
                    return float("inf")
                worst = max(worst, float(np.linalg.norm(dense @ x.ravel() - rhs.ravel()) / np.linalg.norm(rhs)))
                kept[:] = np.nan  # the blocks are the caller's, who writes the next ones over them
    return worst
