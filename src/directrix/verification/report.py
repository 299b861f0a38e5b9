"""The suite on a screen and in a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from directrix.verification.record import Case, Values
from directrix.verification.suite import Outcome, perform

__all__ = ["listing", "run", "write_json"]


def run(console: Console, cases: Sequence[Case]) -> tuple[Outcome, ...]:
    """Run the cases one after the other, a line each; then a table each, then the sum."""
    outcomes: list[Outcome] = []
    for case in cases:
        outcome = perform(case)
        outcomes.append(outcome)
        line = Text(f"{case.section:<4} {case.name:<24} {len(outcome.checks):>3} rows  {outcome.seconds:6.2f} s  ")
        console.print(line + _mark(outcome.passed), soft_wrap=True)
    for outcome in outcomes:
        console.print(_table(outcome))
    console.print(Text(_sum(outcomes), "green" if all(o.passed for o in outcomes) else "bold red"), soft_wrap=True)
    return tuple(outcomes)


def listing(console: Console, cases: Sequence[Case]) -> None:
    """Names, sections and titles."""
    for case in cases:
        cost = "  (long)" if case.cost == "long" else ""
        console.print(Text(f"{case.section:<4} {case.name:<24} {case.title}{cost}"), soft_wrap=True)


def write_json(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Every row with all its digits; numbers that are not finite become null."""
    from directrix import __version__
    from directrix.runs import finite

    rows = [
        {"section": o.case.section, "name": o.case.name, **asdict(c)}
        | {"expected": list(c.expected), "got": list(c.got)}
        | {"error": c.error, "digits": c.digits, "judged": c.judged, "passed": c.passed}
        for o in outcomes
        for c in o.checks
    ]
    data: Any = {
        "program": "directrix",
        "version": __version__,
        "passed": all(o.passed for o in outcomes),
        "seconds": {o.case.name: o.seconds for o in outcomes},
        "failures": {o.case.name: o.failure for o in outcomes if o.failure},
        "rows": rows,
    }
    path.write_text(json.dumps(finite(data), indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


def _table(outcome: Outcome) -> Table:
    title = Text(f"\n{outcome.case.section} {outcome.case.title}  ({outcome.case.name})", "bold")
    table = Table(title=title, title_justify="left", expand=True, box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("case", ratio=6)
    table.add_column("source", ratio=4)
    table.add_column("tag", width=6)
    for name in ("expected", "got"):
        table.add_column(name, width=15, no_wrap=True, justify="right")
    table.add_column("digits", width=6, justify="right")
    table.add_column("pass", width=6)
    for check in outcome.checks:
        words = Text(check.case), Text(check.source), Text(f"[{check.provenance}]")
        numbers = Text(_numbers(check.expected)), Text(_numbers(check.got)), Text(f"{check.digits:.1f}")
        table.add_row(*words, *numbers, _mark(check.passed) if check.judged else Text("shown", "dim"))
    if outcome.failure:
        table.add_row(Text(outcome.failure, "red"), "", "", "", "", "", _mark(False))
    return table


def _mark(passed: bool) -> Text:
    return Text("ok", "green") if passed else Text("FAILED", "bold red")


def _numbers(values: Values) -> str:
    return "\n".join(f"{v:.9g}" for v in values[:4]) + ("\n…" if len(values) > 4 else "")


def _sum(outcomes: Sequence[Outcome]) -> str:
    checks = [c for o in outcomes for c in o.checks]
    judged = [c for c in checks if c.judged]
    bad = sum(not c.passed for c in judged) + sum(bool(o.failure) for o in outcomes)
    seconds = sum(o.seconds for o in outcomes)
    verdict = "all within tolerance" if not bad else f"{bad} NOT within tolerance"
    return (
        f"{len(outcomes)} cases, {len(checks)} rows: {len(judged)} judged, {verdict}; "
        f"{len(checks) - len(judged)} shown only. {seconds:.1f} s"
    )
