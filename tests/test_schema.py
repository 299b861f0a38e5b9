"""Case files: what they describe, where their mistakes are found, and the functions of time."""

from __future__ import annotations

import dataclasses
import json
import pickle
import re
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from directrix.errors import InputError
from directrix.functions import harmonic
from directrix.schema import Case, json_schema, load_case
from directrix.schema.functions import Pulse, Ramp, Rotated, Scaled, Sine, Table, VectorTable
from directrix.schema.models import Dynamics, Statics
from directrix.schema.places import json_places, toml_places

CASES = sorted(Path(str(f)) for f in files("directrix.cases").iterdir() if f.name.endswith(".toml"))
BAD = sorted((Path(__file__).parent / "bad_cases").glob("*.toml"))

CANTILEVER = """
[section.bar]
kind = "properties"
E = 2e9
nu = 0.25
A = 2e-4
I1 = 3e-9
I2 = 4e-9
J = 5e-9
rho = 1000
[[rod]]
name = "arm"
section = "bar"
line = [[0, 0, 0], [2, 0, 0]]
ends = ["root", "tip"]
elements = 4
[[support]]
node = "root"
type = "clamp"
"""


def case_of(tmp_path: Path, text: str) -> Case:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    return load_case(path)


# --- good files


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.stem)
def test_every_example_can_be_run(path: Path) -> None:
    case = load_case(path)
    data = tomllib.loads(path.read_text("utf-8"))
    assert case.title == data["title"] == case.model.name
    assert [rod.name for rod in case.model.rods] == [rod["name"] for rod in data["rod"]]
    assert case.check().elements == sum(rod["elements"] for rod in data["rod"])
    assert isinstance(case.analysis, Dynamics if "dynamics" in data else Statics)


def test_free_flight_is_the_example_of_the_paper() -> None:
    case = load_case(next(p for p in CASES if p.stem == "free_flight"))
    section = case.model.rods[0].section
    shear = 5e5 / 2.6
    np.testing.assert_allclose(
        np.diag(section.stiffness), [shear * 0.005] * 2 + [2500, 10, 10, shear * 4e-5], rtol=1e-14
    )
    np.testing.assert_allclose([section.A_rho, *np.diag(section.I_rho)], [2.5, 0.01, 0.01], rtol=1e-14)
    assert isinstance(case.analysis, Dynamics)
    assert (case.analysis.t_end, case.analysis.dt, case.analysis.integrator) == (30.0, 0.2, "energy-momentum")
    assert case.model.rods[2].points in (None, 1) and case.model.rods[2].order == 1


def test_a_case_is_frozen_and_knows_its_file(tmp_path: Path) -> None:
    case = case_of(tmp_path, CANTILEVER + "[statics]\n")
    assert (case.title, case.source) == ("case", tmp_path / "case.toml")
    assert re.fullmatch("[0-9a-f]{64}", case.sha256)
    assert case_of(tmp_path, CANTILEVER + "[statics]\n# other\n").sha256 != case.sha256
    with pytest.raises(dataclasses.FrozenInstanceError):
        case.title = "x"  # type: ignore[misc]
    with pytest.raises(ValidationError):
        case.analysis.tolerance = 0.5


def test_json_and_toml_say_the_same(tmp_path: Path) -> None:
    text = CANTILEVER + "[[force]]\nnode = 'tip'\nvalue = [0, 0, 1]\n[dynamics]\nt_end = 1\ndt = 0.1\n"
    one = case_of(tmp_path, text)
    other = tmp_path / "case.json"
    other.write_text(json.dumps(tomllib.loads(text)))
    two = load_case(other)
    assert (two.title, two.analysis, two.model.loads, two.model.supports) == (
        one.title, one.analysis, one.model.loads, one.model.supports,
    )  # fmt: skip
    np.testing.assert_array_equal(two.model.rods[0].section.stiffness, one.model.rods[0].section.stiffness)


def test_second_moments_belong_to_the_axes_they_bend_about(tmp_path: Path) -> None:
    by_properties = case_of(tmp_path, CANTILEVER + "[statics]\n").model.rods[0].section
    moduli = (
        'kind = "moduli"\nEA = 4e5\nGA1 = 1.6e5\nGA2 = 1.6e5\nEI1 = 6\nEI2 = 8\nGJ = 4\n'
        "A_rho = 0.2\nI_rho1 = 4e-6\nI_rho2 = 3e-6\n"
    )
    text = re.sub(r'kind = "properties".*?(?=\[\[rod)', moduli, CANTILEVER, flags=re.DOTALL)
    by_moduli = case_of(tmp_path, text + "[statics]\n").model.rods[0].section
    np.testing.assert_allclose(by_moduli.stiffness, by_properties.stiffness, rtol=1e-14)
    np.testing.assert_allclose(by_moduli.I_rho, by_properties.I_rho, rtol=1e-14)
    assert by_moduli.A_rho == by_properties.A_rho


