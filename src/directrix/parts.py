"""Which parts of a model a run keeps: some rods and nodes, some fields; all of them unless said otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from directrix.checks import choice, shown
from directrix.errors import ModelError

if TYPE_CHECKING:
    from directrix.result import Mesh

Array = NDArray[np.float64]

__all__ = ["FIELDS", "Keep", "Parts"]

FIELDS = ("velocity", "reaction", "force")
BEHIND = {"velocity": {"v": (3,), "Rdot": (3, 3)}, "reaction": {"reaction": (6,)}, "force": {"strain": (6,)}}
FOLLOWS = ("force", "density")
"""What follows from the strains of a whole model."""


@dataclass(frozen=True)
class Keep:
    """What a result holds of a model, so that long runs of large models stay small.

    Energies, momenta, links and contacts are those of the whole model all the same.

    Parameters
    ----------
    parts
        Names of nodes and rods; joints stay when all their nodes do. None: all.
    fields
        Of "velocity", "reaction" and "force" (with the strains); positions and rotations are always kept. What is not
        kept is NaN in the result.
    """

    parts: tuple[str, ...] | None = None
    fields: tuple[str, ...] = FIELDS

    def __post_init__(self) -> None:
        for key in ("parts", "fields"):
            value = cast("object", getattr(self, key))
            if isinstance(value, str):
                raise ModelError(f"{key} = {shown(value)} is one text", f'give several, {key}=("{value}",)', "keep=")
            if value is not None:
                try:
                    object.__setattr__(self, key, tuple(cast("Any", value)))
                except TypeError:
                    raise ModelError(f"{key} = {shown(value)} are no names", "give a tuple of texts", "keep=") from None
        for field in self.fields:
            choice(field, "field to keep", FIELDS)


class Parts:
    """A mesh, and rows of a run, cut down to what is kept."""

    def __init__(self, mesh: Mesh, keep: Keep | None = None) -> None:
        self.all, self.keep = mesh, keep or Keep()
        self.whole = self.keep == Keep()
        n = len(mesh.r0)
        self.nodes = self.joints = np.zeros(0, np.int64)
        self.stations = np.arange(sum(len(rod.stations) for rod in mesh.rods))
        if self.keep.parts is None:
            self.nodes, self.joints, self.mesh = np.arange(n), np.arange(len(mesh.joints)), mesh
            return
        rods = [rod for rod in mesh.rods if rod.name in self.keep.parts]
        known = {rod.name for rod in mesh.rods} | set(mesh.node_names)
        for name in self.keep.parts:
            if name not in known:
                raise ModelError(
                    f"there is no node or rod {shown(name)} to keep", f"there are {', '.join(sorted(known))}", "keep="
                )
        named = [mesh.node_names[name] for name in self.keep.parts if name in mesh.node_names]
        chosen = np.unique(np.concatenate([np.array(named, np.int64), *(rod.nodes for rod in rods)]))
        if not len(chosen):
            raise ModelError("nothing is to be kept", "name a node or a rod, or leave parts= out", "keep=")
        place = np.full(n + 1, -1)  # the last one stands for the ground, −1
        place[chosen] = np.arange(len(chosen))
        ends = mesh.joint_nodes
        here = np.all((ends < 0) | (place[ends] >= 0), axis=1) if len(ends) else np.zeros(0, bool)
        self.nodes, self.joints = chosen, np.flatnonzero(here)
        spans = [np.arange(rod.first_station, rod.first_station + len(rod.stations)) for rod in rods]
        self.stations = np.concatenate([np.zeros(0, np.int64), *spans])
        firsts = np.cumsum([0, *(len(rod.stations) for rod in rods)])
        self.mesh = replace(
            mesh,
            rods=tuple(
                replace(rod, nodes=place[rod.nodes], first_station=int(first))
                for rod, first in zip(rods, firsts[:-1], strict=True)
            ),
            node_names={name: int(place[k]) for name, k in mesh.node_names.items() if place[k] >= 0},
            r0=mesh.r0[chosen],
            joints=tuple(mesh.joints[k] for k in self.joints),
            joint_nodes=place[ends[self.joints]],
            joint_arms=mesh.joint_arms[self.joints],
        )

    @cached_property
    def info(self) -> dict[str, str]:
        """What the result says of it."""
        return {} if self.whole else {"kept": repr(self.keep)}

    def of(self, row: Mapping[str, Array]) -> dict[str, Array]:
        """The kept part of rows (nt, …)."""
        if self.whole:
            return dict(row)
        out = dict(row)
        for name in ("r", "R", "v", "Rdot", "reaction"):
            out[name] = row[name][:, self.nodes]
        for name in ("strain", *FOLLOWS):
            out[name] = row[name][:, self.stations]
        for name in ("history", "joints"):  # what goes on behind the joints is for the whole model only
            out[name] = row[name][:, self.joints]
        for field in FIELDS:
            if field not in self.keep.fields:
                for name in (*BEHIND[field], *(FOLLOWS if field == "force" else ())):
                    del out[name]
        return out

    def names(self) -> list[str]:
        """Fields of a result that rows have; of all of a model without what follows from the others."""
        absent = [name for field in FIELDS if field not in self.keep.fields for name in BEHIND[field]]
        names = ["r", "R", "v", "Rdot", "reaction", "strain", *FOLLOWS, "history", "joints"]
        absent += FOLLOWS if self.whole or "strain" in absent else ()
        return [name for name in names if name not in absent]

    def filled(self, found: Mapping[str, Array], rows: int) -> dict[str, Any]:
        """The fields of a result, NaN where they were not kept."""
        shapes = {name: (len(self.nodes), *shape) for field in FIELDS for name, shape in BEHIND[field].items()}
        shapes |= {name: (len(self.stations), 6) for name in ("strain", "force")} | {"density": (len(self.stations),)}
        absent = {name: np.broadcast_to(np.nan, (rows, *shape)) for name, shape in shapes.items() if name not in found}
        return absent | {name: found[name] for name in ("r", "R", *shapes) if name in found}
