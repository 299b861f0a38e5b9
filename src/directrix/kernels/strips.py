"""Steps of a chain in lanes, compiled: several steps a call, each Newton's iteration and its books.

The chain is cut into parts, LANES of them of equal length in a strip, side by side; the up to LANES − 1 elements that
are left over are a strip one element long. Inner nodes are eliminated in lanes (:mod:`rows`), the few nodes where parts
meet are solved for as a chain of their own. All arrays are flat and end in [… value][lane]. Strips of whole chains
(``s.whole``) belong to :mod:`bundle`.

A long chain has several strips, and threads may share them (:mod:`team`): every thread runs the whole loop, does what
there is to do on its own strips, meets the others, and then computes from all strips what concerns all, the nodes where
parts meet (``w``, each its own) among them. So all come to the same decisions, and to the same bits as one alone.
"""
# pyright: basic, reportCallIssue=false

from math import sqrt

from directrix.kernels.call import call_lanes
from directrix.kernels.chain import solve_chain
from directrix.kernels.compile import LANES
from directrix.kernels.jit import compiled, inner
from directrix.kernels.judged import judged
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
    load,
    move,
    rows_back,
    shoot,
    zero,
)
from directrix.kernels.team import meet, strip_at

__all__ = ["change", "eliminate", "imbalance", "run", "solve"]


@inner
def _join(s, w, only_right):
    """Add what couples the ends of the parts to the system of the nodes where they meet."""
    for lane in range(s.lanes):
        a = s.first + lane
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
def solve(code, team, main, w, frozen, only_right):
    """Solve for the nodes where parts meet, then backwards through all rows; False when a pivot vanishes."""
    if not only_right:
        zero(w.blocks.reshape(-1))
    zero(w.rhs.reshape(-1))
    for k in range(team.all.shape[0]):
        _join(strip_at(team.all, k, main), w, only_right)
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
        return False
    for k in range(team.own.shape[0]):
        _back(code, strip_at(team.own, k, main), w)
    return True


@inner
def _back(code, s, w):
    last = s.elements * s.stride * SIX
    for lane in range(LANES):
        a = s.first + min(lane, s.lanes - 1)
        for i in range(6):
            s.du[i * LANES + lane] = w.du[a, i]
            s.du[last + i * LANES + lane] = w.du[a + 1, i]
    zero(s.size)
    call_lanes(code[MEASURE], s.du, 0, s.size, 0)
    call_lanes(code[MEASURE], s.du, last, s.size, 0)
    rows_back(code, s)


@inner
def _measured(team, main):
    """Largest displacement and turn of all increments, and whether they are finite."""
    moved = turned = total = 0.0
    for k in range(team.all.shape[0]):
        s = strip_at(team.all, k, main)
        for lane in range(LANES):
            moved, turned = max(moved, s.size[lane]), max(turned, s.size[LANES + lane])
            total += s.size[2 * LANES + lane]
    return sqrt(moved), sqrt(turned), total < 1e300


@inner
def change(code, team, main, scale):
    """Add the increments to the strips of one thread."""
    for k in range(team.own.shape[0]):
        move(code, strip_at(team.own, k, main), scale)


@inner
def imbalance(code, team, main, g, w, options):
    """Residual of all nodes; the largest unbalanced force or moment over what is allowed, 1e300 if not finite."""
    for k in range(team.own.shape[0]):
        balance(code, strip_at(team.own, k, main), g)
    meet(team)
    for a in range(w.res.shape[0]):
        for i in range(6):
            w.res[a, i] = w.load[a, i]
    force, moment, off_f, off_m, total = w.largest[0], w.largest[1], 0.0, 0.0, 0.0
    for k in range(team.all.shape[0]):
        s = strip_at(team.all, k, main)
        for lane in range(LANES):
            force, moment = max(force, s.most[lane]), max(moment, s.most[LANES + lane])
            off_f, off_m = max(off_f, s.most[2 * LANES + lane]), max(off_m, s.most[3 * LANES + lane])
            total += s.most[4 * LANES + lane]
        for lane in range(s.lanes):
            a = s.first + lane
            for i in range(6):
                w.res[a, i] -= s.ends[i * LANES + lane]
                w.res[a + 1, i] -= s.ends[SIX + i * LANES + lane]
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
def _ends(s, w, own):
    """Residuals of the ends of the parts into the lanes: their own shares for a right-hand side, or all of it."""
    last = s.elements * s.stride * SIX
    for lane in range(s.lanes):
        for i in range(6):
            s.res[i * LANES + lane] = w.res[s.first + lane, i] if own or lane + s.first == 0 else 0.0
            s.res[last + i * LANES + lane] = w.res[s.first + lane + 1, i]


@inner
def eliminate(code, team, main, g, w, frozen, again):
    """New tangents, or ``again`` residuals through the factors that are there: what couples the ends of the parts."""
    for k in range(team.own.shape[0]):
        s = strip_at(team.own, k, main)
        if again:
            _ends(s, w, False)
            pass_again(code, s)
        else:
            eliminate_strip(code, s, g, frozen)
    meet(team)


