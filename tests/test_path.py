"""Paths with limit points: against a bar that snaps through, whose path is closed-form, and against load control."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from test_storage import same
from typer.testing import CliRunner

import directrix as dx
from directrix import path
from directrix.cli import app
from directrix.schema import load_case

EA, HEIGHT = 1000.0, 0.3
BAR = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=100.0, EI2=100.0, GJ=100.0)
SOFT = dx.Section.from_moduli(EA=1e4, GA1=1e4, GA2=1e4, EI1=1.0, EI2=1.0, GJ=1.0)
LENGTH = np.hypot(1.0, HEIGHT)
# the top of the bar at height y: P = EA y (1/l − 1/L), l² = 1 + y²; dP/dy = 0 where l³ = L
AT_LIMIT = np.sqrt(LENGTH ** (2 / 3) - 1.0)


def force_at(y: Any) -> Any:
    """Downward force that holds the top at height y."""
    return EA * y * (1.0 / np.hypot(1.0, y) - 1.0 / LENGTH)


LIMIT = force_at(AT_LIMIT)


def bar(load: Any = (0, -1, 0), *, order: int = 2, branched: bool = False, **how: Any) -> dx.Model:
    """Half of a flat truss: a bar from A up to its top T, which slides down the axis of symmetry; straight all along.

    ``branched`` hangs two stubs at the top, which makes it a general frame and changes nothing else.
    """
    model = dx.Model(name="snap").rod(
        dx.line((-1, 0, 0), (0, HEIGHT, 0)), BAR, name="bar", ends=("A", "T"), elements=2, order=order
    )
    for k, end in enumerate([(0.2, HEIGHT, 0), (0, HEIGHT, 0.2)] if branched else []):
        model = model.rod(dx.line((0, HEIGHT, 0), end), BAR, ends=("T", f"S{k}"), elements=1, order=order)
    model = model.fix("A", "x", "y", "z", "rx", "ry").fix("T", "x", "z", "rx", "ry")
    return model.force("T", load, **how)


def follow(
    model: dx.Model, ds: float = 0.02, *, start: dx.Result | None = None, save_every: int = 1, **how: Any
) -> dx.Result:
    return dx.solve_static(model, control=dx.ArcLength(ds=ds, **how), start=start, save_every=save_every)


def passed(factor: float) -> Callable[[Any], bool]:
    return lambda s: s.load_factor >= factor


def heights(result: dx.Result) -> np.ndarray:
    return HEIGHT + result.node("T").displacement[:, 1]


def on_the_path(result: dx.Result) -> None:
    np.testing.assert_allclose(result.load_factor, force_at(heights(result)), atol=1e-9 * LIMIT)


# --- what the path must be


@pytest.mark.parametrize("branched", [False, True], ids=["chain", "frame"])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_bar_snaps_through_and_its_limit_points_are_found(order: int, branched: bool) -> None:
    result = follow(bar(order=order, branched=branched), until=passed(1.5 * LIMIT))
    assert result.success and result.status.code == "stopped"
    assert result.info["solver"] == ("sparse" if branched else "chain")
    on_the_path(result)
    top, bottom = result.turning_points
    assert (top.kind, bottom.kind) == ("limit point (maximum)", "limit point (minimum)")
    np.testing.assert_allclose([top.load_factor, bottom.load_factor], [LIMIT, -LIMIT], rtol=1e-12)
    np.testing.assert_allclose(heights(result)[[top.index, bottom.index]], [AT_LIMIT, -AT_LIMIT], rtol=1e-6)
    assert result.load_factor[top.index] == top.load_factor
    assert result.audit.passed
    assert f"{top.load_factor:.9g}" in result.status.sentence and str(bottom) in str(result)


def test_the_path_is_measured_in_its_norm_and_never_doubles_back() -> None:
    result = follow(bar(), ds=0.01, ds_max=0.01, until=passed(1.5 * LIMIT))
    steps = np.diff(result.arc_length)
    assert steps.min() > 0.0 and steps.max() < 0.0102
    assert np.count_nonzero(steps < 0.0098) <= 2 * len(result.turning_points)  # short only up to a limit point
    assert np.all(np.diff(heights(result)) < 0.0)
    np.testing.assert_allclose(
        [p.arc_length for p in result.turning_points], result.arc_length[[p.index for p in result.turning_points]]
    )
    # by hand: every node moves by its share of the top's way and turns with the bar
    y = heights(result)[:2]
    turn = np.diff(np.arctan(y))[0]
    r, length = result.r[:2], np.hypot(1.0, HEIGHT) / (2.0 * np.pi)
    moved = np.mean(np.sum((r[1] - r[0]) ** 2, axis=1)) + length**2 * (2.0 * np.sin(0.5 * turn)) ** 2
    assert steps[0] == pytest.approx(np.sqrt(moved), rel=1e-12)


def test_displacement_control_passes_both_limit_points_of_the_load() -> None:
    control = dx.DisplacementControl("T", "y", to=-2.5 * HEIGHT, steps=25)
    result = dx.solve_static(bar(), control=control)
    assert result.status.code == "done" and "y displacement -0.75 of node 'T'" in result.status.sentence
    on_the_path(result)
    np.testing.assert_allclose([p.load_factor for p in result.turning_points], [LIMIT, -LIMIT], rtol=1e-12)
    parts = np.delete(result.node("T").displacement[:, 1], [p.index for p in result.turning_points])
    np.testing.assert_allclose(parts, np.linspace(0.0, -2.5 * HEIGHT, 26), atol=1e-14)


def test_load_factors_asked_for_are_met_at_every_crossing() -> None:
    result = follow(bar(), until=passed(0.9 * LIMIT + 0.2 * LIMIT), load_factors=(0.5 * LIMIT, 0.0))
    at = np.flatnonzero(result.load_factor == 0.5 * LIMIT)
    assert len(at) == 3 and np.all(np.diff(heights(result)[at]) < 0.0)
    np.testing.assert_allclose(force_at(heights(result)[at]), 0.5 * LIMIT, rtol=1e-9)
    zero = heights(result)[result.load_factor == 0.0]
    np.testing.assert_allclose(zero, [HEIGHT, 0.0, -HEIGHT], atol=1e-10)


def test_a_followed_path_agrees_with_load_control() -> None:
    """A cantilever under force and moment out of its plane, to load factor 1 exactly."""
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (1, 0, 0)), SOFT, name="rod", ends=("A", "B"), elements=6)
        .clamp("A")
        .force("B", (0, 2, 1))
        .moment("B", (1, 0, 2))
    )
    by_load = dx.solve_static(model, steps=10)
    along = follow(model, ds=0.05, until=passed(1.0), load_factors=(1.0,))
    assert along.load_factor[-1] == 1.0 and along.turning_points == ()
    np.testing.assert_allclose(along.r[-1], by_load.r[-1], atol=1e-8)
    np.testing.assert_allclose(along.R[-1], by_load.R[-1], atol=1e-8)
    np.testing.assert_allclose(along.node("A").reaction[-1], by_load.node("A").reaction[-1], atol=1e-7)


def test_prescribed_motion_ramps_with_the_load_factor() -> None:
    """A rod bent by turning one end, and pulled: supports move with the unknown factor, both kinds of it."""
    stout = dx.Section.from_moduli(EA=1e3, GA1=1e3, GA2=1e3, EI1=20, EI2=10, GJ=10)
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (1, 0, 0)), stout, name="rod", ends=("A", "B"), elements=6)
        .prescribe("A", displacement=(0, 0, 0), rotation=lambda f: (0, 0.4 * f, 0.8 * f * f))
        .prescribe("B", displacement=(0.05, 0.2, 0.1))
    )
    by_load = dx.solve_static(model, steps=10)
    along = follow(model, ds=0.01, ds_max=0.01, until=passed(1.0), load_factors=(1.0,))
    assert along.success and along.audit.passed
    np.testing.assert_allclose(along.r[-1], by_load.r[-1], atol=1e-8)
    np.testing.assert_allclose(along.node("B").reaction[-1], by_load.node("B").reaction[-1], atol=1e-6)
    np.testing.assert_allclose(along.energy.prescribed[-1], along.energy.stored[-1], rtol=2e-3)  # trapezoidal rule


def test_a_load_that_is_a_function_of_the_load_factor() -> None:
    """The factor multiplies the function of it: λ · λ F."""
    result = follow(bar(lambda f: (0, -1 - f, 0)), until=lambda s: s.node("T").displacement[1] < -0.9 * HEIGHT)
    np.testing.assert_allclose(
        result.load_factor * (1 + result.load_factor), force_at(heights(result)), atol=1e-9 * LIMIT
    )
    (top,) = result.turning_points
    assert top.load_factor == pytest.approx(np.sqrt(LIMIT + 0.25) - 0.5, rel=1e-10)
    with pytest.raises(dx.ModelError, match="begins flat"):
        follow(bar(lambda f: (0, -f, 0)))


def test_a_constant_load_stays() -> None:
    model = bar().force("T", (0, 5, 0), constant=True)
    result = follow(model, until=passed(5.0 + 1.5 * LIMIT))
    np.testing.assert_allclose(result.load_factor - 5.0, force_at(heights(result)), atol=1e-9 * LIMIT)
    assert result.load_factor[0] == 0.0 and heights(result)[0] > HEIGHT  # the first state bears it already
    assert result.energy.work[0] == pytest.approx(result.energy.stored[0], rel=0.2)  # brought on from nothing
    np.testing.assert_allclose([p.load_factor for p in result.turning_points], [5 + LIMIT, 5 - LIMIT], rtol=1e-12)


# --- steps


def test_the_step_adapts_to_the_iterations() -> None:
    few, many = (follow(arch(), ds=2.0, iterations=k, until=passed(1.9)) for k in (4, 7))
    longest = [np.diff(r.arc_length).max() for r in (few, many)]
    assert longest[0] < 0.5 * longest[1] and longest[1] <= 1.05 * 8.0  # 4 ds
    assert few.iterations.mean() < many.iterations.mean() < 7.0
    fixed = follow(arch(), ds=2.0, ds_max=2.0, iterations=7, until=passed(1.9))
    assert np.diff(fixed.arc_length).max() < 1.05 * 2.0


def arch(elements: int = 5) -> dx.Model:
    """The hinged frame of Romero and Armero's example 3."""
    c = dx.Section.from_moduli(EA=4.32e7, GA1=1.6615e7, GA2=1.6615e7, EI1=1.44e7, EI2=1.44e7, GJ=1.1e7)
    model = dx.Model().rod(dx.line((0, 0, 0), (0, 120, 0)), c, name="column", ends=("A", "C"), elements=elements)
    model = model.rod(
        dx.line((0, 120, 0), (120, 120, 0)), c, name="beam", ends=("C", "B"), elements=elements, nodes={"P": 0.2}
    )
    return model.fix("A", "x", "y", "z", "rx", "ry").fix("B", "x", "y", "z", "rx", "ry").force("P", (0, -1e4, 0))


