"""Equilibria of a model as one of its numbers changes: a load, a length, a stiffness, what is prescribed."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from directrix.bordered import around
from directrix.checks import number, reporting
from directrix.controls import ArcLength
from directrix.discretisation import Discretisation, discretise
from directrix.errors import ConvergenceError, ModelError
from directrix.family import Family, made
from directrix.keeping import Folder, Keeper, fingerprint
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.path import Walk
from directrix.recorder import Progress, Recorder
from directrix.result import Result
from directrix.state import initial_state
from directrix.statics import PATIENCE, solve_static, static_scheme, watch_for
from directrix.threads import one_blas_thread

Array = NDArray[np.float64]

__all__ = ["continuation"]


@one_blas_thread()
def continuation(
    make: Callable[[float], Model],
    begin: float,
    *,
    control: ArcLength,
    steps: int = 10,
    start: Result | None = None,
    save_every: int = 1,
    folder: Folder | str | os.PathLike[str] | None = None,
    tolerance: float = 1e-9,
    threads: int = 1,
    stability: bool | None = None,
    progress: Progress | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """Follow the equilibria of ``make(p)`` under its whole loads while p changes from ``begin``, as an unknown.

    Parameters
    ----------
    make
        Gives the model at a value of the parameter: always the same rods, elements, joints and supports, any numbers.
        Loads act in full; those that are functions, and what is prescribed as a function, are taken at p.
    begin
        Value to start at; the equilibrium there is found by load control in ``steps`` parts, or is ``start``.
    control
        ``dx.ArcLength(…)``: its load factors are values of p, "forward" is towards larger ones at first.
    start
        An equilibrium of ``make(begin)``: the last state of this result.
    save_every, folder, tolerance, threads, stability, progress, raise_on_failure
        As in :func:`directrix.solve_static`.

    Returns
    -------
    Result
        ``load_factor`` (nt,) holds the values of p; displacements count from the reference of ``make(begin)``.

    Raises
    ------
    ModelError
        A model or an argument cannot be right, or a model does not fit the first one.
    """
    begin = number(begin, "begin")
    if not isinstance(control, ArcLength):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"control = {control!r} does not follow a path", "use dx.ArcLength(…)", "control=")
    model = made(make, begin)
    if start is None:
        start = solve_static(model, steps, tolerance=tolerance, threads=threads)
        if start.status.code == "interrupted":
            raise KeyboardInterrupt
        if not start.success:
            raise ModelError(
                f"there is no equilibrium to start from at {begin:g}: {start.status.sentence}",
                "begin where there is one, or give start=",
            )
    scheme = static_scheme(model, None)
    disc = discretise(model, scheme)
    if disc.drives:
        raise ModelError(
            "continuation has no form for actuation, tendons and drag yet", "let them be functions of the load factor"
        )
    x = initial_state(disc, start, scheme)
    newton = Newton(disc, scheme, replace(Settings(tolerance, threads=threads), iterations=PATIENCE))
    family = newton.family = Family(make, disc, scheme)
    watch, unread = watch_for(newton, stability, control)
    recorder = Recorder(disc, "static")
    walk = Walk(newton, control, recorder, save_every, watch)
    near = around(begin)[1]
    asked: dict[str, object] = {
        "begin": begin, "control": control, "tolerance": tolerance, "save_every": save_every, "x": x,
        "stability": watch is not None,
    }  # fmt: skip
    if folder is not None:
        asked["near"] = fingerprint(family.at(near), scheme, {}, (near,))
    here = replace(start, t=start.t[-1:], load_factor=np.array([begin]), r=start.r[-1:], R=start.R[-1:])
    status = walk.begin(x, here)
    keeper = Keeper(folder, recorder, "" if folder is None else fingerprint(disc, scheme, asked, (begin,)))
    if keeper.memory is not None and status is None:
        walk.recall(keeper.memory)
    report = reporting(progress)
    status = status or keeper.attend(lambda: walk.go(report, keeper), lambda: f"{walk.factor:.6g}")
    walk.close()
    info = {
        "formulation": "Directors()", "tolerance": tolerance, "cuts": walk.cuts, "element": repr(scheme.element),
        "control": repr(control), "parameter": "p of a family of models",
        **({"stability": f"not read: {unread}"} if unread else {}),
    }  # fmt: skip
    result = recorder.result(status, walk.ledger.audit(), info, keeper.earlier())
    result = replace(
        _of_its_models(result, [family.at(float(p)) for p in result.load_factor]),
        turning_points=tuple(walk.turning_points), stability=walk.stability,
    )  # fmt: skip
    result = keeper.finish(result)
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result


def _of_its_models(result: Result, discs: Sequence[Discretisation]) -> Result:
    """What follows from a state and its model: each state has its own."""
    force = np.array([d.section_force(e) for d, e in zip(discs, result.strain, strict=True)])
    density = np.array([d.stored_density(e) for d, e in zip(discs, result.strain, strict=True)])
    places = [(result.r[k : k + 1], result.R[k : k + 1]) for k in range(len(discs))]
    links = _side_by_side([d.link_states(r, R) for d, (r, R) in zip(discs, places, strict=True)])
    contacts = _side_by_side([d.contact_states(r) for d, (r, _) in zip(discs, places, strict=True)])
    return replace(result, force=force, density=density, links=links, contacts=contacts)


def _side_by_side(states: Sequence[dict[str, Array]]) -> dict[str, Array]:
    return {name: np.concatenate([state[name] for state in states]) for name in states[0]}
