"""Hanging cable and its catenary
==============================

A cable that hangs between two points, against the equation of the catenary.

``dx.catenary`` gives the curve of a chain of length 12 between points 8 apart, one 1.5 higher. A rod of that shape, so
soft in bending and so stiff in stretching that it is next to a chain, is put under its weight: it should stay where it
is, pull horizontally with w c (w the weight per length, c the parameter of the curve), and with w y at height y over
the directrix. Then one support is moved by 0.5 and the cable goes into the catenary of its new span.

    python examples/catenary_cable.py [--elements 40] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

A, B, LENGTH, WEIGHT = (0.0, 0.0, 0.0), (8.0, 0.0, 1.5), 12.0, 9.81


def main(*, elements: int = 40, out: str | None = None) -> dict[str, float]:
    """Sag, tensions and reactions beside those of the catenary."""
    curve = dx.catenary(A, B, length=LENGTH)
    EA, EI = 1e6, 1e-2
    section = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=EI, EI2=EI, GJ=EI, A_rho=1.0)
    model = (
        dx.Model(name="catenary")
        .rod(curve, section, name="cable", ends=("a", "b"), elements=elements)
        .fix("a", "x", "y", "z", "rx", "rz")
        .pin("b")
        .gravity((0, 0, -WEIGHT), constant=True)
    )
    # a chain has no stiffness before it hangs: its shape is that of the curve, and statics starts from there
    hung = dx.solve_static(model, steps=1, raise_on_failure=True)
    moved = dx.solve_static(
        dx.Model(name="moved", rods=model.rods, loads=model.loads)
        .fix("a", "x", "y", "z", "rx", "rz")
        .prescribe("b", displacement=(0.5, 0, 0)),
        steps=5, raise_on_failure=True,
    )  # fmt: skip
    after = dx.catenary(A, (8.5, 0.0, 1.5), length=LENGTH)
    s = hung.mesh.rods[0].s
    history = hung.rod("cable")
    lowest = curve._lowest
    tension = WEIGHT * np.hypot(curve.parameter, lowest + history.s)
    horizontal = -hung.node("a").reaction[-1, 0]
    found = {
        "moves from the curve": float(np.linalg.norm(hung.r[-1] - curve.position(s), axis=1).max()),
        "moved, from its curve": float(np.linalg.norm(moved.r[-1] - after.position(s), axis=1).max()),
        "horizontal pull": float(horizontal),
        "of the catenary": WEIGHT * curve.parameter,
        "tension, largest error": float(np.abs(history.force[-1, :, 2] / tension - 1.0).max()),
        "horizontal pull, moved": float(-moved.node("a").reaction[-1, 0]),
        "of its catenary": WEIGHT * after.parameter,
    }
    for name, value in found.items():
        print(f"{name:<24} {value:.9g}")
    if out is not None:
        path = Path(out) / "catenary_cable.png"
        draw(hung, moved, curve, after, tension, path)
        print(path)
    return found


def draw(hung, moved, curve, after, tension, path: Path) -> None:
    """Both shapes over their curves, and the tension along the first."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    s = np.linspace(0.0, LENGTH, 400)
    for run, chain, color in ((hung, curve, "#1f5fa8"), (moved, after, "#a02c8c")):
        left.plot(*chain.position(s)[:, [0, 2]].T, color="#8a949e", lw=4, alpha=0.5)
        left.plot(*run.r[-1][:, [0, 2]].T, ".", color=color, ms=4)
    left.set(aspect="equal", xlabel="x", ylabel="z", title="catenaries (grey) and nodes of the cable")
    history = hung.rod("cable")
    right.plot(history.s, tension, color="#8a949e", lw=4, alpha=0.5, label="w y")
    right.plot(history.s, history.force[-1, :, 2], ".", color="#1f5fa8", ms=4, label="axial force")
    right.set(xlabel="arclength", title="tension")
    right.legend()
    figure.savefig(path, dpi=130)


def test_a_cable_hangs_in_the_catenary() -> None:
    found = main(elements=30)
    assert found["moves from the curve"] <= 2e-3
    assert found["moved, from its curve"] <= 5e-3
    assert abs(found["horizontal pull"] / found["of the catenary"] - 1.0) <= 2e-3
    assert abs(found["horizontal pull, moved"] / found["of its catenary"] - 1.0) <= 2e-3
    assert found["tension, largest error"] <= 5e-3


if __name__ == "__main__":
    from _command import run

    run(main)
