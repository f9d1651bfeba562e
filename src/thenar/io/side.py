"""The table beside a file: what the file's format has no words for, written with it and read with it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from thenar.errors import InputError
from thenar.io.files import read_bytes
from thenar.io.foreign.assemble import assembled, columns
from thenar.io.foreign.written import Names
from thenar.io.parse import Document, decode
from thenar.model.events import Alphabet, Event

if TYPE_CHECKING:
    from thenar.model.automaton import Automaton
    from thenar.model.extended import ExtendedAutomaton

__all__ = ["ENDING", "table_of", "with_table"]

ENDING = ".names.json"  # MACH1.DES has its table in MACH1.DES.names.json
_FLAGS = ("controllable", "observable", "forcible")


def table_of(automaton: Automaton | ExtendedAutomaton, kind: str, names: Names | None) -> str:
    """Return the text of the table beside the file of ``automaton``, a plant or a specification.

    >>> from thenar.model.automaton import Automaton
    >>> lamp = Automaton.from_transitions(["dark -on-> lit"], initial="dark", name="LAMP")
    >>> print(table_of(lamp, "spec", None), end="")
    {
      "kind": "spec",
      "name": "LAMP"
    }
    """
    table: dict[str, Any] = {"kind": kind, "name": automaton.name}
    if automaton.meaning:
        table["says"] = automaton.meaning
    if names is not None:
        table["events"] = {label: _event_table(event) for label, event in names.events}
        table["states"] = list(names.states)
    return json.dumps(table, ensure_ascii=False, indent=2) + "\n"


def with_table(
    path: Path | None, automaton: Automaton | ExtendedAutomaton, kind: str
) -> tuple[str, Automaton | ExtendedAutomaton]:
    """Return what the automaton in the file ``path`` is, and the automaton with the names of the table beside it.

    Without a table, that is ``kind`` and ``automaton`` as they are.  Raises InputError for a table that does not fit.
    """
    if path is None or not (beside := path.with_name(path.name + ENDING)).is_file():
        return kind, automaton
    source = str(beside)
    table = Document(source, "json", decode(read_bytes(beside), source)).data()
    try:
        said, name, meaning = table.get("kind", kind), table.get("name", automaton.name), table.get("says", "")
        if said not in ("plant", "spec") or not isinstance(name, str) or not isinstance(meaning, str):
            raise TypeError("kind, name or says")
        labels = table.get("events")
        states = table.get("states")
        events = None if labels is None else [(str(label), _event(value)) for label, value in labels.items()]
        Alphabet(event for _, event in events or ())
        if states is not None and not all(isinstance(state, str) for state in states):
            raise TypeError("states")
    except (AttributeError, TypeError, KeyError, InputError) as error:
        raise InputError(f"{source}: no table of names: {error}; {_way_out(path)}") from None
    return said, _renamed(automaton, name, meaning, events, states, path, source)


def _event_table(event: Event) -> dict[str, Any]:
    table: dict[str, Any] = {"name": event.name}
    table |= {flag: getattr(event, flag) for flag in _FLAGS}
    return table | ({"meaning": event.meaning} if event.meaning else {})


def _event(table: dict[str, Any]) -> Event:
    flags = {flag: table[flag] for flag in _FLAGS if flag in table}
    if not all(isinstance(flag, bool) for flag in flags.values()):
        raise TypeError("events")
    return Event(str(table["name"]), **flags, meaning=str(table.get("meaning", "")))


def _renamed(
    automaton: Automaton | ExtendedAutomaton,
    name: str,
    meaning: str,
    events: list[tuple[str, Event]] | None,
    states: list[str] | None,
    path: Path,
    source: str,
) -> Automaton | ExtendedAutomaton:
    """Return ``automaton`` with other names: states of the file that are not named are dropped."""
    n = len(automaton.marked)
    labels = [(e.name, e) for e in automaton.alphabet] if events is None else events
    place = {label: k for k, (label, _) in enumerate(labels)}
    strange = [e.name for e in automaton.alphabet if e.name not in place]
    if strange or (states is not None and len(states) > n):
        what = f"has no event {strange[0]!r}" if strange else f"names {len(states or ())} states, the file has {n}"
        raise InputError(f"{source}: {what}; {_way_out(path)}")
    s, e, t = columns(automaton)
    named = n if states is None else len(states)
    kept = (s < named) & (t < named)
    initial = [automaton.initial] if isinstance(automaton.initial, int) else np.flatnonzero(automaton.initial).tolist()
    if any(q >= named for q in initial):
        raise InputError(f"{source}: does not name the initial state; {_way_out(path)}")
    renumbered = np.array([place[event.name] for event in automaton.alphabet], np.int64)
    return assembled(
        name,
        Alphabet(event for _, event in labels),
        [automaton.states[q] for q in range(n)] if states is None else states,
        [q for q in initial if q >= 0],
        np.asarray(automaton.marked)[:named],
        s[kept],
        renumbered[e[kept]],
        t[kept],
        meaning=meaning,
        where=source,
    )


def _way_out(path: Path) -> str:
    return f"{path.name} and its table belong together: write both again, or delete the table"
