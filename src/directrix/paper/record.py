"""What a page is made of: tables with printed and computed numbers, figures of curves. No HTML here."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = tuple[float | None, ...]

__all__ = ["Array", "Curve", "Erratum", "Figure", "Numbers", "Panel", "Row", "Table", "agrees", "minus", "ten"]


@dataclass(frozen=True)
class Row:
    """A line of a table: what was computed, beside what is printed where something is."""

    label: str
    ours: Numbers
    printed: Numbers | None = None

    @property
    def difference(self) -> Numbers:
        """Computed minus printed, None where one of them is missing."""
        if self.printed is None:
            return tuple(None for _ in self.ours)
        return tuple(None if a is None or b is None else a - b for a, b in zip(self.ours, self.printed, strict=True))


@dataclass(frozen=True)
class Table:
    """A table: ``columns`` name the numbers of its rows, ``form`` formats them (a tuple: column by column),
    ``finding`` is one sentence.

    ``groups`` are titles over equal shares of the columns; ``printed`` formats the paper's numbers, by default with as
    few digits as they have.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    form: str | tuple[str, ...]
    finding: str
    notes: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    printed: str = ""

    @property
    def forms(self) -> tuple[str, ...]:
        """The format of each column."""
        return (self.form,) * len(self.columns) if isinstance(self.form, str) else self.form

    def row(self, label: str) -> Row:
        """The row of that label; KeyError when there is none."""
        found = {r.label: r for r in self.rows}
        return found[label]


@dataclass(frozen=True)
class Curve:
    """Points (k,), (k,) to join; ``ends`` marks the last one: the run stopped there."""

    label: str
    x: Array
    y: Array
    style: str = "line"  # "line", "dashed", "points", "ours", "rival", "ghost"
    ends: bool = False


@dataclass(frozen=True)
class Panel:
    """Axes with curves; the ranges are those of the paper's axes, or None. ``picture`` has equal scales and no "
    "axes."""

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    picture: bool = False


@dataclass(frozen=True)
class Figure:
    """Panels, so many in a row, and the tables that belong to them."""

    name: str
    title: str
    panels: tuple[Panel, ...]
    finding: str
    notes: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    columns: int = 3
    height: float = 2.6  # of a panel, in inches at a page of 10

    def panel(self, title: str) -> Panel:
        """The panel of that title; KeyError when there is none."""
        found = {p.title: p for p in self.panels}
        return found[title]


@dataclass(frozen=True)
class Erratum:
    """Where the paper's print and what follows from its own equations or data differ."""

    where: str
    printed: str
    found: str


def agrees(row: Row, decimals: int, *, cut: bool = False) -> bool:
    """Whether every printed number of a row is the computed one, rounded (or cut off) to its decimals."""
    unit = 10.0**-decimals * (1.0 if cut else 0.5)
    return all(d is None or abs(d) <= 1.02 * unit for d in row.difference)


def minus(text: str) -> str:
    """A text with the sign of mathematics before its numbers."""
    return re.sub(r"(?<![\w.])-(?=\d)|(?<=e)-(?=\d)", "−", text)


def ten(value: float) -> str:
    """A size in one digit and a power of ten."""
    digit, power = f"{value:.0e}".split("e")
    return (
        "0" if value == 0.0 else f"{digit}·10{str(int(power)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}"
    )
