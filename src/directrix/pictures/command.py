"""What the options of ``directrix plot`` mean to a picture."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from directrix.errors import ModelError
from directrix.quantities import QUANTITIES
from directrix.result import Result

__all__ = ["options_of"]

TAKES: Mapping[str, tuple[str, ...]] = {
    "shape": ("at",),
    "history": ("node", "rod", "s", "quantity", "component", "others"),
    "orbit": ("node", "rod", "s", "quantity", "over", "others"),
    "section_forces": ("rod", "component", "at", "envelope", "others"),
    "diagram": ("component", "at"),
    "path": ("node", "component", "others"),
    "branches": ("node", "component", "others"),
    "newton": ("others",),
    "convergence": ("component",),
}
NAMES = {"s": "--s", "others": "--beside"}


def options_of(picture: str, given: Mapping[str, Any], result: Result) -> tuple[dict[str, Any], str]:
    """Arguments of the method ``result.plot.<picture>``, and a name for the file.

    Raises ModelError for an option that the picture does not take, and for one that it needs.
    """
    takes = TAKES.get(picture, ())
    for key in given:
        if key not in takes:
            allowed = ", ".join(NAMES.get(name, f"--{name}") for name in takes)
            raise ModelError(
                f"{picture} takes no {NAMES.get(key, f'--{key}')}", f"it takes {allowed}" if takes else "leave it out"
            )
    out = {key: given[key] for key in ("at", "envelope", "others") if key in given}
    match picture:
        case "history":
            quantity = given.get("quantity", "force" if "rod" in given else "displacement")
            out |= {"quantity": quantity, "component": given.get("component")}
            out["of"] = _of(picture, given, result, needed=_owner(quantity) != "run")
        case "orbit":
            out["of"] = _of(picture, given, result, needed=True)
            for key, name in (("x", "over"), ("y", "quantity")):
                if name in given:
                    what, _, part = given[name].partition(".")
                    out[key] = (what, part) if part else what
        case "section_forces":
            out |= {key: given[name] for key, name in (("rods", "rod"), ("components", "component")) if name in given}
        case "diagram" if "component" in given:
            out["component"] = given["component"]
        case "convergence":
            out["of"] = given.get("component")
        case "path" | "branches":
            out |= {"node": _of(picture, given, result, needed=True), "component": given.get("component", "y")}
            if picture == "branches" and "others" in given:
                out["others"] = list(given["others"].values())
        case _:
            pass
    words = [picture, *(str(value) for key, value in given.items() if key not in ("others", "envelope"))]
    if picture == "history":
        words.insert(len(words), out["quantity"]) if "quantity" not in given else None
    return out, re.sub(r"[^\w.-]", "_", "-".join(words))


def _owner(quantity: str) -> str:
    return QUANTITIES[quantity].owner if quantity in QUANTITIES else "rod"


def _of(picture: str, given: Mapping[str, Any], result: Result, *, needed: bool) -> Any:
    """The node, or the point of a rod."""
    if "rod" in given or "s" in given:
        if "node" in given or not ("rod" in given and "s" in given):
            raise ModelError("a point of a rod is --rod and --s together, without --node", "give both")
        return given["rod"], given["s"]
    if "node" in given:
        return given["node"]
    if needed:
        names = ", ".join(result.mesh.node_names)
        raise ModelError(f"{picture}: of which node?", f"add --node, or --rod and --s; nodes: {names}")
    return None
