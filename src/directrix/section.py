"""Cross-sections: stiffness and inertia of a rod per unit length, in its frame d1, d2, d3.

Components are always (shear 1, shear 2, axial, bending 1, bending 2, torsion); bending 1 turns *about* d1,
EI1 = E ∫ξ2² dA. The Euler dyadic I_ρ,αβ = ∫ρ ξα ξβ dA (paper 31) sits on (d1, d2), so I_rho2 belongs with EI1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from directrix.checks import choice, number
from directrix.errors import ModelError
from directrix.laws import Energy, Law

Array = NDArray[np.float64]

__all__ = ["Section"]

ORDERS = {"shear-axial": (0, 1, 2, 3, 4, 5), "axial-first": (1, 2, 0, 4, 5, 3)}


def _numbers(value: Any) -> Array:
    """An array of real numbers, (0,) when it is none."""
    try:
        a = np.array(value)
    except Exception:  # whatever a foreign array may raise
        a = np.empty(0)
    return a.astype(float) if a.ndim and a.dtype.kind in "iuf" and not np.ma.is_masked(value) else np.empty(0)


def _extent(value: Any, what: str) -> float:
    """A length whose fourth power is a number."""
    x = number(value, what, above=0.0)
    if not 1e-60 < x < 1e60:
        raise ModelError(f"{what} = {x:g} is out of reach of floating point", "use other units")
    return x


def _matrix(value: Any, what: str, size: int) -> Array:
    a = _numbers(value)
    if a.shape != (size, size):
        raise ModelError(f"{what} is not a {size}×{size} matrix of numbers", f"give {size} rows of {size} numbers")
    if not np.all(np.isfinite(a)):
        raise ModelError(f"{what} is not finite", "give finite numbers")
    if np.abs(a - a.T).max() > 1e-9 * max(np.abs(a).max(), 1e-300):
        raise ModelError(f"{what} is not symmetric", "give ½(A + Aᵀ) if that is what is meant")
    a = 0.5 * a + 0.5 * a.T
    a.setflags(write=False)
    return a


@dataclass(frozen=True, eq=False)
class Section:
    """A section by its 6×6 stiffness.

    Parameters
    ----------
    stiffness
        (6, 6), symmetric and positive definite, in force units (shear, axial) and force·length² (bending, torsion).
    A_rho
        Mass per unit length.
    I_rho
        (2, 2) rotary inertia ∫ρ ξα ξβ dA per unit length.
    order
        Of the rows of ``stiffness``: "shear-axial" (shear 1, shear 2, axial, bending 1, bending 2, torsion) or
        "axial-first" (axial, shear 1, shear 2, torsion, bending 1, bending 2). Kept as "shear-axial".
    outline
        (k, 2) polygon of the section in (d1, d2), for pictures. Around a hole it goes in and out again on one line: the
        outer ring and back to its first point, then the inner ring the other way round, closed as well.
    damping
        (6, 6) viscous matrix C_v of Kelvin–Voigt damping, S += C_v dε/dt, symmetric and not negative; a number η
        stands for η times the stiffness (a relaxation time). In the order of ``stiffness``. Used in dynamics.
    law
        Stored energy in place of ½ ε·Cε, see :meth:`hyperelastic`; ``stiffness`` is then that at no strain.
    S_rho
        (2,) first moments of mass ∫ρ ξα dA per unit length: not zero where the axis is off the line of mass centres.
    assumptions
        Sentences on what a constructor assumed; ``check`` prints them.

    Raises
    ------
    ModelError
        Something is not finite, not symmetric or not positive.
    """

    stiffness: Array
    A_rho: float = 0.0
    I_rho: Array = field(default_factory=lambda: np.zeros((2, 2)))
    order: str = field(kw_only=True)
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)), kw_only=True)
    damping: Array = field(default_factory=lambda: np.zeros((6, 6)), kw_only=True)
    law: Law | None = field(default=None, kw_only=True)
    S_rho: Array = field(default_factory=lambda: np.zeros(2), kw_only=True)
    assumptions: tuple[str, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        rows = ORDERS[choice(self.order, "order of a stiffness", ORDERS)]
        c = _matrix(self.stiffness, "the stiffness of a section", 6)[np.ix_(rows, rows)]
        if np.linalg.eigvalsh(_scaled(c))[0] <= 1e-12:
            raise ModelError(
                f"the stiffness of a section is not positive definite: {_costs_nothing(c)} costs no energy",
                "every deformation must cost energy: check the signs",
            )
        inertia = _matrix(self.I_rho, "I_rho of a section", 2)
        if np.linalg.eigvalsh(inertia)[0] < -1e-12 * np.abs(inertia).max():
            raise ModelError("I_rho of a section is negative in some direction", "check the signs of ∫ρ ξα ξβ dA")
        moments = _numbers(self.S_rho)
        if moments.shape != (2,) or not np.all(np.isfinite(moments)):
            raise ModelError("S_rho of a section is not two numbers", "give ∫ρ ξ1 dA and ∫ρ ξ2 dA")
        _refuse_inertia(number(self.A_rho, "A_rho", least=0.0), moments, inertia)
        outline = _numbers(self.outline)
        if outline.shape != (len(outline), 2) or not np.all(np.isfinite(outline)):
            raise ModelError("the outline of a section is not a polygon", "give finite points (k, 2) in (d1, d2)")
        viscous = _damping(self.damping, c, rows)
        for a in (c, outline, viscous, moments):
            a.setflags(write=False)
        for name, value in {
            "stiffness": c, "A_rho": number(self.A_rho, "A_rho", least=0.0), "I_rho": inertia,
            "order": "shear-axial", "outline": outline, "damping": viscous, "S_rho": moments,
        }.items():  # fmt: skip
            object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Section) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[object, ...]:
        return (
            self.stiffness.tobytes(),
            self.A_rho,
            self.I_rho.tobytes(),
            self.S_rho.tobytes(),
            self.outline.tobytes(),
            self.damping.tobytes(),
            self.law,
            self.assumptions,
        )

    def damped(self, damping: ArrayLike) -> Self:
        """The same section with Kelvin–Voigt damping, see ``damping``."""
        return replace(self, damping=np.asarray(damping, float))

    def forces(self, strain: Array) -> Array:
        """Section forces (…, 6) from strains (…, 6)."""
        return strain @ self.stiffness if self.law is None else self.law.forces(strain)

    @property
    def eccentric(self) -> bool:
        """True when the mass is off the axis."""
        return bool(np.any(self.S_rho))

    @property
    def varies(self) -> bool:
        """True when it is not the same along the rod."""
        return False

    @property
    def parts(self) -> tuple[Section, ...]:
        """This section; those of the stations where it varies."""
        return (self,)

    @property
    def mean_mass(self) -> float:
        """Mass per unit length, in the mean over the rod."""
        return self.A_rho

    def mapped(self, change: Callable[[Section], Section]) -> Section:
        """``change`` of this section; of every one of them where it varies along the rod."""
        return change(self)

    def at(self, fraction: float) -> Section:
        """The section at a fraction of a rod's length: this one, everywhere."""
        return self

    def along(self, fractions: Array) -> Stressed:
        """What gives section forces at stress points at ``fractions`` (stations,) of the length."""
        return self

    def offset(self, x1: float, x2: float) -> Self:
        """The same section about an axis from which its present one is at ξ = (``x1``, ``x2``).

        Γ of the present axis is Γ + Ω × x, so C becomes Tᵀ C T; first moments of mass grow by A_ρ x, I_ρ by Steiner's.
        Lengths are those of the new axis. Raises ModelError for a section with a law.
        """
        x = np.array([number(x1, "x1"), number(x2, "x2"), 0.0])
        if self.law is not None:
            raise ModelError("a section with a law of its own has no offset", "write the law about the axis of the rod")
        turn = np.eye(6)
        turn[:3, 3:] = np.array([[0.0, 0.0, x[1]], [0.0, 0.0, -x[0]], [-x[1], x[0], 0.0]]) * -1.0
        s, y = self.S_rho, x[:2]
        inertia = self.I_rho + np.outer(s, y) + np.outer(y, s) + self.A_rho * np.outer(y, y)
        return replace(
            self, stiffness=turn.T @ self.stiffness @ turn, damping=turn.T @ self.damping @ turn, I_rho=inertia,
            S_rho=s + self.A_rho * y, outline=self.outline + y,
        )  # fmt: skip

    def turned(self, angle: float) -> Self:
        """The same section turned in its plane about d3, from d1 towards d2, by ``angle`` [rad].

        Raises ModelError for a section with a law.
        """
        if self.law is not None:
            raise ModelError("a section with a law of its own cannot be turned", "turn d1 of the rod")
        c, s = np.cos(number(angle, "angle")), np.sin(angle)
        plane, q = np.array([[c, -s], [s, c]]), np.eye(6)
        q[:2, :2] = q[3:5, 3:5] = plane
        return replace(
            self, stiffness=q @ self.stiffness @ q.T, damping=q @ self.damping @ q.T,
            I_rho=plane @ self.I_rho @ plane.T, S_rho=plane @ self.S_rho, outline=self.outline @ plane.T,
        )  # fmt: skip

    @classmethod
    def profile(
        cls, name: str, *, E: float, nu: float | None = None, G: float | None = None, rho: float = 0.0,
        unit: float = 1e-3, damping: ArrayLike = 0.0,
    ) -> Section:  # fmt: skip
        """A rolled or hollow steel profile by its name, "IPE200", "HEA 160", "UPN 100", "CHS 60.3x5", "RHS 100x50x4".

        Its web is along d2. ``unit`` is a millimetre in the units of the model; see ``directrix.profiles``, also for
        what is raised.
        """
        from directrix.profiles import section_of

        return section_of(name, E=E, nu=nu, G=G, rho=rho, unit=unit, damping=damping)

    @classmethod
    def polygon(
        cls, outline: ArrayLike, *, holes: Sequence[ArrayLike] = (), E: float, nu: float | None = None,
        G: float | None = None, rho: float = 0.0, axis: str | tuple[float, float] = "centroid",
        mesh: float | None = None, damping: ArrayLike = 0.0,
    ) -> Section:  # fmt: skip
        """Any shape by its corners (k, 2) along d1 and d2, and those of its holes; see ``directrix.shapes.polygon``."""
        from directrix.shapes import polygon

        return polygon(outline, holes, E=E, nu=nu, G=G, rho=rho, axis=axis, mesh=mesh, damping=damping)

    @classmethod
    def from_sectionproperties(
        cls, section: Any, *, axis: str | tuple[float, float] = "centroid", E: float | None = None,
        nu: float | None = None, rho: float | None = None,
    ) -> Section:  # fmt: skip
        """Any shape from the package `sectionproperties`; see ``directrix.shapes.section_of``."""
        from directrix.shapes import section_of

        return section_of(section, axis=axis, E=E, nu=nu, rho=rho)

    def stored(self, strain: Array) -> Array:
        """Stored energy per unit length (…,) at strains (…, 6)."""
        if self.law is None:
            return 0.5 * np.einsum("...i,...i->...", strain, self.forces(strain))
        return np.broadcast_to(self.law.energy([strain[..., k] for k in range(6)]), strain.shape[:-1]).copy()

    @classmethod
    def hyperelastic(
        cls, energy: Energy, *, A_rho: float = 0.0, I_rho: ArrayLike | None = None, metric: ArrayLike | None = None,
        damping: ArrayLike = 0.0, outline: ArrayLike | None = None,
    ) -> Self:  # fmt: skip
        """A section by its stored energy per unit length, a plain function of the six strains.

        Parameters
        ----------
        energy
            ``energy(strain)`` with strain = (shear 1, shear 2, axial, bending 1, bending 2, torsion); see
            :mod:`directrix.laws` for what it may use, and for two laws. Stress and tangent are derived; conserving
            steps use the discrete gradient of Gonzalez (1996).
        A_rho, I_rho
            As in :class:`Section`.
        metric
            (6, 6) symmetric positive definite G of the discrete gradient; ∂²W/∂ε² at no strain unless given. A law
            whose stiffness vanishes there needs one.
        damping, outline
            As in :class:`Section`.

        Raises ModelError for an energy that cannot be recorded or has no positive definite metric.
        """
        given = None if metric is None else _matrix(metric, "the metric of a section", 6)
        law = Law.record(energy, given)
        if np.linalg.eigvalsh(_scaled(law.metric))[0] <= 1e-12:
            raise ModelError(
                "the stiffness of a section at no strain is not positive definite" if given is None
                else "the metric of a section is not positive definite",
                "give metric=, a (6, 6) matrix of the size of the stiffness in use",
            )  # fmt: skip
        inertia = np.zeros((2, 2)) if I_rho is None else np.asarray(I_rho, float)
        return cls(
            law.metric, A_rho, inertia, order="shear-axial", damping=np.asarray(damping, float), law=law,
            outline=np.zeros((0, 2)) if outline is None else np.asarray(outline, float),
        )  # fmt: skip

    @classmethod
    def from_moduli(
        cls, *, EA: float, GA1: float, GA2: float, EI1: float, EI2: float, GJ: float,
        A_rho: float = 0.0, I_rho1: float = 0.0, I_rho2: float = 0.0, damping: ArrayLike = 0.0,
        EI12: float = 0.0, GA12: float = 0.0, I_rho12: float = 0.0, centroid: ArrayLike = (0.0, 0.0),
        shear_centre: ArrayLike = (0.0, 0.0), mass_centre: ArrayLike | None = None,
    ) -> Self:  # fmt: skip
        """Moduli of a section; GA1, GA2 with their shear factors in them. I_rho1 = ∫ρ ξ1² dA sits on d1.

        EA and EI act about the ``centroid``, GA and GJ about the ``shear_centre``, both (ξ1, ξ2) from the axis; the
        inertia is about the ``mass_centre``, the centroid unless given. EI12 = −E∫ξ1 ξ2 dA and GA12 couple where d1
        and d2 are no principal axes.
        """
        given = {"GA1": GA1, "GA2": GA2, "EA": EA, "EI1": EI1, "EI2": EI2, "GJ": GJ}
        c = np.diag([number(v, k, above=0.0) for k, v in given.items()])
        c[3, 4] = c[4, 3] = number(EI12, "EI12")
        c[0, 1] = c[1, 0] = number(GA12, "GA12")
        inertia = np.diag([number(I_rho1, "I_rho1", least=0.0), number(I_rho2, "I_rho2", least=0.0)])
        inertia[0, 1] = inertia[1, 0] = number(I_rho12, "I_rho12")
        mass = number(A_rho, "A_rho", least=0.0)
        places = [
            _place(p, k)
            for k, p in (
                ("centroid", centroid),
                ("shear_centre", shear_centre),
                ("mass_centre", centroid if mass_centre is None else mass_centre),
            )
        ]
        (c1, c2), (s1, s2), m = places
        turn = np.eye(6)  # axial strain at the centroid, shear at the shear centre
        turn[2, 3], turn[2, 4] = c2, -c1
        turn[0, 5], turn[1, 5] = -s2, s1
        return cls(
            turn.T @ c @ turn, mass, inertia + mass * np.outer(m, m), order="shear-axial", S_rho=mass * m,
            damping=np.asarray(damping, float),
        )  # fmt: skip

    @classmethod
    def circle(
        cls, radius: float, *, E: float, nu: float | None = None, G: float | None = None, rho: float = 0.0,
        shear_factor: float | None = None, torsion_constant: float | None = None, damping: ArrayLike = 0.0,
    ) -> Self:  # fmt: skip
        """A solid circle. Shear factor 6(1 + ν)/(7 + 6ν) (Cowper 1966), torsion constant πr⁴/2 (exact)."""
        r = _extent(radius, "radius")
        inertia = 0.25 * np.pi * r**4
        angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        outline = r * np.stack([np.cos(angle), np.sin(angle)], -1)

        def factor(nu: float) -> float:
            return 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)

        return cls._shape(
            "circle", np.pi * r**2, inertia, inertia, 2.0 * inertia, "πr⁴/2", factor, "6(1+ν)/(7+6ν), Cowper 1966",
            outline, E, nu, G, rho, shear_factor, torsion_constant, damping,
        )  # fmt: skip

    @classmethod
    def tube(
        cls, outer: float, wall: float, *, E: float, nu: float | None = None, G: float | None = None, rho: float = 0.0,
        shear_factor: float | None = None, torsion_constant: float | None = None, damping: ArrayLike = 0.0,
    ) -> Self:  # fmt: skip
        """A tube of outer radius ``outer``. Shear factor of Cowper (1966), torsion constant ½π(R⁴ − r⁴) (exact)."""
        R, wall = _extent(outer, "outer"), _extent(wall, "wall")
        if not wall < R:
            raise ModelError(
                f"wall = {wall:g} is not less than the outer radius {R:g}",
                "use Section.circle for a solid rod",
            )
        r = R - wall
        inertia = 0.25 * np.pi * (R**4 - r**4)
        m2 = (r / R) ** 2
        angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        ring = np.stack([np.cos(angle), np.sin(angle)], -1)[[*range(24), 0]]

        def factor(nu: float) -> float:
            return 6.0 * (1.0 + nu) * (1.0 + m2) ** 2 / ((7.0 + 6.0 * nu) * (1.0 + m2) ** 2 + (20.0 + 12.0 * nu) * m2)

        return cls._shape(
            "tube", np.pi * (R**2 - r**2), inertia, inertia, 2.0 * inertia, "½π(R⁴−r⁴)", factor, "Cowper 1966",
            np.concatenate([R * ring, r * ring[::-1]]), E, nu, G, rho, shear_factor, torsion_constant, damping,
        )  # fmt: skip

    @classmethod
    def rectangle(
        cls, width: float, height: float, *, E: float, nu: float | None = None, G: float | None = None,
        rho: float = 0.0, shear_factor: float | None = None, torsion_constant: float | None = None,
        damping: ArrayLike = 0.0,
    ) -> Self:  # fmt: skip
        """A rectangle, ``width`` along d1 and ``height`` along d2.

        Shear factor 10(1 + ν)/(12 + 11ν) (Cowper 1966) in both directions; torsion constant by Saint-Venant's series.
        """
        b, h = _extent(width, "width"), _extent(height, "height")
        long, short = max(b, h), min(b, h)
        n = np.arange(1, 200, 2)
        series = np.sum(np.tanh(0.5 * n * np.pi * long / short) / n**5)
        J = long * short**3 / 3.0 * (1.0 - 192.0 / np.pi**5 * short / long * series)
        corners = 0.5 * np.array([[b, h], [-b, h], [-b, -h], [b, -h]])

        def factor(nu: float) -> float:
            return 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)

        return cls._shape(
            "rectangle", b * h, b * h**3 / 12.0, h * b**3 / 12.0, float(J), "Saint-Venant's series", factor,
            "10(1+ν)/(12+11ν), Cowper 1966", corners, E, nu, G, rho, shear_factor, torsion_constant, damping,
        )  # fmt: skip

    @classmethod
    def _shape(
        cls, name: str, area: float, I1: float, I2: float, J: float, J_source: str, factor: Any, factor_source: str,
        outline: ArrayLike, E: float, nu: float | None, G: float | None, rho: float,
        shear_factor: float | None, torsion_constant: float | None, damping: ArrayLike,
    ) -> Self:  # fmt: skip
        """I1 = ∫ξ2² dA (bending about d1), I2 = ∫ξ1² dA."""
        E, rho = number(E, "E", above=0.0), number(rho, "rho", least=0.0)
        if (nu is None) == (G is None):
            raise ModelError(f"a {name} needs nu or G, one of them", "give nu= (G = E/2(1+ν)) or G=")
        if nu is not None:
            nu = number(nu, "nu", above=-1.0)
            if nu > 0.5:
                raise ModelError(f"nu = {nu:g} is greater than 0.5", "give −1 < ν ≤ 0.5, or G= for another material")
            G = E / (2.0 * (1.0 + nu))
        G = number(G, "G", above=0.0)
        said: list[str] = []
        if shear_factor is None:
            ratio = nu if nu is not None else E / (2.0 * G) - 1.0
            if not -1.0 < ratio <= 0.5:
                raise ModelError(
                    f"E and G of a {name} imply ν = {ratio:g}, for which the default shear factor is not known",
                    "give shear_factor=",
                )
            shear_factor = float(factor(ratio))
            said.append(f"{name}: shear factor {shear_factor:.6g} ({factor_source})")
        if torsion_constant is None:
            torsion_constant = J
            said.append(f"{name}: torsion constant {J:.6g} ({J_source})")
        k = number(shear_factor, "shear_factor", above=0.0)
        GA, GJ = k * G * area, G * number(torsion_constant, "torsion_constant", above=0.0)
        return cls(
            np.diag([GA, GA, E * area, E * I1, E * I2, GJ]), rho * area, np.diag([rho * I2, rho * I1]),
            order="shear-axial", outline=np.asarray(outline), assumptions=tuple(said),
            damping=np.asarray(damping, float),
        )  # fmt: skip


