"""Any cross-section from the package `sectionproperties`, and stresses back from section forces.

Its x and y are d1 and d2. Elastic properties are those of its warping analysis: EA and EI about the centroid, GA and GJ
about the shear centre. Warping is left free: a rod has no degree of freedom for it.
"""

# pyright: reportUnknownLambdaType=false
# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import choice, number, shown
from directrix.errors import ModelError
from directrix.section import Section

Array = NDArray[np.float64]

__all__ = ["polygon", "section_of", "stress"]

LARGEST = 100_000  # triangles

AXES = ("centroid", "shear_centre", "origin")


def section_of(
    section: Any, *, axis: str | tuple[float, float] = "centroid", E: float | None = None, nu: float | None = None,
    rho: float | None = None,
) -> Section:  # fmt: skip
    """A Section from a `sectionproperties` one that has a mesh; it is analysed here if it was not.

    Parameters
    ----------
    section
        ``sectionproperties.analysis.Section``.
    axis
        Where the axis of the rod goes through: "centroid", "shear_centre", "origin" or (x, y).
    E, nu, rho
        The material where the geometry has none of its own; with materials, E and ρ are theirs, and G is made of the
        effective ν.

    Raises ModelError when it is no such section, is in several parts, or the material is missing or given twice.
    """
    _analysed(section)
    own = any(m.name != "default" for m in section.materials)
    if own == (E is not None) or (E is None) != (nu is None):
        raise ModelError(
            "the material is given twice" if own else "the geometry has no material, and E and nu are not given",
            "give E=, nu= and rho= where the geometry has no material, and only there",
        )
    if own:
        ea, eic = float(section.get_ea()), np.array(section.get_eic(e_ref=1.0))
        G = 1.0 / (2.0 * (1.0 + float(section.get_nu_eff())))
        gas, gj = np.array(section.get_eas(e_ref=1.0)) * G, float(section.get_ej(e_ref=1.0)) * G
    else:
        young, ratio = number(E, "E", above=0.0), number(nu, "nu", above=-1.0)
        G = young / (2.0 * (1.0 + ratio))
        ea, eic = young * float(section.get_area()), young * np.array(section.get_ic())
        gas, gj = G * np.array(section.get_as()), G * float(section.get_j())
    shear = np.diag(gas)
    total = float(section.section_props.a_sxy) if hasattr(section.section_props, "a_sxy") else np.inf
    if np.isfinite(total) and total != 0.0:
        unit = float(gas[0] / section.section_props.a_sx)
        flexible = np.array([[1.0 / gas[0], 1.0 / (unit * total)], [1.0 / (unit * total), 1.0 / gas[1]]])
        shear = np.linalg.inv(flexible)
        shear[np.abs(shear) < 1e-6 * shear.max()] = 0.0
    at = _axis(section, axis)
    centroid, shear_centre = _clean(_centroid(section) - at, section), _clean(_shear_centre(section) - at, section)
    mass, first, second = _mass(section, at, number(rho, "rho", least=0.0) if rho is not None else 0.0, own)
    middle = first / mass if mass else centroid
    second -= mass * np.outer(middle, middle)
    coupling = -float(eic[2]) if abs(eic[2]) > 1e-9 * max(eic[0], eic[1]) else 0.0
    mixed = float(second[0, 1]) if abs(second[0, 1]) > 1e-9 * max(np.trace(second), 1e-300) else 0.0
    made = Section.from_moduli(
        EA=ea, GA1=float(shear[0, 0]), GA2=float(shear[1, 1]), GA12=float(shear[0, 1]), EI1=float(eic[0]),
        EI2=float(eic[1]), EI12=coupling, GJ=gj, A_rho=mass, I_rho1=float(second[0, 0]), I_rho2=float(second[1, 1]),
        I_rho12=mixed, centroid=centroid, shear_centre=shear_centre, mass_centre=_clean(middle, section),
    )  # fmt: skip
    said = (
        f"section of sectionproperties, axis through {axis if isinstance(axis, str) else tuple(map(float, axis))}: "
        "warping is free and costs nothing",
    )
    return replace(made, assumptions=said, outline=_outline(section) - at)


