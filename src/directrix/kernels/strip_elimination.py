"""The tangents of a strip of elements and their elimination, node by node; see :mod:`directrix.kernels.rows`."""
# pyright: basic, reportCallIssue=false

from directrix.kernels.call import call_lanes
from directrix.kernels.compile import LANES
from directrix.kernels.jit import inner
from directrix.kernels.rows import NODE, ROW

__all__ = ["BATCH", "eliminate_strip", "pass_again"]

# places of the machine code of a strip
(
    TANGENT, RESIDUAL, AUDIT, PIVOT, HOLD, PASS_ON, FORWARD, BACKWARD, MEASURE, MOVE, BALANCE, FINISH, ADD, LESS,
    MIDDLE, MIDDLE_HOLD, MIDDLE_ON, INSIDE,
) = range(18)  # fmt: skip
BATCH = 4
"""Elements whose tangents are computed before they are eliminated: the code of neither is small, and both together do
not stay in the instruction cache."""
BLOCK = 36 * LANES
# blocks of a row: −D⁻¹, L, G, P, Q
LOW, FIRST, UP, BACK = BLOCK, 2 * BLOCK, 3 * BLOCK, 4 * BLOCK
# parts of the carry
COLUMN, ROW_G, RHS, OWN, OWN_RHS = BLOCK, 2 * BLOCK, 108 * LANES, 120 * LANES, 156 * LANES
SIX, X, R = 6 * LANES, NODE * LANES, ROW * LANES


@inner
def _element(code, s, e, at, g):
    """Forces and tangent of element ``e`` of all lanes into ``s.out[at:]``."""
    out, nn = s.out, s.stride + 1
    call_lanes(code[TANGENT], s.x, e * s.stride * X, s.p, e * s.parameters * LANES, g, 0, out, at)
    blocks = at + nn * SIX
    for point in range(s.points):
        left = blocks + (nn * nn + 2 * nn * point) * BLOCK
        for b in range(nn):
            for a in range(nn):
                to = blocks + (nn * b + a) * BLOCK
                call_lanes(code[ADD], out, left + a * BLOCK, out, left + (nn + b) * BLOCK, out, to, out, to)


@inner
def _middle(code, s, e, out_at, frozen):
    """Eliminate the middle node of an element of three: what is left in ``s.small`` is an element of two."""
    out, row, small, at, middle = s.out, s.within, s.small, e * R, (2 * e + 1) * SIX
    if frozen:
        call_lanes(code[MIDDLE_HOLD], out, out_at, s.load, middle, row, at, s.still, middle)
    else:
        call_lanes(code[MIDDLE], out, out_at, s.load, middle, row, at)
    blocks = out_at + 3 * SIX
    # what the middle feels of the ends
    call_lanes(code[LESS], row, at, out, blocks + 7 * BLOCK, s.none, 0, row, at + UP)
    call_lanes(code[LESS], row, at, out, blocks + BLOCK, s.none, 0, row, at + BACK)
    for b in range(2):
        for a in range(2):
            left, right, to = LOW if a else FIRST, UP if b else BACK, 2 * SIX + (2 * b + a) * BLOCK
            start = blocks + (6 * b + 2 * a) * BLOCK
            call_lanes(code[LESS], row, at + left, row, at + right, out, start, small, to)
    call_lanes(code[MIDDLE_ON], row, at, out, out_at, small, 0)


@inner
def _start(s, small, at):
    """The first row of a strip is solved for last: what it has to do with the second, into ``s.carry``."""
    carry = s.carry
    aa = at + 2 * SIX
    # D, F, G of the next node are BB, BA, AB; b the force on it
    for k in range(BLOCK):
        carry[k] = small[aa + 3 * BLOCK + k]
        carry[COLUMN + k] = small[aa + BLOCK + k]
        carry[ROW_G + k] = small[aa + 2 * BLOCK + k]
        s.row[R + FIRST + k] = small[aa + 2 * BLOCK + k]
        carry[OWN + k] = small[aa + k]
    for k in range(SIX):
        carry[RHS + k] = -small[at + SIX + k]
        carry[OWN_RHS + k] = -small[at + k]


@inner
def _eliminate(code, s, e, small, small_at, frozen):
    """Eliminate the first node of element ``e``, an element of two nodes in ``small[small_at:]``."""
    row, carry, none, at, node = s.row, s.carry, s.none, e * R, e * s.stride * SIX
    if frozen:
        call_lanes(code[HOLD], small, small_at, carry, 0, s.load, node, row, at, s.still, node)
    elif s.held[e]:
        call_lanes(code[HOLD], small, small_at, carry, 0, s.load, node, row, at, s.free, node)
    else:
        call_lanes(code[PIVOT], small, small_at, carry, 0, s.load, node, row, at)
    blocks = small_at + 2 * SIX
    call_lanes(code[LESS], row, at, small, blocks + 2 * BLOCK, none, 0, row, at + UP)
    call_lanes(code[LESS], row, at, carry, COLUMN, none, 0, row, at + BACK)
    call_lanes(code[LESS], row, at + LOW, row, at + UP, small, blocks + 3 * BLOCK, carry, 0)
    call_lanes(code[LESS], row, at + LOW, row, at + BACK, none, 0, carry, COLUMN)
    call_lanes(code[LESS], row, at + FIRST, row, at + BACK, carry, OWN, carry, OWN)
    if e < s.elements - 1:
        call_lanes(code[LESS], row, at + FIRST, row, at + UP, none, 0, row, at + R + FIRST)
    else:
        call_lanes(code[LESS], row, at + FIRST, row, at + UP, none, 0, carry, ROW_G)
    call_lanes(code[PASS_ON], row, at, small, small_at, carry, 0)


@inner
def eliminate_strip(code, s, g, frozen):
    """Assemble and eliminate: rows of the inner nodes, and in ``s.carry`` what couples the ends of the parts."""
    size = s.results * LANES
    for first in range(0, s.elements, BATCH):
        last = min(first + BATCH, s.elements)
        for e in range(first, last):
            _element(code, s, e, (e - first) * size, g)
        for e in range(first, last):
            small, at = s.out, (e - first) * size
            if s.stride == 2:
                _middle(code, s, e, at, frozen)
                small, at = s.small, 0
            if e == 0:
                _start(s, small, at)
            else:
                _eliminate(code, s, e, small, at, frozen)


@inner
def pass_again(code, s):
    """``s.res`` through the rows that are there."""
    last = s.elements * s.stride * SIX
    for e in range(s.elements if s.stride == 2 else 0):
        call_lanes(code[INSIDE], s.within, e * R, s.res, 2 * e * SIX)
    for k in range(SIX):
        s.carry[108 * LANES + k] = 0.0
        s.carry[156 * LANES + k] = s.res[k]
    for e in range(1, s.elements):
        call_lanes(code[FORWARD], s.row, e * R, s.res, e * s.stride * SIX, s.carry, 0)
    for k in range(SIX):
        s.carry[108 * LANES + k] += s.res[last + k]
