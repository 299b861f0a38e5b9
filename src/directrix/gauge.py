"""What a step of a path is measured by: the path's own length, or the displacement that drives it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from directrix.bordered import Bordered, Row, dot, normal_to
from directrix.controls import SMALLEST, ArcLength, Control, DisplacementControl
from directrix.discretisation import Discretisation
from directrix.errors import ModelError
from directrix.result import Status

Array = NDArray[np.float64]

__all__ = ["Gauge", "driven", "gauge_for"]

NEARLY_BACK = 0.2  # of the fastest a displacement moved along the path
NEARLY_STILL = 0.02  # of what moves fastest there


class Along:
    """Steps measured along the path."""

    def __init__(self, control: ArcLength, bordered: Bordered) -> None:
        self.control, self.length = control, bordered.length
        self.first, self.smallest, self.left = control.ds, control.smallest, np.inf
        self.most, self.aim = control.max_steps, ""

    def share(self, steps: int) -> float:
        """How much of the run is done."""
        return steps / self.most

    def load_step(self, reach: float, slope: float) -> float:
        """The change of the load factor to try next, 0 where the step along the path is the smaller one."""
        most = self.control.load_step
        return most if most is not None and abs(slope) * reach > most else 0.0

    def rate(self, tangent: Array) -> float:
        """How fast the measure grows along the unit tangent."""
        return 1.0

    def row(self, tangent: Array, reach: float) -> Row:
        """What holds the end of a step of this reach."""
        return normal_to(tangent, reach, self.length)

    def orient(self, tangent: Array, onward: Array | None) -> float:
        """±1: the sense of the first step along a tangent on which the load factor rises.

        ``onward`` is the last increment of the run that is gone on from.
        """
        ahead = 1.0 if onward is None else float(np.copysign(1.0, dot(onward, tangent, self.length)))
        return ahead if self.control.direction == "forward" else -ahead

    def goal(self, reach: float) -> tuple[float, bool]:
        """The step to try, and whether its end is one to keep."""
        return reach, True

    def after(self, reach: float, iterations: int) -> float:
        """The step to try after one that took so many iterations."""
        growth = np.sqrt(self.control.iterations / iterations)
        return float(np.clip(reach * np.clip(growth, 0.5, 2.0), self.smallest, self.control.largest))

    def walk(self, reach: float, tangent: Array) -> None:
        """Take note of a step and of the tangent at its end."""

    def remember(self) -> dict[str, float]:
        """What was noted."""
        return {}

    def blame(self, tangent: Array) -> Status | None:
        """Why no step can be taken, when the control is to blame."""
        return None


class Towards:
    """Steps measured by one displacement, in the sense of its goal."""

    def __init__(self, control: DisplacementControl, bordered: Bordered, x: Array) -> None:
        disc = bordered.disc
        self.control, self.place = control, driven(control, disc)
        here = float(x[self.place] - disc.mesh.r0[self.place])
        self.start = here if abs(here) > 1e-12 * disc.length else 0.0
        self.whole, self.sense = abs(control.to - here), float(np.sign(control.to - here))
        if self.whole <= 1e-12 * disc.length:
            raise ModelError(
                f"the {control.component} displacement of node {control.node!r} is {control.to:g} already",
                "give another value with to=",
            )
        self.done, self.fastest = 0.0, 0.0
        self.first = self.part = self.whole / control.steps
        self.smallest, self.most = SMALLEST * self.first, np.inf
        self.aim = f"the {control.component} displacement {control.to:g} of node {control.node!r}"

    def share(self, steps: int) -> float:
        return self.done / self.whole

    @property
    def left(self) -> float:
        return self.whole - self.done if self.done < self.whole * (1.0 - 1e-12) else 0.0

    def load_step(self, reach: float, slope: float) -> float:
        return 0.0

    def rate(self, tangent: Array) -> float:
        return self.sense * float(tangent[self.place])

    def row(self, tangent: Array, reach: float) -> Row:
        c = np.zeros_like(tangent)
        c[self.place] = self.sense
        node, column = self.place
        return lambda x: (c, self.sense * float(x[node, 12 + column]) - reach)

    def orient(self, tangent: Array, onward: Array | None) -> float:
        rate = self.rate(tangent)
        if abs(rate) < 1e-9:
            raise ModelError(
                f"the {self.control.component} displacement of node {self.control.node!r} does not move along the path",
                "drive another displacement, or use dx.ArcLength",
            )
        return float(np.sign(rate))

    def goal(self, reach: float) -> tuple[float, bool]:
        to = min(np.floor(self.done / self.part + 1e-9) + 1.0, self.control.steps) * self.part - self.done
        return (float(to), True) if reach >= to * (1.0 - 1e-9) else (reach, False)

    def after(self, reach: float, iterations: int) -> float:
        return min(2.0 * reach, self.part)

    def remember(self) -> dict[str, float]:
        """What was noted."""
        return {"done": self.done, "fastest": self.fastest}

    def walk(self, reach: float, tangent: Array) -> None:
        """Take note of a step and of the tangent at its end."""
        self.done += reach
        self.fastest = max(self.fastest, self.rate(tangent))

    def blame(self, tangent: Array) -> Status | None:
        """The displacement turns back: its part of the tangent vanishes."""
        if self.rate(tangent) > max(NEARLY_BACK * self.fastest, NEARLY_STILL * float(np.abs(tangent[:, :3]).max())):
            return None
        of, here = self.control, self.start + self.sense * self.done
        return Status(
            "not_converged",
            f"the {of.component} displacement of node {of.node!r} turns back or stands still near {here:.6g}: "
            "it does not go on along the path.",
            "Follow the path with dx.ArcLength, or drive another displacement.",
        )


Gauge = Along | Towards


def driven(control: DisplacementControl, disc: Discretisation) -> tuple[int, int]:
    """Node and column of the displacement that is driven. Raises ModelError when it is held or there is none."""
    place = disc.mesh.node(control.node), control.column
    if disc.fixed[place]:
        raise ModelError(
            f"the {control.component} displacement of node {control.node!r} is held by a support or prescribed",
            "drive one that is free",
        )
    return place


def gauge_for(control: Control, bordered: Bordered, x: Array) -> Gauge:
    """The gauge of a control at the state ``x`` it starts from. Raises ModelError for one that cannot be."""
    return Along(control, bordered) if isinstance(control, ArcLength) else Towards(control, bordered, x)
