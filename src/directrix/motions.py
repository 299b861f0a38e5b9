"""Rigid motions of parts, in words: what is free, about which axis, largest at which nodes. Pure functions.

A motion of a part is q = (t, w): its nodes move by t + (w/ℓ) × (r − c) and turn by w/ℓ, with c the middle of the part
and ℓ its size, so that both halves of q are lengths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from directrix.result import Mesh
from directrix.rotations import hat

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
ALIKE = 1e-6  # of the size of a part: what counts as the same place, or as no motion

__all__ = ["ALIKE", "Part", "axis_words", "free_motions", "largest_nodes", "place_words"]


@dataclass(frozen=True, eq=False)
class Part:
    """Rods that are rigidly joined: ``members`` their names, ``nodes`` (m,) their nodes, ``r`` (m, 3) where these are
    now, ``centre`` (3,) the middle of the box around them and ``size`` its diagonal. A node on no rod is a part that is
    ``alone``, of the size of the model."""

    members: tuple[str, ...]
    nodes: Ints
    r: Array
    centre: Array
    size: float
    alone: bool = False

    @property
    def name(self) -> str:
        """ "rod 'arm'", or "part 'mast' (12 members)" after the first of several."""
        first, count = self.members[0], len(self.members)
        if self.alone:
            return f"node {first!r}"
        return f"rod {first!r}" if count == 1 else f"part {first!r} ({count} members)"

    def moved(self) -> Array:
        """(m, 6, 6): displacement and size times turn of each node, for each of the six motions q."""
        out = np.zeros((len(self.nodes), 6, 6))
        out[:, :3, :3] = out[:, 3:, 3:] = np.eye(3)
        out[:, :3, 3:] = -hat((self.r - self.centre) / self.size)
        return out


def free_motions(part: Part, motions: Array, mesh: Mesh) -> str:
    """Independent motions (6, k) of a part in words."""
    u, s, _ = np.linalg.svd(motions, full_matrices=False)
    basis = u[:, s > ALIKE * max(s.max(initial=0.0), 1e-300)]
    if basis.shape[1] == 6:
        return "in every direction, as a rigid body: it has no support"
    _, turning, vt = np.linalg.svd(basis[3:], full_matrices=True)
    rank = int(np.sum(turning > ALIKE))
    shifts = basis[:3] @ vt[rank:].T
    return " and ".join([*_translations(shifts), *_rotations(part, basis @ vt[:rank].T, shifts, mesh)])


def _translations(shifts: Array) -> list[str]:
    match shifts.shape[1]:
        case 0:
            return []
        case 1:
            return [f"translation along {axis_words(shifts[:, 0])}"]
        case 2:
            return [f"translation in the plane normal to {axis_words(np.cross(shifts[:, 0], shifts[:, 1]))}"]
        case _:
            return ["translation in every direction"]


def _rotations(part: Part, turns: Array, shifts: Array, mesh: Mesh) -> list[str]:
    """Motions (6, k) that turn, each up to the translations ``shifts`` (3, j) that are free as well."""
    count = turns.shape[1]
    if count == 0:
        return []
    onto = np.eye(3) - shifts @ np.linalg.pinv(shifts) if shifts.shape[1] else np.eye(3)
    moves = np.concatenate([onto @ hat(w) for w in turns[3:].T])
    centre_moves = np.concatenate([onto @ t for t in turns[:3].T])
    at = np.linalg.lstsq(moves, -centre_moves, rcond=ALIKE)[0]
    if np.abs(moves @ at + centre_moves).max() > 10.0 * ALIKE:  # no point stays where it is
        if count > 1:
            return [words for k in range(count) for words in _rotations(part, turns[:, k : k + 1], shifts, mesh)]
        w = turns[3:, 0]
        lead = 2.0 * np.pi * part.size * float(w @ turns[:3, 0]) / float(w @ w)
        return [f"a screw about {axis_words(w)} through {place_words(part.centre + part.size * at)}, {lead:.3g} a turn"]
    through = place_words(part.centre + part.size * at)
    named = {k: name for name, k in mesh.node_names.items()}
    for node, r in zip(part.nodes.tolist(), part.r, strict=True):
        off = moves @ ((r - part.centre) / part.size) + centre_moves
        if node in named and np.abs(off).max() <= 10.0 * ALIKE:
            through = f"node {named[node]!r} {place_words(r)}"
            break
    match count:
        case 1:
            return [f"rotation about {axis_words(turns[3:, 0])} through {through}"]
        case 2:
            normal = np.cross(turns[3:, 0], turns[3:, 1])
            return [f"rotation about every axis normal to {axis_words(normal)} through {through}"]
        case _:
            return [f"rotation about every axis through {through}"]


def largest_nodes(displacement: Array, nodes: Ints, mesh: Mesh, most: int = 3) -> tuple[str, ...]:
    """Labels of the nodes that move most: ``displacement`` (m,) ≥ 0 of ``nodes`` (m,). Named nodes are preferred to
    others that move as far; nothing when nothing moves."""
    top = float(displacement.max(initial=0.0))
    if top <= ALIKE:
        return ()
    named = set(mesh.node_names.values())
    far = [k for k in np.argsort(-displacement, kind="stable").tolist() if displacement[k] >= 0.9 * top]
    chosen = [k for k in far if int(nodes[k]) in named] or far[:1]
    return tuple(mesh.label(int(nodes[k])) for k in chosen[:most])


def axis_words(direction: Array) -> str:
    """ "x" for a direction along an axis, else its components; the sign says nothing."""
    d = direction / np.linalg.norm(direction)
    d = d * np.sign(d[np.argmax(np.abs(d) > 0.5 * np.abs(d).max())])
    k = int(np.argmax(np.abs(d)))
    return "xyz"[k] if abs(d[k]) > 1.0 - 1e-9 else _vector(d, 1.0)


def place_words(point: Array) -> str:
    """A place by its coordinates."""
    return _vector(point, float(np.abs(point).max()))


def _vector(v: Sequence[float] | Array, size: float) -> str:
    # what is nothing beside the rest is nothing; adding zero turns −0 into 0
    return "(" + ", ".join(f"{0.0 if abs(x) < 1e-9 * size else x + 0.0:.4g}" for x in v) + ")"
