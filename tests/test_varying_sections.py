"""Sections that vary, are twisted, or are off the axis, against independent solutions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_bvp

import directrix as dx
from directrix.formulations.conformance import check_formulation, random_parameters
from directrix.formulations.directors import DirectorStep, Rule
from directrix.formulations.layout import Layout

STEEL = {"E": 210e9, "nu": 0.3, "rho": 7850.0}


def cantilever(section: dx.Section, length: float = 1.0, elements: int = 8, **options: object) -> dx.Model:
    return (
        dx.Model()
        .rod(dx.line((0, 0, 0), (length, 0, 0), d1=(0, 1, 0)), section, name="rod", ends=("root", "tip"),
             elements=elements, **options)
        .clamp("root")
    )  # fmt: skip


def tip(model: dx.Model) -> np.ndarray:
    """(displacement, rotation vector) under a load so small that it is linear."""
    result = dx.solve_static(model, steps=1, raise_on_failure=True)
    R = result.node("tip").R[-1]
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.concatenate([result.node("tip").displacement[-1], turn])


def test_an_element_whose_section_varies_and_whose_mass_is_off_the_axis_conserves() -> None:
    layout = Layout(3, 2, False, varying=True, eccentric=True)
    given = random_parameters(np.random.default_rng(3), layout)
    given[-6:] = 0.0  # no weight, which has a direction of its own
    element = DirectorStep(Rule(w0=0.5, w1=0.5))
    found = check_formulation(element, layout, static=False, states=40, parameters=given)
    assert found.objectivity <= 1e-12 and found.work <= 1e-12 and found.rigid_motion <= 1e-12 and found.tangent <= 1e-10


@pytest.mark.parametrize("load", [0, 2])
def test_a_tapered_cantilever_bends_as_the_closed_form_says(load: int) -> None:
    """A wedge, width b, height h (2 − x/L): ∫(L−x)²/EI dx + ∫1/GA dx, by hand."""
    b, h, L, force = 0.05, 0.04, 1.0, 1e-3
    E, G, k = STEEL["E"], STEEL["E"] / 2.6, 5.0 / 6.0

    def section(fraction: float) -> dx.Section:
        return dx.Section.rectangle(b, h * (2.0 - fraction), shear_factor=k, **STEEL)

    direction = np.zeros(3)
    direction[load] = force
    u = tip(cantilever(dx.taper(section), L).force("tip", direction))[load] / force
    # with η = 2 − x/L: ∫ L²(η−1)²/(EI1 η³) L dη from 1 to 2, and ln 2 for what goes as 1/η
    bending = L**3 / (E * b * h**3 / 12.0) * (np.log(2.0) + 2.0 * (0.5 - 1.0) - 0.5 * (0.25 - 1.0))
    across = bending + L * np.log(2.0) / (k * G * b * h)
    assert u == pytest.approx(across if load == 2 else L * np.log(2.0) / (E * b * h), rel=2e-6)


def linear_tip(stiffness: np.ndarray, rate: float, length: float, force: np.ndarray) -> np.ndarray:
    """Tip (u, θ) in the section's frame at the root of a rod along d3 that is twisted at ``rate``: the linear equations
    as a boundary value problem of 12, integrated by SciPy."""
    compliance = np.linalg.inv(stiffness)
    e3 = np.array([0.0, 0.0, 1.0])

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        out = np.empty_like(y)
        for k, at in enumerate(s):
            c, d = np.cos(rate * at), np.sin(rate * at)
            Q = np.array([[c, -d, 0.0], [d, c, 0.0], [0.0, 0.0, 1.0]])
            u, n, m = y[:3, k], y[6:9, k], y[9:, k]
            strain = compliance @ np.concatenate([Q.T @ n, Q.T @ m])
            out[:3, k] = Q @ strain[:3] + np.cross(y[3:6, k], e3)
            out[3:6, k] = Q @ strain[3:]
            out[6:9, k] = 0.0
            out[9:, k] = -np.cross(e3, n)
            del u
        return out

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.concatenate([a[:6], b[6:9] - force[:3], b[9:] - force[3:]])

    s = np.linspace(0.0, length, 60)
    scale = np.abs(compliance).max()
    found = solve_bvp(slope, ends, s, np.zeros((12, len(s))), tol=1e-10 / max(1.0, scale), max_nodes=20000)
    assert found.success
    return found.y[:6, -1]


@pytest.mark.parametrize("coupled", [False, True])
def test_a_twisted_cantilever_against_the_linear_equations(coupled: bool) -> None:
    C = np.diag([8.0, 6.0, 50.0, 1.0, 9.0, 0.7])
    if coupled:
        C[2, 5] = C[5, 2] = 2.0
        C[3, 5] = C[5, 3] = -0.3
        C[0, 4] = C[4, 0] = 1.0
    load = np.array([1.0, -0.6, 0.4, 0.2, 0.1, -0.3]) * 1e-6
    section = dx.Section(C, order="shear-axial")
    angle = np.pi / 2
    model = (
        dx.Model()
        .rod(dx.line((0, 0, 0), (0, 0, 1), d1=(1, 0, 0)), section, name="rod", ends=("root", "tip"), elements=24,
             order=3, twist=angle)
        .clamp("root").force("tip", load[:3]).moment("tip", load[3:])
    )  # fmt: skip
    np.testing.assert_allclose(tip(model), linear_tip(C, angle, 1.0, load), rtol=2e-5, atol=1e-12)


def test_a_channel_loaded_through_its_centroid_twists_and_through_its_shear_centre_does_not() -> None:
    section = dx.Section.profile("UPN200", **STEEL)
    ecc = section.stiffness[1, 5] / section.stiffness[1, 1]  # Γ2 + Ω3 s1 at the shear centre
    L, force = 2.0, 1.0
    through = tip(cantilever(section, L).force("tip", (0, 0, force)))
    GJ = section.stiffness[5, 5] - section.stiffness[1, 1] * ecc**2
    # the force at the axis turns about the shear centre, s1 along d1 = y: the torque about x is −F s1
    assert through[3] == pytest.approx(-force * ecc * L / GJ, rel=1e-4) and abs(through[3]) > 1e-9
    free = tip(cantilever(section, L).force("tip", (0, 0, force)).moment("tip", (force * ecc, 0, 0)))
    assert abs(free[3]) <= 1e-4 * abs(through[3])


def test_an_offset_axis_is_the_same_rod_joined_by_an_arm() -> None:
    section, x = dx.Section.rectangle(0.02, 0.03, **STEEL), (0.05, -0.02)
    load = np.array([3.0, 2.0, -1.0])
    moved = tip(cantilever(section.offset(*x)).force("tip", load))
    arm = np.array([0.0, *x])  # d1 = y, d2 = z
    straight = tip(cantilever(section).force("tip", load).moment("tip", np.cross(-arm, load)))
    np.testing.assert_allclose(moved[3:], straight[3:], rtol=1e-4)
    np.testing.assert_allclose(moved[:3] + np.cross(moved[3:], arm), straight[:3], rtol=1e-4, atol=1e-10)


def test_a_rod_described_about_an_offset_axis_flies_as_the_same_rod_and_conserves() -> None:
    """The motion of the centroid must not know where the axis is; energy and momenta stay, gravity's work is booked."""
    section = dx.Section.rectangle(0.06, 0.1, E=2e6, nu=0.3, rho=1000.0)
    x, runs = np.array([0.04, -0.03]), []
    for offset in (np.zeros(2), x):
        shift = np.array([0.0, *offset])
        given = section.offset(*offset) if offset.any() else section
        model = (
            dx.Model()
            .rod(dx.line(-shift, (1, 0, 0) - shift, d1=(0, 1, 0)), given, name="rod", ends=("a", "b"), elements=4)
            .rigid_velocity((1, 0, 2), omega=(3, 5, -2))
            .gravity((0.5, 0, -9.81))
        )
        run = dx.simulate(model, 0.2, 0.005, raise_on_failure=True)
        assert run.audit.ok if hasattr(run.audit, "ok") else run.success
        runs.append((run, run.node("b").r + run.node("b").R @ shift))
    (plain, one), (moved, other) = runs
    np.testing.assert_allclose(other, one, atol=2e-5)
    for run in (plain, moved):
        assert np.abs(run.energy.residual).max() <= 1e-9 * run.energy.total.max()
        assert max(entry.value for entry in run.audit.entries) <= 1e-9
    np.testing.assert_allclose(moved.energy.kinetic, plain.energy.kinetic, rtol=1e-4)


