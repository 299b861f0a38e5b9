"""Slider–crank
============

Slider–crank with a flexible connecting rod at 1400 revolutions a minute.

A rigid crank of 0.15 m turns in the x–z plane; its angle is prescribed and runs up to 150 rad/s within one revolution.
A steel rod, 0.3 m long and 6 mm thick, hinges it to a slider of 33 g on the x axis: four joints, of which only the
hinges of the rod are between bodies that move.

* Made a hundred thousand times as stiff, the rod moves the slider as the closed form says:
  x = a cos φ + √(l² − a² sin² φ).
* As it is, its middle bends by more than a hundredth of its length. The reference is the linear beam on the rigid
  motion: six sine waves, driven by the rod's own inertia, and the axial force of rod and slider, which is a
  quarter of the buckling load.

    python examples/slider_crank.py [--dt 2e-4] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import directrix as dx

CRANK, ROD, THICK, E, RHO, SLIDER, SPEED = 0.15, 0.3, 6e-3, 2e11, 7870.0, 0.033, 150.0
RUN_UP = 4.0 * np.pi / SPEED  # one revolution
AREA, SECOND = 0.25 * np.pi * THICK**2, np.pi * THICK**4 / 64.0
Y = (0, -1, 0)  # a turn about −y takes x to z


def angle(t: float) -> float:
    """Of the crank: its speed rises as sin² and stays."""
    if t < RUN_UP:
        return 0.5 * SPEED * (t - RUN_UP / np.pi * np.sin(np.pi * t / RUN_UP))
    return SPEED * (t - 0.5 * RUN_UP)


def ends(t: float) -> np.ndarray:
    """Ends (2, 2) in x, z of a rigid rod: the closed form."""
    phi = angle(t)
    x, z = CRANK * np.cos(phi), CRANK * np.sin(phi)
    return np.array([[x, z], [x + np.sqrt(ROD**2 - z**2), 0.0]])


def mechanism(stiffer: float = 1.0, elements: int = 6) -> dx.Model:
    """Bodies "crank" and "slider", the rod from "big" to "small" with "mid" between."""
    section = dx.Section.circle(radius=0.5 * THICK, E=E * stiffer, nu=0.3, rho=RHO)
    a, b = (CRANK, 0.0, 0.0), (CRANK + ROD, 0.0, 0.0)
    return (
        dx.Model(name="slider–crank")
        .rod(dx.line(a, b), section, name="rod", ends=("big", "small"), elements=elements, nodes={"mid": 0.5})
        .node("crank", (0, 0, 0))
        .node("slider", b)
        .rigid_body("crank", 0.1, 1e-4 * np.eye(3))
        .point_mass("slider", SLIDER)
        .hinge("crank", axis=Y, name="motor", prescribed=angle)
        .hinge("crank", "big", axis=Y, at=a, name="crank pin")
        .hinge("small", "slider", axis=Y, at=b, name="slider pin")
        .slider("slider", axis=(1, 0, 0), name="guide")
    )


def bending(result: dx.Result) -> np.ndarray:
    """How far the middle is off the chord (nt,), positive to the left of big → small."""
    big, mid, small = (result.node(n).r[:, [0, 2]] for n in ("big", "mid", "small"))
    chord = (small - big) / np.linalg.norm(small - big, axis=1)[:, None]
    return chord[:, 0] * (mid - big)[:, 1] - chord[:, 1] * (mid - big)[:, 0]


def linear_beam(times: np.ndarray, waves: int = 6) -> np.ndarray:
    """The same (nt,) by Galerkin's method: sine waves on the rigid motion, with the axial force it causes."""
    mass, h = RHO * AREA, 1e-5
    k = np.pi * np.arange(1, waves + 1) / ROD
    s = (np.arange(400) + 0.5) * ROD / 400
    slopes = k[:, None] * np.cos(np.outer(k, s))

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        before, now, after = ends(t - h), ends(t), ends(t + h)
        (a, b) = (after - 2.0 * now + before) / h**2
        along = (now[1] - now[0]) / ROD
        normal = np.array([-along[1], along[0]])
        spin = (after[1] - after[0] - before[1] + before[0]) / (2.0 * h * ROD) @ normal
        side = mass * ROD * (0.5 * a + (b - a) / 3.0) @ normal  # force of the slider on the rod, across it
        push = np.array([-SLIDER * b[0], 0.0])
        push[1] = (side - push[0] * normal[0]) / normal[1]
        axial = push @ along - mass * ((ROD - s) * (a @ along) + 0.5 * (ROD - s**2 / ROD) * ((b - a) @ along))
        stiff = (slopes * axial) @ slopes.T * 2.0 / (mass * 400)
        drive = -2.0 / (k * ROD) * (a @ normal - (-1.0) ** np.arange(1, waves + 1) * (b @ normal))
        q, v = np.split(y, 2)
        return np.concatenate([v, drive - (E * SECOND / mass * k**4 - spin**2) * q - stiff @ q])

    y = solve_ivp(rate, (0.0, times[-1]), np.zeros(2 * waves), "LSODA", times, rtol=1e-7, atol=1e-10).y[:waves]
    return np.sin(0.5 * np.pi * np.arange(1, waves + 1)) @ y


