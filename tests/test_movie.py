"""A movie has the pictures that were asked for, and what moves in them is the rod."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_result import fake_result
from PIL import Image
from typer.testing import CliRunner

from directrix import movie
from directrix.cli import app
from directrix.errors import ModelError

SMALL: dict[str, Any] = {"seconds": 0.5, "fps": 10, "width": 320, "height": 240}


def frames(path: str) -> list[Any]:
    with Image.open(path) as film:
        pictures = []
        for k in range(film.n_frames):
            film.seek(k)
            pictures.append(np.asarray(film.convert("RGB")).astype(int))
        assert film.info["duration"] == 100
        return pictures


def test_a_gif_moves(tmp_path: Path) -> None:
    result = fake_result("static", planar=True, order=2)
    pictures = frames(result.movie(tmp_path / "run.gif", **SMALL))
    assert len(pictures) == 5
    assert pictures[0].shape == (240, 320, 3)
    blue = [(p[..., 2] - p[..., 0] > 60) for p in pictures]  # the rod; nothing else is blue
    assert all(0.002 < b.mean() < 0.1 for b in blue)
    assert (blue[0] != blue[-1]).mean() > 0.002


def test_colours_of_a_field(tmp_path: Path) -> None:
    result = fake_result(order=2)
    for field in ("bending", "speed"):
        pictures = frames(result.movie(tmp_path / "run.gif", field=field, **SMALL))
        colours = pictures[-1].reshape(-1, 3)
        assert (np.ptp(colours, axis=1) > 60).mean() > 0.005  # a scale and rods in colour
    values = movie._field(result, "bending")
    assert np.allclose(values, np.hypot(result.force[..., 3], result.force[..., 4]))
    rod = result.mesh.rods[1]
    along = movie._along(rod, np.arange(values.shape[1], dtype=float), 41, nodal=False)
    assert along[0] == rod.first_station and along[-1] == rod.first_station + len(rod.stations) - 1
    assert np.all(np.diff(along) >= 0.0)


@pytest.mark.skipif(find_spec("imageio_ffmpeg") is None, reason="needs imageio-ffmpeg")
def test_an_mp4_plays(tmp_path: Path) -> None:
    import imageio_ffmpeg

    path = fake_result("static", planar=True).movie(tmp_path / "run.mp4", **SMALL)
    reader = imageio_ffmpeg.read_frames(path)
    about = next(reader)
    assert about["size"] == (320, 240) and about["fps"] == 10.0
    pictures = [np.frombuffer(frame, np.uint8).reshape(240, 320, 3) for frame in reader]
    assert len(pictures) == 5
    assert (pictures[0] != pictures[-1]).any()


def test_what_cannot_be_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = fake_result()
    for path, options, said in (
        ("run.avi", {}, "no movie that can be written"), ("run.gif", {"fps": 0}, "fps"),
        ("run.gif", {"seconds": -1}, "seconds"),
        ("run.gif", {"field": "colour"}, "field"), ("run.gif", {"field": "density"}, "no strain energy density"),
        ("run.gif", {"seconds": 1e4}, "too many"), ("no/run.gif", {}, "cannot write"),
    ):  # fmt: skip
        with pytest.raises(ModelError, match=said):
            result.movie(tmp_path / path, **options)
    with pytest.raises(ModelError, match="one instant"):
        fake_result(instants=1).movie(tmp_path / "run.gif")
    monkeypatch.setattr(movie, "import_module", lambda name: (_ for _ in ()).throw(ModuleNotFoundError(name)))
    with pytest.raises(ModelError, match="imageio-ffmpeg") as error:
        result.movie(tmp_path / "run.mp4")
    assert "directrix[movie]" in error.value.fix


def test_the_commands(tmp_path: Path) -> None:
    fake_result("static", planar=True, instants=5).save(tmp_path / "a.vtkhdf")
    fake_result("static", planar=True, instants=9).save(tmp_path / "b.vtkhdf")
    done = CliRunner().invoke(app, ["movie", str(tmp_path / "a.vtkhdf"), "--seconds", "0.2", "--fps", "10"])
    assert done.exit_code == 0 and (tmp_path / "movie.gif").stat().st_size > 1000
    both = [str(tmp_path / name) for name in ("a.vtkhdf", "b.vtkhdf")]
    done = CliRunner().invoke(app, ["view", *both, "--label", "x", "--label", "y"])
    assert done.exit_code == 0 and done.output.endswith(" MB\n")
    assert '"label": "y"' in (tmp_path / "views.html").read_text("utf-8")
