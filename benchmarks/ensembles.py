"""What an ensemble gains: rods of 50 elements, 200 steps each, one after the other and side by side in the lanes.

Every member swings from a pin, each of another thickness. The members are run in chunks, in turns: by
``dx.simulate`` one at a time, then by ``dx.ensemble``, everything counted but the description of the models: meshing,
steps, audit, results, with every step saved and with the last alone. The ratio of a chunk compares runs that are
seconds apart, so other work on the machine hits both; the median of the ratios is what counts. Below it are the steps
by themselves: ns per element and Newton iteration in the compiled loop, one rod in all lanes against bundles.

CPU time on one core. Compiling is not counted: a short run goes first.

    python benchmarks/ensembles.py [--members 1000] [--elements 50] [--steps 200]
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator

import numpy as np

import directrix as dx
from directrix.bench import least
from directrix.bundle import Bundle, fit_of
from directrix.fast import fast_for
from directrix.kernels.compile import LANES
from directrix.kernels.strip_steps import RESULTS
from directrix.motion import Asked, Motion
from directrix.stepping import Fixed

DT, CHUNK, ROUNDS = 0.005, 40, 15


def rod(k: int, elements: int) -> dx.Model:
    """A rubber rod that swings, thicker with ``k``."""
    section = dx.Section.circle(radius=0.01 * (1.0 + 1e-4 * k), E=5e6, nu=0.5, rho=1100)
    model = dx.Model(name=f"rod {k}").rod(
        dx.line((0, 0, 0), (1, 0, 0)), section, ends=("pin", "tip"), elements=elements
    )
    return model.pin("pin").gravity((0, 0, -9.81))


def spent(work: Callable[[], bool]) -> float:
    """CPU seconds of work that has to succeed."""
    start = time.process_time()
    if not work():
        raise SystemExit("a run failed, or its audit")
    return time.process_time() - start


def chunks(members: int, elements: int) -> Iterator[list[dx.Model]]:
    """The models, some at a time."""
    for first in range(0, members, CHUNK):
        yield [rod(k, elements) for k in range(first, min(first + CHUNK, members))]


def whole(members: int, elements: int, steps: int, save_every: int) -> str:
    """A line: ms a member one by one and side by side, and the ratio."""
    options = {"t_end": steps * DT, "dt": DT, "save_every": save_every}

    def one_by_one(models: list[dx.Model]) -> bool:
        return all(run.success and run.audit.passed for run in (dx.simulate(model, **options) for model in models))

    def side_by_side(models: list[dx.Model]) -> bool:
        runs = dx.ensemble(models, **options)
        return runs.success and all(run is not None and run.audit.passed for run in runs.results)

    times = np.array(
        [
            (spent(lambda: one_by_one(models)), spent(lambda: side_by_side(models)))  # noqa: B023
            for models in chunks(members, elements)
        ]
    )
    ratios, (alone, together) = times[:, 0] / times[:, 1], 1e3 * times.sum(axis=0) / members
    saved = "every step saved" if save_every == 1 else "last step saved"
    return (
        f"{members} members, {saved}: {alone:.1f} ms each one by one, {together:.1f} ms side by side "
        f"({1e3 / alone:.0f} and {1e3 / together:.0f} members/s), ratio {np.median(ratios):.2f} "
        f"({ratios.min():.2f} … {ratios.max():.2f})"
    )


def steps_alone(elements: int, steps: int) -> str:
    """A line: ns per element and iteration of the compiled loops, taken in turns, best of several."""
    asked = Asked(t_end=steps * DT, dt=DT, save_every=steps)

    def one() -> tuple[float, float]:
        motion = Motion(rod(0, elements), asked)
        assert isinstance(motion.pace, Fixed)
        fast = fast_for(motion.newton, motion.pace, steps)
        assert fast is not None
        fast.strips.pack(motion.x)
        fast.strips.set_loads(motion.standing)
        results = np.zeros((min(steps, fast.strips.many), RESULTS))
        return least(lambda: fast.strips.run(results), 1), float(results[:, 0].sum())

    def many(members: int) -> tuple[float, float]:
        spent, iterations = 0.0, 0.0
        for first in range(0, members, LANES):
            fits = [fit_of(Motion(rod(k, elements), asked)) for k in range(first, min(first + LANES, members))]
            bundle = Bundle([fit for fit in fits if fit is not None])
            results = np.zeros((min(steps, bundle.many), LANES, RESULTS))
            spent += least(lambda: bundle.run(results, 0), 1)  # noqa: B023
            iterations += float(results[:, : len(fits), 0].sum())
        return spent, iterations

    ways = {"one rod in all lanes": one, f"a bundle of {LANES}": lambda: many(LANES)}
    if LANES != 8:
        ways["8 members"] = lambda: many(8)
    best = dict.fromkeys(ways, np.inf)
    for _ in range(ROUNDS):
        for name, way in ways.items():
            seconds, iterations = way()
            best[name] = min(best[name], 1e9 * seconds / iterations / elements)
    return "steps alone, ns per element and iteration: " + ", ".join(f"{name} {ns:.0f}" for name, ns in best.items())


def main() -> None:
    """Print the lines."""
    read = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in (("members", 1000), ("elements", 50), ("steps", 200)):
        read.add_argument(f"--{name}", type=int, default=value)
    given = read.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    whole(LANES, given.elements, 2, 1)
    print(f"{given.elements} elements, {given.steps} steps, {LANES} lanes")
    for save_every in (1, given.steps):
        print(whole(given.members, given.elements, given.steps, save_every))
    print(steps_alone(given.elements, given.steps))


if __name__ == "__main__":
    main()
