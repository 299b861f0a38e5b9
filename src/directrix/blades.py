"""Blades of BeamDyn (NREL): key points and 6×6 matrices at stations, as one rod.

BeamDyn's frame at a section is x, y, z with z along the blade, and its rows are (force x, y, z; moment x, y, z): with
d1 = x, d2 = y, d3 = z that is shear 1, shear 2, axial, bending 1, bending 2, torsion, without a change of sign. The
trap is that other tools put the axial row first. Mass matrices are about the key points' axis:

    m, −m Y in (1, 6), m X in (2, 6);  ∫ρ y² in (4, 4), ∫ρ x² in (5, 5), −∫ρ x y in (4, 5)

"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from directrix.checks import file, text, whole
from directrix.curves import Curve, line, spline, twisted
from directrix.errors import InputError, ModelError
from directrix.model import Model
from directrix.section import Section
from directrix.tapered import Tapered, taper

Array = NDArray[np.float64]

__all__ = ["Blade", "beamdyn", "read_blade"]

POLAR = 0.01  # what the last entry of a mass matrix may differ from the sum of the two before


@dataclass(frozen=True)
class Blade:
    """What the two files say: an axis with its twist, sections at stations, sentences on what was assumed."""

    curve: Curve
    section: Tapered
    notes: tuple[str, ...]


def beamdyn(
    path: str | PathLike[str], *, blade: str | PathLike[str] | None = None, name: str = "blade",
    elements: int | None = None, order: int = 2,
) -> Model:  # fmt: skip
    """The blade of a BeamDyn primary file as a model of one rod ``name`` from node "root" to node "tip".

    The axis is a spline through the key points (a line where there are two directions of them that agree), the sections
    are linear between the stations, at their fractions of the arclength, and turned by the initial twist. What was
    assumed is in ``model.imported``. ``blade`` overrides the name in BldFile; ``elements`` are one a span between
    stations unless given. Units are those of the files: SI.

    Raises InputError with file and line for what cannot be read, ModelError for what no blade has.
    """
    made = read_blade(path, blade)
    count = whole(elements if elements is not None else max(1, len(made.section.stations) - 1), "elements", 1)
    model = Model(name=Path(path).stem).rod(
        made.curve,
        made.section,
        name=text(name, "name of the blade"),
        ends=("root", "tip"),
        elements=count,
        order=order,
    )
    return replace(model, imported=made.notes)


def read_blade(path: str | PathLike[str], blade: str | PathLike[str] | None = None) -> Blade:
    """Read a primary file and the blade file that it names; see :func:`beamdyn`."""
    primary = _File(file(path, "BeamDyn file"))
    points = _key_points(primary)
    if blade is None:
        at = primary.find(r"\bBldFile\b", "the name of the blade file")
        quoted = re.match(r'\s*(?:"([^"]*)"|(\S+))', primary.lines[at])
        assert quoted is not None
        own = primary.path.parent / (quoted[1] or quoted[2])
    else:
        own = file(blade, "blade file")
    stations, sections, notes = _stations(_File(own))
    where, angles = points[:, :3], points[:, 3]
    way = np.diff(where, axis=0)
    sizes = np.linalg.norm(way, axis=1)
    straight = np.ptp(way / sizes[:, None], axis=0).max() <= 1e-12
    start = (1.0, 0.0, 0.0)
    curve: Curve = line(where[0], where[-1], d1=start) if straight else spline(where.tolist(), d1=start)
    at = _arclengths(curve, where, sizes)
    # BeamDyn's first axis is normal to the tangent without a part along y, and its twist right-handed about z
    frames = curve.frames(at * curve.length, at * curve.length)
    tangent = frames[:, :, 2]
    first = np.stack([tangent[:, 2], 0.0 * tangent[:, 1], -tangent[:, 0]], -1)
    turn = np.arctan2(np.einsum("ki,ki->k", first, frames[:, :, 1]), np.einsum("ki,ki->k", first, frames[:, :, 0]))
    whole_turn = np.unwrap(turn) + np.radians(angles)
    if np.abs(whole_turn).max() > 1e-12:
        curve = twisted(curve, list(zip(at.tolist(), whole_turn.tolist(), strict=True)))
    said = (
        f"{primary.path.name}: {len(where)} key points, {len(stations)} stations; d1, d2, d3 are BeamDyn's x, y, z",
        *notes,
    )
    return Blade(curve, taper(list(zip(stations, sections, strict=True))), said)


class _File:
    """Lines of a text file, and errors with their place."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror or error}", "check the name", str(path)) from None

    def error(self, what: str, fix: str, line: int) -> InputError:
        return InputError(what, fix, f"{self.path}:{line + 1}")

    def find(self, pattern: str, what: str) -> int:
        """The line that has a keyword behind its value."""
        for k, row in enumerate(self.lines):
            if re.search(pattern, row):
                return k
        raise self.error(f"{what} is missing", f"a line with {pattern.strip('b').strip(chr(92))}", 0)

    def count(self, pattern: str, what: str) -> tuple[int, int]:
        """A whole number and its line."""
        at = self.find(pattern, what)
        words = self.lines[at].split()
        if not words or not words[0].isdigit():
            raise self.error(f"{what} is not a whole number", "give it first on the line", at)
        return int(words[0]), at

    def numbers(self, at: int, count: int, what: str) -> list[float]:
        """The first ``count`` numbers of a line."""
        words = self.lines[at].replace("D", "E").replace("d", "e").split() if at < len(self.lines) else []
        try:
            values = [float(w) for w in words[:count]]
        except ValueError:
            values = []
        if len(values) != count or not np.all(np.isfinite(values)):
            raise self.error(f"{what} is not {count} finite number{'s' * (count > 1)}", "mend the line", at)
        return values


