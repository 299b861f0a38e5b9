"""Steel profiles by their names: dimensions of the standards, everything else computed from them.

Dimensions [mm]: IPE, HEA, HEB of EN 10365, UPN of DIN 1026-1 and EN 10365; hot-finished CHS and RHS with the corner
radii of EN 10210-2, cold-formed ones ("CFRHS") with those of EN 10219-2. Area and second moments are those of the
outline with its fillets. Torsion constants of RHS follow the formula of EN 10210-2; those of the others, and
shear centres, are what quadratic finite elements of the same outline give for Saint-Venant's problem, converged to
3e-4. Shear areas are those of thin walls, A_s = I²/∫(Q/t)² dA.
"""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false
# pyright: reportUnknownLambdaType=false

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.basis import gauss
from directrix.checks import nearest, number, shown
from directrix.errors import ModelError

if TYPE_CHECKING:
    from directrix.section import Section

Array = NDArray[np.float64]

__all__ = ["PROFILES", "Shape", "profile", "rounded", "section_of"]

IPE = """80 80 46 3.8 5.2 5 0.6732; 100 100 55 4.1 5.7 7 1.154; 120 120 64 4.4 6.3 7 1.69;
140 140 73 4.7 6.9 7 2.403; 160 160 82 5 7.4 9 3.533; 180 180 91 5.3 8 9 4.726;
200 200 100 5.6 8.5 12 6.852; 220 220 110 5.9 9.2 12 8.989; 240 240 120 6.2 9.8 15 12.75;
270 270 135 6.6 10.2 15 15.72; 300 300 150 7.1 10.7 15 19.77; 330 330 160 7.5 11.5 18 27.61;
360 360 170 8 12.7 18 37.11; 400 400 180 8.6 13.5 21 50.46; 450 450 190 9.4 14.6 21 66.11;
500 500 200 10.2 16 21 88.69; 550 550 210 11.1 17.2 24 121.8; 600 600 220 12 19 24 164.7"""
HEA = """100 96 100 5 8 12 5.204; 120 114 120 5 8 12 5.962; 140 133 140 5.5 8.5 12 8.038; 160 152 160 6 9 15 11.85;
180 171 180 6 9.5 15 14.67; 200 190 200 6.5 10 18 20.45; 220 210 220 7 11 18 28.11;
240 230 240 7.5 12 21 41.07; 260 250 260 7.5 12.5 24 52.05; 280 270 280 8 13 24 61.45;
300 290 300 8.5 14 27 84.31; 320 310 300 9 15.5 27 108.9; 340 330 300 9.5 16.5 27 128.8;
360 350 300 10 17.5 27 151.1; 400 390 300 11 19 27 191.5; 450 440 300 11.5 21 27 249.3;
500 490 300 12 23 27 317.9; 550 540 300 12.5 24 27 360.8; 600 590 300 13 25 27 407.8"""
HEB = """100 100 100 6 10 12 9.316; 120 120 120 6.5 11 12 13.95; 140 140 140 7 12 12 20.21;
160 160 160 8 13 15 31.27; 180 180 180 8.5 14 15 42.27; 200 200 200 9 15 18 59.63;
220 220 220 9.5 16 18 77.07; 240 240 240 10 17 21 103.7; 260 260 260 10 17.5 24 125.8;
280 280 280 10.5 18 24 145.4; 300 300 300 11 19 27 187.5; 320 320 300 11.5 20.5 27 229.4;
340 340 300 12 21.5 27 262.2; 360 360 300 12.5 22.5 27 298.1; 400 400 300 13.5 24 27 361.3;
450 450 300 14 26 27 449.1; 500 500 300 14.5 28 27 550.2; 550 550 300 15 29 27 612.6;
600 600 300 15.5 30 27 679.9"""
UPN = """80 80 45 6 8 8 4 25.88 2.156; 100 100 50 6 8.5 8.5 4.5 28.6 2.826; 120 120 55 7 9 9 4.5 29.64 4.148;
140 140 60 7 10 10 5 33.05 5.724; 160 160 65 7.5 10.5 10.5 5.5 34.93 7.44; 180 180 70 8 11 11 5.5 36.89 9.526;
200 200 75 8.5 11.5 11.5 6 38.76 12.02; 220 220 80 9 12.5 12.5 6.5 41.36 16.17; 240 240 85 9.5 13 13 6.5 43.32 19.84;
260 260 90 10 14 14 7 45.94 25.78; 280 280 95 10 15 15 7.5 49.61 31.42; 300 300 100 10 16 16 8 53.32 38.05"""


