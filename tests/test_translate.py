"""Compiled loops compute what the same functions compute as plain Python."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from directrix.kernels.jit import compiled, inner
from directrix.kernels.record import Record

SIZE = 3


class Table(Record):
    scale: float
    many: int
    on: bool
    values: np.ndarray
    places: np.ndarray


@compiled
def whole_numbers(a: Any, b: Any) -> Any:
    return a // b, a % b, -(-a // b), abs(a), max(a, b), min(a, b, 3)


@compiled
def branches(x: Any, y: Any) -> Any:
    total, count = 0, 0
    for k in range(10, -11, -3):
        if k == 7:
            continue
        if k < -6 or (x > y and k < 0 and not x < 3.0):
            break
        total += k if 0 <= k < 5 else 0.5 * x
        count += 1
    while True:
        count += 1
        if count % 7 == 0:
            return total, count, x > y


@inner
def norm(v: Any) -> Any:
    total = 0.0
    for k in range(v.shape[0]):
        total += v[k] ** 2
    return sqrt(total)


@compiled
def arrays(a: Any, marks: Any, out: Any, shift: Any = -1.0) -> Any:
    out[:] = 0.0
    room = np.zeros((SIZE, 2))
    for i in range(a.shape[0]):
        row = a[i]
        room[i % SIZE, 1] += norm(row[1:4]) + norm(a[i, :2])
        if marks[i]:
            out[i, 0], out[i, 1] = out[i, 1] + row[-1], shift
    part = out[1:3]
    part[0, 0] += room[0, 1] + room[1, 1]
    out.reshape(-1)[5] -= room[2, 1]
    return norm(out.reshape(-1))


@compiled
def of_record(t: Any, k: Any) -> Any:
    t.values[t.places[k]] *= t.scale if t.on else 1.0
    return t.many * t.values.shape[0]


@compiled
def halves(x: Any) -> Any:
    x[0] *= 0.5


@compiled
def words(x: Any) -> Any:
    return [x]


def plain(loop: Any, *arguments: Any) -> Any:
    """The function as it is written; what it calls is compiled."""
    return loop.__wrapped__(*arguments)


@given(st.integers(-50, 50), st.integers(-9, 9).filter(bool))
def test_whole_numbers_are_rounded_as_python_does(a: int, b: int) -> None:
    assert whole_numbers(a, b) == plain(whole_numbers, a, b)


@given(st.floats(-5, 5, allow_subnormal=False), st.floats(-5, 5, allow_subnormal=False))
def test_branches_and_loops_go_the_same_ways(x: float, y: float) -> None:
    assert branches(x, y) == pytest.approx(plain(branches, x, y), rel=1e-15)


@pytest.mark.parametrize("contiguous", [True, False])
def test_arrays_are_read_and_written_in_place(contiguous: bool) -> None:
    a = np.random.default_rng(2).normal(size=(5, 12))
    a = a[:, :6].copy() if contiguous else a[:, ::2]
    marks = np.array([1, 0, 1, 1, 0], np.uint8)
    got, want = np.ones((5, 2)), np.ones((5, 2))
    assert arrays(a, marks, got) == pytest.approx(plain(arrays, a, marks, want), rel=1e-14)
    np.testing.assert_allclose(got, want, rtol=1e-14)
    assert got[3, 1] == -1.0


def test_a_record_gives_numbers_and_arrays() -> None:
    table = Table(2.0, 3, True, np.arange(4.0), np.array([2, 1]))
    assert of_record(table, 0) == 12 and table.values[2] == 4.0
    of_record(table.replaced(on=False, scale=5.0), 0)
    assert table.values[2] == 4.0
    with pytest.raises(TypeError, match="values of Table is not contiguous"):
        table.replaced(values=np.zeros((4, 4))[:, 0])


def test_numbers_too_small_for_all_digits_are_zero_inside_and_nowhere_else() -> None:
    x = np.array([1e-309])
    halves(x)
    assert x[0] in (0.0, 5e-310)  # the latter where a processor has no such mode
    assert 0.5 * 1e-309 > 0.0


def test_what_is_not_of_the_language_is_refused_with_its_place() -> None:
    with pytest.raises(NotImplementedError, match=r"test_translate\.py:\d+: not in the language"):
        words(1.0)
    with pytest.raises(TypeError, match="no array of float32"):
        halves(np.zeros(2, np.float32))
