"""The state of a run, (n, 40): per node (r1, R1 e_i), (Δr, R0 e_i) and the rates (ṙ, Ṙ e_i); Δr = r1 − r0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from directrix.checks import shown
from directrix.discretisation import Discretisation, rates_of
from directrix.errors import ModelError
from directrix.formulations.directors import PER_NODE
from directrix.result import Result
from directrix.rotations import exp

Array = NDArray[np.float64]

__all__ = ["initial_state", "place_supports"]


def initial_state(disc: Discretisation, start: Result | None, dynamic: bool) -> Array:
    """(n, 40): the reference at rest or ``start``'s last instant, with the velocities of the model added.

    Raises ModelError when ``start`` belongs to another mesh.
    """
    x = np.zeros((disc.nodes, PER_NODE))
    rotation = np.broadcast_to(np.eye(3), (disc.nodes, 3, 3))
    x[:, :3] = disc.mesh.r0
    if start is not None:
        if not isinstance(start, Result):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError(f"start = {shown(start)} is not a result", "give what simulate or solve_static returned")
        if start.r.shape[1] != disc.nodes or not np.array_equal(start.mesh.r0, disc.mesh.r0):
            raise ModelError(
                f"start= holds another mesh ({start.r.shape[1]} nodes, the model has {disc.nodes})",
                "start from a result of the same rods and elements",
            )
        x[:, :3], rotation = start.r[-1], start.R[-1]
        x[:, 24:27] = start.v[-1]
        x[:, 27:36] = _columns(start.Rdot[-1])
    x[:, 3:12] = _columns(rotation)
    if dynamic and not (start is not None and start.kind == "dynamic"):
        v, omega = disc.initial_rates()
        x[:, 24:27] += v
        x[:, 27:36] += _columns(rates_of(rotation, omega))
    x[:, 15:24] = x[:, 3:12]
    return x


def place_supports(disc: Discretisation, x: Array, t: float) -> bool:
    """Move prescribed nodes to where they are at ``t`` (statics: load factor); True when anything moved."""
    before = x[:, :12].copy()
    for node, displacement, rotation in disc.prescribed:
        if displacement is not None:
            to = disc.mesh.r0[node] + displacement(t)
            x[node, 12:15] = to - x[node, :3]
            x[node, :3] = to
        if rotation is not None:
            x[node, 3:12] = exp(rotation(t)).T.ravel()
    return not np.array_equal(before, x[:, :12])


def _columns(rotation: Array) -> Array:
    return np.swapaxes(rotation, -1, -2).reshape(len(rotation), 9)
