"""What VTK shows of a result: points, one line cell per element, and the data on them.

A node that rods share is a point once per rod, because each rod has directors of its own there.
"""
# pyright: basic

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss
from directrix.result import Mesh, Result

Array = NDArray[np.float64]

__all__ = [
    "FORCES", "STRAINS", "cell_data", "field_data", "lines", "one_after_the_other", "point_data", "points_of",
]  # fmt: skip

FORCES = ("shear_1", "shear_2", "axial_force", "bending_moment_1", "bending_moment_2", "torque")
STRAINS = ("shear_strain_1", "shear_strain_2", "axial_strain", "curvature_1", "curvature_2", "twist")


def points_of(mesh: Mesh) -> NDArray[np.int64]:
    """The node of every point: those of the first rod, then those of the next."""
    return one_after_the_other([rod.nodes for rod in mesh.rods]).astype(np.int64)


def lines(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Points of every element in turn, and where each element starts (and the last one ends) among them."""
    ids: list[NDArray[np.int64]] = []
    sizes: list[NDArray[np.int64]] = []
    start = 0
    for rod in mesh.rods:
        elements = (len(rod.nodes) - 1) // rod.order
        ids.append((start + rod.order * np.arange(elements)[:, None] + np.arange(rod.order + 1)).ravel())
        sizes.append(np.full(elements, rod.order + 1))
        start += len(rod.nodes)
    ends = np.cumsum(one_after_the_other(sizes))
    return one_after_the_other(ids).astype(np.int64), np.concatenate([[0], ends]).astype(np.int64)


def one_after_the_other(parts: list[Any], *shape: int) -> NDArray[Any]:
    """The parts along their first axis, which models without rods do not have: rows of ``shape`` then."""
    return np.concatenate(parts) if parts else np.zeros((0, *shape))


def point_data(result: Result) -> Iterator[tuple[str, NDArray[Any]]]:
    """Names and values (instants or 1, points, …)."""
    rods, nodes = result.mesh.rods, points_of(result.mesh)
    yield "displacement", (result.r - result.mesh.r0)[:, nodes]
    yield "velocity", result.v[:, nodes]
    reference = one_after_the_other([rod.directors for rod in rods], 3, 3)
    rotation = result.R[:, nodes]
    for k in range(3):
        yield f"d{k + 1}", np.einsum("tnij,nj->tni", rotation, reference[:, :, k])
    yield "arclength", one_after_the_other([rod.s for rod in rods])[None]
    yield "rod", np.repeat(np.arange(len(rods)), [len(rod.nodes) for rod in rods])[None]


def cell_data(result: Result) -> Iterator[tuple[str, NDArray[Any]]]:
    """Names and values (instants or 1, cells): means over the elements, as the stress points integrate them."""
    rods = result.mesh.rods
    elements = [(len(rod.nodes) - 1) // rod.order for rod in rods]
    for values, names in ((result.force, FORCES), (result.strain, STRAINS)):
        means: list[Array] = []
        for rod, count in zip(rods, elements, strict=True):
            part = values[:, rod.first_station : rod.first_station + len(rod.stations)]
            weights = 0.5 * gauss(len(rod.stations) // count)[1]
            means.append(np.einsum("tepi,p->tei", part.reshape(len(part), count, -1, 6), weights))
        mean = np.concatenate([values[:, :0], *means], axis=1)
        for k, name in enumerate(names):
            yield name, mean[..., k]
    yield "rod", np.repeat(np.arange(len(rods)), elements)[None]


def field_data(result: Result) -> Iterator[tuple[str, Array]]:
    """Names and values (instants, 1)."""
    yield "load_factor", result.load_factor[:, None]
    for name in ("kinetic", "stored", "total", "work"):
        yield f"energy_{name}", getattr(result.energy, name)[:, None]
