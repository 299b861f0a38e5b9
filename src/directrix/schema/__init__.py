"""Case files: TOML or JSON in, one frozen Case out, every message with file, line and key."""

from directrix.schema.load import Case, json_schema, load_case

__all__ = ["Case", "json_schema", "load_case"]