def test_a_step_too_long_is_cut_and_leads_to_the_same_limit_points() -> None:
    short, long = (follow(arch(), ds=ds, ds_max=ds, until=passed(1.9)) for ds in (2.0, 40.0))
    assert long.success and long.info["cuts"] > 0 and "of them cut" in long.status.sentence
    np.testing.assert_allclose(
        [p.load_factor for p in long.turning_points], [p.load_factor for p in short.turning_points], rtol=1e-8
    )


def test_a_step_along_which_the_path_turns_too_much_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    until = lambda s: s.node("P").displacement[1] < -20.0  # noqa: E731
    monkeypatch.setattr(path, "STRAIGHT", 0.9999)
    careful = follow(arch(), ds=2.0, until=until)
    assert careful.info["cuts"] > 0 and careful.success
    monkeypatch.setattr(path, "STRAIGHT", 1.1)
    stuck = follow(arch(), ds=2.0, until=until)
    assert "the path turns too sharply" in stuck.status.sentence and "bifurcation" in stuck.status.advice


def test_a_run_that_is_stuck_says_where() -> None:
    result = follow(arch(), ds=60.0, ds_min=50.0, until=passed(1.9))
    assert not result.success and len(result.t) >= 1
    assert "stopped at load factor" in result.status.sentence and "arc length" in result.status.sentence
    assert result.status.advice


