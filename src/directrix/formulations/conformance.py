"""What an element has to show before it is finished. Ships beside the formulation it tests."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss, lagrange, nodes
from directrix.formulations.directors import Layout, Rule, internal, residual, strains
from directrix.rotations import exp, hat

Array = NDArray[np.float64]

__all__ = ["Conformance", "check_formulation", "random_parameters"]


class Conformance(NamedTuple):
    """Largest deviations, each relative to the size of what is compared."""

    objectivity: float
    discrete_gradient: float
    tangent: float
    rigid_motion: float


def _coordinates(r: Array, rotation: Array) -> list[Any]:
    """Element vectors of many elements at once: r (m, nn, 3) and rotation (m, nn, 3, 3), directors R e_i."""
    return [[tuple(r[:, a].T)] + [tuple(rotation[:, a, :, i].T) for i in range(3)] for a in range(r.shape[1])]


def _random(rng: np.random.Generator, layout: Layout, count: int) -> tuple[Array, Array]:
    straight = np.stack([np.zeros(layout.nn), np.zeros(layout.nn), nodes(layout.nn - 1)], -1)
    r = straight + 0.3 * rng.standard_normal((count, layout.nn, 3))
    return r, exp(rng.standard_normal((count, layout.nn, 3)))


def random_parameters(rng: np.random.Generator, layout: Layout) -> Array:
    """Element parameters (size,) with a positive definite stiffness and mass and directors R e_i at rest."""
    parts = [np.tile(np.eye(3).ravel(), layout.nn)]
    a = rng.standard_normal((6, 6))
    c = a @ a.T + np.eye(6)
    parts.append(np.diag(c) if layout.principal else c[np.triu_indices(6)])
    parts += [1.0 + rng.random(layout.points), 0.1 * rng.standard_normal(6 * layout.points)]
    b = rng.standard_normal((layout.nn, layout.nn))
    parts.append((b @ b.T + np.eye(layout.nn))[np.triu_indices(layout.nn)])
    parts.append(1.0 + rng.random(layout.sizes[5]))
    return np.concatenate(parts)


def check_formulation(
    layout: Layout, rule: Rule, *, states: int = 1000, largest: float = 1e3, seed: int = 0
) -> Conformance:
    """Measure objectivity, the discrete-gradient identity, the tangent by complex step and rigid motions.

    ``states`` random elements; rigid rotations up to ``largest`` radians. The tangent is that of the machine code.
    """
    rng = np.random.default_rng(seed)
    r, rotation = _random(rng, layout, states)
    turn = exp(rng.uniform(-1.0, 1.0, (states, 3)) * largest / np.sqrt(3.0))[:, None]
    moved = (turn @ r[..., None])[..., 0] + rng.standard_normal((states, 1, 3))
    q, rigid = _coordinates(r, rotation), _coordinates(moved, turn @ rotation)
    other = _coordinates(*_random(rng, layout, states))
    middle = _mean(q, other)
    xi, _ = gauss(layout.points)
    n, dn = lagrange(layout.nn - 1, xi)
    objectivity = gradient = 0.0
    for g in range(layout.points):
        shape, slope = n[g].tolist(), dn[g].tolist()
        e = np.array([strains(x, shape, slope, 1.0) for x in (q, rigid, other)])
        objectivity = max(objectivity, float(np.abs(e[1] - e[0]).max() / np.abs(e[0]).max()))
        for k in range(6):
            force = internal(middle, shape, slope, 1.0, [float(i == k) for i in range(6)])
            work = sum(
                f * (b - a)
                for node, x0, x1 in zip(force, q, other, strict=True)
                for vector, v0, v1 in zip(node, x0, x1, strict=True)
                for f, a, b in zip(vector, v0, v1, strict=True)
            )
            gradient = max(gradient, float(np.abs(work - (e[2] - e[0])[k]).max() / np.abs(e).max()))
    return Conformance(objectivity, gradient, _tangent(layout, rule, rng), _rigid(layout, rng))


def _mean(a: Any, b: Any) -> Any:
    return [
        [[0.5 * (s + t) for s, t in zip(u, v, strict=True)] for u, v in zip(m, n, strict=True)]
        for m, n in zip(a, b, strict=True)
    ]


def _as_rows(q: Any) -> Any:
    return [[[c[0] for c in vector] for vector in node] for node in q]


def _tangent(layout: Layout, rule: Rule, rng: np.random.Generator) -> float:
    """Machine code against the complex step of the same residual."""
    from directrix.kernels.single import run_step  # pyright: ignore[reportUnknownVariableType]

    worst = 0.0
    for _ in range(10):
        p, dt = random_parameters(rng, layout), [3.0, 2.0]
        states = [_random(rng, layout, 1) for _ in range(3)]
        q1, q0, v0 = (_as_rows(_coordinates(*s)) for s in states)
        force, tangent = run_step(layout, rule, [(r[0], rotation[0]) for r, rotation in states], p, dt)
        reference = np.array(residual(layout, rule, q1, q0, v0, p.tolist(), dt), float)
        scale, h = np.abs(tangent).max(), 1e-30
        worst = max(worst, float(np.abs(force - reference).max() / np.abs(reference).max()))
        for column in range(6 * layout.nn):
            node, k = divmod(column, 6)
            after: Any = [[list(vector) for vector in x] for x in q1]
            before: Any = [[list(vector) for vector in x] for x in q0]
            if k < 3:
                after[node][0][k] += 1j * h
                before[node][0][k] += 1j * h  # Δr
            else:
                for i in (1, 2, 3):
                    turn = hat(np.eye(3)[k - 3]) @ np.array(q1[node][i])
                    after[node][i] = [v + 1j * h * d for v, d in zip(q1[node][i], turn, strict=True)]
            exact = np.imag(residual(layout, rule, after, before, v0, p.tolist(), dt)) / h
            worst = max(worst, float(np.abs(tangent[:, column] - exact).max() / scale))
    return worst


def _rigid(layout: Layout, rng: np.random.Generator) -> float:
    """A static element in equilibrium with its nodes feels no rigid motion: forces and moments add up to nothing."""
    p = random_parameters(rng, layout)
    r, rotation = _random(rng, layout, 1)
    q = _as_rows(_coordinates(r, rotation))
    out = np.array(residual(layout, Rule(static=True), q, q, q, p.tolist(), [0.0, 0.0]), float).reshape(-1, 6)
    moment = out[:, 3:] + np.cross(r[0], out[:, :3])
    return float(max(np.abs(out[:, :3].sum(0)).max(), np.abs(moment.sum(0)).max()) / np.abs(out).max())
