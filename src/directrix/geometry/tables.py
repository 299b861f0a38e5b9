"""Centrelines from tables of points: a cubic spline through them, or one that is smoothed by a stated distance."""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import file, number, shown
from directrix.curves import DirectorRule, Spline
from directrix.curves import spline as through
from directrix.errors import InputError, ModelError

Array = NDArray[np.float64]
Columns = Sequence[str | int]

__all__ = ["Centreline", "centreline"]

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048}
TURNS_BACK = -0.5  # cosine of the turn between neighbours that no centreline in order has


@dataclass(frozen=True)
class Centreline(Spline):
    """A spline from a table; ``deviation`` is the largest distance of the ``count`` points from it."""

    deviation: float = 0.0
    count: int = 0

    def __str__(self) -> str:
        return (
            f"centreline of {self.count} points, length {self.length:.6g}, none further than {self.deviation:.3g} off"
        )


def centreline(
    source: str | PathLike[str] | ArrayLike, *, smoothing: float = 0.0, columns: Columns | None = None,
    unit: float | str = 1.0, directors: DirectorRule = "tangent", d1: ArrayLike | None = None,
) -> Centreline:  # fmt: skip
    """A smooth axis from a table of points in order.

    Parameters
    ----------
    source
        A CSV file (commas, semicolons, tabs or blanks; "#" begins a remark), or points (k, 3).
    smoothing
        The largest distance that the axis may have from the points; 0 goes through all of them. The cubic smoothing
        spline is the stiffest one found that keeps it; what it came to is the curve's ``deviation``.
    columns
        Names or positions (from 0) of x, y, z, and as a fourth of a parameter that must rise from row to row. Unless
        given: the columns headed x, y, z (and s or t), in whatever case, else the first three.
    unit
        What a coordinate of the table is in lengths of the model: a number, or "mm", "cm", "m", "in", "ft" for a model
        in metres. A header such as "x [mm]" says it as well.
    directors, d1
        As for :func:`dx.spline`.

    Raises
    ------
    InputError
        With file and line: a row is short, no number, not finite, the same as the one before, or out of order.
    ModelError
        There are fewer than three points, or the smoothing leaves fewer.
    """
    if isinstance(source, (str, PathLike)):
        path = file(source, "centreline")
        points, lines, scale = _read(path, columns)
        label = [f"{path}:{line}" for line in lines]
    else:
        points, scale = np.asarray(source, float), None
        if points.ndim != 2 or points.shape[1] != 3:
            raise ModelError("the points of a centreline are not (k, 3)", "give a file or [(x, y, z), …]")
        label = [f"point {k}" for k in range(len(points))]
    if isinstance(unit, str):
        if unit not in UNITS:
            raise ModelError(f"there is no unit {shown(unit)}", f"use a number or one of {', '.join(UNITS)}")
        unit = UNITS[unit]
    if scale is not None and unit != 1.0 and scale != unit:
        raise ModelError(f"the header says {scale:g} and unit={unit:g}", "give one of them")
    points = points * (number(unit, "unit", above=0.0) if scale is None else scale)
    _refuse_rows(points, label)
    reach = number(smoothing, "smoothing", least=0.0)
    knots = points if reach == 0.0 else _smoothed(points, reach)
    plain = through(knots.tolist(), directors=directors, d1=d1)
    gap = 0.0 if reach == 0.0 else _distance(knots, points)
    return Centreline(plain.points, plain.directors, plain.d1, gap, len(points))


