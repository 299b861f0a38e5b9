"""The line that a run says of itself after a step, and how long it still takes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

Told = TypeVar("Told", bound=Callable[[float, str], None])

__all__ = ["every_step", "line", "now_and_then", "time_left"]


def now_and_then(progress: Told) -> Told:
    """Mark a ``progress`` that need not be called after every step: the steps of some 50 ms may be taken at once."""
    setattr(progress, "every_step", False)  # noqa: B010
    return progress


def every_step(progress: object) -> bool:
    """Whether a run has to call its ``progress`` after every step: what users give, but nothing of our own."""
    return progress is not None and progress is not True and getattr(progress, "every_step", True)


def line(
    clock: str, at: float, iterations: Sequence[int], *, cuts: int = 0, energy: float | None = None, error: float = 0.0
) -> str:
    """Where a run is: time or load factor, steps and the iterations of the last, cuts, how far the ledger of
    its energy is from closing, relative to what was turned over, and the energy."""
    parts = [f"{clock} {at:.6g}", f"step {len(iterations)}", f"{iterations[-1] if iterations else 0} iterations"]
    if cuts:
        parts.append(f"{cuts} cut{'s' * (cuts > 1)}")
    if energy is not None:
        parts += [f"energy error {error:.0e}", f"H = {energy:.6g}"]
    return ", ".join(parts)


def time_left(done: float, elapsed: float) -> str:
    """Of a run that has done a share in some seconds, if the rest goes on like that."""
    if not 0.0 < done < 1.0:
        return ""
    seconds = elapsed * (1.0 - done) / done
    if seconds < 90.0:
        return f"{seconds:.0f} s left"
    minutes = round(seconds / 60.0)
    return f"{minutes} min left" if minutes < 90 else f"{minutes // 60} h {minutes % 60:02d} min left"
