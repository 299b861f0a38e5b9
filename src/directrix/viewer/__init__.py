"""One self-contained HTML page of results: nothing is fetched, nothing installed; it opens from a mail."""

from __future__ import annotations

import html
import json
import re
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from hashlib import sha256
from importlib.resources import files
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix import checks
from directrix.drawing import evenly
from directrix.errors import ModelError
from directrix.result import Result, RodMesh

Array = NDArray[np.float64]

__all__ = ["page_data", "page_text", "view", "write_html"]

# one script, in this order
SCRIPTS = ("model.js", "fields.js", "scene.js", "symbols.js", "page.js", "space.js", "chart.js", "hands.js")
LIVE = "live.js"  # behind them on the page of a run that goes on, the only one that asks for anything
FRAMES_AT_MOST = 600
BYTES_AT_MOST = 24_000_000  # of frames, before base64 adds a third: a page that browsers still open at once
RUNS_AT_MOST = 8  # colours
UNITS = {
    "force": "force", "moment": "force·length", "length": "length", "per_length": "1/length",
    "energy_per_length": "energy/length", "speed": "length/time",
}  # fmt: skip


def view(
    results: Result | Sequence[Result], path: str | PathLike[str] = "view.html", *, labels: Sequence[str] | None = None
) -> str:
    """Write one offline HTML page of one result or of several over one another; returns the path.

    Parameters
    ----------
    results
        One result or up to eight, all of them static or all dynamic. Motions run on one clock; one that ends earlier
        stays at its end. Where load factors turn back the saved instants are counted instead.
    path
        The file to write.
    labels
        What to call each result; its name unless given.

    At most 600 instants are kept, fewer for very large models; the page says how many of how many, and its size.

    Raises
    ------
    ModelError
        Results that cannot share a page, numbers that are not finite, a file that cannot be written.
    """
    runs = (results,) if isinstance(results, Result) else tuple(results)
    if not 1 <= len(runs) <= RUNS_AT_MOST or not all(isinstance(run, Result) for run in runs):  # pyright: ignore
        raise ModelError(f"{checks.shown(results)} are no results to view", f"give 1 to {RUNS_AT_MOST} results")
    if len({run.kind for run in runs}) > 1:
        raise ModelError("static and dynamic results have no clock in common", "view them on pages of their own")
    named = tuple(run.name for run in runs) if labels is None else tuple(labels)
    if len(named) != len(runs) or not all(isinstance(name, str) for name in named):  # pyright: ignore
        raise ModelError(f"labels = {checks.shown(labels)} are not {len(runs)} texts", "give one for each result")
    return _write(page_text(page_data(runs, named)), path)


def write_html(result: Result, path: str | PathLike[str], *, base: tuple[Array, Array] | None = None) -> str:
    """Write one run; ``base``, positions (n, 3) and rotations (n, 3, 3), is what displacements are multiplied from when
    the deformation is exaggerated, the reference unless given. See :func:`view`."""
    return _write(page_text(page_data((result,), (result.name,), base)), path)


def _write(page: str, path: str | PathLike[str]) -> str:
    file = checks.file(path, "path")
    try:
        file.write_text(page, encoding="utf-8", newline="\n")
    except OSError as error:
        raise ModelError(f"cannot write {file}: {error.strerror}", "choose a file in a folder that exists") from None
    return str(file)


def page_text(data: dict[str, Any]) -> str:
    """The page that shows ``data``."""
    style, live = _part("page.css"), bool(data["live"])
    script = "\n".join(_part(name) for name in (*SCRIPTS, *([LIVE] if live else ())))
    # only this style and this script may run, and nothing may be fetched: names in a model stay text
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "base-uri 'none'; form-action 'none'" + ("; connect-src 'self'" if live else "")
    )
    parts = {"policy": policy, "title": html.escape(data["title"]), "style": style, "script": script}
    frame = _part("page.html")
    size = sum(map(len, (frame, style, script))) + len(json.dumps(data))
    data = {**data, "size": "" if live else f"{size / 1e6:.2g} MB"}
    parts["data"] = _inert(json.dumps(data, ensure_ascii=True, allow_nan=False))
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], frame)


