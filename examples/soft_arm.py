"""A soft robot's arm
==================

Silicone, three tendons inside, in water.

One tendon parallel to the axis at the distance ξ, pulled with T, bends the arm into an arc of curvature κ = T ξ/EI and
shortens it by T/EA: that is where the energy of arm and tendon together is least. Between the ends of elements the
tendon is straight, which for linear elements of length h adds T h²/4 to EI. Then the three pull one after the other and
the tip goes round. What they put in and what silicone and water take is booked by its sources; the ledger closes to
round-off.

    python examples/soft_arm.py [--tension 0.5] [--out FOLDER]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import directrix as dx

LENGTH, RADIUS, XI, E, RHO = 0.2, 0.01, 0.007, 1e5, 1070.0
EI, EA = E * np.pi * RADIUS**4 / 4, E * np.pi * RADIUS**2
PERIOD = 1.0


@dataclass(frozen=True)
class Turn:
    """Tension of one tendon while they take turns: grows over the first period, then 0 … 2 ``mean``."""

    mean: float
    phase: float

    def __call__(self, t: float) -> float:
        return self.mean * min(1.0, t / PERIOD) * (1.0 + np.cos(2.0 * np.pi * t / PERIOD - self.phase))


def arm(elements: int) -> dx.Model:
    """The arm, hanging from its root."""
    section = dx.Section.circle(radius=RADIUS, E=E, nu=0.49, rho=RHO, damping=0.02)
    axis = dx.line((0, 0, 0), (0, 0, -LENGTH), d1=(1, 0, 0))
    model = dx.Model(name="soft arm").rod(axis, section, name="arm", ends=("root", "tip"), elements=elements, order=1)
    return model.clamp("root")


def main(
    *, tension: float = 0.5, elements: int = 20, t_end: float = 4.0, dt: float = 0.01, out: str | None = None
) -> dict[str, float]:
    """Curvature and shortening under one tendon against theory; how far the ledger of the motion is from closing."""
    fine = 4 * elements
    bent = dx.solve_static(arm(fine).tendon("arm", tension, offset=(XI, 0)), steps=4, raise_on_failure=True)
    strain = bent.rod("arm").strain[-1].mean(axis=0)
    half = 0.5 * 1000.0 * 2 * RADIUS  # ½ ρ d of water
    moving = arm(elements).drag("arm", normal=1.1 * half, tangential=0.01 * np.pi * half)
    for k in range(3):
        angle = 2.0 * np.pi * k / 3
        offset = (XI * np.cos(angle), XI * np.sin(angle))
        moving = moving.tendon("arm", Turn(0.5 * tension, angle), offset=offset, name=f"tendon {k + 1}")
    motion = dx.simulate(moving, t_end, dt, raise_on_failure=True)
    energy = motion.energy
    found = {
        "curvature": float(abs(strain[4])),
        "curvature, theory": tension * XI / EI,
        "with straight segments": tension * XI / (EI + tension * (LENGTH / fine) ** 2 / 4),
        "shortening": float(-strain[2]),
        "shortening, theory": tension / EA,
        "ledger": float(np.abs(energy.residual).max() / max(abs(energy.work).max(), energy.dissipated.max())),
    }
    for name, value in found.items():
        print(f"{name:<24} {value:.9g}")
    print(motion)
    if out is not None:
        print(picture(bent, motion, Path(out) / "soft_arm.png"))
    return found


def picture(bent: dx.Result, motion: dx.Result, path: Path) -> Path:
    """The arc; the way of the tip and the arm on it; who put in and who took what."""
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(13, 4.2), layout="constrained")
    arc, energy = figure.add_subplot(131), figure.add_subplot(133)
    way = figure.add_subplot(132, projection="3d")
    for r in bent.r:
        arc.plot(r[:, 0], r[:, 2], color="#1f4e79", lw=2)
    arc.set(title="one tendon, pulled in four steps", xlabel="x", ylabel="z", aspect="equal")
    tip = motion.node("tip").r
    way.plot(*tip.T, color="#c04020", lw=1)
    for r in motion.r[::10][-10:]:
        way.plot(*r.T, color="#1f4e79", lw=1.5, alpha=0.6)
    way.set(title="three take turns", xlabel="x", ylabel="y", zlabel="z")
    way.set_box_aspect((1, 1, 1))
    tendons = sum(done for name, done in motion.energy.work_by_source.items() if name.startswith("tendon"))
    for name, values in (("work of tendons", tendons), *motion.energy.by_source.items()):
        label = {"fluid": "taken by water", "damping": "taken by silicone"}.get(name.split()[0], name)
        energy.plot(motion.t, 1e3 * np.asarray(values), lw=1.5, label=label)
    energy.plot(motion.t, 1e3 * motion.energy.total, lw=1.5, label="in the arm")
    energy.set(title="energy, thousandths", xlabel="t")
    energy.legend()
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    return path


def test_the_arc_is_that_of_theory_and_the_ledger_closes() -> None:
    found = main()
    assert abs(found["curvature"] - found["with straight segments"]) <= 5e-4 * found["curvature"]
    assert abs(found["curvature"] - found["curvature, theory"]) <= 5e-3 * found["curvature"]
    assert abs(found["shortening"] - found["shortening, theory"]) <= 1e-3 * found["shortening"]
    assert found["ledger"] <= 1e-10


if __name__ == "__main__":
    from _command import run

    run(main)
