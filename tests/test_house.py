"""What a stranger meets first holds: the README runs, the package is whole, the papers agree."""

from __future__ import annotations

import ast
import inspect
import re
import shlex
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hatchling.builders.wheel import WheelBuilder
from typer.testing import CliRunner

import directrix as dx
from directrix.cli import app
from directrix.schema import json_schema, load_case

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "directrix"
README = (ROOT / "README.md").read_text("utf-8")
PAPERS = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
EXAMPLES = sorted((ROOT / "examples").glob("[!_]*.py"))


def blocks(language: str, page: str = README) -> list[str]:
    """The fenced blocks of a page in one language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)


def test_the_python_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = blocks("python")
    assert len([line for line in code.splitlines() if line]) == 10  # as its heading says
    names: dict[str, Any] = {}
    exec(compile(code, "README.md", "exec"), names)
    assert names["result"].success
    shown = blocks("text")[0].splitlines()
    printed = capsys.readouterr().out.splitlines()
    assert shown[0] == printed[0] and shown[-1] in printed
    assert "<html" in Path("swing.html").read_text("utf-8")[:200]


def test_the_commands_of_the_readme_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("directrix ")]
    assert len(lines) >= 3
    for line in lines:
        outcome = CliRunner().invoke(app, shlex.split(line, comments=True)[1:])
        assert outcome.exit_code == 0, f"{line}\n{outcome.output}"
    assert {p.name for p in Path("free_flight.run").iterdir()} >= {"result.vtkhdf", "run.json", "monitor.csv"}


@pytest.mark.parametrize("paper", PAPERS, ids=lambda p: p.name)
def test_what_the_papers_name_exists(paper: Path) -> None:
    text = paper.read_text("utf-8")
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    assert set(re.findall(r"(?:`|^)make ([a-z-]+)\b", text, re.MULTILINE)) <= targets
    links = re.findall(r"\]\((?!https?:)([^)#]+)[^)]*\)", text)
    assert [link for link in links if not (paper.parent / link).exists()] == []


def test_the_page_on_case_files_is_right(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "input.md").read_text("utf-8")
    case, *_ = blocks("toml", page)
    file = tmp_path / "case.toml"
    file.write_text(case, "utf-8")
    assert load_case(file).run().success
    rows = re.findall(r"^\| (`.*?`) \|", page, re.MULTILINE)
    tables = {name.split(".")[0] for row in rows for name in re.findall(r"`([\w.$]+)`", row)}
    assert tables == set(json_schema()["properties"])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_is_script_test_and_page(path: Path) -> None:
    tree = ast.parse(path.read_text("utf-8"))
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    page = ast.get_docstring(tree) or ""
    assert f"python examples/{path.name}" in page
    assert any(name.startswith("test_") for name in functions)
    imported = {alias.name for node in tree.body if isinstance(node, ast.Import) for alias in node.names}
    assert "pytest" not in imported  # who runs a script need not have it
    main = functions["main"]
    assert not main.args.args
    assert all(a.annotation for a in main.args.kwonlyargs)
    assert None not in main.args.kw_defaults
    assert main.returns is not None and ast.unparse(main.returns) != "None"


def test_versions_agree() -> None:
    top = re.search(r"^## \[(\d[^]]*)\]", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)
    assert top and cited
    assert dx.__version__ == top[1] == cited[1]


def test_the_wheel_is_whole(tmp_path: Path) -> None:
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if name.startswith("directrix/")}
        entry_points = archive.read(f"directrix-{dx.__version__}.dist-info/entry_points.txt").decode()
    ours = {p for p in SOURCE.rglob("*") if p.is_file() and "__pycache__" not in p.parts}
    assert packed == {p.relative_to(SOURCE.parent).as_posix() for p in ours}
    assert "directrix/py.typed" in packed
    assert {Path(name).suffix for name in packed} >= {".py", ".html", ".toml"}
    assert "directrix = directrix.cli:main" in entry_points


def test_nothing_is_left_to_do_in_the_source() -> None:
    marks = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b")
    left = [
        f"{path.relative_to(ROOT)}:{k}"
        for path in sorted(p for p in SOURCE.rglob("*") if p.suffix in {".py", ".html", ".js", ".css", ".toml"})
        for k, line in enumerate(path.read_text("utf-8").splitlines(), 1)
        if marks.search(line)
    ]
    assert left == []


@pytest.mark.parametrize("name", dx.__all__)
def test_public_things_are_documented(name: str) -> None:
    thing = getattr(dx, name)
    bare = [] if inspect.getdoc(thing) else [name]
    if inspect.isclass(thing):
        bare += [
            f"{name}.{key}"
            for key, member in vars(thing).items()
            if not key.startswith("_")
            and (callable(member) or isinstance(member, property | classmethod | staticmethod))
            if not inspect.getdoc(member)
        ]
    assert bare == []
