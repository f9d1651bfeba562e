"""From a problem to files of any format."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, overload

from thenar.errors import InputError
from thenar.io.files import Data, atomic_write_all, check_writable
from thenar.io.foreign.assemble import plain
from thenar.io.foreign.written import Names, ProblemNames, Written
from thenar.io.formats import FORMATS, Format, format_named, format_of
from thenar.io.layout import as_json, as_toml
from thenar.io.side import ENDING, known_labels, problem_table, table_of
from thenar.io.tables import tables_of
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE
from thenar.model.extended import ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem

__all__ = ["Saved", "dumps", "save"]

_FLATTEN = "thenar convert --flatten makes plain automata of it"
Model: TypeAlias = Problem | ExtendedProblem | Automaton | ExtendedAutomaton


@dataclass(frozen=True, slots=True)
class Saved:
    """What was written: the ``files``, and ``notes`` on what a format says in another way than the model did.

    >>> print(Saved((Path("MACH1.DES"),), ("state 3 was added",)))
    wrote MACH1.DES
    note: state 3 was added
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "\n".join([*(f"wrote {file}" for file in self.files), *(f"note: {note}" for note in self.notes)])


@overload
def dumps(model: Model, format: Literal["tct"]) -> bytes: ...  # type: ignore[overload-overlap]
@overload
def dumps(model: Model, format: str = "toml") -> str: ...
def dumps(model: Model, format: str = "toml") -> str | bytes:
    """Return the text (of a binary format, the bytes) of the file that says what ``model`` says.

    An automaton alone is taken as a plant.  :func:`loads` gives the model back with its events, states,
    transitions, variables and conditions in the same order, as far as the format has words for them: see
    docs/formats.md; :func:`save` writes the rest into a table beside the file, here it is left away.  One thing that
    TOML and JSON cannot say: each automaton's alphabet is ordered as that of the problem.  An extended problem without
    variables, guards and conditions comes back as a plain one.

    Raises InputError for what the format has no words for: an automaton without states, two automata or two
    states of one name, a state without a name, an expression that is too long, variables in a format of plain
    automata, several automata in one that holds a single one; UnknownName for an unknown format.

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
    chosen = _writable(format_named(format))
    if chosen.one:
        named = list(_automata(model, chosen))
        if len(named) > 1:
            raise InputError(
                f"{_holds_one(chosen, len(named))}; save(model, 'FOLDER/', format={format!r}) writes them all"
            )
        pieces = list(_written(named[0][1], chosen, _problem(model).alphabet, {}).chunks)
    else:
        pieces = list(_written(model, chosen, _problem(model).alphabet, {}).chunks)
    if pieces and isinstance(pieces[0], bytes):
        return b"".join(piece for piece in pieces if isinstance(piece, bytes))
    text = "".join(piece for piece in pieces if isinstance(piece, str))
    try:
        text.encode()
    except UnicodeEncodeError as error:
        wrong = text[error.start : error.end]
        raise InputError(f"a name has the character {wrong!r}, which UTF-8 does not have; rename it") from None
    return text


def save(model: Model, path: str | os.PathLike[str], format: str | None = None) -> Saved:
    """Write ``model`` to the file ``path``, in the format that its ending tells, or ``format``; all or nothing.

    Where a format holds one automaton a file and there are several, ``path`` is a folder: each automaton gets a file
    there, called after it.  What the format has no words for (names, in TCT; that an automaton is a specification)
    goes into a table beside the file, ``PATH.names.json``, which :func:`load` finds again.

    Raises InputError as :func:`dumps` does, and where the system does not let us write.

    >>> import tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp(), "lamp.json")
    >>> saved = save(Automaton.from_transitions(["dark -on-> lit"], initial="dark", name="LAMP"), file)
    >>> saved.files[0].read_text().splitlines()[2]
    '    "on": {}'
    """
    target = Path(path)
    folder = target.is_dir() or str(path).endswith(("/", os.sep))
    if folder and format is None:
        raise InputError(f"{path}: a folder; say which format its files shall have")
    chosen = _writable(format_of(path) if format is None else format_named(format))
    whole = _problem(model)
    if not chosen.one:
        if folder:
            raise InputError(f"{path}: a folder; a file in {chosen.title} holds the whole problem, name a file")
        check_writable(path)
        written = _written(whole, chosen, whole.alphabet, {})
        table = problem_table(written.names) if isinstance(written.names, ProblemNames) else None
        return _saved([_Output(target, written, table)])
    named = list(_automata(model, chosen))
    if not folder:
        if len(named) > 1:
            what = f"{_holds_one(chosen, len(named))}; name a folder, with '/' at its end, and the format"
            raise InputError(f"{path}: {what}")
        check_writable(path)
        return _saved([_output(*named[0], target, chosen, whole.alphabet)])
    names = _file_names([automaton.name for _, automaton in named], chosen.endings[0])
    if not target.is_dir():
        check_writable(target)
        target.mkdir()
    for name in names:
        check_writable(target / name)
    return _saved(
        [_output(*item, target / name, chosen, whole.alphabet) for item, name in zip(named, names, strict=True)]
    )


@dataclass(frozen=True, slots=True)
class _Output:
    """A file to be written, and the table beside it, if it has one."""

    target: Path
    written: Written
    table: str | None

    @property
    def beside(self) -> Path:
        return self.target.with_name(self.target.name + ENDING)


def _output(
    kind: str, automaton: Automaton | ExtendedAutomaton, target: Path, format: Format, alphabet: Alphabet
) -> _Output:
    labels = known_labels(target.parent, format.endings[0]) if format.numbers else {}
    written = _written(automaton, format, alphabet, labels)
    names = written.names if isinstance(written.names, Names) else None
    named = format.named or automaton.name in ("", target.stem)
    unsaid = names or kind != "plant" or not named or (automaton.meaning and not format.texts)
    return _Output(target, written, table_of(automaton, kind, names) if unsaid and format.reads else None)


def _saved(outputs: Sequence[_Output]) -> Saved:
    """Write all files and tables, or none; tables of what stood in their places before go."""
    pieces: list[tuple[Path, Data]] = []
    for output in outputs:
        pieces.append((output.target, output.written.chunks))
        if output.table is not None:
            pieces.append((output.beside, output.table))
    atomic_write_all(pieces)
    for output in outputs:
        if output.table is None:
            output.beside.unlink(missing_ok=True)
    notes = dict.fromkeys(note for output in outputs for note in output.written.notes)
    return Saved(tuple(path for path, _ in pieces), tuple(notes))


def _writable(format: Format) -> Format:
    if not format.writes:
        known = ", ".join(other.name for other in FORMATS if other.writes)
        raise InputError(f"{format.title} is read only; {known} are written")
    return format


def _holds_one(format: Format, n: int) -> str:
    return f"a file in {format.title} holds one automaton, and there are {n}"


def _written(model: Model, format: Format, alphabet: Alphabet, labels: Mapping[str, int]) -> Written:
    """Return ``model`` in ``format``; ``alphabet`` is that of all automata which are written with it.

    ``labels`` are the numbers that events have in other files.
    """
    whole = model if format.one else _problem(model)
    if not format.module:
        tables = tables_of(_problem(model))
        return Written(as_toml(tables) if format.name == "toml" else as_json(tables))
    numbers: dict[str, Any] = {"alphabet": alphabet, "labels": labels} if format.numbers else {}
    written: Written = format.code().dumps(whole, **numbers)
    return written


def _problem(model: Model) -> Problem | ExtendedProblem:
    if isinstance(model, Automaton):
        return Problem(model)
    if isinstance(model, ExtendedAutomaton):
        return ExtendedProblem(model)
    if not isinstance(model, Problem | ExtendedProblem):
        kind = type(model).__name__
        raise InputError(f"a {kind} is no model; write a problem or an automaton, such as supervisor.automaton")
    return model


def _automata(model: Model, format: Format) -> Iterable[tuple[str, Automaton | ExtendedAutomaton]]:
    """Yield the automata of ``model`` and what they are; raise InputError for variables, guards and conditions."""
    if isinstance(model, Automaton | ExtendedAutomaton):
        yield "plant", _plain(model, format)
        return
    if isinstance(model, ExtendedProblem):
        conditions = [*model.plant_conditions, *model.spec_conditions]
        if model.variables or conditions or (model.initial, model.marked) != (TRUE, TRUE):
            has = "variables" if model.variables else "conditions"
            raise InputError(f"the model has {has}, for which {format.title} has no words; {_FLATTEN}")
    for kind, group in (("plant", model.plants), ("spec", model.specs)):
        for automaton in group:
            yield kind, _plain(automaton, format)


def _plain(automaton: Automaton | ExtendedAutomaton, format: Format) -> Automaton | ExtendedAutomaton:
    """Return the automaton, as an :class:`Automaton` if it is deterministic; refuse guards and updates."""
    if isinstance(automaton, ExtendedAutomaton):
        for k, edge in enumerate(automaton.edges):
            if edge.guard != TRUE or edge.updates:
                where = f"automaton {automaton.name!r}, {automaton.place(k)}"
                what = f"has a guard or an update, for which {format.title} has no words; {_FLATTEN}"
                raise InputError(f"{where} {what}")
    return plain(automaton)


def _file_names(names: Sequence[str], ending: str) -> list[str]:
    """Return a file name for each automaton; raise InputError for two that a file system may not tell apart."""
    files = [re.sub(r'[\x00-\x1f<>:"/\\|?*]', "_", name).strip(". ") or "automaton" for name in names]
    seen: dict[str, str] = {}
    for name, file in zip(names, files, strict=True):
        if (other := seen.setdefault(file.lower(), name)) != name:
            raise InputError(
                f"automata {other!r} and {name!r} would share the file {file + ending!r}; rename one of them"
            )
    return [file + ending for file in files]
