"""Around a case file: templates, conversion, units, versions, warnings, all mistakes at once, help that runs."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from fuzzing import SEEDS
from typer.testing import CliRunner

import directrix as dx
from directrix import codes, estimate
from directrix.cli import app
from directrix.errors import InputError
from directrix.schema import load_case
from directrix.schema.convert import convert
from directrix.schema.describe import describe
from directrix.schema.load import SCHEMA_ID
from directrix.schema.units import UnitSet, meant, unit
from directrix.schema.versions import MIGRATIONS
from directrix.sketch import sketch
from directrix.starting import begin, templates

ROOT = Path(__file__).parent.parent
BAR = """
[section.bar]
kind = "circle"
radius = 0.005
E = 210e9
nu = 0.3
rho = 7850
[[rod]]
name = "arm"
section = "bar"
line = [[0, 0, 0], [1, 0, 0]]
ends = ["root", "tip"]
elements = 4
[[support]]
node = "root"
type = "clamp"
"""
LINE = "line = [[0, 0, 0], [1, 0, 0]]"
PUSH = '[[force]]\nnode = "tip"\nvalue = [0, 0, 1]\n'
STATIC, MOVING = BAR + "[statics]\n", BAR + "[dynamics]\nt_end = 0.1\ndt = 0.01\n"


def case_of(folder: Path, text: str, ending: str = ".toml") -> Any:
    path = folder / f"case{ending}"
    path.write_text(text, encoding="utf-8")
    return load_case(path)


def mistakes(folder: Path, text: str) -> list[tuple[str, str]]:
    """Code and place (line:column: key) of all that is wrong."""
    with pytest.raises(InputError) as caught:
        case_of(folder, text)
    return [(e.code, e.where.split("case.toml:")[1]) for e in caught.value.mistakes]


def command(*args: object) -> Any:
    return CliRunner().invoke(app, [str(a) for a in args])


# --- all mistakes at once


def test_mistakes_of_every_stage_are_told_together(tmp_path: Path) -> None:
    text = """[section.bar]
