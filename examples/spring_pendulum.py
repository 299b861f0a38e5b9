"""Spring pendulum
===============

A mass on a spring that swings: at the ratio 2 : 1 of its frequencies the energy wanders between bouncing and swinging.

Vitt and Gorelik (1933). A mass of 1 hangs on a spring of unstretched length ℓ0 and stiffness k with √(k/m) = 2 √(g/ℓ),
ℓ its length at rest. Pulled down and let go almost straight, it first bounces, then swings, then bounces again. There
is no rod: a node, a mass and a link are a model too. The reference is the Lagrangian's two equations, integrated to
twelve digits; steps of Δt and Δt/2 extrapolated meet it. The energy is kept in every step whatever Δt.

    python examples/spring_pendulum.py [--dt 0.05] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import directrix as dx

G, REST, MASS = 1.0, 1.0, 1.0
STIFFNESS = 4.0 * G * MASS / REST  # twice the frequency of swinging
FREE = REST - MASS * G / STIFFNESS
START = np.array([0.05, 0.0, -1.3])


def pendulum() -> dx.Model:
    """Hangs from the origin, let go at rest."""
    model = dx.Model(name="spring pendulum").node("bob", START).point_mass("bob", MASS).gravity((0, 0, -G))
    return model.spring("bob", (0, 0, 0), STIFFNESS, length=FREE, name="spring")


def reference(times: np.ndarray) -> np.ndarray:
    """Places (nt, 3) of the mass by Newton's law."""

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        length = np.linalg.norm(y[:3])
        pull = -STIFFNESS * (length - FREE) / (MASS * length) * y[:3]
        return np.concatenate([y[3:], pull - np.array([0, 0, G])])

    start = np.concatenate([START, np.zeros(3)])
    return solve_ivp(rate, (0.0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-13).y[:3].T


def main(*, dt: float = 0.05, t_end: float = 40.0, out: str | None = None) -> dict[str, float]:
    """Largest errors of the place with Δt, Δt/2 and extrapolated, and of the energy."""
    coarse = dx.simulate(pendulum(), t_end, dt, raise_on_failure=True)
    fine = dx.simulate(pendulum(), t_end, 0.5 * dt, save_every=2, raise_on_failure=True)
    exact = reference(coarse.t)
    places = {"Δt": coarse.node("bob").r, "Δt/2": fine.node("bob").r}
    places["extrapolated"] = (4.0 * places["Δt/2"] - places["Δt"]) / 3.0
    found = {name: float(np.abs(place - exact).max()) for name, place in places.items()}
    found["energy"] = float(np.abs(coarse.energy.residual).max() / coarse.energy.stored[0])
    for name, value in found.items():
        print(f"{name:<14} off by {value:.3e}")
    if out is not None:
        path = Path(out) / "spring_pendulum.png"
        draw(coarse, exact, path)
        print(path)
    return found


def draw(result: dx.Result, exact: np.ndarray, path: Path) -> None:
    """The way of the mass, and its swing and bounce over time."""
    from matplotlib import pyplot as plt

    figure, (way, pen) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained", width_ratios=(1, 2))
    r = result.node("bob").r
    way.plot(r[:, 0], r[:, 2], color="#1f6fb4", lw=0.8)
    way.plot(0, 0, "k.")
    way.set(aspect="equal", xlabel="x", ylabel="z")
    pen.plot(result.t, r[:, 0], color="#c0392f", lw=1.2, label="x")
    pen.plot(result.t, r[:, 2] + REST, color="#1f6fb4", lw=1.2, label="z + ℓ")
    pen.plot(result.t, exact[:, 0], "k:", lw=1.0, label="exact x")
    pen.set(xlabel="t", title="bouncing feeds the swing, and the swing the bouncing")
    pen.legend(frameon=False, ncols=3)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def test_the_mass_goes_where_newton_sends_it() -> None:
    found = main(t_end=10.0)
    assert 3.8 < found["Δt"] / found["Δt/2"] < 4.2
    assert found["extrapolated"] < 0.03 * found["Δt"]
    assert found["energy"] < 1e-10


if __name__ == "__main__":
    from _command import run

    run(main)
