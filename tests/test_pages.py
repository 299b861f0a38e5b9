"""The pages are right: their code runs and prints what they say, nothing public is missing, lists are current."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import _api
import _verification
import pages
import pytest

import directrix as dx
from directrix.schema import load_case
from directrix.verification.suite import select

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [p for p in sorted(DOCS.rglob("*.md")) if not {"_build", "gallery", "api"} & set(p.relative_to(DOCS).parts)]
RUN = [p for p in PAGES if pages.blocks(p.read_text("utf-8"))]


@pytest.mark.parametrize("path", RUN, ids=lambda p: p.relative_to(DOCS).as_posix())
def test_the_python_of_a_page_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    pages.run(path)


@pytest.mark.parametrize("path", PAGES, ids=lambda p: p.relative_to(DOCS).as_posix())
def test_the_cases_of_a_page_are_cases(path: Path, tmp_path: Path) -> None:
    for case in re.findall(r"^```toml\n(.*?)^```$", path.read_text("utf-8"), re.MULTILINE | re.DOTALL):
        if re.search(r"^\[(statics|dynamics)\]", case, re.MULTILINE):
            file = tmp_path / "case.toml"
            file.write_text(case, "utf-8")
            assert load_case(file).model.check() is not None


def test_a_page_that_says_something_else_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```python\nprint(0.12345)  # → 0.1237\n```\n", "utf-8")
    with pytest.raises(AssertionError, match="says"):
        pages.run(page)
    assert pages.same("tip 0.1235 m", "tip 0.1234 m") and not pages.same("tip 0.1235 m", "tip 0.1237 m")


def test_every_public_object_is_on_the_page_of_the_api() -> None:
    listed = set(re.findall(r"^   ~directrix\.(\S+)$", _api.page(), re.MULTILINE))
    assert set(dx.__all__) <= listed
    for name in listed:
        module, _, last = name.rpartition(".")
        thing = __import__(f"directrix.{module}", fromlist=[last]) if module else dx
        assert (getattr(thing, last).__doc__ or "").strip(), name


def test_the_page_of_the_verification_has_every_case() -> None:
    assert _verification.cases_of((DOCS / "verification.md").read_text("utf-8")) == [
        (case.section, case.name) for case in select((), True)
    ]


def test_every_page_is_reached() -> None:
    named = {p for p in PAGES if p.name != "index.md"}
    reached = set()
    for index in (p for p in PAGES if p.name == "index.md"):
        for tree in re.findall(r"^```\{toctree\}\n(.*?)^```$", index.read_text("utf-8"), re.MULTILINE | re.DOTALL):
            for entry in (line for line in tree.splitlines() if line and not line.startswith(":")):
                reached |= set(index.parent.glob(f"{entry}.md"))
    assert named - reached == set()


def test_the_functions_of_the_theory_exist() -> None:
    for name in set(re.findall(r"`([a-z_]+(?:\.\w+)*)`", (DOCS / "theory.md").read_text("utf-8"))):
        parts = name.split(".")
        depth = next(k for k in range(len(parts), 0, -1) if find_module(parts[:k]))
        thing = import_module(".".join(["directrix", *parts[:depth]]))
        for part in parts[depth:]:
            assert hasattr(thing, part) or part in getattr(thing, "__dataclass_fields__", {}), name
            thing = getattr(thing, part, None)


def find_module(parts: list[str]) -> bool:
    return any((ROOT / "src" / "directrix" / "/".join(parts)).with_suffix(end).exists() for end in ("", ".py"))
