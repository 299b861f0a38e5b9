"""Mutations of valid cases that know the schema: wrong kinds, bounds, names, units, keys, and broken text."""

from __future__ import annotations

import copy
import json
import random
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

from directrix.schema import json_schema

__all__ = ["SEEDS", "mutant"]

HERE = Path(__file__).parent
SEEDS = sorted(
    [Path(str(f)) for package in ("directrix.cases", "directrix.templates") for f in files(package).iterdir()
     if f.name.endswith(".toml")] + list((HERE / "good_cases").glob("*.toml")),
    key=lambda p: p.name,
)  # fmt: skip
KEYS = sorted({key for table in json_schema()["$defs"].values() for key in table.get("properties", {})})
WORDS = sorted(
    {
        str(w)
        for t in json_schema()["$defs"].values()
        for p in t.get("properties", {}).values()
        for w in p.get("enum", ())
    }
)
ODD: tuple[Any, ...] = (
    0, -1, 1, 2, 3, 7, -0.0, 1e-300, -1e300, 1e300, 1e308, 5e-324, float("nan"), float("inf"), -float("inf"), 10**30,
    1.5, True, False, "", " ", "x", "7850", "7850.", "1_000,5", "2e11", "90 deg", "5 mm", "210 GPa",
    "3 parsec/fortnight", "1 m^9", "9" * 500, "\0", "\n", "é☃", "a" * 200, [], [0], [0, 0], [0, 0, 0], [0, 0, 0, 0],
    [[0, 0, 0]], [[]], {}, {"kind": "table"}, {"kind": "sine"}, {"t": [0, 1], "value": [0, 1]}, {"x": {"y": {"z": 1}}},
    [True, False, True], ["a", "b", "c"],
    [1e200] * 3, {"kind": "ramp", "until": 1}, "root", "tip", "arm", ["root", "tip"],
)  # fmt: skip


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place below the top."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*path, key)
        yield from places(item, (*path, key))


def mutant(rng: random.Random) -> tuple[str, str]:
    """The text of a case after one to three mutations, and its ending."""
    path = rng.choice(SEEDS)
    text = path.read_text("utf-8")
    if rng.random() < 0.15:
        return _broken(rng, text), ".toml"
    data = tomllib.loads(text)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        _mutate(rng, data)
    if rng.random() < 0.5:
        return json.dumps(data), ".json"
    return toml(data), ".toml"


def _mutate(rng: random.Random, data: dict[str, Any]) -> None:
    spots = list(places(data))
    if not spots:
        return
    *way, last = rng.choice(spots)
    table: Any = data
    for key in way:
        table = table[key]
    old = table[last]
    match rng.randrange(12):
        case 0:
            del table[last]
        case 1 | 2 | 3:
            table[last] = copy.deepcopy(rng.choice(ODD))
        case 4 if isinstance(old, (int, float)) and not isinstance(old, bool):
            new = old * rng.choice((-1, 1e-9, 1e-3, 1e3, 1e9, 0.5))
            table[last] = int(new) if isinstance(old, int) and abs(new) < 500 else new
        case 5 if isinstance(table, dict):
            table[_typo(rng, last)] = table.pop(last)
        case 6 if isinstance(table, dict):
            table[rng.choice(KEYS)] = copy.deepcopy(rng.choice(ODD))
        case 7 if isinstance(old, str):
            table[last] = rng.choice((*WORDS, _typo(rng, old or "x")))
        case 8 if isinstance(table, list):
            table.insert(last, copy.deepcopy(old))
        case 9:  # a value from elsewhere in the file
            *from_way, from_last = rng.choice(spots)
            source: Any = data
            for key in from_way:
                source = source[key]
            table[last] = copy.deepcopy(source[from_last])
        case 10:
            data[rng.choice(KEYS)] = copy.deepcopy(rng.choice(ODD))
        case _:
            table[last] = [old]
    # a valid mesh may be as large as it likes: that is no fault, and takes its time
    for rod in data["rod"] if isinstance(data.get("rod"), list) else ():
        if isinstance(rod, dict) and isinstance(rod.get("elements"), int) and 200 < rod["elements"] <= 10**6:
            rod["elements"] = 200


def _typo(rng: random.Random, word: str) -> str:
    at = rng.randrange(len(word) + 1)
    return rng.choice((word[:at] + "x" + word[at:], word[:at] + word[at + 1 :], word.upper(), word + "s", word[::-1]))


def _broken(rng: random.Random, text: str) -> str:
    """Text with characters lost, put in, or lines moved."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(len(text) + 1)
        match rng.randrange(5):
            case 0:
                text = text[:at] + text[at + rng.randrange(1, 6) :]
            case 1:
                text = text[:at] + rng.choice(list("[]{}=\"'#,.\n\0\t-_eE0+")) + text[at:]
            case 2:
                lines = text.split("\n")
                lines.insert(rng.randrange(len(lines)), rng.choice(lines))
                text = "\n".join(lines)
            case 3:
                text = text[:at]
            case _:
                text = text.replace(" = ", rng.choice((" == ", " : ", " = =", "=")), rng.randrange(3))
    return text


def toml(value: Any, top: bool = True) -> str:
    """Data as TOML: tables at the top as headers' keys, all below inline."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(k, ensure_ascii=True)} = {toml(v, False)}" for k, v in value.items()]
        return "\n".join(pairs) + "\n" if top else "{ " + ", ".join(pairs) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml(v, False) for v in value) + "]"
    if isinstance(value, float):
        return {"inf": "inf", "-inf": "-inf", "nan": "nan"}.get(repr(value), repr(value))
    return json.dumps(value)
