"""Sections that vary, are twisted, or are off the axis, against independent solutions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_bvp

import directrix as dx
from directrix.formulations.conformance import check_formulation, random_parameters
from directrix.formulations.directors import DirectorStep, Rule
from directrix.formulations.layout import Layout
from directrix.integrators import Integrator
from directrix.result import RodHistory
from directrix.schema.load import load_case

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
    b, h, L, force = 0.05, 0.04, 1.0, 10.0
    E, G, k = STEEL["E"], STEEL["E"] / 2.6, 5.0 / 6.0

    def section(fraction: float) -> dx.Section:
        return dx.Section.rectangle(b, h * (2.0 - fraction), shear_factor=k, **STEEL)

    direction = np.zeros(3)
    direction[load] = force
    u, coarse = (
        tip(cantilever(dx.taper(section), L, elements).force("tip", direction))[load] / force for elements in (16, 8)
    )
    # with η = 2 − x/L: ∫ L²(η−1)²/(EI1 η³) L dη from 1 to 2, and ln 2 for what goes as 1/η
    bending = L**3 / (E * b * h**3 / 12.0) * (np.log(2.0) + 2.0 * (0.5 - 1.0) - 0.5 * (0.25 - 1.0))
    across = bending + L * np.log(2.0) / (k * G * b * h)
    exact = across if load == 2 else L * np.log(2.0) / (E * b * h)
    assert u == pytest.approx(exact, rel=2e-6)
    if load == 2:  # order four: the section is taken at the stress points
        assert abs(coarse - exact) > 12.0 * abs(u - exact)


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


@pytest.mark.parametrize("integrator", [dx.EnergyMomentum(), dx.GeneralizedAlpha(0.8)], ids=repr)
def test_a_rod_described_about_an_offset_axis_flies_as_the_same_rod_and_conserves(integrator: Integrator) -> None:
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
        run = dx.simulate(model, 0.2, 0.005, integrator=integrator, raise_on_failure=True)
        assert run.audit.passed
        runs.append((run, run.node("b").r + run.node("b").R @ shift))
    (plain, one), (moved, other) = runs
    np.testing.assert_allclose(other, one, atol=2e-5)
    for run in (plain, moved) if integrator.conserves_energy else ():
        assert np.abs(run.energy.residual).max() <= 1e-9 * run.energy.total.max()
        assert max(entry.value for entry in run.audit.entries) <= 1e-9
    np.testing.assert_allclose(moved.energy.kinetic, plain.energy.kinetic, rtol=1e-4)


def test_a_heavy_rod_off_its_axis_turns_it() -> None:
    section = dx.Section.rectangle(0.02, 0.03, **STEEL).offset(0.1, 0.0)
    result = dx.solve_static(cantilever(section).gravity((0, 0, -9.81)), steps=1, raise_on_failure=True)
    weight = 9.81 * section.A_rho
    np.testing.assert_allclose(result.node("root").reaction[-1][[2, 3]], [weight, 0.1 * weight], rtol=1e-3)


@pytest.mark.parametrize("rival", [dx.SimoVuQuoc(), dx.CrisfieldJelenic()])
def test_rivals_bend_a_rod_whose_mass_is_off_its_axis(rival: object) -> None:
    model = cantilever(dx.Section.rectangle(0.02, 0.03, **STEEL).offset(0.1, 0.0))
    one, other = (
        dx.solve_static(model.force("tip", (0, 100, 50)), steps=1, formulation=f, raise_on_failure=True)
        for f in (None, rival)
    )
    np.testing.assert_allclose(other.node("tip").displacement, one.node("tip").displacement, rtol=1e-4, atol=1e-9)
    with pytest.raises(dx.ModelError, match="off its axis"):
        dx.solve_static(model.gravity((0, 0, -9.81)), formulation=rival)


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
        (lambda: dx.modes(cantilever(plain.offset(0.1, 0)), count=1, spin=(1.0, 0, 0)), "a steady spin has no form"),
    ):
        with pytest.raises(dx.ModelError, match=words):
            make()


# --- profiles

HOLLOW = {  # tables after EN 10210-2: A [cm²], I, I, It [cm⁴]
    "CHS60.3x5": (8.69, 33.5, 33.5, 67.0), "SHS 100x5": (18.7, 279, 279, 439), "RHS 100x50x4": (11.2, 140, 46.2, 113),
}  # fmt: skip


def properties(name: str) -> np.ndarray:
    """A [cm²], I about d1 and d2, It [cm⁴], place of the shear centre on d1 [mm]."""
    section = dx.Section.profile(name, E=1.0, G=1.0, rho=1.0, unit=0.1)
    C = section.stiffness
    sc = C[1, 5] / C[1, 1]
    assert section.A_rho == pytest.approx(C[2, 2]) and np.abs(section.S_rho).max() == 0.0
    return np.array([*np.diag(C)[[2, 3, 4]], C[5, 5] - sc**2 * C[1, 1], 10.0 * sc])


@pytest.mark.parametrize("name", HOLLOW)
def test_hollow_profiles_have_their_published_properties(name: str) -> None:
    np.testing.assert_allclose(properties(name)[:4], HOLLOW[name], rtol=4e-3)  # printed to three digits


def test_all_profiles_have_their_published_properties() -> None:
    from published_profiles import BEAMS, CHANNELS

    from directrix.profiles import PROFILES, profile

    assert set(BEAMS) | set(CHANNELS) == set(PROFILES)
    for name, (*dimensions, A, strong, weak, formula, exact) in BEAMS.items():
        assert PROFILES[name][:5] == tuple(dimensions), name
        found = properties(name)
        np.testing.assert_allclose(found[:3], (A, strong, weak), rtol=6e-4, err_msg=name)  # of four digits
        assert found[3] == pytest.approx(exact, rel=2e-3) and found[3] == pytest.approx(formula, rel=0.04), name
    for name, (*dimensions, A, strong, weak, centroid, behind, torsion) in CHANNELS.items():
        assert PROFILES[name][:6] == tuple(dimensions), name
        found = properties(name)
        np.testing.assert_allclose(found[:3], (A, strong, weak), rtol=6e-3, err_msg=name)
        assert -profile(name).outline[:, 0].min() == pytest.approx(centroid, abs=0.13), name
        assert found[3] == pytest.approx(torsion, rel=0.025) and -found[4] == pytest.approx(behind, rel=0.025), name


def test_profiles_that_are_none_are_refused() -> None:
    for name, words in (
        ("IPE201", "did you mean 'IPE2"),
        ("RHS 100x4", "2 dimensions"),
        ("SHS 100x50x4", "3 dim"),
        ("CHS 10x6", "does not fit"),
    ):
        with pytest.raises(dx.ModelError, match=words):
            dx.Section.profile(name, E=1.0, nu=0.3)


# --- sectionproperties


@pytest.fixture(scope="module")
def meshed():
    """An analysed section of a polygon, coarse."""
    pytest.importorskip("sectionproperties")
    from sectionproperties.analysis import Section as Analysed
    from sectionproperties.pre import Geometry
    from shapely import Polygon

    def make(points: np.ndarray, size: float) -> Analysed:
        return Analysed(Geometry(Polygon(points)).create_mesh([size]))

    return make


def test_any_shape_against_closed_forms(meshed) -> None:
    b, h = 0.02, 0.03
    corners = np.array([[0, 0], [b, 0], [b, h], [0, h]])
    one = dx.Section.from_sectionproperties(meshed(corners, 2e-5), **STEEL)
    two = dx.Section.rectangle(b, h, shear_factor=5 / 6, **STEEL)
    np.testing.assert_allclose(one.stiffness[2:, 2:], two.stiffness[2:, 2:], rtol=3e-3, atol=1.0)
    np.testing.assert_allclose(np.diag(one.stiffness)[:2], np.diag(two.stiffness)[:2], rtol=2e-2)
    assert one.A_rho == pytest.approx(two.A_rho) and np.abs(one.S_rho).max() < 1e-12
    np.testing.assert_allclose(one.I_rho, two.I_rho, rtol=1e-9, atol=1e-12)
    about = dx.Section.from_sectionproperties(meshed(corners, 2e-5), axis="origin", **STEEL)
    np.testing.assert_allclose(about.stiffness, one.offset(b / 2, h / 2).stiffness, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(about.S_rho, one.offset(b / 2, h / 2).S_rho, rtol=1e-9)
    with pytest.raises(dx.ModelError, match="no material"):
        dx.Section.from_sectionproperties(meshed(corners, 1e-3))
    with pytest.raises(dx.ModelError, match="no section of sectionproperties"):
        dx.Section.from_sectionproperties(3, **STEEL)


def test_a_section_by_its_corners() -> None:
    pytest.importorskip("sectionproperties")
    b, h, t = 0.02, 0.03, 0.002
    corners = [(0, 0), (b, 0), (b, h), (0, h)]
    one, two = dx.Section.polygon(corners, **STEEL), dx.Section.rectangle(b, h, **STEEL)
    np.testing.assert_allclose(one.stiffness[2:, 2:], two.stiffness[2:, 2:], rtol=3e-3, atol=1.0)
    assert one.A_rho == pytest.approx(two.A_rho)
    about = dx.Section.polygon(corners, **STEEL, axis="origin", damping=0.01)
    np.testing.assert_allclose(about.S_rho, one.offset(b / 2, h / 2).S_rho, rtol=1e-9)
    np.testing.assert_allclose(about.damping, 0.01 * about.stiffness)
    hole = [(t, t), (b - t, t), (b - t, h - t), (t, h - t)]
    box = dx.Section.polygon(corners, holes=[hole], E=1.0, G=1.0)
    assert box.stiffness[2, 2] == pytest.approx(b * h - (b - 2 * t) * (h - 2 * t))
    bredt = 4.0 * ((b - t) * (h - t)) ** 2 * t / (2.0 * (b + h - 2 * t))
    assert box.stiffness[5, 5] == pytest.approx(bredt, rel=0.06)
    for points, options, words in (
        ([(0, 0), (b, h), (b, 0), (0, h)], {}, "bound no section: self-intersection"),
        ([(0, 0), (b, 0), (2 * b, 0)], {}, "bound no section"),
        ([(0, 0), (b, 0)], {}, "has no corners"),
        ("abc", {}, "has no corners"),
        (corners, {"holes": [[(9, 9), (9, 10), (10, 9)]]}, "bound no section"),
        (corners, {"mesh": 1e-12}, "triangles"),
        (corners, {"G": 1.0}, "nu or G"),
        (corners, {"axis": "middle"}, "axis"),
    ):
        with pytest.raises(dx.ModelError, match=words):
            dx.Section.polygon(points, **{**STEEL, **options})


def test_a_channel_has_its_shear_centre_and_stresses_come_back(meshed) -> None:
    from directrix.profiles import profile
    from directrix.shapes import stress

    shape = profile("UPN200")
    analysed = meshed((shape.outline + np.array([7.0, -3.0])) * 1e-3, 4e-5)
    one = dx.Section.from_sectionproperties(analysed, **STEEL)
    two = dx.Section.profile("UPN200", **STEEL)
    np.testing.assert_allclose(np.diag(one.stiffness)[2:5], np.diag(two.stiffness)[2:5], rtol=5e-3)
    s1 = [s.stiffness[1, 5] / s.stiffness[1, 1] for s in (one, two)]
    assert s1[0] == pytest.approx(s1[1], rel=5e-3) and s1[0] < 0.0
    torsion = [s.stiffness[5, 5] - arm**2 * s.stiffness[1, 1] for s, arm in zip((one, two), s1, strict=True)]
    assert torsion[0] == pytest.approx(torsion[1], rel=5e-3)
    # resultants of the stresses at the nodes' triangles are the section forces, about any axis
    force = np.array([[300.0, -500.0, 2000.0, 40.0, -30.0, 25.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    for axis in ("centroid", (0.01, 0.02)):
        found = stress(analysed, force, axis=axis)
        origin = np.array(analysed.get_c() if axis == "centroid" else axis)
        back = np.zeros((2, 6))
        for element in analysed.elements:
            at = np.asarray(element.coords)[:, :3].T - origin
            area = 0.5 * abs(np.cross(np.append(at[1] - at[0], 0), np.append(at[2] - at[0], 0))[2])
            # the nodes in the middles of the sides are exact for quadratics
            mid, sigma = 0.5 * (at + np.roll(at, -1, axis=0)), found[:, list(element.node_ids[3:6])]
            n = sigma[..., 0]
            parts = [sigma[..., 1], sigma[..., 2], n, n * mid[:, 1], -n * mid[:, 0],
                     sigma[..., 2] * mid[:, 0] - sigma[..., 1] * mid[:, 1]]  # fmt: skip
            back += area / 3.0 * np.stack([p.sum(axis=1) for p in parts], -1)
        np.testing.assert_allclose(back, force, rtol=0.02, atol=2.0)
    loaded = RodHistory(np.zeros(2), np.zeros((1, 2, 6)), force[None])
    np.testing.assert_allclose(loaded.stress(analysed, axis=(0.01, 0.02)), found[None])
    one_point = stress(analysed, force, points=[np.array(analysed.get_c()) + np.array([-0.018, 0.0])])
    assert one_point.shape == (2, 1, 3)
    with pytest.raises(dx.ModelError, match="is not in the section"):
        stress(analysed, force, points=[(9.0, 9.0)])


# --- BeamDyn: a uniform and a twisted beam whose values follow from its cross-section

PRIMARY = """--------- BEAMDYN INPUT FILE --------------------
A beam of our own
---------------------- GEOMETRY PARAMETER --------
          1   member_total    - members
          3   kp_total        - key points
     1     3                  - member; its key points
 kp_xr kp_yr kp_zr initial_twist
 (m) (m) (m) (deg)
 0.0 0.0 0.0 {0}
 0.0 0.0 2.0 {1}
 0.0 0.0 4.0 {2}
