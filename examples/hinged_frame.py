"""Hinged right-angle frame
========================

Lee, Manuel & Rossow (1968); Romero & Armero (2002), example 3, Figures 3 and 4.

Two members of length 120, hinged at their outer ends A and B and rigidly joined at the corner C, carry a dead load F
at P, one fifth of the beam from the corner. The path is followed by its own length past a maximum and a minimum of
the load until the frame hangs upside down and stiffens. Reference: the exact Simo–Reissner rod, by shooting.

On the paper's mesh, 5 + 5 quadratic elements with reduced quadrature, the two limit loads are 0.27 % and 1.6 % too low:
the price of interpolating directors over elements that turn by 32° (interpolated angles would give the first
to 0.06 %). The error falls with the fourth power of the element size: 10 + 10 elements are within 0.02 % and
0.09 %, 20 + 20 within 1e-5 and 5e-5, 30 + 30 within 1e-5.

In space the supports can be read in two ways. Hinges let the ends turn about z only. Spherical pins let the whole
frame swing about the line AB, so z of the corner is held as well. Nothing else is held: the frame may leave its plane
anywhere. Started in its plane it stays there, on the same path. A small force along z at P shows what that path
is worth: with the corner held in z the frame stays near its plane all the way, between hinges it buckles sideways
at about half the planar limit load.

    python examples/hinged_frame.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

import directrix as dx
from directrix.verification.hinged_frame import AT_LIMITS, LIMITS, PATH

# loads of the shapes of Figure 3, and at which crossing of that load; it is not said whether −7700 is before or after
# the minimum, but before it the shape is nearly that of −5800
DRAWN = {13600.0: 0, 17800.0: 0, -5800.0: 0, -7700.0: -1, 15600.0: -1}
Supports = Literal["hinges", "pins"]


def frame(elements: int, supports: Supports = "hinges", sideways: float = 0.0) -> dx.Model:
    """The frame in the x–y plane under F = 1 at P; ``sideways`` is a constant force on P along z."""
    E, G, A, I = 7.2e6, 7.2e6 / 2.6, 6.0, 2.0
    section = dx.Section.from_moduli(EA=E * A, GA1=G * A, GA2=G * A, EI1=E * I, EI2=E * I, GJ=G * 2 * I)
    model = dx.Model(name="hinged frame").rod(
        dx.line((0, 0, 0), (0, 120, 0)), section, name="column", ends=("A", "C"), elements=elements
    )
    model = model.rod(
        dx.line((0, 120, 0), (120, 120, 0)), section, name="beam", ends=("C", "B"), elements=elements, nodes={"P": 0.2}
    ).force("P", (0, -1, 0))
    if sideways:
        model = model.force("P", (0, 0, sideways), constant=True)
    if supports == "pins":
        return model.pin("A").pin("B").fix("C", "z")
    return model.fix("A", "x", "y", "z", "rx", "ry").fix("B", "x", "y", "z", "rx", "ry")


def trace(model: dx.Model, *, ds: float = 2.0, to: float = 3e4, at: tuple[float, ...] = ()) -> dx.Result:
    """The path until the load passes ``to``, with a state wherever it crosses a load of ``at``."""
    control = dx.ArcLength(ds=ds, ds_max=ds, until=lambda s: s.load_factor >= to, load_factors=(*at, to))
    return dx.solve_static(model, control=control, raise_on_failure=True)


def crossings(result: dx.Result, load: float) -> np.ndarray:
    """Saved instants at exactly this load, in the order of the path."""
    return np.flatnonzero(result.load_factor == load)


def off_plane(result: dx.Result) -> float:
    """Largest distance of a node from the plane of the frame."""
    return float(np.abs(result.r[..., 2]).max())


def main(*, elements: int = 20, out: str | None = None) -> dict[str, tuple[float, float]]:
    """Maximum and minimum of the load on meshes and under supports, printed beside the exact ones."""
    runs = {
        "paper's mesh, 5 + 5": frame(5),
        f"{elements} + {elements}, hinges": frame(elements),
        f"{elements} + {elements}, pins": frame(elements, "pins"),
    }
    found: dict[str, tuple[float, float]] = {}
    for name, model in runs.items():
        result = trace(model)
        found[name] = (result.turning_points[0].load_factor, result.turning_points[1].load_factor)
        print(f"{name:<22} {found[name][0]:12.3f} {found[name][1]:12.3f}   goes on to F = {result.load_factor[-1]:.0f}")
    print(f"{'exact':<22} {LIMITS[0]:12.3f} {LIMITS[1]:12.3f}")
    nudged = trace(frame(elements, sideways=1.0))
    print(f"nudged sideways between hinges: {nudged.turning_points[0]}, then {off_plane(nudged):.1f} off the plane")
    if out is not None:
        path = Path(out) / "hinged_frame.png"
        draw(trace(frame(elements), to=4.5e4, at=tuple(DRAWN)), nudged, path)
        print(path)
    return found


def draw(result: dx.Result, nudged: dx.Result, path: Path) -> None:
    """Figure 4, the load over the displacements of P, and Figure 3, shapes on the way."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    moved = result.node("P").displacement
    for curve, label, colour in ((-moved[:, 1], "down", "#1f6fb4"), (moved[:, 0], "to the right", "#d2601a")):
        left.plot(curve, result.load_factor, color=colour, label=label)
        for point in result.turning_points:
            left.plot(curve[point.index], point.load_factor, "o", color=colour)
    exact = np.array(PATH)
    left.plot(exact[:, 2], exact[:, 0], "k+", label="exact")
    left.plot(exact[:, 1], exact[:, 0], "k+")
    left.plot(
        -nudged.node("P").displacement[:, 1],
        nudged.load_factor,
        "--",
        color="#7d8791",
        lw=1,
        label="down, nudged sideways",
    )
    left.set(
        xlabel="displacement of P",
        ylabel="F",
        title="load and displacement (Figure 4)",
        xlim=(0, 100),
        ylim=(-2e4, 5e4),
    )
    left.legend(frameon=False)
    left.grid(color="#e8ebee")
    shown = [0, *(crossings(result, load)[which] for load, which in DRAWN.items())]
    for k, colour in zip(shown, plt.get_cmap("viridis")(np.linspace(0, 0.88, len(shown))), strict=True):
        for rod in result.mesh.rods:
            right.plot(*result.r[k, rod.nodes, :2].T, color=colour, lw=2)
        right.plot(*result.node("P").r[k, :2], "v", color=colour, label=f"F = {result.load_factor[k]:.0f}")
    right.set(aspect="equal", title="shapes on the way (Figure 3)")
    right.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.savefig(path, dpi=150)
    plt.close(figure)


