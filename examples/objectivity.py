"""Objectivity
===========

Romero & Armero (2002), example 1; after Crisfield & Jelenić (1999).

A straight rod from A = (0, 0, 2) to B = (0, 0, 5) is clamped at A; B is displaced by ½(1/√2, −1/√2, 0) without
rotation. Then both ends turn together about (1, 1, 1) in steps of 10°. Seen from the turning frame nothing
happens, so the reactions at A must stay what they are. With interpolated rotation vectors they drift
(Figure 2); with interpolated directors they are constant to round-off.

    python examples/objectivity.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix.rotations import exp

# nine linear elements, one point, shear factor 1: an independent implementation gives the same eight digits
FORCE = np.array([-21457.6583, 21457.6583, -160654.3099])
MOMENT = np.array([-3786.5495, -3786.5495, 0.0])


def main(*, elements: int = 9, turns: int = 6, degrees: float = 10.0, out: str | None = None) -> np.ndarray:
    """Reactions at A in the turning frame, (turns + 1, 6); prints them and draws their drift if ``out`` is given."""
    E, G = 1.2e8, 1.2e8 / 2.6
    section = dx.Section.from_moduli(
        EA=0.1 * E, GA1=0.1 * G, GA2=0.1 * G, EI1=8.3e-5 * E, EI2=8.3e-5 * E, GJ=1.6e-4 * G
    )
    axis = np.ones(3) / np.sqrt(3.0)
    stretched = np.array([0.5 / np.sqrt(2.0), -0.5 / np.sqrt(2.0), 3.0])
    stages = turns + 1

    def turn(factor: float) -> np.ndarray:
        return np.radians(degrees) * max(0.0, factor * stages - 1.0) * axis

    def move(factor: float) -> np.ndarray:
        pulled = np.array([0.0, 0.0, 3.0]) + min(1.0, factor * stages) * (stretched - [0.0, 0.0, 3.0])
        return exp(turn(factor)) @ pulled - [0.0, 0.0, 3.0]

    model = (
        dx.Model(name="objectivity")
        .rod(
            dx.line((0, 0, 2), (0, 0, 5), d1=(1, 0, 0)),
            section,
            name="rod",
            ends=("A", "B"),
            elements=elements,
            order=1,
        )
        .prescribe("A", displacement=(0, 0, 0), rotation=turn)
        .prescribe("B", displacement=move, rotation=turn)
    )
    result = dx.solve_static(model, steps=stages, raise_on_failure=True)
    frames = exp(np.array([turn(f) for f in result.t[1:]]))
    reaction = result.node("A").reaction[1:]
    local = np.concatenate([np.einsum("tji,tj->ti", frames, reaction[:, k : k + 3]) for k in (0, 3)], axis=1)
    print("angle   reaction at A in the turning frame: force, moment")
    for k, row in enumerate(local):
        print(f"{k * degrees:4.0f}°  " + "  ".join(f"{v:15.6f}" for v in row))
    spread = np.abs(local - local[0]).max() / np.abs(local[0]).max()
    print(f"largest change {spread:.1e} of the reaction")
    if out is not None:
        ax = result.plot.shape(at=-1)
        path = Path(out) / "objectivity.png"
        ax.figure.savefig(path, dpi=150)
        print(path)
    return local


def test_reactions_do_not_change() -> None:
    local = main()
    np.testing.assert_allclose(
        local, np.broadcast_to(local[0], local.shape), rtol=0, atol=1e-10 * np.abs(local[0]).max()
    )
    np.testing.assert_allclose(local[0, :3], FORCE, rtol=1e-8, atol=5e-5)
    np.testing.assert_allclose(local[0, 3:], MOMENT, rtol=1e-8, atol=5e-5)


if __name__ == "__main__":
    from _command import run

    run(main)