def test_a_displacement_that_turns_back_is_named() -> None:
    control = dx.DisplacementControl("P", "x", to=100.0, steps=20)
    start = follow(arch(), ds=2.0, until=lambda s: s.node("P").displacement[0] > 1.0)
    result = dx.solve_static(arch(), control=control, start=start)
    assert not result.success
    assert "the x displacement of node 'P' turns back or stands still near 9" in result.status.sentence
    assert "ArcLength" in result.status.advice
    furthest = follow(arch(), ds=2.0, until=passed(1.9)).node("P").displacement[:, 0].max()
    assert furthest - 0.3 < result.node("P").displacement[-1, 0] < furthest + 0.3
    assert len(result.turning_points) == 2
    # at first it hardly moves: sideways by 1e-4 of what moves down
    still = dx.solve_static(arch(), control=control)
    assert "turns back or stands still near 0" in still.status.sentence and not still.success


def test_most_steps() -> None:
    free = follow(bar(), max_steps=3)
    assert free.status.code == "done" and len(free.t) == 4 and free.iterations.size == 3
    short = follow(bar(), max_steps=3, until=passed(1e9))
    assert short.status.code == "step_limit" and not short.success and "max_steps" in short.status.advice


def test_every_so_many_steps_are_kept_and_all_limit_points() -> None:
    every, some = (follow(bar(), ds=0.01, ds_max=0.01, until=passed(1.2 * LIMIT), save_every=k) for k in (1, 4))
    assert len(some.t) < 0.5 * len(every.t) and some.load_factor[-1] == every.load_factor[-1]
    assert [p.load_factor for p in some.turning_points] == [p.load_factor for p in every.turning_points]
    for point in some.turning_points:
        assert some.load_factor[point.index] == point.load_factor


