"""From the bytes of a case file to tables and places, past numbers in a wrong form, which are noted on the way."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from directrix.errors import InputError
from directrix.schema.messages import Source, together
from directrix.schema.places import json_places, toml_places
from directrix.schema.units import meant, quantity

__all__ = ["parse", "read"]

LARGEST = 32_000_000  # bytes
DEEPEST = 30  # levels of tables and lists
REPAIRS = 50  # values in a wrong form that are looked past


def read(file: Path) -> bytes:
    """The bytes of a case file. Raises InputError when there is none that can be read."""
    try:
        if file.is_dir():
            raise InputError(
                "this is a folder, not a case file", "name the .toml or .json file in it", str(file), "DX102"
            )
        if file.exists() and not file.is_file():
            raise InputError("is a device, not a file", "name a .toml or .json file", str(file), "DX103")
        if file.stat().st_size > LARGEST:
            raise InputError(
                f"is {file.stat().st_size / 1e6:.0f} MB large, and a case file has {LARGEST / 1e6:.0f} MB at most",
                "describe long tables with fewer points",
                str(file),
                "DX106",
            )
        return file.read_bytes()
    except FileNotFoundError:
        raise InputError(
            "there is no such file", "check the path; directrix examples lists ready cases", str(file), "DX101"
        ) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", "check the permissions", str(file), "DX103") from None


def parse(file: Path, raw: bytes) -> tuple[Source, tuple[InputError, ...]]:
    """Tables with their places, and the values in a wrong form that were looked past. Raises InputError."""
    toml = file.suffix.lower() == ".toml"
    if not toml and file.suffix.lower() != ".json":
        ending = file.suffix or "no"
        raise InputError(f"{ending} ending: not a case file", "case files end in .toml or .json", str(file), "DX104")
    try:
        text = raw.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        column = error.start - raw.rfind(b"\n", 0, error.start)
        fix = "save the file as UTF-8" + (" (it seems to be UTF-16)" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "")
        raise InputError("is not UTF-8 text", fix, f"{file}:{line}:{column}", "DX105") from None
    noted: list[InputError] = []
    while True:
        data, wrong = _try(file, text, toml)
        if wrong is None:
            break
        mended = _past(file, text, wrong[1], toml, noted) if len(noted) < REPAIRS else None
        if mended is None:
            raise together([*noted, wrong[0]])
        text = mended
    if data == {}:
        raise InputError(
            "the case is empty",
            "directrix new writes a case to begin with, directrix examples prints others",
            f"{file}:1:1",
            "DX112",
        )
    if not isinstance(data, dict):
        raise InputError(
            "the top of the file is not a table", "write an object in braces { … }", f"{file}:1:1", "DX113"
        )
    tables = cast("dict[str, Any]", data)
    _shallow(file, tables)
    spots = toml_places(text) if toml else json_places(text)
    return Source(str(file), tables, spots), tuple(noted)


def _try(file: Path, text: str, toml: bool) -> tuple[Any, tuple[InputError, int] | None]:
    """The data, or what is wrong with the syntax and its line. Raises InputError where there is no line."""
    try:
        if toml:
            return tomllib.loads(text), None
        return json.loads(text if text.strip() else "{}", object_pairs_hook=_unique), None
    except tomllib.TOMLDecodeError as error:
        return None, _syntax(file, text, str(error))
    except json.JSONDecodeError as error:
        where = f"{file}:{error.lineno}:{error.colno}"
        said = InputError(f"not valid JSON: {error.msg}", "mend the syntax near this place", where, "DX108")
        return None, (said, error.lineno)
    except _TwiceError as twice:
        found = list(re.finditer(re.escape(json.dumps(twice.key, ensure_ascii=False)), text))
        at = found[1].start() if len(found) > 1 else 0
        line, column = text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)
        key = repr(twice.key[:60])
        raise InputError(
            f"the key {key} is given twice", "keep one of them", f"{file}:{line}:{column}", "DX109"
        ) from None
    except ValueError:  # Python's own limit on the digits of a whole number
        long = re.search(r"[\d_]{4300,}", text)
        line = text.count("\n", 0, long.start()) + 1 if long else 1
        raise InputError("holds a number of thousands of digits", "shorten it", f"{file}:{line}:1", "DX111") from None
    except RecursionError:
        raise InputError("is nested too deeply", "a case file needs no such nesting", f"{file}:1:1", "DX110") from None


def _syntax(file: Path, text: str, message: str) -> tuple[InputError, int]:
    """The parser's sentence carries the place; at the end of the file it says so in words."""
    at = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    line = int(at[1]) if at and at[1] else len(text.splitlines()) or 1
    column = int(at[2]) if at and at[2] else 1
    reason = message[: at.start()] if at else message
    twice = any(word in reason for word in ("overwrite", "twice", "mutate", "Duplicate"))
    fix = "give every key and table once" if twice else "texts stand in quotes, lists in brackets"
    said = InputError(
        f"not valid TOML: {reason[:200]}",
        f"mend the syntax at this place; {fix}",
        f"{file}:{line}:{column}",
        "DX109" if twice else "DX107",
    )
    return said, line


