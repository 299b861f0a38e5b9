"""What drives a rod from inside or resists it from outside: intrinsic strain, tendons, drag. Frozen values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import Vec, flag, number, shown, text, vector
from directrix.errors import ModelError

Array = NDArray[np.float64]
Numbers = float | tuple[float, ...] | Callable[..., ArrayLike]
Offset = tuple[float, float] | tuple[tuple[float, float], tuple[float, float]] | Callable[[float], ArrayLike]

__all__ = ["Actuation", "Drag", "Numbers", "Tendon", "numbers", "value_at"]

# key of an actuation: which of the six strains it is
PARTS = {"strain": (0, 1, 2, 3, 4, 5), "curvature": (3, 4), "twist": (5,), "elongation": (2,)}


def numbers(value: Any, count: int, what: str) -> Any:
    """``count`` finite numbers (a tuple; one is a float), or a function; raises ModelError that names ``what``."""
    if callable(value):
        return value
    if count == 1:
        return number(value, what)
    try:
        given = np.asarray(value, float)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != (count,) or not np.all(np.isfinite(given)):
        raise ModelError(f"{what} = {shown(value)} is not {count} finite numbers", f"give {count}, or a function")
    return tuple(given.tolist())


def value_at(function: Callable[..., Any], count: int, what: str, *at: float) -> Array:
    """What a user's function gives at ``at`` (t, …), ``count`` finite numbers; raises ModelError naming ``what``."""
    place = f"{what} at t = {at[0]:.6g}"
    try:
        out = function(*at)
    except Exception as error:  # whatever a user's function raises
        raise ModelError(f"{place} fails: {error!r}", f"return {count} finite numbers for every t") from error
    try:
        given = np.asarray(out, float).reshape(-1)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != (count,) or not np.all(np.isfinite(given)):
        raise ModelError(f"{place} = {shown(out)} is not {count} finite numbers", "return them for every t")
    return given


@dataclass(frozen=True)
class Actuation:
    """Strain ε̂ at which a rod is without stress: the stored energy is that of ε − ε̂.

    ``strain`` (shear 1, shear 2, axial, bending 1, bending 2, torsion), ``curvature`` (bending 1, bending 2), ``twist``
    and ``elongation`` add up; each is a value or a function of t. With ``along`` functions are called with (t, s), s
    the arclength from the start of the rod. In statics values are multiplied by the load factor, functions get it.
    """

    rod: str
    curvature: Numbers | None = None
    twist: Numbers | None = None
    elongation: Numbers | None = None
    strain: Numbers | None = None
    along: bool = False

    def __post_init__(self) -> None:
        text(self.rod, "name of a rod")
        flag(self.along, "along")
        for key, at in PARTS.items():
            if getattr(self, key) is not None:
                given = numbers(getattr(self, key), len(at), f"{key} that actuates rod {self.rod!r}")
                object.__setattr__(self, key, given)
        if all(getattr(self, key) is None for key in PARTS):
            raise ModelError(f"nothing actuates rod {self.rod!r}", f"give one of {', '.join(PARTS)}")

    @property
    def varies(self) -> bool:
        """True when a part is a function."""
        return any(callable(getattr(self, key)) for key in PARTS)

    def at(self, t: float, factor: float, s: Array) -> Array:
        """ε̂ (…, 6) at arclengths ``s`` (…); ``factor`` multiplies values."""
        out = np.zeros((*s.shape, 6))
        for key, columns in PARTS.items():
            given = getattr(self, key)
            if given is None:
                continue
            what = f"the {key} that actuates rod {self.rod!r}"
            if not callable(given):
                out[..., columns] += factor * np.asarray(given)
            elif self.along:
                flat = [value_at(given, len(columns), what, t, float(place)) for place in s.ravel()]
                out[..., columns] += np.array(flat).reshape(*s.shape, len(columns))
            else:
                out[..., columns] += value_at(given, len(columns), what, t)
        return out


