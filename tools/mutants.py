"""Mutation testing of the mechanics, the audit and the compiled loops: change one operator or number, and see whether a
test notices. Traced and compiled code is beyond the usual tools, so every mutant is a copy of the package and a fresh
process (mutant_process.py).

    python tools/mutants.py --count 60 --seed 1 --log mutants.jsonl

With --log a line of JSON is kept for every mutant, and those that have one are not tried again; --again tries the ones
that survived. Every file has its tests, which are first run on the package as it is: they have to pass. What survives
them may be tried again with others: their files are arguments.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import hashlib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "directrix"
TARGETS = ("formulations/*.py", "kernels/*.py", "audit.py", "stepping.py")
# they say what is told to a user or how it is compiled, not what is computed
LEFT_OUT = ("__init__", "conformance", "compile", "jit", "trace", "lanes")
# what notices a change of a file, the quick ones first
OF_RODS = ("formulation", "strips", "ledger", "formulations", "dynamics", "integrators")
OF_LANGUAGE = ("translate", "kernels", *OF_RODS)
OF_CHAINS = ("kernels", "strips", "ledger")
TESTS = {
    "contact": ("contact",), "joint": ("joints",), "attached": ("attachments", "joints", "driven"),
    "driven": ("driven", "ledger"),
    "audit": ("ledger", "dynamics", "driven", "contact"), "stepping": ("stepping",), "struts": ("condensed",),
    "chain": OF_CHAINS, "elimination": OF_CHAINS, "strip_elimination": OF_CHAINS,
    "fronts": ("multifrontal", "condensed"),
    "expressions": OF_LANGUAGE, "translate": OF_LANGUAGE, "kinds": OF_LANGUAGE, "record": OF_LANGUAGE,
}  # fmt: skip
# a third of the time; without them more survive, not fewer
LONG = (
    "tests/test_attachments.py::test_schemes_agree_on_a_machine_as_the_step_shrinks",
    "tests/test_attachments.py::test_many_steps_of_a_machine",
    "tests/test_integrators.py::test_schemes_agree_as_the_step_shrinks",
    "tests/test_dynamics.py::test_many_steps",
)
SWAP: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.GtE, ast.GtE: ast.Lt,
    ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


def sites(tree: ast.AST) -> list[ast.AST]:
    """What can be changed: operators, comparisons and numbers inside functions."""
    found: list[ast.AST] = []
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and not function.name.startswith("__"):
            for node in ast.walk(ast.Module(function.body, [])):
                number = isinstance(node, ast.Constant) and type(node.value) in (int, float)
                operator = isinstance(node, ast.BinOp) and type(node.op) in SWAP
                compared = isinstance(node, ast.Compare) and type(node.ops[0]) in SWAP
                if number or operator or compared or isinstance(node, ast.BoolOp):
                    found.append(node)
    return list(dict.fromkeys(found))


def change(node: ast.AST) -> str:
    """Change a node in place; what was done."""
    before = ast.unparse(node)
    match node:
        case ast.Constant():
            value: Any = node.value
            node.value = value + 1 if isinstance(value, int) else 2.0 * value + 1.0
        case ast.BinOp():
            node.op = SWAP[type(node.op)]()  # type: ignore[assignment]
        case ast.Compare():
            node.ops[0] = SWAP[type(node.ops[0])]()  # type: ignore[assignment]
        case ast.BoolOp():
            node.op = SWAP[type(node.op)]()  # type: ignore[assignment]
        case _:
            raise TypeError(node)
    return f"{before}  →  {ast.unparse(node)}"


def tried(file: Path, text: str, tests: Sequence[str], limit: float, cache: Path) -> dict[str, Any]:
    """What the tests say when ``file`` holds ``text``."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "src" / "directrix"
        shutil.copytree(PACKAGE, copy)
        (copy / file).write_text(text, encoding="utf-8")
        report = Path(folder) / "report.json"
        own = {
            "PYTHONPATH": f"{copy.parent}{os.pathsep}{Path(__file__).parent}", "DIRECTRIX_CACHE_DIR": str(cache),
            "MUTANT_SOURCES": folder, "MUTANT_REPORT": str(report), "CI": "1", "OPENBLAS_NUM_THREADS": "1",
        }  # fmt: skip
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "--no-header",
            "-p",
            "no:cacheprovider",
            "-p",
            "mutant_process",
        ]
        command += ["--hypothesis-profile=mutants", *(f"--deselect={test}" for test in LONG), *tests]
        begun = time.monotonic()
        try:
            done = subprocess.run(
                command, cwd=ROOT, env={**os.environ, **own}, timeout=limit, capture_output=True, text=True
            )
            code = done.returncode
            how = {0: "", 1: "failed"}.get(code, f"exit code {code}")
        except subprocess.TimeoutExpired:
            how = "time"  # a loop that never ends is noticed
        said = json.loads(report.read_text("utf-8")) if report.exists() else {"test": "", "compiled": 0}
        seconds = round(time.monotonic() - begun, 1)
        return {
            "alive": not how,
            "how": how,
            "test": said["test"] if how else "",
            "compiled": said["compiled"],
            "seconds": seconds,
        }


