"""Rotations in three dimensions: pure functions, batched over leading axes, tested by what defines them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

__all__ = ["axial", "cay", "exp", "hat", "is_rotation", "log", "smallest_rotation"]


def hat(v: ArrayLike) -> Array:
    """The matrix of v ×: (…, 3) → (…, 3, 3)."""
    v = np.asarray(v, float)
    out = np.zeros((*v.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i, j], out[..., j, i] = -v[..., k], v[..., k]
    return out


def axial(a: Array) -> Array:
    """The vector of the skew part: (…, 3, 3) → (…, 3), the inverse of :func:`hat`."""
    return 0.5 * np.stack([a[..., k, j] - a[..., j, k] for j, k in ((1, 2), (2, 0), (0, 1))], -1)


def exp(v: ArrayLike) -> Array:
    """Rotation by the vector v [rad]: (…, 3) → (…, 3, 3) (Rodrigues)."""
    v = np.asarray(v, float)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    a = np.sinc(angle / np.pi)
    b = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    skew = hat(v)
    return np.eye(3) + a * skew + b * (skew @ skew)


def log(rotation: Array) -> Array:
    """Rotation vector of a rotation, |v| ≤ π: (…, 3, 3) → (…, 3); exact near 0 and near π."""
    # the unit quaternion with the largest component first never divides by something small
    trace = np.trace(rotation, axis1=-2, axis2=-1)
    diagonal = np.diagonal(rotation, axis1=-2, axis2=-1)
    squares = np.concatenate([1.0 + trace[..., None], 1.0 - trace[..., None] + 2.0 * diagonal], -1)
    skew, even = 2.0 * axial(rotation), rotation + np.swapaxes(rotation, -1, -2)
    candidates = [np.concatenate([squares[..., :1], skew], -1)]
    for i in range(3):
        row = even[..., i, :].copy()
        row[..., i] = squares[..., 1 + i]
        candidates.append(np.concatenate([skew[..., i : i + 1], row], -1))
    best = np.argmax(squares, -1)[..., None, None]
    q: Array = np.take_along_axis(np.stack(candidates, -2), best, -2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    q = np.where(q[..., :1] < 0.0, -q, q)
    size = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(size, q[..., :1])
    return q[..., 1:] * np.where(size > 1e-300, angle / np.fmax(size, 1e-300), 2.0)


def cay(v: ArrayLike) -> Array:
    """Cayley transform of the pseudo-vector ϑ: R1 = cay(ϑ) R0 gives d1 − d0 = ϑ × ½(d0 + d1) (paper 49)."""
    v = np.asarray(v, float)
    skew = hat(v)
    return np.eye(3) + (skew + 0.5 * (skew @ skew)) / (1.0 + 0.25 * np.sum(v * v, -1))[..., None, None]


def smallest_rotation(a: ArrayLike, b: ArrayLike) -> Array:
    """The rotation of least angle that takes the unit vectors a to b: (…, 3), (…, 3) → (…, 3, 3).

    Opposite vectors have no smallest rotation; the result is then not finite.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    skew = hat(np.cross(a, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.eye(3) + skew + (skew @ skew) / (1.0 + np.sum(a * b, -1))[..., None, None]


def is_rotation(rotation: Array, tolerance: float = 1e-9) -> bool:
    """True when every matrix is orthonormal and right-handed within ``tolerance``."""
    gram = np.swapaxes(rotation, -1, -2) @ rotation
    return bool(np.all(np.abs(gram - np.eye(3)) <= tolerance) and np.all(np.linalg.det(rotation) > 0.0))