kind = "circle"
radius = 0.01
E = 2e11
nu = 0.3
rho = 7850.
[section.pipe]
kind = "tube"
outer = 0.01
wall = 0.02
E = 1_000,5
nu = 0.3
[[rod]]
name = "one"
section = "baar"
line = [[0, 0, 0], [1, 0, 0]]
elements = 4
[[rod]]
name = "two"
section = "bar"
line = [[0, 0, 0], [1, 0, 0]]
elements = 4.0
[[rod]]
name = "three"
section = "bar"
line = [[0, 0, 0], [1, 0, 0]]
elements = 4
[[support]]
node = "two.start"
type = "clamp"
[[support]]
node = "three.begin"
type = "clamp"
[[force]]
node = "three.end"
vale = [0, 0, 1]
[statics]
"""
    assert mistakes(tmp_path, text) == [
        ("DX115", "6:7: rho"),
        ("DX115", "11:5: E"),
        ("DX201", "36:1: force[three.end].vale"),
        ("DX205", "22:1: rod[two].elements"),
        ("DX401", "10:1: section.pipe.wall"),
        ("DX421", "15:1: rod[one].section"),
        ("DX420", "32:1: support[three.begin].node"),
    ]  # nothing is said of node two.start: its rod is wrong already


def test_what_only_follows_from_another_mistake_is_not_told(tmp_path: Path) -> None:
    text = STATIC.replace("radius = 0.005", "radius = -1") + '[[force]]\nnode = "tip"\nvalue = [0, 0, 1]\n'
    assert [code for code, _ in mistakes(tmp_path, text)] == ["DX212"]
    two = STATIC + '[[force]]\nnode = "tpi"\nvalue = [0, 0, 1]\n[[moment]]\nnode = "toop"\nvalue = [0, 0, 1]\n'
    assert [code for code, _ in mistakes(tmp_path, two)] == ["DX420", "DX420"]


@pytest.mark.parametrize(
    ("written", "fix"),
    [
        ("7850.", "write 7850.0"),
        ("2e11.", "write 2e+11"),
        (".5", "write 0.5"),
        ("1_000,5", "write 1000.5"),
        ("1.234.567,8", "write 1234567.8"),
        ('"7850"', "write 7850, without quotes"),
        ('"7850."', "write 7850, without quotes"),
        ('"2e11"', "write 2e+11, without quotes"),
        ("2x10^3", "write 2000"),
        ("7850 kg/m^3", 'write "7850 kg/m^3"'),
    ],
)
def test_numbers_in_a_wrong_form_get_a_hint(tmp_path: Path, written: str, fix: str) -> None:
    with pytest.raises(InputError) as caught:
        case_of(tmp_path, STATIC.replace("rho = 7850", f"rho = {written}"))
    (error,) = caught.value.mistakes
    assert error.fix.startswith(fix) and ":7:" in error.where


def test_degrees_where_radians_are_meant_get_a_hint(tmp_path: Path) -> None:
    turn = STATIC + '[[prescribe]]\nnode = "tip"\nrotation = [0, 0, "90 deg"]\n'
    moved = case_of(tmp_path, turn).model.prescribed[0]
    np.testing.assert_allclose(moved.rotation, (0, 0, np.pi / 2))
    plain = case_of(tmp_path, turn.replace('"90 deg"', "90"))
    (warning,) = plain.warnings
    assert warning.code == "degrees" and "write 1.5708" in warning.fix
    # where no unit may stand the number is given in radians
    assert meant("90°") == meant("90 deg") == "1.570796327" == meant("pi/2")


def test_every_code_is_documented_and_every_page_is_true() -> None:
    page = (ROOT / "docs" / "errors.md").read_text("utf-8")
    assert page == codes.page(), "write it anew: python -c 'from directrix import codes; print(codes.page(), end=\"\")'"
    used = {
        code
        for path in (ROOT / "src" / "directrix").rglob("*.py")
        if path.name != "codes.py"
        for code in re.findall(r'"(DX\d{3})"', path.read_text("utf-8"))
    }
    assert used <= set(codes.CODES) and set(codes.TABLES.values()) <= set(codes.CODES)
    assert set(codes.CODES) <= used | set(codes.TABLES.values()) | {"DX502"}


def test_an_error_of_the_model_has_a_code_in_python() -> None:
    with pytest.raises(dx.ModelError) as caught:
        dx.Model().clamp("a").check()
    assert caught.value.code == "DX400"
    bar = dx.Section.from_moduli(EA=1, GA1=1, GA2=1, EI1=1, EI2=1, GJ=1)
    with pytest.raises(dx.ModelError) as caught:
        dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), bar, ends=("a", "b")).clamp("c").check()
    assert caught.value.code == "DX420" and "DX420" not in str(caught.value)


# --- units


def test_quantities_give_what_plain_numbers_give(tmp_path: Path) -> None:
    plain = case_of(tmp_path, STATIC).model
    text = STATIC.replace("0.005", '"5 mm"').replace("210e9", '"210 GPa"').replace("7850", '"7.85 g/cm^3"')
    text = text.replace("[1, 0, 0]]", '["100 cm", 0, 0]]')
    given = case_of(tmp_path, text).model
    one, two = plain.rods[0], given.rods[0]
    np.testing.assert_allclose(two.section.stiffness, one.section.stiffness, rtol=1e-14)
    assert two.section.A_rho == pytest.approx(one.section.A_rho, rel=1e-14)
    assert two.curve.length == pytest.approx(1.0, rel=1e-15)


def test_a_set_of_units_is_that_of_plain_numbers(tmp_path: Path) -> None:
    head = '[units]\nlength = "mm"\nforce = "N"\n'
    text = head + STATIC.replace("0.005", "5").replace("210e9", '"210 GPa"').replace("7850", '"7850 kg/m^3"')
    text = text.replace("[1, 0, 0]]", "[1000, 0, 0]]")
    case = case_of(tmp_path, text)
    section = case.model.rods[0].section
    assert section.stiffness[2, 2] == pytest.approx(210e3 * np.pi * 25)  # N
    assert section.A_rho == pytest.approx(7850e-12 * np.pi * 25)  # tonnes per millimetre
    assert "length mm" in describe(case) and str(case.units).endswith("of stress 1e+06 Pa")


def test_units_that_cannot_be(tmp_path: Path) -> None:
    for given, code, says in (
        ('"5 kg"', "DX303", "a mass, but must be a length"),
        ('"5 mn"', "DX302", "no unit 'mn'"),
        ('"5 m*"', "DX302", "cannot be read"),
        ('"5 K"', "DX303", "not one of mechanics"),
    ):
        with pytest.raises(InputError, match=re.escape(says)) as caught:
            case_of(tmp_path, STATIC.replace("0.005", given))
        assert caught.value.code == code and caught.value.fix
    with pytest.raises(InputError) as caught:
        case_of(tmp_path, STATIC.replace("nu = 0.3", 'nu = "0.3 m"'))
    assert caught.value.code == "DX203"
    for units, code in (('length = "kg"', "DX304"), ('length = "mmm"', "DX302"), ('force = "N"\nmass = "kg"', "DX304")):
        assert mistakes(tmp_path, f"[units]\n{units}\n{STATIC}")[0][0] == code


def test_without_pint_the_install_line_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = import_module("directrix.schema.units")
    module._named.cache_clear()
    monkeypatch.setattr(module, "_registry", lambda: None)
    with pytest.raises(InputError) as caught:
        case_of(tmp_path, STATIC.replace("0.005", '"5 mm"'))
    assert caught.value.code == "DX301" and 'pip install "directrix[units]"' in caught.value.fix
    assert case_of(tmp_path, STATIC).title == "case"  # plain numbers need no pint
    module._named.cache_clear()


def test_units_of_products_and_powers() -> None:
    size, powers = unit("kN/mm^2")
    assert size == pytest.approx(1e9) and powers == (-1, 1, -2)
    assert unit("N·m") == unit("N*m") == unit("J") == unit("kg m² / s^2")
    assert unit("rpm")[0] == pytest.approx(2 * np.pi / 60)
    assert UnitSet(mass=1e3, length=1e-3, time=1.0).size((-1, 1, -2)) == pytest.approx(1e6)


# --- versions


def test_newer_formats_are_refused_and_older_ones_migrated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert mistakes(tmp_path, f"format_version = 2\n{STATIC}") == [("DX114", "1:1: format_version")]
    assert mistakes(tmp_path, f'format_version = "1"\n{STATIC}') == [("DX114", "1:1: format_version")]
    assert case_of(tmp_path, f"format_version = 1\n{STATIC}").title == "case"

    def renamed(data: Any) -> Any:  # as a format 2 might have it
        return {**data, "title": data["heading"]} | {"heading": None} if "heading" in data else data

    def migrate(data: Any) -> Any:
        new = dict(renamed(data))
        new.pop("heading", None)
        return new

    monkeypatch.setattr("directrix.schema.versions.FORMAT", 2)
    monkeypatch.setitem(MIGRATIONS, 1, migrate)
    assert case_of(tmp_path, f'format_version = 1\nheading = "Old"\n{STATIC}').title == "Old"


def test_json_may_name_its_schema(tmp_path: Path) -> None:
    data = {"$schema": "./directrix.schema.json", **tomllib.loads(STATIC)}
    assert case_of(tmp_path, json.dumps(data), ".json").title == "case"
    schema = json.loads(command("schema").stdout)
    assert "$schema" in schema["properties"] and schema["$id"] == SCHEMA_ID
    radius = schema["$defs"]["Circle"]["properties"]["radius"]["anyOf"]
    assert [kind["type"] for kind in radius] == ["number", "string"]  # a quantity may stand for a number


# --- new, convert


@pytest.mark.parametrize("name", templates())
def test_every_template_runs_as_it_is(name: str, tmp_path: Path) -> None:
    path, schema = begin(str(tmp_path / "mine"), name)
    assert path.name == "mine.toml" and path.read_text("utf-8").startswith("#:schema ./directrix.schema.json\n")
    assert json.loads(schema.read_text("utf-8"))["$id"] == SCHEMA_ID
    case = load_case(path)
    assert case.warnings == () and case.title != "mine"
    result = case.run()
    assert result.success and result.audit.passed
    moved = np.abs(result.r[-1] - result.mesh.r0).max()
    assert moved > 1e-3 * np.ptp(result.mesh.r0, axis=0).max()  # something happens in it


def test_new_does_not_write_over_anything(tmp_path: Path) -> None:
    assert command("new", tmp_path / "a", "--template", "swing").exit_code == 0
    before = (tmp_path / "a.toml").read_text("utf-8")
    again = command("new", tmp_path / "a", "--template", "frame")
    assert again.exit_code == 2 and "DX501" in again.stderr
    assert (tmp_path / "a.toml").read_text("utf-8") == before
    assert command("new", tmp_path / "b", "--template", "frame").exit_code == 0  # the schema is ours
    other = tmp_path / "other"
    other.mkdir()
    (other / "directrix.schema.json").write_text("{}")
    assert command("new", other / "a", "--template", "frame").exit_code == 2 and not (other / "a.toml").exists()
    assert (other / "directrix.schema.json").read_text() == "{}"


def test_new_asks_on_a_terminal_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    refused = command("new")
    assert refused.exit_code == 2 and "--template" in refused.stderr and "DX503" in refused.stderr
    assert command("new", "--list").stdout.count("\n") == len(templates()) >= 6
    near = command("new", "x", "--template", "latice")
    assert near.exit_code == 2 and "did you mean 'lattice'" in near.stderr
    monkeypatch.setattr("directrix.cli.asks", lambda: True)
    done = CliRunner().invoke(app, ["new"], input="helix\nspiral\n")
    assert done.exit_code == 0 and load_case(tmp_path / "spiral.toml").title == "Helical spring"


@pytest.mark.parametrize("seed", SEEDS, ids=lambda p: p.stem)
def test_to_json_and_back_says_the_same(seed: Path, tmp_path: Path) -> None:
    there, back = tmp_path / "a.json", tmp_path / "b.toml"
    lost = convert(seed, there)
    assert lost == ("#" in seed.read_text("utf-8"))  # none of them has one in a text
    assert not convert(there, back)
    assert tomllib.loads(back.read_text("utf-8")) == tomllib.loads(seed.read_text("utf-8"))
    assert json.loads(there.read_text("utf-8")) == tomllib.loads(seed.read_text("utf-8"))


def test_convert_keeps_the_schema_and_refuses_the_rest(tmp_path: Path) -> None:
    path, _ = begin(str(tmp_path / "a"), "cantilever")
    done = command("convert", path, tmp_path / "a.json")
    assert done.exit_code == 0 and "comments" in done.stdout
    assert json.loads((tmp_path / "a.json").read_text("utf-8"))["$schema"] == "./directrix.schema.json"
    assert command("convert", tmp_path / "a.json", tmp_path / "b.toml").exit_code == 0
    assert (tmp_path / "b.toml").read_text("utf-8").startswith("#:schema ./directrix.schema.json\n")
    for target in ("a.json", "c.toml", "c.txt"):
        assert command("convert", path, tmp_path / target).exit_code == 2
    path.write_text("x = 1\n")
    assert command("convert", path, tmp_path / "d.json").exit_code == 2 and not (tmp_path / "d.json").exists()


# --- check: warnings, cost, picture


@pytest.mark.parametrize(
    ("text", "code", "fix"),
    [
        (STATIC.replace("7850", "7.85"), "density", "rho = 7850"),
        (STATIC.replace("210e9", "210"), "stiffness", "E = 2.1e+11"),
        (STATIC.replace("210e9", "210e3"), "stiffness", "E = 2.1e+11"),
        (STATIC.replace("0.005", "5"), "thick", "units"),
        (STATIC.replace("0.005", "0.45"), "thick", "rigid body"),
        (STATIC + "[gravity]\nvalue = [0, 0, -9810]\n", "gravity", "write 9.81"),
        (STATIC + '[[force]]\nnode = "tip"\nvalue = [0, 0, 2e10]\n', "large_force", "units"),
        (MOVING.replace("dt = 0.01", "dt = 10").replace("0.1", "100"), "long_step", "dt = "),
        (MOVING + PUSH + 'time = { kind = "sine", frequency = 90 }\n', "long_step", "dt"),
        (MOVING + PUSH + 'time = { kind = "ramp", start = 2, until = 3 }\n', "late", "t_end"),
        (STATIC.replace(LINE, "helix = { radius = 0.1, pitch = 0.1, turns = 4 }"), "coarse", "16 elements"),
    ],
)  # fmt: skip
def test_what_is_likely_not_meant_is_a_warning(tmp_path: Path, text: str, code: str, fix: str) -> None:
    case = case_of(tmp_path, text)
    assert [w.code for w in case.warnings] == [code]
    assert fix in case.warnings[0].fix and not case.warnings[0].error
    assert case.warnings[0].what in describe(case)


def test_bundled_cases_and_sound_models_get_no_warning() -> None:
    for seed in SEEDS:
        assert load_case(seed).warnings == (), seed


def test_run_says_its_warnings(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(STATIC.replace("7850", "7.85"))
    done = command("run", path, "--no-view")
    assert done.exit_code == 0 and "warning: section 'bar'" in done.stdout and "write rho = 7850" in done.stdout


def test_check_says_counts_masses_slenderness_mechanisms_and_cost(tmp_path: Path) -> None:
    text = describe(case_of(tmp_path, MOVING))
    area, inertia = np.pi * 0.005**2, np.pi * 0.005**4 / 4
    for part in (
        f"mass {7850 * area:.6g} ({7850 * area:.6g} of rods, 0 of bodies), 1 of rod",
        f"slenderness {np.sqrt(area / inertia):.4g}",
        f"EI1 = {210e9 * inertia:.6g}",
        "1 support",
        "mechanisms: none",
        "estimated cost: about ",
        "root at (0, 0, 0), held: x y z rx ry rz",
    ):
        assert part in text, part


def test_the_cost_follows_its_rule(tmp_path: Path) -> None:
    disc = case_of(tmp_path, MOVING).check()
    one, two = (estimate.cost(disc, steps, steps, static=False) for steps in (100, 200))
    assert two.seconds == pytest.approx(2 * one.seconds) and two.kept == 2 * one.kept
    assert one.seconds == pytest.approx(100 * 3 * (3e-4 + 4 * 2 * 4e-6))
    assert one.kept == 8 * 100 * (40 * 9 + 12 * 8)


def test_check_draws_the_model(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    path, _ = begin(str(tmp_path / "a"), "frame")
    done = command("check", path)
    assert done.exit_code == 0 and (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert command("check", path, "--picture", tmp_path / "b.svg").exit_code == 0
    drawn = (tmp_path / "b.svg").read_text("utf-8")
    for word in ("clamp", "gravity", "load along a rod", "middle", "beam"):
        assert f"<!-- {word} -->" in drawn or f"<!--   {word} -->" in drawn, word
    refused = command("check", path, "--picture", tmp_path / "b.xyz")
    assert refused.exit_code == 2 and "is no picture" in refused.stderr
    assert not (tmp_path / "none").exists()
    quiet = command("check", path, "--no-picture")
    assert "wrote" not in quiet.stdout


QUICK = {"joined", "machine", "driven"}  # all signs are in them


@pytest.mark.parametrize(
    "seed", [pytest.param(s, id=s.stem, marks=[] if s.stem in QUICK else [pytest.mark.slow]) for s in SEEDS]
)
def test_every_seed_can_be_drawn(seed: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    case = load_case(seed)
    assert sketch(case.check(), tmp_path / "model.png", case.duration).stat().st_size > 5000


# --- what Python can say, a case can


def test_laws_matrices_of_damping_routes_and_muscles_arrive(tmp_path: Path) -> None:
    model = load_case(next(p for p in SEEDS if p.stem == "driven")).model
    arm, soft = model.rods
    np.testing.assert_array_equal(np.diag(arm.section.damping), [1, 1, 1, 1e-3, 1e-3, 1e-3])
    law = dx.laws.stiffening_bending(EA=100, GA1=40, GA2=40, EI1=0.1, EI2=0.1, GJ=0.08, onset=10)
    assert soft.section.law == dx.Section.hyperelastic(law).law
    side = model.tendons[0]
    np.testing.assert_allclose([side.across(f) for f in (0, 0.25, 0.5, 1)], [(0.01, 0), (0.015, 0), (0.02, 0), (0, 0)])
    quarter = np.sin(2 * np.pi * 2 * 0.1)
    at = model.actuations[0].at(0.1, 1.0, np.array([0.0, 0.25, 0.5]))
    np.testing.assert_allclose(at[:, 4], [0, quarter, 2 * quarter])
    cable = load_case(next(p for p in SEEDS if p.stem == "cable")).model.rods[0].section
    pull = dx.laws.tension_only(EA=1000, GA1=400, GA2=400, EI1=0.1, EI2=0.1, GJ=0.08, width=1e-3)
    assert cable.law == dx.Section.hyperelastic(pull).law and cable.A_rho == 1.0


def test_a_muscle_in_statics_ramps_with_the_load_factor(tmp_path: Path) -> None:
    text = STATIC + '[[actuate]]\nrod = "arm"\ntwist = 3\nalong = { s = [0, 1], factor = [1, 0] }\n'
    made = case_of(tmp_path, text).model.actuations[0]
    at = [made.at(factor, factor, np.array([0.0, 0.5]))[:, 5] for factor in (0.0, 0.5, 1.0)]
    np.testing.assert_allclose(at, [(0, 0), (1.5, 0.75), (3, 1.5)])


# --- help


def examples() -> dict[str, str]:
    """The example of every command's help."""
    group = typer.main.get_command(app)
    return {name: str(c.epilog) for name, c in group.commands.items()}  # pyright: ignore


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two cases that have run."""
    folder = tmp_path_factory.mktemp("help")
    for name in ("cantilever", "swing"):
        path, _ = begin(str(folder / name), name)
        assert command("run", path, "--no-view").exit_code == 0
    return folder


LONG = {"paper"}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] if n in LONG else []) for n in examples()])
def test_the_example_of_every_help_runs(name: str, bench: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = examples()[name]
    found = re.fullmatch(r"Example: directrix (.+)", text)
    assert found is not None, f"the help of {name} has no example"
    words = shlex.split(found[1])
    assert words[0] == name
    assert text.split("Example: ")[1].split("--")[0].strip() in " ".join(command(name, "--help").stdout.split())
    monkeypatch.chdir(bench)
    (bench / "cantilever.json").unlink(missing_ok=True)
    done = command(*words)
    assert done.exit_code == 0, done.stderr
