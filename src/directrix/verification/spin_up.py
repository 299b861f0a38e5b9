"""5.6 Spin-up of a rotating beam (Simo & Vu-Quoc 1986).

The hub turns by θ(t) = 0.4 (t²/2 + (15/2π)²(cos(2πt/15) − 1)) until t = 15 and at Ω = 6 from then on. In the relative
equilibrium EA r'' + A_ρ Ω² r = 0, so that r(S) = sin(kS)/(k cos(kL)) with k = Ω √(A_ρ/EA). The mean over time leaves
out the small vibrations that the start excites.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.result import Result
from directrix.rotations import exp
from directrix.verification.record import Case, Check

Array = NDArray[np.float64]

LENGTH, EA, GA, EI, MASS, ROTARY, OMEGA = 10.0, 2.8e7, 1e7, 1.4e4, 1.2, 6e-4, 6.0
EXTENSION = 5.14e-4
LAG = -0.6  # remembered, read from the source's figure


def angle(t: float) -> float:
    """θ(t)."""
    if t >= 15.0:
        return 6.0 * t - 45.0
    return 0.4 * (0.5 * t**2 + (7.5 / np.pi) ** 2 * (np.cos(2.0 * np.pi * t / 15.0) - 1.0))


def exact_extension() -> float:
    """Of the tip at Ω = 6."""
    k = OMEGA * np.sqrt(MASS / EA)
    return float(np.tan(k * LENGTH) / k - LENGTH)


def spun(elements: int, order: int, dt: float, t_end: float = 20.0) -> Result:
    """The beam along x, its hub at the origin turned about z."""
    section = dx.Section.from_moduli(
        EA=EA, GA1=GA, GA2=GA, EI1=EI, EI2=EI, GJ=EI, A_rho=MASS, I_rho1=ROTARY, I_rho2=ROTARY
    )
    model = dx.Model(name="spin-up").rod(
        dx.line((0, 0, 0), (LENGTH, 0, 0)), section, name="rod", ends=("hub", "tip"), elements=elements, order=order
    )

    def turn(t: float) -> Array:
        return np.array([0.0, 0.0, angle(t)])

    model = model.prescribe("hub", displacement=(0, 0, 0), rotation=turn)
    return dx.simulate(model, t_end, dt, raise_on_failure=True)


def in_hub(result: Result) -> Array:
    """Displacement of the tip (nt, 3) seen from the hub."""
    frames = exp(np.array([(0.0, 0.0, angle(t)) for t in result.t]))
    return np.einsum("tji,tj->ti", frames, result.node("tip").r) - (LENGTH, 0.0, 0.0)


def _run() -> Iterator[Check]:
    form = exact_extension()
    yield Check.printed("steady extension: closed form", "Simo & Vu-Quoc 1986, data", "A", EXTENSION, form, 6)
    result = spun(10, 2, 0.01)
    u = in_hub(result)
    steady = u[result.t >= 15.0 - 1e-9, 0]
    name = "10 quadratic, Δt = 0.01"
    yield Check.of(f"{name}: mean extension, t > 15", "relative equilibrium", "A", form, steady.mean(), 1e-3)
    lag = u[:, 1].min()
    yield Check.of(f"{name}: largest lag", "Simo & Vu-Quoc 1986", "M", LAG, lag, None)
    fine = in_hub(spun(20, 2, 0.005, 8.0))[:, 1].min()
    yield Check.of(f"{name}: largest lag", "20 quadratic, Δt = 0.005", "C-FE", fine, lag, 0.02)


CASES = (Case("spin-up", "5.6", "Spin-up of a rotating beam", _run),)
