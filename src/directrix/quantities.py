"""One vocabulary for what a result holds: names, components and dimensions, for tables, pictures and recorders."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.checks import choice, nearest, shown
from directrix.errors import ModelError
from directrix.points import place
from directrix.result import Result

Array = NDArray[np.float64]
Of = str | int | tuple[str, float] | None

__all__ = ["FORCES", "QUANTITIES", "STRAINS", "Of", "Quantity", "Series", "rotation_vectors", "series", "unit"]

XYZ = ("x", "y", "z")
STRAINS = ("Gamma1", "Gamma2", "Gamma3", "Omega1", "Omega2", "Omega3")
FORCES = ("V1", "V2", "N", "M1", "M2", "T")
"""Section forces in the order of components everywhere: shear 1, 2, axial, bending 1, 2, torsion."""


@dataclass(frozen=True)
class Quantity:
    """A thing that has a history.

    ``owner`` is what has it: "node", "rod", "run", "link", "contact" or "joint". ``components`` are empty for a scalar.
    ``dimensions`` has one text a component, or one for all: a product of length, time and force, or "rad".
    """

    name: str
    owner: str
    words: str
    dimensions: tuple[str, ...]
    components: tuple[str, ...] = ()

    def dimension(self, component: int) -> str:
        """Of one component."""
        return self.dimensions[component % len(self.dimensions)]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its columns in a table: those of section components stand for themselves."""
        if self.owner == "rod":
            return self.components
        return tuple(f"{self.name}_{c}" for c in self.components) or (self.name,)


MOMENT = "force·length"
BY_FORCE = ("force",) * 3 + (MOMENT,) * 3
_ALL = (
    Quantity("r", "node", "position", ("length",), XYZ),
    Quantity("displacement", "node", "displacement", ("length",), XYZ),
    Quantity("rotation", "node", "rotation vector", ("rad",), XYZ),
    Quantity("v", "node", "velocity", ("length/time",), XYZ),
    Quantity("reaction", "node", "reaction", BY_FORCE, ("Fx", "Fy", "Fz", "Mx", "My", "Mz")),
    Quantity("strain", "rod", "strain", ("",) * 3 + ("1/length",) * 3, STRAINS),
    Quantity("force", "rod", "section force", BY_FORCE, FORCES),
    *(
        Quantity(name, "run", words, (MOMENT,))
        for name, words in (
            ("kinetic", "kinetic energy"), ("stored", "stored energy"), ("total", "total energy"),
            ("work", "work done on it"), ("prescribed", "work of prescribed motion"),
            ("dissipated", "dissipated energy"), ("residual", "residual of the ledger"),
        )
    ),
    Quantity("L", "run", "linear momentum", ("force·time",), XYZ),
    Quantity("J", "run", "angular momentum", ("force·length·time",), XYZ),
    Quantity("load_factor", "run", "load factor", ("",)),
    Quantity("arc_length", "run", "arc length of the path", ("length",)),
    Quantity("length", "link", "length", ("length",)),
    Quantity("tension", "link", "tension", ("force",)),
    Quantity("gap", "contact", "gap", ("length",)),
    Quantity("normal_force", "contact", "normal force", ("force",)),
    Quantity("joint_force", "joint", "force of the joint", ("force",), XYZ),
    Quantity("joint_moment", "joint", "moment of the joint", (MOMENT,), XYZ),
    Quantity("coordinate", "joint", "coordinate of the joint", ("",)),
)  # fmt: skip
QUANTITIES: Mapping[str, Quantity] = {q.name: q for q in _ALL}


@dataclass(frozen=True)
class Series:
    """The history of a quantity: ``values`` (nt, components) of ``of``, named ``names``, each with its dimension."""

    quantity: Quantity
    values: Array
    names: tuple[str, ...]
    dimensions: tuple[str, ...]
    of: str

    def only(self, component: str | None) -> Series:
        """One component of it; raises ModelError when there is none of that name."""
        if component is None:
            return self
        if not self.quantity.components:
            raise ModelError(f"{self.quantity.name} has no components", "leave component= out")
        k = self.names.index(choice(component, f"component of {self.quantity.name}", self.names))
        return Series(self.quantity, self.values[:, k : k + 1], (component,), (self.dimensions[k],), self.of)


