"""Hanging chain
=============

A heavy rope that hangs from one end swings with Bernoulli's frequencies, ω_n = ½ j_n √(g/L).

j_n are the zeros of the Bessel function J0: 2.4048, 5.5201, 8.6537, … (Daniel Bernoulli 1733, the first such functions
there were). A rope bends a little stiffly, EI = 2·10⁻⁶ m g L² here. That changes nothing where it is taut, and raises
the higher modes a little, as they bend the slack end. Elements have to be short, T h² < 24 EI at the top.

    python examples/hanging_chain.py [--elements 160] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.special import jn_zeros

import directrix as dx

LENGTH, MASS, G, STIFF = 1.0, 1.0, 9.81, 2e-6


def rope(elements: int) -> dx.Model:
    """Hangs along −z from a hinge."""
    EI, inertia = STIFF * MASS * G * LENGTH**2, 1e-8
    section = dx.Section.from_moduli(
        EA=1e6, GA1=1e6, GA2=1e6, EI1=EI, EI2=EI, GJ=EI, A_rho=MASS, I_rho1=inertia, I_rho2=inertia
    )
    axis = dx.line((0, 0, 0), (0, 0, -LENGTH), d1=(1, 0, 0))
    model = dx.Model(name="hanging chain").rod(axis, section, name="rope", ends=("top", "end"), elements=elements)
    return model.fix("top", "x", "y", "z", "rx", "rz").gravity((0, 0, -G))


def main(*, elements: int = 160, count: int = 3, out: str | None = None) -> np.ndarray:
    """Frequencies (count,) of swinging in the x–z plane over Bernoulli's."""
    model = rope(elements)
    hanging = dx.solve_static(model, steps=1, raise_on_failure=True)
    modes = dx.modes(model, about=hanging, count=2 * count + 2)
    size = np.abs(modes.shapes).max(axis=1)
    planar = np.flatnonzero((size[:, 0] > size[:, 1]) & (size[:, 0] > 1e-3 * size[:, 5]))[:count]
    ours = 2.0 * np.pi * modes.frequencies[planar]
    exact = 0.5 * jn_zeros(0, count) * np.sqrt(G / LENGTH)
    for k in range(count):
        print(f"mode {k + 1}: ω = {ours[k]:.6f}, Bernoulli {exact[k]:.6f}, ratio {ours[k] / exact[k]:.6f}")
    if out is not None:
        path = Path(out) / "hanging_chain.png"
        draw(modes, planar, path)
        print(path)
    return ours / exact


def draw(modes: dx.Modes, planar: np.ndarray, path: Path) -> None:
    """The shapes beside Bessel's function."""
    from matplotlib import pyplot as plt
    from scipy.special import j0

    figure, pens = plt.subplots(1, len(planar), figsize=(11, 5), layout="constrained", sharey=True)
    height = modes.mesh.r0[:, 2]
    for k, (mode, pen) in enumerate(zip(planar, pens, strict=True)):
        shape = modes.shapes[mode, :, 0] / modes.shapes[mode, np.argmin(height), 0]
        fine = np.linspace(-LENGTH, 0.0, 200)
        pen.plot(j0(jn_zeros(0, k + 1)[k] * np.sqrt((fine + LENGTH) / LENGTH)), fine, color="#7d8791", lw=3, alpha=0.5)
        pen.plot(shape, height, color="#1f6fb4", lw=1.5)
        pen.set(title=f"mode {k + 1}", xlim=(-1.1, 1.1))
    pens[0].set_ylabel("z")
    figure.suptitle("grey: J0; blue: computed")
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_rope_swings_as_bernoulli_says() -> None:
    ratio = main()
    assert abs(ratio[0] - 1.0) < 1e-4
    assert np.abs(ratio - 1.0).max() < 2e-3


if __name__ == "__main__":
    from _command import run

    run(main)
