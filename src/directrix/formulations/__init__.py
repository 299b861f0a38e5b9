"""Kinematic formulations: how strains follow from nodal unknowns."""

from __future__ import annotations

from directrix.checks import shown
from directrix.errors import ModelError
from directrix.formulations.directors import Directors

__all__ = ["Directors", "refuse_strategies"]


def refuse_strategies(formulation: object, progress: object) -> None:
    """Raise ModelError for arguments of a solver that cannot be what they should."""
    if formulation is not None and not isinstance(formulation, Directors):
        raise ModelError(f"{shown(formulation)} is not a formulation", "use dx.Directors()", "formulation=")
    if progress is not None and not callable(progress):
        raise ModelError(f"{shown(progress)} cannot be called", "give a function of a fraction and a text", "progress=")
