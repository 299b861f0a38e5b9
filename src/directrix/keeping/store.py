"""The parts of a run in its folder: sealed segments of its result, and two checkpoints that take turns."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from directrix.keeping import disk
from directrix.keeping.packing import DamagedError, pack, unpack

__all__ = ["Store", "resume_command"]

PARTS = "parts"


def resume_command(folder: Path, typed: bool = True) -> str:
    """What to type to go on with the run of a case, or what to call to go on with one that was not ``typed``."""
    if not typed:
        return f"the same call and folder=dx.Folder({str(folder)!r}, resume=True)"
    name = str(folder)
    return f"directrix resume {name!r}" if any(c.isspace() for c in name) else f"directrix resume {name}"


@dataclass(frozen=True)
class Store:
    """Reads and writes ``parts/`` of the folder of a run.

    A segment is written once and never touched again. A checkpoint says how many segments belong to it and goes to the
    slot of the older one of two, so that the newer one stands until the new one is complete.
    """

    folder: Path
    typed: bool = True
    """The run is that of a case file."""

    @property
    def path(self) -> Path:
        """Where the parts are."""
        return self.folder / PARTS

    @property
    def then(self) -> str:
        """What to do when the disk takes files again."""
        return f"then go on from the last checkpoint with: {resume_command(self.folder, self.typed)}"

    def make(self) -> None:
        """Make the place. Raises InputError."""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise disk.refused(error, str(self.path), 0) from None

    def clear(self) -> None:
        """Remove all parts."""
        shutil.rmtree(self.path, ignore_errors=True)

    def segment(self, number: int) -> Path:
        """File of a segment, counted from 0."""
        return self.path / f"segment-{number:06d}"

    def slot(self, serial: int) -> Path:
        """File of a checkpoint."""
        return self.path / f"checkpoint-{serial % 2}"

    def seal(self, number: int, values: Mapping[str, Any]) -> int:
        """Write a segment; its bytes. Raises InputError."""
        return self._put(self.segment(number), values)

    def keep(self, serial: int, values: Mapping[str, Any]) -> int:
        """Write a checkpoint; its bytes. Raises InputError."""
        return self._put(self.slot(serial), {**values, "serial": serial})

    def newest(self) -> dict[str, Any] | None:
        """The newest checkpoint that can be read and whose segments can; None when there is none."""
        found: list[dict[str, Any]] = []
        for k in range(2):
            with suppress(OSError, DamagedError):
                found.append(unpack(self.slot(k).read_bytes()))
        for checkpoint in sorted(found, key=lambda c: -int(c["serial"])):
            with suppress(OSError, DamagedError):
                for _ in self.segments(checkpoint["segments"]):
                    pass
                return checkpoint
        return None

    def segments(self, count: int) -> Iterator[dict[str, Any]]:
        """The first ``count`` segments. Raises OSError, DamagedError."""
        for k in range(count):
            yield unpack(self.segment(k).read_bytes())

    def forget(self, first: int) -> None:
        """Remove segments from number ``first`` on."""
        for path in self.path.glob("segment-*"):
            if int(path.name.removeprefix("segment-")) >= first:
                with suppress(OSError):
                    path.unlink()

    def _put(self, path: Path, values: Mapping[str, Any]) -> int:
        data = pack(values)
        try:
            disk.put(path, data)
        except OSError as error:
            raise disk.refused(error, str(path), len(data), self.then) from None
        return len(data)
