"""What an element has to show before it is finished. Ships beside the protocol."""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss, lagrange, nodes
from directrix.formulations.directors import internal, local, strains
from directrix.formulations.element import COMMON, Committed, Element
from directrix.formulations.layout import HISTORY, PER_NODE, Layout
from directrix.rotations import cay, exp, hat

Array = NDArray[np.float64]

__all__ = [
    "Conformance", "check_discrete_gradient", "check_formulation", "check_tangent", "random_parameters",
    "random_states",
]  # fmt: skip

TINY = 1e-300  # an element may have no force or no energy


class Conformance(NamedTuple):
    """Largest deviations, each relative to the size of what is compared.

    ``objectivity``: forces turn with a rotation of everything at x1 (statics), of everything there is (steps).
    ``work``: f·Δx = ΔW over a step without inertia. ``tangent``: machine code against the complex step.
    ``rigid_motion``: forces and moments on the nodes add up to nothing without inertia.
    """

    objectivity: float
    work: float
    tangent: float
    rigid_motion: float


def random_parameters(rng: np.random.Generator, layout: Layout) -> Array:
    """Element parameters (size,) with a positive definite stiffness and mass and directors R e_i at rest."""
    parts = [np.tile(np.eye(3).ravel(), layout.nn)]
    a = rng.standard_normal((6, 6))
    c = a @ a.T + np.eye(6)
    stiffness = np.diag(c) if layout.principal else c[np.triu_indices(6)]
    parts.append(np.tile(stiffness, layout.points if layout.varying else 1))
    parts += [1.0 + rng.random(layout.points), 0.1 * rng.standard_normal(6 * layout.points)]
    b = rng.standard_normal((layout.nn, layout.nn))
    parts.append((b @ b.T + np.eye(layout.nn))[np.triu_indices(layout.nn)])
    parts.append(1.0 + rng.random(layout.sizes[5]))
    parts += [0.1 + rng.random(n) for n in layout.sizes[6:]]
    return np.concatenate(parts)


def random_states(rng: np.random.Generator, element: Element, layout: Layout, count: int, turn: float = 1.0) -> Array:
    """(count, nn + rows, PER_NODE): a straight element disturbed; rotations of the order of ``turn`` radians."""
    nn, rows = layout.nn, element.rows(layout)
    x = np.zeros((count, nn + rows, PER_NODE))
    straight = np.stack([np.zeros(nn), np.zeros(nn), nodes(nn - 1)], -1)
    x[:, :nn, :3] = straight + 0.3 * rng.standard_normal((count, nn, 3))
    before = exp(turn * rng.standard_normal((count, nn, 3)))
    x[:, :nn, 3:12] = _columns(exp(0.5 * turn * rng.standard_normal((count, nn, 3))) @ before)
    x[:, :nn, 12:15] = 0.1 * rng.standard_normal((count, nn, 3))
    x[:, :nn, 15:24] = _columns(before)
    x[:, :nn, 24:27] = rng.standard_normal((count, nn, 3))
    x[:, :nn, 27:36] = _columns(hat(rng.standard_normal((count, nn, 3))) @ before)
    x[:, nn:, :9] = _columns(exp(turn * rng.standard_normal((count, rows, 3))))
    x[:, nn:, 9:HISTORY] = 0.3 * rng.standard_normal((count, rows, 3))
    return x


def check_formulation(
    element: Element, layout: Layout, *, static: bool, states: int = 1000, largest: float = 1e3, turn: float = 1.0,
    seed: int = 0, parameters: Array | None = None,
) -> Conformance:  # fmt: skip
    """Measure what :class:`Conformance` names on ``states`` random elements, with rotations up to ``largest`` rad.

    ``parameters`` are those of the element, random ones unless given. ``turn`` is the size of the rotations inside
    an element; near π logarithms of rotations lose digits.
    """
    rng = np.random.default_rng(seed)
    p, common = random_parameters(rng, layout) if parameters is None else parameters, [3.0, 2.0, 0.4]
    x = random_states(rng, element, layout, states, turn)
    whole = exp(rng.uniform(-1.0, 1.0, (states, 3)) * largest / np.sqrt(3.0))
    moved = _turned(x, layout, whole, only_end=static)
    f, g = (_forces(element, layout, y, p, common) for y in (x, moved))
    expected = np.einsum("sij,snj->sni", whole, f.reshape(states, -1, 3)).reshape(f.shape)
    objectivity = float((np.abs(g - expected).max(axis=1) / (np.abs(f).max(axis=1) + TINY)).max())
    still = _forces(element, layout, x, p, [0.0] * 3)
    at = x[:, : layout.nn, :3] - (0.0 if static else 0.5) * x[:, : layout.nn, 12:15]
    parts = still.reshape(states, layout.nn, 2, 3)
    moment = (parts[:, :, 1] + np.cross(at, parts[:, :, 0])).sum(axis=1)
    rigid = np.maximum(np.abs(parts[:, :, 0].sum(axis=1)).max(axis=1), np.abs(moment).max(axis=1))
    return Conformance(
        objectivity,
        0.0 if static else _work(element, layout, x, p, still),
        check_tangent(element, layout, rng, parameters),
        float((rigid / (np.abs(still).max(axis=1) + TINY)).max()),
    )


