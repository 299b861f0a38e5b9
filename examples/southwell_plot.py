"""Southwell plot
==============

The critical load of a column from its crooked self, without buckling it.

A hinged column with an initial bow a0 sin πx/L bends by w = a0/(P_E/P − 1) long before Euler's load P_E. So w/P over w
is a straight line whose slope is 1/P_E (Southwell 1932), and testers read the critical load off it while the column
stays whole. Here the loads are those up to 0.8 P_E of a column with a bow of a ten-thousandth of its length,
computed with finite rotations.

    python examples/southwell_plot.py [--bow 1e-4] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

LENGTH, EI = 1.0, 1.0
EULER = np.pi**2 * EI / LENGTH**2
SECTION = dx.Section.from_moduli(EA=1e7, GA1=1e7, GA2=1e7, EI1=EI, EI2=EI, GJ=EI)


def column(bow: float, elements: int) -> dx.Model:
    """Along x, bent in the x–y plane, hinged at both ends; the load is Euler's at the load factor 1."""
    x = np.linspace(0.0, LENGTH, 2 * elements + 1)
    axis = dx.spline(np.column_stack([x, bow * np.sin(np.pi * x / LENGTH), 0 * x]), d1=(0, 1, 0))
    model = dx.Model(name="crooked column").rod(
        axis, SECTION, name="column", ends=("foot", "head"), elements=elements, nodes={"middle": 0.5}
    )
    model = model.fix("foot", "x", "y", "z", "rx", "ry").fix("head", "y", "z", "rx", "ry")
    return model.force("head", (-EULER, 0, 0))


def main(*, bow: float = 1e-4, elements: int = 16, out: str | None = None) -> float:
    """Southwell's critical load over Euler's."""
    control = dx.ArcLength(ds=2e-5, load_step=0.1, until=lambda s: s.load_factor > 0.8)
    result = dx.solve_static(column(bow, elements), control=control, raise_on_failure=True)
    w, P = result.node("middle").displacement[:, 1], EULER * result.load_factor
    loaded = result.load_factor > 0.3
    slope, offset = np.polyfit(w[loaded], w[loaded] / P[loaded], 1)
    print(f"{loaded.sum()} loads up to {result.load_factor[-1]:.3f} P_E, deflection {w[-1]:.3e}")
    print(f"slope gives P_cr = {1 / slope:.6f}, Euler {EULER:.6f}, ratio {1 / slope / EULER:.6f}")
    print(f"the line cuts off the bow: {offset / slope:.4e} (given {bow:.4e})")
    if out is not None:
        path = Path(out) / "southwell_plot.png"
        draw(w, P, slope, offset, path)
        print(path)
    return float(1.0 / (slope * EULER))


def draw(w: np.ndarray, P: np.ndarray, slope: float, offset: float, path: Path) -> None:
    """The load over the deflection, and Southwell's line."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.3), layout="constrained")
    left.plot(w, P / EULER, "o-", color="#1f6fb4", ms=3)
    left.axhline(1.0, color="#7d8791", ls=":")
    left.set(xlabel="deflection w", ylabel="P / P_E")
    right.plot(w[1:], w[1:] / P[1:], "o", color="#1f6fb4", ms=3)
    right.plot(w, slope * w + offset, color="#c0392f", lw=1, label="slope 1/P_cr")
    right.set(xlabel="deflection w", ylabel="w / P")
    right.legend(frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_southwells_line_gives_eulers_load() -> None:
    assert abs(main() - 1.0) < 1e-3


if __name__ == "__main__":
    from _command import run

    run(main)
