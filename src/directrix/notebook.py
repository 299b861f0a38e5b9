"""What a notebook shows: a model or a result as a small table beside a picture, and how far a run is.

Every text from outside is escaped; the picture is static SVG in the colours of the page around it.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from directrix.telling import time_left

if TYPE_CHECKING:
    from directrix.audit import Entry
    from directrix.model import Model
    from directrix.result import Result

Array = NDArray[np.float64]

__all__ = ["model_html", "result_html", "shower", "sketch"]

WIDTH, HEIGHT, MARGIN = 300.0, 200.0, 18.0
ROD = "#4f87b8"
NAMES_AT_MOST, POINTS_AT_MOST = 12, 400
VIEW = -0.9, 0.42  # yaw and pitch, those of the HTML page
EVERY = 0.2  # seconds between two showings


def model_html(model: Model) -> str:
    """A model: what it has, and its reference."""
    lines = [rod.curve.position(np.linspace(0.0, rod.curve.length, 33)) for rod in model.rods]
    places = {name: np.array(node.at, float) for node in model.nodes for name in [node.name]}
    for rod, points in zip(model.rods, lines, strict=True):
        places |= {rod.ends[0]: points[0], rod.ends[1]: points[-1]}
    counts = {
        "rods": len(model.rods), "elements": sum(rod.elements for rod in model.rods),
        "supports": len({given.node for given in (*model.supports, *model.prescribed)}), "loads": len(model.loads),
        "joints": len(model.joints), "springs, dashpots, cables": len(model.links), "bodies": len(model.bodies),
        "contacts": len(model.contacts) + len(model.rod_contacts),
        "actuations, tendons": len(model.actuations) + len(model.tendons),
    }  # fmt: skip
    rows = [(name, str(count)) for name, count in counts.items() if count or name in ("rods", "supports", "loads")]
    return _card(model.name, rows, sketch(lines, (), places))


def result_html(result: Result) -> str:
    """A result: how it ended, its audit, and its last shape over the reference."""
    from directrix.drawing import axis_line, clock

    mesh, last = result.mesh, result.r[-1]
    rows = [
        ("status", f"{'done' if result.success else 'NOT DONE'}: {result.status}"),
        (clock(result), f"{result.t[0]:.6g} … {result.t[-1]:.6g}, {len(result.t)} instants saved"),
        ("steps", f"{result.iterations.size}, {int(result.iterations.sum())} Newton iterations"),
        ("rods, nodes", f"{len(mesh.rods)}, {len(mesh.r0)}"),
        ("energy", f"kinetic {result.energy.kinetic[-1]:.6g}, stored {result.energy.stored[-1]:.6g}"),
        *((f"audit of {e.law}", f"off by {e.value:.1e} of {e.limit:.0e}{_claim(e)}") for e in result.audit.entries),
        ("audit", result.audit.verdict),
    ]  # fmt: skip
    places = {name: last[k] for name, k in mesh.node_names.items()}
    shape, reference = ([axis_line(rod, r) for rod in mesh.rods] for r in (last, mesh.r0))
    return _card(result.name, rows, sketch(shape, reference, places))


def _claim(entry: Entry) -> str:
    return "" if entry.claimed else ", not claimed"


def sketch(lines: Sequence[Array], ghosts: Sequence[Array], places: Mapping[str, Array]) -> str:
    """Lines (k, 3) over ``ghosts`` as SVG, seen from a corner or, when all of it is plane, straight on."""
    every = [*lines, *ghosts, *(place[None] for place in places.values())]
    if not every or not all(np.isfinite(points).all() for points in every):
        return ""
    points = np.concatenate(every)
    onto = _look(np.ptp(points, axis=0))
    flat = points @ onto.T
    low, span = flat.min(axis=0), np.ptp(flat, axis=0)
    scale = min((s - 2.0 * MARGIN) / max(w, 1e-300) for s, w in zip((WIDTH, HEIGHT), span, strict=True))
    shift = 0.5 * (np.array([WIDTH, HEIGHT]) - scale * span)

    def place(p: Array) -> Array:
        x = shift + scale * (p @ onto.T - low)
        return np.stack([x[..., 0], HEIGHT - x[..., 1]], -1)

    parts = [_line(place(p), "currentColor", 1.2, 0.35) for p in ghosts] + [
        _line(place(p), ROD, 2.6, 1.0) for p in lines
    ]
    for name, p in list(places.items())[:NAMES_AT_MOST]:
        x, y = place(p).tolist()
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="currentColor"/>')
        side = 'text-anchor="end" ' if x > 0.8 * WIDTH else ""
        parts.append(
            f'<text x="{x - 6 if side else x + 6:.1f}" y="{max(y - 5, 11):.1f}" {side}font-size="11" '
            f'fill="currentColor">{escape(name)}</text>'
        )
    size = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="{WIDTH:g}" height="{HEIGHT:g}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="shape">{"".join(parts)}</svg>'


def _look(span: Array) -> Array:
    """Two directions (2, 3) of the picture."""
    flat = np.flatnonzero(span <= 1e-9 * max(float(span.max()), 1e-300))
    if len(flat):
        kept = [i for i in range(3) if i != flat[-1]]
        return np.eye(3)[kept]
    yaw, pitch = VIEW
    right = (-np.sin(yaw), np.cos(yaw), 0.0)
    up = (-np.sin(pitch) * np.cos(yaw), -np.sin(pitch) * np.sin(yaw), np.cos(pitch))
    return np.array([right, up])


def _line(points: Array, colour: str, width: float, opacity: float) -> str:
    stride = max(1, len(points) // POINTS_AT_MOST)
    spots = " ".join(f"{x:.1f},{y:.1f}" for x, y in [*points[:-1:stride].tolist(), points[-1].tolist()])
    ink = f'stroke="{colour}" stroke-width="{width:g}" stroke-opacity="{opacity:g}"'
    return f'<polyline points="{spots}" fill="none" {ink} stroke-linecap="round" stroke-linejoin="round"/>'


def _card(title: str, rows: Iterable[tuple[str, str]], picture: str) -> str:
    left = 'style="text-align: left"'
    body = "".join(
        f'<tr><th scope="row" {left}>{escape(name)}</th><td {left}>{escape(text)}</td></tr>' for name, text in rows
    )
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start">'
        f"<table><caption {left}><b>{escape(title)}</b></caption><tbody>{body}</tbody></table>{picture}</div>"
    )


def shower() -> Callable[[float, str], None]:
    """What ``progress=True`` is: a bar in a notebook, a line that is written over in a terminal, else lines now and
    then."""
    show = _notebook_bar() or _terminal_line
    every = EVERY if show is not _terminal_line or sys.stderr.isatty() else 5.0
    started = shown = 0.0

    def progress(done: float, text: str) -> None:
        nonlocal started, shown
        now = time.monotonic()
        started = started or now
        if done >= 1.0 or now - shown >= every:
            shown = now
            left = time_left(done, now - started)
            show(done, f"{text}, {left}" if left else text)

    return progress


def _terminal_line(done: float, text: str) -> None:
    said = f"{done:4.0%}  {text}"
    if sys.stderr.isatty():
        print(f"\r\x1b[K{said}", end="\n" if done >= 1.0 else "", file=sys.stderr, flush=True)
    else:
        print(said, file=sys.stderr, flush=True)


def _notebook_bar() -> Callable[[float, str], None] | None:
    """What draws a bar in the cell that runs; None outside notebooks."""
    if "IPython" not in sys.modules or find_spec("IPython") is None:
        return None
    shell: Any = sys.modules["IPython"].get_ipython()
    if shell is None or not hasattr(shell, "kernel"):
        return None
    import_module("IPython.display")
    page: Any = sys.modules["IPython.display"]
    handle: Any = None

    def show(done: float, text: str) -> None:
        nonlocal handle
        bar: Any = page.HTML(
            f'<progress max="1" value="{done:.4f}" style="width: 180px"></progress> {done:.0%} {escape(text)}'
        )
        if handle is None:
            handle = page.display(bar, display_id=True)
        else:
            handle.update(bar)

    return show
