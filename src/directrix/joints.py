"""Joints between two nodes, or a node and the ground: what they leave free, and what acts on that freedom."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.checks import Vec, choice, number, shown, text, vector
from directrix.errors import ModelError

Array = NDArray[np.float64]

__all__ = ["KINDS", "Joint", "Kind"]

V, W, U = range(3)
"""Axes of a joint: u is its own, v and w complete a right-handed (v, w, u)."""


class Kind(NamedTuple):
    """What a joint holds. With p, v, w, u the point and axes of its base a and of what moves, b:

    ``point`` p_b − p_a = 0; ``along`` axes k with (p_b − p_a)·k_a = 0; ``across`` pairs (i, j) with i_a·j_b = 0.
    ``free`` is the coordinate that springs, drives and stops act on: the "angle" about u, the "displacement" along u,
    or for a "ball" the whole relative rotation.
    """

    point: bool
    along: tuple[int, ...] = ()
    across: tuple[tuple[int, int], ...] = ()
    free: str = ""

    @property
    def lengths(self) -> int:
        """Constraints with the dimension of a length."""
        return 3 if self.point else len(self.along)

    @property
    def driven(self) -> int:
        """Multiplier of a prescribed coordinate: the next of its dimension, three lengths before three angles."""
        return 3 + len(self.across) if self.free == "angle" else self.lengths


AXIS = ((V, U), (W, U))

KINDS: Mapping[str, Kind] = {
    "rigid": Kind(True, (), (*AXIS, (W, V))),
    "spherical": Kind(True, (), (), "ball"),
    "hinge": Kind(True, (), AXIS, "angle"),
    "universal": Kind(True, (), ((U, U),), "ball"),
    "cylindrical": Kind(False, (V, W), AXIS, "displacement"),
    "slider": Kind(False, (V, W), (*AXIS, (W, V)), "displacement"),
    "planar": Kind(False, (U,), AXIS),
}


@dataclass(frozen=True)
class Joint:
    """A joint of a kind of :data:`KINDS` at the place ``at``, between node ``a`` and node ``b`` (None: the ground).

    The axes are those of ``a``, of the ground when there is no ``b``; the coordinate of a hinge, slider or cylindrical
    joint is that of ``b`` relative to ``a``, of ``a`` relative to the ground. It is zero in the reference. On it act a
    spring, ½ ``stiffness`` (q − ``rest``)², a damper, a ``drive`` (moment or force, a number or function of time), and
    beyond the ``stops`` (lower, upper) springs of ``stop_stiffness``, the change smooth over ``stop_width``; or it is
    ``prescribed`` as a function of time (statics: of the load factor). A spherical or universal joint has a spring
    ½ k (3 − tr R_aᵀR_b) → ½ k φ² and a damper of the relative spin.
    """

    name: str
    kind: str
    a: str
    b: str | None = None
    axis: Vec = (0.0, 0.0, 1.0)
    second: Vec | None = None
    at: Vec | None = None
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    prescribed: Any = None
    drive: Any = None
    stops: tuple[float, float] | None = None
    stop_stiffness: float = 0.0
    stop_width: float = 0.0

    def __post_init__(self) -> None:
        where = f"joint {text(self.name, 'name of a joint')!r}"
        choice(self.kind, "kind of joint", KINDS)
        text(self.a, f"{where}: first node")
        if self.b is not None and text(self.b, f"{where}: second node") == self.a:
            raise ModelError(f"{where} joins node {self.a!r} to itself", "name another node, or none for the ground")
        for key in ("axis", "second", "at"):
            value = getattr(self, key)
            if value is not None or key == "axis":
                object.__setattr__(self, key, vector(value, f"{where}: {key}"))
        for axis in (self.axis, self.second):
            if axis is not None and not 1e-100 < np.abs(axis).max() < 1e100:
                raise ModelError(f"{where}: axis = {axis} has no direction", "give the direction of its axis")
        for key in ("stiffness", "damping", "stop_stiffness", "stop_width"):
            number(getattr(self, key), f"{where}: {key}", least=0.0)
        number(self.rest, f"{where}: rest")
        for key in ("prescribed", "drive"):
            value = getattr(self, key)
            if value is not None and not callable(value):
                object.__setattr__(self, key, number(value, f"{where}: {key}"))
        self._universal(where)
        self._actions(where)

    def _universal(self, where: str) -> None:
        if (self.second is None) == (self.kind == "universal"):
            raise ModelError(f"{where}: a universal joint has two axes, others one", "give axes= to .universal")
        if self.second is not None:
            cosine = abs(np.dot(self.axis, self.second)) / (np.linalg.norm(self.axis) * np.linalg.norm(self.second))
            if cosine > 1e-9:
                raise ModelError(
                    f"{where}: its axes {self.axis} and {self.second} are not perpendicular", "give two that are"
                )

    def _actions(self, where: str) -> None:
        free = KINDS[self.kind].free
        acting = {k: getattr(self, k) for k in ("stiffness", "damping", "prescribed", "drive", "stops")}
        given = [
            k for k, value in acting.items() if value is not None and not (k in ("stiffness", "damping") and not value)
        ]
        for key in [*given, *(["rest"] if self.rest else [])]:
            if not free or (free == "ball" and key not in ("stiffness", "damping")):
                raise ModelError(
                    f"{where}: a {self.kind} joint has no single coordinate that {key} could act on",
                    "use a hinge, a slider or a cylindrical joint, or links",
                )
        if self.prescribed is not None and len(given) > 1:
            other = next(key for key in given if key != "prescribed")
            raise ModelError(f"{where}: its coordinate is prescribed, {other} would do nothing", "keep one of the two")
        if self.rest and not self.stiffness:
            raise ModelError(f"{where}: rest = {self.rest:g} is that of a spring, and it has none", "give stiffness=")
        if self.stops is None:
            for key in ("stop_stiffness", "stop_width"):
                if getattr(self, key):
                    raise ModelError(f"{where}: {key} is that of stops, and it has none", "give stops=(lower, upper)")
            return
        stops: Any = self.stops
        if not isinstance(stops, (tuple, list, np.ndarray)) or len(cast("list[Any]", stops)) != 2:
            raise ModelError(f"{where}: stops = {shown(self.stops)} are not two numbers", "give (lower, upper)")
        low, high = (number(x, f"{where}: {side} stop") for x, side in zip(self.stops, ("lower", "upper"), strict=True))
        if not high > low:
            raise ModelError(f"{where}: stops = ({low:g}, {high:g}) leave no room", "give (lower, upper)")
        object.__setattr__(self, "stops", (low, high))
        number(self.stop_stiffness, f"{where}: stop_stiffness", above=0.0)

    @property
    def active(self) -> bool:
        """True when a spring, damper, drive or stop acts on it."""
        return bool(self.stiffness or self.damping or self.drive is not None or self.stops is not None)

    @property
    def nodes(self) -> tuple[str, ...]:
        """One or two nodes."""
        return (self.a,) if self.b is None else (self.a, self.b)

    def place(self, places: Mapping[str, Any]) -> Array:
        """Where it is in the reference: ``at``, else its last node; ``places`` maps nodes to positions."""
        return np.array(self.at if self.at is not None else places[self.nodes[-1]], float)

    def axes(self) -> tuple[Array, Array]:
        """Rows v, w, u (3, 3) on its base and on what moves, in the reference."""
        u = np.array(self.axis) / np.linalg.norm(self.axis)
        least = np.eye(3)[np.argmin(np.round(np.abs(u), 12))]
        v = least - (least @ u) * u if self.second is None else np.array(self.second)
        v = v / np.linalg.norm(v)
        base: Array = np.stack([v, np.cross(u, v), u])
        if self.second is None:
            return base, base
        mover: Array = np.stack([np.cross(base[W], v), base[W], v]).real  # its u is the second axis
        return base, mover

    def parameters(self, places: Mapping[str, Any]) -> list[float]:
        """What its element reads, see :class:`directrix.formulations.joint.JointElement`."""
        at = self.place(places)
        arms = [at - np.array(places[node], float) for node in self.nodes]
        if self.b is None:
            arms.insert(0, at)
        base, mover = self.axes()
        out = [*arms[0], *base.ravel(), *arms[1], *mover.ravel()]
        if self.active:
            low, high = self.stops or (-1.0, 1.0)
            width = self.stop_width or 1e-3 * (high - low)
            out += [self.stiffness, self.rest, self.damping, low, high, self.stop_stiffness, width]
        return [float(c) for c in out]
