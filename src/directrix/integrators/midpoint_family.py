"""The midpoint family: one scheme, one row of weights each (paper 44–50, 67).

With x½ = ½(x0 + x1) and ẋ1 = (2/Δt)(x1 − x0) − ẋ0::

    Π(d½)ᵀ { M (ẋ1 − ẋ0)/Δt + ∫ Bᵀ(x½) S* dS } = F_ext,     S* = C (w0 ε0 + w1 ε1 + wh ε½) + C_v Δε/Δt
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from directrix.checks import number
from directrix.errors import ModelError
from directrix.formulations.directors import Directors, DirectorStep, Rule
from directrix.integrators.protocol import Formulation
from directrix.scheme import Rates, Scheme

__all__ = ["LARGEST_CHI", "EnergyDissipating", "EnergyMomentum", "Midpoint"]

LARGEST_CHI = 1.0 / 3.0


@dataclass(frozen=True)
class EnergyMomentum:
    """Romero & Armero (2002): S* = C ½(ε0 + ε1). Energy, linear and angular momentum exact for any Δt; order 2.

    Sections with a stored energy take the discrete gradient (Gonzalez 1996) in its place, which is as exact.
    """

    formulation: ClassVar[Formulation] = Directors()
    why: ClassVar[str] = "strains must be quadratic in the nodal unknowns, which only interpolated directors give"
    conserves_energy: ClassVar[bool] = True
    conserves_momenta: ClassVar[bool] = True
    damping: ClassVar[bool] = True

    @property
    def order(self) -> int:
        """In Δt."""
        return 2

    def scheme(self, dt: float) -> Scheme:
        """One step of length ``dt``."""
        return Scheme(DirectorStep(Rule(w0=0.5, w1=0.5)), Rates.MIDPOINT, (2.0 / dt, 1.0 / dt))


@dataclass(frozen=True)
class Midpoint:
    """The classical midpoint rule: S* = C ε(x½). Momenta exact; the energy drifts and may diverge; order 2."""

    formulation: ClassVar[Formulation] = Directors()
    why: ClassVar[str] = "it is written for interpolated directors"
    conserves_energy: ClassVar[bool] = False
    conserves_momenta: ClassVar[bool] = True
    damping: ClassVar[bool] = True

    @property
    def order(self) -> int:
        """In Δt."""
        return 2

    def scheme(self, dt: float) -> Scheme:
        """One step of length ``dt``."""
        return Scheme(DirectorStep(Rule(w0=0.0, w1=0.0, wh=1.0)), Rates.MIDPOINT, (2.0 / dt, 1.0 / dt))


@dataclass(frozen=True)
class EnergyDissipating:
    """Energy-dissipating, momentum-conserving (Armero & Romero 2001): momenta exact, the energy never grows.

    A step takes exactly ½ χ1 Δε·CΔε per length (``chi_stress``) and ½ χ2 m (|v1| − |v0|)² per node and vector
    (``chi_velocity``), high frequencies first; a steady rotation is kept. With ``chi_velocity`` > 0 the mass is lumped
    at the nodes. Both zero is :class:`EnergyMomentum`. Order 1 where χ > 0, in what it dissipates.

    Raises ModelError unless chi_stress ≥ 0 and 0 ≤ chi_velocity < 1/3: with v1 = 2w/(1 + g) − v0, w = Δx/Δt, a
    larger value leaves more than one |v1| to a w that reverses v0 (and above 0.2 the iteration is the worse for it).
    """

    chi_stress: float = 0.5
    chi_velocity: float = 0.0
    formulation: ClassVar[Formulation] = Directors()
    why: ClassVar[str] = "strains must be quadratic in the nodal unknowns, which only interpolated directors give"
    conserves_energy: ClassVar[bool] = True
    conserves_momenta: ClassVar[bool] = True
    damping: ClassVar[bool] = True

    def __post_init__(self) -> None:
        number(self.chi_stress, "chi_stress", least=0.0)
        if number(self.chi_velocity, "chi_velocity", least=0.0) >= LARGEST_CHI:
            raise ModelError(
                f"chi_velocity = {self.chi_velocity:g} is not less than 1/3: a step could end with several velocities",
                "give 0 ≤ chi_velocity < 1/3",
            )

    @property
    def order(self) -> int:
        """In Δt."""
        return 1 if self.chi_stress or self.chi_velocity else 2

    def scheme(self, dt: float) -> Scheme:
        """One step of length ``dt``."""
        common = (2.0 / dt, 1.0 / dt, self.chi_stress, self.chi_velocity)
        lumped = self.chi_velocity > 0.0
        rule = Rule(w0=0.5, w1=0.5, dissipative=True, inertia=not lumped)
        return Scheme(DirectorStep(rule), Rates.DISSIPATIVE if lumped else Rates.MIDPOINT, common, lumped)
