"""Flying scissors
===============

After Simo & Vu-Quoc (1986): two links joined by a hinge, thrown at one end.

Two links of 5 lie in a line from (0, 0) to (6, −8) of the x–z plane, joined by a hinge. EA = GA = 10⁶, EI = 10⁴,
A_ρ = 1; I_ρ is 10 in the first link and 1 in the second. Until t = 0.5 the free end of the second link carries a force
40 along x and a moment 160 about y. Data: AeroBeams, its example flyingScissors; of the paper only what that program
took from it is used.

What is exact, whatever mesh and step: the linear momentum is (20, 0, 0) after the load, the centre of mass is at
½ 4 t² and goes on with 2, and the angular momentum is that of the moments. For links that hardly bend (EI, EA, GA
10³ times as large) the whole motion is known: two rigid links, integrated from Newton's and Euler's equations.

The ends that AeroBeams keeps for t = 5 are shown beside ours and not judged: its step of 0.05 carries the load for
longer, and its centre of mass rises by about 0.15 although no force acts along z.

    python examples/flying_scissors.py [--dt 0.025] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import directrix as dx

A, B = np.zeros(3), np.array([6.0, 0.0, -8.0])
FORCE, MOMENT, UNTIL, LINK, MASS = 40.0, 160.0, 0.5, 5.0, 5.0
ROTARY = (10.0, 1.0)
AEROBEAMS = {"A": (10.379892, -6.187986), "in": (11.693053, -0.551942), "B": (6.444333, 7.913517)}  # t = 5


def scissors(stiffer: float = 1.0, elements: int = 5) -> dx.Model:
    """Ends "A", "B"; the hinge "pin" joins "in" to "out"."""
    middle = 0.5 * (A + B)
    model = dx.Model(name="flying scissors")
    for name, line, ends, rotary in (
        ("first", (A, middle), ("A", "in"), 10.0),
        ("second", (middle, B), ("out", "B"), 1.0),
    ):
        section = dx.Section.from_moduli(
            **{name: 1e6 * stiffer for name in ("EA", "GA1", "GA2", "GJ")}, EI1=1e4 * stiffer, EI2=1e4 * stiffer,
            A_rho=1.0, I_rho1=rotary, I_rho2=rotary,
        )  # fmt: skip
        model = model.rod(dx.line(*line), section, name=name, ends=ends, elements=elements)

    def on(t: float) -> float:
        return float(t <= UNTIL)

    model = model.force("B", lambda t: (FORCE * on(t), 0, 0)).moment("B", lambda t: (0, MOMENT * on(t), 0))
    return model.hinge("in", "out", axis=(0, 1, 0), name="pin")


def rigid(times: np.ndarray) -> np.ndarray:
    """Places (len(times), 3, 2) in x, z of A, hinge and B of two rigid links: centre and angle of each, and a hinge."""
    inertia = np.array([MASS * LINK**2 / 12.0 + rotary * LINK for rotary in ROTARY])
    axis = (B - A)[[0, 2]] / 10.0

    def along(angle: float) -> np.ndarray:
        """The link's direction after a turn about +y, which takes z to x."""
        c, s = np.cos(angle), np.sin(angle)
        return np.array([c * axis[0] + s * axis[1], c * axis[1] - s * axis[0]])

    def quarter(u: np.ndarray) -> np.ndarray:
        """y × u: dr/dt = ω quarter(r)."""
        return np.array([u[1], -u[0]])

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        on = float(t < UNTIL)
        arms = [0.5 * LINK * along(y[4]), -0.5 * LINK * along(y[5])]  # from the centres to the hinge
        omega, system, right = y[10:12], np.zeros((8, 8)), np.zeros(8)
        for k, sign in enumerate((1.0, -1.0)):  # unknowns: two accelerations, two spins, the force of the hinge
            lever = quarter(arms[k])
            system[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = MASS * np.eye(2)
            system[2 * k : 2 * k + 2, 6:] = -sign * np.eye(2)
            system[4 + k, 4 + k], system[4 + k, 6:] = inertia[k], -sign * lever
            system[6:, 2 * k : 2 * k + 2], system[6:, 4 + k] = sign * np.eye(2), sign * lever
            right[6:] += sign * omega[k] ** 2 * arms[k]
        right[2] = FORCE * on
        right[5] = on * (MOMENT + quarter(-arms[1]) @ (FORCE, 0.0))
        return np.concatenate([y[6:], np.linalg.solve(system, right)[:6]])

    y = np.concatenate([0.25 * (A + B)[[0, 2]], 0.75 * (A + B)[[0, 2]], np.zeros(8)])
    out, t = np.empty((len(times), 3, 2)), 0.0
    for k, end in enumerate(times):
        for stop in sorted({min(end, UNTIL), end}):  # the load ends with a jump
            if stop > t:
                y = solve_ivp(rate, (t, stop), y, "DOP853", rtol=1e-10, atol=1e-11).y[:, -1]
                t = stop
        first, second = 0.5 * LINK * along(y[4]), 0.5 * LINK * along(y[5])
        out[k] = y[:2] - first, y[:2] + first, y[2:4] + second
    return out


def main(*, dt: float = 0.025, t_end: float = 5.0, out: str | None = None) -> dict[str, float]:
    """Deviations from what is exact, and of the stiff scissors from rigid links; the shapes if ``out`` is given."""
    result = dx.simulate(scissors(), t_end, dt, raise_on_failure=True)
    stiff = dx.simulate(scissors(1e3), t_end, dt, raise_on_failure=True)
    steps = min(round(UNTIL / dt), len(result.t) - 1)
    r = result.node("B").r
    levers = 0.5 * (r[1:] + r[:-1])[:steps]  # a step takes its loads at its middle
    turned = dt * (np.cross(levers, (FORCE, 0, 0)) + np.array([0, MOMENT, 0])).sum(axis=0)
    spin, linear = result.momentum.angular[-1], result.momentum.linear[-1]
    known, places = rigid(stiff.t), [stiff.node(n).r[:, [0, 2]] for n in ("A", "in", "B")]
    found = {
        "linear momentum off (20, 0, 0)": float(np.abs(linear - (20, 0, 0)).max() / 20.0),
        "angular momentum off the moments'": float(np.abs(spin - turned).max() / np.abs(turned).max()),
        "worst law": max(entry.value for run in (result, stiff) for entry in run.audit.entries),
        "hinge apart": float(np.abs(result.node("in").r - result.node("out").r).max() / 10.0),
        "stiff scissors off rigid links": float(np.abs(np.stack(places, axis=1) - known).max() / 10.0),
    }
    for name, value in found.items():
        print(f"{name:<36} {value:.1e}")
    if t_end == 5.0:
        for name, u in AEROBEAMS.items():
            print(f"{name:<3} displaced by {result.node(name).displacement[-1][[0, 2]]}   AeroBeams {u}")
    print(result)
    if out is not None:
        path = Path(out) / "flying_scissors.png"
        draw(result, stiff, known, path)
        print(path)
    return found


def draw(result: dx.Result, stiff: dx.Result, known: np.ndarray, path: Path) -> None:
    """Shapes in flight, those of stiff links over rigid ones, and the force of the pin."""
    from matplotlib import pyplot as plt

    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 5), layout="constrained")
    result.plot.motion(11, ax=left)
    for k in range(0, len(stiff.t), len(stiff.t) // 10):
        for rod in stiff.mesh.rods:
            middle.plot(*stiff.r[k, rod.nodes][:, [0, 2]].T, color="#1f6fb4", lw=2.2)
        middle.plot(*known[k].T, "o--", color="#d2601a", ms=4, lw=1)
    middle.set(xlabel="x", ylabel="z", title="stiff links over rigid ones (dashed)", aspect="equal")
    force = result.joint("pin").force[1:]
    right.plot(result.t[1:], force[:, 0], color="#c0392f", label="$F_x$")
    right.plot(result.t[1:], force[:, 2], color="#2463ab", label="$F_z$")
    right.axvline(UNTIL, color="#7d8791", ls=":", label="load gone")
    right.set(xlabel="t", ylabel="force of the pin on the second link")
    right.legend(frameon=False)
    figure.savefig(path, dpi=120)


def test_momenta_are_those_of_the_load_and_stiff_links_are_rigid() -> None:
    found = main()
    assert found["linear momentum off (20, 0, 0)"] <= 1e-12
    assert found["angular momentum off the moments'"] <= 1e-12
    assert found["worst law"] <= 1e-10
    assert found["hinge apart"] <= 1e-12
    assert found["stiff scissors off rigid links"] <= 5e-3


if __name__ == "__main__":
    from _command import run

    run(main)
