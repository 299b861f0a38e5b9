"""What is left of the laws after very many steps: round-off, and nothing else. CONTRIBUTING.md says what was seen."""

from __future__ import annotations

import resource

import numpy as np
import pytest

import directrix as dx

MILLION = 1_000_000


def frame(elements: int) -> dx.Model:
    """Example 5 of the paper, the free flight of a frame of three rods at right angles.

    Its energy is 2.5, and an element of length h folds for ½ GJ/h: more than twelve elements a rod never can.
    """
    section = dx.Section.from_moduli(
        EA=2500, GA1=960, GA2=960, EI1=1.6, EI2=1.6, GJ=1.2, A_rho=1.0, I_rho1=0.01, I_rho2=0.01
    )
    return (
        dx.Model(name="frame in free flight")
        .rod(dx.line((0, 3, 0), (0, 0, 0)), section, name="left", ends=("A", "O"), elements=elements, order=1)
        .rod(dx.line((0, 0, 0), (3, 0, 0)), section, name="mid", ends=("O", "B"), elements=elements, order=1)
        .rod(dx.line((3, 0, 0), (3, 0, 3)), section, name="right", ends=("B", "C"), elements=elements, order=1)
        .velocity("A", (0, 0, -1))
        .velocity("B", (0, 0, 2))
        .velocity("C", (0, -1, 0))
    )


def drift(steps: int, dt: float = 0.002, elements: int = 13) -> dict[str, float]:
    """Largest relative changes of linear momentum, of angular momentum about the mass centre and of energy, the loss
    of orthonormality, and the memory [MB per 1e5 steps] that the second half of the run takes."""
    memory: list[float] = []

    def look(done: float, _: str) -> None:
        if done >= 0.5 and (len(memory) == 0 or done >= 1.0 - 1e-12):
            memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)

    model = frame(elements)
    result = dx.simulate(model, steps * dt, dt, tolerance=1e-13, save_every=steps // 100, progress=look)
    assert result.success and result.audit.passed, str(result)
    p, j = result.momentum.linear, result.momentum.angular
    mass = 9.0  # A_rho times three lengths
    centre = np.array([1.5, 0.5, 0.5])  # in the reference; it moves on a line
    about = j - np.cross(centre + np.outer(result.t, p[0]) / mass, p)
    size = np.linalg.norm
    lost = np.swapaxes(result.R, -1, -2) @ result.R - np.eye(3)
    return {
        "linear": float(size(p - p[0], axis=1).max() / size(p[0])),
        "angular": float(size(about - about[0], axis=1).max() / size(about[0])),
        "energy": float(np.abs(result.energy.total / result.energy.total[0] - 1.0).max()),
        "orthonormal": float(np.abs(lost).max()),
        "memory": (memory[-1] - memory[0]) / (0.5 * steps) * 1e5,
    }


@pytest.mark.slow
def test_a_million_steps_leave_round_off_only() -> None:
    left = drift(MILLION)
    assert left["linear"] <= 2e-12 and left["angular"] <= 2e-11 and left["energy"] <= 2e-10, left
    assert left["orthonormal"] <= 1e-13 and left["memory"] < 1.0, left
