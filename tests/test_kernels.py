"""Compiled loops against dense references."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from directrix.kernels.chain import solve_chain
from directrix.kernels.compile import kernel_address
from directrix.kernels.elimination import elimination_address
from directrix.kernels.trace import Graph
from directrix.linear.conformance import check_linear
from directrix.linear.sparse import BlockSparse


def chain(n: int, seed: int, pivots: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    blocks = rng.standard_normal((3 * n + 1, 6, 6))
    blocks[0] = blocks[3 * n - 1] = 0.0
    blocks[1::3] += pivots * np.eye(6)
    dense = np.zeros((6 * n, 6 * n))
    for i in range(n):
        for k, j in enumerate((i - 1, i, i + 1)):
            if 0 <= j < n:
                dense[6 * i : 6 * i + 6, 6 * j : 6 * j + 6] = blocks[3 * i + k]
    return blocks, rng.standard_normal((n, 6)), dense


def solve(blocks: np.ndarray, rhs: np.ndarray) -> tuple[int, np.ndarray]:
    du = np.zeros_like(rhs)
    return solve_chain(elimination_address(), blocks, rhs, np.zeros((len(rhs) + 1, 56)), du), du


@given(n=st.integers(1, 40), seed=st.integers(0, 2**32 - 1), pivots=st.sampled_from([4.0, 20.0]))
def test_chain_solves_what_a_dense_solver_solves(n: int, seed: int, pivots: float) -> None:
    blocks, rhs, dense = chain(n, seed, pivots)
    row, du = solve(blocks, rhs)
    assert row == -1
    exact = np.linalg.solve(dense, rhs.ravel()).reshape(-1, 6)
    # block elimination pivots inside its block only: allow for its growth on matrices without dominant blocks
    allowed = 1e-13 if pivots == 20.0 else 1e-10
    np.testing.assert_allclose(du, exact, rtol=0, atol=allowed * np.abs(exact).max())


def test_chain_pivots_when_a_diagonal_vanishes() -> None:
    blocks, rhs, dense = chain(8, 3, 20.0)
    blocks[3 * 4 + 1] = np.roll(np.eye(6), 1, axis=0) * 7.0
    dense[24:30, 24:30] = blocks[13]
    row, du = solve(blocks, rhs)
    assert row == -1
    np.testing.assert_allclose(dense @ du.ravel(), rhs.ravel(), atol=1e-11)


def test_chain_names_the_row_of_a_singular_block() -> None:
    blocks, rhs, _ = chain(6, 4, 20.0)
    blocks[9:12] = 0.0
    blocks[11], blocks[9] = 0.0, 0.0
    assert solve(blocks, rhs)[0] == 3


def test_sparse_solver_conforms() -> None:
    assert check_linear(BlockSparse) <= 1e-10


def test_sparse_solver_takes_constraints_beside_any_stiffness() -> None:
    """A stiff node held by six multipliers: K u + Bᵀ λ = 0, B u = g gives u = B⁻¹ g, λ = −B⁻ᵀ K u."""
    rng = np.random.default_rng(4)
    root, B, g = rng.normal(size=(6, 6)), rng.normal(size=(6, 6)) + 4.0 * np.eye(6), 1e-6 * rng.normal(size=6)
    for stiffness in (1.0, 1e6, 1e12):
        K = stiffness * (root @ root.T + np.eye(6))
        solver = BlockSparse(np.array([0, 2, 4]), np.array([0, 1, 0, 1]))
        got = solver.solve(np.array([K, B.T, B, np.zeros((6, 6))]), np.array([np.zeros(6), g]))
        assert got is not None
        u = np.linalg.solve(B, g)
        np.testing.assert_allclose(got[0], u, rtol=1e-9)
        np.testing.assert_allclose(got[1], -np.linalg.solve(B.T, K @ u), rtol=1e-9)


def test_sparse_solver_refuses_a_singular_matrix() -> None:
    solver = BlockSparse(np.array([0, 1]), np.array([0]))
    assert solver.solve(np.zeros((1, 6, 6)), np.ones((1, 6))) is None


def test_kernels_are_kept_and_found_again(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DIRECTRIX_CACHE_DIR", str(tmp_path))
    built = []

    def build():
        built.append(1)
        graph = Graph()
        x = graph.inputs("x", 2)
        return graph, [x[0] * x[1]]

    from directrix.kernels import compile as module

    first = kernel_address("a product", build)
    module._addresses.clear()
    assert kernel_address("a product", build) != 0 and first != 0
    assert built == [1] and len(list(tmp_path.glob("*.o"))) == 1


def test_a_cache_that_cannot_be_written_is_no_error(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("DIRECTRIX_CACHE_DIR", str(tmp_path / "file"))

    def build():
        graph = Graph()
        x = graph.inputs("x", 1)
        return graph, [x[0] + 1.0]

    assert kernel_address("one more", build) != 0
