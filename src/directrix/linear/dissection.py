"""Nested dissection of a graph (George 1973): in which order a multifrontal solver eliminates the nodes of a frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.kernels import fronts as kernel

Ints = NDArray[np.int64]

__all__ = ["Front", "fronts"]

LEAF = 24
"""Parts of so few vertices are not cut any more."""
WIDTH = 40
"""A front eliminates at most so many vertices."""


class Front(NamedTuple):
    """Vertices eliminated together, ``pivots``, and those they are then joined to, ``border``; the ``children`` are
    fronts, earlier ones, whose borders end here."""

    pivots: Ints
    border: Ints
    children: tuple[int, ...]


def fronts(rowptr: Ints, column: Ints) -> list[Front]:
    """Fronts in the order of elimination for a symmetric pattern; the last has no border, nor has any other root."""
    n = len(rowptr) - 1
    part: Ints = np.zeros(n, np.int64)
    found: list[Front] = []
    gone = np.zeros(n, bool)

    def eliminate(pivots: Ints, children: list[int]) -> list[int]:
        for some in np.array_split(pivots, max(1, -(-len(pivots) // WIDTH))) if len(pivots) else ():
            gone[some] = True
            near = [column[rowptr[v] : rowptr[v + 1]] for v in some]
            border = np.unique(np.concatenate([*near, *(found[c].border for c in children)]))
            found.append(Front(np.sort(some), border[~gone[border]], tuple(children)))
            children = [len(found) - 1]
        return children

    def visit(vertices: Ints) -> list[int]:
        separator, *parts = _cut(rowptr, column, part, vertices)
        return eliminate(separator, [child for some in parts for child in visit(some)])

    visit(np.arange(n))
    return found


def _cut(rowptr: Ints, column: Ints, part: Ints, vertices: Ints) -> list[Ints]:
    """A separator of ``vertices`` and the parts it leaves; small sets are separators as they are.

    ``part`` holds a name for every vertex, the same one for all of ``vertices``; the parts get new ones.
    """
    if len(vertices) <= LEAF:
        return [vertices]
    n, name = len(vertices), int(part[vertices[0]])
    start, best, queue = int(vertices[0]), None, np.empty(n, np.int64)
    distance: Ints = np.empty(len(part), np.int64)
    for _ in range(3):
        distance[vertices] = -1
        reached = kernel.distances(rowptr, column, part, name, start, distance, queue)
        if reached < n:  # not connected: nothing separates the two
            inside = distance[vertices] >= 0
            return _named(part, vertices[:0], vertices[inside], vertices[~inside])
        levels = distance[vertices]
        count = np.bincount(levels)
        below = np.cumsum(count) - count
        above = n - below - count
        fair = np.flatnonzero(np.minimum(below, above) >= 0.3 * n)
        if len(fair):
            cost = count[fair] * (1.0 + np.abs(below - above)[fair] / n)
            at = int(fair[np.argmin(cost)])
            if best is None or cost.min() < best[0]:
                best = float(cost.min()), levels, at
        start = int(queue[n - 1])
    if best is None:
        return [vertices]
    _, levels, at = best
    distance[vertices] = levels
    on = vertices[levels == at]
    far = np.array([np.any((part[near] == name) & (distance[near] > at)) for near in _near(rowptr, column, on)])
    return _named(part, on[far], np.concatenate([vertices[levels < at], on[~far]]), vertices[levels > at])


def _near(rowptr: Ints, column: Ints, vertices: Ints) -> list[Ints]:
    return [column[rowptr[v] : rowptr[v + 1]] for v in vertices]


def _named(part: Ints, separator: Ints, *parts: Ints) -> list[Ints]:
    """Separator and parts, with new names where they have none of their own."""
    last = int(part.max())
    part[separator] = -1
    for k, some in enumerate(parts, 1):
        part[some] = last + k
    return [separator, *parts]
