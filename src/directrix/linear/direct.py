"""Sparse direct solvers of other packages: rslab, and PARDISO, which is in Intel's MKL, through pypardiso.

Pivots below 1e-8 of the scaled matrix are lifted to that, and what it changes is corrected afterwards, after Li and
Demmel (1998). So rows go in an order that depends on the pattern alone, also where joints have multipliers, with
nothing on the diagonal.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportMissingImports=false, reportMissingTypeStubs=false, reportMissingModuleSource=false

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from directrix.errors import ModelError
from directrix.linear.blocks import Blocks, Scalars

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Direct", "Packaged"]

FLOOR = 8
"""Pivots below 10 to the minus FLOOR are lifted."""
FRONT = 48
"""Columns up to which rslab joins fronts."""
PARTS = 2
"""Threads whose order of additions PARDISO keeps to, however many there are."""
SAME_BITS = 0x10002
"""MKL_CBWR_AUTO and MKL_CBWR_STRICT."""


@dataclass(frozen=True)
class Packaged:
    """The solver of a package, for the junctions of a frame, on this machine."""

    name: Literal["rslab", "pardiso"]

    def ready(self) -> None:
        """Raises ModelError where the package is missing."""
        (_rslab if self.name == "rslab" else _mkl)()

    def maker(self, points: Array, threads: int) -> Callable[[Ints, Ints, Ints], Direct]:
        """Makes solvers that share their work among ``threads``; the solution is the same for any number."""
        library = Rslab if self.name == "rslab" else Pardiso
        return lambda rowptr, column, rows: Direct(rowptr, column, lambda scalars: library(scalars, threads))


class Library(Protocol):
    """What a package knows of a pattern of scalars it has analysed."""

    def factor(self, values: Array) -> int:
        """Take new numbers; how many pivots were lifted. Raises ArithmeticError where there are no factors."""
        ...

    def solve(self, b: Array) -> Array:
        """x with A x = b, both (size,), for the numbers taken last."""
        ...


class Direct:
    """Analyse a block pattern once, then solve for many values.

    Parameters
    ----------
    rowptr, column
        As for :class:`directrix.linear.sparse.BlockSparse`.
    library
        Analyses the pattern of scalars.
    """

    def __init__(self, rowptr: Ints, column: Ints, library: Callable[[Scalars], Library]) -> None:
        self.rowptr, self.column = rowptr, column
        self._scalars = Scalars(rowptr, column)
        self._library = library(self._scalars)
        self._scale: Array = np.ones((len(rowptr) - 1, 6))

    def solve(self, blocks: Array, rhs: Array) -> Array | None:
        """x with K x = rhs, both (n, 6), or None where K is as good as singular."""
        whole = Blocks(self.rowptr, self.column, blocks)
        self._scale = whole.scale
        try:
            lifted = self._library.factor(self._scalars.values(whole.blocks, whole.scale))
        except ArithmeticError:
            return None
        if lifted and not whole.regular(self._substituted):
            return None
        return whole.refined(rhs, self._substituted)

    def again(self, rhs: Array) -> Array:
        """See :meth:`directrix.linear.conformance.LinearSolver.again`."""
        return self._scale * self._substituted(self._scale * rhs)

    def _substituted(self, b: Array) -> Array:
        """x (n, 6) with D K D x = b, as the factors give it."""
        return self._library.solve(b.ravel()).reshape(b.shape)


class Rslab:
    """rslab's LU, on the transposed matrix: our rows are its columns."""

    def __init__(self, scalars: Scalars, threads: int) -> None:
        from scipy.sparse import csc_matrix

        size = len(scalars.rowptr) - 1
        pattern = csc_matrix((np.ones(len(scalars.columns)), scalars.columns, scalars.rowptr), shape=(size, size))
        self._analysis = _rslab().analyze(
            pattern, path="lu", matching=False, preconditioner=10.0**-FLOOR, nemin=FRONT, threads=threads
        )
        self._factors: Any = None

    def factor(self, values: Array) -> int:
        """See :class:`Library`."""
        self._factors = self._analysis.factor(values)
        return self._factors.n_perturbed

    def solve(self, b: Array) -> Array:
        """See :class:`Library`."""
        return self._factors.solve_transpose(b)


