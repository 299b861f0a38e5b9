"""Flat arrays for the compiled loops, built once per run from a discretisation and a rule."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation, Group
from directrix.formulations.directors import PER_NODE, Rule, record_audit, record_step
from directrix.kernels.compile import LANES, kernel_address, padded
from directrix.kernels.elimination import elimination_address

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Tables", "Work", "tables_for", "work_for"]


class Tables(NamedTuple):
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


class Work(NamedTuple):
    """What the loops write: overwritten by every call."""

    internal: Array
    reaction: Array
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
    flow: Array
    dt: Array


def _in_lanes(parameters: Any) -> Any:
    """(ne, size) → blocks of [parameter][lane], the last one filled up with its last element."""
    ne, size = parameters.shape
    blocks = -(-ne // LANES)
    padded = parameters[np.minimum(np.arange(blocks * LANES), ne - 1)]
    return padded.reshape(blocks, LANES, size).transpose(0, 2, 1).ravel()


def _kernels(group: Group, rule: Rule) -> tuple[int, int, int]:
    layout = group.layout
    about = f"{layout} {rule}"
    return (
        kernel_address(f"step {about}", lambda: record_step(layout, rule, tangent=True)),
        kernel_address(f"residual {about}", lambda: record_step(layout, rule, tangent=False)),
        kernel_address(f"audit {layout}", lambda: record_audit(layout)),
    )


def tables_for(disc: Discretisation, rule: Rule) -> Tables:
    """Compile or fetch the kernels and lay the arrays out flat."""
    head: list[tuple[int, ...]] = []
    conn, places, par, station = (list[Ints](), list[Ints](), list[Array](), list[Ints]())
    at: dict[str, int] = dict.fromkeys(("conn", "par", "element", "back", "at"), 0)
    for group in disc.groups:
        ne, nn = group.conn.shape
        lanes = _in_lanes(group.parameters)
        head.append(
            (
                *_kernels(group, rule), nn, ne, at["conn"], at["par"], group.layout.size, group.layout.points,
                at["element"], at["back"], at["at"],
            )
        )  # fmt: skip
        conn.append(group.conn.ravel())
        places.append(_in_lanes(PER_NODE * group.conn))
        par.append(lanes)
        station.append(group.station)
        for key, n in (
            ("conn", ne * nn),
            ("par", lanes.size),
            ("element", ne),
            ("back", 6 * (nn - 2) * ne),
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
        pattern.dest.ravel(),
    )


def work_for(disc: Discretisation) -> Work:
    """Workspace for one run."""
    n, rows = disc.nodes, len(disc.pattern.node_of_row)
    most = max(g.layout.nn for g in disc.groups)
    outputs = max(6 * most + 36 * most * most, 7 + most + 7 * max(g.layout.points for g in disc.groups))
    inside = sum(6 * (g.layout.nn - 2) * len(g.conn) for g in disc.groups)
    return Work(
        internal=np.zeros((n, 6)),
        reaction=np.zeros((n, 6)),
        scale=np.zeros(2),
        blocks=np.zeros((int(disc.pattern.rowptr[-1]) + 1, 6, 6)),
        rhs=np.zeros((rows, 6)),
        du=np.zeros((rows, 6)),
        step=np.zeros((n, 6)),
        factors=np.zeros((rows + 1, 56)),
        out=np.zeros(padded(outputs) * LANES),
        k=np.zeros((6 * most, 6 * most)),
        r=np.zeros(6 * most),
        eliminated=np.zeros((6 * most - 12, 6 * most - 12)),
        back=np.zeros((inside, 13)),
        flow=np.zeros(8),
        dt=np.zeros(2),
    )
