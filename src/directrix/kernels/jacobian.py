"""All derivatives of a recorded function at once, by eliminating what lies between.

Every recorded operation is a vertex, every local derivative the weight of an edge. A vertex is eliminated by joining
its predecessors to its successors with products of weights; when only directions and results are left, the weights
are the Jacobian. Of all orders one that takes the vertex with the fewest products first (Markowitz) costs a fraction
of going through the directions one by one (Griewank and Walther, *Evaluating Derivatives*, 2008, chapter 10).
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from directrix.kernels.trace import Graph, Sym, needed, slopes

__all__ = ["Factored", "factored_jacobian", "jacobian"]

WAIST = 36
Edges = dict[int, dict[int, Sym]]


class Factored(NamedTuple):
    """A Jacobian ``direct + Σ left · right``: one list a direction, and per value that is left in between the
    derivatives of the outputs with respect to it and its own in the directions."""

    direct: list[list[Sym]]
    left: list[list[Sym]]
    right: list[list[Sym]]


def jacobian(graph: Graph, outputs: Sequence[Sym], seeds: Sequence[Mapping[Sym, Sym | float]]) -> list[list[Sym]]:
    """Derivatives of the outputs, one list a direction; each seed as in :func:`directrix.kernels.trace.derivative`."""
    return factored_jacobian(graph, outputs, seeds, 0).direct


def factored_jacobian(
    graph: Graph, outputs: Sequence[Sym], seeds: Sequence[Mapping[Sym, Sym | float]], most: int
) -> Factored:
    """:func:`jacobian`, of which the last products are left to whoever multiplies matrices.

    What joins all directions to all outputs, like the strains of an element, costs as many products as a row has times
    a column. Up to ``most`` values whose elimination takes WAIST products or more stay.
    """
    into = _edges(graph, outputs, seeds)
    results = -1 - len(seeds)
    for k, out in enumerate(outputs):
        if out.index in into:
            into[results - k] = {out.index: graph.const(1.0)}
    _eliminate(into, [v for v in into if v >= 0], most)
    kept = [v for v in into if v >= 0]
    zero = graph.const(0.0)

    def after(vertex: int) -> list[Sym]:
        return [into.get(results - k, {}).get(vertex, zero) for k in range(len(outputs))]

    directions = range(-1, -1 - len(seeds), -1)
    right = [[into[v].get(d, zero) for d in directions] for v in kept]
    return Factored([after(d) for d in directions], [after(v) for v in kept], right)


def _edges(graph: Graph, outputs: Sequence[Sym], seeds: Sequence[Mapping[Sym, Sym | float]]) -> Edges:
    """Weights of the edges into every value that depends on a direction; direction d is vertex −1 − d."""
    into: Edges = {}
    zero = graph.const(0.0)
    for d, seed in enumerate(seeds):
        for value, slope in seed.items():
            weight = zero.lift(slope)
            if graph.value_of(weight.index) != 0.0:
                into.setdefault(value.index, {})[-1 - d] = weight
    seeded = {value.index for seed in seeds for value in seed}
    for index in needed(graph, outputs):
        if index not in seeded:
            edges = {source: weight for source, weight in slopes(graph, index).items() if source in into}
            if edges:
                into[index] = edges
    return into


def _eliminate(into: Edges, inner: list[int], most: int) -> None:
    """Eliminate the vertices ``inner``; of equally cheap ones the first recorded goes first. What costs WAIST or
    more stays, up to ``most``, where it depends on directions alone and nothing but outputs depends on it."""
    out: dict[int, set[int]] = {}
    for vertex, edges in into.items():
        for source in edges:
            out.setdefault(source, set()).add(vertex)

    def cost(vertex: int) -> int:
        return len(into[vertex]) * len(out.get(vertex, ()))

    left = {vertex: cost(vertex) for vertex in inner}
    queue = [(c, vertex) for vertex, c in left.items()]
    heapq.heapify(queue)
    while queue:
        c, vertex = heapq.heappop(queue)
        if left.get(vertex) != c:
            continue
        del left[vertex]
        alone = all(v < 0 for v in (*into[vertex], *out.get(vertex, ())))
        if most and c >= WAIST and alone:
            most -= 1
            continue
        edges, targets = into.pop(vertex), out.pop(vertex, set[int]())
        for target in sorted(targets):
            weight = into[target].pop(vertex)
            for source, first in edges.items():
                product = weight * first
                known = into[target].get(source)
                into[target][source] = product if known is None else known + product
                out[source].add(target)
        for source in edges:
            out[source].discard(vertex)
        for near in {*edges, *targets} & left.keys():
            now = cost(near)
            if now != left[near]:
                left[near] = now
                heapq.heappush(queue, (now, near))
