"""Where every key of a case file stands, so that a message can name line and column.

Both scanners read text that the standard parsers have accepted already; they only follow it and note places.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import NamedTuple

Path = tuple[str | int, ...]

__all__ = ["Path", "Spot", "has_comments", "json_places", "toml_places"]


class Spot(NamedTuple):
    """Line and column, from 1."""

    line: int
    column: int


class _Token(NamedTuple):
    kind: str
    text: str
    spot: Spot


_TOML = re.compile(
    r'(?P<text>"""(?:\\[\s\S]|(?!""")[^\\])*"{3,5}|\'\'\'(?:(?!\'\'\')[\s\S])*\'{3,5}|"(?:\\.|[^"\\])*"|\'[^\']*\')'
    r"|(?P<comment>#[^\n]*)|(?P<newline>\n)|(?P<mark>[\[\]{}=,])|(?P<bare>[^\s#\[\]{}=,\"']+)"
)
_JSON = re.compile(r'(?P<text>"(?:\\.|[^"\\])*")|(?P<mark>[\[\]{}:,])|(?P<bare>[^\s\[\]{}:,"]+)')


def _tokens(pattern: re.Pattern[str], text: str) -> Iterator[_Token]:
    line, last, start = 1, 0, 0
    for match in pattern.finditer(text):
        if passed := text.count("\n", last, match.start()):
            line, start = line + passed, text.rindex("\n", last, match.start()) + 1
        last = match.start()
        yield _Token(match.lastgroup or "", match.group(), Spot(line, last - start + 1))


class _Toml:
    """A cursor over the tokens; ``spots`` fills as it goes."""

    def __init__(self, text: str) -> None:
        self.tokens = [t for t in _tokens(_TOML, text) if t.kind != "comment"] + [
            _Token("end", "", Spot(text.count("\n") + 1, 1))
        ]
        self.at = 0
        self.spots: dict[Path, Spot] = {(): Spot(1, 1)}
        self.tables: dict[Path, int] = {}  # arrays of tables: how many so far

    @property
    def here(self) -> _Token:
        return self.tokens[self.at]

    def take(self) -> _Token:
        token = self.here
        self.at += token.kind != "end"
        return token

    def at_mark(self, mark: str) -> bool:
        return self.here.text == mark and self.here.kind == "mark"

    def skip(self, *texts: str) -> None:
        while self.here.kind == "newline" or self.here.text in texts:
            self.take()

    def key(self) -> list[str]:
        parts: list[str] = []
        while self.here.kind in ("bare", "text"):
            token = self.take()
            quoted = token.kind == "text"
            parts += [tomllib.loads(f"k={token.text}")["k"]] if quoted else [p for p in token.text.split(".") if p]
        return parts

    def note(self, path: Path, spot: Spot) -> None:
        for n in range(1, len(path) + 1):
            self.spots.setdefault(path[:n], spot)

    def value(self, path: Path) -> None:
        self.note(path, self.here.spot)
        if self.at_mark("["):
            self.take()
            self.skip(",")
            index = 0
            while not self.at_mark("]") and self.here.kind != "end":
                self.value((*path, index))
                self.skip(",")
                index += 1
            self.take()
        elif self.at_mark("{"):
            self.take()
            self.skip(",")
            while not self.at_mark("}") and self.here.kind != "end":
                self.pair(path)
                self.skip(",")
            self.take()
        else:
            while self.take().kind == "bare" and self.here.kind == "bare":  # a date and a time are two words
                pass

    def pair(self, table: Path) -> None:
        spot = self.here.spot
        path = (*table, *self.key())
        self.note(path, spot)
        self.take()  # the equals sign
        self.value(path)

    def header(self) -> Path:
        spot = self.take().spot
        several = self.at_mark("[")
        if several:
            self.take()
        path: Path = ()
        parts = self.key()
        for n, part in enumerate(parts, 1):
            path = (*path, part)
            self.note(path, spot)
            if several and n == len(parts):
                self.tables[path] = self.tables.get(path, 0) + 1
            if path in self.tables:
                path = (*path, self.tables[path] - 1)
        self.note(path, spot)
        self.skip("]")
        return path

    def document(self) -> dict[Path, Spot]:
        table: Path = ()
        self.skip()
        while self.here.kind != "end":
            if self.at_mark("["):
                table = self.header()
            else:
                self.pair(table)
            self.skip()
        return self.spots


def toml_places(text: str) -> Mapping[Path, Spot]:
    """Place of every key, table and list item of valid TOML, by its path from the top."""
    return _Toml(text).document()


def has_comments(text: str) -> bool:
    """True when valid TOML has a comment other than the schema it names."""
    return any(t.kind == "comment" and not t.text.startswith("#:schema") for t in _tokens(_TOML, text))


def json_places(text: str) -> Mapping[Path, Spot]:
    """Place of every key and list item of valid JSON, by its path from the top."""
    spots: dict[Path, Spot] = {(): Spot(1, 1)}
    stack: list[str | int] = []  # path to the value that comes next
    kinds: list[str] = []
    wants_key = False
    for token in _tokens(_JSON, text):
        if token.text in ("{", "["):
            spots.setdefault(tuple(stack), token.spot)
            kinds.append(token.text)
            stack.append("" if token.text == "{" else 0)
            wants_key = token.text == "{"
        elif token.text in ("}", "]"):
            kinds.pop()
            stack.pop()
            wants_key = False
        elif token.text == ",":
            last = stack[-1]
            stack[-1] = last + 1 if isinstance(last, int) else ""
            wants_key = kinds[-1] == "{"
        elif token.text != ":":
            if wants_key:
                stack[-1] = json.loads(token.text)
                wants_key = False
            spots.setdefault(tuple(stack), token.spot)
    return spots
