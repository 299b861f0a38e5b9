"""From recorded scalars to machine code: one element per SIMD lane.

A kernel is ``void k(double *x, double *p, double *g, double *out)``: nodal values ``x`` and results ``out``
have one row a lane (its length rounded up to whole vectors), element parameters ``p`` are
``[parameter][lane]``, ``g`` are scalars common to all lanes. Rows are turned into lanes inside.
Multiplications and additions may be contracted to FMA; nothing else is relaxed, so a result does not depend on the lane.
"""

from __future__ import annotations

import hashlib
import os
import struct
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from directrix.kernels.trace import Graph, Sym, needed

__all__ = ["LANES", "cache_dir", "kernel_address", "padded", "text_address"]


def _features() -> str:
    return llvm.get_host_cpu_features().flatten()


def _machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=_features(), opt=2, jit=True, reloc="pic"
    )


LANES = 8 if "+avx512f" in _features() else 4


def cache_dir() -> Path:
    """Where compiled kernels are kept: ``$DIRECTRIX_CACHE_DIR`` or ``directrix`` in the user's cache."""
    given = os.environ.get("DIRECTRIX_CACHE_DIR")
    if given:
        return Path(given)
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "directrix"


def padded(count: int) -> int:
    """Places that ``count`` numbers take in a buffer with one row a lane."""
    return -(-count // LANES) * LANES


def _interleaved(vectors: list[str], vec: str, tag: str, lines: list[str]) -> list[str]:
    """Transpose of ``len(vectors)`` vectors of as many lanes: log2 rounds of interleaving halves."""
    n = len(vectors)
    for turn in range(n.bit_length() - 1):
        mixed: list[str] = []
        for i in range(n // 2):
            for half in range(2):
                picks = [f"i32 {(half * n // 2 + k // 2) + (n if k % 2 else 0)}" for k in range(n)]
                name = f"%m{tag}_{turn}_{i}_{half}"
                lines.append(
                    f"{name} = shufflevector {vec} {vectors[i]}, {vec} {vectors[i + n // 2]}, "
                    f"<{n} x i32> <{', '.join(picks)}>"
                )
                mixed.append(name)
        vectors = mixed
    return vectors


def llvm_ir(graph: Graph, outputs: Sequence[Sym], name: str) -> str:
    """LLVM text of a kernel that computes ``outputs``; inputs are named by ``x``, ``p`` or ``g``."""
    lanes = LANES
    vec = f"<{lanes} x double>"
    lines = [f"define void @{name}(ptr noalias %x, ptr noalias %p, ptr noalias %g, ptr noalias %out) {{"]
    text: dict[int, str] = {}
    instruction = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
    used = {a: 1 + max(b for op, c, b in graph.ops if op == "in" and c == a) for a in ("x",)}
    row_in, row_out = padded(used["x"]), padded(len(outputs))
    rows: dict[int, list[str]] = {}

    def at(tag: str, array: str, offset: int) -> str:
        lines.append(f"%e{tag} = getelementptr double, ptr %{array}, i64 {offset}")
        return f"%e{tag}"

    def load(tag: str, array: str, offset: int, kind: str) -> str:
        place = at(tag, array, offset)
        lines.append(f"%l{tag} = load {kind}, ptr {place}, align 8")
        return f"%l{tag}"

    def emit(index: int) -> None:
        op, a, b = graph.ops[index]
        if op == "const":
            bits = struct.pack(">d", float(a)).hex().upper()
            text[index] = "<" + ", ".join([f"double 0x{bits}"] * lanes) + ">"
        elif op == "in" and a == "g":
            one = load(f"g{b}", "g", b, "double")
            zeros = f"<{lanes} x i32> zeroinitializer"
            lines.append(f"%t{index} = insertelement {vec} undef, double {one}, i32 0")
            lines.append(f"%v{index} = shufflevector {vec} %t{index}, {vec} undef, {zeros}")
            text[index] = f"%v{index}"
        elif op == "in" and a == "p":
            text[index] = load(f"p{b}", "p", b * lanes, vec)
        elif op == "in":
            group = b // lanes
            if group not in rows:
                by_lane = [load(f"x{group}_{k}", "x", k * row_in + group * lanes, vec) for k in range(lanes)]
                rows[group] = _interleaved(by_lane, vec, f"x{group}", lines)
            text[index] = rows[group][b % lanes]
        else:
            flags = "" if op == "div" else "contract "
            lines.append(f"%v{index} = {instruction[op]} {flags}{vec} {text[int(a)]}, {text[b]}")
            text[index] = f"%v{index}"

    done: set[int] = set()
    for first in range(0, len(outputs), lanes):
        part = outputs[first : first + lanes]
        for index in needed(graph, part, done):
            emit(index)
        columns = [text[out.index] for out in part] + ["zeroinitializer"] * (lanes - len(part))
        for k, value in enumerate(_interleaved(columns, vec, f"o{first}", lines)):
            lines.append(f"store {vec} {value}, ptr {at(f'o{first}_{k}', 'out', k * row_out + first)}, align 8")
    return "\n".join([*lines, "ret void", "}"])


@cache
def _engine() -> Any:
    # the engine takes the machine it is given as its own
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())


def _object(text: str) -> bytes:
    module = llvm.parse_assembly(text)
    module.verify()
    return _machine().emit_object(module)


@cache
def _sources() -> bytes:
    """What a kernel depends on beside its own description: the code that traces and emits it."""
    here = Path(__file__).parent
    files = [*sorted(here.glob("*.py")), *sorted((here.parent / "formulations").glob("*.py")), here.parent / "basis.py"]
    return b"\0".join(f.read_bytes() for f in files)


_addresses: dict[str, int] = {}


def kernel_address(description: str, build: Callable[[], tuple[Graph, Sequence[Sym]]]) -> int:
    """Address of the machine code of a kernel, compiled at most once per machine.

    ``description`` names the kernel and everything ``build`` depends on beside the source code; ``build``
    records it and is called only when nothing usable is in the cache.
    """
    return text_address(description, lambda name: llvm_ir(*build(), name))


def text_address(description: str, text: Callable[[str], str]) -> int:
    """Address of the function that ``text(name)`` defines in LLVM's language, compiled at most once per machine."""
    machine_key = f"{llvm.get_host_cpu_name()} {_features()} {llvmlite.__version__} {LANES}"
    digest = hashlib.sha256(_sources() + machine_key.encode() + description.encode()).hexdigest()
    name = f"k{digest[:24]}"
    if name in _addresses:
        return _addresses[name]
    path = cache_dir() / f"{name}.o"
    try:
        code = path.read_bytes()
    except OSError:
        code = _object(text(name))
        _keep(path, code)
    engine = _engine()
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _addresses[name] = engine.get_function_address(name)
    return _addresses[name]


def _keep(path: Path, code: bytes) -> None:
    """Write to the cache, atomically; a cache that cannot be written costs time and nothing else."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as f:
            f.write(code)
        os.replace(f.name, path)
    except OSError:
        pass
