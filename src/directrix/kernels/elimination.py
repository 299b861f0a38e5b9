"""The inner step of the chain solver as machine code: one 6×6 block row eliminated, all rows in registers.

``void k(double *row, double *before, double *rhs, double *out)`` with ``row`` = left, own and right block (two
numbers behind them are read and not used); ``before`` (of the row above) and ``out`` hold six rows of
D⁻¹U (6), D⁻¹b (1), 0. The pivots are taken in order; ``out[48]`` is 1 when every pivot was within a factor of 100
of the largest entry below it, else 0:
the caller then eliminates with pivoting.
"""

from __future__ import annotations

from directrix.kernels.compile import text_address

__all__ = ["elimination_address"]

VEC = "<8 x double>"
THRESHOLD = 0.01


def _ir(name: str) -> str:
    lines = [
        f"declare double @llvm.fabs.f64(double)\ndefine void @{name}(ptr noalias %row, "
        "ptr noalias %before, ptr noalias %rhs, ptr noalias %out) {"
    ]
    count = 0

    def put(text: str) -> str:
        nonlocal count
        count += 1
        lines.append(f"%v{count} = {text}")
        return f"%v{count}"

    def load(array: str, offset: int, kind: str) -> str:
        return put(f"load {kind}, ptr {put(f'getelementptr double, ptr %{array}, i64 {offset}')}, align 8")

    def splat(scalar: str) -> str:
        one = put(f"insertelement {VEC} undef, double {scalar}, i32 0")
        return put(f"shufflevector {VEC} {one}, {VEC} undef, <8 x i32> zeroinitializer")

    def minus(a: str, b: str, c: str) -> str:
        return put(f"fsub contract {VEC} {a}, {put(f'fmul contract {VEC} {b}, {c}')}")

    six = ", ".join(f"i32 {k if k < 6 else 8 + k}" for k in range(8))
    before = [load("before", 8 * k, VEC) for k in range(6)]
    own: list[str] = []
    right: list[str] = []
    for r in range(6):
        d, u = load("row", 36 + 6 * r, VEC), load("row", 72 + 6 * r, VEC)
        tail = put(f"insertelement {VEC} zeroinitializer, double {load('rhs', r, 'double')}, i32 6")
        u = put(f"shufflevector {VEC} {u}, {VEC} {tail}, <8 x i32> <{six}>")
        acc = "zeroinitializer"
        for k in range(6):
            product = put(f"fmul contract {VEC} {splat(load('row', 6 * r + k, 'double'))}, {before[k]}")
            acc = product if acc == "zeroinitializer" else put(f"fadd contract {VEC} {acc}, {product}")
        own.append(put(f"fsub {VEC} {d}, {acc}"))
        last = put(
            f"shufflevector {VEC} zeroinitializer, {VEC} {acc}, "
            "<8 x i32> <i32 0, i32 1, i32 2, i32 3, i32 4, i32 5, i32 14, i32 7>"
        )
        right.append(put(f"fsub {VEC} {u}, {last}"))
    good = "true"
    for k in range(6):
        pivot = put(f"extractelement {VEC} {own[k]}, i32 {k}")
        size = put(f"call double @llvm.fabs.f64(double {pivot})")
        inverse = splat(put(f"fdiv double 1.0, {pivot}"))
        factors: dict[int, str] = {}
        for i in range(6):
            if i == k:
                continue
            f = put(f"extractelement {VEC} {own[i]}, i32 {k}")
            factors[i] = splat(f)
            if i > k:
                low = put(f"fmul double {THRESHOLD}, {put(f'call double @llvm.fabs.f64(double {f})')}")
                good = put(f"and i1 {good}, {put(f'fcmp ogt double {size}, {low}')}")
        if k == 5:
            good = put(f"and i1 {good}, {put(f'fcmp ogt double {size}, 0.0')}")
        own[k], right[k] = put(f"fmul {VEC} {own[k]}, {inverse}"), put(f"fmul {VEC} {right[k]}, {inverse}")
        for i, f in factors.items():
            if k < 5:
                own[i] = minus(own[i], f, own[k])
            right[i] = minus(right[i], f, right[k])
    for r in range(6):
        lines.append(f"store {VEC} {right[r]}, ptr {put(f'getelementptr double, ptr %out, i64 {8 * r}')}, align 8")
    verdict, where = put(f"uitofp i1 {good} to double"), put("getelementptr double, ptr %out, i64 48")
    lines.append(f"store double {verdict}, ptr {where}, align 8")
    return "\n".join([*lines, "ret void", "}"])


def elimination_address() -> int:
    """Address of the compiled elimination."""
    return text_address("elimination", _ir)
