"""What acts inside a rod's element beside its elasticity: intrinsic strain that changes, and drag (over scalars).

The driven values are parameters of the element, one for the start of a step and one for its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from directrix.formulations.layout import Layout, Scalar, Vector, points
from directrix.formulations.so3 import add, combine, scale, sub
from directrix.kernels.trace import cross, dot

__all__ = ["Dragged", "drag", "drag_flows", "flow_of", "intrinsic"]

REST = 1e-300  # what keeps the size of no velocity from having no slope


class Dragged(NamedTuple):
    """The drag at an inertia point: shape functions, force with the length it stands for, place, relative velocity."""

    shape: Sequence[float]
    force: Vector
    at: Vector
    relative: Vector


def intrinsic(layout: Layout, block: Sequence[Scalar], g: int) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
    """ε̂ at stress point ``g`` at the start and at the end of a step."""
    after = 6 * layout.points
    return block[6 * g : 6 * g + 6], block[after + 6 * g : after + 6 * g + 6]


def flow_of(layout: Layout, block: Sequence[Scalar]) -> tuple[Vector, Vector]:
    """Velocity of the fluid at the start and at the end of a step (both the mean one in dynamics)."""
    first = 2 + layout.nn
    return block[first : first + 3], block[first + 3 : first + 6]


def drag(
    layout: Layout, block: Sequence[Scalar], r: Sequence[Vector], v: Sequence[Vector], flow: Vector
) -> list[Dragged]:
    """−c_n |v_n| v_n − c_t |v_t| v_t per reference length at the inertia points.

    v is the velocity relative to the ``flow``, from the nodes' positions ``r`` and velocities ``v``; v_t its part along
    the axis, v_n the rest. Smooth at rest: |v| v has a slope there.
    """
    out: list[Dragged] = []
    for k, (w, n, dn) in enumerate(points(layout.nn, layout.nn)):
        tangent = combine(dn, r)
        unit = scale(1.0 / _size(tangent), tangent)
        relative = sub(combine(n, v), flow)
        along = scale(dot(relative, unit), unit)
        across = sub(relative, along)
        per_length = add(scale(-block[0] * _size(across), across), scale(-block[1] * _size(along), along))
        out.append(Dragged(n, scale(w * block[2 + k], per_length), combine(n, r), relative))
    return out


def drag_flows(
    layout: Layout, block: Sequence[Scalar], r1: Sequence[Vector], step: Sequence[Vector], rate: Scalar, static: bool
) -> list[Scalar]:
    """Dissipated by the drag, work of the flow, force and moment about the origin of the drag on the element.

    Over a step Δr the force f takes −f·(Δr − U Δt) and the flow U brings in f·U Δt; ``rate`` is 1/Δt. Statics books
    the mean of the forces at both ends times Δr as work, and the force at the end.
    """
    before, after = flow_of(layout, block)
    nothing: list[Vector] = [tuple(0.0 * c for c in s) for s in step]
    if static:
        r0 = [sub(a, b) for a, b in zip(r1, step, strict=True)]
        now, then = (drag(layout, block, r, nothing, u) for r, u in ((r1, after), (r0, before)))
        moved = [combine(point.shape, step) for point in now]
        done = sum(0.5 * dot(add(a.force, b.force), s) for a, b, s in zip(now, then, moved, strict=True))
        taken: Scalar = 0.0 * done
    else:
        half = [sub(a, scale(0.5, b)) for a, b in zip(r1, step, strict=True)]
        mean = scale(0.5, add(before, after))
        now = drag(layout, block, half, [scale(rate, s) for s in step], mean)
        taken = -1.0 / rate * sum(dot(point.force, point.relative) for point in now)
        done = 1.0 / rate * dot(add(*(point.force for point in now)), mean)
    force = add(*(point.force for point in now))
    return [taken, done, *force, *add(*(cross(point.at, point.force) for point in now))]


def _size(v: Vector) -> Scalar:
    return (dot(v, v) + REST) ** 0.5
