"""Who may dissipate in a run: the names, and which of them each element and each stress point is booked under."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from directrix.groups import Group
from directrix.model import Model
from directrix.scheme import Rates, Scheme

Ints = NDArray[np.int64]

__all__ = ["NUMERICAL", "Sources", "sources_of"]

NUMERICAL = "numerical dissipation"


@dataclass(frozen=True)
class Sources:
    """``names`` in the order in which they are booked.

    ``element`` (elements,) is the source of every element that dissipates by itself, ``material`` (rods,) that of the
    damping of every rod's section, ``numerical`` that of the scheme; −1 where there is none.
    """

    names: tuple[str, ...]
    element: Ints
    material: Ints
    numerical: int


def sources_of(model: Model, groups: Sequence[Group], scheme: Scheme) -> Sources:
    """The sources of a model under a scheme: elements of lossy groups by their names, then sections, then the scheme.

    Elements of one name are one source.
    """
    index: dict[str, int] = {}

    def at(name: str) -> int:
        return index.setdefault(name, len(index))

    element = [at(name) if group.lossy else -1 for group in groups for name in (group.names or ("",) * len(group.conn))]
    damped = not scheme.static and scheme.rates is not Rates.ALPHA
    material = [
        at(f"damping of rod {rod.name!r}") if damped and rod.section.damping.any() else -1 for rod in model.rods
    ]
    numerical = at(NUMERICAL) if damped and any(scheme.common[2:4]) else -1
    return Sources(tuple(index), np.array(element, np.int64), np.array(material, np.int64), numerical)
