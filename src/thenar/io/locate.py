"""The line of a text on which a key, or an entry of a list, stands; asked only once something is wrong."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from tree_sitter import Language, Node, Parser

__all__ = ["Places"]

Step = str | int
_TABLES = ("inline_table", "object")
_HEADERS = ("table", "table_array_element")


@dataclass(slots=True)
class _Place:
    """A key or a list entry, the lines that give it, and what is inside."""

    line: int
    given: list[int] = field(default_factory=list)
    inside: dict[Step, _Place] = field(default_factory=dict)
    unread: Node | None = None  # the value, until someone asks what is inside: most lists are never asked
    tables: int = 0  # of a list that is written as [[tables]]: how many so far


class Places:
    """The lines of everything that a TOML or JSON text gives.

    >>> places = Places('name = "lamp"\\n[automata.LAMP]\\nmarked = [\\n  "off",\\n  "lit",\\n]', "toml")
    >>> places.line(("automata", "LAMP", "marked", 1))
    5
    >>> places.line(("automata", "LAMP", "initial"))  # not there: its table is
    2
    >>> Places("[[conditions]]\\n[[conditions]]\\nneeds = 'x'", "toml").line(("conditions", 1, "needs"))
    3
    """

    def __init__(self, text: str, format: str) -> None:
        self._format = format
        self._root = _Place(1)
        root = Parser(_grammar(format)).parse(text.encode("utf-8", "replace")).root_node
        if format == "json":
            self._root.unread = next((n for n in root.named_children if n.type == "object"), None)
        for node in root.named_children:
            if node.type == "pair":
                self._put(self._root, node)
            elif node.type in _HEADERS:
                key, *pairs = _without_comments(node)
                table = self._descend(self._root, key, _line(node))
                if node.type == "table":
                    table.given.append(_line(node))
                else:
                    place = table.inside[table.tables] = _Place(_line(node))
                    table.tables += 1
                    table = place
                for pair in pairs:
                    if pair.type == "pair":
                        self._put(table, pair)

    def line(self, path: Sequence[Step]) -> int:
        """Return the line (from 1) of ``path``, or of its nearest ancestor that the text gives."""
        place = self._root
        for step in path:
            self._read(place)
            if step not in place.inside:
                break
            place = place.inside[step]
        return place.line

    def repeated(self) -> Iterator[tuple[tuple[Step, ...], list[int]]]:
        """Yield each key that is given more than once, with the lines that give it; nothing inside those."""
        todo: list[tuple[tuple[Step, ...], _Place]] = [((), self._root)]
        while todo:
            path, place = todo.pop()
            self._read(place)
            if len(place.given) > 1:
                yield path, place.given
            else:
                todo += [((*path, step), child) for step, child in place.inside.items()]

    def _read(self, place: _Place) -> None:
        """Look into the value of ``place``."""
        value, place.unread = place.unread, None
        if value is None:
            return
        children = _without_comments(value)
        if value.type in _TABLES:
            for pair in children:
                if pair.type == "pair":
                    self._put(place, pair)
        elif value.type == "array":
            place.inside = {k: _Place(_line(child), unread=child) for k, child in enumerate(children)}
        elif value.start_point.row < value.end_point.row:  # a text that holds an entry a line
            written = [row for row, text in enumerate((value.text or b"").split(b"\n")) if text.strip(b"\"' \t\r")]
            place.inside = {k: _Place(_line(value) + row) for k, row in enumerate(written)}

    def _put(self, owner: _Place, pair: Node) -> None:
        """Enter a key and its value below ``owner``."""
        key, *value = _without_comments(pair)
        place = self._descend(owner, key, _line(pair))
        place.given.append(_line(pair))
        place.unread = value[0] if value else None

    def _descend(self, owner: _Place, key: Node, line: int) -> _Place:
        for step in self._steps(key):
            if owner.tables:  # what follows [[tables]] is inside the last one
                owner = owner.inside[owner.tables - 1]
            self._read(owner)
            owner = owner.inside.setdefault(step, _Place(line))
        return owner

    def _steps(self, key: Node) -> list[str]:
        """Return the names in a key, which in TOML may be dotted and quoted."""
        text = (key.text or b"").decode()
        if self._format == "json":
            return [str(json.loads(text))]
        steps = []
        try:
            inner: Any = tomllib.loads(f"{text} = 0")
        except tomllib.TOMLDecodeError:  # the text has an error here too, and its parser reports that
            return [text]
        while isinstance(inner, dict):
            if len(inner) != 1:  # what was taken for a key, at an error, is more
                return [text]
            [(step, inner)] = inner.items()
            steps.append(step)
        return steps


def _grammar(format: str) -> Language:
    if format == "json":
        import tree_sitter_json

        return Language(tree_sitter_json.language())
    import tree_sitter_toml

    return Language(tree_sitter_toml.language())


def _without_comments(node: Node) -> list[Node]:
    return [child for child in node.named_children if child.type != "comment"]


def _line(node: Node) -> int:
    return node.start_point.row + 1
