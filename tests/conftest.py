"""Profiles of hypothesis: no deadlines (the first example compiles), the same ones on every run of CI. One browser."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Browser, browser
from hypothesis import settings

settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One for all tests; those that ask for it are skipped where there is none."""
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    """Where pictures of pages are kept: in DIRECTRIX_PICTURES if that is set, else with the test's own files."""
    return Path(os.environ.get("DIRECTRIX_PICTURES") or tmp_path)
