"""Struts eliminated to their junctions: the same solution as without."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from directrix.linear.condensed import Condensed
from directrix.linear.conformance import check_linear
from directrix.linear.sparse import BlockSparse

# struts as rows from junction to junction; rows with two neighbours are eliminated
FRAMES = {
    "a cross of four struts": [[0, 4, 5, 1], [0, 6, 2], [0, 7, 8, 9, 3], [0, 10]],
    "two struts side by side": [[0, 2, 1], [0, 3, 4, 1], [0, 1], [0, 5], [1, 6]],
    "a loop at a junction": [[0, 1, 2, 3, 0], [0, 4]],
    "a ring without a junction": [[0, 1, 2, 3, 4, 0]],
}


def system(struts: list[list[int]], seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """rowptr, column, blocks and right-hand side of an unsymmetric system whose inner blocks have no zero pivot."""
    n = 1 + max(max(s) for s in struts)
    near = [{i} for i in range(n)]
    for strut in struts:
        for a, b in itertools.pairwise(strut):
            near[a].add(b)
            near[b].add(a)
    column = np.array([j for row in near for j in sorted(row)])
    rowptr = np.cumsum([0, *(len(row) for row in near)])
    rng = np.random.default_rng(seed)
    return rowptr, column, rng.standard_normal((len(column) + 1, 6, 6)), rng.standard_normal((n, 6))


@pytest.mark.parametrize("name", FRAMES)
def test_the_solution_is_that_of_the_whole_system(name: str) -> None:
    rowptr, column, blocks, rhs = system(FRAMES[name])
    solver = Condensed(rowptr, column)
    x, expected = solver.solve(blocks, rhs), BlockSparse(rowptr, column).solve(blocks, rhs)
    assert solver.usable and len(solver.rows) > 0
    assert x is not None and expected is not None
    assert np.abs(x - expected).max() <= 1e-9 * np.abs(expected).max()
    assert not np.array_equal(x, expected)  # it went its own way
    sides = np.random.default_rng(1).standard_normal((2, *rhs.shape))
    for other in sides:
        again = solver.again(other)
        assert solver.condensed and again is not None
        direct = BlockSparse(rowptr, column).solve(blocks, other)
        assert np.abs(again - direct).max() <= 1e-9 * np.abs(direct).max()


def test_a_row_that_cannot_be_eliminated_goes_the_whole_way() -> None:
    rowptr, column, blocks, rhs = system(FRAMES["a cross of four struts"])
    solver = Condensed(rowptr, column)
    blocks[solver.own[0]] = 0.0  # as of a multiplier
    x = solver.solve(blocks, rhs)
    assert x is not None
    assert np.allclose(x, BlockSparse(rowptr, column).solve(blocks, rhs), rtol=1e-12)
    again = solver.again(2.0 * rhs)
    assert again is not None and np.allclose(again, 2.0 * x, rtol=1e-12)


def test_it_passes_the_conformance_test() -> None:
    assert check_linear(Condensed) <= 1e-10
