"""A case from TOML to JSON and back: the same tables in the other language, without the comments."""
# pyright: reportMissingImports=false

from __future__ import annotations

import json
import re
from importlib import import_module
from pathlib import Path
from typing import Any

from directrix.errors import InputError, ModelError
from directrix.schema.load import load_case
from directrix.schema.places import has_comments
from directrix.schema.text import parse, read

__all__ = ["convert"]

DIRECTIVE = re.compile(r"^#:schema[ \t]+(\S+)[ \t]*$", re.MULTILINE)


def convert(source: Path, target: Path) -> bool:
    """Write the case ``source`` as ``target``, .toml or .json; True when comments were left behind.

    Raises InputError for a case that is wrong, an ending that is neither, or a file that would be written over, and
    ModelError when the writer of TOML is missing.
    """
    load_case(source)  # a case that is wrong is refused before anything is written
    raw = read(source)
    data: dict[str, Any] = dict(parse(source, raw)[0].data)
    text = raw.decode("utf-8-sig")
    endings = (source.suffix.lower(), target.suffix.lower())
    if endings not in ((".toml", ".json"), (".json", ".toml")):
        raise InputError(
            "a case is converted from .toml to .json or back", "give the target the other ending", str(target), "DX104"
        )
    if target.exists():
        raise InputError("exists and is not written over", "give another name, or move it away", str(target), "DX501")
    if endings[1] == ".json":
        named = DIRECTIVE.search(text)
        out = _json({**({"$schema": named[1]} if named else {}), **data})
        lost = has_comments(text)
    else:
        named = data.pop("$schema", None)
        out = (f"#:schema {named}\n" if named else "") + _toml(data)
        lost = False
    target.write_text(out, encoding="utf-8")
    return lost


def _json(data: dict[str, Any]) -> str:
    """Lists of numbers and texts on one line."""
    text = json.dumps(data, indent=2, ensure_ascii=False, default=str)
    while (shorter := re.sub(r"\[\s*\n\s*([^\[\]{}\n][^\[\]{}]*?)\s*\n\s*\]", _one_line, text)) != text:
        text = shorter
    return text + "\n"


def _one_line(found: re.Match[str]) -> str:
    return "[" + re.sub(r"\n\s*", " ", found[1]) + "]"


def _toml(data: dict[str, Any]) -> str:
    try:
        tomlkit = import_module("tomlkit")
    except ModuleNotFoundError:
        raise ModelError(
            "writing TOML needs tomlkit, which is not installed", 'pip install "directrix[toml]"', code="DX502"
        ) from None
    return tomlkit.dumps(data)
