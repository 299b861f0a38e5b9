"""Joints and nodes on no rod: what cannot be meant is refused in a sentence, and case files say what Python says."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import directrix as dx
from directrix.joints import KINDS
from directrix.schema import Case, json_schema, load_case
from directrix.schema.describe import describe
from directrix.schema.functions import Ramp, ScaledNumber, Sine, Table
from tests.test_hostile import NEVER

J = np.eye(3)


def bodies() -> dx.Model:
    return dx.Model().node("P", (1, 0, 0)).node("Q", (0, 0, 0)).rigid_body("P", 1.0, J).rigid_body("Q", 1.0, J)


def hinge(**options: Any) -> dx.Model:
    return bodies().hinge("P", "Q", **{"axis": (0, 0, 1), **options})


PLACES: dict[str, Callable[[Any], object]] = {
    "name": lambda w: hinge().spherical("P", name=w),
    "a": lambda w: bodies().spherical(w),
    "b": lambda w: bodies().spherical("P", w),
    "axis": lambda w: hinge(axis=w),
    "axes": lambda w: bodies().universal("P", "Q", axes=w),
    "second of axes": lambda w: bodies().universal("P", "Q", axes=((1, 0, 0), w)),
    "normal": lambda w: bodies().planar("P", "Q", normal=w),
    "at": lambda w: hinge(at=w),
    "at of planar": lambda w: bodies().planar("P", "Q", normal=(0, 0, 1), at=w),
    "stiffness": lambda w: hinge(stiffness=w),
    "rest": lambda w: hinge(stiffness=1.0, rest=w),
    "damping": lambda w: hinge(damping=w),
    "prescribed": lambda w: hinge(prescribed=w),
    "drive": lambda w: hinge(drive=w),
    "stops": lambda w: hinge(stops=w, stop_stiffness=1.0),
    "lower stop": lambda w: hinge(stops=(w, 2.0), stop_stiffness=1.0),
    "stop_stiffness": lambda w: hinge(stops=(-1, 1), stop_stiffness=w),
    "stop_width": lambda w: hinge(stops=(-1, 1), stop_stiffness=1.0, stop_width=w),
    "stop_stiffness without stops": lambda w: hinge(stop_stiffness=w),
    "stiffness of a ball": lambda w: bodies().spherical("P", "Q", stiffness=w),
    "drive of a ball": lambda w: bodies().spherical("P", "Q", drive=w),
    "name of a node": lambda w: bodies().node(w, (0, 0, 0)),
    "place of a node": lambda w: bodies().node("Z", w),
    "node of a body": lambda w: bodies().rigid_body(w, 1.0, J),
    "node of a body with offset": lambda w: bodies().rigid_body(w, 1.0, J, offset=(0, 0, 1)),
    "offset": lambda w: bodies().node("Z", (0, 0, 0)).rigid_body("Z", 1.0, J, offset=w),
}


@pytest.mark.parametrize("place", PLACES)
def test_no_argument_of_a_joint_gets_through_that_is_of_another_kind(place: str) -> None:
    for k, given in enumerate(NEVER):
        if place in ("prescribed", "drive") and callable(given):
            continue  # a function of time
        if "name" in place and isinstance(given, str):
            continue
        with pytest.raises(dx.ModelError) as error:
            made = PLACES[place](given)
            if place in ("a", "b", "node of a body"):
                made.check()  # a text may be the name of a node that comes later
            pytest.fail(f"{place} takes number {k}: a {type(given).__name__}")
        assert error.value.fix


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: hinge(axis=(0, 0, 0)), "has no direction"),
        (lambda: hinge(axis=(0, 0, 1e-300)), "has no direction"),
        (lambda: hinge(axis=(0, 0, 1e300)), "has no direction"),
        (lambda: bodies().universal("P", "Q", axes=((1, 0, 0), (0, 0, 0))), "has no direction"),
        (lambda: bodies().universal("P", "Q", axes=((1, 0, 0), (1, 1, 0))), "not perpendicular"),
        (lambda: bodies().spherical("P", "P"), "joins node 'P' to itself"),
        (lambda: bodies().spherical("P", "R").check(), "no node 'R' for the joint 'joint1'"),
        (lambda: hinge(name="x").spherical("P", name="x"), "two joints called 'x'"),
        (lambda: hinge(stifness=1.0), "there is no stifness="),
        (lambda: hinge(second=(1, 0, 0)), "two axes, others one"),
        (lambda: hinge(stiffness=-1.0), "stiffness = -1"),
        (lambda: hinge(rest=0.3), "rest = 0.3 is that of a spring"),
        (lambda: hinge(stops=(1, -1), stop_stiffness=1.0), "leave no room"),
        (lambda: hinge(stops=(-1, 1)), "stop_stiffness = 0"),
        (lambda: hinge(stops="ab", stop_stiffness=1.0), "stops = 'ab' are not two numbers"),
        (lambda: hinge(stop_width=1.0), "stop_width is that of stops"),
        (lambda: hinge(prescribed=0.0, stiffness=1.0), "stiffness would do nothing"),
        (lambda: hinge(prescribed=0.0, drive=lambda t: t), "drive would do nothing"),
        (lambda: bodies().spherical("P", "Q", drive=0.0), "no single coordinate that drive"),
        (lambda: bodies().spherical("P", "Q", rest=1.0, stiffness=1.0), "no single coordinate that rest"),
        (lambda: hinge(prescribed=lambda t: "x").check(), "prescribed of joint 'joint1' at t = 0 = 'x'"),
        (lambda: hinge(drive=lambda t: 1 / t).check(), "the function fails at t = 0"),
        (lambda: hinge(drive=lambda t: (0, 0, 1)).check(), "drive of joint 'joint1' at t = 0"),
        (lambda: bodies().rigid_body("R", 1.0, J, offset=(0, 0, 1)), "no node 'R' for the body"),
        (lambda: bodies().node("P", (0, 0, 0)), "two nodes called 'P'"),
    ],
)  # fmt: skip
def test_a_joint_that_cannot_be_is_refused(make: Callable[[], object], says: str) -> None:
    with pytest.raises(dx.ModelError, match=says) as error:
        make()
    assert error.value.fix


def mass(at: Any = (1, 0, 0)) -> dx.Model:
    return dx.Model().node("P", at).point_mass("P", 2.0).gravity((0, 0, -10.0))


def without_mass() -> dx.Model:
    return bodies().node("R", (2, 0, 0))


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: run(without_mass()), "nothing is attached to node 'R'"),
        (lambda: run(dx.Model().node("P", (0, 0, 0)).clamp("P")), "nothing in it can move"),
        (lambda: run(without_mass().spherical("P", "R")), "node 'R' has no mass"),
        (lambda: run(without_mass().spring("P", "R", 1.0)), "node 'R' has no mass"),
        # the turn about the line from the joint to the mass moves nothing
        (lambda: run(mass((3, 0, 4)).spherical("P", at=(0, 0, 0))), r"'P' has no rotary inertia about \(0.6, 0, 0.8\)"),
        (lambda: run(mass().moment("P", (0, 0, 1))), "node 'P' has no rotary inertia"),
        (lambda: dx.solve_static(mass()), "nothing is attached to node 'P', which can move"),
        (lambda: run(bodies().clamp("P").hinge("P", axis=(0, 0, 1))), "joint 'joint1': it holds what supports hold"),
        (lambda: run(hinge(at=(0.5, 0, 0)).velocity("P", (0, 0, 1))), "pull joint 'joint1' apart"),
        (lambda: run(hinge(prescribed=lambda t: 1.0 + t)), "joint 'joint1' is not together"),
        (lambda: run(hinge().rigid("P", "Q", name="again")), "joints 'joint1', 'again'"),
    ],
)  # fmt: skip
def test_a_motion_that_is_not_determined_is_refused(make: Callable[[], object], says: str) -> None:
    with pytest.raises(dx.ModelError, match=says) as error:
        make()
    assert error.value.fix


def run(model: dx.Model, t_end: float = 0.5) -> dx.Result:
    return dx.simulate(model, t_end, 0.05)


def test_a_point_mass_needs_no_rotation() -> None:
    """It falls by ½ g t², whatever its initial spin; on a spring it swings with its period."""
    fallen = run(mass().rigid_velocity(omega=(1, 2, 3), about=(1, 0, 0)))
    np.testing.assert_allclose(fallen.node("P").displacement[-1], [0, 0, -0.5 * 10 * 0.5**2], atol=1e-13)
    assert fallen.audit.passed
    period = 2.0 * np.pi * np.sqrt(2.0 / 50.0)
    model = dx.Model().node("P", (1, 0, 0)).point_mass("P", 2.0).spring("P", (0, 0, 0), 50.0, length=0.9)
    swung = dx.simulate(model, period, period / 200)
    u = swung.node("P").displacement[:, 0]
    assert u.min() == pytest.approx(-0.2, rel=1e-3) and abs(u[-1]) <= 1e-3
    assert swung.audit.passed


def test_a_node_without_mass_may_be_held_by_a_joint() -> None:
    """Rigidly on a body it changes nothing."""
    model = bodies().hinge("Q", axis=(0, 1, 0), at=(0, 0, 0)).rigid("P", "Q").gravity((0, 0, -10.0))
    more = run(model.node("R", (2, 0, 0)).rigid("P", "R"))
    np.testing.assert_allclose(more.node("P").r, run(model).node("P").r, atol=1e-12)


def test_a_body_that_a_hinge_on_the_ground_holds_has_an_equilibrium() -> None:
    """k φ = m g a cos φ, by the quadratic convergence of Newton's iteration."""
    k, weight = 20.0, 9.81
    model = dx.Model().node("P", (1, 0, 0)).rigid_body("P", 1.0, J).gravity((0, 0, -weight))
    result = dx.solve_static(model.hinge("P", axis=(0, 1, 0), at=(0, 0, 0), stiffness=k, name="pin"))
    angle = result.joint("pin").coordinate[-1]
    assert result.success and result.audit.passed
    assert k * angle == pytest.approx(weight * np.cos(angle), rel=1e-9)
    np.testing.assert_allclose(result.joint("pin").force[-1], [0, 0, weight], atol=1e-9)
    solved = np.isfinite(result.trail.rows[:, 2])  # the others met a pivot of zero, in the order of a chain
    assert solved.sum() <= 5 * len(result.iterations) and result.info["cuts"] == 0


