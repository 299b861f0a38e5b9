"""One HDF5 file for two readers: ``/VTKHDF`` is what ParaView shows, ``/directrix`` the result bit for bit.

``/VTKHDF`` follows version 2.0 of the "VTKHDF format specification" (docs.vtk.org): temporal PolyData, one
line cell per element through its nodes. The lines are written once and every saved instant points back to
them; only points and data move on. A node that rods share appears once per rod, because each rod has
directors of its own there.

``/directrix`` holds arrays as they were and all else as JSON (a tuple in ``info`` comes back as a list).
"""

# pyright: basic
# (h5py ships no types: a group read from a file is Any)

from __future__ import annotations

import io
import json
import os
import zlib
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from directrix import checks
from directrix.audit import Audit, Entry
from directrix.critical import CriticalPoint, PathStability
from directrix.errors import InputError
from directrix.keeping import disk
from directrix.marks import mark_from
from directrix.result import Energy, Mesh, Momentum, Result, RodMesh, Status, TurningPoint
from directrix.storage.fields import cell_data, field_data, lines, one_after_the_other, point_data, points_of
from directrix.trail import Iterations

Array = NDArray[np.float64]

__all__ = ["FORMAT", "load", "save"]

FORMAT = 1  # of /directrix; raised when an older directrix could no longer read it
CHUNK = 2**18  # bytes; well within HDF5's cache, about what one instant of a large frame takes
HISTORIES = ("t", "load_factor", "r", "R", "v", "Rdot", "reaction", "strain", "force", "iterations")


def save(result: Result, path: str | os.PathLike[str]) -> str:
    """Write ``result`` to ``path``, which it returns. ParaView (5.12 or later) knows the ending ``.vtkhdf``.

    An older file is replaced only by a complete one: the new one is written beside it first, and an
    interrupted or failed save leaves the old file as it was. Raises InputError when it cannot be written.

    ParaView shows as point data the displacement, velocity, directors d1, d2, d3 and arclength, as cell
    data the mean section forces and strains of each element in the section's frame, and as field data the
    energies. The first two carry the index of the rod. Time is ``result.t`` where that increases strictly,
    else (a load factor that turns back) the number of the saved instant.
    """
    where = str(checks.file(path, "path"))
    file = Path(where).resolve()  # a link stays a link
    if os.path.isdir(file):
        raise InputError("this is a folder, not a file", "name a file in it, such as result.vtkhdf", where)
    if not os.path.isdir(file.parent):
        raise InputError(f"there is no folder {str(file.parent)!r}", "make the folder first", where)
    try:
        with disk.replacing(file) as part:
            _write(result, _Patient(part))
    except OSError as error:
        raise disk.refused(error, where, _size(result)) from None
    return where


