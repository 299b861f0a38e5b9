"""Crisfield & Jelenić (1999): local rotation vectors, relative to a triad of the element, are interpolated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from directrix.formulations import rotational as rot
from directrix.formulations.layout import Coordinates, Layout, Scalar, Step, Vector, points
from directrix.formulations.simo_vu_quoc import statics, strains
from directrix.formulations.so3 import Columns, combine, exp, log, scale, spin_rate, times, to_body, transposed

__all__ = ["CrisfieldJelenic", "CrisfieldJelenicStatics"]


@dataclass(frozen=True)
class CrisfieldJelenic:
    """The formulation of Crisfield & Jelenić (1999), for comparison: objective and path independent; statics.

    With Λ_r a triad of the element (two nodes: midway between theirs; three: the middle one's), the local vectors
    log(Λ_rᵀΛ_a) are interpolated. The spin is interpolated by the shape functions, as in the original, so the tangent
    is not symmetric off equilibrium. Elements of order 1 and 2.
    """


@dataclass(frozen=True)
class CrisfieldJelenicStatics:
    """Its element in statics (an :class:`Element`)."""

    sampled = False

    def rows(self, layout: Layout) -> int:
        """No history."""
        return 0

    def reference(self, layout: Layout, q: Coordinates, inverse_j: Sequence[Scalar]) -> list[list[Scalar]]:
        """Strains of the reference."""
        out: list[list[Scalar]] = []
        sections = _sections(layout, [node[1:] for node in q], inverse_j, None)
        for (_, _, dn), j, section in zip(points(layout.nn, layout.points), inverse_j, sections, strict=True):
            tangent = scale(j, rot.slope([node[0] for node in q], dn))
            out.append([*to_body(section.frame, tangent), *section.curvature])
        return out

    def step(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar], g: Sequence[Scalar]) -> Step:
        """See :class:`Element`."""
        parts, at = layout.split(p), rot.nodes(layout, x)
        frames = [rot.frame(n.R, parts[0][9 * a : 9 * a + 9]) for a, n in enumerate(at)]
        out = statics(layout, parts, at, _sections(layout, frames, parts[2], parts[3]))
        return Step(out, [(n.r,) for n in at], frames)

    def audit(self, layout: Layout, x: Sequence[Scalar], p: Sequence[Scalar]) -> list[Scalar]:
        """See :class:`Element`."""
        parts, at = layout.split(p), rot.nodes(layout, x)
        frames = [rot.frame(n.R, parts[0][9 * a : 9 * a + 9]) for a, n in enumerate(at)]
        return rot.books(layout, at, p, strains(layout, parts, at, _sections(layout, frames, parts[2], parts[3])))


def _sections(
    layout: Layout, frames: Sequence[Columns], inverse_j: Sequence[Scalar], e0: Sequence[Scalar] | None
) -> list[rot.Section]:
    """Frames at the stress points, and curvatures minus the reference ones in ``e0``."""
    if layout.nn == 2:
        half = scale(0.5, log(times(transposed(frames[0]), frames[1])))
        triad, local = times(frames[0], exp(half)), [scale(-1.0, half), half]
    else:
        triad = frames[1]
        local = [log(times(transposed(triad), f)) if a != 1 else (0.0, 0.0, 0.0) for a, f in enumerate(frames)]
    out: list[rot.Section] = []
    for k, ((_, n, dn), j) in enumerate(zip(points(layout.nn, layout.points), inverse_j, strict=True)):
        psi = combine(n, local)
        curvature: Vector = spin_rate(psi, scale(j, combine(dn, local)), body=True)
        if e0 is not None:
            curvature = tuple(a - b for a, b in zip(curvature, e0[6 * k + 3 : 6 * k + 6], strict=True))
        out.append(rot.Section(times(triad, exp(psi)), curvature))
    return out
