"""Joints as elements of their own, each with a row of multipliers; what is wrong with them, by name."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from directrix.errors import ModelError
from directrix.formulations.joint import JointElement, JointLayout
from directrix.groups import Group
from directrix.joints import KINDS, Joint
from directrix.scheme import Rates, Scheme

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["joint_ends", "joint_groups", "redundant", "unused"]


def joint_groups(
    joints: Sequence[Joint], scheme: Scheme, names: dict[str, int], r0: Array, carried: bool
) -> tuple[Group, ...]:
    """Groups of equal joints; the row of joint j is ``len(r0) + j``. Raises ModelError for what a scheme has no form
    for."""
    if not joints:
        return ()
    if carried:
        raise ModelError(
            f"joint {joints[0].name!r}: SimoVuQuoc() carries its rotations from iteration to iteration and has no "
            "form for joints",
            "use dx.Directors() or dx.CrisfieldJelenic()",
            "formulation=",
        )
    places = {name: r0[k] for name, k in names.items()}
    kinds: dict[JointElement, list[int]] = {}
    for j, joint in enumerate(joints):
        if joint.damping and scheme.rates is Rates.ALPHA:
            raise ModelError(
                f"joint {joint.name!r} is damped, and the generalised-α family has no form for that",
                "use a step of the midpoint family, e.g. dx.EnergyMomentum(), or leave damping= out",
            )
        driven = joint.prescribed is not None
        element = JointElement(scheme.rates, joint.kind, joint.b is None, driven, joint.active)
        kinds.setdefault(element, []).append(j)
    groups: list[Group] = []
    for element, members in kinds.items():
        conn: Ints = np.array([[*(names[n] for n in joints[j].nodes), len(r0) + j] for j in members])
        parameters = np.array([joints[j].parameters(places) for j in members])
        layout = JointLayout(conn.shape[1], 0, True, parameters=parameters.shape[1])
        lossy = not scheme.static and any(joints[j].damping for j in members)
        nothing: Ints = np.zeros(len(members), np.int64)
        groups.append(
            Group(
                element, layout, conn, parameters, nothing, np.zeros((len(members), 0)),
                tuple(f"joint {joints[j].name!r}" for j in members), lossy, element.grounded,
                condensed=False, jointed=True,
            )
        )  # fmt: skip
    return tuple(groups)


def joint_ends(joints: Sequence[Joint], names: dict[str, int], r0: Array) -> tuple[Ints, Array]:
    """Nodes (joints, 2) of base and of what moves, −1 for the ground; arms (joints, 2, 3) from there to the joint, of
    the ground its place."""
    nodes: Ints = np.full((len(joints), 2), -1)
    arms = np.zeros((len(joints), 2, 3))
    for j, joint in enumerate(joints):
        own = [names[node] for node in joint.nodes]
        at = np.array(joint.at, float) if joint.at is not None else r0[own[-1]]
        nodes[j, 2 - len(own) :] = own
        arms[j] = at
        arms[j, 2 - len(own) :] -= r0[own]
    return nodes, arms


def unused(joints: Sequence[Joint]) -> NDArray[np.bool_]:
    """(joints, 6) multipliers that a joint does not have."""
    out = np.ones((len(joints), 6), bool)
    for row, joint in zip(out, joints, strict=True):
        kind = KINDS[joint.kind]
        lengths, angles = kind.lengths, len(kind.across)
        if joint.prescribed is not None:
            lengths, angles = lengths + (kind.free == "displacement"), angles + (kind.free == "angle")
        row[:lengths] = row[3 : 3 + angles] = False
    return out


def redundant(joints: Sequence[Joint], gradient: Array) -> list[str]:
    """Names of joints that repeat what others and the supports hold already; empty when all are independent.

    ``gradient`` (6 joints, free components) of the constraints in the state, lengths scaled to be comparable; the rows
    of multipliers that a joint does not have are zero.
    """
    used = np.flatnonzero(~unused(joints).ravel())
    rows = gradient[used]
    sizes = np.linalg.norm(rows, axis=1)
    rows = rows / np.maximum(sizes, 1e-300)[:, None]
    vectors, values, _ = np.linalg.svd(rows, full_matrices=False)
    missing = len(used) - int(np.sum(values > 1e-9)) if values.size else len(used)
    if not missing:
        return []
    if rows.shape[1] < rows.shape[0]:  # more constraints than components: the left null space needs all vectors
        vectors = np.linalg.svd(rows, full_matrices=True)[0]
    weight = np.linalg.norm(vectors[:, len(used) - missing :], axis=1)
    guilty = dict.fromkeys(int(used[k]) // 6 for k in np.flatnonzero(weight > 1e-6))
    return [joints[j].name for j in guilty]
