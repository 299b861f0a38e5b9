"""The page of the validation suite, from its JSON: ``directrix verify --all --json rows.json``, then
``python docs/_verification.py rows.json``. Without ``--all`` the long cases keep the rows they had."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

PAGE = Path(__file__).with_name("verification.md")
HEAD = """# Verification

What `directrix verify` found, by version {version}: {rows} rows, {judged} of them judged, {failed} failed. How to read
a row and what the tags mean: [validation.md](validation.md). This page is written by `make verification`.
"""


def cases_of(page: str) -> list[tuple[str, str]]:
    """Section and name of every case on the page."""
    return [(a, b) for a, b in re.findall(r"^## (\S+) .*\(`(.+)`\)$", page, re.MULTILINE)]


def bodies(page: str) -> dict[str, str]:
    """What the page has of each case, by name."""
    parts = re.split(r"^(?=## )", page, flags=re.MULTILINE)[1:]
    return {name: part for part in parts for _, name in cases_of(part)}


def shown(numbers: list[float | None]) -> str:
    """Numbers in a cell."""
    return ", ".join("—" if x is None else f"{x:.9g}" for x in numbers[:6]) + (" …" if len(numbers) > 6 else "")


def cell(text: str) -> str:
    """Text that does not end its cell, and means itself."""
    return re.sub(r"([|*_`<$])", r"\\\1", text)


def body(case: Any, rows: list[Any]) -> str:
    """The table of a case."""
    lines = [f"## {case.section} {cell(case.title)} (`{case.name}`)", ""]
    if not rows:
        return "\n".join([*lines, f"A long case: `directrix verify --only {case.name}`.", ""])
    lines += ["| case | source | tag | expected | got | digits | |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        verdict = ("ok" if row["passed"] else "FAILED") if row["judged"] else "shown"
        digits = "—" if row["digits"] is None else f"{row['digits']:.1f}"
        head = f"| {cell(row['case'])} | {cell(row['source'])} | {row['provenance']} | {shown(row['expected'])} "
        lines.append(head + f"| {shown(row['got'])} | {digits} | {verdict} |")
    return "\n".join([*lines, ""])


def page(data: Any, old: str) -> str:
    """The whole page."""
    from directrix.verification.suite import select

    known, parts = bodies(old), []
    for case in select((), True):
        rows = [row for row in data["rows"] if row["name"] == case.name]
        parts.append(known[case.name].rstrip() + "\n" if not rows and case.name in known else body(case, rows))
    judged = [row for row in data["rows"] if row["judged"]]
    numbers = {"rows": len(data["rows"]), "judged": len(judged), "failed": sum(not row["passed"] for row in judged)}
    return "\n".join([HEAD.format(version=data["version"], **numbers), *parts]).rstrip() + "\n"


if __name__ == "__main__":
    before = PAGE.read_text("utf-8") if PAGE.is_file() else ""
    PAGE.write_text(page(json.loads(Path(sys.argv[1]).read_text("utf-8")), before), "utf-8")
    print(PAGE)
