"""A folder for several runs that belong together: each of them has a folder of its own in it, named after it."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from directrix.checks import shown
from directrix.errors import InputError, ModelError
from directrix.keeping import disk
from directrix.keeping.folder import Folder, summary_of
from directrix.keeping.store import resume_command
from directrix.runs import few

__all__ = ["Many"]

INDEX = "runs.json"
LONGEST = 60  # of a label in the name of a folder


@dataclass(frozen=True)
class Many:
    """The folders of runs that are told apart by labels."""

    options: Folder
    """Of all the runs; its path is where their folders are."""
    names: dict[Hashable, str]

    @classmethod
    def claim(cls, folder: Folder | str | os.PathLike[str], labels: Sequence[Hashable], what: str = "runs") -> Many:
        """Make the folder, or go on with the runs that are in it. Raises InputError, ModelError."""
        options = folder if isinstance(folder, Folder) else Folder(folder)
        many = cls(options, {label: _name(label) for label in labels})
        path, index = Path(options.path), Path(options.path) / INDEX
        if len({name.casefold() for name in many.names.values()}) < len(labels):
            raise ModelError("two labels have the same name", "give labels that differ in more than their kind")
        try:
            path.mkdir(parents=True, exist_ok=True)
            there = sorted(p.name for p in path.iterdir())
        except FileExistsError:
            raise InputError("is a file, not a folder", "name another folder", str(path)) from None
        except OSError as error:
            raise disk.refused(error, str(path), 0, "or name another folder") from None
        said = _read(index)
        if there and said is None:
            raise InputError(
                f"holds {few(there)} but no {INDEX}, so nothing in it is overwritten",
                "name another folder, or move them away",
                str(path),
            )
        if options.resume and said is None:
            raise InputError("holds no runs to go on with", "name the folder of an earlier call", str(path))
        if said is not None and not said["finished"] and not options.resume and not options.overwrite:
            raise InputError(
                f"holds {what} that not all have finished",
                f"go on with {many.again}; or throw them away with overwrite=True",
                str(path),
            )
        many.say(finished=False)
        return many

    def say(self, *, finished: bool) -> None:
        """Write down which folder is whose, and whether all of them are finished. Raises InputError."""
        index = Path(self.options.path) / INDEX
        runs = {name: repr(label) for label, name in self.names.items()}
        said = {"program": "directrix", "finished": finished, "runs": runs}
        data = (json.dumps(said, indent=2, ensure_ascii=False) + "\n").encode()
        try:
            disk.put(index, data)
        except OSError as error:
            raise disk.refused(error, str(index), len(data), f"then go on with {self.again}") from None

    @property
    def again(self) -> str:
        """What to call to go on."""
        return resume_command(Path(self.options.path), typed=False)

    def of(self, label: Hashable) -> Folder:
        """The folder of a run, which goes on if that is wanted and there is something to go on from."""
        path = Path(self.options.path) / self.names[label]
        return replace(self.options, path=path, resume=self.options.resume and summary_of(path) is not None)


def _name(label: Hashable) -> str:
    """What the folder of a label is called: the label, as far as a file system takes it."""
    if not _lasts(label):
        raise ModelError(
            f"the label {shown(label)} has no name that lasts", "use texts, numbers or tuples of them as labels"
        )
    text = str(label)
    if len(text) <= LONGEST and re.fullmatch(r"\w[\w.+=-]*", text, re.ASCII):
        return text
    plain = re.sub(r"[^\w.+=-]+", "_", text, flags=re.ASCII).strip("._")
    return f"{plain[:LONGEST]}-{hashlib.sha256(repr(label).encode()).hexdigest()[:8]}"


def _lasts(label: Any) -> bool:
    if isinstance(label, tuple):
        return all(map(_lasts, cast("tuple[Any, ...]", label)))
    return label is None or isinstance(label, (str, bytes, int, float, complex, np.generic))


def _read(index: Path) -> dict[str, Any] | None:
    """What was written down; None where that is none of ours."""
    try:
        data: Any = json.loads(index.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    said = cast("dict[str, Any]", data) if isinstance(data, dict) else {}
    return said if said.get("program") == "directrix" and "finished" in said else None
