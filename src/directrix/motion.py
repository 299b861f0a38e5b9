"""A motion before its first step and after its last: what is asked for, refused, set up, and given back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix import points
from directrix.audit import DynamicBooks
from directrix.checks import choice, number, shown, whole
from directrix.diagnosis import refuse, without_inertia
from directrix.discretisation import discretise
from directrix.errors import ModelError
from directrix.formulations import refuse_strategies
from directrix.integrators import EnergyMomentum, Formulation, Integrator
from directrix.joint_checks import refuse_joints
from directrix.keeping import fingerprint
from directrix.linear.choice import Linear, chosen, said_of
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.parts import Keep, Parts
from directrix.recorder import Progress, Recorder, feed_of
from directrix.result import Result, Status
from directrix.scheme import Rates
from directrix.state import has_history, initial_state, place_supports, stand
from directrix.statics import PATIENCE
from directrix.stepping import Adaptive, Fixed, stepping

Array = NDArray[np.float64]

__all__ = ["Asked", "Motion", "refuse_damping"]


@dataclass(frozen=True)
class Asked:
    """The arguments of :func:`directrix.simulate` that say what is computed, which see."""

    t_end: float
    dt: float | Adaptive
    integrator: Integrator | None = None
    formulation: Formulation | None = None
    load_rule: Literal["midpoint", "average"] = "midpoint"
    start: Result | None = None
    save_every: int = 1
    keep: Keep | None = None
    tolerance: float = 1e-9
    record: Sequence[points.Recorder] = ()
    threads: int = 1
    linear: Linear | None = None
    progress: Progress | Literal[True] | None = None


class Motion:
    """All that a loop over steps goes on from: the first state ``x`` and its ``books``, the loads that act; the solver,
    the ledger, and a recorder that has the first instant already. Raises ModelError for what cannot be right."""

    def __init__(self, model: Model, asked: Asked) -> None:
        self.integrator = integrator = EnergyMomentum() if asked.integrator is None else asked.integrator
        _refuse(asked.formulation, integrator, asked.load_rule)
        refuse_strategies(asked.formulation, asked.progress)
        self.save_every = whole(asked.save_every, "save_every", 1, 10**9)
        t_end, dt, start = number(asked.t_end, "t_end"), asked.dt, asked.start
        refuse_damping(model, integrator)
        self.t0 = t0 = float(start.t[-1]) if isinstance(start, Result) and start.kind == "dynamic" else 0.0
        self.asked = replace(asked, t_end=t_end)
        self.pace = stepping(dt, t0, t_end, integrator)
        if isinstance(dt, Adaptive) and dt.save_at is not None and self.save_every != 1:
            raise ModelError("save_at and save_every both say what is kept", "leave one of them out", "save_every=")
        self.beat = self.pace.first()
        self.scheme = scheme = integrator.scheme(self.beat.dt)
        self.disc = disc = discretise(model, scheme)
        settings = Settings(asked.tolerance, PATIENCE, retry=False) if self.pace.adaptive else Settings(asked.tolerance)
        self.x = x = initial_state(disc, start, scheme)
        settings = replace(settings, threads=asked.threads, linear=chosen(asked.linear))
        self.newton = newton = Newton(disc, scheme, settings)
        newton.driver.place(t0, 1.0)
        newton.driver.shift()
        place_supports(disc, x, t0)
        stand(x, disc.nodes)  # supports that begin elsewhere are there: no step took them, and none does its work
        refuse_joints(newton, x, fresh=start is None or start.kind == "static")
        refuse(without_inertia(newton, x))
        external = disc.external(t0)
        if self.ends and not has_history(start, scheme):
            newton.accelerate(x, external)
        self.standing = external[None]
        self.steady = not any(load.varies for load in disc.loads)
        """True when loads stay what they are."""
        self.acting = newton.applied(x, external)
        parts = Parts(disc.mesh, asked.keep)
        expected = self.pace.steps // self.save_every + 2 if isinstance(self.pace, Fixed) else 16
        self.recorder = Recorder(disc, "dynamic", parts, asked.record, feed_of(asked.progress), expected)
        self.books = newton.books(x)
        self.ledger = DynamicBooks(disc, integrator, self.books)
        self.recorder.keep(t0, 1.0, newton.positions(x), x, self.books, self.ledger.flows)
        if self.pace.adaptive:
            self.beat = replace(self.beat, past=((0.0, x[: disc.nodes, 24:36].copy()),))

    @property
    def ends(self) -> bool:
        """True when loads act at the ends of steps."""
        return self.scheme.rates is Rates.ALPHA

    def load(self, begin: float, end: float) -> Array:
        """The loads (n, 12) of a step."""
        at = self.disc.external
        if self.ends:
            return at(end)
        if self.asked.load_rule == "midpoint":
            return at(0.5 * (begin + end))
        return 0.5 * (at(begin) + at(end))

    def loads(self, pace: Fixed, before: int, count: int) -> Array:
        """The loads (k, n, 12) of the ``count`` steps behind the first ``before``, or of those of them before a user's
        function fails; steady ones k = 1. Raises ModelError when it fails in the first."""
        if self.steady:
            return self.standing
        times, out = pace.times(before + np.arange(count + 1)).tolist(), list[Array]()
        for begin, end in pairwise(times):
            try:
                out.append(self.load(begin, end))
            except ModelError:
                if not out:
                    raise
                break
        return np.array(out)

    def fingerprint(self) -> str:
        """See :func:`directrix.keeping.fingerprint`."""
        asked = self.asked
        said = {
            "t0": self.t0, "dt": asked.dt, "t_end": asked.t_end if self.pace.adaptive else None,
            "integrator": self.integrator, "load_rule": asked.load_rule, "tolerance": asked.tolerance,
            "save_every": self.save_every, "keep": asked.keep, "x": self.x, **said_of(asked.linear),
        }  # fmt: skip
        return fingerprint(self.disc, self.scheme, said, (self.t0, self.beat.to))

    def done(self) -> Status:
        """How a motion ends that reached its end."""
        log = self.recorder.log
        parts = (
            f"{log.failed} times cut" * (log.failed > 0),
            f"{log.rejected} taken again shorter" * (log.rejected > 0),
        )
        thrown = "".join(f", {part}" for part in parts if part)
        return Status("done", f"reached t = {self.asked.t_end:g} in {len(log.iterations)} steps{thrown}.")

    def result(self, status: Status, earlier: Iterable[Mapping[str, Any]] = ()) -> Result:
        """Everything that was recorded, see :meth:`Recorder.result`."""
        asked, integrator, recorder = self.asked, self.integrator, self.recorder
        info = {
            "integrator": repr(integrator), "formulation": repr(integrator.formulation),
            "dt": repr(asked.dt) if isinstance(asked.dt, Adaptive) else asked.dt, "t_end": asked.t_end,
            "load_rule": asked.load_rule, "tolerance": asked.tolerance, "steps": len(recorder.iterations),
            "cuts": recorder.log.failed, "rejected": recorder.log.rejected, "element": repr(self.scheme.element),
        }  # fmt: skip
        return recorder.result(status, self.ledger.audit(), info, earlier)


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
