"""Curves: a quantity in time, one quantity over another, several results in one picture."""
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix import drawing as draw
from directrix.checks import shown
from directrix.errors import ModelError
from directrix.quantities import QUANTITIES, Of, Series, labelled, series
from directrix.result import Result

Array = NDArray[np.float64]
Others = Mapping[str, Result] | Sequence[Result]

__all__ = ["Others", "history", "orbit", "several"]

LETTERS = {"displacement": "u_", "r": "", "v": "v_", "L": "L_", "J": "J_"}
STYLES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (1, 3)))


def several(result: Result, others: Others) -> Iterator[tuple[str, Result]]:
    """The results of a picture with a label each, the first without one where it is alone.

    Raises ModelError for what is no result.
    """
    if isinstance(others, Result):
        others = (others,)
    if isinstance(others, Mapping):
        rest = list(others.items())
    else:
        rest = [(one.name if isinstance(one, Result) else "", one) for one in others]  # pyright: ignore
    yield (result.name if rest else ""), result
    for label, one in rest:
        if not isinstance(one, Result):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError(f"{shown(one)} is no result", "give results of dx.simulate or dx.solve_static", "others=")
        yield str(label), one


def history(result: Result, of: Of, quantity: str, component: str | None, others: Others, ax: Any) -> Any:
    """See :meth:`directrix.plot.Plots.history`."""
    parts = [(label, one, series(one, quantity, of).only(component)) for label, one in several(result, others)]
    pen = draw.curves(result, ax)
    for k, (label, one, values) in enumerate(parts):
        _draw(pen, one, values, label, k)
    first = parts[0][2]
    title = f"{result.name}: {first.of}" if first.of and len(parts) == 1 else first.of or result.name
    return draw.finish(pen, _axis(result, first), title, below=ax is None)


def _draw(pen: Any, result: Result, values: Series, label: str, number: int) -> None:
    """The components of one result: in colours of their own, or in that of the result where it is one of several."""
    x = draw.abscissa(result)
    for k, (name, column) in enumerate(zip(values.names, values.values.T, strict=True)):
        sign = _sign(values, name)
        alone = len(values.names) == 1
        colour = draw.PALETTE[number % len(draw.PALETTE)] if alone else draw.XYZ[k % 3]
        style = STYLES[(number or int(k >= 3)) % len(STYLES)]
        said = draw.plain(label) + (f", {sign}" if label and not alone else "") if label else sign
        pen.plot(x, column, color=colour, lw=1.7, ls=style, label=said, **draw.dots(result))


def _sign(values: Series, name: str) -> str:
    """How a component is written."""
    kind = values.quantity
    if not kind.components:
        return draw.plain(kind.words)
    if kind.name in LETTERS:
        letter = LETTERS[kind.name]
        return f"${letter}{name}$" if letter else name
    head = name.rstrip("xyz123")
    tail = name[len(head) :]
    head = {"Gamma": r"\Gamma", "Omega": r"\Omega"}.get(head, head)
    return f"${head}_{tail}$" if head and tail else f"${name}$" if not head else f"${head}$"


def _axis(result: Result, values: Series) -> str:
    """Label of the axis: words and units; both units where force and moment are drawn together."""
    dimensions = list(dict.fromkeys(values.dimensions))
    words = values.quantity.words
    if len(values.names) == 1 and values.quantity.components:
        words = f"{words} {_sign(values, values.names[0])}"
    if len(dimensions) == 1:
        return labelled(result, words, dimensions[0])
    return labelled(result, words, ", ".join(d or "1" for d in dimensions))


def orbit(result: Result, of: Of, x: str | tuple[str, str], y: str | tuple[str, str], others: Others, ax: Any) -> Any:
    """See :meth:`directrix.plot.Plots.orbit`."""

    def read(one: Result, what: Any) -> Series:
        if isinstance(what, str):
            what = (what, None)
        if not isinstance(what, tuple) or len(what) != 2:
            raise ModelError(f"{shown(what)} is no quantity to draw", 'give a name, or a pair such as ("r", "x")')
        owner = QUANTITIES[what[0]].owner if what[0] in QUANTITIES else "rod"
        values = series(one, what[0], None if owner == "run" else of).only(what[1])
        if len(values.names) > 1:
            raise ModelError(f"{what[0]} has {len(values.names)} components", f"name one of {', '.join(values.names)}")
        return values

    parts = [(label, one, read(one, x), read(one, y)) for label, one in several(result, others)]
    pen = draw.curves(result, ax)
    for k, (label, one, across, up) in enumerate(parts):
        colour = draw.PALETTE[k % len(draw.PALETTE)]
        path = across.values[:, 0], up.values[:, 0]
        pen.plot(*path, color=colour, lw=1.5, label=draw.plain(label) or None, **draw.dots(one))
        pen.plot(path[0][:1], path[1][:1], ls="", marker="o", ms=5, mfc="white", color=colour)
        pen.plot(path[0][-1:], path[1][-1:], ls="", marker="o", ms=5, color=colour)
    _, _, across, up = parts[0]
    pen.set_xlabel(_axis(result, across))
    pen.set_ylabel(_axis(result, up))
    where = across.of or up.of
    title = f"{result.name}: {where}" if where and len(parts) == 1 else where or result.name
    pen.set_title(draw.plain(title), fontsize=11)
    if across.quantity.name == up.quantity.name and across.quantity.components:
        pen.set_aspect("equal", adjustable="datalim")
    if len(parts) > 1:
        pen.legend(frameon=False, fontsize=9)
    return pen
