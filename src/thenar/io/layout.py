"""How a model file is set: tables with few keys on one line, one transition a line."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

__all__ = ["Table", "Tables", "Value", "as_json", "as_toml"]

Value: TypeAlias = bool | int | str | Sequence["Value"] | Mapping[str, "Value"]
Table = Mapping[str, Value]

_LONGEST_LINE = 100  # characters up to which a list stays on one line
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class Tables:
    """What a model file holds."""

    heading: Table
    events: Mapping[str, Table]
    variables: Mapping[str, Table]
    automata: Mapping[str, Table]
    conditions: Sequence[Table]


def as_toml(tables: Tables) -> str:
    """Write ``tables`` as TOML.

    >>> print(as_toml(Tables({"name": "lamp"}, {"on!": {"controllable": False}}, {}, {}, [])))
    name = "lamp"
    <BLANKLINE>
    [events]
    "on!" = { controllable = false }
    <BLANKLINE>
    """
    blocks = [[f"{key} = {_toml(value)}" for key, value in tables.heading.items()]] if tables.heading else []
    for section, rows in (("events", tables.events), ("variables", tables.variables)):
        if rows or section == "events":
            blocks.append([f"[{section}]", *(f"{_key(name)} = {_toml(table)}" for name, table in rows.items())])
    titled = [(f"[automata.{_key(name)}]", table) for name, table in tables.automata.items()]
    for title, table in titled + [("[[conditions]]", table) for table in tables.conditions]:
        blocks.append([title, *(f"{key} = {_listing(key, value, _toml, ',')}" for key, value in table.items())])
    return "\n\n".join("\n".join(lines) for lines in blocks) + "\n"


def as_json(tables: Tables) -> str:
    """Write ``tables`` as JSON.

    >>> print(as_json(Tables({"name": "lamp"}, {"on!": {"controllable": False}}, {}, {}, [])))
    {
      "name": "lamp",
      "events": {
        "on!": {"controllable": false}
      },
      "automata": {}
    }
    <BLANKLINE>
    """

    def braces(members: Iterable[tuple[str, str]], indent: str) -> str:
        lines = [f"{indent}  {_text(key)}: {value}" for key, value in members]
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}" if lines else "{}"

    def spread(table: Table) -> str:
        return braces([(key, _listing(key, value, _json, "", "      ")) for key, value in table.items()], "    ")

    members = [(key, _json(value)) for key, value in tables.heading.items()]
    members.append(("events", braces([(name, _json(table)) for name, table in tables.events.items()], "  ")))
    if tables.variables:
        members.append(("variables", braces([(name, _json(table)) for name, table in tables.variables.items()], "  ")))
    members.append(("automata", braces([(name, spread(table)) for name, table in tables.automata.items()], "  ")))
    if tables.conditions:
        listed = ",\n".join(f"    {spread(table)}" for table in tables.conditions)
        members.append(("conditions", f"[\n{listed}\n  ]"))
    return braces(members, "") + "\n"


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    """Quote ``text`` for JSON and TOML alike: the two differ in the delete character only, which TOML escapes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _toml(value: Value) -> str:
    if isinstance(value, Mapping):
        members = ", ".join(f"{_key(key)} = {_toml(inner)}" for key, inner in value.items())
        return f"{{ {members} }}" if members else "{}"
    return _plain(value) if isinstance(value, bool | int | str) else f"[{', '.join(map(_toml, value))}]"


def _json(value: Value) -> str:
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_text(key)}: {_json(inner)}' for key, inner in value.items())}}}"
    return _plain(value) if isinstance(value, bool | int | str) else f"[{', '.join(map(_json, value))}]"


def _plain(value: bool | int | str) -> str:
    return _text(value) if isinstance(value, str) else str(value).lower()


def _listing(key: str, value: Value, write: Callable[[Value], str], last_comma: str, indent: str = "") -> str:
    """Write a list on one line if it is short, else, and for transitions, one entry a line."""
    if isinstance(value, bool | int | str | Mapping):
        return write(value)
    if key != "transitions" and len(line := write(value)) <= _LONGEST_LINE:
        return line
    entries = ",\n".join(f"{indent}  {write(entry)}" for entry in value)
    return f"[\n{entries}{last_comma}\n{indent}]"