def test_a_drive_pushes_the_coordinate_up_and_the_second_node_forward() -> None:
    """J φ̈ = M: ½ M/J t² of b against a held a, −½ M/J t² of a against a held b."""
    for free, sign in (("P", -1.0), ("Q", 1.0)):
        held = "Q" if free == "P" else "P"
        model = (
            bodies().clamp(held).hinge("P", "Q", axis=(0, 0, 1), at=(1, 0, 0) if free == "P" else (0, 0, 0), drive=0.4)
        )
        result = run(model)
        assert result.joint("joint1").coordinate[-1] == pytest.approx(0.05, rel=1e-3)
        assert result.node(free).R[-1, 1, 0] == pytest.approx(sign * np.sin(0.05), rel=1e-3)
        np.testing.assert_allclose(result.joint("joint1").moment[-1], [0, 0, 0.4], atol=1e-5)


def test_nothing_moves_and_the_books_say_so() -> None:
    assert run(bodies().spring("P", "Q", 1.0, offset_b=(0, 0, 0))).audit.passed


# --- case files

HEAD = """
[[node]]
name = "P"
at = [1, 0, 0]
[[node]]
name = "Q"
at = [0, 0, 0]
[[rigid_body]]
node = "P"
mass = 1
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
[[rigid_body]]
node = "Q"
mass = 1
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
"""
TAIL = "[dynamics]\nt_end = 0.2\ndt = 0.05\n"
ALL = (
    HEAD
    + """
[[rigid_body]]
node = "P"
mass = 2
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
offset = [0, 1, 0]
[[joint]]
kind = "hinge"
name = "motor"
a = "P"
b = "Q"
axis = [0, 0, 1]
at = [0.5, 0, 0]
stiffness = 2
rest = 0.1
damping = 0.3
drive = 4
time = { kind = "sine", frequency = 2 }
stops = [-1, 1.5]
stop_stiffness = 100
stop_width = 0.01
[[joint]]
kind = "cylindrical"
a = "P"
b = "Q"
axis = [1, 0, 0]
prescribed = { t = [0, 1], value = [0, 2] }
[[joint]]
kind = "slider"
a = "P"
axis = [1, 0, 0]
prescribed = 2
time = { kind = "ramp", until = 3 }
[[joint]]
kind = "universal"
a = "P"
axes = [[1, 0, 0], [0, 1, 0]]
[[joint]]
kind = "spherical"
a = "Q"
damping = 0.5
[[joint]]
kind = "planar"
a = "Q"
normal = [0, 1, 0]
[[joint]]
kind = "rigid"
a = "P"
b = "Q"
"""
)


