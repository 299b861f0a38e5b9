"""What a path tells of stability, as a result keeps it: values, no solver."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Kind = Literal["limit point (maximum)", "limit point (minimum)", "simple bifurcation", "multiple bifurcation"]

__all__ = ["CriticalPoint", "Kind", "PathStability"]


@dataclass(frozen=True, eq=False)
class CriticalPoint:
    """Where the stiffness is singular along a path.

    Attributes
    ----------
    kind : "limit point (maximum)", "limit point (minimum)", "simple bifurcation" or "multiple bifurcation"
    load_factor : there
    arc_length : from the start of the run
    index : of the saved instant that is this state
    before, after : negative pivots of the stiffness on the two sides
    modes : (multiplicity, n, 6) displacement and spin of the nodes, of unit length in the norm of
        :attr:`Result.arc_length <directrix.Result.arc_length>`; the largest component is positive
    """

    kind: Kind
    load_factor: float
    arc_length: float
    index: int
    before: int
    after: int
    modes: Array

    @property
    def bifurcation(self) -> bool:
        """True when other paths go through it."""
        return "bifurcation" in self.kind

    def __str__(self) -> str:
        many = f" ({len(self.modes)} modes)" if len(self.modes) > 1 else ""
        return (
            f"{self.kind}{many} at load factor {self.load_factor:.9g}, arc length {self.arc_length:.6g}, "
            f"negative pivots {self.before} → {self.after}"
        )


@dataclass(frozen=True, eq=False)
class PathStability:
    """Stability of the saved states of a static run under its loads, held as they are.

    Attributes
    ----------
    negative : (nt,) negative pivots of the symmetric stiffness: how many independent ways there are to leave the state;
        at a critical point those that vanish there are not counted
    critical : (nt,) True at a critical point, whose stability the stiffness does not decide
    points : critical points in the order of the path
    """

    negative: NDArray[np.int64]
    critical: NDArray[np.bool_]
    points: tuple[CriticalPoint, ...] = ()

    @cached_property
    def stable(self) -> NDArray[np.bool_]:
        """(nt,) True where every small disturbance costs energy."""
        return (self.negative == 0) & ~self.critical

    @property
    def bifurcations(self) -> tuple[CriticalPoint, ...]:
        """Critical points that other paths go through."""
        return tuple(p for p in self.points if p.bifurcation)
