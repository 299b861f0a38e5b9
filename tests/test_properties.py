"""Laws that hold for every model, tried on models that hypothesis draws."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import directrix as dx
from directrix.discretisation import discretise
from directrix.formulations.conformance import check_discrete_gradient, check_formulation
from directrix.formulations.directors import DirectorStep, Rule
from directrix.formulations.layout import Layout
from directrix.kernels import step as kernel
from directrix.newton import Newton, Settings
from directrix.state import initial_state

LAYOUTS = [Layout(2, 1, True), Layout(2, 2, False), Layout(3, 2, False), Layout(4, 3, True)]
RULES = {"energy-momentum": Rule(0.5, 0.5), "midpoint": Rule(0.0, 0.0, 1.0), "static": Rule(static=True)}
# cubic elements take long to compile: one rule by default
PAIRS = [
    pytest.param(layout, rule, marks=pytest.mark.slow if layout.nn > 3 and rule != "energy-momentum" else ())
    for layout in LAYOUTS
    for rule in RULES
]

Vec = tuple[float, float, float]
parts = st.floats(-1.0, 1.0, width=32)
vectors = st.tuples(parts, parts, parts)
several = settings(max_examples=25)


@dataclass(frozen=True)
class Units:
    """What one metre, one kilogram and one second are in other units."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0


SI = Units()


@dataclass(frozen=True)
class Rod:
    """A soft rod from ``start`` on, with velocities at its ends and a force at its end, in SI units."""

    start: Vec
    order: int
    elements: int
    v: tuple[Vec, Vec]
    omega: Vec
    force: Vec

    def model(self, units: Units = SI, turned_round: bool = False, clamped: bool = False) -> dx.Model:
        l, m, t = units.length, units.mass, units.time
        f = m * l / t**2
        section = dx.Section.from_moduli(
            EA=2500 * f, GA1=950 * f, GA2=900 * f, EI1=10 * f * l**2, EI2=12 * f * l**2, GJ=8 * f * l**2,
            A_rho=2.5 * m / l, I_rho1=0.012 * m * l, I_rho2=0.01 * m * l,
        )  # fmt: skip
        a = np.array(self.start)
        ends = [("a", a * l), ("b", np.add(a, (2.0, 1.0, -2.0)) * l)]
        (first, p), (last, q) = reversed(ends) if turned_round else ends
        axis = dx.line(p, q, d1=(0, 1, 0))
        model = dx.Model().rod(axis, section, name="rod", ends=(first, last), elements=self.elements, order=self.order)
        model = model.force("b", np.multiply(self.force, f)).velocity("b", np.multiply(self.v[1], l / t))
        if clamped:
            return model.clamp("a")
        return model.velocity("a", np.multiply(self.v[0], l / t), omega=np.divide(self.omega, t))


rods = st.builds(
    Rod, vectors, st.sampled_from([1, 2, 3]), st.integers(2, 6), st.tuples(vectors, vectors), vectors, vectors
)


@settings(max_examples=5)
@given(seed=st.integers(0, 2**32 - 1))
@pytest.mark.parametrize(("layout", "rule"), PAIRS)
def test_an_element_is_objective_and_its_tangent_and_discrete_gradient_are_exact(
    layout: Layout, rule: str, seed: int
) -> None:
    """1000 random states and rotations up to 1000 rad each time; the tangent is that of the machine code."""
    static = rule == "static"
    found = check_formulation(DirectorStep(RULES[rule]), layout, static=static, states=1000, largest=1e3, seed=seed)
    assert found.objectivity <= 1e-12
    assert found.tangent <= 1e-10
    assert found.rigid_motion <= 1e-12
    if rule == "energy-momentum":
        assert found.work <= 1e-12
        assert check_discrete_gradient(layout, states=1000, seed=seed) <= 1e-13


@several
@given(rod=rods)
def test_a_flight_keeps_energy_and_momenta(rod: Rod) -> None:
    result = dx.simulate(replace(rod, force=(0.0, 0.0, 0.0)).model(), t_end=2.0, dt=0.1)
    assert result.success
    # a flight of next to no energy has rounding: strains of sixteen digits at EA = 2500, twenty steps
    assert all(
        e.claimed and (e.value <= 1e-11 or e.value * float(e.relative_to) <= 1e-15) for e in result.audit.entries
    )


@several
@given(rod=rods)
def test_a_motion_runs_back(rod: Rod) -> None:
    model = rod.model()
    there = dx.simulate(model, t_end=1.0, dt=0.05)
    back = dx.simulate(model, t_end=2.0, dt=0.05, start=replace(there, v=-there.v, Rdot=-there.Rdot))
    assert there.success and back.success
    for now, then in ((back.r[-1], there.r[0]), (back.R[-1], there.R[0]), (back.v[-1], -there.v[0])):
        np.testing.assert_allclose(now, then, rtol=0, atol=1e-8)


@several
@given(rod=rods)
def test_a_rod_described_from_its_other_end_moves_the_same(rod: Rod) -> None:
    one, two = (
        dx.simulate(rod.model(clamped=True, turned_round=turned), t_end=1.0, dt=0.05).node("b")
        for turned in (False, True)
    )
    np.testing.assert_allclose(two.r, one.r, rtol=0, atol=1e-9)
    np.testing.assert_allclose(two.R, one.R, rtol=0, atol=1e-9)


@several
@given(rod=rods, powers=st.tuples(*[st.integers(-3, 3)] * 3))
def test_other_units_give_the_same_motion(rod: Rod, powers: tuple[int, int, int]) -> None:
    units = Units(*(10.0**k for k in powers))
    paths = [
        dx.simulate(rod.model(u, clamped=True), t_end=u.time, dt=0.05 * u.time).node("b").r / u.length
        for u in (SI, units)
    ]
    np.testing.assert_allclose(paths[1], paths[0], rtol=0, atol=1e-9)


@several
@given(rod=rods, seed=st.integers(0, 2**32 - 1))
def test_newton_converges_quadratically(rod: Rod, seed: int) -> None:
    """What one iteration leaves of a disturbance of the solved step goes with its square."""
    scheme = dx.EnergyMomentum().scheme(0.1)
    disc = discretise(rod.model(clamped=True), scheme)
    newton = Newton(disc, scheme, Settings())
    solved = initial_state(disc, None, scheme)
    external = disc.external(0.0)
    assert newton.solve(solved, external).status is None
    du = np.random.default_rng(seed).uniform(-1.0, 1.0, newton.work.du.shape) * ~disc.fixed[: len(newton.work.du)]
    left: list[float] = []
    for size in (4e-4, 1e-4):
        x = solved.copy()
        newton.work.du[:] = size * du
        kernel.advance(newton.tables, newton.work, x, False, False, np.inf)
        left.append(newton.increments(x, external, 2)[1])
    assert np.log(left[0] / left[1]) / np.log(4.0) >= 1.9
