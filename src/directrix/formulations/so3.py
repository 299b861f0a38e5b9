"""Rotations over scalars: plain Python that can be recorded. A rotation is its three columns.

Nothing is branched on a value. The functions are smooth up to, not at, a turn by π, which no element comes near.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial

from directrix.formulations.layout import Scalar, Vector
from directrix.kernels.trace import cross, dot

__all__ = [
    "Columns", "add", "cayley", "cayley_vector", "combine", "exp", "from_body", "log", "relative", "scale", "spin_rate",
    "stumpff", "sub", "times", "to_body", "transposed",
    "turn_over_sine",
]  # fmt: skip

Columns = Sequence[Vector]


def scale(a: Scalar, v: Vector) -> Vector:
    """a v."""
    return tuple(a * c for c in v)


def sub(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return tuple(s - t for s, t in zip(a, b, strict=True))


def add(*vectors: Vector) -> Vector:
    """Sum."""
    return tuple(sum(v[k] for v in vectors) for k in range(3))


def combine(weights: Sequence[float], vectors: Sequence[Vector]) -> Vector:
    """Σ w_a v_a."""
    return tuple(sum(float(w) * v[k] for w, v in zip(weights, vectors, strict=True)) for k in range(3))


def from_body(R: Columns, v: Vector) -> Vector:
    """R v."""
    return add(*(scale(v[c], R[c]) for c in range(3)))


def to_body(R: Columns, v: Vector) -> Vector:
    """Rᵀ v."""
    return tuple(dot(R[c], v) for c in range(3))


def times(A: Columns, B: Columns) -> Columns:
    """A B."""
    return tuple(from_body(A, B[c]) for c in range(3))


def transposed(A: Columns) -> Columns:
    """Aᵀ."""
    return tuple(tuple(A[c][k] for c in range(3)) for k in range(3))


def relative(A: Columns, B: Columns) -> Columns:
    """A Bᵀ: the rotation that takes B to A."""
    return tuple(tuple(sum(A[c][i] * B[c][j] for c in range(3)) for i in range(3)) for j in range(3))


def _axial(A: Columns) -> Vector:
    """Axial vector of A − Aᵀ; 2 sin φ times the axis for a rotation by φ."""
    return A[1][2] - A[2][1], A[2][0] - A[0][2], A[0][1] - A[1][0]


def cayley_vector(A: Columns) -> Vector:
    """ϑ with A = cay(ϑ): 2 tan(φ/2) times the axis (paper A15)."""
    factor = 2.0 / (1.0 + A[0][0] + A[1][1] + A[2][2])
    return scale(factor, _axial(A))


def cayley(v: Vector) -> Columns:
    """cay(ϑ) (paper A15)."""
    factor = 1.0 / (1.0 + 0.25 * dot(v, v))
    return _rodrigues(v, factor, 0.5 * factor)


def _rodrigues(v: Vector, a: Scalar, b: Scalar) -> Columns:
    """1 + a v̂ + b v̂²."""
    s = dot(v, v)
    unit = [[1.0 if k == c else 0.0 for k in range(3)] for c in range(3)]
    return tuple(
        tuple(u + a * t + b * (v[k] * v[c] - s * u) for k, (u, t) in enumerate(zip(e, cross(v, e), strict=True)))
        for c, e in enumerate(unit)
    )


def stumpff(k: int, s: Scalar) -> Scalar:
    """c_k(s) = Σ_j (−s)^j / (2j + k)!: c_1 = sin φ/φ, c_2 = (1 − cos φ)/φ² for s = φ²; to round-off for φ ≤ 4."""
    total: Scalar = 0.0
    for j in range(17, -1, -1):
        total = 1.0 / factorial(2 * j + k) - s * total
    return total


def exp(v: Vector) -> Columns:
    """Rotation by |v| about v, |v| ≤ 4."""
    s = dot(v, v)
    return _rodrigues(v, stumpff(1, s), stumpff(2, s))


def spin_rate(v: Vector, slope: Vector, body: bool = False) -> Vector:
    """Axial vector of R'Rᵀ for R = exp(v), v' = ``slope``; of RᵀR' with ``body``: T(v) v'."""
    s = dot(v, v)
    turn = -stumpff(2, s) if body else stumpff(2, s)
    return add(scale(stumpff(1, s), slope), scale(stumpff(3, s) * dot(v, slope), v), scale(turn, cross(v, slope)))


def log(A: Columns) -> Vector:
    """Rotation vector of A, less than π long."""
    axial = _axial(A)
    ratio = turn_over_sine(0.5 * (A[0][0] + A[1][1] + A[2][2] - 1.0), 0.25 * dot(axial, axial))
    return scale(0.5 * ratio, axial)


def turn_over_sine(cosine: Scalar, sine2: Scalar) -> Scalar:
    """φ / sin φ from cos φ and sin² φ, |φ| < π: four times the half angle, then arctan by its series."""
    half = [cosine]
    for _ in range(4):
        half.append((0.5 * (1.0 + half[-1])) ** 0.5)
    product = half[1] * half[2] * half[3] * half[4]
    # sin φ = 16 sin(φ/16) cos(φ/2) cos(φ/4) cos(φ/8) cos(φ/16)
    tan2 = sine2 / (256.0 * product * product * half[4] * half[4])
    series: Scalar = 0.0
    for j in range(11, -1, -1):
        series = 1.0 / (2 * j + 1) - tan2 * series
    return series / (product * half[4])
