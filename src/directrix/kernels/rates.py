"""How velocities follow from a step, node by node; the schemes are those of :class:`directrix.scheme.Rates`."""
# pyright: basic

from math import sqrt

import numpy as np

from directrix.kernels.jit import compiled, inner

__all__ = ["ALPHA", "DISSIPATIVE", "MIDPOINT", "NONE", "SPIN", "begin", "dissipative", "end"]

NONE, MIDPOINT, SPIN, ALPHA, DISSIPATIVE = range(5)
# places in `g` for ALPHA
CV, CA, H, BETA, GAMMA, AM, AF = range(7)


@inner
def dissipative(w, v0, chi, v1, slope):
    """v1 (3,) with (1 + g) ½(v0 + v1) = w, g = chi (|v1| − |v0|)/(|v1| + |v0|); ``slope`` (3, 3) = dv1/dw.

    One scalar unknown, s = |v1|, and for chi < 1/3 one solution.
    """
    s0 = sqrt(v0[0] * v0[0] + v0[1] * v0[1] + v0[2] * v0[2])
    for i in range(3):
        v1[i] = 2.0 * w[i] - v0[i]
    s = sqrt(v1[0] * v1[0] + v1[1] * v1[1] + v1[2] * v1[2])
    y, ys = 1.0, 0.0
    if chi > 0.0 and s + s0 > 0.0:
        for _ in range(60):
            d = (1.0 + chi) * s + (1.0 - chi) * s0
            y, ys = (s + s0) / d, -2.0 * chi * s0 / (d * d)
            size, turn = 0.0, 0.0
            for i in range(3):
                v1[i] = 2.0 * y * w[i] - v0[i]
                size += v1[i] * v1[i]
                turn += w[i] * v1[i]
            size = sqrt(size)
            step = size - s
            if size > 0.0:
                step /= 1.0 - 2.0 * ys * turn / size
            s = max(s + step, 0.5 * s)
            if abs(step) <= 1e-15 * (s + s0):
                break
        d = (1.0 + chi) * s + (1.0 - chi) * s0
        y, ys = (s + s0) / d, -2.0 * chi * s0 / (d * d)
        for i in range(3):
            v1[i] = 2.0 * y * w[i] - v0[i]
    size = sqrt(v1[0] * v1[0] + v1[1] * v1[1] + v1[2] * v1[2])
    turn = (w[0] * v1[0] + w[1] * v1[1] + w[2] * v1[2]) / size if size > 0.0 else 0.0
    for i in range(3):
        for j in range(3):
            lean = 2.0 * ys * w[i] * v1[j] / (size * (1.0 - 2.0 * ys * turn)) if size > 0.0 else 0.0
            slope[i, j] = 2.0 * y * ((1.0 if i == j else 0.0) + lean)


