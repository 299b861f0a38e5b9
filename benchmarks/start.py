"""What comes before the first step: import, help, a first run that compiles and one that does not. CPU seconds.

Byte code is kept, as it is where Python is used as it comes; machine code is not there before the first run.

python benchmarks/start.py
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

RUN = """
import directrix as dx
rubber = dx.Section.circle(radius=0.01, E=5e6, nu=0.5, rho=1100)
rod = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), rubber, ends=("pin", "tip"), elements=20)
assert dx.simulate(rod.pin("pin").gravity((0, 0, -9.81)), t_end=0.1, dt=0.01).success
"""


def seconds(*command: str, **variables: str) -> float:
    """CPU seconds of a command and all it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run(command, check=True, env={**kept, **variables}, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print a line each."""
    python = sys.executable
    with tempfile.TemporaryDirectory() as folder:
        kept = {"DIRECTRIX_CACHE_DIR": str(Path(folder) / "code"), "PYTHONPYCACHEPREFIX": str(Path(folder) / "python")}
        seconds(python, "-c", "from directrix import simulate", **kept)
        cold = seconds(python, "-c", RUN, **kept)
        warm = min(seconds(python, "-c", RUN, **kept) for _ in range(3))
        imported = min(seconds(python, "-c", "from directrix import simulate", **kept) for _ in range(3))
        helped = min(seconds(python, "-m", "directrix", "--help", **kept) for _ in range(4))
    rows = (
        ("import directrix and its solvers", imported, 0.8),
        ("directrix --help", helped, 0.5),
        ("a first run, which compiles", cold, 15.0),
        ("the same again", warm, 1.0),
    )
    for what, value, target in rows:
        print(f"{what:<34}{value:>7.2f} s   target {target:g} s")


if __name__ == "__main__":
    main()
