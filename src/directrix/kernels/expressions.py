"""Expressions and variables of compiled loops in LLVM's language; see :mod:`directrix.kernels.translate`."""
# pyright: basic

from __future__ import annotations

import ast
import builtins
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from directrix.kernels.kinds import ITEMS, SCALARS, Array, Fields, Value, joined, llvm_types, result_type

__all__ = ["Emitted", "Expressions", "Whole"]

MATH: dict[Any, tuple[str, int]] = {
    math.sqrt: ("llvm.sqrt.f64", 1), math.sin: ("llvm.sin.f64", 1), math.cos: ("llvm.cos.f64", 1),
    np.arctan2: ("atan2", 2), math.atan2: ("atan2", 2), math.exp: ("llvm.exp.f64", 1), math.log: ("llvm.log.f64", 1),
}  # fmt: skip
COMPARE = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}


class Whole(Protocol):
    """The module that a function is part of."""

    declared: set[str]

    def function(self, function: Any, kinds: tuple[Any, ...]) -> tuple[str, Any]:
        """Name and kind of result of a function for arguments of some kinds."""
        ...


@dataclass(frozen=True)
class Emitted:
    """A function that writes its own code: ``emit(translation, values)``; its result, if it has one."""

    emit: Callable[[Expressions, Sequence[Value]], Value | None]


@cache
def _functions(file: str) -> dict[str, ast.FunctionDef]:
    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


