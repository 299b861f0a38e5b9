"""1.4 Large rotation of the support of a loaded elbow (after Jelenić & Crisfield 1999, example 4).

The force 5 on the tip is normal to the frame and the support turns about its direction, so that nothing changes in the
turning frame. The table of the source was not at hand: the law is checked, not its numbers.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.rotations import exp
from directrix.verification.models import elbow
from directrix.verification.record import Case, Check

Array = NDArray[np.float64]


def _spun(turns: int) -> Iterator[Check]:
    eighths = 8
    stages = 1 + turns * eighths

    def turn(f: float) -> Array:
        return np.array([0.0, 0.0, max(0.0, f * stages - 1.0) * 2.0 * np.pi / eighths])

    def load(f: float) -> Array:
        return np.array([0.0, 0.0, 5.0 * min(1.0, f * stages)])

    model = elbow(5, 2).prescribe("root", displacement=(0, 0, 0), rotation=turn)
    model = model.force("tip", load, constant=True)
    result = dx.solve_static(model, steps=stages, raise_on_failure=True)
    energy = result.energy.stored[1:]
    frames = exp(np.array([turn(f) for f in result.t[1:]]))
    tip = np.einsum("tji,tj->ti", frames, result.node("tip").r[1:])
    moved = float(np.linalg.norm(tip[0] - result.mesh.r0[result.mesh.node("tip")]))
    name = f"{turns} turns of the support by 45°"
    yield Check.law(f"{name}: energy", "constant in the turning frame", float(np.ptp(energy) / energy[0]), 1e-8)
    yield Check.law(f"{name}: tip", "constant in the turning frame", float(np.abs(tip - tip[0]).max() / moved), 1e-8)


CASES = (
    Case("support-turns", "1.4", "A loaded elbow, its support turned ten times", lambda: _spun(10)),
    Case("support-turns-100", "1.4", "A loaded elbow, its support turned a hundred times", lambda: _spun(100), "long"),
)