def series(result: Result, quantity: str, of: Of = None) -> Series:
    """The history of a quantity, or of one component of a section force or strain (such as "N" or "M1").

    ``of`` is a node by name or index, a point of a rod as (rod, arclength), the name of a link, contact or joint, and
    nothing for what the whole run has. Raises ModelError for what there is not.
    """
    known = (*QUANTITIES, *STRAINS, *FORCES)
    if not isinstance(quantity, str) or quantity not in known:  # pyright: ignore[reportUnnecessaryIsInstance]
        hint = nearest(quantity if isinstance(quantity, str) else "", known)  # pyright: ignore
        raise ModelError(f"there is no history of {shown(quantity)}", f"{hint}use one of {', '.join(known)}")
    for name, components in (("strain", STRAINS), ("force", FORCES)):
        if quantity in components:
            return series(result, name, of).only(quantity)
    kind = QUANTITIES[quantity]
    values, label = _READ[kind.owner](result, quantity, of)
    width = len(kind.components) or 1
    names = kind.components or (kind.name,)
    return Series(kind, values.reshape(-1, width), names, tuple(kind.dimension(k) for k in range(width)), label)


def rotation_vectors(R: Array) -> Array:
    """Rotation vectors (…, 3) of rotations (…, 3, 3), no longer than π."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec().reshape(R.shape[:-1]) if R.size else R[..., 0]


def _node(result: Result, quantity: str, of: Of) -> tuple[Array, str]:
    if isinstance(of, tuple):
        return _point(result, quantity, of)
    if of is None:
        names = ", ".join(result.mesh.node_names)
        raise ModelError(f"{quantity} is that of a node", f"name one of {names}, or a point as (rod, arclength)")
    history = result.node(of)
    values = rotation_vectors(history.R) if quantity == "rotation" else getattr(history, quantity)
    return values, result.mesh.label(result.mesh.node(of))


def _point(result: Result, quantity: str, of: Of) -> tuple[Array, str]:
    if not isinstance(of, tuple) or len(of) != 2:  # pyright: ignore[reportUnnecessaryComparison]
        raise ModelError(
            f"{quantity} of {shown(of)}: this is no point of a rod", "give (rod, arclength), such as ('arm', 0.5)"
        )
    point = place(result.mesh, *of)
    label = f"{point.rod.name} at s = {point.s:.4g}"
    match quantity:
        case "strain" | "force":
            return point.of_stations(getattr(result, quantity)), label
        case "r" | "v":
            return point.of_nodes(getattr(result, quantity)), label
        case "displacement":
            return point.of_nodes(result.r - result.mesh.r0), label
        case _:
            raise ModelError(f"{quantity} is that of a node, not of a point of a rod", "name a node")


def _run(result: Result, quantity: str, of: Of) -> tuple[Array, str]:
    if of is not None:
        raise ModelError(f"{quantity} is that of the whole run, not of {shown(of)}", "leave it out")
    if quantity in ("L", "J"):
        return result.momentum.linear if quantity == "L" else result.momentum.angular, ""
    if quantity in ("load_factor", "arc_length"):
        return getattr(result, quantity), ""
    return getattr(result.energy, quantity), ""


def _named(result: Result, quantity: str, of: Of) -> tuple[Array, str]:
    owner = QUANTITIES[quantity].owner
    if not isinstance(of, str):
        raise ModelError(f"{quantity} is that of a {owner}", f"name the {owner}")
    history: Any = getattr(result, owner)(of)
    field = {"normal_force": "force", "joint_force": "force", "joint_moment": "moment"}.get(quantity, quantity)
    return getattr(history, field), of


_READ: Mapping[str, Any] = {
    "node": _node, "rod": _point, "run": _run, "link": _named, "contact": _named, "joint": _named,
}  # fmt: skip


def unit(result: Result, dimension: str) -> str:
    """A dimension in the units that ``result.info["units"]`` names for length, time and force; else as it is.

    Units are the user's: without names for them "force·length" stays what it is.
    """
    named = result.info.get("units")
    if not isinstance(named, Mapping):
        return dimension

    def name(word: re.Match[str]) -> str:
        return str(named.get(word[0], word[0]))  # pyright: ignore[reportUnknownMemberType, reportUnknownArgumentType]

    return re.sub("length|time|force", name, dimension)


def labelled(result: Result, words: str, dimension: str) -> str:
    """Words with the unit behind them in brackets."""
    said = unit(result, dimension)
    return f"{words} [{said}]" if said else words
