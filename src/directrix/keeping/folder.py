"""The folder of a run while it goes on: who owns it, what ran, where it is, and what came out in the end."""

from __future__ import annotations

import fcntl
import json
import os
import platform
import socket
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from directrix import runs
from directrix.checks import file, number, whole
from directrix.errors import InputError
from directrix.keeping import disk
from directrix.keeping.store import Store, resume_command

if TYPE_CHECKING:
    from directrix.result import Result

__all__ = ["Folder", "RunFolder", "Source", "environment"]

LOG, INPUTS = "log.jsonl", ("input.toml", "input.json")
UNFINISHED = ("running", "interrupted")
GOES_ALONG = ("python", "numpy", "scipy", "numba", "llvmlite", "h5py", "directrix")


@dataclass(frozen=True)
class Folder:
    """Where a run is kept while it goes on, and how often.

    Parameters
    ----------
    path
        The folder; it is made, and holds one run and nothing else.
    resume
        Go on with the unfinished run in it; one that has finished goes on when more is asked for (a later ``t_end``).
    overwrite
        Throw away an unfinished run in it.
    seconds
        Time from one checkpoint to the next; longer where a checkpoint takes long.
    steps
        A checkpoint after so many steps as well.
    force
        Go on though the model or an argument is not what it was.
    """

    path: str | os.PathLike[str]
    resume: bool = False
    overwrite: bool = False
    seconds: float = 20.0
    steps: int | None = None
    force: bool = False

    def __post_init__(self) -> None:
        file(self.path, "path of the folder")
        number(self.seconds, "seconds", least=0.0)
        if self.steps is not None:
            whole(self.steps, "steps", 1)


@dataclass(frozen=True)
class Source:
    """The case file that is run: its title, where it is, its bytes and their SHA-256."""

    title: str
    path: Path
    raw: bytes
    sha256: str

    @property
    def copy(self) -> str:
        """Name of the copy in the folder."""
        return f"input{self.path.suffix.lower()}"