def errors(elements: int) -> np.ndarray:
    """Relative errors (2,) of the two limit loads."""
    result = trace(frame(elements))
    return np.array([p.load_factor for p in result.turning_points]) / LIMITS - 1.0


def test_the_limit_loads_converge_with_the_fourth_power_of_the_element() -> None:
    five, ten, twenty, thirty = (np.abs(errors(n)) for n in (5, 10, 20, 30))
    assert np.all(five < (2.8e-3, 1.65e-2)) and np.all(ten < (1e-3, 1e-3))
    assert np.all(twenty < (1e-5, 5e-5)) and np.all(thirty < 1e-5)
    np.testing.assert_allclose(np.log2(ten / twenty), 4.0, atol=0.1)


def test_the_papers_mesh_has_the_limit_load_of_its_own_equations() -> None:
    """18496.465: the same element written for the plane alone, solved by a general root finder."""
    assert abs(trace(frame(5)).turning_points[0].load_factor - 18496.465) < 1e-3


def test_the_limit_points_are_where_they_should_be() -> None:
    result = trace(frame(30))
    assert [p.kind for p in result.turning_points] == ["limit point (maximum)", "limit point (minimum)"]
    for point, place in zip(result.turning_points, AT_LIMITS, strict=True):
        moved = result.node("P").displacement[point.index]
        np.testing.assert_allclose((moved[0], -moved[1]), place, rtol=1e-5)


def test_the_path_meets_the_exact_one() -> None:
    result = trace(frame(30), to=PATH[-1][0], at=tuple(p[0] for p in PATH))
    moved, last = result.node("P").displacement[:, :2] * (1, -1), -1
    for load, *place in PATH:
        off = {int(k): float(np.abs(moved[k] - place).max()) for k in crossings(result, load) if k > last}
        last = min(off, key=lambda k: off[k])
        assert off[last] < 1e-4 * 93.9, load
    assert result.load_factor[-1] > 3e4


def test_the_planar_path_is_a_path_in_space_under_either_support() -> None:
    hinges, pins = trace(frame(20)), trace(frame(20, "pins"))
    # in space there are bifurcations on the way, other ones under other supports, that are located and kept
    steps = [
        np.delete(run.r, [p.index for p in run.stability.points if "bif" in p.kind], axis=0) for run in (pins, hinges)
    ]
    np.testing.assert_allclose(steps[0], steps[1], atol=1e-6)
    assert off_plane(pins) < 1e-9
    for result in (hinges, pins):
        assert result.success and result.load_factor[-1] == 3e4 and result.audit.passed


def test_a_nudge_sideways_takes_the_hinged_frame_out_of_its_plane() -> None:
    hinges, pins = trace(frame(10, sideways=1.0)), trace(frame(10, "pins", sideways=1.0))
    assert hinges.turning_points[0].load_factor < 0.6 * LIMITS[0]
    assert off_plane(hinges) > 50.0 and off_plane(pins) < 3.0
    np.testing.assert_allclose(pins.turning_points[0].load_factor, LIMITS[0], rtol=1e-3)


if __name__ == "__main__":
    from _command import run

    run(main)
