"""What is known of every step of a run."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.trail import Trail

Array = NDArray[np.float64]

__all__ = ["Log"]


class Log:
    """The steps of a run, in little memory however many: iterations, lengths, cuts before each, and how
    the iterations of the last went."""

    def __init__(self) -> None:
        self.iterations = array("i")
        self.lengths, self.counts = array("d"), array("q")  # run lengths
        self.cut: dict[int, int] = {}
        self.rejected = self.failed = self.waiting = 0
        self.trail = Trail()

    def tried(self, trail: Array, *, solved: bool) -> None:
        """Book the iterations of a step of statics, whether it was taken or not."""
        self.trail.tried(len(self.iterations), solved, trail)
        self.iterations.append(len(trail))

    def took(self, dt: float, iterations: list[int], trail: Array) -> None:
        """Book steps of one length, after the cuts since the last one: of one step with its trail, of many with their
        moves (steps, room, 2)."""
        if not iterations:
            return
        if trail.ndim == 3:
            self.trail.took(len(self.iterations), iterations, trail)
        else:
            self.trail.tried(len(self.iterations), True, trail)
        if self.waiting:
            self.cut[len(self.iterations)] = self.waiting
            self.waiting = 0
        self.iterations.extend(iterations)
        if self.lengths and self.lengths[-1] == dt:
            self.counts[-1] += len(iterations)
        else:
            self.lengths.append(dt)
            self.counts.append(len(iterations))

    def threw(self, trail: Array, *, rejected: bool) -> None:
        """Book a step that was thrown away: its error was too large, or it could not be solved."""
        self.trail.tried(len(self.iterations), rejected, trail)
        self.waiting += 1
        self.rejected += rejected
        self.failed += not rejected

    def remember(self) -> dict[str, Any]:
        """All but the iterations."""
        more = {"lengths": list(self.lengths), "counts": list(self.counts), "cut": list(self.cut.items())}
        counts = {"rejected": self.rejected, "failed": self.failed, "waiting": self.waiting}
        return {**more, **counts, "trail": self.trail.remember()}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        self.lengths, self.counts = array("d", memory["lengths"]), array("q", memory["counts"])
        self.cut = {int(k): int(count) for k, count in memory["cut"]}
        self.rejected, self.failed, self.waiting = (int(memory[k]) for k in ("rejected", "failed", "waiting"))
        self.trail.recall(memory["trail"])

    def arrays(self) -> tuple[Array, NDArray[np.int64]]:
        """Length of every step of a motion (steps,), and how many were thrown away before it."""
        dt = np.repeat(np.array(self.lengths), np.array(self.counts, np.int64))
        cuts = np.zeros(len(dt), np.int64)
        for k, count in self.cut.items():
            cuts[k] = count
        return dt, cuts
