"""Pictures show the numbers of the result, refuse what they cannot show, and leave nothing behind."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from fake_result import fake_result, with_joints
from matplotlib.figure import Figure

from directrix import comparison, drawing
from directrix.comparison import compare_energy_momentum
from directrix.errors import ModelError
from directrix.plot import Plots
from directrix.result import Energy, Result, RodMesh

matplotlib.use("Agg")

from matplotlib import pyplot


@pytest.fixture(autouse=True)
def _closed() -> Any:
    yield
    pyplot.close("all")


def flat_axes() -> Any:
    return Figure().add_subplot()


def space_axes() -> Any:
    return Figure().add_subplot(projection="3d")


def curve(ax: Any, label: str) -> np.ndarray:
    return next(np.asarray(line.get_ydata()) for line in ax.lines if line.get_label() == label)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_axis_follows_the_polynomial_of_its_elements(order: int) -> None:
    s = np.linspace(0.0, 2.0, 3 * order + 1)
    rod = RodMesh("a", np.arange(len(s)), s, np.zeros((len(s), 3, 3)), order, s, 0, np.zeros((0, 2)))
    law = np.column_stack([s, s**order - s, 2.0 - s**order])
    drawn = drawing.axis_line(rod, law)
    assert len(drawn) == (4 if order == 1 else 25)
    expected = np.column_stack([drawn[:, 0], drawn[:, 0] ** order - drawn[:, 0], 2.0 - drawn[:, 0] ** order])
    assert np.allclose(drawn, expected, atol=1e-13)
    assert np.array_equal(drawn[[0, -1]], law[[0, -1]])


def test_shape_draws_every_rod_over_the_undeformed_one() -> None:
    result = fake_result(order=2, elements=3)
    ax: Any = Plots(result).shape(7)
    assert ax.name == "3d"
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()) == ("x", "y", "z")
    drawn = [np.column_stack(line.get_data_3d()) for line in ax.lines]
    for rod in result.mesh.rods:
        for r in (result.mesh.r0, result.r[7]):
            expected = drawing.axis_line(rod, r)
            assert any(line.shape == expected.shape and np.allclose(line, expected) for line in drawn)
    assert [text.get_text().strip() for text in ax.texts] == ["A", "O", "B", "C"]
    assert f"{result.t[7]:.4g}" in ax.get_title()


def test_joints_are_open_circles_and_arms_thin_lines() -> None:
    result = one_node_more(with_joints(fake_result()), 1.0)
    ends = result.joint_ends(7)
    arms = result.mesh.joint_arms
    np.testing.assert_allclose(ends[0, 0], [arms[0, 0]] * 2)
    np.testing.assert_allclose(ends[1, 1, 1], result.r[7, 15] + result.R[7, 15] @ arms[1, 1])
    for ax, instant in ((Plots(result).shape(7), 7), (Plots(result).motion(1), 0)):
        lines: Any = ax.lines
        drawn = [np.column_stack(line.get_data_3d()) for line in lines]
        ends = result.joint_ends(instant)
        for points in (ends[0, 1], ends[1, 0], ends[1, 1]):
            assert any(line.shape == (2, 3) and np.allclose(line, points) for line in drawn)
        assert not any(line.shape == (2, 3) and np.allclose(line, ends[0, 0]) for line in drawn)  # the ground has none
        circles = [k for k, line in enumerate(lines) if line.get_markerfacecolor() == "white"]
        assert len(circles) == 1 and np.allclose(drawn[circles[0]], ends[:, 1, 1])
        assert any(len(line) == 1 and np.allclose(line, result.r[instant, -1]) for line in drawn)


def test_nodes_at_one_place_share_a_label() -> None:
    result = one_node_more(fake_result(), 1e-15)
    mesh = replace(result.mesh, node_names={"A": 0, "in": 5, "C": 15, "out": 16})
    ax: Any = Plots(replace(result, mesh=mesh)).shape()
    assert [text.get_text().strip() for text in ax.texts] == ["A", "in, out", "C"]


def one_node_more(result: Result, beside: float) -> Result:
    """With a node on no rod, beside node 5."""
    r, R = (np.append(values, values[:, 5:6], axis=1) for values in (result.r, result.R))
    r[:, -1] += beside
    mesh = replace(result.mesh, r0=np.append(result.mesh.r0, result.mesh.r0[5:6] + beside, axis=0))
    return replace(result, mesh=mesh, r=r, R=R)


def test_space_has_one_scale() -> None:
    ax: Any = Plots(fake_result("static")).shape()
    spans = [np.ptp(limits) for limits in (ax.get_xlim(), ax.get_ylim(), ax.get_zlim())]
    ratio = np.asarray(ax.get_box_aspect()) / spans
    assert np.allclose(ratio, ratio[0])


@pytest.mark.parametrize(("drop", "names"), [(2, ("x", "y")), (1, ("x", "z")), (0, ("y", "z"))])
def test_planar_results_are_drawn_in_their_plane(drop: int, names: tuple[str, str]) -> None:
    flat = fake_result(planar=True)
    columns = [0, 1]
    columns.insert(drop, 2)
    mesh = replace(flat.mesh, r0=flat.mesh.r0[:, columns])
    result = replace(flat, r=flat.r[:, :, columns], mesh=mesh)
    ax: Any = Plots(result).shape()
    assert (ax.name, ax.get_xlabel(), ax.get_ylabel()) == ("rectilinear", *names)
    assert ax.get_aspect() == 1.0
    right = np.asarray(ax.lines[3].get_xdata())
    assert np.allclose(right, result.r[-1, result.mesh.rods[0].nodes, "xyz".index(names[0])])


def test_the_axes_given_is_the_axes_used() -> None:
    plots, static = Plots(fake_result()), Plots(fake_result("static"))
    space, flat = space_axes(), flat_axes()
    assert plots.shape(ax=space) is space
    assert plots.motion(ax=space) is space
    assert Plots(fake_result(planar=True)).shape(ax=space) is space
    assert plots.energy(ax=flat) is flat
    assert plots.momentum(ax=flat) is flat
    assert static.history("A", "reaction", ax=flat) is flat
    assert pyplot.get_fignums() == []


def test_a_flat_axes_cannot_hold_a_motion_in_space() -> None:
    with pytest.raises(ModelError, match="projection"):
        Plots(fake_result()).shape(ax=flat_axes())


def test_motion_spreads_its_shapes_over_the_run() -> None:
    result = fake_result()
    ax: Any = Plots(result).motion(5)
    rods = len(result.mesh.rods)
    shapes = ax.lines[rods : rods + 5 * rods]
    first, final = (np.column_stack(shapes[k].get_data_3d()) for k in (0, -1))
    assert np.allclose(first, result.r[0, result.mesh.rods[0].nodes])
    assert np.allclose(final, result.r[-1, result.mesh.rods[-1].nodes])
    assert len({line.get_color() for line in shapes}) == 5
    assert len(ax.figure.axes) == 2  # with the scale of times
    assert len(Plots(fake_result("static", instants=3)).motion(12).lines) == rods * (1 + 3) + 4


def test_energy_shows_the_ledger() -> None:
    result = fake_result()
    energy = result.energy
    ax = Plots(result).energy()
    assert np.array_equal(curve(ax, "total"), energy.total)
    assert np.array_equal(curve(ax, "kinetic"), energy.kinetic)
    assert np.array_equal(curve(ax, "stored"), energy.stored)
    assert len(ax.lines) == 3  # nothing came in, so nothing is said about it
    work = 0.1 * result.t
    worked = replace(result, energy=Energy(energy.kinetic, energy.stored, work, 0 * work, 0.5 * work))
    ax = Plots(worked).energy(residual=True)
    assert np.allclose(curve(ax, "start + work - dissipated"), 2.5 + 0.5 * work)
    assert np.array_equal(curve(ax.figure.axes[1], "residual"), worked.energy.residual)


def test_static_energy_is_stored_against_work() -> None:
    result = fake_result("static")
    ax = Plots(result).energy()
    assert ax.get_xlabel() == "load factor"
    assert np.array_equal(curve(ax, "stored"), result.energy.stored)
    assert np.array_equal(curve(ax, "work done on it"), result.energy.work)


def test_momentum_shows_six_components() -> None:
    result = fake_result()
    ax = Plots(result).momentum()
    assert np.array_equal(curve(ax, "$L_z$"), result.momentum.linear[:, 2])
    assert np.array_equal(curve(ax, "$J_y$"), result.momentum.angular[:, 1])
    with pytest.raises(ModelError, match="static"):
        Plots(fake_result("static")).momentum()


@pytest.mark.parametrize(
    ("quantity", "label"), [("displacement", "$u_y$"), ("r", "y"), ("v", "$v_y$"), ("reaction", "$F_y$")]
)
def test_history_shows_the_node(quantity: Any, label: str) -> None:
    result = fake_result()
    ax = Plots(result).history("B", quantity)
    assert np.array_equal(curve(ax, label), getattr(result.node("B"), quantity)[:, 1])
    assert "B" in ax.get_title()


def test_reaction_has_moments() -> None:
    result = fake_result("static")
    assert np.array_equal(curve(Plots(result).history("A", "reaction"), "$M_y$"), result.node("A").reaction[:, 4])


@pytest.mark.parametrize(
    ("draw", "match"),
    [
        (lambda p: p.shape(40), "no saved instant 40"),
        (lambda p: p.shape(-41), "no saved instant -41"),
        (lambda p: p.motion(0), "frames = 0"),
        (lambda p: p.motion(float("nan")), "frames = nan"),
        (lambda p: p.history("Z"), "no node 'Z'"),
        (lambda p: p.history("A", "R"), "no history of 'R'"),
    ],
)
def test_what_does_not_exist_is_refused(draw: Any, match: str) -> None:
    with pytest.raises(ModelError, match=match):
        draw(Plots(fake_result()))


def test_names_are_text_and_not_mathematics() -> None:
    result = fake_result(title=r"cost $\frac$ of $5")
    mesh = replace(result.mesh, node_names={"$\\x$": 0})
    for ax in (Plots(replace(result, mesh=mesh)).shape(), Plots(result).momentum()):
        ax.figure.canvas.draw()


def test_missing_matplotlib_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for draw in (Plots(fake_result()).shape, Plots(fake_result()).energy):
        with pytest.raises(ModelError, match=r"directrix\[plot\]"):
            draw()


def failing(peak: float) -> Result:
    result = fake_result(fails=True, t_end=20.0)
    growth = (peak - 2.5) * (result.t / 20.0) ** 6
    energy = replace(result.energy, kinetic=2.5 + growth, stored=0.0 * growth)
    return replace(result, energy=energy)


@pytest.mark.parametrize("peak", [7.0, 1e6])
def test_divergence_and_conservation_are_both_in_sight(peak: float) -> None:
    ax, first = flat_axes(), fake_result(t_end=30.0)
    comparison._total_energies(ax, "conserving", first, [("midpoint", failing(peak))])
    low, high = ax.get_ylim()
    assert low == 0.0
    assert 0.2 * high < 2.5 < 0.8 * high  # the conserving curve keeps a fair part of the height
    cross = next(line for line in ax.lines if line.get_marker() == "x")
    assert cross.get_xdata() == [20.0]
    assert 0.85 * high < cross.get_ydata()[0] < high
    said = ax.texts[0].get_text()
    assert "t = 20" in said
    assert ("1e+06" in said) == (peak > 7.0)


def test_comparison_is_written_without_touching_pyplot(tmp_path: Path) -> None:
    path = tmp_path / "compare.png"
    runs = {
        "energy-momentum": fake_result(t_end=30.0),
        "midpoint $": failing(7.0),
        "late": fake_result(fails=True),
    }
    assert compare_energy_momentum(runs, path, snapshots=3) == str(path)
    image = pyplot.imread(path)
    assert image.shape[:2] == (1152, 1920)
    assert image[..., :3].min() < 0.2 < 0.9 < image[..., :3].mean()
    assert pyplot.get_fignums() == []


def test_comparison_refuses_what_it_cannot_draw(tmp_path: Path) -> None:
    dynamic = fake_result()
    with pytest.raises(ModelError, match="no result to compare"):
        compare_energy_momentum({}, tmp_path / "a.png")
    with pytest.raises(ModelError, match=r"results\['b'\]: a static"):
        compare_energy_momentum({"a": dynamic, "b": fake_result("static")}, tmp_path / "a.png")
    with pytest.raises(ModelError, match="No such file"):
        compare_energy_momentum({"a": dynamic}, tmp_path / "missing" / "a.png")
    with pytest.raises(ModelError, match="no known kind of picture"):
        compare_energy_momentum({"a": dynamic}, tmp_path / "a")
    with pytest.raises(ModelError, match="snapshots = 0"):
        compare_energy_momentum({"a": dynamic}, tmp_path / "a.png", snapshots=0)
