"""All the paths that leave one path at its simple bifurcations."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

from directrix.checks import whole
from directrix.controls import ArcLength
from directrix.errors import ModelError
from directrix.keeping import Folder, Many
from directrix.model import Model
from directrix.result import Result
from directrix.statics import solve_static

__all__ = ["branches"]


def branches(
    model: Model,
    *,
    control: ArcLength,
    count: int = 3,
    folder: Folder | str | os.PathLike[str] | None = None,
    **options: Any,
) -> tuple[Result, ...]:
    """Follow a path, then the other path through each of its first ``count`` bifurcations, to both sides.

    Parameters
    ----------
    model
        Rods, supports and loads.
    control
        ``dx.ArcLength(…)``; its ``branch`` leads to the path to begin with, its other settings hold for all paths.
    count
        How many bifurcations at most; those that are multiple are left out, as no single path goes through them.
    folder
        Where the paths are kept, each in a folder of its own in it, as in :func:`directrix.solve_static`.
    options
        For :func:`directrix.solve_static`.

    Returns
    -------
    tuple of Result
        The path itself, then two for every bifurcation, in the order of the path: to the side of its mode and to the
        other. Each holds the way to the bifurcation as well. ``result.plot.branches`` draws them together.

    Raises
    ------
    ModelError
        The model or an argument cannot be right.
    """
    if not isinstance(control, ArcLength):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"control = {control!r} does not follow a path", "use dx.ArcLength(…)", "control=")
    whole(count, "count", 1)
    sides = {"+": 1, "-": -1}
    labels = ["path", *(f"{number}{sign}" for number in range(1, count + 1) for sign in sides)]
    many = None if folder is None else Many.claim(folder, labels, "paths")

    def follow(control: ArcLength, label: str) -> Result:
        return solve_static(model, control=control, folder=None if many is None else many.of(label), **options)

    first = follow(control, "path")
    found = [first]
    points = () if first.stability is None else first.stability.bifurcations
    passed = sum(abs(turn) for turn in control.turns)  # bifurcations where the path was left, and those before
    for number, point in enumerate(points[passed : passed + count], 1):
        if len(point.modes) == 1:
            for sign, side in sides.items():
                if found[-1].status.code == "interrupted":
                    return tuple(found)
                found.append(follow(replace(control, branch=(*control.turns, side * number)), f"{number}{sign}"))
    if many is not None and found[-1].status.code != "interrupted":
        many.say(finished=True)
    return tuple(found)
