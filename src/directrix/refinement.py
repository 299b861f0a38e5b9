"""How far a quantity is from what it would be on an infinitely fine mesh and in infinitely short steps."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from directrix.checks import choice, nearest, shown, whole
from directrix.errors import ModelError
from directrix.keeping import Folder, Many
from directrix.model import Model
from directrix.result import Result

__all__ = ["Direction", "Refined", "quantity", "refine", "refined"]

AXES = {"x": 0, "y": 1, "z": 2}
SIX = {"shear1": 0, "shear2": 1, "axial": 2, "bending1": 3, "bending2": 4, "torsion": 5}
LEAST_ORDER, MOST_ORDER = 0.5, 8.0
NOTHING = 1e-10  # of a value: below it differences are what Newton leaves, and tell no order


@dataclass(frozen=True)
class Direction:
    """What refining in one way does: ``values`` on two or three levels, the coarsest first, each twice as fine.

    ``order`` is the observed one, None with two levels; ``error`` estimates how far the coarsest value is off, with the
    order observed or ``assumed``. ``asymptotic`` is False where differences do not shrink as they should: the error is
    then the largest difference seen, and no more than a hint.
    """

    what: str
    values: tuple[float, ...]
    order: float | None
    assumed: float
    error: float
    asymptotic: bool

    @property
    def still(self) -> bool:
        """True when refining changes nothing that could be told from round-off."""
        return float(np.ptp(self.values)) <= NOTHING * max(abs(v) for v in self.values)

    @property
    def sentence(self) -> str:
        """The finding in words."""
        if not self.asymptotic:
            gaps = ", ".join(f"{b - a:.2e}" for a, b in pairwise(self.values))
            return f"not in the asymptotic range (differences {gaps}): {self.error:.2e} or more; refine further"
        if self.still:
            return f"{self.error:.2e} or less, as far as Newton's tolerance lets see"
        if self.order is None:
            return f"about {self.error:.2e}, if the order is {self.assumed:g} (two levels cannot tell)"
        return f"about {self.error:.2e}, order {self.order:.2f} observed"


@dataclass(frozen=True)
class Refined:
    """A quantity and its estimated errors: ``mesh`` for h → h/2, ``step`` for Δt → Δt/2 (None in statics), ``both``."""

    what: str
    value: float
    mesh: Direction
    step: Direction | None
    both: Direction | None

    def __str__(self) -> str:
        lines = [f"{self.what} = {self.value:.9g}"]
        for part in (self.mesh, self.step, self.both):
            if part is not None:
                shown = ", ".join(f"{v:.9g}" for v in part.values)
                lines += [f"  {part.what:<10} {shown}", f"  {'':<10} error {part.sentence}"]
        return "\n".join(lines)


def refine(
    model: Model,
    what: str | Callable[[Result], float],
    *,
    levels: int = 3,
    t_end: float | None = None,
    dt: float | None = None,
    folder: Folder | str | os.PathLike[str] | None = None,
    **options: Any,
) -> Refined:
    """Run a model again with elements half as long, with steps half as long, and with both; estimate the error.

    Parameters
    ----------
    model, t_end, dt, options
        As for ``simulate``; without ``t_end`` as for ``solve_static``.
    what
        A function of the result, or words: ``"node:B:displacement:y"``, ``"rod:mid:force:axial"``, ``"energy:stored"``
        or ``"momentum:angular:z"``, at the end and largest along a rod; with ``":max"`` behind, the largest in time.
    folder
        Where the runs are kept, each in a folder of its own in it: a path, or ``dx.Folder(path, resume=True)``, which
        takes from there what is done.
    levels
        3 observes the order, 2 is cheaper and has to assume it.

    Raises
    ------
    ModelError
        The arguments cannot be right, or a run did not get to its end.
    """
    levels = whole(levels, "levels", 2, 4)
    name = what if isinstance(what, str) else getattr(what, "__name__", "quantity")
    measure = quantity(what) if isinstance(what, str) else what
    if (t_end is None) != (dt is None):
        raise ModelError("t_end and dt belong together", "give both for a motion, none for statics", "t_end=, dt=")
    steps = range(1 if dt is None else levels)
    labels = [f"mesh{k}-step{j}" for k in range(levels) for j in steps if j in (0, k) or k == 0]
    many = None if folder is None else Many.claim(folder, labels)
    known: dict[tuple[int, int], float] = {}

    def value(mesh: int, step: int) -> float:
        if (mesh, step) not in known:
            place = None if many is None else many.of(f"mesh{mesh}-step{step}")
            known[mesh, step] = _value(refined(model, 2**mesh), measure, t_end, None if dt is None else dt / 2**step,
                                       2**step, {**options, "folder": place})  # fmt: skip
        return known[mesh, step]

    order = min((rod.order for rod in model.rods), default=1)
    mesh, step, both = _direction("h", [value(k, 0) for k in range(levels)], 2.0 * order), None, None
    if dt is not None:
        step = _direction("Δt", [value(0, k) for k in range(levels)], 2.0)
        both = _direction("h and Δt", [value(k, k) for k in range(levels)], 2.0)
    if many is not None:
        many.say(finished=True)
    return Refined(name, value(0, 0), mesh, step, both)


def _value(
    model: Model, measure: Callable[[Result], float], t_end: float | None, dt: float | None, finer: int,
    options: Mapping[str, Any],
) -> float:  # fmt: skip
    from directrix.dynamics import simulate
    from directrix.statics import solve_static

    if t_end is None or dt is None:
        result = solve_static(model, **options)
    else:
        more = {**options, "save_every": finer * options.get("save_every", 1)}
        result = simulate(model, t_end, dt, **more)
    if not result.success:
        raise ModelError(f"a run did not get to its end: {result.status.sentence}", "refine or shorten the steps first")
    found = np.asarray(measure(result), float)
    if found.ndim or not np.isfinite(found):
        raise ModelError(f"the quantity is {shown(found)}, which is not a number", "measure one finite number")
    return float(found)


def refined(model: Model, times: int) -> Model:
    """The model with so many times as many elements on every rod."""
    return replace(model, rods=tuple(replace(rod, elements=rod.elements * times) for rod in model.rods))


def _direction(what: str, values: list[float], assumed: float) -> Direction:
    gaps = np.diff(values)
    nothing = NOTHING * max(abs(v) for v in values)
    if np.abs(gaps).max() <= nothing:
        return Direction(what, tuple(values), None, assumed, float(np.abs(gaps).max()), True)
    if len(gaps) == 1:
        error = abs(float(gaps[0])) / (1.0 - 2.0**-assumed)
        return Direction(what, tuple(values), None, assumed, error, True)
    # the two finest gaps tell the order; they must have one sign, and shrink at a rate that orders have
    ratio = float(gaps[-2] / gaps[-1]) if gaps[-1] else np.inf
    order = float(np.log2(ratio)) if ratio > 0.0 and np.isfinite(ratio) else np.nan
    same = bool(np.all(gaps > 0.0) or np.all(gaps < 0.0))
    if not same or not LEAST_ORDER <= order <= MOST_ORDER:
        spread = max(values) - min(values)
        return Direction(what, tuple(values), order if np.isfinite(order) else None, assumed, float(spread), False)
    limit = values[-1] + float(gaps[-1]) / (2.0**order - 1.0)
    return Direction(what, tuple(values), order, assumed, abs(limit - values[0]), True)


def quantity(words: str) -> Callable[[Result], float]:
    """What to measure of a result, in words as in :func:`refine`; raises ModelError for what there is not."""
    parts = words.split(":")
    largest = parts[-1] == "max"
    parts = parts[:-1] if largest else parts
    kind, rest = parts[0], parts[1:]
    sizes = {"node": 3, "rod": 3, "energy": 1, "momentum": 2}
    choice(kind, "kind of quantity", sizes)
    if len(rest) != sizes[kind]:
        raise ModelError(
            f"{words!r} is not a quantity",
            "write e.g. node:B:displacement:y, rod:mid:force:axial:max, energy:stored or momentum:angular:z",
        )

    def component(names: Mapping[str, int]) -> int:
        if rest[-1] not in names:
            raise ModelError(f"{words!r}: there is no component {rest[-1]!r}",
                             f"{nearest(rest[-1], names)}use one of {', '.join(names)}")  # fmt: skip
        return names[rest[-1]]

    reader: Callable[[Result], Any]
    match kind:
        case "node":
            choice(rest[1], "quantity of a node", ("displacement", "r", "v", "reaction"))
            k = component({**AXES, "mx": 3, "my": 4, "mz": 5} if rest[1] == "reaction" else AXES)
            reader = lambda result: getattr(result.node(rest[0]), rest[1])[:, k]  # noqa: E731
        case "rod":
            choice(rest[1], "quantity of a rod", ("force", "strain"))
            k = component(SIX)
            reader = lambda result: getattr(result.rod(rest[0]), rest[1])[:, :, k]  # noqa: E731
        case "energy":
            choice(rest[0], "energy", ("kinetic", "stored", "total", "work", "dissipated"))
            reader = lambda result: getattr(result.energy, rest[0])  # noqa: E731
        case _:
            choice(rest[0], "momentum", ("linear", "angular"))
            k = component(AXES)
            reader = lambda result: getattr(result.momentum, rest[0])[:, k]  # noqa: E731

    def measure(result: Result) -> float:
        values = np.asarray(reader(result), float)
        if largest:
            return float(np.abs(values).max())
        # along a rod the largest: no station of one mesh is a station of a finer one
        return float(values[-1] if values.ndim == 1 else np.abs(values[-1]).max())

    return measure
