"""45° bend
========

After Bathe & Bolourchi (1979); Romero & Armero (2002), example 4 and Table II.

An eighth of a circle of radius 100 with unit square section, clamped at one end and loaded at the other by a
dead force normal to its plane. The paper's row "current" is reproduced digit for digit with its own mesh: eight
linear elements, straight, directors along each chord, shear factor 1 and J = 1/6. That mesh is 2 % too flexible,
a known price of interpolating directors linearly; quadratic elements (the default) meet the exact solution
of the Simo–Reissner rod (computed by shooting) to five digits.

    python examples/bend45.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

PAPER = {300: (58.6535, 40.6636, 22.1322), 450: (51.8312, 49.3280, 18.2244), 600: (46.4612, 54.5543, 15.2476)}
EXACT = np.array([47.150439, 53.474859, 15.684801])  # F = 600


def bend(force: float, elements: int, order: int) -> dx.Result:
    """The bend in the x–z plane, loaded along y in one step; tip at (70.71, 0, 29.29) when unloaded."""
    section = dx.Section.from_moduli(EA=1e7, GA1=5e6, GA2=5e6, EI1=1e7 / 12, EI2=1e7 / 12, GJ=5e6 / 6)
    c = 100.0 * np.sqrt(0.5)
    s, half = 100.0 * np.sin(np.pi / 8), 100.0 * (1.0 - np.cos(np.pi / 8))
    curve = dx.arc((0, 0, 0), (s, 0, half), (c, 0, 100.0 - c), directors="chord" if order == 1 else "tangent")
    model = (
        dx.Model(name=f"45° bend, F = {force:g}")
        .rod(curve, section, name="bend", ends=("root", "tip"), elements=elements, order=order)
        .clamp("root")
        .force("tip", (0, force, 0))
    )
    return dx.solve_static(model, steps=1, raise_on_failure=True)


def main(*, elements: int = 8, order: int = 1, out: str | None = None) -> dict[int, np.ndarray]:
    """Tip positions (3,) under 300, 450 and 600, printed beside the paper's."""
    found: dict[int, np.ndarray] = {}
    for force, printed in PAPER.items():
        result = bend(force, elements, order)
        found[force] = result.node("tip").r[-1]
        print(f"F = {force}: tip {found[force]}   paper {printed}")
    exact = bend(600, 16, 2).node("tip").r[-1]
    print(f"F = 600, 16 quadratic elements: {exact}   exact {EXACT}")
    if out is not None:
        ax = result.plot.shape(at=-1)
        path = Path(out) / "bend45.png"
        ax.figure.savefig(path, dpi=150)
        print(path)
    return found


def test_table_2_to_the_printed_digits() -> None:
    for force, tip in main().items():
        np.testing.assert_allclose(tip, PAPER[force], rtol=0, atol=1.01e-4)  # four digits, cut off


def test_sixteen_quadratic_elements_meet_the_exact_solution() -> None:
    np.testing.assert_allclose(bend(600, 16, 2).node("tip").r[-1], EXACT, rtol=0, atol=5e-4)


if __name__ == "__main__":
    from _command import run

    run(main)
