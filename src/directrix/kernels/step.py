"""One step, compiled: Newton's iteration and the books of the step.

Mechanics stay in the element kernels; here are only positions, rotations, supports and stopping.
"""
# pyright: basic

from math import cos, sin, sqrt

import numpy as np

from directrix.kernels.chain import solve_chain
from directrix.kernels.elements import (
    BACK,
    CONN,
    COUNT,
    NN,
    UNKNOWN,
    acts,
    assemble,
    books,
    commit,
    ground,
    internal_forces,
    lost,
    right_side,
)
from directrix.kernels.jit import compiled, inner
from directrix.kernels.judged import BEFORE, FIRST, LEFT, STALLED, blurred, expected, finest_of, judged, noted
from directrix.kernels.nodes import orthonormal
from directrix.kernels.rates import NONE, begin, end

__all__ = [
    "AGAIN",
    "CONVERGED",
    "LIMIT",
    "NON_FINITE",
    "SINGULAR",
    "SOLVE",
    "advance",
    "assemble",
    "begin",
    "books",
    "finish",
    "imbalance",
    "move",
    "newton",
    "off_balance",
    "spread",
]

CONVERGED, SOLVE, LIMIT, NON_FINITE, SINGULAR, AGAIN = range(6)
# places of `control`: what comes next, iterations so far, positions only, the node or element to blame, whether the
# next increment goes through the factors that are there
PHASE, ITERATION, FROZEN, BLAME, KEPT = range(5)
ROUND_OFF = 1e-14
LARGE_TURN = 0.05  # rad: after a larger rotation the positions are solved for again


@inner
def _rotation(t, cayley, out):
    """out (3, 3) = exp(t̂), or the Cayley transform of t."""
    s = t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
    if cayley:
        a = 1.0 / (1.0 + 0.25 * s)
        b = 0.5 * a
    elif s < 1e-4:
        a = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0))
        b = 0.5 - s / 24.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0))
    else:
        angle = sqrt(s)
        a, b = sin(angle) / angle, (1.0 - cos(angle)) / s
    for i in range(3):
        for j in range(3):
            out[i, j] = b * t[i] * t[j]
        out[i, i] += 1.0 - b * s
    out[0, 1] -= a * t[2]
    out[0, 2] += a * t[1]
    out[1, 0] += a * t[2]
    out[1, 2] -= a * t[0]
    out[2, 0] -= a * t[1]
    out[2, 1] += a * t[0]


