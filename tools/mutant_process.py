"""What runs in the process of one mutant, as a plugin of pytest; see mutants.py.

Machine code is found by the text it is made of, and not by the sources that wrote the text: a mutant compiles what it
changes and nothing else. A test that computes for longer than SECONDS ends the process. What happened is written to the
file that MUTANT_REPORT names: the test that failed, or was running when the process ended, and how many texts were new.
"""

from __future__ import annotations

import json
import os
import resource
from collections.abc import Callable
from pathlib import Path
from typing import Any

import directrix
from directrix.kernels import compile as machine
from directrix.kernels import elimination, jit, lanes

SECONDS = 60  # of processor time for a test: five times what the slowest takes
SOURCES = Path(os.environ["MUTANT_SOURCES"])
assert SOURCES in Path(directrix.__file__).parents, "the mutant is not what is tested"

_report: dict[str, Any] = {"test": "", "compiled": 0}
_texts: dict[str, str] = {}
_by_text = machine.text_address
_object = machine._object  # type: ignore[reportPrivateUsage]


def text_address(description: str, text: Callable[[str], str], loops: bool = False) -> int:
    """As that of compile.py, the text taking the part of the description."""
    if description not in _texts:
        _texts[description] = text("the_kernel")
    body = _texts[description]
    return _by_text(f"{loops} {body}", lambda name: body.replace("@the_kernel(", f"@{name}("), loops)


def _counted(text: str, loops: bool) -> bytes:
    _report["compiled"] += 1
    return _object(text, loops)


for _module in (machine, elimination, jit, lanes):
    _module.text_address = text_address  # type: ignore[reportPrivateImportUsage]
machine._sources = lambda: b""  # type: ignore[reportPrivateUsage]
machine._object = _counted  # type: ignore[reportPrivateUsage]


def _say() -> None:
    Path(os.environ["MUTANT_REPORT"]).write_text(json.dumps(_report), encoding="utf-8")


def pytest_runtest_setup(item: Any) -> None:
    """Before each test."""
    _report["test"] = item.nodeid
    _say()
    used = resource.getrusage(resource.RUSAGE_SELF)
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (int(used.ru_utime + used.ru_stime) + SECONDS, most))


def pytest_sessionfinish() -> None:
    """After the last one, or the first that fails."""
    _say()
