"""Hose between two hinges
=======================

A straight hose whose ends are brought together bows out into Euler's elastica.

With the ends a apart and the length L, K(k) and E(k) the complete elliptic integrals of modulus k (Love 1927, §263):
a/L = 2E/K − 1, the force along the line of the ends P = 4 K² EI/L², the rise k L/K, and the ends slope by 2 asin k. The
hose is first bent by moments on its ends; then the ends are held at their distance and the moments taken away.

    python examples/buckled_hose.py [--elements 40] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import directrix as dx

LENGTH, EI, MOMENT = 1.0, 1.0, 2.0
APART = (0.9, 0.7, 0.5)
SECTION = dx.Section.from_moduli(EA=1e6, GA1=1e6, GA2=1e6, EI1=100 * EI, EI2=EI, GJ=100 * EI)


def hose(elements: int) -> dx.Model:
    """Bends in the x–y plane, hinged on the left."""
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="hose").rod(
        axis, SECTION, name="hose", ends=("left", "right"), elements=elements, nodes={"middle": 0.5}
    )
    return model.fix("left", "x", "y", "z", "rx", "ry").fix("right", "rx", "ry")


def held(elements: int, places: tuple[float, ...]) -> list[dx.Result]:
    """Bent by moments at its ends, then held while the moments go, then its ends brought together further."""
    model = hose(elements)
    bent = model.fix("right", "y", "z").moment("left", (0, 0, MOMENT)).moment("right", (0, 0, -MOMENT))
    runs = [dx.solve_static(bent, steps=5, raise_on_failure=True)]
    for k, apart in enumerate(places):
        start, change = float(runs[-1].node("right").displacement[-1, 0]), apart - LENGTH
        path = dx.table((0.0, 1.0), ((start, 0, 0), (change, 0, 0)))
        moving = model.prescribe("right", displacement=path)
        for node, m in (("left", MOMENT), ("right", -MOMENT)) if k == 0 else ():
            moving = moving.moment(node, dx.table((0.0, 1.0), ((0, 0, m), (0, 0, 0))), constant=True)
        runs.append(dx.solve_static(moving, steps=10, start=runs[-1], raise_on_failure=True))
    return runs[1:]


def elastica(apart: float) -> tuple[float, float, float]:
    """Force, rise and slope of the ends (radians)."""
    k = brentq(lambda k: 2 * ellipe(k * k) / ellipk(k * k) - 1 - apart / LENGTH, 1e-9, 1 - 1e-9, xtol=1e-14)
    return 4 * ellipk(k * k) ** 2 * EI / LENGTH**2, k * LENGTH / ellipk(k * k), 2 * np.arcsin(k)


def main(*, elements: int = 40, out: str | None = None) -> dict[float, np.ndarray]:
    """Force, rise and slope over those of the elastica, for ends 0.9, 0.7 and 0.5 apart."""
    found: dict[float, np.ndarray] = {}
    shapes = dict(zip(APART, held(elements, APART), strict=True))
    for apart, result in shapes.items():
        slope = np.arctan2(result.node("left").R[-1, 1, 0], result.node("left").R[-1, 0, 0])
        ours = np.array([-result.node("right").reaction[-1, 0], result.node("middle").r[-1, 1], slope])
        found[apart] = ours / elastica(apart)
        print(f"ends {apart} apart: P = {ours[0]:.5f}, rise {ours[1]:.6f}, slope {ours[2]:.6f}; ratios {found[apart]}")
    if out is not None:
        path = Path(out) / "buckled_hose.png"
        draw(shapes, path)
        print(path)
    return found


def draw(shapes: dict[float, dx.Result], path: Path) -> None:
    """The three shapes, and the force over the distance of the ends."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    apart = np.linspace(0.4, 0.999, 80)
    right.plot(apart, [elastica(a)[0] / np.pi**2 for a in apart], color="#1f6fb4", label="elastica")
    for a, result in shapes.items():
        left.plot(result.r[-1, :, 0], result.r[-1, :, 1], lw=2, label=f"ends {a} apart")
        right.plot(a, -result.node("right").reaction[-1, 0] / np.pi**2, "o", color="#c0392f")
    left.set(aspect="equal", xlabel="x", ylabel="y")
    right.set(xlabel="distance of the ends / length", ylabel="force / Euler's")
    left.legend(frameon=False)
    right.legend(frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_hose_is_an_elastica() -> None:
    found = main()
    assert max(np.abs(ratio - 1.0).max() for ratio in found.values()) < 1e-4


if __name__ == "__main__":
    from _command import run

    run(main)