def _read(path: Path, columns: Columns | None) -> tuple[Array, list[int], float | None]:
    """Points (k, 3), the lines that they are on, the unit of the header."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {error}", "give a text file of columns", str(path)) from None
    rows = [(k + 1, line.split("#")[0].strip()) for k, line in enumerate(text.splitlines())]
    rows = [(k, line) for k, line in rows if line]
    if not rows:
        raise InputError("the file is empty", "give one row a point", f"{path}:1")
    mark = next((m for m in (";", "\t", ",") if m in rows[0][1]), None)

    def cells(line: str) -> list[str]:
        return [c.strip() for c in (next(csv.reader([line], delimiter=mark)) if mark else line.split())]

    head = cells(rows[0][1])
    scale: float | None = None
    named = not all(_is_number(c) for c in head)
    if named:
        rows = rows[1:]
    words = [re.sub(r"\s*[\[(_].*$", "", c).strip().lower() for c in head]
    if columns is None:
        wanted = [words.index(c) for c in "xyz" if c in words] if named else []
        if len(wanted) != 3:
            if named and wanted:
                raise InputError("the header lacks one of x, y, z", "give columns=(…)", f"{path}:1")
            wanted = [0, 1, 2]
        wanted += [words.index(c) for c in ("s", "t") if named and c in words][:1]
    else:
        wanted = []
        for c in columns:
            if isinstance(c, str) and c not in head:
                raise InputError(f"there is no column {c!r}", f"columns are {', '.join(head)}", f"{path}:1")
            wanted.append(head.index(c) if isinstance(c, str) else c)
        if len(wanted) not in (3, 4) or any(not 0 <= c < len(head) for c in wanted):
            raise ModelError(
                f"columns = {shown(columns)} do not name x, y and z", "three columns, or a fourth that rises"
            )
    if named:
        found = {m[1] for k in wanted[:3] if (m := re.search(r"[\[(_]\s*([a-zµ]+)", head[k]))}
        units = {UNITS[u] for u in found if u in UNITS}
        if len(units) > 1:
            raise InputError("the columns have different units", "give them one", f"{path}:1")
        scale = units.pop() if units else None
    points: list[list[float]] = []
    lines: list[int] = []
    for line, row in rows:
        values = cells(row)
        if len(values) <= max(wanted):
            raise InputError(f"the row has {len(values)} columns", f"give {max(wanted) + 1}", f"{path}:{line}")
        for k in wanted:
            if not _is_number(values[k]):
                raise InputError(f"{values[k]!r} is not a number", "mend or remove the row", f"{path}:{line}")
        at = [float(values[k]) for k in wanted]
        if not np.all(np.isfinite(at)):
            raise InputError("the row is not finite", "mend or remove it", f"{path}:{line}")
        if len(at) == 4 and points and at[3] <= points[-1][3]:
            raise InputError(
                f"the parameter {at[3]:g} does not rise from {points[-1][3]:g}: the rows are not in order",
                "sort them along the axis", f"{path}:{line}",
            )  # fmt: skip
        points.append(at)
        lines.append(line)
    return np.array(points).reshape(len(points), -1)[:, :3], lines, scale


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _refuse_rows(points: Array, label: Sequence[str]) -> None:
    if len(points) < 3:
        raise ModelError(f"a centreline needs 3 points or more, {len(points)} given", "add points")
    for k in np.flatnonzero(~np.isfinite(points).all(axis=1)):
        raise InputError("the point is not finite", "mend or remove it", label[int(k)])
    steps = np.diff(points, axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    for k in np.flatnonzero(sizes <= 1e-12 * np.abs(points).max()):
        raise InputError("the point is the same as the one before", "remove one of them", label[int(k) + 1])
    cosine = np.einsum("ki,ki->k", steps[1:], steps[:-1]) / (sizes[1:] * sizes[:-1])
    for k in np.flatnonzero(cosine < TURNS_BACK):
        raise InputError(
            "the axis turns back here: the rows are not in order", "sort them along the axis", label[int(k) + 1]
        )


def _smoothed(points: Array, reach: float) -> Array:
    """Points of the smoothing spline of the fewest knots whose distance from ``points`` stays below ``reach``."""
    from scipy.interpolate import splev, splprep

    best = points
    low, high = 0.0, len(points) * reach**2
    for trial in range(40):
        s = high if trial == 0 else 0.5 * (low + high)
        try:
            tck, _ = splprep(points.T, s=s, k=3)
        except (ValueError, TypeError) as error:
            raise ModelError(f"the points cannot be smoothed: {error}", "give smoothing=0") from None
        inner = max(4, 2 * len(np.unique(tck[0])))
        found = np.array(splev(np.linspace(0.0, 1.0, inner), tck)).T
        if _distance(found, points) <= reach:
            low, best = s, found
            if trial == 0:
                break
        else:
            high = s
        if high - low <= 1e-3 * high:
            break
    return best


def _distance(knots: Array, points: Array) -> float:
    """Largest distance of a point from the axis: the cubic spline by chord length through ``knots``."""
    from scipy.interpolate import CubicSpline
    from scipy.spatial import KDTree

    u = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1)))
    curve = CubicSpline(u, knots)
    table = np.linspace(0.0, u[-1], 8 * len(points) + 1)
    foot, step = table[KDTree(curve(table)).query(points)[1]], table[1]
    for _ in range(30):
        trial = np.clip(foot + np.array([[-step], [0.0], [step]]), 0.0, u[-1])
        gap = np.linalg.norm(curve(trial) - points, axis=-1)
        foot, step = trial[np.argmin(gap, axis=0), np.arange(len(points))], 0.5 * step
    return float(np.linalg.norm(curve(foot) - points, axis=-1).max())
