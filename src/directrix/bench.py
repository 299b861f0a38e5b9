"""How fast this machine takes steps: what ``directrix bench`` prints."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

from directrix.curves import line
from directrix.dynamics import simulate
from directrix.model import Model
from directrix.result import Result
from directrix.section import Section

__all__ = ["Speed", "flying_rod", "least", "measured"]

DT = 0.05
WORK = 20_000  # elements times steps of a run
ROUNDS = 3


class Speed(NamedTuple):
    """Of a rod of so many ``elements``: CPU time [s] of a step of an element, of an iteration of one, and whether the
    run kept what it claims."""

    elements: int
    step: float
    iteration: float
    good: bool


def flying_rod(n: int, order: int = 1) -> Model:
    """A free rod of n elements that bends, twists and turns."""
    section = Section.from_moduli(
        EA=2500, GA1=961.5, GA2=961.5, EI1=10, EI2=10, GJ=7.7, A_rho=2.5, I_rho1=0.01, I_rho2=0.01
    )
    return (
        Model(name=f"{n} elements")
        .rod(line((0, 0, 0), (0.2 * n, 0, 0)), section, name="rod", ends=("A", "B"), elements=n, order=order)
        .velocity("A", (0, 0, -1))
        .velocity("B", (0, 0.5, 1))
        .rigid_velocity((0, 0, 0.1), (0, 0.02, 0), about=(0, 0, 0))
    )


def least(call: Callable[[], object], rounds: int, clock: Callable[[], float] = time.process_time) -> float:
    """Least seconds of a call. CPU time unless said otherwise: other work on the machine is not counted, though it
    takes caches away."""
    times: list[float] = []
    for _ in range(rounds):
        start = clock()
        call()
        times.append(clock() - start)
    return min(times)


def measured(sizes: tuple[int, ...] = (20, 100, 1000)) -> Iterator[Speed]:
    """All of ``simulate`` for rods of linear elements, compiling not counted."""
    for n in sizes:
        model, steps = flying_rod(n), max(4, WORK // n)
        simulate(model, t_end=2 * DT, dt=DT)
        results: list[Result] = []

        def run(model: Model = model, steps: int = steps, results: list[Result] = results) -> None:
            results.append(simulate(model, t_end=steps * DT, dt=DT, save_every=steps))

        seconds = least(run, ROUNDS) / n
        last = results[-1]
        yield Speed(n, seconds / steps, seconds / int(last.iterations.sum()), last.success and last.audit.passed)
