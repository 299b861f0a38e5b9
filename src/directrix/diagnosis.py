"""What is wrong with a model before statics begins, by name: what can move, what is held twice."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation, discretise
from directrix.errors import ModelError
from directrix.findings import Finding
from directrix.formulations.directors import DirectorStep, Rule
from directrix.joint_checks import refuse_joints
from directrix.kernels import step as kernel
from directrix.mechanisms import Cluster, Equations, clusters, equations_of, parts_of, stress_equations
from directrix.model import Model
from directrix.motions import ALIKE, Part, free_motions, largest_nodes
from directrix.newton import Newton, Settings
from directrix.result import Status
from directrix.rotations import log
from directrix.scheme import Scheme
from directrix.state import initial_state, place_supports
from directrix.tangents import whole_tangent
from directrix.touching import join_advice

Array = NDArray[np.float64]
SLACK = 30.0  # widths of its ramp by which a cable is shorter than its length
PUSHED = 1e-9  # of what loads could do: below it they do no work on a motion
STIFFENED = 1e-3  # of the loads over the size of a part: the least stiffness that counts
ROUND_OFF = 1e-14  # of the stiffness times the size of the model: what is no load
NEARBY = 0.5  # of the size of a part: how far an equilibrium under loads may be

__all__ = ["at_start", "examine", "examine_model", "noted", "refuse", "without_inertia"]


def examine_model(model: Model) -> tuple[Finding, ...]:
    """What keeps statics of a model from a definite answer when it starts from the reference."""
    scheme = Scheme(DirectorStep(Rule(static=True)))
    return examine(discretise(model, scheme), scheme)


def examine(disc: Discretisation, scheme: Scheme) -> tuple[Finding, ...]:
    """:func:`at_start` in the reference."""
    newton, x = Newton(disc, scheme, Settings()), initial_state(disc, None, scheme)
    refuse_joints(newton, x)
    return at_start(newton, x, stressed=False)


def at_start(newton: Newton, x: Array, *, stressed: bool) -> tuple[Finding, ...]:
    """What keeps statics from a definite answer when it starts from the state ``x``.

    ``stressed`` says that rods may carry forces there.
    """
    disc = newton.disc
    parts = parts_of(disc, x)
    equations = equations_of(newton, x, parts)
    found: list[Finding] = []
    loose = clusters(parts, equations)
    taut = clusters(parts, [*equations, *stress_equations(newton, x, parts)]) if stressed and loose else loose
    for cluster in loose:
        left = sum(c.free.shape[1] for c in taut if set(c.parts) & set(cluster.parts))
        if left < cluster.free.shape[1]:
            if left:
                found.append(_held_by_tension(disc, cluster, parts))
            continue
        waiting = [joint for joint in _stopped(disc) if joint in cluster.ties]
        if 0 < left <= len(waiting):
            found.append(_until(disc, cluster, waiting, "at a stop", "move the stops"))
            continue
        try:
            found.append(_judge(newton, x, cluster, parts))
        except ModelError:  # a user's function that fails at 1, which the run will say when it is there
            words = _in_words(disc, cluster, " can move freely")
            found.append(Finding("free", True, words, _fix(disc, cluster, parts)))
    if slack := _slack(disc, x):
        known = {part for cluster in loose for part in cluster.parts}
        for cluster in clusters(parts, [e for e in equations if e.name not in slack]):
            if not known & set(cluster.parts):
                at = {parts.index(part) for part in cluster.parts}
                idle = sorted(e.name for e in equations if e.name in slack and at & set(e.parts))
                found.append(_until(disc, cluster, idle, "taut", f"shorten {' and '.join(idle)}"))
    return tuple(found)


def without_inertia(newton: Newton, x: Array) -> tuple[Finding, ...]:
    """Nodes on no rod that can move or turn with neither mass nor stiffness, at a step of dynamics."""
    disc = newton.disc
    if not disc.model.nodes:
        return ()
    parts = parts_of(disc, x)
    equations = equations_of(newton, x, parts)
    bodies = {body.node: body for body in disc.model.bodies}
    for k, part in enumerate(parts):
        if not part.alone:  # a rod has mass, or was refused
            equations.append(Equations((k,), np.eye(6)))
        elif (body := bodies.get(part.members[0])) is not None:
            rows = np.zeros((6, 6))
            rows[:3, :3] = np.eye(3)
            rows[3:, 3:] = body.inertia / max(float(np.abs(body.inertia).max()), 1e-300)
            equations.append(Equations((k,), rows))
    return tuple(
        Finding(
            "no_inertia",
            True,
            f"{_in_words(disc, cluster, ' moves with neither mass nor stiffness')}",
            "give it a body with mass and inertia (.rigid_body), or join it rigidly to what has them",
        )
        for cluster in clusters(parts, equations)
    )


def refuse(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Raise ModelError when one of the findings is an error; the others are given back."""
    errors = [f for f in findings if f.error]
    if errors:
        first, *more = errors
        also = "".join(f"\n  also: {f.what}" for f in more[:5])
        also += f"\n  and {len(more) - 5} more" if len(more) > 5 else ""
        raise ModelError(first.what + also, first.fix)
    return tuple(findings)


