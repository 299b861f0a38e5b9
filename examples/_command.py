"""What examples share: run one from the command line, every keyword of ``main`` an option; mark a test as slow."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any


def slow(test: Callable[[], None]) -> Callable[[], None]:
    """A test that pytest runs with ``-m slow`` alone; a script does without pytest."""
    try:
        import pytest
    except ImportError:
        return test
    return pytest.mark.slow(test)


def run(main: Callable[..., Any]) -> None:
    """Call ``main`` with what the command line gives; ``--out`` folders are made."""
    parser = argparse.ArgumentParser(description=inspect.getmodule(main).__doc__.split("\n")[0])
    for name, parameter in inspect.signature(main).parameters.items():
        kind = type(parameter.default) if parameter.default is not None else str
        parser.add_argument(f"--{name}", type=kind, default=parameter.default, help=f"default {parameter.default}")
    options = vars(parser.parse_args())
    if options.get("out"):
        Path(options["out"]).mkdir(parents=True, exist_ok=True)
    main(**options)
