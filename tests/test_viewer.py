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

from directrix import drawing, viewer
from directrix.errors import ModelError
from directrix.result import Result
from directrix.viewer import write_html

NASTY = ("</script><b>x", "<!--<script>", "{{script}} & \"q\" 'p' \u2028é")
CHROMIUM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
)
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
    for part in (data, *data["rods"]):
        part["arrays"] = {key: np.frombuffer(b64decode(code), "<f4") for key, code in part["arrays"].items()}
    return data


@pytest.mark.parametrize("kind", ["static", "dynamic"])
def test_the_page_holds_the_run(kind: Any, tmp_path: Path) -> None:
    result = fake_result(kind, order=2, elements=3)
    data = data_of(page_of(result, tmp_path))
    expected = {
        "arms": result.mesh.joint_arms,
        "r0": result.mesh.r0, "t": result.t, "r": result.r, "strain": result.strain, "force": result.force,
        "turn": np.stack([result.R[..., 0], result.R[..., 1]], axis=-2), "kinetic": result.energy.kinetic,
        "stored": result.energy.stored, "work": result.energy.work,
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
    data = data_of(page_of(fake_result(fails=True), tmp_path))
    assert (data["success"], data["passed"]) == (False, False)
    assert "smaller step" in data["status"]


def test_long_runs_keep_first_and_last_instant_and_say_how_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = fake_result()
    monkeypatch.setattr(viewer, "FRAMES_AT_MOST", 7)
    data = data_of(page_of(result, tmp_path))
    assert (data["frames"], data["instants"]) == (7, 40)
    t = data["arrays"]["t"]
    assert len(t) == 7
    assert t[[0, -1]].tolist() == result.t[[0, -1]].astype(np.float32).tolist()
    assert len(data["arrays"]["r"]) == 7 * 3 * len(result.mesh.r0)
    monkeypatch.setattr(viewer, "BYTES_AT_MOST", 1)
    assert data_of(page_of(result, tmp_path))["frames"] == 2


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
    data = data_of(text)
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
const run = readRun(require("fs").readFileSync(process.argv[2], "utf-8")), skeleton = makeSkeleton(run);
const at = (array, width) => atFrame(array, width, 9, new Float32Array(width));
place(skeleton, at(run.r, 3 * run.nodes), at(run.turn, 6 * run.nodes));
const part = (rod) => skeleton.poses.subarray(9 * rod.firstSample, 9 * (rod.firstSample + rod.samples));
const rods = skeleton.rods.map((rod) => [...part(rod)]);
const joints = jointEnds(run, at(run.r, 3 * run.nodes), at(run.turn, 6 * run.nodes));
console.log(JSON.stringify({ rods, knots: [...skeleton.knots], joints, room: extent(run) }));
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


@pytest.mark.skipif(not CHROMIUM, reason="needs a chromium")
@pytest.mark.parametrize("case", ["dynamic", "one instant", "no WebGL"])
def test_a_browser_shows_it(case: str, tmp_path: Path) -> None:
    result = fake_result(instants=40) if case != "one instant" else fake_result("static", instants=2)
    if case == "one instant":
        result = replace(
            result, t=result.t[1:], r=result.r[1:], R=result.R[1:], strain=result.strain[1:],
            energy=replace(result.energy, kinetic=np.zeros(1), stored=np.full(1, 2.5), work=np.full(1, 2.5)),
            force=result.force[1:],
        )  # fmt: skip
    mesh = replace(result.mesh, node_names={"<b>N</b>": 0})
    page_of(replace(result, mesh=mesh), tmp_path)
    webgl = ["--disable-3d-apis"] if case == "no WebGL" else ["--enable-unsafe-swiftshader"]
    done = subprocess.run(
        [
            CHROMIUM, "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", *webgl,
            f"--user-data-dir={tmp_path / 'profile'}", "--virtual-time-budget=2000", "--dump-dom",
            f"file://{tmp_path / 'run.html'}#frame=10",
        ],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    assert 'data-state="ready"' in done.stdout
    assert "2.5</span>" in done.stdout  # the total (or stored) energy
    assert str(result.status) in done.stdout
    assert ('id="refusal" hidden' in done.stdout) == (case != "no WebGL")
    assert (">t = 2<" in done.stdout) == (case != "one instant")