def noted(status: Status, findings: Sequence[Finding]) -> Status:
    """The status with what was found before the run."""
    if not findings:
        return status
    said = " ".join(f"Note: {f.what}." for f in findings)
    return Status(status.code, f"{status.sentence} {said}", status.advice)


def _judge(newton: Newton, x: Array, cluster: Cluster, parts: tuple[Part, ...]) -> Finding:
    """Free motions are an error unless the forces that the loads cause hold some of them, near where they are."""
    motions = cluster.nodal(newton.disc.rows)
    fix = _fix(newton.disc, cluster, parts)
    loads, terms = _out_of_balance(newton, x)
    work = np.einsum("nik,ni->k", motions, loads)
    idle = np.linalg.norm(work) <= PUSHED * float(np.einsum("nik,ni->", np.abs(motions), terms))
    stiffness, vectors = np.linalg.eigh(_from_loads(newton, x, loads, motions, cluster))
    push = np.zeros(len(work)) if idle else vectors.T @ work
    size = min(part.size for part in cluster.parts)
    towards = np.abs(push) <= NEARBY * size * np.maximum(stiffness, 0.0)  # an equilibrium is that near
    if np.all(stiffness >= 0.0) and np.any(stiffness > 0.0) and np.all(towards):
        return _held_by_tension(newton.disc, cluster, parts)
    words = _in_words(newton.disc, cluster, " can move freely")
    if not idle:
        words += "; the loads push it that way"
    elif stiffness.min() < 0.0:
        words += "; the loads topple it"
    return Finding("free", True, words, fix)


def _held_by_tension(disc: Discretisation, cluster: Cluster, parts: tuple[Part, ...]) -> Finding:
    words = _in_words(disc, cluster, " is held by nothing but the tension that the loads cause")
    return Finding("loads_hold", False, words, _fix(disc, cluster, parts))


def _out_of_balance(newton: Newton, x: Array) -> tuple[Array, Array]:
    """What pushes (rows, 6) at the state ``x`` once loads, drives and prescribed coordinates act in full, and the size
    of what it is the sum of."""
    disc, work = newton.disc, newton.work
    driven = x.copy()
    place_supports(disc, driven, 1.0)
    driven[: disc.nodes] = x[: disc.nodes]
    applied = newton.applied(driven, disc.external(1.0, 1.0))
    return applied - work.internal, np.abs(applied) + np.abs(work.internal)


def _from_loads(newton: Newton, x: Array, loads: Array, motions: Array, cluster: Cluster) -> Array:
    """Stiffness (k, k) that the loads and the prescribed motion give the free motions, nothing where it does not count.

    The state is moved a little way towards what they do in first order, free motions left out, and back; half the
    difference of the tangents is theirs.
    """
    from scipy.sparse import bmat, csc_matrix, diags
    from scipy.sparse.linalg import splu

    disc = newton.disc
    free = np.flatnonzero(~disc.held.ravel())
    k = motions.shape[2]
    flat = motions.reshape(-1, k)
    tangent = whole_tangent(newton, x)
    given = _prescribed(newton, x)
    push = loads.ravel() - tangent @ given
    kept = csc_matrix(tangent[free][:, free])
    largest = abs(kept).max(axis=1).toarray().ravel()
    if not np.any(np.abs(push[free]) > ROUND_OFF * largest * disc.length):
        return np.zeros((k, k))
    scale = 1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0))
    border = flat[free] / scale[:, None]
    border = csc_matrix(border / np.abs(border).max())
    try:
        system = bmat([[diags(scale) @ kept @ diags(scale), border], [border.T, None]], format="csc")
        answer = splu(system).solve(np.concatenate([scale * push[free], np.zeros(k)]))[: len(free)]
    except RuntimeError:  # something else moves as well
        return np.zeros((k, k))
    step = given.copy()
    step[free] += scale * answer
    step = step.reshape(-1, 6)
    size = max(part.size for part in cluster.parts)
    nodal = np.abs(step[: disc.nodes])
    small = 1e-4 / max(nodal[:, 3:].max(), nodal[:, :3].max() / size, 1e-300)
    seen: list[Array] = []
    for sign in (1.0, -1.0):
        moved = x.copy()
        kernel.move(sign * small * step, disc.nodes, moved, False, False, np.inf)
        seen.append(flat.T @ (whole_tangent(newton, moved) @ flat))
    values, vectors = np.linalg.eigh((seen[0] - seen[1]) / (2.0 * small))
    forces = (tangent @ step.ravel()).reshape(-1, 6) / [1.0, 1.0, 1.0, size, size, size]  # loads and reactions
    forces[disc.nodes :] = 0.0
    least = STIFFENED * float(np.linalg.norm(forces, axis=1).sum() * np.max(np.sum(motions**2, axis=1))) / size
    return (vectors * np.where(np.abs(values) > least, values, 0.0)) @ vectors.T