def _table(family: str, text: str) -> dict[str, tuple[float, ...]]:
    rows = (row.split() for row in text.split(";"))
    return {f"{family}{row[0]}": tuple(float(v) for v in row[1:]) for row in rows}


PROFILES: dict[str, tuple[float, ...]] = {
    **_table("IPE", IPE), **_table("HEA", HEA), **_table("HEB", HEB), **_table("UPN", UPN),
}  # fmt: skip
"""Height, width, web, flange, fillet radius, for UPN also the radius of the toe and how far the shear centre is behind
the centroid [mm]; last the torsion constant [cm⁴]."""
HOLLOW = re.compile(r"(CHS|CFCHS|RHS|SHS|CFRHS|CFSHS)(\d+(?:\.\d+)?(?:X\d+(?:\.\d+)?)*)")


@dataclass(frozen=True)
class Shape:
    """What a profile is, in millimetres, about its centroid; ``A1`` is the shear area along d1."""

    A: float
    I1: float
    I2: float
    J: float
    A1: float
    A2: float
    shear_centre: tuple[float, float]
    outline: Array


def profile(name: str) -> Shape:
    """The shape of a profile by its name; raises ModelError for one that is not known."""
    if not isinstance(name, str):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"{shown(name)} is not the name of a profile", 'give e.g. "IPE200"')
    key = re.sub(r"[\s_-]", "", name.upper().replace("×", "X").replace(",", "."))
    key = re.sub(r"^HE(\d+)([AB])$", r"HE\2\1", key)
    if key in PROFILES:
        dims = PROFILES[key]
        return _channel(*dims) if key.startswith("UPN") else _beam(*dims)
    hollow = HOLLOW.fullmatch(key)
    if hollow is None:
        raise ModelError(
            f"there is no profile {name!r}",
            f"{nearest(key, PROFILES)}there are IPE80 … 600, HEA and HEB100 … 600, UPN80 … 300, CHS DxT, RHS HxBxT, "
            "SHS BxT",
        )
    sizes = [float(v) for v in hollow[2].split("X")]
    round_, square = "CHS" in hollow[1], "SHS" in hollow[1]
    if square and len(sizes) == 3 and sizes[0] == sizes[1]:
        sizes = sizes[1:]  # SHS 100x100x5
    if len(sizes) != (2 if round_ or square else 3):
        raise ModelError(f"profile {name!r} has {len(sizes)} dimensions", "give CHS DxT, SHS BxT or RHS HxBxT")
    if not 0.0 < 2.0 * sizes[-1] < min(sizes[:-1]):
        raise ModelError(f"profile {name!r}: its wall does not fit into it", "the wall comes last, in millimetres")
    if round_:
        return _tube(*sizes)
    h, b, t = sizes if len(sizes) == 3 else (sizes[0], *sizes)
    return _box(h, b, t, cold=hollow[1].startswith("CF"))


def section_of(
    name: str, *, E: float, nu: float | None, G: float | None, rho: float, unit: float, damping: ArrayLike
) -> Section:
    """See :meth:`Section.profile`. The axis is the line of centroids; warping is left free.

    Raises ModelError for a name that is not known and a material that is none.
    """
    from directrix.section import Section

    shape = profile(name)
    E, rho, u = number(E, "E", above=0.0), number(rho, "rho", least=0.0), number(unit, "unit", above=0.0)
    if (nu is None) == (G is None):
        raise ModelError(f"profile {name!r} needs nu or G, one of them", "give nu= (G = E/2(1+ν)) or G=")
    if nu is not None:
        if not -1.0 < number(nu, "nu") <= 0.5:
            raise ModelError(f"nu = {nu:g} is not in −1 < ν ≤ 0.5", "give another, or G=")
        G = E / (2.0 * (1.0 + nu))
    G = number(G, "G", above=0.0)
    made = Section.from_moduli(
        EA=E * shape.A * u**2, GA1=G * shape.A1 * u**2, GA2=G * shape.A2 * u**2, EI1=E * shape.I1 * u**4,
        EI2=E * shape.I2 * u**4, GJ=G * shape.J * u**4, A_rho=rho * shape.A * u**2, I_rho1=rho * shape.I2 * u**4,
        I_rho2=rho * shape.I1 * u**4, damping=damping, shear_centre=np.array(shape.shear_centre) * u,
    )  # fmt: skip
    from dataclasses import replace

    said = (
        f"{name}: axis through the centroid, web along d2; shear areas {shape.A1 * u**2:.6g} and {shape.A2 * u**2:.6g} "
        f"of thin walls, torsion constant {shape.J * u**4:.6g}; warping is free and costs nothing",
    )
    return replace(made, outline=shape.outline * u, assumptions=said)


