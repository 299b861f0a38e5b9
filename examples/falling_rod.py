"""Falling rod
===========

A rod sinks through a fluid at rest until the drag carries its weight.

The drag per length is c_n v_n² across the axis and c_t v_t² along it. Let go at an inclination α, a stiff rod keeps it,
because the drag is the same all along, and slides sideways: with m the mass per length its terminal velocity has the
components v_n = √(m g cos α/c_n) and v_t = √(m g sin α/c_t). Level, its speed is v_n tanh(g t/v_n), and it has fallen
by (v_n²/g) ln cosh(g t/v_n). What the fluid takes is booked in every step: the ledger of energy closes to round-off.

    python examples/falling_rod.py [--degrees 30] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

LENGTH, MASS, G, NORMAL, TANGENTIAL = 1.0, 0.4, 9.81, 5.0, 0.8


def rod(degrees: float) -> dx.Model:
    """The rod in its fluid, at rest."""
    section = dx.Section.from_moduli(
        EA=1e5, GA1=4e4, GA2=4e4, EI1=50, EI2=50, GJ=40, A_rho=MASS, I_rho1=1e-4, I_rho2=1e-4
    )
    alpha = np.radians(degrees)
    end = (LENGTH * np.cos(alpha), 0, -LENGTH * np.sin(alpha))
    model = dx.Model(name="falling rod").rod(
        dx.line((0, 0, 0), end), section, name="rod", ends=("a", "b"), nodes={"middle": 0.5}, elements=4
    )
    return model.gravity((0, 0, -G)).drag("rod", NORMAL, TANGENTIAL)


def main(*, degrees: float = 30.0, t_end: float = 6.0, dt: float = 0.01, out: str | None = None) -> dict[str, float]:
    """Terminal velocity across and along, the fall of the level rod against its closed form, closing of the ledger."""
    fall, level = (dx.simulate(rod(a), t_end, dt, raise_on_failure=True) for a in (degrees, 0.0))
    alpha = np.radians(degrees)
    along, across = np.array([np.cos(alpha), 0, -np.sin(alpha)]), np.array([np.sin(alpha), 0, np.cos(alpha)])
    v = fall.node("middle").v[-1]
    last = np.sqrt(MASS * G / NORMAL)
    exact = -(last**2 / G) * np.log(np.cosh(G * level.t / last))
    found = {
        "across": float(-v @ across),
        "across, exact": float(np.sqrt(MASS * G * np.cos(alpha) / NORMAL)),
        "along": float(v @ along),
        "along, exact": float(np.sqrt(MASS * G * np.sin(alpha) / TANGENTIAL)),
        "level, error of the path": float(np.abs(level.node("middle").displacement[:, 2] - exact).max() / -exact[-1]),
        "ledger": max(float(np.abs(r.energy.residual).max() / r.energy.work[-1]) for r in (fall, level)),
    }
    for name, value in found.items():
        print(f"{name:<26} {value:.9g}")
    print(fall)
    if out is not None:
        print(picture(fall, level, Path(out) / "falling_rod.png"))
    return found


def picture(fall: dx.Result, level: dx.Result, path: Path) -> Path:
    """The inclined rod on its way; speed of the level one against tanh; where the energy went."""
    from matplotlib import pyplot

    figure, (way, speed, energy) = pyplot.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    for k in range(0, len(fall.t) // 3, 15):
        way.plot(fall.r[k, :, 0], fall.r[k, :, 2], color="#1f4e79", lw=2, alpha=0.35 + 0.65 * 3 * k / len(fall.t))
    way.set(title="every 0.15", xlabel="x", ylabel="z", aspect="equal")
    last = np.sqrt(MASS * G / NORMAL)
    early = level.t <= 1.0
    speed.plot(level.t[early], last * np.tanh(G * level.t[early] / last), color="#999999", lw=4, label="closed form")
    speed.plot(level.t[early], -level.node("middle").v[early, 2], color="#1f4e79", lw=1.5, label="level rod")
    speed.set(title="speed of the level rod", xlabel="t", ylabel="v")
    for name, values in (
        ("work of the weight", fall.energy.work),
        ("taken by the fluid", fall.energy.dissipated),
        ("kinetic", fall.energy.kinetic),
    ):
        energy.plot(fall.t, values, lw=1.5, label=name)
    energy.set(title="energy of the inclined rod", xlabel="t")
    speed.legend()
    energy.legend()
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    return path


def test_the_terminal_velocity_is_the_closed_form() -> None:
    found = main()
    for name in ("across", "along"):
        assert abs(found[name] - found[f"{name}, exact"]) <= 1e-8 * found[f"{name}, exact"]
    assert found["level, error of the path"] <= 1e-4
    assert found["ledger"] <= 1e-10


if __name__ == "__main__":
    from _command import run

    run(main)