def page_data(
    results: Sequence[Result], labels: Iterable[str], base: tuple[Array, Array] | None = None
) -> dict[str, Any]:
    """What the page knows: words as they are, numbers as little-endian float32 in base64."""
    runs = [_run(run, label, BYTES_AT_MOST // len(results), base) for run, label in zip(results, labels, strict=True)]
    first, info = results[0], results[0].info
    scheme = [str(info[key]) for key in ("integrator", "formulation") if key in info and len(runs) == 1]
    return {
        "title": first.name if len(runs) == 1 else " and ".join(dict.fromkeys(run.name for run in results)),
        "about": [f"{first.kind} run" if len(runs) == 1 else f"{len(runs)} {first.kind} runs", *scheme]
        + ([f"{len(first.mesh.r0)} nodes"] if len(runs) == 1 else []),
        "units": _units(info.get("units")),
        "mode": base is not None,
        "live": 0,  # a page that asks for more has counted what it has
        "runs": runs,
    }


def _units(given: object) -> dict[str, str]:
    """Units of what is coloured: those of the case, or the words for what any consistent set has."""
    if not isinstance(given, dict) or not {"force", "length", "time"} <= {*given}:
        return UNITS
    force, length, time = (str(given[key]) for key in ("force", "length", "time"))  # pyright: ignore
    return {
        "force": force, "moment": f"{force}·{length}", "length": length, "per_length": f"1/{length}",
        "energy_per_length": f"{force}·{length}/{length}", "speed": f"{length}/{time}",
    }  # fmt: skip


def _run(result: Result, label: str, budget: int, base: tuple[Array, Array] | None) -> dict[str, Any]:
    count, nodes = result.r.shape[:2]
    stations = result.strain.shape[1]
    kept = max(2, min(FRAMES_AT_MOST, budget // (4 * (10 * nodes + 13 * stations))))
    picked = evenly(kept, count)
    audit, energy, mesh = result.audit, result.energy, result.mesh
    gravity = [mark.vector for mark in mesh.marks if mark.kind == "gravity" and any(mark.vector)]
    arrays = {
        "r0": _packed(mesh.r0, "reference positions"),
        "arms": _packed(mesh.joint_arms, "arms of joints"),
        "t": _packed(result.t[picked], "times"),
        "r": _packed(result.r[picked], "positions"),
        "turn": _packed(_two_columns(result.R[picked]), "rotations"),
        "strain": _packed(result.strain[picked], "strains"),
        "force": _packed(result.force[picked], "section forces"),
        "density": _packed(result.density[picked] if result.density.size else [], "stored energies per length"),
        "speed": _packed(np.linalg.norm(result.v[picked], axis=-1) if np.any(result.v) else [], "speeds"),
        "kinetic": _packed(energy.kinetic[picked], "kinetic energies"),
        "stored": _packed(energy.stored[picked], "stored energies"),
        "work": _packed(energy.work[picked], "work"),
    }
    if base is not None:
        arrays |= {"base_r": _packed(base[0], "positions"), "base_turn": _packed(_two_columns(base[1]), "rotations")}
    return {
        "label": label,
        "kind": result.kind,
        "status": str(result.status),
        "success": result.success,
        "verdict": audit.verdict,
        "passed": audit.passed,
        "notes": list(audit.notes),
        "instants": count,
        "frames": len(picked),
        "nodes": nodes,
        "stations": stations,
        "names": [[name, int(node)] for name, node in mesh.node_names.items()],
        "loose": mesh.loose.tolist(),
        "joints": mesh.joint_nodes.tolist(),  # base and what moves, −1 the ground
        "marks": [
            asdict(mark) for mark in mesh.marks if mark.kind != "gravity"
        ],
        "gravity": np.sum(gravity, axis=0).tolist() if gravity else None,
        "rods": [_rod(rod) for rod in mesh.rods],
        "arrays": arrays,
    }  # fmt: skip


def _two_columns(rotation: Array) -> Array:
    """The first two columns of rotations (…, 3, 3), as rows (…, 2, 3)."""
    return np.swapaxes(rotation, -1, -2)[..., :2, :]


def _rod(rod: RodMesh) -> dict[str, Any]:
    return {
        "name": rod.name,
        "order": rod.order,
        "nodes": rod.nodes.tolist(),
        "first": rod.first_station,
        "arrays": {
            "s": _packed(rod.s, rod.name),
            "directors": _packed(_two_columns(rod.directors), rod.name),
            "stations": _packed(rod.stations, rod.name),
            "outline": _packed(rod.outline, rod.name),
        },
    }


def _packed(values: ArrayLike, what: str) -> str:
    with np.errstate(over="ignore"):
        array = np.asarray(values, "<f4")
    if not np.isfinite(array).all():
        raise ModelError(
            f"{what}: some numbers are not finite (or beyond 3e38), so there is nothing to show",
            "look at result.status; view a run that stopped before the numbers broke",
        )
    return b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


def _inert(text: str) -> str:
    """JSON that cannot end its script element or open a comment in it."""
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _hash(text: str) -> str:
    return "sha256-" + b64encode(sha256(text.encode("utf-8")).digest()).decode("ascii")


def _part(name: str) -> str:
    return files(__package__ or "directrix.viewer").joinpath(name).read_text(encoding="utf-8")
