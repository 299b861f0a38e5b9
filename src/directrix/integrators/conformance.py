"""What a time step has to show before it is finished: its order, and every law that it claims."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from directrix.curves import line
from directrix.dynamics import simulate
from directrix.integrators.protocol import Integrator
from directrix.model import Model
from directrix.section import Section

__all__ = ["Measured", "check_integrator"]


class Measured(NamedTuple):
    """Order in Δt, and per law: name, claimed or not, largest relative deviation."""

    order: float
    laws: tuple[tuple[str, bool, float], ...]


def _flying_rod() -> Model:
    section = Section.from_moduli(EA=2500, GA1=950, GA2=950, EI1=10, EI2=12, GJ=8, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)
    return (
        Model(name="flying rod")
        .rod(line((1, 0, 0), (4, 0, 1)), section, name="rod", ends=("a", "b"), elements=6, order=1)
        .velocity("a", (0.3, 1.0, -2.0), omega=(1.0, 0.5, 2.0))
        .velocity("b", (0.0, -1.0, 1.0))
    )


def _carried_rod() -> Model:
    """Smooth from the start: a straight rod that turns as a whole while its ends are pulled."""
    section = Section.from_moduli(EA=2500, GA1=950, GA2=950, EI1=10, EI2=12, GJ=8, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)
    return (
        Model(name="carried rod")
        .rod(line((1, 0, 0), (4, 0, 1)), section, name="rod", ends=("a", "b"), elements=4, order=1)
        .rigid_velocity((1, 0, 0.5), (0.5, 1.0, 0.3), about=(2, 0, 0))
        .force("a", (0.0, 0.2, -0.5))
        .force("b", (0.0, 1.0, 0.4))
    )


def check_integrator(integrator: Integrator) -> Measured:
    """Order from the error at one time under halving of Δt; laws from a free flight with a large step."""
    model = _carried_rod()
    ends = [simulate(model, 0.2, 0.2 / n, integrator=integrator, tolerance=1e-12).r[-1] for n in (160, 320, 640)]
    gaps = [float(np.linalg.norm(b - a)) for a, b in itertools.pairwise(ends)]
    flight = simulate(_flying_rod(), 5.0, 0.1, integrator=integrator)
    laws = tuple((e.law, e.claimed, e.value) for e in flight.audit.entries)
    return Measured(float(np.log2(gaps[-2] / gaps[-1])), laws)
