"""Whether a tangent is good enough for the next increments: what all compiled Newton iterations decide alike."""
# pyright: basic

from math import sqrt

from directrix.kernels.jit import inner

__all__ = ["blurred", "expected", "finest_of", "judged", "noted"]

SETTLED = 1e-15  # error of an iterate, relative to the size of the model or in rad, that is left alone
ROUNDED = 2e-16  # what rounding leaves in an increment for every node in a row; they add up at random
SLOW = 0.1  # increments that shrink by less a time are too many
# places of what is noted: sizes of the last and of the first increment of a step, how far the state is from where the
# tangent was made, by how much first increments shrink through a tangent per distance to where it was made; the largest
# imbalance of the last iteration over what is allowed
BEFORE, FIRST, GONE, BEND, LEFT = range(5)
STALLED = 0.5  # an imbalance that stays above this part of the one before is round-off
BLUR = 1e-9  # of the forces: what may be left in them by round-off that an old tangent turns the wrong way
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
    return size, small, settled, rate < SLOW and (small or size * rate ** (REUSES + 1) <= fine)


@inner
def expected(moved, turned, length, notes, again):
    """The size of the increment before; for the first of a step, through the tangent of the step before, one that it
    would have shrunk from as those of the last steps did, or 0."""
    size = max(moved / length, turned)
    rate = notes[BEND] * (notes[GONE] + size)
    if again and notes[BEFORE] == 0.0 and rate > 0.0:
        return size / rate
    return notes[BEFORE]


@inner
def noted(size, again, count, notes):
    """Take down the ``count``-th increment of a step. Later ones say little about the next step: they are other
    motions, of higher frequency, that converge more slowly."""
    if count == 1:
        notes[FIRST] = size
    if count == 2 and notes[BEFORE] > 0.0:
        notes[BEND] = size / (notes[BEFORE] * notes[GONE])
    notes[BEFORE] = size
    notes[GONE] = size + (notes[GONE] if again else 0.0)


@inner
def blurred(floor, scale, notes):
    """Whether a tangent is too old for the last digits. What rounding leaves in positions, times the stiffness, is in
    balance within every element; an old tangent leaves it turned by as far as the state has gone, and the energy sees
    that. ``floor`` and ``scale``: round-off in forces and moments, and how large they are."""
    return notes[GONE] * floor[0] > BLUR * scale[0] or notes[GONE] * floor[1] > BLUR * scale[1]
