"""1.4 Large rotation of the support of a loaded elbow (after Jelenić & Crisfield 1999, example 4).

The force 5 on the tip is normal to the frame and the support turns about its direction, so that nothing changes in the
turning frame. The table of the source was not at hand: the law is checked, not its numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.result import Result
from directrix.rotations import exp
from directrix.verification.models import elbow
from directrix.verification.record import Case, Check

Array = NDArray[np.float64]


EIGHTHS = 8


def spun(turns: int, **options: Any) -> Result:
    """Saved instant 0 is unloaded, 1 loaded, every later one has the support 45° further; options of solve_static."""
    stages = 1 + turns * EIGHTHS

    def turn(f: float) -> Array:
        return np.array([0.0, 0.0, max(0.0, f * stages - 1.0) * 2.0 * np.pi / EIGHTHS])

    def load(f: float) -> Array:
        return np.array([0.0, 0.0, 5.0 * min(1.0, f * stages)])

    model = elbow(5, 2).prescribe("root", displacement=(0, 0, 0), rotation=turn)
    model = model.force("tip", load, constant=True)
    return dx.solve_static(model, steps=stages, raise_on_failure=True, **options)


def in_frame(result: Result) -> tuple[Array, Array]:
    """Stored energy and place (3,) of the tip seen from the turning support, of every loaded instant."""
    angles = np.arange(len(result.t) - 1) * 2.0 * np.pi / EIGHTHS
    frames = exp(angles[:, None] * np.array([0.0, 0.0, 1.0]))
    return result.energy.stored[1:], np.einsum("tji,tj->ti", frames, result.node("tip").r[1:])


def _spun(turns: int) -> Iterator[Check]:
    result = spun(turns)
    energy, tip = in_frame(result)
    moved = float(np.linalg.norm(tip[0] - result.mesh.r0[result.mesh.node("tip")]))
    name = f"{turns} turns of the support by 45°"
    yield Check.law(f"{name}: energy", "constant in the turning frame", float(np.ptp(energy) / energy[0]), 1e-8)
    yield Check.law(f"{name}: tip", "constant in the turning frame", float(np.abs(tip - tip[0]).max() / moved), 1e-8)


CASES = (
    Case("support-turns", "1.4", "A loaded elbow, its support turned ten times", lambda: _spun(10)),
    Case("support-turns-100", "1.4", "A loaded elbow, its support turned a hundred times", lambda: _spun(100), "long"),
)
