"""Rows and blocks of the system, from the elements that join nodes."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.groups import Group

Ints = NDArray[np.int64]

__all__ = ["Pattern", "pattern_of"]


class Pattern(NamedTuple):
    """Block rows of the condensed system. ``row`` (n,) of every node, −1 for interior ones; the blocks of a
    row are ``rowptr[row] : rowptr[row + 1]`` with block columns ``column``; ``dest`` are, element by element,
    the blocks (a, b) of its nodes in the pattern, a fastest; ``first`` is where each group of elements begins there."""

    chain: bool
    row: Ints
    node_of_row: Ints
    rowptr: Ints
    column: Ints
    diagonal: Ints
    dest: Ints
    first: tuple[int, ...]


def pattern_of(n: int, groups: Sequence[Group]) -> Pattern:
    """Numbering and blocks for the elements of ``groups``."""
    conn = [group.in_pattern for group in groups]
    joined = conn[0]
    in_line = len(conn) == 1 and joined.shape[1] == 2 and np.array_equal(joined[1:, 0], joined[:-1, 1])
    if in_line and len(np.unique(joined)) == len(joined) + 1:
        return _in_line(n, np.append(joined[:, 0], joined[-1, 1]))
    ends = np.unique(np.concatenate([c.ravel() for c in conn]))
    near: dict[int, list[int]] = {int(k): [] for k in ends}
    for elements in conn:
        for a, b in itertools.permutations(range(elements.shape[1]), 2):
            for here, there in elements[:, [a, b]].tolist():
                if there not in near[here]:  # a tendon beside a rod joins no more than the rod does
                    near[here].append(there)
    order: list[int] = []
    seen: set[int] = set()
    for start in [k for k in near if len(near[k]) == 1]:
        k: int | None = start
        while k is not None and k not in seen:
            seen.add(k)
            order.append(k)
            k = next((m for m in near[k] if m not in seen), None)
    chain = len(order) == len(near) and all(len(m) <= 2 for m in near.values())
    if not chain:
        order = [int(k) for k in ends]
    row = np.full(n, -1, np.int64)
    row[order] = np.arange(len(order))
    if chain:
        rows = [[i - 1, i, i + 1] for i in range(len(order))]
    else:
        rows = [sorted({i, *(int(row[m]) for m in near[k])}) for i, k in enumerate(order)]
    rowptr = np.cumsum([0, *(len(r) for r in rows)])
    at = [{c: int(rowptr[i]) + j for j, c in enumerate(r)} for i, r in enumerate(rows)]
    dest = [
        [at[force][increment] for nodes in row[elements].tolist() for increment in nodes for force in nodes]
        for elements in conn
    ]
    return Pattern(
        chain,
        row,
        np.array(order, np.int64),
        rowptr.astype(np.int64),
        np.array([c for r in rows for c in r], np.int64),
        np.array([at[i][i] for i in range(len(rows))], np.int64),
        np.concatenate([np.array(d, np.int64) for d in dest]),
        tuple(itertools.accumulate((len(d) for d in dest[:-1]), initial=0)),
    )


def _in_line(n: int, order: Ints) -> Pattern:
    """The pattern of elements that follow one another along the nodes ``order``."""
    rows = np.arange(len(order))
    row = np.full(n, -1, np.int64)
    row[order] = rows
    own = 3 * rows + 1
    return Pattern(
        True, row, order, np.append(3 * rows, 3 * len(rows)), (rows[:, None] + np.arange(-1, 2)).ravel(), own,
        np.stack([own[:-1], own[:-1] + 2, own[:-1] + 1, own[1:]], -1).ravel(), (0,),
    )  # fmt: skip
