"""The folder of a run: result file, machine-readable summary, monitor table, pictures."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatch
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from directrix.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from directrix.result import Result
    from directrix.schema import Case

__all__ = ["RunFolder", "exit_code", "summary"]

Json: TypeAlias = "dict[str, Json] | list[Json] | str | int | float | bool | None"

RESULT, SUMMARY, MONITOR, VIEW = "result.vtkhdf", "run.json", "monitor.csv", "view.html"
PICTURES, BESIDE = ("energy", "momentum", "motion"), "comparison.png"
RECORDS = "record-*.csv"  # of the points that a case records, written while it runs
OURS = {RESULT, SUMMARY, MONITOR, VIEW, BESIDE, *(f"{p}.png" for p in PICTURES)}


def exit_code(result: Result) -> int:
    """0 done, 3 not converged, 4 the audit failed, 130 interrupted."""
    if result.status.code == "interrupted":
        return 130
    if not result.success:
        return 3
    return 0 if result.audit.passed else 4


@dataclass(frozen=True)
class RunFolder:
    """A folder that holds one run and nothing else."""

    path: Path

    @classmethod
    def claim(cls, path: Path) -> RunFolder:
        """Make the folder, or take over one that holds an earlier run; refuses any other (InputError)."""
        try:
            path.mkdir(parents=True, exist_ok=True)
            names = {p.name for p in path.iterdir() if not p.name.startswith(".")}
            # found out now, not after an hour of computing
            probe = path / ".directrix-write-test"
            probe.write_bytes(b"")
            probe.unlink()
        except FileExistsError:
            raise InputError("is a file, not a folder", "name another folder with --out", str(path)) from None
        except OSError as error:
            raise InputError(
                f"cannot be written: {error.strerror}", "name another folder with --out", str(path)
            ) from None
        foreign = sorted(name for name in names - OURS if not fnmatch(name, RECORDS))
        if foreign:
            raise InputError(
                f"holds files that are not of a run: {_few(foreign)}",
                "name another folder with --out, or move them away",
                str(path),
            )
        if names and not _is_summary(path / SUMMARY):
            raise InputError(
                f"holds {_few(sorted(names))} but no {SUMMARY} of a run, so nothing in it is overwritten",
                "name another folder with --out, or move them away",
                str(path),
            )
        return cls(path)

    def recording(self, case: Case) -> Case:
        """The case, so that what it records goes here; records of an earlier run go away."""
        for old in self.path.glob(RECORDS):
            old.unlink()
        return replace(case, record_in=self.path)

    def write(self, case: Case, result: Result) -> Iterator[Path]:
        """Write result, summary and monitor, in place of an earlier run's; yields each path when it is there."""
        for name in OURS - {SUMMARY}:
            (self.path / name).unlink(missing_ok=True)
        saved = Path(result.save(self.path / RESULT))
        (self.path / SUMMARY).write_text(
            json.dumps(finite(summary(case, result, saved)), indent=2, ensure_ascii=False, allow_nan=False) + "\n",
            encoding="utf-8",
        )
        yield saved
        yield self.path / SUMMARY
        yield _monitor(self.path / MONITOR, result)

    def draw(self, result: Result, beside: Mapping[str, Result]) -> Iterator[Path]:
        """Write the animation and, with matplotlib, the pictures; yields each path when it is there.

        ``beside`` (may be empty) maps labels, the result's own first, to what goes into one picture.
        """
        yield Path(result.view(self.path / VIEW))
        if can_draw():
            pictures = [p for p in PICTURES if p != "momentum" or result.kind == "dynamic"]
            yield from (draw(result, p, self.path / f"{p}.png") for p in pictures)
            if beside:
                from directrix.comparison import compare_energy_momentum

                yield Path(compare_energy_momentum(beside, self.path / BESIDE))


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


def summary(case: Case, result: Result, saved: Path) -> Json:
    """What ``run.json`` holds."""
    energy, audit, steps = result.energy, result.audit, result.iterations
    return {
        "program": "directrix",
        "title": case.title,
        "status": {
            "code": result.status.code,
            "sentence": result.status.sentence,
            "advice": result.status.advice,
            "success": result.success,
            "exit_code": exit_code(result),
        },
        "input": {"path": str(case.source), "sha256": case.sha256},
        "result": {"path": saved.name, "sha256": _sha256(saved)},
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


def _monitor(path: Path, result: Result) -> Path:
    """One row per saved instant, full precision."""
    energy = result.energy
    dt, cuts = _last_steps(result)
    columns = {
        "t" if result.kind == "dynamic" else "load_factor": result.t,
        "kinetic": energy.kinetic,
        "stored": energy.stored,
        "total": energy.total,
        "work": energy.work,
        "dissipated": energy.dissipated,
        "residual": energy.residual,
        **{f"L{axis}": result.momentum.linear[:, k] for k, axis in enumerate("xyz")},
        **{f"J{axis}": result.momentum.angular[:, k] for k, axis in enumerate("xyz")},
        **({"dt": dt, "cuts": cuts} if result.dt.size else {}),
    }
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(c.tolist() for c in columns.values()), strict=True))
    return path


def _last_steps(result: Result) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """At every saved instant the length of the step that ended there, and how many were thrown away so far."""
    ends = result.t[0] + np.cumsum(result.dt)
    slack = 0.25 * float(result.dt.min(initial=np.inf))  # sums of steps round off
    behind = np.asarray(np.searchsorted(ends, result.t + slack), np.int64)
    return np.concatenate([[0.0], result.dt])[behind], np.concatenate([[0], np.cumsum(result.cuts)])[behind]


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _few(names: list[str]) -> str:
    return ", ".join(names[:3]) + (" …" if len(names) > 3 else "")


def _is_summary(path: Path) -> bool:
    try:
        data: Json = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(data, dict) and data.get("program") == "directrix"


def finite(value: Json) -> Json:
    """JSON has no NaN: null stands for what is not a number."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
