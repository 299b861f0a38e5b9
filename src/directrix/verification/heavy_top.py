"""5.7 Heavy top: a spinning body on a ball joint under gravity, and what is exact about it."""
# pyright: reportUnknownArgumentType=false, reportUnknownMemberType=false, reportUnknownVariableType=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import directrix as dx
from directrix.verification.record import Case, Check

Array = NDArray[np.float64]

MASS, INERTIA, GRAVITY = 15.0, np.diag([0.234375, 0.46875, 0.234375]), np.array([0.0, 0.0, -9.81])
ARM, SPIN = np.array([0.0, 1.0, 0.0]), np.array([0.0, 150.0, -4.61538])
KYNEMA = np.array([-0.150416985652933, -1.724164450779749, -0.673023460701136])  # displacement of the centre at t = 2


def top() -> dx.Model:
    """The centre of mass is the node "centre"; joint "ball" holds it to the ground at the origin."""
    return (
        dx.Model(name="heavy top")
        .node("centre", ARM)
        .rigid_body("centre", MASS, INERTIA)
        .spherical("centre", at=(0, 0, 0), name="ball")
        .gravity(GRAVITY)
        .velocity("centre", np.cross(SPIN, ARM), SPIN)
    )


def exact(t: float) -> Array:
    """Displacement (3,) of the centre at time t from Euler's equations about the joint, by quaternion."""
    arm = MASS * (ARM @ ARM * np.eye(3) - np.outer(ARM, ARM))
    about = INERTIA + arm

    def turned(q: Array, vector: Array) -> Array:
        w, u = float(q[0]), q[1:]
        return vector + 2.0 * np.cross(u, np.cross(u, vector) + w * vector)

    def rate(_: float, y: Array) -> Array:
        q, omega = y[:4] / np.linalg.norm(y[:4]), y[4:]  # ω in the body
        back = np.array([q[0], *(-q[1:])])
        moment = np.cross(ARM, MASS * turned(back, GRAVITY))
        spin = np.linalg.solve(about, moment - np.cross(omega, about @ omega))
        return np.array([-0.5 * q[1:] @ omega, *(0.5 * (q[0] * omega + np.cross(q[1:], omega))), *spin])

    start = np.array([1.0, 0.0, 0.0, 0.0, *SPIN])
    end: Array = solve_ivp(rate, (0.0, t), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    quaternion: Array = end[:4] / float(np.linalg.norm(end[:4]))
    return turned(quaternion, ARM) - ARM


def _run() -> Iterator[Check]:
    runs = [dx.simulate(top(), 2.0, dt, save_every=4, raise_on_failure=True) for dt in (1e-3, 5e-4)]
    coarse, fine = (run.node("centre").displacement[-1] for run in runs)
    got, known = (4.0 * fine - coarse) / 3.0, exact(2.0)
    name = "Δt = 0.001, 0.0005, extrapolated: centre at t = 2"
    yield Check.of(name, "Euler's equations", "C", known, got, 1e-6)
    yield Check.of(name, "kynema", "F", KYNEMA, got, 2e-6)
    order = np.abs(coarse - known).max() / np.abs(fine - known).max()
    yield Check.of("error with Δt over that with Δt/2", "second order", "A", 4.0, float(order), 0.02)
    laws = {entry.law: entry.value for entry in runs[-1].audit.entries}
    for law, value in laws.items():
        yield Check.law(f"Δt = 0.0005: {law}", "its ledger closes", value, 1e-10)
    spin = runs[-1].momentum.angular
    drift = float(np.ptp(spin[:, 2]) / np.linalg.norm(spin[0]))
    yield Check.law("Δt = 0.0005: angular momentum about the vertical", "conserved", drift, 1e-11)


CASES = (Case("heavy-top", "5.7", "Heavy top on a ball joint", _run),)