def test_every_kind_of_section_and_curve(tmp_path: Path) -> None:
    material = "E = 2e9\nnu = 0.3\nrho = 10\n"
    row = [[float(i == j) * 1e3 for j in range(6)] for i in range(6)]
    sections = {
        "circle": f'kind = "circle"\nradius = 0.1\n{material}',
        "rectangle": f'kind = "rectangle"\nwidth = 0.1\nheight = 0.2\nshear_factor = 0.8\n{material}',
        "tube": f'kind = "tube"\nouter = 0.1\nwall = 0.01\ntorsion_constant = 1e-4\n{material}',
        "matrix": f'kind = "matrix"\norder = "axial-first"\nstiffness = {row}\nI_rho = [[1, 0], [0, 2]]\n',
    }
    curves = {
        "circle": "arc = { start = [0, 0, 0], through = [1, 1, 0], end = [2, 0, 0] }",
        "rectangle": "polyline = [[0, 0, 0], [1, 1, 0], [2, 0, 0]]\nd1 = [0, 0, 1]",
        "tube": 'spline = [[0, 0, 0], [1, 1, 0], [2, 0, 0]]\ndirectors = "chord"',
        "matrix": "helix = { radius = 1, origin = [0, 0, 1], pitch = 0.3, turns = -2 }",
    }
    text = "".join(f"[section.{k}]\n{v}" for k, v in sections.items())
    text += "".join(f'[[rod]]\nname = "{k}"\nsection = "{k}"\nelements = 4\n{v}\n' for k, v in curves.items())
    text += "".join(f'[[support]]\nnode = "{k}.start"\ntype = "clamp"\n' for k in curves)
    model = case_of(tmp_path, text + "[statics]\n").model
    length = {rod.name: rod.curve.length for rod in model.rods}
    assert length["circle"] == pytest.approx(np.pi)
    assert length["rectangle"] == pytest.approx(2 * np.sqrt(2))
    assert length["matrix"] == pytest.approx(2 * np.hypot(2 * np.pi, 0.3))
    stiffness = {rod.name: rod.section.stiffness for rod in model.rods}
    np.testing.assert_allclose(stiffness["matrix"], 1e3 * np.eye(6))
    shear = 2e9 / 2.6
    assert stiffness["rectangle"][0, 0] == pytest.approx(0.8 * shear * 0.02)
    assert stiffness["tube"][5, 5] == pytest.approx(shear * 1e-4)


def test_loads_supports_and_motion_arrive_in_the_model(tmp_path: Path) -> None:
    text = (
        CANTILEVER.replace("elements = 4", "elements = 4\nnodes = { P = 0.25 }")
        + """
[[support]]
node = "P"
dofs = ["x", "z"]
[[prescribe]]
node = "tip"
displacement = { t = [0, 1], value = [[0, 0, 0], [0, 0, 2]] }
rotation = [0, 1, 0]
time = { kind = "ramp", until = 2 }
[[force]]
node = "P"
value = [1, 2, 3]
constant = true
time = { kind = "sine", frequency = 2 }
[[moment]]
node = "P"
value = [4, 5, 6]
[[distributed]]
rod = "arm"
value = [0, 0, -1]
[gravity]
value = [0, 0, -9.81]
[[velocity]]
node = "P"
v = [0, 1, 0]
omega = [0, 0, 3]
[rigid_velocity]
v = [0, 1, 0]
about = [1, 1, 1]
[dynamics]
t_end = 1
dt = 0.1
"""
    )
    model = case_of(tmp_path, text).model
    assert model.supports[1].dofs == ("x", "z")
    assert [type(load).__name__ for load in model.loads] == ["Force", "Moment", "Distributed", "Gravity"]
    force = model.loads[0]
    assert force.constant and force.value == harmonic((1.0, 2.0, 3.0), 2.0)
    assert model.loads[1].value == (4.0, 5.0, 6.0) and not model.loads[1].constant
    moved = model.prescribed[0]
    assert callable(moved.displacement) and callable(moved.rotation)
    np.testing.assert_allclose(moved.displacement(0.25), [0, 0, 0.5])
    np.testing.assert_allclose(moved.rotation(0.5), [0, 0.25, 0])
    assert (model.velocities[0].omega, model.velocities[1].about) == ((0.0, 0.0, 3.0), (1.0, 1.0, 1.0))