def rounded(corners: ArrayLike, radii: ArrayLike, points: int = 8) -> Array:
    """A polygon (k, 2) whose corners are rounded by their radii (k,), ``points`` to an arc."""
    p, out = np.asarray(corners, float), []
    for k, r in enumerate(np.asarray(radii, float).tolist()):
        a, b, c = p[k - 1], p[k], p[(k + 1) % len(p)]
        if r == 0.0:
            out.append(b[None])
            continue
        u, v = (a - b) / np.linalg.norm(a - b), (c - b) / np.linalg.norm(c - b)
        half = 0.5 * np.arccos(np.clip(u @ v, -1.0, 1.0))
        middle = b + (u + v) / np.linalg.norm(u + v) * r / np.sin(half)
        first = b + u * r / np.tan(half) - middle
        turn = (np.pi - 2.0 * half) * (1.0 if u[0] * v[1] - u[1] * v[0] < 0.0 else -1.0)
        angle = np.linspace(0.0, turn, points)
        cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
        out.append(middle + cos * first + sin * np.array([-first[1], first[0]]))
    return np.concatenate(out)


def moments(outline: Array) -> tuple[float, Array, Array]:
    """Area, centroid (2,) and ∫ξα ξβ dA (2, 2) about the centroid of a polygon, by Green's theorem."""
    p, q = outline, np.roll(outline, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
    area = 0.5 * float(cross.sum())
    centre = ((p + q) * cross[:, None]).sum(axis=0) / (6.0 * area)
    p, q = p - centre, q - centre
    cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
    both = sum(np.einsum("k,ki,kj->ij", cross, a, b) for a, b in ((p, p), (q, q), (p + q, p + q))) / 24.0
    return abs(area), centre, np.asarray(both) * np.sign(area)


def _integral(f: object, a: float, b: float) -> float:
    """Of a polynomial up to degree nine."""
    xi, w = gauss(5)
    x = 0.5 * (a + b) + 0.5 * (b - a) * xi
    return 0.5 * (b - a) * float(w @ f(x))  # type: ignore[operator]


def _beam(h: float, b: float, tw: float, tf: float, r: float, J: float) -> Shape:
    x, w, y, i = 0.5 * b, 0.5 * tw, 0.5 * h, 0.5 * h - tf
    corners = [
        (x, -y),
        (x, -i),
        (w, -i),
        (w, i),
        (x, i),
        (x, y),
        (-x, y),
        (-x, i),
        (-w, i),
        (-w, -i),
        (-x, -i),
        (-x, -y),
    ]
    radii = [0, 0, r, r, 0, 0, 0, 0, r, r, 0, 0]
    area, _, both = moments(rounded(corners, radii, 200))
    hm = h - tf
    I = 0.5 * b * tf * hm**2 + tw * hm**3 / 12.0
    flow = 4.0 * tf * (0.5 * hm) ** 2 * (0.5 * b) ** 3 / 3.0
    flow += _integral(lambda z: (0.5 * b * tf * hm + 0.5 * tw * (0.25 * hm**2 - z**2)) ** 2 / tw, -0.5 * hm, 0.5 * hm)
    return Shape(
        area, both[1, 1], both[0, 0], 1e4 * J, 5.0 / 3.0 * b * tf, I**2 / flow, (0.0, 0.0), rounded(corners, radii)
    )


def _channel(h: float, b: float, tw: float, tf: float, r: float, toe: float, behind: float, J: float) -> Shape:
    """Flanges that slope by 8 %, ``tf`` thick at half of the width; the back of the web on −d1."""
    slope, y = 0.08, 0.5 * h

    def inner(x: float) -> float:
        return y - tf - slope * (0.5 * b - x)

    corners = [(0, -y), (b, -y), (b, -inner(b)), (tw, -inner(tw)), (tw, inner(tw)), (b, inner(b)), (b, y), (0, y)]
    radii = [0, 0, toe, r, r, toe, 0, 0]
    area, centre, both = moments(rounded(corners, radii, 200))
    # thin walls: flange from the middle of the web on, thickness t and height z of its middle line
    back, bm = 0.5 * tw, b - 0.5 * tw
    xi, w = np.polynomial.legendre.leggauss(40)
    x, w = back + 0.5 * bm * (1.0 + xi), 0.5 * bm * w
    t = tf + slope * (0.5 * b - x)
    z = y - 0.5 * t
    top = y - 0.5 * (tf + slope * (0.5 * b - back))
    I = 2.0 * float(w @ (t * z**2)) + tw * top**3 / 1.5

    def beyond(f: Array) -> Array:
        """∫f from x to the toe, of values at the Gauss points."""
        fit = np.polynomial.legendre.Legendre.fit(x, f, 12).integ()
        return fit(b) - fit(x)

    q = beyond(t * z)
    web_flow = _integral(lambda v: (float(w @ (t * z)) + 0.5 * tw * (top**2 - v**2)) ** 2 / tw, -top, top)
    flow = 2.0 * float(w @ (q**2 / t)) + web_flow
    web = float(w @ (t * (x - back))) * 2.0 / (2.0 * float(w @ t) + 2.0 * top * tw)  # centroid, from that of the web
    arm = x - back - web
    across = 2.0 * float(w @ (t * arm**2)) + 2.0 * top * tw * web**2
    side = 2.0 * float(w @ (beyond(t * arm) ** 2 / t)) + 2.0 * tw * web**2 * top**3 / 3.0
    shear = (-behind, 0.0)
    return Shape(
        area, both[1, 1], both[0, 0], 1e4 * J, across**2 / side, I**2 / flow, shear, rounded(corners, radii) - centre
    )


def _tube(d: float, t: float) -> Shape:
    R, r = 0.5 * d, 0.5 * d - t
    inertia = 0.25 * np.pi * (R**4 - r**4)
    area = np.pi * (R**2 - r**2)
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    outline = R * np.stack([np.cos(angle), np.sin(angle)], -1)
    return Shape(area, inertia, inertia, 2.0 * inertia, 0.5 * area, 0.5 * area, (0.0, 0.0), outline)


def _box(h: float, b: float, t: float, *, cold: bool) -> Shape:
    outer = (2.0 if t <= 6.0 else 2.5 if t <= 10.0 else 3.0) * t if cold else 1.5 * t
    inner = outer - t if cold else t
    if min(h, b) < 2.0 * outer:
        raise ModelError(f"a hollow profile of {h:g}×{b:g}×{t:g} mm has no room for its corners", "give a thinner wall")

    def ring(h: float, b: float, r: float, points: int) -> Array:
        x, y = 0.5 * b, 0.5 * h
        return rounded([(x, -y), (x, y), (-x, y), (-x, -y)], [r] * 4, points)

    a, _, first = moments(ring(h, b, outer, 200))
    hole, _, second = moments(ring(h - 2.0 * t, b - 2.0 * t, inner, 200))
    both = first - second
    rc = 0.5 * (outer + inner)
    hm, bm = h - t, b - t
    way = 2.0 * (hm + bm) - 2.0 * rc * (4.0 - np.pi)
    inside = hm * bm - rc**2 * (4.0 - np.pi)
    J = t**3 * way / 3.0 + 4.0 * inside**2 * t / way

    def shear(hm: float, bm: float) -> float:
        """Along ``hm``: half of it, one wall of it and two halves of the others."""
        I = 2.0 * (t * hm**3 / 12.0 + bm * t * (0.5 * hm) ** 2)
        flow = 4.0 * t * (0.5 * hm) ** 2 * (0.5 * bm) ** 3 / 3.0
        start = 0.25 * bm * t * hm
        flow += 2.0 * _integral(lambda z: (start + 0.5 * t * (0.25 * hm**2 - z**2)) ** 2 / t, -0.5 * hm, 0.5 * hm)
        return I**2 / flow

    return Shape(a - hole, both[1, 1], both[0, 0], J, shear(bm, hm), shear(hm, bm), (0.0, 0.0), ring(h, b, outer, 6))
