"""What solvers ask of a matrix of 6×6 blocks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from directrix.kernels import fronts as kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Blocks", "Scalars"]

GOOD = 1e-8
"""Residual over right-hand side, both scaled, of a solution."""
REFINEMENTS = 2
"""Corrections of a solution that is not good enough yet."""


class Blocks:
    """A matrix K in block rows, with D (n, 6) that scales its rows and columns alike: D K D has entries near 1.

    So multipliers of joints weigh as much as stiffnesses of any size.
    """

    def __init__(self, rowptr: Ints, column: Ints, blocks: Array) -> None:
        self.rowptr, self.column, self.blocks = rowptr, column, np.ascontiguousarray(blocks)
        self.scale: Array = np.empty((len(rowptr) - 1, 6))
        kernel.equilibrate(rowptr, column, self.blocks, 3, self.scale, np.empty_like(self.scale))

    def off(self, rhs: Array, x: Array) -> Array:
        """D (b − K x), all (n, 6)."""
        out = np.empty_like(self.scale)
        kernel.residual(
            self.rowptr, self.column, self.blocks, self.scale, np.ascontiguousarray(rhs), np.ascontiguousarray(x), out
        )
        return out

    def refined(self, rhs: Array, solve: Callable[[Array], Array | None]) -> Array | None:
        """x with K x = rhs from ``solve(b)``, x with D K D x = b, corrected until it is good; None where it is not.

        ``solve`` may give None, and is asked again at most REFINEMENTS times, for what is left.
        """
        off = self.scale * rhs
        x = np.zeros_like(off)
        for _ in range(REFINEMENTS + 1):
            part = solve(off)
            if part is None:
                return None
            x += self.scale * part
            off = self.off(rhs, x)
            if self.solved(rhs, off):
                return x
        return None

    def regular(self, solve: Callable[[Array], Array | None]) -> bool:
        """Whether ``solve``, as in :meth:`refined`, works for right-hand sides in general.

        Where vanishing pivots are lifted a singular matrix has factors too, and a right-hand side that it can reach,
        such as nothing on a row of zeros, a solution.
        """
        anything = np.random.default_rng(0).standard_normal(self.scale.shape)
        return self.refined(anything / self.scale, solve) is not None

    def solved(self, rhs: Array, off: Array) -> bool:
        """Whether what is left of a solution, see :meth:`off`, is small enough."""
        return bool(np.linalg.norm(off) <= GOOD * np.linalg.norm(self.scale * rhs))


class Scalars:
    """The scalar rows of some block rows, compressed, with columns in order.

    Parameters
    ----------
    rowptr, column
        As for :class:`directrix.linear.sparse.BlockSparse`.
    first, last
        Block rows ``first`` … ``last`` − 1; all unless given.
    """

    def __init__(self, rowptr: Ints, column: Ints, first: int = 0, last: int | None = None) -> None:
        n = len(rowptr) - 1
        last = n if last is None else last
        row = np.repeat(np.arange(n), np.diff(rowptr))
        here = np.flatnonzero((column >= 0) & (column < n) & (row >= first) & (row < last))[:, None, None]
        i, j = np.meshgrid(np.arange(6), np.arange(6), indexing="ij")
        rows, columns = (6 * row[here] + i).ravel(), (6 * column[here] + j).ravel()
        order = np.lexsort((columns, rows))
        self._rows, self._entries = rows[order], (36 * here + 6 * i + j).ravel()[order]
        self.columns: Ints = columns[order]
        """Scalar columns (entries,)."""
        counts = np.bincount(rows - 6 * first, minlength=6 * (last - first))
        self.rowptr: Ints = np.concatenate([[0], np.cumsum(counts)])
        """Scalar row i, counted from the first, holds the entries ``rowptr[i] : rowptr[i + 1]``."""

    def values(self, blocks: Array, scale: Array) -> Array:
        """Entries of D K D, D (n, 6) as in :class:`Blocks`."""
        size = scale.ravel()
        return size[self._rows] * blocks.ravel()[self._entries] * size[self.columns]
