"""1.3 Rigid motions: of a stressed rod at rest, of free rods, of a loaded one through whole turns."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.result import Result
from directrix.rotations import exp, log
from directrix.verification.record import Case, Check

Array = NDArray[np.float64]

SECTION = dx.Section.from_moduli(
    EA=2e3, GA1=8e2, GA2=7e2, EI1=3.0, EI2=2.0, GJ=1.5, A_rho=1.0, I_rho1=2e-3, I_rho2=3e-3
)


def _arc(name: str) -> dx.Model:
    """A quarter circle of radius 1 from the origin to (1, 1, 0)."""
    curve = dx.arc((0, 0, 0), (np.sqrt(0.5), 1.0 - np.sqrt(0.5), 0), (1, 1, 0))
    return dx.Model(name=name).rod(curve, SECTION, name="rod", ends=("root", "tip"), elements=6)


def _carried() -> Iterator[Check]:
    """Its end displaced and turned, and then all of it moved rigidly, in four steps."""
    stages, axis, shift = 5, np.array([0.7, -1.1, 1.9]), np.array([3.0, -2.0, 5.0])
    end = np.array([1.0, 1.0, 0.0])

    def loaded(f: float) -> float:
        return min(1.0, f * stages)

    def moved(f: float) -> float:
        return max(0.0, f * stages - 1.0)

    def root(f: float) -> Array:
        return moved(f) * shift

    def root_turn(f: float) -> Array:
        return moved(f) * axis

    def tip(f: float) -> Array:
        there = end + loaded(f) * np.array([-0.2, -0.1, 0.3])
        return exp(root_turn(f)) @ there + root(f) - end

    def tip_turn(f: float) -> Array:
        return log(exp(root_turn(f)) @ exp(loaded(f) * np.array([0.4, -0.3, 0.8])))

    model = _arc("carried along")
    model = model.prescribe("root", displacement=root, rotation=root_turn)
    result = dx.solve_static(
        model.prescribe("tip", displacement=tip, rotation=tip_turn), steps=stages, raise_on_failure=True
    )
    energy, force = result.energy.stored[1:], result.force[1:]
    change = float(np.abs(force - force[0]).max() / np.abs(force[0]).max())
    yield Check.law("stressed arc moved rigidly: energy", "invariant", float(np.ptp(energy) / energy[0]), 1e-11)
    yield Check.law("stressed arc moved rigidly: section forces", "invariant", change, 1e-10)


def _free(name: str, v: tuple[float, float, float], omega: tuple[float, float, float]) -> Result:
    section = dx.Section.circle(radius=0.05, E=1e6, nu=0.3, rho=1e3)
    model = dx.Model(name=name).rod(dx.line((0, 0, 0), (0.6, 0, 0)), section, name="rod", ends=("a", "b"), elements=2)
    return dx.simulate(
        model.rigid_velocity(v, omega, about=(0.3, 0, 0)), t_end=4.0, dt=0.02, save_every=10, raise_on_failure=True
    )


def _flights() -> Iterator[Check]:
    motions = {
        "torque-free rotation": ((0.0, 0, 0), (2.0, 1.0, -3.0)),
        "translation": ((1.0, -2.0, 0.5), (0.0, 0, 0)),
        "spin about the axis": ((0.0, 0, 0), (5.0, 0, 0)),
    }
    for name, (v, omega) in motions.items():
        result = _free(name, v, omega)
        scale = 10 * np.linalg.norm(v) or np.linalg.norm(result.momentum.angular[0])
        for law, h in (("H", result.energy.total), ("L", result.momentum.linear), ("J", result.momentum.angular)):
            size = result.energy.total[0] if law == "H" else scale
            yield Check.law(f"{name}: {law}", "conserved", float(np.abs(h - h[0]).max() / size), 1e-11)
        if name == "translation":
            gone = np.array([4.0 * np.array(v)] * result.r.shape[1])
            yield Check.of(f"{name}: displacement", "v t", "A", gone, result.r[-1] - result.mesh.r0, 1e-12)
        if name == "spin about the axis":
            yield Check.law(f"{name}: axis at rest", "stays", float(np.abs(result.r - result.mesh.r0).max()), 1e-12)


def _turns() -> Iterator[Check]:
    """Stage 1 loads, every further one turns the root by 45° about z."""
    turns, eighths = 10, 8
    stages = 1 + turns * eighths

    def turn(f: float) -> Array:
        return np.array([0.0, 0.0, max(0.0, f * stages - 1.0) * 2.0 * np.pi / eighths])

    def load(f: float) -> Array:
        return min(1.0, f * stages) * np.array([0.3, 0.2, 0.4])

    model = _arc("root turned").prescribe("root", displacement=(0, 0, 0), rotation=turn)
    model = model.force("tip", load, constant=True)
    result = dx.solve_static(model, steps=stages, raise_on_failure=True)
    energy = result.energy.stored[1:]
    whole = energy[::eighths]
    yield Check.law("energy after whole turns", "returns", float(np.ptp(whole) / whole[0]), 1e-9)
    yield Check.control("energy on the way varies", "dead load", bool(np.ptp(energy) > 0.1 * whole[0]))


CASES = (
    Case("rigid-motion", "1.3", "A stressed arc moved rigidly: energy and section forces", _carried),
    Case("rigid-flight", "1.3", "Free rods: rotation, translation, spin", _flights),
    Case("whole-turns", "1.3", "A loaded quarter circle whose root is turned ten times", _turns),
)