class Expressions:
    """The code of one function as it is written."""

    def __init__(
        self, whole: Whole, function: Any, kinds: tuple[Any, ...], variables: dict[str, Any], result: Any
    ) -> None:
        self.whole, self.function, self.kinds = whole, function, kinds
        self.variables, self.result = variables, result
        self.lines: list[str] = []
        self.rooms: list[str] = []
        self.held: dict[str, list[str]] = {}  # where variables are
        self.names = 0
        self.loops: list[tuple[str, str]] = []  # where continue and break go
        self.node = _functions(function.__code__.co_filename)[function.__name__]

    # --- writing ---

    def fresh(self) -> str:
        self.names += 1
        return f"%t{self.names}"

    def put(self, text: str) -> str:
        """Write an instruction with a result."""
        name = self.fresh()
        self.lines.append(f"{name} = {text}")
        return name

    def room(self, of: str) -> str:
        """Room on the stack, once a call of the function."""
        name = self.fresh()
        self.rooms.append(f"{name} = alloca {of}, align 32")
        return name

    def label(self) -> str:
        self.names += 1
        return f"L{self.names}"

    def go(self, to: str, start: str | None = None) -> None:
        """Jump, and begin another block."""
        self.lines.append(f"br label %{to}")
        self.lines.append(f"{start or self.label()}:")

    def fork(self, on: str, yes: str, no: str, start: str) -> None:
        self.lines += [f"br i1 {on}, label %{yes}, label %{no}", f"{start}:"]

    def wrong(self, node: ast.AST, what: str) -> NotImplementedError:
        where = f"{self.function.__code__.co_filename}:{getattr(node, 'lineno', 0)}"
        return NotImplementedError(f"{where}: {what}: {ast.unparse(node)}")

    # --- variables ---

    def assign(self, name: str, value: Value) -> None:
        kind = self.variables[name] = joined(self.variables.get(name), value.kind)
        types = llvm_types(kind)
        if name not in self.held or len(self.held[name]) != len(types):
            self.held[name] = [self.room(t) for t in types]
        for t, part, to in zip(types, self.cast(value, kind).parts, self.held[name], strict=True):
            self.lines.append(f"store {t} {part}, ptr {to}")

    def cast(self, value: Value, kind: Any) -> Value:
        """The same value of another kind."""
        if value.kind == kind:
            return value
        if isinstance(kind, tuple):
            parts: list[str] = []
            at = 0
            for old, new in zip(value.kind, kind, strict=True):
                count = len(llvm_types(old))
                parts += self.cast(Value(old, value.parts[at : at + count]), new).parts
                at += count
            return Value(kind, tuple(parts))
        if isinstance(kind, Array):
            return Value(kind, (*value.parts[: 1 + kind.ndim], *self.strides(value)))
        part = value.parts[0]
        if kind == "f":
            how = "sitofp i64" if value.kind == "i" else "uitofp i1"
            return Value("f", (self.put(f"{how} {part} to double"),))
        if kind == "i":
            how = "zext i1 {} to i64" if value.kind == "b" else "fptosi double {} to i64"
            return Value("i", (self.put(how.format(part)),))
        zero = "icmp ne i64 {}, 0" if value.kind == "i" else "fcmp une double {}, 0.0"
        return Value("b", (self.put(zero.format(part)),))

    def taken_apart(self, value: Value) -> list[Value]:
        out: list[Value] = []
        at = 0
        for kind in value.kind:
            count = len(llvm_types(kind))
            out.append(Value(kind, value.parts[at : at + count]))
            at += count
        return out

    def fill(self, node: ast.expr, array: Value, value: Value) -> None:
        """Every number of a packed array, with one number or those of another packed array."""
        copied = isinstance(value.kind, Array)
        if not array.kind.packed or (copied and not value.kind.packed):
            raise self.wrong(node, "only a packed array can be filled")
        count = "1"
        for size in array.parts[1:]:
            count = self.operate("mul nsw", "i", count, size)
        t, scalar = ITEMS[array.kind.item]
        counter, end = self.begin("0", count, 1)
        if copied:
            from_ = self.put(f"getelementptr inbounds {t}, ptr {value.parts[0]}, i64 {counter}")
            part = self.put(f"load {t}, ptr {from_}")
        else:
            part = self.cast(value, scalar).parts[0]
        place = self.put(f"getelementptr inbounds {t}, ptr {array.parts[0]}, i64 {counter}")
        self.lines.append(f"store {t} {part}, ptr {place}")
        self.end(end)

    def begin(self, first: str, last: str, step: int) -> tuple[str, tuple[str, str, str, str, int]]:
        """Begin a counted loop; the count, and what :meth:`end` wants."""
        counter = self.room("i64")
        head, body, tail, after = (self.label() for _ in range(4))
        self.lines.append(f"store i64 {first}, ptr {counter}")
        self.go(head, head)
        now = self.put(f"load i64, ptr {counter}")
        self.fork(self.put(f"icmp {'slt' if step > 0 else 'sgt'} i64 {now}, {last}"), body, after, body)
        return now, (counter, head, tail, after, step)

    def end(self, loop: tuple[str, str, str, str, int]) -> None:
        counter, head, tail, after, step = loop
        self.go(tail, tail)
        now = self.put(f"load i64, ptr {counter}")
        self.lines.append(f"store i64 {self.put(f'add nsw i64 {now}, {step}')}, ptr {counter}")
        self.go(head, after)

    # --- expressions ---

    def value(self, node: ast.expr) -> Value:
        return getattr(self, f"of_{type(node).__name__.lower()}", self.of_other)(node)

    def of_other(self, node: ast.expr) -> Value:
        raise self.wrong(node, "not in the language of compiled loops")

    def constant(self, node: ast.AST, number: Any) -> Value:
        if isinstance(number, bool | np.bool_):
            return Value("b", ("true" if number else "false",))
        if isinstance(number, int | np.integer):
            return Value("i", (str(int(number)),))
        if isinstance(number, float | np.floating):
            return Value("f", (f"0x{struct.pack('>d', float(number)).hex().upper()}",))
        raise self.wrong(node, "not a number")

    def of_constant(self, node: ast.Constant) -> Value:
        return self.constant(node, node.value)

    def of_name(self, node: ast.Name) -> Value:
        if node.id not in self.variables:
            return self.constant(node, self.known(node))
        kind = self.variables[node.id]
        if node.id not in self.held:
            self.held[node.id] = [self.room(t) for t in llvm_types(kind)]
        parts = zip(llvm_types(kind), self.held[node.id], strict=True)
        return Value(kind, tuple(self.put(f"load {t}, ptr {at}") for t, at in parts))

    def known(self, node: ast.expr) -> Any:
        """What a name means in the module of the function, or one of its attributes."""
        if isinstance(node, ast.Attribute):
            return getattr(self.known(node.value), node.attr)
        if not isinstance(node, ast.Name):
            raise self.wrong(node, "not known")
        scope = self.function.__globals__
        if node.id in scope:
            return scope[node.id]
        if not hasattr(builtins, node.id):
            raise self.wrong(node, "not known")
        return getattr(builtins, node.id)

    def of_tuple(self, node: ast.Tuple) -> Value:
        values = [self.value(part) for part in node.elts]
        return Value(tuple(v.kind for v in values), tuple(p for v in values for p in v.parts))

    def operate(self, how: str, kind: str, a: str, b: str) -> str:
        if kind == "i" and (x := Value("i", (a,)).number) is not None and (y := Value("i", (b,)).number) is not None:
            whole = {"add nsw": x + y, "sub nsw": x - y, "mul nsw": x * y}
            if how in whole:
                return str(whole[how])
        if how == "mul nsw" and "1" in (a, b):
            return b if a == "1" else a
        if how == "add nsw" and "0" in (a, b):
            return b if a == "0" else a
        return self.put(f"{how} {SCALARS[kind]} {a}, {b}")

    def of_binop(self, node: ast.BinOp) -> Value:
        return self.operated(node, node.op, self.value(node.left), self.value(node.right))

    def operated(self, node: ast.AST, op: ast.operator, left: Value, right: Value) -> Value:
        if isinstance(op, ast.Pow):
            return self.power(node, left, right)
        kind = "f" if isinstance(op, ast.Div) or "f" in (left.kind, right.kind) else "i"
        a, b = self.cast(left, kind).parts[0], self.cast(right, kind).parts[0]
        names = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div"}
        if type(op) in names:
            name = names[type(op)]  # type: ignore[index]
            return Value(kind, (self.operate(f"f{name}" if kind == "f" else f"{name} nsw", kind, a, b),))
        if kind == "i" and isinstance(op, ast.FloorDiv | ast.Mod):
            return Value("i", (self.divided(isinstance(op, ast.Mod), a, b),))
        raise self.wrong(node, "no such operation")

    def divided(self, rest: bool, a: str, b: str) -> str:
        """a // b or a % b, rounded down."""
        x, y = Value("i", (a,)).number, Value("i", (b,)).number
        if x is not None and y:
            return str(x % y if rest else x // y)
        left = self.put(f"srem i64 {a}, {b}")
        other = self.put(f"icmp slt i64 {self.put(f'xor i64 {left}, {b}')}, 0")
        down = self.put(f"and i1 {other}, {self.put(f'icmp ne i64 {left}, 0')}")
        if rest:
            return self.put(f"select i1 {down}, i64 {self.put(f'add i64 {left}, {b}')}, i64 {left}")
        return self.put(f"sub i64 {self.put(f'sdiv i64 {a}, {b}')}, {self.put(f'zext i1 {down} to i64')}")

    def power(self, node: ast.AST, base: Value, power: Value) -> Value:
        n = power.number
        if n is None or n < 1:
            raise self.wrong(node, "powers are whole and positive")
        x = out = base.parts[0]
        for _ in range(n - 1):
            out = self.operate("fmul" if base.kind == "f" else "mul nsw", base.kind, out, x)
        return Value(base.kind, (out,))

    def of_unaryop(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return Value("b", (self.put(f"xor i1 {self.cast(value, 'b').parts[0]}, true"),))
        if not isinstance(node.op, ast.USub):
            raise self.wrong(node, "no such operation")
        if value.kind == "f":
            return Value("f", (self.put(f"fneg double {value.parts[0]}"),))
        return Value("i", (self.operate("sub nsw", "i", "0", self.cast(value, "i").parts[0]),))

    def of_compare(self, node: ast.Compare) -> Value:
        values = [self.value(part) for part in (node.left, *node.comparators)]
        out = ""
        for op, a, b in zip(node.ops, values, values[1:], strict=False):
            one = self.compared(COMPARE[type(op)], a, b)  # type: ignore[index]
            out = self.put(f"and i1 {out}, {one}") if out else one
        return Value("b", (out,))

    def compared(self, how: str, a: Value, b: Value) -> str:
        kind = "f" if "f" in (a.kind, b.kind) else "i"
        x, y = self.cast(a, kind).parts[0], self.cast(b, kind).parts[0]
        if kind == "f":
            return self.put(f"fcmp {'une' if how == 'ne' else 'o' + how} double {x}, {y}")
        return self.put(f"icmp {how if how in ('eq', 'ne') else 's' + how} i64 {x}, {y}")

    def of_boolop(self, node: ast.BoolOp) -> Value:
        out, after = self.room("i1"), self.label()
        for k, part in enumerate(node.values):
            now = self.cast(self.value(part), "b").parts[0]
            self.lines.append(f"store i1 {now}, ptr {out}")
            if k == len(node.values) - 1:
                self.go(after, after)
            else:
                more = self.label()
                yes, no = (more, after) if isinstance(node.op, ast.And) else (after, more)
                self.fork(now, yes, no, more)
        return Value("b", (self.put(f"load i1, ptr {out}"),))

    def of_ifexp(self, node: ast.IfExp) -> Value:
        yes, no, after = (self.label() for _ in range(3))
        self.fork(self.cast(self.value(node.test), "b").parts[0], yes, no, yes)
        name = f" {node.lineno}:{node.col_offset}"  # a variable that no source can name
        self.assign(name, self.value(node.body))
        self.go(after, no)
        self.assign(name, self.value(node.orelse))
        self.go(after, after)
        return self.of_name(ast.Name(name, ast.Load()))

    def of_attribute(self, node: ast.Attribute) -> Value:
        root: ast.expr = node
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in self.variables:
            return self.constant(node, self.known(node))
        value = self.value(node.value)
        if not isinstance(value.kind, Fields):
            raise self.wrong(node, "no such attribute")
        at = 0
        for name, kind in value.kind.fields:
            types = llvm_types(kind)
            if name == node.attr:
                return Value(kind, tuple(self.word(value.parts[0], at + k, t) for k, t in enumerate(types)))
            at += len(types)
        raise self.wrong(node, "no such field")

    def word(self, start: str, place: int, kind: str) -> str:
        at = self.put(f"getelementptr inbounds i64, ptr {start}, i64 {place}")
        # a record never changes
        return self.put(f"load {kind}, ptr {at}, align 8, !invariant.load !{{}}")

    def strides(self, array: Value) -> tuple[str, ...]:
        ndim = array.kind.ndim
        if not array.kind.packed:
            return array.parts[1 + ndim :]
        out = ["1"]
        for size in reversed(array.parts[2 : 1 + ndim]):
            out.insert(0, self.operate("mul nsw", "i", out[0], size))
        return tuple(out)

    def item(self, node: ast.Subscript) -> Value | tuple[str, str]:
        """What an index leads to: a smaller array, or the address of a number and the kind of its array."""
        array = self.value(node.value)
        if not isinstance(array.kind, Array):
            raise self.wrong(node, "only arrays have items")
        wanted = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        sizes, strides = array.parts[1 : 1 + array.kind.ndim], self.strides(array)
        offset, shape, steps = "0", list[str](), list[str]()
        packed = array.kind.packed
        for k, index in enumerate(wanted):
            if isinstance(index, ast.Slice):
                low = self.index(index.lower, sizes[k]) if index.lower else "0"
                high = self.index(index.upper, sizes[k]) if index.upper else sizes[k]
                # what is cut off behind the first dimension that is left leaves gaps
                packed = packed and not (shape and (index.lower or index.upper))
                shape.append(self.operate("sub nsw", "i", high, low))
                steps.append(strides[k])
            else:
                low = self.index(index, sizes[k])
                packed = packed and not shape
            offset = self.operate("add nsw", "i", offset, self.operate("mul nsw", "i", low, strides[k]))
        item = ITEMS[array.kind.item][0]
        place = self.put(f"getelementptr inbounds {item}, ptr {array.parts[0]}, i64 {offset}")
        shape += sizes[len(wanted) :]
        steps += strides[len(wanted) :]
        if not shape:
            return place, array.kind.item
        parts = (place, *shape) if packed else (place, *shape, *steps)
        return Value(Array(array.kind.item, len(shape), packed), parts)

    def index(self, node: ast.expr, size: str) -> str:
        value = self.cast(self.value(node), "i")
        if value.number is not None and value.number < 0:
            return self.operate("add nsw", "i", size, value.parts[0])
        return value.parts[0]

    def place(self, node: ast.Subscript) -> tuple[str, str]:
        found = self.item(node)
        if isinstance(found, Value):
            raise self.wrong(node, "not a number")
        return found

    def of_subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            array, axis = self.value(node.value.value), self.value(node.slice).number
            assert axis is not None
            return Value("i", (array.parts[1 + axis],))
        if isinstance(node.value, ast.Call):  # one of several results
            at = self.value(node.slice).number
            assert at is not None
            return self.taken_apart(self.value(node.value))[at]
        found = self.item(node)
        if isinstance(found, Value):
            return found
        item, kind = ITEMS[found[1]]
        part = self.put(f"load {item}, ptr {found[0]}")
        return Value(kind, (self.put(f"zext i8 {part} to i64") if item == "i8" else part,))

    # --- calls ---

    def of_call(self, node: ast.Call) -> Value:
        if isinstance(node.func, ast.Attribute) and node.func.attr == "reshape":
            return self.flat(node, self.value(node.func.value))
        called = self.known(node.func)
        if called in (np.empty, np.zeros):
            return self.made(node, called is np.zeros)
        values = [self.value(argument) for argument in node.args]
        if isinstance(called, Emitted):
            return called.emit(self, values) or Value(None, ())
        if called in (min, max):
            return self.extreme("lt" if called is min else "gt", values)
        if called is abs:
            return self.size(values[0])
        if called in (int, float, bool):
            return self.cast(values[0], {int: "i", float: "f", bool: "b"}[called])
        if called in MATH:
            name, count = MATH[called]
            self.whole.declared.add(f"declare double @{name}({', '.join(['double'] * count)})")
            operands = ", ".join(f"double {self.cast(v, 'f').parts[0]}" for v in values)
            return Value("f", (self.put(f"call double @{name}({operands})"),))
        return self.call(node, called, values)

    def call(self, node: ast.Call, called: Any, values: list[Value]) -> Value:
        """Another compiled loop."""
        function = getattr(called, "__wrapped__", None)
        if function is None or node.keywords:
            raise self.wrong(node, "only other loops can be called, by position")
        given = function.__defaults__ or ()
        missing = function.__code__.co_argcount - len(values)
        values += [self.constant(node, d) for d in given[len(given) - missing :]]
        name, result = self.whole.function(function, tuple(v.kind for v in values))
        operands = [f"{t} {p}" for v in values for t, p in zip(llvm_types(v.kind), v.parts, strict=True)]
        types = llvm_types(result)
        text = f"call {result_type(types)} @{name}({', '.join(operands)})"
        if not types:
            self.lines.append(text)
            return Value(None, ())
        whole = self.put(text)
        if len(types) == 1:
            return Value(result, (whole,))
        parts = tuple(self.put(f"extractvalue {result_type(types)} {whole}, {k}") for k in range(len(types)))
        return Value(result, parts)

    def flat(self, node: ast.Call, array: Value) -> Value:
        if not array.kind.packed:
            raise self.wrong(node, "only a packed array can be reshaped")
        count = "1"
        for size in array.parts[1:]:
            count = self.operate("mul nsw", "i", count, size)
        return Value(Array(array.kind.item, 1), (array.parts[0], count))

    def made(self, node: ast.Call, zero: bool) -> Value:
        given = node.args[0]
        sizes = [self.value(part) for part in (given.elts if isinstance(given, ast.Tuple) else [given])]
        numbers = [size.number for size in sizes]
        if any(n is None for n in numbers):
            raise self.wrong(node, "a new array has a shape that is a number in the source")
        place = self.room(f"[{math.prod(n or 0 for n in numbers)} x double]")
        array = Value(Array("f8", len(sizes)), (place, *(size.parts[0] for size in sizes)))
        if zero:
            self.fill(node, array, Value("f", ("0.0",)))
        return array

    def extreme(self, how: str, values: list[Value]) -> Value:
        kind = "f" if any(v.kind == "f" for v in values) else "i"
        best = self.cast(values[0], kind)
        for value in values[1:]:
            other = self.cast(value, kind)
            pick, t = self.compared(how, other, best), SCALARS[kind]
            best = Value(kind, (self.put(f"select i1 {pick}, {t} {other.parts[0]}, {t} {best.parts[0]}"),))
        return best

    def size(self, value: Value) -> Value:
        if value.kind != "f":
            x = self.cast(value, "i").parts[0]
            minus = self.put(f"sub i64 0, {x}")
            return Value("i", (self.put(f"select i1 {self.put(f'icmp slt i64 {x}, 0')}, i64 {minus}, i64 {x}"),))
        self.whole.declared.add("declare double @llvm.fabs.f64(double)")
        return Value("f", (self.put(f"call double @llvm.fabs.f64(double {value.parts[0]})"),))
