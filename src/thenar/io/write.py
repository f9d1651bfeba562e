"""From a problem to a model file that people read: arrow notation, one transition a line."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

from thenar.errors import InputError
from thenar.io.files import atomic_write
from thenar.io.parse import format_by_ending, format_by_name
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.problem import Problem

__all__ = ["dumps", "save"]

Value = bool | str | list[str] | list[list[str]]  # of a key; a triple is a list of three texts
Table = Mapping[str, Value]

_LONGEST_LINE = 100  # characters up to which a list stays on one line
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def dumps(model: Problem | Automaton, format: str = "toml") -> str:
    """Return the text of the model file that says what ``model`` says; an automaton alone is taken as a plant.

    :func:`loads` gives it back with its events, states and transitions in the same order.  One thing a model
    file cannot say: each automaton's alphabet is ordered as that of the problem.

    Raises InputError for what the format has no words for: an automaton without states, two automata or two
    states of one name, a state without a name, and a ``format`` other than "toml" and "json".

    >>> lamp = Automaton.from_transitions(["off -on!-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> print(dumps(lamp))
    [events]
    "on!" = {}
    off = {}
    <BLANKLINE>
    [automata.LAMP]
    kind = "plant"
    initial = "off"
    marked = ["off"]
    transitions = [
      "off -on!-> lit",
      "lit -off-> off",
    ]
    <BLANKLINE>
    """
    problem = model if isinstance(model, Problem) else Problem(model)
    write = _toml if format_by_name(format) == "toml" else _json
    kinds = [("plant", a) for a in problem.plants] + [("spec", a) for a in problem.specs]
    automata = {a.name: _automaton_table(a, kind) for kind, a in kinds}
    if len(automata) < len(kinds):  # named ones differ, a Problem sees to that
        raise InputError("two automata have no name; a model file tells automata by their names")
    heading = {"name": problem.name, "description": problem.description}
    events = {event.name: _event_table(event) for event in problem.alphabet}
    text = write({key: value for key, value in heading.items() if value}, events, automata)
    try:
        text.encode()
    except UnicodeEncodeError as error:
        wrong = text[error.start : error.end]
        raise InputError(f"a name has the character {wrong!r}, which UTF-8 does not have; rename it") from None
    return text


def save(problem: Problem | Automaton, path: str | os.PathLike[str]) -> None:
    """Write ``problem`` to the file ``path``, TOML or JSON by its ending; all or nothing.

    Raises InputError as :func:`dumps` does, for another ending, and where the system does not let us write.

    >>> import tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp(), "lamp.json")
    >>> save(Automaton.from_transitions(["dark -on-> lit"], initial="dark", name="LAMP"), file)
    >>> file.read_text().splitlines()[2]
    '    "on": {}'
    """
    atomic_write(path, dumps(problem, format_by_ending(path)))


def _event_table(event: Event) -> Table:
    """Return what is not as in most events."""
    table: dict[str, Value] = {}
    if not event.controllable:
        table["controllable"] = False
    if not event.observable:
        table["observable"] = False
    if event.forcible:
        table["forcible"] = True
    if event.meaning:
        table["meaning"] = event.meaning
    return table


def _automaton_table(automaton: Automaton, kind: str) -> Table:
    owner = f"automaton {automaton.name!r}" if automaton.name else "the automaton"
    if automaton.is_empty:
        raise InputError(f"{owner} has no states, and a model file needs an initial one; there is nothing to write")
    states = [automaton.states[q] for q in range(automaton.n_states)]
    if not all(states):
        raise InputError(f"{owner}: state {states.index('')} has an empty name; a model file needs one")
    if len(set(states)) < len(states):
        twice = next(q for q, times in Counter(states).items() if times > 1)
        raise InputError(f"{owner}: two states are called {twice!r}; a model file tells states by their names")
    triples = list(automaton.transitions())
    carried = {event for _, event, _ in triples}
    table: dict[str, Value] = {"kind": kind}
    if automaton.meaning:
        table["says"] = automaton.meaning
    table["initial"] = states[automaton.initial]
    if automaton.marked.any():
        table["marked"] = [states[q] for q in automaton.marked.nonzero()[0].tolist()]
    if states != list(dict.fromkeys([states[automaton.initial], *(q for s, _, t in triples for q in (s, t))])):
        table["states"] = states
    if blocked := [event.name for event in automaton.alphabet if event.name not in carried]:
        table["alphabet"] = blocked
    if triples:
        arrows = all(_fits_arrow(state) for state in states)
        table["transitions"] = [f"{s} -{e}-> {t}" for s, e, t in triples] if arrows else [list(t) for t in triples]
    return table


def _fits_arrow(state: str) -> bool:
    return state == state.strip() and "->" not in state


def _toml(heading: Table, events: Mapping[str, Table], automata: Mapping[str, Table]) -> str:
    blocks = [[f"{key} = {_value(value)}" for key, value in heading.items()]] if heading else []
    blocks.append(
        ["[events]", *(f"{_key(name)} = {_braces(table, _key, ' = ', ' ')}" for name, table in events.items())]
    )
    for name, table in automata.items():
        lines = [f"{key} = {_listing(key, value, ',')}" for key, value in table.items()]
        blocks.append([f"[automata.{_key(name)}]", *lines])
    return "\n\n".join("\n".join(lines) for lines in blocks) + "\n"


def _json(heading: Table, events: Mapping[str, Table], automata: Mapping[str, Table]) -> str:
    def braces(members: Iterable[tuple[str, str]], indent: str) -> str:
        lines = [f"{indent}  {_text(key)}: {value}" for key, value in members]
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}" if lines else "{}"

    written_events = [(name, _braces(table, _text, ": ", "")) for name, table in events.items()]
    written_automata = [
        (name, braces([(key, _listing(key, value, "", "      ")) for key, value in table.items()], "    "))
        for name, table in automata.items()
    ]
    members = [(key, _value(value)) for key, value in heading.items()]
    members += [("events", braces(written_events, "  ")), ("automata", braces(written_automata, "  "))]
    return braces(members, "") + "\n"


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    """Quote ``text`` for JSON and TOML alike: the two differ in the delete character only, which TOML escapes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Value | Sequence[str]) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    return f"[{', '.join(map(_value, value))}]"


def _braces(table: Table, key: Callable[[str], str], equals: str, margin: str) -> str:
    members = ", ".join(f"{key(name)}{equals}{_value(value)}" for name, value in table.items())
    return f"{{{margin}{members}{margin}}}" if members else "{}"


def _listing(key: str, value: Value, last_comma: str, indent: str = "") -> str:
    """Write a list on one line if it is short, else, and for transitions, one entry a line."""
    line = _value(value)
    if not isinstance(value, list) or (key != "transitions" and len(line) <= _LONGEST_LINE):
        return line
    entries = ",\n".join(f"{indent}  {_value(entry)}" for entry in value)
    return f"[\n{entries}{last_comma}\n{indent}]"
