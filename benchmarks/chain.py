"""What a step of a chain costs: one free rod of n elements, energy–momentum, through ``simulate``.

Everything a run does is counted: meshing, assembly, solution, update, loads, audit and what is kept; it is so long that
what comes before the first step does not show. Compiling is not: a short run goes first. It is CPU time, best of
several, on one core. Caches and execution units are shared with all else the machine does, so the yardstick beside it
counts as much as the nanoseconds: LAPACK solving one banded system of the same size (``scipy.linalg.solve_banded``),
what the linear algebra of one iteration alone costs elsewhere, measured in turns with it. The target is for a quiet
machine.

Below it are the phases of a step by themselves: ns per element each time they are run, best of many, and how often
that is in a step; Python and meshing come on top. Then a rod of 10⁵ elements and its memory, and two threads
against one.

    make bench        or: python benchmarks/chain.py
"""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_banded

import directrix as dx
from directrix.bench import flying_rod, least
from directrix.discretisation import discretise
from directrix.fast import fast_for
from directrix.kernels import strip_steps
from directrix.kernels import strips as kernel
from directrix.newton import Newton, Settings
from directrix.state import initial_state
from directrix.stepping import Fixed
from directrix.strips import Strips

CASES = {  # (elements, order): target, ns per element and Newton iteration
    (20, 1): 350.0, (100, 1): 200.0, (1000, 1): 150.0, (10_000, 1): 220.0, (50, 2): 880.0, (500, 2): 660.0,
}  # fmt: skip
DT, ROUNDS = 0.05, 7
PHASES = ((100, 1), (1000, 1), (10_000, 1), (500, 2))
LINE = "{:>8}  {:>5}  {:>10}  {:>14}  {:>7}  {:>13}  {:>13}"


def banded(n: int) -> Callable[[], object]:
    """LAPACK on the band of a chain: 6 (n + 1) unknowns, 11 diagonals on either side."""
    rng = np.random.default_rng(1)
    size = 6 * (n + 1)
    band = rng.standard_normal((23, size))
    band[11] += 40.0
    right = rng.standard_normal(size)
    return lambda: solve_banded((11, 11), band, right, check_finite=False)


def measure(n: int, order: int, steps: int) -> tuple[float, float, float, dx.Result]:
    """Best seconds of a run, best and typical ratio of one iteration to LAPACK's solution, and the result."""
    model, lapack = flying_rod(n, order), banded(n * order)
    dx.simulate(model, t_end=2 * DT, dt=DT)
    results: list[dx.Result] = []

    def run() -> None:
        results.append(dx.simulate(model, t_end=steps * DT, dt=DT, save_every=steps))

    times = [(least(run, 1), least(lapack, 5)) for _ in range(ROUNDS)]
    iterations = float(results[-1].iterations.sum())
    ratios = [run / iterations / solve for run, solve in times]
    return min(t for t, _ in times), min(ratios), float(np.median(ratios)), results[-1]


def chain_of(n: int, order: int = 1, threads: int = 1) -> Strips:
    """A rod of n elements in lanes, before its first step."""
    scheme = dx.EnergyMomentum().scheme(DT)
    disc = discretise(flying_rod(n, order), scheme)
    fast = fast_for(Newton(disc, scheme, Settings(threads=threads)), Fixed(DT, 0.0, 10_000), 10_000)
    assert fast is not None
    fast.strips.pack(initial_state(disc, None, scheme))
    fast.strips.set_loads(disc.external(0.0)[None])
    return fast.strips


