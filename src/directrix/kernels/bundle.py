"""Steps of LANES chains of one kind side by side, each whole in a lane of its own; several steps a call.

No lane learns of another: what one computes does not depend on who is beside it. Each goes through Newton's iteration
as if it were alone, and asks for rounds: one with a new tangent, one that solves for positions alone, or a right-hand
side through the factors that are there, with which a step begins too. A round is for all lanes, and who did not ask for
it stays as it was. Who is ready to go on with its own factors stays where they were made until nobody asks for new
ones: made again there, they are the same to the last bit. From then on there are no new ones before the next step.
"""
# pyright: basic, reportCallIssue=false

from math import sqrt

from directrix.kernels.call import call_lanes
from directrix.kernels.compile import LANES
from directrix.kernels.jit import compiled, inner
from directrix.kernels.judged import judged
from directrix.kernels.strip_elimination import BACKWARD_FAR, SIX, R, eliminate_strip, pass_again
from directrix.kernels.strip_steps import (
    BOOKS,
    HELD,
    ITERATIONS,
    LARGE_TURN,
    LOSS,
    MOVES,
    SHOWN,
    TANGENTS,
    WORK,
    balance,
    close,
    finest,
    load,
    move,
    rows_back,
    shoot,
    zero,
)

__all__ = ["FAILED", "run"]

# what a lane asks for; the first that anybody asks for is what comes next
REUSE, FROZEN, TANGENT, READY, DONE, FAILED = range(6)


@inner
def _next(lanes):
    kind = FAILED
    for lane in range(LANES):
        kind = min(kind, lanes.mode[lane])
    return kind


@inner
def _increments(code, s, g, kind):
    """``s.du`` and its sizes, in all lanes."""
    if kind == REUSE:
        pass_again(code, s)
    else:
        eliminate_strip(code, s, g, kind == FROZEN)
    zero(s.size)
    none, last = s.none, s.elements * s.stride * SIX
    call_lanes(code[BACKWARD_FAR], s.row, s.elements * R, none, 0, none, 0, s.du, last, s.size, 0)
    rows_back(code, s)


@inner
def _weigh(s, w, lanes, lane, kind, gone, result):
    """What the increment of a lane means for it."""
    options = lanes.options[lane]
    moved, turned = sqrt(s.size[lane]), sqrt(s.size[LANES + lane])
    lanes.iteration[lane] += 1
    n = lanes.iteration[lane]
    result[TANGENTS] += 0 if kind == REUSE else 1
    if n <= SHOWN:
        result[MOVES + 2 * n - 2], result[MOVES + 2 * n - 1] = moved, turned
    if not s.size[2 * LANES + lane] < 1e300 or (gone and turned > LARGE_TURN):
        lanes.mode[lane] = FAILED
        return
    w.scale[lane] = 1.0 if turned <= options[4] else options[4] / turned
    lanes.mode[lane] = TANGENT
    if n == 1:
        lanes.kept[lane] = turned <= LARGE_TURN
    if kind == FROZEN or turned > LARGE_TURN:
        lanes.before[lane] = 0.0
        if kind != FROZEN and options[6] > 0.0:
            lanes.mode[lane] = FROZEN
    else:
        size, small, settled, again = judged(moved, turned, options[3], lanes.before[lane], kind == REUSE, finest(s))
        lanes.before[lane] = size
        lanes.good[lane] = small and settled
        if gone or (kind != REUSE and (again or small)):
            lanes.mode[lane] = READY
    if lanes.mode[lane] != READY and n >= int(options[5]):
        lanes.mode[lane] = FAILED


@inner
def _off(s, w, options, lane):
    """Largest unbalanced force or moment of a lane over what is allowed, 1e300 if not finite."""
    if not abs(s.most[4 * LANES + lane]) < 1e300:
        return 1e300
    force, moment = max(w.largest[lane], s.most[lane]), max(w.largest[LANES + lane], s.most[LANES + lane])
    return max(
        s.most[2 * LANES + lane] / max(options[0] * force, options[1]),
        s.most[3 * LANES + lane] / max(options[0] * moment, options[2]),
    )


@inner
def _settle(s, w, lanes, lane):
    """What a lane asks for that was ready, has moved and knows its residual."""
    off = _off(s, w, lanes.options[lane], lane)
    if lanes.good[lane] and off <= 1.0:
        lanes.mode[lane] = DONE
    elif not off < 1e300 or lanes.iteration[lane] >= int(lanes.options[lane, 5]):
        lanes.mode[lane] = FAILED
    else:
        lanes.mode[lane] = REUSE


@inner
def _iterate(code, s, g, w, lanes, results, k):
    """Newton's iteration, until every lane is DONE or FAILED."""
    for lane in range(LANES):
        lanes.iteration[lane] = 0
        lanes.before[lane] = 0.0
        if lanes.mode[lane] != FAILED:
            lanes.mode[lane] = REUSE if lanes.kept[lane] else TANGENT
    kind = _next(lanes)
    if kind == REUSE:
        balance(code, s, g)
    gone = False  # to the last factors of the step
    while kind < DONE:
        _increments(code, s, g, kind)
        for lane in range(LANES):
            w.scale[lane] = 0.0
            if lanes.mode[lane] == kind and kind != READY:
                _weigh(s, w, lanes, lane, kind, gone, results[k, lane])
        # nothing is cut of the increments of those who are ready: they have turned by little
        go = gone = gone or (kind > FROZEN and _next(lanes) >= READY)
        for lane in range(LANES):
            if lanes.mode[lane] == READY:
                w.scale[lane] = 1.0 if go else 0.0
        move(code, s, w.scale)
        if go:
            balance(code, s, g)
            for lane in range(LANES):
                if lanes.mode[lane] == READY:
                    _settle(s, w, lanes, lane)
        kind = _next(lanes)


@inner
def _book(s, lanes, lane, result):
    result[ITERATIONS] = lanes.iteration[lane]
    for c in range(7):
        result[WORK + c] = s.sums[c * LANES + lane]
    result[HELD] = s.sums[7 * LANES + lane]
    for c in range(8):
        result[BOOKS + c] = s.books[c * LANES + lane]
    result[LOSS] = s.loss[lane]


@compiled
def run(code, s, g, w, lanes, results, loads, shots, before):
    """Take steps, one a row of ``results`` (steps, LANES, RESULTS), which are as in :func:`kernels.strips.run`; of a
    lane that does not converge the iterations are 0 in that step and after it. ``loads`` and ``shots`` as there.
    """
    kept = 0
    for k in range(results.shape[0]):
        if k < loads.strips.shape[0]:
            load(s, loads.strips[k])
            for i in range(w.largest.shape[0]):
                w.largest[i] = loads.largest[k, i]
        _iterate(code, s, g, w, lanes, results, k)
        close(code, s, g)
        for lane in range(LANES):
            if lanes.mode[lane] == DONE:
                _book(s, lanes, lane, results[k, lane])
        if (before + k + 1) % shots.every == 0:
            shoot(s, shots, kept)
            kept += 1
