"""Which entries and keys of a file are to blame for what the model refuses: all of them, each at its place."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, cast

from directrix.codes import TABLES
from directrix.errors import InputError, ModelError
from directrix.model import Model
from directrix.schema.messages import Source
from directrix.schema.places import Path

__all__ = ["Add", "Blame", "at_entry", "placed"]

Add = Callable[[Model], Model]
COMMON = {"rod", "node", "name", "kind", "type", "value", "time", "a", "b", "t", "section"}  # words of any sentence


def at_entry(source: Source, loc: Path, error: ModelError) -> InputError:
    """A ModelError with the place of the key of an entry that it speaks of, or of the entry."""
    if isinstance(error, InputError):
        return error
    code = error.code if error.code != ModelError.usual else TABLES.get(str(loc[0]) if loc else "", error.code)
    key = _key(_at(source.data, loc), error.what)
    return InputError(error.what, error.fix, source.where((*loc, *key)), code)


@contextmanager
def placed(source: Source, loc: Path) -> Generator[None]:
    """Give a ModelError the place of an entry of the file."""
    try:
        yield
    except ModelError as error:
        raise at_entry(source, loc, error) from None


class Blame:
    """Collects what the entries of a file are to blame for; what only follows from an entry left out is not."""

    def __init__(self, source: Source, left: Sequence[Path] = ()) -> None:
        """``left`` are entries of the file that are left out beforehand."""
        self.source = source
        self.left = frozenset(left)
        self.found: list[InputError] = []
        self.lost: set[str] = set()  # names that are not there because their entry was left out
        for loc in left:
            self._leave(loc)

    def _leave(self, loc: Path) -> None:
        self.lost |= _names(loc, _at(self.source.data, loc))

    def in_file(self, loc: Path) -> Path:
        """The place in the file of an entry among those that were not left out."""
        if len(loc) < 2 or not isinstance(loc[1], int):
            return loc
        gone = sorted(k for key, k in (p for p in self.left if len(p) == 2) if key == loc[0] and isinstance(k, int))
        k = loc[1]
        for other in gone:
            k += other <= k
        return (loc[0], k, *loc[2:])

    def note(self, loc: Path, error: ModelError) -> None:
        """An entry is left out because of an error."""
        loc = self.in_file(loc)
        if not any(repr(name) in error.what for name in self.lost):
            self.found.append(at_entry(self.source, loc, error))
        self._leave(loc)

    def absorb(self, model: Model, entries: Sequence[tuple[Path, Add]], check: Callable[[Model], object]) -> Model:
        """The model with all entries that fit it, the others noted: halves of those that do not fit are tried."""
        new = model
        try:
            for _, add in entries:
                new = add(new)
            if new.rods or new.nodes:
                check(new)
            return new
        except ModelError as error:
            if len(entries) == 1:
                self.note(entries[0][0], error)
                return model
        middle = len(entries) // 2
        return self.absorb(self.absorb(model, entries[:middle], check), entries[middle:], check)


def _at(data: Any, loc: Path) -> Any:
    """What is at a place of the data; None when nothing is."""
    found: Any = data
    for part in loc:
        if isinstance(found, dict):
            found = cast("dict[str, Any]", found).get(str(part))
        elif isinstance(found, list) and isinstance(part, int):
            items = cast("list[Any]", found)
            found = items[part] if part < len(items) else None
    return cast("Any", found)


def _names(loc: Path, table: object) -> set[str]:
    """Names that others may refer to and that an entry gives."""
    if loc and loc[0] == "section" and len(loc) > 1:
        return {str(loc[1])}
    if not isinstance(table, dict) or not loc:
        return set()
    given = cast("dict[str, Any]", table)
    if loc[0] == "rod":
        name, ends, nodes = given.get("name"), given.get("ends"), given.get("nodes")
        out: list[Any] = [name, f"{name}.start", f"{name}.end"]
        out += cast("list[Any]", ends) if isinstance(ends, list) else []
        out += list(cast("dict[str, Any]", nodes)) if isinstance(nodes, dict) else []
        return {n for n in out if isinstance(n, str)}
    if loc[0] == "node":
        return {n for n in [given.get("name")] if isinstance(n, str)}
    if loc[0] == "rigid_body":
        return {f"{given.get('node')}.body"}
    return set()


def _texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(v, str) for v in cast("list[Any]", value))


def _key(table: object, what: str) -> Path:
    """The key of an entry that a sentence speaks of: by its value when that is a name, or by its own name."""
    if not isinstance(table, dict):
        return ()
    given: Mapping[str, Any] = cast("dict[str, Any]", table)
    for key, value in given.items():
        if isinstance(value, str) and key not in ("name", "kind", "type") and _spoken(repr(value), what, last=key):
            return (key,)
        if isinstance(value, list) and _texts(cast("list[Any]", value)):
            for k, item in enumerate(cast("list[str]", value)):
                if repr(item) in what:
                    return (key, k)
    for key in given:
        if re.search(rf"(?<!\w){re.escape(key)} = ", what):
            return (key,)
    for key in given:
        if key not in COMMON and re.search(rf"(?<!\w){re.escape(key)}(?!\w)", what):
            return (key,)
    return ()


def _spoken(shown: str, what: str, last: str) -> bool:
    """A rod of a load is the member, not the mistake, unless it is what is missing."""
    return shown in what and (last not in ("rod", "node") or f"no {last} {shown}" in what)
