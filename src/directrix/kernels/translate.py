"""Loops in plain Python, translated to LLVM's language: what :mod:`directrix.kernels.jit` compiles.

The language is small, which makes it quick to compile: scalars (float, int, bool), arrays (float64, int64, uint8) with
indices and slices without step, records (:mod:`directrix.kernels.record`), tuples of scalars; assignments, ``for`` over
``range``, ``while``, ``if``, calls of other loops and of the functions in ``MATH``. ``np.empty`` and ``np.zeros`` of a
shape that is a number in the source are room on the stack. Types follow from those of the arguments. Divisions by zero
give inf, indices are not checked, and negative ones count from the end only when they are numbers in the source.

Every function is translated for the kinds it is called with, again and again until the kinds of its variables stay.
"""
# pyright: basic

from __future__ import annotations

import ast
import platform
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from directrix.kernels.expressions import Expressions
from directrix.kernels.kinds import ITEMS, Array, Value, joined, llvm_types, result_type

__all__ = ["Body", "Translation", "kind_of"]


# Numbers too small to have all digits count as zero while a loop runs: disturbances that fade out along a rod end there
# (arithmetic with them is many times slower). The bits are "flush to zero" and "denormals are zero".
GET, SET = "@llvm.x86.sse.stmxcsr", "@llvm.x86.sse.ldmxcsr"
FLUSH = [
    "%modes = alloca i32", f"call void {GET}(ptr %modes)", "%mode = load i32, ptr %modes",
    f"%flush = or i32 %mode, {0x8040}", "store i32 %flush, ptr %modes", f"call void {SET}(ptr %modes)",
]  # fmt: skip


@dataclass
class Translation:
    """The functions of one module, translated as they are called for."""

    texts: list[str] = field(default_factory=lambda: [])
    declared: set[str] = field(default_factory=lambda: set())
    done: dict[tuple[Any, tuple[Any, ...]], tuple[str, Any]] = field(default_factory=lambda: {})

    def function(self, function: Any, kinds: tuple[Any, ...]) -> tuple[str, Any]:
        """Name and kind of result of a plain Python function for arguments of the given kinds."""
        key = function, kinds
        if key not in self.done:
            variables: dict[str, Any] = {}
            result = None
            while True:
                body = Body(self, function, kinds, dict(variables), result)
                body.translated(f"f{len(self.done)}")
                if body.variables == variables and body.result == result:
                    break
                variables, result = body.variables, body.result
            self.done[key] = f"f{len(self.done)}", result
            self.texts.append(body.translated(self.done[key][0]))
        return self.done[key]

    def entry(self, function: Any, kinds: tuple[Any, ...], name: str) -> str:
        """A whole module with ``void name(ptr words, ptr results)``: arguments and results are words of 64 bits; an
        array is its address, sizes and, unless packed, strides in bytes. The first result is the kind of the others,
        see :func:`kind_of`."""
        called, result = self.function(function, kinds)
        lines = [
            f"define void @{name}(ptr %words, ptr %results) {{",
            f"store i64 {int.from_bytes(''.join(('', *(result or ()))).encode(), 'little')}, ptr %results",
        ]
        if isinstance(result, tuple):
            lines[1] = f"store i64 {int.from_bytes(('(' + ''.join(result)).encode(), 'little')}, ptr %results"
        operands: list[str] = []
        types = [t for kind in kinds for t in llvm_types(kind)]
        strides = {k for k, size in _strides(kinds)}
        items = dict(_strides(kinds))
        for k, t in enumerate(types):
            lines.append(f"%a{k} = getelementptr i64, ptr %words, i64 {k}")
            lines.append(f"%v{k} = load {t}, ptr %a{k}")
            if k in strides:
                lines.append(f"%s{k} = sdiv i64 %v{k}, {items[k]}")
            operands.append(f"{t} %{'s' if k in strides else 'v'}{k}")
        returned = llvm_types(result)
        call = f"call {result_type(returned)} @{called}({', '.join(operands)})"
        lines.append(call if not returned else f"%r = {call}")
        for k, t in enumerate(returned):
            value = "%r"
            if len(returned) > 1:
                lines.append(f"%e{k} = extractvalue {result_type(returned)} %r, {k}")
                value = f"%e{k}"
            if t == "i1":
                lines.append(f"%w{k} = zext i1 {value} to i64")
                t, value = "i64", f"%w{k}"
            lines.append(f"%o{k} = getelementptr i64, ptr %results, i64 {k + 1}")
            lines.append(f"store {t} {value}, ptr %o{k}")
        if platform.machine() in ("x86_64", "AMD64"):
            lines[1:1] = FLUSH
            lines += ["store i32 %mode, ptr %modes", f"call void {SET}(ptr %modes)"]
            self.declared |= {f"declare void {GET}(ptr)", f"declare void {SET}(ptr)"}
        return "\n".join([*sorted(self.declared), *self.texts, *lines, "ret void", "}"])


@cache
def kind_of(word: int) -> str:
    """The kinds of results from their code: nothing, one letter, or "(" and a letter each for a tuple."""
    return word.to_bytes(8, "little").rstrip(b"\0").decode()


