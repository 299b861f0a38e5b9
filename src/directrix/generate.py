"""Models by rule: grids, lattices, springs, rings, weaves. Rods, nodes and their names are the same every time.

Each function returns a Model of rods alone; supports and loads are added by the names that its docstring says.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import number, vector, whole
from directrix.curves import arc, first_frame, lines, spline
from directrix.errors import ModelError
from directrix.model import Model
from directrix.section import Section

Array = NDArray[np.float64]
Place = tuple[int, ...]

__all__ = ["cubic", "grid", "octet", "ring", "spring", "weave"]

LARGEST = 10_000


def grid(
    counts: tuple[int, int], cell: tuple[float, float], section: Section, *, origin: ArrayLike = (0, 0, 0), **rod: Any
) -> Model:
    """A flat grid of ``counts`` (nx, ny) cells of size ``cell``, in the plane z = const, its joints rigid.

    Nodes "i.j", 0 ≤ i ≤ nx along x and 0 ≤ j ≤ ny along y; rods "i.j-k.l" between neighbours, in that direction.
    ``rod`` are other arguments of ``Model.rod``. Raises ModelError for counts or sizes that are none.
    """
    nx, ny = _counts(counts, 2)
    a, b = (number(c, "cell", above=0.0) for c in cell)
    places = list(product(range(nx + 1), range(ny + 1)))
    pairs = [
        (p, q) for p in places for q in ((p[0] + 1, p[1]), (p[0], p[1] + 1)) if q[0] <= nx and q[1] <= ny
    ]  # fmt: skip
    return _struts("grid", pairs, (a, b), section, origin, rod)


def cubic(
    counts: tuple[int, int, int], cell: float, section: Section, *, origin: ArrayLike = (0, 0, 0), **rod: Any
) -> Model:
    """A cubic lattice of ``counts`` (nx, ny, nz) cells of edge ``cell``, its joints rigid.

    Nodes "i.j.k", from 0 to the count along x, y, z; rods "i.j.k-l.m.n" between neighbours. ``rod`` are other arguments
    of ``Model.rod``. Raises ModelError for counts or a size that are none.
    """
    most = _counts(counts, 3)
    a = number(cell, "cell", above=0.0)
    pairs: list[tuple[Place, Place]] = []
    for p in product(*(range(n + 1) for n in most)):
        for axis in range(3):
            q = tuple(v + (k == axis) for k, v in enumerate(p))
            if q[axis] <= most[axis]:
                pairs.append((p, q))
    return _struts("cubic lattice", pairs, (a, a, a), section, origin, rod)


def octet(
    counts: tuple[int, int, int], cell: float, section: Section, *, origin: ArrayLike = (0, 0, 0), **rod: Any
) -> Model:
    """An octet truss of ``counts`` cells of edge ``cell``, its joints rigid: nodes of a face-centred cubic crystal with
    struts to their nearest neighbours, twelve inside; struts are ``cell``/√2 long.

    Nodes "i.j.k" in halves of a cell, i + j + k even, so corners are "0.0.0", "2.0.0", …; rods "i.j.k-l.m.n". ``rod``
    are other arguments of ``Model.rod``. Raises ModelError for counts or a size that are none.
    """
    most = tuple(2 * n for n in _counts(counts, 3))
    a = 0.5 * number(cell, "cell", above=0.0)
    ways = [(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
    pairs: list[tuple[Place, Place]] = []
    for p in product(*(range(n + 1) for n in most)):
        if sum(p) % 2:
            continue
        for way in ways:
            q = tuple(v + w for v, w in zip(p, way, strict=True))
            if all(0 <= v <= n for v, n in zip(q, most, strict=True)):
                pairs.append((p, q))
    return _struts("octet truss", pairs, (a, a, a), section, origin, rod)


def ring(
    radius: float, section: Section, *, parts: int = 4, centre: ArrayLike = (0, 0, 0), normal: ArrayLike = (0, 0, 1),
    **rod: Any,
) -> Model:  # fmt: skip
    """A ring of ``parts`` equal arcs around ``normal``.

    Nodes "0", "1", … counted right-handed, "0" towards the Cartesian axis least aligned with the normal; rods "arc0"
    from "0" to "1", …. d1 of the rods is along the normal, d2 points to the centre. ``rod`` are
    other arguments of ``Model.rod``. Raises ModelError for fewer than two parts and values that are none.
    """
    r, n = number(radius, "radius", above=0.0), whole(parts, "parts", 2, LARGEST)
    axis = np.array(vector(normal, "normal"))
    if not axis.any():
        raise ModelError("normal = (0, 0, 0) has no direction", "give a vector")
    frame, middle = first_frame(axis / np.linalg.norm(axis), None), np.array(vector(centre, "centre"))

    def at(k: float) -> Array:
        angle = 2.0 * np.pi * (k % n) / n
        return middle + r * (np.cos(angle) * frame[:, 0] + np.sin(angle) * frame[:, 1])

    return Model(name="ring").add_rods(
        {
            **rod, "curve": arc(at(k), at(k + 0.5), at(k + 1), d1=axis), "section": section, "name": f"arc{k}",
            "ends": (str(k), str((k + 1) % n)),
        }
        for k in range(n)
    )  # fmt: skip


def spring(
    radius: float, pitch: float, turns: float, section: Section, *, wire: float | None = None, end_coils: float = 0.0,
    elements_per_turn: int = 12, seats: bool = False, **rod: Any,
) -> Model:  # fmt: skip
    """A helix spring around the z axis: ``turns`` active coils of ``pitch`` (< 0 winds left-handed), and at both ends
    ``end_coils`` closed ones, whose pitch is the diameter of the ``wire``; it changes smoothly over a quarter turn.

    One rod "wire" from node "bottom" to node "top", with nodes "active.start" and "active.end" where there are end
    coils. ``seats`` adds nodes "base" and "head" on the axis, rigidly joined to the bottom and to the top. ``wire`` is
    that of a round section unless given. ``rod`` are other arguments of ``Model.rod``. Raises ModelError for values
    that are none, or end coils without a wire.
    """
    R, p, n = number(radius, "radius", above=0.0), number(pitch, "pitch", above=0.0), number(turns, "turns")
    ends, per = number(end_coils, "end_coils", least=0.0), whole(elements_per_turn, "elements_per_turn", 3, LARGEST)
    if n == 0.0:
        raise ModelError("turns = 0 is no spring", "give a number of turns, < 0 for a left-handed one")
    if wire is None:
        sizes = np.linalg.norm(section.outline, axis=1) if len(section.outline) else np.zeros(1)
        wire = 2.0 * float(sizes.max())
        if ends and (len(sizes) < 8 or np.ptp(sizes) > 1e-9 * wire):
            raise ModelError("end coils need the diameter of the wire", "give wire=")
    total = abs(n) + 2.0 * ends
    sense, blend = float(np.sign(n)), 0.25
    u = np.linspace(0.0, total, max(40, int(np.ceil(40 * total))) + 1)

    def rate(v: Array) -> Array:
        """dz/d(turn): the wire's diameter in the end coils, the pitch between, smooth over a quarter turn."""
        if not ends:
            return np.full_like(v, p)
        from_end = np.minimum(v, total - v)
        share = np.clip((from_end - ends) / blend + 0.5, 0.0, 1.0)
        return wire + (p - wire) * share * share * (3.0 - 2.0 * share)

    middle = rate(0.5 * (u[1:] + u[:-1]))
    z = np.append(0.0, np.cumsum((rate(u[:-1]) + 4.0 * middle + rate(u[1:])) / 6.0 * np.diff(u)))
    angle = 2.0 * np.pi * sense * u
    curve = spline(np.stack([R * np.cos(angle), R * np.sin(angle), z], -1).tolist())
    named: dict[str, float] = {}
    if ends:
        way = np.append(0.0, np.cumsum(np.hypot(2.0 * np.pi * R * np.diff(u), np.diff(z))))
        named = {
            "active.start": float(np.interp(ends, u, way) / way[-1]),
            "active.end": float(np.interp(total - ends, u, way) / way[-1]),
        }
    given = {"elements": max(1, round(per * total)), **rod}
    model = Model(name="spring").rod(curve, section, name="wire", ends=("bottom", "top"), nodes=named, **given)
    if seats:
        for seat, end, height in (("base", "bottom", 0.0), ("head", "top", float(z[-1]))):
            model = model.node(seat, (0.0, 0.0, height)).rigid(seat, end, name=seat)
    return model


