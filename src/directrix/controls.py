"""What drives a static path in place of the load factor, and what a stopping rule sees of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from directrix.checks import choice, number, text, whole
from directrix.errors import ModelError

if TYPE_CHECKING:
    from directrix.result import Mesh

Array = NDArray[np.float64]

__all__ = ["SMALLEST", "ArcLength", "Control", "DisplacementControl", "NodeState", "Snapshot"]

SMALLEST = 2.0**-12  # of a first step


@dataclass(frozen=True)
class NodeState:
    """A node in one state: ``r`` (3,), ``R`` (3, 3), ``displacement`` (3,), ``reaction`` (6,) force and moment."""

    r: Array
    R: Array
    displacement: Array
    reaction: Array


@dataclass(frozen=True)
class Snapshot:
    """An equilibrium on the path, as ``until=`` sees it.

    ``load_factor``; ``arc_length`` along the path since the start of the run; ``steps`` taken. ``r`` (n, 3),
    ``R`` (n, 3, 3) and ``reaction`` (n, 6) of all nodes; :meth:`node` picks one.
    """

    load_factor: float
    arc_length: float
    steps: int
    mesh: Mesh
    r: Array
    R: Array
    reaction: Array

    def node(self, name: str | int) -> NodeState:
        """One node, by name or index; raises ModelError for an unknown one."""
        k = self.mesh.node(name)
        return NodeState(self.r[k], self.R[k], self.r[k] - self.mesh.r0[k], self.reaction[k])


Until = Callable[[Snapshot], bool]


@dataclass(frozen=True, repr=False)
class ArcLength:
    """Follow the equilibrium path by its own length: the load factor is an unknown and may rise and fall.

    A state is predicted along the tangent t of the path and corrected in the plane normal to it (Riks, 1979):
    ⟨t, x1 − x0⟩ = ds, in the norm of :attr:`Result.arc_length <directrix.Result.arc_length>`, which has the unit of
    a length. A step grows and shrinks with the Newton iterations that the last one took, by at most a factor of
    two; one that fails, or turns the tangent by more than 45°, is halved and tried again. The run ends well when
    ``until`` is true, or after ``max_steps`` when there is no ``until``.

    Parameters
    ----------
    ds
        Length of the first step: root mean square over the nodes of their displacement and turn.
    until
        ``until(snapshot) -> bool``, asked after every step; see :class:`Snapshot`.
    max_steps
        Most steps to take.
    ds_min, ds_max
        Smallest and largest step; ds/4096 and 4 ds unless given.
    iterations
        Newton iterations that a step is meant to take.
    load_factors
        Load factors to stop at on the way: wherever the path crosses one of them, that state is computed and kept.
    direction
        "forward": from the reference with a rising load factor, from ``start=`` onward along its last step;
        "backward": the other way.
    load_step
        Largest change of the load factor in a step, as the slope of the path foretells it; for paths along which next
        to nothing moves, such as that of a straight column.
    branch
        Which bifurcation to leave the path at, counted from the start of the run: 1 takes the other path through the
        first one to the side of its mode, −1 to the other side, 2 and −2 through the second. Several numbers, (1, −1):
        the next count begins on the new path.
    """

    ds: float
    until: Until | None = None
    max_steps: int = 200
    ds_min: float | None = None
    ds_max: float | None = None
    iterations: int = 5
    load_factors: tuple[float, ...] = ()
    direction: Literal["forward", "backward"] = "forward"
    load_step: float | None = None
    branch: int | tuple[int, ...] = ()

    def __post_init__(self) -> None:
        number(self.ds, "ds", above=0.0)
        whole(self.max_steps, "max_steps", 1)
        whole(self.iterations, "iterations", 2, 15)
        choice(self.direction, "direction", ("forward", "backward"))
        low = number(self.ds_min, "ds_min", above=0.0) if self.ds_min is not None else 0.0
        high = number(self.ds_max, "ds_max", above=0.0) if self.ds_max is not None else np.inf
        if not low <= self.ds <= high:
            raise ModelError(
                f"ds = {self.ds:g} is not between ds_min = {low:g} and ds_max = {high:g}",
                "give ds_min <= ds <= ds_max",
            )
        _set(self, "load_factors", _numbers(self.load_factors))
        if self.load_step is not None:
            number(self.load_step, "load_step", above=0.0)
        _set(self, "branch", _turns(self.branch))
        _callable(self.until)

    def __repr__(self) -> str:
        return _shown(self)

    @property
    def turns(self) -> tuple[int, ...]:
        """``branch`` as numbers."""
        return cast("tuple[int, ...]", self.branch)

    @property
    def smallest(self) -> float:
        """Step below which the run gives up."""
        return self.ds_min if self.ds_min is not None else SMALLEST * self.ds

    @property
    def largest(self) -> float:
        """Step that is not exceeded."""
        return self.ds_max if self.ds_max is not None else 4.0 * self.ds


@dataclass(frozen=True, repr=False)
class DisplacementControl:
    """Drive one displacement of one node to a value; the load factor follows and may rise and fall.

    The displacement goes on in ``steps`` equal parts. One that does not converge, or along which the tangent of the
    path turns by more than 45°, is halved, down to 1/4096 of itself; steps grow again after easy ones. Where the
    displacement itself turns back along the path, the run stops and says so: that is for :class:`ArcLength`.

    Parameters
    ----------
    node
        Name of the node.
    component
        "x", "y" or "z".
    to
        Displacement from the reference to reach.
    steps
        Parts of the way, each of them kept.
    until
        ``until(snapshot) -> bool``, asked after every step; see :class:`Snapshot`. Ends the run before ``to``.
    load_factors
        Load factors to stop at on the way: wherever the path crosses one of them, that state is computed and kept.
    """

    node: str
    component: Literal["x", "y", "z"]
    to: float
    steps: int = 10
    until: Until | None = None
    load_factors: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        text(self.node, "node of DisplacementControl")
        choice(self.component, "component", ("x", "y", "z"))
        number(self.to, "to")
        whole(self.steps, "steps", 1)
        _set(self, "load_factors", _numbers(self.load_factors))
        _callable(self.until)

    def __repr__(self) -> str:
        return _shown(self)

    @property
    def column(self) -> int:
        """0, 1 or 2."""
        return "xyz".index(self.component)


Control = ArcLength | DisplacementControl


def _callable(until: object) -> None:
    if until is not None and not callable(until):
        raise ModelError(
            f"until = {until!r} is not a function", "give a function of a snapshot, lambda s: s.load_factor >= 1"
        )


def _numbers(values: Iterable[Any] | Any) -> tuple[float, ...]:
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ModelError(f"load_factors = {values!r} is not a list of numbers", "give e.g. (0.5, 1.0)")
    return tuple(number(v, "an entry of load_factors") for v in values)  # pyright: ignore[reportUnknownVariableType]


def _turns(values: Any) -> tuple[int, ...]:
    if not isinstance(values, (tuple, list)):
        values = (values,)
    for value in cast("tuple[Any, ...]", values):
        if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value == 0:
            raise ModelError(
                f"branch = {value!r} is no number of a bifurcation",
                "give 1 or −1 for the two ways at the first one, 2 or −2 at the second, …",
            )
    return tuple(int(value) for value in cast("tuple[int, ...]", values))


def _shown(control: ArcLength | DisplacementControl) -> str:
    """What was given and is not the default; a function by its name."""
    values = [(f, getattr(control, f.name)) for f in fields(control)]
    given = [f"{f.name}={getattr(v, '__name__', repr(v))}" for f, v in values if v != f.default]
    return f"{type(control).__name__}({', '.join(given)})"


def _set(of: object, name: str, value: object) -> None:
    object.__setattr__(of, name, value)