@dataclass
class RunFolder:
    """A folder that holds one run and nothing else, and is locked while it is open."""

    path: Path
    options: Folder
    source: Source | None = None
    command: bool = False
    """The command line runs it: a second signal ends the process."""
    said: dict[str, Any] = field(default_factory=dict[str, Any])
    """What run.json says."""
    more: dict[str, Any] = field(default_factory=dict[str, Any])
    """What run.json is to say beside."""
    kind: str = "dynamic"
    lock: int = -1
    first: float | None = None

    @classmethod
    def claim(cls, options: Folder, source: Source | None = None, *, command: bool = False) -> RunFolder:
        """Make the folder, or take over one that holds an earlier run, where other files are left alone; refuses any
        other (InputError)."""
        path = Path(options.path)
        where = str(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
            names = {p.name for p in path.iterdir() if not p.name.startswith(".")}
            # found out now, not after an hour of computing
            probe = path / ".directrix-write-test"
            probe.write_bytes(b"")
            probe.unlink()
        except FileExistsError:
            raise InputError("is a file, not a folder", "name another folder with --out", where) from None
        except OSError as error:
            raise disk.refused(error, where, 0, "or name another folder with --out") from None
        said = summary_of(path)
        if names and said is None:
            raise InputError(
                f"holds {runs.few(sorted(names))} but no {runs.SUMMARY} of a run, so nothing in it is overwritten",
                "name another folder with --out, or move them away",
                where,
            )
        if options.resume and said is None:
            raise InputError("holds no run to go on with", "name the folder of a run", where)
        folder = cls(path, options, source, command, said or {})
        folder._lock()
        if said is not None and unfinished(said) and not options.resume and not options.overwrite:
            folder.close()
            raise InputError(
                f"holds a run that has not finished: {how_far(path, said)}",
                f"go on with it: {resume_command(path, typed(said))}; or throw it away with --overwrite (in Python, "
                "overwrite=True of dx.Folder)",
                where,
            )
        return folder

    @property
    def store(self) -> Store:
        """Segments and checkpoints."""
        return Store(self.path, typed(self.said))

    def begin(self, fingerprint: str) -> None:
        """Freeze the input and say that the run is on. Raises InputError."""
        source, copy = self.source, {}
        if source is not None:
            beside = str(source.path.resolve().parent)
            copy = {"path": str(source.path), "folder": beside, "sha256": source.sha256, "copy": source.copy}
        elif self.options.resume and "copy" in self.said.get("input", {}):
            copy = self.said["input"]
        self.said = {
            "program": "directrix", "title": source.title if source is not None else self.said.get("title", ""),
            "status": {
                "code": "running", "sentence": "has begun.", "success": False, "complete": False, "exit_code": None,
            },
            "input": copy, "fingerprint": fingerprint, "environment": environment(), "pid": os.getpid(),
            "host": socket.gethostname(), "progress": {"steps": 0, "at": None}, **self.more,
        }  # fmt: skip
        self._say()  # first: it makes the folder ours
        for old in () if self.options.resume else self.path.glob(runs.RECORDS):
            with suppress(OSError):
                old.unlink()
        for name in INPUTS:
            if not (self.options.resume and name == copy.get("copy")):
                with suppress(OSError):
                    (self.path / name).unlink(missing_ok=True)
        if source is not None:
            self._put(source.copy, source.raw)
        self._put(LOG, b"")
        self._put(runs.MONITOR, b"")
        self.log("started")

    def resumed(self, at: float, segments: int) -> None:
        """The run goes on from there. Raises InputError."""
        self.said["status"] = {
            "code": "running", "sentence": f"goes on from {at:.9g}.", "success": False, "complete": False,
            "exit_code": None,
        }  # fmt: skip
        self.said |= {"environment": environment(), "pid": os.getpid(), "host": socket.gethostname(), **self.more}
        self._say()
        self._put(runs.MONITOR, b"")
        for part in self.store.segments(segments):
            self._watch(part)
        self.log("resumed", at=at)

    def checkpointed(self, rows: Mapping[str, Any], steps: int, at: float) -> None:
        """Say how far it is."""
        self.said["status"]["sentence"] = f"has reached {at:.9g}."
        self.said["progress"] = {"steps": steps, "at": at}
        self._say()
        self._watch(rows)
        self.log("checkpoint", steps=steps, at=at)

    def log(self, event: str, **more: Any) -> None:
        """Add a line to the log."""
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        try:
            disk.append(self.path / LOG, json.dumps({"time": now, "event": event, **more}) + "\n")
        except OSError as error:
            raise disk.refused(error, str(self.path / LOG), 1000, self.store.then) from None

    def write(self, result: Result) -> None:
        """Write result, summary and monitor in place of what was there. Raises InputError."""
        for name in runs.OURS - {runs.SUMMARY, runs.MONITOR, runs.RESULT}:
            with suppress(OSError):
                (self.path / name).unlink(missing_ok=True)
        try:
            saved = Path(result.save(self.path / runs.RESULT))
        except InputError as error:
            raise InputError(error.what, f"{error.fix}, {self.store.then}", error.where) from None
        self._put(runs.MONITOR, runs.monitor(result))
        kept = ("title", "input", "fingerprint", "environment", "progress", "until", "adaptive")
        self.said = {**runs.summary(result, saved), **{k: self.said[k] for k in kept if k in self.said}}
        self.said["title"] = self.said["title"] or result.name
        self._say()
        self.log("ended", status=result.status.code, sentence=result.status.sentence)

    def result(self) -> Result:
        """The result that is there, checked against what run.json says of it. Raises InputError."""
        from directrix.storage import load

        path = self.path / runs.RESULT
        found = load(path)
        if runs.sha256(path) != self.said.get("result", {}).get("sha256"):
            raise InputError("is not the result that the run left", "run the case again", str(path))
        return found

    def close(self) -> None:
        """Give the folder back."""
        if self.lock >= 0:
            os.close(self.lock)
            self.lock = -1

    def __del__(self) -> None:
        self.close()  # an error of ours leaves a run that can be gone on with, in this process too

    def _lock(self) -> None:
        try:
            self.lock = os.open(self.path / ".lock", os.O_RDWR | os.O_CREAT, 0o644)
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise InputError(
                f"belongs to a run that is on (process {self.said.get('pid', '?')})",
                "wait for it, stop it, or name another folder with --out",
                str(self.path),
            ) from None
        except OSError:  # a file system without locks
            pass

    def _watch(self, rows: Mapping[str, Any]) -> None:
        """Add rows to the monitor."""
        if not rows["rows"]:
            return
        if self.first is None:
            self.first = float(rows["totals"][0, :2].sum())
            self._append(runs.MONITOR, ",".join(runs.columns_of(self.kind)) + "\n")
        scalars, totals = rows["scalars"], rows["totals"]
        total = totals[:, 1] + totals[:, 0]
        residual = total - self.first - scalars[:, 2] + scalars[:, 4]
        table = np.column_stack([scalars[:, 0], totals[:, 1], totals[:, 0], total, scalars[:, [2, 4]], residual])
        lines = (",".join(map(repr, row)) for row in np.hstack([table, totals[:, 2:8]]).tolist())
        self._append(runs.MONITOR, "".join(f"{line}\n" for line in lines))

    def _append(self, name: str, text: str) -> None:
        try:
            disk.append(self.path / name, text)
        except OSError as error:
            raise disk.refused(error, str(self.path / name), len(text), self.store.then) from None

    def _say(self) -> None:
        text = json.dumps(runs.finite(self.said), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        self._put(runs.SUMMARY, text.encode())

    def _put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        needed, parts = 0, iter((data,) if isinstance(data, bytes) else data)
        try:
            with disk.replacing(self.path / name) as file:
                for part in parts:
                    needed += len(part)
                    disk.write(file, part)
        except OSError as error:
            needed += sum(map(len, parts))
            raise disk.refused(error, str(self.path / name), needed, self.store.then) from None


def summary_of(path: Path) -> dict[str, Any] | None:
    """What run.json of a folder says; None when there is none of ours."""
    try:
        data: Any = json.loads((path / runs.SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return data if isinstance(data, dict) and data.get("program") == "directrix" else None  # pyright: ignore


def unfinished(said: Mapping[str, Any]) -> bool:
    """True for a run that is on, was killed or was interrupted."""
    return said.get("status", {}).get("code") in UNFINISHED


def typed(said: Mapping[str, Any]) -> bool:
    """True for the run of a case file, which the command line goes on with."""
    return "copy" in (said.get("input") or {})


def is_on(path: Path) -> bool:
    """True while a process runs in the folder."""
    try:
        lock = os.open(path / ".lock", os.O_RDWR)
    except OSError:
        return False
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(lock)
    return False


def how_far(path: Path, said: Mapping[str, Any]) -> str:
    """In words."""
    if said["status"]["code"] == "interrupted":
        return str(said["status"]["sentence"]).rstrip(".")
    at, steps = (said.get("progress", {}).get(key) for key in ("at", "steps"))
    return (
        f"it was killed, or failed, after it had reached {at:.9g} in {steps} steps"
        if at is not None
        else ("it was killed, or failed, before its first checkpoint")
    )


def about(path: Path) -> Iterator[str]:
    """Lines on a folder whose run has not finished. Raises InputError where there is no such run."""
    said = summary_of(path)
    if said is None:
        raise InputError("holds no run", "name the folder of a run", str(path))
    on = is_on(path)
    yield f"{said.get('title') or path}: " + (
        f"is running (process {said.get('pid')} on {said.get('host')})" if on else how_far(path, said)
    )
    progress = said.get("progress", {})
    if progress.get("at") is not None:
        yield f"  last checkpoint at {progress['at']:.9g}, after {progress['steps']} steps"
    for key, value in said.get("environment", {}).items():
        yield f"  {key} = {value}"
    if not on:
        yield f"  go on with: {resume_command(path, typed(said))}"


def changed(said: Mapping[str, Any]) -> list[str]:
    """What is not as it was when the run began, in words."""
    now = environment()
    return [f"{k} was {v}, is {now.get(k)}" for k, v in said.get("environment", {}).items() if now.get(k) != v]


@cache
def environment() -> dict[str, str]:
    """What the last digits of a run may depend on beside its input."""
    from llvmlite.binding import get_host_cpu_name

    found: dict[str, str] = {}
    for name in GOES_ALONG[1:]:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return {
        "python": platform.python_version(), **found, "system": platform.system(), "machine": platform.machine(),
        "cpu": str(get_host_cpu_name()),
    }  # fmt: skip