def case_of(tmp_path: Path, text: str, name: str = "case.toml") -> Case:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return load_case(path)


def test_every_joint_of_a_file_is_that_of_python(tmp_path: Path) -> None:
    case = case_of(tmp_path, ALL + TAIL)
    expected = (
        bodies()
        .rigid_body("P", 2.0, J, offset=(0, 1, 0))
        .hinge(
            "P", "Q", axis=(0, 0, 1), name="motor", at=(0.5, 0, 0), stiffness=2.0, rest=0.1, damping=0.3,
            drive=ScaledNumber(4.0, Sine(frequency=2.0)), stops=(-1, 1.5), stop_stiffness=100.0, stop_width=0.01,
        )
        .cylindrical("P", "Q", axis=(1, 0, 0), prescribed=Table(t=(0, 1), value=(0, 2)))
        .slider("P", axis=(1, 0, 0), prescribed=ScaledNumber(2.0, Ramp(until=3.0)))
        .universal("P", axes=((1, 0, 0), (0, 1, 0)))
        .spherical("Q", damping=0.5)
        .planar("Q", normal=(0, 1, 0))
        .rigid("P", "Q")
    )  # fmt: skip
    assert case.model.joints == expected.joints and case.model.nodes == expected.nodes
    assert {joint.kind for joint in case.model.joints} == set(KINDS)
    motor, moved = case.model.joints[1], case.model.joints[3]
    assert motor.drive(0.125) == pytest.approx(4.0) and moved.prescribed(1.5) == 1.0
    assert case.model.joints[2].prescribed(0.5) == 1.0
    again = case_of(tmp_path, json.dumps(tomllib.loads(ALL + TAIL)), "case.json")
    assert again.model.joints == case.model.joints
    said = describe(case)
    for line in (
        "hinge motor: P – Q, at (0.5, 0, 0), leaves free: turning about (0, 0, 1)",
        "stiffness 2 from 0.1 on, damping 0.3, drive 4 × sine(",
        "stops at -1 and 1.5 of stiffness 100",
        "slider joint4: P – ground, at (1, 0, 0), leaves free: sliding along (1, 0, 0)",
        "rigid P.body: P – P.body, at (1, 1, 0), leaves free: nothing",
        "0 rods, 0 elements, 3 nodes, 18 unknowns and 38 multipliers of joints",
    ):
        assert line in said


