"""Quantities with units in a case file: ``"210 GPa"``, and the set of units that plain numbers are in.

A case is computed in one set of units, SI unless ``[units]`` says another. Texts are converted to it; plain numbers are
in it already. pint knows the units; it is an extra.
"""
# pyright: reportMissingImports=false, reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.util import find_spec
from math import isfinite, pi
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

__all__ = ["SI", "Dim", "UnitSet", "meant", "quantity"]

Exponents = tuple[int, int, int]
COMMON = (
    "m", "mm", "cm", "um", "km", "in", "ft", "N", "kN", "MN", "mN", "lbf", "Pa", "kPa", "MPa", "GPa", "psi", "kg", "g",
    "tonne", "lb", "s", "ms", "us", "min", "h", "Hz", "rad", "deg", "rpm", "kg/m^3", "g/cm^3", "N/m", "N*m", "m/s",
)  # fmt: skip
_QUANTITY = re.compile(r"\s*([+-]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-zµμΩ°%].*?)\s*", re.DOTALL)
_POWER_OF_TEN = re.compile(r"[+-]?[\d_.,]+[eE][+-]?\d+")
_FACTOR = re.compile(r"(\s*[*/·⋅]\s*|\s+|)([A-Za-zµμΩ°%]+)(?:(?:\^|\*\*)?(-?\d)(?!\d)|([²³⁴]))?")
_UP = {"²": 2, "³": 3, "⁴": 4}
_ANGLES = {"deg": pi / 180.0, "degree": pi / 180.0, "degrees": pi / 180.0, "°": pi / 180.0, "rad": 1.0, "turn": 2 * pi}


def _refuse(code: str, what: str, fix: str) -> PydanticCustomError:
    return PydanticCustomError("case", "{what}", {"what": what, "fix": fix, "at": (), "code": code})


@dataclass(frozen=True)
class UnitSet:
    """What plain numbers are in: sizes of the units of mass, length and time in kg, m and s, and their names."""

    mass: float = 1.0
    length: float = 1.0
    time: float = 1.0
    names: tuple[tuple[str, str], ...] = ()

    def size(self, powers: Exponents) -> float:
        """SI units in one unit of the set; powers of length, mass, time."""
        return self.length ** powers[0] * self.mass ** powers[1] * self.time ** powers[2]

    def __str__(self) -> str:
        if not self.names:
            return "SI (m, kg, s, N, Pa), or whatever consistent set the plain numbers are in"
        given = ", ".join(f"{k} {v}" for k, v in self.names)
        return f"{given}; a unit of mass is {self.mass:.6g} kg, of stress {self.size((-1, 1, -2)):.6g} Pa"


def quantity(text: str) -> tuple[float, str] | None:
    """Number and unit of a text like "210 GPa"; None for any other text."""
    found = _QUANTITY.fullmatch(text) if len(text) <= 80 else None
    if found is None or _POWER_OF_TEN.fullmatch(text.strip()):
        return None
    try:
        return float(found[1]), found[2]
    except ValueError:
        return None


@cache
def _registry() -> Any:
    """pint's registry; None when pint is missing."""
    if find_spec("pint") is None:
        return None
    import pint

    return pint.UnitRegistry()


@cache
def _named(name: str) -> tuple[float, Exponents]:
    """One named unit: its size in SI and its powers of length, mass, time. Raises a pydantic error."""
    if name in _ANGLES:
        return _ANGLES[name], (0, 0, 0)
    registry = _registry()
    if registry is None:
        raise _refuse(
            "DX301",
            f"the unit {name!r} needs pint, which is missing",
            'pip install "directrix[units]", or a plain number',
        )
    try:
        base = registry.Quantity(1.0, registry.Unit(name)).to_base_units()
        powers = {str(k): v for k, v in base.dimensionality.items()}
        size = float(base.magnitude)
    except Exception:  # pint raises many kinds for what it cannot read
        near = get_close_matches(name, COMMON, 1, 0.4)
        fix = f"did you mean {near[0]!r}? " if near else ""
        raise _refuse("DX302", f"there is no unit {name!r}", f"{fix}units are written as in 5 mm, 210 GPa") from None
    out = [powers.pop(k, 0) for k in ("[length]", "[mass]", "[time]")]
    if powers or any(int(p) != p for p in out):
        raise _refuse(
            "DX303", f"the unit {name!r} is not one of mechanics", "lengths, masses, times and what they make"
        )
    return size, (int(out[0]), int(out[1]), int(out[2]))


