"""Stability along paths: what is counted, where it changes, and the paths that leave there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import directrix as dx
from directrix.result import Result


def column(EI2: float = 100.0, EA: float = 1e4, EI: float = 1.0, L: float = 1.0, P: float = 1.0) -> dx.Model:
    """Clamped, unit length along x, EI = 1 in the x–z plane."""
    section = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=EI, EI2=EI2, GJ=100.0)
    axis = dx.line((0, 0, 0), (L, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="column").rod(axis, section, name="rod", ends=("a", "b"), elements=12)
    return model.clamp("a").force("b", (-P, 0, 0))


def along(load_step: float = 2.0, to: float = 30.0, **more: object) -> dx.ArcLength:
    return dx.ArcLength(ds=0.02, load_step=load_step, until=lambda s: s.load_factor > to, **more)  # type: ignore[arg-type]


def at(result: Result, k: int) -> Result:
    """One saved state alone."""
    part = slice(k, k + 1) if k != -1 else slice(-1, None)
    one = np.ones(1)
    return replace(result, t=one, load_factor=one, r=result.r[part], R=result.R[part], v=result.v[part],
                   Rdot=result.Rdot[part], history=result.history[part])  # fmt: skip


def test_a_bifurcation_is_where_it_is_whatever_the_steps() -> None:
    """To 1e-8 of the load factor; EA = GA, so that it is Euler's load but for the mesh."""
    found = [dx.solve_static(column(), control=along(step)).stability for step in (0.5, 0.77, 2.9)]
    loads = np.array([[p.load_factor for p in s.points] for s in found if s is not None])
    assert loads.shape == (3, 2)
    np.testing.assert_allclose(loads, loads[:1].repeat(3, axis=0), rtol=1e-8)
    np.testing.assert_allclose(loads[0], [np.pi**2 / 4, 9 * np.pi**2 / 4], rtol=2e-4)


def test_points_have_names_counts_and_modes() -> None:
    result = dx.solve_static(column(), control=along())
    s = result.stability
    assert s is not None
    assert [(p.kind, p.before, p.after, len(p.modes)) for p in s.points] == [
        ("simple bifurcation", 0, 1, 1), ("simple bifurcation", 1, 2, 1),
    ]  # fmt: skip
    for p in s.points:
        assert s.critical[p.index] and not s.stable[p.index]
        assert result.load_factor[p.index] == pytest.approx(p.load_factor, rel=1e-8)
        assert s.negative[p.index] == p.before
    assert np.array_equal(s.negative[~s.critical], np.searchsorted([p.load_factor for p in s.points],
                                                                  result.load_factor[~s.critical]))  # fmt: skip
    quarter = s.points[0].modes[0][result.mesh.rod("rod").nodes, 2]
    x = result.mesh.rod("rod").s
    np.testing.assert_allclose(quarter / quarter[-1], 1.0 - np.cos(0.5 * np.pi * x), atol=1e-4)
    assert "simple bifurcation at load factor 2.46" in str(result)


def test_equal_modes_are_a_multiple_bifurcation_and_no_branch_is_picked() -> None:
    s = dx.solve_static(column(EI2=1.0), control=along(to=5.0)).stability
    assert s is not None
    assert [(p.kind, p.before, p.after, len(p.modes)) for p in s.points] == [("multiple bifurcation", 0, 2, 2)]
    left = dx.solve_static(column(EI2=1.0), control=along(to=5.0, branch=1))
    assert left.status.code == "singular" and "multiple" in left.status.sentence


def test_both_sides_of_a_branch_mirror_each_other_and_stay_stable() -> None:
    sides = [dx.solve_static(column(), control=along(to=2.9, branch=b)) for b in (1, -1)]
    for result in sides:
        assert result.success and result.audit.passed and result.stability is not None
        assert np.all(result.stability.negative == 0)
        assert abs(result.node("b").displacement[-1, 2]) > 0.5
    np.testing.assert_allclose(sides[0].r * (1, 1, -1), sides[1].r, atol=1e-7)


def test_branches_of_branches_and_bifurcations_that_do_not_come() -> None:
    missed = dx.solve_static(column(), control=along(to=5.0, branch=2))
    assert not missed.success and "bifurcation 2" in missed.status.sentence
    every = dx.branches(column(), control=along(to=23.0), count=2)
    assert len(every) == 5 and all(r.success for r in every)
    bent = [float(np.abs(r.r[-1, :, 2]).max()) for r in every]
    assert bent[0] < 1e-6 and min(bent[1:]) > 0.1


