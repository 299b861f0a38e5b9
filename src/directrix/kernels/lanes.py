"""Machine code over arrays that are in lanes already: element i of eight rods, or of eight parts of one, side by side.

A function is ``void f(double *first, double *second, …)``, one pointer for each array of ``Code``. Value k of an array
are LANES neighbouring numbers, one a lane; an array named in ``common`` has one number for all lanes. No lane reads
another, so what a lane computes does not depend on its neighbours.
"""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import NamedTuple

from directrix.kernels.compile import LANES, text_address
from directrix.kernels.order import FENCE, scheduled
from directrix.kernels.trace import FUNCTIONS, Graph, Sym, needed

__all__ = ["Code", "Store", "lane_address", "lane_ir"]

VEC = f"<{LANES} x double>"


class Store(NamedTuple):
    """Place ``place`` of ``array`` receives ``value``."""

    array: str
    place: int
    value: Sym


class Code(NamedTuple):
    """What a function does: its arrays in the order of its arguments, and what it stores; neighbours are close.

    Arrays that are read and written are read in full before the first is stored.
    """

    graph: Graph
    arrays: Sequence[str]
    stores: Sequence[Store]
    common: Sequence[str] = ()
    recorded: bool = False
    """Compute in the order of recording."""
    tile: int = 0
    """So many results are computed and stored at a time, in the order of recording and with inputs read anew. Of an
    array that is read and written, a tile must read none that was stored before it."""
    may_be_one: Sequence[str] = ()
    """Arrays of which some may be one and the same."""


def in_time(graph: Graph, indices: Sequence[int]) -> list[int]:
    """The order of recording, but inputs and numbers only when they are first used."""
    out: list[int] = []
    waiting = {index for index in indices if graph.ops[index][0] in ("in", "const")}
    for index in sorted(set(indices) - waiting):
        _, a, b = graph.ops[index]
        for operand in (int(a), b):
            if operand in waiting:
                waiting.discard(operand)
                out.append(operand)
        out.append(index)
    return [*out, *waiting]


def lane_ir(code: Code, name: str) -> str:
    """LLVM text of a function."""
    graph, stores = code.graph, code.stores
    arguments = ", ".join(f"ptr {'' if a in code.may_be_one else 'noalias '}%{a}" for a in code.arrays)
    lines = [f"define void @{name}({arguments}) {{"]
    text: dict[int, str] = {}
    instruction = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
    written = {store.array for store in stores}

    def put(operation: str) -> str:
        lines.append(f"%t{len(lines)} = {operation}")
        return f"%t{len(lines) - 1}"

    def place(array: str, offset: int, kind: str = VEC) -> str:
        return put(f"getelementptr {kind}, ptr %{array}, i64 {offset}")

    def emit(index: int) -> str:
        op, a, b = graph.ops[index]
        if op == "const":
            bits = struct.pack(">d", float(a)).hex().upper()
            return "<" + ", ".join([f"double 0x{bits}"] * LANES) + ">"
        if op == "in" and a in code.common:
            one = put(f"load double, ptr {place(str(a), b, 'double')}, align 8")
            one = put(f"insertelement {VEC} undef, double {one}, i32 0")
            return put(f"shufflevector {VEC} {one}, {VEC} undef, <{LANES} x i32> zeroinitializer")
        if op == "in":
            return put(f"load {VEC}, ptr {place(str(a), b)}, align 8")
        if op in FUNCTIONS:
            return put(f"call {VEC} @llvm.{op}.v{LANES}f64({VEC} {text[int(a)]})")
        if op == "max":
            more = put(f"fcmp ogt {VEC} {text[int(a)]}, {text[b]}")
            return put(f"select <{LANES} x i1> {more}, {VEC} {text[int(a)]}, {VEC} {text[b]}")
        if op == "abs":
            return put(f"call {VEC} @llvm.fabs.v{LANES}f64({VEC} {text[int(a)]})")
        flags = "" if op == "div" else "contract "
        return put(f"{instruction[op]} {flags}{VEC} {text[int(a)]}, {text[b]}")

    def save(store: Store) -> None:
        target = place(store.array, store.place)
        lines.append(f"store {VEC} {text[store.value.index]}, ptr {target}, align 8")

    def compute(indices: Sequence[int]) -> None:
        for index in indices:
            text[index] = emit(index)

    values = [store.value for store in stores]
    order = needed(graph, values)
    both = {a for index in order for op, a, _ in [graph.ops[index]] if op == "in" and a in written}
    if code.recorded:
        compute(in_time(graph, order))
        for store in stores:
            save(store)
    elif code.tile:
        for first in range(0, len(stores), code.tile):
            text.clear()
            compute(in_time(graph, needed(graph, values[first : first + code.tile])))
            for store in stores[first : first + code.tile]:
                save(store)
    else:
        for indices, part in scheduled(graph, values, reread=True):
            compute(indices)
            for store in (stores[k] for k in part):
                if store.array not in both:
                    save(store)
            lines.append(FENCE)
        for store in stores:
            if store.array in both:
                save(store)
    used = {op for op, _, _ in graph.ops} & {*FUNCTIONS, "abs"}
    names = sorted("fabs" if op == "abs" else op for op in used)
    declared = [f"declare {VEC} @llvm.{op}.v{LANES}f64({VEC})" for op in names]
    return "\n".join([*declared, *lines, "ret void", "}"])


def lane_address(description: str, build: Callable[[], Code]) -> int:
    """Address of the machine code, compiled at most once per machine; see ``kernel_address``."""
    return text_address(f"lanes {description}", lambda name: lane_ir(build(), name))
