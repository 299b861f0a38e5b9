"""From what pydantic found to messages with file, line, column, key and a fix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path as FilePath
from typing import Any, cast, get_args

from pydantic import BaseModel

from directrix.errors import InputError
from directrix.schema.places import Path, Spot
from directrix.schema.units import meant, quantity

__all__ = ["Source", "explain", "together"]

LOOKED_AT = 200  # mistakes of one file


@dataclass(frozen=True)
class Source:
    """A case file that was read: its name for messages, its data, and the places of its keys."""

    name: str
    data: Mapping[str, Any]
    spots: Mapping[Path, Spot]
    folder: FilePath = FilePath()
    """Where files that it names are looked for."""

    def where(self, loc: Sequence[str | int] = (), missing: bool = False) -> str:
        """``file.toml:12:1: rod[left].elements`` for a path.

        Parts that the file does not have are passed over, except the last one of a ``missing`` key, which is
        shown with the place of the table that lacks it.
        """
        path: Path = ()
        shown = ""
        value: Any = self.data
        for part in loc:
            if (*path, part) in self.spots:
                path = (*path, part)
                value = value[part]
                shown += _label(part, value) if isinstance(part, int) else f".{part}"
        if missing and isinstance(loc[-1], str):
            shown += f".{loc[-1]}"
        line, column = self.spots.get(path, Spot(1, 1))
        return f"{self.name}:{line}:{column}" + (f": {shown.lstrip('.')}" if shown else "")


def _label(index: int, item: object) -> str:
    if isinstance(item, dict):
        table = cast("dict[str, Any]", item)
        for key in ("name", "node", "rod"):
            if isinstance(table.get(key), str):
                return f"[{table[key]}]"
        return f"[#{index + 1}]"
    return f"[{index}]"


def explain(errors: Sequence[Mapping[str, Any]], source: Source, root: type[BaseModel]) -> InputError:
    """One error with all that pydantic reported, in the order of the file."""
    # pydantic counts the entries of a list that are good; one that has enough was reported already
    real = [e for e in errors if e["type"] != "too_short" or len(e["input"]) < e["ctx"]["min_length"]]
    real = real[:LOOKED_AT]
    # a misspelt key is the likely cause of the missing one beside it
    meant_keys = {
        (*e["loc"][:-1], near)
        for e in real
        if e["type"] == "extra_forbidden"
        for near in get_close_matches(str(e["loc"][-1]), _keys(root, e["loc"][:-1]), 1, 0.5)
    }
    real = [e for e in real if e["type"] != "missing" or e["loc"] not in meant_keys]
    order = sorted(real, key=lambda e: (e["type"] != "extra_forbidden", e["type"] == "missing"))
    found: dict[tuple[str, str], InputError] = {}
    for e in order:
        code, what, fix = _sentence(e, root)
        where = source.where((*e["loc"], *_below(e)), e["type"] == "missing")
        found.setdefault((where, what), InputError(what, fix, where, code))
    return together(list(found.values()))


def together(errors: Sequence[InputError]) -> InputError:
    """One error for several."""
    flat = [one for error in errors for one in error.mistakes]
    first, *rest = flat
    alone = tuple(InputError(e.what, e.fix, e.where, e.code) for e in rest)
    return InputError(first.what, first.fix, first.where, first.code, alone)


def _sentence(error: Mapping[str, Any], root: type[BaseModel]) -> tuple[str, str, str]:
    """Code, what is wrong and how to mend it, for one pydantic error."""
    kind, given, limits = str(error["type"]), error["input"], error.get("ctx", {})
    key = str(error["loc"][-1]) if error["loc"] else "the file"
    shown = f"is {_show(given)}, but must be"
    match kind:
        case "case":
            return str(limits["code"]), str(limits["what"]), str(limits["fix"])
        case "extra_forbidden":
            known = _keys(root, error["loc"][:-1])
            near = get_close_matches(key, known, 1, 0.5)
            fix = f"did you mean {near[0]!r}? " if near else ""
            return "DX201", f"unknown key {_short(key)}", f"{fix}known here: {', '.join(known)}"
        case "missing" if isinstance(error["loc"][-1], int):
            return "DX213", "has too few entries", f"give {_entries(error['loc'])}"
        case "missing":
            return "DX202", f"{key!r} is missing", f"add {key} = …"
        case "float_type" | "int_parsing_size" if type(given) is int:
            return "DX212", f"{shown} a smaller number", "check the number of digits"
        case "float_type":
            return "DX203", f"{shown} a number", _as_number(given)
        case "finite_number":
            return "DX204", f"{shown} finite", "write an ordinary number; nan and inf are refused"
        case "int_type" | "int_from_float":
            fix = "write it without a decimal point, e.g. 10"
            if isinstance(given, float) and given.is_integer() and abs(given) < 1e15:
                fix = f"write {int(given)}, without a decimal point"
            return "DX205", f"{shown} a whole number", fix
        case "string_type":
            return "DX206", f"{shown} a text", 'write it in quotes, e.g. "left"'
        case "string_too_short" | "string_pattern_mismatch" | "string_too_long":
            return "DX207", f"{shown} a name of 1 to 80 characters without blanks around it", 'e.g. "left"'
        case "bool_type":
            return "DX208", f"{shown} true or false", "write true or false, without quotes"
        case "literal_error":
            return "DX209", f"{shown} {limits['expected']}", _nearest(given, str(limits["expected"]))
        case "union_tag_invalid":
            found = limits["tag"]
            return "DX210", f"there is no kind {_short(str(found))}", _nearest(found, str(limits["expected_tags"]))
        case "union_tag_not_found":
            kinds = [k for model in _models_at(root, error["loc"]) for k in _kinds(model)]
            return "DX211", "'kind' is missing", f"say which kind it is, one of {', '.join(kinds)}"
        case "greater_than":
            return "DX212", f"{shown} greater than {limits['gt']:g}", "check the sign and the units"
        case "greater_than_equal":
            return "DX212", f"{shown} at least {limits['ge']:g}", "check the sign and the units"
        case "less_than":
            return "DX212", f"{shown} less than {limits['lt']:g}", "check the value"
        case "less_than_equal":
            return "DX212", f"{shown} at most {limits['le']:g}", "check the value"
        case "too_long":
            return (
                "DX213",
                f"has {limits['actual_length']} entries, but takes {limits['max_length']}",
                "remove the others",
            )
        case "too_short":
            return (
                "DX213",
                f"has {limits['actual_length']} entries, but needs {limits['min_length']}",
                "add the missing ones",
            )
        case "tuple_type" if isinstance(error["input"], dict) and _tables_at(root, error["loc"]):
            return (
                "DX216",
                "is one table, but there may be several",
                f"write the header as [[{key}]], with double brackets",
            )
        case "tuple_type":
            example = "[[0, 0, 0], [1, 0, 0]]" if key == "line" else "[0, 0, 1]"
            return "DX214", f"{shown} a list", f"write it in brackets, e.g. {example}"
        case "model_type" | "model_attributes_type" | "dict_type" if isinstance(given, list):
            return (
                "DX216",
                "is a list of tables, but there is only one",
                f"write the header as [{key}], with single brackets",
            )
        case "model_type" | "model_attributes_type" | "dict_type":
            return "DX215", f"{shown} a table", f"write it as [{key}] or {{ … }}"
        case _:
            return "DX219", f"{_show(given)}: {error['msg']}", "see: directrix schema"


def _as_number(given: object) -> str:
    """How to write what was given as a number."""
    if isinstance(given, str):
        if value := meant(given):
            angle = " (angles are in radians)" if any(mark in given for mark in ("°", "deg", "pi", "π")) else ""
            return f"write {value}, without quotes{angle}"
        if parts := quantity(given):
            return f"write {parts[0]:g}, without quotes and without a unit"
    return "write it without quotes, e.g. 0.5"


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else f"{text[:57]}…")


def _show(value: object) -> str:
    """A value of the file in few characters."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            text = f'the text "{value[:60]}"'
        case list():
            few = cast("list[Any]", value)
            text = f"the list {few}" if len(few) < 20 else f"a list of {len(few)} entries"
        case dict():
            text = "a table"
        case int() if value.bit_length() > 100:
            text = "a huge number"
        case _:
            text = str(value)
    return text if len(text) <= 60 else text[:57] + "…"


