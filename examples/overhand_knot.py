"""An overhand knot pulled tight
=============================

A straight elastic rod that holds itself by where it touches itself.

The rod is laid into the shape of a knot, settles there, and its ends are pulled apart; it is so light that its inertia
plays no part, and viscous, so that it creeps from one equilibrium to the next. Friction acts where the rod slides on
itself, and the ledger of the pull has what it takes. Then the loose and the tight knot are put to rest by statics.

Theory (Audoly, Clauvelin & Neukirch, Phys. Rev. Lett. 99 (2007) 164301), for a rod of radius h and bending stiffness
B, without friction and twist, as ε → 0: a pull T holds a loop of radius R with T = B/(2R²), and in the braid strands
press on one another with P = 0.492 ε³ B/h² all in all, ε⁴ = (h/R)² = 2Th²/B. Here ε is no small number; P h²/(B ε³)
grows nearly linearly with it, and two knots, extended to ε = 0, meet the value.

    python examples/overhand_knot.py [--out FOLDER]
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from _command import slow
from numpy.typing import NDArray

import directrix as dx

THEORY = 0.492  # Audoly, Clauvelin & Neukirch (2007), trefoil


def laid_out(loop: float, tail: float, radius: float) -> dx.curves.Curve:
    """A loop of radius ``loop`` between two straight ends, its strands wound round one another by three half turns."""
    apart = 2.0 * radius
    half = 2.0 * np.sqrt(apart * loop)  # of the braid; the circle is clear of the line there
    x = np.linspace(-half, half, 201)
    turn = 1.5 * np.pi * (1.0 + np.sin(0.5 * np.pi * x / half))
    share = (x / half) ** 2
    distance = np.sqrt((x**2 / (2 * loop)) ** 2 * share + (2 * apart) ** 2 * (1 - share))
    middle = np.stack([x, 0 * x, x**2 / (4 * loop)], 1)
    between = 0.5 * distance[:, None] * np.stack([0 * x, np.sin(turn), np.cos(turn)], 1)
    angle = np.linspace(0.0, 2 * np.pi, 800)
    start = 1.15 * np.arcsin(half / loop)
    angle = angle[(angle > start) & (angle < 2 * np.pi - start)]
    circle = loop * np.stack([np.sin(angle), 0 * angle, 1 - np.cos(angle)], 1)
    straight = np.linspace(-tail, -1.1 * half, 100)[:, None] * [1.0, 0.0, 0.0]
    path = np.concatenate([straight, (middle - between)[2:-2], circle, (middle + between)[2:-2], -straight[::-1]])
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    at = np.linspace(0.0, s[-1], int(s[-1] / radius))
    points = np.stack([np.interp(at, s, path[:, k]) for k in range(3)], 1)
    for _ in range(3):
        points[1:-1] = 0.25 * points[:-2] + 0.5 * points[1:-1] + 0.25 * points[2:]
    return dx.spline(points)


def main(
    *, loop: float = 18.0, final: float = 9.0, tail: float = 35.0, friction: float = 0.1, elements: int = 72,
    out: str | None = None,
) -> tuple[dx.Result, list[tuple[float, float]]]:  # fmt: skip
    """Lengths in radii of the rod, forces in B per radius squared. Returns the pull, and (ε, P h²/(B ε³)) of the loose
    and of the tight knot without friction; draws if ``out`` is given."""
    section = dx.Section.circle(radius=1.0, E=4.0 / np.pi, nu=0.3, rho=1e-4, damping=2.0)  # B = 1
    shape = laid_out(loop, tail, 1.0)
    length = shape.length
    rod = dx.Model(name="overhand knot").rod(
        dx.line((0, 0, 0), (length, 0, 0)), section, name="rod", ends=("a", "b"), elements=elements, nodes={"top": 0.5}
    )
    straight = dx.solve_static(rod.clamp("a"), steps=1)
    s = straight.mesh.rods[0].s
    turned = shape.frames(s, s) @ np.swapaxes(straight.directors("rod")[-1], 1, 2)
    knotted = replace(straight, r=shape.position(s)[None], R=turned[None])
    ends = [shape.position(np.array(at)) - (at, 0, 0) for at in (0.0, length)]
    apart = length - 2 * np.pi * final - 2 * tail  # how far the ends go

    def held(pulled, spin: float | None = None, **contact: float | None) -> dx.Model:
        """Ends at their distance; the top stays in its plane, or the loop could go round the ends for nothing."""
        model = rod.prescribe(
            "a", displacement=lambda t: ends[0] - (0.5 * apart * pulled(t), 0, 0), rotation=(0, 0, 0)
        ).fix("top", "y")

        def move(t: float) -> NDArray[np.float64]:
            return ends[1] + (0.5 * apart * pulled(t), 0, 0)

        if spin is None:  # the end may turn about the rod, which then has no twist
            model = model.prescribe("b", displacement=move).fix("b", "ry", "rz")
        else:  # in statics nothing but that would hold it
            model = model.prescribe("b", displacement=move, rotation=lambda t: (spin, 0, 0))
        return model.self_contact(stiffness=2.0, width=0.1, name="knot", **contact)

    def at_rest(state: dx.Result, pulled: float) -> dx.Result:
        R = state.node("b").R[-1]
        return dx.solve_static(held(lambda t: pulled, np.arctan2(R[2, 1], R[1, 1])), steps=1, start=state)

    settled = dx.simulate(held(lambda t: 0.0), t_end=30.0, dt=0.2, start=knotted, save_every=150, tolerance=1e-10)
    print(settled.status)
    loose = at_rest(settled, 0.0)
    print(loose.status)
    pull = dx.simulate(
        held(lambda t: min(1.0, t / 80.0), friction=friction, slip_speed=0.01), t_end=80.0, dt=0.25, start=loose,
        save_every=8, tolerance=1e-10,
    )  # fmt: skip
    print(pull)
    settled = dx.simulate(held(lambda t: 1.0), t_end=30.0, dt=0.25, start=replace(pull, kind="static"), save_every=120)
    tight = at_rest(settled, 1.0)
    print(tight.status)
    found: list[tuple[float, float]] = []
    for name, knot in (("loose", loose), ("tight", tight)):
        T, P = knot.node("b").reaction[-1, 0], knot.contact("knot").force[-1]
        epsilon = (2.0 * T) ** 0.25
        found.append((epsilon, P / epsilon**3))
        print(
            f"{name}: pull {T:.6f}, pressed together by {P:.5f}, ε = {epsilon:.4f}, P/ε³ = {P / epsilon**3:.4f}, "
            f"deepest {-knot.contact('knot').gap[-1]:.4f}"
        )
    print(f"P/ε³ at ε → 0: {extended(found):.3f}, theory {THEORY}")
    if out is not None:
        _draw(pull, loose, tight, Path(out) / "overhand_knot.png")
    return pull, found


def extended(found: list[tuple[float, float]]) -> float:
    """The line through two points, at zero."""
    (a, f), (b, g) = found
    return f - a * (g - f) / (b - a)


def _draw(pull: dx.Result, loose: dx.Result, tight: dx.Result, path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(10, 8), layout="constrained")
    for ax, knot, title in ((axes[0, 0], loose, "loose"), (axes[0, 1], tight, "tight")):
        x, y, z = knot.r[-1].T
        middle = 0.5 * (x[0] + x[-1])
        order = np.argsort(0.5 * (y[1:] + y[:-1]))  # the farthest first
        for k in order:
            for color, wide, cap in (("black", 2.35, "butt"), ("tab:orange", 2.0, "round")):
                unit = 72 * 4.4 / 56  # points per radius
                ax.plot(x[k : k + 2] - middle, z[k : k + 2], color=color, lw=wide * unit, solid_capstyle=cap)
        ax.set(xlim=(-28, 28), ylim=(-14, 34), aspect="equal", title=f"{title}, seen along y")
    force, books = axes[1]
    way = pull.node("b").r[:, 0] - pull.node("a").r[:, 0]
    force.plot(way - way[0], pull.node("b").reaction[:, 0], label="pull, with friction")
    force.plot([0], loose.node("b").reaction[-1:, 0], "o", label="at rest without")
    force.plot(way[-1:] - way[0], tight.node("b").reaction[-1:, 0], "o", color="C1")
    force.set(xlabel="ends apart [radii]", ylabel="pull [B/radius²]")
    force.legend()
    books.plot(pull.t, pull.energy.total - pull.energy.total[0], label="energy of the rod, since the start")
    books.plot(pull.t, pull.energy.work, label="work of the pull")
    books.plot(pull.t, pull.energy.dissipated, label="dissipated")
    books.set(xlabel="t")
    books.legend()
    figure.savefig(path, dpi=110)
    print(path)


@slow
def test_a_knot_pulled_tight() -> None:
    """Ledger with friction; what presses the strands together against theory."""
    pull, found = main()
    assert pull.success and pull.audit.passed
    energy = pull.energy
    scale = max(np.abs(term).max() for term in (energy.total, energy.work, energy.dissipated))
    assert np.abs(energy.residual).max() <= 1e-10 * scale
    assert pull.contact("knot").force.min() > 0.0
    assert abs(extended(found) - THEORY) <= 0.06 * THEORY


if __name__ == "__main__":
    from _command import run

    run(main)
