"""Block tridiagonal systems of 6×6 blocks: a chain of rods solved in one sweep down and one up."""
# pyright: basic, reportCallIssue=false

import numpy as np

from directrix.kernels.call import FACTORS, call_elimination
from directrix.kernels.jit import compiled, inner

__all__ = ["solve_chain"]


@inner
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


@inner
def _eliminate(row, before, rhs, out):
    """What the machine code of :mod:`elimination` does, with pivoting; smallest |pivot| / largest."""
    w = np.zeros((6, 16))
    for r in range(6):
        for c in range(6):
            w[r, c] = row[1, r, c]
            w[r, 8 + c] = row[2, r, c]
        w[r, 14] = rhs[r]
        for k in range(6):
            f = row[0, r, k]
            for c in range(6):
                w[r, c] -= f * before[8 * k + c]
            w[r, 14] -= f * before[8 * k + 6]
    quality = _reduce(w)
    for r in range(6):
        for c in range(8):
            out[8 * r + c] = w[r, 8 + c]
    return quality


@compiled
def solve_chain(eliminate, blocks, rhs, factors, du):
    """du = K⁻¹ rhs for a block tridiagonal K; returns the row of a vanishing pivot, or −1.

    ``eliminate`` is the address of the fast elimination. ``blocks`` (≥ 3n + 1, 6, 6): rows of (left, own, right),
    the left of the first and the right of the last row zero; ``rhs`` and ``du`` (n, 6); ``factors`` (n + 1, 56) is
    workspace whose first row is zero, then per row D⁻¹U and D⁻¹b as six rows of eight, and a flag.
    """
    n = rhs.shape[0]
    flat, right, kept, x = blocks.reshape(-1), rhs.reshape(-1), factors.reshape(-1), du.reshape(-1)
    for i in range(n):
        at = FACTORS * (i + 1)
        call_elimination(eliminate, flat, 108 * i, right, 6 * i, kept, at)
        if (
            kept[at + 48] != 1.0
            and not _eliminate(blocks[3 * i : 3 * i + 3], factors[i], rhs[i], factors[i + 1]) > 1e-300
        ):
            return i
    for r in range(6):
        du[n - 1, r] = factors[n, 8 * r + 6]
    for i in range(n - 2, -1, -1):
        at = FACTORS * (i + 1)
        for r in range(6):
            s = kept[at + 8 * r + 6]
            for c in range(6):
                s -= kept[at + 8 * r + c] * x[6 * i + 6 + c]
            x[6 * i + r] = s
    return -1
