"""Sections that vary along a rod: stations with sections between which 6×6 and inertia are linear, or a function."""

# pyright: reportUnknownArgumentType=false, reportUnknownVariableType=false, reportUnknownMemberType=false
# pyright: reportUnknownLambdaType=false

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from directrix.basis import gauss
from directrix.checks import number, shown
from directrix.errors import ModelError
from directrix.section import Section

Array = NDArray[np.float64]

__all__ = ["Tapered", "taper"]


@dataclass(frozen=True, eq=False)
class Tapered(Section):
    """A section that varies: as a :class:`Section` it is the one at half of the length, which tolerances are made of.

    ``stations`` are fractions of the arclength with their ``sections``; a ``function`` of the fraction takes their
    place where there is one. Make one with :func:`taper`.
    """

    stations: tuple[float, ...] = field(default=(), kw_only=True)
    sections: tuple[Section, ...] = field(default=(), kw_only=True)
    function: Callable[[float], Section] | None = field(default=None, kw_only=True)

    def _key(self) -> tuple[object, ...]:
        return (*super()._key(), self.stations, self.sections, self.function)

    @property
    def varies(self) -> bool:
        """True."""
        return True

    @property
    def parts(self) -> tuple[Section, ...]:
        """The sections of the stations."""
        return self.sections

    @property
    def mean_mass(self) -> float:
        """∫A_ρ over the fraction: exact between stations, by Gauss points for a function."""
        xi, w = gauss(5)
        total = 0.0
        for a, b in pairwise(self.stations):
            masses = [self.at(0.5 * (a + b + x * (b - a))).A_rho for x in xi.tolist()]
            total += 0.5 * (b - a) * float(w @ masses)
        return total

    @property
    def eccentric(self) -> bool:
        """True when the mass is off the axis somewhere."""
        return any(section.eccentric for section in self.sections)

    def mapped(self, change: Callable[[Section], Section]) -> Section:
        """``change`` of every section."""
        make = self.function
        after = None if make is None else lambda fraction: change(make(fraction))
        return _tapered(self.stations, tuple(change(s) for s in self.sections), after)

    def at(self, fraction: float) -> Section:
        """The section there; beyond the stations that of the nearest."""
        if self.function is not None:
            return _checked(self.function, fraction)
        return _between(self.stations, self.sections, fraction)

    def along(self, fractions: Array) -> AtStations:
        """The stiffness at some fractions."""
        return AtStations(np.array([self.at(f).stiffness for f in fractions.tolist()]))

    def offset(self, x1: float, x2: float) -> Any:
        """See :meth:`Section.offset`, at every station."""
        return self.mapped(lambda section: section.offset(x1, x2))

    def turned(self, angle: float) -> Any:
        """See :meth:`Section.turned`, at every station."""
        return self.mapped(lambda section: section.turned(angle))

    def damped(self, damping: Any) -> Any:
        """See :meth:`Section.damped`, at every station."""
        return self.mapped(lambda section: section.damped(damping))


@dataclass(frozen=True)
class AtStations:
    """Stiffness (stations, 6, 6) at the stress points of a rod."""

    stiffness: Array

    def forces(self, strain: Array) -> Array:
        """Section forces (…, stations, 6) from strains (…, stations, 6)."""
        return np.einsum("qij,...qj->...qi", self.stiffness, strain)

    def stored(self, strain: Array) -> Array:
        """Stored energy per unit length (…, stations) at strains (…, stations, 6)."""
        return 0.5 * np.einsum("...qi,...qi->...q", strain, self.forces(strain))


def taper(sections: Sequence[tuple[float, Section]] | Callable[[float], Section], *, stations: int = 21) -> Tapered:
    """A section that varies along a rod.

    Parameters
    ----------
    sections
        Pairs (fraction of the arclength, section), from 0 to 1, between which stiffness, damping and inertia are
        linear; or a function of the fraction that gives a section, which is asked at every stress point.
    stations
        Of a function: how many places show what it gives, for checks and pictures.

    Raises
    ------
    ModelError
        Stations are no rising fractions from 0 to 1, or a section has a law of its own.
    """
    if callable(sections):
        function = sections
        if isinstance(stations, bool) or stations < 2:
            raise ModelError(f"stations = {shown(stations)} are less than two", "give 2 or more")
        at = tuple(float(f) for f in np.linspace(0.0, 1.0, stations))
        return _tapered(at, tuple(_checked(function, f) for f in at), function)
    try:
        pairs = [(number(f, "fraction of a station"), s) for f, s in sections]
    except (TypeError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError("stations are not pairs of a fraction and a section", "give [(0, first), (1, last)]") from None
    at = tuple(f for f, _ in pairs)
    if len(at) < 2 or at[0] != 0.0 or at[-1] != 1.0 or np.any(np.diff(at) <= 0.0):
        raise ModelError(
            f"the stations {shown(at)} do not rise from 0 to 1", "give fractions of the arclength, 0 first and 1 last"
        )
    return _tapered(at, tuple(s for _, s in pairs), None)


def _tapered(
    stations: tuple[float, ...], sections: tuple[Section, ...], function: Callable[[float], Section] | None
) -> Tapered:
    for f, section in zip(stations, sections, strict=True):
        if not isinstance(section, Section) or isinstance(section, Tapered):  # pyright: ignore
            raise ModelError(f"{shown(section)} at station {f:g} is not a section", "use dx.Section")
        if section.law is not None:
            raise ModelError(f"the section at station {f:g} has a law", "sections that vary are linear")
    middle = _between(stations, sections, 0.5)
    said = dict.fromkeys(a for section in sections for a in section.assumptions)
    return Tapered(
        middle.stiffness, middle.A_rho, middle.I_rho, order="shear-axial", outline=middle.outline,
        damping=middle.damping, S_rho=middle.S_rho, assumptions=tuple(said), stations=stations, sections=sections,
        function=function,
    )  # fmt: skip


def _between(stations: Sequence[float], sections: Sequence[Section], fraction: float) -> Section:
    k = min(max(bisect_right(stations, fraction) - 1, 0), len(stations) - 2)
    a, b = sections[k], sections[k + 1]
    w = min(max((fraction - stations[k]) / (stations[k + 1] - stations[k]), 0.0), 1.0)
    if w == 0.0 or a == b:
        return a
    if w == 1.0:
        return b

    def mix(x: Any, y: Any) -> Any:
        return (1.0 - w) * x + w * y

    same = a.outline.shape == b.outline.shape
    return Section(
        mix(a.stiffness, b.stiffness), mix(a.A_rho, b.A_rho), mix(a.I_rho, b.I_rho), order="shear-axial",
        outline=mix(a.outline, b.outline) if same else (a if w < 0.5 else b).outline,
        damping=mix(a.damping, b.damping), S_rho=mix(a.S_rho, b.S_rho),
    )  # fmt: skip


def _checked(function: Callable[[float], Section], fraction: float) -> Section:
    try:
        given = cast("object", function(fraction))
    except Exception as error:  # whatever a user's function raises
        raise ModelError(
            f"the section as a function fails at fraction {fraction:g}: {error!r}", "return a section for 0 … 1"
        ) from error
    if not isinstance(given, Section):
        raise ModelError(f"the section as a function gives {shown(given)}", "return a dx.Section")
    return given
