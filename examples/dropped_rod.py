"""Dropped rod
===========

A rod dropped on a floor: it hits with one end, slaps down, bends, jumps, and friction brings it to rest sideways.

The floor is a plane with a penalty: a force per length that grows with the penetration. A step takes the mean force
of the penalty's energy, so that bouncing loses nothing whatever the step, and friction is booked as what it takes:
H − H(0) = work of gravity − dissipated. A rod that falls level and without friction rebounds to where it fell from.

    python examples/dropped_rod.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx


def main(
    *, height: float = 0.3, tilt: float = 0.15, friction: float = 0.3, dt: float = 0.001, t_end: float = 1.0,
    elements: int = 8, out: str | None = None,
) -> dx.Result:  # fmt: skip
    """A rubber rod 1 m long, 2 cm in radius, let go with one end ``tilt`` above the other; drawn with ``out``."""
    section = dx.Section.circle(radius=0.02, E=5e6, nu=0.45, rho=1100)
    low = 0.02 + height
    model = (
        dx.Model(name="dropped rod")
        .rod(dx.line((0, 0, low), (1, 0, low + tilt)), section, name="rod", ends=("a", "b"), elements=elements)
        .rigid_velocity((0, 0.5, 0))
        .gravity((0, 0, -9.81))
        .contact(
            dx.Plane((0, 0, 0), (0, 0, 1)), stiffness=1e6, friction=friction, slip_speed=0.01 if friction else None,
            name="floor",
        )
    )  # fmt: skip
    result = dx.simulate(model, t_end=t_end, dt=dt)
    print(result)
    floor = result.contact("floor")
    print(f"deepest in the floor {-1e3 * floor.gap.min():.2f} mm, largest force {floor.force.max():.0f} N")
    if out is not None:
        _draw(result, Path(out) / "dropped_rod.png")
    return result


def _draw(result: dx.Result, path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (side, books) = plt.subplots(2, 1, figsize=(8, 7), layout="constrained")
    chosen = np.linspace(0, len(result.t) - 1, 11).astype(int)
    for k in chosen:
        shade = plt.get_cmap("viridis")(k / len(result.t))
        side.plot(*result.r[k][:, [0, 2]].T, color=shade, label=f"{result.t[k]:.1f} s")
    side.axhline(0.0, color="0.4", lw=3)
    side.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", title="side view")
    side.legend(fontsize=7, ncols=2, loc="upper left", bbox_to_anchor=(1, 1))
    energy = result.energy
    books.plot(result.t, energy.total - energy.work, label="energy, with that of gravity since the start")
    books.plot(result.t, energy.total[0] - energy.dissipated, "--", label="start − taken by friction")
    books.plot(result.t, energy.stored, label="stored in rod and floor")
    books.set(xlabel="t [s]", ylabel="[J]")
    books.legend()
    figure.savefig(path, dpi=130)
    print(path)


def test_the_ledger_closes() -> None:
    result = main()
    assert result.success and result.audit.passed
    energy = result.energy
    scale = max(np.abs(energy.work).max(), energy.total.max())
    assert np.abs(energy.residual).max() <= 1e-10 * scale
    assert energy.dissipated[-1] > 0.1 and np.all(np.diff(energy.dissipated) >= 0.0)


def test_a_level_rod_rebounds_to_where_it_fell_from() -> None:
    """With the period of the fall, 2√(2h/g), and the time on the floor."""
    height, g = 0.05, 9.81
    result = main(height=height, tilt=0.0, friction=0.0, dt=0.0005, t_end=2.5)
    z = result.node("a").r[:, 2] - 0.02
    apex = np.flatnonzero((z[1:-1] >= z[:-2]) & (z[1:-1] > z[2:])) + 1
    assert len(apex) >= 10
    np.testing.assert_allclose(z[apex], height, rtol=1e-4)
    period = np.diff(result.t[apex]).mean()
    flight = 2.0 * np.sqrt(2.0 * height / g)
    on_floor = period - flight
    spring = np.pi * np.sqrt(np.pi * 0.02**2 * 1100 / 1e6)  # half a period on the penalty as a linear spring
    assert 0.8 * spring < on_floor < 2.0 * spring


if __name__ == "__main__":
    from _command import run

    run(main)
