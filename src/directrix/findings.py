"""What may be wrong with a model: a value with a sentence and advice, and what the model alone shows."""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from directrix.model import Model

__all__ = ["Finding", "closer", "remarks"]

NEAR = 1e-3  # of the shortest rod: places that near to each other are likely meant to be one
SAME = 1e-9  # of the model's size
SOFT = 1e-10  # of the largest stiffness of its kind
COMPONENTS = ("shear 1", "shear 2", "axial", "bending 1", "bending 2", "torsion")


@dataclass(frozen=True)
class Finding:
    """Something about a model that a user should know.

    ``code``: "free" (a part can move), "loads_hold" (only the tension that loads cause holds it), "slack" (only a cable
    that is slack could hold it), and those of :func:`remarks`. An ``error`` stops a static run. ``what`` is a sentence
    with the names, ``fix`` what to do.
    """

    code: str
    error: bool
    what: str
    fix: str

    def __str__(self) -> str:
        return f"{self.what}\n  fix: {self.fix}"


def remarks(model: Model, *, static: bool) -> tuple[Finding, ...]:
    """What the description alone shows, none of it an error.

    "idle_load": a load on what is held; "idle_velocity" and "idle_dashpot": what statics does not know; "soft": a
    component of a section that is as good as nothing; "no_inertia": sections that turn without inertia about an axis;
    "near": nodes that nearly touch.
    """
    found = [*_idle_loads(model), *_soft(model), *_near(model)]
    found += [*_not_for_statics(model)] if static else [*_no_inertia(model)]
    return tuple(found)


def _note(code: str, what: str, fix: str) -> Finding:
    return Finding(code, False, what, fix)


def _idle_loads(model: Model) -> Iterator[Finding]:
    from directrix.model import DOFS, Force, Moment

    held: dict[str, dict[str, str]] = {}
    for support in model.supports:
        held.setdefault(support.node, {}).update(dict.fromkeys(support.dofs, "a support holds"))
    for given in model.prescribed:
        for value, dofs in ((given.displacement, DOFS[:3]), (given.rotation, DOFS[3:])):
            if value is not None:
                held.setdefault(given.node, {}).update(dict.fromkeys(dofs, "prescribed motion moves"))
    for load in model.loads:
        if not isinstance(load, (Force, Moment)) or load.follower:
            continue
        kind, dofs = ("force", DOFS[:3]) if isinstance(load, Force) else ("moment", DOFS[3:])
        acts = [d for k, d in enumerate(dofs) if callable(load.value) or load.value[k] != 0.0]
        on = held.get(load.node, {})
        hit = [d for d in acts if d in on]
        if not hit or (callable(load.value) and len(hit) < 3):
            continue
        whole = "" if len(hit) < len(acts) else ", and does nothing else"
        yield _note(
            "idle_load",
            f"the {kind} on node {load.node!r} acts on {', '.join(hit)}, which {on[hit[0]]}{whole}: "
            "that goes into the reaction",
            "move the load, or free that component",
        )


def _not_for_statics(model: Model) -> Iterator[Finding]:
    for link in model.links:
        if link.stiffness == 0.0:
            yield _note(
                "idle_dashpot",
                f"link {link.name!r} has damping alone, which statics does not know",
                "give it stiffness=",
            )
    if model.velocities:
        yield _note("idle_velocity", "initial velocities play no part in statics", "use dx.simulate, or leave them out")


def _soft(model: Model) -> Iterator[Finding]:
    for rod in model.rods:
        stiffness = np.diag(rod.section.stiffness)
        for first in (0, 3):
            largest = stiffness[first : first + 3].max()
            for k in range(first, first + 3):
                if stiffness[k] < SOFT * largest:
                    yield _note(
                        "soft",
                        f"the {COMPONENTS[k]} stiffness of rod {rod.name!r} is {stiffness[k] / largest:.1g} of its "
                        "largest of that kind, as good as nothing",
                        "check its units",
                    )


def _no_inertia(model: Model) -> Iterator[Finding]:
    for rod in model.rods:
        inertia = rod.section.I_rho
        least = float(np.linalg.eigvalsh(inertia)[0])
        if np.trace(inertia) > 0.0 and least <= 1e-12 * np.trace(inertia):
            yield _note(
                "no_inertia",
                f"the sections of rod {rod.name!r} have no rotary inertia about one of their axes",
                "give I_rho1= and I_rho2=, both greater than 0",
            )


def closer(points: NDArray[np.float64], reach: float) -> set[tuple[int, int]]:
    """Pairs of points that are no further apart than ``reach``."""
    if len(points) > 500:
        from scipy.spatial import KDTree  # takes longer to load than the pairs of a few points

        return KDTree(points).query_pairs(reach)
    near = np.linalg.norm(points[:, None] - points, axis=2) <= reach
    return {(int(i), int(j)) for i, j in np.argwhere(np.triu(near, 1))}


def _near(model: Model) -> Iterator[Finding]:
    from directrix.model import place_on

    places = {
        name: place_on(rod.curve, f)
        for rod in model.rods
        for name, f in [(rod.ends[0], 0.0), (rod.ends[1], 1.0), *rod.nodes]
    }
    if len(places) < 2:  # lone nodes are where their links and joints want them
        return
    points = np.array(list(places.values()))
    shortest = min(rod.curve.length for rod in model.rods)
    pairs = closer(points, NEAR * shortest)
    names, size = list(places), float(np.ptp(points, axis=0).max())
    joined = {frozenset(pair) for rod in model.rods for pair in combinations(rod.names, 2)}
    joined |= {frozenset((k.a, k.b)) for k in model.links if isinstance(k.b, str)}
    joined |= {frozenset(joint.nodes) for joint in model.joints}
    for i, j in sorted(pairs):
        gap = float(np.linalg.norm(points[i] - points[j]))
        if gap > SAME * size and frozenset((names[i], names[j])) not in joined:
            yield _note(
                "near",
                f"nodes {names[i]!r} and {names[j]!r} are {gap:.3g} apart and not joined",
                "give them one place and one name if they are meant to be joined",
            )
