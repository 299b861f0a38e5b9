"""What one step of a run is made of, as the solver and the compiled loops need it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from directrix.formulations.element import COMMON, Element

__all__ = ["Rates", "Scheme"]


class Rates(IntEnum):
    """How velocities follow from a step; the compiled loops read the number."""

    NONE = 0
    """Statics."""
    MIDPOINT = 1
    """ẋ1 = (2/Δt)(x1 − x0) − ẋ0."""
    SPIN = 2
    """ω1 = (2/Δt) ϑ − cay(ϑ) ω0 (paper B2)."""
    ALPHA = 3
    """Accelerations at the nodes: the generalised-α family."""
    DISSIPATIVE = 4
    """(1 + g) ½(v0 + v1) = Δx/Δt on a lumped mass, g = χ2 (|v1| − |v0|)/(|v1| + |v0|)."""

    @property
    def half(self) -> bool:
        """True when a step balances at its middle, not at its end."""
        return self not in (Rates.NONE, Rates.ALPHA)


@dataclass(frozen=True)
class Scheme:
    """One step: the element under its rule, how rates follow, scalars common to all elements.

    ``common`` begins with what the rule needs: (2/Δt, 1/Δt, χ1, χ2), or (c_v, c_a, Δt, β, γ, α_m, α_f) for ALPHA.
    ``lumped`` asks for a diagonal mass.
    """

    element: Element
    rates: Rates = Rates.NONE
    common: tuple[float, ...] = ()
    lumped: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "common", (*self.common, *[0.0] * (COMMON - len(self.common))))

    @property
    def static(self) -> bool:
        """True when time plays no part."""
        return self.rates is Rates.NONE

    @property
    def inertia(self) -> float:
        """What multiplies the mass in the tangent, 1/time²."""
        if self.static:
            return 0.0
        return self.common[1] if self.rates is Rates.ALPHA else 0.5 * self.common[0] ** 2

    @property
    def nodal_rows(self) -> bool:
        """True when every node has a row of history: its accelerations."""
        return self.rates is Rates.ALPHA
