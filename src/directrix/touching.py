"""Nodes that touch and are not joined: the usual reason why a part has no support."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation
from directrix.motions import Part

Array = NDArray[np.float64]
NEAR = 1e-3  # of the size of the smaller part

__all__ = ["join_advice"]


def join_advice(disc: Discretisation, part: Part, others: tuple[Part, ...]) -> str:
    """A sentence on a node of ``part`` that is at, or next to, a node or a rod of another part; "" when none is."""
    for words, _ in sorted(_contacts(disc, part, others), key=lambda c: c[1]):
        return words
    return ""


def _contacts(disc: Discretisation, part: Part, others: tuple[Part, ...]) -> Iterator[tuple[str, float]]:
    named = {k: name for name, k in disc.mesh.node_names.items()}
    own = [int(k) for k in part.nodes if int(k) in named]
    r0 = disc.mesh.r0
    jointed = {frozenset(joint.nodes) for joint in disc.model.joints}
    for other in others:
        if other is part:
            continue
        near = NEAR * min(part.size, other.size)
        theirs = np.array([int(k) for k in other.nodes if int(k) in named])
        for k in own:
            gaps = np.linalg.norm(r0[theirs] - r0[k], axis=1)
            gap, there = float(gaps.min()), named[int(theirs[gaps.argmin()])]
            if frozenset((named[k], there)) in jointed:
                continue
            if gap <= near:
                apart = "at the same place" if gap <= 1e-9 * other.size else f"{gap:.3g} apart"
                yield f"nodes {named[k]!r} and {there!r} are {apart} and not joined: give them one name", gap
            else:
                yield from _on_a_rod(disc, named[k], r0[k], other, near)
        for k in theirs.tolist():
            yield from _on_a_rod(disc, named[k], r0[k], part, near)


def _on_a_rod(disc: Discretisation, name: str, point: Array, other: Part, near: float) -> Iterator[tuple[str, float]]:
    """A point on the axis of a rod, between its ends."""
    for rod in disc.mesh.rods:
        if rod.name not in other.members:
            continue
        a, b = disc.mesh.r0[rod.nodes[:-1]], disc.mesh.r0[rod.nodes[1:]]
        along = np.einsum("ni,ni->n", point - a, b - a) / np.einsum("ni,ni->n", b - a, b - a)
        t = np.clip(along, 0.0, 1.0)
        gaps = np.linalg.norm(a + t[:, None] * (b - a) - point, axis=1)
        k = int(gaps.argmin())
        s = rod.s[k] + t[k] * (rod.s[k + 1] - rod.s[k])
        if gaps[k] <= near and 1e-6 < s / rod.s[-1] < 1.0 - 1e-6:
            yield (
                f"node {name!r} lies on rod {rod.name!r} and is not joined to it: name that place "
                f"with nodes={{{name!r}: {s / rod.s[-1]:.6g}}} there",
                float(gaps[k]),
            )
