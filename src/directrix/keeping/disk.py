"""Everything that a run writes goes through here: whole files in place of old ones, and lines at the end of a log.

A file is written beside its place, brought to the disk and moved there, so its place always holds an old or a new file
and never a part of one. The four calls that can fail, :func:`write`, :func:`flush`, :func:`sync` and :func:`replace`,
are functions of their own: the tests let each of them fail in turn.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager, suppress
from errno import EDQUOT, ENOSPC, EROFS
from pathlib import Path
from typing import BinaryIO
from uuid import uuid4

from directrix.errors import InputError

__all__ = ["append", "put", "refused", "replacing"]


def write(file: BinaryIO, data: bytes | memoryview) -> int:
    """Write all of ``data``."""
    return file.write(data)


def flush(file: BinaryIO) -> None:
    """Hand what was written to the system."""
    file.flush()


def sync(descriptor: int) -> None:
    """Wait until it is on the disk."""
    os.fsync(descriptor)


def replace(part: Path, path: Path) -> None:
    """Move a file to its place, in one piece."""
    part.replace(path)


@contextmanager
def replacing(path: Path) -> Generator[BinaryIO]:
    """A file to write to that takes the place of ``path`` when all went well. Raises OSError."""
    part = path.with_name(f".{uuid4().hex}.part")
    try:
        with part.open("w+b") as file:
            yield file
            flush(file)
            sync(file.fileno())
        replace(part, path)
        _sync_folder(path.parent)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def put(path: Path, data: bytes | memoryview) -> None:
    """Write a whole file in place of what was there. Raises OSError, with the old file as it was."""
    with replacing(path) as file:
        write(file, data)


def append(path: Path, text: str) -> None:
    """Add to a text file; what is lost of it in a crash is at its end. Raises OSError."""
    with path.open("ab") as file:
        write(file, text.encode())
        flush(file)


def refused(error: OSError, where: str, needed: int, then: str = "") -> InputError:
    """What to say when the system does not take a file of ``needed`` bytes; ``then`` is to be done after that."""
    what = f"cannot be written: {error.strerror or error}"
    fix = "check free space and permissions"
    if error.errno in (ENOSPC, EDQUOT):
        free = -1
        with suppress(OSError):
            free = shutil.disk_usage(Path(where).parent).free
        room = f", {_megabytes(free)} are free" if free >= 0 else ""
        what, fix = f"{what}; {_megabytes(needed)} are needed{room}", "make room for that"
    elif error.errno == EROFS:
        fix = "make the disk writable"
    return InputError(what, f"{fix}, {then}" if then else fix, where)


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.3g} MB"


def _sync_folder(folder: Path) -> None:
    """Bring the new name to the disk as well, where a system can do that for a folder."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            sync(descriptor)
        finally:
            os.close(descriptor)
