"""Cross-sections in a case file: a shape, a table of properties, moduli, or a full matrix."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from directrix.schema.base import (
    ANGLE,
    AREA,
    BENDING,
    CURVATURE,
    DENSITY,
    FORCE,
    INERTIA_PER_LENGTH,
    LENGTH,
    MASS,
    MASS_PER_LENGTH,
    SECOND_MOMENT,
    STRESS,
    TIME,
    NotNegative,
    Positive,
    Strict,
    refuse,
)

__all__ = [
    "Circle",
    "Damped",
    "Material",
    "Matrix",
    "Moduli",
    "Plain",
    "Polygon",
    "Profile",
    "Properties",
    "Rectangle",
    "Section",
    "Shape",
    "StiffeningBending",
    "Taper",
    "TensionOnly",
    "Tube",
]

Row2 = Annotated[tuple[float, float], Field(strict=False)]
Lengths2 = Annotated[tuple[Annotated[float, LENGTH], Annotated[float, LENGTH]], Field(strict=False)]
Row6 = Annotated[tuple[float, float, float, float, float, float], Field(strict=False)]


class Damped(Strict):
    """What every section may have."""

    damping: Annotated[NotNegative, TIME] = 0.0
    """Kelvin–Voigt damping: viscous matrix over stiffness, a time. Used in dynamics."""
    turn: Annotated[float, ANGLE] = 0.0
    """Angle by which it is turned in its plane, from d1 towards d2; before ``offset``."""
    offset: Lengths2 = (0.0, 0.0)
    """Place of it, as it is, from the axis of the rod, along d1 and d2."""
    viscous: Annotated[tuple[Row6, Row6, Row6, Row6, Row6, Row6], Field(strict=False)] | None = None
    """The viscous matrix itself, 6×6, in place of ``damping``; rows in the order of the stiffness."""

    @model_validator(mode="after")
    def _one_damping(self) -> Self:
        if self.viscous is not None and "damping" in self.model_fields_set:
            raise refuse("damping and viscous both say how it is damped", "keep one", "viscous")
        return self


class Material(Damped):
    """What the sections with a shape need of the material."""

    E: Annotated[Positive, STRESS]
    """Young's modulus (force per area)."""
    nu: Annotated[float, Field(gt=-1.0, le=0.5)] | None = None
    """Poisson's ratio; G = E / (2 (1 + nu)). Either nu or G."""
    G: Annotated[Positive, STRESS] | None = None
    """Shear modulus."""
    rho: Annotated[NotNegative, DENSITY] = 0.0
    """Density (mass per volume); needed in dynamics and under gravity."""

    @model_validator(mode="after")
    def _nu_or_shear_modulus(self) -> Self:
        if (self.nu is None) == (self.G is None):
            raise refuse("a material needs nu or G, one of them", "give nu, or G")
        return self

    @property
    def shear_modulus(self) -> float:
        """G, or what nu gives."""
        return self.G if self.G is not None else self.E / (2.0 * (1.0 + (self.nu or 0.0)))


class Shape(Material):
    """What the sections with a shape compute unless told."""

    shear_factor: Positive | None = None
    """Shear factor; the formula of the shape unless given."""
    torsion_constant: Annotated[Positive, SECOND_MOMENT] | None = None
    """Torsion constant (length⁴); the formula of the shape unless given."""


class Circle(Shape):
    """Solid circle."""

    kind: Literal["circle"]
    radius: Annotated[Positive, LENGTH]


class Rectangle(Shape):
    """Solid rectangle."""

    kind: Literal["rectangle"]
    width: Annotated[Positive, LENGTH]
    """Size along d1."""
    height: Annotated[Positive, LENGTH]
    """Size along d2."""


class Tube(Shape):
    """Round tube."""

    kind: Literal["tube"]
    outer: Annotated[Positive, LENGTH]
    """Outer radius."""
    wall: Annotated[Positive, LENGTH]
    """Wall thickness."""


class Properties(Material):
    """Area, second moments and material, as tables of profiles give them."""

    kind: Literal["properties"]
    A: Annotated[Positive, AREA]
    """Area."""
    I1: Annotated[Positive, SECOND_MOMENT]
    """Second moment for bending about d1, ∫ξ2² dA."""
    I2: Annotated[Positive, SECOND_MOMENT]
    """Second moment for bending about d2, ∫ξ1² dA."""
    J: Annotated[Positive, SECOND_MOMENT]
    """Torsion constant."""
    shear_factor: Positive = 1.0
    """GA1 = GA2 = shear_factor · G · A; A_rho = rho·A, I_rho1 = rho·I2, I_rho2 = rho·I1."""


class Profile(Material):
    """A steel profile of the standards."""

    kind: Literal["profile"]
    name: str
    """IPE, HEA, HEB, UPN, CHS, RHS, SHS (cold-formed: CFRHS …) with their sizes, e.g. "IPE200", "RHS 100x50x4"."""
    unit: Annotated[Positive | None, Field(validate_default=True)] = None
    """A millimetre in lengths of the model; what the units of the case make of it unless given."""

    @field_validator("unit", mode="before")
    @classmethod
    def _millimetre(cls, value: object, info: ValidationInfo) -> object:
        return 1e-3 / info.context["units"].length if value is None and info.context else value


