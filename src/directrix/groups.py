"""Elements of one kernel, as arrays: meshes of rods, their parameters, and what is attached to them."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.actuators import Drag
from directrix.basis import gauss, lagrange
from directrix.errors import ModelError
from directrix.formulations.attached import AttachedLayout, BodyElement, LinkElement, TendonElement
from directrix.formulations.element import Committed, Element
from directrix.formulations.layout import Layout
from directrix.model import Model, Rod
from directrix.rotations import smallest_rotation
from directrix.routes import Route
from directrix.scheme import Rates, Scheme

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Group", "attached_groups", "layout_of", "lumped_at_nodes", "mesh_rod", "parameters_of"]


@dataclass(frozen=True)
class Group:
    """Elements that share one kernel: ``conn`` (ne, nn) nodes, ``parameters`` (ne, size),
    ``station`` (ne,) index of their first stress point, ``history`` (ne, 12 rows) in the reference.

    What is attached to rods has ``names``, elements of rods have the names of their rods in ``owners``. A group is
    ``lossy`` when it dissipates by itself, ``works`` when it brings in work, ``grounded`` when the ground holds its
    other end. Interior nodes are ``condensed``, or are unknowns of the system like all others; elements of one node
    are ``inside`` when theirs is an interior one, and come before the rods then. The last nodes of a
    ``jointed`` one are rows of multipliers.
    """

    element: Element
    layout: Layout
    conn: Ints
    parameters: Array
    station: Ints
    history: Array
    names: tuple[str, ...] = ()
    lossy: bool = False
    grounded: bool = False
    works: bool = False
    owners: tuple[str, ...] = ()
    condensed: bool = True
    inside: bool = False
    jointed: bool = False

    @property
    def in_pattern(self) -> Ints:
        """(ne, 0 … nn) nodes that are unknowns of the system."""
        if self.condensed and self.inside:
            return self.conn[:, :0]
        return self.conn[:, [0, -1]] if self.condensed and self.layout.nn > 2 else self.conn


def _boundaries(rod: Rod) -> tuple[Array, list[str]]:
    """Arclengths of the element ends; kinks and named nodes get one, and the sentence that says so."""
    length = rod.curve.length
    wanted = sorted({*rod.curve.breaks, *(f * length for _, f in rod.nodes)})
    uniform = np.linspace(0.0, length, rod.elements + 1)
    if all(np.min(np.abs(uniform - s)) <= 1e-9 * length for s in wanted):
        return uniform, []
    cuts = np.array([0.0, *wanted, length])
    cuts = cuts[np.concatenate(([True], np.diff(cuts) > 1e-9 * length))]
    spans = np.diff(cuts)
    share = spans / length * rod.elements
    counts = np.maximum(1, np.floor(share).astype(int))
    while counts.sum() < rod.elements:
        counts[np.argmax(share - counts)] += 1
    ends = zip(cuts[:-1].tolist(), cuts[1:].tolist(), counts.tolist(), strict=True)
    s = np.concatenate([np.linspace(a, b, k, endpoint=False) for a, b, k in ends])
    lengths = spans / counts
    note = (
        f"rod '{rod.name}': the mesh was fitted to {len(wanted)} kinks or named nodes; "
        f"{counts.sum()} elements between {lengths.min():.4g} and {lengths.max():.4g} long"
    )
    return np.append(s, length), [note]


class _RodArrays(NamedTuple):
    s: Array  # (m,)
    r: Array  # (m, 3)
    directors: Array  # (ne, nn, 3, 3)
    notes: list[str]


def mesh_rod(rod: Rod) -> _RodArrays:
    """Nodes, directors and elements of a rod."""
    ends, notes = _boundaries(rod)
    p, ne = rod.order, len(ends) - 1
    xi = np.linspace(0.0, 1.0, p + 1)
    s = ends[:-1, None] + xi * np.diff(ends)[:, None]
    middle = np.broadcast_to(0.5 * (ends[:-1] + ends[1:])[:, None], s.shape)
    r = rod.curve.position(s)
    directors = rod.curve.frames(s, middle)
    if rod.curve.directors == "chord":
        chord = r[:, -1] - r[:, 0]
        r = r[:, :1] + xi[:, None] * chord[:, None]
        frame = rod.curve.frames(middle[:, 0], middle[:, 0])
        unit = chord / np.linalg.norm(chord, axis=1, keepdims=True)
        frame = smallest_rotation(frame[:, :, 2], unit) @ frame
        directors = np.broadcast_to(frame[:, None], (ne, p + 1, 3, 3))
    nodes = np.append(r[:, :-1].reshape(-1, 3), r[-1, -1:], axis=0)
    return _RodArrays(np.append(s[:, :-1].ravel(), s[-1, -1]), nodes, directors, notes)


def parameters_of(
    rod: Rod, layout: Layout, element: Element, r: Array, directors: Array, lumped: bool, drag: Drag | None = None
) -> tuple[Array, Array, Array]:
    """Element parameters (ne, size) in the order of :class:`Layout`, ∫N_a dS (ne, nn), history (ne, 12 rows).

    ``r`` (ne, nn, 3) reference positions, ``directors`` (ne, nn, 3, 3) with columns d1, d2, d3.
    """
    ne, nn, order = len(r), layout.nn, layout.nn - 1
    section = rod.section

    def speed(points: int) -> tuple[Array, Array, Array]:
        xi, w = gauss(points)
        n, dn = lagrange(order, xi)
        return w, n, np.linalg.norm(np.einsum("ga,eai->egi", dn, r), axis=2)

    _, _, j = speed(layout.points)
    w, n, jm = speed(order + 1)
    weights = np.einsum("g,eg,ga->ea", w, jm, n)
    mass = np.einsum("ea,ab->eab", weights, np.eye(nn)) if lumped else np.einsum("g,eg,ga,gb->eab", w, jm, n, n)
    pairs = mass[:, *np.triu_indices(nn)]
    q = [[list(r[:, a].T)] + [list(directors[:, a, :, i].T) for i in range(3)] for a in range(nn)]
    e0 = element.reference(layout, q, list(1.0 / j.T))
    history = np.zeros((ne, 0))
    if element.rows(layout):
        history = np.stack(cast(Committed, element).initial(layout, q), -1)
    c, inertia = section.stiffness, section.I_rho
    stiff = np.diag(c) if layout.principal else c[np.triu_indices(6)]
    masses = [section.A_rho, inertia[0, 0], inertia[1, 1]] + ([] if layout.principal else [inertia[0, 1]])
    viscous = section.damping
    damping = {"none": np.zeros(0), "principal": np.diag(viscous), "full": viscous[np.triu_indices(6)]}[layout.damping]
    table = [
        # place() reads the components of d_i one director after the other
        directors.transpose(0, 1, 3, 2).reshape(ne, 9 * nn),
        np.broadcast_to(stiff, (ne, len(stiff))),
        1.0 / j,
        np.stack([np.stack(e, -1) for e in e0], 1).reshape(ne, -1),
        pairs,
        np.broadcast_to(masses, (ne, len(masses))),
        np.broadcast_to(damping, (ne, len(damping))),
        jm if layout.sampled else np.zeros((ne, 0)),
        np.zeros((ne, layout.sizes[8])),
    ]
    if drag is not None:
        table += [np.broadcast_to([drag.normal, drag.tangential], (ne, 2)), jm, np.zeros((ne, 6))]
    return np.concatenate(table, axis=1), weights, history


def layout_of(rod: Rod, nn: int, element: Element, model: Model) -> Layout:
    """What kind of element a rod has."""
    section = rod.section
    c, viscous, inertia = section.stiffness, section.damping, section.I_rho
    principal = not np.any(c - np.diag(np.diag(c))) and inertia[0, 1] == 0.0
    damping = "none"
    if np.any(viscous):
        damping = "full" if np.any(viscous - np.diag(np.diag(viscous))) else "principal"
    return Layout(
        nn, rod.points or rod.order, principal, damping, section.law, element.sampled,
        any(a.rod == rod.name for a in model.actuations), any(d.rod == rod.name for d in model.drags),
    )  # fmt: skip


def lumped_at_nodes(n: int, groups: Sequence[Group], model: Model, names: dict[str, int]) -> Array:
    """See :class:`Discretisation`; the mass of the groups must be lumped."""
    out, dyadic = np.zeros((n, 13)), np.zeros((n, 3, 3))
    for group in groups:
        columns: Any = group.parameters.T
        nn = group.layout.nn
        parts: list[Array] = [np.asarray(p).T for p in group.layout.split(columns)]
        directors = parts[0].reshape(-1, nn, 3, 3)  # [element, node, director, component]
        for a in range(nn):
            weight = parts[4][:, a * nn - a * (a - 1) // 2]
            np.add.at(out[:, 0], group.conn[:, a], weight * parts[5][:, 0])
            euler = np.zeros((len(weight), 2, 2))
            euler[:, 0, 0], euler[:, 1, 1] = parts[5][:, 1], parts[5][:, 2]
            if parts[5].shape[1] > 3:
                euler[:, 0, 1] = euler[:, 1, 0] = parts[5][:, 3]
            d = directors[:, a, :2]
            np.add.at(dyadic, group.conn[:, a], np.einsum("e,epq,epi,eqj->eij", weight, euler, d, d))
    for body in model.bodies:
        out[names[body.node], 0] += body.mass
        dyadic[names[body.node]] += body.euler
    values, vectors = np.linalg.eigh(dyadic)
    small = values.max(axis=1, initial=0.0, keepdims=True) * 1e-14
    out[:, 1:4] = np.where(values > small, values, 0.0)
    out[:, 4:] = vectors.transpose(0, 2, 1).reshape(n, 9)
    return out


def attached_groups(
    model: Model, scheme: Scheme, names: dict[str, int], r0: Array, routes: Mapping[str, Route]
) -> tuple[Group, ...]:
    """Links, tendons and bodies as elements of their own; raises ModelError for what the scheme has no form for.

    ``routes`` are the nodes and offsets of the tendons.
    """
    groups: list[Group] = []
    places = {name: r0[k] for name, k in names.items()}
    for grounded, cable in ((True, False), (False, False), (True, True), (False, True)):
        links = [k for k in model.links if k.cable == cable and isinstance(k.b, str) != grounded]
        if not links:
            continue
        rows: list[list[float]] = []
        for link in links:
            if link.damping and scheme.rates is Rates.ALPHA:
                raise ModelError(
                    f"link {link.name!r} is damped, and the generalised-α family has no form for that",
                    "use a step of the midpoint family, e.g. dx.EnergyMomentum(), or leave damping= out",
                )
            rest, width = link.measures(places)
            other = link.offset_b if isinstance(link.b, str) else link.b
            rows.append([*link.offset_a, *other, link.stiffness, rest, link.damping, width])
        ends = [[names[k.a]] if grounded else [names[k.a], names[str(k.b)]] for k in links]
        groups.append(
            _attached(
                LinkElement(scheme.rates, cable), np.array(ends), np.array(rows),
                tuple(f"link {k.name!r}" for k in links),
                not scheme.static and scheme.rates is not Rates.ALPHA and any(k.damping for k in links), grounded,
            )
        )  # fmt: skip
    if model.tendons:
        segments = [(name, route, k) for name, route in routes.items() for k in range(len(route.nodes) - 1)]
        ends = np.array([route.nodes[k : k + 2] for _, route, k in segments])
        offsets = np.array([[*route.offsets[k], *route.offsets[k + 1], 0.0, 0.0] for _, route, k in segments])
        labels = tuple(f"tendon {name!r}" for name, _, _ in segments)
        groups.append(_attached(TendonElement(scheme.rates), ends, offsets, labels, works=True))
    if model.bodies and scheme.rates is Rates.SPIN:
        raise ModelError(
            f"the body on node {model.bodies[0].node!r} has no form in SimoTarnowDoblare()",
            "use another step, e.g. dx.EnergyMomentum()",
        )
    if model.bodies and not scheme.static:
        rows = [[body.mass, *body.euler[np.triu_indices(3)]] for body in model.bodies]
        ends = np.array([[names[body.node]] for body in model.bodies])
        labels = tuple(f"the body on node {body.node!r}" for body in model.bodies)
        groups.append(_attached(BodyElement(scheme.rates), ends, np.array(rows), labels))
    return tuple(groups)


def _attached(
    element: LinkElement | BodyElement | TendonElement, conn: Ints, parameters: Array, names: tuple[str, ...],
    lossy: bool = False, grounded: bool = False, works: bool = False,
) -> Group:  # fmt: skip
    count = len(conn)
    layout = AttachedLayout(conn.shape[1], 0, True, parameters=parameters.shape[1])
    nothing: Ints = np.zeros(count, np.int64)
    return Group(element, layout, conn, parameters, nothing, np.zeros((count, 0)), names, lossy, grounded, works)