def main() -> int:
    """Try a sample of all mutants; exit code 1 below the score asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=60, help="mutants to try")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--limit", type=float, default=1800.0, help="seconds for one, beside a minute of computing for a test"
    )
    parser.add_argument("--least", type=float, default=0.0, help="share that has to be noticed")
    parser.add_argument("--only", default="", help="files whose path holds this")
    parser.add_argument("--log", type=Path, help="where a line is kept for every mutant")
    parser.add_argument("--cache", type=Path, help="where machine code is kept from one call to the next")
    parser.add_argument("--again", action="store_true", help="try again what has survived")
    parser.add_argument("tests", nargs="*", help="files of tests, in place of those of the mutated file")
    given = parser.parse_args()
    files = sorted({f for pattern in TARGETS for f in PACKAGE.glob(pattern)})
    files = [f for f in files if f.stem not in LEFT_OUT and given.only in str(f)]
    trees = {f: ast.parse(f.read_text("utf-8")) for f in files}
    pool = [(f, k) for f, tree in trees.items() for k in range(len(sites(tree)))]
    chosen = random.Random(given.seed).sample(pool, min(given.count, len(pool)))
    known: dict[tuple[str, int, str], dict[str, Any]] = {}
    if given.log and given.log.exists():
        for line in given.log.read_text("utf-8").splitlines():
            one = json.loads(line)
            known[one["file"], one["site"], one["source"]] = one
    compileall.compile_dir(PACKAGE, quiet=1)  # what is copied is loaded sooner
    passed: set[tuple[str, ...]] = set()
    noticed = 0
    with tempfile.TemporaryDirectory() as folder:
        cache = given.cache or Path(folder)
        for number, (file, site) in enumerate(chosen, 1):
            path, text = str(file.relative_to(PACKAGE)), file.read_text("utf-8")
            tree = ast.parse(text)
            node = sites(tree)[site]
            source = hashlib.sha256(text.encode()).hexdigest()[:16]
            one = known.get((path, site, source))
            if one is None or (given.again and one["alive"]):
                tests = tuple(given.tests or [f"tests/test_{name}.py" for name in TESTS.get(file.stem, OF_RODS)])
                if tests not in passed:
                    plain = tried(Path(path), text, tests, given.limit, cache)
                    if not plain["alive"]:
                        raise SystemExit(f"the tests notice something where nothing was changed: {plain}")
                    passed.add(tests)
                line, did = getattr(node, "lineno", 0), change(node)
                one = {"file": path, "site": site, "source": source, "line": line, "change": did}
                one |= tried(Path(path), ast.unparse(tree), tests, given.limit, cache)
                if given.log:
                    with given.log.open("a", encoding="utf-8") as log:
                        log.write(json.dumps(one) + "\n")
            noticed += not one["alive"]
            about = f"[{one['seconds']:.0f} s, {one['compiled']} compiled] {one['how']} {one['test']}"
            word = "SURVIVES" if one["alive"] else "noticed "
            print(
                f"{number:3}/{len(chosen)} {noticed / number:4.0%} {word} {path}:{one['line']} {one['change']} {about}",
                flush=True,
            )
    print(f"{noticed} of {len(chosen)} noticed ({noticed / max(1, len(chosen)):.0%}), out of {len(pool)} possible")
    return 0 if noticed >= given.least * len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main())
