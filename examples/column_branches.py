"""Branches of a perfect Euler column
==================================

Bifurcations found without an imperfection, and followed.

A clamped column of unit length is pressed at its free end. The straight path is followed past its first three
bifurcations; each is left to both sides until the end of the column has turned by 60°. Reference: the elastica, whose
branch n is a quarter wave repeated 2n − 1 times. Only the first branch is stable.

    python examples/column_branches.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix.verification.branching import column, elastica_branch

TURN = np.pi / 3


def follow(model: dx.Model, mode: int = 0, side: int = 1) -> dx.Result:
    """The straight path (mode 0), or the way to the side of a mode up to the load that turns the end by 60°."""
    load = elastica_branch(mode, TURN)[0] if mode else 75.0
    control = dx.ArcLength(
        ds=0.02,
        ds_max=0.04,
        load_step=4.0,
        branch=side * mode if mode else (),
        load_factors=(load,),
        until=lambda s: s.load_factor >= load,
    )
    return dx.solve_static(model, control=control, raise_on_failure=True)


def main(*, elements: int = 48, out: str | None = None) -> dict[int, tuple[float, float]]:
    """Load of each bifurcation over that of Euler, and the turn of the end on its branch, printed beside the exact."""
    model = column(elements)
    straight = follow(model)
    assert straight.stability is not None
    branches = {(mode, side): follow(model, mode, side) for mode in (1, 2, 3) for side in (1, -1)}
    found: dict[int, tuple[float, float]] = {}
    for mode, point in enumerate(straight.stability.bifurcations[:3], 1):
        branch = branches[mode, 1]
        assert branch.stability is not None
        turned = float(np.degrees(np.arccos(branch.node("b").R[-1, 0, 0])))
        euler = (mode - 0.5) ** 2 * np.pi**2
        found[mode] = point.load_factor / euler, turned
        sort = "stable" if branch.stability.stable[-1] else f"{branch.stability.negative[-1]} negative pivots"
        print(f"branch {mode}: P/P_E = {found[mode][0]:.7f}, end turned by {turned:.4f}° (60° exactly), {sort}")
    if out is not None:
        path = Path(out) / "column_branches.png"
        draw(straight, list(branches.values()), path)
        print(path)
    return found


def draw(straight: dx.Result, branches: list[dx.Result], path: Path) -> None:
    """The branch diagram, stable full and unstable dashed, and the shapes at 60°."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    straight.plot.branches("b", "z", branches, ax=left)
    left.set(title="paths through the bifurcations", xlabel="deflection of the end", ylabel="P")
    for mode, branch in enumerate(branches[::2], 1):
        place = branch.r[-1, branch.mesh.rod("column").nodes]
        right.plot(place[:, 2], place[:, 0], lw=2, label=f"branch {mode}, P = {branch.load_factor[-1]:.2f}")
    right.plot([0, 0], [0, 1], color="#7d8791", lw=1, ls=":")
    right.set(aspect="equal", title="shapes where the end has turned by 60°")
    right.legend(frameon=False)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def test_the_first_bifurcation_and_its_branch() -> None:
    model = column(16, EA=1e4)
    branch = follow(model, 1)
    assert branch.stability is not None and branch.stability.stable[-1]
    assert abs(branch.stability.bifurcations[0].load_factor / (np.pi**2 / 4) - 1.0) < 1e-4
    assert abs(np.arccos(branch.node("b").R[-1, 0, 0]) - TURN) < 1e-4


if __name__ == "__main__":
    from _command import run

    run(main)
