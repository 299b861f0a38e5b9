"""Steps of a chain in lanes, compiled: several steps a call, each Newton's iteration and its books.

The chain is cut into LANES parts of equal length that lie side by side in one strip; the up to LANES − 1 elements that
are left over follow as a second strip, one element long. Inner nodes are eliminated in lanes (:mod:`rows`), the few
nodes where parts meet are solved for as a chain of their own. All arrays are flat and end in [… value][lane]. Strips of
whole chains (``s.whole``) belong to :mod:`bundle`.
"""
# pyright: basic, reportCallIssue=false

from math import sqrt

from directrix.kernels.call import call_lanes
from directrix.kernels.chain import solve_chain
from directrix.kernels.compile import LANES
from directrix.kernels.jit import compiled, inner
from directrix.kernels.strip_elimination import MEASURE, SIX, X, eliminate_strip, pass_again
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
    judged,
    load,
    move,
    rows_back,
    shoot,
    zero,
)

__all__ = ["imbalance", "run", "solve"]


@inner
def _join(s, first, w, only_right):
    """Add what couples the ends of the parts to the system of the nodes where they meet."""
    for lane in range(s.lanes):
        a = first + lane
        for i in range(6):
            w.rhs[a, i] += s.carry[(156 + i) * LANES + lane]
            w.rhs[a + 1, i] += s.carry[(108 + i) * LANES + lane]
            for j in range(0 if only_right else 6):
                k = (6 * i + j) * LANES + lane
                w.blocks[3 * a + 1, i, j] += s.carry[120 * LANES + k]
                w.blocks[3 * a + 2, i, j] += s.carry[72 * LANES + k]
                w.blocks[3 * a + 3, i, j] += s.carry[36 * LANES + k]
                w.blocks[3 * a + 4, i, j] += s.carry[k]


@inner
def solve(code, main, rest, w, frozen, only_right):
    """Solve for the nodes where parts meet, then backwards through all rows; largest displacement and turn, and a sum
    that shows what is not finite."""
    if not only_right:
        zero(w.blocks.reshape(-1))
    zero(w.rhs.reshape(-1))
    for part in range(2):  # one call for both strips: what is called is compiled into each place
        _join(main if part == 0 else rest, part * main.lanes, w, only_right)
    for a in range(w.rhs.shape[0]):
        for i in range(6):
            if not only_right:
                w.rhs[a, i] += w.load[a, i]
            if w.fixed[a, i] or (frozen and i > 2):
                w.rhs[a, i] = 0.0
                for b in range(0 if only_right else 3):
                    for j in range(6):
                        w.blocks[3 * a + b, i, j] = 0.0
                w.blocks[3 * a + 1, i, i] = 1.0
    if solve_chain(w.eliminate, w.blocks, w.rhs, w.factors, w.du) >= 0:
        return 0.0, 0.0, False
    zero(w.size)
    for part in range(2):
        _back(code, main if part == 0 else rest, part * main.lanes, w)
    moved = turned = total = 0.0
    for lane in range(LANES):
        moved, turned = max(moved, w.size[lane]), max(turned, w.size[LANES + lane])
        total += w.size[2 * LANES + lane]
    return sqrt(moved), sqrt(turned), total < 1e300


@inner
def _back(code, s, first, w):
    last = s.elements * s.stride * SIX
    for lane in range(LANES):
        a = first + min(lane, max(s.lanes - 1, 0))
        for i in range(6):
            s.du[i * LANES + lane] = w.du[a, i]
            s.du[last + i * LANES + lane] = w.du[a + 1, i] if s.lanes else 0.0
    if s.lanes == 0:
        return
    call_lanes(code[MEASURE], s.du, 0, w.size, 0)
    call_lanes(code[MEASURE], s.du, last, w.size, 0)
    rows_back(code, s, w)


@inner
def imbalance(code, main, rest, g, w, options):
    """Residual of all nodes; the largest unbalanced force or moment over what is allowed, 1e300 if not finite."""
    zero(w.most)
    for a in range(w.res.shape[0]):
        for i in range(6):
            w.res[a, i] = w.load[a, i]
    for part in range(2):
        balance(code, main if part == 0 else rest, part * main.lanes, g, w)
    force, moment, off_f, off_m, total = w.largest[0], w.largest[1], 0.0, 0.0, 0.0
    for lane in range(LANES):
        force, moment = max(force, w.most[lane]), max(moment, w.most[LANES + lane])
        off_f, off_m = max(off_f, w.most[2 * LANES + lane]), max(off_m, w.most[3 * LANES + lane])
        total += w.most[4 * LANES + lane]
    for a in range(w.res.shape[0]):
        for i in range(6):
            if not w.fixed[a, i]:
                off = abs(w.res[a, i])
                total += off
                if i < 3:
                    off_f = max(off_f, off)
                else:
                    off_m = max(off_m, off)
    if not abs(total) < 1e300:
        return 1e300
    return max(off_f / max(options[0] * force, options[1]), off_m / max(options[0] * moment, options[2]))


