"""Nodes on no rod: a rotation that nothing depends on is held, a node that nothing is attached to is refused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from directrix.errors import ModelError
from directrix.groups import Group
from directrix.model import Force, Model, Moment

__all__ = ["idle_rotations", "refuse_loose"]


def idle_rotations(model: Model, static: bool) -> frozenset[str]:
    """Names of nodes whose rotation nothing depends on: a point mass (in statics any body) that is held by links at the
    node itself."""
    turning = {name for rod in model.rods for name in rod.names} | {n for joint in model.joints for n in joint.nodes}
    turning |= {body.node for body in model.bodies if np.any(body.inertia) and not static}
    turning |= {moved.node for moved in model.prescribed if moved.rotation is not None}
    turning |= {
        load.node for load in model.loads if isinstance(load, Moment) or (isinstance(load, Force) and load.follower)
    }
    for link in model.links:
        turning |= {
            node
            for node, offset in ((link.a, link.offset_a), (link.b, link.offset_b))
            if isinstance(node, str) and any(offset)
        }
    return frozenset(node.name for node in model.nodes if node.name not in turning)


def refuse_loose(model: Model, names: dict[str, int], groups: Sequence[Group], fixed: NDArray[np.bool_]) -> None:
    """Raise ModelError for a node that can move and has neither mass nor anything that holds it, and for a model of
    nothing else than nodes."""
    used = {int(k) for group in groups for k in group.conn.ravel()}
    for node in model.nodes:
        if names[node.name] not in used and not fixed[names[node.name]].all():
            raise ModelError(
                f"nothing is attached to node {node.name!r}, which can move",
                "give it a link, a joint or a support, in dynamics a body, or leave it out",
            )
    if not groups:
        raise ModelError(f"{model.name}: nothing in it can move", "add a rod, or a body on a node that is not held")
