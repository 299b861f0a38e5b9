"""Rotating blade
==============

A spinning blade is stiffer: flapping frequencies over the speed of the rotor.

A uniform blade is clamped to a hub of no radius that turns with Ω about the vertical. The centrifugal force holds it
straight, T(x) = ½ m Ω² (L² − x²), and raises the frequencies of flapping. Southwell's estimate ω² = ω0² + c Ω² is a
lower bound; the exact numbers are those of the linear beam under T, found here by Ritz's method with 12 polynomials.
Wright, Smith, Thresher and Wang (1982) print those of the first mode. Speeds are in units of √(EI/m L⁴).

    python examples/rotating_blade.py [--elements 16] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.polynomial import Polynomial
from scipy.linalg import eigh

import directrix as dx

LENGTH, EI, MASS = 1.0, 1.0, 1.0
WRIGHT = {0.0: 3.5160, 4.0: 5.5850, 8.0: 9.2568, 12.0: 13.1702}


def blade(elements: int) -> dx.Model:
    """Slender, with little rotary inertia; flaps along z."""
    inertia = 1e-6 * MASS * LENGTH**2
    section = dx.Section.from_moduli(
        EA=1e8, GA1=1e8, GA2=1e8, EI1=EI, EI2=100 * EI, GJ=100 * EI, A_rho=MASS, I_rho1=inertia, I_rho2=inertia
    )
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="rotating blade").rod(axis, section, name="blade", ends=("hub", "tip"), elements=elements)
    return model.clamp("hub")


def ritz(omega: float, count: int = 3, terms: int = 12) -> np.ndarray:
    """Flapping frequencies (count,) of the linear beam under its centrifugal tension."""
    shapes = [Polynomial([0.0, 0.0, *[0.0] * k, 1.0]) for k in range(terms)]
    tension = 0.5 * MASS * omega**2 * Polynomial([LENGTH**2, 0.0, -1.0])

    def inner(a: Polynomial, b: Polynomial) -> float:
        whole = (a * b).integ()
        return float(whole(LENGTH) - whole(0.0))

    stiffness = np.array(
        [[EI * inner(a.deriv(2), b.deriv(2)) + inner(tension * a.deriv(), b.deriv()) for a in shapes] for b in shapes]
    )
    mass = np.array([[MASS * inner(a, b) for a in shapes] for b in shapes])
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:count])


def flapping(model: dx.Model, omega: float, count: int = 3) -> np.ndarray:
    """Frequencies (count,) of the modes that move along z, in radians."""
    modes = dx.modes(model, count=8, spin=(0, 0, omega) if omega else None)
    size = np.abs(modes.shapes[:, :, :3]).max(axis=1)
    flaps = size[:, 2] > 10.0 * size[:, 1]
    return 2.0 * np.pi * modes.frequencies[flaps][:count]


def main(*, elements: int = 16, out: str | None = None) -> dict[float, np.ndarray]:
    """Per speed the first three frequencies over the exact ones, printed with the exact and the published first."""
    model, found = blade(elements), {}
    for omega, printed in WRIGHT.items():
        ours, exact = flapping(model, omega), ritz(omega)
        found[omega] = ours / exact
        print(
            f"Ω = {omega:4.1f}: ω1 = {ours[0]:.4f} (exact {exact[0]:.4f}, Wright {printed:.4f}), ratios {found[omega]}"
        )
    if out is not None:
        path = Path(out) / "rotating_blade.png"
        draw(model, path)
        print(path)
    return found


def draw(model: dx.Model, path: Path) -> None:
    """Frequencies over speed, exact as lines, with the multiples of the speed that excite them."""
    from matplotlib import pyplot as plt

    speeds, few = np.linspace(0.0, 12.0, 49), np.linspace(0.0, 12.0, 4)
    figure, pen = plt.subplots(figsize=(8, 5), layout="constrained")
    exact = np.array([ritz(omega) for omega in speeds])
    ours = np.array([flapping(model, omega) for omega in few])
    for k, colour in enumerate(("#1f6fb4", "#c0392f", "#2b8a4b")):
        pen.plot(speeds, exact[:, k], color=colour, lw=1.5, label=f"mode {k + 1}, exact")
        pen.plot(few, ours[:, k], "o", color=colour, ms=5)
    for multiple in range(1, 6):
        pen.plot(speeds, multiple * speeds, color="#7d8791", lw=0.8, ls=":")
        pen.annotate(f"{multiple}Ω", (12.05, multiple * 12.0), color="#7d8791", va="center", annotation_clip=False)
    pen.set(xlabel="Ω", ylabel="ω", title="flapping of a rotating blade: dots computed", ylim=(0, 90), xlim=(0, 12))
    pen.legend(frameon=False, loc="upper left")
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_blade_flaps_as_the_beam_under_centrifugal_tension() -> None:
    found = main()
    assert max(np.abs(ratio - 1.0).max() for ratio in found.values()) < 2e-4
    for omega, printed in WRIGHT.items():
        assert abs(ritz(omega)[0] - printed) < 6e-5


if __name__ == "__main__":
    from _command import run

    run(main)
