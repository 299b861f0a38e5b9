"""What an object has to remember of a run so that it can go on from there: some of its attributes, copied."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

__all__ = ["recall", "remember"]


def remember(of: object, *names: str) -> dict[str, Any]:
    """Copies of the attributes ``names``: arrays, numbers, texts, lists and tuples of them."""
    return {name: _copied(getattr(of, name)) for name in names}


def recall(of: object, memory: Mapping[str, Any]) -> None:
    """Put back what :func:`remember` gave. An array that fits is written into: others may hold it."""
    for name, value in memory.items():
        here = getattr(of, name)
        if isinstance(here, np.ndarray) and here.shape == value.shape and here.dtype == value.dtype:
            here[...] = value
        else:
            setattr(of, name, tuple(value) if isinstance(here, tuple) else value)


def _copied(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return cast("Any", value.copy())
    return list(cast("list[Any]", value)) if isinstance(value, list) else value
