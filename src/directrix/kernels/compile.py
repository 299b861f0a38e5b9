"""From recorded scalars to machine code: one element per SIMD lane.

A kernel is ``void k(double *x, int64 *at, double *p, double *g, double *out)``. The values of node a of the element
in lane l begin at ``x[at[a][l]]``; element parameters ``p`` are ``[parameter][lane]``; ``g`` are scalars common to
all lanes; results ``out`` have one row a lane, its length rounded up to whole vectors. Inside, rows are turned into
lanes and back.
Multiplications and additions may be contracted to FMA; nothing else is relaxed: no result depends on its lane.
"""
# pyright: reportUnknownMemberType=false

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

from directrix.kernels.order import FENCE, scheduled
from directrix.kernels.trace import FUNCTIONS, Graph, Sym

__all__ = ["LANES", "STRIDE", "cache_dir", "kernel_address", "padded", "text_address"]


@cache
def _features() -> str:
    return llvm.get_host_cpu_features().flatten()


@cache
def _key() -> bytes:
    """What machine code depends on beside its own description."""
    machine = f"{llvm.get_host_cpu_name()} {_features()} {llvmlite.__version__} {LANES}"
    return _sources() + machine.encode()


def _machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=_features(), opt=2, jit=True, reloc="pic"
    )


STRIDE = 40  # values a node has in memory: a multiple of every number of lanes
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
    """LLVM text of a kernel that computes ``outputs`` and leaves them in a row.

    Inputs are named by ``x`` (STRIDE values a node), ``p`` or ``g``.
    """
    lanes = LANES
    vec = f"<{lanes} x double>"
    lines = [
        f"define void @{name}(ptr noalias %x, ptr noalias %at, ptr noalias %p, ptr noalias %g, ptr noalias %out) {{",
        f"%scratch = alloca [{padded(len(outputs))} x {vec}], align 64",
    ]
    text: dict[int, str] = {}
    instruction = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
    row = padded(len(outputs))
    groups: dict[int, list[str]] = {}
    count = 0

    def put(instruction: str) -> str:
        nonlocal count
        count += 1
        lines.append(f"%t{count} = {instruction}")
        return f"%t{count}"

    def pointer(array: str, offset: int | str, kind: str = "double") -> str:
        return put(f"getelementptr {kind}, ptr {array}, i64 {offset}")

    def load(array: str, offset: int, kind: str) -> str:
        return put(f"load {kind}, ptr {pointer(array, offset)}, align 8")

    def group(index: int) -> list[str]:
        """``lanes`` consecutive values of a node, from every lane's own node, by lanes."""
        if index not in groups:
            node, offset = divmod(index * lanes, STRIDE)
            by_lane: list[str] = []
            for lane in range(lanes):
                start = put(f"load i64, ptr {pointer('%at', node * lanes + lane, 'i64')}, align 8")
                by_lane.append(load(pointer("%x", start), offset, vec))
            groups[index] = _interleaved(by_lane, vec, f"x{index}", lines)
        return groups[index]

    def emit(index: int) -> str:
        op, a, b = graph.ops[index]
        if op == "const":
            bits = struct.pack(">d", float(a)).hex().upper()
            return "<" + ", ".join([f"double 0x{bits}"] * lanes) + ">"
        if op == "in" and a == "g":
            one = put(f"insertelement {vec} undef, double {load('%g', b, 'double')}, i32 0")
            return put(f"shufflevector {vec} {one}, {vec} undef, <{lanes} x i32> zeroinitializer")
        if op == "in":
            return load("%p", b * lanes, vec) if a == "p" else group(b // lanes)[b % lanes]
        if op in FUNCTIONS:
            return put(f"call {vec} @llvm.{op}.v{lanes}f64({vec} {text[int(a)]})")
        flags = "" if op == "div" else "contract "
        return put(f"{instruction[op]} {flags}{vec} {text[int(a)]}, {text[b]}")

    for indices, part in scheduled(graph, outputs, reread=False):
        for index in indices:
            text[index] = emit(index)
        for k in part:
            target = pointer("%scratch", k, vec)
            lines.append(f"store {vec} {text[outputs[k].index]}, ptr {target}, align 64")
        lines.append(FENCE)
    for first in range(0, row, lanes):
        columns = [put(f"load {vec}, ptr {pointer('%scratch', first + k, vec)}, align 64") for k in range(lanes)]
        for lane, value in enumerate(_interleaved(columns, vec, f"o{first}", lines)):
            lines.append(f"store {vec} {value}, ptr {pointer('%out', lane * row + first)}, align 8")
    used = {op for op, _, _ in graph.ops} & FUNCTIONS.keys()
    declared = [f"declare {vec} @llvm.{op}.v{lanes}f64({vec})" for op in sorted(used)]
    return "\n".join([*declared, *lines, "ret void", "}"])


def _object(text: str, loops: bool) -> bytes:
    module, machine = llvm.parse_assembly(text), _machine()
    module.verify()
    if loops:  # what the element kernels are has nothing left to gain
        builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
        builder.getModulePassManager().run(module, builder)
    return machine.emit_object(module)


@cache
def _sources() -> bytes:
    """What a kernel depends on beside its own description: the code that traces and emits it."""
    here = Path(__file__).parent
    files = [
        *sorted(here.glob("*.py")),
        *sorted((here.parent / "formulations").glob("*.py")),
        here.parent / "basis.py",
    ]
    return hashlib.sha256(b"\0".join(f.read_bytes() for f in files)).digest()


_addresses: dict[str, int] = {}
_engines: dict[str, Any] = {}


Recorded = tuple[Graph, Sequence[Sym]]
"""A graph, and its results in the order of a row."""


def kernel_address(description: str, build: Callable[[], Recorded]) -> int:
    """Address of the machine code of a kernel, compiled at most once per machine.

    ``description`` names the kernel and everything ``build`` depends on beside the source code; ``build``
    records it and is called only when nothing usable is in the cache.
    """
    return text_address(description, lambda name: llvm_ir(*build(), name))


def text_address(description: str, text: Callable[[str], str], loops: bool = False) -> int:
    """Address of the function that ``text(name)`` defines in LLVM's language, compiled at most once per machine.

    ``loops`` says that it is worth optimising before code is made of it."""
    digest = hashlib.sha256(_key() + description.encode()).hexdigest()
    name = f"k{digest[:24]}"
    if name in _addresses:
        return _addresses[name]
    path = cache_dir() / f"{name}.o"
    try:
        code = path.read_bytes()
    except OSError:
        code = _object(text(name), loops)
        _keep(path, code)
    # An engine a kernel: one that has finished with a kernel that calls exp or the like gives no address for the next.
    # The engine takes the machine it is given as its own.
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _engines[name] = engine
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
