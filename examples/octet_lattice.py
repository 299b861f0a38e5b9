"""Octet lattice
=============

How stiff is an octet truss? Theory for slender struts and pins (Deshpande, Fleck & Ashby, J. Mech. Phys. Solids 49
(2001) 1747–1769): with E of the solid and the relative density ρ = 6√2 π (r/ℓ)², E/9 ρ along the cell.

Here a block of cells is pressed together with its sides held. All its faces are mirror planes, and the struts that
lie in them are halved, so the block is a piece of an endless lattice. What the faces carry are the moduli C11 and C12,
and the stiffness of a block whose sides are free is E = C11 − 2 C12²/(C11 + C12). The joints are rigid, and the nodes
of an octet truss do not turn when it is strained evenly: struts are stretched, and bent with clamped ends. That gives
C11 = Eρ (1 + k)/6 and C12 = Eρ (1 − k)/12, k the stiffness of a clamped strut across over that along itself: with its
shear k = 12 EI/(EA ℓ²) / (1 + 12 EI/(GA ℓ²)). Computed values meet these for any strut, and the theory of pins as
struts get slender.

    python examples/octet_lattice.py [--cells 2] [--out FOLDER]
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import directrix as dx

E, CELL, SQUEEZE = 70e9, 1e-2, 1e-5
STRUT = CELL / np.sqrt(2.0)
SLENDERNESS = (10.0, 20.0, 40.0, 80.0)


def half(section: dx.Section) -> dx.Section:
    """The part of a strut on one side of a plane that it lies in."""
    GA1, GA2, EA, EI1, EI2, GJ = 0.5 * np.diag(section.stiffness)
    return dx.Section.from_moduli(EA=EA, GA1=GA1, GA2=GA2, EI1=EI1, EI2=EI2, GJ=GJ)


def block(cells: int, section: dx.Section) -> dx.Model:
    """``cells`` in every direction between mirrors, the upper one pressed down."""
    most = 2 * cells
    lattice = dx.generate.octet((cells, cells, cells), CELL, section, elements=2)

    def faces(node: str) -> list[tuple[int, int]]:
        """Axis and place of the faces that a node is on."""
        return [(axis, k) for axis, k in enumerate(map(int, node.split("."))) if k in (0, most)]

    shared = half(section)
    rods = (replace(r, section=shared) if set(faces(r.ends[0])) & set(faces(r.ends[1])) else r for r in lattice.rods)
    lattice = replace(lattice, rods=tuple(rods))
    for node in sorted({end for rod in lattice.rods for end in rod.ends}):
        held = {dof for axis, _ in faces(node) for dof in ("xyz"[axis], *(f"r{c}" for c in "xyz" if c != "xyz"[axis]))}
        if (2, most) in faces(node):
            lattice = lattice.prescribe(node, displacement=(0.0, 0.0, -SQUEEZE * cells * CELL))
            held -= set("xyz")
        if held:
            lattice = lattice.fix(node, *sorted(held))
    return lattice


def moduli(cells: int, section: dx.Section) -> tuple[float, float, dx.Result]:
    """C11 and C12, and the block as it is pressed."""
    pressed = dx.solve_static(block(cells, section), steps=1, raise_on_failure=True)
    area = (cells * CELL) ** 2

    def stress(axis: int) -> float:
        face = [k for name, k in pressed.mesh.node_names.items() if name.split(".")[axis] == str(2 * cells)]
        return -float(pressed.reaction[-1, face, axis].sum()) / area

    return stress(2) / SQUEEZE, stress(0) / SQUEEZE, pressed


def main(*, cells: int = 2, out: str | None = None) -> dict[float, dict[str, float]]:
    """By ℓ/r: C11 and C12 over those of rigid joints, and E over that of pins, E ρ/9."""
    found: dict[float, dict[str, float]] = {}
    print("   ℓ/r    density   C11/rigid   C12/rigid    E/pins")
    for slenderness in SLENDERNESS:
        section = dx.Section.circle(radius=STRUT / slenderness, E=E, nu=0.33)
        c11, c12, pressed = moduli(cells, section)
        GA, _, EA, EI = np.diag(section.stiffness)[:4]
        k = 12.0 * EI / (EA * STRUT**2) / (1.0 + 12.0 * EI / (GA * STRUT**2))
        density = 6.0 * np.sqrt(2.0) * np.pi / slenderness**2
        young = c11 - 2.0 * c12**2 / (c11 + c12)
        row = {
            "C11": c11 / (E * density * (1.0 + k) / 6.0),
            "C12": c12 / (E * density * (1.0 - k) / 12.0),
            "E": young / (E * density / 9.0),
        }
        found[slenderness] = row
        print(f"{slenderness:6.0f} {density:10.5f} {row['C11']:11.6f} {row['C12']:11.6f} {row['E']:9.5f}")
    if out is not None:
        path = Path(out) / "octet_lattice.png"
        pressed.plot.shape().figure.savefig(path, dpi=150)
        print(path)
    return found


def test_the_moduli_are_those_of_theory() -> None:
    found = main(cells=1)
    for row in found.values():
        assert abs(row["C11"] - 1.0) <= 2e-5 and abs(row["C12"] - 1.0) <= 2e-5
    excess = np.array([row["E"] - 1.0 for row in found.values()])
    assert abs(excess[-1]) <= 2e-3  # pins, as struts get slender
    assert np.all(excess[:-1] / excess[1:] > 3.5)  # and with the square of that
    more = moduli(2, dx.Section.circle(radius=STRUT / 20.0, E=E, nu=0.33))
    less = moduli(1, dx.Section.circle(radius=STRUT / 20.0, E=E, nu=0.33))
    assert np.allclose(more[:2], less[:2], rtol=1e-8)  # a piece of an endless lattice, however large


if __name__ == "__main__":
    from _command import run

    run(main)
