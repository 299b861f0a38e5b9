"""Profiles of hypothesis: no deadlines (the first example compiles), the same ones on every run of CI. One browser.

And the ledger of every motion that any test computes: it has to close, unless the test is marked ``open_ledger`` and
says why it does not.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import Browser, browser
from hypothesis import Phase, settings

from directrix.audit import Audit, DynamicBooks

settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
# tools/mutants.py: one counterexample is enough, however large
settings.register_profile(
    "mutants", deadline=None, derandomize=True, max_examples=30, phases=[Phase.explicit, Phase.generate]
)
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


@pytest.fixture(autouse=True)
def _ledgers(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    failed: list[str] = []
    audit = DynamicBooks.audit

    def watched(self: DynamicBooks) -> Audit:
        result = audit(self)
        failed.extend(
            f"{self.integrator}: {e.law} off by {e.value:.1e}"
            for e in result.entries
            if e.law != "turn of an element" and not e.holds
        )
        return result

    monkeypatch.setattr(DynamicBooks, "audit", watched)
    yield
    marker: Any = request.node.get_closest_marker("open_ledger")
    if marker is None:
        assert not failed, f"a motion of this test does not keep what it claims: {failed}"
    else:
        assert marker.args and failed, "open_ledger needs a reason, and a ledger that is open"
