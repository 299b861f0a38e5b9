"""Robot arms
==========

After Simo & Vu-Quoc (1986): one thrown by a moment, one turned by its motor, one with an elbow.

Arms of length 10 lie along x and move in the x–z plane, turning from x towards z. Data and reference displacements of
the tips are those of AeroBeams (its examples momentDrivenRobotArm, rotationDrivenRobotArm and
rotationDrivenArticulatedRobotArm); of the paper only what these programs took from it is used.

* thrown: EA = GA = 10⁴, EI = 10³, A_ρ = 1, I_ρ = 10; a moment 80 acts on the pinned end until t = 2.5. Nothing else has
  a moment about the pin, so the angular momentum is 200 from then on, to round-off. AeroBeams' step takes the mean of
  the moment at both ends and its moment ends at t = 2.4: ``load_rule="average"`` with the same data is the same load.
* turned: the same arm; the motor's angle rises to 1.5 within 5 and stays. All the energy is the motor's work.
* elbow: EA = GA = 10⁶, EI = 10⁵, I_ρ = 1, with a hinge in the middle; the motor goes to 1.5 within 0.5 at once.

    python examples/robot_arm.py [--elements 10] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

# displacement (x, z) at times: printed by AeroBeams, 40 linear elements (20 with elbow), Δt = 0.1 (0.01)
THROWN = {
    1.0: (-0.143287, 0.389326),
    2.5: (-1.651754, 5.510698),
    5.0: (-11.442239, 9.896217),
    13.0: (-4.214188, -8.164952),
}
TURNED = {2.5: (-1.261328, 4.782856), 5.0: (-12.587693, 9.578202), 9.0: (-4.813151, 8.196610)}
ELBOW = {0.25: (-3.451004, -0.491326), 0.5: (-7.792780, 0.574893), 1.0: (-14.959083, 3.949097)}
Y = (0, 1, 0)


def section(EA: float, EI: float, rotary: float) -> dx.Section:
    """GA = EA, GJ = EI, A_ρ = 1."""
    return dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=EI, EI2=EI, GJ=EI, A_rho=1.0, I_rho1=rotary, I_rho2=rotary)


def arm(elements: int, **motor: object) -> dx.Model:
    """One arm on a hinge "motor"."""
    axis = dx.line((0, 0, 0), (10, 0, 0))
    model = dx.Model(name="robot arm").rod(
        axis, section(1e4, 1e3, 10.0), name="arm", ends=("base", "tip"), elements=elements
    )
    return model.hinge("base", axis=Y, name="motor", **motor)


def ramp(angle: float, until: float):
    """An angle that rises to ``angle``; positive from x towards z, which is −y."""
    return lambda t: -angle * min(t / until, 1.0)


def jointed(elements: int) -> dx.Model:
    """Two halves joined by a hinge "elbow", on a fast motor."""
    stiff = section(1e6, 1e5, 1.0)
    model = dx.Model(name="robot arm with elbow")
    model = model.rod(dx.line((0, 0, 0), (5, 0, 0)), stiff, name="upper", ends=("base", "in"), elements=elements // 2)
    model = model.rod(dx.line((5, 0, 0), (10, 0, 0)), stiff, name="fore", ends=("out", "tip"), elements=elements // 2)
    return model.hinge("base", axis=Y, name="motor", prescribed=ramp(1.5, 0.5)).hinge("in", "out", axis=Y, name="elbow")


def main(*, elements: int = 10, t_end: float = 15.0, out: str | None = None) -> dict[str, float]:
    """Deviations, relative to what the print says."""

    def block(t: float) -> tuple[float, float, float]:
        return 0.0, -80.0 * (t <= 2.45), 0.0

    runs = {
        "thrown": dx.simulate(
            arm(elements).moment("base", block), t_end, 0.1, load_rule="average", raise_on_failure=True
        ),
        "turned": dx.simulate(arm(elements, prescribed=ramp(1.5, 5.0)), 0.6 * t_end, 0.1, raise_on_failure=True),
        "elbow": dx.simulate(jointed(elements), 0.1 * t_end, 0.01, raise_on_failure=True),
    }
    exact = dx.simulate(arm(elements).moment("base", lambda t: (0, -80.0 * (t <= 2.5), 0)), 5.0, 0.1)
    after = exact.momentum.angular[exact.t > 2.5 + 1e-9, 1]
    found = {"angular momentum after 2.5, off 200": float(np.abs(after + 200.0).max() / 200.0)}
    for (name, result), known in zip(runs.items(), (THROWN, TURNED, ELBOW), strict=True):
        print(f"{result}\n  {name}: displacement of the tip, and AeroBeams'")
        off = 0.0
        for t, u in known.items():
            got = result.node("tip").displacement[np.argmin(np.abs(result.t - t))][[0, 2]]
            off = max(off, float(np.abs(got - u).max()) / 10.0)
            print(f"    t = {t:5.2f}   {got}   {np.array(u)}")
        found[f"{name}, tip off AeroBeams' / length"] = off
        found[f"{name}, worst law"] = max(entry.value for entry in result.audit.entries)
    turned = runs["turned"]
    due = np.array([ramp(1.5, 5.0)(t) for t in turned.t])
    found["turned, angle of the motor off"] = float(np.abs(turned.joint("motor").coordinate - due).max())
    energy = turned.energy
    found["turned, energy − work of the motor"] = float(
        np.abs(energy.total - energy.prescribed).max() / energy.total.max()
    )
    for name, value in found.items():
        print(f"{name:<40} {value:.1e}")
    if out is not None:
        path = Path(out) / "robot_arm.png"
        draw(runs, path)
        print(path)
    return found


def draw(runs: dict[str, dx.Result], path: Path) -> None:
    """Shapes on the way, and what each motor holds."""
    from matplotlib import pyplot as plt

    figure, panels = plt.subplots(2, 3, figsize=(13, 7.6), layout="constrained", height_ratios=(1.6, 1))
    for (name, result), above, below in zip(runs.items(), *panels, strict=True):
        result.plot.motion(24, ax=above)
        above.set_title(name)
        moment = -result.joint("motor").moment[1:, 1] if name != "thrown" else result.joint("motor").force[1:]
        lines = below.plot(result.t[1:], moment, lw=1.2)
        below.set(xlabel="t", ylabel="moment of the motor" if name != "thrown" else "force of the pin")
        if name == "thrown":
            for line, letter in zip(lines, "xyz", strict=True):
                line.set_label(f"$F_{letter}$")
            below.legend(frameon=False)
    figure.savefig(path, dpi=130)


def test_arms_move_as_known_and_momenta_add_up() -> None:
    found = main()
    assert found["angular momentum after 2.5, off 200"] <= 1e-12
    assert found["thrown, tip off AeroBeams' / length"] <= 0.01
    assert found["turned, tip off AeroBeams' / length"] <= 0.01
    assert found["elbow, tip off AeroBeams' / length"] <= 0.02
    assert found["turned, angle of the motor off"] <= 1e-12
    assert found["turned, energy − work of the motor"] <= 1e-12
    assert max(value for name, value in found.items() if "worst law" in name) <= 1e-10


if __name__ == "__main__":
    from _command import run

    run(main)
