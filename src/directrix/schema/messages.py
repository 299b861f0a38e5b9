"""From what pydantic found to one message with file, line, key and a fix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, cast, get_args

from pydantic import BaseModel

from directrix.errors import InputError
from directrix.schema.places import Path

__all__ = ["Source", "explain"]


@dataclass(frozen=True)
class Source:
    """A case file that was read: its name for messages, its data, and the lines of its keys."""

    name: str
    data: Mapping[str, Any]
    lines: Mapping[Path, int]

    def where(self, loc: Sequence[str | int] = (), missing: bool = False) -> str:
        """``file.toml:12: rod[left].elements`` for a path.

        Parts that the file does not have are passed over, except the last one of a ``missing`` key, which is
        shown with the line of the table that lacks it.
        """
        path: Path = ()
        shown = ""
        value: Any = self.data
        for part in loc:
            if (*path, part) in self.lines:
                path = (*path, part)
                value = value[part]
                shown += _label(part, value) if isinstance(part, int) else f".{part}"
        if missing and isinstance(loc[-1], str):
            shown += f".{loc[-1]}"
        line = self.lines.get(path, 1)
        return f"{self.name}:{line}" + (f": {shown.lstrip('.')}" if shown else "")


def _label(index: int, item: object) -> str:
    if isinstance(item, dict):
        table = cast("dict[str, Any]", item)
        for key in ("name", "node", "rod"):
            if isinstance(table.get(key), str):
                return f"[{table[key]}]"
        return f"[#{index + 1}]"
    return f"[{index}]"


def explain(errors: Sequence[Mapping[str, Any]], source: Source, root: type[BaseModel]) -> InputError:
    """One error for all that pydantic reported; the first in full, the rest a line each."""
    # pydantic counts the entries of a list that are good; one that has enough was reported already
    real = [e for e in errors if e["type"] != "too_short" or len(e["input"]) < e["ctx"]["min_length"]]
    # a misspelt key is the likely cause of the missing one beside it
    order = sorted(real, key=lambda e: (e["type"] != "extra_forbidden", e["type"] == "missing"))
    places = [source.where((*e["loc"], *_below(e)), e["type"] == "missing") for e in order]
    sentences = [_sentence(e, root) for e in order]
    what, fix = sentences[0]
    if rest := [f"\n    {place}: {text}" for place, (text, _) in zip(places[1:], sentences[1:], strict=True)]:
        fix += f"\n  (and {len(rest)} more)" + "".join(rest)
    return InputError(what, fix, places[0])


def _sentence(error: Mapping[str, Any], root: type[BaseModel]) -> tuple[str, str]:
    """What is wrong and how to mend it, for one pydantic error."""
    kind, given, limits = str(error["type"]), error["input"], error.get("ctx", {})
    key = str(error["loc"][-1]) if error["loc"] else "the file"
    shown = f"is {_show(given)}, but must be"
    match kind:
        case "case":
            return str(limits["what"]), str(limits["fix"])
        case "extra_forbidden":
            known = [k for model in _models_at(root, error["loc"][:-1]) for k in model.model_fields]
            near = get_close_matches(key, known, 1, 0.5)
            fix = f"did you mean {near[0]!r}? " if near else ""
            return f"unknown key {key!r}", f"{fix}known here: {', '.join(known)}"
        case "missing" if isinstance(error["loc"][-1], int):
            return "has too few entries", f"give {_entries(error['loc'])}"
        case "missing":
            return f"{key!r} is missing", f"add {key} = …"
        case "float_type" | "int_parsing_size" if type(given) is int:
            return f"{shown} a smaller number", "check the number of digits"
        case "float_type":
            return f"{shown} a number", "write it without quotes, e.g. 0.5"
        case "finite_number":
            return f"{shown} finite", "write an ordinary number; nan and inf are refused"
        case "int_type" | "int_from_float":
            return f"{shown} a whole number", "write it without a decimal point, e.g. 10"
        case "string_type":
            return f"{shown} a text", 'write it in quotes, e.g. "left"'
        case "string_too_short" | "string_pattern_mismatch" | "string_too_long":
            return f"{shown} a name of 1 to 80 characters without blanks around it", 'e.g. "left"'
        case "bool_type":
            return f"{shown} true or false", "write true or false, without quotes"
        case "literal_error":
            return f"{shown} {limits['expected']}", _nearest(given, str(limits["expected"]))
        case "union_tag_invalid":
            found = limits["tag"]
            return f"there is no kind {found!r}", _nearest(found, str(limits["expected_tags"]))
        case "union_tag_not_found":
            kinds = [k for model in _models_at(root, error["loc"]) for k in _kinds(model)]
            return "'kind' is missing", f"say which kind it is, one of {', '.join(kinds)}"
        case "greater_than":
            return f"{shown} greater than {limits['gt']:g}", "check the sign and the units"
        case "greater_than_equal":
            return f"{shown} at least {limits['ge']:g}", "check the sign and the units"
        case "less_than":
            return f"{shown} less than {limits['lt']:g}", "check the value"
        case "less_than_equal":
            return f"{shown} at most {limits['le']:g}", "check the value"
        case "too_long":
            return (
                f"has {limits['actual_length']} entries, but takes {limits['max_length']}",
                "remove the others",
            )
        case "too_short":
            return (
                f"has {limits['actual_length']} entries, but needs {limits['min_length']}",
                "add the missing ones",
            )
        case "tuple_type" if isinstance(given, dict):
            return (
                "is one table, but there may be several",
                f"write the header as [[{key}]], with double brackets",
            )
        case "tuple_type":
            return f"{shown} a list", "write it in brackets, e.g. [0, 0, 1]"
        case "model_type" | "model_attributes_type" | "dict_type" if isinstance(given, list):
            return (
                "is a list of tables, but there is only one",
                f"write the header as [{key}], with single brackets",
            )
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{shown} a table", f"write it as [{key}] or {{ … }}"
        case _:
            return f"{_show(given)}: {error['msg']}", "see: directrix schema"


def _show(value: object) -> str:
    """A value of the file in few characters."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            text = f'the text "{value}"'
        case list():
            text = f"the list {value}"
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


def _kinds(model: type[BaseModel]) -> tuple[str, ...]:
    return get_args(model.model_fields["kind"].annotation) if "kind" in model.model_fields else ()


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models_in(part)]
