"""One self-contained HTML page of a result: nothing is fetched, nothing installed; it opens from a mail."""

from __future__ import annotations

import html
import json
import re
from base64 import b64encode
from hashlib import sha256
from importlib.resources import files
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from directrix import checks
from directrix.drawing import evenly
from directrix.errors import ModelError
from directrix.result import Result, RodMesh

__all__ = ["write_html"]

SCRIPTS = ("model.js", "scene.js", "page.js", "chart.js", "hands.js")  # one script, in this order
FRAMES_AT_MOST = 600
BYTES_AT_MOST = 24_000_000  # of frames, before base64 adds a third: a page that browsers still open at once


def write_html(result: Result, path: str | PathLike[str]) -> str:
    """Write the run as one offline HTML page with its own WebGL drawing; returns the path.

    At most 600 instants are kept, fewer for very large models; the page says how many of how many.
    Raises ModelError when the file cannot be written (its folder is missing, say) and when the result holds
    numbers that are not finite.
    """
    file, page = checks.file(path, "path"), _page(result)
    try:
        file.write_text(page, encoding="utf-8", newline="\n")
    except OSError as error:
        raise ModelError(f"cannot write {file}: {error.strerror}", "choose a file in a folder that exists") from None
    return str(file)


def _page(result: Result) -> str:
    style = _part("page.css")
    script = "\n".join(_part(name) for name in SCRIPTS)
    # only this style and this script may run, and nothing may be fetched: names in a model stay text
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "base-uri 'none'; form-action 'none'"
    )
    parts = {
        "policy": policy,
        "title": html.escape(result.name),
        "style": style,
        "script": script,
        "data": _inert(json.dumps(_data(result), ensure_ascii=True, allow_nan=False)),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _part("page.html"))


def _data(result: Result) -> dict[str, Any]:
    """What the page knows: words as they are, numbers as little-endian float32 in base64."""
    count, nodes = result.r.shape[:2]
    stations = result.strain.shape[1]
    room = BYTES_AT_MOST // (4 * (9 * nodes + 12 * stations))
    kept = max(2, min(FRAMES_AT_MOST, room))
    picked = evenly(kept, count)
    audit, info, energy = result.audit, result.info, result.energy
    scheme = [str(info[key]) for key in ("integrator", "formulation") if key in info]
    return {
        "title": result.name,
        "kind": result.kind,
        "about": [f"{result.kind} run", *scheme, f"{nodes} nodes"],
        "status": str(result.status),
        "success": result.success,
        "verdict": audit.verdict,
        "passed": audit.passed,
        "notes": list(audit.notes),
        "instants": count,
        "frames": len(picked),
        "nodes": nodes,
        "stations": stations,
        "names": [[name, int(node)] for name, node in result.mesh.node_names.items()],
        "loose": result.mesh.loose.tolist(),
        "joints": result.mesh.joint_nodes.tolist(),  # base and what moves, −1 the ground
        "rods": [_rod(rod) for rod in result.mesh.rods],
        "arrays": {
            "r0": _packed(result.mesh.r0, "reference positions"),
            "arms": _packed(result.mesh.joint_arms, "arms of joints"),
            "t": _packed(result.t[picked], "times"),
            "r": _packed(result.r[picked], "positions"),
            "turn": _packed(np.swapaxes(result.R[picked], -1, -2)[..., :2, :], "rotations"),  # first two columns
            "strain": _packed(result.strain[picked], "strains"),
            "force": _packed(result.force[picked], "section forces"),
            "kinetic": _packed(energy.kinetic[picked], "kinetic energies"),
            "stored": _packed(energy.stored[picked], "stored energies"),
            "work": _packed(energy.work[picked], "work"),
        },
    }


def _rod(rod: RodMesh) -> dict[str, Any]:
    return {
        "name": rod.name,
        "order": rod.order,
        "nodes": rod.nodes.tolist(),
        "first": rod.first_station,
        "arrays": {
            "s": _packed(rod.s, rod.name),
            "directors": _packed(np.swapaxes(rod.directors, -1, -2)[:, :2], rod.name),
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
