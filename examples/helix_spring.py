"""Rate of a helix spring
======================

The rate of a helix spring, against the formula of springs and against Castigliano's theorem.

A wire of diameter d is wound into n coils of mean diameter D and pressed along its axis between seats that neither turn
nor shift. The formula of springs, k = G d⁴/(8 D³ n), knows torsion of the wire alone. Castigliano's theorem with all
six section forces of the wire is exact for small loads: the forces and moments W on the seat move it by ∫ Jᵀ C⁻¹ J
ds W, J W the section forces on the helix, and five of its six components must vanish. A long stroke follows, on
which the coils flatten and the rate changes.

    python examples/helix_spring.py [--turns 6] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx
from directrix import generate

E, NU, WIRE, RADIUS, PITCH = 206e9, 0.3, 0.003, 0.015, 0.009


def castigliano(section: dx.Section, turns: float) -> float:
    """Force along the axis over travel of the seat."""
    climb = PITCH / (2.0 * np.pi)
    angle, height = np.linspace(0.0, 2.0 * np.pi * turns, 4001), PITCH * turns
    flexible, compliance = np.zeros((6, 6)), np.linalg.inv(section.stiffness)
    weights = np.full(len(angle), angle[1] * np.hypot(RADIUS, climb))
    weights[[0, -1]] *= 0.5
    for a, w in zip(angle, weights, strict=True):
        out = np.array([np.cos(a), np.sin(a), 0.0])
        tangent = np.array([-RADIUS * np.sin(a), RADIUS * np.cos(a), climb]) / np.hypot(RADIUS, climb)
        frame = np.stack([out, np.cross(tangent, out), tangent])
        x, y, z = np.array([0.0, 0.0, height]) - (*(RADIUS * out[:2]), climb * a)
        J = np.zeros((6, 6))
        J[:3, :3] = J[3:, 3:] = frame
        J[3:, :3] = frame @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        flexible += w * J.T @ compliance @ J
    return float(np.linalg.inv(flexible)[2, 2])


def main(*, turns: float = 6.0, elements_per_turn: int = 10, out: str | None = None) -> dict[str, float]:
    """Rates beside the formulas; what a travel of 40 % of the height takes."""
    section = dx.Section.circle(radius=WIRE / 2, E=E, nu=NU, rho=7850)
    held = (
        generate.spring(RADIUS, PITCH, turns, section, elements_per_turn=elements_per_turn, seats=True)
        .clamp("base")
        .fix("head", "x", "y", "rx", "ry", "rz")
    )
    formula = E / (2.0 * (1.0 + NU)) * WIRE**4 / (8.0 * (2.0 * RADIUS) ** 3 * turns)
    small = 1e-4 * formula * PITCH
    pressed = [dx.solve_static(held.force("head", (0, 0, f)), steps=1, raise_on_failure=True) for f in (small, -small)]
    travel = [run.node("head").displacement[-1, 2] for run in pressed]
    height = PITCH * turns
    stroke = 0.4 * height
    model = held.force("head", (0, 0, -formula * stroke))
    control = dx.DisplacementControl("head", "z", to=-stroke, steps=8)
    long = dx.solve_static(model, control=control, raise_on_failure=True)
    found = {
        "rate": 2.0 * small / (travel[0] - travel[1]),
        "Castigliano": castigliano(section, turns),
        "G d⁴/(8 D³ n)": formula,
        "force at 40 % travel, of linear": float(
            long.load_factor[-1] * formula * stroke / (castigliano(section, turns) * stroke)
        ),
    }
    for name, value in found.items():
        print(f"{name:<32} {value:.9g}")
    if out is not None:
        path = Path(out) / "helix_spring.png"
        draw(long, formula * stroke, castigliano(section, turns), path)
        print(path)
    return found


def draw(long: dx.Result, force: float, rate: float, path: Path) -> None:
    """The spring free and pressed, and force over travel."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(10, 4.5), layout="constrained")
    space = figure.add_subplot(1, 2, 1, projection="3d")
    wire = long.mesh.rods[0]
    for k, color, shift in ((0, "#8a949e", -0.025), (-1, "#1f5fa8", 0.025)):
        r = long.r[k, wire.nodes] + (shift, 0, 0)
        space.plot(*r.T, color=color, lw=2.5)
    space.set_aspect("equal")
    space.set(yticks=(), xticks=(-0.03, 0.0, 0.03))
    space.set_title("free and pressed")
    right = figure.add_subplot(1, 2, 2)
    travel = -long.node("head").displacement[:, 2]
    right.plot(1e3 * travel, rate * travel, color="#8a949e", label="linear, Castigliano")
    right.plot(1e3 * travel, long.load_factor * force, ".-", color="#1f5fa8", label="directrix")
    right.set(xlabel="travel [mm]", ylabel="force [N]")
    right.legend()
    figure.savefig(path, dpi=130)


def test_a_spring_has_the_rate_of_castigliano_and_nearly_that_of_the_formula() -> None:
    found = main(turns=3.0)
    assert abs(found["rate"] / found["Castigliano"] - 1.0) <= 3e-4
    assert 0.005 < abs(found["rate"] / found["G d⁴/(8 D³ n)"] - 1.0) < 0.05
    assert abs(found["force at 40 % travel, of linear"] - 1.0) > 0.001


if __name__ == "__main__":
    from _command import run

    run(main)