def test_a_heavy_rod_off_its_axis_turns_it() -> None:
    section = dx.Section.rectangle(0.02, 0.03, **STEEL).offset(0.1, 0.0)
    result = dx.solve_static(cantilever(section).gravity((0, 0, -9.81)), steps=1, raise_on_failure=True)
    weight = 9.81 * section.A_rho
    np.testing.assert_allclose(result.node("root").reaction[-1][[2, 3]], [weight, 0.1 * weight], rtol=1e-3)


def test_what_cannot_be_is_refused() -> None:
    plain = dx.Section.rectangle(0.02, 0.03, **STEEL)
    for make, words in (
        (lambda: dx.taper([(0.0, plain), (0.9, plain)]), "do not rise from 0 to 1"),
        (lambda: dx.taper([(0.0, plain), (1.0, 3)]), "is not a section"),
        (lambda: dx.taper(lambda f: 1 / 0), "fails at fraction"),
        (lambda: dx.Section(np.eye(6), 1.0, 0.01 * np.eye(2), order="shear-axial", S_rho=(5, 0)), "more than A_rho"),
        (lambda: cantilever(plain, twist=[(0, 0)]), "fractions of a twist"),
        (lambda: cantilever(plain, twist="much"), "twist"),
        (
            lambda: dx.simulate(
                cantilever(plain.offset(0.1, 0)), 0.1, 0.01, integrator=dx.EnergyDissipating(chi_velocity=0.1)
            ),
            "off its axis",
        ),
    ):
        with pytest.raises(dx.ModelError, match=words):
            make()
