"""How a model file is set: tables with few keys on one line, one transition a line."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

__all__ = ["Lines", "Table", "Tables", "Value", "as_json", "as_toml"]


@dataclass(frozen=True, slots=True)
class Lines:
    """A text of very many lines, made piece by piece; what stands in a line can be printed."""

    pieces: Iterable[str]


Value: TypeAlias = bool | int | str | Sequence["Value"] | Mapping[str, "Value"] | Lines
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


def as_toml(tables: Tables) -> Iterator[str]:
    """Write ``tables`` as TOML, piece by piece.

    >>> print("".join(as_toml(Tables({"name": "lamp"}, {"on!": {"controllable": False}}, {}, {}, []))))
    name = "lamp"
    <BLANKLINE>
    [events]
    "on!" = { controllable = false }
    <BLANKLINE>
    """
    yield "".join(f"{key} = {_toml(value)}\n" for key, value in tables.heading.items())
    gap = "\n" * bool(tables.heading)
    for section, rows in (("events", tables.events), ("variables", tables.variables)):
        if rows or section == "events":
            yield f"{gap}[{section}]\n"
            yield "".join(f"{_key(name)} = {_toml(table)}\n" for name, table in rows.items())
            gap = "\n"
    titled = [(f"[automata.{_key(name)}]", table) for name, table in tables.automata.items()]
    for title, table in titled + [("[[conditions]]", table) for table in tables.conditions]:
        yield f"\n{title}\n"
        for key, value in table.items():
            if isinstance(value, Lines):
                yield f"{key} = '''\n"
                yield from value.pieces
                yield "'''\n"
            else:
                yield f"{key} = {_listing(key, value, _toml, ',')}\n"


def as_json(tables: Tables) -> Iterator[str]:
    """Write ``tables`` as JSON, piece by piece.

    >>> print("".join(as_json(Tables({"name": "lamp"}, {"on!": {"controllable": False}}, {}, {}, []))))
    {
      "name": "lamp",
      "events": {
        "on!": {"controllable": false}
      },
      "automata": {}
    }
    <BLANKLINE>
    """

    def braces(members: Iterable[tuple[str, Iterable[str]]], indent: str) -> Iterator[str]:
        opening = "{\n"
        for key, value in members:
            yield f"{opening}{indent}  {_text(key)}: "
            yield from value
            opening = ",\n"
        yield f"\n{indent}}}" if opening == ",\n" else "{}"

    def written(key: str, value: Value) -> Iterable[str]:
        if isinstance(value, Lines):
            return _quoted(map(_escaped, value.pieces))
        return (_listing(key, value, _json, "", "      "),)

    def spread(table: Table) -> Iterator[str]:
        return braces(((key, written(key, value)) for key, value in table.items()), "    ")

    def rows(tables: Mapping[str, Table]) -> Iterator[str]:
        return braces(((name, (_json(table),)) for name, table in tables.items()), "  ")

    def listed(tables: Sequence[Table]) -> Iterator[str]:
        for k, table in enumerate(tables):
            yield ",\n    " if k else "[\n    "
            yield from spread(table)
        yield "\n  ]"

    members: list[tuple[str, Iterable[str]]] = [(key, (_json(value),)) for key, value in tables.heading.items()]
    members.append(("events", rows(tables.events)))
    if tables.variables:
        members.append(("variables", rows(tables.variables)))
    members.append(("automata", braces(((name, spread(table)) for name, table in tables.automata.items()), "  ")))
    if tables.conditions:
        members.append(("conditions", listed(tables.conditions)))
    yield from braces(members, "")
    yield "\n"


def _escaped(piece: str) -> str:
    """Escape what JSON has to, in a text of printable lines; many times quicker than the encoder."""
    return piece.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")


def _quoted(pieces: Iterable[str]) -> Iterator[str]:
    yield '"'
    yield from pieces
    yield '"'


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    """Quote ``text`` for JSON and TOML alike: the two differ in the delete character only, which TOML escapes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _toml(value: Value) -> str:
    assert not isinstance(value, Lines)  # they stand in automata only, and are written there
    if isinstance(value, Mapping):
        members = ", ".join(f"{_key(key)} = {_toml(inner)}" for key, inner in value.items())
        return f"{{ {members} }}" if members else "{}"
    return _plain(value) if isinstance(value, bool | int | str) else f"[{', '.join(map(_toml, value))}]"


def _json(value: Value) -> str:
    assert not isinstance(value, Lines)
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_text(key)}: {_json(inner)}' for key, inner in value.items())}}}"
    return _plain(value) if isinstance(value, bool | int | str) else f"[{', '.join(map(_json, value))}]"


def _plain(value: bool | int | str) -> str:
    return _text(value) if isinstance(value, str) else str(value).lower()


def _listing(key: str, value: Value, write: Callable[[Value], str], last_comma: str, indent: str = "") -> str:
    """Write a list on one line if it is short, else, and for transitions, one entry a line."""
    if isinstance(value, bool | int | str | Mapping | Lines):
        return write(value)
    if key != "transitions" and len(line := write(value)) <= _LONGEST_LINE:
        return line
    entries = ",\n".join(f"{indent}  {write(entry)}" for entry in value)
    return f"[\n{entries}{last_comma}\n{indent}]"