class Polygon(Material):
    """Any shape by its corners; needs the extra `sections`."""

    kind: Literal["polygon"]
    outline: Annotated[tuple[Lengths2, ...], Field(strict=False, min_length=3, max_length=5000)]
    """Corners along d1 and d2, in their order."""
    holes: Annotated[tuple[Annotated[tuple[Lengths2, ...], Field(strict=False, min_length=3, max_length=5000)], ...],
                     Field(strict=False, max_length=100)] = ()  # fmt: skip
    """Corners of each hole."""
    axis: Literal["centroid", "shear_centre", "origin"] | Lengths2 = "centroid"
    """Where the axis of the rod goes through."""
    mesh: Annotated[Positive, AREA] | None = None
    """Largest area of a triangle; a 400th of the section, or less where walls are thin, unless given."""


class Taper(Strict):
    """A section that varies along a rod, linear between other sections of this case."""

    kind: Literal["taper"]
    at: Annotated[tuple[float, ...], Field(strict=False, min_length=2)]
    """Fractions of the arclength, from 0 to 1."""
    sections: Annotated[tuple[str, ...], Field(strict=False, min_length=2)]
    """Names of the sections there, which stand above this one."""

    @model_validator(mode="after")
    def _as_many(self) -> Self:
        if len(self.at) != len(self.sections):
            raise refuse(f"there are {len(self.at)} places and {len(self.sections)} sections", "give as many", "at")
        return self


class Principal(Damped):
    """Principal stiffnesses."""

    EA: Annotated[Positive, FORCE]
    GA1: Annotated[Positive, FORCE]
    GA2: Annotated[Positive, FORCE]
    EI1: Annotated[Positive, BENDING]
    """Bending about d1."""
    EI2: Annotated[Positive, BENDING]
    """Bending about d2."""
    GJ: Annotated[Positive, BENDING]
    A_rho: Annotated[NotNegative, MASS_PER_LENGTH] = 0.0
    """Mass per length."""
    I_rho1: Annotated[NotNegative, INERTIA_PER_LENGTH] = 0.0
    """∫ρ ξ1² dA, on d1 (belongs with EI2)."""
    I_rho2: Annotated[NotNegative, INERTIA_PER_LENGTH] = 0.0
    """∫ρ ξ2² dA, on d2 (belongs with EI1)."""


class Moduli(Principal):
    """Stiffnesses, coupled ones as well."""

    kind: Literal["moduli"]
    EI12: Annotated[float, BENDING] = 0.0
    """−E ∫ξ1 ξ2 dA."""
    GA12: Annotated[float, FORCE] = 0.0
    I_rho12: Annotated[float, INERTIA_PER_LENGTH] = 0.0
    """∫ρ ξ1 ξ2 dA."""
    centroid: Lengths2 = (0.0, 0.0)
    """Where EA and EI act, from the axis along d1 and d2."""
    shear_centre: Lengths2 = (0.0, 0.0)
    """Where GA and GJ act."""
    mass_centre: Lengths2 | None = None
    """What the inertia is about; the centroid unless given."""


class StiffeningBending(Principal):
    """Bending that stiffens exponentially, as rubbers and tissues do; linear in all else."""

    kind: Literal["stiffening-bending"]
    onset: Annotated[Positive, CURVATURE]
    """Curvature at which the moment is e times the linear one."""


class TensionOnly(Principal):
    """A cable: next to no axial force in compression, with a smooth change; linear in all else."""

    kind: Literal["tension-only"]
    width: Positive
    """Axial strain over which the change is smooth."""


class Matrix(Damped):
    """Full 6×6 stiffness."""

    kind: Literal["matrix"]
    stiffness: Annotated[tuple[Row6, Row6, Row6, Row6, Row6, Row6], Field(strict=False)]
    """Symmetric positive definite, by rows."""
    order: Literal["shear-axial", "axial-first"]
    """Of rows and columns: shear 1, shear 2, axial, bending 1, bending 2, torsion, or the axial one first."""
    A_rho: Annotated[NotNegative, MASS_PER_LENGTH] = 0.0
    """Mass per length."""
    I_rho: Annotated[tuple[Row2, Row2], Field(strict=False)] | None = None
    """∫ρ ξα ξβ dA, 2×2."""
    S_rho: Annotated[tuple[Annotated[float, MASS], Annotated[float, MASS]], Field(strict=False)] = (0.0, 0.0)
    """∫ρ ξα dA, first moments of mass."""


Plain = Circle | Rectangle | Tube | Profile | Polygon | Properties | Moduli | StiffeningBending | TensionOnly | Matrix
Section = Annotated[Plain | Taper, Field(discriminator="kind")]
