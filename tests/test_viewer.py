"""The page holds the numbers of the result, needs no network, and lets no name become code."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from base64 import b64decode, b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_result import fake_result, with_joints

import directrix as dx
from directrix import drawing, viewer
from directrix.errors import ModelError
from directrix.marks import Mark, marks_of
from directrix.result import Result, RodMesh
from directrix.viewer import write_html

NASTY = ("</script><b>x", "<!--<script>", "{{script}} & \"q\" 'p' \u2028é")
NODE = shutil.which("node") or ""


class Page(HTMLParser):
    """Elements of a page, the text of its scripts, its style and its title."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.texts: dict[str, list[str]] = {"script": [], "style": [], "title": [], "h1": []}
        self.open = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs
        self.open = tag
        self.texts.get(tag, []).append("")

    def handle_endtag(self, tag: str) -> None:
        self.open = ""

    def handle_data(self, data: str) -> None:
        if self.open in self.texts:
            self.texts[self.open][-1] += data


def page_of(result: Result, tmp_path: Path) -> str:
    path = tmp_path / "run.html"
    assert write_html(result, path) == str(path)
    return path.read_text(encoding="utf-8")


def data_of(text: str) -> dict[str, Any]:
    data = json.loads(Page(text).texts["script"][0])
    for part in (part for run in data["runs"] for part in (run, *run["rods"])):
        part["arrays"] = {key: np.frombuffer(b64decode(code), "<f4") for key, code in part["arrays"].items()}
    return data


def run_of(text: str) -> dict[str, Any]:
    (run,) = data_of(text)["runs"]
    return run


@pytest.mark.parametrize("kind", ["static", "dynamic"])
def test_the_page_holds_the_run(kind: Any, tmp_path: Path) -> None:
    result = fake_result(kind, order=2, elements=3)
    result = replace(result, density=np.abs(result.force[..., 3]))
    data = run_of(page_of(result, tmp_path))
    expected = {
        "arms": result.mesh.joint_arms,
        "r0": result.mesh.r0, "t": result.t, "r": result.r, "strain": result.strain, "force": result.force,
        "turn": np.stack([result.R[..., 0], result.R[..., 1]], axis=-2), "kinetic": result.energy.kinetic,
        "stored": result.energy.stored, "work": result.energy.work, "density": result.density,
        "speed": np.linalg.norm(result.v, axis=-1) if kind == "dynamic" else np.zeros(0),
    }  # fmt: skip
    assert set(data["arrays"]) == set(expected)
    for key, values in expected.items():
        assert np.array_equal(data["arrays"][key], values.astype(np.float32).ravel()), key
    for rod, mesh in zip(data["rods"], result.mesh.rods, strict=True):
        assert (rod["name"], rod["order"], rod["first"]) == (mesh.name, mesh.order, mesh.first_station)
        assert rod["nodes"] == mesh.nodes.tolist()
        directors = np.stack([mesh.directors[..., 0], mesh.directors[..., 1]], axis=-2)
        assert np.array_equal(rod["arrays"]["directors"], directors.astype(np.float32).ravel())
        assert np.array_equal(rod["arrays"]["outline"], mesh.outline.astype(np.float32).ravel())
    assert data["status"] == str(result.status)
    assert data["verdict"] == result.audit.verdict
    assert data["names"] == [["A", 0], ["O", 6], ["B", 12], ["C", 18]]


def test_a_failed_run_says_so(tmp_path: Path) -> None:
    data = run_of(page_of(fake_result(fails=True), tmp_path))
    assert (data["success"], data["passed"]) == (False, False)
    assert "smaller step" in data["status"]


def test_long_runs_keep_first_and_last_instant_and_say_how_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = fake_result()
    monkeypatch.setattr(viewer, "FRAMES_AT_MOST", 7)
    data = run_of(page_of(result, tmp_path))
    assert (data["frames"], data["instants"]) == (7, 40)
    t = data["arrays"]["t"]
    assert len(t) == 7
    assert t[[0, -1]].tolist() == result.t[[0, -1]].astype(np.float32).tolist()
    assert len(data["arrays"]["r"]) == 7 * 3 * len(result.mesh.r0)
    monkeypatch.setattr(viewer, "BYTES_AT_MOST", 1)
    assert run_of(page_of(result, tmp_path))["frames"] == 2


def test_nothing_is_fetched(tmp_path: Path) -> None:
    text = page_of(fake_result(), tmp_path)
    page = Page(text)
    assert not {"link", "img", "iframe", "object", "embed", "base"} & set(page.tags)
    assert not {"src", "href", "onclick", "style"} & {name for name, _ in page.attributes}
    code = page.texts["script"][1] + page.texts["style"][0]
    assert not re.search(r"https?:|@import|url\(|fetch\(|import\(|XMLHttpRequest|WebSocket|eval\(", code)


