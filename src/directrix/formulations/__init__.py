"""Kinematic formulations: how strains follow from nodal unknowns."""

from collections.abc import Callable

from directrix.checks import shown
from directrix.errors import ModelError
from directrix.formulations.crisfield_jelenic import CrisfieldJelenic
from directrix.formulations.directors import Directors
from directrix.formulations.simo_vu_quoc import SimoVuQuoc

BY_NAME: dict[str, Callable[[], Directors | SimoVuQuoc | CrisfieldJelenic]] = {
    "directors": Directors,
    "simo-vu-quoc": SimoVuQuoc,
    "crisfield-jelenic": CrisfieldJelenic,
}
"""Their names in case files."""

__all__ = ["BY_NAME", "CrisfieldJelenic", "Directors", "SimoVuQuoc", "refuse_strategies"]


def refuse_strategies(formulation: object, progress: object) -> None:
    """Raise ModelError for arguments of a solver that cannot be what they should."""
    if formulation is not None and not isinstance(formulation, Directors | SimoVuQuoc | CrisfieldJelenic):
        raise ModelError(f"{shown(formulation)} is not a formulation", "use dx.Directors()", "formulation=")
    if progress is not None and progress is not True and not callable(progress):
        raise ModelError(
            f"{shown(progress)} cannot be called", "give a function of a fraction and a text, or True", "progress="
        )