@inner
def _iterate(code, team, main, g, w, options, row):
    """Newton's iteration; the number of increments, 0 when the general solver has to take the step;
    and how many of them had a new tangent."""
    length, limit, allowed = options[3], options[4], int(options[5])
    fine = finest(main)
    frozen = False
    again = stale = w.kept[0] > 0
    before, tangents = 0.0, 0
    if stale:
        imbalance(code, team, main, g, w, options)
    for iteration in range(1, allowed + 1):
        tangents += 0 if again else 1
        eliminate(code, team, main, g, w, frozen, again)
        solved = solve(code, team, main, w, frozen, again)
        meet(team)
        moved, turned, finite = _measured(team, main)
        if not (solved and finite):
            return 0, tangents
        if iteration <= SHOWN:
            row[MOVES + 2 * iteration - 2], row[MOVES + 2 * iteration - 1] = moved, turned
        w.scale[0] = 1.0 if turned <= limit else limit / turned
        change(code, team, main, w.scale)
        if iteration == 1:
            w.kept[0] = turned <= LARGE_TURN
        if frozen or turned > LARGE_TURN:
            frozen, again, stale, before = not frozen and options[6] > 0.0, False, False, 0.0
            continue
        before, small, settled, again = judged(moved, turned, length, before, again, fine)
        if stale:  # every step has a tangent of its own
            stale = again = False
        elif again or small:
            worst = imbalance(code, team, main, g, w, options)
            if small and settled and worst <= 1.0:
                return iteration, tangents
            if not worst < 1e300:
                return 0, tangents
    return 0, tangents


@inner
def _keep(team, main, back):
    """Positions at the start of the step, or back to where it began."""
    for k in range(team.own.shape[0]):
        s = strip_at(team.own, k, main)
        for node in range(s.elements * s.stride + 1):
            for i in range(3 * LANES):
                if back:
                    s.x[node * X + i] = s.start[node * 3 * LANES + i]
                    s.x[node * X + 12 * LANES + i] = 0.0
                else:
                    s.start[node * 3 * LANES + i] = s.x[node * X + i]
            for i in range(9 * LANES if back else 0):
                s.x[node * X + 3 * LANES + i] = s.x[node * X + 15 * LANES + i]


@inner
def _loads(team, main, w, loads, step):
    for k in range(team.own.shape[0]):
        load(strip_at(team.own, k, main), loads.strips[step])
    for a in range(w.load.shape[0]):
        for i in range(6):
            w.load[a, i] = loads.joints[step, a, i]
    for i in range(2):
        w.largest[i] = loads.largest[step, i]


@inner
def _add_up(s, row):
    """The books of a strip to those of a step."""
    for lane in range(s.lanes):
        for c in range(8):
            row[BOOKS + c] += s.books[c * LANES + lane]
    for lane in range(LANES):
        for c in range(7):
            row[WORK + c] += s.sums[c * LANES + lane]
        row[HELD] += s.sums[7 * LANES + lane]
        row[LOSS] = max(row[LOSS], s.loss[lane])


@inner
def _take(code, team, main, g, w, options, results, loads, shots, before):
    kept = 0
    for step in range(results.shape[0]):
        if step < loads.strips.shape[0]:
            _loads(team, main, w, loads, step)
        _keep(team, main, False)
        row = results[step]
        zero(row)
        iterations, tangents = _iterate(code, team, main, g, w, options, row)
        if iterations == 0:
            w.kept[0] = 0
            _keep(team, main, True)
            return step
        row[ITERATIONS], row[TANGENTS] = iterations, tangents
        saved = (before + step + 1) % shots.every == 0
        for k in range(team.own.shape[0]):
            s = strip_at(team.own, k, main)
            _ends(s, w, True)
            close(code, s, g)
            if saved:
                shoot(s, shots, kept)
        meet(team)
        if saved:
            kept += 1
        for k in range(team.all.shape[0]):
            _add_up(strip_at(team.all, k, main), row)
    return results.shape[0]


@compiled
def run(code, team, main, g, w, options, results, loads, shots, before):
    """Take steps, one a row of ``results`` (steps, RESULTS), as long as they converge; how many did. ``main`` is any of
    the strips; every thread of a team calls this, with ``team``, ``w`` and ``results`` of its own, and none comes back
    before all have done everything.

    ``before`` steps were taken already; of every ``shots.every``-th the state and the reactions are kept. ``loads``
    have a row for every step, or one for all.

    A row: iterations, work of the loads, Σ force (3), Σ moment (3), W, T, L (3), J (3), largest squared loss of
    orthonormality, Σ |support force|², how many iterations had a new tangent, displacement and turn of the first SHOWN
    iterations. When a step does not converge the state is that at its start.
    """
    if not meet(team):
        return 0
    taken = _take(code, team, main, g, w, options, results, loads, shots, before)
    meet(team)
    return taken
