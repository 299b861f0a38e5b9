"""Nodes on no rod, and joints, as pydantic sees them: a table for each kind, so that a key of another is refused."""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeVar

from pydantic import Discriminator, Field, Tag, model_validator

from directrix.schema.base import (
    ANGLE,
    FORCE,
    FORCE_PER_LENGTH,
    FORCE_PER_SPEED,
    LENGTH,
    MOMENT,
    MOMENT_PER_SPIN,
    Name,
    NotNegative,
    Place,
    Positive,
    Strict,
    Vector,
    refuse,
)
from directrix.schema.functions import Table, Time

__all__ = ["AnyJoint", "Driven", "Joint", "Node"]


class Node(Strict):
    """A node that is on no rod: bodies, links and joints attach to it."""

    name: Name
    at: Place
    """Where it is in the reference."""


class Joint(Strict):
    """A joint between two nodes, or a node and the ground."""

    name: Name | None = None
    """"joint1", "joint2", … unless given."""
    a: Name
    """First node: carries the axis."""
    b: Name | None = None
    """Second node; without it the joint is between ``a`` and the ground."""


class Rigid(Joint):
    """Nothing moves or turns between its nodes, near or far."""

    kind: Literal["rigid"]


class _Placed(Joint):
    at: Place | None = None
    """Where it is in the reference; at its second node unless given, at its only one when it is on the ground."""


class _Ball(_Placed):
    stiffness: Annotated[NotNegative, MOMENT] = 0.0
    """Moment per angle against any relative rotation."""
    damping: Annotated[NotNegative, MOMENT_PER_SPIN] = 0.0
    """Moment per relative spin."""


class Spherical(_Ball):
    """A ball joint."""

    kind: Literal["spherical"]


class Universal(_Ball):
    """A universal (Cardan) joint: two perpendicular axes stay so."""

    kind: Literal["universal"]
    axes: Annotated[tuple[Vector, Vector], Field(strict=False)]
    """The first turns with ``a``, the second with ``b``."""


class Planar(_Placed):
    """Moves in a plane and turns about its normal."""

    kind: Literal["planar"]
    normal: Vector
    """Turns with ``a``."""


def _number_or_table(value: object) -> str:
    return "table" if isinstance(value, dict | Table) else "number"


T = TypeVar("T")
InTime = Annotated[Annotated[T, Tag("number")] | Annotated[Table, Tag("table")], Discriminator(_number_or_table)]


class Driven(_Placed):
    """A joint with one coordinate that something may act on; zero in the reference, of b relative to a (of a relative
    to the ground)."""

    axis: Vector
    """Its direction; turns with ``a``."""
    stiffness: NotNegative = 0.0
    """Force or moment of a spring, per displacement or angle."""
    rest: float = 0.0
    """Coordinate where the spring is at rest."""
    damping: NotNegative = 0.0
    """Force or moment per rate of the coordinate."""
    prescribed: InTime[float] | None = None
    """The coordinate: a number (times ``time``), or a table ``{ t = […], value = […] }``."""
    drive: InTime[float] | None = None
    """Force or moment on the coordinate: a number (times ``time``), or a table."""
    time: Time | None = None
    """Factor on ``prescribed`` or ``drive`` given as a number."""
    stops: Annotated[tuple[float, float], Field(strict=False)] | None = None
    """Lower and upper end of its way, beyond which springs of ``stop_stiffness`` act."""
    stop_stiffness: Positive | None = None
    """Of the springs at both stops."""
    stop_width: Positive | None = None
    """The change is smooth over it; a thousandth of the way between the stops unless given."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.time is not None and not any(isinstance(v, float) for v in (self.prescribed, self.drive)):
            raise refuse(
                "there is no number that time could multiply",
                "give prescribed or drive as a number, or leave time out: a table has its own",
                "time",
            )
        if self.stops is not None and self.stop_stiffness is None:
            raise refuse("stops need a stiffness", "add stop_stiffness = …", "stops")
        return self


class Hinge(Driven):
    """Turns about an axis; its coordinate is the angle in radians, any number of turns."""

    kind: Literal["hinge"]
    stiffness: Annotated[NotNegative, MOMENT] = 0.0
    """Moment of a spring, per angle."""
    rest: Annotated[float, ANGLE] = 0.0
    """Angle where the spring is at rest."""
    damping: Annotated[NotNegative, MOMENT_PER_SPIN] = 0.0
    """Moment per rate of the angle."""
    prescribed: InTime[Annotated[float, ANGLE]] | None = None
    """The angle: a number (times ``time``), or a table ``{ t = […], value = […] }``."""
    drive: InTime[Annotated[float, MOMENT]] | None = None
    """Moment on the angle: a number (times ``time``), or a table."""
    stops: Annotated[tuple[Annotated[float, ANGLE], Annotated[float, ANGLE]], Field(strict=False)] | None = None
    """Lower and upper end of its way, beyond which springs of ``stop_stiffness`` act."""
    stop_stiffness: Annotated[Positive, MOMENT] | None = None
    """Of the springs at both stops."""
    stop_width: Annotated[Positive, ANGLE] | None = None
    """The change is smooth over it; a thousandth of the way between the stops unless given."""


class _Sliding(Driven):
    stiffness: Annotated[NotNegative, FORCE_PER_LENGTH] = 0.0
    """Force of a spring, per displacement."""
    rest: Annotated[float, LENGTH] = 0.0
    """Displacement where the spring is at rest."""
    damping: Annotated[NotNegative, FORCE_PER_SPEED] = 0.0
    """Force per rate of the displacement."""
    prescribed: InTime[Annotated[float, LENGTH]] | None = None
    """The displacement: a number (times ``time``), or a table ``{ t = […], value = […] }``."""
    drive: InTime[Annotated[float, FORCE]] | None = None
    """Force on the displacement: a number (times ``time``), or a table."""
    stops: Annotated[tuple[Annotated[float, LENGTH], Annotated[float, LENGTH]], Field(strict=False)] | None = None
    """Lower and upper end of its way, beyond which springs of ``stop_stiffness`` act."""
    stop_stiffness: Annotated[Positive, FORCE_PER_LENGTH] | None = None
    """Of the springs at both stops."""
    stop_width: Annotated[Positive, LENGTH] | None = None
    """The change is smooth over it; a thousandth of the way between the stops unless given."""


class Cylindrical(_Sliding):
    """Slides along an axis and turns about it; its coordinate is the displacement."""

    kind: Literal["cylindrical"]


class Slider(_Sliding):
    """Slides along an axis and does not turn; its coordinate is the displacement."""

    kind: Literal["slider"]


AnyJoint = Annotated[Hinge | Spherical | Universal | Cylindrical | Slider | Planar | Rigid, Field(discriminator="kind")]
