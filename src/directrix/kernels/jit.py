"""The decorator of the compiled loops."""
# pyright: basic

from __future__ import annotations

import ctypes
import hashlib
import struct
from collections.abc import Callable
from functools import cache, update_wrapper
from pathlib import Path
from typing import Any

import numpy as np

from directrix.kernels.compile import text_address
from directrix.kernels.kinds import Array
from directrix.kernels.record import Record, address
from directrix.kernels.translate import Translation, kind_of

__all__ = ["compiled", "inner"]

# kinds of arrays by type, dimensions and whether strides are left out; one object each, known by its place in memory
ARRAYS = {
    (np.dtype(item), ndim, packed): Array(item, ndim, packed)
    for item in ("f8", "i8", "u1") for ndim in range(1, 7) for packed in (True, False)
}  # fmt: skip
OUT = ctypes.c_int64 * 8
ENTRY = ctypes.CFUNCTYPE(None, ctypes.c_char_p, OUT)


class _Loop:
    """A function that is translated (:mod:`directrix.kernels.translate`) and compiled when it is first called with
    arguments of some kinds, at most once per machine. While it runs, other threads run as well."""

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.function = function
        self.count = function.__code__.co_argcount
        self.ready: dict[tuple[int, ...], tuple[Any, Callable[..., bytes]]] = {}

    def __call__(self, *arguments: Any) -> Any:
        missing = self.count - len(arguments)
        if missing:
            arguments = (*arguments, *(self.function.__defaults__ or ())[-missing:])
        words: list[int | float] = []
        kinds = [_word(value, words) for value in arguments]
        key = tuple(map(id, kinds))  # kinds that are equal are one object
        ready = self.ready.get(key)
        if ready is None:
            of = "".join("d" if isinstance(word, float) else "q" for word in words)
            ready = self.ready[key] = self.make(tuple(kinds)), struct.Struct(of).pack
        call, packed = ready
        out = OUT()
        call(packed(*words), out)
        if not out[0]:
            return None
        result = kind_of(out[0])
        if result.startswith("("):
            return tuple(_number(kind, word) for kind, word in zip(result[1:], out[1:], strict=False))
        return _number(result, out[1])

    def make(self, kinds: tuple[Any, ...]) -> Any:
        """Compile, or fetch from the cache."""
        name = f"{self.function.__module__}.{self.function.__qualname__}"
        about = f"loop {name} {_source(self.function.__code__.co_filename)} {kinds}"
        address = text_address(about, lambda symbol: Translation().entry(self.function, kinds, symbol), loops=True)
        return ENTRY(address)


@cache
def _source(file: str) -> str:
    """What changes with a file: the code of the loops of this folder changes with all files in it as well."""
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


def _word(value: Any, words: list[int | float]) -> Any:
    """Append the words of an argument; its kind."""
    if isinstance(value, Record):
        words.append(value.address)
        return value.kind
    if isinstance(value, np.ndarray):
        packed = value.flags.c_contiguous
        words.append(address(value))
        words += value.shape
        if not packed:
            words += value.strides
        kind = ARRAYS.get((value.dtype, value.ndim, packed))
        if kind is None:
            raise TypeError(f"compiled loops take no array of {value.dtype} with {value.ndim} dimensions")
        return kind
    if isinstance(value, float):
        words.append(value)
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
