"""The motion as a file: GIF with what matplotlib brings along, MP4 with an encoder from the extra ``movie``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix import checks
from directrix import drawing as draw
from directrix.errors import ModelError
from directrix.result import Result, RodMesh

Array = NDArray[np.float64]

__all__ = ["FIELDS", "write_movie"]

PICTURES_AT_MOST = 5000
FIELDS = {
    "axial": ("force", "axial force N3"), "shear": ("force", "shear force |N1, N2|"),
    "bending": ("force", "bending moment |M1, M2|"), "torsion": ("force", "torsion M3"),
    "curvature": ("strain", "curvature |Ω1, Ω2|"), "stretch": ("strain", "axial strain Γ3"),
    "density": ("density", "strain energy density"), "speed": ("v", "speed"),
}  # fmt: skip
OF = {"axial": [2], "stretch": [2], "shear": [0, 1], "bending": [3, 4], "curvature": [3, 4], "torsion": [5]}


def write_movie(
    result: Result, path: str | PathLike[str], *, seconds: float | None = None, fps: int = 25, width: int = 720,
    height: int = 540, field: str | None = None,
) -> str:  # fmt: skip
    """Write the motion to a .gif or .mp4 file; returns its path.

    Parameters
    ----------
    result
        A run of two instants or more.
    path
        The file; its ending says the format.
    seconds
        How long it lasts; the time of the run, but 4 to 12 seconds, unless given. Statics: by load factor, or by the
        saved instants where that turns back.
    fps
        Pictures per second, at most 60; of a GIF the nearest that whole hundredths of a second allow.
    width, height
        Of a picture, in pixels.
    field
        "axial", "shear", "bending", "torsion", "curvature", "stretch", "density" or "speed": coloured by that.

    Raises
    ------
    ModelError
        What was asked for cannot be; matplotlib, or the encoder of MP4, is missing; the file cannot be written.
    """
    file = checks.file(path, "path")
    kind = file.suffix.lower()
    if kind not in (".gif", ".mp4"):
        raise ModelError(f"{file} is no movie that can be written", "end it in .gif or .mp4")
    if len(result.t) < 2:
        raise ModelError("one instant is no motion", "save more of the run, or draw it with result.plot.shape()")
    span = float(result.t[-1] - result.t[0])
    given = min(12.0, max(4.0, span if result.kind == "dynamic" else 4.0)) if seconds is None else seconds
    seconds, fps = checks.number(given, "seconds", above=0.0), checks.whole(fps, "fps", 1, 60)
    width, height = (checks.whole(size, what, 64, 4096) for size, what in ((width, "width"), (height, "height")))
    count = max(2, round(seconds * fps))
    if count > PICTURES_AT_MOST:
        raise ModelError(f"{count} pictures are too many for a movie", f"make it shorter: at most {PICTURES_AT_MOST}")
    values = None if field is None else _field(result, field)
    draw.need_matplotlib()
    write = _gif if kind == ".gif" else _encoder()
    if file.is_dir() or not file.parent.is_dir():
        raise ModelError(f"cannot write {file}", "choose a file in a folder that exists")
    try:
        # whole macroblocks: what is not would be scaled by the encoder
        write(file, _pictures(result, count, width // 16 * 16, height // 16 * 16, values, field), fps)
    except OSError as error:
        raise ModelError(f"cannot write {file}: {error.strerror or error}", "check space and permissions") from None
    return str(file)


def _field(result: Result, field: str) -> Array:
    """Values (nt, stations), or (nt, n) on nodes."""
    name = checks.choice(field, "field", FIELDS)
    values: Array = getattr(result, FIELDS[name][0])
    if not values.size or (name == "speed" and not np.any(values)):
        raise ModelError(f"this result has no {FIELDS[name][1]}", "colour by another field")
    if name == "density":
        return values
    part = values if name == "speed" else values[..., OF[name]]
    return part[..., 0] if part.shape[-1] == 1 else np.linalg.norm(part, axis=-1)


def _pictures(
    result: Result, count: int, width: int, height: int, values: Array | None, field: str | None
) -> Iterator[Array]:
    """Pictures (height, width, 3) of bytes; between two saved instants positions are interpolated."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(width / 100, height / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    stage = draw.stage_in(figure, result)
    draw.ghost(stage, result)
    stage.finish(result.name)
    _all_in_sight(stage, result)
    paint = _painter(stage, result, values, field)
    moving: set[Any] = set()
    clock = result.t if draw.rises(result) else np.arange(len(result.t), dtype=float)
    times: list[float] = np.linspace(float(clock[0]), float(clock[-1]), count).tolist()
    for t in times:
        k = min(int(np.searchsorted(clock, t, "right")) - 1, len(clock) - 2)
        a = float((t - clock[k]) / (clock[k + 1] - clock[k]))
        for artist in moving:
            artist.remove()
        before = set(stage.ax.get_children())
        paint(k, a)
        moving = set(stage.ax.get_children()) - before
        shown = (1.0 - a) * result.t[k] + a * result.t[k + 1]
        stage.ax.set_title(f"{draw.plain(result.name)}, {draw.clock(result)} = {shown:.3f}", fontsize=11)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _painter(stage: Any, result: Result, values: Array | None, field: str | None) -> Callable[[int, float], None]:
    """Draws the rods between instants k and k + 1."""
    if values is None or field is None:

        def plain(k: int, a: float) -> None:
            r = (1.0 - a) * result.r[k] + a * result.r[k + 1]
            for rod in result.mesh.rods:
                stage.line(draw.axis_line(rod, r), color=draw.BLUE, lw=3.0, solid_capstyle="round")

        return plain
    from matplotlib import colormaps, colors
    from matplotlib.cm import ScalarMappable

    low, high = float(values.min()), float(values.max())
    most = max(abs(low), abs(high)) or 1.0
    signed = low < 0.0
    hues: Any = (
        colormaps["coolwarm"] if signed else colors.ListedColormap(colormaps["viridis"](np.linspace(0, 0.9, 256)))
    )
    norm: Any = colors.Normalize(-most if signed else 0.0, most)
    stage.ax.figure.colorbar(ScalarMappable(norm, hues), ax=stage.ax, label=FIELDS[field][1], shrink=0.7, pad=0.1)

    def coloured(k: int, a: float) -> None:
        r, now = ((1.0 - a) * of[k] + a * of[k + 1] for of in (result.r, values))
        for rod in result.mesh.rods:
            line = draw.axis_line(rod, r)
            stage.coloured(line, hues(norm(_along(rod, now, len(line), field == "speed"))), lw=3.2)

    return coloured