class Stressed(Protocol):
    """Gives section forces and stored energy from strains (…, stations, 6) at some stations."""

    def forces(self, strain: Array) -> Array: ...

    def stored(self, strain: Array) -> Array: ...


def _place(value: ArrayLike, what: str) -> Array:
    at = _numbers(value)
    if at.shape != (2,) or not np.all(np.isfinite(at)):
        raise ModelError(f"{what} of a section is not two numbers", "give (ξ1, ξ2)")
    return at


def _refuse_inertia(mass: float, moments: Array, inertia: Array) -> None:
    """The mass of a section about an axis off it: ∫ρ (1, ξ1, ξ2)² dA must not be negative."""
    if not np.any(moments):
        return
    whole = np.block([[np.array([[mass]]), moments[None]], [moments[:, None], inertia]])
    size = np.sqrt(np.maximum(np.diag(whole), 1e-300))
    if np.linalg.eigvalsh(whole / np.outer(size, size))[0] < -1e-9:
        raise ModelError(
            "S_rho is more than A_rho and I_rho allow", "I_rho is about the axis: it holds the part A_ρ x² of an offset"
        )


def _damping(given: ArrayLike, stiffness: Array, rows: Sequence[int]) -> Array:
    """The viscous matrix in our order; a number is a multiple of the stiffness."""
    if np.ndim(given) == 0:
        return number(np.asarray(given).item(), "damping of a section", least=0.0) * stiffness
    viscous = _matrix(given, "the damping of a section", 6)[np.ix_(rows, rows)]
    if np.linalg.eigvalsh(viscous)[0] < -1e-12 * np.abs(viscous).max():
        raise ModelError("the damping of a section is negative for some rate", "damping must take energy, not give it")
    return viscous


def _scaled(c: Array) -> Array:
    """With unit diagonal, so that the sizes of the components do not matter."""
    size = np.sqrt(np.abs(np.diag(c)))
    if np.any(np.diag(c) <= 0.0):
        return -np.eye(len(c))
    return c / np.outer(size, size)


def _costs_nothing(c: Array) -> str:
    """The components of a strain, in our order, that a stiffness does not resist."""
    names = np.array(
        ["shear 1 (GA1)", "shear 2 (GA2)", "extension (EA)", "bending 1 (EI1)", "bending 2 (EI2)", "torsion (GJ)"]
    )
    bad = np.diag(c) <= 0.0
    if not np.any(bad):
        softest = np.abs(np.linalg.eigh(_scaled(c))[1][:, 0])
        bad = softest > 0.1 * softest.max()
    return " with ".join(names[bad].tolist())