def polygon(
    outline: ArrayLike, holes: Sequence[ArrayLike] = (), *, E: float, nu: float | None = None, G: float | None = None,
    rho: float = 0.0, axis: str | tuple[float, float] = "centroid", mesh: float | None = None,
    damping: ArrayLike = 0.0,
) -> Section:  # fmt: skip
    """A Section by its corners: meshed, and analysed as :func:`section_of` does.

    Parameters
    ----------
    outline, holes
        (k, 2) corners along d1 and d2, of the section and of each of its holes; not closed.
    E, nu, G, rho
        The material; ν or G.
    axis
        Where the axis of the rod goes through: "centroid", "shear_centre", "origin" or (x, y).
    mesh
        Largest area of a triangle; a 400th of the section, or less where walls are thin, unless given.
    damping
        As in :class:`directrix.Section`.

    Raises ModelError when `sectionproperties` is missing, for corners that bound no area, and a mesh of more than
    100 000 triangles.
    """
    from directrix.geometry.pieces import extra

    extra("sectionproperties", "a section by its corners")
    from sectionproperties.analysis.section import Section as Analysed
    from sectionproperties.pre.geometry import Geometry
    from shapely import Polygon, is_valid_reason

    rings = [_corners(ring, what) for ring, what in ((outline, "outline"), *((hole, "hole") for hole in holes))]
    young = number(E, "E", above=0.0)
    if (nu is None) == (G is None):
        raise ModelError("a material needs nu or G, one of them", "give nu= (G = E/2(1+ν)) or G=")
    ratio = number(nu, "nu") if nu is not None else young / (2.0 * number(G, "G", above=0.0)) - 1.0
    if nu is not None and not -1.0 < ratio <= 0.5:
        raise ModelError(f"nu = {nu:g} is not in −1 < ν ≤ 0.5", "give another, or G=")
    shape = Polygon(rings[0], rings[1:])
    if not shape.is_valid or shape.area <= 1e-9 * shape.length**2:
        why = is_valid_reason(shape) if not shape.is_valid else "no area"
        raise ModelError(
            f"these corners bound no section: {why[0].lower()}{why[1:]}",
            "give corners in their order, of sides that do not cross, and holes inside",
        )
    thick = 2.0 * shape.area / shape.length
    size = min(shape.area / 400.0, 0.2 * thick**2) if mesh is None else number(mesh, "mesh", above=0.0)
    if shape.area / size > LARGEST:
        raise ModelError(f"that takes {shape.area / size:.2g} triangles", "give a larger mesh=")
    analysed = Analysed(Geometry(shape).create_mesh([size]))
    return section_of(analysed, axis=axis, E=young, nu=ratio, rho=rho).damped(damping)


def _corners(ring: ArrayLike, what: str) -> Array:
    try:
        out = np.asarray(ring, float)
    except (TypeError, ValueError):
        out = np.zeros(0)
    if out.ndim != 2 or out.shape[-1] != 2 or not 3 <= len(out) <= 5000 or not np.all(np.isfinite(out)):
        raise ModelError(f"the {what} has no corners (k, 2)", "give three or more, each as (x, y)")
    return out


