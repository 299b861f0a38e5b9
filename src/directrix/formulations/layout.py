"""What kind of element, and where its parameters are: shared by all formulations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

from directrix.basis import at_gauss, gauss

if TYPE_CHECKING:
    from directrix.laws import Law

__all__ = [
    "HISTORY", "PER_NODE", "Coordinates", "Layout", "Point", "Scalar", "Step", "Vector", "points", "symmetric_times",
]  # fmt: skip

Scalar = Any
Vector = Sequence[Scalar]
Coordinates = Sequence[Sequence[Vector]]
Point = tuple[float, Sequence[float], Sequence[float]]
"""Weight, shape functions and their slopes d/dξ at a Gauss point."""


class Step(NamedTuple):
    """What an element does in a step.

    ``forces``: force (3) and moment (3) on every node. ``moving``, ``turning``: per node the vectors that move with it
    and those that turn with it. ``through``: values that derivatives are better taken through, such as the stresses
    and the forces on directors, in the order in which they are taken; what comes out does not depend on it.
    """

    forces: list[Scalar]
    moving: list[Sequence[Vector]]
    turning: list[Sequence[Vector]]
    through: Sequence[Sequence[Scalar]] = ()


# Per node (r1, R1 e_i), (Δr, R0 e_i), (ṙ0, Ṙ0 e_i). The step Δr = r1 − r0 is kept by itself: far from the origin
# the difference of two positions would lose the digits that momentum is made of.
PER_NODE = 40  # 36 values, then room to a whole number of vectors
HISTORY = 12  # values of a row of history, at the start of a row of PER_NODE

Damping = Literal["none", "principal", "full"]


@dataclass(frozen=True)
class Layout:
    """What kind of element, and where its parameters are.

    ``nn`` nodes; ``points`` Gauss points for the stresses; ``principal`` when stiffness and rotary inertia
    are diagonal; ``damping`` the kind of the viscous matrix; ``law`` a stored energy in place of ½ ε·Cε;
    ``sampled`` when dS/dξ at the inertia points is wanted; ``actuated`` when the strain without stress changes,
    ``dragged`` when a fluid resists. Parameters in order: reference directors (9 nn),
    stiffness (6 or the 21 of the upper triangle by rows), dξ/dS at the stress points, their reference
    strains (6 each), ∫N_a N_b dS (upper triangle by rows), A_ρ, I_ρ1, I_ρ2 (, I_ρ12), viscous matrix
    (0, 6 or 21), dS/dξ at the inertia points (0 or nn), strains without stress at the stress points at the start and
    at the end of a step (0 or 12 each), drag (0, or c_n, c_t, dS/dξ at the nn inertia points, velocity of the fluid at
    the start and at the end of a step), acceleration of gravity at the start and at the end of a step (0 or 6).

    ``varying``: stiffness and viscous matrix are given at every stress point in turn. ``eccentric``: behind I_ρ12 come
    the first moments of mass S_ρ1, S_ρ2 = ∫ρ ξα dA, and the element carries its own weight, M (g, 0, 0).
    """

    last_adds: ClassVar[bool] = False
    """The last node is none: increments of all six components are added (multipliers)."""

    nn: int
    points: int
    principal: bool
    damping: Damping = "none"
    law: Law | None = None
    sampled: bool = False
    actuated: bool = False
    dragged: bool = False
    varying: bool = False
    eccentric: bool = False

    @property
    def sizes(self) -> tuple[int, ...]:
        """Lengths of the parameter blocks."""
        pairs = self.nn * (self.nn + 1) // 2
        small, each = self.principal, self.points if self.varying else 1
        viscous = {"none": 0, "principal": 6, "full": 21}[self.damping]
        return (
            9 * self.nn, each * (6 if small else 21), self.points, 6 * self.points, pairs,
            6 if self.eccentric else 3 if small else 4, each * viscous,
            self.nn if self.sampled else 0, 12 * self.points if self.actuated else 0,
            8 + self.nn if self.dragged else 0, 6 if self.eccentric else 0,
        )  # fmt: skip

    @property
    def size(self) -> int:
        """Number of parameters."""
        return sum(self.sizes)

    def split(self, p: Sequence[Scalar]) -> list[Sequence[Scalar]]:
        """The parameter blocks of ``p``."""
        parts: list[Sequence[Scalar]] = []
        first = 0
        for n in self.sizes:
            parts.append(p[first : first + n])
            first += n
        return parts

    def at(self, block: Sequence[Scalar], g: int) -> Sequence[Scalar]:
        """The part of a block of matrices that belongs to stress point ``g``."""
        size = len(block) // self.points
        return block[size * g : size * g + size] if self.varying else block

    def stress(self, stiffness: Sequence[Scalar], e: Sequence[Scalar]) -> list[Scalar]:
        """∂W/∂ε at the strains ``e``."""
        return symmetric_times(stiffness, e) if self.law is None else self.law.stress(e)

    def energy(self, stiffness: Sequence[Scalar], e: Sequence[Scalar]) -> Scalar:
        """W(ε), zero at no strain."""
        if self.law is not None:
            return self.law.energy(e)
        return 0.5 * sum(a * b for a, b in zip(symmetric_times(stiffness, e), e, strict=True))


def symmetric_times(c: Sequence[Scalar], e: Sequence[Scalar]) -> list[Scalar]:
    """C e for a C given by its diagonal (6) or its upper triangle by rows (21)."""
    if len(c) == 6:
        return [c[i] * e[i] for i in range(6)]
    full: dict[tuple[int, int], Scalar] = {}
    for i in range(6):
        for j in range(i, 6):
            full[i, j] = full[j, i] = c[i * 6 - i * (i - 1) // 2 + j - i]
    return [sum(full[i, j] * e[j] for j in range(6)) for i in range(6)]


@cache
def points(nn: int, count: int) -> tuple[Point, ...]:
    """The ``count`` Gauss points of an element with ``nn`` nodes."""
    w, (n, dn) = gauss(count)[1], at_gauss(nn - 1, count)
    return tuple((float(w[g]), n[g].tolist(), dn[g].tolist()) for g in range(count))
