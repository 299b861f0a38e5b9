"""A synthetic result of a three-rod frame, so that plots, viewer and storage are tested without a solver."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from directrix.audit import Audit, Entry
from directrix.basis import gauss
from directrix.result import Energy, Mesh, Momentum, Result, RodMesh, Status

Array = NDArray[np.float64]

LENGTH = 3.0
STIFFNESS = np.array([960.0, 960.0, 2500.0, 1.6, 1.6, 1.2])


def fake_result(
    kind: Literal["static", "dynamic"] = "dynamic",
    *,
    instants: int = 40,
    t_end: float = 7.8,
    order: int = 1,
    elements: int = 5,
    planar: bool = False,
    fails: bool = False,
    names: tuple[str, str, str] = ("left", "mid", "right"),
    title: str = "three-rod frame",
) -> Result:
    """An inextensible frame A, O, B, C whose directors follow a smooth law; positions follow from them.

    Dynamic: free flight with a turn, a drift and two bending modes; total energy 2.5 (growing to 7 when it
    ``fails``). Static: clamped at A, rolled up by the load factor. ``planar`` keeps all of it in the x-y
    plane. The sections are a circle, a rectangle and one without outline.
    """
    mesh = _mesh(order, elements, planar, names)
    dynamic = kind == "dynamic"
    t = np.linspace(0.0, t_end if dynamic else 1.0, instants)
    poses = [_pose(mesh, time, dynamic, planar) for time in t]
    r, rotation = np.stack([p[0] for p in poses]), np.stack([p[1] for p in poses])
    v, rate, reaction = np.zeros_like(r), np.zeros_like(rotation), np.zeros((instants, len(mesh.r0), 6))
    if dynamic:
        h = 1e-5
        ahead, behind = ([_pose(mesh, time + d, True, planar) for time in t] for d in (h, -h))
        v = np.stack([(a[0] - b[0]) / (2 * h) for a, b in zip(ahead, behind, strict=True)])
        rate = np.stack([(a[1] - b[1]) / (2 * h) for a, b in zip(ahead, behind, strict=True)])
    else:
        reaction[:, mesh.node_names["A"]] = t[:, None] * np.array([0.4, 0.0, -1.2, 0.3, 2.4, -0.7])
    strain = np.concatenate([_strain(mesh, rod, rotation) for rod in mesh.rods], axis=1)
    weight = sum(rod.s[-1] for rod in mesh.rods) / strain.shape[1]
    stored = 0.5 * weight * np.einsum("tqi,i->t", strain**2, STIFFNESS)
    return Result(
        kind=kind,
        name=title,
        mesh=mesh,
        t=t,
        load_factor=np.ones(instants) if dynamic else t.copy(),
        r=r,
        R=rotation,
        v=v,
        Rdot=rate,
        reaction=reaction,
        strain=strain,
        force=strain * STIFFNESS,
        energy=_energy(t, stored, dynamic, fails),
        momentum=Momentum(
            np.tile((0.0, -0.75, 2.25), (instants, 1)) * dynamic,
            np.tile((2.1, -8.7, -2.25), (instants, 1)) * dynamic,
        ),
        iterations=np.full(instants - 1, 4, np.int64),
        status=_status(t[-1], fails),
        audit=_audit(dynamic, fails),
        info={"directrix": "0.1.0", "formulation": "Directors()"}
        | ({"integrator": "Midpoint()" if fails else "EnergyMomentum()"} if dynamic else {}),
    )


def with_joints(result: Result) -> Result:
    """The same with node 0 on the ground at (1, −20, 2), and a joint that both ends hold on arms."""
    nodes = np.array([[-1, 0], [1, result.r.shape[1] - 1]])
    arms = np.array([[(1.0, -20.0, 2.0), (0.0, 0.5, 0.0)], [(0.3, 0.2, 0.1), (0.0, 0.0, -0.4)]])
    mesh = replace(result.mesh, joints=("pin", "arms"), joint_nodes=nodes, joint_arms=arms)
    return replace(result, mesh=mesh)


def _mesh(order: int, elements: int, planar: bool, names: tuple[str, str, str]) -> Mesh:
    corners = np.array([(0, 1, 0), (0, 0, 0), (1, 0, 0), (1, 1, 0) if planar else (1, 0, 1)]) * LENGTH
    first = np.array([(1, 0, 0), (0, 1, 0), (1, 0, 0)], float)  # d1: the axis least aligned with the rod
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    outlines = (
        0.08 * np.column_stack([np.cos(turn), np.sin(turn)]),
        np.array([(-0.06, -0.12), (0.06, -0.12), (0.06, 0.12), (-0.06, 0.12)]),
        np.zeros((0, 2)),
    )
    steps = elements * order
    s = np.linspace(0.0, LENGTH, steps + 1)
    xi = gauss(order)[0]
    stations = (LENGTH / elements * (np.arange(elements)[:, None] + 0.5 * (xi + 1.0))).ravel()
    rods = []
    for k, name in enumerate(names):
        d3 = (corners[k + 1] - corners[k]) / LENGTH
        frame = np.column_stack([first[k], np.cross(d3, first[k]), d3])
        rods.append(
            RodMesh(
                name, k * steps + np.arange(steps + 1), s, np.tile(frame, (steps + 1, 1, 1)), order,
                stations, k * len(stations), outlines[k],
            )
        )  # fmt: skip
    r0 = np.concatenate([corners[:1]] + [corners[k] + rods[k].directors[0, :, 2] * s[1:, None] for k in range(3)])
    return Mesh(tuple(rods), {"A": 0, "O": steps, "B": 2 * steps, "C": 3 * steps}, r0)


def _turns(total: Array, t: float, dynamic: bool, planar: bool) -> Array:
    """Rotations (k, 3, 3) at the arclengths ``total`` (k,) counted from A through the frame."""
    z = total / (3.0 * LENGTH)
    if dynamic:
        bend = np.outer(np.sin(np.pi * z) * np.sin(1.1 * t), (0.5, -0.4, 0.7))
        bend += np.outer(np.cos(2.0 * np.pi * z) * np.sin(1.9 * t), (-0.35, 0.45, 0.3))
    else:
        bend = np.outer(t * z, (0.5, 0.9, -1.6))
    whole = np.array([0.12, -0.2, 0.35]) * t * dynamic
    if planar:
        bend[:, :2] = whole[:2] = 0.0
    return (Rotation.from_rotvec(whole) * Rotation.from_rotvec(bend)).as_matrix()


def _pose(mesh: Mesh, t: float, dynamic: bool, planar: bool) -> tuple[Array, Array]:
    """Positions (n, 3) and rotations (n, 3, 3): directors from the law, positions by the midpoint rule."""
    n, fine = len(mesh.r0), 16
    total = np.linspace(0.0, 3.0 * LENGTH, n)
    middle = (np.arange((n - 1) * fine) + 0.5) * 3.0 * LENGTH / ((n - 1) * fine)
    tangent = np.repeat(np.diff(mesh.r0, axis=0), fine, axis=0) / fine
    moved = np.einsum("kij,kj->ki", _turns(middle, t, dynamic, planar), tangent)
    r = np.concatenate([np.zeros((1, 3)), np.cumsum(moved, axis=0)])[::fine] + mesh.r0[0]
    if dynamic:
        drift = np.array([0.0, -0.17, 0.0 if planar else 0.5]) * t
        r += mesh.r0.mean(axis=0) - r.mean(axis=0) + drift
    return r, _turns(total, t, dynamic, planar)


def _strain(mesh: Mesh, rod: RodMesh, rotation: Array) -> Array:
    """(nt, stations, 6): curvature from neighbouring nodes in the section's frame, a little axial strain."""
    one = rotation[:, rod.nodes] @ rod.directors
    between = np.swapaxes(one[:, :-1], -1, -2) @ one[:, 1:]
    turn = Rotation.from_matrix(between.reshape(-1, 3, 3)).as_rotvec().reshape(*between.shape[:2], 3)
    curvature = turn / np.diff(rod.s)[:, None]
    strain = np.zeros((len(rotation), len(rod.stations), 6))
    cell = np.clip(np.searchsorted(rod.s, rod.stations) - 1, 0, curvature.shape[1] - 1)
    strain[..., 3:] = curvature[:, cell]
    strain[..., 2] = 0.01 * curvature[:, cell, 0]
    return strain