def stress(
    section: Any, force: ArrayLike, *, axis: str | tuple[float, float] = "centroid", points: ArrayLike | None = None
) -> Array:
    """Stresses (…, points, 3) from section forces (…, 6): normal stress σ33, shear stresses σ31 and σ32.

    Parameters
    ----------
    section
        The `sectionproperties` section that the forces act on.
    force
        (shear 1, shear 2, axial, bending 1, bending 2, torsion) as ``result.rod(name).force`` has them, acting at
        ``axis``.
    axis
        The same as in :func:`section_of`.
    points
        (k, 2) in the section's own coordinates; the nodes of its mesh unless given.

    Stress is linear in the forces: six unit states are computed and superposed. Raises ModelError for what is no
    section, forces that are no (…, 6), and points outside.
    """
    _analysed(section)
    given = np.asarray(force, float)
    if given.ndim < 1 or given.shape[-1] != 6:
        raise ModelError(f"section forces of shape {given.shape} are not (…, 6)", "give result.rod(name).force")
    at = _axis(section, axis)
    c, s = _centroid(section) - at, _shear_centre(section) - at
    nodes = None if points is None else [(float(x), float(y)) for x, y in np.asarray(points, float)]
    columns: list[Array] = []
    for k in range(6):
        n1, n2, n3, m1, m2, m3 = np.eye(6)[k].tolist()
        # moments about the centroid and the shear centre; its M_yy is −∫σ x, as ours about d2
        load = {
            "n": n3, "vx": n1, "vy": n2, "mxx": m1 - c[1] * n3, "myy": m2 + c[0] * n3,
            "mzz": m3 - (s[0] * n2 - s[1] * n1),
        }  # fmt: skip
        if nodes is None:
            parts = section.calculate_stress(**load).get_stress()
            columns.append(np.sum([[p["sig_zz"], p["sig_zx"], p["sig_zy"]] for p in parts], axis=0).T)
            continue
        found = section.get_stress_at_points(pts=nodes, **load)
        for point, value in zip(nodes, found, strict=True):
            if value is None:
                raise ModelError(f"the point {point} is not in the section", "give points of the section")
        columns.append(np.array(found, float))
    return np.einsum("pcf,...f->...pc", np.stack(columns, -1), given)


def _analysed(section: Any) -> None:
    if not all(hasattr(section, a) for a in ("calculate_warping_properties", "section_props", "elements")):
        from directrix.geometry.pieces import extra

        extra("sectionproperties", "a section of any shape")
        raise ModelError(
            f"{shown(section)} is no section of sectionproperties", "give sectionproperties.analysis.Section(geometry)"
        )
    if section.section_props.area is None:
        section.calculate_geometric_properties()
    if section.section_props.j is None:
        try:
            section.calculate_warping_properties()
        except Exception as error:  # whatever its solver raises
            raise ModelError(f"the section cannot be analysed: {error}", "give one connected shape") from error


def _centroid(section: Any) -> Array:
    return np.array(section.get_c(), float)


def _shear_centre(section: Any) -> Array:
    return np.array(section.get_sc(), float)


def _axis(section: Any, axis: str | tuple[float, float]) -> Array:
    if not isinstance(axis, str):
        return np.array([number(v, "axis of a section") for v in axis])
    choice(axis, "axis of a section", AXES)
    return {"centroid": _centroid, "shear_centre": _shear_centre}.get(axis, lambda _: np.zeros(2))(section)


def _clean(at: Array, section: Any) -> Array:
    """Without what the mesh makes of zeros: a millionth of the section's size."""
    size = float(np.ptp(section.mesh_nodes, axis=0).max())
    return np.where(np.abs(at) < 1e-5 * size, 0.0, at)


def _mass(section: Any, at: Array, rho: float, own: bool) -> tuple[float, Array, Array]:
    """Mass, first and second moments about ``at``, of straight triangles."""
    mass, first, second = 0.0, np.zeros(2), np.zeros((2, 2))
    for element in section.elements:
        p = np.asarray(element.coords, float)[:, :3].T - at
        u, v = p[1] - p[0], p[2] - p[0]
        m = 0.5 * abs(u[0] * v[1] - u[1] * v[0]) * (float(element.material.density) if own else rho)
        mid = 0.5 * (p + np.roll(p, -1, axis=0))  # exact for quadratics
        mass += m
        first += m * mid.mean(axis=0)
        second += m / 3.0 * mid.T @ mid
    return mass, first, second


def _outline(section: Any) -> Array:
    """The exterior of the geometry."""
    shape = section.geometry.geom
    parts = getattr(shape, "geoms", [shape])
    whole = max(parts, key=lambda g: g.area)
    return np.array(whole.exterior.coords)[:-1]
