"""A result for xarray and pandas."""
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from directrix.errors import ModelError
from directrix.exports.tables import LEDGER, table
from directrix.quantities import QUANTITIES, XYZ, rotation_vectors, unit
from directrix.result import Result

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ["needed", "to_pandas", "to_xarray"]

SECTION = ("shear 1", "shear 2", "axial", "bending 1", "bending 2", "torsion")


def needed(module: str, what: str) -> Any:
    """A module that is an extra; raises ModelError that says how to install it."""
    try:
        return import_module(module)
    except ModuleNotFoundError:
        raise ModelError(
            f"{what} needs {module}, which is not installed", f'pip install "directrix[{module}]"'
        ) from None


def to_pandas(result: Result, name: str = "nodes") -> pandas.DataFrame:
    """One table of a result, a row per instant and node, stress point, link, contact or joint.

    "nodes", "rods", "energy", "momentum", "path", "steps", "links", "contacts" or "joints". Raises ModelError without
    pandas, for another name, and for a table without rows.
    """
    return needed("pandas", "a table").DataFrame(table(result, name))


def to_xarray(result: Result) -> xarray.Dataset:
    """A Dataset with dimensions ``time``, ``node``, ``axis`` (x, y, z), ``station`` and ``component``.

    Every variable and coordinate has ``long_name`` and ``units``; those are the user's, see
    :func:`directrix.quantities.unit`. Sources of work and of dissipation, links, contacts and joints have dimensions of
    their own where there are any. Raises ModelError without xarray.
    """
    xr = needed("xarray", "a labelled array")
    mesh, n = result.mesh, result.r.shape[1]
    names = [""] * n
    for name, k in mesh.node_names.items():
        names[k] = name
    at, nodal, section = ("time",), ("time", "node", "axis"), ("time", "station", "component")

    def said(words: str, dimension: str) -> dict[str, str]:
        return {"long_name": words, "units": unit(result, dimension)}

    def quantity(name: str, dims: tuple[str, ...], values: Any) -> tuple[Any, ...]:
        kind = QUANTITIES[name]
        same = len(set(kind.dimensions)) == 1
        attributes = said(kind.words, kind.dimension(0)) if same else {"long_name": kind.words, "units": "by component"}
        return dims, values, attributes

    def section_units(name: str) -> tuple[Any, ...]:
        return ("component",), [unit(result, QUANTITIES[name].dimension(k)) for k in range(6)]

    energy, joints = result.energy, [result.joint(name) for name in mesh.joints]
    variables: dict[str, Any] = {
        "r": quantity("r", nodal, result.r),
        "displacement": quantity("displacement", nodal, result.r - mesh.r0),
        "rotation": quantity("rotation", nodal, rotation_vectors(result.R)),
        "v": quantity("v", nodal, result.v),
        "reaction_force": (nodal, result.reaction[..., :3], said("force of supports on the node", "force")),
        "reaction_moment": (nodal, result.reaction[..., 3:], said("moment of supports on the node", "force·length")),
        "strain": quantity("strain", section, result.strain),
        "force": quantity("force", section, result.force),
        **{name: quantity(name, at, getattr(energy, name)) for name in LEDGER},
        "L": quantity("L", ("time", "axis"), result.momentum.linear),
        "J": quantity("J", ("time", "axis"), result.momentum.angular),
    }
    time = said("time", "time") if result.kind == "dynamic" else said("load factor", "")
    coords: dict[str, Any] = {
        "time": (at, result.t, time),
        "load_factor": quantity("load_factor", at, result.load_factor),
        "arc_length": quantity("arc_length", at, result.arc_length),
        "node": np.arange(n),
        "node_name": ("node", names),
        "r0": (("node", "axis"), mesh.r0, said("reference position", "length")),
        "axis": list(XYZ),
        "component": list(SECTION),
        "strain_units": section_units("strain"),
        "force_units": section_units("force"),
        "rod": ("station", [rod.name for rod in mesh.rods for _ in rod.stations]),
        "s": ("station", np.array([x for rod in mesh.rods for x in rod.stations]), said("arclength", "length")),
    }
    for dim, name, words, parts in (
        ("work_source", "work_by_source", "work by source", energy.work_by_source),
        ("loss_source", "dissipated_by_source", "dissipated by source", energy.by_source),
    ):
        if parts:
            coords[dim] = list(parts)
            variables[name] = (("time", dim), np.stack(list(parts.values()), 1), said(words, "force·length"))
    for dim, columns, parts in (
        ("link", ("length", "tension"), result.links),
        ("contact", ("gap", "normal_force"), result.contacts),
    ):
        if parts:
            coords[dim] = list(parts)
            values = np.stack(list(parts.values()), 1)
            for k, name in enumerate(columns):
                variables[f"{dim}_{name}"] = quantity(name, ("time", dim), values[..., k])
    if joints:
        coords["joint"] = list(mesh.joints)
        for name, field in (("joint_force", "force"), ("joint_moment", "moment"), ("coordinate", "coordinate")):
            stacked = np.stack([getattr(j, field) for j in joints], 1)
            variables[name] = quantity(name, ("time", "joint", "axis")[: stacked.ndim], stacked)
    about = {"title": result.name, "kind": result.kind, "status": str(result.status), "audit": result.audit.verdict}
    return xr.Dataset(variables, coords, about)
