"""What pictures show of a model beside its rods: supports, loads, springs and masses, as values without mechanics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from directrix.functions import Harmonic, Ramp, Table

if TYPE_CHECKING:
    from directrix.model import Model
    from directrix.result import RodMesh

Vec = tuple[float, float, float]

__all__ = ["Mark", "mark_from", "marks_of"]

ARROWS_AT_MOST = 9  # of a pressure along a rod


@dataclass(frozen=True)
class Mark:
    """One sign of a picture.

    ``kind`` is "clamp", "pin", "fix", "prescribe", "force", "moment", "distributed", "pressure", "gravity", "spring" or
    "mass"; ``nodes`` where it sits (of a spring its ends); ``vector`` the direction and size of a load, zero where only
    a function of time knows; ``follower`` says that the vector turns with its node; ``place`` is the other end of a
    spring to the ground; ``text`` what else there is to say, such as the components that a "fix" holds.
    """

    kind: str
    nodes: tuple[int, ...] = ()
    vector: Vec = (0.0, 0.0, 0.0)
    follower: bool = False
    place: Vec | None = None
    text: str = ""


def marks_of(model: Model, names: Mapping[str, int], rods: tuple[RodMesh, ...]) -> tuple[Mark, ...]:
    """The marks of a model whose node names have these indices. No user's function is called."""
    return (*_supports(model, names), *_loads(model, names, rods), *_things(model, names))


def _supports(model: Model, names: Mapping[str, int]) -> list[Mark]:
    held: dict[str, set[str]] = {}
    for support in model.supports:
        held.setdefault(support.node, set()).update(support.dofs)
    marks: list[Mark] = []
    for node, dofs in held.items():
        kind = {6: "clamp"}.get(len(dofs), "pin" if dofs == {"x", "y", "z"} else "fix")
        marks.append(Mark(kind, (names[node],), text=" ".join(sorted(dofs))))
    return marks + [Mark("prescribe", (names[given.node],)) for given in model.prescribed]


def _loads(model: Model, names: Mapping[str, int], rods: tuple[RodMesh, ...]) -> list[Mark]:
    meshes, marks = {rod.name: rod for rod in rods}, list[Mark]()
    for load in model.loads:
        kind, value = type(load).__name__.lower(), _largest(load.value)
        text = "" if np.any(value) else "f(t)"
        if kind == "gravity":
            marks.append(Mark(kind, (), _vec(value)))
        elif kind in ("force", "moment"):
            marks.append(Mark(kind, (names[getattr(load, "node")],), _vec(value), getattr(load, "follower"), text=text))  # noqa: B009
        else:
            mesh, options = meshes[getattr(load, "rod")], vars(load)  # noqa: B009
            if kind == "distributed":
                nodes = tuple(mesh.nodes.tolist())
                marks.append(Mark(kind, nodes, _vec(value), options["follower"], text=text))
                continue
            along, size = options["along"], float(np.ravel(value)[0]) * options["width"]
            side = mesh.directors[:, :, int(along[-1]) - 1] * (-size if along.startswith("-") else size)
            for k in np.unique(np.linspace(0, len(mesh.nodes) - 1, ARROWS_AT_MOST).round().astype(int)):
                marks.append(Mark(kind, (int(mesh.nodes[k]),), _vec(side[k]), True, text=text))
    return marks


def _things(model: Model, names: Mapping[str, int]) -> list[Mark]:
    marks = [Mark("mass", (names[body.node],)) for body in model.bodies]
    for link in model.links:
        ground = None if isinstance(link.b, str) else _vec(link.b)
        ends = (names[link.a], *([names[link.b]] if isinstance(link.b, str) else []))
        marks.append(Mark("spring", ends, place=ground, text="cable" if link.cable else link.name))
    return marks


def _largest(value: Any) -> Any:
    """A value, that of the functions that are known at its largest, zeros of any other function."""
    if isinstance(value, Table):
        values = np.array(value.values, float).reshape(len(value.values), -1)
        return values[np.argmax(np.linalg.norm(values, axis=1))]
    if isinstance(value, Harmonic | Ramp):
        return np.asarray(value.value, float)
    return np.zeros(3) if callable(value) else np.asarray(value, float)


def _vec(value: Any) -> Vec:
    x, y, z = np.asarray(value, float).ravel().tolist()
    return (x, y, z)


def mark_from(said: Mapping[str, Any]) -> Mark:
    """A mark from its fields as JSON gives them."""
    place = None if said["place"] is None else _vec(said["place"])
    nodes = tuple(int(k) for k in said["nodes"])
    return Mark(said["kind"], nodes, _vec(said["vector"]), said["follower"], place, said["text"])
