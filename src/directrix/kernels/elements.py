"""Loops over elements: gather lanes, call the kernel, condense interior nodes, scatter.

``tables`` (see :class:`directrix.kernels.tables.Tables`) are flat arrays for all groups of equal elements;
``x`` (≥ n, 40) holds per node (r1, R1), (Δr, R0) and the rate, twelve numbers each, and behind the nodes the rows of
history. ``external`` (n, 12) are forces and moments on the nodes, dead ones (6) and followers (6) in the node's frame.
"""
# pyright: basic, reportCallIssue=false

from directrix.formulations.element import FLOWS
from directrix.kernels.call import add_block, call_kernel
from directrix.kernels.compile import LANES
from directrix.kernels.jit import compiled, inner
from directrix.kernels.nodes import nodal_terms, orthonormal
from directrix.kernels.rates import NONE

__all__ = [
    "acts", "assemble", "books", "books_of", "commit", "element_tangents", "ground", "internal_forces", "lost",
    "right_side",
]  # fmt: skip

COORDINATE = 6  # place in the row of a joint
# columns of tables.head
(
    STEP, RESIDUAL, AUDIT, COMMIT, LOST, ACTS, NN, COUNT, CONN, PAR, SIZE, POINTS, ELEMENT, BACK, AT, ROWS, HISTORY,
    GROUND, DEST, UNKNOWN,
) = range(20)  # fmt: skip


@inner
def _scatter(out, at, conn, first, nn, internal):
    """Forces of one element, 6 nn from ``out[at]`` on, onto its nodes ``conn[first:]``; all arrays flat.

    Here and below places are counted, not sliced: a slice costs more than what is done with it.
    """
    for a in range(nn):
        to = 6 * conn[first + a]
        for i in range(6):
            internal[to + i] += out[at + 6 * a + i]


@inner
def _add_blocks(out, at, dest, first, count, blocks):
    """``count`` blocks of 36 from ``out[at]`` on, onto blocks ``dest[first:]``; all arrays flat."""
    for b in range(count):
        add_block(blocks, 36 * dest[first + b], out, at + 36 * b)


@inner
def _condense(k, r, nn, eliminated, back, kept):
    """Eliminate the interior nodes 1 … nn−2 of an element matrix ``k`` with right-hand side ``r``.

    ``k`` (6nn, 6nn) and ``r`` (6nn,) are overwritten: rows of the end nodes get the Schur complement.
    ``back`` (6(nn−2), 13): the interior increment is back[:, 12] − back[:, :12] · (end increments).
    ``kept`` (6(nn−2), ≥ 6(nn−2) + 12), where it has rows, receives what another right-hand side needs: the inverse of
    the interior block, and what couples the end nodes with it, transposed.
    Returns the row of a vanishing pivot, or −1.
    """
    m = 6 * (nn - 2)
    last = 6 * (nn - 1)
    inverse = m if kept.shape[0] > 0 else 0
    for i in range(m):
        for c in range(6):
            back[i, c] = k[6 + i, c]
            back[i, 6 + c] = k[6 + i, last + c]
        back[i, 12] = r[6 + i]
        for j in range(m):
            eliminated[i, j] = k[6 + i, 6 + j]
        for j in range(inverse):
            eliminated[i, m + j] = 1.0 if i == j else 0.0
    for p in range(m):
        best, at = abs(eliminated[p, p]), p
        for i in range(p + 1, m):
            if abs(eliminated[i, p]) > best:
                best, at = abs(eliminated[i, p]), i
        if not best > 0.0:
            return p
        if at != p:
            for c in range(m + inverse):
                eliminated[p, c], eliminated[at, c] = eliminated[at, c], eliminated[p, c]
            for c in range(13):
                back[p, c], back[at, c] = back[at, c], back[p, c]
        f = 1.0 / eliminated[p, p]
        for c in range(p, m + inverse):
            eliminated[p, c] *= f
        for c in range(13):
            back[p, c] *= f
        for i in range(m):
            if i != p:
                f = eliminated[i, p]
                for c in range(p, m + inverse):
                    eliminated[i, c] -= f * eliminated[p, c]
                for c in range(13):
                    back[i, c] -= f * back[p, c]
    for i in range(inverse):
        for j in range(m):
            kept[i, j] = eliminated[i, m + j]
        for c in range(6):
            kept[i, m + c], kept[i, m + 6 + c] = k[c, 6 + i], k[last + c, 6 + i]
    for end in range(2):
        for i in range(6):
            row = end * last + i
            for j in range(m):
                f = k[row, 6 + j]
                for c in range(6):
                    k[row, c] -= f * back[j, c]
                    k[row, last + c] -= f * back[j, 6 + c]
                r[row] -= f * back[j, 12]
    return -1