@inner
def _ends(s, first, w, own):
    """Residuals of the ends of the parts into the lanes: their own shares for a right-hand side, or all of it."""
    last = s.elements * s.stride * SIX
    for lane in range(s.lanes):
        for i in range(6):
            s.res[i * LANES + lane] = w.res[first + lane, i] if own or lane + first == 0 else 0.0
            s.res[last + i * LANES + lane] = w.res[first + lane + 1, i]


@inner
def _iterate(code, main, rest, g, w, options, row):
    """Newton's iteration; the number of increments, 0 when the general solver has to take the step;
    and how many of them had a new tangent."""
    length, limit, allowed = options[3], options[4], int(options[5])
    fine = finest(main)
    frozen = False
    again = stale = w.kept[0] > 0
    before, tangents = 0.0, 0
    if stale:
        imbalance(code, main, rest, g, w, options)
    for iteration in range(1, allowed + 1):
        tangents += 0 if again else 1
        for part in range(2 if rest.lanes else 1):
            s = main if part == 0 else rest
            if again:
                _ends(s, part * main.lanes, w, False)
                pass_again(code, s)
            else:
                eliminate_strip(code, s, g, frozen)
        moved, turned, finite = solve(code, main, rest, w, frozen, again)
        if not finite:
            return 0, tangents
        if iteration <= SHOWN:
            row[MOVES + 2 * iteration - 2], row[MOVES + 2 * iteration - 1] = moved, turned
        w.scale[0] = 1.0 if turned <= limit else limit / turned
        for part in range(2):
            move(code, main if part == 0 else rest, w.scale)
        if iteration == 1:
            w.kept[0] = turned <= LARGE_TURN
        if frozen or turned > LARGE_TURN:
            frozen, again, stale, before = not frozen and options[6] > 0.0, False, False, 0.0
            continue
        before, small, settled, again = judged(moved, turned, length, before, again, fine)
        if stale:  # every step has a tangent of its own
            stale = again = False
        elif again or small:
            worst = imbalance(code, main, rest, g, w, options)
            if small and settled and worst <= 1.0:
                return iteration, tangents
            if not worst < 1e300:
                return 0, tangents
    return 0, tangents


@inner
def _keep(s, back):
    """Positions at the start of the step, or back to where it began."""
    for node in range(s.elements * s.stride + 1 if s.lanes else 0):
        for k in range(3 * LANES):
            if back:
                s.x[node * X + k] = s.start[node * 3 * LANES + k]
                s.x[node * X + 12 * LANES + k] = 0.0
            else:
                s.start[node * 3 * LANES + k] = s.x[node * X + k]
        for k in range(9 * LANES if back else 0):
            s.x[node * X + 3 * LANES + k] = s.x[node * X + 15 * LANES + k]


@inner
def _loads(main, rest, w, loads, k):
    load(main, w, loads.main[k], loads.largest[k])
    load(rest, w, loads.rest[k], loads.largest[k])
    for a in range(w.load.shape[0]):
        for i in range(6):
            w.load[a, i] = loads.joints[k, a, i]


@compiled
def run(code, main, rest, g, w, options, results, loads, shots, before):
    """Take steps, one a row of ``results`` (steps, RESULTS), as long as they converge; how many did.

    ``before`` steps were taken already; of every ``shots.every``-th the state and the reactions are kept. ``loads``
    have a row for every step, or one for all.

    A row: iterations, work of the loads, Σ force (3), Σ moment (3), W, T, L (3), J (3), largest squared loss of
    orthonormality, Σ |support force|², how many iterations had a new tangent, displacement and turn of the first SHOWN
    iterations. When a step does not converge the state
    is that at its start.
    """
    kept = 0
    for k in range(results.shape[0]):
        if k < loads.main.shape[0]:
            _loads(main, rest, w, loads, k)
        for part in range(2):
            _keep(main if part == 0 else rest, False)
        row = results[k]
        zero(row)
        iterations, tangents = _iterate(code, main, rest, g, w, options, row)
        if iterations == 0:
            w.kept[0] = 0
            for part in range(2):
                _keep(main if part == 0 else rest, True)
            return k
        row[ITERATIONS], row[TANGENTS] = iterations, tangents
        zero(w.sums)
        zero(w.loss)
        for part in range(2):
            s = main if part == 0 else rest
            _ends(s, part * main.lanes, w, True)
            close(code, s, g, w)
            for lane in range(s.lanes):
                for c in range(8):
                    row[BOOKS + c] += w.books[c * LANES + lane]
        for lane in range(LANES):
            for c in range(7):
                row[WORK + c] += w.sums[c * LANES + lane]
            row[HELD] += w.sums[7 * LANES + lane]
            row[LOSS] = max(row[LOSS], w.loss[lane])
        if (before + k + 1) % shots.every == 0:
            # of a node that is in both strips the main one has the last word
            shoot(rest, shots.rest, shots, kept)
            shoot(main, shots.main, shots, kept)
            kept += 1
    return results.shape[0]
