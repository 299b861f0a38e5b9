"""What a strip of elements does row by row, written over scalars and recorded for vector code (``lanes``).

A strip is LANES chains of elements side by side. Its inner nodes are eliminated one after the other, each by a 6×6
inverse: with D the node's own block after its predecessors, U and L its couplings with the next node, F and G with the
first node of the strip (columns and rows),

    P = D⁻¹ U,  Q = D⁻¹ F,  y = D⁻¹ b;   D' = K_BB − L P,  F' = −L Q,  G' = −G P,  K_00 −= G Q.

What is left couples the two ends of every chain. No pivot is sought: a step that comes out badly is taken again by the
general solver, which does.
"""

from __future__ import annotations

from collections.abc import Sequence

from directrix.formulations.element import COMMON, Element, step_of
from directrix.formulations.layout import PER_NODE, Layout, Scalar
from directrix.kernels.lanes import Code, Store
from directrix.kernels.trace import Graph, Sym, cross, dot

__all__ = [
    "CARRY", "NODE", "ROW", "audit", "backward", "block", "finish", "forward", "inside", "measure", "move", "pass_on",
    "pivot", "product", "residual", "step",
]  # fmt: skip

NODE = 36  # values of a node: (r1, R1), (Δr, R0), rates
ROW = 186  # −D⁻¹, L, G, P, Q by rows, y
CARRY = 162  # D, F, G by rows, b, K_00, b_0

Matrix = list[list[Scalar]]


def _matrix(values: Sequence[Scalar], columns: int = 6) -> Matrix:
    return [list(values[k : k + columns]) for k in range(0, len(values), columns)]


def _flat(m: Matrix) -> list[Scalar]:
    return [v for row in m for v in row]


def times(a: Matrix, b: Matrix, start: Matrix | None = None, sign: int = 1) -> Matrix:
    """start ± A B, computed in tiles of 3×3 whose sums stay in registers."""
    rows, inner, columns = len(a), len(b), len(b[0])
    out: Matrix = [[0.0] * columns for _ in range(rows)]
    for i0 in range(0, rows, 3):
        for j0 in range(0, columns, 3):
            for k in range(inner):
                for i in range(i0, min(i0 + 3, rows)):
                    for j in range(j0, min(j0 + 3, columns)):
                        product = a[i][k] * b[k][j]
                        old = out[i][j] if k or start is None else start[i][j]
                        out[i][j] = old + product if sign > 0 else old - product
    return out


def _inverse3(m: Matrix) -> Matrix:
    """By cofactors, one division."""
    columns = [cross(m[(i + 1) % 3], m[(i + 2) % 3]) for i in range(3)]
    over = 1.0 / dot(m[0], columns[0])
    return [[over * columns[j][i] for j in range(3)] for i in range(3)]


def inverse(m: Matrix) -> Matrix:
    """Inverse of a 6×6 by the Schur complement of its first 3×3."""
    a, b, c, d = ([row[j : j + 3] for row in m[i : i + 3]] for i in (0, 3) for j in (0, 3))
    ai = _inverse3(a)
    cai, aib = times(c, ai), times(ai, b)
    si = _inverse3(times(c, aib, d, -1))
    low, right = times(si, cai), times(aib, si)
    top = times(right, cai, ai)
    return [[*p, *(-v for v in q)] for p, q in zip(top, right, strict=True)] + [
        [*(-v for v in p), *q] for p, q in zip(low, si, strict=True)
    ]


def _column(values: Sequence[Scalar]) -> Matrix:
    return [[v] for v in values]


def _held(
    free: Sequence[Scalar], d: Matrix, f: Matrix, u: Matrix, b: Sequence[Scalar]
) -> tuple[Matrix, Matrix, Matrix, list[Scalar]]:
    """A row of blocks whose components are held where ``free`` is 0: the increment there is 0."""
    own = [[free[i] * v + (1.0 - free[i] if i == j else 0.0) for j, v in enumerate(row)] for i, row in enumerate(d)]
    f, u = ([[m * v for v in row] for m, row in zip(free, block, strict=True)] for block in (f, u))
    return own, f, u, [m * v for m, v in zip(free, b, strict=True)]