@compiled
def assemble(tables, work, x, g, external, mask, frozen):
    """Residual and tangent of the whole system, interior nodes condensed, supports applied.

    Fills ``work.internal`` (n, 6), ``work.blocks`` and ``work.rhs`` = −(internal − external) on the free
    components. ``frozen`` also holds all rotations. Returns the element of a vanishing interior pivot, or −1.
    """
    internal, blocks, rhs, applied = work.internal, work.blocks, work.rhs, work.applied
    blocks[:] = 0.0
    rhs[:] = 0.0
    by_nodes = nodal_terms(tables, work, x, g, external)
    flat_internal, flat_blocks, out = internal.reshape(-1), blocks.reshape(-1), work.out
    flat_inside = work.node_block.reshape(-1)
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        nn, ne = head[NN], head[COUNT]
        nd = 6 * nn
        last = nd - 6
        stride = -(-(nd + nd * nd) // LANES) * LANES
        for block in range(-(-ne // LANES)):
            first, count = block * LANES, min(LANES, ne - block * LANES)
            parameters, places = head[PAR] + block * LANES * head[SIZE], head[AT] + block * LANES * (nn + head[ROWS])
            call_kernel(head[STEP], x, tables.at, places, tables.par, parameters, g, out)
            for lane in range(count):
                e, from_ = first + lane, lane * stride
                _scatter(out, from_, tables.conn, head[CONN] + e * nn, nn, flat_internal)
                if head[UNKNOWN] == nn:
                    _add_blocks(out, from_ + nd, tables.dest, head[DEST] + e * nn * nn, nn * nn, flat_blocks)
                elif nn == 1:  # on an interior node, which goes with the element of the rod
                    add_block(flat_inside, 36 * tables.conn[head[CONN] + e], out, from_ + nd)
                else:
                    conn = tables.conn[head[CONN] + e * nn : head[CONN] + (e + 1) * nn]
                    to = tables.dest[head[DEST] + 4 * e : head[DEST] + 4 * e + 4]
                    k, r = work.k, work.r
                    for b in range(nn):
                        for a in range(nn):
                            at = from_ + nd + 36 * (nn * b + a)
                            for i in range(6):
                                for j in range(6):
                                    k[6 * a + i, 6 * b + j] = out[at + 6 * i + j]
                    for i in range(6, last):
                        node = conn[i // 6]
                        r[i] = applied[node, i % 6] - internal[node, i % 6]
                        if by_nodes:
                            for j in range(6):
                                k[i, 6 * (i // 6) + j] += work.node_block[node, i % 6, j]
                        if frozen and i % 6 > 2:
                            r[i] = 0.0
                            for j in range(nd):
                                k[i, j] = 0.0
                            k[i, i] = 1.0
                    for i in range(6):
                        r[i] = 0.0
                        r[last + i] = 0.0
                    m = 6 * (nn - 2)
                    back = work.back[head[BACK] + e * m : head[BACK] + (e + 1) * m]
                    at = min(head[BACK] + e * m, work.kept.shape[0])
                    kept = work.kept[at : min(at + m, work.kept.shape[0])]
                    if _condense(k, r, nn, work.eliminated, back, kept) >= 0:
                        return head[ELEMENT] + e
                    for i in range(6):
                        rhs[tables.row[conn[0]], i] += r[i]
                        rhs[tables.row[conn[nn - 1]], i] += r[last + i]
                        for j in range(6):
                            blocks[to[0], i, j] += k[i, j]
                            blocks[to[1], i, j] += k[last + i, j]
                            blocks[to[2], i, j] += k[i, last + j]
                            blocks[to[3], i, j] += k[last + i, last + j]
    for node in range(external.shape[0]):
        row = tables.row[node]
        if row < 0:
            continue
        for i in range(6):
            if mask[node, i] or (frozen and i > 2):
                rhs[row, i] = 0.0
                for b in range(tables.rowptr[row], tables.rowptr[row + 1]):
                    for j in range(6):
                        blocks[b, i, j] = 0.0
                blocks[tables.diagonal[row], i, i] = 1.0
            else:
                rhs[row, i] += applied[node, i] - internal[node, i]
                if by_nodes:
                    for j in range(6):
                        blocks[tables.diagonal[row], i, j] += work.node_block[node, i, j]
    return -1


@compiled
def right_side(tables, work, mask):
    """``work.rhs`` and what interior nodes take, as :func:`assemble` has them, with the forces of
    :func:`internal_forces` and the tangent that was assembled last."""
    internal, rhs, applied = work.internal, work.rhs, work.applied
    rhs[:] = 0.0
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        nn = head[NN]
        m = 6 * (nn - 2)
        for e in range(head[COUNT] if nn > 2 and nn > head[UNKNOWN] else 0):
            conn = tables.conn[head[CONN] + e * nn : head[CONN] + (e + 1) * nn]
            a, b = tables.row[conn[0]], tables.row[conn[nn - 1]]
            first = head[BACK] + e * m
            for i in range(m):
                s = 0.0
                for j in range(m):
                    node = conn[1 + j // 6]
                    s += work.kept[first + i, j] * (applied[node, j % 6] - internal[node, j % 6])
                work.back[first + i, 12] = s
                for c in range(6):
                    rhs[a, c] -= work.kept[first + i, m + c] * s
                    rhs[b, c] -= work.kept[first + i, m + 6 + c] * s
    for node in range(applied.shape[0]):
        row = tables.row[node]
        if row >= 0:
            for i in range(6):
                if mask[node, i]:
                    rhs[row, i] = 0.0
                else:
                    rhs[row, i] += applied[node, i] - internal[node, i]


@compiled
def element_tangents(tables, work, x, g, group, out):
    """Tangents (ne, 6 nn, 6 nn) of a group of elements, nothing condensed and nothing held."""
    head = tables.head[group]
    nn, ne = head[NN], head[COUNT]
    nd = 6 * nn
    stride = -(-(nd + nd * nd) // LANES) * LANES
    for block in range(-(-ne // LANES)):
        first, count = block * LANES, min(LANES, ne - block * LANES)
        parameters, places = head[PAR] + block * LANES * head[SIZE], head[AT] + block * LANES * (nn + head[ROWS])
        call_kernel(head[STEP], x, tables.at, places, tables.par, parameters, g, work.out)
        for lane in range(count):
            for b in range(nn):
                for a in range(nn):
                    at = lane * stride + nd + 36 * (nn * b + a)
                    for i in range(6):
                        for j in range(6):
                            out[first + lane, 6 * a + i, 6 * b + j] = work.out[at + 6 * i + j]


@compiled
def internal_forces(tables, work, x, g, external):
    """Residual alone: ``work.internal`` and ``work.applied`` (n, 6); ``work.scale``, the largest force and moment of
    an element."""
    internal, scale, out = work.internal, work.scale, work.out
    nodal_terms(tables, work, x, g, external)
    force = moment = 0.0
    flat = internal.reshape(-1)
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        nn, ne = head[NN], head[COUNT]
        stride = -(-6 * nn // LANES) * LANES
        for block in range(-(-ne // LANES)):
            first, count = block * LANES, min(LANES, ne - block * LANES)
            parameters, places = head[PAR] + block * LANES * head[SIZE], head[AT] + block * LANES * (nn + head[ROWS])
            call_kernel(head[RESIDUAL], x, tables.at, places, tables.par, parameters, g, out)
            for lane in range(count):
                at = lane * stride
                _scatter(out, at, tables.conn, head[CONN] + (first + lane) * nn, nn, flat)
                for a in range(nn):
                    for i in range(at + 6 * a, at + 6 * a + 3):
                        force, moment = max(force, abs(out[i])), max(moment, abs(out[i + 3]))
    scale[0], scale[1] = force, moment


@inner
def commit(tables, work, x, g):
    """Write the history at the end of a step; rotations in it stay orthonormal."""
    out = work.out
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        rows, ne = head[ROWS], head[COUNT]
        if rows == 0:
            continue
        stride = -(-12 * rows // LANES) * LANES
        for block in range(-(-ne // LANES)):
            first, count = block * LANES, min(LANES, ne - block * LANES)
            parameters = head[PAR] + block * LANES * head[SIZE]
            places = head[AT] + block * LANES * (head[NN] + rows)
            call_kernel(head[COMMIT], x, tables.at, places, tables.par, parameters, g, out)
            for lane in range(count):
                for k in range(rows):
                    at = lane * stride + 12 * k
                    orthonormal(out[at : at + 9])
                    to = head[HISTORY] + (first + lane) * rows + k
                    for i in range(12):
                        x[to, i] = out[at + i]


@inner
def lost(tables, work, x, g):
    """Add what elements took in the step to ``work.taken`` and what was done on them to ``work.done``, by source, and
    the forces and moments on them from outside to ``work.ground``."""
    stride = -(-FLOWS // LANES) * LANES
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        if head[LOST] == 0:
            continue
        for block in range(-(-head[COUNT] // LANES)):
            count = min(LANES, head[COUNT] - block * LANES)
            parameters = head[PAR] + block * LANES * head[SIZE]
            places = head[AT] + block * LANES * (head[NN] + head[ROWS])
            call_kernel(head[LOST], x, tables.at, places, tables.par, parameters, g, work.out)
            for lane in range(count):
                at, e = lane * stride, head[ELEMENT] + block * LANES + lane
                for k in range(2):
                    source = tables.source[e, k]
                    if source >= 0:
                        work.taken[source] += work.out[at + 8 * k]
                        work.done[source] += work.out[at + 8 * k + 1]
                for i in range(6):
                    work.ground[i] += work.out[at + 2 + i]


@inner
def ground(tables, work, x, g):
    """Fill ``work.ground`` (6,): Σ force and Σ moment about the origin that the ground exerts through links."""
    total, out = work.ground, work.out
    total[:] = 0.0
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        if head[GROUND] == 0:
            continue
        for block in range(-(-head[COUNT] // LANES)):
            first, count = block * LANES, min(LANES, head[COUNT] - block * LANES)
            parameters = head[PAR] + block * LANES * head[SIZE]
            nn = head[NN]
            places = head[AT] + block * LANES * (nn + head[ROWS])
            call_kernel(head[RESIDUAL], x, tables.at, places, tables.par, parameters, g, out)
            for lane in range(count):
                node, at = tables.conn[head[CONN] + (first + lane) * nn], lane * (-(-6 * nn // LANES) * LANES)
                for i in range(3):
                    j, k = (i + 1) % 3, (i + 2) % 3
                    total[i] -= out[at + i]
                    y, z = x[node, j], x[node, k]
                    if tables.half:
                        y, z = y - 0.5 * x[node, 12 + j], z - 0.5 * x[node, 12 + k]
                    total[3 + i] -= out[at + 3 + i] + y * out[at + k] - z * out[at + j]


@inner
def acts(tables, work, x, g):
    """Fill ``work.joints`` (joints, 12), see :meth:`Jointed.acts`, the forces of the step before at the end; the work
    of drives and of prescribed motion, for which statics take the mean of both ends of a step. Their rows of ``x`` keep
    the coordinate."""
    driven, prescribed, out = 0.0, 0.0, work.out
    stride = -(-10 // LANES) * LANES
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        if head[ACTS] == 0:
            continue
        nn = head[NN]
        for block in range(-(-head[COUNT] // LANES)):
            first, count = block * LANES, min(LANES, head[COUNT] - block * LANES)
            parameters, places = head[PAR] + block * LANES * head[SIZE], head[AT] + block * LANES * nn
            call_kernel(head[ACTS], x, tables.at, places, tables.par, parameters, g, out)
            for lane in range(count):
                row = tables.conn[head[CONN] + (first + lane) * nn + nn - 1] - tables.nodes
                at, own = lane * stride, work.joints[row]
                for i in range(10):
                    own[i] = out[at + i]
                share = 0.5 if tables.rates == NONE else 1.0
                prescribed += (share * own[8] + (1.0 - share) * own[10]) * own[7]
                driven += (share * own[9] + (1.0 - share) * own[11]) * own[7]
                own[10], own[11] = own[8], own[9]
                x[tables.nodes + row, COORDINATE] = own[6]
    return driven, prescribed


@compiled
def books(tables, work, x, totals, strains):
    """Audit of a state (x1 and the rate): fills ``strains`` (stations, 6) and ``totals``.

    ``totals``: stored, kinetic, L (3), J (3), smallest Σ_i d_i·d_i between neighbouring nodes and its element,
    largest squared loss of orthonormality at a stress point.
    """
    totals[:] = 0.0
    totals[8] = 3.0
    out = work.out
    for group in range(tables.head.shape[0]):
        head = tables.head[group]
        nn, ne, points = head[NN], head[COUNT], head[POINTS]
        stride = -(-(7 + nn + 7 * points) // LANES) * LANES
        for block in range(-(-ne // LANES)):
            first, count = block * LANES, min(LANES, ne - block * LANES)
            parameters, places = head[PAR] + block * LANES * head[SIZE], head[AT] + block * LANES * (nn + head[ROWS])
            call_kernel(head[AUDIT], x, tables.at, places, tables.par, parameters, work.common, out)
            for lane in range(count):
                e = first + lane
                at = lane * stride
                for c in range(8):
                    totals[c] += out[at + c]
                for c in range(8, 7 + nn):
                    if out[at + c] < totals[8]:
                        totals[8] = out[at + c]
                        totals[9] = head[ELEMENT] + e
                at += 7 + nn
                for point in range(points):
                    totals[10] = max(totals[10], out[at])
                    for c in range(6):
                        strains[tables.station[head[ELEMENT] + e] + point, c] = out[at + 1 + c]
                    at += 7


@compiled
def books_of(tables, work, states, totals, strains):
    """:func:`books` of ``states`` (k, ≥ n, 40): ``totals`` (k, 11), ``strains`` (k, stations, 6)."""
    for k in range(states.shape[0]):
        books(tables, work, states[k], totals[k], strains[k])
