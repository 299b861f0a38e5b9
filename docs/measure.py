"""Measure the tables of choosing.md and write them there: ``make measured``. Nothing is timed."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import directrix as dx

PAGE = Path(__file__).with_name("choosing.md")


def quarter(order: int, elements: int) -> float:
    """Error of the tip of a rod that a moment bends into a quarter circle, over its displacement."""
    section = dx.Section.from_moduli(EA=1e8, GA1=1e8, GA2=1e8, EI1=1.0, EI2=1.0, GJ=1.0)
    rod = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), section, ends=("a", "b"), elements=elements, order=order)
    run = dx.solve_static(rod.clamp("a").moment("b", (0, 0, np.pi / 2)), steps=4, raise_on_failure=True)
    exact = np.array([2 / np.pi, 2 / np.pi, 0.0])
    return float(np.linalg.norm(run.node("b").r[-1] - exact) / np.linalg.norm(exact - [1, 0, 0]))


def bend(order: int, elements: int) -> np.ndarray:
    """Displacement (3,) of the tip of the 45° bend under 600."""
    c = np.sqrt(0.5)
    axis = dx.arc((0, 0, 0), (100 * np.sin(np.pi / 8), 100 * (1 - np.cos(np.pi / 8)), 0), (100 * c, 100 * (1 - c), 0))
    section = dx.Section.from_moduli(EA=1e7, GA1=5e6, GA2=5e6, EI1=1e7 / 12, EI2=1e7 / 12, GJ=5e6 / 6)
    rod = dx.Model().rod(axis, section, ends=("a", "b"), elements=elements, order=order)
    run = dx.solve_static(rod.clamp("a").force("b", (0, 0, 600)), steps=6, raise_on_failure=True)
    return run.node("b").displacement[-1]


def swing(dt: float, integrator: object = None) -> dx.Result:
    """A rubber rod that falls from the horizontal."""
    rubber = dx.Section.circle(radius=0.01, E=5e6, nu=0.5, rho=1100)
    rod = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), rubber, ends=("pin", "tip"), elements=10).pin("pin")
    return dx.simulate(rod.gravity((0, 0, -9.81)), 0.5, dt, integrator=integrator)


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Markdown."""
    lines = [list(head), ["---"] * len(list(head)), *map(list, rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def elements() -> str:
    """Errors over nodes, orders side by side."""
    fine = bend(3, 32)
    rows = []
    for order, counts in ((1, (4, 8, 16, 32)), (2, (2, 4, 8, 16)), (3, (2, 4, 8))):
        for count in counts:
            off = np.linalg.norm(bend(order, count) - fine) / np.linalg.norm(fine)
            rows.append([f"{order}", f"{count}", f"{order * count + 1}", f"{quarter(order, count):.1e}", f"{off:.1e}"])
    return table(("order", "elements", "nodes", "quarter circle", "45° bend"), rows)


def steps() -> str:
    """Errors over Δt, time steps side by side."""
    fine = swing(2.5e-4).r[-1, -1]
    rows = []
    for name, integrator in (
        ("EnergyMomentum()", dx.EnergyMomentum()),
        ("Midpoint()", dx.Midpoint()),
        ("EnergyDissipating(0.5)", dx.EnergyDissipating(0.5)),
        ("GeneralizedAlpha(0.8)", dx.GeneralizedAlpha(0.8)),
    ):
        for dt in (0.02, 0.01, 0.005):
            run = swing(dt, integrator)
            off = np.linalg.norm(run.r[-1, -1] - fine) if run.success else np.inf
            ledger = np.abs(run.energy.residual).max() / np.abs(run.energy.work).max()
            rows.append(
                [f"`{name}`", f"{1000 * dt:g} ms", f"{off:.1e}" if run.success else "did not finish", f"{ledger:.0e}"]
            )
    return table(("time step", "Δt", "tip", "energy"), rows)


if __name__ == "__main__":
    page = PAGE.read_text("utf-8")
    for name, made in (("elements", elements()), ("steps", steps())):
        page = re.sub(rf"(<!-- table: {name} -->\n).*?(<!-- end -->)", rf"\1{made}\n\2", page, flags=re.DOTALL)
    PAGE.write_text(page, "utf-8")
    print(PAGE)