def test_a_turn_carries_its_node_along(tmp_path: Path) -> None:
    text = CANTILEVER.replace('[[support]]\nnode = "root"\ntype = "clamp"\n', "")
    for node in ("root", "tip"):
        text += f'[[prescribe]]\nnode = "{node}"\ndisplacement = [0, 0.5, 0]\n'
        text += "turn = { axis = [0, 0, 2], degrees = 90, about = [2, 0, 0] }\n"
    root, tip = case_of(tmp_path, text + "[statics]\n").model.prescribed
    # half way: moved by (0, ¼, 0), then turned by 45° about (2, 0, 0)
    c = np.sqrt(0.5)
    assert callable(root.displacement) and callable(root.rotation) and callable(tip.displacement)
    np.testing.assert_allclose(root.displacement(0.5), [2 - 2 * c - 0.25 * c, -2 * c + 0.25 * c, 0], atol=1e-15)
    np.testing.assert_allclose(tip.displacement(0.5), [-0.25 * c, 0.25 * c, 0], atol=1e-15)
    np.testing.assert_allclose(root.rotation(0.5), [0, 0, np.pi / 4], rtol=1e-15)


# --- wrong files


@pytest.mark.parametrize("path", BAD, ids=lambda p: p.stem)
def test_a_wrong_file_is_refused_at_its_place(path: Path) -> None:
    expected = dict(re.findall(r"^# (place|says|fix): (.+)$", path.read_text("utf-8"), re.MULTILINE))
    assert set(expected) == {"place", "says", "fix"}
    with pytest.raises(InputError) as caught:
        load_case(path)
    message = str(caught.value)
    assert caught.value.where == f"{path}:{expected['place']}"
    assert message.startswith(caught.value.where + ": ")
    assert expected["says"] in message
    assert "\n  fix: " in message and expected["fix"] in message.split("\n  fix: ")[1]


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("none.toml", None, "no such file"),
        ("folder.toml", "folder", "a folder, not a case file"),
        ("case.txt", b"", "not a case file"),
        ("latin.toml", b'title = "ok"\nx = "\xe9"\n', "latin.toml:2:6: is not UTF-8"),
        ("empty.toml", b"# later\n", "empty.toml:1:1: the case is empty"),
        ("empty.json", b"", "empty.json:1:1: the case is empty"),
        ("empty.json", b"{ }", "empty.json:1:1: the case is empty"),
        (
            "long.toml",
            b"[[rod]]\norder = " + b"9" * 25,
            "long.toml:2:1: rod[#1].order: is 9999999999999999999999999, but",
        ),
        ("list.json", b"[1, 2]", "the top of the file is not a table"),
        ("broken.json", b'{\n "title": "x",\n}', "broken.json:3:1: not valid JSON"),
        ("twice.json", b'{"title": "x", "title": "y"}', "the key 'title' is given twice"),
        ("nan.json", b'{\n"output": {\n"save_every": NaN}}', "nan.json:3:1: output.save_every: is nan"),
        ("deep.json", b"[" * 100_000, "nested too deeply"),
        ("digits.toml", b"x = " + b"9" * 5000, "thousands of digits"),
        (
            "huge.toml",
            b"[output]\nsave_every = 0x" + b"f" * 9000,
            "huge.toml:2:1: output.save_every: is a huge number",
        ),
    ],
)
def test_a_file_that_is_no_case(tmp_path: Path, name: str, content: bytes | str | None, says: str) -> None:
    path = tmp_path / name
    if content == "folder":
        path.mkdir()
    elif isinstance(content, bytes):
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert says in str(caught.value) and caught.value.fix
    assert len(str(caught.value)) < 2000


def test_windows_line_ends_and_a_byte_order_mark_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    text = CANTILEVER + "[statics]\nsteps = 0\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    with pytest.raises(InputError, match=f"case.toml:{text.count(chr(10))}:1: statics.steps: is 0"):
        load_case(path)


# --- where a key stands