_VALUE = re.compile(r"^(\s*[^=#\[]+?=\s*)([^\[\]{}\"'#]+?)(\s*(?:#.*)?)$")
_WORD = re.compile(r"[A-Za-z][\w-]*")
_TOKEN = re.compile(r"\"[^\"]*\"|'[^']*'|#.*|[^\s,\[\]{}=:\"'#]+")


def _past(file: Path, text: str, line: int, toml: bool, noted: list[InputError]) -> str | None:
    """The text with what is no value on a line replaced by what is meant; None when nothing is known to be meant."""
    lines = text.split("\n")
    if not 1 <= line <= len(lines) or len(lines[line - 1]) > 2000:
        return None
    old = lines[line - 1]

    def note(given: str, value: str, column: int) -> str:
        language = "TOML" if toml else "JSON"
        where = f"{file}:{line}:{column + 1}"
        key = old[:column].split("=")[0].strip() if toml and "=" in old[:column] else ""
        noted.append(
            InputError(
                f"{given!r} is no value of {language}",
                f"write {value}",
                f"{where}: {key}" if re.fullmatch(r"[\w.]{1,60}", key) else where,
                "DX115",
            )
        )
        return value

    whole = _VALUE.fullmatch(old) if toml else None
    if whole is not None and (value := _written(whole[2], toml)) is not None:
        lines[line - 1] = whole[1] + note(whole[2], value, len(whole[1])) + whole[3]
    else:
        start = old.find("=" if toml else ":") + 1
        new, at = "", 0
        for token in _TOKEN.finditer(old):
            value = None
            if token.start() >= start and token[0][0] not in "\"'#":
                value = _written(token[0], toml, words=False)
            if value is not None:
                new, at = new + old[at : token.start()] + note(token[0], value, token.start()), token.end()
        if not at:
            return None
        lines[line - 1] = new + old[at:]
    return "\n".join(lines)


def _written(given: str, toml: bool, words: bool = True) -> str | None:
    """What a text that is no value is likely meant to be, as the language writes it; None for a value, or no idea."""
    if _is_value(given, toml):
        return None
    if given.lower() in ("true", "false", "yes", "no", "on", "off"):
        return "true" if given.lower() in ("true", "yes", "on") else "false"
    if value := meant(given):
        return value if re.search(r"[.en]", value) or "." not in given else f"{value}.0"
    if quantity(given) is not None:
        return f'"{given}"'
    return f'"{given}"' if words and toml and _WORD.fullmatch(given) else None


def _is_value(given: str, toml: bool) -> bool:
    try:
        if toml:
            tomllib.loads(f"x = {given}")
        else:
            json.loads(given)
    except (ValueError, RecursionError):
        return False
    return True


def _shallow(file: Path, data: object) -> None:
    """Refuse what is nested deeper than any case."""
    level: list[object] = [data]
    for _ in range(DEEPEST):
        inner: list[object] = []
        for value in level:
            if isinstance(value, dict):
                inner += cast("dict[str, object]", value).values()
            elif isinstance(value, list):
                inner += cast("list[object]", value)
        if not inner:
            return
        level = inner
    raise InputError("is nested too deeply", "a case file needs no such nesting", f"{file}:1:1", "DX110")


class _TwiceError(Exception):
    def __init__(self, key: str) -> None:
        self.key = key
        super().__init__(key)


def _unique(pairs: list[tuple[str, Any]]) -> Mapping[str, Any]:
    out: dict[str, Any] = {}
    for key, value in pairs:
        if key in out:
            raise _TwiceError(key)
        out[key] = value
    return out