def _energy(t: Array, stored: Array, dynamic: bool, fails: bool) -> Energy:
    none = np.zeros_like(t)
    if not dynamic:
        return Energy(none, stored, stored.copy(), none, none)
    total = 2.5 + (4.5 * (t / t[-1]) ** 6 if fails else none)
    stored = np.minimum(stored, 0.9 * total)
    return Energy(total - stored, stored, none, none, none)


def _status(end: float, fails: bool) -> Status:
    if not fails:
        return Status("done", f"Reached {end:g} in all steps asked for.")
    return Status(
        "not_converged",
        f"Newton found no solution in the step after t = {end:g}; the residual stayed largest at B.",
        "Use a conserving integrator or a smaller step.",
    )


def _audit(dynamic: bool, fails: bool) -> Audit:
    if not dynamic:
        laws = (("balance of forces", 2e-12, 1e-7, "1.2"), ("balance of moments", 3e-12, 1e-7, "2.5"))
        return Audit(tuple(Entry(*law) for law in laws), 0.35, "mid, element 2", 1e-3)
    return Audit(
        (
            Entry("energy", 1.8 if fails else 4e-13, 1e-9, "2.5"),
            Entry("linear momentum", 2e-14, 1e-9, "2.37"),
            Entry("angular momentum", 3e-14, 1e-9, "9.23"),
        ),
        0.62,
        "right, element 1",
        4e-3,
        ("right, element 1 turns by 36° between its nodes; refine or raise the order",),
    )