def paths_of(value: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from paths_of(item, (*path, key))


TRAPS = """# [not.a.table] x = 1
title = "a # b ] } = [x]" # = y
text = \"\"\"
[no] key = "1"
\\"\"\" x = [
ends with two quotes \"\"\"\"\"
raw = '''
x = {'''

[a."b.c".'d']  # comment
"k\\u0041" = 1
e.f . g = [ # numbers
  1, [2,
  3], # ]
  { h = 'x]', i.j = [4] },
]
when = 1979-05-27 07:32:00
inf = -inf

[[ many ]]
x = 1
[[many]]
y = {}
[many.sub]
z = 2
[[many.list]]
w = [
]
[[many.list]]
"""

LINES = {
    ("title",): 2, ("text",): 3, ("raw",): 7, ("a", "b.c", "d"): 10, ("a", "b.c", "d", "kA"): 11,
    ("a", "b.c", "d", "e", "f", "g"): 12, ("a", "b.c", "d", "e", "f", "g", 1): 13,
    ("a", "b.c", "d", "e", "f", "g", 1, 1): 14, ("a", "b.c", "d", "e", "f", "g", 2, "i", "j", 0): 15,
    ("a", "b.c", "d", "when"): 17, ("a", "b.c", "d", "inf"): 18, ("many",): 20, ("many", 0): 20,
    ("many", 0, "x"): 21, ("many", 1): 22, ("many", 1, "y"): 23, ("many", 1, "sub"): 24,
    ("many", 1, "sub", "z"): 25, ("many", 1, "list", 0, "w"): 27, ("many", 1, "list", 1): 29,
}  # fmt: skip


def test_lines_of_a_file_full_of_traps() -> None:
    places = toml_places(TRAPS)
    assert set(places) == set(paths_of(tomllib.loads(TRAPS)))
    assert {path: places[path].line for path in LINES} == LINES


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.stem)
def test_lines_of_the_examples(path: Path) -> None:
    text = path.read_text("utf-8")
    lines = text.split("\n")
    places = toml_places(text)
    assert set(places) == set(paths_of(tomllib.loads(text)))
    for keys, (line, column) in places.items():
        if keys and isinstance(keys[-1], str):
            assert keys[-1] in lines[line - 1][column - 1 :]
            assert column == 1 or lines[line - 1][column - 2] in " .[{,"


names = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=8)
values = st.recursive(
    st.integers(-99, 99) | st.booleans() | names,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(names, inner, max_size=4),
    max_leaves=20,
)


