"""directrix: variant = order of the elements."""

from __future__ import annotations

import common
from common import Clock, Rod, Run

import directrix as dx


def section(rod: Rod) -> dx.Section:
    return dx.Section.from_moduli(
        EA=rod.EA, GA1=rod.GA, GA2=rod.GA, EI1=rod.EI, EI2=rod.EI, GJ=rod.GJ,
        A_rho=rod.mass, I_rho1=rod.inertia, I_rho2=rod.inertia,
    )  # fmt: skip


def swing(n: int, order: int) -> dx.Model:
    axis = dx.line((0, 0, 0), (1, 0, 0))
    model = dx.Model().rod(axis, section(common.SWING), name="rod", ends=("pin", "tip"), elements=n, order=order)
    return model.pin("pin").gravity((0, 0, -common.GRAVITY))


def flight(n: int, order: int) -> dx.Model:
    """``n`` elements in each of the three rods."""
    model = dx.Model()
    for i, (a, b) in enumerate(common.FLIGHT_LEGS):
        ends = ("AOB"[i], "OBC"[i])
        model = model.rod(dx.line(a, b), section(common.FLIGHT), name=f"{i}", ends=ends, elements=n, order=order)
    for name, v in zip("ABC", common.FLIGHT_VELOCITY.values(), strict=True):
        model = model.velocity(name, v)
    return model


def spaghetti(n: int, order: int) -> dx.Model:
    axis = dx.line(common.LOADED, common.OTHER)
    model = dx.Model().rod(axis, section(common.SPAGHETTI), name="rod", ends=("tip", "other"), elements=n, order=order)
    model = model.force("tip", lambda t: (common.hat(t) / 10, 0.0, 0.0))
    return model.moment("tip", lambda t: (0.0, common.hat(t), common.hat(t) / 2))


def solve(case: str, n: int, dt: float, variant: str, clock: Clock) -> Run:
    model = {"swing": swing, "flight": flight, "spaghetti": spaghetti}[case](n, int(variant))
    end = {"swing": 1.0, "flight": common.FLIGHT_END, "spaghetti": common.SPAGHETTI_END}[case]
    every = round(end / dt) if case != "spaghetti" else round(common.RELEASE / dt)
    dx.simulate(model, t_end=2 * dt, dt=dt, save_every=2)  # compiles
    with clock.running():
        result = dx.simulate(model, t_end=end, dt=dt, save_every=every)
    total = result.energy.total
    if case == "swing":
        drift = float(result.energy.residual[-1] / result.energy.work[-1])
    else:
        first = common.FLIGHT_ENERGY if case == "flight" else total[-2]
        drift = float(total[-1] / first - 1)
    tip = result.node("C" if case == "flight" else "tip").r[-1].tolist()
    cuts = f"{len(result.iterations)} steps, {result.iterations.mean():.2f} iterations"
    return Run(result.success, tip, float(total[-1]), drift, float(result.t[-1]), note=cuts)


if __name__ == "__main__":
    common.main("directrix", dx.__version__, solve)
