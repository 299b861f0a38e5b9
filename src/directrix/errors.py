"""The errors a user can meet. Each says what, where, why, and what to do about it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from directrix.result import Result

__all__ = ["ConvergenceError", "DirectrixError", "InputError", "ModelError"]


class DirectrixError(Exception):
    """Base of every error that directrix raises on purpose."""


class ModelError(DirectrixError, ValueError):
    """The model, or what is asked of it, cannot be right.

    Parameters
    ----------
    what
        One sentence that names the member and says what is wrong and why.
    fix
        One sentence that says what to do.
    where
        The member, node, key or file and line, when it is not in ``what`` already.
    """

    def __init__(self, what: str, fix: str = "", where: str = "") -> None:
        self.what, self.fix, self.where = what, fix, where
        text = f"{where}: {what}" if where else what
        super().__init__(f"{text}\n  fix: {fix}" if fix else text)


class InputError(ModelError):
    """A case file cannot be read; ``where`` holds file, line and key."""


class ConvergenceError(DirectrixError, RuntimeError):
    """Raised only with ``raise_on_failure=True``; ``result`` holds everything up to the failure."""

    def __init__(self, result: Result) -> None:
        self.result = result
        super().__init__(f"{result.status.sentence}\n  advice: {result.status.advice}")
