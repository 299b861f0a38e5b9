"""The version of the case format: newer files are refused, older ones are brought up to date."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from directrix.errors import InputError
from directrix.schema.messages import Source

__all__ = ["FORMAT", "MIGRATIONS", "migrated"]

FORMAT = 1
# MIGRATIONS[n] makes tables of format n + 1 of tables of format n; none is needed while there is one format only
MIGRATIONS: dict[int, Callable[[Mapping[str, Any]], Mapping[str, Any]]] = {}


def migrated(source: Source) -> Mapping[str, Any]:
    """The tables of a file in the format of today. Raises InputError for a newer one, or one that is no version."""
    given = source.data.get("format_version", FORMAT)
    where = source.where(("format_version",))
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        raise InputError(
            f"is {str(given)[:40]!r}, but must be a whole number from 1 to {FORMAT}",
            f"write format_version = {FORMAT}, or leave it out",
            where,
            "DX114",
        )
    if given > FORMAT:
        raise InputError(
            f"the file is of format {str(given)[:20]}, and this directrix knows formats up to {FORMAT}",
            "install a newer directrix, or write the file for this one",
            where,
            "DX114",
        )
    data = source.data
    for version in range(given, FORMAT):
        data = {**MIGRATIONS[version](data), "format_version": version + 1}
    return data