def test_only_the_script_and_style_of_the_page_may_run(tmp_path: Path) -> None:
    text = page_of(fake_result(names=NASTY, title=NASTY[0]), tmp_path)
    page = Page(text)
    policy = next(value for name, value in page.attributes if name == "content" and "default-src" in (value or ""))
    assert policy is not None
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy
    for kind, content in (("script", page.texts["script"][1]), ("style", page.texts["style"][0])):
        digest = b64encode(sha256(content.encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}'" in policy


def test_names_stay_text(tmp_path: Path) -> None:
    result = fake_result(names=NASTY, title="".join(NASTY))
    mesh = replace(result.mesh, node_names={name: k for k, name in enumerate(NASTY)})
    text = page_of(replace(result, mesh=mesh), tmp_path)
    page, plain = Page(text), Page(page_of(fake_result(), tmp_path))
    assert page.tags == plain.tags  # not one element more
    assert "b" not in page.tags
    assert page.texts["title"] == ["".join(NASTY)]
    data = run_of(text)
    assert tuple(rod["name"] for rod in data["rods"]) == NASTY
    assert tuple(name for name, _ in data["names"]) == NASTY
    assert page.texts["script"][1] == plain.texts["script"][1]


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="No such file"):
        write_html(fake_result(), tmp_path / "missing" / "run.html")
    with pytest.raises(ModelError, match="Is a directory"):
        write_html(fake_result(), tmp_path)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e39])
def test_numbers_that_are_not_finite_are_refused(bad: float, tmp_path: Path) -> None:
    result = fake_result()
    r = result.r.copy()
    r[3, 2, 1] = bad
    with pytest.raises(ModelError, match="positions: some numbers are not finite"):
        write_html(replace(result, r=r), tmp_path / "run.html")
    assert not (tmp_path / "run.html").exists()


