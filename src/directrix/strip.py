"""What lanes are made of: the arrays of a strip of elements, what its steps read and write, and its machine code."""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from directrix.groups import Group
from directrix.kernels import rows
from directrix.kernels.compile import LANES
from directrix.kernels.elimination import elimination_address
from directrix.kernels.lanes import Code, lane_address
from directrix.kernels.record import Record
from directrix.kernels.strip_elimination import BATCH

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Loads", "Shots", "Strip", "Work", "code_of", "largest_of", "steps_at_once", "strip_of", "work_for"]

MOST, ELEMENTS = 64, 50_000
"""Steps of a call, and steps times elements: some 50 ms, after which progress and signals are looked at again."""


class Strip(Record):
    """Parts of a chain, or ``whole`` chains, side by side: ``elements`` long, ``lanes`` of them real, ``stride`` nodes
    an element; ``first`` is the joint where they begin, ``loaded`` where their loads do. See
    :mod:`directrix.kernels.strips`."""

    elements: int
    lanes: int
    stride: int
    whole: int
    first: int
    loaded: int
    results: int
    parameters: int
    x: Array
    p: Array
    load: Array
    first_load: Array
    free: Array
    first_free: Array
    still: Array
    held: NDArray[np.uint8]
    far: NDArray[np.uint8]
    own: Array
    row: Array
    within: Array
    out: Array
    small: Array
    carry: Array
    none: Array
    res: Array
    f: Array
    du: Array
    start: Array
    turn: Array
    nodes: Ints
    ends: Array
    size: Array
    most: Array
    sums: Array
    books: Array
    loss: Array


class Work(Record):
    """The nodes where parts meet, if they do. ``kept`` (1,): the next step begins with the factors that there are."""

    eliminate: int
    blocks: Array
    rhs: Array
    du: Array
    factors: Array
    fixed: NDArray[np.uint8]
    load: Array
    res: Array
    largest: Array
    scale: Array
    kept: NDArray[np.uint8]


class Loads(Record):
    """What acts in the steps to come, one of them or one for all: on the ``strips`` as their ``load``, one behind the
    other; on the nodes where parts meet (k, …, 6), and the largest force and moment (k, 2)."""

    strips: Array
    joints: Array
    largest: Array


class Shots(Record):
    """States (k, ≥ n, 40) and reactions (k, n, 6) of every ``every``-th step; ``frames`` and ``fixed`` of all nodes."""

    every: int
    x: Array
    reaction: Array
    frames: Array
    fixed: NDArray[np.uint8]


def steps_at_once(elements: int) -> int:
    """Steps of one call with so many elements."""
    return max(1, min(MOST, ELEMENTS // elements))


def largest_of(dead: Array) -> Array:
    """(k, 2) largest component of a force and of a moment among loads (k, n, 6)."""
    return np.abs(dead).reshape(*dead.shape[:2], 2, 3).max(axis=(1, 3))


def strip_of(
    stride: int,
    nodes: Ints,
    p: Array,
    held: NDArray[np.bool_],
    own: Array,
    *,
    whole: bool,
    first: int = 0,
    loaded: int = 0,
) -> Strip:
    """A strip of ``nodes`` (…, real lanes), with parameters (elements, …, LANES), what is held (nodes, 6, LANES), and
    the nodes that are booked (nodes, LANES)."""
    many, size = int(p.shape[0]), int(p.shape[1])
    free: Array = np.where(held, 0.0, 1.0)
    still = free.copy()
    still[:, 3:] = 0.0
    first_free = free[:stride].copy()
    first_free[0] = 0.0
    count = len(free)

    def lane(values: int, many: int = 1) -> Array:
        return _room(many * values * LANES)

    nn = stride + 1
    results = 6 * nn + 36 * nn * nn
    out = lane(results, min(many, BATCH))
    return Strip(
        many, nodes.shape[1], stride, int(whole), first, loaded, results, size,
        x=lane(rows.NODE, count), p=_aligned(p), load=lane(6, count), first_load=lane(6, stride), free=_aligned(free),
        first_free=first_free.ravel(), still=_aligned(still),
        held=(free[::stride] == 0.0).any(axis=(1, 2)).astype(np.uint8), far=np.full(many + 1, whole, np.uint8),
        own=own.ravel(), row=lane(rows.ROW, many + 1), within=lane(rows.ROW, many * (stride - 1)), out=out,
        small=lane(156) if stride > 1 else out, carry=lane(rows.CARRY), none=lane(156), res=lane(6, count), f=lane(6),
        du=lane(6, count), start=lane(3, 0 if whole else count), turn=np.full(many * LANES, -3.0),
        nodes=np.ascontiguousarray(nodes), ends=lane(12), size=lane(3), most=lane(5), sums=lane(8), books=lane(8),
        loss=lane(1),
    )  # fmt: skip


def _room(count: int) -> Array:
    """Zeros that begin where a line of the cache does: a vector that lies across two costs two loads."""
    room = np.zeros(count + 8)
    first = -(room.ctypes.data // 8) % 8
    return room[first : first + count]


def _aligned(values: Array) -> Array:
    out = _room(values.size)
    out[:] = values.ravel()
    return out


def work_for(fixed: NDArray[np.uint8], largest: int) -> Work:
    """For the nodes where parts meet, held where ``fixed`` (n, 6); ``largest`` numbers of loads."""
    n = len(fixed)
    return Work(
        elimination_address(), np.zeros((3 * n + 1, 6, 6)), np.zeros((n, 6)), np.zeros((n, 6)), np.zeros((n + 1, 56)),
        fixed, np.zeros((n, 6)), np.zeros((n, 6)), np.zeros(largest), np.zeros(LANES), np.zeros(1, np.uint8),
    )  # fmt: skip


def code_of(group: Group, aligned: bool, *, whole: bool) -> Ints:
    """Addresses of the machine code, in the order of the names in :mod:`directrix.kernels.strip_elimination`."""
    element, layout = group.element, group.layout
    about = f"{layout} {element} {aligned}"
    three = layout.nn > 2
    codes: list[tuple[str, Callable[[], Code]]] = [
        (f"tangent {about}", lambda: rows.step(element, layout, aligned, True)),
        (f"residual {about}", lambda: rows.step(element, layout, aligned, False)),
        (f"audit {about}", lambda: rows.audit(element, layout, aligned)),
        ("pivot", lambda: rows.pivot(masked=False, inner=True)),
        ("hold", lambda: rows.pivot(masked=True, inner=True)),
        ("pass on", lambda: rows.pass_on(inner=True)),
        ("pass on far", lambda: rows.pass_on(inner=True, far=True)),
        ("forward", lambda: rows.forward(far=False)),
        ("forward far", lambda: rows.forward(far=True)),
        ("backward", lambda: rows.backward(far=False)),
        ("backward far", lambda: rows.backward(far=True)),
        ("measure", rows.measure),
        (f"move {whole}", lambda: rows.move(each=whole)),
        (f"balance {layout.nn}", lambda: rows.residual(layout.nn)),
        ("finish", rows.finish),
        ("less", rows.product),
        ("balance 2", lambda: rows.residual(2)),
    ]
    middle: list[tuple[str, Callable[[], Code]]] = [
        ("middle", lambda: rows.pivot(masked=False, inner=False)),
        ("middle hold", lambda: rows.pivot(masked=True, inner=False)),
        ("middle on", lambda: rows.pass_on(inner=False)),
        ("inside", rows.inside),
    ]
    addresses = [lane_address(*code) for code in [*codes, *(middle if three else [])]]
    return np.array(addresses + [0] * (0 if three else len(middle)), np.int64)