def phases(n: int, order: int) -> dict[str, tuple[float, float]]:
    """By phase: ns per element, and how often a step runs it."""
    strips, results = chain_of(n, order), np.zeros((40, strip_steps.RESULTS))
    strips.run(results)
    iterations, tangents = (float(results[:, column].mean()) for column in (0, strip_steps.TANGENTS))
    main, team = strips.parts[0].strip, strips.team[0]
    code, g, work = strips.code, strips.g, strips.works[0]
    work.scale[0] = 0.0  # increments are not added
    each = [part.strip for part in strips.parts]
    calls: dict[str, tuple[Callable[[], object], float]] = {
        "tangent and elimination": (lambda: kernel.eliminate(code, team, main, g, work, False, False), tangents),
        "ends and back substitution": (lambda: kernel.solve(code, team, main, work, False, False), iterations),
        "update": (lambda: kernel.change(code, team, main, work.scale), iterations),
        "forces alone": (
            lambda: kernel.imbalance(code, team, main, g, work, strips.options),
            iterations - tangents + 1,
        ),
        "right-hand side through old factors": (
            lambda: kernel.eliminate(code, team, main, g, work, False, True),
            iterations - tangents,
        ),
        "books": (lambda: [strip_steps.close(code, strip, g) for strip in each], 1.0),
    }
    return {name: (1e9 * least(call, 41, time.perf_counter) / n, times) for name, (call, times) in calls.items()}


def two_threads(n: int = 10_000, steps: int = 10, rounds: int = 12) -> str:
    """A line on two threads against one, by the clock, in turns; every core that the process may use is used."""
    chains = [chain_of(n, threads=threads) for threads in (1, 2)]

    def seconds(chain: Strips) -> float:
        return least(lambda: chain.run(np.zeros((steps, strip_steps.RESULTS))), 1, time.perf_counter)

    times = np.array([[seconds(chain) for chain in chains] for _ in range(rounds)])[1:]
    ratios = np.sort(times[:, 0] / times[:, 1])
    best = times.min(axis=0)
    return (
        f"{n} elements, steps alone: two threads are {best[0] / best[1]:.2f} times as fast as one by the best of "
        f"{rounds - 1}, {np.median(ratios):.2f} by the median ({ratios[0]:.2f} … {ratios[-1]:.2f})"
    )


def long_rod(n: int = 100_000, steps: int = 20) -> str:
    """A line on a rod of so many elements."""
    model = flying_rod(n)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    result = dx.simulate(model, t_end=steps * DT, dt=DT, save_every=steps)
    spent = time.process_time() - start
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    each, memory = 1e9 * spent / n / float(result.iterations.sum()), 1024 * (most - before) / n
    return (
        f"{n} elements: {each:.0f} ns per element and iteration over {steps} steps, meshing and all; "
        f"{memory / 1000:.1f} kB an element, {most / 1024**2:.2f} GiB for the whole process"
    )


def main() -> None:
    """Print the tables; exit 1 when a run does not conserve."""
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_setaffinity") else set[int]()
    if cores:
        os.sched_setaffinity(0, {max(cores)})
    heads = (
        ("elements", "order", "iterations", "ns per element", "target", "element-steps", "of LAPACK"),
        ("", "", "a step", "and iteration", "", "a second", "best (median)"),
    )
    for head in heads:
        print(LINE.format(*head))
    good = True
    for (n, order), target in CASES.items():
        steps = max(100, 400_000 // n)
        best, ratio, typical, result = measure(n, order, steps)
        iterations = int(result.iterations.sum())
        good = good and result.success and result.audit.passed
        cells = (n, order, f"{iterations / steps:.2f}", f"{1e9 * best / iterations / n:.0f}", f"{target:.0f}")
        print(LINE.format(*cells, f"{n * steps / best:.3g}", f"{ratio:.2f} ({typical:.2f})"))
    for n, order in PHASES:
        print(f"\n{n} elements of order {order}: ns per element each time, times a step")
        parts = phases(n, order)
        for name, (each, times) in parts.items():
            print(f"  {name:<36}{each:>6.0f}  {times:.2f}")
        print(f"  {'together':<36}{sum(each * times for each, times in parts.values()):>6.0f}  a step")
    print(f"\n{long_rod()}")
    if len(cores) > 1:
        os.sched_setaffinity(0, cores)
        print(f"\n{two_threads()}")
    if not good:
        raise SystemExit("a run failed, or its audit")


if __name__ == "__main__":
    main()
