"""Kinematic formulations: how strains follow from nodal unknowns."""

from collections.abc import Callable

from directrix.formulations.crisfield_jelenic import CrisfieldJelenic
from directrix.formulations.directors import Directors
from directrix.formulations.simo_vu_quoc import SimoVuQuoc

BY_NAME: dict[str, Callable[[], Directors | SimoVuQuoc | CrisfieldJelenic]] = {
    "directors": Directors,
    "simo-vu-quoc": SimoVuQuoc,
    "crisfield-jelenic": CrisfieldJelenic,
}
"""Their names in case files."""

__all__ = ["BY_NAME", "CrisfieldJelenic", "Directors", "SimoVuQuoc"]
