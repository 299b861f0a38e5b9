"""What ``directrix doctor`` looks at: this installation, and whether it still conserves."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version

__all__ = ["facts", "self_test"]

CORE = ("numpy", "scipy", "llvmlite", "h5py", "pydantic", "typer", "rich")
EXTRAS = {"matplotlib": "pictures"}


def facts() -> Iterator[tuple[str, str]]:
    """Pairs of a name and what was found, one a line of the report."""
    import llvmlite.binding as llvm

    from directrix import __version__
    from directrix.kernels.compile import LANES, cache_dir

    yield "directrix", __version__
    yield "python", f"{platform.python_version()} ({platform.python_implementation()}), {platform.platform()}"
    for name in CORE:
        yield name, _version(name) or "MISSING"
    for name, use in EXTRAS.items():
        yield name, _version(name) or f'not installed (no {use}); pip install "directrix[plot]"'
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield "processor", f"{llvm.get_host_cpu_name()}, {os.cpu_count()} cores, {usable} usable"
    yield "SIMD", f"{LANES} elements at a time ({64 * LANES} bits)"
    folder = cache_dir()
    kernels = list(folder.glob("k*.o")) if folder.is_dir() else []
    size = sum(f.stat().st_size for f in kernels) / 1024
    nearest = next(p for p in (folder, *folder.parents) if p.exists())
    writable = (
        "writable"
        if os.access(nearest, os.W_OK)
        else "NOT WRITABLE: every start compiles again; set DIRECTRIX_CACHE_DIR"
    )
    yield "compiled kernels", f"{len(kernels)} in {folder} ({size:.0f} kB), {writable}"


def self_test() -> tuple[bool, str]:
    """A short free flight that must keep energy and momenta; True and a sentence."""
    from directrix.curves import line
    from directrix.dynamics import simulate
    from directrix.model import Model
    from directrix.section import Section

    started = time.perf_counter()
    section = Section.circle(radius=0.02, E=5e6, nu=0.3, rho=1000.0)
    model = Model().rod(line((0, 0, 0), (1, 0, 0)), section, name="rod", ends=("A", "B"), elements=4)
    result = simulate(model.velocity("A", (0, 1, 2)).velocity("B", (0, -1, 1)), t_end=0.2, dt=0.01)
    passed = result.success and result.audit.passed
    seconds = time.perf_counter() - started
    word = "passed" if passed else "FAILED"
    return passed, f"{word} in {seconds:.1f} s: {result.status} audit {result.audit.verdict}"


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
