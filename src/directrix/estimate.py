"""What a run is likely to cost, from a rule that is stated: no timing, nothing is run.

An iteration takes 0.3 ms and, for every element, ``order`` times 4 µs in a chain and 25 µs in a frame; twice that in
statics, where paths look at the stability of what they find. A step of dynamics takes 3 iterations, one of statics 5.
The constants are those of one core of a common processor. Contacts, cuts and hard steps are not in it, so it is good to
a factor of about three. What is kept is a state of 40 numbers a node and 12 a station.
"""

from __future__ import annotations

from dataclasses import dataclass

from directrix.discretisation import Discretisation

__all__ = ["Cost", "cost"]

BASE, CHAIN, FRAME = 3e-4, 4e-6, 25e-6  # seconds
ITERATIONS = {"dynamics": 3, "statics": 5}
PROGRAM = 250e6  # bytes of the program itself
FIRST = 10  # seconds that compilers take the first time


@dataclass(frozen=True)
class Cost:
    """Seconds and bytes of a run."""

    seconds: float
    memory: float
    kept: float

    def __str__(self) -> str:
        return (
            f"estimated cost: about {_time(self.seconds)} on one core (within a factor of three; the first run "
            f"compiles, some {FIRST} s), {_size(self.memory)} of memory, {_size(self.kept)} of results"
        )


def cost(disc: Discretisation, steps: int, kept: int, *, static: bool) -> Cost:
    """Of ``steps`` steps, of which ``kept`` are kept."""
    orders = [rod.order for rod in disc.mesh.rods]
    order = max(orders, default=1)
    each = (CHAIN if disc.pattern.chain else FRAME) * order * max(disc.elements, 1)
    seconds = steps * ITERATIONS["statics" if static else "dynamics"] * (BASE + each) * (2.0 if static else 1.0)
    stations = sum(len(rod.stations) for rod in disc.mesh.rods)
    results = 8.0 * kept * (40 * disc.nodes + 12 * stations)
    matrix = 0.0 if disc.pattern.chain else 3.0 * 12.0 * disc.elements * (6 * (order + 1)) ** 2
    return Cost(seconds, PROGRAM + 2.0 * results + matrix, results)


def _time(seconds: float) -> str:
    for size, unit in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.1g} s" if seconds < 10.0 else f"{seconds:.0f} s"


def _size(count: float) -> str:
    for size, unit in ((1e9, "GB"), (1e6, "MB")):
        if count >= size:
            return f"{count / size:.2g} {unit}" if count < 100.0 * size else f"{count / size:.0f} {unit}"
    return f"{count / 1e3:.0f} kB"
