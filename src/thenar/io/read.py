"""From files of any format to a problem."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from thenar.errors import InputError
from thenar.io.files import read_bytes, read_stdin
from thenar.io.foreign.assemble import simplest
from thenar.io.formats import FORMATS, Format, format_named, format_of
from thenar.io.parse import Document, decode, sniff
from thenar.io.side import ENDING, with_problem_table, with_table
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event, merge
from thenar.model.expressions import conjunction
from thenar.model.problem import Problem

if TYPE_CHECKING:
    from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem

__all__ = ["load", "loads"]


def load(
    *paths: str | os.PathLike[str],
    specs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    format: str | None = None,
) -> Problem | ExtendedProblem:
    """Read model files; their endings, or ``format``, tell the format; ``-`` is standard input.

    A file with variables, guards or conditions is an ExtendedProblem; so is one of a nondeterministic automaton.

    Several files make one problem.  Our own TOML and JSON files share their events: one declared in one file may be
    used in each.  Of the others, each says all itself.  A format whose files hold one automaton (TCT, libFAUDES, IDES,
    DESUMA, DOT, Mermaid) does not say which automata are specifications: name their files in ``specs``; the others
    are plants.  So are the automata of a CIF or Supremica file that has no plant, unless it is named in ``specs``.
    Automata of one name are called after their files.  What a format has no words for, such as TCT for names, is read
    from the table that :func:`save` writes beside the file.  The name is the first that a file gives;
    without one the problem is called after the first file.  See docs/formats.md and docs/model-file.md.

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
    allowed = [specs] if isinstance(specs, str | os.PathLike) else list(specs)
    everything = [*paths, *allowed]
    if not everything:
        raise InputError("no file to load; name at least one model file, or - for standard input")
    if [str(path) for path in everything].count("-") > 1:
        raise InputError("standard input can be read once only; give - once")
    given = None if format is None else format_named(format)
    files = [_open(path, "plant", given) for path in paths] + [_open(path, "spec", given) for path in allowed]
    stems = [Path(path).stem for path in everything if str(path) != "-"]
    return _together(files, stems[0] if stems else "")


def loads(text: str | bytes, format: str | None = None, source: str = "<string>") -> Problem | ExtendedProblem:
    """Read the text (of a binary format, the bytes) of one model file; ``source`` is what messages call it.

    Without ``format`` the first character tells TOML from JSON.  A single automaton is taken as a plant.  Raises as
    :func:`load` does.

    >>> loads('[events]\\nslip = {}\\n[automata.PAD]\\nkind = "plant"\\ninitial = "dry"\\nmarked = ["dri"]')
    Traceback (most recent call last):
    thenar.errors.ModelError: <string>:6: automaton 'PAD', marked state 1: unknown state 'dri'; did you mean 'dry'?
    """
    chosen = _sniffed(text, source) if format is None else _readable(format_named(format), source)
    return _together([_File(source, chosen, "plant", text)], "")


@dataclass(frozen=True, slots=True)
class _File:
    """A file, opened; ``kind`` is what its automaton is, if the format does not say."""

    source: str
    format: Format
    kind: str
    content: str | bytes
    path: Path | None = None

    @property
    def text(self) -> str:
        if isinstance(self.content, str):
            return self.content.removeprefix("\ufeff")
        return decode(self.content, self.source)

    @property
    def data(self) -> bytes:
        return self.content.encode() if isinstance(self.content, str) else self.content


@dataclass(frozen=True, slots=True)
class _Single:
    """The automaton of a file that holds one, and what it is."""

    kind: str
    automaton: Automaton | ExtendedAutomaton


def _open(path: str | os.PathLike[str], kind: str, given: Format | None) -> _File:
    if str(path) == "-":
        data = read_stdin()
        chosen = given or _sniffed(data, "<stdin>")
        return _File("<stdin>", _readable(chosen, "<stdin>"), _kind(chosen, kind, "<stdin>"), data)
    if str(path).endswith(ENDING):
        raise InputError(f"{path}: a table of names; it is read with the file beside it, leave it out")
    if not Path(path).is_dir():
        _readable(given or format_of(path), str(path))  # before anything is read
    data = read_bytes(path)
    chosen = _readable(given or format_of(path, data), str(path))
    return _File(str(path), chosen, _kind(chosen, kind, str(path)), data, Path(path))


def _readable(format: Format, source: str) -> Format:
    if not format.reads:
        raise InputError(f"{source}: {format.title} is written only; {_readable_formats()} are read")
    return format


def _readable_formats() -> str:
    return ", ".join(format.name for format in FORMATS if format.reads)


def _kind(format: Format, kind: str, source: str) -> str:
    if kind == "spec" and not format.module:
        raise InputError(f"{source}: a file in {format.title} says itself what its automata are; leave it out of specs")
    return kind


def _sniffed(content: str | bytes, source: str) -> Format:
    """Tell TOML from JSON."""
    return format_named(sniff(decode(content, source) if isinstance(content, bytes) else content))


