"""Models that several cases share."""

from __future__ import annotations

from typing import Any

import directrix as dx
from directrix.result import Result

__all__ = ["cantilever", "elbow", "equilibrium", "plane_section"]


def plane_section(EI: float, EA: float, GA: float) -> dx.Section:
    """Moduli for bending in any plane; GJ = EI."""
    return dx.Section.from_moduli(EA=EA, GA1=GA, GA2=GA, EI1=EI, EI2=EI, GJ=EI)


def cantilever(section: dx.Section, length: float, elements: int, order: int = 2, **rod: Any) -> dx.Model:
    """Clamped at the origin, along x; d1 = y, d2 = z; its ends are "root" and "tip"."""
    axis = dx.line((0, 0, 0), (length, 0, 0), d1=(0, 1, 0))
    model = dx.Model(name="cantilever")
    return model.rod(axis, section, name="rod", ends=("root", "tip"), elements=elements, order=order, **rod).clamp(
        "root"
    )


def elbow(elements: int, order: int) -> dx.Model:
    """Two legs of 10 at a right angle, EA = GA = 10⁶, EI = GJ = 10³, A_ρ = 1, I_ρ = 10; ends "root", "elbow", "tip"."""
    section = dx.Section.from_moduli(
        EA=1e6, GA1=1e6, GA2=1e6, EI1=1e3, EI2=1e3, GJ=1e3, A_rho=1.0, I_rho1=10.0, I_rho2=10.0
    )
    model = dx.Model(name="elbow")
    model = model.rod(
        dx.line((0, 0, 0), (10, 0, 0)), section, name="first", ends=("root", "elbow"), elements=elements, order=order
    )
    return model.rod(
        dx.line((10, 0, 0), (10, 10, 0)), section, name="second", ends=("elbow", "tip"), elements=elements, order=order
    )


def equilibrium(model: dx.Model, steps: int = 1, **options: Any) -> Result:
    """The last state of a static run that must succeed (ConvergenceError otherwise)."""
    return dx.solve_static(model, steps=steps, save_every=steps, raise_on_failure=True, **options)
