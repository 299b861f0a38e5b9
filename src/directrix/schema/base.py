"""What every table of a case file shares: strictness, and the kinds of values."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

__all__ = ["Name", "NotNegative", "Numbers", "Positive", "Strict", "Tolerance", "Vector", "Vectors", "refuse"]

Name = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^\S(.*\S)?$")]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Tolerance = Annotated[float, Field(gt=0.0, lt=1.0)]
# the arrays of a file arrive as lists, which strict tuples would refuse
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Numbers = Annotated[tuple[float, ...], Field(strict=False, min_length=2)]
Vectors = Annotated[tuple[Vector, ...], Field(strict=False, min_length=2)]


class Strict(BaseModel):
    """A table: unknown keys, texts for numbers, truth values for numbers, NaN and inf are refused."""

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


def refuse(sentence: str, fix: str, *at: str | int) -> PydanticCustomError:
    """The error of a validator; ``at`` is the key below its table that is to blame."""
    # braces in the sentence would be taken for placeholders
    return PydanticCustomError("case", "{what}", {"what": sentence, "fix": fix, "at": at})
