"""Block rows with two neighbours eliminated, strut by strut: what is left are the junctions of a frame.

A strut runs from a junction a through its inner rows to a junction b. Its rows go as in :mod:`directrix.kernels.rows`,
here with row pivoting inside each 6×6.
"""
# pyright: basic, reportCallIssue=false

import numpy as np

from directrix.kernels.jit import compiled, inner

__all__ = ["again", "back", "reduce"]


@inner
def _gauss_jordan(w, columns):
    """Turn the first six columns of ``w`` (6, columns) into the identity; False at a vanishing pivot."""
    for k in range(6):
        best, at = abs(w[k, k]), k
        for i in range(k + 1, 6):
            if abs(w[i, k]) > best:
                best, at = abs(w[i, k]), i
        if not best > 1e-300:
            return False
        if at != k:
            for c in range(k, columns):
                w[k, c], w[at, c] = w[at, c], w[k, c]
        f = 1.0 / w[k, k]
        for c in range(k, columns):
            w[k, c] *= f
        for i in range(6):
            if i != k:
                f = w[i, k]
                for c in range(k, columns):
                    w[i, c] -= f * w[k, c]
    return True


@inner
def _less(to, a, b, first, columns):
    """to −= a · b[:, first : first + columns]."""
    for i in range(6):
        for k in range(6):
            f = a[i, k]
            for c in range(columns):
                to[i, c] -= f * b[k, first + c]


@compiled
def reduce(strut, rows, own, before, after, joints, dest, blocks, rhs, small, small_rhs, kept, factors):
    """Fill the system of the junctions, ``small`` blocks and ``small_rhs``; False where a row cannot be eliminated.

    ``strut`` (struts + 1): where the inner rows of each begin in ``rows``. Per inner row the places of its blocks:
    ``own``, ``before`` (in its row, in the row before it) and ``after`` (in its row, in the row after it). Per strut
    ``joints`` (a, b) and ``dest``, the places of (a, a), (a, b), (b, a), (b, b) in ``small``. ``kept`` (rows, 6, 13)
    receives P, Q, y, and ``factors`` (rows, 6, 18) what :func:`again` needs: D⁻¹, and what of y goes to a and to the
    next row.
    """
    w, d, f, g, b = np.empty((6, 25)), np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6)), np.empty(6)
    for s in range(strut.shape[0] - 1):
        start, stop = strut[s], strut[s + 1]
        head, tail = joints[s, 0], joints[s, 1]
        d[:] = blocks[own[start]]
        f[:] = blocks[before[start, 0]]
        g[:] = blocks[before[start, 1]]
        b[:] = rhs[rows[start]]
        for j in range(start, stop):
            up, low = blocks[after[j, 0]], blocks[after[j, 1]]
            for i in range(6):
                for c in range(6):
                    w[i, c], w[i, 6 + c], w[i, 12 + c] = d[i, c], up[i, c], f[i, c]
                    w[i, 19 + c] = 0.0
                w[i, 18], w[i, 19 + i] = b[i], 1.0
            if not _gauss_jordan(w, 25):
                return False
            for i in range(6):
                for c in range(13):
                    kept[j, i, c] = w[i, 6 + c]
                for c in range(6):
                    factors[j, i, c], factors[j, i, 6 + c], factors[j, i, 12 + c] = w[i, 19 + c], g[i, c], low[i, c]
            _less(small[dest[s, 0]], g, w, 12, 6)
            for i in range(6):
                for k in range(6):
                    small_rhs[head, i] -= g[i, k] * w[k, 18]
            if j == stop - 1:
                _less(small[dest[s, 1]], g, w, 6, 6)
                _less(small[dest[s, 2]], low, w, 12, 6)
                _less(small[dest[s, 3]], low, w, 6, 6)
                for i in range(6):
                    for k in range(6):
                        small_rhs[tail, i] -= low[i, k] * w[k, 18]
            else:
                d[:] = blocks[own[j + 1]]
                f[:] = 0.0
                b[:] = rhs[rows[j + 1]]
                _less(d, low, w, 6, 6)
                _less(f, low, w, 12, 6)
                for i in range(6):
                    for k in range(6):
                        b[i] -= low[i, k] * w[k, 18]
                d_next = np.zeros((6, 6))
                _less(d_next, g, w, 6, 6)
                g[:] = d_next
    return True


@compiled
def again(strut, rows, joints, factors, rhs, small_rhs, kept):
    """``small_rhs`` and y in ``kept`` for another right-hand side, with the ``factors`` of :func:`reduce`."""
    b, y = np.empty(6), np.empty(6)
    for s in range(strut.shape[0] - 1):
        head, tail = joints[s, 0], joints[s, 1]
        b[:] = 0.0
        for j in range(strut[s], strut[s + 1]):
            for i in range(6):
                b[i] += rhs[rows[j], i]
            for i in range(6):
                y[i] = 0.0
                for k in range(6):
                    y[i] += factors[j, i, k] * b[k]
                kept[j, i, 12] = y[i]
            for i in range(6):
                b[i] = 0.0
                for k in range(6):
                    small_rhs[head, i] -= factors[j, i, 6 + k] * y[k]
                    b[i] -= factors[j, i, 12 + k] * y[k]
        for i in range(6):
            small_rhs[tail, i] += b[i]


@compiled
def back(strut, rows, ends, kept, x):
    """Increments of the inner rows from those of the junctions, ``ends`` (struts, 2) as rows of ``x`` (n, 6)."""
    for s in range(strut.shape[0] - 1):
        first = ends[s, 0]
        after = ends[s, 1]
        for j in range(strut[s + 1] - 1, strut[s] - 1, -1):
            row = rows[j]
            for i in range(6):
                value = kept[j, i, 12]
                for k in range(6):
                    value -= kept[j, i, k] * x[after, k] + kept[j, i, 6 + k] * x[first, k]
                x[row, i] = value
            after = row
