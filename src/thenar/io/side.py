"""The table beside a file: what the file's format has no words for, written with it and read with it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from thenar.errors import InputError
from thenar.io.files import read_bytes
from thenar.io.foreign.assemble import assembled, columns
from thenar.io.foreign.written import Names, ProblemNames
from thenar.io.parse import Document, decode
from thenar.model.events import Alphabet, Event

if TYPE_CHECKING:
    from thenar.io.side_schema import NamedEvent
    from thenar.model.automaton import Automaton
    from thenar.model.extended import ExtendedAutomaton, ExtendedProblem
    from thenar.model.problem import Problem

__all__ = ["ENDING", "known_labels", "problem_table", "table_of", "with_problem_table", "with_table"]

ENDING = ".names.json"  # MACH1.DES has its table in MACH1.DES.names.json


def table_of(automaton: Automaton | ExtendedAutomaton, kind: str, names: Names | None) -> str:
    """Return the text of the table beside the file of ``automaton``, a plant or a specification.

    >>> from thenar.model.automaton import Automaton
    >>> lamp = Automaton.from_transitions(["dark -on-> lit"], initial="dark", name="LAMP")
    >>> print(table_of(lamp, "spec", None), end="")
    {
      "kind": "spec",
      "name": "LAMP",
      "size": [
        2,
        1
      ]
    }
    """
    table: dict[str, Any] = {"kind": kind} if kind == "spec" else {}
    table |= {"name": automaton.name, "size": [len(automaton.marked), len(columns(automaton)[0])]}
    if automaton.meaning:
        table["says"] = automaton.meaning
    if names is not None:
        table |= {"added": names.added} if names.added else {}
        table["events"] = {label: _event_table(event) for label, event in names.events}
        table["states"] = list(names.states)
    return _text(table)


def problem_table(names: ProblemNames) -> str:
    """Return the text of the table beside the file of a problem; names that the file has itself are left out."""
    automata: dict[str, dict[str, Any]] = {}
    for label, name, meaning, states in names.automata:
        automata[label] = {"name": name} | ({"says": meaning} if meaning else {})
        if changed := {a: b for a, b in states if a != b}:
            automata[label]["states"] = changed
    table: dict[str, Any] = {"name": names.name, "description": names.description}
    table |= {"events": {label: _event_table(event) for label, event in names.events}, "automata": automata}
    table |= {"variables": _changed(names.variables), "literals": _changed(names.literals)}
    return _text({key: value for key, value in table.items() if value or key in ("events", "automata")})


def with_table(
    path: Path | None, automaton: Automaton | ExtendedAutomaton, kind: str
) -> tuple[str, Automaton | ExtendedAutomaton]:
    """Return what the automaton in the file ``path`` is, and the automaton with the names of the table beside it.

    Without a table, that is ``kind`` and ``automaton`` as they are; what is said to be a specification, is one.
    Raises InputError for a table that does not fit.
    """
    if path is None or not (beside := path.with_name(path.name + ENDING)).is_file():
        return kind, automaton
    from thenar.io.side_schema import AutomatonNames

    with _fitting(path, beside):
        table = AutomatonNames.model_validate(_content(beside))
        events = None if table.events is None else [(label, _event(e)) for label, e in table.events.items()]
        if len(automaton.marked) != table.size[0] + table.added:
            raise InputError(f"is of {table.size[0] + table.added} states, and the file has {len(automaton.marked)}")
        if table.states is not None and len(table.states) != table.size[0]:
            raise InputError(f"is of {table.size[0]} states, and names {len(table.states)}")
        found = _renamed(automaton, table.name, table.says, events, table.states)
        if len(columns(found)[0]) != table.size[1]:
            raise InputError(f"is of {table.size[1]} transitions, and the file has {len(columns(found)[0])}")
        return "spec" if kind == "spec" else table.kind, found


def known_labels(folder: Path, ending: str) -> dict[str, int]:
    """Return the numbers by which the files with ``ending`` in ``folder`` call events, as far as their tables agree."""
    labels: dict[str, int] = {}
    for beside in sorted(folder.glob(f"*{ending}{ENDING}")):
        try:
            events = _content(beside)["events"]
            told = {str(event["name"]): int(label) for label, event in events.items()}
        except (InputError, AttributeError, KeyError, TypeError, ValueError):
            continue  # a table that cannot be read is told of when its file is
        taken = {label: name for name, label in labels.items()}
        if all(labels.get(n, k) == k and taken.get(k, n) == n for n, k in told.items()):
            labels |= told
    return labels


def with_problem_table(path: Path | None, problem: Problem | ExtendedProblem) -> Problem | ExtendedProblem:
    """Return the problem of the file ``path`` with the names of the table beside it, if there is one."""
    if path is None or not (beside := path.with_name(path.name + ENDING)).is_file():
        return problem
    from thenar.io.rename import renamed
    from thenar.io.side_schema import ProblemTable

    with _fitting(path, beside):
        table = ProblemTable.model_validate(_content(beside))
        names = ProblemNames(
            table.name,
            table.description,
            tuple((label, _event(e)) for label, e in table.events.items()),
            tuple((label, a.name, a.says, tuple(a.states.items())) for label, a in table.automata.items()),
            tuple(table.variables.items()),
            tuple(table.literals.items()),
        )
        return renamed(problem, names)


@contextmanager
def _fitting(path: Path, beside: Path) -> Iterator[None]:
    """Turn what is wrong with a table into one message, with the way out."""
    from pydantic import ValidationError

    try:
        yield
    except (ValidationError, InputError) as error:
        if isinstance(error, ValidationError):
            first = error.errors(include_url=False)[0]
            what = f"{'.'.join(map(str, first['loc'])) or 'the table'}: {first['msg'].lower()}"
        else:
            what = str(error).removeprefix(f"{beside}: ")
        way_out = f"{path.name} and its table belong together: write both again, or delete the table"
        raise InputError(f"{beside}: {what}; {way_out}") from None


def _content(beside: Path) -> Any:
    return Document(str(beside), "json", decode(read_bytes(beside), str(beside))).data()


def _text(table: dict[str, Any]) -> str:
    return json.dumps(table, ensure_ascii=False, indent=2) + "\n"


def _changed(pairs: tuple[tuple[str, str], ...]) -> dict[str, str]:
    return {label: name for label, name in pairs if label != name}


def _event_table(event: Event) -> dict[str, Any]:
    table: dict[str, Any] = {"name": event.name, "controllable": event.controllable, "observable": event.observable}
    table["forcible"] = event.forcible
    return table | ({"meaning": event.meaning} if event.meaning else {})


def _event(table: NamedEvent) -> Event:
    return Event(table.name, table.controllable, table.observable, table.forcible, table.meaning)


def _renamed(
    automaton: Automaton | ExtendedAutomaton,
    name: str,
    meaning: str,
    events: list[tuple[str, Event]] | None,
    states: list[str] | None,
) -> Automaton | ExtendedAutomaton:
    """Return ``automaton`` with other names: states of the file that are not named are dropped."""
    n = len(automaton.marked)
    labels = [(e.name, e) for e in automaton.alphabet] if events is None else events
    place = {label: k for k, (label, _) in enumerate(labels)}
    strange = [e.name for e in automaton.alphabet if e.name not in place]
    if strange:
        raise InputError(f"has no event {strange[0]!r}")
    s, e, t = columns(automaton)
    named = n if states is None else len(states)  # and those that were added are dropped
    kept = (s < named) & (t < named)
    initial = [automaton.initial] if isinstance(automaton.initial, int) else np.flatnonzero(automaton.initial).tolist()
    if any(q >= named for q in initial):
        raise InputError("does not name the initial state")
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
    )
