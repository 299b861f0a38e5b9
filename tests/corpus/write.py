"""Writes the files of this version: cases, results and runs small enough to keep, in ``tests/corpus/<version>/``.

``make corpus``. What is there already is left as it is: files of a released version are never written again. Every
number in ``KNOWN`` is a closed form, so the test that reads the files asks them for something that is true.
"""

from __future__ import annotations

import json
import os
import tomllib
from pathlib import Path

from typer.testing import CliRunner

import directrix as dx
from directrix.cli import app
from directrix.schema import load_case

FOLDER = Path(__file__).parent
ROD = """
[section.plain]
kind = "moduli"
EA = 50.0
GA1 = 20.0
GA2 = 20.0
EI1 = 3.0
EI2 = 3.0
GJ = 2.0
A_rho = 0.5
I_rho1 = 0.01
I_rho2 = 0.01

[[rod]]
name = "rod"
section = "plain"
line = [[0, 0, 0], [2, 0, 0]]
ends = ["a", "b"]
elements = 2
order = 1
"""
CLAMP = '\n[[support]]\nnode = "a"\ntype = "clamp"\n'
PULL = '\n[[force]]\nnode = "b"\nvalue = [3, 0, 0]\n'
CASES = {
    "load": ROD + CLAMP + PULL + "\n[statics]\nsteps = 2\n",
    "path": ROD
    + CLAMP
    + PULL
    + '\n[statics]\ncontrol = { kind = "arc-length", ds = 0.05, max_load_factor = 1.5, load_factors = [1.0] }\n',
    "displacement": ROD
    + CLAMP
    + PULL
    + '\n[statics]\ncontrol = { kind = "displacement", node = "b", component = "x", to = 0.12, steps = 2 }\n',
    "twist": ROD + CLAMP + '\n[[moment]]\nnode = "b"\nvalue = [0.4, 0, 0]\n\n[statics]\nsteps = 1\n',
    "flight": ROD + "\n[rigid_velocity]\nv = [1, 2, 0]\n\n[dynamics]\nt_end = 1\ndt = 0.25\n",
    "hinge": ROD
    + '\n[[joint]]\nname = "pivot"\nkind = "hinge"\na = "a"\naxis = [0, 0, 1]\n\n[[point_mass]]\nnode = "b"\nmass = 2\n'
    + '\n[[spring]]\nname = "stay"\na = "b"\nb = [2, 4, 0]\nstiffness = 5\nlength = 3\n'
    + "\n[gravity]\nvalue = [0, -1, 0]\n\n[dynamics]\nt_end = 0.2\ndt = 0.05\n",
    "floor": ROD
    + '\n[[contact]]\nname = "floor"\nstiffness = 100\nradius = 0.1\n'
    + 'obstacle = { kind = "plane", point = [0, 0, -0.2], normal = [0, 0, 1] }\n'
    + "\n[gravity]\nvalue = [0, 0, -1]\n\n[dynamics]\nt_end = 0.2\ndt = 0.05\n",
}
"""Case files by name; each is written as TOML and as JSON, and run."""

EA_END = 100.0 / 3.0
KNOWN = {
    "load": ("b", "displacement", [0.12, 0.0, 0.0]),  # F L/EA
    "path": ("b", "displacement", [0.18, 0.0, 0.0]),  # at 1.5 times the load
    "displacement": ("b", "displacement", [0.12, 0.0, 0.0]),
    "twist": ("a", "reaction", [0.0, 0.0, 0.0, -0.4, 0.0, 0.0]),
    "flight": ("b", "displacement", [1.0, 2.0, 0.0]),
    "hinge": ("a", "displacement", [0.0, 0.0, 0.0]),
    "floor": ("a", "displacement", [0.0, 0.0, -0.02]),  # ½ g t², it has not touched
    "formed": ("b", "displacement", [0.12, 0.0, 0.0]),
    "continued": ("b", "displacement", [0.18, 0.0, 0.0]),  # EA = 33⅓
    "failed": ("a", "displacement", [0.0, 0.0, 0.0]),
}
"""Node, quantity and its last value."""


def results(cases: dict[str, dx.Result]) -> dict[str, dx.Result]:
    """What has no case file: form finding, continuation, a mode, a run that failed."""
    section = dx.Section.from_moduli(EA=50, GA1=20, GA2=20, EI1=3, EI2=3, GJ=2, A_rho=0.5, I_rho1=0.01, I_rho2=0.01)

    def pulled(EA: float) -> dx.Model:
        moduli = dx.Section.from_moduli(EA=EA, GA1=20, GA2=20, EI1=3, EI2=3, GJ=2)
        rod = dx.Model(name="pulled").rod(
            dx.line((0, 0, 0), (2, 0, 0)), moduli, name="rod", ends=("a", "b"), elements=2
        )
        return rod.clamp("a").force("b", (3, 0, 0))

    rod = dx.Model(name="rod").rod(
        dx.line((0, 0, 0), (2, 0, 0)), section, name="rod", ends=("a", "b"), elements=2, order=1
    )
    coiled = rod.clamp("a").moment("b", (0, 0, 40))  # more than two linear elements can carry
    back = dx.ArcLength(
        ds=0.5, load_step=5.0, load_factors=(EA_END,), direction="backward", until=lambda s: s.load_factor <= EA_END
    )
    return {
        **cases,
        "formed": dx.form_find(pulled(50.0)),
        "continued": dx.continuation(pulled, 50.0, control=back),
        "mode": dx.modes(rod.clamp("a"), count=2).motion(1, frames=5),
        "failed": dx.solve_static(coiled, steps=1),
    }


def main() -> None:
    folder = FOLDER / dx.__version__
    folder.mkdir(exist_ok=True)
    os.chdir(folder)  # so that nothing names a folder of this machine
    found: dict[str, dx.Result] = {}
    for name, text in CASES.items():
        _write(Path(f"{name}.toml"), text.lstrip())
        _write(Path(f"{name}.json"), json.dumps(tomllib.loads(text), indent=1) + "\n")
        found[name] = load_case(f"{name}.toml").run()
    for name, result in results(found).items():
        if not Path(f"{name}.vtkhdf").exists():
            result.save(f"{name}.vtkhdf")
    for name in ("load", "path", "flight"):
        if not Path(f"{name}.run.json").exists():
            done = CliRunner().invoke(app, ["run", f"{name}.toml", "--out", f"{name}.folder"])
            assert done.exit_code == 0, done.output
            Path(f"{name}.folder/run.json").rename(f"{name}.run.json")
            Path(f"{name}.folder/monitor.csv").rename(f"{name}.monitor.csv")
            for left in Path(f"{name}.folder").iterdir():
                left.unlink()
            Path(f"{name}.folder").rmdir()
    _write(Path("known.json"), json.dumps(KNOWN, indent=1) + "\n")
    print(folder, sum(f.stat().st_size for f in folder.iterdir()) // 1024, "kB")


def _write(path: Path, text: str) -> None:
    if not path.exists():
        path.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
