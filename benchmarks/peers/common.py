"""The cases every peer runs, in numbers, and how a run is timed and printed.

    python peer_NAME.py CASE N DT VARIANT

prints one line of JSON (``Run``). Time is CPU time of the process inside the solver's own run;
building the model, import and compiling (a short run goes first where there is any) are not in it.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Rod:
    """What a rod is made of, per length: stiffness and inertia; the section is round."""

    EA: float
    GA: float
    EI: float
    GJ: float
    mass: float  # per length
    inertia: float  # ∫ρ ξ² dA, twice that about the axis


def round_rod(radius: float, E: float, nu: float, rho: float) -> Rod:
    """Section of the swing: Cowper's factor 6 (1 + ν) / (7 + 6 ν), as directrix takes it."""
    area, second, G = math.pi * radius**2, math.pi * radius**4 / 4, E / (2 * (1 + nu))
    factor = 6 * (1 + nu) / (7 + 6 * nu)
    return Rod(E * area, factor * G * area, E * second, G * 2 * second, rho * area, rho * second)


RADIUS, YOUNG, POISSON, DENSITY, GRAVITY = 0.01, 5e6, 0.5, 1100.0, 9.81
SWING = round_rod(RADIUS, YOUNG, POISSON, DENSITY)
SWING_TIP: Vector = (-0.91585, 0.0, 0.10739)  # at t = 1: directrix, 40 quadratic elements, Δt = 2.5e-4; ± 2e-5
FLIGHT = Rod(EA=2500.0, GA=2500.0 / 2.6, EI=10.0, GJ=20.0 / 2.6, mass=2.5, inertia=0.01)
FLIGHT_LEGS: tuple[tuple[Vector, Vector], ...] = (
    ((0, 3, 0), (0, 0, 0)),
    ((0, 0, 0), (3, 0, 0)),
    ((3, 0, 0), (3, 0, 3)),
)
FLIGHT_VELOCITY: dict[Vector, Vector] = {(0, 3, 0): (0, 0, -1), (3, 0, 0): (0, 0, 2), (3, 0, 3): (0, -1, 0)}
FLIGHT_ENERGY, FLIGHT_END = 2.5, 30.0
SPAGHETTI = Rod(EA=1e4, GA=1e4, EI=500.0, GJ=500.0, mass=1.0, inertia=10.0)
LOADED: Vector = (6.0, 0.0, 0.0)
OTHER: Vector = (0.0, 0.0, 8.0)
RELEASE, SPAGHETTI_END = 5.0, 10.0


def hat(t: float) -> float:
    """The load of the spaghetti: up to 200 at 2.5, down to nothing at 5."""
    return 80.0 * t if t <= 2.5 else max(80.0 * (RELEASE - t), 0.0)


@dataclass
class Run:
    """What one run says of itself."""

    completed: bool = False
    tip: list[float] | None = None  # of the free, of the loaded end
    energy: float | None = None  # at the end
    drift: float | None = None  # swing: of the work gravity did; flight: of 2.5; spaghetti: from t = 5 to 10
    reached: float | None = None  # t
    dt: float | None = None  # where it is not what was asked for
    cpu: float = 0.0  # seconds
    note: str = ""


@dataclass
class Clock:
    """CPU seconds of what runs under it."""

    cpu: float = field(default=0.0)

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        start = time.process_time()
        try:
            yield
        finally:
            self.cpu += time.process_time() - start


def quietly() -> int:
    """Everything the libraries print goes to stderr; the answer goes to the descriptor returned."""
    sys.stdout.flush()
    answer = os.dup(1)
    os.dup2(2, 1)
    return answer


def main(peer: str, version: str, solve: Callable[[str, int, float, str, Clock], Run]) -> None:
    case, n, dt, variant = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
    answer, clock = quietly(), Clock()
    try:
        run = solve(case, n, dt, variant, clock)
    except Exception as error:  # a peer that fails says so in the table
        traceback.print_exc()
        run = Run(note=f"{type(error).__name__}: {error}"[:200])
    run.cpu = clock.cpu
    line = {"peer": peer, "version": version, "variant": variant, "case": case, "n": n, **asdict(run)}
    line["dt"] = run.dt or dt
    os.write(answer, (json.dumps(line) + "\n").encode())
    os._exit(0)  # some peers crash while they are taken down
