"""The symmetric tangent of a whole model on its free components: assembled once for a pattern, and what it tells of
stability: how many of its pivots are negative, and which eigenvalues are nearest to zero."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportOptionalSubscript=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.kernels.tables import Tables
from directrix.newton import Newton
from directrix.tangents import group_tangents

if TYPE_CHECKING:  # few runs need it, and it takes as long to import as all of ours
    from scipy.sparse import csc_matrix

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Hessian", "NearZero", "largest_entry", "nearest_zero", "negative_pivots", "not_conservative"]

SMALL = 40  # unknowns up to which a matrix is treated as full
MORE, ROUNDS, SETTLED = 5, 60, 1e-11  # of inverse iteration: more vectors than asked for, rounds, relative change
ROUND_OFF = 1e-14  # of the largest entry: what a pivot has to be to have a sign


class NearZero(NamedTuple):
    """Eigenvalues (k,) nearest to zero, rising, and their vectors (free, k)."""

    values: Array
    vectors: Array


class Hessian:
    """Symmetric part of the tangent at a state: the Hessian in the exponential chart at an equilibrium.

    Nothing is condensed. With ``turn`` = ℓ, spins are measured as ℓ θ, so that all unknowns are lengths and eigenvalues
    are forces per length.
    """

    def __init__(self, newton: Newton, turn: float = 1.0) -> None:
        disc = newton.disc
        self.newton, self.nodes = newton, disc.nodes
        held = disc.fixed.ravel()
        self.free: Ints = np.flatnonzero(~held)
        self.weights: Array = np.tile([1.0, 1.0, 1.0, turn, turn, turn], disc.nodes)
        size = len(self.free)
        number = np.full(len(held), -1, np.int64)
        number[self.free] = np.arange(size)
        self._at: list[Ints] = []
        keys: list[Ints] = []
        for group in disc.groups:
            at: Ints = (6 * group.conn[:, :, None] + np.arange(6)).reshape(len(group.conn), -1)
            self._at.append(at)
            places = number[at]
            rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None, :])
            keys.append(np.where((rows >= 0) & (columns >= 0), columns * size + rows, -1).ravel())
        every = np.concatenate(keys)
        self._kept: Ints = np.flatnonzero(every >= 0)
        entries, self._place = np.unique(every[self._kept], return_inverse=True)
        self._indices, column = entries % size, entries // size
        self._indptr: Ints = np.concatenate([[0], np.cumsum(np.bincount(column, minlength=size))])

    def matrix(self, x: Array, tables: Tables | None = None, common: Array | None = None) -> csc_matrix:
        """The matrix (free, free) at the state ``x``, with other parameters or scalars if they are given."""
        return self.gathered([group_tangents(self.newton, x, k, tables, common=common) for k in range(len(self._at))])

    def gathered(self, blocks: list[Array]) -> csc_matrix:
        """The matrix of element blocks (ne, 6 nn, 6 nn), one array a group, as they are."""
        scaled: list[Array] = []
        for block, at in zip(blocks, self._at, strict=True):
            w = 1.0 / self.weights[at]
            scaled.append((block * w[:, :, None] * w[:, None, :]).ravel())
        return self._gathered(np.concatenate(scaled))

    def _gathered(self, values: Array) -> csc_matrix:
        from scipy.sparse import csc_matrix

        size = len(self.free)
        data = np.bincount(self._place, values[self._kept], len(self._indices))
        return csc_matrix((data, self._indices, self._indptr), shape=(size, size))

    def increment(self, vector: Array) -> Array:
        """An eigenvector (free,) as displacement and spin (n, 6)."""
        out = np.zeros(6 * self.nodes, vector.dtype)
        out[self.free] = vector
        return (out / self.weights).reshape(-1, 6)


def negative_pivots(matrix: csc_matrix, below: float = 0.0) -> int:
    """Number of eigenvalues of a symmetric matrix under −``below``, by the signs of its pivots (Sylvester's law).

    Pivots stay on the diagonal. Where one vanishes the matrix is shifted by round-off.
    """
    from scipy.linalg import eigh
    from scipy.sparse.linalg import splu

    if matrix.shape[0] == 0:
        return 0
    matrix = _shifted(matrix, below)
    size = largest_entry(matrix)
    for shift in (0.0, ROUND_OFF, 1e2 * ROUND_OFF):
        try:
            factor = splu(_shifted(matrix, shift * size), "MMD_AT_PLUS_A", 0.0, options={"SymmetricMode": True})
        except RuntimeError:  # exactly singular
            continue
        if np.array_equal(factor.perm_r, factor.perm_c):
            return int(np.sum(cast("Any", factor).U.diagonal() < 0.0))
    return int(np.sum(eigh(matrix.toarray(), eigvals_only=True) < 0.0))


def nearest_zero(matrix: csc_matrix, count: int) -> NearZero:
    """The ``count`` eigenvalues of a symmetric matrix that are nearest to zero."""
    from scipy.linalg import eigh

    n = matrix.shape[0]
    count = min(count, n)
    if n <= SMALL or 2 * count + MORE > n:
        values, vectors = eigh(matrix.toarray())
    else:
        values, vectors = _by_inverse(matrix, count)
    near = np.argsort(np.abs(values))[:count]
    order = near[np.argsort(values[near])]
    return NearZero(values[order], vectors[:, order])


def _by_inverse(matrix: csc_matrix, count: int) -> tuple[Array, Array]:
    """Inverse iteration with a block, which also sees eigenvalues that are equal."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import splu

    size, factor = largest_entry(matrix), cast("Any", None)
    for shift in (0.0, ROUND_OFF, 1e2 * ROUND_OFF):
        try:
            factor = splu(_shifted(matrix, shift * size))
            break
        except RuntimeError:  # exactly singular
            continue
    # the same run gives the same digits
    block = np.random.default_rng(0).standard_normal((matrix.shape[0], count + MORE))
    before, values = np.zeros(count), np.zeros(0)
    for _ in range(ROUNDS):
        block = np.linalg.qr(factor.solve(block))[0]
        values, turn = eigh(block.T @ (matrix @ block))
        block = block @ turn
        found = np.sort(np.abs(values))[:count]
        if np.all(np.abs(found - before) <= SETTLED * found + 1e-17 * size):
            break
        before = found
    return values, block


def largest_entry(matrix: csc_matrix) -> float:
    """Size of the largest entry."""
    return float(np.abs(matrix.data).max(initial=0.0))


def _shifted(matrix: csc_matrix, by: float) -> csc_matrix:
    if by == 0.0:
        return matrix
    out = matrix.copy()
    out.setdiag(out.diagonal() + by)
    return out


def not_conservative(newton: Newton) -> str:
    """Why stability cannot be read from the symmetric tangent; empty when it can.

    Loads that turn with their node have no potential, nor has a dead moment on a node that can turn about more than one
    axis (Ziegler, 1968).
    """
    disc = newton.disc
    if disc.model.joints:
        return f"joint {disc.model.joints[0].name!r} holds by forces that are unknowns, for which there is no form yet"
    if disc.model.rod_contacts:
        return "rods may touch one another, and the system of equations changes with that"
    for load in disc.loads:
        if load.first >= 6:
            return f"{load.label} turns with its node"
        if load.first == 3 and np.any(np.sum(~disc.fixed[load.nodes, 3:], axis=1) > 1):
            return f"{load.label} has no potential where the node can turn about more than one axis"
    return ""
