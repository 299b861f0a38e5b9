"""The codes of errors: stable, so that programs and people can look them up. docs/errors.md is :func:`page`."""

from __future__ import annotations

__all__ = ["CODES", "TABLES", "page"]

HEADS = {
    "DX1": "The file cannot be read",
    "DX2": "A key or a value is not one of a case file",
    "DX3": "Units",
    "DX4": "The model cannot be right",
    "DX5": "Commands, files and folders",
}
CODES: dict[str, tuple[str, str]] = {
    "DX101": ("there is no such file", "check the path; `directrix examples` lists ready cases"),
    "DX102": ("the path is a folder", "name the file in it"),
    "DX103": ("the file cannot be read", "check the permissions"),
    "DX104": ("the ending is not that of a case file", "case files end in .toml or .json"),
    "DX105": ("the file is not UTF-8 text", "save it as UTF-8"),
    "DX106": ("the file is too large", "a case has 32 MB at most: describe long tables with fewer points"),
    "DX107": ("not valid TOML", "mend the syntax at the place named"),
    "DX108": ("not valid JSON", "mend the syntax at the place named"),
    "DX109": ("a key is given twice", "keep one"),
    "DX110": ("tables or lists are nested too deeply", "a case needs no such nesting"),
    "DX111": ("a number of thousands of digits", "shorten it"),
    "DX112": ("the case is empty", "`directrix new` writes one to begin with"),
    "DX113": ("the top of the file is not a table", "write an object in braces"),
    "DX114": ("the file is of a format that this directrix does not know", "install a newer directrix"),
    "DX115": ("a number is written in a form that the file format does not have", "write it as the message shows"),
    "DX201": ("unknown key", "take the key that is meant, or leave it out"),
    "DX202": ("a key is missing", "add it"),
    "DX203": ("not a number", "write a number without quotes, with a point"),
    "DX204": ("not finite", "write an ordinary number"),
    "DX205": ("not a whole number", "write it without a point"),
    "DX206": ("not a text", "write it in quotes"),
    "DX207": ("not a name", "1 to 80 characters, no blanks around them"),
    "DX208": ("neither true nor false", "write true or false, without quotes"),
    "DX209": ("not one of the words that are known here", "take one of them"),
    "DX210": ("there is no such kind", "take one of the kinds named"),
    "DX211": ("the kind is missing", "add kind = …"),
    "DX212": ("out of bounds", "check the sign and the units"),
    "DX213": ("too many or too few entries", "give as many as the message says"),
    "DX214": ("not a list", "write it in brackets"),
    "DX215": ("not a table", "write it as [key] or in braces"),
    "DX216": (
        "one table where several may be, or the other way round",
        "[[key]] is one of several, [key] the only one",
    ),
    "DX217": ("keys that contradict each other or lack each other", "do what the message says"),
    "DX218": ("no analysis, or two", "give [statics] or [dynamics], one of them"),
    "DX219": ("a value that cannot be used", "`directrix schema` says what each key takes"),
    "DX301": ("quantities with units need pint", 'pip install "directrix[units]"'),
    "DX302": ("there is no such unit", "take the unit that is meant"),
    "DX303": ("a unit of another kind of quantity", "give one of the kind that the key takes"),
    "DX304": ("the units of the file are no set", "give length, time, and force or mass"),
    "DX305": ("a unit where none can be", "write a plain number"),
    "DX400": ("the model or a call cannot be right", "do what the message says"),
    "DX401": ("a section cannot be", "check its numbers and their units"),
    "DX402": ("a rod cannot be", "check its axis, its section and its mesh"),
    "DX403": ("a node cannot be", "check its name and place"),
    "DX404": ("a support cannot be", "check what it holds"),
    "DX405": ("a prescribed motion cannot be", "check its values and times"),
    "DX406": ("a load cannot be", "check its value and what it acts on"),
    "DX407": ("a spring, cable or dashpot cannot be", "check its ends and constants"),
    "DX408": ("a mass or body cannot be", "check mass and inertia"),
    "DX409": ("an actuation, tendon or drag cannot be", "check its numbers and what it acts on"),
    "DX410": ("a joint cannot be", "check its nodes, axis and what acts on it"),
    "DX411": ("a contact cannot be", "check its surface, rods and constants"),
    "DX412": ("an initial velocity cannot be", "check it against supports"),
    "DX413": ("the analysis cannot be", "check steps, control and scheme"),
    "DX420": ("a node that is named is not there", "take one of the nodes listed"),
    "DX421": ("a rod or section that is named is not there", "take one of those listed"),
    "DX422": ("a name is given twice", "give each a name of its own"),
    "DX423": ("one node is at two places", "give the ends the same place, or different names"),
    "DX424": ("a component is held or moved twice", "keep one of the two"),
    "DX425": ("a part of the model can move freely", "hold it, tie it, or compute its motion"),
    "DX426": ("joints hold what is held already", "let one of them be of a kind that holds less"),
    "DX427": ("mass or inertia is missing", "give the section rho, or A_rho and I_rho"),
    "DX500": ("a file or folder cannot be used", "do what the message says"),
    "DX501": ("the file exists and is not written over", "name another, or move it away"),
    "DX502": ("a package that is needed is missing", "install the extra that the message names"),
    "DX503": ("the terminal is not there to ask", "give the choice as an option"),
}

# what of a case an error comes from, when nothing more is known of it
TABLES = {
    "section": "DX401", "rod": "DX402", "node": "DX403", "support": "DX404", "prescribe": "DX405", "force": "DX406",
    "moment": "DX406", "distributed": "DX406", "pressure": "DX406", "gravity": "DX406", "spring": "DX407",
    "cable": "DX407", "dashpot": "DX407", "point_mass": "DX408", "rigid_body": "DX408", "actuate": "DX409",
    "tendon": "DX409", "drag": "DX409", "joint": "DX410", "contact": "DX411", "self_contact": "DX411",
    "contact_between": "DX411", "velocity": "DX412", "rigid_velocity": "DX412", "statics": "DX413", "dynamics": "DX413",
}  # fmt: skip


def page() -> str:
    """docs/errors.md."""
    lines = [
        "# Errors",
        "",
        "Every refusal ends in a code that stays what it is. In Python it is `error.code` of a `ModelError`; an",
        "`InputError` has one error for each thing that is wrong with a file in `error.mistakes`. The exit code of the",
        "command is 2.",
    ]
    for head, title in HEADS.items():
        lines += ["", f"## {title}", "", "| code | what | what to do |", "| --- | --- | --- |"]
        lines += [f"| {code} | {what} | {fix} |" for code, (what, fix) in CODES.items() if code.startswith(head)]
    return "\n".join(lines) + "\n"
