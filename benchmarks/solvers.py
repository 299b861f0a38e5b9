"""What solvers of frames take: SciPy alone and the packages that are installed, one thread and two.

Two cubic lattices of 10³ and 6³ places: struts of four elements that meet in joints as stiff as themselves, and struts
of two elements, one of which at every place the others turn on, in hinges. Seconds, best of several
in turns: the analysis of the pattern with the first solution, and solutions with new numbers.

    python benchmarks/solvers.py [places along an edge, 10 and 6 unless given]
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from lattice import lattice

import directrix as dx
from directrix.discretisation import discretise
from directrix.kernels import step
from directrix.linear.choice import chosen
from directrix.linear.condensed import Condensed, usual
from directrix.linear.sparse import BlockSparse
from directrix.newton import Newton, Settings
from directrix.state import initial_state
from directrix.threads import one_blas_thread

TURNS = 7


def hinged(edge: int) -> dx.Model:
    """edge³ places, one apart, at each of which rods turn on the first that comes there; clamped at the bottom."""
    section = dx.Section.circle(radius=0.02, E=1e9, nu=0.3, rho=1000)
    model, there = dx.Model(name=f"hinged {edge}"), dict[str, str]()
    for place in itertools.product(range(edge), repeat=3):
        for axis in range(3):
            other = tuple(v + (k == axis) for k, v in enumerate(place))
            if max(other) == edge:
                continue
            at = ["{}.{}.{}".format(*one) for one in (place, other)]
            ends = tuple(f"{one}{side}{axis}" for one, side in zip(at, "+-", strict=True))
            model = model.rod(dx.line(place, other), section, name="-".join(at), ends=ends, elements=2, order=1)
            for one, end in zip(at, ends, strict=True):
                if there.setdefault(one, end) != end:
                    model = model.hinge(there[one], end, axis=np.eye(3)[(axis + 1) % 3])
    for place, end in there.items():
        if place.endswith(".0"):
            model = model.clamp(end)
    return model.gravity((0, 0, -9.81))


def solvers() -> dict[str, Callable[[Any, Any], Any]]:
    """By name, what makes a solver for a pattern."""
    out: dict[str, Callable[[Any, Any], Any]] = {}
    for threads in (1, 2):
        out[f"SciPy, {threads}"] = lambda ptr, column, n=threads: Condensed(ptr, column, usual(n))
    for name in ("rslab", "pardiso"):
        try:
            found = chosen(name)
        except dx.ModelError as missing:
            print(missing)
            continue
        assert found is not None
        for threads in (1, 2):
            make = found.maker(np.zeros((0, 3)), threads)
            out[f"{name}, {threads}"] = lambda ptr, column, make=make: Condensed(ptr, column, make)
    return out


def compare(model: dx.Model, makers: dict[str, Callable[[Any, Any], Any]]) -> None:
    """Print a row for each solver."""
    scheme = dx.EnergyMomentum().scheme(0.01)
    disc = discretise(model, scheme)
    newton, x = Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)
    external = disc.external(0.0)
    step.assemble(newton.tables, newton.work, x, newton.globals, external, newton.mask, False)
    blocks, rhs = newton.work.blocks, newton.work.rhs
    print(f"{model.name}: {6 * len(rhs)} unknowns")
    made: dict[str, Any] = {}
    first: dict[str, float] = {}
    for name, make in makers.items():
        clock = time.perf_counter()
        made[name] = make(disc.pattern.rowptr, disc.pattern.column)
        if made[name].solve(blocks, rhs) is None:
            print(f"  {name} does not solve it")
        first[name] = time.perf_counter() - clock
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in made}
    for _ in range(TURNS):
        for name, solver in made.items():
            cpu, clock = time.process_time(), time.perf_counter()
            solver.solve(blocks, rhs)
            times[name].append((time.process_time() - cpu, time.perf_counter() - clock))
    for name, some in times.items():
        cpu, clock = (min(one) for one in zip(*some, strict=True))
        print(f"  {name:10}  first {first[name]:6.3f} s, then {clock:6.3f} s, {cpu:6.3f} s of processors")


def main(edge: int = 10, edge_hinged: int = 6) -> None:
    """Print a table for each lattice."""
    with one_blas_thread():
        compare(lattice(edge), solvers())
        compare(hinged(edge_hinged), {"SuperLU": BlockSparse, **solvers()})


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]))
