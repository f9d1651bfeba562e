"""The check against the schema: all that breaks it, in plain sentences, and the rest made ready to be read."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from thenar.errors import Mistake
from thenar.io.parse import Document, Format
from thenar.io.schema import (
    AutomatonTable,
    ConditionTable,
    EventTable,
    ModelFile,
    TransitionTable,
    VariableTable,
)
from thenar.model.build import Complaint, KeyPath

__all__ = ["Checked", "check"]

_MISSING: dict[str | int, str] = {
    "kind": "no kind; say whether it is a 'plant' or a 'spec'",
    "initial": "no initial state; say which state the automaton starts in",
    "values": 'no values; write values = "0..5", "bool" or a list of names',
    "arrow": "no arrow; write arrow = 'state -event-> state'",
}
_TRANSITION = "'state -event-> state' or ['state', 'event', 'state']"
_VALUES = "'lowest..highest', 'bool' or a list of values"
_EXPECTED = {
    "string_type": "text",
    "string_too_short": "a name",
    "bool_type": "true or false",
    "list_type": "a list",
    "literal_error": "'plant' or 'spec'",
    "too_short": "at least one state",
}
_TABLES: dict[str, type[BaseModel]] = {
    "events": EventTable,
    "variables": VariableTable,
    "automata": AutomatonTable,
    "conditions": ConditionTable,
}
_LISTS = ("marked", "states", "transitions")  # of an automaton; a list, or a text with an entry a line
_TABLE = {"toml": "a table", "json": "an object in braces"}
_LONGEST_SHOWN = 40  # characters of a value that a message repeats


@dataclass(slots=True)
class Checked:
    """A document as the schema sees it, and all that is wrong with it."""

    document: Document
    file: ModelFile = field(default_factory=ModelFile)
    complaints: list[Complaint] = field(default_factory=list)
    broken: set[KeyPath] = field(default_factory=set)  # what breaks the schema
    written: dict[KeyPath, str | int] = field(default_factory=dict)  # how a misspelt key stands in the text

    def complain(self, path: KeyPath, what: str) -> None:
        """Note that ``path`` makes no sense, unless it breaks the schema already."""
        if path not in self.broken:
            self.complaints.append((path, what))

    def mistakes(self) -> list[Mistake]:
        """Return the complaints with their lines, in the order of the text."""
        return self.document.mistakes(self.complaints, self.written)


def check(document: Document, data: Any) -> Checked:
    """Return what ``data``, the content of ``document``, says, and everything in it that breaks the schema.

    All mistakes of a file are to be found at once, those of meaning too.  So ``data`` is mended (in place):
    a key close to a known one is taken for it, a wrong value gives way to a neutral one.  A broken file is
    then good for looking for more mistakes, and for nothing else.

    >>> hand = Document("hand.toml", "toml", "events.slip.controlable = false")
    >>> checked = check(hand, hand.data())
    >>> checked.complaints
    [(('events', 'slip', 'controlable'), "unknown key; did you mean 'controllable'?")]
    >>> checked.file.events["slip"].controllable
    False
    """
    checked = Checked(document)
    if not isinstance(data, dict):
        found = _in_words(data, document.format)
        checked.complain((), f"expected {_TABLE[document.format]} with events and automata, found {found}")
        checked.broken.add(())
        return checked
    while True:
        try:
            checked.file = ModelFile.model_validate(data)
            return checked
        except ValidationError as error:
            details = {_culprit(detail): detail["type"] for detail in error.errors(include_url=False)}
        unknown = [path for path, kind in details.items() if kind == "extra_forbidden"]
        for path in unknown:
            checked.complain(path, _unknown_key(path, data, document.format))
            _rename(path, data, checked.written)
        missing = [path for path, kind in details.items() if kind == "missing" and path not in checked.written]
        for path in missing:
            if path[-1] != "values" or not any(other[:-1] == path[:-1] for other in unknown):  # a.b = { values ...
                checked.complain(path[:-1], _MISSING[path[-1]])
        wrong = [path for path, kind in details.items() if kind not in ("extra_forbidden", "missing")]
        for path in wrong:
            checked.complain(path, _sentence(path, details[path], data, document.format))
        for path in missing + wrong:
            _mend(path, data)
        checked.broken.update(unknown, missing, wrong)
        checked.broken.update(path[:-1] for path in missing + wrong if path[-1] == "arrow")


def _culprit(detail: ErrorDetails) -> KeyPath:
    """Return the path of the smallest thing that makes sense as a whole: a transition, a size, a key."""
    loc = detail["loc"]
    if loc[:1] == ("automata",) and loc[2:3] and loc[2] in _LISTS and loc[3:4] and loc[3] in ("one", "list"):
        loc = loc[:3] + loc[4:]  # which of two shapes it has
    match loc:
        case ["computed" | "published", _, *_] as path:
            return path[:2]
        case ["automata", _, "transitions", int(), "table", "do", str(), *_] as path:
            return path[:4] + path[5:7]
        case ["automata", _, "transitions", int(), "table", _, *_] as path:
            return path[:4] + path[5:6]
        case ["automata", _, "transitions", int(), *_] as path:
            return path[:4]
        case ["automata" | "variables", _, "initial" | "values" | "marked", *inner] as path:  # one of several shapes
            return path[:3] + tuple(step for step in inner if isinstance(step, int))[:1]
        case path:
            return path


def _at(path: KeyPath, data: Any) -> Any:
    """Return the value at ``path``, or None where there is none."""
    for step in path:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            return None
    return data


# -- sentences ---------------------------------------------------------------------------------------------


def _sentence(path: KeyPath, kind: str, data: Any, format: Format) -> str:
    value = _at(path, data)
    found = _in_words(value, format)
    if path[0] in ("computed", "published") and len(path) == 2:
        return f"expected [states, transitions], two whole numbers, found {found}"
    match path:
        case ["automata", _, "transitions", int()] | ["automata", _, "transitions", int(), "arrow"]:
            expected = _TRANSITION
        case ["automata", _, "transitions", int(), "do", _]:
            expected = "a value or an expression"
            if isinstance(value, dict):
                found += "; a name with a dot stands in double quotes"
        case ["automata", _, "marked" | "states" | "transitions"] if not isinstance(value, str):
            expected = "a list"
        case ["variables", _, "values"]:
            expected = _VALUES
        case ["variables", _, "initial" | "marked"]:
            expected = "a value or a list of values"
        case ["variables", _, "values" | "initial" | "marked", int()]:
            expected = "a whole number, true, false or a name"
        case _:
            expected = _EXPECTED.get(kind, _TABLE[format])
    if expected == "a list" and isinstance(value, str):
        found += f"; write [{json.dumps(value, ensure_ascii=False)}]"
    return f"expected {expected}, found {found}"


def _unknown_key(path: KeyPath, data: Any, format: Format) -> str:
    owner, keys = path[:-1], _keys(path)
    if near := get_close_matches(str(path[-1]), keys, n=1):
        return f"unknown key; did you mean {near[0]!r}?"
    if format == "toml" and owner and path[-1] in _keys(()):
        return f"unknown key; {path[-1]!r} is said of the whole file, above the first [table]"
    if format == "toml" and len(owner) == 2 and owner[0] != "conditions" and isinstance(_at(path, data), dict):
        # [automata.SPEC.1] and re.align = {} are tables in tables, which is rarely what was meant
        return f'unknown key; a name with a dot stands in double quotes: "{owner[-1]}.{path[-1]}"'
    return f"unknown key; the keys here are {', '.join(keys)}"


def _keys(path: KeyPath) -> list[str]:
    """Return the keys that the schema has beside ``path``."""
    table: type[BaseModel]
    match path:
        case ["automata", _, "transitions", _, _]:
            table = TransitionTable
        case [str(section), _, _]:
            table = _TABLES[section]
        case _:
            table = ModelFile
    return [field.alias or key for key, field in table.model_fields.items()]


def _in_words(value: Any, format: Format) -> str:
    if isinstance(value, dict):
        return _TABLE[format]
    if isinstance(value, list):
        if len(value) > 3 or any(isinstance(item, list | dict) for item in value):
            return f"a list of {len(value)}"
        items = [json.dumps(x, ensure_ascii=False) if isinstance(x, str) else _in_words(x, format) for x in value]
        text = f"[{', '.join(items)}]"
        return text if len(text) <= _LONGEST_SHOWN else f"a list of {len(value)}"
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    if isinstance(value, str):
        return f"the text {value!r}" if len(value) <= _LONGEST_SHOWN else "a long text"
    if isinstance(value, int | float):
        return "a long number" if abs(value) >= 1e15 else f"{value}"
    return "a date or time"


# -- mending -----------------------------------------------------------------------------------------------


def _rename(path: KeyPath, data: Any, written: dict[KeyPath, str | int]) -> None:
    """Take an unknown key for the known one that it is close to, if that is still free; else drop it."""
    owner = _at(path[:-1], data)
    value = owner.pop(path[-1])
    near = get_close_matches(str(path[-1]), _keys(path), n=1)
    if near and near[0] not in owner:
        owner[near[0]] = value
        written[(*path[:-1], near[0])] = path[-1]


def _mend(path: KeyPath, data: Any) -> None:
    """Put something neutral in the place of a wrong value: it causes no complaint that is not there already."""
    automata = data.get("automata")
    match path:
        case ["events", name, *_]:
            data["events"][name] = {}
        case ["variables", name, *_]:
            data["variables"].pop(name, None)
        case ["conditions", int(k), *_]:
            data["conditions"][k] = {"kind": "spec", "invariant": "true"}
        case ["automata", name, *_] if name not in automata:
            pass
        case ["automata", name] | ["automata", name, "states" | "transitions"]:
            del automata[name]  # without them nothing can be said about its states
        case ["automata", name, "kind"]:
            automata[name]["kind"] = "plant"
        case ["automata", name, "initial"]:
            automata[name]["initial"] = "\0"
        case ["automata", name, "transitions", int(k)] | ["automata", name, "transitions", int(k), "arrow"]:
            wrong = automata[name]["transitions"][k]
            wrong = wrong.get("arrow") if isinstance(wrong, dict) else wrong
            words = [word for word in wrong if isinstance(word, str)] if isinstance(wrong, list) else []
            automata[name]["transitions"][k] = " ".join(words)  # the states in it are no others' mistakes
        case ["automata", name, "transitions", int(k), "when"]:
            if isinstance(automata[name]["transitions"][k], dict):
                automata[name]["transitions"][k]["when"] = "\0"  # it has a guard all the same
        case ["automata", name, "transitions", int(k), "do", *inner]:
            if isinstance(transition := automata[name]["transitions"][k], dict):
                transition["do"] = {v: x for v, x in transition["do"].items() if v not in inner} if inner else {}
        case ["automata", name, str(key), int(k)]:
            automata[name][key][k] = f"\0{k}"
        case [*_, key]:
            del _at(path[:-1], data)[key]
