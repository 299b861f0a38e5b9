"""What a person sees of a run: a live line, and the audit as a table."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from directrix.audit import stepped
from directrix.result import Result
from directrix.telling import now_and_then, time_left

if TYPE_CHECKING:
    from directrix.viewer.live import Live

__all__ = ["live", "opened", "show"]


@contextmanager
def live(console: Console) -> Generator[Callable[[float, str], None]]:
    """A live bar with the solver's line; where nothing can move, a line every five seconds and at the end."""
    columns = (
        BarColumn(bar_width=16),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}", markup=False),
        TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1)),
    )
    moves = console.is_terminal and not console.quiet
    with Progress(*columns, console=console, disable=not moves, expand=True) as bar:
        task = bar.add_task("preparing; new kernels are compiled once, some seconds", total=1.0, left="")
        started: tuple[float, float] | None = None  # when steps began, and at which share
        shown = time.monotonic()

        def progress(done: float, text: str) -> None:
            nonlocal shown, started
            now = time.monotonic()
            started = (now, done) if started is None else started
            # a step may take microseconds, what is shown should not
            if done >= 1.0 or now - shown > (0.1 if moves else 5.0):
                shown = now
                left = time_left((done - started[1]) / (1.0 - started[1] or 1.0), now - started[0])
                if moves:
                    bar.update(task, completed=done, description=text, left=left)
                else:
                    console.print(f"{done:4.0%}  {text}" + (f", {left}" if left else ""), markup=False, soft_wrap=True)

        yield now_and_then(progress)


@contextmanager
def opened(port: int) -> Generator[Live]:
    """A page of the run that is about to start, opened in a browser if there is one; its address is always printed."""
    import webbrowser

    from directrix.viewer.live import Live

    with Live(port) as page:
        print(f"watch it at {page.url}", flush=True)
        # without a display a browser for terminals might take this one
        if sys.platform in ("darwin", "win32") or {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"} & {*os.environ}:
            webbrowser.open(page.url)
        yield page


def show(console: Console, result: Result) -> None:
    """How it ended, and the audit as a table."""
    colour = "green" if result.success else "red"
    console.print(str(result.status), style=colour, markup=False, soft_wrap=True)
    energy, steps = result.energy, result.iterations
    table = Table("law", "deviation", "allowed", "relative to", "")
    for entry in result.audit.entries:
        mark = ("ok" if entry.holds else "FAILED") if entry.claimed else "not claimed"
        table.add_row(entry.law, f"{entry.value:.2e}", f"{entry.limit:.0e}", entry.relative_to, mark)
    console.print(table)
    lines = [
        f"audit {result.audit.verdict}",
        f"energy: kinetic {energy.kinetic[-1]:.9g}, stored {energy.stored[-1]:.9g}, "
        f"total {energy.total[-1]:.9g}; work done on it {energy.work[-1]:.9g}"
        + (f", dissipated {energy.dissipated[-1]:.9g}" if energy.dissipated[-1] else ""),
        f"{_count(steps.size, 'step')}, {_count(int(steps.sum()), 'Newton iteration')}, "
        f"{result.info.get('wall_seconds', 0.0):.2f} s",
        *(line.strip() for line in stepped(result)),
        *(f"note: {note}" for note in result.audit.notes),
    ]
    for line in lines:
        console.print(line, markup=False, soft_wrap=True)


def _count(n: int, what: str) -> str:
    return f"{n} {what}" if n == 1 else f"{n} {what}s"
