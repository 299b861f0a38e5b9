"""Tendons on the mesh, and which schemes have a form for what drives and resists rods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.errors import ModelError
from directrix.formulations.director_acceleration import DirectorAcceleration
from directrix.formulations.directors import DirectorStep
from directrix.model import Model
from directrix.result import RodMesh
from directrix.scheme import Rates, Scheme

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["Route", "refuse_driven", "routes_of"]


class Route(NamedTuple):
    """A tendon on the mesh: nodes (k,), and from each to its point in the reference (k, 3)."""

    nodes: Ints
    offsets: Array


def routes_of(model: Model, names: dict[str, int], rods: Sequence[RodMesh]) -> dict[str, Route]:
    """Where the tendons of a model go."""
    out: dict[str, Route] = {}
    for tendon in model.tendons:
        if not isinstance(tendon.along, str):
            out[tendon.name] = Route(np.array([names[n] for n in tendon.along]), np.array(tendon.offset))
            continue
        (rod,) = (r for r in rods if r.name == tendon.along)
        ends = slice(None, None, rod.order)
        across = np.array([tendon.across(float(s / rod.s[-1])) for s in rod.s[ends]])
        out[tendon.name] = Route(rod.nodes[ends], np.einsum("kij,kj->ki", rod.directors[ends, :, :2], across))
    return out


def refuse_driven(model: Model, scheme: Scheme) -> None:
    """Raise ModelError for actuation, drag and tendons that the scheme has no form for."""
    interpolated = isinstance(scheme.element, (DirectorStep, DirectorAcceleration))
    why = "which carries rotations of its own at the stress points" if not interpolated else ""
    for what, wanted in (
        *((f"actuation of rod {a.rod!r}", interpolated) for a in model.actuations),
        *((f"drag on rod {d.rod!r}", interpolated and scheme.rates is not Rates.ALPHA) for d in model.drags),
        *((f"tendon {t.name!r}", interpolated) for t in model.tendons),
    ):
        if not wanted:
            reason = why or "which balances at the end of a step and has no exact form for it"
            raise ModelError(
                f"the {what} has no form in this scheme, {reason}",
                "use interpolated directors, in motion with a step of the midpoint family, e.g. dx.EnergyMomentum()",
            )
