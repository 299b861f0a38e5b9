"""Time stepping. The loop knows states, times and when to save or stop; the mechanics are elsewhere."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

from directrix import points
from directrix.audit import DynamicBooks
from directrix.checks import choice, number, reporting, shown, whole
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
from directrix.recorder import Progress, Recorder, feed_of
from directrix.result import Result, Status
from directrix.scheme import Rates
from directrix.state import has_history, initial_state, place_supports, stand
from directrix.statics import PATIENCE
from directrix.stepping import Adaptive, Beat, Fixed, Stepping, stepping, way
from directrix.telling import line
from directrix.threads import one_blas_thread

__all__ = ["refuse_damping", "simulate"]


@one_blas_thread()
def simulate(
    model: Model,
    t_end: float,
    dt: float | Adaptive,
    *,
    integrator: Integrator | None = None,
    formulation: Formulation | None = None,
    load_rule: Literal["midpoint", "average"] = "midpoint",
    start: Result | None = None,
    save_every: int = 1,
    keep: Keep | None = None,
    folder: Folder | RunFolder | str | os.PathLike[str] | None = None,
    tolerance: float = 1e-9,
    record: Sequence[points.Recorder] = (),
    threads: int = 1,
    linear: Petsc | str | None = None,
    progress: Progress | Literal[True] | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """Integrate the motion from t = 0 (or from ``start``) to ``t_end``, in equal steps or as long as an error allows.

    A step that cannot be solved is cut in halves, down to 1/4096, and the steps grow again after easy ones; what the
    integrator conserves it conserves in steps of any length. ``result.dt`` and ``result.cuts`` tell.

    Parameters
    ----------
    model
        Rods with mass, supports, loads, initial velocities.
    t_end, dt
        End and step; ``t_end`` must be a whole number of steps away. Or ``dx.Adaptive(…)``, which see.
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
        Keep every so many steps, whole ones of a fixed ``dt``; the last state is always kept.
    keep
        Which rods, nodes and fields: ``dx.Keep(…)``; all unless given.
    folder
        Where the run is kept while it goes on: a path, or ``dx.Folder(path, resume=True)`` to go on with a run that was
        killed or interrupted, to the same digits. The result is written there in the end.
    tolerance
        Unbalanced over largest element force at which a step is accepted (never below round-off).
    record
        Points of rods whose history goes to files while the run goes on: ``dx.Recorder(rod, s=…)``.
    threads
        How many threads share the work on a frame of many junctions; no bit of the result depends on it.
    linear
        "petsc", or ``dx.Petsc(…)``, for frames that go beyond one machine; None is SciPy and LAPACK.
    progress
        Called after each step with the fraction done and a line of text. What it raises ends the run, which is kept.
        True shows a line, in a notebook a bar.
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
    t_end = number(t_end, "t_end")
    refuse_damping(model, integrator)
    t0 = float(start.t[-1]) if isinstance(start, Result) and start.kind == "dynamic" else 0.0
    pace = stepping(dt, t0, t_end, integrator)
    if isinstance(dt, Adaptive) and dt.save_at is not None and save_every != 1:
        raise ModelError("save_at and save_every both say what is kept", "leave one of them out", "save_every=")
    beat = pace.first()
    scheme = integrator.scheme(beat.dt)
    disc = discretise(model, scheme)
    settings = Settings(tolerance, PATIENCE, retry=False) if pace.adaptive else Settings(tolerance)
    x = initial_state(disc, start, scheme)
    newton = Newton(disc, scheme, replace(settings, threads=threads, linear=Petsc.of(linear)))
    newton.driver.place(t0, 1.0)
    newton.driver.shift()
    place_supports(disc, x, t0)
    stand(x, disc.nodes)  # supports that begin elsewhere are there: no step took them, and none does its work
    refuse_joints(newton, x, fresh=start is None or start.kind == "static")
    refuse(without_inertia(newton, x))
    external = disc.external(t0)
    ends = scheme.rates is Rates.ALPHA
    if ends and not has_history(start, scheme):
        newton.accelerate(x, external)
    acting = newton.applied(x, external)
    recorder = Recorder(disc, "dynamic", Parts(disc.mesh, keep), record, feed_of(progress))
    books = newton.books(x)
    ledger = DynamicBooks(disc, integrator, books)
    recorder.keep(t0, 1.0, newton.positions(x), x, books, ledger.flows)
    steady = not any(load.varies for load in disc.loads)
    before, report = t0, reporting(progress)
    unsaved = None
    fast = fast_for(newton, pace.dt) if isinstance(pace, Fixed) else None
    if pace.adaptive:
        beat = replace(beat, past=((0.0, x[: disc.nodes, 24:36].copy()),))
    saved = 0  # steps that are behind what was last kept
    paced = beat.dt  # of the last step
    asked = {
        "t0": t0, "dt": dt, "t_end": t_end if pace.adaptive else None, "integrator": integrator,
        "load_rule": load_rule, "tolerance": tolerance, "save_every": save_every, "keep": keep, "x": x,
    }  # fmt: skip
    print_ = "" if folder is None else fingerprint(disc, scheme, asked, (t0, beat.to))
    keeper = Keeper(folder, recorder, print_)

    def memory() -> dict[str, Any]:
        return {
            "beat": beat.remember(), "saved": saved, "paced": paced, "x": x, "acting": acting,
            "newton": newton.remember(), "ledger": ledger.remember(), "log": recorder.log.remember(),
            "fast": None if fast is None else fast.remember(),
        }  # fmt: skip

    if keeper.memory is not None:
        past = keeper.memory
        beat, saved, paced = pace.again(Beat.recalled(past["beat"])), past["saved"], past["paced"]
        newton.retime(integrator.scheme(paced), x)
        x, acting = past["x"], past["acting"]
        books = newton.recall(past["newton"])
        ledger.recall(past["ledger"])
        recorder.log.recall(past["log"])
        if fast is not None:
            fast.recall(past["fast"])
        before = beat.t
        unsaved = (
            (newton.positions(x), x.copy())
            if saved < len(recorder.iterations) and not (fast is not None and fast.inside)
            else None
        )
    status = Status("done", "")
    try:
        keeper.listen()
        while not beat.done:
            if keeper.due(taken := len(recorder.iterations)):
                keeper.keep(taken, beat.t, memory)
                if keeper.stopping:
                    status = keeper.interrupted(f"t = {beat.t:g}")
                    break
            before, t = beat.t, beat.to
            if not steady:
                if ends:
                    external = disc.external(t)
                elif load_rule == "midpoint":
                    external = disc.external(0.5 * (before + t))
                else:
                    external = 0.5 * (disc.external(before) + disc.external(t))
            if fast is not None and isinstance(pace, Fixed) and beat.whole:
                alone = progress is not None or not steady
                many = 1 if alone else min(pace.steps - beat.k, save_every - beat.k % save_every)
                many = min(many, keeper.room(len(recorder.iterations)))
                done = fast.take(x, external, many, ledger, beat.k)
                if done:
                    recorder.log.took(beat.dt, done, fast.moves)
                    beat = pace.on(beat, len(done))
                    before = beat.t
                    if beat.k % save_every == 0:
                        books = fast.books(x)
                        recorder.keep(before, 1.0, newton.positions(x), x, books, ledger.flows)
                        unsaved, saved = None, len(recorder.iterations)
                    report(pace.fraction(beat), _line(before, recorder, ledger, fast.energy))
                    continue
                if fast.inside:
                    books = fast.books(x)
                    fast.give(x)
                unsaved = (newton.positions(x), x.copy()) if saved < len(recorder.iterations) else None
            x, paced = newton.retime(integrator.scheme(beat.dt), x), beat.dt
            good = x.copy()
            if newton.driver.varies and ends:
                newton.driver.place(t, 1.0)
            elif newton.driver.varies:
                newton.driver.act(before, t, load_rule)
            newton.begin(x)
            moved = bool(disc.prescribed or disc.driven) and place_supports(disc, x, t)
            outcome = newton.solve(x, external, moved)
            if outcome.status is not None:
                x, shorter = good, pace.shorter(beat)
                recorder.log.threw(newton.trail, rejected=False)
                if shorter is None:
                    failed = explained(newton, newton.start, outcome.status, static=False)
                    status = Status(failed.code, f"{_stopped(pace, beat)}: {failed.sentence}", failed.advice)
                    break
                beat = shorter
                continue
            fine, after = pace.judge(beat, way(x, disc.nodes) / beat.dt if pace.adaptive else None, disc.length)
            if not fine:
                x = good
                recorder.log.threw(newton.trail, rejected=True)
                if after is None:
                    status = Status("inaccurate", f"{_stopped(pace, beat)}.", "Raise the tolerance, or lower dt_min.")
                    break
                beat = after
                continue
            assert after is not None
            books = newton.finish(x, acting if ends else None)
            if ends:
                acting = books.applied.copy()
            ledger.add(books, beat.dt)
            recorder.log.took(beat.dt, [outcome.iterations], newton.trail)
            whole_step, beat, before = beat.asked, after, t
            count = len(recorder.iterations) if pace.adaptive else beat.k
            if (whole_step or not pace.on_time) and count % save_every == 0:
                recorder.keep(t, 1.0, newton.positions(x), x, books, ledger.flows)
                unsaved, saved = None, len(recorder.iterations)
            else:  # for a run that ends on the way: a step that fails leaves x somewhere
                unsaved = newton.positions(x), x.copy()
            report(pace.fraction(beat), _line(t, recorder, ledger, float(books.totals[0] + books.totals[1])))
        else:
            keeper.keep(len(recorder.iterations), before, memory, done=True)
            status = Status("done", f"reached t = {t_end:g} in {len(recorder.iterations)} steps{_thrown(recorder)}.")
    except KeyboardInterrupt:
        if fast is not None:  # it may have come while steps were taken
            done = fast.settle(ledger)
            recorder.log.took(beat.dt, done, fast.moves)
            before = pace.on(beat, len(done)).t if isinstance(pace, Fixed) and done else before
        status = keeper.interrupted(f"t = {before:g}")
    except ModelError as error:  # a user's function that fails on the way: keep what there is
        status = Status("bad_input", f"stopped at t = {before:g}: {error.what}.", f"{error.fix}.")
    finally:
        keeper.hush()
    if fast is not None:
        fast.close(ledger)
        if fast.inside and saved < len(recorder.iterations):
            books = fast.books(x)
            unsaved = newton.positions(x), x
    if unsaved is not None:
        recorder.keep(before, 1.0, *unsaved, books, ledger.flows)
    info = {
        "integrator": repr(integrator), "formulation": repr(integrator.formulation),
        "dt": repr(dt) if isinstance(dt, Adaptive) else dt, "t_end": t_end, "load_rule": load_rule,
        "tolerance": tolerance, "steps": len(recorder.iterations), "cuts": recorder.log.failed,
        "rejected": recorder.log.rejected, "element": repr(scheme.element),
    }  # fmt: skip
    result = keeper.finish(recorder.result(status, ledger.audit(), info, keeper.earlier()))
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result


def _line(t: float, recorder: Recorder, ledger: DynamicBooks, energy: float) -> str:
    log = recorder.log
    return line("t =", t, log.iterations, cuts=log.failed, energy=energy, error=ledger.error(energy))


def _stopped(pace: Stepping, beat: Beat) -> str:
    where = f", in step {beat.k + 1} to t = {beat.to:g}" if beat.whole and not pace.adaptive else ""
    return f"stopped at t = {beat.t:g}{where}: {pace.why(beat)}"


def _thrown(recorder: Recorder) -> str:
    log = recorder.log
    parts = (f"{log.failed} times cut" * (log.failed > 0), f"{log.rejected} taken again shorter" * (log.rejected > 0))
    return "".join(f", {part}" for part in parts if part)


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