def check_discrete_gradient(layout: Layout, *, states: int = 1000, seed: int = 0) -> float:
    """Largest deviation from ε(x1) − ε(x0) = B(½(x0 + x1)) (x1 − x0) of the director strains, over the strains."""
    rng = np.random.default_rng(seed)
    xi, _ = gauss(layout.points)
    n, dn = lagrange(layout.nn - 1, xi)
    q: Any = [[[rng.standard_normal((3, states)) for _ in range(4)] for _ in range(layout.nn)] for _ in range(2)]
    middle: Any = [[0.5 * (a + b) for a, b in zip(*node, strict=True)] for node in zip(*q, strict=True)]
    worst = 0.0
    for g in range(layout.points):
        shape, slope = n[g].tolist(), dn[g].tolist()
        e = np.array([strains(local(x, shape, slope), 1.0) for x in q])
        for k in range(6):
            force = internal(local(middle, shape, slope), shape, slope, 1.0, [float(i == k) for i in range(6)])
            work = sum(
                (np.array(f) * (b - a)).sum(axis=0)
                for node, x0, x1 in zip(force, *q, strict=True)
                for f, a, b in zip(node, x0, x1, strict=True)
            )
            worst = max(worst, float(np.abs(work - (e[1] - e[0])[k]).max() / np.abs(e).max()))
    return worst


def _columns(rotation: Array) -> Array:
    return np.swapaxes(rotation, -1, -2).reshape(*rotation.shape[:-2], 9)


def _turned(x: Array, layout: Layout, turn: Array, only_end: bool) -> Array:
    """Every vector of x1 (all vectors unless ``only_end``) turned; curvatures of the history are in the body frame."""
    out, nn = x.copy(), layout.nn
    vectors = np.einsum("sij,snkj->snki", turn, x[:, :nn, :36].reshape(len(x), nn, 12, 3)).reshape(len(x), nn, 36)
    out[:, :nn, : 12 if only_end else 36] = vectors[..., : 12 if only_end else 36]
    if not only_end:
        frames = x[:, nn:, :9].reshape(len(x), -1, 3, 3)
        out[:, nn:, :9] = np.einsum("sij,snkj->snki", turn, frames).reshape(len(x), -1, 9)
    return out


def _scalars(x: Array) -> list[Any]:
    """One entry an element, in the order of the kernels' input."""
    return list(x.reshape(len(x), -1).T)


def _forces(element: Element, layout: Layout, x: Array, p: Array, common: list[float]) -> Array:
    g = [*common, *[0.0] * (COMMON - len(common))]
    out = element.step(layout, _scalars(x), p.tolist(), g)[0]
    return np.stack([np.broadcast_to(c, len(x)) for c in out], -1)


def _work(element: Element, layout: Layout, x: Array, p: Array, force: Array) -> float:
    """f·Δx over ΔW of a step without inertia."""
    nn, start, end = layout.nn, x.copy(), x.copy()
    start[:, :nn, :3] -= x[:, :nn, 12:15]
    start[:, :nn, 3:12] = x[:, :nn, 15:24]
    if element.rows(layout):
        after = cast(Committed, element).commit(layout, _scalars(x), p.tolist(), [0.0] * COMMON)
        rows = np.stack([np.broadcast_to(c, len(x)) for c in after], -1)
        end[:, nn:, :HISTORY] = rows.reshape(len(x), -1, HISTORY)
    stored = [np.asarray(element.audit(layout, _scalars(y), p.tolist())[0], float) for y in (start, end)]
    R1, R0 = (np.swapaxes(x[:, :nn, k : k + 9].reshape(len(x), nn, 3, 3), -1, -2) for k in (3, 15))
    turned = R1 @ np.swapaxes(R0, -1, -2)
    skew = turned - np.swapaxes(turned, -1, -2)
    theta = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
    theta *= 2.0 / (1.0 + np.trace(turned, axis1=-2, axis2=-1))[..., None]
    assert np.allclose(cay(theta), turned, atol=1e-6)
    parts = force.reshape(len(x), nn, 2, 3)
    work = (parts[:, :, 0] * x[:, :nn, 12:15] + parts[:, :, 1] * theta).sum(axis=(1, 2))
    size = np.abs(stored).max(axis=0) * (1.0 + np.abs(theta).max(axis=(1, 2))) + TINY
    return float((np.abs(work - stored[1] + stored[0]) / size).max())


def check_tangent(element: Element, layout: Layout, rng: np.random.Generator, parameters: Array | None = None) -> float:
    """Largest deviation of the machine code from the complex step of the same residual, over its largest entry."""
    from directrix.kernels.single import run_step  # pyright: ignore[reportUnknownVariableType]

    worst, common, h = 0.0, [3.0, 2.0, 0.4], 1e-30
    padding = [0.0] * (COMMON - len(common))
    for x in random_states(rng, element, layout, 10):
        p = random_parameters(rng, layout) if parameters is None else parameters
        force, tangent = run_step(element, layout, x, p, common)
        reference = np.array(element.step(layout, x.ravel().tolist(), p.tolist(), [*common, *padding])[0], float)
        worst = max(worst, float(np.abs(force - reference).max() / np.abs(reference).max()))
        for column in range(6 * layout.nn):
            node, k = divmod(column, 6)
            y = x.astype(complex)
            if layout.last_adds and node == layout.nn - 1:
                y[node, k] += 1j * h
            elif k < 3:
                y[node, [k, 12 + k]] += 1j * h
            else:
                turned = np.cross(np.eye(3)[k - 3], x[node, 3:12].reshape(3, 3))
                y[node, 3:12] += 1j * h * turned.ravel()
            out = element.step(layout, y.ravel().tolist(), p.tolist(), [*common, *padding])[0]
            exact = np.imag(np.array(out, complex)) / h
            worst = max(worst, float(np.abs(tangent[:, column] - exact).max() / np.abs(tangent).max()))
    return worst
