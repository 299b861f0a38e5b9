"""Heavy top
=========

A fast spinning body on a ball joint, falling and precessing under gravity.

Mass 15, inertia diag(0.234375, 0.46875, 0.234375) about the centre, which is at (0, 1, 0) from a spherical joint on
the ground; spin (0, 150, −4.61538), g = 9.81 along −z. The centre of mass is a node of its own, there is no rod.

The reference is Euler's equations about the fixed point, integrated to twelve digits with a quaternion: nothing of
this library is in it. The verification manual of kynema prints the displacement of the centre at t = 2 from its own
step; it is 1.2e-6 off. Here every step is second order in Δt, and two of them extrapolated meet Euler's equations to
the seventh digit. Whatever the step, the ledger of energy closes, and with it that of the momenta, the force of
the joint included; the angular momentum about the vertical through the joint stays what it is.

    python examples/heavy_top.py [--dt 0.001] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix.verification.heavy_top import KYNEMA, exact, top


def main(*, dt: float = 1e-3, t_end: float = 2.0, out: str | None = None) -> dict[str, np.ndarray]:
    """Displacements (3,) of the centre at the end: with Δt, with Δt/2, extrapolated, exact, printed; and worst laws."""
    runs = [dx.simulate(top(), t_end, h, save_every=4, raise_on_failure=True) for h in (dt, 0.5 * dt)]
    coarse, fine = (run.node("centre").displacement[-1] for run in runs)
    found = {"Δt": coarse, "Δt/2": fine, "extrapolated": (4.0 * fine - coarse) / 3.0, "exact": exact(t_end)}
    for name, u in found.items():
        print(f"{name:<14} {u}   off by {np.abs(u - found['exact']).max():.1e}")
    if t_end == 2.0:
        print(f"{'kynema':<14} {KYNEMA}   off by {np.abs(KYNEMA - found['exact']).max():.1e}")
    print(runs[-1])
    found["laws"] = np.array([max(run.audit.entries[k].value for run in runs) for k in range(3)])
    vertical = runs[-1].momentum.angular[:, 2]
    found["vertical"] = np.ptp(vertical) / np.linalg.norm(runs[-1].momentum.angular[0])
    if out is not None:
        path = Path(out) / "heavy_top.png"
        draw(runs[-1], path)
        print(path)
    return found


def draw(result: dx.Result, path: Path) -> None:
    """Where the centre goes on its sphere, and how hard the joint holds."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(11, 4.8), layout="constrained")
    space = figure.add_subplot(1, 2, 1, projection="3d")
    space.plot(*result.node("centre").r.T, color="#1f6fb4", lw=1.2)
    result.plot.shape(ax=space)
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        axis.set_major_locator(plt.MaxNLocator(4))
    pen = figure.add_subplot(1, 2, 2)
    force = result.joint("ball").force[1:]
    for k, (name, colour) in enumerate(zip("xyz", ("#c0392f", "#2b8a4b", "#2463ab"), strict=True)):
        pen.plot(result.t[1:], force[:, k], color=colour, lw=1.2, label=f"$F_{name}$")
    pen.plot(result.t[1:], np.linalg.norm(force, axis=1), color="#1b2733", lw=1.8, label="|F|")
    pen.axhline(15 * 9.81, color="#7d8791", ls=":", label="weight")
    pen.set(xlabel="t", ylabel="force of the ball joint on the top")
    pen.legend(frameon=False, ncols=5, loc="upper center", bbox_to_anchor=(0.5, -0.14))
    figure.savefig(path, dpi=150)


def test_the_top_moves_as_euler_says() -> None:
    found = main(dt=2e-3)
    error = {name: float(np.abs(found[name] - found["exact"]).max()) for name in ("Δt", "Δt/2", "extrapolated")}
    assert 3.9 < error["Δt"] / error["Δt/2"] < 4.1
    assert error["extrapolated"] < 3e-6
    assert np.abs(KYNEMA - found["exact"]).max() < 2e-6
    assert found["laws"].max() <= 1e-10
    assert found["vertical"] <= 1e-11


if __name__ == "__main__":
    from _command import run

    run(main)