def product() -> Code:
    """c = start − a b of 6×6 matrices; ``start`` may be ``c``. One small function for all products: what is straight
    line in one piece does not stay in the instruction cache."""
    graph = Graph()
    a, b, start = (_matrix(graph.inputs(name, 36)) for name in ("a", "b", "start"))
    stores: list[Store] = []
    for i0 in range(0, 6, 3):
        for j0 in range(0, 6, 3):
            columns, part = [row[j0 : j0 + 3] for row in b], [row[j0 : j0 + 3] for row in start[i0 : i0 + 3]]
            tile = times(a[i0 : i0 + 3], columns, part, -1)
            stores += [Store("c", 6 * (i0 + i) + j0 + j, tile[i][j]) for i in range(3) for j in range(3)]
    return Code(graph, ("a", "b", "start", "c"), stores, tile=9, may_be_one=("start", "c"))


def pivot(masked: bool, inner: bool) -> Code:
    """−D⁻¹, L, y of a row. For an inner node D and b go on from ``carry`` and ``out`` is the element behind it; for the
    middle node of an element of three they are from ``out`` alone, and G is as well.

    ``masked``: ``free`` (6) is 0 where the node is held. U and F, which the caller multiplies, are then masked in
    place: in ``out`` and ``carry``, or both in ``out``; so are the columns of D⁻¹, for right-hand sides to come.
    """
    graph = Graph()
    out = graph.inputs("out", 156 if inner else 342)
    k = _blocks(out, 2 if inner else 3)
    load = graph.inputs("load", 6)
    if inner:
        carry = graph.inputs("carry", 114)
        d = [[p + q for p, q in zip(*rows, strict=True)] for rows in zip(_matrix(carry[:36]), k[0, 0], strict=True)]
        b = [carry[108 + i] + (load[i] - out[i]) for i in range(6)]
        f, u, low = _matrix(carry[36:72]), k[0, 1], k[1, 0]
    else:
        d, f, u, low = k[1, 1], k[1, 0], k[1, 2], k[2, 1]
        b = [p - q for p, q in zip(load, out[6:12], strict=True)]
    stores: list[Store] = []
    free = graph.inputs("free", 6) if masked else []
    if masked:
        d, f, u, b = _held(free, d, f, u, b)
        to_u, to_f = ("out", block(2, 0, 1) if inner else block(3, 1, 2)), ("out", block(3, 1, 0))
        for (array, at), matrix in ((to_u, u), (("carry", 36) if inner else to_f, f)):
            stores += [Store(array, at + i, v) for i, v in enumerate(_flat(matrix))]
    di = inverse(d)
    known = [[v * m for v, m in zip(row, free, strict=True)] for row in di] if masked else di
    row = [*(-v for v in _flat(known)), *_flat(low), *([] if inner else _flat(k[0, 1]))]
    stores += [Store("row", i, v) for i, v in enumerate(row)]
    stores += [Store("row", 180 + i, v) for i, v in enumerate(_flat(times(di, _column(b))))]
    arrays = ("out", *(("carry",) if inner else ()), "load", "row", *(("free",) if masked else ()))
    return Code(graph, arrays, stores, recorded=True)


