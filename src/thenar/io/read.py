"""From model files to a problem; all that is wrong with them comes back as one error."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from itertools import chain

from thenar.errors import InputError, Mistake, ModelError
from thenar.io.parse import Document, format_by_name, open_document, sniff
from thenar.model.automaton import Automaton
from thenar.model.build import Complaint, Parts, assemble, check_parts
from thenar.model.events import Alphabet, Event, merge
from thenar.model.problem import Problem

__all__ = ["load", "loads"]

TYPE_CHECKING = False
if TYPE_CHECKING:
    from thenar.io.schema import EventTable, ModelFile


def load(*paths: str | os.PathLike[str]) -> Problem:
    """Read model files, by their endings TOML or JSON; ``-`` is standard input.

    Several files make one problem: the events of all of them, in order of first mention, and the automata of
    all of them.  An event declared in one file may be used in each.  The name and the description are the
    first that a file gives.

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
    Problem: 1 plant, 0 specs, 2 events (1 uncontrollable)
    """
    if not paths:
        raise InputError("no file to load; name at least one model file, or - for standard input")
    if [str(path) for path in paths].count("-") > 1:
        raise InputError("standard input can be read once only; give - once")
    return _problem([open_document(path) for path in paths])


def loads(text: str, format: str | None = None, source: str = "<string>") -> Problem:
    """Read the text of one model file; ``source`` is what messages call it.

    Without ``format`` ("toml" or "json") the first character tells.  Raises as :func:`load` does.

    >>> loads('[events]\\nslip = {}\\n[automata.PAD]\\nkind = "plant"\\ninitial = "dry"\\nmarked = ["dri"]')
    Traceback (most recent call last):
    thenar.errors.ModelError: <string>:6: automaton 'PAD', marked state 1: unknown state 'dri'; did you mean 'dry'?
    """
    return _problem([Document(source, sniff(text) if format is None else format_by_name(format), text)])


def _problem(documents: Sequence[Document]) -> Problem:
    from thenar.io.check import check  # brings pydantic: needed to read a file, not to import thenar

    checked = [check(data, document.format) for document, data in zip(documents, _data(documents), strict=True)]
    files = [file for file, _ in checked]
    complaints = [broken for _, broken in checked]
    is_sound = not any(complaints)

    alphabets = [list(_events(file.events, wrong)) for file, wrong in zip(files, complaints, strict=True)]
    if is_sound and not any(complaints):  # mended files could clash where their authors agree
        merge([Alphabet(events) for events in alphabets], [document.source for document in documents])
    known = Alphabet({event.name: event for event in reversed([*chain(*alphabets)])}.values())
    ...
