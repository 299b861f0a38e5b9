"""Path independence
=================

Romero & Armero (2002), example 2; after Jelenić & Crisfield (1999).

One linear element along e3; its ends are turned to (1, −0.5, 0.25) and (−0.4, 0.7, 0.1), A held in place and B
free to move. Path I goes there in two equal parts; path II turns A by 0.775 and B by 0.4 of it first. The end
state depends on the end rotations alone: with D_m the mean and D' the slope of the end directors,
κ_i = ½(d_j·d_l' − d_l·d_j') and, there being no force, D_mᵀ r' = e3.

The paper's Table I prints κ3 = +0.22128; its own equation (34) gives −0.22128: a misprint of the sign.

    python examples/path_independence.py
"""

from __future__ import annotations

import numpy as np

import directrix as dx
from directrix.rotations import exp

AT_A, AT_B = np.array([1.0, -0.5, 0.25]), np.array([-0.4, 0.7, 0.1])
PAPER_CURVATURE = np.array([-0.66123, 0.66499, -0.22128])  # sign of the third as (34) gives it
PAPER_TIP = np.array([0.11370, -0.40047, 0.57033])


def closed_form() -> tuple[np.ndarray, np.ndarray]:
    """Curvature and displacement of B from the end rotations."""
    a, b = exp(AT_A), exp(AT_B)
    mean, slope = 0.5 * (a + b), b - a
    d, s = mean.T, slope.T
    curvature = [
        0.5 * (d[2] @ s[1] - d[1] @ s[2]),
        0.5 * (d[0] @ s[2] - d[2] @ s[0]),
        0.5 * (d[1] @ s[0] - d[0] @ s[1]),
    ]
    return np.array(curvature), np.linalg.solve(mean.T, [0.0, 0.0, 1.0]) - [0.0, 0.0, 1.0]


def main(*, first_a: float = 0.775, first_b: float = 0.4) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Curvature (3,) and tip displacement (3,) by path; path II starts with the given fractions."""
    E, G = 1.2e8, 1.2e8 / 2.6
    section = dx.Section.from_moduli(
        EA=0.1 * E, GA1=0.1 * G, GA2=0.1 * G, EI1=8.3e-5 * E, EI2=8.3e-5 * E, GJ=1.6e-4 * G
    )
    rod = dx.Model(name="path independence").rod(
        dx.line((0, 0, 0), (0, 0, 1), d1=(1, 0, 0)), section, name="rod", ends=("A", "B"), elements=1, order=1
    )
    found = {}
    for path, (a, b) in {"I": (0.5, 0.5), "II": (first_a, first_b)}.items():

        def share(factor: float, middle: float) -> float:
            return float(np.interp(factor, [0.0, 0.5, 1.0], [0.0, middle, 1.0]))

        model = rod.prescribe("A", displacement=(0, 0, 0), rotation=lambda f, m=a: share(f, m) * AT_A)
        model = model.prescribe("B", rotation=lambda f, m=b: share(f, m) * AT_B)
        result = dx.solve_static(model, steps=2, raise_on_failure=True)
        found[path] = result.rod("rod").strain[-1, 0, 3:], result.node("B").displacement[-1]
        print(f"path {path:<3} κ {found[path][0]}  u_B {found[path][1]}")
    print(f"paper    κ {PAPER_CURVATURE} (κ3 printed without its minus)  u_B {PAPER_TIP}")
    return found


def test_both_paths_end_in_the_closed_form() -> None:
    found = main()
    for one, two, exact, printed in zip(*found.values(), closed_form(), (PAPER_CURVATURE, PAPER_TIP), strict=True):
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-13)
        np.testing.assert_allclose(one, exact, rtol=0, atol=1e-12)
        np.testing.assert_allclose(one, printed, rtol=0, atol=1e-5)


if __name__ == "__main__":
    from _command import run

    run(main)