def _prescribed(newton: Newton, x: Array) -> Array:
    """(6 rows,) displacement and turn that prescribed motion gives nodes by load factor 1."""
    disc = newton.disc
    after = x.copy()
    place_supports(disc, after, 1.0)
    n = disc.nodes
    out = np.zeros((disc.rows, 6))
    before, now = (y[:n, 3:12].reshape(n, 3, 3).swapaxes(-1, -2) for y in (x, after))
    out[:n, :3] = after[:n, :3] - x[:n, :3]
    moved = np.flatnonzero(np.any(before != now, axis=(1, 2)))
    out[moved, 3:] = log(now[moved] @ before[moved].swapaxes(-1, -2))
    return out.ravel()


def _until(disc: Discretisation, cluster: Cluster, names: Sequence[str], state: str, fix: str) -> Finding:
    """Motions that something will stop which does not yet."""
    words = f"{_in_words(disc, cluster, ' can move freely')}, until {' and '.join(names)}"
    said = f"{words} {'is' if len(names) == 1 else 'are'} {state}"
    return Finding("slack", False, said, f"{fix}, or hold the part in another way")


def _stopped(disc: Discretisation) -> list[str]:
    """Labels of joints with stops."""
    return [f"joint {joint.name!r}" for joint in disc.model.joints if joint.stops is not None]


def _in_words(disc: Discretisation, cluster: Cluster, verb: str) -> str:
    """One sentence on what moves how, and where most."""
    if len(cluster.parts) > 1 and cluster.free.shape[1] == 6 and np.linalg.matrix_rank(cluster.free[:6], ALIKE) == 6:
        tied = ", ".join(part.name for part in cluster.parts[1:3]) + (" …" if len(cluster.parts) > 3 else "")
        return f"{cluster.parts[0].name}, and with it {tied},{verb}: in every direction; together they have no support"
    said: list[str] = []
    for part, q in zip(cluster.parts, np.split(cluster.free, len(cluster.parts)), strict=True):
        top = largest_nodes(_far(part, q), part.nodes, disc.mesh)
        where = f", largest at {'node' if len(top) == 1 else 'nodes'} {', '.join(map(repr, top))}"
        if part.alone:
            where = ""
        elif not top:
            where = ", its own axis, along which no node moves"
        elif np.linalg.matrix_rank(q, ALIKE) == 6:
            where = ""
        said.append(f"{part.name}{'' if said else verb}: {free_motions(part, q, disc.mesh)}{where}")
    more = f"; {len(said) - 3} parts more go along" if len(said) > 3 else ""
    return "; with it ".join(said[:3]) + more


def _far(part: Part, q: Array) -> Array:
    """How far (m,) each node goes."""
    return np.linalg.norm((part.moved() @ q)[:, :3], axis=(1, 2))


def _fix(disc: Discretisation, cluster: Cluster, parts: tuple[Part, ...]) -> str:
    for part in cluster.parts[:5]:
        if touching := join_advice(disc, part, parts):
            return touching
    first, q = cluster.parts[0], cluster.free[:6]
    if not np.any(_far(first, q) > ALIKE):
        return "hold two rotations of one of its nodes, that about its axis among them, with .fix, or .clamp a node"
    top = largest_nodes(_far(first, q), first.nodes, disc.mesh)[0]
    place = f"node {top!r}" if top in disc.mesh.node_names else f"{top} (name it with nodes=)"
    return f"hold {place} too (.pin, .fix or .clamp) or tie it with a link; or use dx.simulate"


def _slack(disc: Discretisation, x: Array) -> set[str]:
    """Labels of the cables that are slack at ``x``."""
    n = disc.nodes
    rotation = x[None, :n, 3:12].reshape(1, n, 3, 3).swapaxes(-1, -2)
    states = disc.link_states(x[None, :n, :3], rotation)
    places = {name: disc.mesh.r0[k] for name, k in disc.mesh.node_names.items()}
    out: set[str] = set()
    for link in disc.model.links:
        rest, width = link.measures(places)
        if link.cable and float(states[link.name][0, 0]) < rest - SLACK * width:
            out.add(f"link {link.name!r}")
    return out
