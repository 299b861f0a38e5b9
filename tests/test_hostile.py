"""What cannot be meant is refused with a sentence, whatever type it comes in; no other error gets out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import directrix as dx
from directrix.comparison import compare_energy_momentum
from directrix.schema import load_case

SECTION = dx.Section.from_moduli(EA=1e3, GA1=1e3, GA2=1e3, EI1=1.0, EI2=1.0, GJ=1.0, A_rho=1.0, I_rho1=0.1, I_rho2=0.1)
LINE = dx.line((0, 0, 0), (1, 0, 0))


class Hostile:
    """Neither a number nor an array, and says so in its own way."""

    def __float__(self) -> float:
        raise RuntimeError("no")

    def __repr__(self) -> str:
        raise RuntimeError("no")


NEVER = [
    Hostile(), object(), 1j, float("nan"), float("inf"), True, 10**5000, b"x", {"a": 1}, set(), np.zeros((3, 3)),
    np.array([1j, 0, 0]), np.array(["a", "b", "c"]), np.ma.masked_array([1, 2, 3], mask=[1, 0, 0]), ["1", "2", "3"],
    [True, False, True], [None] * 3, [1, [2], 3], [[1], [2], [3]], (x for x in (1, 2)), "12", int,
]  # fmt: skip


def held(**more: Any) -> dx.Model:
    return dx.Model().rod(LINE, SECTION, **{"name": "beam", "ends": ("A", "B"), "elements": 2, **more}).clamp("A")


def static(**more: Any) -> dx.Result:
    return dx.solve_static(held(), **{"steps": 1, **more})


def moving(**more: Any) -> dx.Result:
    return dx.simulate(held(), **{"t_end": 0.1, "dt": 0.1, **more})


PLACES: dict[str, Callable[[Any], object]] = {
    "line": lambda w: dx.line(w, (1, 0, 0)),
    "d1": lambda w: dx.line((0, 0, 0), (0, 0, 1), d1=w),
    "directors": lambda w: dx.line((0, 0, 0), (0, 0, 1), directors=w),
    "polyline": dx.polyline,
    "spline": dx.spline,
    "radius of helix": lambda w: dx.helix(radius=w, pitch=1, turns=1),
    "radius": lambda w: dx.Section.circle(w, E=1, nu=0.3),
    "E": lambda w: dx.Section.circle(1, E=w, nu=0.3),
    "EA": lambda w: dx.Section.from_moduli(EA=w, GA1=1, GA2=1, EI1=1, EI2=1, GJ=1),
    "stiffness": lambda w: dx.Section(w, order="shear-axial"),
    "order of stiffness": lambda w: dx.Section(np.eye(6), order=w),
    "outline": lambda w: dx.Section(np.eye(6), order="shear-axial", outline=w),
    "curve": lambda w: dx.Model().rod(w, SECTION),
    "section": lambda w: dx.Model().rod(LINE, w),
    "elements": lambda w: held(elements=w),
    "order": lambda w: held(order=w),
    "points": lambda w: held(points=w),
    "ends": lambda w: held(ends=w),
    "nodes": lambda w: held(nodes={"P": w}),
    "split": lambda w: held().split(w, {"P": 0.5}),
    "fix": lambda w: held().fix("B", w),
    "force": lambda w: held().force("B", w),
    "prescribe": lambda w: held().prescribe("B", displacement=w),
    "velocity": lambda w: held().velocity("B", w),
    "model": lambda w: dx.solve_static(w),
    "steps": lambda w: static(steps=10.5 if w is True else w),
    "tolerance": lambda w: static(tolerance=w),
    "start": lambda w: static(start=w),
    "formulation": lambda w: static(formulation=w),
    "rotation": lambda w: static(rotation=w),
    "t_end": lambda w: moving(t_end=w),
    "dt": lambda w: moving(dt=w),
    "integrator": lambda w: moving(integrator=w),
    "load rule": lambda w: moving(load_rule=w),
    "save_every": lambda w: moving(save_every=w),
    "node": lambda w: RESULT.node(w),
    "rod": lambda w: RESULT.rod(w),
    "shape": lambda w: RESULT.plot.shape(at=w),
    "motion": lambda w: RESULT.plot.motion(frames=1.5 if isinstance(w, int) and w > 1 else w),
    "residual": lambda w: RESULT.plot.energy(residual=None if w is True else w),
    "history of a node": lambda w: RESULT.plot.history(w),
    "history": lambda w: RESULT.plot.history("A", w),
    "path of a node": lambda w: RESULT.plot.path(w, "x"),
    "path": lambda w: RESULT.plot.path("A", w),
    **{
        f"axes of {name}": lambda w, name=name, args=args: getattr(RESULT.plot, name)(*args, ax=w)
        for name, args in (("shape", ()), ("motion", ()), ("energy", ()), ("history", ("A",)), ("path", ("A", "x")))
    },
    "save": lambda w: RESULT.save(no_text(w)),
    "view": lambda w: RESULT.view(no_text(w)),
    "load": lambda w: dx.load(no_text(w)),
    "case": lambda w: load_case(no_text(w)),
    "comparison": lambda w: compare_energy_momentum({"a": RESULT}, no_text(w)),
}


def no_text(given: Any) -> Any:
    """What is never the name of a file: a text is one, unless it is empty or holds what no file system takes."""
    return {"12": "a\0b"}.get(given, given) if isinstance(given, str) else given


RESULT = static()


@pytest.mark.parametrize("place", PLACES)
def test_no_argument_gets_through_that_is_of_another_kind(place: str) -> None:
    for k, given in enumerate(NEVER):
        if callable(given) and place in ("force", "prescribe"):
            continue  # a function of time
        with pytest.raises(dx.ModelError) as error:
            PLACES[place](given)
            pytest.fail(f"{place} takes number {k}: a {type(given).__name__}")
        assert error.value.fix


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: held(elements=10**9), "elements = 1000000000"),
        (lambda: held(nodes=["P"]), "nodes = .* are not names"),
        (lambda: held().split("beam", ["P"]), "nodes = .* are not names"),
        (lambda: held().force("B", (0, 0, 1), constant="no"), "neither True nor False"),
        (lambda: static(progress="bar"), "cannot be called"),
        (lambda: moving(integrator=dx.Midpoint), "not an integrator"),
        (lambda: moving(dt=1e-300), "more than 10¹² steps"),
        (lambda: RESULT.save(""), "path = '' is not the path"),
        (lambda: RESULT.view("\ud800.html"), "is not the path"),
        (lambda: RESULT.plot.energy(ax=Figure().add_subplot(projection="3d")), "the axes given is in space"),
        (lambda: dx.Section.circle(1e308, E=1, nu=0.3), "out of reach"),
        (lambda: dx.spline([(0, 0, 0), (1, 0, 0), (0, 0, 0)]), "turns back on itself"),
        (lambda: dx.polyline([(0, 0, 0), (1, 0, 0), (0, 0, 0)]), "turns back on itself"),
        (lambda: dx.spline([(0, 0, 0), (0, 0, 0), (1, 0, 0)]), "are the same"),
        (lambda: dx.arc((0, 0, 0), (1, 0, 0), (2, 0, 0)), "lie on a line"),
        (lambda: dx.line((0, 0, 0), (1, 0, 0), d1=(2, 0, 0)), "along the rod"),
        (lambda: dx.Model().rod(dx.line((0, 0, 0), (1e300, 0, 0)), SECTION), "of the line is 1e.300 away"),
        (lambda: dx.Model().rod(dx.helix(radius=1e308, pitch=1, turns=9), SECTION), "inf long"),
    ],
)  # fmt: skip
def test_a_model_that_cannot_be_computed_is_refused(make: Callable[[], object], says: str) -> None:
    with np.errstate(all="ignore"), pytest.raises(dx.ModelError, match=says) as error:
        make()
    assert error.value.fix


def test_a_small_rod_is_a_rod() -> None:
    """What coincides is measured against the model, not against a metre."""
    assert dx.line((0, 0, 0), (1e-14, 0, 0)).length == 1e-14


@pytest.mark.parametrize(
    "bad", [None, (0, 0), "abc", (0, 0, float("nan")), (0, 0, 1j), KeyError("k"), ZeroDivisionError()]
)
def test_a_function_that_fails_on_the_way_keeps_the_run_so_far(bad: Any) -> None:
    def f(t: float) -> Any:
        if t > 0.35 and isinstance(bad, Exception):
            raise bad
        return bad if t > 0.35 else (0, 0, 0)

    for model in (held().force("B", f), held().prescribe("B", displacement=f)):
        for result in (dx.simulate(model, 1.0, 0.1), dx.solve_static(model, steps=10)):
            assert (result.success, result.status.code) == (False, "bad_input")
            assert "node 'B'" in result.status.sentence and result.status.advice
            assert 0.25 < result.t[-1] < 0.4 and np.all(np.isfinite(result.r))


RUNS: dict[str, Callable[..., dx.Result]] = {
    "motion": lambda **more: dx.simulate(held().velocity("B", (0, 1, 0)), 1.0, 0.1, **more),
    "statics": lambda **more: dx.solve_static(held().force("B", (0, 1, 0)), steps=10, **more),
    "path": lambda **more: dx.solve_static(
        held().force("B", (0, 1, 0)), control=dx.DisplacementControl("B", "y", to=0.1, steps=10), **more
    ),
}


@pytest.mark.parametrize("error", [ZeroDivisionError("no"), dx.ModelError("no"), Hostile], ids=repr)
@pytest.mark.parametrize("kind", RUNS)
def test_a_progress_that_fails_keeps_the_run_so_far(kind: str, error: Any) -> None:
    def progress(done: float, line: str) -> None:
        if done > 0.35:
            raise error if isinstance(error, Exception) else TypeError(error())

    whole, result = RUNS[kind](), RUNS[kind](progress=progress)
    assert (result.success, result.status.code) == (False, "bad_input")
    assert "progress fails with" in result.status.sentence and "start=" in result.status.advice
    assert 1 < len(result.t) < len(whole.t)
    np.testing.assert_array_equal(result.r, whole.r[: len(result.t)])
    if kind == "motion":
        assert f"stopped at t = {result.t[-1]:g}" in result.status.sentence
    with pytest.raises(dx.ConvergenceError, match="progress fails with"):
        RUNS[kind](progress=progress, raise_on_failure=True)