def test_limit_points_are_counted_too() -> None:
    from directrix.verification.hinged_frame import trace

    result = trace(10)
    s = result.stability
    assert s is not None
    assert [(p.kind, p.before, p.after) for p in s.points] == [
        ("simple bifurcation", 0, 1), ("limit point (maximum)", 1, 2), ("limit point (minimum)", 2, 1),
    ]  # fmt: skip
    turning = [p.load_factor for p in result.turning_points]
    assert [p.load_factor for p in s.points[1:]] == turning
    # the mode at a limit point is the path itself
    k = s.points[1].index
    step = result.r[k + 1] - result.r[k - 1]
    mode = s.points[1].modes[0][:, :3]
    assert abs(np.sum(step * mode)) > 0.999 * np.linalg.norm(step) * np.linalg.norm(mode)


def frame(load: float, held: bool) -> dx.Model:
    """Example 3 with mass under this load; ``held`` in its plane at the corner and at the load."""
    E, G, A, I = 7.2e6, 7.2e6 / 2.6, 6.0, 2.0
    section = dx.Section.from_moduli(
        EA=E * A, GA1=G * A, GA2=G * A, EI1=E * I, EI2=E * I, GJ=G * 2 * I, A_rho=1.0, I_rho1=0.5, I_rho2=0.5
    )
    column, beam = dx.line((0, 0, 0), (0, 120, 0)), dx.line((0, 120, 0), (120, 120, 0))
    model = dx.Model(name="frame").rod(column, section, name="column", ends=("A", "C"), elements=5)
    model = model.rod(beam, section, name="beam", ends=("C", "B"), elements=5, nodes={"P": 0.2})
    model = model.fix("A", "x", "y", "z", "rx", "ry").fix("B", "x", "y", "z", "rx", "ry").force("P", (0, -load, 0))
    return model.fix("C", "z").fix("P", "z") if held else model


def test_stable_states_stay_and_unstable_ones_leave() -> None:
    """Ten states of Example 3's path, kicked a little and left to an energy–momentum run."""
    seen: list[bool] = []
    for held, picked in ((False, (1, 6, 18, 35, 53)), (True, (1, 6, 18, 40, 52))):
        control = dx.ArcLength(ds=4.0, ds_max=4.0, until=lambda s: s.load_factor >= 3e4)
        path = dx.solve_static(frame(1.0, held), control=control)
        assert path.stability is not None
        for k in picked:
            here, model = at(path, k), frame(float(path.load_factor[k]), held)
            assert not path.stability.critical[k]
            slowest = dx.modes(model, about=here, count=1)
            assert slowest.stable == path.stability.stable[k]
            rate = float(np.sqrt(abs(slowest.squares[0])))
            kick = 1e-3 * rate
            kicked = model.velocity("P", (0.3 * kick, kick, 0.0 if held else kick)).velocity(
                "C", (0, 0, 0), (0, 0, 1e-5 * rate)
            )
            run = dx.simulate(kicked, t_end=3 * 2 * np.pi / rate, dt=2 * np.pi / rate / 40, start=here)
            far = float(np.abs(run.r - run.r[0]).max())
            assert (far < 1e-2) == path.stability.stable[k], (held, k, far)
            assert far < 1e-2 or far > 1.0
            seen.append(bool(path.stability.stable[k]))
    assert len(seen) == 10 and 4 <= sum(seen) <= 6


def test_load_control_counts_when_asked() -> None:
    assert dx.solve_static(column(P=3.0), steps=3).stability is None
    s = dx.solve_static(column(P=3.0), steps=3, stability=True).stability
    assert s is not None and s.negative.tolist() == [0, 0, 0, 1] and not s.points


