"""Thick cantilever
================

Frequencies of a cantilever five times as long as it is high, where shear and rotary inertia count.

The exact frequencies are those of Timoshenko's beam: w′ = ψ + Q/κGA, ψ′ = M/EI, Q′ = −ρA ω² w, M′ = −Q − ρI ω² ψ with
w = ψ = 0 at the root and M = Q = 0 at the tip. The transfer matrix is one exponential, and ω a root of a determinant
of two rows: no formula for shapes is needed. Euler's beam would be a quarter off already in the second mode.

    python examples/thick_cantilever.py [--elements 30] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

import directrix as dx

LENGTH, WIDTH, HEIGHT, E, NU, RHO = 1.0, 0.05, 0.2, 7e10, 0.33, 2700.0
SECTION = dx.Section.rectangle(width=WIDTH, height=HEIGHT, E=E, nu=NU, rho=RHO)
EULER = np.array([1.875104069, 4.694091133, 7.854757438])


def determinant(omega: float) -> float:
    """Of the moment and the shear force at the tip, over those at the root."""
    GA, EI = SECTION.stiffness[1, 1], SECTION.stiffness[3, 3]
    A, inertia = SECTION.A_rho, SECTION.I_rho[1, 1]
    system = np.array([[0, 1, 1 / GA, 0], [0, 0, 0, 1 / EI], [-A * omega**2, 0, 0, 0], [0, -inertia * omega**2, -1, 0]])
    scale = np.array([1.0, 1.0, GA, EI])  # entries of one size
    return float(np.linalg.det(expm(LENGTH * system * scale / scale[:, None])[2:, 2:]))


def timoshenko(count: int = 3) -> np.ndarray:
    """Frequencies (count,) in Hz."""
    grid = np.linspace(10.0, 4e4, 200)
    values = [determinant(omega) for omega in grid]
    roots = [
        brentq(determinant, a, b, xtol=1e-9)
        for a, b, u, v in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True)
        if u * v < 0
    ]
    return np.array(roots[:count]) / (2.0 * np.pi)


def main(*, elements: int = 30, out: str | None = None) -> np.ndarray:
    """The first three frequencies of bending about the strong axis over the exact ones."""
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="thick cantilever").rod(axis, SECTION, name="beam", ends=("root", "tip"), elements=elements)
    modes = dx.modes(model.clamp("root"), count=12)
    size = np.abs(modes.shapes[:, :, :3]).max(axis=1)
    strong = modes.frequencies[size[:, 2] > 10 * np.maximum(size[:, 0], size[:, 1])][:3]
    exact = timoshenko()
    euler = EULER**2 / LENGTH**2 * np.sqrt(SECTION.stiffness[3, 3] / SECTION.A_rho) / (2 * np.pi)
    for k in range(3):
        print(f"mode {k + 1}: {strong[k]:10.4f} Hz, Timoshenko {exact[k]:10.4f}, Euler {euler[k]:10.4f}")
    if out is not None:
        path = Path(out) / "thick_cantilever.png"
        draw(strong, exact, euler, path)
        print(path)
    return strong / exact


def draw(ours: np.ndarray, exact: np.ndarray, euler: np.ndarray, path: Path) -> None:
    """The three frequencies beside both theories."""
    from matplotlib import pyplot as plt

    figure, pen = plt.subplots(figsize=(7, 4.5), layout="constrained")
    place = np.arange(1, 4)
    for shift, values, colour, label in (
        (-0.25, euler, "#b9c0c7", "Euler"),
        (0.0, exact, "#1f6fb4", "Timoshenko, exact"),
        (0.25, ours, "#c0392f", "computed"),
    ):
        pen.bar(place + shift, values, 0.24, color=colour, label=label)
    pen.set(xticks=place, xlabel="mode", ylabel="frequency / Hz", title="cantilever, length over height 5")
    pen.legend(frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_frequencies_are_timoshenkos() -> None:
    assert np.abs(main() - 1.0).max() < 1e-5


if __name__ == "__main__":
    from _command import run

    run(main)