def _together(files: Sequence[_File], otherwise: str) -> Problem | ExtendedProblem:
    """Return one problem of all the files; without a name in them, it is called ``otherwise``."""
    own = [file for file in files if not file.format.module]
    pieces: list[tuple[_File, Problem | ExtendedProblem | _Single]] = []
    for file in files:
        if file.format.one:
            pieces.append((file, _single(file)))
        elif file.format.module:
            pieces.append((file, _whole(file)))
        elif file is own[0]:
            from thenar.io.modelfile import problem_of

            documents = [Document(f.source, "toml" if f.format.name == "toml" else "json", f.text) for f in own]
            pieces.append((file, problem_of(documents, otherwise)))
    return _joined(pieces, otherwise)


def _single(file: _File) -> _Single:
    automaton = file.format.code().loads(file.data, file.source)
    return _Single(*with_table(file.path, automaton, file.kind))


def _whole(file: _File) -> Problem | ExtendedProblem:
    problem: Problem | ExtendedProblem
    if file.format.name == "cif":  # has files that import others
        from thenar.io import cif

        model = cif.loads(file.text, file.source) if file.path is None else cif.load(file.path)
        problem = simplest(model)
    else:
        problem = file.format.code().loads(file.data, file.source)
    return with_problem_table(file.path, problem)


def _joined(
    pieces: Sequence[tuple[_File, Problem | ExtendedProblem | _Single]], otherwise: str
) -> Problem | ExtendedProblem:
    """Return one problem of all that the files hold."""
    from thenar.model.extended import ExtendedProblem

    problems = [piece for _, piece in pieces if not isinstance(piece, _Single)]
    if len(problems) == len(pieces) == 1 and problems[0].name and pieces[0][0].kind == "plant":
        return problems[0]
    pieces = _with_flags(pieces)
    plants: list[Automaton | ExtendedAutomaton | Condition] = []
    specs: list[Automaton | ExtendedAutomaton | Condition] = []
    counts = Counter(piece.automaton.name for _, piece in pieces if isinstance(piece, _Single))
    for file, piece in pieces:
        if isinstance(piece, _Single):
            renamed = file.path is not None and counts[piece.automaton.name] > 1
            automaton = replace(piece.automaton, name=file.path.stem) if renamed and file.path else piece.automaton
            (plants if piece.kind == "plant" else specs).append(automaton)
            continue
        first = plants if file.kind == "plant" else specs
        first += piece.plants
        specs += piece.specs
        if isinstance(piece, ExtendedProblem):
            first += piece.plant_conditions
            specs += piece.spec_conditions
    alphabets = [piece.automaton.alphabet if isinstance(piece, _Single) else piece.alphabet for _, piece in pieces]
    texts: dict[str, Any] = {
        "name": next(filter(None, (problem.name for problem in problems)), otherwise),
        "description": "\n".join(problem.description for problem in problems if problem.description),
        "alphabet": merge(alphabets, [file.source for file, _ in pieces]),
    }
    extended = [problem for problem in problems if isinstance(problem, ExtendedProblem)]
    if not extended and all(isinstance(a, Automaton) for a in plants + specs):
        plain = [[a for a in group if isinstance(a, Automaton)] for group in (plants, specs)]
        return Problem(plain[0], plain[1], **texts)
    return ExtendedProblem(
        plants,
        specs,
        variables=[v for problem in extended for v in problem.variables],
        initial=conjunction(problem.initial for problem in extended),
        marked=conjunction(problem.marked for problem in extended),
        **texts,
    )


def _with_flags(
    pieces: Sequence[tuple[_File, Problem | ExtendedProblem | _Single]],
) -> list[tuple[_File, Problem | ExtendedProblem | _Single]]:
    """Return ``pieces``; generators of libFAUDES that say nothing of control have the events of the others' alphabets.

    A specification is a plain Generator there, whose events have no flags: a synthesis takes them from the plant.
    """
    silent = [file.format.name.startswith("faudes") and _says_nothing(piece) for file, piece in pieces]
    known: dict[str, Event] = {}
    for (_, piece), unknown in zip(pieces, silent, strict=True):
        if not unknown:
            alphabet = piece.automaton.alphabet if isinstance(piece, _Single) else piece.alphabet
            known |= {event.name: event for event in alphabet if event.name not in known}

    def told(piece: Problem | ExtendedProblem | _Single) -> Problem | ExtendedProblem | _Single:
        assert isinstance(piece, _Single)
        alphabet = Alphabet(known.get(event.name, event) for event in piece.automaton.alphabet)
        return replace(piece, automaton=replace(piece.automaton, alphabet=alphabet))

    return [(file, told(piece) if unknown else piece) for (file, piece), unknown in zip(pieces, silent, strict=True)]


def _says_nothing(piece: Problem | ExtendedProblem | _Single) -> bool:
    default = ("uncontrollable",)  # libFAUDES's for an event without a flag
    return isinstance(piece, _Single) and all(event.properties == default for event in piece.automaton.alphabet)
