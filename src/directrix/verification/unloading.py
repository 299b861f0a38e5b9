"""1.5 Stress-free recovery: an elastic rod has no memory of its loads."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.paper.models import bend
from directrix.verification.models import equilibrium
from directrix.verification.record import Case, Check

Array = NDArray[np.float64]


def _back() -> Iterator[Check]:
    """Load, load reversed, no load, each as a part of one path."""

    def force(f: float) -> Array:
        return np.array([0.0, 600.0 * np.interp(f, (0, 1 / 3, 2 / 3, 1), (0, 1, -1, 0)), 0.0])

    def moment(f: float) -> Array:
        return np.array([0.0, 0.0, 4e3 * np.interp(f, (0, 1 / 3, 1), (0, 1, 0))])

    model = bend(0.0, 8, 2)
    model = model.force("tip", force, constant=True).moment("tip", moment, constant=True)
    result = dx.solve_static(model, steps=12, raise_on_failure=True)
    gone = float(np.abs(result.r - result.r[0]).max())
    yield Check.law("positions", "returns", float(np.abs(result.r[-1] - result.r[0]).max()) / 100.0, 1e-10)
    yield Check.law("rotations", "returns", float(np.abs(result.R[-1] - result.R[0]).max()), 1e-10)
    yield Check.control("it had moved by half its radius", "dead load", gone > 50.0)


def _increments() -> Iterator[Check]:
    tips = {steps: equilibrium(bend(600.0, 8, 2), steps).node("tip").r[-1] for steps in (1, 8, 10)}
    for steps in (1, 10):
        gap = float(np.abs(tips[steps] - tips[8]).max()) / 100.0
        yield Check.law(f"45° bend, tip: {steps} against 8 increments", "the same equilibrium", gap, 1e-10)


CASES = (
    Case("unloading", "1.5", "Load, reverse, return", _back),
    Case("increments", "1.5", "The number of increments does not matter", _increments),
)
