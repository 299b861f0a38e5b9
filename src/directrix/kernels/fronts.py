"""The loops of the multifrontal solver: graph distances, equilibration, and what goes where in a front."""
# pyright: basic, reportCallIssue=false

import math

from directrix.kernels.jit import compiled

__all__ = ["distances", "equilibrate", "extend", "gather", "residual"]


@compiled
def distances(rowptr, column, part, name, start, distance, queue):
    """Breadth first through the vertices whose ``part`` is ``name``: ``distance`` from ``start``, order in ``queue``.

    Returns how many were reached. ``distance`` is −1 where nobody was yet.
    """
    queue[0], distance[start] = start, 0
    first, last = 0, 1
    while first < last:
        v = queue[first]
        first += 1
        for at in range(rowptr[v], rowptr[v + 1]):
            c = column[at]
            if part[c] == name and distance[c] < 0:
                distance[c] = distance[v] + 1
                queue[last] = c
                last += 1
    return last


@compiled
def equilibrate(rowptr, column, blocks, rounds, scale, largest):
    """Fill D = ``scale`` (n, 6), which brings the largest entry of every column of D K D towards 1 (Ruiz 2001).

    ``largest`` (n, 6) is room to work in."""
    n = scale.shape[0]
    scale[:] = 1.0
    for _round in range(rounds):
        largest[:] = 0.0
        for row in range(n):
            for at in range(rowptr[row], rowptr[row + 1]):
                c = column[at]
                if 0 <= c < n:
                    for i in range(6):
                        for k in range(6):
                            size = abs(blocks[at, i, k]) * scale[row, i] * scale[c, k]
                            largest[c, k] = max(largest[c, k], size)
        for row in range(n):
            for i in range(6):
                if largest[row, i] > 0.0:
                    scale[row, i] /= math.sqrt(largest[row, i])


@compiled
def gather(entries, rows, columns, blocks, left, right, pivots, f11, f12, f21):
    """Blocks ``entries`` scaled by ``left`` and ``right`` (6 each) into a front, at its block rows and columns."""
    for e in range(entries.shape[0]):
        block = blocks[entries[e]]
        a, b = rows[e], columns[e]
        for k in range(6):
            for i in range(6):
                value = block[i, k] * left[e, i] * right[e, k]
                if a < pivots and b < pivots:
                    f11[6 * a + i, 6 * b + k] += value
                elif a < pivots:
                    f12[6 * a + i, 6 * (b - pivots) + k] += value
                else:
                    f21[6 * (a - pivots) + i, 6 * b + k] += value


@compiled
def extend(child, place, pivots, f11, f12, f21, f22):
    """Add the matrix that a ``child`` leaves to a front: its block q belongs at ``place[q]``."""
    size = place.shape[0]
    for q in range(size):
        b = place[q]
        for p in range(size):
            a = place[p]
            for k in range(6):
                for i in range(6):
                    value = child[6 * p + i, 6 * q + k]
                    if a < pivots:
                        if b < pivots:
                            f11[6 * a + i, 6 * b + k] += value
                        else:
                            f12[6 * a + i, 6 * (b - pivots) + k] += value
                    elif b < pivots:
                        f21[6 * (a - pivots) + i, 6 * b + k] += value
                    else:
                        f22[6 * (a - pivots) + i, 6 * (b - pivots) + k] += value


@compiled
def residual(rowptr, column, blocks, scale, rhs, x, out):
    """Fill ``out`` with D (b − K x) for D = ``scale``; all (n, 6)."""
    n = rhs.shape[0]
    for row in range(n):
        for i in range(6):
            value = rhs[row, i]
            for at in range(rowptr[row], rowptr[row + 1]):
                c = column[at]
                if 0 <= c < n:
                    for k in range(6):
                        value -= blocks[at, i, k] * x[c, k]
            out[row, i] = scale[row, i] * value
