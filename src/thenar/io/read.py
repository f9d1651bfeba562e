"""From model files to a problem; all that is wrong with them comes back as one error."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from thenar.errors import InputError, Mistake, ModelError
from thenar.io.parse import Document, format_by_name, open_document, sniff
from thenar.model.automaton import Automaton
from thenar.model.build import Unknown, assemble
from thenar.model.events import Alphabet, Event, merge
from thenar.model.problem import Problem

if TYPE_CHECKING:
    from thenar.io.automata import Written
    from thenar.io.check import Checked
    from thenar.model.extended import ExtendedProblem

__all__ = ["load", "loads"]


def load(*paths: str | os.PathLike[str]) -> Problem | ExtendedProblem:
    """Read model files, by their endings TOML, JSON or CIF; ``-`` is standard input.

    A file with variables, guards or conditions is an ExtendedProblem; so is a CIF model (Eclipse ESCET), one file
    with those that it imports: see docs/model-file.md and docs/cif.md.

    Several files make one problem: the events of all of them, in order of first mention, and the automata,
    variables and conditions of all of them.  An event declared in one file may be used in each.  The name and the
    description are the first that a file gives; without a name the problem is called after the first file.

    Raises ModelError with every mistake in the files, each with its file and line; AlphabetClash for an event
    that is, say, controllable in one file and uncontrollable in another; InputError for a file that cannot
    be read.

    >>> import tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp(), "lamp.toml")
    >>> _ = file.write_text('''
    ... [events]
    ... on = {}
    ... off = { controllable = false }
    ... [automata.LAMP]
    ... kind = "plant"
    ... initial = "dark"
    ... transitions = ["dark -on-> lit -off-> dark"]
    ... ''')
    >>> load(file)
    Problem 'lamp': 1 plant, 0 specs, 2 events (1 uncontrollable)
    """
    if not paths:
        raise InputError("no file to load; name at least one model file, or - for standard input")
    if [str(path) for path in paths].count("-") > 1:
        raise InputError("standard input can be read once only; give - once")
    if any(Path(path).suffix.lower() == ".cif" for path in paths):
        from thenar.io import cif

        if len(paths) > 1:
            raise InputError("a CIF model is loaded alone, from the file that imports the others; name one file")
        return cif.load(paths[0])
    stems = [Path(path).stem for path in paths if str(path) != "-"]
    return _problem([open_document(path) for path in paths], _first(stems))


@overload
def loads(text: str, format: Literal["cif"], source: str = "<string>") -> ExtendedProblem: ...
@overload
def loads(text: str, format: str | None = None, source: str = "<string>") -> Problem | ExtendedProblem: ...
def loads(text: str, format: str | None = None, source: str = "<string>") -> Problem | ExtendedProblem:
    """Read the text of one model file; ``source`` is what messages call it.

    Without ``format`` ("toml", "json" or "cif") the first character tells TOML from JSON.  Raises as :func:`load` does.

    >>> loads('[events]\\nslip = {}\\n[automata.PAD]\\nkind = "plant"\\ninitial = "dry"\\nmarked = ["dri"]')
    Traceback (most recent call last):
    thenar.errors.ModelError: <string>:6: automaton 'PAD', marked state 1: unknown state 'dri'; did you mean 'dry'?
    """
    text = text.removeprefix("\ufeff")
    if format == "cif":
        from thenar.io import cif

        return cif.loads(text, source)
    return _problem([Document(source, sniff(text) if format is None else format_by_name(format), text)])


def _problem(documents: Sequence[Document], otherwise: str = "") -> Problem | ExtendedProblem:
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