def _along(rod: RodMesh, values: Array, points: int, nodal: bool) -> Array:
    """Values (points − 1,) in the middle of the pieces of a rod's axis."""
    at = rod.s if nodal else rod.stations
    own = values[rod.nodes] if nodal else values[rod.first_station : rod.first_station + len(rod.stations)]
    cuts = (points - 1) // ((len(rod.s) - 1) // rod.order)
    ends = rod.s[:: rod.order]
    s = np.append((ends[:-1, None] + np.diff(ends)[:, None] * np.arange(cuts) / cuts).ravel(), ends[-1])
    return np.interp(0.5 * (s[:-1] + s[1:]), at, own)


def _all_in_sight(stage: Any, result: Result) -> None:
    """One box for all pictures."""
    points = np.concatenate([result.mesh.r0[None], result.r]).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    reach = np.maximum(high - low, 0.25 * float((high - low).max()) or 1.0) * 0.54
    middle = 0.5 * (low + high)
    letters = "xyz"[: len(stage.shown)]
    for letter, i in zip(letters, stage.shown, strict=True):
        getattr(stage.ax, f"set_{letter}lim")(middle[i] - reach[i], middle[i] + reach[i])
    if len(stage.shown) == 3:
        stage.ax.set_box_aspect(reach, zoom=0.95)
    else:
        stage.ax.set_aspect("equal", adjustable="box")


def _gif(file: Path, pictures: Iterator[Array], fps: int) -> None:
    from PIL import Image

    first, *rest = (Image.fromarray(picture) for picture in pictures)
    # one palette for all: colours that flicker from picture to picture are worse than few colours
    palette = rest[len(rest) // 2].quantize(128)
    few = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in (first, *rest)]
    few[0].save(
        file, save_all=True, append_images=few[1:], duration=max(2, round(100 / fps)) * 10, loop=0, optimize=False
    )


def _encoder() -> Callable[[Path, Iterator[Array], int], None]:
    try:
        ffmpeg: Any = import_module("imageio_ffmpeg")
    except ModuleNotFoundError:
        raise ModelError(
            "MP4 needs imageio-ffmpeg, which is not installed", 'pip install "directrix[movie]", or write a .gif'
        ) from None

    def write(file: Path, pictures: Iterator[Array], fps: int) -> None:
        first = next(pictures)
        size = first.shape[1], first.shape[0]
        film = ffmpeg.write_frames(str(file), size, fps=fps, codec="libx264", pix_fmt_out="yuv420p", quality=8)
        film.send(None)
        try:
            film.send(np.ascontiguousarray(first))
            for picture in pictures:
                film.send(np.ascontiguousarray(picture))
        finally:
            film.close()

    return write
