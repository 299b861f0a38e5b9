"""What a value is in a compiled loop, and what it consists of in LLVM's language."""
# pyright: basic

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

__all__ = ["ITEMS", "SCALARS", "Array", "Fields", "Value", "joined", "llvm_types", "result_type"]

SCALARS = {"f": "double", "i": "i64", "b": "i1"}
ITEMS = {"f8": ("double", "f"), "i8": ("i64", "i"), "u1": ("i8", "i")}


@dataclass(frozen=True)
class Array:
    """Kind of an array: ``item`` in ITEMS; a packed one is contiguous and has no strides of its own."""

    item: str
    ndim: int
    packed: bool = True


@dataclass(frozen=True, eq=False)
class Fields:
    """Kind of a record: (name, kind) of its fields, in the order of their words. Equal ones are one object."""

    fields: tuple[tuple[str, Any], ...]

    @staticmethod
    @cache
    def of(*fields: tuple[str, Any]) -> Fields:
        """The one object for these fields."""
        return Fields(fields)


@dataclass(frozen=True)
class Value:
    """A value in LLVM's language: ``parts`` are the operands that it consists of, see :func:`llvm_types`."""

    kind: Any
    parts: tuple[str, ...]

    @property
    def number(self) -> int | None:
        """The number when it is an int known at compile time."""
        if self.kind != "i":
            return None
        digits = self.parts[0]
        return int(digits) if digits.lstrip("-").isdigit() else None


def llvm_types(kind: Any) -> list[str]:
    """The types of the operands that a value of a kind consists of: an array is a pointer, sizes (and strides)."""
    if kind is None:
        return []
    if isinstance(kind, str):
        return [SCALARS[kind]]
    if isinstance(kind, Array):
        return ["ptr"] + ["i64"] * (kind.ndim if kind.packed else 2 * kind.ndim)
    if isinstance(kind, Fields):
        return ["ptr"]
    return [t for part in kind for t in llvm_types(part)]


def joined(a: Any, b: Any) -> Any:
    """The kind of a variable that is given values of two kinds."""
    if a == b or b is None:
        return a
    if a is None:
        return b
    if isinstance(a, str) and isinstance(b, str):
        return "f" if "f" in (a, b) else "i"
    if isinstance(a, Array) and isinstance(b, Array) and (a.item, a.ndim) == (b.item, b.ndim):
        return Array(a.item, a.ndim, packed=False)
    if isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b):
        return tuple(joined(p, q) for p, q in zip(a, b, strict=True))
    raise NotImplementedError(f"one variable for {a} and {b}")


def result_type(types: Sequence[str]) -> str:
    """The type of what a function returns."""
    return "void" if not types else types[0] if len(types) == 1 else "{" + ", ".join(types) + "}"