def pass_on(inner: bool, far: bool = False) -> Code:
    """What y of a ``row`` leaves on the next node and on the first: into ``carry``, or into the forces ``small``.

    Here and below ``far`` is for rows that feel nothing of the first node: G and Q are not read."""
    graph = Graph()
    row, out = graph.inputs("row", ROW), graph.inputs("out", 12 if inner else 18)
    low, g, y = _matrix(row[36:72]), _matrix(row[72:108]), _column(row[180:186])
    if inner:
        after = _flat(times(low, y, _column([-v for v in out[6:12]]), -1))
        stores = [Store("carry", 108 + i, v) for i, v in enumerate(after)]
        if not far:
            first = graph.inputs("carry", CARRY)[156:162]
            stores += [Store("carry", 156 + i, v) for i, v in enumerate(_flat(times(g, y, _column(first), -1)))]
        return Code(graph, ("row", "out", "carry"), stores, recorded=True)
    ends = [*_flat(times(g, y, _column(out[:6]))), *_flat(times(low, y, _column(out[12:])))]
    return Code(graph, ("row", "out", "small"), [Store("small", i, v) for i, v in enumerate(ends)], recorded=True)


def block(nn: int, a: int, b: int) -> int:
    """Where ∂(force on a)/∂(increment of b) begins in the results of an element of ``nn`` nodes."""
    return 6 * nn + 36 * (nn * b + a)


def _blocks(out: Sequence[Scalar], nn: int) -> dict[tuple[int, int], Matrix]:
    """The blocks of the tangent by (a, b)."""
    places = {(a, b): block(nn, a, b) for a in range(nn) for b in range(nn)}
    return {key: _matrix(out[first : first + 36]) for key, first in places.items()}


def inside() -> Code:
    """A new right-hand side ``res`` (18) of an element of three nodes through the row of its middle node."""
    graph = Graph()
    row, res = graph.inputs("row", ROW), graph.inputs("res", 18)
    minus_di, l, g = (_matrix(row[36 * k : 36 * k + 36]) for k in range(3))
    y = times(minus_di, _column(res[6:12]), sign=-1)
    ends = [*_flat(times(g, y, _column(res[:6]), -1)), *_flat(times(l, y, _column(res[12:]), -1))]
    stores = [Store("row", 180 + k, v) for k, v in enumerate(_flat(y))]
    stores += [Store("res", k, v) for k, v in zip([*range(6), *range(12, 18)], ends, strict=True)]
    return Code(graph, ("row", "res"), stores, recorded=True)


def forward(far: bool) -> Code:
    """A new right-hand side ``res`` (6) through a row that is eliminated already."""
    graph = Graph()
    row, res, carry = graph.inputs("row", ROW), graph.inputs("res", 6), graph.inputs("carry", CARRY)
    minus_di, l, g = (_matrix(row[36 * k : 36 * k + 36]) for k in range(3))
    y = times(minus_di, _column([r + c for r, c in zip(res, carry[108:114], strict=True)]), sign=-1)
    stores = [Store("row", 180 + k, v) for k, v in enumerate(_flat(y))]
    stores += [Store("carry", 108 + k, -v) for k, v in enumerate(_flat(times(l, y)))]
    if not far:
        on_first = _flat(times(g, y, _column(carry[156:162]), -1))
        stores += [Store("carry", 156 + k, v) for k, v in enumerate(on_first)]
    return Code(graph, ("row", "res", "carry"), stores, recorded=True)


def backward(far: bool) -> Code:
    """The increment ``du`` of a node from those of the ``next`` and, if not ``far``, the ``first``; ``size``: largest
    squares so far of displacement and turn, and the sum of all, which shows what is not finite."""
    graph = Graph()
    row, after, first = graph.inputs("row", ROW), graph.inputs("next", 6), graph.inputs("first", 6)
    size = graph.inputs("size", 3)
    p, q = (_matrix(row[108 + 36 * k : 144 + 36 * k]) for k in range(2))
    own = times(p, _column(after), _column(row[180:186]), -1)
    du = _flat(own if far else times(q, _column(first), own, -1))
    return Code(graph, ("row", "next", "first", "du", "size"), _sized(du, size), recorded=True)


def _sized(du: Sequence[Sym], size: Sequence[Sym]) -> list[Store]:
    moved, turned = dot(du[:3], du[:3]), dot(du[3:], du[3:])
    sizes = (size[0].larger(moved), size[1].larger(turned), size[2] + (moved + turned))
    return [*(Store("du", k, v) for k, v in enumerate(du)), *(Store("size", k, v) for k, v in enumerate(sizes))]


