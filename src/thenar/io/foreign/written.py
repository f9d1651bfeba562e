"""What a writer gives back: the file piece by piece, and what it could not say."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from thenar.model.events import Event

__all__ = ["Names", "ProblemNames", "Written"]


@dataclass(frozen=True, slots=True)
class Names:
    """What a file of one automaton calls otherwise, or leaves out; it is kept in a table beside the file.

    * ``events``: what the file calls each event of the automaton's alphabet, and the event itself, in order
    * ``states``: the name of each state, in the order of the numbers that the states have in the file; states of the
      file beyond these, ``added`` in number, are the writer's (see :attr:`Written.notes`) and are dropped by the reader
    """

    events: tuple[tuple[str, Event], ...]
    states: tuple[str, ...]
    added: int = 0


@dataclass(frozen=True, slots=True)
class ProblemNames:
    """What a file of a whole problem calls otherwise, or leaves out: what the file says, then what the model says.

    * ``events`` in the order of the alphabet; ``automata``: label, name, meaning, and the pairs of its states
    * ``literals``: the values of enumerations
    """

    name: str
    description: str
    events: tuple[tuple[str, Event], ...]
    automata: tuple[tuple[str, str, str, tuple[tuple[str, str], ...]], ...]
    variables: tuple[tuple[str, str], ...]
    literals: tuple[tuple[str, str], ...]

    def says_nothing(self) -> bool:
        """Return whether the file says all itself."""
        events = all(label == e.name and e.observable and not e.forcible and not e.meaning for label, e in self.events)
        automata = all(
            label == name and not meaning and all(a == b for a, b in states)
            for label, name, meaning, states in self.automata
        )
        pairs = all(a == b for a, b in self.variables + self.literals)
        return events and automata and pairs and not self.name and not self.description


@dataclass(frozen=True, slots=True)
class Written:
    """A model in another tool's format.

    * ``chunks``: the file, text or bytes, in pieces of some kilobytes; made while they are read
    * ``names``: what the file cannot say and a table beside it can; None if it says all
    * ``notes``: sentences on what the file says in another way than the model did
    """

    chunks: Iterable[str] | Iterable[bytes]
    names: Names | ProblemNames | None = None
    notes: tuple[str, ...] = ()