def _key_points(primary: _File) -> Array:
    """(k, 4): place and initial twist [deg] of the key points."""
    members, at = primary.count(r"\bmember_total\b", "member_total")
    total, _ = primary.count(r"\bkp_total\b", "kp_total")
    if total < 3:
        raise primary.error(f"kp_total = {total} is less than 3", "give three key points or more", at)
    head = primary.find(r"\bkp_xr\b", "the table of key points")
    first = head + 2  # below the names, the units
    points = np.array([primary.numbers(first + k, 4, "a key point") for k in range(total)])
    if members > 1:
        raise primary.error(f"the blade has {members} members", "one member is read: join their key points", at)
    for k in np.flatnonzero(np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1) == 0.0):
        raise primary.error("the key point is the same as the one before", "remove one", first + int(k) + 1)
    return points


def _arclengths(curve: Curve, points: Array, sizes: Array) -> Array:
    """Fractions of the arclength of the key points."""
    rough = np.append(0.0, np.cumsum(sizes))
    s = rough / rough[-1] * curve.length
    for _ in range(20):  # nearest place on the curve, by its tangent
        gap = points - curve.position(s)
        s = np.clip(s + np.einsum("ki,ki->k", gap, curve.frames(s, s)[:, :, 2]), 0.0, curve.length)
    s[0], s[-1] = 0.0, curve.length
    return s / curve.length


def _stations(own: _File) -> tuple[list[float], list[Section], tuple[str, ...]]:
    total, at = own.count(r"\bstation_total\b", "station_total")
    kind, _ = own.count(r"\bdamp_type\b", "damp_type")
    factors = [0.0] * 6
    head = own.find(r"\bmu1\b", "the damping coefficients")
    if kind:
        factors = own.numbers(head + 2, 6, "the damping coefficients")
    row = own.find(r"DISTRIBUTED PROPERTIES", "the distributed properties") + 1
    places: list[float] = []
    sections: list[Section] = []
    off = 0.0
    for _ in range(total):
        while row < len(own.lines) and not own.lines[row].strip():
            row += 1
        begin = row
        eta = own.numbers(row, 1, "the place of a station")[0]
        stiffness, row = _matrix(own, row + 1, "stiffness")
        mass, row = _matrix(own, row, "mass")
        try:
            section, polar = _section(stiffness, mass, factors)
        except ModelError as error:
            raise own.error(error.what, error.fix, begin) from None
        if places and eta <= places[-1]:
            raise own.error(f"station {eta:g} does not lie behind {places[-1]:g}", "sort the stations", begin)
        places.append(eta)
        sections.append(section)
        off = max(off, polar)
    if total < 2 or places[0] != 0.0 or places[-1] != 1.0:
        raise own.error("the stations do not go from 0 to 1", "give fractions of the length", at)
    said = ["between stations stiffness and inertia are linear"]
    if kind:
        said.append(f"stiffness-proportional damping, mu = {', '.join(f'{m:g}' for m in factors)}")
    if off > POLAR:
        said.append(f"the polar inertia differs from the sum of the others by up to {100 * off:.3g} %; the sum is used")
    return places, sections, tuple(f"{own.path.name}: {s}" for s in said)


def _matrix(own: _File, row: int, what: str) -> tuple[Array, int]:
    while row < len(own.lines) and not own.lines[row].strip():
        row += 1
    return np.array([own.numbers(row + k, 6, f"row {k + 1} of a {what} matrix") for k in range(6)]), row + 6


def _section(stiffness: Array, mass: Array, factors: Sequence[float]) -> tuple[Section, float]:
    """A section, and how far the polar inertia is from the sum of the others."""
    m = float(mass[0, 0])
    # any (6, 6) mass of a section in its plane is this one; the rest of the matrix must agree with it
    X, Y = (float(mass[1, 5]) / m, -float(mass[0, 5]) / m) if m else (0.0, 0.0)
    yy, xx, xy = float(mass[3, 3]), float(mass[4, 4]), -float(mass[3, 4])
    want = np.zeros((6, 6))
    want[:3, :3] = m * np.eye(3)
    want[:3, 3:] = m * np.array([[0.0, 0.0, -Y], [0.0, 0.0, X], [Y, -X, 0.0]])
    want[3:, :3] = want[:3, 3:].T
    want[3:, 3:] = [[yy, -xy, 0.0], [-xy, xx, 0.0], [0.0, 0.0, mass[5, 5]]]
    size = np.sqrt(np.maximum(np.abs(np.diag(want)), 1e-300))
    if np.abs((mass - want) / np.outer(size, size)).max() > 1e-6:
        raise ModelError(
            "the mass matrix is not that of a flat section about its axis",
            "check its order and signs: see docs/geometry.md",
        )
    polar = abs(float(mass[5, 5]) - xx - yy) / max(xx + yy, 1e-300)
    # C_v = √μ C √μ is BeamDyn's μ C for equal factors, and symmetric for others
    root = np.sqrt(np.asarray(factors, float))
    viscous = root[:, None] * stiffness * root
    inertia = np.array([[xx, xy], [xy, yy]])
    first = np.array([m * X, m * Y])
    return Section(stiffness, m, inertia, order="shear-axial", S_rho=first, damping=viscous), polar
