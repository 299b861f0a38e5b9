"""Axes: arclength, tangent, frames that do not turn about the tangent."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import directrix as dx
from directrix.curves import Curve
from directrix.rotations import is_rotation

CURVES: dict[str, Curve] = {
    "line": dx.line((1, 2, 3), (4, 0, 5)),
    "arc": dx.arc((0, 0, 0), (1, 0.3, 0.2), (2, 0, 0)),
    "long arc": dx.arc((1, 0, 0), (-1, 0.1, 0), (0.9, -0.3, 0), d1=(0, 0, 1)),
    "helix": dx.helix(radius=2.0, pitch=0.7, turns=3.0, origin=(1, 0, 0), axis=(1, 1, 1)),
    "left helix": dx.helix(radius=0.5, pitch=1.0, turns=-2.0),
    "spline": dx.spline([(0, 0, 0), (1, 0.5, 0), (2, 0, 1), (3, 1, 1)]),
}


@pytest.mark.parametrize("name", CURVES)
def test_arclength_tangent_and_frame(name: str) -> None:
    curve = CURVES[name]
    s, h = np.linspace(0.05, 0.95, 41) * curve.length, 1e-5 * curve.length
    slope = (curve.position(s + h) - curve.position(s - h)) / (2 * h)
    np.testing.assert_allclose(np.linalg.norm(slope, axis=1), 1.0, atol=1e-8)
    frames = curve.frames(s, s)
    assert is_rotation(frames, 1e-12)
    np.testing.assert_allclose(frames[:, :, 2], slope, atol=1e-8)
    # d1' has no part along d2: the frame does not turn about the tangent
    rate = (curve.frames(s + h, s) - curve.frames(s - h, s)) / (2 * h)
    np.testing.assert_allclose(np.einsum("si,si->s", rate[:, :, 0], frames[:, :, 1]), 0.0, atol=2e-7)


def test_ends_and_lengths() -> None:
    arc = CURVES["arc"]
    np.testing.assert_allclose(arc.position(0.0), (0, 0, 0), atol=1e-14)
    np.testing.assert_allclose(arc.position(arc.length), (2, 0, 0), atol=1e-14)
    quarter = dx.arc((1, 0, 0), (np.sqrt(0.5), np.sqrt(0.5), 0), (0, 1, 0))
    assert quarter.length == pytest.approx(np.pi / 2, rel=1e-14)
    three = dx.arc((1, 0, 0), (-1, 0, 0), (0, -1, 0))
    assert three.length == pytest.approx(1.5 * np.pi, rel=1e-14)
    assert CURVES["helix"].length == pytest.approx(3 * np.hypot(4 * np.pi, 0.7), rel=1e-14)
    np.testing.assert_allclose(CURVES["spline"].position(CURVES["spline"].length), (3, 1, 1), atol=1e-12)


def test_a_spline_through_points_of_a_circle_has_its_length() -> None:
    angle = np.linspace(0, 1, 41)
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    assert dx.spline(points).length == pytest.approx(1.0, rel=1e-8)


def test_default_d1_is_the_axis_least_aligned_ties_to_the_lowest() -> None:
    np.testing.assert_allclose(dx.line((0, 0, 0), (0, 0, 2)).frames(0.0, 0.0), np.eye(3), atol=0)
    np.testing.assert_allclose(dx.line((0, 0, 0), (2, 0, 0)).frames(0.0, 0.0)[:, 0], (0, 1, 0), atol=0)
    d1 = dx.line((0, 0, 0), (1, 1, 1)).frames(0.0, 0.0)[:, 0]
    np.testing.assert_allclose(d1, np.array([2, -1, -1]) / np.sqrt(6), atol=1e-15)
    np.testing.assert_allclose(
        dx.line((0, 0, 0), (0, 0, 1), d1=(1, 1, 5)).frames(0.0, 0.0)[:, 0], [np.sqrt(0.5)] * 2 + [0]
    )


def test_a_polyline_has_two_frames_at_a_corner() -> None:
    curve = dx.polyline([(0, 0, 0), (1, 0, 0), (1, 1, 0)], d1=(0, 0, 1))
    assert curve.breaks == (1.0,) and curve.length == 2.0
    before, after = curve.frames(np.array([1.0, 1.0]), np.array([0.9, 1.1]))
    np.testing.assert_allclose(before[:, 2], (1, 0, 0), atol=1e-15)
    np.testing.assert_allclose(after[:, 2], (0, 1, 0), atol=1e-15)
    np.testing.assert_allclose(after[:, 0], (0, 0, 1), atol=1e-15)


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: dx.line((0, 0, 0), (0, 0, 0)), "the same"),
        (lambda: dx.line((0, 0), (1, 0, 0)), "point 0 of the line"),
        (lambda: dx.line((0, 0, 0), (1, 0, float("inf"))), "point 1 of the line"),
        (lambda: dx.line((0, 0, 0), (1, 0, 0), d1=(2, 0, 0)), "along the rod"),
        (lambda: dx.line((0, 0, 0), (1, 0, 0), d1=(0, 0, 0)), "no direction"),
        (lambda: dx.line((0, 0, 0), (1, 0, 0), directors="cord"), "directors"),
        (lambda: dx.arc((0, 0, 0), (1, 0, 0), (2, 0, 0)), "on a line"),
        (lambda: dx.helix(radius=0.0, pitch=1.0, turns=1.0), "radius"),
        (lambda: dx.helix(radius=1.0, pitch=1.0, turns=0.0), "turns"),
        (lambda: dx.helix(radius=1.0, pitch=1.0, turns=1.0, axis=(0, 0, 0)), "axis"),
        (lambda: dx.polyline([(0, 0, 0)]), "2 points"),
        (lambda: dx.polyline([(0, 0, 0), (1, 0, 0), (0.5, 0, 0)]), "turns back"),
        (lambda: dx.polyline(3), "list of points"),
        (lambda: dx.spline([(0, 0, 0), (1, 0, 0)]), "3 points"),
    ],
)
def test_curves_that_cannot_be_are_refused_by_name(make, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        make()
    assert error.value.fix


@pytest.mark.parametrize("make", [dx.polyline, dx.spline, lambda p: dx.arc(*p)])
def test_points_that_cannot_be_computed_with_are_refused(make: Callable[[object], object]) -> None:
    with pytest.raises(dx.ModelError, match="away"):
        make([(0, 0, 1), (1e200, 1e200, 1e200), (1, 0, 1)])