def main(*, dt: float = 2e-4, t_end: float = 0.14, out: str | None = None) -> dict[str, float]:
    """The slider beside the closed form, the bending beside the linear beam's, and the worst law."""
    stiff, result = (dx.simulate(mechanism(times), t_end, dt, raise_on_failure=True) for times in (1e5, 1.0))
    exact = np.array([ends(t)[1, 0] for t in stiff.t])
    bent, known = bending(result), linear_beam(result.t)
    peak = float(np.abs(known).max())
    found = {
        "stiff: slider off the closed form / stroke": float(
            np.abs(stiff.node("slider").r[:, 0] - exact).max() / (2 * CRANK)
        ),
        "largest bending / length": float(np.abs(bent).max() / ROD),
        "linear beam": peak / ROD,
        "bending off the linear beam / largest": float(np.abs(bent - known).max() / peak),
        "worst law": max(entry.value for run in (stiff, result) for entry in run.audit.entries),
    }
    for name, value in found.items():
        print(f"{name:<44} {value:.3g}")
    print(result)
    if out is not None:
        path = Path(out) / "slider_crank.png"
        draw(result, bent, known, path)
        print(path)
    return found


def draw(result: dx.Result, bent: np.ndarray, known: np.ndarray, path: Path) -> None:
    """The last revolution with its bending drawn large, the bending in time, and what motor and guide do."""
    from matplotlib import pyplot as plt

    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained")
    last = np.searchsorted(result.t, result.t[-1] - 2.0 * np.pi / SPEED)
    for k in np.linspace(last, len(result.t) - 1, 9).astype(int)[:-1]:
        colour = plt.colormaps["viridis"]((k - last) / (len(result.t) - last))
        r = result.r[k, result.mesh.rods[0].nodes][:, [0, 2]]
        chord = np.linspace(0.0, 1.0, len(r))[:, None] * (r[-1] - r[0]) + r[0]
        left.plot(*np.vstack([[0, 0], chord + 10 * (r - chord)]).T, color=colour, lw=1.8)
        left.plot(*r[[0, -1]].T, "o", mfc="white", mec=colour, ms=5)
    left.set(xlabel="x", ylabel="z", title="last revolution, bending ten times as large", aspect="equal")
    middle.plot(result.t, bent / ROD, color="#1f6fb4", lw=2.4, label="rod")
    middle.plot(result.t, known / ROD, "--", color="#d2601a", lw=1.2, label="linear beam on the rigid motion")
    middle.set(xlabel="t", ylabel="bending of the middle / length")
    middle.legend(frameon=False, loc="lower left")
    motor, guide = result.joint("motor").moment[1:, 1], result.joint("guide").force[1:, 2]
    right.plot(result.t[1:], -motor, color="#1b2733", lw=1.2, label="moment of the motor")
    right.plot(result.t[1:], 0.1 * guide, color="#2b8a4b", lw=1.2, label="a tenth of the force of the guide")
    right.set(xlabel="t")
    right.legend(frameon=False)
    figure.savefig(path, dpi=120)


def test_a_stiff_rod_moves_the_slider_as_the_closed_form_and_a_steel_rod_bends_as_a_beam() -> None:
    found = main(t_end=0.1)
    assert found["stiff: slider off the closed form / stroke"] <= 1e-9
    assert found["largest bending / length"] > 0.01
    assert found["bending off the linear beam / largest"] <= 0.03
    assert found["worst law"] <= 1e-10


if __name__ == "__main__":
    from _command import run

    run(main)
