"""What is wrong with a model is said by name, and what is sound raises no alarm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from faulty_models import FAULTY, SECTION
from sound_models import sound
from typer.testing import CliRunner

import directrix as dx
from directrix.cli import app
from directrix.discretisation import discretise
from directrix.failures import nearest_mode
from directrix.motions import Part, free_motions
from directrix.newton import Newton, Settings
from directrix.result import Mesh
from directrix.state import initial_state
from directrix.statics import static_scheme


@pytest.mark.parametrize(("make", "names"), [c[1:] for c in FAULTY], ids=[c[0] for c in FAULTY])
def test_a_fault_is_named(make: Callable[[], object], names: tuple[str, ...]) -> None:
    try:
        said = str(make())
    except dx.ModelError as error:
        assert error.fix
        said = str(error)
    assert [name for name in names if name not in said] == [], said


def test_there_are_enough_faults() -> None:
    assert len(FAULTY) >= 60 and len({name for name, *_ in FAULTY}) == len(FAULTY)


def test_what_is_sound_raises_no_alarm() -> None:
    alarms: dict[int, str] = {}
    for seed in range(300):
        try:
            found = sound(seed).check(static=True)
        except dx.ModelError as error:
            found = (error,)
        if found:
            alarms[seed] = "; ".join(map(str, found))
    assert alarms == {}


@pytest.mark.parametrize("seed", range(11))
def test_what_was_sound_is_not_when_what_holds_it_is_taken_away(seed: int) -> None:
    """Each kind of sound model, with nothing left of its supports and links to the ground."""
    model = sound(seed)
    links, joints = (k for k in model.links if isinstance(k.b, str)), (j for j in model.joints if j.b is not None)
    loose = replace(model, supports=(), prescribed=(), links=tuple(links), joints=tuple(joints))
    with pytest.raises(dx.ModelError, match="can move freely") as error:
        loose.check(static=True)
    assert repr(model.rods[0].name) in str(error.value) and error.value.fix


@pytest.mark.parametrize("left_out", ["", "joint20"])
def test_many_parts_are_one_system(left_out: str) -> None:
    """A chain of forty bars on hinges with springs, held at one end; without one of the joints the rest is loose."""
    model = dx.Model()
    for k in range(40):
        axis = dx.line((k, 0, 0), (k + 0.8, 0, 0))
        model = model.rod(axis, SECTION, name=f"bar{k}", ends=(f"a{k}", f"b{k}"), elements=1, order=1)
        if k:
            model = model.hinge(f"b{k - 1}", f"a{k}", axis=(0, 1, 0), name=f"joint{k}", stiffness=1.0)
    model = model.spring("a0", (0, 0, 1), 1.0).spring("a0", (0, 1, 0), 1.0).spring("a0", (-1, 0, 0), 1.0)
    model = model.spring("b39", (39.8, 0, 1), 1.0).spring("b39", (39.8, 1, 0), 1.0)
    model = model.spring("b39", (39.8, 1, 0), 1.0, offset_a=(0, 0, 0.5))
    model = replace(model, joints=tuple(j for j in model.joints if j.name != left_out))
    if not left_out:
        assert model.check(static=True) == ()
        return
    with pytest.raises(dx.ModelError, match="'bar0'") as error:
        model.check(static=True)
    assert "'bar20'" in str(error.value)


def test_each_link_of_a_body_on_six_is_needed() -> None:
    model = sound(7)
    assert len(model.links) == 6 and not model.supports
    for left_out in model.links:
        with pytest.raises(dx.ModelError, match="rod 'bar' can move freely"):
            replace(model, links=tuple(k for k in model.links if k is not left_out)).check(static=True)


def pendulum(*held: str) -> dx.Model:
    rod = dx.Model().rod(dx.line((0, 0, 0), (0, 0, -1)), SECTION, name="bob", ends=("a", "b"), elements=4)
    return rod.fix("a", "x", "y", "z", *held).gravity((0, 0, -9.8))


@pytest.mark.parametrize("held", [(), ("rx", "rz")])
def test_what_hangs_is_noted_and_computed(held: tuple[str, ...]) -> None:
    model = pendulum(*held)
    (found,) = model.check(static=True)
    assert (found.code, found.error) == ("loads_hold", False)
    result = dx.solve_static(model)
    assert result.success and "Note: rod 'bob' is held by nothing but the tension" in result.status.sentence
    again = dx.solve_static(model.force("b", (0, 0, -1), constant=True), start=result)
    assert again.success
    # about the axis nothing turns it back, about y the weight does
    assert ("Note" in again.status.sentence) == (not held)


def test_a_push_that_the_weight_withstands_is_no_fault() -> None:
    assert [f.code for f in pendulum("rx", "rz").force("b", (0.5, 0, 0)).check(static=True)] == ["loads_hold"]
    with pytest.raises(dx.ModelError, match="push it"):
        pendulum("rx", "rz").force("b", (50.0, 0, 0)).check(static=True)


def test_loads_that_a_user_function_does_not_give_leave_the_motion_named() -> None:
    def force(t: float) -> tuple[float, float, float]:
        return (0.0, 0.0, 1.0 / (t - 1.0))

    with pytest.raises(dx.ModelError, match="rod 'bob' can move freely: rotation about every axis"):
        pendulum().force("b", force).check(static=True)


def test_prescribed_motion_that_tightens_holds_too() -> None:
    """A bar on a slider, whose transverse motion only the tension of a stretched spring resists."""
    model = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), SECTION, name="bar", ends=("a", "b"), elements=2)
    model = model.rod(dx.line((2, 0, 0), (3, 0, 0)), SECTION, name="anchor", ends=("c", "d"), elements=2)
    model = model.fix("a", "x", "y", "rx", "ry", "rz").spring("b", "c", 10.0).clamp("d")
    with pytest.raises(dx.ModelError, match="rod 'bar' can move freely: translation along z"):
        model.check(static=True)
    pulled = replace(model, supports=model.supports[:1]).prescribe("d", displacement=(0.1, 0, 0), rotation=(0, 0, 0))
    assert [f.code for f in pulled.check(static=True)] == ["loads_hold"]


def test_a_screw_is_described_as_one() -> None:
    part = Part(("rod",), np.arange(2), np.array([[0.0, 0, 0], [0, 0, 1.0]]), np.array([0, 0, 0.5]), 1.0)
    mesh = Mesh((), {"a": 0, "b": 1}, part.r)
    lead = 0.25
    w = np.array([0, 0, 1.0])
    t = lead / (2.0 * np.pi) * w + np.cross(w, part.centre - (1.0, 0, 0))
    words = free_motions(part, np.concatenate([t, w])[:, None], mesh)
    assert words == "a screw about z through (1, 0, 0.5), 0.25 a turn"


def test_the_nearest_mode_of_a_column_is_its_buckling() -> None:
    """Under half its Euler load the softest mode has about half its stiffness left; it bends about the weaker axis."""
    weak = dx.Section.from_moduli(EA=1e5, GA1=1e5, GA2=1e5, EI1=1.0, EI2=2.0, GJ=5.0)
    column = dx.Model().rod(
        dx.line((0, 0, 0), (0, 0, 1), d1=(1, 0, 0)), weak, name="column", ends=("a", "b"), elements=8
    )
    euler = np.pi**2 / 4.0
    result = dx.solve_static(column.clamp("a").force("b", (0, 0, -0.5 * euler)), steps=1)
    scheme = static_scheme(column, None)
    disc = discretise(column.clamp("a"), scheme)
    found = nearest_mode(Newton(disc, scheme, Settings()), initial_state(disc, result, scheme))
    assert found is not None and found.share == pytest.approx(0.5, rel=0.03)
    top = found.shape[disc.mesh.node("b")]
    assert abs(top[1]) == pytest.approx(1.0) and abs(top[0]) <= 1e-6


def test_check_prints_the_findings(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    text = (
        'title = "Bob"\n[section.bar]\nkind = "circle"\nradius = 0.01\nE = 2e9\nnu = 0.3\nrho = 1000\n'
        '[[rod]]\nname = "bob"\nsection = "bar"\nline = [[0, 0, 0], [0, 0, -1]]\nends = ["a", "b"]\nelements = 2\n'
        '[[support]]\nnode = "a"\ntype = "pin"\n[gravity]\nvalue = [0, 0, -9.81]\n[statics]\nsteps = 2\n'
    )
    file.write_text(text, "utf-8")
    good = CliRunner().invoke(app, ["check", str(file)])
    assert good.exit_code == 0 and "findings\n  rod 'bob' is held by nothing but the tension" in good.output
    file.write_text(text.replace("-9.81", "9.81"), "utf-8")
    bad = CliRunner().invoke(app, ["check", str(file)])
    assert bad.exit_code == 2
    assert (
        "case.toml:12:9: rod[bob]" in bad.output
        and "rod 'bob' can move freely: rotation about every axis" in bad.output
    )
