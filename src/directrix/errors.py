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
    code
        What kind of error it is, for programs and for docs/errors.md; see ``directrix.codes``.
    """

    usual = "DX400"

    def __init__(self, what: str, fix: str = "", where: str = "", code: str = "") -> None:
        self.what, self.fix, self.where, self.code = what, fix, where, code or self.usual
        super().__init__(self._text())

    def _text(self) -> str:
        text = f"{self.where}: {self.what}" if self.where else self.what
        return f"{text}\n  fix: {self.fix}" if self.fix else text


class InputError(ModelError):
    """A file cannot be used; ``where`` holds file, line, column and key, ``more`` what else is wrong with it."""

    usual = "DX500"

    def __init__(
        self, what: str, fix: str = "", where: str = "", code: str = "", more: tuple[InputError, ...] = ()
    ) -> None:
        self.more = more
        super().__init__(what, fix, where, code)

    @property
    def mistakes(self) -> tuple[InputError, ...]:
        """All that is wrong, one error each."""
        return (self, *self.more)

    def _text(self) -> str:
        first = f"{self.where}: {self.what} [{self.code}]" + (f"\n  fix: {self.fix}" if self.fix else "")
        return "\n".join([first, *(error._text() for error in self.more[:SHOWN])]) + _rest(len(self.more) - SHOWN)


SHOWN = 50  # mistakes of one file beyond the first; more are counted


def _rest(count: int) -> str:
    return f"\nand {count} more" if count > 0 else ""


class ConvergenceError(DirectrixError, RuntimeError):
    """Raised only with ``raise_on_failure=True``; ``result`` holds everything up to the failure."""

    def __init__(self, result: Result) -> None:
        self.result = result
        super().__init__(f"{result.status.sentence}\n  advice: {result.status.advice}")
