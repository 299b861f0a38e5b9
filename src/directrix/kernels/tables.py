"""Flat arrays for the compiled loops, built once per run from a discretisation and a rule."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss
from directrix.discretisation import Discretisation
from directrix.formulations.element import (
    FLOWS,
    Committed,
    Jointed,
    Lossy,
    record_acts,
    record_audit,
    record_commit,
    record_lost,
    record_step,
)
from directrix.formulations.layout import HISTORY, PER_NODE, symmetric_times
from directrix.groups import Group
from directrix.kernels.compile import LANES, kernel_address, padded
from directrix.kernels.elimination import elimination_address
from directrix.kernels.record import Record
from directrix.scheme import Scheme

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ROOM = 256
"""Iterations of one try that are written down."""

__all__ = ["ROOM", "Tables", "Work", "damping_for", "in_lanes", "tables_for", "work_for"]


class Tables(Record):
    """What never changes in a run. ``head`` has one row a group, see the names in ``elements``."""

    chain: int
    eliminate: int
    head: Ints
    conn: Ints
    at: Ints
    par: Array
    station: Ints
    element_node: Ints
    row: Ints
    node_of_row: Ints
    rowptr: Ints
    diagonal: Ints
    dest: Ints
    rates: int
    half: bool
    carried: bool
    inside: bool
    nodes: int
    lumped: Array
    damping: Array
    damped: Ints
    source: Ints
    numerical: int


class Work(Record):
    """What the loops write: overwritten by every call."""

    internal: Array
    applied: Array
    reaction: Array
    node_block: Array
    before: Array
    scale: Array
    blocks: Array
    rhs: Array
    du: Array
    step: Array
    factors: Array
    out: Array
    k: Array
    r: Array
    eliminated: Array
    back: Array
    kept: Array
    notes: Array
    flow: Array
    ground: Array
    taken: Array
    done: Array
    joints: Array
    common: Array
    trail: Array


def in_lanes(parameters: Any) -> Any:
    """(ne, size) → blocks of [parameter][lane], the last one filled up with its last element."""
    ne, size = parameters.shape
    blocks = -(-ne // LANES)
    padded = parameters[np.minimum(np.arange(blocks * LANES), ne - 1)]
    return padded.reshape(blocks, LANES, size).transpose(0, 2, 1).ravel()


def _kernels(group: Group) -> tuple[int, ...]:
    layout, element = group.layout, group.element
    about = f"{layout} {element}"
    return (
        kernel_address(f"step {about}", lambda: record_step(element, layout, tangent=True)),
        kernel_address(f"residual {about}", lambda: record_step(element, layout, tangent=False)),
        kernel_address(f"audit {about}", lambda: record_audit(element, layout)),
        kernel_address(f"commit {about}", lambda: record_commit(cast(Committed, element), layout))
        if element.rows(layout)
        else 0,
        kernel_address(f"lost {about}", lambda: record_lost(cast(Lossy, element), layout))
        if group.lossy or group.works
        else 0,
        kernel_address(f"acts {about}", lambda: record_acts(cast(Jointed, element), layout)) if group.jointed else 0,
    )


def tables_for(disc: Discretisation, scheme: Scheme) -> Tables:
    """Compile or fetch the kernels and lay the arrays out flat."""
    head: list[tuple[int, ...]] = []
    conn, places, par, station = (list[Ints](), list[Ints](), list[Array](), list[Ints]())
    at: dict[str, int] = dict.fromkeys(("conn", "par", "element", "back", "at"), 0)
    history = disc.rows + (disc.nodes if scheme.nodal_rows else 0)
    for group, dest in zip(disc.groups, disc.pattern.first, strict=True):
        ne, nn = group.conn.shape
        rows = group.element.rows(group.layout)
        lanes = in_lanes(group.parameters)
        head.append(
            (
                *_kernels(group), nn, ne, at["conn"], at["par"], group.layout.size, group.layout.points,
                at["element"], at["back"], at["at"], rows, history,
                int(group.grounded), dest, group.in_pattern.shape[1],
            )
        )  # fmt: skip
        conn.append(group.conn.ravel())
        read = np.concatenate([group.conn, history + rows * np.arange(ne)[:, None] + np.arange(rows)], axis=1)
        places.append(in_lanes(PER_NODE * read))
        history += rows * ne
        par.append(lanes)
        station.append(group.station)
        for key, n in (
            ("conn", ne * nn),
            ("par", lanes.size),
            ("element", ne),
            ("back", 6 * (nn - group.in_pattern.shape[1]) * ne),
            ("at", places[-1].size),
        ):
            at[key] += n
    pattern = disc.pattern
    return Tables(
        int(pattern.chain),
        elimination_address(),
        np.array(head, np.int64),
        np.concatenate(conn),
        np.concatenate(places),
        np.concatenate(par),
        np.concatenate(station),
        np.concatenate([g.conn[:, 0] for g in disc.groups]),
        pattern.row,
        pattern.node_of_row,
        pattern.rowptr,
        pattern.diagonal,
        pattern.dest,
        int(scheme.rates),
        scheme.rates.half,
        scheme.static and any(g.element.rows(g.layout) for g in disc.groups),
        any(g.inside and g.condensed for g in disc.groups),
        disc.nodes,
        disc.lumped if scheme.lumped else np.zeros((0, 13)),
        *damping_for(disc, scheme),
        disc.sources.element,
        disc.sources.numerical,
    )


def damping_for(disc: Discretisation, scheme: Scheme) -> tuple[Array, Ints]:
    """(parts, stations, 6, 6) Q of what a step dissipates, Σ Δε·Q Δε, and the source (parts, stations) it is booked
    under: first the viscous sections, then the scheme; no parts when nothing dissipates."""
    sources, chi = disc.sources, scheme.common[2]
    matrices: list[Array] = []
    booked: list[Ints] = []
    if sources.material.max(initial=-1) >= 0:
        matrices.append(_at_stations(disc, 6, scheme.common[1]))
        booked.append(np.repeat(sources.material, [len(rod.stations) for rod in disc.mesh.rods]))
    if sources.numerical >= 0 and chi:
        matrices.append(_at_stations(disc, 1, 0.5 * chi))
        booked.append(np.full(disc.stations, sources.numerical))
    shape = (len(matrices), disc.stations)
    return np.array(matrices).reshape(*shape, 6, 6), np.array(booked, np.int64).reshape(shape)


def _at_stations(disc: Discretisation, block: int, factor: float) -> Array:
    """``factor`` times a matrix of the parameters, with the weights of the stress points, (stations, 6, 6)."""
    out = np.zeros((disc.stations, 6, 6))
    for group in disc.groups:
        parts = group.layout.split(group.parameters.T)  # type: ignore[arg-type]
        if group.names or not len(parts[block]):
            continue
        unit: Any = np.eye(6)[:, :, None]
        for k, w in enumerate(gauss(group.layout.points)[1]):
            matrix = factor * np.array(symmetric_times(group.layout.at(parts[block], k), unit))
            out[group.station + k] = (w / parts[2][k] * matrix).transpose(2, 0, 1)
    return out


def work_for(disc: Discretisation, scheme: Scheme) -> Work:
    """Workspace for one run."""
    n, rows = disc.rows, len(disc.pattern.node_of_row)
    most = max(g.layout.nn for g in disc.groups)
    history = max(HISTORY * g.element.rows(g.layout) for g in disc.groups)
    outputs = max(6 * most + 36 * most * most, 7 + most + 7 * max(g.layout.points for g in disc.groups), history, FLOWS)
    chain = disc.pattern.chain  # its solver keeps no factors, so nothing that goes with them is kept either
    inside = sum(6 * (g.layout.nn - g.in_pattern.shape[1]) * len(g.conn) for g in disc.groups)
    return Work(
        internal=np.zeros((n, 6)),
        applied=np.zeros((n, 6)),
        reaction=np.zeros((n, 6)),
        node_block=np.zeros((n, 6, 6)),
        before=np.zeros((disc.stations, 6)),
        scale=np.zeros(2),
        blocks=np.zeros((int(disc.pattern.rowptr[-1]) + 1, 6, 6)),
        rhs=np.zeros((rows, 6)),
        du=np.zeros((rows, 6)),
        step=np.zeros((n, 6)),
        factors=np.zeros((rows + 1, 56)),
        out=np.zeros(padded(outputs) * LANES),
        k=np.zeros((6 * most, 6 * most)),
        r=np.zeros(6 * most),
        eliminated=np.zeros((max(0, 6 * most - 12), max(0, 12 * most - 24))),
        back=np.zeros((inside, 13)),
        kept=np.zeros((0 if chain else inside, max(0, 6 * most - 12) + 12)),
        notes=np.zeros(5),
        flow=np.zeros(10),
        ground=np.zeros(6),
        taken=np.zeros(len(disc.sources.names)),
        done=np.zeros(len(disc.sources.names)),
        joints=np.zeros((n - disc.nodes, 12)),
        common=np.array(scheme.common),
        trail=np.zeros((ROOM, 5)),
    )
