"""Watches the stability of a path while it is walked: counts negative pivots, and finds where one changes its sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.bordered import dot
from directrix.hessian import Hessian, largest_entry, nearest_zero, negative_pivots
from directrix.newton import Newton

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

Array = NDArray[np.float64]

__all__ = ["Crossing", "Settled", "Watch"]

FOUND = 1e-10  # of the larger eigenvalue at the ends of the step
VANISHES = 1e-5  # of that: an eigenvalue as small as this at a crossing crosses there too
NOISE = 4e-16  # of the largest entry of the stiffness: below this an eigenvalue has no sign


class Settled(NamedTuple):
    """An equilibrium at some reach along a step: its state and load factor."""

    reach: float
    x: Array
    factor: float


class Crossing(NamedTuple):
    """Where eigenvalues of the stiffness vanish: the equilibrium found next to it, the load factor there, negative ones
    before, at and after it, the modes (multiplicity, n, 6)."""

    at: Settled
    factor: float
    before: int
    inside: int
    after: int
    modes: Array


class _Probe(NamedTuple):
    """An equilibrium and the one eigenvalue that is followed."""

    at: Settled
    value: float


class Watch:
    """``count`` is the number of negative pivots just behind the state that the walk has reached."""

    def __init__(self, newton: Newton, length: float) -> None:
        self.newton, self.length = newton, length
        self.hessian = Hessian(newton, length)
        self.count = 0

    def matrix(self, x: Array, factor: float) -> csc_matrix:
        """The stiffness at a state."""
        self.newton.loads(factor)
        self.newton.driver.place(factor, factor)
        return self.hessian.matrix(x)

    def pivots(self, x: Array, factor: float) -> int:
        """Negative pivots at a state."""
        return negative_pivots(self.matrix(x, factor))

    def singular(self, x: Array, factor: float) -> tuple[int, Array]:
        """At a state where one eigenvalue vanishes: negative ones beside it, and its mode (1, n, 6)."""
        matrix = self.matrix(x, factor)
        found = nearest_zero(matrix, 3)
        sizes = np.abs(found.values)
        k, gap = int(np.argmin(sizes)), 0.5 * float(np.sort(sizes)[min(1, len(sizes) - 1)])
        inside = negative_pivots(matrix, gap)
        return inside, self._unit(found.vectors[:, k])[None]

    def between(self, start: Settled, end: Settled, settle: Callable[[float], Settled], after: int) -> list[Crossing]:
        """Where eigenvalues change sign between two equilibria of one step, in the order of the path.

        ``settle`` gives the equilibrium at a reach, ``after`` are the negative pivots at the end. A pair that changes
        sign and changes back within the step is not seen.
        """
        found: list[Crossing] = []
        count, low = self.count, start
        while count != after and len(found) < abs(after - self.count):
            crossing = self._locate(low, end, settle, count, after)
            found.append(crossing)
            count, low = crossing.after, crossing.at
        self.count = after
        return found

    def _locate(
        self, low: Settled, high: Settled, settle: Callable[[float], Settled], count: int, after: int
    ) -> Crossing:
        """The first change of sign: of the lowest positive eigenvalue, or of the highest negative one."""
        number = count + 1 if after > count else count
        a, b = self._probe(low, number, count), self._probe(high, number, after)
        tried = [a, b]
        if a.value * b.value > 0.0:  # the start is a critical point itself, and its own eigenvalue is next to zero
            a, tried = _Probe(low, -a.value), [b]
        size = max(abs(a.value), abs(b.value))
        small = max(FOUND * size, NOISE * largest_entry(self.matrix(high.x, high.factor)))
        weight, best = a.value, min(tried, key=lambda p: abs(p.value))
        for _ in range(50):
            reach = b.at.reach - b.value * (b.at.reach - a.at.reach) / (b.value - weight)
            if not min(a.at.reach, b.at.reach) < reach < max(a.at.reach, b.at.reach):
                break
            try:
                probe = self._probe(settle(reach), number)
            except ArithmeticError:  # too near to the singular point to come to balance
                break
            tried.append(probe)
            best = min((best, probe), key=lambda p: abs(p.value))
            if abs(probe.value) <= small:
                break
            if probe.value * b.value < 0.0:
                a, weight = b, b.value
            else:  # an end that stays is given less weight (Anderson and Björck, 1973)
                ratio = 1.0 - probe.value / b.value
                weight *= ratio if ratio > 0.0 else 0.5
            b = probe
        return self._crossing(best, tried, count, after, size)

    def _probe(self, at: Settled, number: int, count: int | None = None) -> _Probe:
        """The eigenvalue that is ``number``-th from below."""
        matrix = self.matrix(at.x, at.factor)
        negative = negative_pivots(matrix) if count is None else count
        values = nearest_zero(matrix, abs(negative - number) + 3).values
        below, above = values[values < 0.0][::-1], values[values >= 0.0]
        wanted = below[negative - number :] if number <= negative else above[number - negative - 1 :]
        # pivots and eigenvalues disagree where there is nothing but rounding
        value = float(wanted[0]) if wanted.size else float(np.abs(values).min()) * (-1.0 if number <= negative else 1.0)
        return _Probe(at, value)

    def _crossing(self, best: _Probe, tried: list[_Probe], count: int, after: int, size: float) -> Crossing:
        matrix = self.matrix(best.at.x, best.at.factor)
        found = nearest_zero(matrix, abs(after - count) + 2)
        small = max(VANISHES * size, 3.0 * abs(best.value), NOISE * largest_entry(matrix))
        near = np.argsort(np.abs(found.values))[: abs(after - count)]
        vanish = near[np.abs(found.values[near]) <= small]
        vanish = near[:1] if vanish.size == 0 else vanish
        inside = min(count, count + len(vanish) if after > count else count - len(vanish))
        then = count + len(vanish) * (1 if after > count else -1)
        modes = np.array([self._unit(found.vectors[:, k]) for k in vanish])
        return Crossing(best.at, _at_zero(tried, best), count, inside, then, modes)

    def _unit(self, vector: Array) -> Array:
        """A mode (n, 6) of unit length, its largest component positive."""
        mode = self.hessian.increment(vector)
        size = mode * np.repeat([1.0, self.length], 3)
        largest = size.ravel()[np.argmax(np.abs(size))]
        return mode * np.sign(largest) / np.sqrt(dot(mode, mode, self.length))


def _at_zero(tried: list[_Probe], best: _Probe) -> float:
    """The load factor where the eigenvalue vanishes, from the three nearest probes (inverse interpolation)."""
    near = sorted(tried, key=lambda p: abs(p.value))[:3]
    if best.value == 0.0 or len({p.value for p in near}) < len(near):
        return best.at.factor
    total = 0.0
    for p in near:
        weight = 1.0
        for q in near:
            if q is not p:
                weight *= q.value / (q.value - p.value)
        total += weight * p.at.factor
    return total
