"""The state of a run, (≥ n, 40): per node (r1, R1 e_i), (Δr, R0 e_i) and the rates (ṙ, Ṙ e_i), Δr = r1 − r0; then
a row for every joint (six multipliers, its coordinate; at 12 and 13 what is prescribed and what drives), and rows of
history where a formulation or a scheme has one. A state is all there is: a copy is a way back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from directrix.checks import shown
from directrix.discretisation import Discretisation, rates_of
from directrix.errors import ModelError
from directrix.formulations.joint import TARGET
from directrix.formulations.layout import HISTORY, PER_NODE
from directrix.result import Result
from directrix.rotations import exp
from directrix.scheme import Scheme

Array = NDArray[np.float64]

__all__ = ["has_history", "initial_state", "place_all", "place_supports", "stand"]


def initial_state(disc: Discretisation, start: Result | None, scheme: Scheme) -> Array:
    """(≥ n, 40): the reference at rest or ``start``'s last instant, with the velocities of the model added.

    Behind the nodes come the rows of history: accelerations of the nodes (zero unless ``start`` has them), then the
    Gauss points that carry a rotation. Raises ModelError when ``start`` belongs to another mesh, or has no history
    and the formulation needs one.
    """
    n, joints = disc.nodes, disc.rows - disc.nodes
    history = [
        np.zeros((joints, HISTORY)),
        np.zeros((n if scheme.nodal_rows else 0, HISTORY)),
        *(g.history.reshape(-1, HISTORY) for g in disc.groups),
    ]
    rows = np.concatenate(history)
    x = np.zeros((n + len(rows), PER_NODE))
    x[n:, :HISTORY] = rows
    nodes = x[:n]
    rotation = np.broadcast_to(np.eye(3), (n, 3, 3))
    nodes[:, :3] = disc.mesh.r0
    if start is not None:
        if not isinstance(start, Result):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError(f"start = {shown(start)} is not a result", "give what simulate or solve_static returned")
        if start.r.shape[1] != n or not np.array_equal(start.mesh.r0, disc.mesh.r0):
            raise ModelError(
                f"start= holds another mesh ({start.r.shape[1]} nodes, the model has {n})",
                "start from a result of the same rods and elements",
            )
        nodes[:, :3], rotation = start.r[-1], start.R[-1]
        nodes[:, 24:27] = start.v[-1]
        nodes[:, 27:36] = _columns(start.Rdot[-1])
        if start.mesh.joints != disc.mesh.joints:
            raise ModelError(
                f"start= has the joints {', '.join(start.mesh.joints) or 'none'}, "
                f"the model {', '.join(disc.mesh.joints) or 'none'}",
                "start from a result of a model with the same joints",
            )
        if joints:
            x[n : n + joints, :HISTORY] = start.history[-1][:joints]
        if has_history(start, scheme):
            x[n:, :HISTORY] = start.history[-1]
        elif any(g.history.size for g in disc.groups):
            raise ModelError(
                "start= was computed by another formulation and holds no rotations at the Gauss points",
                "start from a result of the same formulation",
            )
    nodes[:, 3:12] = _columns(rotation)
    if not scheme.static and not (start is not None and start.kind == "dynamic"):
        v, omega = disc.initial_rates()
        nodes[:, 24:27] += v
        nodes[:, 27:36] += _columns(rates_of(rotation, omega))
    nodes[:, 15:24] = nodes[:, 3:12]
    return x


def has_history(start: Result | None, scheme: Scheme) -> bool:
    """True when ``start`` carries what ``scheme`` needs to go on beside positions and velocities."""
    rows = 0 if start is None else start.history.shape[1] - len(start.mesh.joints)
    return start is not None and rows > 0 and start.info.get("element") == repr(scheme.element)


def stand(x: Array, nodes: int) -> None:
    """Count the next step from the state ``x`` as it is."""
    x[:nodes, 12:15], x[:nodes, 15:24] = 0.0, x[:nodes, 3:12]


def place_supports(disc: Discretisation, x: Array, t: float) -> bool:
    """Move prescribed nodes to where they are at ``t`` (statics: load factor); True when anything moved."""
    before = x[: disc.nodes, :12].copy()
    for node, displacement, rotation in disc.prescribed:
        if displacement is not None:
            to = disc.mesh.r0[node] + displacement(t)
            x[node, 12:15] += to - x[node, :3]
            x[node, :3] = to
        if rotation is not None:
            x[node, 3:12] = exp(rotation(t)).T.ravel()
    moved = not np.array_equal(before, x[: disc.nodes, :12])
    for joint, value in disc.driven:
        x[disc.nodes + joint, TARGET] = value(t)
    return moved


def place_all(disc: Discretisation, x: Array, t: float) -> bool:
    """:func:`place_supports` for a discretisation whose supports may be elsewhere than they were."""
    nodes, given = x[: disc.nodes], {node for node, displacement, _ in disc.prescribed if displacement is not None}
    held = disc.fixed[:, :3].copy()
    held[list(given)] = False
    moved = np.where(held, disc.mesh.r0 - nodes[:, :3], 0.0)
    nodes[:, :3] = np.where(held, disc.mesh.r0, nodes[:, :3])
    nodes[:, 12:15] += moved
    return place_supports(disc, x, t) or bool(np.any(moved))


def _columns(rotation: Array) -> Array:
    return np.swapaxes(rotation, -1, -2).reshape(len(rotation), 9)
