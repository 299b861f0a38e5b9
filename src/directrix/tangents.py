"""Tangents at a state, nothing condensed and nothing held: of the elements of a group, and of the whole model."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from directrix.kernels.elements import element_tangents
from directrix.kernels.tables import Tables
from directrix.newton import Newton

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["group_tangents", "whole_tangent"]


def group_tangents(
    newton: Newton,
    x: Array,
    group: int,
    tables: Tables | None = None,
    *,
    symmetric: bool = True,
    common: Array | None = None,
) -> Array:
    """Tangents (ne, 6 nn, 6 nn) of a group of elements, with other parameters or common scalars if they are given; the
    symmetric part is the Hessian at an equilibrium."""
    ne, nn = newton.disc.groups[group].conn.shape
    out = np.empty((ne, 6 * nn, 6 * nn))
    tables, common = newton.tables if tables is None else tables, newton.globals if common is None else common
    element_tangents(tables, newton.work, x, common, group, out)
    return 0.5 * (out + out.transpose(0, 2, 1)) if symmetric else out


def whole_tangent(newton: Newton, x: Array, tables: Tables | None = None) -> csc_matrix:
    """The symmetric part of the tangent (6 rows, 6 rows) of all elements, without loads that turn with their node."""
    from scipy.sparse import coo_matrix, csc_matrix

    rows, columns, values = list[Ints](), list[Ints](), list[Array]()
    for k, group in enumerate(newton.disc.groups):
        ne, nn = group.conn.shape
        at = (6 * group.conn[:, :, None] + np.arange(6)).reshape(ne, -1)
        rows.append(np.repeat(at, 6 * nn, axis=1).ravel())
        columns.append(np.tile(at, (1, 6 * nn)).ravel())
        values.append(group_tangents(newton, x, k, tables).ravel())
    size = newton.disc.held.size
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csc_matrix(coo_matrix(entries, shape=(size, size)))
