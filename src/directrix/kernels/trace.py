"""Scalar expressions, recorded: an element is written once, as plain Python over scalars.

Run with :class:`Sym` arguments, such a function leaves a list of operations (+ − × ÷ and the functions of
``FUNCTIONS``) with common subexpressions merged. From that list come the tangent (:func:`derivative`), the SIMD
machine code (:mod:`directrix.kernels.compile`) and the operation counts. Run with float, complex or SymPy numbers
the same function is its own reference. Elements need no function but a square root (``x ** 0.5``, which every
kind of scalar has); the others are there for the energies that users write with NumPy's names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

__all__ = ["FUNCTIONS", "Graph", "Sym", "cross", "derivative", "dot", "needed", "replay", "slopes"]

Op = Literal["in", "const", "add", "sub", "mul", "div", "sqrt", "exp", "log", "sin", "cos", "tanh", "abs", "max"]
Number = float | int

FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "sqrt": lambda x: x**0.5,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tanh": np.tanh,
}


@dataclass(eq=False)
class Graph:
    """Operations in the order they were first met; equal operations are one."""

    ops: list[tuple[Op, float | int | str, int]] = field(default_factory=lambda: [])
    _seen: dict[tuple[Op, float | int | str, int], int] = field(default_factory=lambda: {})

    def _intern(self, op: Op, a: float | int | str, b: int = -1) -> Sym:
        key = (op, a, b)
        index = self._seen.get(key)
        if index is None:
            index = self._seen[key] = len(self.ops)
            self.ops.append(key)
        return Sym(self, index)

    def inputs(self, array: str, count: int) -> list[Sym]:
        """``count`` inputs, read from consecutive places of the argument ``array``."""
        return [self._intern("in", array, k) for k in range(count)]

    def const(self, value: Number) -> Sym:
        """A number."""
        return self._intern("const", float(value))

    def value_of(self, index: int) -> float | None:
        """The number behind a constant, None for anything else."""
        op, a, _ = self.ops[index]
        return float(a) if op == "const" else None

    def negated(self, index: int) -> Sym | None:
        """a where the value is −a, else None."""
        op, a, b = self.ops[index]
        return Sym(self, b) if op == "sub" and self.value_of(int(a)) == 0.0 else None

    def add(self, a: Sym, b: Sym) -> Sym:
        """a + b."""
        x, y = self.value_of(a.index), self.value_of(b.index)
        if x is not None and y is not None:
            return self.const(x + y)
        if x == 0.0:
            return b
        if y == 0.0:
            return a
        minus_a, minus_b = self.negated(a.index), self.negated(b.index)
        if minus_b is not None:
            return self.sub(a, minus_b)
        if minus_a is not None:
            return self.sub(b, minus_a)
        return self._intern("add", min(a.index, b.index), max(a.index, b.index))

    def sub(self, a: Sym, b: Sym) -> Sym:
        """a − b. Signs are moved to where they cost nothing: no rounding changes."""
        x, y = self.value_of(a.index), self.value_of(b.index)
        if x is not None and y is not None:
            return self.const(x - y)
        if y == 0.0:
            return a
        if a.index == b.index:
            return self.const(0.0)
        minus_a, minus_b = self.negated(a.index), self.negated(b.index)
        if minus_b is not None:
            return minus_b if x == 0.0 else self.add(a, minus_b)
        if x == 0.0:
            op, c, d = self.ops[b.index]
            if op == "sub":
                return self.sub(Sym(self, d), Sym(self, int(c)))
        elif minus_a is not None:
            return -self.add(minus_a, b)
        return self._intern("sub", a.index, b.index)

    def mul(self, a: Sym, b: Sym) -> Sym:
        """a · b."""
        x, y = self.value_of(a.index), self.value_of(b.index)
        if x is not None and y is not None:
            return self.const(x * y)
        if y is not None:
            a, b, x, y = b, a, y, x
        if x == 0.0:
            return self.const(0.0)
        if x == 1.0:
            return b
        if x is not None and x < 0.0:
            return -self.mul(self.const(-x), b)
        minus_a, minus_b = self.negated(a.index), self.negated(b.index)
        if minus_a is not None or minus_b is not None:
            product = self.mul(a if minus_a is None else minus_a, b if minus_b is None else minus_b)
            return product if minus_a is not None and minus_b is not None else -product
        if x is not None and self.ops[b.index][0] == "mul":  # c (c' v) = (c c') v
            _, c, d = self.ops[b.index]
            for one, other in ((int(c), d), (d, int(c))):
                inside = self.value_of(one)
                if inside is not None:
                    return self.mul(self.const(x * inside), Sym(self, other))
        return self._intern("mul", min(a.index, b.index), max(a.index, b.index))

    def div(self, a: Sym, b: Sym) -> Sym:
        """a / b."""
        x, y = self.value_of(a.index), self.value_of(b.index)
        if y is not None:
            return self.mul(a, self.const(1.0 / y))
        if x == 0.0:
            return a
        return self._intern("div", a.index, b.index)

    def larger(self, a: Sym, b: Sym) -> Sym:
        """max(a, b)."""
        return self._intern("max", a.index, b.index)

    def magnitude(self, a: Sym) -> Sym:
        """|a|."""
        return self._intern("abs", a.index)

    def call(self, function: Op, a: Sym) -> Sym:
        """``function(a)``, one of FUNCTIONS."""
        x = self.value_of(a.index)
        return self._intern(function, a.index) if x is None else self.const(FUNCTIONS[function](x))


@dataclass(frozen=True, slots=True)
class Sym:
    """One recorded scalar; supports + − × ÷, unary minus and powers with itself and with numbers.

    ``numpy.exp(sym)`` and the other names in FUNCTIONS find the methods below.
    """

    graph: Graph
    index: int

    def lift(self, other: Sym | Number) -> Sym:
        return other if isinstance(other, Sym) else self.graph.const(other)

    def __add__(self, other: Sym | Number) -> Sym:
        return self.graph.add(self, self.lift(other))

    __radd__ = __add__

    def __sub__(self, other: Sym | Number) -> Sym:
        return self.graph.sub(self, self.lift(other))

    def __rsub__(self, other: Number) -> Sym:
        return self.graph.sub(self.lift(other), self)

    def __mul__(self, other: Sym | Number) -> Sym:
        return self.graph.mul(self, self.lift(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Sym | Number) -> Sym:
        return self.graph.div(self, self.lift(other))

    def __rtruediv__(self, other: Number) -> Sym:
        return self.graph.div(self.lift(other), self)

    def __neg__(self) -> Sym:
        return self.graph.sub(self.graph.const(0.0), self)

    def __pow__(self, power: Number) -> Sym:
        if power == 0.5:
            return self.sqrt()
        if power == int(power):
            whole = self.graph.const(1.0)
            for _ in range(abs(int(power))):
                whole = whole * self
            return whole if power >= 0 else 1.0 / whole
        return (self.log() * power).exp()

    def sqrt(self) -> Sym:
        return self.graph.call("sqrt", self)

    def exp(self) -> Sym:
        return self.graph.call("exp", self)

    def log(self) -> Sym:
        return self.graph.call("log", self)

    def sin(self) -> Sym:
        return self.graph.call("sin", self)

    def cos(self) -> Sym:
        return self.graph.call("cos", self)

    def tanh(self) -> Sym:
        return self.graph.call("tanh", self)

    def size(self) -> Sym:
        """|value|, of which no derivative is taken."""
        return self.graph.magnitude(self)

    def larger(self, other: Sym) -> Sym:
        """The larger of two, of which no derivative is taken; a NaN in the other is returned."""
        return self.graph.larger(self, other)

    def sinh(self) -> Sym:
        return 0.5 * (self.exp() - (-self).exp())

    def cosh(self) -> Sym:
        return 0.5 * (self.exp() + (-self).exp())


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """a · b of two 3-tuples of any scalars."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, Any, Any]:
    """a × b of two 3-tuples of any scalars."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def needed(graph: Graph, outputs: Iterable[Sym], done: set[int] | None = None) -> list[int]:
    """Indices of what the outputs depend on, in the order of a depth-first visit of the outputs in turn.

    Each value is computed shortly before it is first used, which keeps the number of live values small.
    What is in ``done`` is left out, and what is returned is added to it.
    """
    order: list[int] = []
    done = set() if done is None else done
    for out in outputs:
        stack = [(out.index, False)]
        while stack:
            index, ready = stack.pop()
            if index in done:
                continue
            op, a, b = graph.ops[index]
            if ready or op in ("in", "const"):
                done.add(index)
                order.append(index)
                continue
            stack.append((index, True))
            if b >= 0:
                stack.append((b, False))
            stack.append((int(a), False))
    return order


def slopes(graph: Graph, index: int) -> dict[int, Sym]:
    """∂value/∂operand for the operands of one operation."""
    op, first, b = graph.ops[index]
    if op in ("in", "const"):
        return {}
    a, one = int(first), graph.const(1.0)
    x, f = Sym(graph, a), Sym(graph, index)
    match op:
        case "add" | "sub" | "mul" | "div":
            y = Sym(graph, b)
            match op:
                case "add":
                    pair = one, one
                case "sub":
                    pair = one, -one
                case "mul":
                    pair = y, x
                case _:
                    pair = 1.0 / y, -f / y
            return {a: pair[0] + pair[1]} if a == b else {a: pair[0], b: pair[1]}
        case "sqrt":
            return {a: 0.5 / f}
        case "exp":
            return {a: f}
        case "log":
            return {a: 1.0 / x}
        case "sin":
            return {a: x.cos()}
        case "cos":
            return {a: -x.sin()}
        case _:  # tanh
            return {a: 1.0 - f * f}


def derivative(graph: Graph, outputs: Sequence[Sym], seed: Mapping[Sym, Sym | Number]) -> list[Sym]:
    """Directional derivative of the outputs, forward mode.

    ``seed`` gives the derivative of some values (inputs or not) in the direction; every input that it does
    not name is held fixed. Values named in the seed are not differentiated further.
    """
    zero = graph.const(0.0)
    d: dict[int, Sym] = {s.index: zero.lift(v) for s, v in seed.items()}
    for index in needed(graph, outputs):
        if index in d:
            continue
        value = zero
        for operand, slope in slopes(graph, index).items():
            if operand in d:
                value = value + slope * d[operand]
        if graph.value_of(value.index) != 0.0:
            d[index] = value
    return [d.get(out.index, zero) for out in outputs]


def replay(graph: Graph, outputs: Sequence[Sym], inputs: Callable[[str, int], Any]) -> list[Any]:
    """The outputs for other scalars: ``inputs(array, place)`` gives them, of any kind that the operations know."""
    values: dict[int, Any] = {}
    for index in needed(graph, outputs):
        op, a, b = graph.ops[index]
        match op:
            case "const":
                value: Any = float(a)
            case "in":
                value = inputs(str(a), b)
            case "add":
                value = values[int(a)] + values[b]
            case "sub":
                value = values[int(a)] - values[b]
            case "mul":
                value = values[int(a)] * values[b]
            case "div":
                value = values[int(a)] / values[b]
            case _:
                value = FUNCTIONS[op](values[int(a)])
        values[index] = value
    return [values[out.index] for out in outputs]