def test_a_length_a_stiffness_and_a_load_as_the_parameter() -> None:
    """Euler's column meets its load at P L²/EI = π²/4, whichever of them changes; with the stiffness nothing moves."""
    families: list[tuple[Callable[[float], dx.Model], Literal["forward", "backward"], float]] = [
        (lambda p: column(L=p, P=2.0), "forward", np.pi / 2 / np.sqrt(2.0)),
        (lambda p: column(EI=p, P=2.0), "backward", 8.0 / np.pi**2),
        (lambda p: column(P=p), "forward", np.pi**2 / 4),
    ]
    for make, direction, known in families:
        control = dx.ArcLength(ds=0.05, load_step=0.2, direction=direction, branch=1, max_steps=14)
        result = dx.continuation(make, 1.0, control=control)
        assert result.success and result.audit.passed and result.stability is not None
        assert result.stability.points[0].load_factor == pytest.approx(known, rel=5e-4)
        assert abs(result.node("b").displacement[-1, 2]) > 0.1 and result.stability.negative[-1] == 0


def test_a_family_has_one_mesh() -> None:
    def make(p: float) -> dx.Model:
        return column() if p < 1.05 else column().fix("b", "y")

    result = dx.continuation(make, 1.0, control=dx.ArcLength(ds=0.02, load_step=0.1, max_steps=4))
    assert result.status.code == "bad_input" and "supports" in result.status.sentence
    with pytest.raises(dx.ModelError, match="gives 3"):
        dx.continuation(lambda p: 3, 1.0, control=dx.ArcLength(ds=0.02))  # type: ignore[arg-type, return-value]


def test_what_cannot_be_read_or_asked_is_said() -> None:
    turned = column().fix("b", "y").moment("b", (0, 0, 0.01))
    result = dx.solve_static(turned, control=along(to=1.0))
    assert result.stability is None and "no potential" in result.info["stability"]
    cases = [
        (lambda: dx.solve_static(turned, control=along(to=1.0), stability=True), "no potential"),
        (lambda: dx.solve_static(column(), control=along(branch=1), stability=False), "branch= needs"),
        (lambda: dx.ArcLength(ds=0.1, branch=0), "no number of a bifurcation"),
        (lambda: dx.ArcLength(ds=0.1, load_step=-1.0), "load_step"),
        (lambda: dx.branches(column(), control=dx.DisplacementControl("b", "x", -0.1)), "does not follow"),  # type: ignore[arg-type]
        (lambda: dx.simulate(frame(0.0, True), 1.0, 1.0).plot.branches("C", "x"), "nobody looked"),
    ]
    for make, reason in cases:
        with pytest.raises(dx.ModelError, match=reason) as error:
            make()
        assert error.value.fix


def test_it_is_kept_drawn_and_written(tmp_path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    first, second, _ = dx.branches(column(), control=along(to=4.0), count=1)
    loaded = dx.load(second.save(tmp_path / "a.vtkhdf"))
    a, b = second.stability, loaded.stability
    assert a is not None and b is not None
    assert np.array_equal(a.negative, b.negative) and np.array_equal(a.critical, b.critical)
    assert [str(p) for p in a.points] == [str(p) for p in b.points]
    assert np.array_equal(a.points[0].modes, b.points[0].modes)
    axes = first.plot.branches("b", "z", [second])
    drawn = [(line.get_linestyle(), np.asarray(line.get_ydata(), float)) for line in axes.lines]
    styles = [(style, float(np.ptp(y))) for style, y in drawn if len(y) > 1]
    assert any(s == "-" and h > 2.0 for s, h in styles) and any(s != "-" and h > 1.0 for s, h in styles)
    import matplotlib.pyplot as plt

    plt.close("all")


def test_a_case_file_says_it_too(tmp_path: Path) -> None:
    from directrix.schema import load_case

    text = """
    title = "column"
    [section.s]
    kind = "properties"
    E = 1e4
    nu = 0
    A = 1.0
    I1 = 1e-4
    I2 = 1e-2
    J = 1e-2
    [[rod]]
    name = "rod"
    section = "s"
    line = [[0, 0, 0], [1, 0, 0]]
    ends = ["a", "b"]
    elements = 8
    [[support]]
    node = "a"
    type = "clamp"
    [[force]]
    node = "b"
    value = [-1, 0, 0]
    [statics]
    control = { kind = "arc-length", ds = 0.02, load_step = 1.0, branch = -1, max_load_factor = 2.6 }
    """
    path = tmp_path / "case.toml"
    path.write_text(text)
    case = load_case(path)
    control = case.control
    assert isinstance(control, dx.ArcLength) and control.branch == (-1,) and control.load_step == 1.0
    result = case.run()
    assert result.success and float(np.abs(result.node("b").displacement[-1]).max()) > 0.2
