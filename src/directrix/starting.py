"""Cases to begin with: commented templates that run as they are."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

from directrix.checks import choice
from directrix.errors import InputError
from directrix.schema.load import SCHEMA_ID, json_schema

__all__ = ["SCHEMA_FILE", "begin", "templates", "write_schema"]

SCHEMA_FILE = "directrix.schema.json"


def templates() -> dict[str, str]:
    """Text of every template by its name."""
    found = {f.name: f.read_text("utf-8") for f in files("directrix.templates").iterdir() if f.name.endswith(".toml")}
    return {name.removesuffix(".toml"): text for name, text in sorted(found.items())}


def begin(name: str, template: str) -> tuple[Path, Path]:
    """Write a case ``name``.toml from a template, and the schema for editors beside it; both paths.

    Raises ModelError for a template that is not there, and InputError where a file would be written over.
    """
    text = templates()[choice(template, "template", templates())]
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not path.stem.strip(". ") or "\0" in name:
        raise InputError("is no name for a file", "give a name such as mast", name, "DX500")
    if path.exists():
        raise InputError("exists and is not written over", "give another name, or move it away", str(path), "DX501")
    if not path.parent.is_dir():
        raise InputError("there is no such folder", "make it first", str(path.parent), "DX500")
    beside = write_schema(path.with_name(SCHEMA_FILE))
    path.write_text(f"#:schema ./{SCHEMA_FILE}\n{text}", encoding="utf-8")
    return path, beside


def write_schema(path: Path) -> Path:
    """Write the JSON schema of cases. Raises InputError when another file is there."""
    if path.exists() and not _ours(path):
        raise InputError("exists and is another file", "move it away", str(path), "DX501")
    path.write_text(json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def _ours(path: Path) -> bool:
    try:
        return json.loads(path.read_text("utf-8"))["$id"].startswith(SCHEMA_ID.rsplit(":", 1)[0])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return False
