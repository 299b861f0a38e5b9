"""Follower force
==============

A cantilever under a force at its tip that stays normal to it (Argyris 1981; Simo & Vu-Quoc 1986).

Length 100, EI 3.5e7, EA 3.23076e8, GA 1.61538e8; the force grows to 134 000 and turns the tip by 177° and back. In the
frame of the tip the force is known and the moment is zero, so the exact solution is one integration from the tip to the
root, without iteration: that is what the tip is compared with at eight loads.

    python examples/follower_cantilever.py [--elements 80] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix.verification.references import follower

LENGTH, EI, EA, GA = 100.0, 3.5e7, 3.23076e8, 1.61538e8
LAST, STEPS = 134e3, 67
LOADS = (10e3, 20e3, 40e3, 60e3, 80e3, 100e3, 120e3, 134e3)


def main(*, elements: int = 80, out: str | None = None) -> dict[str, float]:
    """Axial and transverse displacement of the tip at eight loads; the largest error, over the length."""
    section = dx.Section.from_moduli(EA=EA, GA1=GA, GA2=GA, EI1=EI, EI2=EI, GJ=EI)
    axis = dx.line((0, 0, 0), (LENGTH, 0, 0))
    model = dx.Model(name="follower force").rod(axis, section, name="beam", ends=("root", "tip"), elements=elements)
    model = model.clamp("root").force("tip", (0, LAST, 0), follower=True)
    result = dx.solve_static(model, steps=STEPS, raise_on_failure=True)
    u = result.node("tip").displacement
    found: dict[str, float] = {}
    worst = 0.0
    print(f"{'P':>8} {'u':>14} {'v':>14}   exact")
    for load in LOADS:
        k = round(load / LAST * STEPS)
        exact = follower(load, EI, EA, GA, LENGTH)
        found[f"u({load:g})"], found[f"v({load:g})"] = float(u[k, 0]), float(u[k, 1])
        worst = max(worst, float(np.abs(u[k, :2] - exact[:2]).max() / LENGTH))
        print(f"{load:8g} {u[k, 0]:14.6f} {u[k, 1]:14.6f}   {exact[0]:.6f} {exact[1]:.6f}")
    found["largest error"] = worst
    print(f"largest error over the length: {worst:.2e}")
    if out is not None:
        print(picture(result, Path(out) / "follower_cantilever.png"))
    return found


def picture(result: dx.Result, path: Path) -> Path:
    """Shapes at the eight loads, and the way of the tip with the exact points."""
    from matplotlib import pyplot

    figure, (shape, way) = pyplot.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    nodes = result.mesh.rod("beam").nodes
    force = LAST * result.load_factor
    for load in (0.0, *LOADS):
        k = round(load / LAST * STEPS)
        shape.plot(*result.r[k][nodes, :2].T, lw=1.5, label=f"{load / 1e3:g}")
    shape.set(title="shapes, force in thousands", xlabel="x", ylabel="y", aspect="equal")
    u = result.node("tip").displacement
    exact = np.array([follower(load, EI, EA, GA, LENGTH) for load in LOADS])
    for k, name in enumerate(("axial", "transverse")):
        way.plot(force / 1e3, u[:, k], lw=1.5, label=name)
        way.plot(np.array(LOADS) / 1e3, exact[:, k], "ko", ms=4, label="exact" if k else None)
    way.set(title="displacement of the tip", xlabel="force in thousands")
    shape.legend(fontsize=8)
    way.legend()
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    return path


def test_every_row_is_within_a_hundred_thousandth() -> None:
    found = main()
    assert found["largest error"] <= 1e-5
    # two numbers of the table in the validation suite
    assert abs(found["u(10000)"] + 41.692934) <= 1e-3 and abs(found["v(134000)"] + 49.525101) <= 1e-3


if __name__ == "__main__":
    from _command import run

    run(main)
