"""What a step of a chain costs: one free rod of n elements, energy–momentum, through ``simulate``.

Everything a run does is counted: meshing, assembly, solution, update, loads, audit and what is kept. Compiling is not:
a short run goes first. It is CPU time, best of several, on one core. Caches and execution units are shared with all
else the machine does, so the yardstick beside it counts as much as the nanoseconds: LAPACK solving one banded system of
the same size (``scipy.linalg.solve_banded``), what the linear algebra of one iteration alone costs elsewhere, measured
in turns with it. The target is for a quiet machine.

    make bench        or: python benchmarks/chain.py
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_banded

import directrix as dx

CASES = {  # (elements, order): target, ns per element and Newton iteration
    (20, 1): 350.0, (100, 1): 200.0, (1000, 1): 150.0, (10_000, 1): 220.0, (50, 2): 880.0, (500, 2): 660.0,
}  # fmt: skip
DT, ROUNDS = 0.05, 7
LINE = "{:>8}  {:>5}  {:>10}  {:>14}  {:>7}  {:>13}  {:>13}"


def rod(n: int, order: int = 1) -> dx.Model:
    """A flying rod that bends, twists and turns."""
    section = dx.Section.from_moduli(
        EA=2500, GA1=961.5, GA2=961.5, EI1=10, EI2=10, GJ=7.7, A_rho=2.5, I_rho1=0.01, I_rho2=0.01
    )
    axis = dx.line((0, 0, 0), (0.2 * n, 0, 0))
    return (
        dx.Model(name=f"{n} elements")
        .rod(axis, section, name="rod", ends=("A", "B"), elements=n, order=order)
        .velocity("A", (0, 0, -1))
        .velocity("B", (0, 0.5, 1))
        .rigid_velocity((0, 0, 0.1), (0, 0.02, 0), about=(0, 0, 0))
    )


def banded(n: int) -> Callable[[], object]:
    """LAPACK on the band of a chain: 6 (n + 1) unknowns, 11 diagonals on either side."""
    rng = np.random.default_rng(1)
    size = 6 * (n + 1)
    band = rng.standard_normal((23, size))
    band[11] += 40.0
    right = rng.standard_normal(size)
    return lambda: solve_banded((11, 11), band, right, check_finite=False)


def seconds(call: Callable[[], object]) -> float:
    """CPU time of one call: other work on the machine is not counted."""
    start = time.process_time()
    call()
    return time.process_time() - start


def measure(n: int, order: int, steps: int) -> tuple[float, float, float, dx.Result]:
    """Best seconds of a run, best and typical ratio of one iteration to LAPACK's solution, and the result."""
    model, lapack = rod(n, order), banded(n * order)
    dx.simulate(model, t_end=2 * DT, dt=DT)
    results: list[dx.Result] = []

    def run() -> None:
        results.append(dx.simulate(model, t_end=steps * DT, dt=DT, save_every=steps))

    times = [(seconds(run), min(seconds(lapack) for _ in range(5))) for _ in range(ROUNDS)]
    iterations = float(results[-1].iterations.sum())
    ratios = [run / iterations / solve for run, solve in times]
    return min(t for t, _ in times), min(ratios), float(np.median(ratios)), results[-1]


def main() -> None:
    """Print the table; exit 1 when a run does not conserve."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    heads = (
        ("elements", "order", "iterations", "ns per element", "target", "element-steps", "of LAPACK"),
        ("", "", "a step", "and iteration", "", "a second", "best (median)"),
    )
    for head in heads:
        print(LINE.format(*head))
    good = True
    for (n, order), target in CASES.items():
        steps = max(4, 40_000 // n)
        best, ratio, typical, result = measure(n, order, steps)
        iterations = int(result.iterations.sum())
        good = good and result.success and result.audit.passed
        cells = (n, order, f"{iterations / steps:.2f}", f"{1e9 * best / iterations / n:.0f}", f"{target:.0f}")
        print(LINE.format(*cells, f"{n * steps / best:.3g}", f"{ratio:.2f} ({typical:.2f})"))
    if not good:
        raise SystemExit("a run failed, or its audit")


if __name__ == "__main__":
    main()
