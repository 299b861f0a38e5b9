"""What a folder offers to go on with, and what speaks against it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from directrix.errors import InputError
from directrix.keeping.folder import changed, summary_of, unfinished
from directrix.keeping.store import Store

__all__ = ["Frozen", "frozen"]


@dataclass(frozen=True)
class Frozen:
    """The copy of the case as it was run, its title, the folder of the case, the end and the error of steps that were
    asked for last, and what is not as it was."""

    path: Path
    title: str
    beside: Path
    until: float | None
    adaptive: float | None
    warnings: tuple[str, ...]


def frozen(folder: Path, *, force: bool = False, until: float | None = None) -> Frozen:
    """What ``directrix resume`` goes on with.

    Raises InputError where there is nothing to go on with, and without ``force`` where the case or its copy in the
    folder has changed since.
    """
    said = summary_of(folder)
    where = str(folder)
    if said is None:
        raise InputError("holds no run to go on with", "name the folder that directrix run wrote", where)
    of: dict[str, Any] = said.get("input") or {}
    if "copy" not in of:
        raise InputError(
            "holds a run that was not started from a case file",
            "go on from Python, with the same call and folder=dx.Folder(…, resume=True)",
            where,
        )
    if not unfinished(said) and said["status"].get("success") and until is None:
        raise InputError("holds a run that has finished", "name a later end with --until", where)
    copy, original = folder / of["copy"], Path(of["path"])
    warnings: list[str] = []
    if not copy.exists() and _sha256(original) == of["sha256"]:  # killed before the copy was made
        copy = original
    for path, what in ((copy, "the copy of the case in the folder"), (original, "the case")):
        now = _sha256(path)
        if now is None and path is copy:
            raise InputError("is not there", "put the copy of the case back, or run the case again", str(copy))
        if now is None or now == of["sha256"]:
            continue
        if not force:
            raise InputError(
                f"{what} has changed since the run began",
                "put it back, or add --force to go on with the copy in the folder as it is, or run the case again",
                str(path),
            )
        warnings.append(f"{path} has changed since the run began")
    warnings += [f"{line}: the last digits may be others" for line in changed(said)]
    if Store(folder).newest() is None:
        warnings.append("there is no checkpoint that can be read: the run begins anew")
    end = said.get("until") if until is None else until
    return Frozen(copy, said.get("title", ""), Path(of["folder"]), end, said.get("adaptive"), tuple(warnings))


def _sha256(path: Path) -> str | None:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None
