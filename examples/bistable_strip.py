"""Bistable strip
==============

A strip, clamped at both ends and buckled, is pushed at its middle until it snaps to the other side.

The first half of the way is symmetric. The strip leaves it at a bifurcation, where the compression reaches that of the
antisymmetric mode, P = 4 × 4.4934² EI/L², tan 4.4934 = 4.4934: long before the symmetric shape would give way. For a
strip that was shortened by a small d the equation EI w⁗ + P w″ = F δ(½L) gives the pushing force there in proportion
to √d; it is solved below. Deployable structures that hold two shapes without power are held by this force.

    python examples/bistable_strip.py [--shortening 0.002] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

import directrix as dx

LENGTH, EI = 1.0, 1.0
SECTION = dx.Section.from_moduli(EA=1e8, GA1=1e8, GA2=1e8, EI1=EI, EI2=1e3 * EI, GJ=1e3 * EI)


def strip(elements: int) -> dx.Model:
    """Along x, bends in the x–z plane."""
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="bistable strip").rod(
        axis, SECTION, name="strip", ends=("a", "b"), elements=elements, nodes={"middle": 0.5}
    )
    return model.clamp("a").fix("b", "rx", "ry", "rz")


def theory(shortening: float) -> tuple[float, float]:
    """Force on the middle and compression where the shallow strip leaves its symmetric shapes."""
    tau = 2.0 * brentq(lambda x: np.tan(x) - x, 4.4, 4.6)
    # half of the strip under F = 1: w′ = a (cos τx − 1) + b sin τx, no slope at ½, shear force ½ there
    system = [[np.cos(tau / 2) - 1.0, np.sin(tau / 2)], [-(tau**2), 0.0]]
    a, b = np.linalg.solve(system, [0.0, 0.5])
    length = quad(lambda x: (a * (np.cos(tau * x) - 1.0) + b * np.sin(tau * x)) ** 2, 0.0, 0.5)[0]  # 2 × ½ ∫ w′²
    return float(np.sqrt(shortening / length)), tau**2


def push(elements: int, shortening: float) -> dx.Result:
    """Buckled by a given shortening upwards, then pushed down at the middle along the symmetric path."""
    lift = 400.0 * EI / LENGTH**2 * np.sqrt(shortening / np.pi**2)  # bends it by about that much
    bent = strip(elements).fix("b", "y", "z").force("middle", (0, 0, lift))
    start = dx.solve_static(bent, steps=2, raise_on_failure=True)
    moved = float(start.node("b").displacement[-1, 0])
    buckled = strip(elements).prescribe("b", displacement=lambda f: (moved - f * (shortening + moved), 0.0, 0.0))
    buckled = buckled.force("middle", lambda f: (0.0, 0.0, lift * (1.0 - f)), constant=True)
    start = dx.solve_static(buckled, steps=10, start=start, raise_on_failure=True)
    held = strip(elements).prescribe("b", displacement=lambda factor: (-shortening, 0.0, 0.0))
    rise = float(start.node("middle").r[-1, 2])
    control = dx.DisplacementControl("middle", "z", to=0.3 * rise, steps=20)
    return dx.solve_static(held.force("middle", (0, 0, -1)), start=start, control=control, raise_on_failure=True)


def main(*, shortening: float = 0.002, elements: int = 24, out: str | None = None) -> dict[str, float]:
    """Force and compression at the bifurcation over theory."""
    result = push(elements, shortening)
    assert result.stability is not None
    point = result.stability.bifurcations[0]
    force, compression = theory(shortening)
    found = {
        "force": point.load_factor / force,
        "compression": float(-result.node("b").reaction[point.index, 0] / compression),
    }
    print(f"snaps at F = {point.load_factor:.5f}, shallow theory {force:.5f}, ratio {found['force']:.5f}")
    print(f"compression there over theory {found['compression']:.5f}")
    if out is not None:
        path = Path(out) / "bistable_strip.png"
        draw(result, path)
        print(path)
    return found


def draw(result: dx.Result, path: Path) -> None:
    """Force over the height of the middle, unstable dashed; shapes."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    z, F, good = result.node("middle").r[:, 2], result.load_factor, result.stability.stable
    left.plot(z, F, color="#7d8791", lw=1.5, ls="--", label="unstable")
    left.plot(z[good], F[good], color="#1f6fb4", lw=2.5, label="stable")
    point = result.stability.bifurcations[0]
    left.plot(z[point.index], F[point.index], "o", color="#c0392f", label="it snaps")
    left.set(xlabel="height of the middle", ylabel="pushing force", title="symmetric path")
    left.invert_xaxis()
    left.legend(frameon=False)
    for k in np.linspace(0, point.index, 5).astype(int):
        right.plot(result.r[k, :, 0], result.r[k, :, 2], color="#1f6fb4", lw=1.5)
    shape = result.r[point.index] + 0.02 * point.modes[0, :, :3] / np.abs(point.modes[0, :, :3]).max()
    right.plot(shape[:, 0], shape[:, 2], color="#c0392f", lw=1.5, label="how it leaves")
    right.set(xlabel="x", ylabel="z")
    right.legend(frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_strip_snaps_where_the_antisymmetric_mode_is_reached() -> None:
    found = main()
    assert abs(found["force"] - 1.0) < 5e-3
    assert abs(found["compression"] - 1.0) < 5e-3


if __name__ == "__main__":
    from _command import run

    run(main)
