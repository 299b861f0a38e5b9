"""Who may dissipate in a run and who may do work: names, and under which of them what is booked."""

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
    """``names`` in the order in which they are booked; ``lossy`` may dissipate, ``working`` may do work.

    ``element`` (elements, 2) are the sources of every element that takes or brings in energy by itself, ``material``
    (rods,) that of the damping of every rod's section, ``numerical`` that of the scheme; −1 where there is none.
    """

    names: tuple[str, ...]
    lossy: frozenset[str]
    working: frozenset[str]
    element: Ints
    material: Ints
    numerical: int


def sources_of(model: Model, groups: Sequence[Group], scheme: Scheme) -> Sources:
    """The sources of a model under a scheme: elements by their names, then sections, then the scheme.

    Elements of one name are one source. A rod's element has two, its actuation and what acts on it from outside: the
    fluid around it, and its weight where its mass is off the axis.
    """
    index: dict[str, int] = {}
    lossy: set[str] = set()
    working: set[str] = set()

    def at(name: str, takes: bool, works: bool) -> int:
        lossy.update([name] if takes else ())
        working.update([name] if works else ())
        return index.setdefault(name, len(index))

    if not scheme.static:  # their elements come and go, their names are there from the start
        for touch in model.rod_contacts:
            if touch.friction:
                at(touch.where, True, False)
    element: list[tuple[int, int]] = []
    for group in groups:
        for name in group.names:
            own = at(name, group.lossy, group.works) if group.lossy or group.works else -1
            element.append((own, -1))
        layout = group.layout
        for rod in group.owners:
            outside = " and ".join(["fluid around"] * layout.dragged + ["weight of"] * layout.eccentric)
            fluid = at(f"{outside} rod {rod!r}", group.lossy, True) if outside else -1
            strain = at(f"actuation of rod {rod!r}", False, True) if layout.actuated else -1
            element.append((fluid, strain))
    damped = not scheme.static and scheme.rates is not Rates.ALPHA
    material = [
        at(f"damping of rod {rod.name!r}", True, False) if damped and rod.section.damping.any() else -1
        for rod in model.rods
    ]
    numerical = at(NUMERICAL, True, False) if damped and any(scheme.common[2:4]) else -1
    return Sources(
        tuple(index), frozenset(lossy), frozenset(working), np.array(element, np.int64).reshape(-1, 2),
        np.array(material, np.int64), numerical,
    )  # fmt: skip
