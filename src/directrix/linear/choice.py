"""Which solver of frames a user asks for."""

from __future__ import annotations

from typing import Literal

from directrix.checks import nearest, shown
from directrix.errors import ModelError
from directrix.linear.direct import Packaged
from directrix.linear.petsc import Petsc

__all__ = ["Linear", "chosen", "said_of"]

Linear = Petsc | Literal["rslab", "pardiso", "petsc"]
"""What ``linear=`` may be beside None."""
NAMES = {"rslab": Packaged("rslab"), "pardiso": Packaged("pardiso"), "petsc": Petsc()}


def chosen(linear: Linear | None) -> Petsc | Packaged | None:
    """The strategy of ``linear=``; None is the solver that needs nothing but SciPy.

    Raises ModelError for what is no solver, and where the package is missing.
    """
    if linear is None:
        return None
    found = linear if isinstance(linear, Petsc) else NAMES.get(linear)
    if found is None:
        hint = nearest(linear, NAMES) if isinstance(linear, str) else ""
        raise ModelError(
            f"linear = {shown(linear)} is no solver",
            f'{hint}use "rslab", "pardiso", "petsc", dx.Petsc(…) or nothing',
            "linear=",
        )
    found.ready()
    return found


def said_of(linear: Linear | None) -> dict[str, Linear]:
    """What a kept run notes of it: its last digits are those of its solver. Nothing where there is nothing to say."""
    return {} if linear is None else {"linear": linear}
