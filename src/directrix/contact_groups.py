"""Contacts as elements: nodes against surfaces, and the pairs of points and pieces of rods that are near in a state."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss
from directrix.contacts import Contact, Plane, RodContact, Touch, force_per_length
from directrix.errors import ModelError
from directrix.formulations.attached import AttachedLayout
from directrix.formulations.contact import ObstacleElement, PairElement
from directrix.groups import Group
from directrix.scheme import Rates, Scheme

if TYPE_CHECKING:
    from directrix.model import Model
    from directrix.result import Mesh

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Pairs = tuple[Ints, ...]
"""Per contact of rods the pairs in it, point · pieces + piece, in ascending order."""

__all__ = ["Near", "Pairs", "contact_states", "near_of", "obstacle_groups", "refuse_rod_contacts", "union"]

SKIN = 0.5  # of the reach: pairs are taken in from here on
LEAST = 0.1  # of the reach: with any pair nearer than this not in it, the set is made anew


def _group(element: ObstacleElement | PairElement, conn: Ints, parameters: Array, touch: Touch, inside: bool) -> Group:
    count = len(conn)
    layout = AttachedLayout(conn.shape[1], 0, True, parameters=parameters.shape[1])
    nothing: Ints = np.zeros(count, np.int64)
    return Group(
        element, layout, conn, parameters, nothing, np.zeros((count, 0)), (touch.where,) * count, element.rough,
        grounded=isinstance(element, ObstacleElement), condensed=isinstance(element, ObstacleElement), inside=inside,
    )  # fmt: skip


def _rough(touch: Touch, scheme: Scheme) -> bool:
    """Whether friction acts; raises ModelError for a scheme that has no form for it."""
    if touch.friction and scheme.rates is Rates.ALPHA:
        raise ModelError(
            f"{touch.where} has friction, and the generalised-α family has no form for that",
            "use a step of the midpoint family, e.g. dx.EnergyMomentum(), or leave friction= out",
        )
    return touch.friction > 0.0 and not scheme.static


def obstacle_groups(
    model: Model, scheme: Scheme, spread: Mapping[str, tuple[Ints, Array]], ends: Ints
) -> tuple[Group, ...]:
    """Nodes of rods against surfaces; raises ModelError for what the scheme has no form for.

    ``spread`` has the nodes of every rod and the length that each stands for, ``ends`` the nodes that are no
    interior ones.
    """
    groups: list[Group] = []
    for contact in model.contacts:
        rough = _rough(contact, scheme)
        element = ObstacleElement(scheme.rates, isinstance(contact.obstacle, Plane), rough)
        nodes: list[Ints] = []
        rows: list[Array] = []
        for rod in model.rods:
            if contact.rods is not None and rod.name not in contact.rods:
                continue
            found, back = np.unique(spread[rod.name][0], return_inverse=True)
            length = np.bincount(back, spread[rod.name][1])
            radius = contact.radius_of(rod.name, rod.section)
            row = [*contact.obstacle.row(), radius, 0.0, contact.width_of(radius), *contact.rubbing]
            table = np.tile(row, (len(found), 1))
            table[:, 9] = contact.stiffness * length
            nodes.append(found)
            rows.append(table)
        conn, table = np.concatenate(nodes)[:, None], np.concatenate(rows)
        at_end = np.isin(conn[:, 0], ends)
        for inside in (True, False):
            part = at_end != inside
            if part.any():
                groups.append(_group(element, conn[part], table[part], contact, inside))
    return tuple(groups)


class _Pieces(NamedTuple):
    """Straight pieces between neighbouring nodes of rods: nodes, rod, arclength from and to, radius."""

    nodes: Ints
    rod: Ints
    s: Array
    radius: Array


@dataclass(frozen=True)
class _Side:
    """What one contact of rods may bring together. ``sides`` (2, rods) says which rods are on which side;
    ``joints`` (k, 4) are pairs of rods that share a node, and where it is on each."""

    touch: RodContact
    element: PairElement
    pieces: _Pieces
    sides: NDArray[np.bool_]
    joints: tuple[tuple[int, float, int, float], ...]

    @cached_property
    def points(self) -> tuple[Ints, Array, Array]:
        """Piece, place on it and length of every point."""
        xi, w = gauss(self.touch.points)
        count = len(self.pieces.nodes)
        piece = np.repeat(np.arange(count), len(xi))
        length = np.diff(self.pieces.s, axis=1).ravel()
        return piece, np.tile(0.5 * (1.0 + xi), count), np.outer(0.5 * length, w).ravel()

    @cached_property
    def reach(self) -> float:
        """Largest sum of two radii."""
        return 2.0 * float(self.pieces.radius.max())

    def may_touch(self, first: Ints, second: Ints) -> NDArray[np.bool_]:
        """Whether the pieces ``first`` and ``second`` are on two sides, and far enough apart along the axes."""
        rod, s, radius = self.pieces.rod, self.pieces.s, self.pieces.radius
        a, b = rod[first], rod[second]
        good = (self.sides[0, a] & self.sides[1, b]) | (self.sides[1, a] & self.sides[0, b])
        away = np.where(a == b, np.maximum(s[second, 0] - s[first, 1], s[first, 0] - s[second, 1]), np.inf)
        for one, at_one, other, at_other in self.joints:
            for i, at_i, j, at_j in ((one, at_one, other, at_other), (other, at_other, one, at_one)):
                both = (a == i) & (b == j)
                if both.any():
                    along = _distance(s[first[both]], at_i) + _distance(s[second[both]], at_j)
                    away[both] = np.minimum(away[both], along)
        return good & (away >= 0.5 * np.pi * (radius[first] + radius[second]))

    def pairs(self, r: Array, margin: float) -> Ints:
        """Pairs nearer than ``margin`` to a touch at the positions ``r`` (n, 3)."""
        from scipy.spatial import KDTree

        piece, place, _ = self.points
        ends = r[self.pieces.nodes]
        at = _on(ends[piece], place)
        half = 0.5 * float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
        tree = KDTree(ends.mean(axis=1))
        found = tree.query_ball_point(at, self.reach + margin + half)
        count = np.array([len(k) for k in found])
        point = np.repeat(np.arange(len(at)), count)
        other = np.fromiter((j for k in found for j in k), np.int64, int(count.sum()))
        keep = self.may_touch(piece[point], other)
        point, other = point[keep], other[keep]
        near = self.distances(r, point, other)[0] < self._reaches(piece[point], other) + margin
        return np.sort(point[near] * len(self.pieces.nodes) + other[near])

    def _reaches(self, first: Ints, second: Ints) -> Array:
        return self.pieces.radius[first] + self.pieces.radius[second]

    def distances(self, r: Array, point: Ints, other: Ints) -> tuple[Array, Array]:
        """Distances of points from pieces, and from the ends of the pieces."""
        near, end = self._shortest(r, point, other)
        return np.linalg.norm(near, axis=1), np.linalg.norm(end, axis=1)

    def _shortest(self, r: Array, point: Ints, other: Ints) -> tuple[Array, Array]:
        """Vectors to points from the nearest places of pieces, and from the ends of the pieces."""
        piece, place, _ = self.points
        at, ends = _on(r[self.pieces.nodes[piece[point]]], place[point]), r[self.pieces.nodes[other]]
        y, u = at - ends[:, 0], ends[:, 1] - ends[:, 0]
        t = np.clip(np.sum(y * u, axis=1) / np.maximum(np.sum(u * u, axis=1), 1e-300), 0.0, 1.0)
        return y - t[:, None] * u, y - u

    def crossed(self, before: Array, after: Array) -> int:
        """A node where rods passed through one another between two positions (n, 3), or −1.

        Where they did, the shortest way from one to the other turned round.
        """
        motion = 2.0 * float(np.linalg.norm(after - before, axis=1).max())
        point, other = np.divmod(self.pairs(before, motion), len(self.pieces.nodes))
        first, second = (self._shortest(r, point, other)[0] for r in (before, after))
        bad = np.flatnonzero(np.sum(first * second, axis=1) < 0.0)
        return int(self.pieces.nodes[other[bad[0]], 0]) if len(bad) else -1

    def parameters(self, pairs: Ints) -> tuple[Ints, Array]:
        """Nodes (ne, 4) and parameters (ne, 8) of :class:`PairElement`."""
        piece, place, length = self.points
        point, other = np.divmod(pairs, len(self.pieces.nodes))
        first, radius = piece[point], self.pieces.radius
        reach = self._reaches(first, other)
        smaller = np.minimum(radius[first], radius[other])
        width = 0.1 * smaller if self.touch.width is None else np.full(len(pairs), self.touch.width)
        goes_on = np.append(self.pieces.rod[1:] == self.pieces.rod[:-1], False)[other]
        goes_on &= self.may_touch(first, np.minimum(other + 1, len(self.pieces.nodes) - 1))
        mu, slow = self.touch.rubbing
        one = np.ones(len(pairs))
        table = [
            # every two rods meet twice, each time one of them by its points
            place[point], 0.5 * self.touch.stiffness * length[point], reach, width, radius[first] / reach,
            goes_on.astype(float), mu * one, slow * one,
        ]  # fmt: skip
        return np.concatenate([self.pieces.nodes[first], self.pieces.nodes[other]], axis=1), np.stack(table, axis=1)

    def state(self, r: Array) -> tuple[float, float]:
        """Smallest gap (infinite when nothing is near) and sum of the normal forces at ``r`` (n, 3)."""
        pairs = self.pairs(r, SKIN * self.reach)
        if not len(pairs):
            return np.inf, 0.0
        _, p = self.parameters(pairs)
        near, end = self.distances(r, *np.divmod(pairs, len(self.pieces.nodes)))
        force = force_per_length(1.0, p[:, 2] - near, p[:, 3]) - p[:, 5] * force_per_length(1.0, p[:, 2] - end, p[:, 3])
        return float((near - p[:, 2]).min()), float((p[:, 1] * force).sum())


@dataclass(frozen=True)
class Near:
    """Finds what rods may touch in a state."""

    sides: tuple[_Side, ...]

    @cached_property
    def reach(self) -> float:
        """Smallest radius, twice."""
        return 2.0 * min(float(side.pieces.radius.min()) for side in self.sides)

    def around(self, r: Array) -> Pairs:
        """Pairs to take into account from the positions ``r`` (n, 3) on."""
        return tuple(side.pairs(r, SKIN * side.reach) for side in self.sides)

    def outside(self, pairs: Pairs, r: Array, *, touching: bool) -> bool:
        """Whether pairs that are not among ``pairs`` touch at ``r``, or (not ``touching``) are about to."""
        return any(
            not np.isin(side.pairs(r, 0.0 if touching else LEAST * side.reach), known, assume_unique=True).all()
            for side, known in zip(self.sides, pairs, strict=True)
        )

    def crossed(self, before: Array, after: Array) -> int:
        """See :meth:`_Side.crossed`."""
        return max(side.crossed(before, after) for side in self.sides)

    def groups(self, pairs: Pairs) -> tuple[Group, ...]:
        """Elements for ``pairs``."""
        return tuple(
            _group(side.element, *side.parameters(known), side.touch, False)
            for side, known in zip(self.sides, pairs, strict=True)
            if len(known)
        )


def union(a: Pairs, b: Pairs) -> Pairs:
    """All pairs of both."""
    return tuple(np.union1d(one, other) for one, other in zip(a, b, strict=True))


def near_of(model: Model, mesh: Mesh, scheme: Scheme) -> Near | None:
    """What finds the contacts between rods of a model; None when it has none."""
    if not model.rod_contacts:
        return None
    joints: list[tuple[int, float, int, float]] = []
    for i, one in enumerate(mesh.rods):
        for j in range(i + 1, len(mesh.rods)):
            other = mesh.rods[j]
            for node in np.intersect1d(one.nodes, other.nodes):
                at = (float(rod.s[np.flatnonzero(rod.nodes == node)[0]]) for rod in (one, other))
                joints.append((i, next(at), j, next(at)))
    sides: list[_Side] = []
    for touch in model.rod_contacts:
        parties = (touch.rods, touch.rods if touch.others is None else touch.others)
        member = np.array([[names is None or rod.name in names for rod in mesh.rods] for names in parties])
        kept = [k for k in range(len(mesh.rods)) if member[:, k].any()]
        radius = {k: touch.radius_of(mesh.rods[k].name, model.rods[k].section) for k in kept}
        pieces = [
            _Pieces(
                np.stack([rod.nodes[:-1], rod.nodes[1:]], 1), np.full(len(rod.s) - 1, k),
                np.stack([rod.s[:-1], rod.s[1:]], 1), np.full(len(rod.s) - 1, radius[k]),
            )
            for k, rod in ((k, mesh.rods[k]) for k in kept)
        ]  # fmt: skip
        together = _Pieces(*(np.concatenate(part) for part in zip(*pieces, strict=True)))
        sides.append(_Side(touch, PairElement(scheme.rates, _rough(touch, scheme)), together, member, tuple(joints)))
    return Near(tuple(sides))


def refuse_rod_contacts(model: Model, why: str, where: str = "") -> None:
    """Raise ModelError when rods may touch one another: their pairs, and the system with them, come and go."""
    for touch in model.rod_contacts:
        raise ModelError(
            f"{touch.where} brings rods together and parts them, and {why}",
            "use load control or dx.simulate, or leave the contact of rods out",
            where,
        )


def contact_states(
    contacts: Sequence[Contact], model: Model, spread: Mapping[str, tuple[Ints, Array]], near: Near | None, r: Array
) -> dict[str, Array]:
    """Smallest gap and sum of the normal forces (nt, 2) of every contact at the positions ``r`` (nt, n, 3)."""
    out: dict[str, Array] = {}
    for contact in contacts:
        gap, force = np.full(len(r), np.inf), np.zeros(len(r))
        for rod in model.rods:
            if contact.rods is not None and rod.name not in contact.rods:
                continue
            nodes, length = spread[rod.name]
            radius = contact.radius_of(rod.name, rod.section)
            here = contact.gap(r[:, nodes], radius)
            gap = np.minimum(gap, here.min(axis=1))
            force += force_per_length(contact.stiffness, -here, contact.width_of(radius)) @ length
        out[contact.name] = np.stack([gap, force], -1)
    for side in near.sides if near is not None else ():
        out[side.touch.name] = np.array([side.state(at) for at in r])
    return out


def _on(ends: Array, place: Array) -> Array:
    """Points (k, 3) between the ends (k, 2, 3)."""
    return ends[:, 0] + place[:, None] * (ends[:, 1] - ends[:, 0])


def _distance(s: Array, at: float) -> Array:
    """Distance of the intervals ``s`` (k, 2) from the arclength ``at``."""
    return np.maximum(np.maximum(s[:, 0] - at, at - s[:, 1]), 0.0)
