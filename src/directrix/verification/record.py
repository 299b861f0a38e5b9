"""A row of the suite: a number with its source beside the number that was computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np

__all__ = ["Case", "Check", "Cost", "Provenance", "Values", "rotation_angle"]

Provenance = Literal["A", "C", "C-FE", "S", "F", "D", "M"]
Cost = Literal["quick", "long"]
Values = tuple[float, ...]


@dataclass(frozen=True)
class Check:
    """One comparison.

    Attributes
    ----------
    case : what is compared
    source : where the expected numbers are from, or the law that asks for them
    provenance : how they came here. A closed form or a law; C computed from the exact equations by other means;
        C-FE computed with the same discretisation by an independent program; S printed in the source; F another
        program's; D digitised from a figure; M from memory
    expected, got : the numbers, component by component
    tolerance : of the largest difference over ``scale``; None shows the row without judging it
    scale : what differences are relative to; the largest expected component by default
    """

    case: str
    source: str
    provenance: Provenance
    expected: Values
    got: Values
    tolerance: float | None
    scale: float

    def __post_init__(self) -> None:
        if self.provenance == "M" and self.tolerance is not None:
            raise ValueError(f"{self.case}: a number from memory is no measure of anything")

    @classmethod
    def of(
        cls, case: str, source: str, provenance: Provenance, expected: Any, got: Any, tolerance: float | None = None,
        *, scale: float | None = None,
    ) -> Self:  # fmt: skip
        """From anything that is an array of numbers; both must have the same size."""
        a, b = (tuple(float(v) for v in np.ravel(x)) for x in (expected, got))
        if len(a) != len(b):
            raise ValueError(f"{case}: {len(a)} numbers expected, {len(b)} computed")
        return cls(case, source, provenance, a, b, tolerance, scale or max(map(abs, a), default=0.0) or 1.0)

    @classmethod
    def printed(
        cls, case: str, source: str, provenance: Provenance, expected: Any, got: Any, decimals: int, *,
        ulps: float = 0.5,
    ) -> Self:  # fmt: skip
        """To the last printed decimal: half a unit of it if it was rounded, a whole one (``ulps=1``) if cut off."""
        row = cls.of(case, source, provenance, expected, got)
        return replace(row, tolerance=1.02 * ulps * 10.0**-decimals / row.scale)

    @classmethod
    def law(cls, case: str, law: str, deviation: float, tolerance: float) -> Self:
        """A relative deviation that should be nothing."""
        return cls.of(case, law, "A", 0.0, deviation, tolerance, scale=1.0)

    @classmethod
    def control(cls, case: str, law: str, seen: bool) -> Self:
        """That something does happen, which shows that a law is no empty one: 1 if it was seen."""
        return cls.of(f"{case} (control)", law, "A", 1.0, float(seen), 0.0)

    @property
    def error(self) -> float:
        """Largest difference, relative to ``scale``; infinite where nothing finite was computed."""
        gaps = [abs(a - b) for a, b in zip(self.expected, self.got, strict=True)]
        return max(gaps, default=0.0) / self.scale if all(map(math.isfinite, gaps)) else math.inf

    @property
    def digits(self) -> float:
        """Decimal digits that agree, 0 … 16."""
        return min(16.0, max(0.0, -math.log10(max(self.error, 1e-16))))

    @property
    def judged(self) -> bool:
        """Whether the row can fail."""
        return self.tolerance is not None

    @property
    def passed(self) -> bool:
        """True within the tolerance, and for what is not judged."""
        return self.tolerance is None or self.error <= self.tolerance


@dataclass(frozen=True)
class Case:
    """Rows that belong together: a problem of the suite, its section there, and whether it takes seconds or minutes."""

    name: str
    section: str
    title: str
    run: Callable[[], Iterable[Check]]
    cost: Cost = "quick"


def rotation_angle(R: np.ndarray[Any, Any]) -> float:
    """Turn about z of a section whose axis was x (3, 3), in (−π, π]."""
    return float(np.arctan2(R[1, 0], R[0, 0]))
