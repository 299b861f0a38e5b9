"""PyElastica: CosseratRod, explicit (PositionVerlet), undamped. Its step is bounded by the fastest wave through an
element: variant is the fraction of min(Δs/c) taken; where that blows up it is halved, and the step that went
through counts. Stiffness and inertia are set to the case's.
"""

from __future__ import annotations

from importlib.metadata import version

import common
import elastica as ea
import numpy as np
from common import Clock, Rod, Run


class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    """What its examples build on."""


class Hat(ea.NoForces):
    """The load of the spaghetti on the first node and element."""

    def apply_forces(self, system, time=0.0):
        system.external_forces[0, 0] += common.hat(time) / 10

    def apply_torques(self, system, time=0.0):
        moment = np.array([0.0, common.hat(time), common.hat(time) / 2])
        system.external_torques[:, 0] += system.director_collection[:, :, 0] @ moment


def rod_of(rod: Rod, a, b, n: int) -> ea.CosseratRod:
    a, b = np.array(a, float), np.array(b, float)
    length = float(np.linalg.norm(b - a))
    axis = (b - a) / length
    side = np.eye(3)[np.argmin(abs(axis))]
    made = ea.CosseratRod.straight_rod(
        n, a, axis, np.cross(axis, side) / np.linalg.norm(np.cross(axis, side)), length,
        np.sqrt(rod.inertia / rod.mass) * 2, rod.mass / (4 * np.pi * rod.inertia / rod.mass),
        youngs_modulus=1.0, shear_modulus=1.0,
    )  # fmt: skip
    # radius and density such that mass and inertia are the rod's; stiffness is put in its place
    made.shear_matrix[:] = np.diag([rod.GA, rod.GA, rod.EA])[:, :, None]
    made.bend_matrix[:] = np.diag([rod.EI, rod.EI, rod.GJ])[:, :, None]
    return made


def energy(rod: ea.CosseratRod, spec: Rod, gravity: float) -> tuple[float, float]:
    total = rod.compute_translational_energy() + rod.compute_rotational_energy()
    total += rod.compute_bending_energy() + rod.compute_shear_energy()
    height = gravity * float(rod.mass @ rod.position_collection[2])
    return float(total) + height, height


def solve(case: str, n: int, dt: float, variant: str, clock: Clock) -> Run:
    if case == "flight":
        return Run(note="explicit: Δt = 0.2 is far past its limit, and its joints between rods are springs")
    swing = case == "swing"
    spec = common.SWING if swing else common.SPAGHETTI
    length, end = (1.0, 1.0) if swing else (10.0, common.SPAGHETTI_END)
    fast = np.sqrt(max(spec.EA / spec.mass, spec.GA / spec.mass, spec.EI / spec.inertia))
    shear = np.sqrt(spec.inertia / spec.GA)  # and no faster than sections turn against shear
    limit = min(length / n / fast, shear)
    factor = float(variant)
    for _ in range(6):
        steps = int(np.ceil(1.0 / (factor * limit))) * round(end)  # whole steps a second
        system, rod = (
            System(),
            (rod_of(spec, (0, 0, 0), (1, 0, 0), n) if swing else rod_of(spec, common.LOADED, common.OTHER, n)),
        )
        system.append(rod)
        if swing:
            system.constrain(rod).using(ea.FixedConstraint, constrained_position_idx=(0,))
            system.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array([0.0, 0.0, -common.GRAVITY]))
        else:
            system.add_forcing_to(rod).using(Hat)
        system.finalize()
        stepper, time, h = ea.PositionVerlet(), 0.0, end / steps
        if clock.cpu == 0.0:  # compile
            start = rod.position_collection.copy(), rod.director_collection.copy()
            stepper.step(system, np.float64(0.0), np.float64(1e-12))
            rod.position_collection[:], rod.director_collection[:] = start
        clock.cpu, before, tall = 0.0, None, energy(rod, spec, common.GRAVITY if swing else 0.0)[1]
        for k in range(10):
            with clock.running(), np.errstate(all="ignore"):
                for _ in range(steps // 10):
                    time = stepper.step(system, time, h)
            if not np.isfinite(rod.position_collection).all():
                break
            if not swing and k == 4:
                before = energy(rod, spec, 0.0)[0]
        total, height = energy(rod, spec, common.GRAVITY if swing else 0.0)
        drift = total / (tall - height) if swing else total / (before or np.nan) - 1
        if np.isfinite(drift) and abs(drift) < 0.05:
            break
        factor /= 2
    else:
        return Run(note="blew up at every step tried", dt=h)
    tip = rod.position_collection[:, -1 if swing else 0].tolist()
    return Run(True, tip, total, float(drift), end, h, note=f"{steps} steps")


if __name__ == "__main__":
    common.main("PyElastica", version("pyelastica"), solve)
