"""A result as tables: columns by name, one row per instant and node, stress point, link, contact or joint."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.checks import choice
from directrix.errors import ModelError
from directrix.quantities import FORCES, QUANTITIES, STRAINS, rotation_vectors
from directrix.result import Result

Table = dict[str, NDArray[Any]]

__all__ = ["TABLES", "Table", "filled", "table"]

LEDGER = ("kinetic", "stored", "total", "work", "prescribed", "dissipated", "residual")


def table(result: Result, name: str) -> Table:
    """One of :data:`TABLES`, as columns of equal length.

    Raises ModelError for a name that is none, and for a table in which this result has nothing.
    """
    columns = TABLES[choice(name, "table", TABLES)](result)
    if not len(next(iter(columns.values()))):
        raise ModelError(f"this result has no {name}", f"it has {', '.join(filled(result))}")
    return columns


def filled(result: Result) -> list[str]:
    """Names of the tables that have rows."""
    return [name for name, make in TABLES.items() if len(next(iter(make(result).values())))]


def _instants(result: Result, each: int) -> Table:
    """Time and load factor, every instant ``each`` times."""
    out = {"t": np.repeat(result.t, each)} if result.kind == "dynamic" else {}
    return {**out, "load_factor": np.repeat(result.load_factor, each)}


def _split(name: str, values: NDArray[Any]) -> Table:
    """Columns of a quantity from values (…, components)."""
    names = QUANTITIES[name].columns
    return dict(zip(names, values.reshape(-1, len(names)).T, strict=True))


def _nodes(result: Result) -> Table:
    nt, n = result.r.shape[:2]
    names = np.full(n, "", object)
    for name, k in result.mesh.node_names.items():
        names[k] = name
    return {
        **_instants(result, n),
        "node": np.tile(np.arange(n), nt),
        "name": np.tile(names, nt),
        **_split("r", result.r),
        **_split("displacement", result.r - result.mesh.r0),
        **_split("rotation", rotation_vectors(result.R)),
        **_split("v", result.v),
        **_split("reaction", result.reaction),
    }


def _rods(result: Result) -> Table:
    rods, nt = result.mesh.rods, len(result.t)
    names = np.array([rod.name for rod in rods for _ in rod.stations], object)
    s = np.array([x for rod in rods for x in rod.stations])
    return {
        **_instants(result, len(s)),
        "rod": np.tile(names, nt),
        "s": np.tile(s, nt),
        **dict(zip(STRAINS, result.strain.reshape(-1, 6).T, strict=True)),
        **dict(zip(FORCES, result.force.reshape(-1, 6).T, strict=True)),
    }


def _energy(result: Result) -> Table:
    energy = result.energy
    return {
        **_instants(result, 1),
        **{name: getattr(energy, name) for name in LEDGER},
        **{f"work by {name}": a for name, a in energy.work_by_source.items()},
        **{f"dissipated by {name}": a for name, a in energy.by_source.items()},
    }


def _momentum(result: Result) -> Table:
    return {**_instants(result, 1), **_split("L", result.momentum.linear), **_split("J", result.momentum.angular)}


def _path(result: Result) -> Table:
    static = result.kind == "static"
    out: Table = {"load_factor": result.load_factor if static else np.zeros(0)}
    if static:
        out["arc_length"] = result.arc_length
        if result.stability is not None:
            out |= {"negative_pivots": result.stability.negative, "critical": result.stability.critical}
    return out


def _steps(result: Result) -> Table:
    return {"step": np.arange(1, len(result.iterations) + 1), "iterations": result.iterations}


def _owned(owner: str, result: Result, names: list[str], values: Table) -> Table:
    """Rows of things that have names; ``values`` are (nt, things, …) flattened already."""
    return {**_instants(result, len(names)), owner: np.tile(np.array(names, object), len(result.t)), **values}


def _pairs(owner: str, columns: tuple[str, str], result: Result, histories: Mapping[str, NDArray[Any]]) -> Table:
    """Things with two values each, (nt, 2) by name."""
    names, nt = list(histories), len(result.t)
    values = np.stack([histories[n] for n in names], axis=1) if names else np.zeros((nt, 0, 2))
    return _owned(owner, result, names, {c: values[..., k].ravel() for k, c in enumerate(columns)})


def _links(result: Result) -> Table:
    return _pairs("link", ("length", "tension"), result, result.links)


def _contacts(result: Result) -> Table:
    return _pairs("contact", ("gap", "normal_force"), result, result.contacts)


def _joints(result: Result) -> Table:
    names = list(result.mesh.joints)
    histories = [result.joint(n) for n in names]
    nt = len(result.t)

    def stack(field: str, *shape: int) -> NDArray[Any]:
        return np.stack([getattr(h, field) for h in histories], axis=1) if names else np.zeros((nt, 0, *shape))

    return _owned(
        "joint", result, names,
        {
            **_split("joint_force", stack("force", 3)),
            **_split("joint_moment", stack("moment", 3)),
            **_split("coordinate", stack("coordinate")),
        },
    )  # fmt: skip


TABLES: Mapping[str, Callable[[Result], Table]] = {
    "nodes": _nodes, "rods": _rods, "energy": _energy, "momentum": _momentum, "path": _path, "steps": _steps,
    "links": _links, "contacts": _contacts, "joints": _joints,
}  # fmt: skip
"""The tables there are, and what makes each."""
