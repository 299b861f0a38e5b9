"""What a run leaves: machine-readable summary, monitor table, pictures. Its folder is in :mod:`directrix.keeping`."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from directrix.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from directrix.result import Result

__all__ = ["exit_code", "summary"]

Json: TypeAlias = "dict[str, Json] | list[Json] | str | int | float | bool | None"

RESULT, SUMMARY, MONITOR, VIEW = "result.vtkhdf", "run.json", "monitor.csv", "view.html"
COLUMNS = ("kinetic", "stored", "total", "work", "dissipated", "residual", "Lx", "Ly", "Lz", "Jx", "Jy", "Jz")
MANY = 4096
PICTURES, BESIDE = ("energy", "momentum", "motion"), "comparison.png"
WHY = "convergence"  # drawn when a run did not converge
RECORDS = "record-*.csv"  # of the points that a case records, written while it runs
OURS = {RESULT, SUMMARY, MONITOR, VIEW, BESIDE, *(f"{p}.png" for p in (*PICTURES, WHY))}


def exit_code(result: Result) -> int:
    """0 done, 3 not converged, 4 the audit failed, 130 interrupted."""
    if result.status.code == "interrupted":
        return 130
    if not result.success:
        return 3
    return 0 if result.audit.passed else 4


def draw_all(path: Path, result: Result, beside: Mapping[str, Result]) -> Iterator[Path]:
    """Write the animation and, with matplotlib, the pictures to the folder ``path``; yields each path when it is there.

    ``beside`` (may be empty) maps labels, the result's own first, to what goes into one picture.
    """
    yield Path(result.view(path / VIEW))
    if can_draw():
        pictures = [p for p in PICTURES if p != "momentum" or result.kind == "dynamic"]
        if result.status.code in ("not_converged", "singular", "non_finite") and result.trail.rows.size:
            pictures.append(WHY)
        yield from (draw(result, p, path / f"{p}.png") for p in pictures)
        if beside:
            from directrix.comparison import compare_energy_momentum

            yield Path(compare_energy_momentum(beside, path / BESIDE))


def written(path: Path) -> Iterator[Path]:
    """The files that every run leaves in its folder ``path``, and those that this one recorded."""
    yield from (path / name for name in (RESULT, SUMMARY, MONITOR))
    yield from sorted(path.glob(RECORDS))


def can_draw() -> bool:
    """True when matplotlib is installed."""
    return find_spec("matplotlib") is not None


def draw(result: Result, picture: str, path: Path, **options: Any) -> Path:
    """One of ``result.plot`` into a file; the ending says the format. Needs no display.

    Raises ModelError without matplotlib or for what cannot be drawn, InputError for an unknown ending.
    """
    if can_draw():
        import matplotlib

        matplotlib.use("Agg")
    figure = getattr(result.plot, picture)(**options).get_figure()
    formats = figure.canvas.get_supported_filetypes()
    if path.suffix.lstrip(".").lower() not in formats:
        raise InputError("is no picture that can be written", f"use one of the endings {', '.join(formats)}", str(path))
    figure.savefig(path, dpi=150)
    from matplotlib import pyplot

    pyplot.close(figure)
    return path


def summary(result: Result, saved: Path) -> dict[str, Json]:
    """What ``run.json`` holds of a result and the file that it was saved to."""
    energy, audit, steps = result.energy, result.audit, result.iterations
    return {
        "program": "directrix",
        "title": result.name,
        "status": {
            "code": result.status.code,
            "sentence": result.status.sentence,
            "advice": result.status.advice,
            "success": result.success,
            "complete": result.success and audit.passed,
            "exit_code": exit_code(result),
        },
        "result": {"path": saved.name, "sha256": sha256(saved)},
        "kind": result.kind,
        "info": {k: v if isinstance(v, (bool, int, float)) else str(v) for k, v in result.info.items()},
        "turning_points": [asdict(point) for point in result.turning_points],
        "stability": _stability(result),
        "steps": {
            "taken": int(steps.size),
            "saved_instants": int(result.t.size),
            "last_t": float(result.t[-1]),
            "iterations": int(steps.sum()),
            "most_iterations": int(steps.max(initial=0)),
            "cuts": int(result.info.get("cuts", 0)),
            "rejected": int(result.info.get("rejected", 0)),
            "shortest": float(result.dt.min()) if result.dt.size else None,
            "longest": float(result.dt.max()) if result.dt.size else None,
        },
        "energy": {
            name: {"first": float(h[0]), "last": float(h[-1]), "largest": float(abs(h).max())}
            for name, h in (
                ("kinetic", energy.kinetic),
                ("stored", energy.stored),
                ("total", energy.total),
                ("work", energy.work),
                ("dissipated", energy.dissipated),
                ("residual", energy.residual),
            )
        },
        "work_by_source": {name: float(done[-1]) for name, done in energy.work_by_source.items()},
        "dissipated_by_source": {name: float(taken[-1]) for name, taken in energy.by_source.items()},
        "audit": {
            "passed": audit.passed,
            "verdict": audit.verdict,
            "laws": [
                {
                    "law": e.law,
                    "deviation": e.value,
                    "limit": e.limit,
                    "relative_to": e.relative_to,
                    "claimed": e.claimed,
                    "holds": e.holds,
                }
                for e in audit.entries
            ],
            "largest_turn_rad": audit.largest_turn,
            "largest_turn_where": audit.largest_turn_where,
            "director_loss": audit.director_loss,
            "notes": list(audit.notes),
        },
    }


def _stability(result: Result) -> Json:
    """Negative pivots of the saved instants and the critical points, without their modes."""
    if result.stability is None:
        return None
    return {
        "negative_pivots": result.stability.negative.tolist(),
        "critical_points": [
            {
                "kind": p.kind, "load_factor": p.load_factor, "arc_length": p.arc_length, "index": p.index,
                "negative_before": p.before, "negative_after": p.after, "modes": len(p.modes),
            }
            for p in result.stability.points
        ],
    }  # fmt: skip


def monitor(result: Result) -> Iterator[bytes]:
    """One row per saved instant, full precision; some thousand at a time, since numbers as Python's own take room."""
    energy, momentum = result.energy, result.momentum
    columns = [
        result.t, energy.kinetic, energy.stored, energy.total, energy.work, energy.dissipated, energy.residual,
        *momentum.linear.T, *momentum.angular.T,
    ]  # fmt: skip
    names = columns_of(result.kind)
    if result.dt.size:
        names, columns = (*names, "dt", "cuts"), [*columns, *_last_steps(result)]
    yield (",".join(names) + "\n").encode()
    for first in range(0, len(result.t), MANY):
        rows = zip(*(c[first : first + MANY].tolist() for c in columns), strict=True)
        yield "".join(",".join(map(repr, row)) + "\n" for row in rows).encode()


def columns_of(kind: str) -> tuple[str, ...]:
    """The head of the monitor while a run goes on; behind it are the steps in the end."""
    return ("t" if kind == "dynamic" else "load_factor", *COLUMNS)


def _last_steps(result: Result) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """At every saved instant the length of the step that ended there, and how many were thrown away so far."""
    ends = result.t[0] + np.cumsum(result.dt)
    slack = 0.25 * float(result.dt.min(initial=np.inf))  # sums of steps round off
    behind = np.asarray(np.searchsorted(ends, result.t + slack), np.int64)
    return np.concatenate([[0.0], result.dt])[behind], np.concatenate([[0], np.cumsum(result.cuts)])[behind]


def sha256(path: Path) -> str:
    """Of the bytes of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def few(names: list[str]) -> str:
    """The first of some names."""
    return ", ".join(names[:3]) + (" …" if len(names) > 3 else "")


def finite(value: Json) -> Json:
    """JSON has no NaN: null stands for what is not a number."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