# --- going on


def test_a_run_goes_on_where_another_ended() -> None:
    whole = follow(bar(), ds=0.01, ds_max=0.01, until=passed(1.2 * LIMIT))
    half = follow(bar(), ds=0.01, ds_max=0.01, until=lambda s: s.load_factor < 0.0)
    rest = follow(bar(), ds=0.01, ds_max=0.01, start=half, until=passed(1.2 * LIMIT))
    assert rest.load_factor[0] == half.load_factor[-1] < 0.0
    assert rest.load_factor[1] < rest.load_factor[0]  # still falling
    found = [p.load_factor for p in (*half.turning_points, *rest.turning_points)]
    np.testing.assert_allclose(found, [p.load_factor for p in whole.turning_points], rtol=1e-12)
    back = follow(bar(), start=half, direction="backward", until=lambda s: s.load_factor <= 1e-6 and s.steps > 3)
    assert heights(back)[-1] > AT_LIMIT


def test_backward_from_the_reference_is_a_falling_load() -> None:
    result = follow(bar(), direction="backward", max_steps=3)
    assert np.all(np.diff(result.load_factor) < 0.0)
    on_the_path(result)


def test_displacement_control_goes_on_from_a_load() -> None:
    loaded = dx.solve_static(bar((0, -0.5 * LIMIT, 0)), steps=2)
    result = dx.solve_static(
        bar((0, -0.5 * LIMIT, 0)), control=dx.DisplacementControl("T", "y", -HEIGHT, 5), start=loaded
    )
    assert result.load_factor[0] == 1.0
    assert result.load_factor[-1] == pytest.approx(0.0, abs=1e-9)
    assert result.turning_points[0].load_factor == pytest.approx(2.0, rel=1e-12)


# --- what is refused


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: dx.ArcLength(ds=0.0), "ds = 0 is not greater"),
        (lambda: dx.ArcLength(ds=float("nan")), "ds = nan"),
        (lambda: dx.ArcLength(ds="1"), "ds = '1' is not a number"),
        (lambda: dx.ArcLength(ds=1.0, ds_min=2.0), "not between ds_min = 2"),
        (lambda: dx.ArcLength(ds=1.0, ds_max=0.5), "ds_max = 0.5"),
        (lambda: dx.ArcLength(ds=1.0, max_steps=0), "max_steps"),
        (lambda: dx.ArcLength(ds=1.0, iterations=1), "iterations"),
        (lambda: dx.ArcLength(ds=1.0, until=3), "until = 3 is not a function"),
        (lambda: dx.ArcLength(ds=1.0, load_factors=1.0), "load_factors = 1.0 is not a list"),
        (lambda: dx.ArcLength(ds=1.0, load_factors=(1.0, None)), "entry of load_factors"),
        (lambda: dx.ArcLength(ds=1.0, direction="up"), "no direction 'up'"),
        (lambda: dx.DisplacementControl("T", "rz", 1.0), "no component 'rz'"),
        (lambda: dx.DisplacementControl("", "y", 1.0), "node of DisplacementControl"),
        (lambda: dx.DisplacementControl("T", "y", float("inf")), "to = inf"),
        (lambda: dx.DisplacementControl("T", "y", 1.0, steps=0.5), "steps = 0.5"),
        (lambda: dx.solve_static(bar(), control="arc"), "'arc' is no control"),
        (lambda: dx.solve_static(bar(), steps=5, control=dx.ArcLength(1.0)), "steps= are those of load control"),
        (lambda: dx.solve_static(bar(), control=dx.DisplacementControl("Z", "y", 1.0)), "no node 'Z'"),
        (lambda: dx.solve_static(bar(), control=dx.DisplacementControl("T", "x", 1.0)), "x displacement .* is held"),
        (lambda: dx.solve_static(bar(), control=dx.DisplacementControl("T", "y", 0.0)), "is 0 already"),
        (lambda: follow(bar(constant=True)), "nothing moves with the load factor"),
        (lambda: follow(bar((1, 0, 0))), "nothing moves with the load factor"),
        (lambda: follow(bar(), until=passed(0.0)), "until is true at the start"),
        (lambda: follow(bar(), until=lambda s: s.load_factor), "until gives 0.0 .* return True or False"),
        (lambda: follow(bar(), until=lambda s: s.node("Z").r[0] > 0), "no node 'Z'"),
        (lambda: follow(bar(), until=lambda: True), "until fails at load factor 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(make: Callable[[], Any], says: str) -> None:
    with pytest.raises(dx.ModelError, match=says.replace(" .* ", "(.|\n)*")) as caught:
        make()
    assert caught.value.fix


def test_a_displacement_off_the_path_is_refused() -> None:
    model = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), SOFT, ends=("A", "B")).clamp("A").force("B", (0, 1, 0))
    with pytest.raises(dx.ModelError, match="z displacement of node 'B' does not move along the path"):
        dx.solve_static(model, control=dx.DisplacementControl("B", "z", 0.1))


