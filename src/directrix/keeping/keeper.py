"""What a loop calls so that its run can be gone on with: it decides when, the loop says what."""

from __future__ import annotations

import hashlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from types import FrameType
from typing import TYPE_CHECKING, Any

import numpy as np

from directrix.errors import InputError, ModelError
from directrix.keeping.folder import Folder, RunFolder, typed
from directrix.keeping.packing import pack
from directrix.keeping.store import resume_command
from directrix.result import Status

if TYPE_CHECKING:
    from directrix.discretisation import Discretisation
    from directrix.recorder import Recorder
    from directrix.result import Result
    from directrix.scheme import Scheme

__all__ = ["Keeper", "fingerprint"]

LARGE = 32_000_000  # bytes of rows that wait in memory for a checkpoint
COST = 50  # a checkpoint may take one part in so many of the time
NEVER = 10**9


class Keeper:
    """Watches one run. Without a folder it keeps nothing, and only ends the run when it is asked to."""

    def __init__(
        self, folder: Folder | RunFolder | str | os.PathLike[str] | None, recorder: Recorder, print_: str
    ) -> None:
        self.recorder, self.print = recorder, print_
        self.stopping = 0  # the signal that asked the run to end
        self.serial = self.sealed = 0
        self.last, self.at, self.pause = time.monotonic(), -1, 0.0
        self.memory: dict[str, Any] | None = None
        self.same = True  # what is asked for now is what the run in the folder was begun with
        self.refused: InputError | None = None
        self.checkpoint: dict[str, Any] = {"done": False}
        self.handlers: dict[signal.Signals, Any] = {}
        if folder is None:
            self.folder, self.options = None, Folder(".")
            return
        if isinstance(folder, RunFolder):
            self.folder, self.options = folder, folder.options
        else:
            self.options = folder if isinstance(folder, Folder) else Folder(folder)
            self.folder = RunFolder.claim(self.options)
        try:
            self._begin(self.folder)
        except BaseException:
            self.folder.close()
            raise

    def _begin(self, folder: RunFolder) -> None:
        found = folder.store.newest() if self.options.resume else None
        folder.kind = self.recorder.kind
        if found is None:
            folder.store.clear()  # of an earlier run, before anything says that this one is on
            folder.begin(self.print)
            folder.store.make()
            return
        self.same = found["fingerprint"] == self.print
        if not self.same and not self.options.force:
            raise InputError(
                "holds a run of another model, or with other arguments",
                "go on with the same ones, or use force to go on all the same",
                str(folder.path),
            )
        self.serial, self.sealed = found["serial"], found["segments"]
        self.memory = found["memory"]
        folder.store.forget(self.sealed)
        if found["in_result"]:
            self.recorder.go_on([])
            self.recorder.adopt(folder.result(), found["rows"], found["steps"])
        else:
            self.recorder.go_on(folder.store.segments(self.sealed))
        folder.resumed(found["at"], self.sealed)

    def due(self, steps: int) -> bool:
        """True when a checkpoint is to be made now, ``steps`` having been taken."""
        if self.folder is None:
            return False
        if self.stopping or self.recorder.size > LARGE:
            return True
        if self.options.steps is not None and steps % self.options.steps == 0 and steps != self.at:
            return steps > 0
        return time.monotonic() - self.last > max(self.options.seconds, self.pause)

    def room(self, steps: int) -> int:
        """Steps that may be taken before the next checkpoint that is due by their number."""
        every = self.options.steps
        return NEVER if every is None or self.folder is None else every - steps % every

    def keep(self, steps: int, t: float, memory: Callable[[], Mapping[str, Any]], *, done: bool = False) -> None:
        """Seal what was recorded and make a checkpoint of what ``memory`` then gives. Raises InputError when that
        cannot be written."""
        if self.folder is None:
            return
        try:
            self._keep(self.folder, steps, t, memory(), done)
        except InputError as error:
            self.refused = error
            raise

    def _keep(self, folder: RunFolder, steps: int, t: float, memory: Mapping[str, Any], done: bool) -> None:
        began, store, rows = time.monotonic(), folder.store, self.recorder.take()
        if rows["rows"] or len(rows["iterations"]):
            store.seal(self.sealed, rows)
            self.sealed += 1
            self.recorder.forget()
        self.serial += 1
        self.checkpoint = {
            "fingerprint": self.print, "segments": self.sealed, "in_result": False, "rows": self.recorder.count,
            "steps": len(self.recorder.iterations), "at": t, "done": done, "memory": memory,
        }  # fmt: skip
        store.keep(self.serial, self.checkpoint)
        folder.checkpointed(rows, steps, t)
        self.at, self.last = steps, time.monotonic()
        self.pause = COST * (self.last - began)

    def earlier(self) -> Iterable[dict[str, Any]]:
        """What was sealed, for the result."""
        return () if self.folder is None else self.folder.store.segments(self.sealed)

    def finish(self, result: Result) -> Result:
        """Write the result, which is returned; the parts that are in it are not needed any more. Raises InputError.
        A signal that came in the last step ended nothing, and is sent again for what would follow the run."""
        folder = self.folder
        if folder is None:
            return result
        try:
            if self.refused is not None:
                status = Status(
                    "interrupted", f"interrupted: {self.refused.where} {self.refused.what}.", self.refused.fix
                )
                result = replace(result, status=status)
            folder.write(result)
            if result.success and self.sealed and self.checkpoint["done"]:
                with suppress(InputError):  # then there is a segment too many, and nothing is lost
                    for _ in range(2):
                        self.serial += 1
                        folder.store.keep(self.serial, {**self.checkpoint, "segments": 0, "in_result": True})
                    folder.store.forget(0)
        finally:
            folder.close()
        if self.stopping and result.status.code != "interrupted" and not folder.command:
            signal.raise_signal(self.stopping)
        return result

    def interrupted(self, at: str) -> Status:
        """How a run ends that was asked to."""
        where = "start=" if (folder := self.folder) is None else resume_command(folder.path, typed(folder.said))
        return Status("interrupted", f"interrupted at {at}.", f"Go on with {where}.")

    def attend(self, go: Callable[[], Status], where: Callable[[], str]) -> Status:
        """Let a loop go until it ends, or is broken off ``where`` it is then: how it ended."""
        try:
            self.listen()
            return go()
        except KeyboardInterrupt:
            return self.interrupted(where())
        except ModelError as error:  # a user's function that fails on the way: keep what there is
            return Status("bad_input", f"stopped at {where()}: {error.what}.", f"{error.fix}.")
        finally:
            self.hush()

    def listen(self) -> None:
        """From here on the first SIGINT or SIGTERM asks the run to end after its step, the second ends it at once."""
        if self.folder is None or threading.current_thread() is not threading.main_thread():
            return
        self.handlers = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}
        for s in self.handlers:
            signal.signal(s, self._ask)

    def hush(self) -> None:
        """Signals are what they were before."""
        for s, handler in self.handlers.items():
            signal.signal(s, handler)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        self.stopping = number
        hard = self.folder is not None and self.folder.command
        for s, handler in self.handlers.items():
            signal.signal(s, signal.SIG_DFL if hard else handler)


def _loads(disc: Discretisation, t: float) -> object:
    """At a time; what a function says that has none then, which ends the run when it gets there."""
    try:
        return disc.external(t, 1.0)
    except ModelError as error:
        return error.what


def fingerprint(disc: Discretisation, scheme: Scheme, settings: Mapping[str, Any], times: tuple[float, ...]) -> str:
    """A number that is the same for the same system of equations: what the loops read, loads at some ``times``."""
    asked: dict[str, Any] = {name: v if isinstance(v, np.ndarray) else repr(v) for name, v in settings.items()}
    said: dict[str, Any] = {
        "scheme": repr(scheme), "settings": asked,
        "groups": [[repr(g.element), repr(g.layout), list(g.names), g.conn, g.parameters] for g in disc.groups],
        "r0": disc.mesh.r0, "fixed": disc.fixed.astype(int), "joints": list(disc.mesh.joints),
        "loads": [_loads(disc, t) for t in times], "mass": disc.lumped if scheme.lumped else None,
    }  # fmt: skip
    return hashlib.sha256(pack(said)).hexdigest()
