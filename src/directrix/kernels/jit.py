"""The decorator of the compiled loops."""
# pyright: basic

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from functools import update_wrapper
from typing import Any

import numpy as np

from directrix.kernels.compile import text_address
from directrix.kernels.kinds import Array
from directrix.kernels.record import Record
from directrix.kernels.translate import Translation, kind_of

__all__ = ["compiled", "inner"]

ITEM = {np.dtype(t): t for t in ("f8", "i8", "u1")}
ENTRY = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class _Loop:
    """A function that is translated (:mod:`directrix.kernels.translate`) and compiled when it is first called with
    arguments of some kinds, at most once per machine. While it runs, other threads run as well."""

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.function = function
        self.ready: dict[tuple[Any, ...], Any] = {}

    def __call__(self, *arguments: Any) -> Any:
        given = self.function.__defaults__ or ()
        missing = self.function.__code__.co_argcount - len(arguments)
        if missing:
            arguments = (*arguments, *given[len(given) - missing :])
        kinds: list[Any] = []
        words: list[int] = []
        for value in arguments:
            kinds.append(_word(value, words))
        key = tuple(kinds)
        call = self.ready.get(key) or self.make(key)
        out = (ctypes.c_int64 * 8)()
        call((ctypes.c_int64 * len(words))(*words), out)
        result = kind_of(out[0])
        if result.startswith("("):
            return tuple(_number(kind, word) for kind, word in zip(result[1:], out[1:], strict=False))
        return _number(result, out[1]) if result else None

    def make(self, kinds: tuple[Any, ...]) -> Any:
        """Compile, or fetch from the cache."""
        name = f"{self.function.__module__}.{self.function.__qualname__}"
        address = text_address(
            f"loop {name} {kinds}", lambda symbol: Translation().entry(self.function, kinds, symbol), loops=True
        )
        self.ready[kinds] = ENTRY(address)
        return self.ready[kinds]


def _word(value: Any, words: list[int]) -> Any:
    """Append the words of an argument; its kind."""
    if isinstance(value, np.ndarray):
        about = value.__array_interface__
        words.append(about["data"][0])
        words += value.shape
        strides = about["strides"]
        if strides is not None:
            words += strides
        return Array(ITEM[value.dtype], value.ndim, strides is None)
    if isinstance(value, Record):
        words.append(value.address)
        return value.kind
    if isinstance(value, float):
        words.append(struct.unpack("q", struct.pack("d", value))[0])
        return "f"
    words.append(int(value))
    return "b" if isinstance(value, bool | np.bool_) else "i"


def _number(kind: str, word: int) -> Any:
    if kind == "f":
        return struct.unpack("d", struct.pack("q", word))[0]
    return bool(word) if kind == "b" else word


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of the language of :mod:`directrix.kernels.translate`. Called from Python it takes arrays of
    float64, int64 and uint8, records and numbers, all by position, and returns numbers."""
    return _Loop(function)


inner = compiled
"""What only compiled loops call, with any kinds of arguments that compiled loops have."""
