"""The check against the schema: all that breaks it, in plain sentences, and the rest made ready to be read."""

from __future__ import annotations

import json
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from thenar.io.parse import Format
from thenar.io.schema import AutomatonTable, EventTable, ModelFile
from thenar.model.build import Complaint

__all__ = ["check"]

Path = tuple[str | int, ...]

_MISSING = {
    "kind": "no kind; say whether it is a 'plant' or a 'spec'",
    "initial": "no initial state; say which state the automaton starts in",
}
_EXPECTED = {
    "string_type": "text",
    "string_too_short": "a name",
    "string_unicode": "valid Unicode text",
    "bool_type": "true or false",
    "list_type": "a list",
    "literal_error": "'plant' or 'spec'",
}
_TABLE = {"toml": "a table", "json": "an object in braces"}
_LONGEST_SHOWN = 40  # characters of a value that a message repeats


def check(data: Any, format: Format) -> tuple[ModelFile, list[Complaint]]:
    """Return what ``data`` says, and everything in it that breaks the schema.

    All mistakes of a file are to be found at once, those of meaning too.  So ``data`` is mended (in place):
    a key close to a known one is taken for it, a wrong value gives way to a neutral one.  A file with
    complaints is good for looking for more, and for nothing else.

    >>> file, complaints = check({"events": {"slip": {"controlable": False}}}, "toml")
    >>> complaints
    [(('events', 'slip', 'controlable'), "unknown key; did you mean 'controllable'?")]
    >>> file.events["slip"].controllable
    False
    """
    complaints: dict[Path, str] = {}
    written: dict[Path, str | int] = {}  # a key that was taken for a known one, as it stands in the file
    if not isinstance(data, dict):
        complaints[()] = f"expected {_TABLE[format]} with events and automata, found {_in_words(data, format)}"
        data = {}
    while True:
        try:
            return ModelFile.model_validate(data), list(complaints.items())
        except ValidationError as error:
            details = {_culprit(detail): detail for detail in error.errors(include_url=False, include_input=False)}
        unknown = [path for path, detail in details.items() if detail["type"] == "extra_forbidden"]
        for path in unknown:
            complaints[_as_written(path, written)] = _unknown_key(path, data, format)
            _rename(path, data, written)
        for path, detail in details.items():
            if path in unknown or (detail["type"] == "missing" and path in written):
                continue
            complaints[_as_written(path, written)] = _sentence(path, detail, data, format)
            _mend(path, data)


def _culprit(detail: ErrorDetails) -> Path:
    """Return the path of the smallest thing that makes sense as a whole: a transition, a size, a key."""
    path = detail["loc"]
    if path[:1] in (("computed",), ("published",)):
        return path[:2]
    if path[0] == "automata" and path[2:3] == ("transitions",):
        return path[:4]
    return path[:-1] if path[-1] == "[key]" else path


def _as_written(path: Path, written: dict[Path, str | int]) -> Path:
    return tuple(written.get(path[: k + 1], step) for k, step in enumerate(path))


def _at(path: Path, data: Any) -> Any:
    """Return the value at ``path``, or None where there is none."""
    for step in path:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            return None
    return data


# -- sentences ---------------------------------------------------------------------------------------------


def _sentence(path: Path, detail: ErrorDetails, data: Any, format: Format) -> str:
    if detail["type"] == "missing":
        return _MISSING[str(path[-1])]
    value = _at(path, data)
    found = _in_words(value, format)
    if path[0] in ("computed", "published") and len(path) == 2:
        return f"expected [states, transitions], two whole numbers, found {found}"
    if path[0] == "automata" and path[2:3] == ("transitions",) and len(path) == 4:
        return f"expected 'state -event-> state' or ['state', 'event', 'state'], found {found}"
    expected = _EXPECTED.get(detail["type"], _TABLE[format])
    way_out = f"; write [{json.dumps(value)}]" if expected == "a list" and isinstance(value, str) else ""
    return f"expected {expected}, found {found}{way_out}"


def _unknown_key(path: Path, data: Any, format: Format) -> str:
    owner, keys = path[:-1], _keys(path)
    if near := get_close_matches(str(path[-1]), keys, n=1):
        return f"unknown key; did you mean {near[0]!r}?"
    if format == "toml" and owner and isinstance(_at(path, data), dict):
        # [automata.SPEC.1] and re.align = {} are tables in tables, which is rarely what was meant
        return f'unknown key; a name with a dot stands in double quotes: "{owner[-1]}.{path[-1]}"'
    return f"unknown key; the keys here are {', '.join(keys)}"


def _keys(path: Path) -> list[str]:
    """Return the keys that the schema has where ``path`` is."""
    tables: dict[Any, type[BaseModel]] = {"events": EventTable, "automata": AutomatonTable}
    table = ModelFile if len(path) == 1 else tables[path[0]]
    return [field.alias or key for key, field in table.model_fields.items()]


def _in_words(value: Any, format: Format) -> str:
    if isinstance(value, dict):
        return _TABLE[format]
    if isinstance(value, list):
        return f"a list of {len(value)}" if value else "an empty list"
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    if isinstance(value, str):
        return f"the text {value!r}" if len(value) <= _LONGEST_SHOWN else "a long text"
    return f"{value}" if isinstance(value, float) or (isinstance(value, int) and abs(value) < 10**15) else "a number"


# -- mending -----------------------------------------------------------------------------------------------


def _rename(path: Path, data: Any, written: dict[Path, str | int]) -> None:
    """Take an unknown key for the known one that it is close to, if that is still free; else drop it."""
    owner = _at(path[:-1], data)
    value = owner.pop(path[-1])
    near = get_close_matches(str(path[-1]), _keys(path), n=1)
    if near and near[0] not in owner:
        owner[near[0]] = value
        written[(*path[:-1], near[0])] = path[-1]


def _mend(path: Path, data: Any) -> None:
    """Put something neutral in the place of a wrong value: it causes no complaint that is not there already."""
    automata = data.get("automata")
    match path:
        case ["events", name, *_]:
            data["events"][name] = {}
        case ["automata", name, *_] if name not in automata:
            pass
        case ["automata", name] | ["automata", name, "states" | "transitions"]:
            del automata[name]  # without them nothing can be said about its states
        case ["automata", name, "kind"]:
            automata[name]["kind"] = "plant"
        case ["automata", name, "initial"]:
            automata[name]["initial"] = "\0"
        case ["automata", name, "transitions", int(k)]:
            automata[name]["transitions"][k] = ""
        case ["automata", name, str(key), int(k)]:
            automata[name][key][k] = f"\0{k}"
        case [*_, key]:
            del _at(path[:-1], data)[key]
