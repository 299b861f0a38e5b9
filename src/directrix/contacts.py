"""What rods may touch: surfaces that are fixed, and one another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from directrix.checks import Vec, flag, number, shown, text, vector, whole
from directrix.errors import ModelError
from directrix.section import Section

Array = NDArray[np.float64]

__all__ = [
    "Contact",
    "Cylinder",
    "Obstacle",
    "Plane",
    "RodContact",
    "Sphere",
    "Touch",
    "force_per_length",
    "named_rods",
    "round_radius",
]


def _unit(value: Any, what: str) -> Vec:
    v = np.array(vector(value, what))
    size = float(np.linalg.norm(v))
    if size == 0.0:
        raise ModelError(f"{what} has no length", "give a direction")
    x, y, z = (v / size).tolist()
    return x, y, z


@dataclass(frozen=True)
class Plane:
    """A plane through ``point``; ``normal`` points to where the rods are."""

    point: Vec
    normal: Vec

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", vector(self.point, "point of a plane"))
        object.__setattr__(self, "normal", _unit(self.normal, "normal of a plane"))

    def row(self) -> tuple[float, ...]:
        """Point, axis, radius and side as the element takes them."""
        return *self.point, *self.normal, 0.0, 1.0


@dataclass(frozen=True)
class Sphere:
    """A sphere; ``inside`` for rods within it."""

    center: Vec
    radius: float
    inside: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector(self.center, "center of a sphere"))
        number(self.radius, "radius of a sphere", least=0.0)
        flag(self.inside, "inside")

    def row(self) -> tuple[float, ...]:
        """See :meth:`Plane.row`."""
        return *self.center, 0.0, 0.0, 0.0, self.radius, -1.0 if self.inside else 1.0


@dataclass(frozen=True)
class Cylinder:
    """A cylinder without ends around the line through ``point`` along ``axis``; ``inside`` for rods in a pipe."""

    point: Vec
    axis: Vec
    radius: float
    inside: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", vector(self.point, "point of a cylinder"))
        object.__setattr__(self, "axis", _unit(self.axis, "axis of a cylinder"))
        number(self.radius, "radius of a cylinder", least=0.0)
        flag(self.inside, "inside")

    def row(self) -> tuple[float, ...]:
        """See :meth:`Plane.row`."""
        return *self.point, *self.axis, self.radius, -1.0 if self.inside else 1.0


Obstacle = Plane | Sphere | Cylinder


@dataclass(frozen=True)
class Touch:
    """What all contacts have: ``stiffness`` per penetration and per length of rod, so [force/length²].

    The force per length is ½ k p²(2p + 3w)/(p + w)² at the penetration p ≥ 0, w = ``width``: nothing outside, and
    k (p − ½w) or so from p = 2w on. ``width`` None is a tenth of the radius, ``radius`` None that of the section.
    ``friction`` is Coulomb's coefficient, full from a few ``slip_speed`` on: −μ N v/√(v² + slip_speed²).
    """

    name: str
    stiffness: float
    rods: tuple[str, ...] | None
    friction: float
    slip_speed: float | None
    radius: float | None
    width: float | None

    def __post_init__(self) -> None:
        where = self.where
        text(self.name, "name of a contact")
        number(self.stiffness, f"{where}: stiffness", above=0.0)
        number(self.friction, f"{where}: friction", least=0.0)
        if self.radius is not None:
            number(self.radius, f"{where}: radius", least=0.0)
        if self.width is not None:
            number(self.width, f"{where}: width", above=0.0)
        if self.slip_speed is not None:
            number(self.slip_speed, f"{where}: slip_speed", above=0.0)
        elif self.friction:
            raise ModelError(
                f"{where} has friction and no speed at which it is fully there",
                "give slip_speed=, well below the speeds of interest",
            )

    @property
    def where(self) -> str:
        """ "contact 'floor'"."""
        return f"contact {self.name!r}"

    @property
    def rubbing(self) -> tuple[float, float]:
        """μ and v0 as the elements take them."""
        return self.friction, 1.0 if self.slip_speed is None else self.slip_speed

    def radius_of(self, rod: str, section: Section) -> float:
        """Radius of a rod; raises ModelError where it is neither given nor that of a round section."""
        if self.radius is not None:
            return self.radius
        found = round_radius(section)
        if found is None:
            raise ModelError(f"{self.where}: the section of rod {rod!r} is not known to be round", "give radius=")
        return found

    def width_of(self, radius: float) -> float:
        """Width of the rise of the force; raises ModelError for a rod of no radius without one."""
        if self.width is not None:
            return self.width
        if radius == 0.0:
            raise ModelError(f"{self.where}: a rod of no radius has no width by itself", "give width=")
        return 0.1 * radius


@dataclass(frozen=True)
class Contact(Touch):
    """Rods (None: all) against a surface, at their nodes, each with the length that it stands for."""

    obstacle: Obstacle

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.obstacle, (Plane, Sphere, Cylinder)):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError(
                f"{self.where}: {shown(self.obstacle)} is no surface", "use dx.Plane, dx.Sphere or dx.Cylinder"
            )

    def gap(self, r: Array, radius: float) -> Array:
        """Distance (…) of rods of ``radius`` at ``r`` (…, 3) from the surface, negative where they penetrate."""
        row = np.array(self.obstacle.row())
        y, axis = r - row[:3], row[3:6]
        if isinstance(self.obstacle, Plane):
            return y @ axis - radius
        out = y - (y @ axis)[..., None] * axis
        return row[7] * (np.linalg.norm(out, axis=-1) - row[6]) - radius


@dataclass(frozen=True)
class RodContact(Touch):
    """Rods (None: all) against one another, and each against itself unless ``others`` are the second party.

    ``points`` of every piece between two nodes are held against the pieces that come near.
    """

    others: tuple[str, ...] | None
    points: int

    def __post_init__(self) -> None:
        super().__post_init__()
        whole(self.points, f"{self.where}: points", 1, 6)
        both = set(self.rods or ()) & set(self.others or ())
        if both:
            raise ModelError(f"{self.where}: rod {min(both)!r} is on both sides", "use self_contact for it")


def force_per_length(stiffness: float, penetration: Array, width: Array | float) -> Array:
    """½ k p²(2p + 3w)/(p + w)², p = max(penetration, 0)."""
    p = np.maximum(penetration, 0.0)
    return 0.5 * stiffness * p * p * (2.0 * p + 3.0 * width) / (p + width) ** 2


def round_radius(section: Section) -> float | None:
    """Radius of a circle or tube, None for any other section."""
    size = np.linalg.norm(section.outline, axis=1)
    outer = size >= (1.0 - 1e-9) * size.max(initial=0.0)
    ring, hole = size[: outer.sum()], size[outer.sum() :]
    whole = len(ring) > 8 and bool(outer[: len(ring)].all()) and (len(hole) in (0, len(ring)))
    return float(ring[0]) if whole and np.ptp(hole if hole.size else ring) <= 1e-9 * ring[0] else None


def named_rods(value: Any, what: str) -> tuple[str, ...] | None:
    """One name, several, or None for all; raises ModelError that names ``what``."""
    if value is None:
        return None
    given = (value,) if isinstance(value, str) else value
    if not isinstance(given, Sequence) or not given:
        raise ModelError(f"{what} = {shown(value)} are not names of rods", "give a name or a list of names")
    return tuple(text(name, what) for name in cast("Sequence[Any]", given))
