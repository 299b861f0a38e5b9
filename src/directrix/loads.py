"""Supports, prescribed motion and loads of a model as functions on its numbered nodes."""
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.actuators import value_at
from directrix.checks import number, vector
from directrix.errors import ModelError
from directrix.model import Distributed, Force, Gravity, Model, Pressure, Vec

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
T = TypeVar("T")
Prescribed = tuple[int, Callable[[float], Array] | None, Callable[[float], Array] | None]

__all__ = ["LoadTerm", "Prescribed", "as_function", "driven_joints", "drives_as_loads", "loads_of", "supports_of"]


@dataclass(frozen=True)
class LoadTerm:
    """A load as the solvers see it: ``value(t)`` times ``weights`` on ``nodes``, from column ``first`` on of the loads:
    0 force, 3 moment, 6 following force, 9 following moment. ``weights`` are (nodes, 1) for a vector, (nodes, 3) for a
    number that acts in directions of their own."""

    first: int
    nodes: Ints
    weights: Array
    value: Callable[[float], Array]
    constant: bool
    varies: bool
    label: str


def supports_of(
    model: Model, names: dict[str, int], n: int, dynamic: bool
) -> tuple[NDArray[np.bool_], tuple[Prescribed, ...]]:
    """Components (n, 6) that are held or prescribed, and what is prescribed."""
    fixed = np.zeros((n, 6), bool)
    for support in model.supports:
        for dof in support.dofs:
            fixed[names[support.node], ("x", "y", "z", "rx", "ry", "rz").index(dof)] = True
    prescribed: list[Prescribed] = []
    for given in model.prescribed:
        k = names[given.node]
        functions: list[Callable[[float], Array] | None] = []
        for part, value in ((slice(0, 3), given.displacement), (slice(3, 6), given.rotation)):
            if value is not None:
                fixed[k, part] = True
            what = f"the prescribed {'displacement' if part.start == 0 else 'rotation'} of node {given.node!r}"
            functions.append(None if value is None else as_function(value, not dynamic, what))
        prescribed.append((k, functions[0], functions[1]))
    return fixed, tuple(prescribed)


def driven_joints(model: Model, dynamic: bool) -> tuple[tuple[int, Callable[[float], float]], ...]:
    """Joints with a prescribed coordinate, and that as a function of time (statics: of the load factor)."""
    out: list[tuple[int, Callable[[float], float]]] = []
    for j, joint in enumerate(model.joints):
        if joint.prescribed is not None:
            out.append(
                (j, _scalar(joint.prescribed, not dynamic, f"the prescribed coordinate of joint {joint.name!r}"))
            )
    return tuple(out)


def _scalar(value: float | Callable[[float], object], ramp: bool, what: str) -> Callable[[float], float]:
    if not callable(value):
        given = number(value, what)
        return (lambda t: t * given) if ramp else (lambda t: given)
    return _checked(value, what, "return a number for every t", number)


def _checked(
    value: Callable[[float], object], what: str, fix: str, read: Callable[[object, str], T]
) -> Callable[[float], T]:
    """A user's function; what it raises, and what ``read`` refuses of what it gives, is a ModelError."""

    def checked(t: float) -> T:
        try:
            out = value(t)
        except Exception as error:  # whatever a user's function raises
            raise ModelError(f"{what} fails at t = {t:.6g}: {error!r}", fix) from error
        return read(out, f"{what} at t = {t:.6g}")

    return checked


def drives_as_loads(model: Model, n: int) -> list[LoadTerm]:
    """Drives of joints as loads in the first column of the followers."""
    terms: list[LoadTerm] = []
    for j, joint in enumerate(model.joints):
        if joint.drive is None:
            continue
        what = f"the drive of joint {joint.name!r}"
        value = _scalar(joint.drive, False, what)
        terms.append(
            LoadTerm(
                6, np.array([n + j]), np.ones((1, 1)), lambda t, f=value: np.array([f(t), 0.0, 0.0]), False,
                callable(joint.drive), what,
            )
        )  # fmt: skip
    return terms


def loads_of(
    model: Model, names: dict[str, int], spread: dict[str, tuple[Ints, Array, Array, Array]]
) -> tuple[LoadTerm, ...]:
    """Loads on nodes; ``spread`` has of every rod its nodes, the lengths they stand for, their directors and masses."""
    terms: list[LoadTerm] = []
    for load in model.loads:
        if isinstance(load, Pressure):
            nodes, weights, directors, _ = spread[load.rod]
            side = directors[:, :, int(load.along[-1]) - 1] * (-1.0 if load.along.startswith("-") else 1.0)
            what = f"the pressure on rod {load.rod!r}"
            value = _number_function(load.value, what)
            terms.append(
                LoadTerm(6, nodes, load.width * weights * side, value, load.constant, callable(load.value), what)
            )
            continue
        if isinstance(load, Gravity):
            over = [(spread[rod.name][0], spread[rod.name][3]) for rod in model.rods]
            over += [(np.array([names[body.node]]), np.array([[body.mass]])) for body in model.bodies]
            what, first = "gravity", 0
        elif isinstance(load, Distributed):
            over, what = [spread[load.rod][:2]], f"the distributed load on rod {load.rod!r}"
            first = 6 if load.follower else 0
        else:
            kind = "force" if isinstance(load, Force) else "moment"
            over, what = [(np.array([names[load.node]]), np.ones((1, 1)))], f"the {kind} on node {load.node!r}"
            first = (0 if kind == "force" else 3) + (6 if load.follower else 0)
        value = as_function(load.value, False, what)
        terms += [LoadTerm(first, nodes, w, value, load.constant, callable(load.value), what) for nodes, w in over]
    return tuple(terms)


def as_function(value: Vec | Callable[[float], object], ramp: bool, what: str) -> Callable[[float], Array]:
    if not callable(value):
        given = np.asarray(value, float)
        return (lambda t: t * given) if ramp else (lambda t: given)
    return _checked(value, what, "return three numbers for every t", lambda out, at: np.array(vector(out, at)))


def _number_function(value: float | Callable[[float], ArrayLike], what: str) -> Callable[[float], Array]:
    if not callable(value):
        given = np.array([value])
        return lambda t: given
    return lambda t: value_at(value, 1, what, t)