def test_a_case_of_bodies_runs_and_its_joints_survive(tmp_path: Path) -> None:
    text = HEAD.replace("mass = 1", "mass = 3", 1)
    text += '[[joint]]\nkind = "hinge"\nname = "pin"\na = "Q"\naxis = [0, 1, 0]\nat = [-1, 0, 0]\n'
    text += '[[joint]]\nkind = "rigid"\na = "Q"\nb = "P"\n[gravity]\nvalue = [0, 0, -9.81]\n'
    result = case_of(tmp_path, text + TAIL).run()
    assert result.success and result.audit.passed and abs(result.joint("pin").coordinate[-1]) > 0.01
    loaded = dx.load(result.save(tmp_path / "pin.vtkhdf"))
    assert loaded.mesh.joints == result.mesh.joints == ("pin", "joint2")
    np.testing.assert_array_equal(loaded.joints, result.joints)
    for name in ("force", "moment", "coordinate"):
        np.testing.assert_array_equal(getattr(loaded.joint("pin"), name), getattr(result.joint("pin"), name))
    static = case_of(tmp_path, text.replace("at = [-1", "stiffness = 90\nat = [-1") + "[statics]\nsteps = 2\n").run()
    assert static.success and static.audit.passed


def test_the_schema_knows_every_kind_of_joint() -> None:
    kinds = json_schema()["properties"]["joint"]["items"]["discriminator"]["mapping"]
    assert set(kinds) == set(KINDS)
    assert json_schema()["$defs"]["Hinge"]["properties"]["axis"]["description"]