def _strides(kinds: Sequence[Any]) -> list[tuple[int, int]]:
    """Places of strides among the operands of arguments, and the size of the items."""
    found: list[tuple[int, int]] = []
    at = 0
    for kind in kinds:
        count = len(llvm_types(kind))
        if isinstance(kind, Array) and not kind.packed:
            found += [(at + 1 + kind.ndim + k, int(kind.item[1])) for k in range(kind.ndim)]
        at += count
    return found


class Body(Expressions):
    """One function, translated once under the kinds of variables found so far."""

    def translated(self, name: str) -> str:
        """The text of the function."""
        self.lines, self.rooms, self.names, self.held = [], [], 0, {}
        parameters: list[str] = []
        for argument, kind in zip(self.node.args.args, self.kinds, strict=True):
            parts = tuple(f"%p{len(parameters) + k}" for k in range(len(llvm_types(kind))))
            parameters += [f"{t} {p}" for t, p in zip(llvm_types(kind), parts, strict=True)]
            self.assign(argument.arg, Value(kind, parts))
        self.block(self.node.body)
        end = "ret void" if self.result is None else "unreachable"
        head = f"define internal {result_type(llvm_types(self.result))} @{name}({', '.join(parameters)}) {{"
        return "\n".join([head, *self.rooms, *self.lines, end, "}"])

    # --- statements ---

    def block(self, statements: Sequence[ast.stmt]) -> None:
        for statement in statements:
            getattr(self, f"do_{type(statement).__name__.lower()}", self.do_other)(statement)

    def do_other(self, node: ast.stmt) -> None:
        raise self.wrong(node, "not in the language of compiled loops")

    def do_pass(self, node: ast.Pass) -> None:
        pass

    def do_expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def do_assign(self, node: ast.Assign) -> None:
        source = node.value
        for target in node.targets:
            if isinstance(target, ast.Tuple) and isinstance(source, ast.Tuple):
                values = [self.value(part) for part in source.elts]
            elif isinstance(target, ast.Tuple):
                values = self.taken_apart(self.value(source))
            else:
                self.store(target, self.value(source))
                continue
            for part, value in zip(target.elts, values, strict=True):
                self.store(part, value)

    def do_augassign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Subscript):
            place, kind = self.place(node.target)
            old = Value(ITEMS[kind][1], (self.put(f"load {ITEMS[kind][0]}, ptr {place}"),))
            new = self.cast(self.operated(node, node.op, old, self.value(node.value)), ITEMS[kind][1])
            self.lines.append(f"store {ITEMS[kind][0]} {new.parts[0]}, ptr {place}")
        else:
            old = self.value(ast.Name(node.target.id, ast.Load()))  # type: ignore[union-attr]
            self.store(node.target, self.operated(node, node.op, old, self.value(node.value)))

    def store(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self.assign(target.id, value)
            return
        if not isinstance(target, ast.Subscript):
            raise self.wrong(target, "cannot be assigned")
        to = self.item(target)
        if isinstance(to, Value):
            self.fill(target, to, value)
            return
        place, item = to
        part = self.cast(value, ITEMS[item][1]).parts[0]
        if item == "u1":
            part = self.put(f"trunc i64 {part} to i8")
        self.lines.append(f"store {ITEMS[item][0]} {part}, ptr {place}")

    def do_for(self, node: ast.For) -> None:
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"):
            raise self.wrong(node.iter, "loops are over a range")
        bounds = [self.cast(self.value(a), "i") for a in call.args]
        step = bounds[2].number if len(bounds) == 3 else 1
        if not step:
            raise self.wrong(call, "the step is a number in the source")
        first, last = (bounds[0].parts[0], bounds[1].parts[0]) if len(bounds) > 1 else ("0", bounds[0].parts[0])
        count, loop = self.begin(first, last, step)
        self.store(node.target, Value("i", (count,)))
        self.loops.append((loop[2], loop[3]))
        self.block(node.body)
        self.loops.pop()
        self.end(loop)

    def do_while(self, node: ast.While) -> None:
        head, body, after = (self.label() for _ in range(3))
        self.go(head, head)
        self.fork(self.cast(self.value(node.test), "b").parts[0], body, after, body)
        self.loops.append((head, after))
        self.block(node.body)
        self.loops.pop()
        self.go(head, after)

    def do_continue(self, node: ast.Continue) -> None:
        self.go(self.loops[-1][0])

    def do_break(self, node: ast.Break) -> None:
        self.go(self.loops[-1][1])

    def do_if(self, node: ast.If) -> None:
        yes, no, after = (self.label() for _ in range(3))
        self.fork(self.cast(self.value(node.test), "b").parts[0], yes, no, yes)
        self.block(node.body)
        self.go(after, no)
        self.block(node.orelse)
        self.go(after, after)

    def do_return(self, node: ast.Return) -> None:
        value = Value(None, ()) if node.value is None else self.value(node.value)
        self.result = joined(self.result, value.kind)
        value = self.cast(value, self.result)
        types = llvm_types(self.result)
        if not types:
            self.lines.append("ret void")
        elif len(types) == 1:
            self.lines.append(f"ret {types[0]} {value.parts[0]}")
        else:
            whole, packed = result_type(types), "undef"
            for k, (t, part) in enumerate(zip(types, value.parts, strict=True)):
                packed = self.put(f"insertvalue {whole} {packed}, {t} {part}, {k}")
            self.lines.append(f"ret {whole} {packed}")
        self.lines.append(f"{self.label()}:")
