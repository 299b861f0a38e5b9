"""Whether a tangent is good enough for the next increments: what all compiled Newton iterations decide alike."""
# pyright: basic

from math import sqrt

from directrix.kernels.jit import inner

__all__ = ["finest_of", "judged"]

SETTLED = 1e-15  # error of an iterate, relative to the size of the model or in rad, that is left alone
ROUNDED = 2e-16  # what rounding leaves in an increment for every node in a row; they add up at random
REUSES = 4  # a tangent is kept when so many increments with it are expected to be enough


@inner
def finest_of(nodes):
    """Size of an increment that is round-off, for so many nodes in a row."""
    return max(SETTLED, ROUNDED * sqrt(nodes))


@inner
def judged(moved, turned, length, before, again, fine):
    """An increment against the one ``before``, made with an old tangent or not: its size; whether it is small, and so
    small that the next is round-off; whether the next ones may do with the tangent that there is."""
    size = max(moved / length, turned)
    # by how much the next increment shrinks if the tangent is kept: after a new one convergence is quadratic
    rate = size / before if before > 0.0 else 1.0
    if not again:
        rate *= rate
    small = moved <= 1e-9 * length and turned <= 1e-9
    settled = not again or size * rate <= fine
    return size, small, settled, rate < 0.1 and (small or size * rate ** (REUSES + 1) <= fine)
