"""Frames: struts eliminated to the junctions they join, the junctions by dense fronts, SuperLU or a package."""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from directrix.kernels import struts
from directrix.linear.backed import Backed
from directrix.linear.blocks import Blocks
from directrix.linear.conformance import LinearSolver
from directrix.linear.sparse import BlockSparse

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Condensed", "Make", "usual"]

MANY = 64
"""From so many junctions on fronts are quicker than SuperLU."""


Make = Callable[[Ints, Ints, Ints], LinearSolver]


def usual(threads: int = 1) -> Make:
    """The solvers that need nothing but SciPy."""

    def make(rowptr: Ints, column: Ints, rows: Ints) -> LinearSolver:
        if len(rows) < MANY:
            return BlockSparse(rowptr, column)
        from directrix.linear.multifrontal import Multifrontal  # brings scipy.linalg, which few models need

        return Multifrontal(rowptr, column, threads)

    return make


class Condensed:
    """As :class:`BlockSparse`, for patterns in which many rows have just two neighbours.

    Those rows are eliminated along their struts, and only the junctions are left: many of them go to
    :class:`Multifrontal`, a few to SuperLU. A system that cannot be solved so, as where joints have multipliers, or
    whose solution does not satisfy it, goes whole to the solver for many junctions, and to :class:`BlockSparse`.

    Parameters
    ----------
    rowptr, column
        As for :class:`BlockSparse`.
    make
        Makes the solver for the junctions from their pattern and their rows in the whole, and that for the whole; by
        default :class:`Multifrontal` for many rows, :class:`BlockSparse` for a few.
    """

    def __init__(self, rowptr: Ints, column: Ints, make: Make | None = None) -> None:
        self.rowptr, self.column, self.make = rowptr, column, make or usual()
        self.condensed = False  # whether the factors that are there are those of struts and junctions
        n = len(rowptr) - 1
        place: list[dict[int, int]] = [
            {int(column[k]): int(k) for k in range(rowptr[i], rowptr[i + 1]) if 0 <= column[k] < n} for i in range(n)
        ]
        chains, junctions = _struts([[j for j in row if j != i] for i, row in enumerate(place)])
        self.junctions = np.array(junctions, np.int64)
        index = {row: k for k, row in enumerate(junctions)}
        self.usable = bool(junctions) and (bool(chains) or n >= MANY)
        if not self.usable:
            return
        near: list[set[int]] = [{k, *(index[j] for j in place[row] if j in index)} for k, row in enumerate(junctions)]
        for chain in chains:
            a, b = index[chain[0]], index[chain[-1]]
            near[a].add(b)
            near[b].add(a)
        self.small_ptr: Ints = np.cumsum([0, *(len(row) for row in near)])
        small_column = [j for row in near for j in sorted(row)]
        at = [{j: int(self.small_ptr[k]) + q for q, j in enumerate(sorted(row))} for k, row in enumerate(near)]
        direct = [
            (at[k][index[j]], there) for k, row in enumerate(junctions) for j, there in place[row].items() if j in index
        ]
        self.direct = _pairs(direct)
        self.strut: Ints = np.cumsum([0, *(len(chain) - 2 for chain in chains)])
        inner = [(a, i, b) for chain in chains for a, i, b in zip(chain, chain[1:], chain[2:], strict=False)]
        self.rows = np.array([i for _, i, _ in inner], np.int64)
        self.own = np.array([place[i][i] for _, i, _ in inner], np.int64)
        self.before = _pairs((place[i][a], place[a][i]) for a, i, _ in inner)
        self.after = _pairs((place[i][b], place[b][i]) for _, i, b in inner)
        ends = [(index[chain[0]], index[chain[-1]]) for chain in chains]
        self.joints = _pairs(ends)
        self.ends = _pairs((chain[0], chain[-1]) for chain in chains)
        self.dest = np.array([(at[a][a], at[a][b], at[b][a], at[b][b]) for a, b in ends], np.int64).reshape(-1, 4)
        self.kept, self.factors = np.zeros((len(inner), 6, 13)), np.zeros((len(inner), 6, 18))
        self.small = self.make(self.small_ptr, np.array(small_column, np.int64), self.junctions)

    @cached_property
    def plain(self) -> BlockSparse | Backed:
        """The solver for the whole pattern, made when it is needed."""
        last = BlockSparse(self.rowptr, self.column)
        n = len(self.rowptr) - 1
        if not MANY <= len(self.junctions) < n:  # all of them: the same has been asked already
            return last
        return Backed(self.make(self.rowptr, self.column, np.arange(n)), last)

    def solve(self, blocks: Array, rhs: Array, *, at_limit: bool = False) -> Array | None:
        """See :meth:`BlockSparse.solve`."""
        self.condensed = self.usable and not at_limit and (rhs.ndim == 2 or not isinstance(self.small, BlockSparse))
        if self.condensed:
            found = self._condensed(blocks, rhs.reshape(-1, *rhs.shape[-2:]))
            if found is not None:
                return found.reshape(rhs.shape)
            self.condensed = False
        return self.plain.solve(blocks, rhs, at_limit=at_limit)

    def again(self, rhs: Array) -> Array | None:
        """See :meth:`LinearSolver.again`."""
        return self._through(rhs) if self.condensed else self.plain.again(rhs)

    def _condensed(self, blocks: Array, sides: Array) -> Array | None:
        """Solutions for ``sides`` (many, n, 6); None where one of them is not good."""
        whole = Blocks(self.rowptr, self.column, blocks)
        found: list[Array] = []
        for b in sides:
            x = self._through(b) if found else self._factored(blocks, b)
            if x is None or not whole.solved(b, whole.off(b, x)):
                return None
            found.append(x)
        return np.array(found)

    def _factored(self, blocks: Array, rhs: Array) -> Array | None:
        small = np.zeros((int(self.small_ptr[-1]) + 1, 6, 6))
        small[self.direct[:, 0]] = blocks[self.direct[:, 1]]
        small_rhs = rhs[self.junctions].copy()
        if not struts.reduce(
            self.strut, self.rows, self.own, self.before, self.after, self.joints, self.dest, blocks, rhs, small,
            small_rhs, self.kept, self.factors,
        ):  # fmt: skip
            return None
        return self._spread(self.small.solve(small, small_rhs), rhs)

    def _through(self, rhs: Array) -> Array | None:
        small_rhs = rhs[self.junctions].copy()
        struts.again(self.strut, self.rows, self.joints, self.factors, rhs, small_rhs, self.kept)
        return self._spread(self.small.again(small_rhs), rhs)

    def _spread(self, at_junctions: Array | None, rhs: Array) -> Array | None:
        """All rows from those of the junctions."""
        if at_junctions is None:
            return None
        x = np.zeros_like(rhs)
        x[self.junctions] = at_junctions
        struts.back(self.strut, self.rows, self.ends, self.kept, x)
        return x


def _pairs(pairs: Iterable[tuple[int, int]]) -> Ints:
    return np.array(list(pairs), np.int64).reshape(-1, 2)


def _struts(near: list[list[int]]) -> tuple[list[list[int]], list[int]]:
    """Struts as rows from junction to junction, and the junctions: rows with other than two neighbours, and one of
    every ring that has none."""
    inner = [len(row) == 2 for row in near]
    seen = [not flag for flag in inner]

    def walk(before: int, row: int) -> list[int]:
        path = [before]
        while inner[row] and not seen[row]:
            seen[row] = True
            path.append(row)
            before, row = row, next(j for j in near[row] if j != before)
        return [*path, row]

    chains: list[list[int]] = []
    for start in [i for i, flag in enumerate(inner) if not flag]:
        chains += [walk(start, j) for j in near[start] if not seen[j]]
    for start, done in enumerate(seen):
        if not done:  # a ring
            inner[start], seen[start] = False, True
            chains += [walk(start, j) for j in near[start] if not seen[j]]
    return chains, [i for i, flag in enumerate(inner) if not flag]
