"""What the machine code of an element is recorded from, and the recording."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Protocol

from directrix.formulations.layout import HISTORY, PER_NODE, Coordinates, Layout, Scalar, Step, Vector
from directrix.kernels.jacobian import jacobian
from directrix.kernels.trace import Graph, Sym, cross

__all__ = [
    "COMMON",
    "FLOWS",
    "Committed",
    "Element",
    "Jointed",
    "Lossy",
    "record_acts",
    "record_audit",
    "record_commit",
    "record_lost",
    "record_step",
    "step_of",
]

COMMON = 8  # scalars that all elements of a run share
FLOWS = 10  # values of what an element takes and brings in
Recorded = tuple[Graph, list[Sym]]


class Element(Protocol):
    """An element under a rule: a frozen value whose ``repr`` names its kernels. Plain Python over scalars.

    ``x`` holds the values of the element's nodes, ``PER_NODE`` each, and behind them its rows of history;
    ``p`` the parameters of :class:`Layout`; ``g`` scalars common to all elements.
    """

    sampled: bool
    """True when the parameters include dS/dξ at the inertia points."""

    def rows(self, layout: Layout) -> int:
        """Rows of history of an element: Gauss points that carry a rotation."""
        ...

    def reference(self, layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
        """What is subtracted from the strains: per stress point six values, from the reference coordinates."""
        ...

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """Forces on the nodes, what moves and turns with them, and a way for the derivatives."""
        ...

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """W, T, L (3), J (3), per pair of neighbouring nodes Σ d_i·d_i, per stress point the loss of
        orthonormality and the six strains."""
        ...


class Lossy(Element, Protocol):
    """An element that dissipates by itself."""

    def lost(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """What it took in the step; and if there is more: the work that is done on it from outside, force (3) and
        moment about the origin (3) from outside, and for a second source what it took and its work."""
        ...


class Jointed(Lossy, Protocol):
    """An element whose last node is a row of multipliers."""

    def acts(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """Force (3) and moment (3) on what moves, coordinate at x1, its increment in the step, the forces on it
        that do the work of prescribed motion and of a drive."""
        ...


class Committed(Element, Protocol):
    """An element with history."""

    def initial(self, layout: Layout, q: Coordinates) -> list[Scalar]:
        """The rows of history in the reference, ``HISTORY`` values each."""
        ...

    def commit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> list[Scalar]:
        """The rows of history at the end of a step, ``HISTORY`` values each."""
        ...


def _inputs(element: Element, layout: Layout) -> tuple[Graph, list[Sym], list[Sym], list[Sym]]:
    graph = Graph()
    x = graph.inputs("x", PER_NODE * (layout.nn + element.rows(layout)))
    return graph, x, graph.inputs("p", layout.size), graph.inputs("g", COMMON)


def record_step(element: Element, layout: Layout, tangent: bool) -> Recorded:
    """Residual (6 nn), and behind it the tangent if asked for: blocks (6, 6) by rows, for each node b (increments)
    and each node a (forces).

    The tangent is the derivative of the residual for increments (δr, spin θ at n + 1), δd_i = θ × d_i.
    """
    graph, x, p, g = _inputs(element, layout)
    return graph, step_of(graph, element, layout, x, p, g, tangent)


def step_of(
    graph: Graph, element: Element, layout: Layout, x: Sequence[Sym], p: Sequence[Sym], g: Sequence[Sym], tangent: bool
) -> list[Sym]:
    """What :func:`record_step` records, for inputs that are there already."""
    out, moving, turning, through = Step(*element.step(layout, x, p, g))
    results = list(out)
    if tangent:
        seeds = _seeds(layout, moving, turning)
        turned = [value for seed in seeds for value, slope in seed.items() if isinstance(slope, Sym)]
        slopes = jacobian(graph, out, seeds, [*through[:1], turned, *through[1:]])
        for b, a, i in itertools.product(range(layout.nn), range(layout.nn), range(6)):
            results += [slopes[6 * b + k][6 * a + i] for k in range(6)]
    return results


def _seeds(
    layout: Layout, moving: Sequence[Sequence[Vector]], turning: Sequence[Sequence[Vector]]
) -> list[dict[Sym, Sym | float]]:
    """The increments of an element: per node three that move, three that turn."""
    seeds: list[dict[Sym, Sym | float]] = []
    for b in range(layout.nn):
        adds = layout.last_adds and b == layout.nn - 1
        for k in range(6):
            if k < 3 or adds:
                seeds.append({v[k % 3]: 1.0 for v in (moving if k < 3 else turning)[b]})
            else:
                e = [1.0 if c == k - 3 else 0.0 for c in range(3)]
                seeds.append({d[c]: turned for d in turning[b] for c, turned in enumerate(cross(e, d))})
    return seeds


def record_audit(element: Element, layout: Layout) -> Recorded:
    """The books of one element at (x1, ẋ in the place of the rate)."""
    graph, x, p, _ = _inputs(element, layout)
    out = element.audit(layout, x, p)
    return graph, out


def record_lost(element: Lossy, layout: Layout) -> Recorded:
    """What an element dissipated in a step, and what came in from outside: FLOWS values."""
    graph, x, p, g = _inputs(element, layout)
    out = [x[0].lift(value) for value in element.lost(layout, x, p, g)]
    return graph, [*out, *[graph.const(0.0)] * (FLOWS - len(out))]


def record_acts(element: Jointed, layout: Layout) -> Recorded:
    """What a joint does in a step, 10 values."""
    graph, x, p, g = _inputs(element, layout)
    out = [x[0].lift(value) for value in element.acts(layout, x, p, g)]
    return graph, out


def record_commit(element: Committed, layout: Layout) -> Recorded:
    """The history at the end of a step."""
    graph, x, p, g = _inputs(element, layout)
    # a row may hold plain numbers; they are lifted by adding nothing that is recorded
    out = [x[0].lift(value) for value in element.commit(layout, x, p, g)]
    assert len(out) == HISTORY * element.rows(layout)
    return graph, out
