"""Block tridiagonal systems of 6×6 blocks: a chain of rods solved in one sweep down and one up."""
# pyright: basic

import numpy as np
from numba import njit

__all__ = ["solve_chain"]


@njit(cache=True, error_model="numpy")
def _reduce(w):
    """Gauss–Jordan with row pivoting on the left 6×6 of the 6×16 rows ``w``; smallest |pivot| / largest."""
    low, high = np.inf, 0.0
    for k in range(6):
        best, at = abs(w[k, k]), k
        for i in range(k + 1, 6):
            if abs(w[i, k]) > best:
                best, at = abs(w[i, k]), i
        low, high = min(low, best), max(high, best)
        if not best > 0.0:
            return 0.0
        if at != k:
            for c in range(16):
                w[k, c], w[at, c] = w[at, c], w[k, c]
        f = 1.0 / w[k, k]
        for c in range(16):
            w[k, c] *= f
        for i in range(6):
            if i != k:
                f = w[i, k]
                for c in range(16):
                    w[i, c] -= f * w[k, c]
    return low / high


@njit(cache=True, error_model="numpy")
def solve_chain(blocks, rhs, factors, du):
    """du = K⁻¹ rhs for a block tridiagonal K; returns the row of a vanishing pivot, or −1.

    ``blocks`` (n, 3, 6, 6) are (left, own, right) of every row; ``rhs`` and ``du`` (n, 6);
    ``factors`` (n, 6, 8) is workspace: D⁻¹U (6×6), D⁻¹b (6), unused.
    """
    n = blocks.shape[0]
    w = np.zeros((6, 16))
    for i in range(n):
        own, right = blocks[i, 1], blocks[i, 2]
        for r in range(6):
            for c in range(6):
                w[r, c] = own[r, c]
                w[r, 8 + c] = right[r, c]
            w[r, 14] = rhs[i, r]
        if i > 0:
            left, before = blocks[i, 0], factors[i - 1]
            for r in range(6):
                for k in range(6):
                    f = left[r, k]
                    for c in range(8):
                        w[r, 8 + c] -= f * before[k, c]
                # D − L (D⁻¹U): what was subtracted on the right belongs to the own block
                for c in range(6):
                    w[r, c] += w[r, 8 + c] - right[r, c]
                    w[r, 8 + c] = right[r, c]
        if _reduce(w) < 1e-300:
            return i
        for r in range(6):
            for c in range(8):
                factors[i, r, c] = w[r, 8 + c]
    for r in range(6):
        du[n - 1, r] = factors[n - 1, r, 6]
    for i in range(n - 2, -1, -1):
        for r in range(6):
            s = factors[i, r, 6]
            for c in range(6):
                s -= factors[i, r, c] * du[i + 1, c]
            du[i, r] = s
    return -1
