"""Parameters of elements that change in time: intrinsic strain, tension of tendons, flow of a fluid.

An element has two values of each, for the start and for the end of a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from directrix.groups import Group
from directrix.kernels.compile import LANES
from directrix.loads import as_function
from directrix.model import Gravity, Model
from directrix.result import RodMesh

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Value = Callable[[float, float], Array]

__all__ = ["Drive", "Driver", "driven", "drives_of"]


@dataclass(frozen=True)
class Drive:
    """Columns of the parameters of some elements of a group, and what is in them.

    ``start`` and ``end`` are the first of ``size`` columns; ``value(t, factor)`` gives (elements, size) or (size,).
    ``state`` says that the value belongs to the state, at t0 and t1, and is no load, that acts over a step.
    """

    group: int
    elements: Ints
    start: int
    end: int
    size: int
    value: Value
    state: bool
    varies: bool


def drives_of(model: Model, groups: Sequence[Group], rods: Sequence[RodMesh]) -> tuple[Drive, ...]:
    """Everything of a model that changes parameters of elements."""
    found: list[Drive] = []
    meshes = {rod.name: rod for rod in rods}
    for k, group in enumerate(groups):
        first = np.cumsum([0, *group.layout.sizes])
        owners = np.array(group.owners)
        for actuation in model.actuations:
            at = np.flatnonzero(owners == actuation.rod) if group.owners else np.zeros(0, np.int64)
            if at.size:
                size, s = 6 * group.layout.points, meshes[actuation.rod].stations.reshape(len(at), -1)

                def hat(t: float, factor: float, a=actuation, s: Array = s) -> Array:  # type: ignore[no-untyped-def]
                    return a.at(t, factor, s).reshape(len(s), -1)

                begin = int(first[8])
                found.append(Drive(k, at, begin, begin + size, size, hat, True, actuation.varies))
        for drag in model.drags:
            at = np.flatnonzero(owners == drag.rod) if group.owners else np.zeros(0, np.int64)
            if at.size:
                begin = int(first[9]) + 2 + group.layout.nn
                found.append(Drive(k, at, begin, begin + 3, 3, drag.at, False, callable(drag.flow)))
        for gravity in (load for load in model.loads if isinstance(load, Gravity)):
            if group.owners and group.layout.eccentric:

                def pull(t: float, factor: float, load: Gravity = gravity) -> Array:
                    share = 1.0 if load.constant else factor
                    return share * as_function(load.value, False, "gravity")(t)

                begin = int(first[10])
                found.append(
                    Drive(k, np.arange(len(owners)), begin, begin + 3, 3, pull, False, callable(gravity.value))
                )
        for tendon in model.tendons:
            names = np.array(group.names)
            at = np.flatnonzero(names == f"tendon {tendon.name!r}") if group.names else np.zeros(0, np.int64)
            if at.size:
                found.append(Drive(k, at, 6, 7, 1, tendon.at, False, callable(tendon.tension)))
    return tuple(found)


def driven(groups: Sequence[Group], drives: Sequence[Drive], t: float, factor: float) -> tuple[Group, ...]:
    """The groups with what drives them as it is at ``t``, at both ends of a step."""
    out = list(groups)
    for drive in drives:
        parameters, value = out[drive.group].parameters.copy(), drive.value(t, factor)
        for first in (drive.start, drive.end):
            parameters[drive.elements, first : first + drive.size] = value
        out[drive.group] = replace(out[drive.group], parameters=parameters)
    return tuple(out)


class Driver:
    """Writes what drives the elements into the flat parameters that the compiled loops read."""

    def __init__(self, drives: Sequence[Drive], sizes: Sequence[tuple[int, int]], par: Array) -> None:
        """``sizes``: of every group, where its parameters begin in ``par`` and how many an element has."""
        self.drives, self.par = tuple(drives), par
        self.varies = any(drive.varies for drive in drives)
        self.places: list[tuple[Ints, Ints]] = []
        for drive in self.drives:
            begin, size = sizes[drive.group]
            block, lane = np.divmod(drive.elements, LANES)
            element = begin + block * LANES * size + lane
            columns = np.arange(drive.size) * LANES
            start, end = (element[:, None] + first * LANES + columns for first in (drive.start, drive.end))
            self.places.append((start, end))

    def remember(self) -> list[list[Array]]:
        """What is written, for the start and the end of a step."""
        return [[self.par[start].copy(), self.par[end].copy()] for start, end in self.places]

    def recall(self, memory: Sequence[Sequence[Array]]) -> None:
        """Write what :meth:`remember` gave."""
        for here, values in zip(self.places, memory, strict=True):
            for to, value in zip(here, values, strict=True):
                self.par[to] = value

    def follow(self, other: Driver) -> None:
        """Take over what ``other`` wrote, for the same drives in other tables."""
        for here, there in zip(self.places, other.places, strict=True):
            for to, of in zip(here, there, strict=True):
                self.par[to] = other.par[of]

    def place(self, t: float, factor: float) -> None:
        """What is at the end of a step."""
        for drive, (_, end) in zip(self.drives, self.places, strict=True):
            self.par[end] = drive.value(t, factor)

    def act(self, before: float, after: float, rule: str) -> None:
        """What is at the end of a step of a motion; a load with its mean over the step by ``rule``, at both ends."""
        for drive, (start, end) in zip(self.drives, self.places, strict=True):
            if drive.state:
                self.par[end] = drive.value(after, 1.0)
                continue
            if rule == "midpoint":
                value = drive.value(0.5 * (before + after), 1.0)
            else:
                value = 0.5 * (drive.value(before, 1.0) + drive.value(after, 1.0))
            self.par[start] = self.par[end] = value

    def shift(self) -> None:
        """The end of a step becomes the start of the next."""
        for start, end in self.places:
            self.par[start] = self.par[end]
