"""Michell's ring
==============

A closed ring that is twisted buckles out of its plane at a total twist of 2π√3 B/C.

A straight rod with bending stiffness B and torsional stiffness C is bent to a ring. Its end is then turned about its
tangent against its beginning, where both are held: that takes away the rigid motions of the closed ring and nothing
else. The twist is the load factor. At 2π√3 B/C (Michell, 1890) the ring leaves its plane; the path behind is unstable,
the twist falls, and the ring folds to a figure of eight.

    python examples/michell_ring.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix.verification.branching import bent_to_a_ring


def twist(elements: int, B: float, C: float, steps: int = 90) -> dx.Result:
    """The ring twisted up to its bifurcation, then along the path out of its plane."""
    model, bent = bent_to_a_ring(elements, B, C)
    control = dx.ArcLength(ds=0.02, load_step=2.0, branch=1, max_steps=steps)
    return dx.solve_static(model, start=bent, control=control, raise_on_failure=True)


def main(*, elements: int = 48, out: str | None = None) -> dict[float, float]:
    """Critical twist over Michell's for three ratios of the stiffnesses."""
    found: dict[float, float] = {}
    for ratio in (1.0, 1.25, 1.5):
        result = twist(elements, 1.0, 1.0 / ratio, steps=40)
        assert result.stability is not None
        point = result.stability.bifurcations[0]
        found[ratio] = point.load_factor / (2.0 * np.pi * np.sqrt(3.0) * ratio)
        print(f"B/C = {ratio:4.2f}: critical twist {point.load_factor:.6f}, over 2π√3 B/C {found[ratio]:.6f}")
    if out is not None:
        path = Path(out) / "michell_ring.png"
        draw(twist(elements, 1.0, 0.8), path)
        print(path)
    return found


def draw(result: dx.Result, path: Path) -> None:
    """The twist over the way out of the plane, and shapes on it."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(13, 4), layout="constrained")
    left = figure.add_subplot(1, 4, 1)
    high = np.ptp(result.r[:, :, 2], axis=1)
    assert result.stability is not None
    at = result.stability.bifurcations[0].index
    left.plot(high[: at + 1], result.load_factor[: at + 1], color="#1f6fb4", label="stable")
    left.plot(high[at:], result.load_factor[at:], "--", color="#d2601a", label="unstable")
    left.plot(high[at], result.load_factor[at], "o", mfc="white", color="#d2601a")
    left.set(xlabel="height of the ring", ylabel="twist [rad]", title="twist")
    left.legend(frameon=False)
    for k, which in enumerate(np.linspace(at, len(result.t) - 1, 3).astype(int)):
        pen = figure.add_subplot(1, 4, k + 2, projection="3d")
        r = result.r[which, result.mesh.rod("rod").nodes]
        middle = r.mean(axis=0)
        pen.plot(*(r - middle).T, color="#1f6fb4", lw=2.5)
        pen.set(xlim=(-0.2, 0.2), ylim=(-0.2, 0.2), zlim=(-0.2, 0.2), title=f"twist {result.load_factor[which]:.2f}")
        pen.view_init(elev=25, azim=-60)
        pen.set_box_aspect((1, 1, 1), zoom=1.3)
        pen.set_axis_off()
    figure.savefig(path, dpi=150)
    plt.close(figure)


def test_the_critical_twist_converges() -> None:
    off = []
    for elements in (16, 24):
        result = twist(elements, 1.0, 0.8, steps=26)
        assert result.stability is not None
        off.append(1.0 - result.stability.bifurcations[0].load_factor / (2.0 * np.pi * np.sqrt(3.0) / 0.8))
    assert 0.0 < off[1] < 6e-4 and abs(np.log(off[0] / off[1]) / np.log(1.5) - 4.0) < 0.5


if __name__ == "__main__":
    from _command import run

    run(main)
