"""The page of the public objects, from ``directrix.__all__``: what is in no group below comes last."""

from __future__ import annotations

from pathlib import Path

import directrix

GROUPS = {
    "Describe": ("Model", "Section", "laws"),
    "Axes": ("line", "arc", "helix", "polyline", "spline"),
    "Functions of time": ("ramp", "harmonic", "table"),
    "Surfaces": ("Plane", "Sphere", "Cylinder"),
    "Statics": (
        "solve_static", "ArcLength", "DisplacementControl", "Snapshot", "branches", "continuation", "form_find",
    ),
    "Dynamics": ("simulate",),
    "Vibration and buckling": ("modes", "Modes", "buckling", "BucklingLoads"),
    "Formulations": ("Directors", "SimoVuQuoc", "CrisfieldJelenic"),
    "Time steps": (
        "EnergyMomentum", "Midpoint", "EnergyDissipating", "GeneralizedAlpha", "HilberHughesTaylor", "Newmark",
        "SimoTarnowDoblare",
    ),
    "Frames past one machine": ("Petsc",),
    "Many runs": ("ensemble", "Ensemble"),
    "Results": ("Result", "Status", "TurningPoint", "load"),
    "Errors": ("DirectrixError", "ModelError", "InputError", "ConvergenceError"),
}  # fmt: skip
BEHIND = {
    "What a model is made of": (
        "model.Rod", "model.Node", "model.Support", "model.Prescribed", "model.Force", "model.Moment",
        "model.Distributed", "model.Pressure", "model.Gravity", "model.Velocity", "model.RigidVelocity",
        "attachments.Link", "attachments.Body", "joints.Joint", "actuators.Actuation", "actuators.Tendon",
        "actuators.Drag", "contacts.Contact", "contacts.RodContact",
    ),
    "What a result is made of": (
        "result.Mesh", "result.NodeHistory", "result.RodHistory", "result.LinkHistory", "result.ContactHistory",
        "result.JointHistory", "result.Energy", "result.Momentum", "trail.Iterations", "audit.Audit", "plot.Plots",
        "critical.PathStability",
    ),
    "For those who extend": (
        "integrators.protocol.Integrator", "integrators.conformance.check_integrator",
        "formulations.element.Element", "formulations.layout.Layout", "formulations.conformance.check_formulation",
        "linear.conformance.LinearSolver", "linear.conformance.check_linear", "kernels.trace",
    ),
}  # fmt: skip


def page() -> str:
    """The page, in reStructuredText."""
    named = {name for names in GROUPS.values() for name in names}
    rest = tuple(name for name in directrix.__all__ if name not in named)
    groups = {**GROUPS, **({"More": rest} if rest else {}), **BEHIND}
    parts = [
        "API reference", "=============", "",
        "``import directrix as dx``. Models, sections, results and strategies are values. The first lists are",
        "what is used as ``dx.NAME``; the last three are what one meets behind it.",
        "",
    ]  # fmt: skip
    for heading, names in groups.items():
        parts += [heading, "-" * len(heading), "", ".. autosummary::", "   :toctree: api", "   :nosignatures:", ""]
        parts += [f"   ~directrix.{name}" for name in names] + [""]
    return "\n".join(parts)


def write(path: Path) -> None:
    """Write the page unless it is there already, word for word."""
    text = page()
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")
