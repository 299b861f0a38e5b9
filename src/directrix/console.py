"""What a person sees of a run: a live line, and the audit as a table."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from directrix.audit import stepped
from directrix.result import Result

__all__ = ["live", "show"]


@contextmanager
def live(console: Console) -> Generator[Callable[[float, str], None]]:
    """A live bar with the solver's line; where nothing can move, a line every five seconds and at the end."""
    columns = (
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    moves = console.is_terminal and not console.quiet
    with Progress(*columns, console=console, disable=not moves) as bar:
        task = bar.add_task("preparing; new kernels are compiled once, some seconds", total=1.0)
        shown = time.monotonic()

        def progress(done: float, text: str) -> None:
            nonlocal shown
            # a step may take microseconds, what is shown should not
            if done >= 1.0 or time.monotonic() - shown > (0.1 if moves else 5.0):
                shown = time.monotonic()
                if moves:
                    bar.update(task, completed=done, description=text)
                else:
                    console.print(f"{done:4.0%}  {text}", markup=False, soft_wrap=True)

        yield progress


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
