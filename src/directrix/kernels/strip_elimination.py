"""The tangents of a strip of elements and their elimination, node by node; see :mod:`directrix.kernels.rows`."""
# pyright: basic, reportCallIssue=false

from directrix.kernels.call import call_lanes
from directrix.kernels.compile import LANES
from directrix.kernels.jit import inner
from directrix.kernels.rows import NODE, ROW

__all__ = ["BATCH", "eliminate_strip", "pass_again"]

# places of the machine code of a strip
(
    TANGENT, RESIDUAL, AUDIT, PIVOT, HOLD, PASS_ON, PASS_ON_FAR, FORWARD, FORWARD_FAR, BACKWARD, BACKWARD_FAR, MEASURE,
    MOVE, BALANCE, FINISH, LESS, BALANCE_LAST, MIDDLE, MIDDLE_HOLD, MIDDLE_ON, INSIDE,
) = range(21)  # fmt: skip
BATCH = 4
"""Elements whose tangents are computed before they are eliminated: the code of neither is small, and both together do
not stay in the instruction cache."""
FADED = 1e-14  # a coupling so much less than the node's own stiffness is none; only convergence depends on it
BLOCK = 36 * LANES
# blocks of a row: −D⁻¹, L, G, P, Q
LOW, FIRST, UP, BACK = BLOCK, 2 * BLOCK, 3 * BLOCK, 4 * BLOCK
# parts of the carry
COLUMN, ROW_G, RHS, OWN, OWN_RHS = BLOCK, 2 * BLOCK, 108 * LANES, 120 * LANES, 156 * LANES
SIX, X, R = 6 * LANES, NODE * LANES, ROW * LANES


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
def _pivot(code, s, small, at, e, frozen):
    """The row of the first node of element ``e``, or of the last one of the strip, with ``small`` behind it."""
    node = e * s.stride * SIX
    if frozen:
        call_lanes(code[HOLD], small, at, s.carry, 0, s.load, node, s.row, e * R, s.still, node)
    elif s.held[e]:
        call_lanes(code[HOLD], small, at, s.carry, 0, s.load, node, s.row, e * R, s.free, node)
    else:
        call_lanes(code[PIVOT], small, at, s.carry, 0, s.load, node, s.row, e * R)


@inner
def _eliminate(code, s, e, small, small_at, frozen, far):
    """Eliminate the first node of element ``e``, an element of two nodes in ``small[small_at:]``; ``far`` when it feels
    nothing of the first node of the strip."""
    row, carry, none, at = s.row, s.carry, s.none, e * R
    _pivot(code, s, small, small_at, e, frozen)
    blocks = small_at + 2 * SIX
    call_lanes(code[LESS], row, at, small, blocks + 2 * BLOCK, none, 0, row, at + UP)
    call_lanes(code[LESS], row, at + LOW, row, at + UP, small, blocks + 3 * BLOCK, carry, 0)
    s.far[e] = far
    if far:
        call_lanes(code[PASS_ON_FAR], row, at, small, small_at, carry, 0)
    else:
        call_lanes(code[LESS], row, at, carry, COLUMN, none, 0, row, at + BACK)
        call_lanes(code[LESS], row, at + LOW, row, at + BACK, none, 0, carry, COLUMN)
        call_lanes(code[LESS], row, at + FIRST, row, at + BACK, carry, OWN, carry, OWN)
        if e < s.elements - 1:
            call_lanes(code[LESS], row, at + FIRST, row, at + UP, none, 0, row, at + R + FIRST)
        else:
            call_lanes(code[LESS], row, at + FIRST, row, at + UP, none, 0, carry, ROW_G)
        call_lanes(code[PASS_ON], row, at, small, small_at, carry, 0)


@inner
def _feels_nothing(s, e):
    """Whether the couplings F and G of the node behind element ``e`` with the first one have faded out; they are then
    zero from there on. Left alone they would underflow, and arithmetic with such numbers is slow."""
    carry, g = s.carry, (e + 1) * R + FIRST
    own = coupled = 0.0
    for k in range(BLOCK):
        own = max(own, abs(carry[k]))
        coupled = max(coupled, max(abs(carry[COLUMN + k]), abs(s.row[g + k])))
    if not coupled < FADED * own:
        return False
    for k in range(BLOCK):
        carry[COLUMN + k] = 0.0
        carry[ROW_G + k] = 0.0
    return True


@inner
def eliminate_strip(code, s, g, frozen):
    """Assemble and eliminate: rows of the inner nodes, and in ``s.carry`` what couples the ends of the parts; of whole
    chains rows of all nodes."""
    size = s.results * LANES
    far = s.whole > 0
    for k in range(s.carry.shape[0] if far else 0):
        s.carry[k] = 0.0
    for first in range(0, s.elements, BATCH):
        last = min(first + BATCH, s.elements)
        for e in range(first, last):
            call_lanes(
                code[TANGENT], s.x, e * s.stride * X, s.p, e * s.parameters * LANES, g, 0, s.out, (e - first) * size
            )
        for e in range(first, last):
            small, at = s.out, (e - first) * size
            if s.stride == 2:
                _middle(code, s, e, at, frozen)
                small, at = s.small, 0
            if e == 0 and s.whole == 0:
                _start(s, small, at)
            else:
                _eliminate(code, s, e, small, at, frozen, far)
        if not far and last < s.elements:
            far = _feels_nothing(s, last - 1)
    if s.whole > 0:
        _pivot(code, s, s.none, 0, s.elements, frozen)


@inner
def pass_again(code, s):
    """``s.res`` through the rows that are there."""
    last = s.elements * s.stride * SIX
    for e in range(s.elements if s.stride == 2 else 0):
        call_lanes(code[INSIDE], s.within, e * R, s.res, 2 * e * SIX)
    for k in range(SIX):
        s.carry[RHS + k] = 0.0
        s.carry[OWN_RHS + k] = s.res[k]
    for e in range(0 if s.whole else 1, s.elements + s.whole):
        call_lanes(code[FORWARD_FAR if s.far[e] else FORWARD], s.row, e * R, s.res, e * s.stride * SIX, s.carry, 0)
    for k in range(0 if s.whole else SIX):
        s.carry[RHS + k] += s.res[last + k]