class Pardiso:
    """PARDISO for unsymmetric matrices, in nested dissection; scaled and matched it is not, which would take values."""

    def __init__(self, scalars: Scalars, threads: int) -> None:
        self._threads, self._mkl = threads, _mkl()
        # counted from one, as long as the handle is there, which refers to them
        self._rowptr, self._columns = ((one + 1).astype(np.int32) for one in (scalars.rowptr, scalars.columns))
        self._values, self._nothing = np.ones(len(scalars.columns)), np.zeros(1)
        self._handle, self._options = np.zeros(64, np.int64), np.zeros(64, np.int32)
        for number, value in {1: 1, 2: 2, 10: FLOOR, 34: PARTS}.items():
            self._options[number - 1] = value
        self._run(11, self._nothing, self._nothing)
        weakref.finalize(self, _call, self._mkl, -1, self._handle, self._options, 0).atexit = False

    def factor(self, values: Array) -> int:
        """See :class:`Library`."""
        self._values = values
        self._run(22, self._nothing, self._nothing)
        return int(self._options[13])

    def solve(self, b: Array) -> Array:
        """See :class:`Library`."""
        x = np.empty(len(self._rowptr) - 1)
        self._run(33, np.ascontiguousarray(b), x)
        return x

    def _run(self, phase: int, b: Array, x: Array) -> None:
        before = self._mkl.MKL_Set_Num_Threads_Local(self._threads)
        try:
            arrays = (self._values, self._rowptr, self._columns, b, x)
            error = _call(self._mkl, phase, self._handle, self._options, len(self._rowptr) - 1, *arrays)
        finally:
            self._mkl.MKL_Set_Num_Threads_Local(before)
        if error:
            raise ArithmeticError(f"PARDISO ends phase {phase} with {error}")


def _call(
    mkl: Any, phase: int, handle: Any, options: Any, size: int,
    values: Any = None, rowptr: Any = None, columns: Any = None, b: Any = None, x: Any = None,
) -> int:  # fmt: skip
    """A phase of PARDISO: 11 analysis, 22 factors, 33 solution, −1 the end. Returns its error, 0 for none."""

    def number(value: int) -> Any:
        return ctypes.byref(ctypes.c_int32(value))

    def at(array: Any) -> Any:
        return None if array is None else array.ctypes.data_as(ctypes.c_void_p)

    error, one, unsymmetric, quiet = ctypes.c_int32(0), number(1), number(11), number(0)
    mkl.pardiso(
        at(handle), one, one, unsymmetric, number(phase), number(size), at(values), at(rowptr), at(columns), None,
        one, at(options), quiet, at(b), at(x), ctypes.byref(error),
    )  # fmt: skip
    return error.value


@cache
def _rslab() -> Any:
    try:
        import rslab
    except ImportError:
        raise _missing("rslab") from None
    return rslab


@cache
def _mkl() -> Any:
    """MKL, told to give the same bits in every run."""
    try:
        from pypardiso import ps
    except ImportError:  # also where pypardiso does not find MKL
        raise _missing("pardiso") from None
    mkl = ctypes.CDLL(ps.libmkl._name)
    if mkl.MKL_CBWR_Set(SAME_BITS) != 0 and mkl.MKL_CBWR_Get(-1) <= 1:  # 1: off
        raise ModelError(
            "MKL is in use already by another package, in a way that changes its last digits from run to run",
            "set MKL_CBWR=AUTO,STRICT in the environment",
            "linear=",
        )
    return mkl


def _missing(name: str) -> ModelError:
    return ModelError(
        f'linear="{name}" needs a package that is not installed', f'pip install "directrix[{name}]"', "linear=", "DX502"
    )
