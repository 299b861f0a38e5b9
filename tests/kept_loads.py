"""Every joint, support, load and link, each in a motion, under load control and along a path."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import test_driven
import test_joints

import directrix as dx

Solve = Callable[..., dx.Result]
Act = Callable[[dx.Model], dx.Model]
SWAY = dx.harmonic((0.0, 0.1, 0.05), 1.0)
SURFACE = {"stiffness": 2e3, "radius": 0.05}
ROUGH = {**SURFACE, "friction": 0.3, "slip_speed": 0.01}


def arm() -> dx.Model:
    """Clamped, with a load along it, and a second rod below."""
    model = test_driven.rod().clamp("a").distributed("arm", (0, 0.3, -4.0))
    model = model.rod(dx.line((1.7, -0.5, -0.3), (1.7, 0.5, -0.3)), test_driven.PLAIN, name="other", elements=2)
    return model.clamp("other.start").clamp("other.end")


def jointed(kind: str, **options: Any) -> dx.Model:
    """Two clamped rods and the joint between them."""
    model = test_joints.joined(kind, **options).clamp("A").clamp("D")
    return model.distributed("one", (0, 2.0, 20.0)).moment("C", (1.0, 0.5, -0.5))


ON_THE_ARM: dict[str, Act] = {
    "clamp": lambda m: m.clamp("b"),
    "pin": lambda m: m.pin("b"),
    "fix": lambda m: m.fix("b", "z"),
    "prescribe": lambda m: m.prescribe("b", displacement=(0.0, 0.1, 0.1), rotation=(0.4, 0.2, -0.3)),
    "prescribe, as functions": lambda m: m.prescribe("b", displacement=SWAY, rotation=dx.harmonic((0.4, 0.2, 0), 1.0)),
    "force": lambda m: m.force("b", (0, 0, -3.0)).force("b", SWAY),
    "force, constant": lambda m: m.force("b", (0.3, 0.1, 0), constant=True),
    "force, follower": lambda m: m.force("b", (0, 0, -3.0), follower=True),
    "moment": lambda m: m.moment("b", (0.5, -1.0, 0.3)),
    "moment, follower": lambda m: m.moment("b", (0.5, -1.0, 0.3), follower=True),
    "distributed": lambda m: m.distributed("arm", SWAY),
    "distributed, follower": lambda m: m.distributed("arm", (0, 0.5, -1.0), follower=True),
    "pressure": lambda m: m.pressure("arm", 5.0, width=0.2, along="-d2"),
    "gravity": lambda m: m.gravity((0, 0.2, -0.8)),
    "spring": lambda m: m.spring("b", (2.0, 0.0, 0.5), 20.0, damping=0.2, offset_a=(0, 0, 0.1)),
    "dashpot": lambda m: m.dashpot("b", (2.0, 0.0, 0.5), 2.0),
    "cable": lambda m: m.cable("b", (2.0, 0.0, 0.5), 20.0, length=0.45, width=0.02),
    "actuate": lambda m: m.actuate("arm", curvature=dx.harmonic((0.5, 0.2), 0.5), twist=0.1, elongation=0.01),
    "actuate, along": lambda m: m.actuate("arm", curvature=lambda t, s: (0.5 * t * s, 0.1 * s), along=True),
    "tendon": lambda m: m.tendon("arm", dx.ramp(4.0, 0.0, 1.0), offset=((0.1, 0.0), (0.0, 0.05))),
    "tendon, from node to node": lambda m: m.tendon(("a", "b"), 3.0, offset=((0, 0, 1), (0, 0, 0.2))),
    "drag": lambda m: m.drag("arm", 1.0, 0.2, flow=(0.5, 1.0, 0.0)),
    "point_mass": lambda m: m.point_mass("b", 1.0).gravity((0, 0, -1.0)),
    "rigid_body": lambda m: m.rigid_body("b", 1.0, np.diag([0.1, 0.2, 0.25]), offset=(0.1, 0, 0.1)).gravity((0, 1, -1)),
    "contact, plane": lambda m: m.contact(dx.Plane((0, 0, -0.2), (0, 0, 1)), rods="arm", **ROUGH),
    "contact, sphere": lambda m: m.contact(dx.Sphere((1.5, 0.1, -1.2), 1.0), rods="arm", **ROUGH),
    "contact, cylinder": lambda m: m.contact(dx.Cylinder((1, 0, 0), (1, 0, 0), 0.2, inside=True), rods="arm", **ROUGH),
    "self_contact": lambda m: m.self_contact(**ROUGH),
    "contact_between": lambda m: m.contact_between("arm", "other", **SURFACE),
}
ACTING: dict[str, dict[str, Any]] = {
    "a spring, a damper and stops": {"stiffness": 3.0, "damping": 0.2, "rest": 0.1, "stops": (-0.02, 0.02),
        "stop_stiffness": 50.0},
    "a drive": {"drive": dx.harmonic(2.0, 1.0, mean=1.0)},
    "a prescribed motion": {"prescribed": dx.harmonic(0.2, 1.0)},
}  # fmt: skip
IN_JOINTS: dict[str, Callable[[], dx.Model]] = {
    **{kind: partial(jointed, kind) for kind in (*test_joints.AXES, "spherical", "rigid")},
    **{
        f"{kind}, with {what}": partial(jointed, kind, **acting)
        for kind in ("hinge", "cylindrical", "slider")
        for what, acting in ACTING.items()
    },
    **{f"{k}, with a spring": partial(jointed, k, stiffness=3.0, damping=0.2) for k in ("spherical", "universal")},
    "hinge, on the ground": lambda: test_driven.rod().hinge("a", axis=(0, 1, 0), stiffness=8.0).gravity((0, 0, -2.0)),
}
"""Every kind, and what can act on its freedom."""
WITHOUT_PATH = {"self_contact", "contact_between"}
"""Refused along a path."""


def every_load() -> dict[str, Solve]:
    """Runs by name."""
    models = {name: partial(act, arm()) for name, act in ON_THE_ARM.items()} | IN_JOINTS
    found: dict[str, Solve] = {}
    for name, make in models.items():
        found[f"{name}: motion"] = lambda make=make, **o: dx.simulate(make(), 0.48, 0.02, save_every=5, **o)
        found[f"{name}: statics"] = lambda make=make, **o: dx.solve_static(make(), 10, save_every=3, **o)
        if name not in WITHOUT_PATH:
            way = dx.ArcLength(ds=0.03, max_steps=10)
            found[f"{name}: path"] = lambda make=make, way=way, **o: dx.solve_static(
                make(), control=way, save_every=3, **o
            )
    return found