def weave(
    counts: tuple[int, int], spacing: float, section: Section, *, amplitude: float, weft: Section | None = None,
    elements_per_crossing: int = 4, **rod: Any,
) -> Model:  # fmt: skip
    """A plain weave: ``counts`` (warps, wefts) of wavy yarns that pass over and under one another in turn.

    Warp i runs along y at x = (i + ½) ``spacing``, weft j along x at y = (j + ½) ``spacing``; where they cross their
    axes are 2 ``amplitude`` apart. Rods "warp0", …, "weft0", … of ``section`` and ``weft`` (``section`` unless
    given), with ends "warp0.start", "warp0.end" and nodes "warp0.j" at the crossings. Nothing joins the yarns: add
    contact. ``rod`` are other arguments of ``Model.rod``. Raises ModelError for counts or sizes that are none.
    """
    warps, wefts = _counts(counts, 2)
    a, h = number(spacing, "spacing", above=0.0), number(amplitude, "amplitude", above=0.0)
    rods: list[Mapping[str, Any]] = []
    for along, mine, others, own in ((1, warps, wefts, section), (0, wefts, warps, weft or section)):
        kind, sense = ("weft", "warp")[along], 1.0 if along else -1.0
        t = np.linspace(0.0, others * a, 16 * others + 1)
        for k in range(mine):
            points = np.zeros((len(t), 3))
            points[:, along], points[:, 1 - along] = t, (k + 0.5) * a
            points[:, 2] = sense * (-1.0) ** k * h * np.sin(np.pi * t / a)
            curve = spline(points.tolist())
            name = f"{kind}{k}"
            # half periods are equally long, so crossings are at equal parts of the length
            nodes = {f"{name}.{j}": (j + 0.5) / others for j in range(others)}
            rods.append(
                {
                    "elements": whole(elements_per_crossing, "elements_per_crossing", 1, LARGEST) * others, **rod,
                    "curve": curve, "section": own, "name": name, "nodes": nodes,
                }
            )  # fmt: skip
    return Model(name="weave").add_rods(rods)


def _counts(counts: Iterable[int], size: int) -> tuple[int, ...]:
    try:
        given = tuple(counts)
    except TypeError:
        given = ()
    if len(given) != size:
        raise ModelError(f"counts = {counts} are not {size} numbers of cells", f"give {size} whole numbers")
    return tuple(whole(c, "number of cells", 1, LARGEST) for c in given)


def _struts(
    title: str, pairs: list[tuple[Place, Place]], steps: tuple[float, ...], section: Section, origin: ArrayLike,
    rod: dict[str, Any],
) -> Model:  # fmt: skip
    start = np.array(vector(origin, "origin"))
    a, b = (np.tile(start, (len(pairs), 1)) for _ in range(2))
    for k, points in enumerate((a, b)):
        points[:, : len(steps)] += np.array([pair[k] for pair in pairs]) * steps
    names = [(".".join(map(str, p)), ".".join(map(str, q))) for p, q in pairs]
    return Model(name=title).add_rods(
        {**rod, "curve": curve, "section": section, "name": f"{p}-{q}", "ends": (p, q)}
        for curve, (p, q) in zip(lines(a, b), names, strict=True)
    )
