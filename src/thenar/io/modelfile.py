"""From our own model files to a problem; all that is wrong with them comes back as one error."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from thenar.errors import InputError, Mistake, ModelError
from thenar.io.parse import Document
from thenar.model.automaton import Automaton
from thenar.model.build import Unknown, assemble
from thenar.model.events import Alphabet, Event, merge
from thenar.model.problem import Problem

if TYPE_CHECKING:
    from thenar.io.automata import Written
    from thenar.io.check import Checked
    from thenar.model.extended import ExtendedProblem

__all__ = ["problem_of"]


def problem_of(documents: Sequence[Document], otherwise: str = "") -> Problem | ExtendedProblem:
    """Return the problem that the files describe together; without a name in them, it is called ``otherwise``.

    Raises ModelError with every mistake in the files, AlphabetClash for an event of which two say different things.

    >>> text = '[events]\\na = {}\\n[automata.A]\\nkind = "plant"\\ninitial = "0"\\ntransitions = ["0 -a-> 0"]'
    >>> problem_of([Document("a.toml", "toml", text)], "a")
    Problem 'a': 1 plant, 0 specs, 1 event (0 uncontrollable)
    """
    from thenar.io.check import check  # brings pydantic: needed to read a file, not to import thenar
    from thenar.io.meaning import Meaning, is_extended

    sources = [check(document, data) for document, data in zip(documents, _data(documents), strict=True)]
    known = _known_events(sources)
    events = _Events(sources, known)
    parts, faulty = _parts(sources, events)
    meaning = Meaning(sources, parts, faulty, known, events.unknown) if is_extended(sources, parts.values()) else None
    mistakes = [mistake for source in sources for mistake in source.mistakes()]
    mistakes += _missing(sources, parts)
    if mistakes:
        raise ModelError(mistakes)
    name = _first(source.file.name for source in sources) or otherwise
    description = _first(source.file.description for source in sources)
    if meaning is not None:
        return meaning.problem(name, description)

    def built(kind: str) -> list[Automaton]:
        return [
            p.quick or assemble(Automaton, p, known, n, p.table.says) for n, p in parts.items() if p.table.kind == kind
        ]

    return Problem(built("plant"), built("spec"), name=name, alphabet=known, description=description)


def _data(documents: Sequence[Document]) -> list[Any]:
    """Return what each document gives; the syntax errors of all of them are one ModelError."""
    data: list[Any] = []
    mistakes: list[Mistake] = []
    for document in documents:
        try:
            data.append(document.data())
        except ModelError as error:
            mistakes += error.mistakes
    if mistakes:
        raise ModelError(mistakes)
    return data


def _known_events(sources: Sequence[Checked]) -> Alphabet:
    """Return the union of the events, in order of first mention; raise AlphabetClash if it has no meaning."""
    alphabets = []
    for source in sources:
        events = []
        for name, table in source.file.events.items():
            try:
                events.append(Event(name, table.controllable, table.observable, table.forcible, table.meaning))
            except InputError:
                source.complain(("events", name), "a name is not empty and has no white space and no comma")
        alphabets.append(Alphabet(events))
    if not any(source.broken for source in sources):  # mended events could clash where their authors agree
        return merge(alphabets, [source.document.source for source in sources])
    first: dict[str, Event] = {}
    for event in chain(*alphabets):
        first.setdefault(event.name, event)
    return Alphabet(first.values())


class _Events:
    """Says what is wrong with the name of an event, unless that is said already where the events are listed."""

    def __init__(self, sources: Sequence[Checked], known: Alphabet) -> None:
        self.known = known
        self.say = Unknown("event", known.names, "; list it in events")
        unusable = [name for source in sources for name in source.file.events if name not in known]
        self.said = tuple(f"unknown event {name!r}" for name in unusable) if len(known) else ("unknown event",)

    def unknown(self, name: str) -> str | None:
        what = None if name in self.known else self.say(name)
        return None if what is None or what.startswith(self.said) else what


def _parts(sources: Sequence[Checked], events: _Events) -> tuple[dict[str, Written], set[str]]:
    """Read the transitions of every automaton, and complain of what cannot be meant; say which automata have that."""
    from thenar.io.automata import Written, complaints_of

    parts: dict[str, Written] = {}
    faulty: set[str] = set()
    home: dict[str, str] = {}
    for source in sources:
        for name, table in source.file.automata.items():
            if name in home:
                source.complain(("automata", name), f"already given in {home[name]}; rename one of the two")
            home[name] = source.document.source
            parts[name] = Written(table, name, events.known)
            for path, what in complaints_of(parts[name], events.known, events.say):
                faulty.add(name)
                if not what.startswith(events.said):
                    source.complain(("automata", name, *path), what)
    return parts, faulty


def _missing(sources: Sequence[Checked], parts: Mapping[str, Written]) -> list[Mistake]:
    """Say what no file gives."""
    if any(source.broken for source in sources):  # it may be there, and broken
        return []
    missing = []
    kinds = [table.kind for source in sources for table in source.file.automata.values()]
    if not kinds:
        missing.append("no automata; say in automata.NAME what the plant can do, and what a specification allows")
    elif "plant" not in kinds:
        missing.append("no plant; at least one automaton of kind 'plant' says what can happen")
    uses_events = any(True for part in parts.values() for _ in part.event_names()) or any(
        condition.event for source in sources for condition in source.file.conditions
    )
    if uses_events and not any(source.file.events for source in sources):
        missing.append("no events; list in events each event that the automata use")
    return [Mistake(", ".join(source.document.source for source in sources), what) for what in missing]


def _first(texts: Iterable[str]) -> str:
    return next(filter(None, texts), "")
