"""From a problem to a model file that people read: arrow notation, one transition a line."""

from __future__ import annotations

import os

from thenar.errors import InputError
from thenar.io.files import atomic_write
from thenar.io.layout import as_json, as_toml
from thenar.io.parse import format_by_ending, format_by_name
from thenar.io.tables import tables_of
from thenar.model.automaton import Automaton
from thenar.model.extended import ExtendedProblem
from thenar.model.problem import Problem

__all__ = ["dumps", "save"]


def dumps(model: Problem | ExtendedProblem | Automaton, format: str = "toml") -> str:
    """Return the text of the model file that says what ``model`` says; an automaton alone is taken as a plant.

    :func:`loads` gives it back with its events, states, transitions, variables and conditions in the same order.  One
    thing a model file cannot say: each automaton's alphabet is ordered as that of the problem.  An extended
    problem without variables, guards and conditions comes back as a plain one.

    Raises InputError for what the format has no words for: an automaton without states, two automata or two
    states of one name, a state without a name, an expression that is too long; and for a ``format`` other than
    "toml" and "json".

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
    write = as_toml if format_by_name(format) == "toml" else as_json
    text = "".join(write(tables_of(Problem(model) if isinstance(model, Automaton) else model)))
    try:
        text.encode()
    except UnicodeEncodeError as error:
        wrong = text[error.start : error.end]
        raise InputError(f"a name has the character {wrong!r}, which UTF-8 does not have; rename it") from None
    return text


def save(problem: Problem | ExtendedProblem | Automaton, path: str | os.PathLike[str]) -> None:
    """Write ``problem`` to the file ``path``, TOML or JSON by its ending; all or nothing.

    Raises InputError as :func:`dumps` does, for another ending, and where the system does not let us write.

    >>> import tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp(), "lamp.json")
    >>> save(Automaton.from_transitions(["dark -on-> lit"], initial="dark", name="LAMP"), file)
    >>> file.read_text().splitlines()[2]
    '    "on": {}'
    """
    atomic_write(path, dumps(problem, format_by_ending(path)))
