"""The ledger of energy as areas: where it is on top, where it came from below, and what is left in between."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix import drawing as draw
from directrix.quantities import labelled
from directrix.result import Result

Array = NDArray[np.float64]

__all__ = ["ledger", "sides"]

START = "at the start"
KEPT = {"kinetic": "#d2601a", "stored": "#1f6fb4"}
LOST = ("#8a3324", "#b5651d", "#c9a227", "#7a6a53")
GIVEN = ("#2b8a4b", "#5aa897", "#8fbf6b", "#3f6f5e", "#a7c4a0")


def sides(result: Result) -> tuple[dict[str, Array], dict[str, Array]]:
    """What the energy is, and where it came from: name → (nt,), none negative; the residual is their difference.

    Work that a source takes out stands on the first side.
    """
    energy, zero = result.energy, np.zeros(len(result.t))
    sources = energy.work_by_source or {"work": energy.work}
    losses = energy.by_source or ({"dissipated": energy.dissipated} if np.any(energy.dissipated) else {})
    there = {"kinetic": energy.kinetic, "stored": energy.stored}
    there |= {f"dissipated: {name}": a for name, a in losses.items()}
    there |= {f"given to {name}": np.maximum(-a, zero) for name, a in sources.items()}
    came = {START: np.full(len(zero), energy.total[0])}
    came |= {f"work of {name}": np.maximum(a, zero) for name, a in sources.items()}
    least = 1e-12 * max(float(np.abs(a).max()) for side in (there, came) for a in side.values())
    first, second = ({n: a for n, a in side.items() if np.abs(a).max() > least} for side in (there, came))
    return first, second


def ledger(result: Result, ax: Any) -> Any:
    """See :meth:`directrix.plot.Plots.ledger`."""
    there, came = sides(result)
    pen = draw.curves(result, ax)
    t = draw.abscissa(result)
    given, lost = cycle(GIVEN), cycle(LOST)
    _stack(pen, t, there, [KEPT.get(name) or next(lost) for name in there], 1.0)
    _stack(pen, t, came, [draw.GREY if name == START else next(given) for name in came], -1.0)
    pen.axhline(0.0, color=draw.INK, lw=0.8)
    residual = result.energy.residual
    pen.plot(t, residual, color=draw.XYZ[0], lw=1.4, label=f"residual, at most {np.abs(residual).max():.1e}")
    for height, side, said in ((0.98, "top", "what became of it"), (0.02, "bottom", "where it came from")):
        pen.text(0.01, height, said, transform=pen.transAxes, fontsize=9, color=draw.GREY, va=side)
    return draw.finish(pen, labelled(result, "energy", "force·length"), result.name, below=ax is None)


def _stack(pen: Any, t: Array, parts: dict[str, Array], colours: list[str], sign: float) -> None:
    level = np.zeros(len(t))
    for (name, values), colour in zip(parts.items(), colours, strict=True):
        above = level + sign * values
        pen.fill_between(t, level, above, color=colour, alpha=0.85, lw=0, label=draw.plain(name))
        level = above
