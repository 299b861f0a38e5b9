"""What the page shows, in the paper's order."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from directrix.paper import bend, cantilever, flight, frame, objectivity, paths
from directrix.paper.record import Figure, Table

__all__ = ["EXAMPLES", "Example", "Item", "compute"]

Item = Table | Figure


@dataclass(frozen=True)
class Example:
    """A section of the page: what the problem is, and the functions that compute its tables and figures."""

    title: str
    text: str
    items: tuple[Callable[[], Item], ...]
    quick: tuple[Callable[[], Item], ...] = ()


EXAMPLES = (
    Example(
        "Example 1. Objectivity",
        "A straight rod of length 3 is clamped at A; its end B is displaced by ½(1/√2, −1/√2, 0) without "
        "rotation. Then both ends are "
        "turned together about (1, 1, 1) in six steps of 10°. Seen from the turning frame nothing happens.",
        (objectivity.figure_2,),
    ),
    Example(
        "Example 2. Path independence",
        "One linear element of unit length. Its ends are turned to (1, −0.5, 0.25) and (−0.4, 0.7, 0.1), B is "
        "free to move. Path I goes there "
        "in two equal steps; the first step of path II goes 0.775 of the way at A and 0.4 at B.",
        (paths.table_1,),
    ),
    Example(
        "Example 3. Buckling of a hinged frame",
        "Two members of length 120 meet at a rigid corner and are hinged at their other ends; a dead load pushes the "
        "beam down, 24 from the corner.",
        (frame.figure_3, frame.figure_4),
    ),
    Example(
        "Example 4. 45° bend",
        "An eighth of a circle of radius 100 with unit square section, clamped at one end and loaded at the "
        "other by a dead force normal to its "
        "plane.",
        (bend.table_2, bend.convergence),
    ),
    Example(
        "Example 5. Free flight of a three-rod frame",
        "Three rods of length 3 at right angles, five linear elements each, three nodes of which get a velocity. "
        "Nothing acts on it.",
        (flight.figure_7, flight.figure_8, flight.figure_9, flight.figure_9_rivals),
        (
            flight.figure_7,
            lambda: flight.figure_8(6),
            lambda: flight.figure_9(6.0),
            lambda: flight.figure_9_rivals(6.0),
        ),
    ),
    Example(
        "Example 6. Cantilever after a pulse",
        "A cantilever of length 10, ten linear elements, is pushed and twisted at its tip until t = 6 and then "
        "left alone; Δt = 1.",
        (cantilever.table_3,),
    ),
)


def compute(quick: bool = False) -> Iterator[tuple[Example, tuple[Item, ...]]]:
    """Every example with its tables and figures; ``quick`` shortens the long motions."""
    for example in EXAMPLES:
        yield example, tuple(item() for item in (quick and example.quick) or example.items)
