"""What is attached to nodes beside rods: springs, dashpots and cables between two points, masses and rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.checks import Vec, number, text, vector
from directrix.errors import ModelError

Array = NDArray[np.float64]

__all__ = ["Body", "Link"]


@dataclass(frozen=True)
class Link:
    """A straight link between a point of node ``a`` and a point of node ``b``, or of the ground when ``b`` is a place.

    The points are offset from their nodes by vectors given in the reference, and turn with them. With the length ℓ and
    e = ℓ − ``length``: tension k e, for a ``cable`` k p p' with the smooth ramp p = ½(e + √(e² + width²)), and
    ``damping`` · dℓ/dt in dynamics. ``length`` None is the distance in the reference, ``width`` None a thousandth of
    ``length``.
    """

    name: str
    a: str
    b: str | Vec
    stiffness: float
    length: float | None = None
    damping: float = 0.0
    offset_a: Vec = (0.0, 0.0, 0.0)
    offset_b: Vec = (0.0, 0.0, 0.0)
    cable: bool = False
    width: float | None = None

    def __post_init__(self) -> None:
        where = f"link {text(self.name, 'name of a link')!r}"
        text(self.a, f"{where}: first node")
        number(self.stiffness, f"{where}: stiffness", least=0.0)
        number(self.damping, f"{where}: damping", least=0.0)
        if self.length is not None:
            number(self.length, f"{where}: length", least=0.0)
        if self.width is not None:
            number(self.width, f"{where}: width", above=0.0)
        if self.stiffness == 0.0 and self.damping == 0.0:
            raise ModelError(f"{where} has neither stiffness nor damping", "give one of them")
        b = text(self.b, f"{where}: second node") if isinstance(self.b, str) else vector(self.b, f"{where}: place")
        if b == self.a:
            raise ModelError(f"{where} joins node {self.a!r} to itself", "name another node, or a place on the ground")
        for name, value in (
            ("b", b),
            ("offset_a", vector(self.offset_a, f"{where}: offset of its first point")),
            ("offset_b", vector(self.offset_b, f"{where}: offset of its second point")),
        ):
            object.__setattr__(self, name, value)

    def ends(self, places: Any) -> tuple[Array, Array]:
        """Where its points are in the reference; ``places`` maps nodes to positions."""
        first = np.add(places[self.a], self.offset_a)
        return first, np.add(places[self.b], self.offset_b) if isinstance(self.b, str) else np.array(self.b)

    def measures(self, places: Any) -> tuple[float, float]:
        """Length without tension, and width of the ramp (0 for a spring)."""
        first, second = self.ends(places)
        rest = float(np.linalg.norm(second - first)) if self.length is None else self.length
        if not self.cable:
            return rest, 0.0
        width = 1e-3 * rest if self.width is None else self.width
        if width == 0.0:
            raise ModelError(f"link {self.name!r}: a cable of no length needs a width", "give width=")
        return rest, width

    def tension(self, length: Array, rest: float, width: float) -> Array:
        """Elastic tension at lengths ``length``."""
        e = length - rest
        if not self.cable:
            return self.stiffness * e
        root = np.sqrt(e * e + width**2)
        return self.stiffness * 0.25 * (e + root) * (1.0 + e / root)


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body on a node, its centre of mass there: ``mass``, ``inertia`` (3, 3) in the reference frame."""

    node: str
    mass: float
    inertia: Array

    def __post_init__(self) -> None:
        where = f"body on node {text(self.node, 'node of a body')!r}"
        number(self.mass, f"{where}: mass", above=0.0)
        try:
            inertia = np.array(self.inertia, float)
        except (TypeError, ValueError):
            inertia = np.empty(0)
        if inertia.shape != (3, 3) or not np.all(np.isfinite(inertia)):
            raise ModelError(f"{where}: inertia is not a 3×3 matrix of finite numbers", "give three rows of three")
        size = np.abs(inertia).max()
        if np.abs(inertia - inertia.T).max() > 1e-9 * max(size, 1e-300):
            raise ModelError(f"{where}: inertia is not symmetric", "give ½(J + Jᵀ) if that is what is meant")
        inertia = 0.5 * (inertia + inertia.T)
        object.__setattr__(self, "inertia", inertia)
        inertia.setflags(write=False)
        if np.linalg.eigvalsh(self.euler)[0] < -1e-9 * size:
            raise ModelError(
                f"{where}: no body has this inertia, one moment exceeds the sum of the others",
                "check the units and the signs of its products",
            )

    @property
    def euler(self) -> Array:
        """∫ρ ξξᵀ dV = ½ tr(J) 1 − J, (3, 3)."""
        return 0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia
