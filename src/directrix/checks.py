"""Arguments that users give: one clear refusal each."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np

from directrix.errors import ModelError

Vec = tuple[float, float, float]

__all__ = [
    "Vec",
    "choice",
    "file",
    "flag",
    "nearest",
    "number",
    "reporting",
    "shown",
    "step_count",
    "text",
    "vector",
    "whole",
]


def shown(value: Any) -> str:
    """A value in few characters, whatever it is."""
    try:
        text = repr(value)
    except Exception:  # a repr of the user's own, or Python's limit on digits
        text = f"a {type(value).__name__}"
    return text if len(text) <= 60 else f"{text[:57]}…"


def flag(value: Any, what: str) -> bool:
    """True or False; raises ModelError that names ``what``."""
    if not isinstance(value, (bool, np.bool_)):
        raise ModelError(f"{what} = {shown(value)} is neither True nor False", "give True or False")
    return bool(value)


def number(value: Any, what: str, *, above: float | None = None, least: float | None = None) -> float:
    """A finite float, above or at least a bound; raises ModelError that names ``what``."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ModelError(f"{what} = {shown(value)} is not a number", "give a finite number")
    try:
        value = float(value)
    except OverflowError:
        value = np.inf
    if not np.isfinite(value):
        raise ModelError(f"{what} = {value} is not finite", "give a finite number")
    if above is not None and not value > above:
        raise ModelError(f"{what} = {value:g} is not greater than {above:g}", f"give a number greater than {above:g}")
    if least is not None and not value >= least:
        raise ModelError(f"{what} = {value:g} is less than {least:g}", f"give {least:g} or more")
    return float(value)


def whole(value: Any, what: str, low: int, high: int | None = None) -> int:
    """A whole number within bounds; raises ModelError that names ``what``."""
    good = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not good or value < low or (high is not None and value > high):
        span = f"{low} or more" if high is None else f"{low} … {high}"
        raise ModelError(f"{what} = {shown(value)} is not a whole number, {span}", f"give a whole number, {span}")
    return int(value)


def vector(value: Any, what: str) -> Vec:
    """Three finite numbers; raises ModelError that names ``what``."""
    try:
        v = np.asarray(value, object)
    except Exception:  # whatever a foreign array may raise
        v = np.empty(0)
    if v.shape != (3,) or np.ma.is_masked(value):
        raise ModelError(f"{what} = {shown(value)} is not three numbers", "give (x, y, z)")
    x, y, z = (number(c, f"{what} = {shown(value)}: component {k}") for k, c in zip("xyz", v, strict=True))
    return x, y, z


def text(value: Any, what: str) -> str:
    """A name that is not empty; raises ModelError that names ``what``."""
    if not isinstance(value, str) or not value.strip():
        raise ModelError(f"{what} = {shown(value)} is not a name", "give a text that is not empty")
    return value


def choice(value: Any, what: str, allowed: Iterable[str]) -> str:
    """One of some words; raises ModelError that names ``what``, the words and the nearest one."""
    allowed = list(allowed)
    if not isinstance(value, str) or value not in allowed:
        raise ModelError(
            f"there is no {what} {shown(value)}",
            f"{nearest(value if isinstance(value, str) else '', allowed)}use one of {', '.join(allowed)}",
        )
    return str(value)


def nearest(word: str, known: Iterable[str]) -> str:
    """ "did you mean 'x'? " for the nearest known word, or nothing."""
    found = get_close_matches(word, list(known), 1)
    return f"did you mean {found[0]!r}? " if found else ""


def file(value: Any, what: str) -> Path:
    """A path from a text or ``os.PathLike`` that gives one; raises ModelError that names ``what``."""
    try:
        name = cast("object", os.fspath(value))
        good = isinstance(name, str) and name.strip() and b"\0" not in os.fsencode(name)
    except Exception:  # no path, a __fspath__ of the user's own, or characters that no file system takes
        good = False
    if not good:
        raise ModelError(f"{what} = {shown(value)} is not the path of a file", "give a text or a pathlib.Path")
    return Path(value)


def step_count(t0: float, t_end: float, dt: float, what: str = "dt") -> int:
    """Steps ``dt`` > 0, called ``what``, from ``t0`` to ``t_end``; raises ModelError: too many, or not whole."""
    if not t_end > t0:
        raise ModelError(f"t_end = {t_end} is not after the start at t = {t0:g}", "give a later end", "t_end=")
    if not (t_end - t0) / dt < 1e12:
        raise ModelError(
            f"{what} = {dt:g} makes more than 10¹² steps", "give a longer step or an earlier end", f"{what}=, t_end="
        )
    steps = round((t_end - t0) / dt)
    if steps < 1 or abs(steps * dt - (t_end - t0)) > 1e-6 * dt * max(1, steps) ** 0.5:
        near = max(1, steps)
        since = f"from t = {t0:g} to " if t0 else ""
        raise ModelError(
            f"{since}t_end = {t_end:g} is not a whole number of steps {what} = {dt:g}",
            f"use {what} = {(t_end - t0) / near:.10g} or t_end = {t0 + near * dt:.10g}",
            f"{what}=, t_end=",
        )
    return steps


def reporting(progress: Callable[[float, str], Any] | Literal[True] | None) -> Callable[[float, str], None]:
    """``progress`` as a run calls it: what it raises becomes a ModelError, with which the run ends and is kept."""
    if progress is True:
        from directrix.notebook import shower  # what shows it is not needed by who does not look

        progress = shower()

    def report(done: float, line: str) -> None:
        try:
            if progress is not None:
                progress(done, line)
        except Exception as error:  # whatever a user's function raises
            raise ModelError(
                f"progress fails with {shown(error)}", "mend or leave out the function, and go on with start="
            ) from error

    return report
