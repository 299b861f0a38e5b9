"""Arrays and plain values as bytes with a checksum, the same bytes for the same values.

A line that names the format, a line with the SHA-256 of the rest, a line of JSON, the arrays one after the other. In
the JSON an array stands as {"array": number}; a tuple comes back as a list, floats exactly as they were.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

__all__ = ["DamagedError", "pack", "unpack"]

MAGIC = b"directrix keeping 1\n"


class DamagedError(ValueError):
    """The bytes are not those that were written."""


def pack(values: Mapping[str, Any]) -> bytes:
    """``values`` may hold arrays, numbers, texts, None, lists, tuples and mappings of them."""
    arrays: list[np.ndarray] = []

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            arrays.append(np.ascontiguousarray(value))
            return {"array": len(arrays) - 1}
        if isinstance(value, np.generic):
            return value.item()
        if isinstance(value, Mapping):
            return {str(k): plain(v) for k, v in cast("Mapping[Any, Any]", value).items()}
        if isinstance(value, (list, tuple)):
            return [plain(v) for v in cast("list[Any]", value)]
        return value

    said = {"values": plain(values)}
    said["arrays"] = [[a.dtype.str, list(a.shape)] for a in arrays]
    body = b"".join([json.dumps(said).encode() + b"\n", *(a.tobytes() for a in arrays)])
    return MAGIC + hashlib.sha256(body).hexdigest().encode() + b"\n" + body


def unpack(data: bytes) -> dict[str, Any]:
    """What :func:`pack` packed. Raises DamagedError."""
    if not data.startswith(MAGIC):
        raise DamagedError("is no file of a run, or of another format")
    end = len(MAGIC) + 65
    body = memoryview(data)[end:]
    if hashlib.sha256(body).hexdigest().encode() + b"\n" != data[len(MAGIC) : end]:
        raise DamagedError("is damaged: its checksum is not that of its contents")
    line = data.index(b"\n", end) + 1
    said = json.loads(data[end:line])
    arrays: list[np.ndarray] = []
    for kind, shape in said["arrays"]:
        size = int(np.prod(shape)) * np.dtype(kind).itemsize
        arrays.append(np.frombuffer(data, kind, int(np.prod(shape)), line).reshape(shape).copy())
        line += size

    def rich(value: Any) -> Any:
        if isinstance(value, dict):
            table = cast("dict[str, Any]", value)
            return arrays[table["array"]] if set(table) == {"array"} else {k: rich(v) for k, v in table.items()}
        return [rich(v) for v in cast("list[Any]", value)] if isinstance(value, list) else value

    return rich(said["values"])
