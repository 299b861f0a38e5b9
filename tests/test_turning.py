"""Supports that turn by much in one step of load control: the rod comes along, or the run says that it does not."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx

THIN = dx.Section.circle(0.01, E=1e7, nu=0.3, rho=1000)


def held(order: int, elements: int, turn: tuple[float, float, float]) -> dx.Model:
    """A rod whose support turns by a rotation vector in degrees."""
    model = dx.Model(name="held").rod(
        dx.line((0, 0, 0), (1, 0, 0)), THIN, name="rod", ends=("A", "B"), elements=elements, order=order
    )
    return model.prescribe("A", displacement=(0, 0, 0), rotation=tuple(np.radians(turn)))


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("turn", [(60, 0, 0), (0, 60, 0), (0, 90, 0), (50, 100, 20)])
def test_a_free_rod_turns_with_its_support_in_one_part(order: int, turn: tuple[float, float, float]) -> None:
    result = dx.solve_static(held(order, 4, turn), steps=1, stability=True)
    assert result.success and result.energy.stored[-1] <= 1e-20
    assert result.stability is not None and result.stability.stable[-1]
    assert len(result.t) == 2 and result.info["cuts"] == 0
    np.testing.assert_allclose(result.node("B").R[-1], result.node("A").R[-1], atol=1e-12)


@pytest.mark.parametrize(("order", "elements", "degrees"), [(1, 4, 120), (2, 2, 170), (2, 4, 170)])
def test_a_twisted_rod_is_the_one_of_small_steps(order: int, elements: int, degrees: float) -> None:
    model = held(order, elements, (degrees, 0, 0)).clamp("B")
    once, often = (dx.solve_static(model, steps=n) for n in (1, 40))
    assert once.success and once.energy.stored[-1] == pytest.approx(often.energy.stored[-1], rel=1e-9)
    if order == 2:  # and of Coulomb
        exact = 0.5 * THIN.stiffness[5, 5] * np.radians(degrees) ** 2
        assert once.energy.stored[-1] == pytest.approx(exact, rel=0.2)


def test_an_element_that_is_folded_is_no_equilibrium() -> None:
    """Two elements cannot carry half a turn: where they would fold, the run says so."""
    result = dx.solve_static(held(1, 2, (0, 150, 0)).clamp("B"), steps=2)
    assert not result.success and result.audit.largest_turn < np.radians(85)


@pytest.mark.parametrize("elements", [1, 8])
def test_a_motion_that_folds_an_element_fails_its_audit_by_name(elements: int) -> None:
    """Twisted past a right angle an element holds nothing together, and conserves energy and momenta all the same."""
    section = dx.Section.from_moduli(
        EA=2500, GA1=960, GA2=960, EI1=1.6, EI2=1.6, GJ=1.2, A_rho=1, I_rho1=0.01, I_rho2=0.01
    )
    rod = dx.Model().rod(
        dx.line((0, 0, 0), (2, 0, 0)), section, name="shaft", ends=("A", "B"), elements=elements, order=1
    )
    result = dx.simulate(rod.clamp("A").velocity("B", (0, 0, 0), omega=(25, 0, 0)), t_end=0.5, dt=0.01)
    entries = {entry.law: entry.holds for entry in result.audit.entries}
    assert result.success and entries["energy"]
    assert result.audit.passed == (elements == 8)
    if elements == 1:
        assert not entries["turn of an element"] and "rod 'shaft', element 1" in str(result)