def measure() -> Code:
    """``size`` of an increment that is known already, see :func:`backward`."""
    graph = Graph()
    stores = _sized(graph.inputs("du", 6), graph.inputs("size", 3))
    return Code(graph, ("du", "size"), [s for s in stores if s.array == "size"], recorded=True)


def move(each: bool) -> Code:
    """r1 += c u, Δr += c u, R1 ← cay(c θ) R1, c one number, or one for ``each`` lane. To second order the Cayley
    transform is the exponential: Newton's iteration converges as fast, and to the same."""
    graph = Graph()
    x, du, (c,) = graph.inputs("x", NODE), graph.inputs("du", 6), graph.inputs("c", 1)
    step = [c * v for v in du]
    u, t = step[:3], step[3:]
    factor = 1.0 / (1.0 + 0.25 * dot(t, t))
    stores = [Store("x", k, x[k] + u[k]) for k in range(3)]
    stores += [Store("x", 12 + k, x[12 + k] + u[k]) for k in range(3)]
    for a in range(3, 12, 3):
        d = x[a : a + 3]
        # cay(t) d = d + f t × (d + ½ t × d)
        turned = cross(t, [p + 0.5 * q for p, q in zip(d, cross(t, d), strict=True)])
        stores += [Store("x", a + k, d[k] + factor * turned[k]) for k in range(3)]
    return Code(graph, ("x", "du", "c"), stores, () if each else ("c",))


