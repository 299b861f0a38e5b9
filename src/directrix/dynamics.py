"""Time stepping. The loop knows states, times and when to save or stop; the mechanics are elsewhere."""

from __future__ import annotations

import os
from typing import Any, Literal

from directrix.audit import DynamicBooks
from directrix.checks import choice, number, reporting, shown, step_count, whole
from directrix.diagnosis import refuse, without_inertia
from directrix.discretisation import discretise
from directrix.errors import ConvergenceError, ModelError
from directrix.failures import explained
from directrix.fast import fast_for
from directrix.formulations import refuse_strategies
from directrix.integrators import EnergyMomentum, Formulation, Integrator
from directrix.joint_checks import refuse_joints
from directrix.keeping import Folder, Keeper, RunFolder, fingerprint
from directrix.linear.petsc import Petsc
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.parts import Keep, Parts
from directrix.recorder import Progress, Recorder
from directrix.result import Result, Status
from directrix.scheme import Rates
from directrix.state import has_history, initial_state, place_supports
from directrix.threads import one_blas_thread

__all__ = ["refuse_damping", "simulate"]


@one_blas_thread()
def simulate(
    model: Model,
    t_end: float,
    dt: float,
    *,
    integrator: Integrator | None = None,
    formulation: Formulation | None = None,
    load_rule: Literal["midpoint", "average"] = "midpoint",
    start: Result | None = None,
    save_every: int = 1,
    keep: Keep | None = None,
    folder: Folder | RunFolder | str | os.PathLike[str] | None = None,
    tolerance: float = 1e-9,
    threads: int = 1,
    linear: Petsc | str | None = None,
    progress: Progress | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """Integrate the motion from t = 0 (or from ``start``) to ``t_end`` in equal steps.

    Parameters
    ----------
    model
        Rods with mass, supports, loads, initial velocities.
    t_end, dt
        End and step; ``t_end`` must be a whole number of steps away.
    integrator
        ``EnergyMomentum()`` (default), ``Midpoint()``, ``EnergyDissipating(..)``, ``GeneralizedAlpha(rho_inf)``,
        ``HilberHughesTaylor(alpha)``, ``Newmark(..)``, ``SimoTarnowDoblare()``.
    formulation
        The one that the integrator works with, ``Directors()`` for most; any other is refused.
    load_rule
        A load acts over a step with its value at t½ ("midpoint") or the mean of its end values ("average");
        the generalised-α family takes its value at the end of the step.
    start
        Go on from the last instant of this result, at its time if it is dynamic and at t = 0 if static.
    save_every
        Keep every so many steps; the last one is always kept.
    keep
        Which rods, nodes and fields: ``dx.Keep(…)``; all unless given.
    folder
        Where the run is kept while it goes on: a path, or ``dx.Folder(path, resume=True)`` to go on with a run that was
        killed or interrupted, to the same digits. The result is written there in the end.
    tolerance
        Unbalanced over largest element force at which a step is accepted (never below round-off).
    threads
        How many threads share the work on a frame of many junctions; no bit of the result depends on it.
    linear
        "petsc", or ``dx.Petsc(…)``, for frames that go beyond one machine; None is SciPy and LAPACK.
    progress
        Called after each step with the fraction done and a line of text. What it raises ends the run, which is kept.
    raise_on_failure
        Raise ConvergenceError instead of returning a Result with ``success`` False.

    Raises
    ------
    ModelError
        The model or an argument cannot be right.
    """
    integrator = EnergyMomentum() if integrator is None else integrator
    _refuse(formulation, integrator, load_rule)
    refuse_strategies(formulation, progress)
    save_every = whole(save_every, "save_every", 1, 10**9)
    t_end, dt = number(t_end, "t_end"), number(dt, "dt", above=0.0)
    refuse_damping(model, integrator)
    t0 = float(start.t[-1]) if isinstance(start, Result) and start.kind == "dynamic" else 0.0
    steps = step_count(t0, t_end, dt)
    scheme = integrator.scheme(dt)
    disc = discretise(model, scheme)
    x = initial_state(disc, start, scheme)
    newton = Newton(disc, scheme, Settings(tolerance, threads=threads, linear=Petsc.of(linear)))
    newton.driver.place(t0, 1.0)
    newton.driver.shift()
    place_supports(disc, x, t0)
    refuse_joints(newton, x, fresh=start is None or start.kind == "static")
    refuse(without_inertia(newton, x))
    external = disc.external(t0)
    ends = scheme.rates is Rates.ALPHA
    if ends and not has_history(start, scheme):
        newton.accelerate(x, external)
    acting = newton.applied(x, external)
    recorder = Recorder(disc, "dynamic", Parts(disc.mesh, keep))
    books = newton.books(x)
    ledger = DynamicBooks(disc, integrator, books, dt)
    recorder.keep(t0, 1.0, newton.positions(x), x, books, ledger.flows)
    steady = not any(load.varies for load in disc.loads)
    before, report = t0, reporting(progress)
    unsaved = None
    fast = fast_for(newton)
    k = saved = 0
    settings = {
        "t0": t0, "dt": dt, "integrator": integrator, "load_rule": load_rule, "tolerance": tolerance,
        "save_every": save_every, "keep": keep, "x": x,
    }  # fmt: skip
    keeper = Keeper(folder, recorder, fingerprint(disc, scheme, settings, (t0, t0 + dt)))

    def memory() -> dict[str, Any]:
        return {
            "k": k, "saved": saved, "x": x, "acting": acting, "newton": newton.remember(), "ledger": ledger.remember(),
            "fast": None if fast is None else fast.remember(),
        }  # fmt: skip

    if keeper.memory is not None:
        past = keeper.memory
        k, saved, x, acting = past["k"], past["saved"], past["x"], past["acting"]
        books = newton.recall(past["newton"])
        ledger.recall(past["ledger"])
        if fast is not None:
            fast.recall(past["fast"])
        before = t0 + k * dt
        if k > steps:
            raise ModelError(f"the run has reached t = {before:g} already", "give a later end", "t_end=")
        unsaved = (newton.positions(x), x.copy()) if saved < k and not (fast is not None and fast.inside) else None
    status = Status("done", f"reached t = {t_end:g} in {steps} steps.")
    try:
        keeper.listen()
        while k < steps:
            if keeper.due(k):
                keeper.keep(k, before, memory())
                if keeper.stopping:
                    status = keeper.interrupted(f"t = {before:g}")
                    break
            before, t = t0 + k * dt, t0 + (k + 1) * dt
            if not steady:
                if ends:
                    external = disc.external(t)
                elif load_rule == "midpoint":
                    external = disc.external(0.5 * (before + t))
                else:
                    external = 0.5 * (disc.external(before) + disc.external(t))
            if fast is not None:
                alone = progress is not None or not steady
                most = 1 if alone else min(steps - k, save_every - k % save_every, keeper.room(k))
                taken = fast.take(x, external, most, ledger, k)
                if taken:
                    k += len(taken)
                    recorder.iterations += taken
                    before = t0 + k * dt
                    if k % save_every == 0:
                        books = fast.books(x)
                        recorder.keep(before, 1.0, newton.positions(x), x, books, ledger.flows)
                        unsaved, saved = None, k
                    report(k / steps, _line(before, fast.energy, taken[-1]))
                    continue
                books = fast.books(x)
                fast.give(x)
                unsaved = (newton.positions(x), x.copy()) if saved < k else None
            if newton.driver.varies and ends:
                newton.driver.place(t, 1.0)
            elif newton.driver.varies:
                newton.driver.act(before, t, load_rule)
            newton.begin(x)
            moved = bool(disc.prescribed or disc.driven) and place_supports(disc, x, t)
            outcome = newton.solve(x, external, moved)
            recorder.iterations.append(outcome.iterations)
            if outcome.status is not None:
                failed = explained(newton, newton.start, outcome.status, static=False)
                status = Status(
                    failed.code,
                    f"stopped at t = {before:g}, in step {k + 1} to t = {t:g}: {failed.sentence}",
                    failed.advice,
                )
                break
            books = newton.finish(x, acting if ends else None)
            if ends:
                acting = books.applied.copy()
            ledger.add(books)
            k += 1
            if k % save_every == 0:
                recorder.keep(t, 1.0, newton.positions(x), x, books, ledger.flows)
                unsaved, saved = None, k
            else:  # for a run that ends on the way: a step that fails leaves x somewhere
                unsaved = newton.positions(x), x.copy()
            before = t
            report(k / steps, _line(t, float(books.totals[0] + books.totals[1]), outcome.iterations))
        else:
            keeper.keep(k, before, memory(), done=True)
    except KeyboardInterrupt:
        if fast is not None:  # it may have come while steps were taken
            taken = fast.settle(ledger)
            k += len(taken)
            recorder.iterations += taken
            before = t0 + k * dt
        status = keeper.interrupted(f"t = {before:g}")
    except ModelError as error:  # a user's function that fails on the way: keep what there is
        status = Status("bad_input", f"stopped at t = {before:g}: {error.what}.", f"{error.fix}.")
    finally:
        keeper.hush()
    if fast is not None:
        fast.close(ledger)
        if fast.inside and saved < k:
            books = fast.books(x)
            unsaved = newton.positions(x), x
    if unsaved is not None:
        recorder.keep(before, 1.0, *unsaved, books, ledger.flows)
    info = {
        "integrator": repr(integrator), "formulation": repr(integrator.formulation), "dt": dt, "t_end": t_end,
        "load_rule": load_rule, "tolerance": tolerance, "steps": len(recorder.iterations),
        "element": repr(scheme.element),
    }  # fmt: skip
    result = keeper.finish(recorder.result(status, ledger.audit(), info, keeper.earlier()))
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result


def _line(t: float, energy: float, iterations: int) -> str:
    return f"t = {t:.6g}  H = {energy:.9g}  {iterations} iterations"


def _refuse(formulation: object, integrator: object, load_rule: str) -> None:
    if isinstance(integrator, type) or not hasattr(integrator, "scheme"):
        raise ModelError(
            f"{shown(integrator)} is not an integrator", "use dx.EnergyMomentum(), dx.Midpoint(), …", "integrator="
        )
    needs: Formulation = integrator.formulation  # type: ignore[attr-defined]
    if isinstance(formulation, Formulation) and formulation != needs:
        raise ModelError(
            f"{integrator!r} does not go with {formulation!r}: {integrator.why}",  # type: ignore[attr-defined]
            f"use formulation=dx.{needs!r}, or leave it out",
            "formulation=",
        )
    choice(load_rule, "load_rule", ("midpoint", "average"))


def refuse_damping(model: Model, integrator: Integrator) -> None:
    """Raise ModelError when a section is damped and the integrator has no form for that."""
    for rod in model.rods:
        if rod.section.damping.any() and not integrator.damping:
            raise ModelError(
                f"the section of rod {rod.name!r} is damped, and {integrator!r} has no form for that",
                "use a step of the midpoint family, e.g. dx.EnergyMomentum(), or leave damping= out",
                "integrator=",
            )
