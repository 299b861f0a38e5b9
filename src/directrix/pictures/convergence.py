"""Convergence: Newton's iterations step by step, and the error under refinement."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix import drawing as draw
from directrix.checks import choice, shown, whole
from directrix.errors import ModelError
from directrix.pictures.curves import Others, several
from directrix.quantities import Of, labelled, series
from directrix.result import Result

Array = NDArray[np.float64]
Value = Callable[[Result], Any]

__all__ = ["convergence", "newton", "refinement", "slope"]

TRIED = {
    "turn": (3, "largest turn asked for", "rad"),
    "displacement": (2, "largest displacement asked for", "length"),
    "moment": (1, "largest unbalanced moment", "force·length"),
    "force": (0, "largest unbalanced force", "force"),
}
"""Column of the rows of a try, words, dimension."""


def newton(result: Result, others: Others, ax: Any) -> Any:
    """See :meth:`directrix.plot.Plots.newton`."""
    pen = draw.curves(result, ax)
    runs = list(several(result, others))
    if not any(one.iterations.size for _, one in runs):
        raise ModelError("no step was taken, so there are no iterations to draw", "draw a result of a run")
    for k, (label, one) in enumerate(runs):
        steps = np.arange(1, len(one.iterations) + 1)
        mean = float(one.iterations.mean()) if one.iterations.size else 0.0
        said = f"{draw.plain(label)}, " if label else ""
        pen.step(steps, one.iterations, where="mid", color=draw.PALETTE[k % len(draw.PALETTE)], lw=1.3,
                 label=f"{said}{int(one.iterations.sum())} in all, {mean:.2f} a step")  # fmt: skip
    from matplotlib.ticker import MaxNLocator

    pen.yaxis.set_major_locator(MaxNLocator(integer=True))
    pen.set_ylim(0.0, max(int(one.iterations.max(initial=0)) for _, one in runs) + 1.0)
    draw.finish(pen, "Newton iterations", result.name, below=ax is None)
    pen.set_xlabel("step")
    return pen


def convergence(result: Result, of: str | None, tries: int, ax: Any) -> Any:
    """See :meth:`directrix.plot.Plots.convergence`."""
    trail, count = result.trail, whole(tries, "tries", 1)
    named = list(TRIED) if of is None else [choice(of, "of", TRIED)]
    parts = [(k, trail.of(k)) for k in range(max(0, len(trail.step) - count), len(trail.step))]
    of = next((name for name in named if any(_known(rows, name).any() for _, rows in parts)), None)
    if of is None:
        raise ModelError(
            "nothing is known of the iterations of these steps",
            "steps of a chain that are taken many a call tell displacement and turn alone; older files tell nothing",
        )
    column, label, dimension = TRIED[of]
    pen = draw.curves(result, ax)
    for k, rows in parts:
        late = (k - parts[0][0] + 1) / len(parts)
        known = _known(rows, of)
        color = draw.BLUE if trail.solved[k] else draw.ORANGE
        pen.semilogy(np.flatnonzero(known) + 1, rows[known, column], color=color, alpha=0.25 + 0.75 * late, lw=1.3,
                     marker="o", ms=3)  # fmt: skip
    for color, solved, label_ in ((draw.BLUE, True, "solved"), (draw.ORANGE, False, "not solved")):
        tried = [k for k, _ in parts if trail.solved[k] == solved]
        if tried:
            first, last = trail.step[tried[0]] + 1, trail.step[tried[-1]] + 1
            steps = f"step {last}" if first == last else f"steps {first} to {last}"
            pen.plot([], [], color=color, marker="o", ms=3, lw=1.3, label=f"{steps}, {label_}")
    from matplotlib.ticker import MaxNLocator

    pen.xaxis.set_major_locator(MaxNLocator(integer=True))
    node = int(parts[-1][1][-1, 4]) if len(parts[-1][1]) and not trail.solved[parts[-1][0]] else -1
    if node >= 0:
        pen.plot([], [], ls="", label=f"last furthest from balance at {draw.plain(result.mesh.label(node))}")
    draw.finish(pen, labelled(result, label, dimension), result.name, below=ax is None)
    pen.set_xlabel("iteration")
    return pen


def _known(rows: Array, of: str) -> NDArray[np.bool_]:
    """Where there is something to draw on a logarithmic scale."""
    values = rows[:, TRIED[of][0]]
    return np.isfinite(values) & (values > 0.0)


def refinement(
    results: Sequence[Result], of: Of, quantity: str | Value, component: str | None, exact: float | None,
    by: str | None, ax: Any,
) -> Any:  # fmt: skip
    """See :meth:`directrix.plot.Plots.refinement`."""
    for one in results:
        if not isinstance(one, Result):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError(f"{shown(one)} is no result", "give results of finer and finer runs", "others=")
    by = _by(results, by)
    sizes = np.array([_size(one, by) for one in results])
    order = np.argsort(sizes if by == "elements" else -sizes)
    ends = [_last(results[k], of, quantity, component) for k in order]
    sizes, label = sizes[order], "the value asked for"
    first = results[0]
    if isinstance(quantity, str):
        history = series(first, quantity, of).only(component)
        what = f"{history.quantity.words} {history.names[0] if len(history.names) == 1 else ''}".strip()
        label = labelled(first, f"error of the {what}", history.dimensions[0])
        where = history.of
    else:
        label, where = f"error of {getattr(quantity, '__name__', 'the value')}", ""
    if exact is None:
        if len(ends) < 3:
            raise ModelError(
                f"{len(ends)} results show no convergence: the finest is what the others are compared with",
                "give three or more, or the exact value with exact=",
            )
        reference, ends, sizes = ends[-1], ends[:-1], sizes[:-1]
        note = "against the finest"
    else:
        reference, note = np.asarray(exact, float), "against the value given"
    errors = np.array([float(np.linalg.norm(end - reference)) for end in ends])
    if not np.all(np.isfinite(errors)) or not np.any(errors > 0.0):
        raise ModelError("there is no error to draw on a logarithmic scale", "give results that differ")
    pen = draw.curves(first, ax)
    pen.loglog(sizes, np.where(errors > 0.0, errors, np.nan), color=draw.BLUE, lw=1.7, marker="o", ms=5)
    if len(errors) > 1 and errors[-1] > 0.0 and errors[-2] > 0.0:
        rate = slope(sizes, errors)
        finer = by == "elements"  # the finest is on the right, and its label under the curve
        pen.annotate(
            f"order {abs(rate):.2f}", (sizes[-1], errors[-1]), (-10 if finer else 10, -4), textcoords="offset points",
            ha="right" if finer else "left", va="top", color=draw.INK, fontsize=9,
        )  # fmt: skip
    pen.set_ylabel(label)
    pen.set_xlabel("elements" if by == "elements" else labelled(first, "time step", "time"))
    pen.set_title(draw.plain(f"{first.name}{': ' + where if where else ''}, {note}"), fontsize=11)
    pen.grid(which="minor", color="#f2f4f5", lw=0.5)
    return pen


def slope(sizes: Array, errors: Array) -> float:
    """Exponent of the power of the size that the last two errors follow."""
    return float(np.log(errors[-1] / errors[-2]) / np.log(sizes[-1] / sizes[-2]))


def _by(results: Sequence[Result], by: str | None) -> str:
    if by is not None:
        return choice(by, "size to refine by,", ("elements", "dt"))
    for name in ("dt", "elements"):
        if all(name in one.info for one in results) and len({one.info[name] for one in results}) == len(results):
            return name
    raise ModelError(
        "the results differ neither all in their number of elements nor all in their time step",
        "give results of finer and finer runs, each once",
        "others=",
    )


def _size(result: Result, by: str) -> float:
    if by not in result.info:
        raise ModelError(f"{result.name}: this result does not say its {by}", "give results of dx.simulate", "by=")
    return float(result.info[by])


def _last(result: Result, of: Of, quantity: str | Value, component: str | None) -> Array:
    if isinstance(quantity, str):
        return series(result, quantity, of).only(component).values[-1]
    return np.atleast_1d(np.asarray(quantity(result), float))
