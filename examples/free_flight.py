"""Free flight of a three-rod frame
================================

Romero & Armero (2002), example 5; Figures 7 to 9.

Three rods joined at right angles, A (0, 3, 0) – O (0, 0, 0) – B (3, 0, 0) – C (3, 0, 3), five linear elements
each. Three nodes get a velocity: A −e3, B 2 e3, C −e2 (the shape functions do the rest). Nothing acts, so
H = 2.5, L = (0, −0.75, 2.25) and J must stay what they are; the energy–momentum step keeps them to round-off at every
Δt, the classical midpoint rule keeps the momenta and lets the energy run away.

    python examples/free_flight.py [--dt 0.2] [--t_end 30] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

ENERGY, LINEAR = 2.5, np.array([0.0, -0.75, 2.25])


def frame() -> dx.Model:
    """The frame with its initial velocities."""
    E, rho, A, inertia, J = 5e5, 500.0, 0.005, 2e-5, 4e-5
    G = E / 2.6
    section = dx.Section.from_moduli(
        EA=E * A, GA1=G * A, GA2=G * A, EI1=E * inertia, EI2=E * inertia, GJ=G * J,
        A_rho=rho * A, I_rho1=rho * inertia, I_rho2=rho * inertia,
    )  # fmt: skip
    return (
        dx.Model(name="free flight")
        .rod(dx.line((0, 3, 0), (0, 0, 0)), section, name="left", ends=("A", "O"), elements=5, order=1)
        .rod(dx.line((0, 0, 0), (3, 0, 0)), section, name="mid", ends=("O", "B"), elements=5, order=1)
        .rod(dx.line((3, 0, 0), (3, 0, 3)), section, name="right", ends=("B", "C"), elements=5, order=1)
        .velocity("A", (0, 0, -1))
        .velocity("B", (0, 0, 2))
        .velocity("C", (0, -1, 0))
    )


def main(*, dt: float = 0.2, t_end: float = 30.0, out: str | None = None) -> dict[str, dx.Result]:
    """Both schemes with the same step; prints the audits, writes result, picture and animation if ``out`` is given."""
    model = frame()
    results = {
        "energy–momentum": dx.simulate(model, t_end=t_end, dt=dt),
        "classical midpoint": dx.simulate(model, t_end=t_end, dt=dt, integrator=dx.Midpoint()),
    }
    for result in results.values():
        print(result, end="\n\n")
    if out is not None:
        from directrix.comparison import compare_energy_momentum

        folder, result = Path(out), results["energy–momentum"]
        compare_energy_momentum(results, folder / "free_flight.png")
        print(
            folder / "free_flight.png",
            result.view(folder / "free_flight.html"),
            result.save(folder / "free_flight.vtkhdf"),
            sep="\n",
        )
    return results


def test_energy_and_momenta_are_exact_and_the_midpoint_rule_is_not() -> None:
    for dt in (0.2, 0.15, 0.1, 0.05):
        exact, midpoint = main(dt=dt).values()
        assert exact.success and exact.t[-1] == 30.0
        energy, momentum = exact.energy.total, exact.momentum
        assert abs(energy[0] - ENERGY) <= 1e-13
        np.testing.assert_allclose(momentum.linear[0], LINEAR, rtol=0, atol=1e-13)
        assert np.abs(energy - energy[0]).max() <= 1e-11 * energy[0]
        assert np.abs(momentum.linear - momentum.linear[0]).max() <= 1e-11
        assert np.abs(momentum.angular - momentum.angular[0]).max() <= 1e-11
        drift = np.abs(midpoint.energy.total - ENERGY).max()
        assert not midpoint.success or drift > 0.1


if __name__ == "__main__":
    from _command import run

    run(main)
