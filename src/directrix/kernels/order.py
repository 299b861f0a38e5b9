"""The order of straight-line code. A machine has few registers: what is computed early and used late goes to memory and
comes back, and half of what an element's code does is that. Here is what keeps it low.

Results are computed a few at a time, next those that need the fewest new operations; sums that end in them grow side by
side, so that what one product reads is still there for its neighbours.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from directrix.kernels.trace import Graph, Sym, needed

__all__ = ["FENCE", "scheduled"]

NEAR = 3  # neighbouring results that are taken together
TOGETHER = 9  # results whose sums grow side by side
FENCE = 'call void asm sideeffect "", "~{memory}"()'
"""Nothing is read ahead of it: LLVM would read all of it early, run out of registers and put it on the stack."""


def scheduled(graph: Graph, results: Sequence[Sym], reread: bool) -> Iterator[tuple[list[int], list[int]]]:
    """Values to compute, in this order, and which results are then there; a FENCE belongs behind each.

    ``reread``: inputs are read anew each time instead of kept.
    """
    used = Counter(
        operand
        for op, a, b in (graph.ops[index] for index in needed(graph, results))
        if op not in ("in", "const")
        for operand in (int(a), b)
    )
    used.update(value.index for value in results)
    order, done = _nearest(graph, results), set[int]()
    for first in range(0, len(order), TOGETHER):
        part = order[first : first + TOGETHER]
        sums = [_sum(graph, results[k].index, used) for k in part]
        turns = [start for start, _ in sums]
        for turn in range(max(len(steps) for _, steps in sums)):
            turns += [steps[turn] for _, steps in sums if turn < len(steps)]
        yield needed(graph, [Sym(graph, index) for index in turns], done), part
        if reread:
            done -= {index for index in done if graph.ops[index][0] == "in"}


def _nearest(graph: Graph, results: Sequence[Sym]) -> list[int]:
    """NEAR results after NEAR results, those first that need the fewest new operations."""
    groups = [list(range(k, min(k + NEAR, len(results)))) for k in range(0, len(results), NEAR)]
    needs = [set(needed(graph, [results[k] for k in group])) for group in groups]
    order: list[int] = []
    done = set[int]()
    left = list(range(len(groups)))
    while left:
        best = min(left, key=lambda g: len(needs[g] - done)) if order else 0
        left.remove(best)
        order += groups[best]
        done |= needs[best]
    return order


def _sum(graph: Graph, index: int, used: Counter[int]) -> tuple[int, list[int]]:
    """What a sum starts with, and its additions of products that are used nowhere else."""
    steps: list[int] = []
    while True:
        op, a, b = graph.ops[index]
        if op not in ("add", "sub") or (steps and used[index] > 1):
            return index, steps[::-1]
        for term, rest in ((b, int(a)), (int(a), b)):
            if graph.ops[term][0] == "mul" and used[term] == 1:
                steps.append(index)
                index = rest
                break
        else:
            return index, steps[::-1]
