"""Simo, Tarnow & Doblaré (1995), the scheme that the paper compares itself with (appendix B)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from directrix.formulations.simo_tarnow_doblare import SimoTarnowDoblareStep
from directrix.formulations.simo_vu_quoc import SimoVuQuoc
from directrix.integrators.protocol import Formulation
from directrix.scheme import Rates, Scheme

__all__ = ["SimoTarnowDoblare"]


@dataclass(frozen=True)
class SimoTarnowDoblare:
    """B1–B6 of the paper: momenta exact; the energy oscillates, because interpolation in space and time do not commute.

    Rotations are carried at the Gauss points, as in ``dx.SimoVuQuoc()``.
    """

    formulation: ClassVar[Formulation] = SimoVuQuoc()
    why: ClassVar[str] = "it interpolates increments of rotation and carries rotations at the Gauss points"
    conserves_energy: ClassVar[bool] = False
    conserves_momenta: ClassVar[bool] = True
    damping: ClassVar[bool] = False

    @property
    def order(self) -> int:
        """In Δt."""
        return 2

    def scheme(self, dt: float) -> Scheme:
        """One step of length ``dt``."""
        return Scheme(SimoTarnowDoblareStep(), Rates.SPIN, (2.0 / dt, 1.0 / dt))
