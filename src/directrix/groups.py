"""Elements of one kernel, as arrays: meshes of rods, their parameters, and what is attached to them."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from directrix.actuators import Drag
from directrix.basis import at_gauss, gauss
from directrix.curves import Polyline
from directrix.errors import ModelError
from directrix.formulations.attached import AttachedLayout, BodyElement, LinkElement, TendonElement
from directrix.formulations.element import Committed, Element
from directrix.formulations.layout import Layout
from directrix.model import Model, Rod
from directrix.rotations import smallest_rotation
from directrix.routes import Route
from directrix.scheme import Rates, Scheme
from directrix.section import Section

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Group", "RodArrays", "attached_groups", "layout_of", "lumped_at_nodes", "mesh_rods", "parameters_of"]


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


class RodArrays(NamedTuple):
    """Nodes, directors and elements of a rod as it is meshed."""

    s: Array  # (m,)
    r: Array  # (m, 3)
    directors: Array  # (ne, nn, 3, 3)
    notes: list[str]


def mesh_rods(rods: Sequence[Rod]) -> list[RodArrays]:
    """Nodes, directors and elements of rods. Straight ones of as many elements are meshed together."""
    alike: dict[tuple[int, int], list[int]] = {}
    out: list[RodArrays | None] = [None] * len(rods)
    for k, rod in enumerate(rods):
        curve = rod.curve
        if type(curve) is Polyline and len(curve.points) == 2 and not rod.nodes and curve.directors == "tangent":
            alike.setdefault((rod.elements, rod.order), []).append(k)
        else:
            out[k] = _mesh_rod(rod)
    for (elements, order), which in alike.items():
        for k, mesh in zip(which, _mesh_straight([rods[k] for k in which], elements, order), strict=True):
            out[k] = mesh
    return cast("list[RodArrays]", out)


def _mesh_straight(rods: Sequence[Rod], elements: int, order: int) -> Iterator[RodArrays]:
    lengths = np.array([rod.curve.length for rod in rods])
    frames = np.array([rod.curve.frames(0.0, 0.0) for rod in rods])
    first, last = np.array([cast(Polyline, rod.curve).points for rod in rods]).transpose(1, 0, 2)[..., None, :]
    ends = np.linspace(0.0, lengths, elements + 1, axis=-1)
    xi = np.linspace(0.0, 1.0, order + 1)
    s = ends[:, :-1, None] + xi * np.diff(ends)[..., None]
    s = np.concatenate([s[..., :-1].reshape(len(rods), -1), s[:, -1, -1:]], axis=1)
    share = (s / lengths[:, None])[..., None]
    r = first * (1.0 - share) + last * share
    shape = (elements, order + 1, 3, 3)
    for k in range(len(rods)):
        yield RodArrays(s[k], r[k], np.broadcast_to(frames[k], shape), [])


def _mesh_rod(rod: Rod) -> RodArrays:
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
    return RodArrays(np.append(s[:, :-1].ravel(), s[-1, -1]), nodes, directors, notes)


class Parameters(NamedTuple):
    """Of elements: their parameters (ne, size) in the order of :class:`Layout`, ∫N_a dS (ne, nn), ∫A_ρ N_a dS (ne, nn),
    history (ne, 12 rows)."""

    table: Array
    lengths: Array
    masses: Array
    history: Array


def parameters_of(
    rods: Sequence[Rod], layout: Layout, element: Element, s: Sequence[Array], r: Array, directors: Array,
    lumped: bool, drags: Mapping[str, Drag],
) -> Parameters:  # fmt: skip
    """Parameters of all elements of rods that have one layout.

    ``s`` has of every rod the arclengths (ne, nn) of the nodes of its elements, ``r`` (ne, nn, 3) reference positions,
    ``directors`` (ne, nn, 3, 3) with columns d1, d2, d3 of all rods in turn.
    """
    ne, nn, order = len(r), layout.nn, layout.nn - 1
    counts = [len(part) for part in s]

    def speed(points: int) -> tuple[Array, Array, Array]:
        w, (n, dn) = gauss(points)[1], at_gauss(order, points)
        return w, n, np.linalg.norm(np.einsum("ga,eai->egi", dn, r), axis=2)

    _, _, j = speed(layout.points)
    w, n, jm = speed(order + 1)
    weights = np.einsum("g,eg,ga->ea", w, jm, n)
    if layout.varying:
        stiff, viscous, density, masses = _varying(rods, layout, s, np.einsum("g,eg->eg", w, jm))
        shares = np.einsum("g,eg,ga->ea", w, jm * density, n)
        mass = np.einsum("g,eg,ga,gb->eab", w, jm * density, n, n)
    else:
        known = {id(rod.section): rod.section for rod in rods}
        made = {key: _uniform(section, layout) for key, section in known.items()}
        rows = [made[id(rod.section)] for rod in rods]
        stiff, viscous, masses = (np.repeat([row[k] for row in rows], counts, axis=0) for k in range(3))
        shares, mass = weights, np.einsum("g,eg,ga,gb->eab", w, jm, n, n)
    if lumped:
        mass = np.einsum("ea,ab->eab", shares, np.eye(nn))
    pairs = mass[:, *np.triu_indices(nn)]
    q = [[list(r[:, a].T)] + [list(directors[:, a, :, i].T) for i in range(3)] for a in range(nn)]
    e0 = element.reference(layout, q, list(1.0 / j.T))
    history = np.zeros((ne, 0))
    if element.rows(layout):
        history = np.stack(cast(Committed, element).initial(layout, q), -1)
    table = [
        # place() reads the components of d_i one director after the other
        directors.transpose(0, 1, 3, 2).reshape(ne, 9 * nn),
        stiff,
        1.0 / j,
        np.stack([np.stack(e, -1) for e in e0], 1).reshape(ne, -1),
        pairs,
        masses,
        viscous,
        jm if layout.sampled else np.zeros((ne, 0)),
        np.zeros((ne, layout.sizes[8])),
    ]
    if layout.dragged:
        drag = [[drags[rod.name].normal, drags[rod.name].tangential] for rod in rods]
        table += [np.repeat(drag, counts, axis=0), jm, np.zeros((ne, 6))]
    table.append(np.zeros((ne, layout.sizes[10])))
    return Parameters(np.concatenate(table, axis=1), weights, masses[:, :1] * shares, history)


def _uniform(section: Section, layout: Layout) -> tuple[Array, Array, Array]:
    """Stiffness, viscous matrix and inertia of a section as rows of parameters."""
    c, inertia, viscous = section.stiffness, section.I_rho, section.damping
    masses = [section.A_rho, inertia[0, 0], inertia[1, 1]] + ([] if layout.principal else [inertia[0, 1]])
    masses += section.S_rho.tolist() if layout.eccentric else []
    damping = {"none": np.zeros(0), "principal": np.diag(viscous), "full": viscous[np.triu_indices(6)]}[layout.damping]
    return np.diag(c) if layout.principal else c[np.triu_indices(6)], damping, np.array(masses)


def _varying(
    rods: Sequence[Rod], layout: Layout, s: Sequence[Array], weights: Array
) -> tuple[Array, Array, Array, Array]:
    """Of elements whose section varies: matrices at their stress points, mass per length at their inertia points over
    its mean, and the mean inertia. ``weights`` (ne, points) of the inertia points.

    What A_ρ does within an element is exact by that; of I_ρ and S_ρ it is the mean.
    """
    rows: list[list[tuple[Array, Array, Array]]] = []
    inner: list[list[Array]] = []
    order = layout.nn - 1
    for rod, part in zip(rods, s, strict=True):
        for points, found in ((layout.points, rows), (order + 1, inner)):
            at = part @ at_gauss(order, points)[0].T / rod.curve.length
            for element in at.tolist():
                found.append([_uniform(rod.section.at(f), layout) for f in element])  # type: ignore[arg-type]
    stiff, viscous = (np.array([np.concatenate([g[k] for g in row]) for row in rows]) for k in range(2))
    inertia = np.array([[g[2] for g in row] for row in cast("list[list[Any]]", inner)])  # (ne, points, values)
    mean = np.einsum("eg,egk->ek", weights, inertia) / weights.sum(axis=1)[:, None]
    weightless = mean[:, :1] == 0.0
    density = np.where(weightless, 1.0, inertia[..., 0] / np.where(weightless, 1.0, mean[:, :1]))
    return stiff, viscous, density, mean


def layout_of(rod: Rod, nn: int, element: Element, model: Model) -> Layout:
    """What kind of element a rod has."""
    parts = rod.section.parts
    eccentric = rod.section.eccentric
    principal = not eccentric and getattr(rod.section, "function", None) is None and all(
        not np.any(s.stiffness - np.diag(np.diag(s.stiffness))) and s.I_rho[0, 1] == 0.0 for s in parts
    )  # fmt: skip
    damping = "none"
    if any(np.any(s.damping) for s in parts):
        damping = "full" if any(np.any(s.damping - np.diag(np.diag(s.damping))) for s in parts) else "principal"
    return Layout(
        nn, rod.points or rod.order, principal, damping, rod.section.law, element.sampled,
        any(a.rod == rod.name for a in model.actuations), any(d.rod == rod.name for d in model.drags),
        rod.section.varies, eccentric,
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
