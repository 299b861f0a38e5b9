"""A result as files of other programs: CSV, NumPy, MATLAB, Excel; numbers with all their digits but in Excel, which
keeps sixteen."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix import checks
from directrix.errors import InputError, ModelError
from directrix.exports.tables import LEDGER, Table, filled, table
from directrix.quantities import FORCES, STRAINS
from directrix.result import Result

__all__ = ["to_csv", "to_mat", "to_npz", "to_xlsx", "written"]

ROWS = 1_048_576  # of a sheet of Excel
HISTORIES = ("t", "load_factor", "r", "R", "v", "Rdot", "reaction", "strain", "force", "iterations")


def to_csv(result: Result, folder: str | PathLike[str]) -> str:
    """Write one CSV file per table that has rows into ``folder``, made where it is not there; returns the folder.

    A number is written so that reading gives the same bits. Raises InputError where it cannot be written.
    """
    out = checks.file(folder, "folder")

    def write() -> None:
        out.mkdir(parents=True, exist_ok=True)
        for name in filled(result):
            with (out / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
                _rows(table(result, name), csv.writer(file).writerow)

    return written(out, write)


def to_npz(result: Result, path: str | PathLike[str]) -> str:
    """Write the arrays of a result to one compressed ``.npz``; names as in the result; returns the path.

    ``rod.NAME.s``, ``.nodes``, ``.stations``, ``.strain``, ``.force`` are those of a rod; ``energy.…``, ``momentum.…``,
    ``link.NAME``, ``contact.NAME`` and ``node_names``, ``node_indices`` the rest.
    """
    energy, mesh = result.energy, result.mesh
    arrays: dict[str, NDArray[Any]] = {name: getattr(result, name) for name in HISTORIES}
    arrays |= {f"energy.{name}": getattr(energy, name) for name in LEDGER}
    arrays |= {f"energy.work by {name}": a for name, a in energy.work_by_source.items()}
    arrays |= {f"energy.dissipated by {name}": a for name, a in energy.by_source.items()}
    arrays |= {"momentum.linear": result.momentum.linear, "momentum.angular": result.momentum.angular}
    for rod in mesh.rods:
        history = result.rod(rod.name)
        for key, value in (
            ("s", rod.s), ("nodes", rod.nodes), ("stations", rod.stations), ("directors", rod.directors),
            ("strain", history.strain), ("force", history.force),
        ):  # fmt: skip
            arrays[f"rod.{rod.name}.{key}"] = value
    arrays |= {f"link.{name}": a for name, a in result.links.items()}
    arrays |= {f"contact.{name}": a for name, a in result.contacts.items()}
    for name in mesh.joints:
        joint = result.joint(name)
        arrays |= {f"joint.{name}.{key}": getattr(joint, key) for key in ("force", "moment", "coordinate")}
    arrays |= {
        "r0": mesh.r0,
        "node_names": np.array(list(mesh.node_names), str),
        "node_indices": np.array(list(mesh.node_names.values()), np.int64),
        "components_strain": np.array(STRAINS), "components_force": np.array(FORCES),
        "kind": np.array(result.kind), "name": np.array(result.name), "status": np.array(str(result.status)),
    }  # fmt: skip
    out = checks.file(path, "path")

    def write() -> None:
        with out.open("wb") as file:  # a name without .npz stays what it is
            np.savez_compressed(file, **arrays)  # pyright: ignore[reportArgumentType]

    return written(out, write)


def to_mat(result: Result, path: str | PathLike[str]) -> str:
    """Write a MATLAB 5 file with one struct ``result``; returns the path.

    Fields have the names of the result. ``result.rod``, ``.link``, ``.contact``, ``.joint``, ``.node`` and
    ``.energy.work_by``, ``.dissipated_by`` are arrays of structs with a ``name``. Node indices count from 1, as MATLAB
    does. Raises InputError where it cannot be written.
    """
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    energy, mesh = result.energy, result.mesh
    histories: dict[str, Any] = {name: getattr(result, name) for name in HISTORIES}
    joints = [(name, result.joint(name)) for name in mesh.joints]
    tree = {
        **histories,
        "kind": result.kind,
        "title": result.name,
        "status": str(result.status),
        "r0": mesh.r0,
        "components": {"strain": np.array(STRAINS, object), "force": np.array(FORCES, object)},
        "energy": {
            **{name: getattr(energy, name) for name in LEDGER},
            "work_by": _structs([{"name": n, "value": a} for n, a in energy.work_by_source.items()]),
            "dissipated_by": _structs([{"name": n, "value": a} for n, a in energy.by_source.items()]),
        },
        "momentum": {"linear": result.momentum.linear, "angular": result.momentum.angular},
        "node": _structs([{"name": n, "index": k + 1} for n, k in mesh.node_names.items()]),
        "rod": _structs(
            [
                {
                    "name": rod.name, "s": rod.s, "nodes": rod.nodes + 1, "stations": rod.stations,
                    "directors": rod.directors, "strain": result.rod(rod.name).strain,
                    "force": result.rod(rod.name).force,
                }
                for rod in mesh.rods
            ]
        ),
        "link": _structs([{"name": n, "length": a[:, 0], "tension": a[:, 1]} for n, a in result.links.items()]),
        "contact": _structs([{"name": n, "gap": a[:, 0], "force": a[:, 1]} for n, a in result.contacts.items()]),
        "joint": _structs(
            [{"name": n, "force": j.force, "moment": j.moment, "coordinate": j.coordinate} for n, j in joints]
        ),
    }  # fmt: skip
    out = checks.file(path, "path")

    def write() -> None:
        try:
            with out.open("wb") as file:
                savemat(file, {"result": tree}, long_field_names=True, do_compression=True, oned_as="column")
        except MatWriteError as error:
            raise InputError(f"cannot hold this result: {error}", "export it to npz", str(out)) from None

    return written(out, write)


def to_xlsx(result: Result, path: str | PathLike[str]) -> str:
    """Write one sheet of an Excel file per table that has rows; returns the path.

    Raises ModelError without openpyxl, and for a table that is longer than a sheet.
    """
    out = checks.file(path, "path")
    try:
        openpyxl = import_module("openpyxl")
    except ModuleNotFoundError:
        raise ModelError(
            "an Excel file needs openpyxl, which is not installed", 'pip install "directrix[xlsx]"'
        ) from None
    tables = {name: table(result, name) for name in filled(result)}
    for name, columns in tables.items():
        rows = len(next(iter(columns.values())))
        if rows >= ROWS:
            raise ModelError(
                f"the table of {name} has {rows} rows, a sheet holds {ROWS - 1}",
                "export to csv, or save fewer instants",
            )

    def write() -> None:
        with out.open("wb") as file:
            book: Any = openpyxl.Workbook(write_only=True)
            for name, columns in tables.items():
                _rows(columns, book.create_sheet(name).append)
            book.save(file)

    return written(out, write)


def written(out: Path, write: Callable[[], object]) -> str:
    """Call ``write``; what the system says against it becomes an InputError. Returns the path."""
    try:
        write()
    except OSError as error:
        what = f"cannot be written: {error.strerror or error}"
        raise InputError(what, "name a place in a folder that is there", str(out)) from None
    return str(out)


def _rows(columns: Table, put: Callable[[list[Any]], Any]) -> None:
    put(list(columns))
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        put(list(row))


def _structs(rows: list[Mapping[str, Any]]) -> NDArray[Any]:
    """An array of structs (1, k) as SciPy writes it; empty where there are none."""
    if not rows:
        return np.zeros((0, 0))
    out = np.empty((1, len(rows)), [(key, object) for key in rows[0]])
    for k, row in enumerate(rows):
        out[0, k] = tuple(row.values())
    return out
