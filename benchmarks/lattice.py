"""What a general frame costs: a cubic lattice of rigid joints, four linear elements a strut, at rest under its weight.

One Newton iteration is an assembly and a sparse solution, or a right-hand side through the factors that are there; the
analysis of the pattern, done once, is printed beside them. Then whole steps, with a new tangent in every iteration and
with factors that are kept, in turns. CPU time, best of several.

    python benchmarks/lattice.py [joints along an edge, 10 unless given]
"""

from __future__ import annotations

import itertools
import resource
import sys
import time
from typing import Any

import directrix as dx
from directrix.bench import least
from directrix.curves import lines
from directrix.discretisation import discretise
from directrix.kernels import step
from directrix.linear.condensed import Condensed, usual
from directrix.newton import Newton, Settings
from directrix.scheme import Scheme
from directrix.state import initial_state
from directrix.statics import static_scheme
from directrix.threads import one_blas_thread


def lattice(edge: int, elements: int = 4) -> dx.Model:
    """edge³ joints, one apart, clamped at the bottom."""
    section = dx.Section.circle(radius=0.02, E=1e9, nu=0.3, rho=1000)
    rods: list[dict[str, Any]] = []
    for place in itertools.product(range(edge), repeat=3):
        for axis in range(3):
            other = tuple(v + (k == axis) for k, v in enumerate(place))
            if max(other) < edge:
                ends = ("{}.{}.{}".format(*place), "{}.{}.{}".format(*other))
                rods.append({"line": (place, other), "name": "-".join(ends), "ends": ends})
    curves = lines(*zip(*(rod.pop("line") for rod in rods), strict=True))
    model = dx.Model(name=f"lattice {edge}").add_rods(
        {**rod, "curve": curve, "section": section, "elements": elements, "order": 1}
        for rod, curve in zip(rods, curves, strict=True)
    )
    for place in itertools.product(range(edge), repeat=2):
        model = model.clamp("{}.{}.0".format(*place))
    return model.gravity((0, 0, -9.81))


class Run:
    """Steps of one lattice: what they cost."""

    def __init__(self, model: dx.Model, scheme: Scheme, reuse: bool) -> None:
        self.disc = discretise(model, scheme)
        self.newton, self.x = Newton(self.disc, scheme, Settings(reuse=reuse)), initial_state(self.disc, None, scheme)
        self.seconds, self.iterations, self.tangents = list[float](), 0, 0
        sparse, solve = self.newton.sparse, self.newton.sparse.solve

        def counted(*given: Any) -> Any:
            self.tangents += 1
            return solve(*given)

        sparse.solve = counted

    def step(self, factor: float) -> None:
        clock = time.process_time()
        self.newton.begin(self.x)
        outcome = self.newton.solve(self.x, self.disc.external(0.0, factor))
        if outcome.status is not None:
            raise RuntimeError(outcome.status.sentence)
        self.newton.finish(self.x)
        self.seconds.append(time.process_time() - clock)
        self.iterations += outcome.iterations


def steps(model: dx.Model, what: str, scheme: Scheme, factors: list[float]) -> None:
    """Print a line on steps at load factors."""
    runs = [Run(model, scheme, reuse) for reuse in (False, True)]
    for factor in factors:
        for run in runs:
            run.step(factor)
    gone = float(abs(runs[0].x[:, :3] - runs[1].x[:, :3]).max())
    print(f"{what}: {len(factors)} steps; positions are the same to {gone:.0e}")
    for run, name in zip(runs, ("new tangents", "kept factors"), strict=True):
        n = len(factors)
        print(
            f"  {name}: {sum(run.seconds) / n:.3f} s a step (least {min(run.seconds):.3f}), "
            f"{run.iterations / n:.1f} iterations, {run.tangents / n:.1f} factorizations"
        )


def main(edge: int = 10) -> None:
    """Print some lines."""
    clock = time.process_time()
    model = lattice(edge)
    described, clock = time.process_time() - clock, time.process_time()
    scheme = dx.EnergyMomentum().scheme(0.01)
    disc = discretise(model, scheme)
    meshed, clock = time.process_time() - clock, time.process_time()
    newton, x = Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)
    external = disc.external(0.0)
    step.assemble(newton.tables, newton.work, x, newton.globals, external, newton.mask, False)
    clock = time.process_time()
    analysed = newton.sparse
    order = time.process_time() - clock
    assembled = least(
        lambda: step.assemble(newton.tables, newton.work, x, newton.globals, external, newton.mask, False), 3
    )
    solved = least(lambda: analysed.solve(newton.work.blocks, newton.work.rhs), 3)
    print(f"{edge}³ joints, {disc.elements} elements, {6 * len(newton.work.rhs)} unknowns")
    print(f"once: describe {described:.2f} s, mesh {meshed:.2f} s, analyse {order:.2f} s")
    through = least(lambda: analysed.again(newton.work.rhs), 3)
    print(f"an iteration: assemble {assembled:.3f} s, solve {solved:.3f} s, together {assembled + solved:.3f} s")
    print(f"a right-hand side through factors: {through:.3f} s")
    two = Condensed(disc.pattern.rowptr, disc.pattern.column, usual(2))
    ratios: list[float] = []
    for _ in range(5):  # wall time, in turns: two threads need two free cores
        one_s, two_s = (
            least(lambda s=s: s.solve(newton.work.blocks, newton.work.rhs), 1, time.perf_counter)
            for s in (analysed, two)
        )
        ratios.append(one_s / two_s)
    print(f"two threads: {max(ratios):.2f} times as fast at best, {sorted(ratios)[2]:.2f} in the middle")
    steps(model, "motion, Δt = 2 ms", dx.EnergyMomentum().scheme(0.002), [1.0] * 12)
    steps(model, "motion, Δt = 20 ms", dx.EnergyMomentum().scheme(0.02), [1.0] * 8)
    steps(model, "load steps", static_scheme(model, None), [0.5, 1.0])
    print(f"memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB at most")


if __name__ == "__main__":
    with one_blas_thread():  # as in a run: what BLAS does on other threads counts as CPU time
        main(*(int(word) for word in sys.argv[1:2]))
