"""Joints that cannot be, found where a run starts: redundant ones, and velocities that pull them apart."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation
from directrix.errors import ModelError
from directrix.formulations.attached import BodyElement
from directrix.joint_groups import redundant
from directrix.joints import KINDS
from directrix.newton import Newton, axial_rates
from directrix.tangents import group_tangents

Array = NDArray[np.float64]

__all__ = ["refuse_joints"]

LARGEST = 2000  # constraints: beyond, their rank is not looked for


def refuse_joints(newton: Newton, x: Array, *, fresh: bool = True) -> None:
    """Raise ModelError for joints that repeat what others or supports hold in the state ``x``, that are not together
    there, or, when ``fresh``, that its velocities pull apart (those of a step do so a little, of second order); and for
    nodes without mass that nothing holds."""
    disc, scheme = newton.disc, newton.scheme
    if not scheme.static:
        _refuse_massless(newton, x)
    joints = disc.model.joints
    if not joints:
        return
    n, count = disc.nodes, len(joints)
    gradient, off = _constraints(newton, x)
    lengths = np.array([disc.length] * 3 + [1.0] * 3)
    off = off / lengths
    at = int(np.abs(off).max(axis=1).argmax())
    if np.abs(off[at]).max() > 1e-9:
        raise ModelError(
            f"joint {joints[at].name!r} is not together where the run starts, it is off by {np.abs(off[at]).max():.3g} "
            "of the model's size",
            "start from a state of the same joints, or prescribe its coordinate from 0 on",
        )
    free = ~disc.fixed.ravel()
    scaled = gradient / np.tile(lengths, count)[:, None]
    scaled[:, np.tile(np.arange(6) < 3, n)] *= disc.length
    if 6 * count <= LARGEST:
        again = redundant(joints, scaled[:, free])
        if again:
            names = ", ".join(repr(name) for name in again)
            one = len(again) == 1
            raise ModelError(
                f"{'joint' if one else 'joints'} {names}: {'it holds' if one else 'together they hold'} what "
                f"{'supports' if one else 'others of them, or supports,'} hold already, and what each of them carries "
                "is not determined",
                "let one of them hold less, e.g. a spherical or cylindrical joint for a hinge, or release a support",
                code="DX426",
            )
    if scheme.static or not fresh:
        return
    omega = np.einsum("nci,nc->ni", x[:n, 3:12].reshape(n, 3, 3), axial_rates(x[:n]))
    rates = np.concatenate([x[:n, 24:27], omega], axis=1).ravel()
    for j, joint in enumerate(joints):
        rows = slice(6 * j, 6 * j + 6)
        size = np.abs(gradient[rows]) @ np.abs(rates)
        speed = np.abs(gradient[rows] @ rates)
        if joint.prescribed is not None:  # its coordinate starts moving as it is told to
            speed[KINDS[joint.kind].driven] = 0.0
        if np.any(speed > 1e-9 * size + 1e-300):
            raise ModelError(
                f"the initial velocities pull joint {joint.name!r} apart",
                f"give its nodes {' and '.join(map(repr, joint.nodes))} velocities and spins that go together",
            )


def _refuse_massless(newton: Newton, x: Array) -> None:
    """Free nodes may lack mass only where constraints, links or springs of joints say how they move."""
    disc = newton.disc
    where, ways = _massless(disc)
    if not len(where) or len(where) > LARGEST:
        return
    n = disc.nodes
    pulls, holds = np.zeros((len(where), n, 6)), np.zeros((len(where), len(disc.model.joints), 6))
    for k, group in enumerate(disc.groups):
        if not group.names or isinstance(group.element, BodyElement):
            continue
        out = group_tangents(newton, x, k, symmetric=False)
        for e, nodes in enumerate(group.conn):
            for b, there in enumerate(nodes):
                for way in np.flatnonzero(where == there):
                    column = (out[e, :, 6 * b : 6 * b + 6] @ ways[way]).reshape(-1, 6)
                    for a, here in enumerate(nodes):
                        to = pulls[way, here] if here < n else holds[way, here - n]
                        to += column[a]
    pulls[:, :, 3:] /= disc.length
    holds[:, :, :3] /= disc.length
    parts = [part.reshape(len(where), -1) for part in (pulls, holds)]
    stack = np.concatenate([part / max(np.abs(part).max(initial=0.0), 1e-300) for part in parts], axis=1)
    vectors, values, _ = np.linalg.svd(stack, full_matrices=False)
    if values[-1] > 1e-12 * max(values[0], 1e-300):
        return
    loose = vectors[:, -1]
    node = int(where[np.abs(loose).argmax()])
    motion = np.einsum("w,wc->c", loose * (where == node), ways)
    name = disc.mesh.label(node)
    if all(body.node != name for body in disc.model.bodies):
        does = "moves" if np.any(np.round(motion[:3], 6)) else "turns"
        raise ModelError(
            f"node {name!r} has no mass, and nothing says how it {does}",
            "give it .point_mass or .rigid_body, or hold it with joints or supports",
            code="DX427",
        )
    axis = motion[3:] / np.linalg.norm(motion[3:])
    about = ", ".join(f"{c + 0.0:.3g}" for c in np.round(axis * np.sign(axis[np.abs(axis).argmax()]), 9))
    raise ModelError(
        f"node {name!r} has no rotary inertia about ({about}) and nothing holds that turn, its speed is not determined",
        "give it .rigid_body with inertia about that line, or a joint or support that holds the turn",
        code="DX427",
    )


def _massless(disc: Discretisation) -> tuple[NDArray[np.int64], Array]:
    """Nodes (m,) on no rod, and how they could move (m, 6) without moving a mass; turns in units of the size."""
    model = disc.model
    on_rods = {name for rod in model.rods for name in rod.names}
    bodies = {body.node: body for body in model.bodies}
    where: list[int] = []
    ways: list[Array] = []
    for node in model.nodes:
        if node.name in on_rods:
            continue
        k = disc.mesh.node_names[node.name]
        free = ~disc.fixed[k]
        body = bodies.get(node.name)
        found: list[Array] = []
        if body is None:
            found += list(np.eye(6)[free])
        else:
            turns = np.flatnonzero(free[3:])
            values, vectors = np.linalg.eigh(body.inertia[np.ix_(turns, turns)])
            for value, vector in zip(values, vectors.T, strict=True):
                if value <= 1e-12 * np.abs(body.inertia).max():
                    way = np.zeros(6)
                    way[3 + turns] = vector
                    found.append(way)
        where += [k] * len(found)
        ways += found
    out = np.array(ways).reshape(-1, 6)
    out[:, 3:] /= disc.length
    return np.array(where, np.int64), out


def _constraints(newton: Newton, x: Array) -> tuple[Array, Array]:
    """Gradient (6 joints, 6 n) of the constraints in the state, and their values (joints, 6)."""
    disc = newton.disc
    n, count = disc.nodes, len(disc.model.joints)
    gradient = np.zeros((count, 6, n, 6))
    for k, group in enumerate(disc.groups):
        if not group.jointed:
            continue
        out = group_tangents(newton, x, k, symmetric=False)
        for e, nodes in enumerate(group.conn):
            for a, node in enumerate(nodes[:-1]):
                gradient[nodes[-1] - n, :, node] += out[e, -6:, 6 * a : 6 * a + 6]
    newton.applied(x, np.zeros((disc.rows, 12)))
    return gradient.reshape(6 * count, 6 * n), newton.work.internal[n:].copy()
