"""What every table of a case file shares: strictness, and the kinds of values."""

from __future__ import annotations

import ast
import inspect
import textwrap
from itertools import pairwise
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

from directrix.schema.units import Dim

__all__ = [
    "ACCELERATION",
    "ANGLE",
    "AREA",
    "BENDING",
    "CURVATURE",
    "DENSITY",
    "FORCE",
    "FORCE_PER_LENGTH",
    "FREQUENCY",
    "INERTIA",
    "INERTIA_PER_LENGTH",
    "LENGTH",
    "MASS",
    "MASS_PER_LENGTH",
    "MOMENT",
    "SECOND_MOMENT",
    "SPEED",
    "SPIN",
    "STRESS",
    "TIME",
    "Name",
    "NotNegative",
    "Numbers",
    "Place",
    "Positive",
    "Speed",
    "Spin",
    "Strict",
    "Times",
    "Tolerance",
    "Vector",
    "Vectors",
    "refuse",
]  # fmt: skip

LENGTH = Dim("a length", (1, 0, 0), "5 mm")
AREA = Dim("an area", (2, 0, 0), "200 mm^2")
SECOND_MOMENT = Dim("a second moment of area (length⁴)", (4, 0, 0), "12 cm^4")
ANGLE = Dim("an angle", (0, 0, 0), "30 deg")
DEGREES = Dim("an angle", (0, 0, 0), "30 deg", degrees=True)
TIME = Dim("a time", (0, 0, 1), "10 ms")
FREQUENCY = Dim("a frequency", (0, 0, -1), "50 Hz")
MASS = Dim("a mass", (0, 1, 0), "3 kg")
INERTIA = Dim("a moment of inertia", (2, 1, 0), "0.1 kg*m^2")
MASS_PER_LENGTH = Dim("a mass per length", (-1, 1, 0), "2 kg/m")
INERTIA_PER_LENGTH = Dim("a rotary inertia per length", (1, 1, 0), "1e-4 kg*m")
DENSITY = Dim("a density", (-3, 1, 0), "7850 kg/m^3")
STRESS = Dim("a stress", (-1, 1, -2), "210 GPa")
FORCE = Dim("a force", (1, 1, -2), "2 kN")
MOMENT = Dim("a moment", (2, 1, -2), "3 N*m")
BENDING = Dim("a bending stiffness", (3, 1, -2), "12 N*m^2")
FORCE_PER_LENGTH = Dim("a force per length", (0, 1, -2), "2 kN/m")
FORCE_PER_AREA_LENGTH = Dim("a force per length and penetration", (-1, 1, -2), "1e6 N/m^2")
FORCE_PER_SPEED = Dim("a force per speed", (0, 1, -1), "30 N*s/m")
MOMENT_PER_SPIN = Dim("a moment per spin", (2, 1, -1), "0.3 N*m*s")
DRAG = Dim("a force per length and speed²", (-2, 1, 0), "5 kg/m^2")
SPEED = Dim("a speed", (1, 0, -1), "3 m/s")
SPIN = Dim("an angular velocity", (0, 0, -1), "20 rpm")
ACCELERATION = Dim("an acceleration", (1, 0, -2), "9.81 m/s^2")
CURVATURE = Dim("a curvature", (-1, 0, 0), "2 rad/m")

Name = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^\S(.*\S)?$")]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Tolerance = Annotated[float, Field(gt=0.0, lt=1.0)]
# the arrays of a file arrive as lists, which strict tuples would refuse
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Numbers = Annotated[tuple[float, ...], Field(strict=False, min_length=2)]
_L = Annotated[float, LENGTH]
_V = Annotated[float, SPEED]
_W = Annotated[float, SPIN]
Place = Annotated[tuple[_L, _L, _L], Field(strict=False)]
Speed = Annotated[tuple[_V, _V, _V], Field(strict=False)]
Spin = Annotated[tuple[_W, _W, _W], Field(strict=False)]
Times = Annotated[tuple[Annotated[float, TIME], ...], Field(strict=False, min_length=2)]
Vectors = Annotated[tuple[Vector, ...], Field(strict=False, min_length=2)]
Places = Annotated[tuple[Place, ...], Field(strict=False, min_length=2)]


class Strict(BaseModel):
    """A table: unknown keys, texts for numbers, truth values for numbers, NaN and inf are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False, defer_build=True)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """With what stands below the attributes: read here, as only the schema needs it and reading takes its time."""
        schema = handler(core)
        properties = handler.resolve_ref_schema(schema).get("properties", {})
        below = _below_attributes(cls)
        for name, field in cls.model_fields.items():
            if name in below:
                properties[field.alias or name].setdefault("description", below[name])
        return schema


def _below_attributes(table: type[BaseModel]) -> dict[str, str]:
    """The text below each attribute of a class, and of those that it comes from."""
    found: dict[str, str] = {}
    for one in reversed(table.__mro__):
        if one is BaseModel or not issubclass(one, BaseModel):
            continue
        (body,) = ast.parse(textwrap.dedent(inspect.getsource(one))).body
        assert isinstance(body, ast.ClassDef)
        for line, below in pairwise(body.body):
            match line, below:
                case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                    found[name] = inspect.cleandoc(text)
                case _:
                    pass
    return found


def refuse(sentence: str, fix: str, *at: str | int, code: str = "DX217") -> PydanticCustomError:
    """The error of a validator; ``at`` is the key below its table that is to blame."""
    # braces in the sentence would be taken for placeholders
    return PydanticCustomError("case", "{what}", {"what": sentence, "fix": fix, "at": at, "code": code})
