"""Sparse 6×6 blocks through SuperLU, for frames that are not a chain."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["BlockSparse"]


class BlockSparse:
    """Analyse a block pattern once, then solve for many values.

    The fill-reducing order is found once for the pattern; values go to their places by one permutation. Rows and
    columns are scaled alike, so that multipliers of joints weigh as much as stiffnesses of any size: pivots are chosen,
    and residuals judged, among comparable numbers. A solution whose residual is not small is computed again with
    full pivoting.

    Parameters
    ----------
    rowptr, column
        Block pattern: block row i holds the blocks ``rowptr[i] : rowptr[i + 1]`` in block columns ``column``
        (blocks with a column outside 0 … n−1 are ignored). The pattern is structurally symmetric.
    """

    def __init__(self, rowptr: Ints, column: Ints) -> None:
        from scipy.sparse import csc_matrix

        n = len(rowptr) - 1
        self.size = 6 * n
        block_row = np.repeat(np.arange(n), np.diff(rowptr))
        real = (column >= 0) & (column < n)
        i, j = np.meshgrid(np.arange(6), np.arange(6), indexing="ij")
        rows = (6 * block_row[real, None, None] + i).ravel()
        columns = (6 * column[real, None, None] + j).ravel()
        entries = (36 * np.flatnonzero(real)[:, None, None] + 6 * i + j).ravel()
        probe = csc_matrix((np.where(rows == columns, 1e3, 1.0), (rows, columns)), shape=(self.size, self.size))
        self._order = np.asarray(_factor(probe, "MMD_AT_PLUS_A").perm_c)
        place = self._order  # perm_c[i] is where row and column i go
        tag = csc_matrix((np.arange(1, len(rows) + 1), (place[rows], place[columns])), shape=probe.shape)
        tag.sort_indices()
        self._indices, self._indptr = tag.indices, tag.indptr
        self._columns = np.repeat(np.arange(self.size), np.diff(tag.indptr))
        self._entries: Ints = entries[np.asarray(tag.data, np.int64) - 1]
        self._factors: Any = None
        self._sizes: Array = np.ones(self.size)

    def solve(self, blocks: Array, rhs: Array, *, at_limit: bool = False) -> Array | None:
        """x with K x = rhs, or None when K is singular. ``blocks`` (blocks, 6, 6), ``rhs`` and x (…, n, 6).

        ``at_limit`` says that K may be as good as singular, where only the direction of x counts: its residual is then
        compared with |K||x| too.
        """
        from scipy.sparse import csc_matrix

        data = blocks.ravel()[self._entries]
        self._factors = None  # room for the next ones
        scale = self._sizes = self._scale(data)
        data = data * scale[self._indices] * scale[self._columns]
        matrix = csc_matrix((data, self._indices, self._indptr), shape=(self.size, self.size))
        b = self._placed(rhs)
        size = np.linalg.norm(b, axis=0)
        for spec, pivot in (("NATURAL", 1e-3), ("COLAMD", 1.0)):
            try:
                factors = _factor(matrix, spec, pivot)
            except RuntimeError:  # SuperLU: the factor is exactly singular
                continue
            x = factors.solve(b)
            allowed = size + np.abs(data).max() * np.linalg.norm(x, axis=0) if at_limit else size
            if np.all(np.linalg.norm(b - matrix @ x, axis=0) <= 1e-8 * allowed):
                self._factors = factors
                return self._back(x, rhs)
        return None

    def again(self, rhs: Array) -> Array:
        """See :meth:`LinearSolver.again`."""
        return self._back(self._factors.solve(self._placed(rhs)), rhs)

    def _placed(self, rhs: Array) -> Array:
        """Scaled right-hand sides (size, many) in the order of the factors."""
        b = np.empty((self.size, rhs.size // self.size))
        b[self._order] = rhs.reshape(-1, self.size).T
        b *= self._sizes[:, None]
        return b

    def _back(self, x: Array, rhs: Array) -> Array:
        return (self._sizes[:, None] * x)[self._order].T.reshape(rhs.shape)

    def _scale(self, data: Array) -> Array:
        """D (size,) that brings the largest entry of every column of D K D towards 1 (Ruiz 2001, three rounds)."""
        size, scale = np.abs(data), np.ones(self.size)
        for _ in range(3):
            largest = np.maximum.reduceat(size, self._indptr[:-1])
            factor = 1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0))
            scale *= factor
            size *= factor[self._indices] * factor[self._columns]
        return scale


def _factor(matrix: Any, spec: str, pivot: float = 1e-3) -> Any:
    from scipy.sparse.linalg import splu

    symmetric = pivot < 1.0
    return splu(matrix, permc_spec=spec, diag_pivot_thresh=pivot, options={"SymmetricMode": symmetric})
