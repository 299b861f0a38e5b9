"""From recorded scalars to machine code: one element per SIMD lane.

A kernel is ``void k(double *x, double *p, double *g, double *out)``: ``x`` nodal values and ``p`` element
parameters as ``[component][lane]``, ``g`` scalars common to all lanes, ``out`` as ``[component][lane]``.
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

__all__ = ["LANES", "cache_dir", "kernel_address"]


@cache
def _target() -> tuple[Any, str]:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    features = llvm.get_host_cpu_features().flatten()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=features, opt=2, jit=True, reloc="pic"
    )
    return machine, features


@cache
def _lanes() -> int:
    return 8 if "+avx512f" in _target()[1] else 4


LANES = _lanes()


def cache_dir() -> Path:
    """Where compiled kernels are kept: ``$DIRECTRIX_CACHE_DIR`` or ``directrix`` in the user's cache."""
    given = os.environ.get("DIRECTRIX_CACHE_DIR")
    if given:
        return Path(given)
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "directrix"


def llvm_ir(graph: Graph, outputs: Sequence[Sym], name: str, lanes: int) -> str:
    """LLVM text of a kernel that computes ``outputs``; inputs are named by ``x``, ``p`` or ``g``."""
    vec = f"<{lanes} x double>"
    lines = [
        f"define void @{name}(ptr noalias %x, ptr noalias %p, ptr noalias %g, ptr noalias %out) {{"
    ]
    where: dict[int, list[int]] = {}
    for slot, out in enumerate(outputs):
        where.setdefault(out.index, []).append(slot)
    text: dict[int, str] = {}
    instruction = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}

    def pointer(tag: str, array: str, offset: int) -> None:
        lines.append(f"%e{tag} = getelementptr double, ptr %{array}, i64 {offset}")

    for index in needed(graph, outputs):
        op, a, b = graph.ops[index]
        if op == "const":
            bits = struct.pack(">d", float(a)).hex().upper()
            text[index] = "<" + ", ".join([f"double 0x{bits}"] * lanes) + ">"
        elif op == "in" and a == "g":
            pointer(f"i{index}", "g", b)
            lines.append(f"%s{index} = load double, ptr %ei{index}, align 8")
            lines.append(f"%t{index} = insertelement {vec} undef, double %s{index}, i32 0")
            zeros = f"<{lanes} x i32> zeroinitializer"
            lines.append(f"%v{index} = shufflevector {vec} %t{index}, {vec} undef, {zeros}")
            text[index] = f"%v{index}"
        elif op == "in":
            pointer(f"i{index}", str(a), b * lanes)
            lines.append(f"%v{index} = load {vec}, ptr %ei{index}, align 8")
            text[index] = f"%v{index}"
        else:
            flags = "" if op == "div" else "contract "
            lines.append(f"%v{index} = {instruction[op]} {flags}{vec} {text[int(a)]}, {text[b]}")
            text[index] = f"%v{index}"
        for slot in where.get(index, ()):
            pointer(f"o{slot}", "out", slot * lanes)
            lines.append(f"store {vec} {text[index]}, ptr %eo{slot}, align 8")
    return "\n".join([*lines, "ret void", "}"])


@cache
def _engine() -> Any:
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target()[0])


def _object(text: str) -> bytes:
    machine = _target()[0]
    module = llvm.parse_assembly(text)
    module.verify()
    return machine.emit_object(module)


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
    machine_key = f"{llvm.get_host_cpu_name()} {_target()[1]} {llvmlite.__version__} {LANES}"
    digest = hashlib.sha256(_sources() + machine_key.encode() + description.encode()).hexdigest()
    name = f"k{digest[:24]}"
    if name in _addresses:
        return _addresses[name]
    path = cache_dir() / f"{name}.o"
    try:
        code = path.read_bytes()
    except OSError:
        graph, outputs = build()
        code = _object(llvm_ir(graph, outputs, name, LANES))
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
