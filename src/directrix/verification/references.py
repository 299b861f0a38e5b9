"""Answers by other means than elements: elliptic integrals, and the rod's ordinary differential equations.

The rod: n' = −Σ F δ(S − S_F), m' = −r' × n, r' = Λ (e3 + Γ), Λ' = Λ hat(K0 + K), Γ = C_Γ⁻¹ Λᵀ n, K = C_K⁻¹ Λᵀ m, with
Λ = [d1 d2 d3]. Dead loads make n known, so that the moment at the root is all there is to shoot for.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

from directrix.rotations import hat

Array = NDArray[np.float64]

__all__ = ["ALONG_X", "Shot", "elastica", "follower", "shoot", "solve"]

ALONG_X = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # columns d1 = y, d2 = z, d3 = x
TIGHT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


def elastica(a: float) -> tuple[float, float, float]:
    """Deflection w/L, shortening u/L and slope of the tip of the inextensible cantilever under a = PL²/EI.

    With k² = ½(1 + sin θ) and sin φ = 1/(k√2): √a = K(k) − F(φ, k), w/L = 1 − (2/√a)(E(k) − E(φ, k)),
    x/L = √(2 sin θ/a).
    """

    def parts(theta: float, integral: Callable[[float, float], float]) -> float:
        m = 0.5 * (1.0 + np.sin(theta))
        return integral(0.5 * np.pi, m) - integral(np.arcsin(np.sqrt(0.5 / m)), m)

    def excess(theta: float) -> float:
        return parts(theta, ellipkinc) - float(np.sqrt(a))

    root: Any = brentq(excess, 1e-9, 0.5 * np.pi - 1e-12, xtol=1e-15)
    theta = float(root)
    w = 1.0 - 2.0 / np.sqrt(a) * parts(theta, ellipeinc)
    return float(w), float(1.0 - np.sqrt(2.0 * np.sin(theta) / a)), theta


def solve(residual: Callable[[Array], Array], guess: ArrayLike, size: float = 1.0, tolerance: float = 1e-11) -> Array:
    """Newton's iteration with forward differences; ``residual`` takes (k, p) points at once and returns (k, p).

    ``size`` is that of the unknowns. Raises ArithmeticError when it does not settle.
    """
    x = np.array(guess, float)
    step = 1e-7 * size
    last = np.inf
    for _ in range(30):
        rows = residual(np.concatenate([x[None], x + step * np.eye(len(x))]))
        update = np.linalg.solve((rows[1:] - rows[0]).T / step, rows[0])
        x = x - update
        change = float(np.abs(update).max()) / size
        if change <= tolerance or (change < 1e-9 and change >= 0.5 * last):
            return x
        if not change < 1e3:
            break
        last = change
    raise ArithmeticError("the shooting does not settle")


@dataclass(frozen=True)
class Shot:
    """The exact rod: ``r`` and ``directors`` (columns) of the tip, and ``axis(S)`` → (…, 3)."""

    r: Array
    directors: Array
    axis: Callable[[ArrayLike], Array]


def shoot(
    stiffness: ArrayLike, length: float, *, force: ArrayLike = (0, 0, 0), moment: ArrayLike = (0, 0, 0),
    between: Sequence[tuple[float, ArrayLike]] = (), directors: Array = ALONG_X, curvature: ArrayLike = (0, 0, 0),
    ramp: int = 4, guess: ArrayLike | None = None,
) -> Shot:  # fmt: skip
    """The clamped rod under dead end loads, from the origin.

    ``stiffness`` (6,) in the order shear 1, shear 2, axial, bending 1, bending 2, torsion; ``between`` further forces
    as (S, force); ``curvature`` (3,) of the reference in its own frame. The load grows in ``ramp`` parts, unless the
    root moment is guessed.
    """
    flexible = 1.0 / np.asarray(stiffness, float)
    tip_force, tip_moment, k0 = (np.asarray(v, float) for v in (force, moment, curvature))
    inner = sorted(((float(s), np.asarray(f, float)) for s, f in between), key=lambda pair: pair[0])
    cuts = [0.0, *(s for s, _ in inner), float(length)]

    def march(m0: Array, factor: float, dense: bool = False) -> list[Any]:
        """Integrate from root moments (k, 3); one solution a segment."""
        k = len(m0)
        state = np.concatenate([np.zeros((k, 3)), np.broadcast_to(directors.ravel(), (k, 9)), m0], axis=1).ravel()
        solutions: list[Any] = []
        for i, (a, b) in enumerate(itertools.pairwise(cuts)):
            n = factor * (tip_force + sum((f for _, f in inner[i:]), np.zeros(3)))

            def slope(_: float, y: Array, n: Array = n) -> Array:
                y = y.reshape(k, 15)
                frame, m = y[:, 3:12].reshape(k, 3, 3), y[:, 12:]
                turned = frame.transpose(0, 2, 1)
                strain = flexible[:3] * (turned @ n)
                strain[:, 2] += 1.0
                bend = k0 + flexible[3:] * np.einsum("kij,kj->ki", turned, m)
                tangent = np.einsum("kij,kj->ki", frame, strain)
                return np.concatenate(
                    [tangent, (frame @ hat(bend)).reshape(k, 9), -np.cross(tangent, n)], axis=1
                ).ravel()

            solutions.append(solve_ivp(slope, (a, b), state, dense_output=dense, **TIGHT))
            state = solutions[-1].y[:, -1]
        return solutions

    lever = float(np.abs(tip_force).max() + sum(np.abs(f).max() for _, f in inner)) * length
    size = max(lever, float(np.abs(tip_moment).max()), 1e-300)
    factors = [1.0] if guess is not None else [(i + 1) / ramp for i in range(ramp)]
    path = [np.zeros(3)] if guess is None else [np.asarray(guess, float)]
    for factor in factors:
        start = path[-1] if len(path) < 2 else 2.0 * path[-1] - path[-2]
        path.append(
            solve(
                lambda m0, f=factor: march(m0, f)[-1].y[:, -1].reshape(len(m0), 15)[:, 12:] - f * tip_moment,
                start,
                size,
            )
        )
    segments = march(path[-1][None], 1.0, dense=True)

    def axis(s: ArrayLike) -> Array:
        s = np.asarray(s, float)
        part = np.clip(np.searchsorted(cuts, s, side="right") - 1, 0, len(segments) - 1)
        values = np.stack([segment.sol(s.ravel())[:3].T for segment in segments])
        return values[part.ravel(), np.arange(s.size)].reshape(*s.shape, 3)

    end = segments[-1].y[:, -1]
    return Shot(end[:3], end[3:12].reshape(3, 3), axis)


def follower(P: float, EI: float, EA: float, GA: float, length: float) -> tuple[float, float, float]:
    """Tip displacement (axial, transverse) and rotation of the plane cantilever, force P normal to its tip section.

    In the frame of the tip the section force is known, so the equations are integrated from the tip to the root and
    the picture is turned until the root points along x.
    """

    def slope(_: float, y: Array) -> list[float]:
        c, s = np.cos(y[2]), np.sin(y[2])
        axial, shear = 1.0 + P * s / EA, P * c / GA
        dx, dy = c * axial - s * shear, s * axial + c * shear
        return [dx, dy, y[3] / EI, -dx * P]

    x, y, turn, _ = solve_ivp(slope, (length, 0.0), [0.0, 0.0, 0.0, 0.0], **TIGHT).y[:, -1]
    c, s = np.cos(turn), np.sin(turn)
    return float(-c * x - s * y) - length, float(s * x - c * y), float(-turn)
