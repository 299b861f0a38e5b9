"""The models of the paper's six examples, with its meshes unless told otherwise."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.curves import DirectorRule
from directrix.rotations import exp

Array = NDArray[np.float64]

__all__ = ["bend", "cantilever_pulse", "free_flight", "hinged_frame", "properties", "two_ends", "two_turns"]


def properties(
    E: float, nu: float, A: float, inertia: float, J: float, rho: float = 0.0, shear_factor: float = 1.0
) -> dx.Section:
    """A section with equal moments of inertia, by the numbers the paper gives."""
    G = E / (2.0 * (1.0 + nu))
    GA = shear_factor * G * A
    return dx.Section.from_moduli(
        EA=E * A, GA1=GA, GA2=GA, EI1=E * inertia, EI2=E * inertia, GJ=G * J,
        A_rho=rho * A, I_rho1=rho * inertia, I_rho2=rho * inertia,
    )  # fmt: skip


def two_ends(
    *, elements: int = 9, order: int = 1, shear_factor: float = 1.0, turns: int = 6, degrees: float = 10.0
) -> tuple[dx.Model, Array]:
    """Example 1: a rod with displaced end, then both ends turned together ``turns`` times about (1, 1, 1).

    Returns the model, to be solved in turns + 1 steps, and the frames after each of them, (turns + 1, 3, 3).
    """
    stages = turns + 1
    axis = np.ones(3) / np.sqrt(3.0)
    straight = np.array([0.0, 0.0, 3.0])
    pull = 0.5 * np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)

    def turn(factor: float) -> Array:
        return np.radians(degrees) * max(0.0, factor * stages - 1.0) * axis

    def move(factor: float) -> Array:
        return exp(turn(factor)) @ (straight + min(1.0, factor * stages) * pull) - straight

    section = properties(1.2e8, 0.3, 0.1, 8.3e-5, 1.6e-4, shear_factor=shear_factor)
    model = (
        dx.Model(name="objectivity")
        .rod(
            dx.line((0, 0, 2), (0, 0, 5), d1=(1, 0, 0)),
            section,
            name="rod",
            ends=("A", "B"),
            elements=elements,
            order=order,
        )
        .prescribe("A", displacement=(0, 0, 0), rotation=turn)
        .prescribe("B", displacement=move, rotation=turn)
    )
    return model, exp(np.array([turn((k + 1) / stages) for k in range(stages)]))


AT_A, AT_B = (1.0, -0.5, 0.25), (-0.4, 0.7, 0.1)


def two_turns(first_a: float = 0.5, first_b: float = 0.5, elements: int = 1) -> dx.Model:
    """Example 2: both ends turned to given rotations in two steps; the first goes the given fractions of the way."""

    def turn(whole: Array, first: float, factor: float) -> Array:
        return np.interp(factor, [0.0, 0.5, 1.0], [0.0, first, 1.0]) * whole

    axis = dx.line((0, 0, 0), (0, 0, 1), d1=(1, 0, 0))
    return (
        dx.Model(name="path independence")
        .rod(axis, properties(1.2e8, 0.3, 0.1, 8.3e-5, 1.6e-4), name="rod", ends=("A", "B"), elements=elements, order=1)
        .prescribe("A", displacement=(0, 0, 0), rotation=partial(turn, np.array(AT_A), first_a))
        .prescribe("B", rotation=partial(turn, np.array(AT_B), first_b))
    )


def hinged_frame(elements: int = 5) -> dx.Model:
    """Example 3: a column from A to the corner C and a beam from C to B, 120 each, that turn about z at A and B.

    Quadratic elements, as many in each member; unit load down at P, 24 from the corner.
    """
    section = properties(7.2e6, 0.3, 6.0, 2.0, 4.0)
    column, beam = dx.line((0, 0, 0), (0, 120, 0)), dx.line((0, 120, 0), (120, 120, 0))
    model = dx.Model(name="hinged frame").rod(column, section, name="column", ends=("A", "C"), elements=elements)
    model = model.rod(beam, section, name="beam", ends=("C", "B"), elements=elements, nodes={"P": 0.2})
    hinge = ("x", "y", "z", "rx", "ry")
    return model.force("P", (0, -1, 0)).fix("A", *hinge).fix("B", *hinge)


def bend(
    force: float = 600.0, elements: int = 8, order: int = 1, *, directors: DirectorRule | None = None,
    J: float = 1.0 / 6.0, shear_factor: float = 1.0, side: float = 1.0,
) -> dx.Model:  # fmt: skip
    """Example 4: an eighth of a circle of radius 100 in the x–z plane with square section, its tip loaded along y.

    ``J`` of the unit square, ``side`` of the section; linear elements are straight (directors along the chord) unless
    ``directors`` says otherwise. The unloaded tip is at (70.71, 0, 29.29).
    """
    c = 100.0 * np.sqrt(0.5)
    s, half = 100.0 * np.sin(np.pi / 8), 100.0 * (1.0 - np.cos(np.pi / 8))
    rule: DirectorRule = directors or ("chord" if order == 1 else "tangent")
    curve = dx.arc((0, 0, 0), (s, 0, half), (c, 0, 100.0 - c), directors=rule)
    section = properties(1e7, 0.0, side**2, side**4 / 12.0, J * side**4, shear_factor=shear_factor)
    return (
        dx.Model(name=f"45° bend, F = {force:g}")
        .rod(curve, section, name="bend", ends=("root", "tip"), elements=elements, order=order)
        .clamp("root")
        .force("tip", (0, force, 0))
    )


def free_flight() -> dx.Model:
    """Example 5: three rods at right angles, three nodes of which get a velocity."""
    section = properties(5e5, 0.3, 0.005, 2e-5, 4e-5, rho=500.0)
    return (
        dx.Model(name="free flight")
        .rod(dx.line((0, 3, 0), (0, 0, 0)), section, name="left", ends=("A", "O"), elements=5, order=1)
        .rod(dx.line((0, 0, 0), (3, 0, 0)), section, name="mid", ends=("O", "B"), elements=5, order=1)
        .rod(dx.line((3, 0, 0), (3, 0, 3)), section, name="right", ends=("B", "C"), elements=5, order=1)
        .velocity("A", (0, 0, -1))
        .velocity("B", (0, 0, 2))
        .velocity("C", (0, -1, 0))
    )


def cantilever_pulse() -> dx.Model:
    """Example 6: force and moment 100 t/6 (1, 1, 1) on the tip of a cantilever until t = 6, then nothing."""

    def pulse(t: float) -> Array:
        return np.full(3, 100.0 * t / 6.0 if t <= 6.0 else 0.0)

    section = properties(2e10, 0.3, 5e-4, 1.2e-6, 5e-7, rho=15e3)
    return (
        dx.Model(name="cantilever pulse")
        .rod(dx.line((0, 0, 0), (10, 0, 0)), section, name="rod", ends=("root", "tip"), elements=10, order=1)
        .clamp("root")
        .force("tip", pulse)
        .moment("tip", pulse)
    )
