"""Stiffening strip
================

A strip of rubber-like material, by its energy alone: its bending stiffens, and still no energy is lost or gained.

The law is a plain Python function of the six strains; stress, tangent and machine code are derived from it. Here
W has ½ β (exp(q) − 1) in place of ½ (EI1 Ω1² + EI2 Ω2²), with q = (EI1 Ω1² + EI2 Ω2²)/β: ``dx.laws.stiffening_bending``
written out. At rest it is the linear strip. Under an end moment M the strip is an arc of the curvature κ that solves
M = EI κ exp(EI κ²/β), less than the linear M/EI. Let go, it flies for ten thousand steps at constant energy, because
the discrete gradient of Gonzalez (1996) makes each step do exactly the work of this energy; the classical midpoint
rule with the same law and the same step does not.

    python examples/stiffening_strip.py [--moment 25] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import directrix as dx

LENGTH, EA, GA, EI, GJ, ONSET = 3.0, 2500.0, 950.0, 10.0, 8.0, 0.8
BETA = EI * ONSET**2


def energy(e):
    """Stored energy per length of the strains (shear 1, shear 2, axial, bending 1, bending 2, torsion)."""
    stretch = GA * (e[0] ** 2 + e[1] ** 2) + EA * e[2] ** 2 + GJ * e[5] ** 2
    return 0.5 * stretch + 0.5 * BETA * (np.exp((EI * e[3] ** 2 + EI * e[4] ** 2) / BETA) - 1.0)


def strip(elements: int, order: int) -> dx.Model:
    """The strip along x, straight at rest."""
    section = dx.Section.hyperelastic(energy, A_rho=2.5, I_rho=np.diag([0.01, 0.01]))
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0))
    return dx.Model(name="stiffening strip").rod(
        axis, section, name="strip", ends=("a", "b"), elements=elements, order=order
    )


def exact_curvature(moment: float) -> float:
    """κ with M = EI κ exp(EI κ²/β)."""
    return brentq(lambda k: EI * k * np.exp(EI * k * k / BETA) - moment, 0.0, moment / EI)


def main(*, moment: float = 25.0, steps: int = 10_000, dt: float = 0.05, out: str | None = None) -> dict[str, float]:
    """Curvature under the moment beside the exact and the linear one; energy error of the flight and of the rival."""
    bent = dx.solve_static(strip(24, 2).clamp("a").moment("b", (0, 0, moment)), steps=1, raise_on_failure=True)
    curvature = bent.rod("strip").strain[-1, :, 3:5]
    found = {
        "curvature": float(np.linalg.norm(curvature, axis=1).mean()),
        "exact": exact_curvature(moment),
        "linear": moment / EI,
    }
    flying = strip(5, 1).velocity("a", (0.3, 1.0, -2.0), omega=(1.0, 0.5, 2.0)).velocity("b", (0.0, -1.0, 1.0))
    flight = dx.simulate(flying, t_end=steps * dt, dt=dt, save_every=max(1, steps // 200))
    rival = dx.simulate(flying, t_end=100 * dt, dt=dt, integrator=dx.Midpoint())
    for name, result in (("energy error", flight), ("midpoint's in 100 steps", rival)):
        found[name] = float(np.abs(result.energy.residual).max() / result.energy.total[0])
    for name, value in found.items():
        print(f"{name:<24} {value:.9g}")
    print(flight)
    if out is not None:
        path = Path(out) / "stiffening_strip.png"
        bent.plot.shape().figure.savefig(path, dpi=150)
        print(path)
    return found


def test_the_arc_is_the_exact_one_and_the_flight_keeps_its_energy() -> None:
    found = main()
    assert abs(found["curvature"] - found["exact"]) <= 1e-5 * found["exact"]
    assert found["exact"] < 0.6 * found["linear"]
    assert found["energy error"] <= 1e-10
    assert found["midpoint's in 100 steps"] >= 1e-4


if __name__ == "__main__":
    from _command import run

    run(main)
