"""Four-bar linkage
================

Four-bar linkage with flexible links, and the same with one of its hinges askew.

Crank 1, coupler 3, rocker 2.5, ground 3: the crank turns right round, the rocker swings. All links are rods; four
hinges join them and the ground. Between rigid links four parallel hinges would hold what others hold already; rods bend
and twist, so it is determined what every hinge carries.

* With stiff links the angle of the rocker is Freudenstein's:
  (d/a) cos ψ − (d/c) cos φ + (a² − b² + c² + d²)/2ac = cos(φ − ψ).
* With the rocker's hinge on the ground turned out of parallel by 5° a linkage of rigid links could not move at all.
  Here the links twist and bend, the motor pays for it, and the ledger closes in every step.

    python examples/four_bar.py [--skew 5] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

CRANK, COUPLER, ROCKER, GROUND, SPEED = 1.0, 3.0, 2.5, 3.0, 2.0
RUN_UP = 1.5


def angle(t: float) -> float:
    """Of the crank, from x towards z; it starts at 90° and its speed rises as sin² and stays."""
    turned = (
        0.5 * SPEED * (t - RUN_UP / np.pi * np.sin(np.pi * t / RUN_UP)) if t < RUN_UP else SPEED * (t - 0.5 * RUN_UP)
    )
    return 0.5 * np.pi + turned


def freudenstein(phi: np.ndarray) -> np.ndarray:
    """Angle ψ of the rocker from x towards z, on the branch with the linkage open."""
    k1, k2 = GROUND / CRANK, GROUND / ROCKER
    k3 = (CRANK**2 - COUPLER**2 + ROCKER**2 + GROUND**2) / (2.0 * CRANK * ROCKER)
    # k1 cos ψ − cos φ cos ψ − sin φ sin ψ = k2 cos φ − k3, of which tan ψ/2 is a root
    A, B, C = np.cos(phi) - k1 - k2 * np.cos(phi) + k3, -2.0 * np.sin(phi), k1 - (k2 + 1.0) * np.cos(phi) + k3
    return 2.0 * np.arctan((-B - np.sqrt(B * B - 4.0 * A * C)) / (2.0 * A))


def linkage(stiffer: float = 1.0, skew: float = 0.0, elements: int = 4) -> dx.Model:
    """Rods and hinges; the hinge "rocker" of the rocker on the ground is turned about z by ``skew`` degrees."""
    psi = float(freudenstein(np.array(0.5 * np.pi)))
    a, d = np.array([0.0, 0.0, CRANK]), np.array([GROUND, 0.0, 0.0])
    b = d + ROCKER * np.array([np.cos(psi), 0.0, np.sin(psi)])
    moduli = {"EA": 4e5, "GA1": 1.5e5, "GA2": 1.5e5, "EI1": 300.0, "EI2": 300.0, "GJ": 230.0}
    section = dx.Section.from_moduli(**{k: v * stiffer for k, v in moduli.items()}, A_rho=1.0, I_rho1=1e-3, I_rho2=1e-3)
    y, tilted = np.array([0.0, -1.0, 0.0]), np.array([np.sin(np.radians(skew)), -np.cos(np.radians(skew)), 0.0])
    model = dx.Model(name="four-bar")
    for name, line, nodes in (
        ("crank", (np.zeros(3), a), ("O", "A")), ("coupler", (a, b), ("A'", "B")), ("rocker", (d, b), ("D", "B'")),
    ):  # fmt: skip
        model = model.rod(dx.line(*line), section, name=name, ends=nodes, elements=elements)
    model = model.hinge("O", axis=y, name="motor", prescribed=lambda t: angle(t) - 0.5 * np.pi)
    model = model.hinge("A", "A'", axis=y, name="one").hinge("B'", "B", axis=y, name="two")
    return model.hinge("D", axis=tilted, name="rocker")


def main(*, skew: float = 5.0, dt: float = 0.015, t_end: float = 4.5, out: str | None = None) -> dict[str, float]:
    """The rocker beside Freudenstein's equation, energy beside the work of the motor, and the worst laws."""
    phi = np.array([angle(k * dt) for k in range(round(t_end / dt) + 1)])
    psi = freudenstein(phi)
    runs = {
        "stiff": dx.simulate(linkage(1e5), t_end, dt, raise_on_failure=True),
        "flexible": dx.simulate(linkage(), t_end, dt, raise_on_failure=True),
        f"askew by {skew:g}°": dx.simulate(linkage(skew=skew), t_end, dt, raise_on_failure=True),
    }
    swing, found = float(np.ptp(psi)), dict[str, float]()
    for name, result in runs.items():
        rocker = psi[0] + result.joint("rocker").coordinate
        found[f"{name}: rocker off Freudenstein / swing"] = float(np.abs(rocker - psi).max() / swing)
        found[f"{name}: worst law"] = max(entry.value for entry in result.audit.entries)
        energy = result.energy
        found[f"{name}: energy − work of the motor"] = float(
            np.abs(energy.total - energy.prescribed).max() / energy.total.max()
        )
    for name, value in found.items():
        print(f"{name:<44} {value:.1e}")
    print(result)
    if out is not None:
        path = Path(out) / "four_bar.png"
        draw(runs, phi, psi, path)
        print(path)
    return found


def draw(runs: dict[str, dx.Result], phi: np.ndarray, psi: np.ndarray, path: Path) -> None:
    """The linkage askew, the rocker over the crank, and what the motor gives."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(15, 4.8), layout="constrained")
    result = list(runs.values())[-1]
    space = figure.add_subplot(1, 3, 1, projection="3d")
    result.plot.shape(ax=space)
    space.yaxis.set_major_locator(plt.MaxNLocator(3))
    middle, right = figure.add_subplot(1, 3, 2), figure.add_subplot(1, 3, 3)
    for (name, run), colour in zip(runs.items(), ("#1f6fb4", "#2b8a4b", "#d2601a"), strict=True):
        rocker = psi[0] + run.joint("rocker").coordinate
        middle.plot(np.degrees(phi), np.degrees(rocker), color=colour, lw=1.6, label=name)
        right.plot(run.t[1:], -run.joint("motor").moment[1:, 1], color=colour, lw=1.2, label=f"motor, {name}")
    middle.plot(np.degrees(phi[::12]), np.degrees(psi[::12]), "k+", label="Freudenstein")
    middle.set(xlabel="angle of the crank [°]", ylabel="angle of the rocker [°]")
    across = np.linalg.norm(result.joint("rocker").moment[1:, [0, 2]], axis=1)
    right.plot(result.t[1:], across, "--", color="#d2601a", lw=1.2, label="across the hinge askew")
    right.set(xlabel="t", ylabel="moment")
    for pen in (middle, right):
        pen.legend(frameon=False)
    figure.savefig(path, dpi=120)


def test_the_rocker_follows_freudenstein_and_the_motor_pays() -> None:
    found = main()
    assert found["stiff: rocker off Freudenstein / swing"] <= 1e-5
    assert found["flexible: rocker off Freudenstein / swing"] >= 1e-4
    for name, value in found.items():
        if "law" in name or "work" in name:
            assert value <= 1e-10, name


if __name__ == "__main__":
    from _command import run

    run(main)