def unit(text: str) -> tuple[float, Exponents]:
    """A unit with products and powers, e.g. kg/m^3: its size in SI and its powers. Raises a pydantic error."""
    text = text.strip()
    at, size, powers = 0, 1.0, [0, 0, 0]
    while at < len(text):
        found = _FACTOR.match(text, at)
        if found is None or (found[1] == "") != (at == 0):
            raise _refuse(
                "DX302", f"the unit {text!r} cannot be read", "write units as in N/m^2, kg*m^2, kg/m/s: no parentheses"
            )
        one, own = _named(found[2])
        power = int(found[3] or _UP.get(found[4] or "", 1)) * (-1 if "/" in found[1] else 1)
        try:
            size *= one**power
        except OverflowError:
            size = float("inf")
        powers = [p + power * q for p, q in zip(powers, own, strict=True)]
        at = found.end()
    if not (isfinite(size) and size > 0.0):
        raise _refuse("DX302", f"the unit {text!r} is out of reach", "take one of an ordinary size")
    return size, (powers[0], powers[1], powers[2])


SI = UnitSet()


@dataclass(frozen=True)
class Dim:
    """In the annotation of a number: what kind of quantity it is, so that a text with a unit may stand for it.

    ``powers`` of length, mass and time; ``degrees`` for the one key whose plain number is in degrees.
    """

    what: str
    powers: Exponents
    example: str
    degrees: bool = False

    def number(self, value: object, info: core_schema.ValidationInfo) -> object:
        """The number that a text with a unit stands for, in the units of the file; anything else as it is."""
        parts = quantity(value) if isinstance(value, str) else None
        if parts is None:
            return value
        if self.powers == (0, 0, 0) and self.what == "plain":
            raise _refuse("DX305", f'is the text "{value}", but a plain number belongs here', "leave the unit out")
        size, powers = unit(parts[1])
        if powers != self.powers:
            raise _refuse(
                "DX303",
                f'is the text "{value}", {_spoken(powers)}, but must be {self.what}',
                f'give {self.what}, e.g. "{self.example}"',
            )
        units: UnitSet = (info.context or {}).get("units") or SI
        if self.degrees:
            return parts[0] * size * 180.0 / pi
        return parts[0] * size / units.size(self.powers)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_before_validator_function(self.number, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        inner = handler(schema)
        text = {"type": "string", "pattern": r"^\s*[+-]?[\d.].*[A-Za-zµ°%]", "description": f'e.g. "{self.example}"'}
        return {"anyOf": [inner, text]}


KINDS: dict[Exponents, str] = {
    (0, 0, 0): "a plain number or an angle", (1, 0, 0): "a length", (2, 0, 0): "an area", (4, 0, 0): "a length⁴",
    (0, 1, 0): "a mass", (0, 0, 1): "a time", (1, 0, -1): "a speed", (1, 0, -2): "an acceleration",
    (1, 1, -2): "a force", (2, 1, -2): "a moment or an energy", (-1, 1, -2): "a stress", (-3, 1, 0): "a density",
    (0, 1, -2): "a force per length", (0, 0, -1): "a frequency or a spin", (-1, 1, 0): "a mass per length",
}  # fmt: skip


def _spoken(powers: Exponents) -> str:
    made = " ".join(f"{k}^{p}" for k, p in zip(("m", "kg", "s"), powers, strict=True) if p)
    return KINDS.get(powers, f"in {made}")


def meant(text: str) -> str:
    """The number that a text in a wrong form is likely meant to be, as a case file writes it; empty when none is."""
    t = text.strip().replace("\u2212", "-").replace("\u00a0", "").replace("'", "")
    if len(t) > 60:
        return ""
    for pattern, read in _FORMS:
        found = pattern.fullmatch(t)
        if found is not None:
            try:
                value = read(found)
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            return f"{value:.10g}" if isfinite(value) else ""
    return ""


def _plain(text: str) -> float:
    """A number with a decimal comma or point, and marks between thousands."""
    t = text.replace("_", "").replace(" ", "")
    if "," in t and "." in t:
        thousands = "," if t.rindex(".") > t.rindex(",") else "."
        t = t.replace(thousands, "")
    elif t.count(",") > 1:
        t = t.replace(",", "")
    return float(t.replace(",", "."))


_DIGITS = r"[+-]?(?:\d[\d_ .,]*|[.,]\d+)"
_TEN = rf"({_DIGITS})\s*[*x×·]\s*10(?:\^|\*\*)\s*\(?([+-]?\d+)\)?"
_FORMS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], float]], ...] = (
    (re.compile(rf"({_DIGITS})(?:[eE]([+-]?\d+)(?:\.0*)?)?"), lambda m: _plain(m[1]) * 10.0 ** int(m[2] or 0)),
    (re.compile(_TEN), lambda m: _plain(m[1]) * 10.0 ** int(m[2])),
    (re.compile(rf"({_DIGITS})\s*/\s*({_DIGITS})"), lambda m: _plain(m[1]) / _plain(m[2])),
    (
        re.compile(rf"({_DIGITS})?\s*\*?\s*(?:pi|π)(?:\s*/\s*({_DIGITS}))?"),
        lambda m: _plain(m[1] or "1") * pi / _plain(m[2] or "1"),
    ),
    (re.compile(rf"({_DIGITS})\s*(?:deg|degrees?|°)"), lambda m: _plain(m[1]) * pi / 180.0),
)
