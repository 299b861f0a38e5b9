"""Runs the Python of a page: its blocks one after the other in one namespace, and what they print beside what they say.

A line ``print(…)  # → text`` says what is printed; numbers may differ by one in their last digit. ``<!-- run … -->``
is Python that runs and is not shown. ``<!-- not run: reason -->`` before a block leaves it out.
"""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

BLOCK = re.compile(
    r"^<!-- run\n(?P<hidden>.*?)^-->$|(?:^<!-- not run: (?P<reason>[^\n]+) -->\n)?^```python\n(?P<shown>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
NUMBER = re.compile(r"[-−]?\d+\.?\d*(?:e[-+]?\d+)?")


def blocks(page: str) -> list[tuple[int, str]]:
    """Line numbers and texts of what is to be run."""
    found: list[tuple[int, str]] = []
    for match in BLOCK.finditer(page):
        if match["reason"] is None:
            name = "shown" if match["shown"] is not None else "hidden"
            found.append((page.count("\n", 0, match.start(name)), match[name]))
    return found


def run(path: Path) -> dict[str, Any]:
    """Run a page in the current folder; returns its names. AssertionError where it prints something else."""
    names: dict[str, Any] = {"__name__": "page"}
    for line, code in blocks(path.read_text("utf-8")):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile("\n" * line + code, str(path), "exec", dont_inherit=True), names)
        said = re.findall(r"# → (.*)$", code, re.MULTILINE)
        printed = out.getvalue().splitlines()
        assert not said or len(said) == len(printed), f"{path}:{line}: says {said}, prints {printed}"
        for a, b in zip(said, printed, strict=False):
            assert same(a.strip(), b.strip()), f"{path}:{line}: says {a!r}, prints {b!r}"
    return names


def same(said: str, printed: str) -> bool:
    """Equal but for one in the last digit of numbers."""
    if NUMBER.sub("#", said) != NUMBER.sub("#", printed):
        return False
    return all(
        abs(float(a.replace("−", "-")) - float(b.replace("−", "-"))) <= 1.01 * unit(a)
        for a, b in zip(NUMBER.findall(said), NUMBER.findall(printed), strict=True)
    )


def unit(number: str) -> float:
    """One in the last digit."""
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