@pytest.mark.skipif(not NODE, reason="needs node")
@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_page_interpolates_as_the_elements_do(order: int, tmp_path: Path) -> None:
    """The script's own kinematics, run by node: axis, directors and joints at a saved instant."""
    result = with_joints(fake_result(order=order, elements=3))
    page = Page(page_of(result, tmp_path))
    (tmp_path / "data.json").write_text(page.texts["script"][0], encoding="utf-8")
    code = (
        viewer._part("model.js")
        + """
const [run] = readPage(require("fs").readFileSync(process.argv[2], "utf-8")).runs, skeleton = makeSkeleton(run);
const at = (array, width) => atFrame(array, width, 9, new Float32Array(width));
place(skeleton, at(run.r, 3 * run.nodes), at(run.turn, 6 * run.nodes));
const part = (rod) => skeleton.poses.subarray(9 * rod.firstSample, 9 * (rod.firstSample + rod.samples));
const rods = skeleton.rods.map((rod) => [...part(rod)]);
const joints = jointEnds(run, at(run.r, 3 * run.nodes), at(run.turn, 6 * run.nodes));
console.log(JSON.stringify({ rods, knots: [...skeleton.knots], joints, room: extent([run]) }));
"""
    )
    (tmp_path / "check.js").write_text(code, encoding="utf-8")
    done = subprocess.run(
        [NODE, str(tmp_path / "check.js"), str(tmp_path / "data.json")],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    said = json.loads(done.stdout)
    knots = np.array(said["knots"]).reshape(-1, 3, 3)
    expected = np.concatenate([result.directors(rod.name)[9] for rod in result.mesh.rods])
    assert np.allclose(knots[:, 1], expected[..., 0], atol=1e-6)
    assert np.allclose(knots[:, 2], expected[..., 1], atol=1e-6)
    for rod, flat in zip(result.mesh.rods, said["rods"], strict=True):
        poses = np.array(flat).reshape(-1, 3, 3)
        cuts = (len(poses) - 1) // 3
        xi = np.linspace(-1.0, 1.0, cuts + 1)[:-1]
        nodal, local = result.r[9, rod.nodes], np.arange(3)[:, None] * order + np.arange(order + 1)
        axis = np.concatenate([(drawing.lagrange(order, xi)[0] @ nodal[local]).reshape(-1, 3), nodal[-1:]])
        assert np.allclose(poses[:, 0], axis, atol=1e-5)
        assert np.allclose(np.linalg.norm(poses[:, 1:], axis=-1), 1.0, atol=1e-6)
    for ends, drawn in zip(result.joint_ends(9), said["joints"], strict=True):
        for (foot, tip), end in zip(ends, drawn, strict=True):
            assert np.allclose(tip, end["tip"], atol=1e-5)
            assert end["foot"] is None or np.allclose(foot, end["foot"], atol=1e-5)
    assert [end["foot"] is None for ends in said["joints"] for end in ends] == [True, False, False, False]
    assert said["room"]["low"][1] == -20.0  # the pin on the ground is in sight


@pytest.mark.skipif(not NODE, reason="needs node")
def test_caps_fill_outlines_with_corners_and_holes(tmp_path: Path) -> None:
    """Ears of an I, of a tube and of a box with a hole cover the area between their rings, and nothing of the hole."""
    tube = dx.Section.tube(1.0, 0.25, E=1.0, nu=0.3).outline
    flange = np.array(
        [(-3, -4), (3, -4), (3, -3), (1, -3), (1, 3), (3, 3), (3, 4), (-3, 4), (-3, 3), (-1, 3), (-1, -3), (-3, -3)]
    )
    box = np.array([(-2, -2), (2, -2), (2, 2), (-2, 2), (-2, -2), (-1, -1), (-1, 1), (1, 1), (1, -1), (-1, -1)], float)
    code = (
        viewer._part("model.js")
        + viewer._part("scene.js")
        + """
const said = JSON.parse(process.argv[2]).map((points) => {
  const outline = outlineOf({ outline: points.flat() }, 1), corners = triangulate(outline).map((k) => outline[k]);
  const edges = outline.map((p, i) => ({ p, q: outline[(i + 1) % outline.length], length: 1 }));
  return { corners, seams: seamed(edges).filter(Boolean).length };
});
console.log(JSON.stringify(said));
"""
    )
    (tmp_path / "caps.js").write_text(code, encoding="utf-8")
    shapes = json.dumps([shape.tolist() for shape in (tube, flange, box)])
    done = subprocess.run(
        [NODE, str(tmp_path / "caps.js"), shapes], capture_output=True, text=True, check=True, timeout=60
    )
    ring = 12.0 * np.sin(np.pi / 12.0)  # area of a 24-gon in the unit circle
    for said, area, hole, seams in zip(
        json.loads(done.stdout), (ring * (1 - 0.75**2), 24.0, 12.0), (0.7, None, 0.9), (2, 0, 2), strict=True
    ):
        triangles = np.array(said["corners"]).reshape(-1, 3, 2)
        one, two = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        areas = 0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        assert areas.min() >= 0.0
        assert np.isclose(areas.sum(), area, rtol=1e-6)
        assert said["seams"] == seams
        if hole is not None:
            assert np.abs(triangles.mean(axis=1)).max(axis=1).min() > 0.5 * hole


def test_what_is_seen_of_a_model(tmp_path: Path) -> None:
    """Supports, loads and springs of a model become marks, no user's function is called, and a file keeps them."""
    rubber = dx.Section.circle(radius=0.1, E=5e6, nu=0.5, rho=1100)
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (1, 0, 0)), rubber, name="rod", ends=("a", "b"), elements=1, order=1)
        .clamp("a").fix("b", "x").prescribe("b", displacement=(0, 0, 0.01)).point_mass("b", 1.0)
        .force("b", (0, 0, -2), follower=True).moment("b", lambda t: 1 / 0).gravity(dx.harmonic((0, 0, -9), 2.0))
        .distributed("rod", (0, 1, 0)).pressure("rod", 3.0, width=2.0, along="-d1").spring("b", (1, 0, 2), 1.0)
        .force("a", dx.table((0, 1), ((0, 0, 0), (4, 0, 0))))
    )  # fmt: skip
    nodes, s, directors = np.array([0, 1]), np.array([0.0, 1.0]), np.array([np.eye(3)] * 2)
    rod = RodMesh("rod", nodes, s, directors, 1, np.zeros(1), 0, rubber.outline)
    marks = marks_of(model, {"a": 0, "b": 1}, (rod,))
    assert marks == (
        Mark("clamp", (0,), text="rx ry rz x y z"), Mark("fix", (1,), text="x"), Mark("prescribe", (1,)),
        Mark("force", (1,), (0.0, 0.0, -2.0), True), Mark("moment", (1,), text="f(t)"),
        Mark("gravity", (), (0.0, 0.0, -9.0)),
        Mark("distributed", (0, 1), (0.0, 1.0, 0.0)),
        Mark("pressure", (0,), (-6.0, 0.0, 0.0), True), Mark("pressure", (1,), (-6.0, 0.0, 0.0), True),
        Mark("force", (0,), (4.0, 0.0, 0.0)), Mark("mass", (1,)),
        Mark("spring", (1,), place=(1.0, 0.0, 2.0), text="link1"),
    )  # fmt: skip
    result = fake_result()
    result = replace(result, mesh=replace(result.mesh, marks=marks))
    assert dx.load(result.save(tmp_path / "run.vtkhdf")).mesh.marks == marks
    run = run_of(page_of(result, tmp_path))
    assert run["gravity"] == [0.0, 0.0, -9.0]
    assert [mark["kind"] for mark in run["marks"]] == [mark.kind for mark in marks if mark.kind != "gravity"]


def test_runs_over_one_another(tmp_path: Path) -> None:
    path, first, other = tmp_path / "both.html", fake_result(), fake_result(order=2, t_end=5.0, title="other")
    assert dx.view([first, other], path, labels=("one", "<two>")) == str(path)
    data = data_of(path.read_text("utf-8"))
    assert [run["label"] for run in data["runs"]] == ["one", "<two>"]
    assert data["title"] == "three-rod frame and other"
    for wrong, labels, said in (
        ([], None, "are no results"), ([first, "x"], None, "are no results"), ([first] * 9, None, "are no results"),
        ([first, fake_result("static")], None, "no clock in common"), ([first], ["a", "b"], "are not 1 texts"),
    ):  # fmt: skip
        with pytest.raises(ModelError, match=said):
            dx.view(wrong, path, labels=labels)  # type: ignore[arg-type]
