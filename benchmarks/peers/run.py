"""directrix beside other programs: every peer in an environment of its own, on one core, directrix in turns with it.

    python benchmarks/peers/run.py              # makes the environments, runs all, writes docs/peers.{json,md}
    python benchmarks/peers/run.py --quick      # the smallest meshes, one round; prints, writes nothing
    python benchmarks/peers/run.py --only Exudyn --only MuJoCo
    python benchmarks/peers/run.py --tables     # only the tables again, from docs/peers.json

Run it with the Python that directrix is installed in. Every run is a process of its own, ``LIMIT`` seconds at most.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import venv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import common

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
ROUNDS = 3  # best of; one for a peer that takes more than 5 s or fails
LIMIT = 100  # seconds a run may take
Line = dict[str, Any]


@dataclass(frozen=True)
class Peer:
    script: str
    packages: tuple[str, ...]
    runs: dict[str, tuple[tuple[int, float, str], ...]]  # case: (n, Δt, variant)


PEERS = {
    "Exudyn": Peer(
        "peer_exudyn.py", ("exudyn",), {
            "swing": ((20, 1e-3, "cable"), (20, 1e-3, "beam"), (100, 1e-3, "cable"), (100, 1e-3, "beam"),
                      (1000, 1e-3, "cable")),
            "accuracy": ((20, 4e-3, "cable"), (60, 2e-3, "beam")),
            "flight": ((5, 0.2, "beam"), (5, 0.2, "beam 0.9")),
            "spaghetti": ((20, 0.1, "beam"), (20, 0.1, "beam J=10")),
        },
    ),
    "MuJoCo": Peer(
        "peer_mujoco.py", ("mujoco<4", "scipy"), {
            "swing": ((20, 1e-3, "RK4"), (20, 1e-3, "implicitfast"), (100, 1e-3, "implicitfast")),
            "accuracy": ((40, 5e-4, "RK4"),), "flight": ((5, 0.2, "RK4"),), "spaghetti": ((20, 0.1, "RK4"),),
        },
    ),
    "PyElastica": Peer(
        "peer_pyelastica.py", ("pyelastica",), {
            "swing": ((20, 1e-3, "1.0"), (100, 1e-3, "1.0")),
            "accuracy": ((40, 1e-3, "1.0"), (100, 1e-3, "1.0")),
            "flight": ((5, 0.2, "1.0"),), "spaghetti": ((20, 0.1, "1.0"),),
        },
    ),
    "OpenSees": Peer(
        "peer_opensees.py", ("openseespy", "numpy"), {
            "swing": ((20, 1e-3, "corotational"), (100, 1e-3, "corotational")),
            "flight": ((5, 0.2, "corotational"),), "spaghetti": ((20, 0.1, "corotational"),),
        },
    ),
    "Kratos": Peer(
        "peer_kratos.py",
        ("KratosMultiphysics", "KratosStructuralMechanicsApplication", "KratosLinearSolversApplication"), {
            "swing": ((20, 1e-3, "corotational"), (100, 1e-3, "corotational")),
            "flight": ((5, 0.2, "corotational"),), "spaghetti": ((20, 0.1, "corotational"),),
        },
    ),
}  # fmt: skip
# directrix where accuracy is what counts: (n, Δt, order)
OURS = {1.5e-4: (12, 2e-3, "2"), 1e-3: (8, 5e-3, "2")}


def environment(name: str, peer: Peer) -> Path:
    """The Python of the peer's environment, which is made where it is not there."""
    home = HERE / ".venvs" / name.lower()
    python, done = home / "bin" / "python", home / "done"
    if not done.exists():
        venv.create(home, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *peer.packages], check=True)
        done.write_text("\n".join(peer.packages))
    return python


def once(python: Path | str, script: str, case: str, n: int, dt: float, variant: str) -> Line:
    """One run in a process of its own, on one core and one thread."""
    core = str(max(os.sched_getaffinity(0))) if hasattr(os, "sched_getaffinity") else None
    pinned = ["taskset", "-c", core] if core is not None else []
    command = [
        *pinned,
        str(python),
        str(HERE / script),
        "swing" if case == "accuracy" else case,
        str(n),
        str(dt),
        variant,
    ]
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    line: Line = {"n": n, "dt": dt, "variant": variant, "completed": False, "cpu": None, "tip": None, "drift": None}
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=LIMIT,
            env=os.environ | threads,
            check=False,
            cwd=tempfile.gettempdir(),
        )
    except subprocess.TimeoutExpired:
        return line | {"case": case, "note": f"not done after {LIMIT} s"}
    try:
        line |= json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        line |= {"note": f"ended with {done.returncode} and no answer"}
    return line | {"case": case}


def off(line: Line) -> float | None:
    """How far the tip of the swing is from where it should be."""
    if line["case"] not in ("swing", "accuracy") or not line["tip"]:
        return None
    return sum((a - b) ** 2 for a, b in zip(line["tip"], common.SWING_TIP, strict=True)) ** 0.5


def best(lines: list[Line]) -> Line:
    done = [line for line in lines if line["completed"]]
    return min(done, key=lambda line: line["cpu"]) if done else lines[0]


