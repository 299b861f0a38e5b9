"""PETSc as the solver of frames. What needs petsc4py is marked ``petsc``; ``make test-petsc`` runs that."""

from __future__ import annotations

import itertools
import sys

import numpy as np
import pytest
from test_direct import hinged

import directrix as dx
from directrix.discretisation import discretise
from directrix.kernels import step
from directrix.linear import petsc
from directrix.linear.backed import Backed
from directrix.linear.conformance import check_linear
from directrix.newton import Newton, Settings
from directrix.state import initial_state

SECTION = dx.Section.circle(radius=0.02, E=1e9, nu=0.3, rho=1000)


def lattice(edge: int, *, held: bool = True) -> dx.Model:
    model = dx.Model(name="lattice")
    for place in itertools.product(range(edge), repeat=3):
        for axis in range(3):
            other = tuple(v + (k == axis) for k, v in enumerate(place))
            if max(other) < edge:
                ends = ("{}.{}.{}".format(*place), "{}.{}.{}".format(*other))
                model = model.rod(dx.line(place, other), SECTION, name="-".join(ends), ends=ends, elements=2, order=1)
    for place in itertools.product(range(edge), repeat=2) if held else ():
        model = model.clamp("{}.{}.0".format(*place))
    return model.gravity((0, 0, -9.81)) if held else model


def test_without_petsc4py_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "petsc4py", None)
    petsc._library.cache_clear()
    with pytest.raises(dx.ModelError, match="petsc4py is not here"):
        dx.simulate(lattice(2), t_end=0.02, dt=0.02, linear="petsc")


def test_what_is_no_solver_is_refused() -> None:
    with pytest.raises(dx.ModelError, match='"petsc"'):
        dx.simulate(lattice(2), t_end=0.02, dt=0.02, linear="mumps")
    with pytest.raises(dx.ModelError, match="method"):
        dx.Petsc("ilu")  # type: ignore[arg-type]
    with pytest.raises(dx.ModelError, match="tolerance"):
        dx.Petsc("gamg", tolerance=1e-3)


def test_the_stiffness_of_a_free_frame_has_nothing_against_the_rigid_motions() -> None:
    model = lattice(2, held=False)
    scheme = dx.EnergyMomentum().scheme(1e9)  # so long a step that inertia counts for nothing
    disc = discretise(model, scheme)
    newton, x = Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)
    step.assemble(newton.tables, newton.work, x, newton.globals, disc.external(0.0), newton.mask, False)
    motions = petsc._motions(newton._points())
    pattern, blocks = disc.pattern, newton.work.blocks
    for i in range(len(motions)):
        at = range(pattern.rowptr[i], pattern.rowptr[i + 1])
        out = sum(blocks[k] @ motions[pattern.column[k]] for k in at)
        size = sum(np.abs(blocks[k]) @ np.abs(motions[pattern.column[k]]) for k in at)
        assert np.abs(out).max() <= 1e-10 * size.max()


@pytest.mark.petsc
def test_it_passes_the_conformance_test() -> None:
    def make(rowptr: np.ndarray, column: np.ndarray) -> petsc.PetscSolver:
        return petsc.PetscSolver(rowptr, column, dx.Petsc(), np.zeros((len(rowptr) - 1, 6, 6)))

    assert check_linear(make, sizes=(7, 40, 150)) <= 1e-8


@pytest.mark.petsc
@pytest.mark.parametrize("how", [dx.Petsc(), dx.Petsc("gamg")])
def test_a_motion_is_that_of_the_usual_solver(how: dx.Petsc) -> None:
    model = lattice(4)
    usual, other = (dx.simulate(model, t_end=0.06, dt=0.02, linear=linear) for linear in (None, how))
    assert other.success and other.audit.passed
    assert np.abs(usual.r - other.r).max() <= 1e-10


@pytest.mark.petsc
def test_multipliers_inside_struts_are_for_mumps_not_for_the_multigrid() -> None:
    scheme = dx.EnergyMomentum().scheme(0.01)
    disc = discretise(hinged(), scheme)
    for how in (dx.Petsc(), dx.Petsc("gamg")):
        newton, x = Newton(disc, scheme, Settings(linear=how)), initial_state(disc, None, scheme)
        step.assemble(newton.tables, newton.work, x, newton.globals, disc.external(0.0), newton.mask, False)
        plain = newton.sparse.plain
        assert isinstance(plain, Backed)
        assert (plain.first.solve(newton.work.blocks, newton.work.rhs) is None) == (how.method == "gamg")
        expected = plain.last.solve(newton.work.blocks, newton.work.rhs)
        x = newton.sparse.solve(newton.work.blocks, newton.work.rhs)
        assert x is not None and expected is not None
        assert np.abs(x - expected).max() <= 1e-8 * np.abs(expected).max()