def residual(nn: int) -> Code:
    """``res`` = load − forces of the elements on both sides of the first node of an element of ``nn``, and on the nodes
    between; ``f`` goes along from element to element. The largest so far (``most``): force and moment of an element,
    force and moment out of balance; then a sum of all that shows what is not finite."""
    graph = Graph()
    count = 6 * (nn - 1)
    force, before, load = graph.inputs("out", 6 * nn), graph.inputs("f", 6), graph.inputs("load", count)
    free, most = graph.inputs("free", count), list(graph.inputs("most", 5))
    on = [b + f for b, f in zip(before, force[:6], strict=True)] + force[6:count]
    res = [p - f for p, f in zip(load, on, strict=True)]
    for k, f in enumerate(force):
        most[k % 6 // 3] = most[k % 6 // 3].larger(f.size())
    for k, (m, r) in enumerate(zip(free, res, strict=True)):
        most[2 + k % 6 // 3] = most[2 + k % 6 // 3].larger((m * r).size())
    most[4] = most[4] + sum(res[1:], res[0])
    stores = [Store("res", k, v) for k, v in enumerate(res)]
    stores += [Store("f", k, v) for k, v in enumerate(force[count:])]
    stores += [Store("most", k, v) for k, v in enumerate(most)]
    return Code(graph, ("out", "f", "load", "free", "res", "most"), stores)


def finish() -> Code:
    """Books of a node and x1 as the next x0, as ``step.finish`` does it for ẋ1 = (2/Δt)(x1 − x0) − ẋ0.

    ``sums``: work of the loads, Σ force (3), Σ moment about the origin (3) at x½, Σ |support force|²; ``own`` is 1 or
    0: nodes that are in two lanes count once.
    """
    graph = Graph()
    x, load, res, free = (graph.inputs(n, k) for n, k in (("x", NODE), ("load", 6), ("res", 6), ("free", 6)))
    (own,), g, sums = graph.inputs("own", 1), graph.inputs("g", 1), graph.inputs("sums", 8)
    new, old = [[x[b + a : b + a + 3] for a in (3, 6, 9)] for b in (0, 12)]
    turned = [cross(a, b) for a, b in zip(old, new, strict=True)]
    axial = [turned[0][k] + turned[1][k] + turned[2][k] for k in range(3)]
    trace = 1.0 + sum(dot(a, b) for a, b in zip(new, old, strict=True))
    work = dot(load[:3], x[12:15]) + 2.0 * dot(load[3:], axial) / trace
    held = [(1.0 - m) * r for m, r in zip(free, res, strict=True)]
    on = [f - r for f, r in zip(load, held, strict=True)]
    middle = [x[k] - 0.5 * x[12 + k] for k in range(3)]
    moment = [m + c for m, c in zip(on[3:], cross(middle, on[:3]), strict=True)]
    flows = [work, *on[:3], *moment, dot(held[:3], held[:3])]
    stores = [Store("sums", k, sums[k] + own * v) for k, v in enumerate(flows)]
    gram = {(i, j): dot(new[i], new[j]) for i in range(3) for j in range(i, 3)}
    fresh: list[list[Scalar]] = []
    for i in range(3):
        off = [gram[min(i, j), max(i, j)] - (1.0 if i == j else 0.0) for j in range(3)]
        fresh.append([new[i][k] - 0.5 * sum(off[j] * new[j][k] for j in range(3)) for k in range(3)])
    stores += [Store("x", 24 + k, g[0] * x[12 + k] - x[24 + k]) for k in range(3)]
    for i in range(3):
        for k in range(3):
            at = 3 * i + k
            stores.append(Store("x", 27 + at, g[0] * (fresh[i][k] - old[i][k]) - x[27 + at]))
            stores += [Store("x", 3 + at, fresh[i][k]), Store("x", 15 + at, fresh[i][k])]
    stores += [Store("x", 12 + k, graph.const(0.0)) for k in range(3)]
    return Code(graph, ("x", "load", "res", "free", "own", "g", "sums"), stores, ("g",))


def step(element: Element, layout: Layout, aligned: bool, tangent: bool) -> Code:
    """Forces of an element on nodes in lanes, and its tangent if asked for, as ``record_step`` has them."""
    graph, x, p, g = _element_inputs(layout, aligned)
    stores = [Store("out", k, v) for k, v in enumerate(step_of(graph, element, layout, x, p, g, tangent))]
    return Code(graph, ("x", "p", "g", "out"), stores, ("g",))


def audit(element: Element, layout: Layout, aligned: bool) -> Code:
    """The books of an element, added to ``sums`` (8); ``turn``: the least Σ d_i·d_i between its nodes so far, negative;
    ``loss``: the largest loss of orthonormality so far."""
    graph, x, p, _ = _element_inputs(layout, aligned)
    sums, (turn,), (loss,) = graph.inputs("sums", 8), graph.inputs("turn", 1), graph.inputs("loss", 1)
    out = element.audit(layout, x, p)
    for dots in out[8 : 7 + layout.nn]:
        turn = turn.larger(-dots)
    for gram in out[7 + layout.nn :: 7]:
        loss = loss.larger(gram)
    stores = [Store("sums", k, sums[k] + out[k]) for k in range(8)]
    return Code(graph, ("x", "p", "sums", "turn", "loss"), [*stores, Store("turn", 0, turn), Store("loss", 0, loss)])


def _element_inputs(layout: Layout, aligned: bool) -> tuple[Graph, list[Sym], list[Sym], list[Sym]]:
    """Inputs of an element whose nodes are NODE values apart; of ``aligned`` elements the directors of the nodes are
    those of the element, so that their reference directors are the identity."""
    graph = Graph()
    packed, zero = graph.inputs("x", NODE * layout.nn), graph.const(0.0)
    x: list[Sym] = []
    for a in range(layout.nn):
        x += [*packed[NODE * a : NODE * a + NODE], *[zero] * (PER_NODE - NODE)]
    frames = 9 * layout.nn
    if aligned:
        unit = [graph.const(1.0 if i % 9 // 3 == i % 3 else 0.0) for i in range(frames)]
        p = [*unit, *graph.inputs("p", layout.size - frames)]
    else:
        p = graph.inputs("p", layout.size)
    return graph, x, p, graph.inputs("g", COMMON)
