"""Many arrays as one argument of compiled loops: a pointer to where they are."""
# pyright: basic

from __future__ import annotations

import ctypes
import dataclasses
from typing import Any, Self, dataclass_transform

import numpy as np

from directrix.kernels.kinds import Array, Fields

__all__ = ["Record", "address"]

_capsule = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
    ("PyCapsule_GetPointer", ctypes.pythonapi)
)
DATA = 40  # where NumPy's array interface in C has the address: behind five ints and two pointers


def address(array: np.ndarray[Any, Any]) -> int:
    """Where the first item of an array is. ``array.ctypes.data`` says the same and takes many times longer."""
    interface = array.__array_struct__  # what it points to goes with it
    return ctypes.c_void_p.from_address(_capsule(interface, None) + DATA).value or 0


@dataclass_transform(frozen_default=True)
class Record:
    """Base of frozen values whose fields are C-contiguous arrays, ints, bools and floats.

    In compiled loops fields are read as attributes, and arrays are written in place. Raises TypeError for an array that
    is not contiguous.
    """

    kind: Fields
    address: int
    """Where the words of 64 bits are that compiled loops read: addresses and sizes of arrays, and numbers."""

    def __init_subclass__(cls) -> None:
        dataclasses.dataclass(frozen=True, eq=False)(cls)

    def __post_init__(self) -> None:
        kinds: list[tuple[str, Any]] = []
        words: list[int] = []
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                if not value.flags.c_contiguous:
                    raise TypeError(f"{field.name} of {type(self).__name__} is not contiguous")
                kinds.append((field.name, Array(value.dtype.str[1:], value.ndim)))
                words += [address(value), *value.shape]
            else:
                real = isinstance(value, float)
                kinds.append((field.name, "f" if real else "i"))
                words.append(int(np.float64(value).view(np.int64)) if real else int(value))
        kept = np.array(words, np.int64)
        for name, value in (("kind", Fields.of(*kinds)), ("words", kept), ("address", address(kept))):
            object.__setattr__(self, name, value)

    def replaced(self, **changes: Any) -> Self:
        """The same with other values in some fields."""
        return dataclasses.replace(self, **changes)  # type: ignore[type-var]