def test_a_part_that_can_move_freely_is_no_start() -> None:
    for branched in (False, True):
        model = bar(branched=branched).rod(dx.line((5, 0, 0), (6, 0, 0)), BAR, ends=("X", "Y"))
        with pytest.raises(
            dx.ModelError, match=r"rod 'rod.' can move freely: rotation about every axis through node 'X'"
        ):
            follow(model.pin("X").force("Y", (0, 1, 0)))


def test_a_motion_is_no_start_of_a_path() -> None:
    heavy = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=1, EI2=1, GJ=1, A_rho=1, I_rho1=0.1, I_rho2=0.1)
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (1, 0, 0)), heavy, ends=("A", "B"), elements=1)
        .clamp("A")
        .force("B", (0, 1, 0))
    )
    with pytest.raises(dx.ModelError, match="start= is a motion"):
        follow(model, start=dx.simulate(model, t_end=0.1, dt=0.1))


def test_a_rule_that_fails_on_the_way_keeps_the_run() -> None:
    def until(s: Any) -> bool:
        if s.steps == 3:
            raise ZeroDivisionError("three")
        return False

    result = follow(bar(), until=until)
    assert result.status.code == "bad_input" and "three" in result.status.sentence and len(result.t) == 4


def test_an_interrupt_keeps_the_run() -> None:
    def until(s: Any) -> bool:
        if s.steps == 3:
            raise KeyboardInterrupt
        return False

    result = follow(bar(), until=until)
    assert result.status.code == "interrupted" and len(result.t) == 4


def test_no_start_under_a_constant_load_that_cannot_be_borne() -> None:
    result = follow(bar().force("T", (0, -1e9, 0), constant=True))
    assert not result.success and "no equilibrium to start from at load factor 0" in result.status.sentence
    assert np.all(result.r[0] == result.mesh.r0) and "load control" in result.status.advice


# --- a result whose load factor turns back, everywhere it goes


@pytest.fixture(scope="module")
def snapped() -> dx.Result:
    return follow(bar(), until=passed(1.5 * LIMIT))


def test_it_survives_saving_and_paraview_gets_times_that_rise(snapped: dx.Result, tmp_path: Path) -> None:
    path = snapped.save(tmp_path / "a.vtkhdf")
    kept = {name: value for name, value in snapped.info.items() if name != "wall_seconds"}
    same(replace(snapped, info=kept), dx.load(path))
    with h5py.File(path) as file:
        values: Any = file["VTKHDF/Steps/Values"]
        assert np.array_equal(values[()], np.arange(len(snapped.t)))
    with h5py.File(path, "r+") as file:
        del file["directrix/turning_points"]  # as an older file is
    assert dx.load(path).turning_points == ()


def test_it_is_drawn_over_what_rises_and_over_a_displacement(snapped: dx.Result, tmp_path: Path) -> None:
    ax: Any = snapped.plot.path("T", "y")
    assert np.array_equal(ax.lines[0].get_xdata(), snapped.node("T").displacement[:, 1])
    assert np.array_equal(ax.lines[0].get_ydata(), snapped.load_factor)
    assert [line.get_ydata() for line in ax.lines[1:]] == [[p.load_factor] for p in snapped.turning_points]
    for pen in (snapped.plot.energy(), snapped.plot.history("T")):
        assert np.array_equal(pen.lines[0].get_xdata(), snapped.arc_length) and "arc length" in pen.get_xlabel()
    motion: Any = snapped.plot.motion(5)
    assert motion.figure.axes[1].get_ylabel() == "arc length of the path"
    with pytest.raises(dx.ModelError, match="component 'w'"):
        snapped.plot.path("T", "w")  # type: ignore[arg-type]
    assert "instant" in Path(snapped.view(tmp_path / "a.html")).read_text("utf-8")


