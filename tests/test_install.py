"""Without an extra everything else works, and what needs it names the line that installs it."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
DEVELOPERS = {"all", "test", "dev", "docs"}
EXTRAS = sorted(set(PROJECT["optional-dependencies"]) - DEVELOPERS)

BLOCK = """
import sys

class Without:
    # a finder that does not find what is blocked
    def __init__(self, finder):
        self.finder = finder

    def __getattr__(self, name):
        return getattr(self.finder, name)

    def find_spec(self, name, path=None, target=None):
        blocked = name.partition(".")[0].replace("_", "-").lower() in BLOCKED
        return None if blocked else self.finder.find_spec(name, path, target)

sys.meta_path[:] = [Without(finder) for finder in sys.meta_path]
import directrix as dx
from directrix.errors import DirectrixError
"""
RESULT = """
section = dx.Section.circle(radius=0.01, E=1e9, nu=0.3)
rod = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), section, ends=("a", "b"), elements=1)
result = dx.solve_static(rod.clamp("a").force("b", (1, 0, 0)), steps=1)
assert result.success
"""
CASE = """
import json
from pathlib import Path
from directrix.schema import load_case
from directrix.schema.convert import convert
section = {"kind": "circle", "radius": RADIUS, "E": 1e9, "nu": 0.3}
rod = {"name": "r", "section": "s", "line": [[0, 0, 0], [1, 0, 0]], "ends": ["a", "b"], "elements": 2}
case = {"section": {"s": section}, "rod": [rod], "support": [{"node": "a", "type": "clamp"}], "statics": {}}
Path("case.json").write_text(json.dumps(case))
"""
CHOSEN = """
section = dx.Section.circle(radius=0.01, E=1e9, nu=0.3, rho=1)
dx.simulate(dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), section, elements=2), t_end=1, dt=1, linear="{}")
"""
ASK = {
    "geometry": "dx.from_graph(None, section=dx.Section.circle(radius=0.01, E=1e9, nu=0.3))",
    "movie": f"{RESULT}result.movie('x.mp4')",
    "pandas": f"{RESULT}result.to_pandas()",
    "pardiso": CHOSEN.format("pardiso"),
    "plot": f"{RESULT}result.plot.energy()",
    "pyvista": f"{RESULT}result.to_pyvista()",
    "rslab": CHOSEN.format("rslab"),
    "sections": "dx.Section.from_sectionproperties(object())",
    "toml": f"RADIUS = 0.01\n{CASE}convert(Path('case.json'), Path('case.toml'))",
    "units": f"RADIUS = '1 cm'\n{CASE}load_case('case.json')",
    "xarray": f"{RESULT}result.to_xarray()",
    "xlsx": f"{RESULT}result.to_xlsx('x.xlsx')",
}
"""What a user does that needs an extra. Every extra whose absence has to be named at once belongs here."""
IMPORTED_AS = {"pyyaml": "yaml", "pillow": "pil"}  # where a package is imported under another name


def packages(extra: str) -> list[str]:
    """Names of the modules that an extra brings, itself and through other extras of ours."""
    found: list[str] = []
    for line in PROJECT["optional-dependencies"][extra]:
        name = line.split(">")[0].split("=")[0].split(";")[0].strip().lower()
        found.append(IMPORTED_AS.get(name, name))
    return [name for name in found if not name.startswith("directrix")]


def without(extra: str, code: str) -> subprocess.CompletedProcess[str]:
    """Run code in a Python that cannot import what the extra brings."""
    program = f"BLOCKED = {packages(extra)!r}\n{BLOCK}\n{code}"
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.parametrize("extra", EXTRAS)
def test_what_needs_an_extra_names_it(extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = without(extra, f"try:\n{_indented(ASK[extra])}\nexcept DirectrixError as error:\n    print(error)\n")
    assert done.returncode == 0, done.stderr
    assert f"directrix[{extra}]" in done.stdout


def test_all_extras_are_in_the_one_that_is_all_but_for_the_largest() -> None:
    (line,) = PROJECT["optional-dependencies"]["all"]
    assert sorted(line.removeprefix("directrix[").removesuffix("]").split(",")) == [
        extra for extra in EXTRAS if extra != "pardiso"
    ]


def test_doctor_names_every_missing_extra() -> None:
    blocked = [name for extra in EXTRAS for name in packages(extra)]
    code = f"""
import importlib.metadata as metadata
real = metadata.version
def version(name):
    if name.lower() in {blocked!r}:
        raise metadata.PackageNotFoundError(name)
    return real(name)
metadata.version = version
from directrix.doctor import facts
for pair in facts():
    print(*pair)
"""
    done = without(EXTRAS[0], code)
    assert done.returncode == 0, done.stderr
    for name in blocked:
        lines = {f'not installed; pip install "directrix[{extra}]"' for extra in EXTRAS if name in packages(extra)}
        said = [line for line in done.stdout.splitlines() if line.lower().startswith(f"{name} ")]
        assert said and said[0].partition(" ")[2] in lines, (name, said)


def test_the_command_line_works_without_extras(tmp_path: Path) -> None:
    code = """
import os
from directrix.cli import main
for line in (["examples", "swinging_rod", "--copy", "."], ["check", "swinging_rod.toml"], ["run", "swinging_rod.toml"]):
    sys.argv = ["directrix", *line]
    try:
        main()
    except SystemExit as end:
        assert not end.code, (line, end.code)
"""
    done = without("plot", f"import os\nos.chdir({str(tmp_path)!r})\n{code}")
    assert done.returncode == 0, done.stderr + done.stdout
    assert 'pip install "directrix[plot]"' in done.stdout
    assert (tmp_path / "swinging_rod.run" / "result.vtkhdf").is_file()


def _indented(code: str) -> str:
    return "\n".join("    " + line for line in code.splitlines())
