"""What a strip does in a step, be its lanes parts of one chain (:mod:`strips`) or chains (:mod:`bundle`)."""
# pyright: basic, reportCallIssue=false

from directrix.kernels.call import call_lanes
from directrix.kernels.compile import LANES
from directrix.kernels.jit import compiled, inner
from directrix.kernels.judged import finest_of
from directrix.kernels.rows import NODE
from directrix.kernels.strip_elimination import (
    AUDIT,
    BACKWARD,
    BACKWARD_FAR,
    BALANCE,
    BALANCE_LAST,
    FINISH,
    MOVE,
    RESIDUAL,
    SIX,
    R,
    X,
)

__all__ = [
    "LARGE_TURN", "MOVES", "RESULTS", "SHOWN", "TANGENTS", "balance", "close", "finest", "load", "move",
    "pack", "rows_back", "shoot", "unpack", "zero",
]  # fmt: skip

LARGE_TURN = 0.2  # rad: after a larger rotation the positions are solved for again
# places of the results of a step
ITERATIONS, WORK, FORCE, MOMENT, BOOKS, LOSS, HELD, TANGENTS, MOVES = 0, 1, 2, 5, 8, 16, 17, 18, 19
SHOWN = 12  # iterations of a step whose moves are among its results
RESULTS = MOVES + 2 * SHOWN


@inner
def zero(values):
    """All of a flat array; here and elsewhere loops in place of slices that are assigned, which are slow to compile."""
    for k in range(values.shape[0]):
        values[k] = 0.0


@inner
def rows_back(code, s):
    """Increments of all nodes from that of the last, and of the first where it has no row."""
    step = s.stride * SIX
    for e in range(s.elements - 1, -1 if s.whole else 0, -1):
        back = BACKWARD_FAR if s.far[e] else BACKWARD
        call_lanes(code[back], s.row, e * R, s.du, (e + 1) * step, s.du, 0, s.du, e * step, s.size, 0)
    for e in range(s.elements if s.stride == 2 else 0):
        at = e * step
        call_lanes(code[BACKWARD], s.within, e * R, s.du, at + step, s.du, at, s.du, at + SIX, s.size, 0)  # fmt: skip


@inner
def move(code, s, scale):
    for node in range(s.elements * s.stride + 1):
        call_lanes(code[MOVE], s.x, node * X, s.du, node * SIX, scale, 0)


@inner
def balance(code, s, g):
    """``s.res`` of the inner nodes, and in ``s.ends`` the forces of the parts on their ends; of whole chains ``s.res``
    of all nodes. What is largest goes to ``s.most``."""
    zero(s.most)
    for k in range(SIX):
        s.f[k] = 0.0
    for e in range(s.elements):
        at = e * s.stride
        call_lanes(code[RESIDUAL], s.x, at * X, s.p, e * s.parameters * LANES, g, 0, s.out, 0)
        if e == 0 and s.whole == 0:
            for k in range(SIX):
                s.ends[k] = s.out[k]
            call_lanes(code[BALANCE], s.out, 0, s.f, 0, s.first_load, 0, s.first_free, 0, s.res, 0, s.most, 0)
        else:
            to = at * SIX
            call_lanes(code[BALANCE], s.out, 0, s.f, 0, s.load, to, s.free, to, s.res, to, s.most, 0)
    if s.whole:
        to = s.elements * s.stride * SIX
        call_lanes(code[BALANCE_LAST], s.none, 0, s.f, 0, s.load, to, s.free, to, s.res, to, s.most, 0)
    for k in range(SIX):
        s.ends[SIX + k] = s.f[k]


@inner
def finest(s):
    """Size of an increment that is round-off."""
    return finest_of(s.elements * s.stride)


@inner
def load(s, values):
    """The loads of a step on a strip, from those of all strips."""
    for k in range(s.load.shape[0]):
        s.load[k] = values[s.loaded + k]
    for k in range(SIX, s.first_load.shape[0]):
        s.first_load[k] = s.load[k]


@inner
def close(code, s, g):
    """Books of the step, and x1 becomes x0."""
    zero(s.sums)
    zero(s.loss)
    for node in range(s.elements * s.stride + 1):
        call_lanes(
            code[FINISH], s.x, node * X, s.load, node * SIX, s.res, node * SIX, s.free, node * SIX, s.own, node * LANES,
            g, 0, s.sums, 0,
        )  # fmt: skip
    zero(s.books)
    for e in range(s.elements):
        call_lanes(
            code[AUDIT], s.x, e * s.stride * X, s.p, e * s.parameters * LANES, s.books, 0, s.turn, e * LANES, s.loss, 0
        )


@compiled
def pack(lanes, nodes, frames, x):
    """State rows of ``nodes`` (many, LANES) into lanes; the columns of rotations become those of R times the frame."""
    for i in range(nodes.shape[0]):
        for lane in range(LANES):
            node = nodes[i, lane]
            for part in range(0, 36, 12):
                for k in range(3):
                    lanes[(NODE * i + part + k) * LANES + lane] = x[node, part + k]
                    for column in range(3):
                        s = 0.0
                        for c in range(3):
                            s += x[node, part + 3 + 3 * c + k] * frames[node, c, column]
                        lanes[(NODE * i + part + 3 + 3 * column + k) * LANES + lane] = s


@compiled
def unpack(lanes, nodes, frames, x):
    """The way back from :func:`pack`, for the lanes that ``nodes`` has."""
    for i in range(nodes.shape[0]):
        for lane in range(nodes.shape[1]):
            node = nodes[i, lane]
            for part in range(0, 36, 12):
                for k in range(3):
                    x[node, part + k] = lanes[(NODE * i + part + k) * LANES + lane]
                    for column in range(3):
                        s = 0.0
                        for c in range(3):
                            s += lanes[(NODE * i + part + 3 + 3 * c + k) * LANES + lane] * frames[node, column, c]
                        x[node, part + 3 + 3 * column + k] = s


@inner
def _react(s, fixed, out):
    """Forces of the supports on the nodes of a strip in the step that was closed last."""
    for i in range(s.nodes.shape[0]):
        for lane in range(s.lanes):
            node = s.nodes[i, lane]
            for c in range(6):
                out[node, c] = -s.res[(6 * i + c) * LANES + lane] if fixed[node, c] else 0.0


@inner
def shoot(s, shots, k):
    """The state of a strip and its reactions, as the ``k``-th of ``shots``."""
    unpack(s.x, s.nodes, shots.frames, shots.x[k])
    _react(s, shots.fixed, shots.reaction[k])