CASE = """
[section.bar]
kind = "moduli"
EA = 1e3
GA1 = 1e3
GA2 = 1e3
EI1 = 100
EI2 = 100
GJ = 100
[[rod]]
name = "bar"
section = "bar"
line = [[-1, 0, 0], [0, 0.3, 0]]
ends = ["A", "T"]
elements = 2
[[support]]
node = "A"
dofs = ["x", "y", "z", "rx", "ry"]
[[support]]
node = "T"
dofs = ["x", "z", "rx", "ry"]
[[force]]
node = "T"
value = [0, -1, 0]
[statics]
"""
ALONG = 'control = { kind = "arc-length", ds = 0.02, max_load_factor = 15, load_factors = [5] }\n'


@pytest.mark.parametrize(
    ("control", "says"),
    [
        (ALONG, ("along the path in steps of ds = 0.02", "load factor is 15 or more", "load factors 5")),
        (
            'control = { kind = "arc-length", ds = 0.02, min_load_factor = -5, '
            'until = { node = "T", component = "y", displacement = -0.7 } }\n',
            ("the load factor is -5 or less, or y of T has moved -0.7 or less",),
        ),
        (
            'control = { kind = "displacement", node = "T", component = "y", to = -0.8, steps = 20 }\n',
            ("y displacement of T → -0.8 in 20 steps",),
        ),
    ],
)
def test_a_case_file_follows_a_path(tmp_path: Path, control: str, says: tuple[str, ...]) -> None:
    file = tmp_path / "snap.toml"
    file.write_text(CASE + control, "utf-8")
    shown = CliRunner().invoke(app, ["check", str(file)])
    assert shown.exit_code == 0 and all(text in shown.output for text in says), shown.output
    result = load_case(file).run()
    assert result.success
    on_the_path(result)
    assert result.load_factor[-1] == 15.0 or heights(result)[-1] <= HEIGHT - 0.7


def test_the_commands_run_and_draw_it(tmp_path: Path) -> None:
    file = tmp_path / "snap.toml"
    file.write_text(CASE + ALONG, "utf-8")
    done = CliRunner().invoke(app, ["run", str(file)])
    assert done.exit_code == 0 and "limit point (maximum)" in done.output, done.output
    folder = tmp_path / "snap.run"
    with (folder / "monitor.csv").open(newline="") as table:
        factors = [float(row["load_factor"]) for row in csv.DictReader(table)]
    assert factors == dx.load(folder / "result.vtkhdf").load_factor.tolist()
    assert '"turning_points"' in (folder / "run.json").read_text("utf-8")
    drawn = CliRunner().invoke(app, ["plot", str(folder), "path", "--node", "T", "--component", "y"])
    assert drawn.exit_code == 0 and (folder / "path-T-y.png").is_file(), drawn.output


@pytest.mark.parametrize(
    ("control", "says"),
    [
        ("steps = 3\n" + ALONG, "steps are those of load control"),
        ('control = { kind = "arc", ds = 1 }\n', "no kind 'arc'"),
        ('control = { kind = "arc-length", ds = 0 }\n', "ds"),
        ('control = { kind = "displacement", node = "Z", component = "y", to = 1 }\n', "no node 'Z'"),
        ('control = { kind = "displacement", node = "T", component = "x", to = 1 }\n', "held by a support"),
        (
            'control = { kind = "arc-length", ds = 1, until = { node = "Z", component = "y", displacement = 1 } }\n',
            "no node 'Z'",
        ),
        (
            'control = { kind = "arc-length", ds = 1, until = { node = "T", component = "y", displacement = 0 } }\n',
            "no sense",
        ),
    ],
)
def test_a_wrong_control_is_refused_at_its_place(tmp_path: Path, control: str, says: str) -> None:
    file = tmp_path / "snap.toml"
    file.write_text(CASE + control, "utf-8")
    with pytest.raises(dx.InputError, match=says) as caught:
        load_case(file)
    assert caught.value.where.startswith(f"{file}:2") and "statics" in caught.value.where
