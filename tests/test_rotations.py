"""Rotations tested by what defines them."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from directrix import rotations as rot

vectors = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(np.array)


@given(vectors, st.sampled_from([0.0, 1e-300, 1e-12, 1e-6, 1e-3, 1.0, 3.0, 1e3]))
def test_exp_is_the_rotation_of_scipy(v: np.ndarray, size: float) -> None:
    np.testing.assert_allclose(rot.exp(v * size), Rotation.from_rotvec(v * size).as_matrix(), rtol=0, atol=2e-13)
    assert rot.is_rotation(rot.exp(v * size), 1e-12)


@given(vectors, st.sampled_from([0.0, 1e-12, 1e-6, 0.5, 1.0]))
def test_log_undoes_exp(v: np.ndarray, size: float) -> None:
    w = v * size * np.pi / np.sqrt(3.0)
    np.testing.assert_allclose(rot.log(rot.exp(w)), w, rtol=0, atol=1e-12)


@given(vectors.filter(lambda v: np.linalg.norm(v) > 0.1), st.floats(-1e-6, 0.0))
def test_log_near_half_a_turn(v: np.ndarray, short: float) -> None:
    w = v / np.linalg.norm(v) * (np.pi + short)
    back = rot.log(rot.exp(w))
    np.testing.assert_allclose(rot.exp(back), rot.exp(w), rtol=0, atol=1e-12)
    assert np.linalg.norm(back) <= np.pi * (1 + 1e-15)


@given(vectors, vectors)
def test_cayley_gives_the_mean_value_property(v: np.ndarray, d0: np.ndarray) -> None:
    """d1 − d0 = ϑ × ½(d0 + d1), paper (49)."""
    d1 = rot.cay(5.0 * v) @ d0
    np.testing.assert_allclose(d1 - d0, np.cross(5.0 * v, 0.5 * (d0 + d1)), rtol=0, atol=1e-14 * 50)
    assert rot.is_rotation(rot.cay(5.0 * v), 1e-13)


directions = vectors.filter(lambda v: np.linalg.norm(v) > 0.1)


@given(directions, directions)
def test_smallest_rotation_carries_one_to_the_other_about_their_normal(a: np.ndarray, b: np.ndarray) -> None:
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    if a @ b < -0.999:
        return
    q = rot.smallest_rotation(a, b)
    np.testing.assert_allclose(q @ a, b, rtol=0, atol=1e-12)
    normal = np.cross(a, b)
    np.testing.assert_allclose(q @ normal, normal, rtol=0, atol=1e-12)


def test_hat_and_axial_undo_each_other_over_batches() -> None:
    v = np.random.default_rng(0).standard_normal((4, 5, 3))
    w = np.random.default_rng(1).standard_normal((4, 5, 3))
    np.testing.assert_array_equal(rot.axial(rot.hat(v)), v)
    np.testing.assert_allclose((rot.hat(v) @ w[..., None])[..., 0], np.cross(v, w), atol=1e-15)
