"""Load control. The loop knows load factors, when to cut and when to stop; the mechanics are elsewhere."""

from __future__ import annotations

import numpy as np

from directrix.audit import StaticBooks
from directrix.checks import choice, whole
from directrix.discretisation import discretise
from directrix.errors import ConvergenceError, ModelError
from directrix.formulations import Directors, refuse_strategies
from directrix.formulations.directors import Rule
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.recorder import Progress, Recorder
from directrix.result import Result, Status
from directrix.state import initial_state, place_supports

__all__ = ["solve_static"]

SMALLEST = 2.0**-12  # of a requested step


def solve_static(
    model: Model,
    steps: int = 10,
    *,
    formulation: Directors | None = None,
    start: Result | None = None,
    save_every: int = 1,
    tolerance: float = 1e-9,
    rotation: str = "exponential",
    progress: Progress | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """Find the equilibria while the load factor goes from 0 to 1 in ``steps`` equal parts.

    A part that does not converge is cut in halves, down to 1/4096 of itself, and the steps grow again after
    easy ones. Loads are multiplied by the load factor unless marked ``constant``; prescribed values ramp with it.

    Parameters
    ----------
    model
        Rods, supports and loads.
    steps
        Parts of the load path that are saved (the cuts between them are not, unless they are the last state).
    formulation
        ``Directors()``.
    start
        Begin at the last state of this result instead of the reference.
    save_every
        Keep every so many parts; the last one is always kept.
    tolerance
        Unbalanced over largest element force at which a state is accepted (never below round-off).
    rotation
        Update of the rotations in an iteration, "exponential" or "cayley"; both reach the same state.
    progress
        Called after each part with the fraction done and a line of text.
    raise_on_failure
        Raise ConvergenceError instead of returning a Result with ``success`` False.

    Raises
    ------
    ModelError
        The model or an argument cannot be right.
    """
    steps, save_every = whole(steps, "steps", 1, 10**9), whole(save_every, "save_every", 1, 10**9)
    choice(rotation, "rotation update", ("exponential", "cayley"))
    refuse_strategies(formulation, progress)
    disc = discretise(model, dynamic=False)
    x = initial_state(disc, start, dynamic=False)
    newton = Newton(disc, Rule(static=True), Settings(tolerance, rotation=rotation))
    recorder = Recorder(disc, "static")
    books = newton.books(x)
    ledger = StaticBooks(disc, books)
    recorder.keep(0.0, 0.0, x[:, :3], x, books, (0.0, 0.0))
    external = disc.external(0.0, 0.0)
    done, reach, cuts, kept = 0.0, 1.0 / steps, 0, 0.0
    status = Status("done", "")
    try:
        while status.success and done < 1.0:
            goal = min(np.floor(done * steps + 1e-9) + 1.0, steps) / steps
            factor = goal if done + reach >= goal * (1.0 - 1e-12) else done + reach
            before = x.copy()
            moved = place_supports(disc, x, factor)
            loads = disc.external(factor, factor)
            outcome = newton.solve(x, loads, moved)
            recorder.iterations.append(outcome.iterations)
            if outcome.status is not None:
                x = before
                reach, cuts = 0.5 * (factor - done), cuts + 1
                if reach < SMALLEST / steps:
                    why = outcome.status
                    status = Status(
                        why.code,
                        f"stopped at load factor {done:.6g}, after {cuts} cuts of the step: {why.sentence}",
                        why.advice,
                    )
                continue
            books = newton.finish(x, loads, external)
            ledger.add(books, x[:, :3], loads)
            external, done = loads, factor
            reach = min(1.0 / steps, 2.0 * reach)
            part = round(done * steps)
            if factor == goal and (part % save_every == 0 or part == steps):
                recorder.keep(done, done, x[:, :3], x, books, (ledger.work, ledger.prescribed))
                kept = done
            if progress is not None:
                progress(done, f"load factor {done:.6g}  {outcome.iterations} iterations")
    except KeyboardInterrupt:
        status = Status("interrupted", f"interrupted at load factor {done:.6g}.", "Go on with start=.")
    except ModelError as error:  # a function of the load factor that fails on the way: keep what there is
        status = Status("bad_input", f"stopped at load factor {done:.6g}: {error.what}.", f"{error.fix}.")
    if kept < done:
        recorder.keep(done, done, x[:, :3], x, books, (ledger.work, ledger.prescribed))
    if status.success:
        cut = f", {cuts} of them cut" if cuts else ""
        status = Status("done", f"reached load factor 1 in {len(recorder.iterations)} steps{cut}.")
    info = {
        "formulation": repr(formulation or Directors()), "steps": steps, "tolerance": tolerance, "cuts": cuts,
        "rotation": rotation,
    }  # fmt: skip
    result = recorder.result(status, ledger.audit(), info)
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result
