"""A point of a rod at any arclength: what is there, from the shape functions, and its record while a run goes on."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix.basis import lagrange
from directrix.checks import choice, file, number, shown, text
from directrix.errors import InputError, ModelError

if TYPE_CHECKING:
    from directrix.result import Mesh, RodMesh

Array = NDArray[np.float64]

__all__ = ["RECORDED", "Live", "Point", "Recorder", "place"]

RECORDED = {
    "r": ("r_x", "r_y", "r_z"),
    "displacement": ("displacement_x", "displacement_y", "displacement_z"),
    "v": ("v_x", "v_y", "v_z"),
    "strain": ("Gamma1", "Gamma2", "Gamma3", "Omega1", "Omega2", "Omega3"),
    "force": ("V1", "V2", "N", "M1", "M2", "T"),
}
"""What a recorder knows, and the columns that it makes of it."""


@dataclass(frozen=True)
class Point:
    """A point of a rod: which nodes and stress points it lies between, and their weights."""

    rod: RodMesh
    s: float
    nodes: NDArray[np.int64]
    shape: Array
    stations: NDArray[np.int64]
    weights: Array

    def of_nodes(self, values: Array) -> Array:
        """Interpolate nodal values (…, n, k) with the shape functions of the element (52)."""
        return np.einsum("a,...ak->...k", self.shape, values[..., self.nodes, :])

    def of_stations(self, values: Array) -> Array:
        """Values (…, stations, k) on the polynomial through the stress points of the element.

        Strains are most accurate there; the shape functions themselves would bring in what reduced integration leaves
        out.
        """
        return np.einsum("q,...qk->...k", self.weights, values[..., self.stations, :])


def place(mesh: Mesh, rod: str, s: float) -> Point:
    """The point at arclength ``s`` of a rod; between elements it belongs to the one that ends there.

    Raises ModelError for an unknown rod and for a place that is not on it.
    """
    on, s = mesh.rod(rod), number(s, "s")
    length = float(on.s[-1])
    if not -1e-12 * length <= s <= length * (1.0 + 1e-12):
        raise ModelError(f"rod {rod!r} has no arclength s = {s:g}", f"give 0 … {length:.9g}")
    ends = on.s[:: on.order]
    e = int(np.clip(np.searchsorted(ends, s * (1.0 - 1e-12)) - 1, 0, len(ends) - 2))
    xi = 2.0 * (s - ends[e]) / (ends[e + 1] - ends[e]) - 1.0
    many = len(on.stations) // (len(ends) - 1)
    stations = np.arange(e * many, (e + 1) * many)
    at = on.stations[stations]
    weights = [float(np.prod((s - np.delete(at, q)) / (at[q] - np.delete(at, q)))) for q in range(many)]
    nodes = on.nodes[e * on.order : (e + 1) * on.order + 1]
    return Point(on, s, nodes, lagrange(on.order, float(xi))[0], on.first_station + stations, np.array(weights))


@dataclass(frozen=True)
class Recorder:
    """A point of a rod whose history goes to a CSV file while the run goes on, a row for every saved instant.

    For ``record=`` of :func:`directrix.simulate` and :func:`directrix.solve_static`. The columns are ``t`` (dynamics)
    or ``load_factor``, then those of the quantities; every row is on disk before the next step begins.

    Parameters
    ----------
    rod
        Name of the rod.
    s
        Arclength on the reference axis; any, not only that of a node.
    quantities
        Of "r", "displacement", "v" (components in the global frame), "strain" and "force" (in the section's frame:
        V1, V2, N, M1, M2, T).
    path
        The file; ``record-<rod>-<s>.csv`` unless given. An older one is replaced.

    Raises
    ------
    ModelError
        A quantity that there is not, or none; when the run begins, a rod or a place that is not there.
    """

    rod: str
    s: float
    quantities: Sequence[str] = ("r", "force")
    path: str | PathLike[str] | None = None

    def __post_init__(self) -> None:
        text(self.rod, "rod")
        number(self.s, "s", least=0.0)
        given: Any = (self.quantities,) if isinstance(self.quantities, str) else self.quantities
        if not isinstance(given, Sequence) or not given:
            raise ModelError(f"quantities = {shown(given)} names nothing", f"name some of {', '.join(RECORDED)}")
        names = tuple(choice(q, "quantity to record", RECORDED) for q in given)  # pyright: ignore
        if len(set(names)) < len(names):
            raise ModelError(f"quantities = {shown(given)} names one twice", "name each once")
        object.__setattr__(self, "quantities", names)
        if self.path is not None:
            file(self.path, "path")

    @property
    def name(self) -> str:
        """Of its rod and place, in characters that a file name takes."""
        return re.sub(r"[^\w.-]", "_", f"{self.rod}-{self.s:.9g}")

    @property
    def file(self) -> str:
        """Where it writes."""
        return str(self.path) if self.path is not None else f"record-{self.name}.csv"

    @property
    def columns(self) -> tuple[str, ...]:
        """Behind the first."""
        return tuple(column for q in self.quantities for column in RECORDED[q])


class Live:
    """The open files of a run's recorders."""

    def __init__(self, record: Sequence[Recorder], mesh: Mesh, kind: Literal["static", "dynamic"]) -> None:
        if isinstance(record, Recorder):
            record = (record,)
        for one in record:
            if not isinstance(one, Recorder):  # pyright: ignore[reportUnnecessaryIsInstance]
                raise ModelError(f"{shown(one)} is no recorder", "give dx.Recorder(rod, s=…)", "record=")
        names = [one.file for one in record]
        if len(set(names)) < len(names):
            raise ModelError("two recorders write to one file", "give each a path= of its own", "record=")
        self.r0 = mesh.r0
        self.points = [(one, place(mesh, one.rod, one.s)) for one in record]
        self.names = names
        self.heads = [["t" if kind == "dynamic" else "load_factor", *one.columns] for one in record]
        self.first: list[list[float]] = []
        """The first rows: they wait until it is known whether the run goes on with an earlier one."""
        self.files: list[Any] = []
        for name in names:
            _opened(name, "a").close()

    def go_on(self, rows: int) -> None:
        """Go on behind the first ``rows`` rows of the files of an earlier run. Raises InputError."""
        self.first = []
        for name in self.names:
            out = _opened(name, "r+")
            for _ in range(rows + 1):
                out.readline()
            out.seek(out.tell())
            out.truncate()
            self.files.append(out)

    def _begin(self) -> None:
        """Write the first rows, in place of what was there."""
        self.files = [_opened(name, "w") for name in self.names]
        for out, head, row in zip(self.files, self.heads, self.first, strict=True):
            _row(out, head)
            _row(out, row)
        self.first = []

    def write(self, t: float, r: Array, v: Array, strain: Array, force: Callable[[], Array]) -> None:
        """A row in every file, from positions and velocities (n, 3), strains and section forces (stations, 6)."""
        pulled = force() if any("force" in one.quantities for one, _ in self.points) else strain
        nodal = {"r": r, "v": v, "displacement": r - self.r0}
        rows: list[list[float]] = []
        for one, point in self.points:
            row = [
                point.of_nodes(nodal[q]) if q in nodal else point.of_stations(strain if q == "strain" else pulled)
                for q in one.quantities
            ]
            rows.append([float(t), *np.concatenate(row).tolist()])
        if not self.files and not self.first:
            self.first = rows
            return
        if not self.files:
            self._begin()
        for out, row in zip(self.files, rows, strict=True):
            _row(out, row)

    def close(self) -> None:
        """The run is over."""
        if self.first:
            self._begin()
        for out in self.files:
            out.close()


def _opened(name: str, mode: str) -> Any:
    try:
        return open(name, mode, newline="", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", "name a file in a folder that is there", name
        ) from None


def _row(out: Any, values: Sequence[Any]) -> None:
    try:
        csv.writer(out).writerow(values)
        out.flush()
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", "check free space", out.name) from None
