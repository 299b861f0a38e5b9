"""The validation suite is within its tolerances, and the command that runs it can tell when it is not."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from directrix.cli import app
from directrix.errors import ModelError
from directrix.verification import models, record, suite
from directrix.verification.record import Case, Check

CLI = CliRunner()


@pytest.mark.parametrize(
    "case", [pytest.param(c, id=c.name, marks=[pytest.mark.slow] * (c.cost == "long")) for c in suite.CASES]
)
def test_a_case_is_within_its_tolerances(case: Case) -> None:
    outcome = suite.perform(case)
    assert outcome.failure == ""
    assert outcome.checks
    assert [(c.case, c.expected, c.got, c.error, c.tolerance) for c in outcome.checks if not c.passed] == []
    for check in outcome.checks:
        assert check.case and check.source and check.expected
        # a row that is not judged says why by its tag, or is beyond the range that a tolerance is stated for
        assert check.judged or check.provenance != "A"
    keys = [(c.case, c.source) for c in outcome.checks]
    assert len(set(keys)) == len(keys)


def test_names_are_unique_and_sections_in_order() -> None:
    names = [c.name for c in suite.CASES]
    assert len(set(names)) == len(names)
    sections = [tuple(map(int, c.section.split("."))) for c in suite.CASES]
    assert sections == sorted(sections)


def test_a_row_counts_digits_of_its_largest_component() -> None:
    row = Check.of("tip", "somebody", "F", (1.0, 100.0), (1.1, 100.0), 1e-2)
    assert row.error == pytest.approx(1e-3) and row.digits == pytest.approx(3.0) and row.passed
    assert not replace(row, tolerance=1e-4).passed
    assert replace(row, tolerance=None).passed and not replace(row, tolerance=None).judged
    lost = Check.of("tip", "somebody", "F", 1.0, math.nan, 1e-2)
    assert lost.error == math.inf and lost.digits == 0.0 and not lost.passed
    assert Check.of("zero", "law", "A", 0.0, 1e-20, 1e-12).digits == 16.0


@pytest.mark.parametrize(
    ("printed", "cut", "good"), [(0.124, False, False), (0.123, False, True), (0.123, True, True), (0.122, True, False)]
)
def test_printed_digits_are_rounded_or_cut_off(printed: float, cut: bool, good: bool) -> None:
    row = Check.printed("tip", "somebody", "S", printed, 0.1234, 3, ulps=1 if cut else 0.5)
    assert row.passed is good


def test_what_is_remembered_is_never_judged() -> None:
    assert not Check.of("tip", "somebody", "M", 1.0, 2.0).judged
    with pytest.raises(ValueError, match="memory"):
        Check.of("tip", "somebody", "M", 1.0, 1.0, 1e-3)
    with pytest.raises(ValueError, match="2 numbers expected, 1 computed"):
        Check.of("tip", "somebody", "F", (1.0, 2.0), 1.0)


def test_picking_cases() -> None:
    quick = suite.select()
    assert {c.cost for c in quick} == {"quick"} and len(suite.select(long=True)) > len(quick)
    assert {c.section for c in suite.select(("2.4",))} == {"2.4"}
    assert [c.name for c in suite.select(("kayak-long", "bend"))] == ["bend", "kayak-long"]
    assert "kayak-long" not in [c.name for c in suite.select(("kayak*",))]
    assert "kayak-long" in [c.name for c in suite.select(("kayak*",), long=True)]
    with pytest.raises(ModelError, match=r"no case 'elastika'(?s:.*)did you mean 'elastica'"):
        suite.select(("elastika",))


def test_the_command_prints_rows_and_writes_them(tmp_path: Path) -> None:
    file = tmp_path / "rows.json"
    outcome = CLI.invoke(app, ["verify", "--only", "path-independence", "--only", "spin-up", "--json", str(file)])
    assert outcome.exit_code == 0, outcome.output
    assert "Romero & Armero" in outcome.output and "-0.66123" in outcome.output and "[M]" in outcome.output
    data = json.loads(file.read_text("utf-8"))
    assert data["passed"] and {r["section"] for r in data["rows"]} == {"1.2", "5.6"}
    row = next(r for r in data["rows"] if r["case"].startswith("u_B, path I ") or r["case"] == "u_B, path I")
    assert len(row["got"]) == 3 and row["tolerance"] > row["error"]
    listed = CLI.invoke(app, ["verify", "--list"])
    assert listed.exit_code == 0
    assert [line.split()[1] for line in listed.output.splitlines()] == [c.name for c in suite.CASES]
    unknown = CLI.invoke(app, ["verify", "--only", "bent"])
    assert unknown.exit_code == 2 and "did you mean 'bend'" in unknown.output


def test_a_wrong_number_is_exit_code_4(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def wrong() -> Iterator[Check]:
        yield Check.of("tip", "nobody", "A", 1.0, 1.1, 1e-3)
        yield Check.of("tip", "nobody", "F", 1.0, math.nan, 1e-3)

    def stops() -> Iterator[Check]:
        yield Check.of("tip", "nobody", "A", 1.0, 1.0, 1e-3)
        raise ArithmeticError("no answer")

    monkeypatch.setattr(suite, "CASES", (Case("wrong", "1.1", "Wrong", wrong), Case("stops", "1.2", "Stops", stops)))
    file = tmp_path / "rows.json"
    outcome = CLI.invoke(app, ["verify", "--json", str(file)])
    assert outcome.exit_code == 4
    assert "FAILED" in outcome.output and "no answer" in outcome.output and "3 NOT within tolerance" in outcome.output
    data = json.loads(file.read_text("utf-8"))
    assert not data["passed"] and data["rows"][1]["got"] == [None] and "no answer" in data["failures"]["stops"]


def test_the_case_of_the_page_runs() -> None:
    page = (Path(__file__).parents[1] / "docs" / "validation.md").read_text("utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    names: dict[str, Any] = {**vars(models), **vars(record), "Iterator": Iterator}
    exec(compile(code, "validation.md", "exec"), names)
    (case,) = names["CASES"]
    outcome = suite.perform(case)
    assert outcome.passed and len(outcome.checks) == 1