@compiled
def spread(tables, work):
    """Fill ``work.step`` (n, 6) from the increments ``work.du`` of the end nodes; interior nodes follow."""
    step = work.step
    for node in range(step.shape[0]):
        row = tables.row[node]
        if row >= 0:
            for i in range(6):
                step[node, i] = work.du[row, i]
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        nn = head[NN]
        m = 6 * (nn - 2)
        for e in range(head[COUNT] if nn > 2 and nn > head[UNKNOWN] else 0):
            conn = tables.conn[head[CONN] + e * nn : head[CONN] + (e + 1) * nn]
            back = work.back[head[BACK] + e * m : head[BACK] + (e + 1) * m]
            for i in range(m):
                s = back[i, 12]
                for c in range(6):
                    s -= back[i, c] * step[conn[0], c] + back[i, 6 + c] * step[conn[nn - 1], c]
                step[conn[1 + i // 6], i % 6] = s


@compiled
def move(step, nodes, x, frozen, cayley, limit, far=np.inf):
    """Add the increments ``step`` (≥ n, 6) to the ``nodes`` of ``x`` and to the multipliers behind them; largest
    displacement and turn.

    If a node would turn by more than ``limit``, or move further than ``far``, everything is scaled down to that. Node
    of the first value that is not finite, or −1.
    """
    moved, turned = 0.0, 0.0
    for node in range(step.shape[0]):
        u, t = step[node, :3], step[node, 3:]
        d2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
        t2 = t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
        if not (d2 + t2 < 1e300):
            return moved, turned, node
        if node < nodes:
            moved, turned = max(moved, d2), max(turned, t2)
    moved, turned = sqrt(moved), sqrt(turned)
    factor = 1.0 if turned <= limit else limit / turned
    if factor * moved > far:
        factor = far / moved
    q, t = np.empty((3, 3)), np.empty(3)
    for node in range(nodes, step.shape[0]):
        for i in range(6):
            x[node, i] += factor * step[node, i]
    for node in range(nodes):
        for i in range(3):
            x[node, i] += factor * step[node, i]
            x[node, 12 + i] += factor * step[node, i]
            t[i] = factor * step[node, 3 + i]
        if frozen or (t[0] == 0.0 and t[1] == 0.0 and t[2] == 0.0):
            continue
        _rotation(t, cayley, q)
        for c in range(3):
            at = 3 + 3 * c
            a, b, d = x[node, at], x[node, at + 1], x[node, at + 2]
            for i in range(3):
                x[node, at + i] = q[i, 0] * a + q[i, 1] * b + q[i, 2] * d
    return moved, turned, -1


@compiled
def advance(tables, work, x, frozen, cayley, limit, far=np.inf):
    """Spread the increments ``work.du`` over all nodes and :func:`move` them."""
    spread(tables, work)
    return move(work.step, tables.nodes, x, frozen, cayley, limit, far)


@inner
def carry(tables, work, x, g):
    """Write the history after an iteration: rotations count from here on from R1 (in the place of R0)."""
    commit(tables, work, x, g)
    for node in range(tables.nodes):
        for i in range(9):
            x[node, 15 + i] = x[node, 3 + i]


@compiled
def imbalance(nodes, work, mask, tolerance, floor, length):
    """Largest unbalanced force or moment over what is allowed, and its node; behind the ``nodes`` constraints, which
    may be off by 1e-12 of the ``length`` of the model. What rounds off where forces act on arms is always allowed."""
    applied = work.applied
    scale_f, scale_m = work.scale[0], work.scale[1]
    for node in range(applied.shape[0]):
        for i in range(3):
            scale_f = max(scale_f, abs(applied[node, i]))
            scale_m = max(scale_m, abs(applied[node, 3 + i]))
    allowed_f = max(tolerance * scale_f, floor[0], ROUND_OFF * scale_m / length)
    allowed_m = max(tolerance * scale_m, floor[1], ROUND_OFF * scale_f * length)
    worst, at = 0.0, 0
    for node in range(applied.shape[0]):
        for i in range(6):
            if not mask[node, i]:
                allowed = allowed_f if i < 3 else allowed_m
                if node >= nodes:
                    allowed = 1e-12 * length if i < 3 else 1e-12
                off = abs(work.internal[node, i] - applied[node, i]) / allowed
                if not off <= worst:
                    worst, at = off, node
    return worst, at


@compiled
def off_balance(nodes, work, mask, frozen, row):
    """Into ``row`` the largest unbalanced force and moment of the ``nodes``, and at [4] the node of that force, of that
    moment where no force is unbalanced."""
    row[0], row[1], row[4] = 0.0, 0.0, -1.0
    for node in range(nodes):
        for i in range(6):
            if not mask[node, i] and not (frozen and i > 2):
                off, at = abs(work.internal[node, i] - work.applied[node, i]), i // 3
                if not off <= row[at]:
                    row[at] = off
                    if at == 0 or row[0] == 0.0:
                        row[4] = node


@compiled
def newton(tables, work, x, g, external, mask, options, control):
    """Iterate until balance, in one call for a chain; a general frame returns for every linear system: ``SOLVE`` asks
    for new factors, ``AGAIN`` for another right-hand side through those that are there. These are kept as
    :func:`judged` says, and for the last increments the iteration then goes on until the next would be round-off.
    ``control[KEPT]`` may say at the start that there are some from the step before.

    ``options``: tolerance, floors (force, moment), length, largest turn per iteration, iterations allowed, Cayley,
    whether the positions are solved for by themselves after a large turn, largest displacement per iteration, whether
    factors may be kept.
    ``work.trail`` gets a row an iteration, as long as it has room: the largest unbalanced force and moment before it,
    the largest displacement and turn that it asked for, and the node that is furthest from balance.
    """
    tolerance, floor, length = options[0], options[1:3], options[3]
    limit, allowed, cayley, fine = options[4], options[5], options[6] > 0.0, finest_of(tables.nodes)
    while True:
        if control[PHASE] == 0:
            if control[ITERATION] == 0:
                work.notes[BEFORE] = 0.0
                if control[KEPT] == 1:
                    internal_forces(tables, work, x, g, external)
                    work.notes[LEFT] = imbalance(tables.nodes, work, mask, tolerance, floor, length)[0]
            if control[ITERATION] >= allowed:
                internal_forces(tables, work, x, g, external)
                control[BLAME] = imbalance(tables.nodes, work, mask, tolerance, floor, length)[1]
                return LIMIT
            control[ITERATION] += 1
            if control[KEPT] == 1:
                right_side(tables, work, mask)
            else:
                bad = assemble(tables, work, x, g, external, mask, control[FROZEN] == 1)
                if bad >= 0:
                    control[BLAME] = tables.element_node[bad]
                    return SINGULAR
            if control[ITERATION] <= work.trail.shape[0]:
                off_balance(tables.nodes, work, mask, control[FROZEN] == 1, work.trail[control[ITERATION] - 1])
            control[PHASE] = 1
            if tables.chain == 0:
                return AGAIN if control[KEPT] == 1 else SOLVE
            row = solve_chain(tables.eliminate, work.blocks, work.rhs, work.factors, work.du)
            if row >= 0:
                control[BLAME] = tables.node_of_row[row]
                return SINGULAR
        control[PHASE] = 0
        frozen, again = control[FROZEN] == 1, control[KEPT] == 1
        control[KEPT] = 0
        moved, turned, bad = advance(tables, work, x, frozen, cayley, limit, options[8])
        if control[ITERATION] <= work.trail.shape[0]:
            tried = work.trail[control[ITERATION] - 1]
            tried[2], tried[3] = moved, turned
        if bad >= 0 and again:
            continue  # nothing has moved
        if bad >= 0:
            control[BLAME] = bad
            return NON_FINITE
        if tables.carried:
            carry(tables, work, x, g)
        control[FROZEN] = 0
        if frozen or turned > LARGE_TURN or moved > options[8]:
            if not frozen and turned > LARGE_TURN and options[7] > 0.0:
                control[FROZEN] = 1
            if control[ITERATION] == 1:
                work.notes[FIRST] = turned
            work.notes[BEFORE] = 0.0
            continue
        before = expected(moved, turned, length, work.notes, again)
        size, small, settled, keep = judged(moved, turned, length, before, again, fine)
        noted(size, again, control[ITERATION], work.notes)
        keep = keep and options[9] > 0.0
        if small or keep:
            internal_forces(tables, work, x, g, external)
            if blurred(floor, work.scale, work.notes):
                keep, settled = False, settled and not again
            if keep:
                control[KEPT] = 1
            worst, at = imbalance(tables.nodes, work, mask, tolerance, floor, length)
            control[BLAME] = at
            # displacements of stiff parts are round-off long before their forces are
            settled = settled and (not again or worst >= STALLED * work.notes[LEFT])
            work.notes[LEFT] = worst
            if small and settled and worst <= 1.0:
                return CONVERGED
            if not worst < 1e300:
                return NON_FINITE


@compiled
def finish(tables, work, x, g, before, mask, totals, strains):
    """Books of a finished step, and x1 becomes x0 (Δr = 0); history and rates go along.

    Work is booked with the mean of the loads ``before`` (n, 6) and ``work.applied``; statics take the mean of the
    support forces as well. ``work.flow`` receives the work of the loads, the work at the supports, Σ force (3) and
    Σ moment about the origin (3) at x½ of loads and supports together, what was dissipated and the work that was done
    on elements; ``work.taken`` and ``work.done`` have these by source, ``work.reaction`` (n, 6) the support forces.
    """
    internal, reaction, applied = work.internal, work.reaction, work.applied
    nodes = tables.nodes
    static = tables.rates == NONE
    base = 24 if tables.carried else 12
    done, at_supports = 0.0, 0.0
    force, moment, turn = np.zeros(3), np.zeros(3), np.zeros(3)
    for node in range(nodes):
        y = x[node]
        # ϑ of R1 = cay(ϑ) R0: with A = R1 R0ᵀ, ϑ = 2 axial(A − Aᵀ) / (1 + tr A)
        trace, t0, t1, t2 = 1.0, 0.0, 0.0, 0.0
        for a in range(3, 12, 3):
            b = base + a
            trace += y[a] * y[b] + y[a + 1] * y[b + 1] + y[a + 2] * y[b + 2]
            t0 += y[a + 2] * y[b + 1] - y[a + 1] * y[b + 2]
            t1 += y[a] * y[b + 2] - y[a + 2] * y[b]
            t2 += y[a + 1] * y[b] - y[a] * y[b + 1]
        turn[0], turn[1], turn[2] = 2.0 * t0 / trace, 2.0 * t1 / trace, 2.0 * t2 / trace
        for i in range(6):
            delta = y[12 + i] if i < 3 else turn[i - 3]
            held = 0.0
            if mask[node, i]:
                held = internal[node, i] - applied[node, i]
                at_supports += (0.5 * (held + reaction[node, i]) if static else held) * delta
            reaction[node, i] = held
            done += 0.5 * (applied[node, i] + before[node, i]) * delta
        for i in range(3):
            # Σ F and Σ (M + r½ × F)
            j, k = (i + 1) % 3, (i + 2) % 3
            force[i] += applied[node, i] + reaction[node, i]
            moment[i] += applied[node, 3 + i] + reaction[node, 3 + i]
            moment[i] += (y[j] - 0.5 * y[12 + j]) * (applied[node, k] + reaction[node, k])
            moment[i] -= (y[k] - 0.5 * y[12 + k]) * (applied[node, j] + reaction[node, j])
    work.taken[:] = 0.0
    work.done[:] = 0.0
    ground(tables, work, x, g)
    lost(tables, work, x, g)
    driven, prescribed = acts(tables, work, x, g)
    done, at_supports = done + driven, at_supports + prescribed
    if tables.carried:
        for node in range(nodes):
            for i in range(24, 36):
                x[node, i] = 0.0
    else:
        commit(tables, work, x, g)
    for i in range(3):
        force[i] += work.ground[i]
        moment[i] += work.ground[3 + i]
    for node in range(nodes):
        orthonormal(x[node, 3:12])
    taken = end(tables.rates, nodes, work.applied.shape[0], x, g, tables.lumped)
    if tables.numerical >= 0:
        work.taken[tables.numerical] += taken
    for node in range(nodes):
        for i in range(12):
            x[node, 12 + i] = 0.0 if i < 3 else x[node, i]
    work.flow[0], work.flow[1] = done, at_supports
    for i in range(3):
        work.flow[2 + i], work.flow[5 + i] = force[i], moment[i]
    damped = tables.damping.shape[0] > 0
    for point in range(strains.shape[0] if damped else 0):
        for i in range(6):
            work.before[point, i] = strains[point, i]
    books(tables, work, x, totals, strains)
    if damped:
        _dissipated(tables, work, strains)
    work.flow[8], work.flow[9] = 0.0, 0.0
    for source in range(work.taken.shape[0]):
        work.flow[8] += work.taken[source]
        work.flow[9] += work.done[source]


@inner
def _dissipated(tables, work, after):
    """Add Σ Δε·Q Δε of the stress points to ``work.taken``: Q has the weights of the points in it."""
    damping, before = tables.damping, work.before
    for part in range(damping.shape[0]):
        for point in range(damping.shape[1]):
            total = 0.0
            for i in range(6):
                for j in range(6):
                    total += (
                        (after[point, i] - before[point, i])
                        * damping[part, point, i, j]
                        * (after[point, j] - before[point, j])
                    )
            if total != 0.0:
                work.taken[tables.damped[part, point]] += total
