"""All derivatives of a recorded function at once, by eliminating what lies between.

Every recorded operation is a vertex, every local derivative the weight of an edge. A vertex is eliminated by joining
its predecessors to its successors with products of weights; when only directions and results are left, the weights
are the Jacobian. Of all orders one that takes the vertex with the fewest products first (Markowitz) costs a fraction
of going through the directions one by one (Griewank and Walther, *Evaluating Derivatives*, 2008, chapter 10).
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence

from directrix.kernels.trace import Graph, Sym, needed, slopes

__all__ = ["jacobian"]

Edges = dict[int, dict[int, Sym]]


def jacobian(
    graph: Graph,
    outputs: Sequence[Sym],
    seeds: Sequence[Mapping[Sym, Sym | float]],
    last: Sequence[Sequence[Sym]] = (),
) -> list[list[Sym]]:
    """Derivatives of the outputs, one list a direction; each seed as in :func:`directrix.kernels.trace.derivative`.

    ``last``: groups of values that are eliminated behind all others, one group after the other. Through what joins
    much to much, like the stresses of an element, the way is short, and Markowitz does not look that far ahead.
    """
    into = _edges(graph, outputs, seeds)
    results = -1 - len(seeds)
    for k, out in enumerate(outputs):
        if out.index in into:
            into[results - k] = {out.index: graph.const(1.0)}
    groups = [{value.index for value in group} & into.keys() for group in last]
    waiting = set[int]().union(*groups)
    for group in [{v for v in into if v >= 0} - waiting, *groups]:
        _eliminate(into, sorted(group & into.keys()))
    zero = graph.const(0.0)
    rows = [into.get(results - k, {}) for k in range(len(outputs))]
    return [[row.get(d, zero) for row in rows] for d in range(-1, -1 - len(seeds), -1)]


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


def _eliminate(into: Edges, inner: list[int]) -> None:
    """Eliminate the vertices ``inner``; of equally cheap ones the first recorded goes first."""
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
