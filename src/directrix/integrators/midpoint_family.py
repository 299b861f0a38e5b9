"""The midpoint family: one scheme, one row of weights each (paper 44–50, 67).

With x½ = ½(x0 + x1) and ẋ1 = (2/Δt)(x1 − x0) − ẋ0::

    Π(d½)ᵀ { M (ẋ1 − ẋ0)/Δt + ∫ Bᵀ(x½) S* dS } = F_ext,     S* = C (w0 ε0 + w1 ε1 + wh ε½)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

from directrix.formulations.directors import Rule

__all__ = ["EnergyMomentum", "Integrator", "Midpoint"]


class Integrator(Protocol):
    """What the time loop asks of a scheme: its rule, and which laws it claims."""

    rule: ClassVar[Rule]
    conserves_energy: ClassVar[bool]
    conserves_momenta: ClassVar[bool]


@dataclass(frozen=True)
class EnergyMomentum:
    """Romero & Armero (2002): S* = C ½(ε0 + ε1). Energy, linear and angular momentum exact for any Δt; order 2."""

    rule: ClassVar[Rule] = Rule(w0=0.5, w1=0.5, wh=0.0)
    conserves_energy: ClassVar[bool] = True
    conserves_momenta: ClassVar[bool] = True


@dataclass(frozen=True)
class Midpoint:
    """The classical midpoint rule: S* = C ε(x½). Momenta exact; the energy drifts and may diverge; order 2."""

    rule: ClassVar[Rule] = Rule(w0=0.0, w1=0.0, wh=1.0)
    conserves_energy: ClassVar[bool] = False
    conserves_momenta: ClassVar[bool] = True