@dataclass(frozen=True)
class Drag:
    """Resistance of a fluid, per reference length: −c_n |v_n| v_n − c_t |v_t| v_t.

    v is the velocity of the axis relative to the fluid, v_t its part along the axis, v_n the rest; ``normal`` c_n =
    ½ ρ C_n d, ``tangential`` c_t = ½ ρ C_t π d. ``flow`` is the velocity of the fluid, a vector or a function of t;
    in statics it is multiplied by the load factor unless ``constant``.
    """

    rod: str
    normal: float
    tangential: float = 0.0
    flow: Vec | Callable[[float], ArrayLike] = (0.0, 0.0, 0.0)
    constant: bool = False

    def __post_init__(self) -> None:
        where = f"drag on rod {text(self.rod, 'name of a rod')!r}"
        number(self.normal, f"{where}: normal", least=0.0)
        number(self.tangential, f"{where}: tangential", least=0.0)
        if self.normal == 0.0 and self.tangential == 0.0:
            raise ModelError(f"{where} has no coefficient", "give normal= or tangential=")
        if not callable(self.flow):
            object.__setattr__(self, "flow", vector(self.flow, f"{where}: flow"))
        flag(self.constant, "constant")

    def at(self, t: float, factor: float) -> Array:
        """Velocity of the fluid (3,)."""
        given = self.flow
        what = f"the flow around rod {self.rod!r}"
        flow = value_at(given, 3, what, t) if callable(given) else np.array(given)
        return flow * (1.0 if self.constant else factor)


@dataclass(frozen=True)
class Tendon:
    """A tendon without friction, of given ``tension``: straight between points that are fixed to sections.

    ``along`` is a rod, the points then being at the ends of its elements, ``offset`` (ξ1, ξ2) from the axis along d1
    and d2: one pair, a pair at each end of the rod and linear between, or a function of the fraction of arclength. Or
    ``along`` are nodes, with ``offset`` one vector each in the reference. ``tension`` is a number or a function of t;
    in statics it is multiplied by the load factor unless ``constant``.
    """

    name: str
    along: str | tuple[str, ...]
    tension: float | Callable[[float], ArrayLike]
    offset: Any = (0.0, 0.0)
    constant: bool = False

    def __post_init__(self) -> None:
        where = f"tendon {text(self.name, 'name of a tendon')!r}"
        if not callable(self.tension):
            number(self.tension, f"{where}: tension", least=0.0)
        flag(self.constant, "constant")
        if isinstance(self.along, str):
            text(self.along, f"{where}: rod")
            if not callable(self.offset):
                object.__setattr__(self, "offset", _pairs(self.offset, where))
                self.across(0.0)
            return
        nodes = tuple(text(n, f"{where}: node") for n in cast("Sequence[Any]", self.along))
        if len(nodes) < 2 or any(a == b for a, b in pairwise(nodes)):
            raise ModelError(f"{where} does not go from node to node", "name two nodes or more, neighbours different")
        given: Any = self.offset
        if given == (0.0, 0.0):
            given = [(0.0, 0.0, 0.0)] * len(nodes)
        if callable(given) or len(given) != len(nodes):
            raise ModelError(f"{where}: there is not one offset for each of its {len(nodes)} nodes", "give one each")
        object.__setattr__(self, "along", nodes)
        object.__setattr__(self, "offset", tuple(vector(o, f"{where}: offset") for o in given))

    def across(self, fraction: float) -> Array:
        """(ξ1, ξ2) of a tendon along a rod, at a fraction of its arclength."""
        if callable(self.offset):
            return value_at(self.offset, 2, f"the offset of tendon {self.name!r}", fraction)
        pairs = np.atleast_2d(np.array(self.offset))
        return (1.0 - fraction) * pairs[0] + fraction * pairs[-1]

    def at(self, t: float, factor: float) -> Array:
        """The tension (1,)."""
        what = f"the tension of tendon {self.name!r}"
        pull = value_at(self.tension, 1, what, t) if callable(self.tension) else np.array([self.tension])
        if pull[0] < 0.0:
            raise ModelError(f"{what} at t = {t:.6g} is {pull[0]:g}, and a tendon does not push", "give 0 or more")
        return pull * (1.0 if self.constant else factor)


def _pairs(offset: Any, where: str) -> Any:
    try:
        given = np.asarray(offset, float)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape not in ((2,), (2, 2)) or not np.all(np.isfinite(given)):
        raise ModelError(
            f"{where}: offset = {shown(offset)} is neither two numbers nor two pairs of them",
            "give (ξ1, ξ2), or ((ξ1, ξ2), (ξ1, ξ2)) for the two ends",
        )
    rows: Any = given.tolist()
    return tuple(rows) if given.ndim == 1 else tuple(tuple(row) for row in rows)
