"""Every element against what it claims, and the rivals against what they are known not to be."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import directrix as dx
from directrix.formulations import so3
from directrix.formulations.conformance import check_formulation
from directrix.formulations.crisfield_jelenic import CrisfieldJelenicStatics
from directrix.formulations.director_acceleration import DirectorAcceleration
from directrix.formulations.directors import DirectorStep, Rule
from directrix.formulations.layout import Layout
from directrix.formulations.simo_tarnow_doblare import SimoTarnowDoblareStep
from directrix.formulations.simo_vu_quoc import SimoVuQuocStatics
from directrix.laws import Law, stiffening_bending, tension_only
from directrix.newton import Newton
from directrix.rotations import cay, exp

MODULI = dict(EA=5.0, GA1=3.0, GA2=2.0, EI1=1.0, EI2=1.5, GJ=1.0)
FUNG, CABLE = Law.record(stiffening_bending(**MODULI, onset=2.0)), Law.record(tension_only(**MODULI, width=0.1))
CONSERVING = Rule(0.5, 0.5)


@pytest.mark.parametrize(
    ("element", "layout"),
    [
        (DirectorStep(CONSERVING), Layout(2, 1, True, law=FUNG)),
        (DirectorStep(CONSERVING), Layout(3, 2, True, law=CABLE)),
        (SimoTarnowDoblareStep(), Layout(2, 1, True, sampled=True)),
        (SimoTarnowDoblareStep(), Layout(3, 2, False, sampled=True)),
    ],
    ids=repr,
)
def test_a_conserving_element_does_the_work_of_its_energy(element, layout: Layout) -> None:
    found = check_formulation(element, layout, static=False, largest=3.0)
    assert found.objectivity <= 1e-12 and found.work <= 1e-12
    assert found.tangent <= 1e-10 and found.rigid_motion <= 1e-12


@pytest.mark.parametrize(("nn", "points"), [(2, 1), (3, 2)])
def test_crisfield_jelenic_is_objective_and_simo_vu_quoc_is_not(nn: int, points: int) -> None:
    layout = Layout(nn, points, False)
    one = check_formulation(CrisfieldJelenicStatics(), layout, static=True, largest=1e3, turn=0.3)
    two = check_formulation(SimoVuQuocStatics(), layout, static=True, largest=1.0)
    assert one.objectivity <= 1e-11 and one.tangent <= 1e-10 and one.rigid_motion <= 1e-12
    assert two.objectivity >= 1e-2 and two.tangent <= 1e-10 and two.rigid_motion <= 1e-12


@pytest.mark.parametrize(("nn", "points", "principal"), [(2, 1, True), (3, 2, False)])
def test_tangents_of_damped_and_accelerated_elements(nn: int, points: int, principal: bool) -> None:
    damped = Layout(nn, points, principal, damping="full")
    dissipative = DirectorStep(Rule(0.5, 0.5, dissipative=True))
    for element, layout in ((dissipative, damped), (DirectorAcceleration(), Layout(nn, points, principal))):
        assert check_formulation(element, layout, static=False, states=1).tangent <= 1e-10


def test_rotations_over_scalars_are_those_over_arrays() -> None:
    rng = np.random.default_rng(0)
    v = rng.standard_normal((500, 3))
    v *= (rng.uniform(0.0, 3.0, 500) / np.linalg.norm(v, axis=1))[:, None]
    v[0] = 0.0
    R = exp(v)
    columns = [R[:, :, c].T for c in range(3)]
    np.testing.assert_allclose(np.array(so3.exp(v.T)), np.array(columns), atol=1e-14)
    np.testing.assert_allclose(np.array(so3.log(columns)), v.T, atol=1e-12)
    theta = np.array(so3.cayley_vector(columns))
    np.testing.assert_allclose(cay(theta.T), R, atol=1e-12)
    np.testing.assert_allclose(np.array(so3.cayley(theta)), np.array(columns), atol=1e-12)


@pytest.mark.parametrize("body", [False, True])
def test_the_rate_of_a_turn_is_its_derivative(body: bool) -> None:
    rng = np.random.default_rng(1)
    v, w = rng.standard_normal((2, 3, 200))
    h = 1e-30
    R = np.moveaxis(np.array(so3.exp(v + 1j * h * w)), 0, 1)  # [row, column, sample]
    skew = np.einsum("kis,kjs->ijs" if body else "iks,jks->ijs", R.real, R.imag / h)
    skew = skew if body else -skew
    axial = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    np.testing.assert_allclose(np.array(so3.spin_rate(v, w, body)), axial, atol=1e-13)


def cantilever(order: int, elements: int = 8) -> dx.Model:
    section = dx.Section.from_moduli(EA=1e4, GA1=4e3, GA2=4e3, EI1=10.0, EI2=12.0, GJ=8.0)
    axis = dx.arc((0, 0, 0), (1, 0, 0.3), (2, 0.5, 0.5))
    model = dx.Model(name="hook").rod(axis, section, name="rod", ends=("a", "b"), elements=elements, order=order)
    return model.clamp("a").force("b", (0.5, 3.0, -2.0)).moment("b", (1.0, 0, 0.5))


@pytest.mark.parametrize("formulation", [dx.SimoVuQuoc(), dx.CrisfieldJelenic()], ids=repr)
@pytest.mark.parametrize("order", [1, 2])
def test_the_formulations_converge_to_one_solution(formulation, order: int) -> None:
    """Curved at rest, bent, twisted: the error against a fine mesh of directors falls with the order of the element."""
    exact = dx.solve_static(cantilever(2, 128)).node("b").r[-1]
    errors = []
    for n in (16, 32):
        result = dx.solve_static(cantilever(order, n), formulation=formulation)
        assert result.success and result.audit.passed
        errors.append(np.abs(result.node("b").r[-1] - exact).max())
    assert errors[1] <= 1e-3 / 4.0 ** (order - 1)
    assert np.log2(errors[0] / errors[1]) >= 2 * order - 0.3


def test_a_step_that_is_cut_starts_from_where_it_started(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simo & Vu-Quoc carry their rotations in the state: a failed try leaves no trace."""
    starts: list[np.ndarray] = []
    begin = Newton.begin

    def noted(self: Newton, x: np.ndarray) -> None:
        starts.append(x.copy())
        begin(self, x)

    monkeypatch.setattr(Newton, "begin", noted)
    model = dx.Model().rod(
        dx.line((0, 0, 0), (1, 0, 0)), dx.Section.from_moduli(EA=1e6, GA1=1e6, GA2=1e6, EI1=1.0, EI2=1.0, GJ=1.0),
        ends=("a", "b"), elements=4, order=1,
    ).clamp("a").moment("b", (0, 0, 40.0)).force("b", (0.0, 0.0, 3000.0))  # fmt: skip
    cut = dx.solve_static(model, steps=1, formulation=dx.SimoVuQuoc())
    assert cut.success and cut.info["cuts"] >= 1
    same = sum(np.array_equal(one, two) for one, two in pairwise(starts))
    assert len(starts) == len(cut.iterations) and same == cut.info["cuts"]
    assert cut.audit.passed


def test_stored_history_takes_up_where_it_was_left(tmp_path) -> None:
    model = cantilever(1)
    half = model.named("half")
    path = tmp_path / "half.vtkhdf"
    result = dx.solve_static(half, steps=4, formulation=dx.SimoVuQuoc())
    loaded = dx.load(result.save(path))
    np.testing.assert_array_equal(loaded.history, result.history)
    assert loaded.history.shape == (5, 8, 12)
    on, again = (dx.solve_static(model, steps=1, formulation=dx.SimoVuQuoc(), start=s) for s in (result, loaded))
    np.testing.assert_array_equal(on.r, again.r)