def toml_text(value: Any) -> str:
    """A value as TOML, lists over several lines with comments that look like syntax."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{toml_text(k)} = {toml_text(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[ # ] {\n" + "".join(f"  {toml_text(v)}, # [[x]]\n" for v in value) + "]"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


@given(st.lists(st.dictionaries(names, values, max_size=3), min_size=1, max_size=3), st.integers(0, 3))
def test_every_key_of_any_toml_is_found_on_its_line(tables: list[dict[str, Any]], gap: int) -> None:
    text, expected = "", {}
    for n, table in enumerate(tables):
        text += "\n" * gap + "[[t]] # x = 1\n"
        expected[("t", n)] = text.count("\n")
        for key, value in table.items():
            expected[("t", n, key)] = text.count("\n") + 1
            text += f"{toml_text(key)} = {toml_text(value)}\n"
    places = toml_places(text)
    assert set(places) == set(paths_of(tomllib.loads(text)))
    assert {path: places[path].line for path in expected} == expected


@given(values, st.sampled_from([None, 1]))
def test_every_key_of_any_json_is_found(value: Any, indent: int | None) -> None:
    data = {"top": value}
    text = json.dumps(data, indent=indent)
    places = json_places(text)
    assert set(places) == set(paths_of(data))
    lines = text.split("\n")
    for keys, (line, column) in places.items():
        if keys and isinstance(keys[-1], str):
            assert lines[line - 1].startswith(json.dumps(keys[-1]) + ":", column - 1)


# --- functions of time


def test_functions_are_values() -> None:
    for one, other in (
        (Table(t=(0, 1), value=(0, 2)), Table(t=(0, 1), value=(0, 3))),
        (Ramp(until=2), Ramp(until=3)),
        (Sine(frequency=1), Sine(frequency=1, phase=1)),
        (Pulse(end=1), Pulse(end=1, shape="rectangle")),
        (
            VectorTable(t=(0, 1), value=((0, 0, 0), (1, 2, 3))),
            VectorTable(t=(0, 1), value=((0, 0, 0), (1, 2, 4))),
        ),
        (Scaled((1, 2, 3), Ramp(until=1)), Scaled((1, 2, 3), Ramp(until=2))),
    ):
        again = pickle.loads(pickle.dumps(one))
        assert again == one and repr(again) == repr(one) and one != other
        np.testing.assert_array_equal(again(0.3), one(0.3))


def test_functions_have_the_values_of_their_formulas() -> None:
    table = Table(t=(1, 2, 4), value=(10, 20, 0))
    assert [table(t) for t in (0, 1, 1.5, 3, 4, 9)] == [10, 10, 15, 10, 0, 0]
    ramp = Ramp(start=1, until=3)
    assert [ramp(t) for t in (0, 1, 2, 3, 4)] == [0, 0, 0.5, 1, 1]
    sine = Sine(frequency=0.5, amplitude=2, phase=np.pi / 2, mean=1)
    np.testing.assert_allclose([sine(t) for t in (0, 0.5, 1)], [3, 1, -1], atol=1e-15)
    vectors = VectorTable(t=(0, 2), value=((0, 0, 0), (1, 2, 3)))
    np.testing.assert_allclose(vectors(1), [0.5, 1, 1.5])


def test_pulses() -> None:
    triangle = Pulse(start=1, end=5, peak=2)
    assert [triangle(t) for t in (0.9, 1, 1.5, 2, 3.5, 5, 5.1)] == [0, 0, 0.5, 1, 0.5, 0, 0]
    assert [Pulse(end=4)(t) for t in (1, 2, 3)] == [0.5, 1, 0.5]
    ends_at_once = Pulse(peak=6, end=6)  # Example 6 of the paper
    assert [ends_at_once(t) for t in (0, 3, 6, 6 + 1e-12, 6.001)] == [0, 0.5, 1, 1, 0]
    starts_at_once = Pulse(peak=0, end=2)
    assert [starts_at_once(t) for t in (-0.1, 0, 1, 2)] == [0, 1, 0.5, 0]
    assert [Pulse(start=1, end=2, shape="rectangle")(t) for t in (0.9, 1, 1.5, 2, 2.1)] == [0, 1, 1, 1, 0]
    np.testing.assert_allclose([Pulse(end=3, shape="half-sine")(t) for t in (0.5, 1.5, 4)], [0.5, 1, 0])


@given(
    st.floats(-2, 2),
    st.floats(0.1, 5),
    st.floats(0, 1),
    st.sampled_from(["triangle", "half-sine", "rectangle"]),
    st.floats(-9, 9),
)
def test_a_pulse_stays_between_zero_and_one(start: float, span: float, at: float, shape: Any, t: float) -> None:
    peak = min(start + span, start + at * span) if shape == "triangle" else None
    pulse = Pulse(start=start, end=start + span, peak=peak, shape=shape)
    assert 0.0 <= pulse(t) <= 1.0
    if not start - 1e-6 <= t <= start + span + 1e-6:
        assert pulse(t) == 0.0


vectors = st.tuples(*[st.floats(-3, 3)] * 3)


@given(vectors, vectors, vectors, st.floats(0, 1))
def test_a_turned_point_keeps_its_distance(position: Any, about: Any, turn: Any, t: float) -> None:
    moved = Rotated(position, about, Scaled(turn, Ramp(until=1)))(t) + position
    arm, turned = np.subtract(position, about), moved - about
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(arm), abs=1e-12)
    axis = np.array(turn)
    assert turned @ axis == pytest.approx(arm @ axis, abs=1e-11)
    # the cosine between the parts normal to the axis is that of the angle
    angle = np.linalg.norm(axis) * t
    if angle > 1e-3:
        unit = axis / np.linalg.norm(axis)
        a, b = (v - (v @ unit) * unit for v in (arm, turned))
        assert a @ b == pytest.approx(a @ a * np.cos(angle), abs=1e-11)
        assert np.cross(a, b) @ unit == pytest.approx(a @ a * np.sin(angle), abs=1e-11)


# --- the schema for editors


def test_the_json_schema_explains_every_key() -> None:
    schema = json_schema()
    json.dumps(schema)
    assert {"section", "rod", "statics", "dynamics"} <= set(schema["properties"])
    assert schema["additionalProperties"] is False
    assert schema["$defs"]["Rod"]["properties"]["d1"]["description"]
    assert schema["$defs"]["Dynamics"]["properties"]["dt"]["description"]
