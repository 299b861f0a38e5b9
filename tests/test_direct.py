"""Packages as solvers of frames, and frames whose joints have multipliers, where nothing is on the diagonal."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_multifrontal import GRIDS, system

import directrix as dx
from directrix.discretisation import discretise
from directrix.kernels import step
from directrix.linear.backed import Backed
from directrix.linear.blocks import Scalars
from directrix.linear.condensed import Condensed, usual
from directrix.linear.conformance import check_linear
from directrix.linear.direct import Direct, Packaged
from directrix.linear.multifrontal import Multifrontal
from directrix.linear.sparse import BlockSparse
from directrix.motion import Asked, Motion
from directrix.newton import Newton, Settings
from directrix.schema import load_case
from directrix.schema.describe import describe
from directrix.state import initial_state

MODULES = {"rslab": "rslab", "pardiso": "pypardiso"}
SECTION = dx.Section.circle(radius=0.02, E=1e9, nu=0.3, rho=1000)


@pytest.fixture(params=MODULES)
def package(request: pytest.FixtureRequest) -> str:
    pytest.importorskip(MODULES[request.param], reason=f'pip install "directrix[{request.param}]"')
    return request.param


@pytest.fixture(params=[None, *MODULES])
def linear(request: pytest.FixtureRequest) -> str | None:
    if request.param is not None:
        pytest.importorskip(MODULES[request.param], reason=f'pip install "directrix[{request.param}]"')
    return request.param


def make(linear: str | None, threads: int = 1) -> Callable[[Any, Any, Any], Any]:
    return usual(threads) if linear is None else Packaged(linear).maker(np.zeros((0, 3)), threads)  # type: ignore[arg-type]


def hinged(edge: int = 4) -> dx.Model:
    """A lattice at each place of which struts turn on the first one, in hinges that all lie one way."""
    model, there = dx.Model(name="hinged"), dict[str, str]()
    for place in itertools.product(range(edge), repeat=3):
        for axis in range(3):
            other = tuple(v + (k == axis) for k, v in enumerate(place))
            if max(other) == edge:
                continue
            at = ["{}.{}.{}".format(*one) for one in (place, other)]
            ends = tuple(f"{one}{side}{axis}" for one, side in zip(at, "+-", strict=True))
            model = model.rod(dx.line(place, other), SECTION, name="-".join(at), ends=ends, elements=1, order=1)
            for one, end in zip(at, ends, strict=True):
                if there.setdefault(one, end) != end:
                    model = model.hinge(there[one], end, axis=(1, 2, 3))
    for place, end in there.items():
        if place.endswith(".0"):
            model = model.clamp(end)
    return model.gravity((0, 0, -9.81))


@pytest.fixture(scope="module")
def jointed() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """rowptr, column, blocks and right-hand side of a frame with many joints."""
    scheme = dx.EnergyMomentum().scheme(0.01)
    disc = discretise(hinged(), scheme)
    newton, x = Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)
    step.assemble(newton.tables, newton.work, x, newton.globals, disc.external(0.0), newton.mask, False)
    return disc.pattern.rowptr, disc.pattern.column, newton.work.blocks.copy(), newton.work.rhs.copy()


def test_scalar_rows_are_those_of_the_matrix() -> None:
    rowptr, column = GRIDS["islands"]
    blocks, scale = system(rowptr, column)
    n = len(rowptr) - 1
    dense = np.zeros((n, 6, n, 6))
    for i in range(n):
        for k in range(rowptr[i], rowptr[i + 1]):
            dense[i, :, column[k]] = scale[i][:, None] * blocks[k] * scale[column[k]]
    dense = dense.reshape(6 * n, 6 * n)
    for first, last in ((0, n), (3, 40)):
        rows = Scalars(rowptr, column, first, last)
        found = np.zeros((6 * (last - first), 6 * n))
        row = np.repeat(np.arange(len(found)), np.diff(rows.rowptr))
        found[row, rows.columns] = rows.values(blocks, scale)
        assert np.array_equal(found, dense[6 * first : 6 * last])
        assert all(np.all(np.diff(rows.columns[a:b]) > 0) for a, b in itertools.pairwise(rows.rowptr))


def test_it_passes_the_conformance_test(package: str) -> None:
    assert check_linear(lambda ptr, column: make(package)(ptr, column, column), sizes=(1, 2, 7, 40, 150)) <= 1e-9


def test_a_frame_with_joints_is_solved_without_superlu(
    linear: str | None, jointed: tuple[np.ndarray, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    rowptr, column, blocks, rhs = jointed
    expected = BlockSparse(rowptr, column).solve(blocks, rhs)
    monkeypatch.setattr(BlockSparse, "solve", lambda *args, **options: pytest.fail("SuperLU was asked"))
    found = []
    for threads in (1, 2, 5):
        solver = Condensed(rowptr, column, make(linear, threads))
        found += [solver.solve(blocks, rhs), solver.solve(blocks, rhs)]
        assert isinstance(solver.plain, Backed)
    assert all(x is not None and x.tobytes() == found[0].tobytes() for x in found)
    assert np.abs(found[0] - expected).max() <= 1e-8 * np.abs(expected).max()
    several = solver.solve(blocks, np.array([rhs, 2 * rhs]))
    assert np.allclose(several, [found[0], 2 * found[0]], rtol=1e-12)


def test_many_junctions_are_solved_with_the_same_bits_by_any_number_of_threads(package: str) -> None:
    rowptr, column = GRIDS["cube"]
    blocks, rhs = system(rowptr, column)
    solvers = [make(package, threads)(rowptr, column, column) for threads in (1, 2, 5)]
    found = [solver.solve(blocks, rhs) for solver in solvers]
    assert all(x.tobytes() == found[0].tobytes() for x in found)
    assert np.allclose(solvers[0].again(rhs), found[0], rtol=1e-7)


@pytest.mark.parametrize("what", ["a row of zeros", "two rows alike", "not finite"])
def test_a_singular_matrix_is_told_from_a_constrained_one(linear: str | None, what: str) -> None:
    rowptr, column = GRIDS["plane"]
    blocks, rhs = system(rowptr, column)
    n = len(rowptr) - 1
    row, at = np.repeat(np.arange(n), np.diff(rowptr)), column
    if what == "a row of zeros":
        blocks[:-1][row == 7, 2], blocks[:-1][at == 7, :, 2], rhs[7, 2] = 0.0, 0.0, 0.0
    elif what == "two rows alike":
        blocks[:-1][row == 7, 2], rhs[7, 2] = blocks[:-1][row == 7, 3], rhs[7, 3]
        blocks[:-1][at == 7, :, 2] = blocks[:-1][at == 7, :, 3]
    else:
        blocks[3, 1, 1] = np.nan
    solver = make(linear)(rowptr, column, np.arange(n))
    assert isinstance(solver, Multifrontal | Direct)
    assert solver.solve(blocks, rhs) is None


def test_where_there_are_no_factors_superlu_is_asked() -> None:
    class Helpless:
        def factor(self, values: np.ndarray) -> int:
            raise ArithmeticError

        def solve(self, b: np.ndarray) -> np.ndarray:
            raise AssertionError

    rowptr, column = GRIDS["plane"]
    blocks, rhs = system(rowptr, column)
    expected = BlockSparse(rowptr, column).solve(blocks, rhs)
    x = Condensed(rowptr, column, lambda ptr, column, rows: Direct(ptr, column, lambda some: Helpless())).solve(
        blocks, rhs
    )
    assert x is not None and expected is not None and x.tobytes() == expected.tobytes()


def test_a_motion_is_that_of_the_usual_solver(package: str) -> None:
    model = hinged()
    first, other = (dx.simulate(model, t_end=0.04, dt=0.02, linear=one) for one in (None, package))  # type: ignore[arg-type]
    assert first.success and first.audit.passed and other.success and other.audit.passed
    assert np.abs(first.r - other.r).max() <= 1e-10
    prints = {Motion(model, Asked(0.04, 0.02, linear=one)).fingerprint() for one in (None, package)}  # type: ignore[arg-type]
    assert len(prints) == 2


def test_a_case_names_it_and_a_kept_run_holds_to_it(tmp_path: Path) -> None:
    pytest.importorskip("rslab", reason='pip install "directrix[rslab]"')
    text = """
    [section.s]
    kind = "circle"
    radius = 0.02
    E = 1e9
    nu = 0.3

    [[rod]]
    name = "r"
    section = "s"
    line = [[0, 0, 0], [1, 0, 0]]
    ends = ["a", "b"]
    elements = 2

    [[support]]
    node = "a"
    type = "clamp"

    [statics]
    steps = 1
    linear = "rslab"
    """
    (tmp_path / "case.toml").write_text(text)
    case = load_case(tmp_path / "case.toml")
    assert "frames solved by rslab" in describe(case)
    assert case.run(folder=dx.Folder(tmp_path / "run")).success
    (tmp_path / "case.toml").write_text(text.replace("rslab", "mumps"))
    with pytest.raises(dx.InputError, match="linear"):
        load_case(tmp_path / "case.toml")
    (tmp_path / "case.toml").write_text(text.replace('linear = "rslab"', ""))
    with pytest.raises(dx.InputError, match="other arguments"):
        load_case(tmp_path / "case.toml").run(folder=dx.Folder(tmp_path / "run", resume=True))
