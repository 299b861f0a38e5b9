"""Runs of every analysis, with every joint and load, short enough to be gone on with from many steps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import test_attachments
import test_contact
import test_driven
import test_form_finding
import test_joints
from kept_loads import every_load

import directrix as dx
from directrix.schema import load_case

RUBBER = dx.Section.circle(radius=0.02, E=5e6, nu=0.5, rho=1100)
INTEGRATORS = {
    "energy-momentum": dx.EnergyMomentum(),
    "midpoint": dx.Midpoint(),
    "energy-dissipating": dx.EnergyDissipating(0.5, 0.1),
    "generalized-alpha": dx.GeneralizedAlpha(0.8),
    "hilber-hughes-taylor": dx.HilberHughesTaylor(0.1),
    "newmark": dx.Newmark(),
    "simo-tarnow-doblare": dx.SimoTarnowDoblare(),
}

Solve = Callable[..., dx.Result]
"""``solve(folder=…, save_every=…, progress=…)``."""


def chain(elements: int = 48, order: int = 1) -> dx.Model:
    """Long enough for the lanes; flies, so that its origin goes along."""
    model = dx.Model(name="chain").rod(
        dx.line((0, 0, 0), (1, 0, 0)), RUBBER, name="rod", ends=("A", "B"), elements=elements, order=order
    )
    return model.velocity("A", (0, 0, -1)).velocity("B", (0, 0.5, 1), (3, 0, 1)).rigid_velocity((20, 0, 5), (0, 0, 0))


def frame(damping: float = 0.1) -> dx.Model:
    """Branches and closes: three joints, a body, a moving support, a load that changes."""
    line, section = dx.line, test_joints.SECTION
    return (
        dx.Model(name="frame")
        .rod(line((0, 0, 0), (0, 0, 1)), section, name="left", ends=("A", "B"), elements=3)
        .rod(line((0, 0, 1), (1, 0, 1)), section, name="top", ends=("C", "D"), elements=4)
        .rod(line((1, 0, 1), (1, 0, 0)), section, name="right", ends=("D", "E"), elements=3)
        .rod(line((1, 0, 1), (1.5, 0, 1.2)), section, name="arm", ends=("F", "G"), elements=2)
        .clamp("A")
        .prescribe("E", displacement=dx.harmonic((0.0, 0.1, 0.0), 1.0))
        .spherical("B", "C")
        .hinge("D", "F", axis=(0, 1, 0), stiffness=5.0, damping=damping)
        .point_mass("G", 1.0)
        .gravity((0, 0, -9.81))
        .force("G", dx.ramp((0.0, 3.0, 1.0), 0.0, 0.2))
    )


def swinging() -> dx.Model:
    """A frame whose steps begin with the factors of the ones before: nothing is prescribed."""
    rod, section = test_joints.two_rods(test_joints.STIFF), test_joints.STIFF
    model = rod.hinge("B", "C", axis=(0, 0.3, 1), stiffness=10.0).clamp("A")
    model = model.rod(dx.line((1, 0, 0), (1, 0, 0.5)), section, name="three", ends=("B", "E"), elements=2)
    model = model.actuate("one", curvature=dx.harmonic((0.05, 0.02), 2.0))
    return model.gravity((0, 0, -9.81)).force("D", dx.ramp((20.0, 0, 5.0), 0.0, 0.2), follower=True)


def flying() -> dx.Model:
    """Two rods that every time step can take."""
    model = dx.Model(name="flight").rod(dx.line((0, 0, 0), (1, 0, 0)), RUBBER, name="a", ends=("A", "B"), elements=4)
    model = model.rod(dx.line((1, 0, 0), (1, 1, 0)), RUBBER, name="b", ends=("B", "C"), elements=4)
    return model.pin("A").gravity((0, 0, -9.81)).velocity("C", (0, 0, 1))


def column() -> dx.Model:
    """A hinged frame that snaps, with a bifurcation on the way."""
    from importlib.resources import files

    return load_case(str(files("directrix.cases") / "hinged_frame.toml")).model


def bent() -> dx.Model:
    """A clamped rod under a force, for load control."""
    model = dx.Model(name="bent").rod(dx.line((0, 0, 0), (1, 0, 0)), RUBBER, name="a", ends=("A", "B"), elements=6)
    return model.clamp("A").force("B", (0, 0, 2.0)).moment("B", (0.02, 0, 0))


def hinged() -> dx.Model:
    """Two clamped rods and a sprung hinge between them."""
    return test_joints.joined("hinge", stiffness=3.0).clamp("A").clamp("D").force("B", (0, 0, 20.0))


def upright() -> dx.Model:
    """A straight rod under more than its buckling load: an equilibrium that is not stable is found first, and left."""
    model = dx.Model(name="upright").rod(dx.line((0, 0, 0), (0, 0, 1)), RUBBER, name="a", ends=("a", "b"), elements=6)
    return model.clamp("a").force("b", (0, 0, -3.0))


def pushed_column(stiff: float) -> dx.Model:
    """A column that buckles under its load when its bending stiffness falls."""
    section = dx.Section.from_moduli(EA=1e4, GA1=1e4, GA2=1e4, EI1=stiff, EI2=2.0 * stiff, GJ=1.0)
    model = dx.Model(name="column").rod(dx.line((0, 0, 0), (1, 0, 0)), section, name="a", ends=("a", "b"), elements=4)
    model = model.spring("b", (1.0, 0.3, 0.0), 3.0 * stiff, length=0.3)
    return model.clamp("a").force("b", (-2.0, 0.01, 0.0))


def simulated(model: dx.Model, dt: float, steps: int, **options: Any) -> Solve:
    return partial(dx.simulate, model, steps * dt, dt, **options)


FEW: dict[str, Solve] = {
    "a chain in lanes": simulated(chain(), 0.01, 200, save_every=7),
    "a frame with joints": simulated(frame(), 0.01, 40, save_every=3),
    "rods that hit": simulated(test_contact.crossing(1, 0.02, friction=0.3, slip_speed=0.01), 1e-3, 40),
    "a path": partial(
        dx.solve_static, column(), control=dx.ArcLength(ds=2.0, max_steps=24, load_factors=(1.5e4,)), save_every=2
    ),
    "load control": partial(dx.solve_static, bent(), 12, save_every=5),
    "steps that adapt": partial(
        dx.simulate, flying(), 0.1, dx.Adaptive(tolerance=1e-4, first=0.01), integrator=dx.GeneralizedAlpha(0.8),
        save_every=3,
    ),
    "a family of models": partial(
        dx.continuation, pushed_column, 1.0, control=dx.ArcLength(ds=0.05, load_step=0.05, direction="backward",
        max_steps=16, branch=1), save_every=2,
    ),
    "a frame that keeps its factors": simulated(swinging(), 0.005, 40, save_every=3),
}  # fmt: skip


def every() -> dict[str, Solve]:
    """All of them."""
    found = FEW | every_load()
    found["a form that is found"] = partial(dx.form_find, test_form_finding.cable())
    found["a form that is left"] = partial(dx.form_find, upright())
    for name, integrator in INTEGRATORS.items():
        found[name] = simulated(flying(), 0.01, 30, integrator=integrator, save_every=4)
    for kind in (*test_joints.AXES, "spherical", "rigid"):
        model = test_joints.pushed(test_joints.joined(kind))
        found[f"a {kind} joint"] = simulated(model, 0.01, 24, save_every=5)
    found["motion cut"] = simulated(flying().force("A", dx.ramp((0, 0, 9e4), 0.1, 0.2)), 0.1, 6, save_every=2)
    found["instants that are asked for"] = partial(dx.simulate, flying(), 0.5, dx.Adaptive(1e-4, save_at=0.1))
    for name in ("midpoint", "generalized-alpha", "energy-dissipating"):
        found[f"joints under {name}"] = simulated(frame(0.0), 0.01, 24, integrator=INTEGRATORS[name])
    found |= {
        "a machine": simulated(test_attachments.machine(damping=0.1), 0.01, 30, save_every=4),
        "all that drives": simulated(test_driven.soft_arm(test_driven.DAMPED, 2), 0.02, 30, save_every=4),
        "loads as means": simulated(frame(), 0.01, 24, load_rule="average"),
        "bounces": simulated(test_contact.bouncing(2, friction=0.3, slip_speed=0.01), 2e-3, 60, save_every=9),
        "quadratic lanes": simulated(chain(44, 2), 0.01, 150, save_every=11),
        "kept in part": simulated(
            frame(), 0.01, 24, keep=dx.Keep(("G", "top"), ("velocity",)), save_every=3
        ),
        "a displacement": partial(
            dx.solve_static, column(), control=dx.DisplacementControl("P", "y", to=-20.0, steps=12), save_every=2
        ),
        "a path with an end": partial(
            dx.solve_static, column(), control=dx.ArcLength(ds=2.0, until=lambda s: s.node("P").displacement[1] < -30.0)
        ),
        "Simo and Vu-Quoc": partial(dx.solve_static, bent(), 12, formulation=dx.SimoVuQuoc(), save_every=5),
        "Crisfield and Jelenic": partial(dx.solve_static, bent(), 12, formulation=dx.CrisfieldJelenic()),
        "joints at rest": partial(dx.solve_static, hinged(), 12, save_every=5),
        "stability": partial(dx.solve_static, bent().force("A", (0, 0, 0)), 12, rotation="cayley"),
        "cut": partial(dx.solve_static, bent().force("B", (0, 0, 400.0)), 2),
        "the other branch": partial(
            dx.solve_static, column(), control=dx.ArcLength(ds=2.0, max_steps=24, branch=1), save_every=3
        ),
    }  # fmt: skip
    return found
