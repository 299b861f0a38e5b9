"""Mutation testing of the mechanics, the audit and the compiled loops: change one operator or number, and see whether a
test notices. Traced and compiled code is beyond the usual tools, so every mutant is a copy of the package and a fresh
process.

    python tools/mutants.py --count 60 --seed 1
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "directrix"
TARGETS = ("formulations/*.py", "kernels/*.py", "audit.py", "stepping.py")
# they say what is told to a user or how it is compiled, not what is computed
LEFT_OUT = ("__init__", "conformance", "compile", "jit", "trace", "lanes")
TESTS = (
    "tests/test_kernels.py", "tests/test_dynamics.py", "tests/test_stepping.py", "tests/test_ledger.py",
    "tests/test_formulation.py", "tests/test_formulations.py", "tests/test_integrators.py", "tests/test_strips.py",
    "tests/test_joints.py", "tests/test_contact.py", "tests/test_driven.py", "tests/test_attachments.py",
)  # fmt: skip
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
    line = getattr(node, "lineno", 0)
    before = ast.unparse(node)
    match node:
        case ast.Constant():
            node.value = node.value + 1 if isinstance(node.value, int) else 2.0 * node.value + 1.0
        case ast.BinOp():
            node.op = SWAP[type(node.op)]()  # type: ignore[assignment]
        case ast.Compare():
            node.ops[0] = SWAP[type(node.ops[0])]()  # type: ignore[assignment]
        case ast.BoolOp():
            node.op = SWAP[type(node.op)]()  # type: ignore[assignment]
        case _:
            raise TypeError(node)
    return f"line {line}: {before}  →  {ast.unparse(node)}"


def survives(file: Path, text: str, tests: list[str], limit: float) -> bool:
    """True when no test notices that ``file`` holds ``text``."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "src" / "directrix"
        shutil.copytree(PACKAGE, copy)
        (copy / file).write_text(text, encoding="utf-8")
        own = {"PYTHONPATH": str(copy.parent), "DIRECTRIX_CACHE_DIR": f"{folder}/cache", "CI": "1"}
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", *tests]
        try:
            done = subprocess.run(command, cwd=ROOT, env={**os.environ, **own}, timeout=limit, capture_output=True)
        except subprocess.TimeoutExpired:
            return False  # a loop that never ends is noticed
        return done.returncode == 0


def main() -> int:
    """Try a sample of all mutants; exit code 1 below the score asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=60, help="mutants to try")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=900.0, help="seconds for one")
    parser.add_argument("--least", type=float, default=0.0, help="share that has to be noticed")
    parser.add_argument("--only", default="", help="files whose path holds this")
    parser.add_argument("tests", nargs="*", default=list(TESTS))
    given = parser.parse_args()
    files = sorted({f for pattern in TARGETS for f in PACKAGE.glob(pattern)} - {None})
    files = [f for f in files if f.stem not in LEFT_OUT and given.only in str(f)]
    trees = {f: ast.parse(f.read_text("utf-8")) for f in files}
    pool = [(f, k) for f, tree in trees.items() for k in range(len(sites(tree)))]
    chosen = random.Random(given.seed).sample(pool, min(given.count, len(pool)))
    noticed = 0
    for number, (file, k) in enumerate(chosen, 1):
        tree = ast.parse(file.read_text("utf-8"))
        done = change(sites(tree)[k])
        alive = survives(file.relative_to(PACKAGE), ast.unparse(tree), given.tests, given.limit)
        noticed += not alive
        word = "SURVIVES" if alive else "noticed "
        print(f"{number:3}/{len(chosen)} {word} {file.relative_to(PACKAGE)} {done}", flush=True)
    print(f"{noticed} of {len(chosen)} noticed ({noticed / max(1, len(chosen)):.0%}), out of {len(pool)} possible")
    return 0 if noticed >= given.least * len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main())
