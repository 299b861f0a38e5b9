"""Writhing rod
============

A twisted rod under tension writhes into a loop.

Both ends of a straight rod are clamped; one may slide along the axis, is pulled there with T, and is turned. The rod
stays straight until the moment reaches that of Greenhill's equation for clamped ends, then gives its twist to a helix
that gathers into a loop: the path is unstable from there on, the turn falls. After all, at one whole turn, the rod is a
loop in a plane and no twist is left in it: the elastica with one loop, which that turn has to meet exactly.

    python examples/writhing_rod.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix.verification.branching import greenhill, pulled, twisted_rod


def writhe(elements: int = 64, tension: float = 100.0, C: float = 0.8, steps: int = 220) -> dx.Result:
    """The straight rod up to its bifurcation, then the writhing one until the turn is a whole one again."""
    model = twisted_rod(elements, tension, C)
    whole = 2.0 * np.pi
    control = dx.ArcLength(
        ds=0.02,
        load_step=3.0,
        branch=1,
        max_steps=steps,
        load_factors=(whole,),
        until=lambda s: s.node("B").displacement[0] < -0.1 and s.load_factor <= whole,
    )
    return dx.solve_static(model, start=pulled(model, tension), control=control, raise_on_failure=True)


def main(*, elements: int = 64, out: str | None = None) -> dict[str, float]:
    """Critical moment beside Greenhill's, and how far the loop is from a plane at one whole turn."""
    tension, C = 100.0, 0.8
    result = writhe(elements, tension, C)
    assert result.stability is not None
    moment = C * result.stability.bifurcations[0].load_factor
    loop = result.r[-1, result.mesh.rod("rod").nodes]
    spread = np.linalg.svd(loop - loop.mean(axis=0), compute_uv=False)
    found = {"moment": moment / greenhill(tension), "off plane": float(spread[2] / spread[0])}
    print(f"critical moment {moment:.5f}, over Greenhill's {found['moment']:.6f}")
    print(f"at one turn the end has come {-result.node('B').displacement[-1, 0]:.4f} nearer, off plane {spread[2]:.1e}")
    twist = float(np.abs(result.rod("rod").force[-1, :, 5]).max())
    print(f"largest torque left there {twist:.1e}")
    if out is not None:
        path = Path(out) / "writhing_rod.png"
        draw(result, path)
        print(path)
    return found


def draw(result: dx.Result, path: Path) -> None:
    """Turn over end shortening, and the rod on the way."""
    from matplotlib import pyplot as plt

    assert result.stability is not None
    at = result.stability.bifurcations[0].index
    figure = plt.figure(figsize=(13, 4), layout="constrained")
    left = figure.add_subplot(1, 3, 1)
    result.plot.branches("B", "x", ax=left)
    left.set(xlabel="movement of the end", ylabel="turn [rad]", title="turn of the end")
    pen = figure.add_subplot(1, 3, (2, 3), projection="3d")
    picked = np.linspace(at, len(result.t) - 1, 5).astype(int)
    for k, (which, colour) in enumerate(zip(picked, plt.get_cmap("viridis")(np.linspace(0, 0.88, 5)), strict=True)):
        r = result.r[which, result.mesh.rod("rod").nodes]
        pen.plot(r[:, 0], r[:, 1] + 0.3 * k, r[:, 2], color=colour, lw=2, label=f"{result.load_factor[which]:.1f} rad")
    pen.set_box_aspect((1.0, 1.3, 0.3), zoom=1.4)
    pen.set(ylim=(-0.1, 1.2), zlim=(-0.15, 0.15))
    pen.view_init(elev=40, azim=-75)
    pen.set_axis_off()
    pen.legend(frameon=False, loc="center left", bbox_to_anchor=(0.95, 0.5))
    figure.savefig(path, dpi=150)
    plt.close(figure)


def test_the_rod_writhes_into_a_plane_loop() -> None:
    result = writhe(32)
    assert result.stability is not None
    assert abs(0.8 * result.stability.bifurcations[0].load_factor / greenhill(100.0) - 1.0) < 3e-3
    loop = result.r[-1, result.mesh.rod("rod").nodes]
    spread = np.linalg.svd(loop - loop.mean(axis=0), compute_uv=False)
    assert spread[2] < 1e-6 * spread[0] and result.load_factor[-1] == 2.0 * np.pi
    crossed = loop[:, 0].argmax() < len(loop) // 2 or np.any(np.diff(loop[:, 0]) < 0.0)
    assert crossed and np.abs(result.rod("rod").force[-1, :, 5]).max() < 1e-6


if __name__ == "__main__":
    from _command import run

    run(main)
