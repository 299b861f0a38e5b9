"""What solvers ask of a matrix of 6×6 blocks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from directrix.kernels import fronts as kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Blocks"]

GOOD = 1e-8
"""Residual over right-hand side, both scaled, of a solution."""
REFINEMENTS = 2
"""Corrections of a solution that is not good enough yet."""


class Blocks:
    """A matrix K in block rows, with D (n, 6) that scales its rows and columns alike: D K D has entries near 1.

    So multipliers of joints weigh as much as stiffnesses of any size.
    """

    def __init__(self, rowptr: Ints, column: Ints, blocks: Array) -> None:
        self.rowptr, self.column, self.blocks = rowptr, column, np.ascontiguousarray(blocks)
        self.scale: Array = np.empty((len(rowptr) - 1, 6))
        kernel.equilibrate(rowptr, column, self.blocks, 3, self.scale, np.empty_like(self.scale))

    def off(self, rhs: Array, x: Array) -> Array:
        """D (b − K x), all (n, 6)."""
        out = np.empty_like(self.scale)
        kernel.residual(
            self.rowptr, self.column, self.blocks, self.scale, np.ascontiguousarray(rhs), np.ascontiguousarray(x), out
        )
        return out

    def refined(self, rhs: Array, solve: Callable[[Array], Array | None]) -> Array | None:
        """x with K x = rhs from ``solve(b)``, x with D K D x = b, corrected until it is good; None where it is not.

        ``solve`` may give None, and is asked again at most REFINEMENTS times, for what is left.
        """
        off = self.scale * rhs
        x = np.zeros_like(off)
        for _ in range(REFINEMENTS + 1):
            part = solve(off)
            if part is None:
                return None
            x += self.scale * part
            off = self.off(rhs, x)
            if self.solved(rhs, off):
                return x
        return None

    def solved(self, rhs: Array, off: Array) -> bool:
        """Whether what is left of a solution, see :meth:`off`, is small enough."""
        return bool(np.linalg.norm(off) <= GOOD * np.linalg.norm(self.scale * rhs))
