"""The suite as a whole: its cases in the order of their sections, picking some of them, running one."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase

from directrix.checks import nearest
from directrix.errors import ConvergenceError, ModelError
from directrix.verification import (
    bend45,
    branching,
    cantilevers,
    elastica,
    elbow,
    follower,
    heavy_top,
    helix,
    hinged_frame,
    objectivity,
    path_independence,
    rigid_motion,
    roll_up,
    spaghetti,
    spin_up,
    support_turns,
    unloading,
    vibration_and_buckling,
)
from directrix.verification.record import Case, Check

__all__ = ["CASES", "Outcome", "perform", "select"]

MODULES = (
    objectivity, path_independence, rigid_motion, support_turns, unloading,
    roll_up, elastica, follower, bend45, cantilevers, helix,
    hinged_frame, vibration_and_buckling, branching, elbow, spaghetti, spin_up, heavy_top,
)  # fmt: skip
_EVERY = [case for module in MODULES for case in module.CASES]
CASES: tuple[Case, ...] = tuple(sorted(_EVERY, key=lambda case: [int(n) for n in case.section.split(".")]))


@dataclass(frozen=True)
class Outcome:
    """What a case gave: its rows, the seconds it took, and why it stopped if it did."""

    case: Case
    checks: tuple[Check, ...]
    seconds: float
    failure: str = ""

    @property
    def passed(self) -> bool:
        """True when it ran to its end and no row is out of tolerance."""
        return not self.failure and all(check.passed for check in self.checks)


def select(patterns: tuple[str, ...] = (), long: bool = False) -> tuple[Case, ...]:
    """The cases that are asked for: all quick ones, or those whose name or section matches a pattern (``*``, ``?``).

    ``long`` adds the long ones; a case that is named in full is taken whatever it costs. Raises ModelError for a
    pattern that fits nothing.
    """
    if not patterns:
        return tuple(c for c in CASES if long or c.cost == "quick")
    chosen: set[str] = set()
    for pattern in patterns:
        hits = [c for c in CASES if fnmatchcase(c.name, pattern) or fnmatchcase(c.section, pattern)]
        if not hits:
            names = [c.name for c in CASES]
            raise ModelError(
                f"there is no case {pattern!r} in the suite",
                f"{nearest(pattern, names)}directrix verify --list shows them",
                "--only",
            )
        chosen |= {c.name for c in hits if long or c.cost == "quick" or c.name == pattern}
    return tuple(c for c in CASES if c.name in chosen)


def perform(case: Case) -> Outcome:
    """Run a case; one that does not converge is a failure with the sentence of its status."""
    started = time.perf_counter()
    checks: list[Check] = []
    failure = ""
    rows: Iterator[Check] = iter(case.run())
    try:
        checks.extend(rows)
    except ConvergenceError as error:
        failure = error.result.status.sentence
    except ArithmeticError as error:
        failure = f"{type(error).__name__}: {error}"
    return Outcome(case, tuple(checks), time.perf_counter() - started, failure)
