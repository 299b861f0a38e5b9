"""Swinging rod
============

A heavy rod let go: pinned at one end, released from the horizontal under gravity.

Nothing is prescribed and nothing dissipates, so what the rod gains in speed and strain is what gravity puts in:
H(t) − H(0) = work of gravity in every step, whatever the step. A stiff rod starts to fall like the compound
pendulum, φ̈ = 3g/2L at the horizontal.

    python examples/swinging_rod.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx


def main(
    *, E: float = 5e6, dt: float = 0.01, t_end: float = 2.0, elements: int = 10, out: str | None = None
) -> dx.Result:
    """A rubber rod 1 m long, 1 cm in radius; prints the audit, draws and writes the animation if ``out`` is given."""
    section = dx.Section.circle(radius=0.01, E=E, nu=0.5, rho=1100)
    model = (
        dx.Model(name="swinging rod")
        .rod(dx.line((0, 0, 0), (1, 0, 0)), section, name="rod", ends=("pin", "tip"), elements=elements)
        .pin("pin")
        .gravity((0, 0, -9.81))
    )
    result = dx.simulate(model, t_end=t_end, dt=dt)
    print(result)
    if out is not None:
        folder = Path(out)
        ax = result.plot.motion()
        ax.figure.savefig(folder / "swinging_rod.png", dpi=150)
        print(folder / "swinging_rod.png", result.view(folder / "swinging_rod.html"), sep="\n")
    return result


def test_the_ledger_closes() -> None:
    result = main()
    assert result.success and result.audit.passed
    scale = np.abs(result.energy.work).max()
    assert np.abs(result.energy.residual).max() <= 1e-11 * scale
    assert scale > 0.1  # J: it has moved


def test_a_stiff_rod_falls_like_a_pendulum() -> None:
    t, g = 0.05, 9.81
    result = main(E=5e10, dt=0.0005, t_end=t)
    fall = -result.node("tip").displacement[-1, 2]
    assert abs(fall - 0.75 * g * t**2) <= 2e-3 * fall


if __name__ == "__main__":
    from _command import run

    run(main)
