"""What nodes have by themselves: loads that turn with them, and the lumped mass of dissipative steps."""
# pyright: basic

import numpy as np

from directrix.kernels.jit import inner
from directrix.kernels.rates import DISSIPATIVE, dissipative

__all__ = ["nodal_terms", "orthonormal"]

DRIVE = 13  # place in the row of a joint


@inner
def orthonormal(q):
    """q ← q (3 − qᵀq)/2 for nine numbers, columns of a rotation: round-off of many products does not pile up."""
    old = np.empty(9)
    for i in range(9):
        old[i] = q[i]
    for k in range(0, 9, 3):
        g0 = old[k] * old[0] + old[k + 1] * old[1] + old[k + 2] * old[2]
        g1 = old[k] * old[3] + old[k + 1] * old[4] + old[k + 2] * old[5]
        g2 = old[k] * old[6] + old[k + 1] * old[7] + old[k + 2] * old[8]
        for i in range(3):
            own = old[k + i]
            q[k + i] = own - 0.5 * (g0 * old[i] + g1 * old[3 + i] + g2 * old[6 + i] - own)


@inner
def nodal_terms(tables, work, x, g, external):
    """Start ``work.internal`` and ``work.applied`` (n, 6) and, when True is returned, ``work.node_block`` (n, 6, 6)."""
    internal, applied = work.internal, work.applied
    follows = False
    for node in range(applied.shape[0]):
        for i in range(6):
            internal[node, i] = 0.0
            applied[node, i] = external[node, i]
            follows = follows or (node < tables.nodes and external[node, 6 + i] != 0.0)
    for joint in range(tables.nodes, applied.shape[0]):
        x[joint, DRIVE] = external[joint, 6]
    if not follows and not tables.inside and tables.rates != DISSIPATIVE:
        return False
    work.node_block[:] = 0.0
    if follows:
        _followers(tables, work, x, external)
    if tables.rates == DISSIPATIVE:
        for node in range(tables.nodes):
            _inertia(x[node], g, tables.lumped[node], internal[node], work.node_block[node])
    return True


@inner
def _followers(tables, work, x, external):
    """F = R f with R = R1, at half a step ½(R0 + R1) where a step balances there."""
    # 1, or the share of R1 in the mean
    share = 0.5 if tables.half else 1.0
    for node in range(tables.nodes):
        y = x[node]
        for part in range(0, 6, 3):
            f = external[node, 6 + part : 9 + part]
            if f[0] == 0.0 and f[1] == 0.0 and f[2] == 0.0:
                continue
            now = np.zeros(3)
            for c in range(3):
                for i in range(3):
                    now[i] += share * f[c] * y[3 + 3 * c + i]
                    work.applied[node, part + i] += f[c] * (
                        share * y[3 + 3 * c + i] + (1.0 - share) * y[15 + 3 * c + i]
                    )
            # d(applied) = θ × now, and the tangent is that of internal − applied
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                work.node_block[node, part + i, 3 + j] -= now[k]
                work.node_block[node, part + i, 3 + k] += now[j]


@inner
def _inertia(y, g, lump, force, block):
    """M (v1 − v0)/Δt of one node and its tangent; ``lump`` = mass, λ (3), D (9): Euler dyadic Σ λ D Dᵀ."""
    w, v0, v1, f = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    after, half, slope = np.empty(3), np.empty(3), np.empty((3, 3))
    for k in range(4):
        if lump[k] == 0.0:
            continue
        for i in range(3):
            if k == 0:
                w[i], v0[i] = g[1] * y[12 + i], y[24 + i]
            else:
                after[i], half[i], v0[i] = 0.0, 0.0, 0.0
                for c in range(3):
                    d = lump[4 + 3 * (k - 1) + c]
                    after[i] += d * y[3 + 3 * c + i]
                    half[i] += 0.5 * d * (y[3 + 3 * c + i] + y[15 + 3 * c + i])
                    v0[i] += d * y[27 + 3 * c + i]
                w[i] = 2.0 * g[1] * (after[i] - half[i])
        dissipative(w, v0, g[3], v1, slope)
        scale = lump[k] * g[1]
        for i in range(3):
            f[i] = scale * (v1[i] - v0[i])
        if k == 0:
            for i in range(3):
                force[i] += f[i]
                for j in range(3):
                    block[i, j] += scale * g[1] * slope[i, j]
            continue
        for i in range(3):
            j, m = (i + 1) % 3, (i + 2) % 3
            force[3 + i] += half[j] * f[m] - half[m] * f[j]
        for c in range(3):
            # θ = e_c: δp1 = e_c × p1, δf = λ/Δt² A δp1
            j, m = (c + 1) % 3, (c + 2) % 3
            turned = np.zeros(3)
            turned[j], turned[m] = -after[m], after[j]
            df = np.zeros(3)
            for i in range(3):
                for n in range(3):
                    df[i] += scale * g[1] * slope[i, n] * turned[n]
            for i in range(3):
                p, q = (i + 1) % 3, (i + 2) % 3
                block[3 + i, 3 + c] += 0.5 * (turned[p] * f[q] - turned[q] * f[p]) + half[p] * df[q] - half[q] * df[p]
