"""Vibrating ring
==============

A free ring bends in its plane and twists out of it: two families of frequencies, each twice.

Love's formulas for a thin ring that does not stretch, with n waves round it, n = 2, 3, …:

* in its plane ω² = n²(n² − 1)²/(n² + 1) · EI/(m R⁴),
* out of it ω² = n²(n² − 1)²/(n² + EI/GJ) · EI/(m R⁴).

Nothing holds the ring, so six motions without frequency come first. A closed ring is two rods here.

    python examples/ring_vibration.py [--elements 24] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

E, NU, RHO, RADIUS, THICK = 2.1e11, 0.3, 7850.0, 1.0, 2e-3


def ring(elements: int) -> dx.Model:
    """A thin round wire bent to a circle of radius 1, of two halves."""
    wire = dx.Section.circle(radius=THICK, E=E, nu=NU, rho=RHO)
    model = dx.Model(name="ring")
    for name, side, ends in (("upper", 1, ("a", "b")), ("lower", -1, ("b", "a"))):
        half = dx.arc((side * RADIUS, 0, 0), (0, side * RADIUS, 0), (-side * RADIUS, 0, 0), d1=(0, 0, 1))
        model = model.rod(half, wire, name=name, ends=ends, elements=elements)
    return model


def love(waves: int) -> tuple[float, float]:
    """Frequencies in Hz in and out of the plane."""
    n, speed = waves, E * THICK**2 / (4.0 * RHO * RADIUS**4)
    common = n**2 * (n**2 - 1) ** 2 * speed
    return float(np.sqrt(common / (n**2 + 1)) / (2 * np.pi)), float(np.sqrt(common / (n**2 + 1 + NU)) / (2 * np.pi))


def main(*, elements: int = 24, out: str | None = None) -> dict[str, float]:
    """Frequencies over Love's for two to four waves."""
    modes = dx.modes(ring(elements), count=18)
    assert np.abs(modes.frequencies[:6]).max() < 1e-3 * modes.frequencies[6]
    found: dict[str, float] = {}
    for k in range(6, 18, 2):
        lift = np.abs(modes.shapes[k, :, 2]).max() > np.abs(modes.shapes[k, :, :2]).max()
        waves = 2 + sum(name.startswith("out" if lift else "in") for name in found)
        name = f"{'out of' if lift else 'in'} plane, {waves} waves"
        exact = love(waves)[int(lift)]
        found[name] = float(modes.frequencies[k : k + 2].mean() / exact)
        pair = ", ".join(f"{f:.5f}" for f in modes.frequencies[k : k + 2])
        print(f"{name:<22} {pair} Hz, Love {exact:.5f}, ratio {found[name]:.6f}")
    if out is not None:
        path = Path(out) / "ring_vibration.png"
        draw(modes, path)
        print(path)
    return found


def draw(modes: dx.Modes, path: Path) -> None:
    """The first six pairs of shapes."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(11, 7), layout="constrained")
    for place, mode in enumerate(range(7, 19, 2), 1):
        space = figure.add_subplot(2, 3, place, projection="3d")
        motion = modes.motion(mode, amplitude=0.35)
        for k, colour, width in ((0, "#1f6fb4", 2.2), (len(motion.t) // 2, "#c0392f", 1.2)):
            for rod in motion.mesh.rods:
                space.plot(*motion.r[k, rod.nodes].T, color=colour, lw=width)
        space.set(xlim=(-1.2, 1.2), ylim=(-1.2, 1.2), zlim=(-1.2, 1.2), title=f"{modes.frequencies[mode - 1]:.3f} Hz")
        space.set_axis_off()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_ring_vibrates_as_love_says() -> None:
    found = main()
    assert len(found) == 6
    assert max(abs(ratio - 1.0) for ratio in found.values()) < 1e-3


if __name__ == "__main__":
    from _command import run

    run(main)