def _nearest(given: object, expected: str) -> str:
    words = [w.strip("' ") for w in expected.replace(" or ", ", ").split(",")]
    near = get_close_matches(str(given), words, 1, 0.5)
    return f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(words)}"


def _below(error: Mapping[str, Any]) -> tuple[str | int, ...]:
    """The key to blame, where that is one below the place pydantic names."""
    return ("kind",) if error["type"] == "union_tag_invalid" else error.get("ctx", {}).get("at", ())


def _entries(loc: Sequence[str | int]) -> str:
    """How many entries a list that is too short should have."""
    key = next(str(part) for part in reversed(loc) if part in _ENTRIES or part == loc[0])
    outer, inner = _ENTRIES.get(key, ("three numbers", "three numbers"))
    return inner if isinstance(loc[-2], int) else outer


_ENTRIES = {
    "line": ("two points", "three numbers"),
    "ends": ("two names", ""),
    "axes": ("two vectors", "three numbers"),
    "stops": ("two numbers, lower and upper", ""),
    "stiffness": ("six rows", "six numbers"),
    "I_rho": ("two rows", "two numbers"),
}


def _models_at(root: type[BaseModel], loc: Sequence[str | int]) -> list[type[BaseModel]]:
    """The tables that may stand at a place of the file."""
    models = [root]
    for part in loc:
        found: list[type[BaseModel]] = []
        for model in models:
            if part in model.model_fields:
                found += _models_in(model.model_fields[str(part)].annotation)
            elif part in _kinds(model):
                found = [model]
                break
        models = found or models
    return models


def _tables_at(root: type[BaseModel], loc: Sequence[str | int]) -> bool:
    """Whether a key of the file holds tables."""
    fields = (m.model_fields[str(loc[-1])] for m in _models_at(root, loc[:-1]) if loc[-1] in m.model_fields)
    return any(_models_in(field.annotation) for field in fields)


def _keys(root: type[BaseModel], loc: Sequence[str | int]) -> list[str]:
    """The keys that a table may have."""
    fields = (item for model in _models_at(root, loc) for item in model.model_fields.items())
    return list(dict.fromkeys(field.alias or key for key, field in fields))


def _kinds(model: type[BaseModel]) -> tuple[str, ...]:
    return get_args(model.model_fields["kind"].annotation) if "kind" in model.model_fields else ()


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models_in(part)]
