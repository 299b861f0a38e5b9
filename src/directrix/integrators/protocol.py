"""What the time loop asks of a time step."""

from __future__ import annotations

from typing import ClassVar, Protocol

from directrix.formulations.crisfield_jelenic import CrisfieldJelenic
from directrix.formulations.directors import Directors
from directrix.formulations.simo_vu_quoc import SimoVuQuoc
from directrix.scheme import Scheme

__all__ = ["Formulation", "Integrator"]

Formulation = Directors | SimoVuQuoc | CrisfieldJelenic


class Integrator(Protocol):
    """A frozen value: its parameters, what it conserves, what it needs."""

    formulation: ClassVar[Formulation]
    """The one it works with, and its default."""
    why: ClassVar[str]
    """Why no other."""
    conserves_energy: ClassVar[bool]
    """The ledger closes: total = start + work − dissipated."""
    conserves_momenta: ClassVar[bool]
    damping: ClassVar[bool]
    """Sections may be damped."""

    @property
    def order(self) -> int:
        """In Δt."""
        ...

    def scheme(self, dt: float) -> Scheme:
        """One step of length ``dt``."""
        ...