def pair(name: str, peer: Peer, case: str, n: int, dt: float, variant: str, rounds: int) -> Line:
    """The peer and directrix in turns, best of ``rounds`` (one where the peer takes more than 20 s or fails)."""
    python = environment(name, peer)
    theirs: list[Line] = []
    ours: list[Line] = []
    for _ in range(rounds):
        theirs.append(once(python, peer.script, case, n, dt, variant))
        mine = (n, dt, "1")
        if case == "accuracy":
            error = off(theirs[-1])
            bound = 1.5e-4 if error is not None and error <= 1.5e-4 else 1e-3
            mine = OURS[bound]
        ours.append(once(sys.executable, "peer_directrix.py", case, *mine))
        if not theirs[-1]["completed"] or theirs[-1]["cpu"] > 5:
            break
    line, own = best(theirs), best(ours)
    line["peer"] = name
    ratio = line["cpu"] / own["cpu"] if line["completed"] and own["completed"] else None
    line |= {"off": off(line), "ratio": ratio, "rounds": len(theirs), "directrix": own | {"off": off(own)}}
    print(json.dumps(line), flush=True)
    return line


def _number(value: float | None, form: str = ".2g") -> str:
    return "–" if value is None else format(value, form)


def _remark(line: Line) -> str:
    stopped = f"stopped at t = {line['reached']:.3g}" if line.get("reached") and not line["completed"] else ""
    return "; ".join(said for said in (stopped, line.get("note", "").replace("|", "/")) if said)


def _row(line: Line, name: str) -> str:
    end = {"swing": 1.0, "accuracy": 1.0, "flight": 30.0, "spaghetti": 10.0}[line["case"]]
    speed = (
        line["cpu"] / (end / line["dt"]) / line["n"] / (3 if line["case"] == "flight" else 1) * 1e6
        if line["completed"]
        else None
    )
    cells = [
        f"{name} {line['variant']}", str(line["n"]), f"{line['dt']:.3g}", "yes" if line["completed"] else "no",
        _number(line["cpu"] if line["completed"] else None, ".3g"), _number(speed), _number(line.get("off"), ".1e"),
        _number(line["drift"], ".1e"), _number(line.get("ratio"), ".3g"), _remark(line),
    ]  # fmt: skip
    return "| " + " | ".join(cells) + " |"


HEAD = (
    "| program, element | n | Δt | done | CPU s | µs per element and step | tip off by | energy drift "
    "| times directrix | remark |\n" + "| --- " * 10 + "|"
)
TITLES = {
    "swing": "The swing, same mesh and step", "accuracy": "The swing, equal accuracy",
    "flight": "Free flight, Δt = 0.2", "spaghetti": "Flying spaghetti in space, Δt = 0.1",
}  # fmt: skip


def _key(line: Line) -> tuple[int, float, str]:
    return line["n"], line["dt"], line["variant"]


def tables(record: Line) -> str:
    out: list[str] = []
    for case, title in TITLES.items():
        rows = [line for line in record["runs"] if line["case"] == case]
        if not rows:
            continue
        out += [f"### {title}", "", HEAD]
        seen: set[tuple[int, float, str]] = set()
        for line in rows:
            own = line["directrix"]
            key = _key(own)
            if key not in seen:
                seen.add(key)
                same = [r["directrix"] for r in rows if _key(r["directrix"]) == key]
                out.append(_row(best(same) | {"case": case}, "**directrix** order"))
            out.append(_row(line, line["peer"]))
        out.append("")
    versions = sorted({f"{line['peer']} {line['version']}" for line in record["runs"] if line.get("version")})
    out.append(f"Versions: {', '.join(versions)}. {record['machine']}, Python {record['python']}.")
    return "\n".join(out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", action="append", choices=list(PEERS), help="this peer; may be said again")
    parser.add_argument("--quick", action="store_true", help="n ≤ 20, one round, nothing written")
    parser.add_argument("--tables", action="store_true", help="write the tables from docs/peers.json and run nothing")
    args = parser.parse_args()
    store, page = DOCS / "peers.json", DOCS / "peers.md"
    record: Line = json.loads(store.read_text()) if store.exists() else {"runs": []}
    if not args.tables:
        names = args.only or list(PEERS)
        kept = [line for line in record["runs"] if line["peer"] not in names]
        for name in names:
            for case, runs in PEERS[name].runs.items():
                for n, dt, variant in runs:
                    if not args.quick or n <= 20:
                        kept.append(pair(name, PEERS[name], case, n, dt, variant, 1 if args.quick else ROUNDS))
        order = list(PEERS)
        kept.sort(key=lambda line: (list(TITLES).index(line["case"]), order.index(line["peer"])))
        record = {"machine": _processor(), "python": platform.python_version(), "runs": kept}
    if args.quick:
        print(tables(record))
        return
    store.write_text(json.dumps(record, indent=1) + "\n")
    text = page.read_text()
    before, after = text.split("<!-- tables -->\n")[0], text.split("<!-- end of tables -->\n")[1]
    page.write_text(f"{before}<!-- tables -->\n\n{tables(record)}\n\n<!-- end of tables -->\n{after}")


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    names = (
        [row.split(":")[1].strip() for row in info.read_text().splitlines() if "model name" in row]
        if info.exists()
        else []
    )
    return names[0] if names else platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
