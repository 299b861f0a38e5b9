"""General frames by dense fronts: nested dissection and LAPACK, after Duff and Reid (1983)."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from directrix.kernels import fronts as kernel
from directrix.linear.blocks import Blocks
from directrix.linear.dissection import Front, fronts
from directrix.threads import Share, crew, in_turn

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Multifrontal"]

getrf, getrs = get_lapack_funcs(("getrf", "getrs"), dtype=np.float64)

LITTLE = 1e-8
"""Of the largest entries of a row, on its diagonal."""
SLAB = 192
"""Columns of a front that one thread takes at a time."""
PIECES = 16
"""Into about so many independent parts the tree of fronts is cut."""


class Multifrontal:
    """Analyse a block pattern once, then solve for many values, with most of the work in products of dense matrices.

    Rows and columns are scaled alike (see :class:`directrix.linear.sparse.BlockSparse`). Pivots are chosen inside a
    front alone, and rows with nothing on the diagonal, as of multipliers, get a little, whose effect is corrected
    afterwards: so every order is as good as another (Vanderbei 1995). Where that is not enough, :meth:`solve` returns
    None, and another solver has to be asked.

    Parameters
    ----------
    rowptr, column
        As for :class:`directrix.linear.sparse.BlockSparse`.
    threads
        How many threads share the work. The solution is the same for any number, bit by bit.
    """

    def __init__(self, rowptr: Ints, column: Ints, threads: int = 1) -> None:
        self.rowptr, self.column, self.threads = rowptr, column, threads
        n = len(rowptr) - 1
        row = np.repeat(np.arange(n), np.diff(rowptr))
        real = np.flatnonzero((column >= 0) & (column < n))
        row, column = row[real], column[real]
        self._own = real[row == column]
        found = fronts(np.concatenate([[0], np.cumsum(np.bincount(row, minlength=n))]), column)
        when = np.empty(n, np.int64)
        for k, front in enumerate(found):
            when[front.pivots] = k
        owner = np.minimum(when[row], when[column])
        order = np.argsort(owner, kind="stable")
        cuts = np.searchsorted(owner[order], np.arange(len(found) + 1))
        parts = [order[a:b] for a, b in pairwise(cuts)]
        self._fronts = [
            _placed(front, found, real[some], row[some], column[some]) for front, some in zip(found, parts, strict=True)
        ]
        self._branches, self._trunk = _branches(found)
        self._factors: list[_Factor] = []
        self._scale: Array = np.ones((n, 6))

    def solve(self, blocks: Array, rhs: Array) -> Array | None:
        """x with K x = rhs, both (n, 6), or None where pivots inside the fronts are not enough."""
        whole = Blocks(self.rowptr, self.column, blocks)
        filled = self._filled(whole)
        self._factors, self._scale = [], whole.scale  # room for the next ones
        try:
            self._factors = self._factored(whole.blocks if filled is None else filled, whole.scale)
        except _VanishingPivotError:
            return None
        if filled is not None and not whole.regular(self._substituted):
            return None
        return whole.refined(rhs, self._substituted)

    def _filled(self, whole: Blocks) -> Array | None:
        """The blocks with LITTLE where a row has less than that on the diagonal; None where all have more.

        It is taken away: multipliers then oppose what they hold, as stiffness does what is free.
        """
        diagonal = whole.scale**2 * np.einsum("kii->ki", whole.blocks[self._own])
        bare = np.abs(diagonal) < LITTLE
        if not bare.any():
            return None
        blocks = whole.blocks.copy()
        for k in range(6):
            blocks[self._own, k, k] -= np.where(bare[:, k], LITTLE / whole.scale[:, k] ** 2, 0.0)
        return blocks

    def again(self, rhs: Array) -> Array:
        """See :meth:`LinearSolver.again`."""
        return self._scale * self._substituted(self._scale * rhs)

    def _factored(self, blocks: Array, scale: Array) -> list[_Factor]:
        left, factors = dict[int, Array](), dict[int, _Factor]()

        def eliminate(k: int, share: Share = in_turn) -> None:
            children = [(left.pop(c), place) for c, place in self._fronts[k].children]
            factors[k], left[k] = _eliminated(self._fronts[k], children, blocks, scale, share)

        def grow(branch: list[int]) -> None:
            for k in branch:
                eliminate(k)

        with crew(self.threads) as share:
            share(grow, self._branches)
            for k in self._trunk:
                eliminate(k, share)
        return [factors[k] for k in range(len(self._fronts))]

    def _substituted(self, b: Array) -> Array:
        """x (n, 6) with D K D x = b."""
        x = b.copy()
        for front, factor in zip(self._fronts, self._factors, strict=True):
            y = getrs(factor.lu, factor.swaps, x[front.pivots].ravel())[0]
            x[front.border] -= (factor.lower @ y).reshape(-1, 6)
            x[front.pivots] = y.reshape(-1, 6)
        for front, factor in zip(reversed(self._fronts), reversed(self._factors), strict=True):
            x[front.pivots] -= (factor.upper @ x[front.border].ravel()).reshape(-1, 6)
        return x


class _VanishingPivotError(Exception):
    pass


class _Placed(NamedTuple):
    """A front, and where its own blocks and what its children leave go."""

    pivots: Ints
    border: Ints
    entries: Ints
    rows: Ints
    columns: Ints
    at_row: Ints
    at_column: Ints
    children: tuple[tuple[int, Ints], ...]


class _Factor(NamedTuple):
    """F11 = L U with its row swaps, F21, and F11⁻¹ F12."""

    lu: Array
    swaps: Any
    lower: Array
    upper: Array


def _placed(front: Front, found: list[Front], entries: Ints, row: Ints, column: Ints) -> _Placed:
    vertices = np.concatenate([front.pivots, front.border])
    order = np.argsort(vertices)

    def where(some: Ints) -> Ints:
        return order[np.searchsorted(vertices, some, sorter=order)]

    children = tuple((c, where(found[c].border)) for c in front.children)
    return _Placed(front.pivots, front.border, entries, row, column, where(row), where(column), children)


def _eliminated(
    front: _Placed, children: list[tuple[Array, Ints]], blocks: Array, scale: Array, share: Share
) -> tuple[_Factor, Array]:
    """The pivots of a front eliminated, and F22 − F21 F11⁻¹ F12, which is left to the border."""
    p, q, pivots = 6 * len(front.pivots), 6 * len(front.border), len(front.pivots)
    f11, f12, f21, f22 = (np.zeros(shape, order="F") for shape in ((p, p), (p, q), (q, p), (q, q)))
    left, right = scale[front.rows], scale[front.columns]
    kernel.gather(front.entries, front.at_row, front.at_column, blocks, left, right, pivots, f11, f12, f21)
    for child, place in children:
        kernel.extend(child, place, pivots, f11, f12, f21, f22)
    lu, swaps, info = getrf(f11, overwrite_a=True)
    if info != 0:
        raise _VanishingPivotError

    def slab(first: int) -> None:
        part = slice(first, first + SLAB)
        f12[:, part] = getrs(lu, swaps.copy(), f12[:, part])[0]  # SciPy counts the swaps from 1 in place
        f22[:, part] -= f21 @ f12[:, part]

    share(slab, range(0, q, SLAB))
    return _Factor(lu, swaps, f21, f12), f22


def _branches(found: list[Front]) -> tuple[list[list[int]], list[int]]:
    """The tree of fronts cut into branches of like work, most work first, and the trunk they grow on."""
    work = np.array([len(f.pivots) * (len(f.pivots) + len(f.border)) ** 2 for f in found], float)
    members = [[k] for k in range(len(found))]
    for k, front in enumerate(found):
        for c in front.children:
            work[k] += work[c]
            members[k] = members[c] + members[k]
    roots = set(range(len(found))) - {c for f in found for c in f.children}
    most = sum(work[k] for k in roots) / PIECES
    branches: list[int] = []
    trunk: list[int] = []
    waiting = sorted(roots)
    while waiting:
        k = waiting.pop()
        if work[k] <= most or not found[k].children:
            branches.append(k)
        else:
            trunk.append(k)
            waiting += found[k].children
    branches.sort(key=lambda k: -work[k])
    return [sorted(members[k]) for k in branches], sorted(trunk)
