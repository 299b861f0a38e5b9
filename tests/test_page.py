"""The page in a browser: it renders, plays, obeys, and has nothing to complain about. Pictures are kept."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import MISSING, Browser
from fake_result import fake_result, with_joints

import directrix as dx
from directrix.marks import Mark
from directrix.modal import Modes
from directrix.result import Result

pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)


def a_run() -> Result:
    result = fake_result(order=2)
    end, tip = result.mesh.node_names["A"], result.mesh.node_names["C"]
    marks = (
        Mark("clamp", (end,)), Mark("fix", (3,)), Mark("pin", (5,)), Mark("prescribe", (7,)), Mark("mass", (tip,)),
        Mark("force", (tip,), (0.0, 0.0, -3.0), True), Mark("moment", (tip,), (0.0, 1.0, 0.0)),
        Mark("force", (2,), text="f(t)"),
        Mark("distributed", tuple(result.mesh.rods[1].nodes.tolist()), (0.0, 0.0, -1.0)),
        Mark("spring", (tip,), place=(6.0, 0.0, -2.0)), Mark("gravity", (), (0.0, 0.0, -9.81)),
    )  # fmt: skip
    mesh = replace(result.mesh, marks=marks, node_names={**result.mesh.node_names, "<b>N</b>": 9})
    return replace(with_joints(replace(result, mesh=mesh)), density=np.abs(result.force[..., 3]))


def ink(picture: bytes) -> Any:
    """The pixels (height, width, 3) of a PNG."""
    from PIL import Image

    return np.asarray(Image.open(BytesIO(picture)).convert("RGB")).astype(int)


def test_it_plays_colours_and_obeys(chromium: Browser, tmp_path: Path, pictures: Path) -> None:
    result = a_run()
    page_file = result.view(tmp_path / "run.html")
    with chromium.open(f"file://{page_file}#frame=10", files=tmp_path, width=900, height=700) as page:
        plain = ink(page.picture(pictures / "light.png"))
        assert "2.5" in page.run("part('legend').textContent")
        assert page.run("part('clock').textContent") == "t = 2"
        assert str(result.status) in page.run("part('runs').textContent")
        assert page.run("part('hint').textContent").startswith("all 40 saved instants are shown · 0.2")
        stage = plain[120:480, 200:600]
        assert (stage != stage[0, 0]).any(axis=2).mean() > 0.02  # rods, and most of it paper

        page.choose("colour", "bending")
        assert page.run("part('field').textContent") == "bending moment |M1, M2| [force·length]"
        most = float(np.hypot(result.force[..., 3], result.force[..., 4]).max())
        assert float(page.run("part('high').textContent")) == pytest.approx(most, rel=1e-4)
        assert (ink(page.picture(pictures / "bending.png")) != plain).any()
        for field in page.run("[...part('colour').options].map((one) => one.value)"):
            page.choose("colour", field)
        assert page.run("part('colour').options.length") == 20

        page.press(" ")
        page.wait("seen.playing && seen.u > 10.2")
        page.press(" ")
        assert page.run("Number.isInteger(seen.u) && !seen.playing")
        for key, frame in (("End", 39), ("ArrowLeft", 38), ("Home", 0), ("ArrowRight", 1)):
            page.press(key)
            assert page.run("seen.u") == frame
        page.run("part('loop').click(), seen.u = 38.9, play(true)")
        page.wait("!seen.playing && seen.u === 39")  # no loop: it stops at the end
        for key, yaw, pitch in (("1", 0, 0), ("2", -np.pi / 2, 0), ("3", -np.pi / 2, np.pi / 2), ("4", -0.9, 0.42)):
            page.press(key)
            assert page.run("[seen.yaw, seen.pitch]") == pytest.approx([yaw, pitch])
        page.run("seen.distance *= 3")
        far = page.run("seen.distance")
        page.press("f")
        assert page.run("seen.distance") < 0.5 * far
        page.press("h")
        assert not page.run("part('help').hidden")
        page.picture(pictures / "help.png")
        page.press("h")

        with_marks = ink(page.picture())
        page.press("m")
        assert (ink(page.picture()) != with_marks).any()
        page.press("m")
        page.choose("deformation", "2")
        page.settle()
        moved = page.run("[...runs[0].r_]")
        r = result.mesh.r0 + 2.0 * (result.r[39] - result.mesh.r0)
        assert np.allclose(np.array(moved).reshape(-1, 3), r, atol=1e-4)

        page.press("s")
        photo = tmp_path / "three-rod-frame.png"
        page.wait("true")
        for _ in range(200):
            if photo.is_file() and photo.stat().st_size:
                break
            page.run("new Promise((done) => setTimeout(done, 50))")
        assert (ink(photo.read_bytes()) != 255).any()
        page.theme(dark=True)
        assert ink(page.picture(pictures / "dark.png")).mean() < 80
        assert page.errors == []


def test_two_runs_on_one_clock(chromium: Browser, tmp_path: Path, pictures: Path) -> None:
    short = fake_result(order=2, t_end=5.0, instants=21, fails=True, title="other")
    page_file = dx.view([fake_result(), short], tmp_path / "both.html", labels=["one", "two"])
    with chromium.open(f"file://{page_file}#frame=9999", width=800, height=600) as page:
        assert page.run("part('clock').textContent") == "t = 7.8"
        assert page.run("runs.map((run) => clock.frame(run, seen.u))") == [39, 20]  # the second has stopped
        page.run("go(clock.ticks.findIndex((t) => t > 2.49))")
        assert page.run("clock.frame(runs[1], seen.u)") == pytest.approx(10.0, abs=1e-4)
        both = ink(page.picture(pictures / "both.png"))
        page.run("document.querySelectorAll('.swatch')[1].click()")
        assert (ink(page.picture()) != both).any()
        assert page.run("part('runs').textContent").count("audit") == 2
        assert page.errors == []


@pytest.mark.parametrize("case", ["one instant", "a mode", "a path that turns back"])
def test_odd_runs(case: str, chromium: Browser, tmp_path: Path, pictures: Path) -> None:
    result = fake_result("static", instants=9)
    path = tmp_path / "run.html"
    if case == "a mode":
        n, q = len(result.mesh.r0), result.strain.shape[1]
        shape, none = np.ones((1, n, 6)), np.zeros((1, q, 6))
        state = result.r[-1], result.R[-1], result.strain[-1], result.force[-1]
        modes = Modes(
            np.ones(1),
            np.ones(1),
            shape,
            result.mesh,
            np.ones(1, complex),
            np.zeros(1),
            np.zeros((1, 3)),
            none,
            none,
            state,
        )
        modes.view(path)
    elif case == "one instant":
        energy = replace(result.energy, kinetic=np.zeros(1), stored=np.full(1, 2.5), work=np.full(1, 2.5))
        cut = {name: getattr(result, name)[-1:] for name in ("t", "r", "R", "v", "strain", "force")}
        replace(result, energy=energy, **cut).view(path)
    else:
        replace(result, t=np.array([0, 1, 2, 3, 2, 1, 2, 3, 4.0])).view(path)
    with chromium.open(f"file://{path}", width=640, height=480) as page:
        page.picture(pictures / f"{case}.png")
        if case == "a mode":
            assert page.run("page.mode")
            page.choose("deformation", "0")
            page.settle()
            assert np.allclose(page.run("[...runs[0].r_]"), result.r[-1].ravel(), atol=1e-5)
        elif case == "one instant":
            assert page.run("part('play').disabled")
        else:
            assert page.run("[clock.rising, clock.last, part('clock').textContent]") == [False, 8, "load factor = 4"]
        assert page.errors == []


def test_without_webgl_the_energies_are_left(chromium: Browser, tmp_path: Path) -> None:
    page_file = fake_result().view(tmp_path / "run.html")
    bare = """
        const own = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind) {
            return kind === "2d" ? own.call(this, kind) : null;
        };
    """
    with chromium.open(f"file://{page_file}#frame=10", width=640, height=480, first=bare) as page:
        assert not page.run("part('refusal').hidden")
        assert page.run("part('clock').textContent") == "t = 2"
        assert "2.5" in page.run("part('legend').textContent")
        page.press("s")
        assert page.errors == []
