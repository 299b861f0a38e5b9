"""One HTML file of everything: tables, figures and errata, nothing loaded from anywhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from html import escape
from importlib.resources import files
from itertools import chain
from string import Template

from directrix.paper.contents import Example, Item, compute
from directrix.paper.errata import ERRATA
from directrix.paper.picture import data_uri
from directrix.paper.record import Figure, Numbers, Row, Table, minus

__all__ = ["report"]

TITLE = "Section 5 of Romero and Armero (2002), recomputed"
PAPER = (
    "I. Romero and F. Armero, <i>An objective finite element approximation of the kinematics of geometrically "
    "exact rods and its use in "
    "the formulation of an energy–momentum conserving scheme in dynamics</i>, Int. J. Numer. Meth. Engng 54 "
    "(2002) 1683–1716, "
    "doi 10.1002/nme.486."
)
LEGEND = (
    "Lines marked <i>printed</i> hold the paper's numbers as they stand there, <i>here</i> what this run "
    "computed, <i>difference</i> the second "
    "minus the first. Axes have the ranges of the paper's figures. Every number on this page was computed when "
    "the page was made, or "
    "is printed in the paper."
)


def report(quick: bool = False, progress: Callable[[str], None] | None = None) -> str:
    """The page; ``quick`` shortens the long motions, ``progress`` gets the title of each example when it is done.

    Raises ModelError without matplotlib.
    """
    started = time.perf_counter()
    done: list[tuple[Example, tuple[Item, ...]]] = []
    for example, items in compute(quick):
        done.append((example, items))
        if progress is not None:
            progress(example.title)
    sections = [_section(example, items) for example, items in done]
    body = [_head(quick, time.perf_counter() - started), _summary([i for _, items in done for i in items])]
    return Template(files("directrix.paper").joinpath("page.html").read_text("utf-8")).substitute(
        title=escape(TITLE), body="\n".join([*body, *sections, _errata()])
    )


def _head(quick: bool, seconds: float) -> str:
    import platform

    import numpy as np

    from directrix import __version__

    short = " Shortened: made with --quick, motions are not run to their ends." if quick else ""
    return (
        f"<h1>{escape(TITLE)}</h1>\n<p class='small'>{PAPER}</p>\n"
        f"<p class='small'>directrix {__version__}, Python {platform.python_version()}, NumPy {np.__version__}; "
        f"computed in {seconds:.1f} s.{short}</p>\n<p>{LEGEND}</p>"
    )


def _summary(items: Sequence[Item]) -> str:
    lines = "\n".join(
        f"<li><a href='#{_anchor(i)}'>{escape(i.name)}</a>. {escape(minus(i.finding))}</li>" for i in items
    )
    return f"<h2>In short</h2>\n<ul>\n{lines}\n<li><a href='#errata'>Errata</a>: {len(ERRATA)} places.</li>\n</ul>"


def _section(example: Example, items: Sequence[Item]) -> str:
    shown = (_figure(item) if isinstance(item, Figure) else _table(item) for item in items)
    return f"<h2>{escape(example.title)}</h2>\n<p>{escape(example.text)}</p>\n" + "\n".join(chain.from_iterable(shown))


def _title(item: Item) -> Iterator[str]:
    yield f"<h3 id='{_anchor(item)}'>{escape(item.name)}. {escape(item.title)}</h3>"
    yield f"<p class='finding'>{escape(minus(item.finding))}</p>"


def _notes(item: Item) -> Iterator[str]:
    yield from (f"<p class='note'>{escape(minus(note))}</p>" for note in item.notes)


def _figure(figure: Figure) -> Iterator[str]:
    yield from _title(figure)
    alt = escape(f"{figure.name}: {figure.title}")
    yield f"<figure class='wide'><img alt='{alt}' src='{data_uri(figure)}'></figure>"
    for table in figure.tables:
        yield _grid(table, table.title)
    yield from _notes(figure)


def _table(table: Table) -> Iterator[str]:
    yield from _title(table)
    yield _grid(table)
    yield from _notes(table)


def _grid(table: Table, caption: str = "") -> str:
    compared = any(row.printed is not None for row in table.rows)
    layout = _plain if not compared else _beside if len(table.columns) <= 2 else _stacked
    name = f"<caption>{escape(minus(caption))}</caption>" if caption else ""
    return f"<div class='wide'><table>{name}\n" + "\n".join(layout(table)) + "\n</table></div>"


def _plain(table: Table) -> Iterator[str]:
    yield _header(("", *table.columns))
    for row in table.rows:
        yield f"<tbody><tr><th>{escape(minus(row.label))}</th>{_cells(row.ours, table.forms)}</tr></tbody>"


def _beside(table: Table) -> Iterator[str]:
    """Printed, here and difference in columns."""
    words = ("printed", "here", "difference")
    yield _header(
        ("", *(f"{column}, {word}" if len(table.columns) > 1 else word for column in table.columns for word in words))
    )
    for row in table.rows:
        printed = row.printed or tuple(None for _ in row.ours)
        parts = zip(printed, row.ours, row.difference, table.forms, strict=True)
        cells = "".join(
            _printed((a,), table.printed) + _cells((b,), (form,)) + _cells((d,), ("+.1e",), "n grey")
            for a, b, d, form in parts
        )
        yield f"<tbody><tr><th>{escape(minus(row.label))}</th>{cells}</tr></tbody>"


def _stacked(table: Table) -> Iterator[str]:
    """Printed, here and difference below each other."""
    if table.groups:
        span = len(table.columns) // len(table.groups)
        over = "".join(f"<th class='group' colspan='{span}'>{escape(g)}</th>" for g in table.groups)
        yield f"<thead><tr><th></th><th></th>{over}</tr></thead>"
    yield _header(("", "", *table.columns))
    for row in table.rows:
        yield "<tbody>" + "".join(_lines(row, table)) + "</tbody>"


def _lines(row: Row, table: Table) -> Iterator[str]:
    if row.printed is None:
        yield f"<tr><th>{escape(minus(row.label))}</th><td>here</td>{_cells(row.ours, table.forms)}</tr>"
        return
    label = f"<th rowspan='3'>{escape(minus(row.label))}</th>"
    yield f"<tr class='printed'>{label}<td>printed</td>{_printed(row.printed, table.printed)}</tr>"
    yield f"<tr><td>here</td>{_cells(row.ours, table.forms)}</tr>"
    yield f"<tr class='difference'><td>difference</td>{_cells(row.difference, ('+.1e',) * len(row.ours))}</tr>"


def _printed(values: Numbers, form: str) -> str:
    """As printed; without a format no more digits than the number has."""
    texts = ("—" if v is None else minus(format(v, form) if form else repr(v)) for v in values)
    return "".join(f"<td class='n'>{text}</td>" for text in texts)


def _cells(values: Numbers, forms: Sequence[str], kind: str = "n") -> str:
    texts = ("" if v is None else minus(format(v, form)) for v, form in zip(values, forms, strict=True))
    return "".join(f"<td class='{kind}'>{text}</td>" for text in texts)


def _header(columns: Sequence[str]) -> str:
    return "<thead><tr>" + "".join(f"<th>{escape(c)}</th>" for c in columns) + "</tr></thead>"


def _errata() -> str:
    rows = "\n".join(
        f"<tbody><tr><th>{escape(e.where)}</th><td>{escape(e.printed)}</td><td>{escape(e.found)}</td></tr></tbody>"
        for e in ERRATA
    )
    return (
        "<h2 id='errata'>Errata and what the print leaves open</h2>\n<div class='wide'><table class='text'>\n"
        f"{_header(('where', 'printed', 'found'))}\n{rows}\n</table></div>"
    )


def _anchor(item: Item) -> str:
    return item.name.lower().replace(" ", "-")
