"""Piano string
============

The partials of a stiff string are not harmonic: f_n = n f0 √(1 + B n²).

A steel wire of 1 mm and 1 m is pulled with 700 N between two pins. Its bending stiffness raises the partials: Fletcher
(1964) has B = π² EI/(T L²), f0 = √(T/m)/2L for Euler's beam. The sine is the exact shape for the exact rod too: with
w = W sin kS, ψ = P cos kS, stretch λ = 1 + T/EA and k = nπ/L its equations become

    ω² (m W, ρI P) = [GA k², −k (λGA − T); −k (λGA − T), EI k² + λ (λGA − T)] (W, P),

which is what the partials are compared with. The wire is first stretched, then the vibrations about that state are
computed.

    python examples/piano_string.py [--partials 10] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.linalg import eigh

import directrix as dx

LENGTH, RADIUS, TENSION = 1.0, 5e-4, 700.0
STEEL = dx.Section.circle(radius=RADIUS, E=2e11, nu=0.3, rho=7850.0)


def string(elements: int) -> dx.Model:
    """Hinged at both ends; the right one slides while the wire is pulled."""
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="piano string").rod(axis, STEEL, name="wire", ends=("a", "b"), elements=elements)
    return model.fix("a", "x", "y", "z", "rx", "ry").fix("b", "y", "z", "rx", "ry").force("b", (TENSION, 0, 0))


def theory(n: int) -> tuple[float, float]:
    """Partial n in Hz of the exact rod, and Fletcher's."""
    c, k, stretch = STEEL.stiffness, n * np.pi / LENGTH, 1.0 + TENSION / STEEL.stiffness[2, 2]
    shear = stretch * c[0, 0] - TENSION
    stiffness = np.array([[c[0, 0] * k**2, -k * shear], [-k * shear, c[3, 3] * k**2 + stretch * shear]])
    exact = np.sqrt(eigh(stiffness, np.diag([STEEL.A_rho, STEEL.I_rho[0, 0]]), eigvals_only=True)[0]) / (2.0 * np.pi)
    length, mass = stretch * LENGTH, STEEL.A_rho / stretch  # of the wire as it is
    B = np.pi**2 * c[3, 3] / (TENSION * length**2)
    return float(exact), float(n / (2.0 * length) * np.sqrt(TENSION / mass) * np.sqrt(1.0 + B * n**2))


def main(*, partials: int = 10, elements: int = 120, out: str | None = None) -> dict[str, np.ndarray]:
    """Partials in Hz beside the exact and Fletcher's, and how many cents they are above the harmonic ones."""
    model = string(elements)
    taut = dx.solve_static(model, steps=1, raise_on_failure=True)
    modes = dx.modes(model, about=taut, count=2 * partials + 4)
    size = np.abs(modes.shapes).max(axis=1)
    others = np.maximum(size[:, 0], np.maximum(size[:, 2], RADIUS * size[:, 3]))
    across = modes.frequencies[size[:, 1] > others][:partials]  # the pins let it turn about z
    exact, fletcher = np.array([theory(n) for n in range(1, partials + 1)]).T
    n = np.arange(1, partials + 1)
    found = {
        "computed": across,
        "exact": exact,
        "Fletcher": fletcher,
        "cents": 1200 * np.log2(across / (n * across[0])),
    }
    for k, cents in enumerate(found["cents"]):
        row = f"{across[k]:10.4f} Hz, exact {exact[k]:10.4f}, Fletcher {fletcher[k]:10.4f}, {cents:5.2f} cents"
        print(f"partial {k + 1:2}: {row}")
    if out is not None:
        path = Path(out) / "piano_string.png"
        draw(found, path)
        print(path)
    return found


def draw(found: dict[str, np.ndarray], path: Path) -> None:
    """How far the partials are from harmonic."""
    from matplotlib import pyplot as plt

    n = np.arange(1, len(found["cents"]) + 1)
    figure, pen = plt.subplots(figsize=(7, 4.5), layout="constrained")
    pen.plot(n, 1200 * np.log2(found["exact"] / (n * found["exact"][0])), color="#1f6fb4", label="exact")
    pen.plot(n, found["cents"], "o", color="#c0392f", label="computed")
    pen.set(xlabel="partial", ylabel="cents above the harmonic", title="a stiff string is out of tune with itself")
    pen.legend(frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_partials_are_those_of_a_stiff_string() -> None:
    found = main()
    assert np.abs(found["computed"] / found["exact"] - 1.0).max() < 2e-5
    assert np.abs(found["Fletcher"] / found["exact"] - 1.0).max() < 2e-4
    assert found["cents"][-1] > 5.0  # the stiffness is seen


if __name__ == "__main__":
    from _command import run

    run(main)
