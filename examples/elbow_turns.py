"""A loaded elbow whose support turns a hundred times
==================================================

After Jelenić & Crisfield (1999), example 4.

Two legs of 10 at a right angle, EA = GA = 10⁶, EI = GJ = 10³, five quadratic elements each. A force 5 on the tip,
normal to the frame, comes first; then the support turns about its direction in steps of 45°. Seen from the turning
frame nothing happens, so stored energy and tip must stay what they are. They do for a hundred turns, to 1e-8 and
better; an element that adds up rotation vectors (Simo & Vu-Quoc 1986) does not get back after one.

The table of the source was not at hand: the law is checked, not its numbers.

    python examples/elbow_turns.py [--turns 100] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from _command import slow

import directrix as dx
from directrix.verification.support_turns import in_frame, spun


def main(*, turns: int = 100, rival_turns: int = 10, out: str | None = None) -> dict[str, float]:
    """Largest relative change of energy and tip, seen from the turning frame; the rival's beside it."""
    runs = {"directors": spun(turns), "Simo & Vu-Quoc": spun(rival_turns, formulation=dx.SimoVuQuoc())}
    found: dict[str, float] = {}
    for name, result in runs.items():
        energy, tip = in_frame(result)
        moved = np.linalg.norm(tip[0] - result.mesh.r0[result.mesh.node("tip")])
        found[f"{name}: energy"] = float(np.ptp(energy) / energy[0])
        found[f"{name}: tip"] = float(np.abs(tip - tip[0]).max() / moved)
    found["balance"] = max(entry.value for entry in runs["directors"].audit.entries)
    for name, value in found.items():
        print(f"{name:<24} changes by {value:.1e}")
    print(runs["directors"])
    if out is not None:
        path = Path(out) / "elbow_turns.png"
        draw(runs, path)
        print(path)
    return found


def draw(runs: dict[str, dx.Result], path: Path) -> None:
    """One turn of the elbow, and how far energy and tip stray, turn after turn."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(12, 5), layout="constrained")
    space = figure.add_subplot(1, 2, 1, projection="3d")
    result = runs["directors"]
    for k in range(1, 9):
        for rod in result.mesh.rods:
            space.plot(*result.r[k, rod.nodes].T, color=plt.colormaps["viridis"]((k - 1) / 9), lw=2)
    space.plot(*result.node("tip").r[1:10].T, ":", color="#7d8791")
    space.set_aspect("equal")
    space.set(xlabel="x", ylabel="y", zlabel="z", title="the first turn, 45° a step")
    pen = figure.add_subplot(1, 2, 2)
    for (name, run), colour in zip(runs.items(), ("#1f6fb4", "#d2601a"), strict=True):
        energy, _ = in_frame(run)
        pen.semilogy(
            np.arange(len(energy)) / 8,
            np.maximum(np.abs(energy / energy[0] - 1.0), 1e-17),
            color=colour,
            label=name,
            lw=1,
        )
    pen.axhline(1e-8, color="#7d8791", ls=":", label="1e-8")
    pen.set(xlabel="turns of the support", ylabel="relative change of the stored energy")
    pen.legend(frameon=False)
    figure.savefig(path, dpi=140)


def test_turns_change_nothing(turns: int = 5) -> None:
    found = main(turns=turns, rival_turns=1)
    assert found["directors: energy"] <= 1e-8
    assert found["directors: tip"] <= 1e-8
    assert found["balance"] <= 1e-10
    assert found["Simo & Vu-Quoc: energy"] >= 1e-4


@slow
def test_many_turns_change_nothing() -> None:
    test_turns_change_nothing(100)


if __name__ == "__main__":
    from _command import run

    run(main)
