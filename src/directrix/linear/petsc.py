"""PETSc over MPI, for frames whose factors do not fit one machine. Needs petsc4py, and MUMPS for ``method="lu"``."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportMissingImports=false

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix.checks import choice, number
from directrix.errors import ModelError
from directrix.linear.blocks import Blocks, Scalars

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Petsc", "PetscSolver"]


@dataclass(frozen=True)
class Petsc:
    """The junctions of a frame by PETSc, on all processes of ``mpirun``; every process runs the same program.

    Struts are eliminated before, on every process alike; the system of the junctions, its factors or its multigrid, are
    spread over the processes. Chains need no such solver and do not use it.

    Parameters
    ----------
    method
        "lu": MUMPS, a direct solver. "gamg": GMRES with algebraic multigrid that knows the six rigid motions; it takes
        less memory, and as many iterations as it needs, which are more where struts are slender.
    tolerance
        Of "gamg": residual over right-hand side at which it stops.

    Raises
    ------
    ModelError
        A parameter cannot be right; when used: petsc4py is missing.
    """

    method: Literal["lu", "gamg"] = "lu"
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        choice(self.method, "method", ("lu", "gamg"))
        if not 0.0 < number(self.tolerance, "tolerance") <= 1e-8:
            raise ModelError(f"tolerance = {self.tolerance} does not work", "give one of at most 1e-8", "Petsc")

    def ready(self) -> None:
        """Raises ModelError where petsc4py is missing."""
        _library()

    def maker(self, points: Array, threads: int) -> Callable[[Ints, Ints, Ints], PetscSolver]:
        """Makes solvers for rows that are nodes at ``points`` (n, 3), or NaN; processes share the work, not threads."""
        return lambda rowptr, column, rows: PetscSolver(rowptr, column, self, _motions(points[rows]))


def _motions(points: Array) -> Array:
    """(n, 6, 6): increments of nodes at ``points`` in the six rigid motions."""
    nodes = np.isfinite(points[:, 0])
    r = np.where(nodes[:, None], points, 0.0)
    r -= r.sum(axis=0) / max(1, nodes.sum())
    out = np.zeros((len(points), 6, 6))
    for k, axis in enumerate(np.eye(3)):
        out[:, k, k] = 1.0
        out[:, :3, 3 + k], out[:, 3 + k, 3 + k] = np.cross(axis, r), 1.0
    out[~nodes] = 0.0
    return out


@cache
def _library() -> Any:
    try:
        import petsc4py
    except ImportError:
        raise ModelError(
            "linear= asks for PETSc, and petsc4py is not here",
            "install it as docs/performance.md says (Debian: python3-petsc4py), or leave linear= out",
            "linear=",
        ) from None
    petsc4py.init([])
    from petsc4py import PETSc

    return PETSc


class PetscSolver:
    """Rows spread over the processes in slabs; matrix, right-hand side and solution are known to every process.

    Parameters
    ----------
    rowptr, column
        As for :class:`directrix.linear.sparse.BlockSparse`.
    how
        The method.
    motions
        (n, 6, 6): increments of each row in the six rigid motions, zero for rows that are no nodes.
    """

    def __init__(self, rowptr: Ints, column: Ints, how: Petsc, motions: Array) -> None:
        lib = self._lib = _library()
        self.rowptr, self.column, self.how, self.motions = rowptr, column, how, motions
        n = len(rowptr) - 1
        world = lib.COMM_WORLD
        share = np.linspace(0, n, world.size + 1).astype(np.int64)
        self.first, self.last = int(share[world.rank]), int(share[world.rank + 1])
        self.scalars = Scalars(rowptr, column, self.first, self.last)
        self.csr = self.scalars.rowptr.astype(lib.IntType), self.scalars.columns.astype(lib.IntType)
        local = 6 * (self.last - self.first)
        self.matrix = lib.Mat().createAIJ(
            ((local, 6 * n), (local, 6 * n)), bsize=6, csr=(*self.csr, np.zeros(len(self.csr[1]))), comm=world
        )
        joints = ~motions.any(axis=(1, 2)) & (np.diff(rowptr) > 2)
        # of multipliers that join two nodes the multigrid knows nothing: GMRES would try in vain, for long
        self.hopeless = how.method == "gamg" and bool(joints.any())
        self.b = self.matrix.createVecLeft()
        self.x = self.matrix.createVecRight()
        self.spread, self.all = lib.Scatter.toAll(self.x)
        self.scale: Array = np.ones((n, 6))
        self.ksp = lib.KSP().create(world)
        self.ksp.setOperators(self.matrix)
        part = self.ksp.getPC()
        if how.method == "lu":
            self.ksp.setType("preonly")
            part.setType("lu")
            part.setFactorSolverType("mumps")
        else:
            self.ksp.setType("gmres")
            self.ksp.setGMRESRestart(200)
            self.ksp.setTolerances(rtol=how.tolerance, max_it=2000)
            part.setType("gamg")

    def solve(self, blocks: Array, rhs: Array) -> Array | None:
        """x with K x = rhs, both (n, 6), or None where PETSc finds none."""
        if self.hopeless:
            return None
        whole = Blocks(self.rowptr, self.column, blocks)
        scale = self.scale = whole.scale
        self.matrix.setValuesCSR(*self.csr, self.scalars.values(blocks, scale))
        self.matrix.assemble()
        if self.how.method == "gamg":
            self._tell_motions(scale)
        return whole.refined(rhs, self._solved)

    def again(self, rhs: Array) -> Array | None:
        """See :meth:`directrix.linear.conformance.LinearSolver.again`."""
        x = self._solved(self.scale * rhs)
        return None if x is None else self.scale * x

    def _solved(self, b: Array) -> Array | None:
        """What PETSc gives for the right-hand side ``b`` (n, 6), on every process."""
        lib = self._lib
        self.b.setArray(b[self.first : self.last].ravel())
        try:
            self.ksp.solve(self.b, self.x)
        except lib.Error:
            return None
        if self.ksp.getConvergedReason() < 0:
            return None
        self.spread.scatter(self.x, self.all, addv=lib.InsertMode.INSERT, mode=lib.ScatterMode.FORWARD)
        return self.all.getArray().reshape(b.shape)

    def _tell_motions(self, scale: Array) -> None:
        """Rigid motions of the scaled unknowns, orthonormal, for the multigrid."""
        lib = self._lib
        basis, _ = np.linalg.qr((self.motions / scale[:, :, None]).reshape(-1, 6))
        vectors: list[Any] = []
        for k in range(6):
            vector = self.matrix.createVecRight()
            vector.setArray(basis[6 * self.first : 6 * self.last, k])
            vectors.append(vector)
        self.matrix.setNearNullSpace(lib.NullSpace().create(vectors=vectors, comm=lib.COMM_WORLD))
