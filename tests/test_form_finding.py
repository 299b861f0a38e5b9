"""Form finding: hanging cables from starts that are far from them; a net is among the examples."""
# pyright: reportUnknownVariableType=false

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from scipy.optimize import brentq

import directrix as dx


def cable(EI: float = 1e-3, elements: int = 20, length: float = 1.2) -> dx.Model:
    """Drawn straight, its end then pushed in to a span of 1, under a unit load per length."""
    section = dx.Section.from_moduli(
        EA=1e4, GA1=1e4, GA2=1e4, EI1=EI, EI2=EI, GJ=EI, A_rho=1.0, I_rho1=1e-6, I_rho2=1e-6
    )
    axis = dx.line((0, 0, 0), (length, 0, 0))
    model = dx.Model(name="cable").rod(
        axis, section, name="cable", ends=("A", "B"), elements=elements, nodes={"M": 0.5}
    )
    model = model.fix("A", "x", "y", "z", "rx", "ry").fix("B", "rx", "ry")
    return model.prescribe("B", displacement=(1.0 - length, 0, 0)).distributed("cable", (0, -1, 0))


def _too_long(a: float) -> float:
    return 2.0 * a * float(np.sinh(0.5 / a)) - 1.2


def _stays(_: float) -> tuple[float, float, float]:
    return (-0.2, 0.0, 0.0)


def test_a_slack_cable_hangs_as_a_catenary() -> None:
    a = cast("float", brentq(_too_long, 0.05, 10.0))
    found = dx.form_find(cable())
    assert found.success and found.audit.passed and found.stability is not None
    assert found.stability.stable[-1]
    assert -found.node("M").r[-1, 1] == pytest.approx(a * (np.cosh(0.5 / a) - 1.0), rel=1e-3)


def test_later_runs_start_from_it() -> None:
    found = dx.form_find(cable())
    again = dx.solve_static(
        dx.Model(name="cable").rod(cable().rods[0].curve, cable().rods[0].section, name="cable", ends=("A", "B"),
                                   elements=20, nodes={"M": 0.5})
        .fix("A", "x", "y", "z", "rx", "ry").fix("B", "rx", "ry")
        .prescribe("B", displacement=_stays).distributed("cable", (0, -1, 0), constant=True),
        steps=1, start=found,
    )  # fmt: skip
    np.testing.assert_allclose(again.r[-1], found.r[-1], atol=1e-7)
    swing = dx.modes(cable(), about=found, count=2)
    assert swing.stable and swing.squares[0] > 1.0


def test_what_has_no_energy_or_finds_no_form_is_said() -> None:
    with pytest.raises(dx.ModelError, match="no energy to fall"):
        dx.form_find(cable().force("M", (0, 1, 0), follower=True))
    short = dx.form_find(cable(), iterations=1)
    assert not short.success and "relaxation" in short.status.sentence and len(short.t) == 2
