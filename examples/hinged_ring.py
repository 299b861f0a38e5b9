"""A ring of three rods with three hinges
======================================

Two opposite forces, and a long flight.

Three arcs of 120° close a ring of radius 1; hinges normal to its plane join them. Such a ring is statically
determinate: without load between its hinges an arc carries a force along its chord. It is pulled together at one hinge
and held at the middle of the opposite arc. Castigliano's theorem gives how much it gives, exactly for small forces:
δ = ∂/∂P ∫ ½ (M²/EI + N²/EA + Q²/GA) ds.

Then the ring is thrown, turning about all its axes while it is struck out of shape: energy and both momenta stay
what they are, with fifteen constraints at work in every step, and no hinge opens.

    python examples/hinged_ring.py [--steps 4000] [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import directrix as dx

EA, GA, EI, GJ = 2e4, 8e3, 2.0, 1.6
TURN = 2.0 * np.pi / 3.0


def at(angle: float) -> np.ndarray:
    """A place on the ring; angle 0 is the top."""
    return np.array([np.sin(angle), 0.0, np.cos(angle)])


def ring(elements: int) -> dx.Model:
    """Arcs "0", "1", "2" from hinge to hinge; hinge "0" at the top joins the end of arc 2 to the start of arc 0."""
    section = dx.Section.from_moduli(EA=EA, GA1=GA, GA2=GA, EI1=EI, EI2=EI, GJ=GJ, A_rho=1.0, I_rho1=1e-3, I_rho2=1e-3)
    model = dx.Model(name="hinged ring")
    for k in range(3):
        arc = dx.arc(at(k * TURN), at((k + 0.5) * TURN), at((k + 1) * TURN))
        model = model.rod(
            arc, section, name=str(k), ends=(f"start {k}", f"end {k}"), elements=elements,
            nodes={"bottom": 0.5} if k == 1 else None,
        )  # fmt: skip
    for k in range(3):
        model = model.hinge(f"end {(k + 2) % 3}", f"start {k}", axis=(0, 1, 0), name=str(k))
    return model


def castigliano() -> float:
    """Approach of the hinge at the top to the middle of the opposite arc, per force."""
    points, weights = np.polynomial.legendre.leggauss(40)
    top, side, total = at(0.0), at(TURN), 0.0
    chord = (side - top) / np.linalg.norm(side - top)
    pull = chord * 0.5 / -chord[2]  # in either arc from the top: a half of the force, along its chord
    for first, last, source in ((0.0, TURN, top), (TURN, 1.5 * TURN, side)):
        # twice each, by symmetry: the whole arc from the top to the side, and half the arc below
        for xi, w in zip(points, weights, strict=True):
            angle = 0.5 * (first + last) + 0.5 * (last - first) * xi
            tangent, inward = np.array([np.cos(angle), 0.0, -np.sin(angle)]), -at(angle)
            moment = np.cross(source - at(angle), pull)[1]
            energy = moment**2 / EI + (pull @ tangent) ** 2 / EA + (pull @ inward) ** 2 / GA
            total += 2.0 * w * 0.5 * (last - first) * energy
    return total


def main(*, elements: int = 16, steps: int = 4000, dt: float = 0.02, out: str | None = None) -> dict[str, float]:
    """Approach beside Castigliano's, under a small force and a large one; what the flight does not keep."""
    held = ring(elements).clamp("bottom")
    known, small, large = castigliano(), 1e-3, 2.0
    squeezed = [
        dx.solve_static(held.force("start 0", (0, 0, -p)), steps=s, raise_on_failure=True)
        for p, s in ((small, 1), (-small, 1), (large, 10))
    ]
    given = [-run.node("start 0").displacement[-1, 2] for run in squeezed]
    thrown = ring(4).rigid_velocity((0.2, 0.1, 0.0), omega=(0.6, 1.0, 0.4)).velocity("bottom", (0, 4, 2))
    flight = dx.simulate(thrown, steps * dt, dt, save_every=max(1, steps // 200), raise_on_failure=True)
    gaps = [flight.node(f"end {(k + 2) % 3}").r - flight.node(f"start {k}").r for k in range(3)]
    energy, momentum = flight.energy.total, flight.momentum
    found = {
        "approach / force": (given[0] - given[1]) / (2.0 * small),  # what is quadratic in the force drops out
        "Castigliano": known,
        "under 2, of Castigliano's": given[2] / (large * known),
        "energy": float(np.ptp(energy) / energy[0]),
        "linear momentum": float(
            np.abs(momentum.linear - momentum.linear[0]).max() / np.linalg.norm(momentum.linear[0])
        ),
        "angular momentum": float(
            np.abs(momentum.angular - momentum.angular[0]).max() / np.linalg.norm(momentum.angular[0])
        ),
        "hinges apart": float(np.abs(gaps).max()),
        "worst law": max(entry.value for entry in flight.audit.entries),
        "worst balance": max(entry.value for run in squeezed for entry in run.audit.entries),
    }
    for name, value in found.items():
        print(f"{name:<28} {value:.9g}")
    print(flight)
    if out is not None:
        path = Path(out) / "hinged_ring.png"
        draw(squeezed[2], flight, path)
        print(path)
    return found


def draw(squeezed: dx.Result, flight: dx.Result, path: Path) -> None:
    """The ring under the large force, and on its flight."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(13, 5), layout="constrained")
    squeezed.plot.shape(ax=figure.add_subplot(1, 3, 1))
    space = figure.add_subplot(1, 3, 2, projection="3d")
    for k in (0, 15, 30, 45):
        for rod in flight.mesh.rods:
            space.plot(*flight.r[k, rod.nodes].T, color=plt.colormaps["viridis"](k / 55), lw=1.8)
        for joint in range(3):
            space.plot(*flight.node(f"start {joint}").r[k : k + 1].T, "o", mfc="white", mec="#1b2733", ms=4)
    space.set_aspect("equal")
    flight.plot.energy(ax=figure.add_subplot(1, 3, 3))
    figure.savefig(path, dpi=130)


def test_the_ring_gives_as_castigliano_says() -> None:
    found = main(steps=500)
    assert abs(found["approach / force"] / found["Castigliano"] - 1.0) <= 1e-5
    assert abs(found["under 2, of Castigliano's"] - 1.0) > 0.02
    for law in ("energy", "linear momentum", "angular momentum", "hinges apart", "worst law"):
        assert found[law] <= 1e-10


if __name__ == "__main__":
    from _command import run

    run(main)
