"""Fronts: every vertex is eliminated once, the solution is SuperLU's, and no bit depends on the number of threads."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import directrix as dx
from directrix.linear.condensed import Condensed
from directrix.linear.conformance import check_linear
from directrix.linear.dissection import fronts
from directrix.linear.multifrontal import Multifrontal
from directrix.linear.sparse import BlockSparse


def grid(*sizes: int, islands: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """rowptr and column of a grid graph, with vertices joined to nobody behind it."""
    places = list(itertools.product(*(range(n) for n in sizes)))
    index = {place: k for k, place in enumerate(places)}
    near = [{k} for k in range(len(places) + islands)]
    for place, k in index.items():
        for axis in range(len(sizes)):
            j = index.get(tuple(v + (i == axis) for i, v in enumerate(place)))
            if j is not None:
                near[k].add(j)
                near[j].add(k)
    column = np.array([j for row in near for j in sorted(row)])
    return np.cumsum([0, *(len(row) for row in near)]), column


def system(rowptr: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    n = len(rowptr) - 1
    return rng.standard_normal((len(column) + 1, 6, 6)) * 10.0 ** rng.integers(-3, 4, (1, 6, 6)), rng.random((n, 6))


GRIDS = {"plane": grid(15, 14), "cube": grid(6, 6, 6), "line": grid(90), "islands": grid(9, 9, islands=40)}


@pytest.mark.parametrize("name", GRIDS)
def test_every_vertex_goes_once_and_every_edge_is_in_a_front(name: str) -> None:
    rowptr, column = GRIDS[name]
    found = fronts(rowptr, column)
    assert sorted(v for front in found for v in front.pivots) == list(range(len(rowptr) - 1))
    when = {int(v): k for k, front in enumerate(found) for v in front.pivots}
    for k, front in enumerate(found):
        assert all(when[int(v)] > k for v in front.border)
        assert all(c < k for c in front.children)
        inside = {*front.pivots.tolist(), *front.border.tolist()}
        for v in front.pivots:
            near = [j for j in column[rowptr[v] : rowptr[v + 1]] if when[int(j)] >= k]
            assert inside.issuperset(near)
        for c in front.children:
            assert inside.issuperset(found[c].border.tolist())
    children = [c for front in found for c in front.children]
    assert len(children) == len(set(children))
    roots = set(range(len(found))) - set(children)
    assert all(len(found[k].border) == 0 for k in roots)


@pytest.mark.parametrize("name", GRIDS)
def test_the_solution_is_superlus_and_the_same_for_any_number_of_threads(name: str) -> None:
    rowptr, column = GRIDS[name]
    blocks, rhs = system(rowptr, column)
    x, expected = Multifrontal(rowptr, column).solve(blocks, rhs), BlockSparse(rowptr, column).solve(blocks, rhs)
    assert x is not None and expected is not None
    assert np.abs(x - expected).max() <= 1e-8 * np.abs(expected).max()
    for threads in (2, 5):
        again = Multifrontal(rowptr, column, threads).solve(blocks, rhs)
        assert again is not None and again.tobytes() == x.tobytes()


def test_a_front_without_pivots_is_left_to_another_solver() -> None:
    rowptr, column = GRIDS["plane"]
    blocks, rhs = system(rowptr, column)
    pivots = fronts(rowptr, column)[0].pivots
    for row in pivots:  # rows of multipliers alone: nothing on the diagonal of the front
        for at in range(rowptr[row], rowptr[row + 1]):
            if column[at] in pivots:
                blocks[at] = 0.0
    assert Multifrontal(rowptr, column).solve(blocks, rhs) is None
    x, expected = Condensed(rowptr, column).solve(blocks, rhs), BlockSparse(rowptr, column).solve(blocks, rhs)
    if expected is None:
        assert x is None
    else:
        assert x is not None and x.tobytes() == expected.tobytes()


def test_it_passes_the_conformance_test() -> None:
    assert check_linear(Multifrontal, sizes=(1, 7, 40, 150)) <= 1e-9


def test_threads_do_not_change_a_motion() -> None:
    section = dx.Section.circle(radius=0.02, E=1e9, nu=0.3, rho=1000)
    model = dx.Model(name="lattice")
    for place in itertools.product(range(4), range(4), range(6)):
        for axis, size in enumerate((4, 4, 6)):
            other = tuple(v + (k == axis) for k, v in enumerate(place))
            if other[axis] < size:
                ends = ("{}.{}.{}".format(*place), "{}.{}.{}".format(*other))
                model = model.rod(dx.line(place, other), section, name="-".join(ends), ends=ends, elements=2, order=1)
    for place in itertools.product(range(4), repeat=2):
        model = model.clamp("{}.{}.0".format(*place))
    model = model.gravity((0, 0, -9.81))
    one, two = (dx.simulate(model, t_end=0.04, dt=0.02, threads=threads) for threads in (1, 2))
    assert one.success and one.audit.passed
    assert one.r.tobytes() == two.r.tobytes() and one.R.tobytes() == two.R.tobytes()
    with pytest.raises(dx.ModelError, match="threads"):
        dx.simulate(model, t_end=0.04, dt=0.02, threads=0)