---------------------- MATERIAL PARAMETER --------
"own.dat"    BldFile - properties
"""
OWN = """ ------- BEAMDYN BLADE FILE -------
 values from closed forms
 ---------------------- BLADE PARAMETERS ------
   2   station_total    - stations
   1   damp_type        - damping
 ---------------------- DAMPING COEFFICIENT ------
   mu1 mu2 mu3 mu4 mu5 mu6
   (-) (-) (-) (-) (-) (-)
  1e-3 1e-3 1e-3 1e-3 1e-3 1e-3
 ---------------------- DISTRIBUTED PROPERTIES ------
"""


def blade_file(folder, twist=(0.0, 0.0, 0.0), height=(0.1, 0.06), centre=(0.01, -0.02), spoil=None):
    """A rectangle 0.2 wide along x, ``height`` along y, its mass at ``centre``; returns the primary file."""
    rows = [OWN]
    for eta, h in zip((0.0, 1.0), height, strict=True):
        s = dx.Section.rectangle(0.2, h, shear_factor=5 / 6, **STEEL)
        m, (x, y) = s.A_rho, centre
        xx, yy, xy = s.I_rho[0, 0] + m * x * x, s.I_rho[1, 1] + m * y * y, m * x * y
        mass = np.diag([m, m, m, yy, xx, xx + yy])
        mass[0, 5] = mass[5, 0] = -m * y
        mass[1, 5] = mass[5, 1] = m * x
        mass[2, 3] = mass[3, 2] = m * y
        mass[2, 4] = mass[4, 2] = -m * x
        mass[3, 4] = mass[4, 3] = -xy
        if spoil is not None:
            mass[spoil] *= 1.3
        for a in (None, s.stiffness, mass):
            rows.append(f" {eta}\n" if a is None else "\n".join(" ".join(f"{v:.16e}" for v in r) for r in a) + "\n\n")
    (folder / "own.dat").write_text("".join(rows))
    (folder / "own.inp").write_text(PRIMARY.format(*twist))
    return folder / "own.inp"


def test_a_blade_of_beamdyn_is_the_rod_that_its_numbers_describe(tmp_path) -> None:
    model = dx.beamdyn(blade_file(tmp_path, twist=(10.0, 20.0, 30.0)), elements=6)
    (rod,) = model.rods
    root = dx.Section.rectangle(0.2, 0.1, shear_factor=5 / 6, **STEEL)
    first = rod.section.at(0.0)
    np.testing.assert_allclose(first.stiffness, root.stiffness)
    np.testing.assert_allclose(first.damping, 1e-3 * root.stiffness, atol=1e-9 * root.stiffness.max())
    m = root.A_rho
    np.testing.assert_allclose(first.S_rho, [0.01 * m, -0.02 * m])
    np.testing.assert_allclose(first.I_rho - np.diag(np.diag(root.I_rho)), m * np.outer((0.01, -0.02), (0.01, -0.02)))
    assert rod.section.at(0.5).stiffness[2, 2] == pytest.approx(0.8 * root.stiffness[2, 2])
    for fraction, degrees in ((0.0, 10.0), (0.25, 15.0), (1.0, 30.0)):  # right-handed about z
        d1 = rod.curve.frames(fraction * 4.0, 0.0)[:, 0]
        np.testing.assert_allclose(d1, [np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0], atol=1e-12)
    assert "1 member" not in "".join(model.imported) and "stiffness-proportional" in "".join(model.imported)


def test_a_case_reads_a_blade_of_beamdyn(tmp_path) -> None:
    made = dx.beamdyn(blade_file(tmp_path, twist=(10.0, 20.0, 30.0)), elements=6, name="one")
    case = tmp_path / "case.toml"
    table = '[[geometry]]\nkind = "beamdyn"\nfile = "own.inp"\nblade = "own.dat"\nelements = 6\nname = "one"\n'
    case.write_text(table + '[[support]]\nnode = "root"\ntype = "clamp"\n[statics]\nsteps = 1\n')
    assert load_case(case).model.rods == made.rods


def test_flap_and_edge_are_not_mixed_up(tmp_path) -> None:
    """A force along x bends about y: E∫x² of the wide side, so it is the stiff one; tip F L³/3EI + F L/GA."""
    model = dx.beamdyn(blade_file(tmp_path, height=(0.1, 0.1)), elements=8).clamp("root")
    E, G, area = STEEL["E"], STEEL["E"] / 2.6, 0.02
    for k, inertia in ((0, 0.1 * 0.2**3 / 12.0), (1, 0.2 * 0.1**3 / 12.0)):
        force = np.eye(3)[k]
        exact = 4.0**3 / (3.0 * E * inertia) + 4.0 / (5.0 / 6.0 * G * area)
        assert tip(model.force("tip", force))[k] == pytest.approx(exact, rel=1e-5)


def test_blades_that_cannot_be_are_refused_with_file_and_line(tmp_path) -> None:
    with pytest.raises(dx.InputError, match="not that of a flat section") as error:
        dx.beamdyn(blade_file(tmp_path, spoil=(1, 5)))
    assert error.value.where.endswith("own.dat:11")
    path = blade_file(tmp_path)
    text = (tmp_path / "own.dat").read_text()
    (tmp_path / "own.dat").write_text(text.replace(" 1.0\n", " 0.9\n"))
    with pytest.raises(dx.InputError, match="do not go from 0 to 1"):
        dx.beamdyn(path)
    path.write_text(PRIMARY.format(0, 0, 0).replace("0.0 0.0 2.0 0", "0.0 0.0"))
    with pytest.raises(dx.InputError, match="a key point is not 4 finite numbers") as error:
        dx.beamdyn(path)
    assert error.value.where.endswith("own.inp:10")
    with pytest.raises(dx.InputError, match="cannot be read"):
        dx.beamdyn(tmp_path / "none.inp")
