"""How far a static step may turn things: interpolated directors bend back softly when an element is turned by much.

Between nodes that are turned by φ against one another, interpolated directors carry a moment like sin φ cos φ. It is
largest at 45° and vanishes at 90°: there an element balances without having anything to say about the rod.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation
from directrix.formulations.directors import DirectorStep
from directrix.newton import Newton, turn_of
from directrix.result import Status
from directrix.rotations import exp

Array = NDArray[np.float64]

__all__ = ["folded", "within_reach"]

SOFT = np.radians(45.0)
STEP = np.radians(7.5), np.radians(30.0)  # of a support: least and most that it may turn
FOLDED = np.radians(85.0)


def within_reach(newton: Newton, x: Array, done: float, goal: float, least: float) -> float:
    """``goal``, or a load factor nearer to ``done``, where ``x`` is, up to which no support turns an element to SOFT;
    not nearer than ``least``."""
    disc = newton.disc
    if isinstance(newton.scheme.element, DirectorStep) and any(turn is not None for _, _, turn in disc.prescribed):
        step = float(np.clip(SOFT - _worst(disc, x)[0], *STEP))
        while goal - done > least and _turn(disc, done, goal) > step:
            goal = 0.5 * (done + goal)
    return goal


def folded(newton: Newton, x: Array) -> Status | None:
    """What speaks against the equilibrium ``x``: an element that is turned by a right angle between its nodes."""
    if not isinstance(newton.scheme.element, DirectorStep):
        return None
    angle, node = _worst(newton.disc, x)
    if angle < FOLDED:
        return None
    return Status(
        "not_converged",
        f"an element at {newton.disc.mesh.place(node)} is turned by {np.degrees(angle):.0f}° between its nodes, where "
        "it balances whatever the rod does.",
        "Refine the mesh, or raise the order.",
    )


def _worst(disc: Discretisation, x: Array) -> tuple[float, int]:
    """Largest angle [rad] between neighbouring nodes of an element, counted from the reference, and one of the two."""
    pairs = [np.stack([g.conn[:, :-1], g.conn[:, 1:]], -1).reshape(-1, 2) for g in disc.groups if g.owners]
    if not pairs:
        return 0.0, 0
    a, b = np.concatenate(pairs).T
    dots = np.einsum("ni,ni->n", x[a, 3:12], x[b, 3:12])
    worst = int(np.argmin(dots))
    return turn_of(float(dots[worst])), int(a[worst])


def _turn(disc: Discretisation, a: float, b: float) -> float:
    """Largest angle [rad] between a support at load factor ``a`` and itself at ``b``."""
    turns = (turn for _, _, turn in disc.prescribed if turn is not None)
    return max((turn_of(float((exp(turn(a)) * exp(turn(b))).sum())) for turn in turns), default=0.0)
