"""Calling machine code by its address from compiled loops, and what loops do in vectors.

The address is a run-time value, so one compiled loop serves every element. All arrays are flat.
"""
# pyright: basic, reportCallIssue=false

from __future__ import annotations

from collections.abc import Sequence

from directrix.kernels.expressions import Emitted, Expressions
from directrix.kernels.kinds import Value

__all__ = ["FACTORS", "add_block", "call_elimination", "call_kernel", "call_lanes"]

FACTORS = 56  # what the elimination leaves of a row


def _from(body: Expressions, array: Value, first: Value | str) -> str:
    """Address of a number of an array."""
    place = first if isinstance(first, str) else first.parts[0]
    item = "i64" if array.kind.item == "i8" else "double"
    return body.put(f"getelementptr inbounds {item}, ptr {array.parts[0]}, i64 {place}")


def _run(body: Expressions, address: Value, pointers: Sequence[str]) -> None:
    function = body.put(f"inttoptr i64 {address.parts[0]} to ptr")
    body.lines.append(f"call void {function}({', '.join(f'ptr {p}' for p in pointers)})")


def _kernel(body: Expressions, given: Sequence[Value]) -> None:
    address, x, at, first_at, p, first_p, g, out = given
    pointers = x.parts[0], _from(body, at, first_at), _from(body, p, first_p), g.parts[0], out.parts[0]
    _run(body, address, pointers)


call_kernel = Emitted(_kernel)
"""(address, x, at, first_at, p, first_p, g, out): run an element kernel on (x, at[first_at:], p[first_p:], g, out)."""


def _elimination(body: Expressions, given: Sequence[Value]) -> None:
    address, blocks, block, rhs, row, factors, factor = given
    out = _from(body, factors, factor)
    before = body.put(f"getelementptr inbounds double, ptr {out}, i64 {-FACTORS}")
    _run(body, address, (_from(body, blocks, block), before, _from(body, rhs, row), out))


call_elimination = Emitted(_elimination)
"""(address, blocks, block, rhs, row, factors, factor): run the elimination on blocks[block:], the factors before,
rhs[row:] and factors[factor:]."""


def _lanes(body: Expressions, given: Sequence[Value]) -> None:
    _run(body, given[0], [_from(body, array, first) for array, first in zip(given[1::2], given[2::2], strict=True)])


call_lanes = Emitted(_lanes)
"""(address, array, first, array, first, …): run a function of :mod:`directrix.kernels.lanes` on each array[first:]."""


def _add(body: Expressions, given: Sequence[Value]) -> None:
    to, at, values, first = given
    target, source = _from(body, to, at), _from(body, values, first)
    sums: list[tuple[str, str, str]] = []
    for place, lanes in ((0, 8), (8, 8), (16, 8), (24, 8), (32, 4)):
        vector = f"<{lanes} x double>"
        a, b = (body.put(f"getelementptr inbounds double, ptr {p}, i64 {place}") for p in (target, source))
        x, y = (body.put(f"load {vector}, ptr {p}, align 8") for p in (a, b))
        sums.append((vector, body.put(f"fadd {vector} {x}, {y}"), a))
    for vector, total, a in sums:
        body.lines.append(f"store {vector} {total}, ptr {a}, align 8")


add_block = Emitted(_add)
"""(to, at, values, first): to[at : at + 36] += values[first : first + 36], in vectors: the arrays do not overlap."""