class _Patient(io.RawIOBase):
    """A file whose failing writes HDF5 does not see: it cannot stand one, a full disk may end the process."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.error: OSError | None = None

    def write(self, data: Any) -> int:
        if self.error is None:
            try:
                disk.write(self.file, data)
            except OSError as error:
                self.error = error
        return len(data)

    def readinto(self, buffer: Any) -> int:
        return self.file.readinto(buffer)  # type: ignore[attr-defined]

    def seek(self, offset: int, whence: int = 0) -> int:
        return self.file.seek(offset, whence)

    def tell(self) -> int:
        return self.file.tell()

    def truncate(self, size: int | None = None) -> int:
        return self.file.truncate(size) if self.error is None else 0

    def flush(self) -> None:
        pass


def _write(result: Result, file: _Patient) -> None:
    try:
        with h5py.File(file, "w") as root:
            _write_vtk(root.create_group("VTKHDF"), result)
            _write_result(root.create_group("directrix"), result)
    except Exception:
        if file.error is None:
            raise
    if file.error is not None:
        raise file.error


def _size(result: Result) -> int:
    """About the bytes that a file of ``result`` takes."""
    return 2 * sum(getattr(result, name).nbytes for name in (*HISTORIES, "history", "joints")) + 100_000


def load(path: str | os.PathLike[str]) -> Result:
    """The result that :func:`save` wrote to ``path``, equal to it bit for bit.

    Raises InputError for a file that is missing, unreadable, damaged, from a newer format or not ours.
    """
    file = checks.file(path, "path")
    where = str(file)
    if os.path.isdir(file):
        raise InputError("this is a folder, not a result file", "name the .vtkhdf file in it", where)
    try:
        file.open("rb").close()
    except FileNotFoundError:
        raise InputError("there is no such file", "check the path", where) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", "check the permissions", where) from None
    ours = "name a file that result.save wrote"
    if not h5py.is_hdf5(file):
        raise InputError("is not an HDF5 file", ours, where)
    try:
        with h5py.File(file, "r", locking="best-effort") as root:
            group = root.get("directrix")
            if not isinstance(group, h5py.Group) or "format" not in group.attrs:
                raise InputError("is HDF5 but holds no directrix result", ours, where)
            version: Any = group.attrs["format"]
            if version > FORMAT:
                what = f"has format {version}; this directrix reads up to {FORMAT}"
                raise InputError(what, "install a newer directrix", where)
            return _read_result(group)
    except InputError:
        raise
    except (OSError, RuntimeError, LookupError, TypeError, ValueError, AttributeError) as error:
        fix = "take an intact copy, or run the case again"
        raise InputError(f"is damaged, perhaps cut short while copying ({error})", fix, where) from None


# ---- /VTKHDF ----


def _write_vtk(root: h5py.Group, result: Result) -> None:
    mesh, t = result.mesh, result.t
    nodes = points_of(mesh)
    connectivity, offsets = lines(mesh)
    points, cells, instants = len(nodes), len(offsets) - 1, len(t)

    root.attrs["Type"] = np.bytes_("PolyData")  # readers ask for a string of fixed length
    root.attrs["Version"] = np.array([2, 0])
    _put(root, "NumberOfPoints", np.array([points]))
    _put(root, "Points", result.r[:, nodes].reshape(-1, 3))
    nothing = np.zeros(0, np.int64)
    for name in ("Vertices", "Lines", "Polygons", "Strips"):
        ids, starts = (connectivity, offsets) if name == "Lines" else (nothing, np.zeros(1, np.int64))
        group = root.create_group(name)
        _put(group, "NumberOfConnectivityIds", np.array([len(ids)]))
        _put(group, "NumberOfCells", np.array([len(starts) - 1]))
        _put(group, "Connectivity", ids)
        _put(group, "Offsets", starts)

    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = instants
    count, still = np.arange(instants), np.zeros(instants, np.int64)
    increasing = bool(np.all(np.diff(t) > 0.0))
    _put(steps, "Values", t if increasing else count.astype(np.float64))
    _put(steps, "PartOffsets", still)
    _put(steps, "NumberOfParts", np.ones(instants, np.int64))
    _put(steps, "PointOffsets", count * points)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        _put(steps, name, np.zeros((instants, 4), np.int64))  # vertices, lines, polygons, strips

    for kind, rows, arrays in (
        ("PointData", points, point_data(result)),
        ("CellData", cells, cell_data(result)),
        ("FieldData", 1, field_data(result)),
    ):
        group, starts = root.create_group(kind), steps.create_group(f"{kind}Offsets")
        for name, values in arrays:  # (instants or 1, rows, ...)
            _put(group, name, values.reshape(len(values) * rows, *values.shape[2:]))
            _put(starts, name, count * rows if len(values) == instants else still)


# ---- /directrix ----


def _write_result(root: h5py.Group, result: Result) -> None:
    root.attrs["format"] = FORMAT
    mesh = result.mesh
    texts = {
        "kind": result.kind,
        "name": result.name,
        "status": asdict(result.status),
        "audit": asdict(result.audit),
        # the same run gives the same bytes, however long it took
        "info": {name: value for name, value in result.info.items() if name != "wall_seconds"},
        "rod_names": [rod.name for rod in mesh.rods],
        "node_names": {name: int(k) for name, k in mesh.node_names.items()},
        "mesh_notes": mesh.notes,
        "joint_names": mesh.joints,
        "marks": [asdict(mark) for mark in mesh.marks],
        "turning_points": [asdict(point) for point in result.turning_points],
    }
    for name, value in texts.items():
        root.create_dataset(name, data=json.dumps(value, default=_plain))
    for name in (*HISTORIES, "history", "joints", "density", "dt", "cuts"):
        _put(root, name, getattr(result, name))
    for key, named in (
        ("links", result.links),
        ("contacts", result.contacts),
        ("dissipated_by_source", result.energy.by_source),
        ("work_by_source", result.energy.work_by_source),
    ):
        group = root.create_group(key)
        for k, (name, values) in enumerate(named.items()):
            _put(group, str(k), values)
            group[str(k)].attrs["name"] = name
    for name, value in (("energy", result.energy), ("momentum", result.momentum)):
        group = root.create_group(name)
        for key in fields(value):
            if not key.name.endswith("by_source"):
                _put(group, key.name, getattr(value, key.name))

    group = root.create_group("trail")
    for name, values in vars(result.trail).items():
        _put(group, name, values)
    if result.stability is not None:
        _write_stability(root.create_group("stability"), result.stability)

    group = root.create_group("mesh")  # the rods one after the other, so that many rods stay few datasets
    sizes = [(len(r.nodes), len(r.stations), len(r.outline), r.order, r.first_station) for r in mesh.rods]
    _put(group, "sizes", np.array(sizes, np.int64).reshape(-1, 5))
    _put(group, "r0", mesh.r0)
    _put(group, "joint_nodes", mesh.joint_nodes)
    _put(group, "joint_arms", mesh.joint_arms)
    for name in ("nodes", "s", "directors", "stations", "outline"):
        _put(group, name, one_after_the_other([getattr(rod, name) for rod in mesh.rods]))


def _read_result(root: Any) -> Result:
    def text(name: str) -> Any:
        return json.loads(root[name][()])

    group = root["mesh"]
    sizes = group["sizes"][()]
    nodes, stations, outline = np.cumsum(sizes[:-1, :3], axis=0).T

    def split(name: str, at: NDArray[np.int64]) -> list[NDArray[Any]]:
        return [part.copy() for part in np.split(group[name][()], at)][: len(sizes)]

    rods = zip(
        text("rod_names"), split("nodes", nodes), split("s", nodes), split("directors", nodes),
        sizes[:, 3].tolist(), split("stations", stations), sizes[:, 4].tolist(), split("outline", outline),
        strict=True,
    )  # fmt: skip
    names, notes = text("node_names"), tuple(text("mesh_notes"))
    joints = tuple(text("joint_names")) if "joint_names" in root else ()
    ends = (group["joint_nodes"][()], group["joint_arms"][()]) if "joint_nodes" in group else ()
    audit = text("audit")
    audit["entries"] = tuple(Entry(**entry) for entry in audit["entries"])
    audit["notes"] = tuple(audit["notes"])
    return Result(
        kind=text("kind"),
        name=text("name"),
        mesh=Mesh(
            tuple(RodMesh(*rod) for rod in rods),
            names,
            group["r0"][()],
            notes,
            joints,
            *ends,
            marks=tuple(mark_from(m) for m in text("marks")) if "marks" in root else (),
        ),
        **{name: root[name][()] for name in HISTORIES},
        links=_read_named(root, "links"),
        contacts=_read_named(root, "contacts"),
        **({name: root[name][()] for name in ("dt", "cuts") if name in root}),
        history=root["history"][()] if "history" in root else np.zeros((0, 0, 12)),
        joints=root["joints"][()] if "joints" in root else np.zeros((0, 0, 6)),
        density=root["density"][()] if "density" in root else np.zeros((0, 0)),
        energy=Energy(
            **{name: data[()] for name, data in root["energy"].items()},
            by_source=_read_named(root, "dissipated_by_source"),
            work_by_source=_read_named(root, "work_by_source"),
        ),
        momentum=Momentum(**{name: data[()] for name, data in root["momentum"].items()}),
        status=Status(**text("status")),
        audit=Audit(**audit),
        info=text("info"),
        # a file from before there were any has none
        trail=Iterations(**{name: data[()] for name, data in root["trail"].items()} if "trail" in root else {}),
        turning_points=tuple(TurningPoint(**p) for p in text("turning_points")) if "turning_points" in root else (),
        stability=_read_stability(root["stability"]) if "stability" in root else None,
    )


def _write_stability(group: h5py.Group, of: PathStability) -> None:
    _put(group, "negative", of.negative)
    _put(group, "critical", of.critical)
    said = [{k: v for k, v in vars(p).items() if k != "modes"} for p in of.points]
    group.create_dataset("points", data=json.dumps(said, default=_plain))
    for k, point in enumerate(of.points):
        _put(group, f"modes{k}", point.modes)


def _read_stability(group: Any) -> PathStability:
    said = json.loads(group["points"][()])
    points = tuple(CriticalPoint(**p, modes=group[f"modes{k}"][()]) for k, p in enumerate(said))
    return PathStability(group["negative"][()], group["critical"][()], points)


def _read_named(root: Any, key: str) -> dict[str, Array]:
    """Arrays by name, in their order; a file from before there were any has none."""
    group = root.get(key, {})
    ordered = [group[str(k)] for k in range(len(group))]
    return {str(data.attrs["name"]): data[()] for data in ordered}


def _plain(value: Any) -> Any:
    """What JSON does not know, for ``info``: numpy values become plain ones, anything else its text."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    return dict(value) if isinstance(value, Mapping) else str(value)


def _put(group: h5py.Group, name: str, values: NDArray[Any]) -> None:
    """Write an array; a big one in checksummed chunks of whole rows, compressed where that pays."""
    if values.nbytes < CHUNK:
        group.create_dataset(name, data=values)
        return
    rows = max(1, CHUNK * len(values) // values.nbytes)
    group.create_dataset(
        name, data=values, chunks=(rows, *values.shape[1:]), fletcher32=True, **_compression(values, rows)
    )


def _compression(values: NDArray[Any], rows: int) -> dict[str, Any]:
    """Trailing digits do not shrink and cost ten times the writing; zeros and constants do. Try a piece."""
    middle = min(len(values) // 2, len(values) - rows)
    piece = np.ascontiguousarray(values[middle : middle + rows])
    shuffled = piece.reshape(-1).view(np.uint8).reshape(-1, piece.itemsize).T.tobytes()
    if len(zlib.compress(shuffled, 1)) > 0.7 * len(shuffled):
        return {}
    return {"compression": "gzip", "compression_opts": 1, "shuffle": True}