@inner
def _spin(x, axes, out):
    """out (3,) = ω of Ṙ = ω̂ R for the columns of R at ``axes`` and those of Ṙ at 27 of the row ``x``."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = 0.0
        for c in range(0, 9, 3):
            out[i] += 0.5 * (x[axes + c + j] * x[27 + c + k] - x[axes + c + k] * x[27 + c + j])


@inner
def _to_body(x, axes, v, out):
    for c in range(3):
        out[c] = x[axes + 3 * c] * v[0] + x[axes + 3 * c + 1] * v[1] + x[axes + 3 * c + 2] * v[2]


@inner
def _turn(x, out):
    """out (3,) = log(R0ᵀ R1) of the row ``x``, by the quaternion."""
    m = np.empty((3, 3))
    for a in range(3):
        for b in range(3):
            m[a, b] = 0.0
            for i in range(3):
                m[a, b] += x[15 + 3 * a + i] * x[3 + 3 * b + i]
    c = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    for i in range(3):
        out[i] = 0.5 * (m[(i + 2) % 3, (i + 1) % 3] - m[(i + 1) % 3, (i + 2) % 3])
    s = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    factor = np.arctan2(s, c) / s if s > 1e-8 else 1.0 + s * s / 6.0
    for i in range(3):
        out[i] *= factor


@compiled
def begin(kind, carried, nodes, rows, x, g):
    """Prepare the place of the rates: predictors for ALPHA (see ``DirectorAcceleration``), R0 where rotations are
    carried from iteration to iteration; others need nothing. Accelerations are kept from ``rows`` on."""
    # here and elsewhere loops in place of slices that are assigned: those take two seconds more to compile
    for node in range(nodes if carried else 0):
        for i in range(9):
            x[node, 27 + i] = x[node, 15 + i]
    if kind != ALPHA:
        return
    h, beta, gamma, am, af = g[H], g[BETA], g[GAMMA], g[AM], g[AF]
    v, w = np.empty(6), np.empty(3)
    for node in range(nodes):
        y, old = x[node], x[rows + node]
        _spin(y, 15, w)
        for i in range(3):
            v[i] = y[24 + i]
        _to_body(y, 15, w, v[3:])
        for i in range(6):
            a, rate = old[i], old[6 + i]
            p = v[i] / (beta * h) + (0.5 - beta) / beta * a
            place = 24 + i if i < 3 else 27 + i
            y[place] = v[i] + (1.0 - gamma) * h * a - gamma * h * p
            y[place + 3] = (-(1.0 - am) * p + am * a - af * rate) / (1.0 - af)


@inner
def end(kind, nodes, rows, x, g, lumped):
    """Rates at the end of a step, in place; what the scheme took from the kinetic energy."""
    lost = 0.0
    v, w, slope = np.empty(6), np.empty(3), np.empty((3, 3))
    theta, omega = np.empty(3), np.empty(3)
    for node in range(nodes):
        y = x[node]
        if kind == MIDPOINT:
            for i in range(12):
                y[24 + i] = g[0] * (y[12 + i] if i < 3 else y[i] - y[12 + i]) - y[24 + i]
        elif kind == SPIN:
            for i in range(3):
                y[24 + i] = g[0] * y[12 + i] - y[24 + i]
            _spin(y, 15, omega)
            _cayley(y, theta)
            _to_body(y, 15, omega, w)
            for i in range(3):
                omega[i] = g[0] * theta[i] - (y[3 + i] * w[0] + y[6 + i] * w[1] + y[9 + i] * w[2])
            _rates_from_spin(y, omega)
        elif kind == ALPHA:
            old = x[rows + node]
            _turn(y, theta)
            for i in range(6):
                place = 24 + i if i < 3 else 27 + i
                q = y[12 + i] if i < 3 else theta[i - 3]
                v[i] = g[CV] * q + y[place]
                rate = g[CA] * q + y[place + 3]
                old[i] = ((1.0 - g[AF]) * rate + g[AF] * old[6 + i] - g[AM] * old[i]) / (1.0 - g[AM])
                old[6 + i] = rate
            for i in range(3):
                y[24 + i] = v[i]
                omega[i] = y[3 + i] * v[3] + y[6 + i] * v[4] + y[9 + i] * v[5]
            _rates_from_spin(y, omega)
        elif kind == DISSIPATIVE:
            lost += _end_dissipative(y, g, lumped[node], v, w, slope)
    return lost


@inner
def _cayley(y, out):
    """ϑ of R1 = cay(ϑ) R0."""
    trace = 1.0
    for i in range(3):
        out[i] = 0.0
    for a in range(3, 12, 3):
        b = 12 + a
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            trace += y[a + i] * y[b + i]
            out[i] += y[a + k] * y[b + j] - y[a + j] * y[b + k]
    for i in range(3):
        out[i] *= 2.0 / trace


@inner
def _rates_from_spin(y, omega):
    """Ṙ1 = ω̂ R1."""
    for c in range(0, 9, 3):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            y[27 + c + i] = omega[j] * y[3 + c + k] - omega[k] * y[3 + c + j]


@inner
def _end_dissipative(y, g, lump, v1, w, slope):
    """Rates of one node from its principal vectors: position, then R D_k; ``lump`` = mass, λ (3), D (9)."""
    lost = 0.0
    before = np.empty(3)
    rates = np.zeros(9)
    for k in range(4):
        for i in range(3):
            if k == 0:
                w[i], before[i] = g[1] * y[12 + i], y[24 + i]
            else:
                w[i], before[i] = 0.0, 0.0
                for c in range(3):
                    share = lump[4 + 3 * (k - 1) + c]
                    w[i] += g[1] * share * (y[3 + 3 * c + i] - y[15 + 3 * c + i])
                    before[i] += share * y[27 + 3 * c + i]
        dissipative(w, before, g[3], v1, slope)
        change = sqrt(v1[0] * v1[0] + v1[1] * v1[1] + v1[2] * v1[2])
        change -= sqrt(before[0] * before[0] + before[1] * before[1] + before[2] * before[2])
        lost += 0.5 * g[3] * lump[k] * change * change
        for i in range(3):
            if k == 0:
                y[24 + i] = v1[i]
            else:
                for c in range(3):
                    rates[3 * c + i] += lump[4 + 3 * (k - 1) + c] * v1[i]
    for i in range(9):
        y[27 + i] = rates[i]
    return lost
