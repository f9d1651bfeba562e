"""What libFAUDES's two forms of a generator share: states by index and name, events by flags, names to write."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError, Mistake, ModelError
from thenar.io.foreign.apart import Parts, apart, beside, said
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.faudes_tokens import Tokens
from thenar.io.foreign.words import event_name
from thenar.io.foreign.written import Names
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton
from thenar.model.names import Numbered

__all__ = ["REFUSED", "Called", "Flags", "Generator", "called", "option", "skip"]

MOST = 1_000_000  # states that a file may declare by a range, without a byte for each
CONTROLLABLE, OBSERVABLE, FORCIBLE, PREEMPTIBLE = 1, 2, 4, 8  # libFAUDES's bits, cfl_attributes.h
REFUSED = {
    "Clocks": "clocks; a timed generator needs a model of time that an automaton does not have",
    "Invariant": "an invariant of clocks; a timed generator needs a model of time that an automaton does not have",
    "Timing": "a guard or reset of clocks; a timed generator needs a model of time that an automaton does not have",
    "Colors": "colours, which are several kinds of marking; an automaton has one",
    "RabinAcceptance": "an acceptance condition for infinite strings; an automaton marks finite ones",
    "R": "an acceptance condition for infinite strings; an automaton marks finite ones",
    "Rate": "continuous variables of a hybrid automaton",
    "LhaStateSpace": "continuous variables of a hybrid automaton",
}
_SYMBOL = re.compile(r"(?!(?:inf|[Tt]rue|[Ff]alse)$)[!$-~]+")  # SymbolTable::ValidSymbol; what is no number unquoted


def skip(tokens: Tokens) -> None:
    """Take a word or a section that is no element but says something about one; refuse what has a meaning."""
    token = tokens.peek()
    if token.kind != "begin":
        tokens.next()
    elif tokens.skip_section() and token.text in REFUSED:
        tokens.fail(token.position, f"<{token.text}>: {REFUSED[token.text]}; leave them out")


@dataclass(slots=True)
class Flags:
    """What a file says of an event; libFAUDES's default is uncontrollable, observable, not forcible."""

    bits: int = OBSERVABLE
    priority: int = 0

    def letters(self, option: str) -> None:
        """Note the option ``+option+``: a capital letter sets a flag, a small one clears it."""
        for letter, bit in zip("COFP", (CONTROLLABLE, OBSERVABLE, FORCIBLE, PREEMPTIBLE), strict=True):
            if letter in option:
                self.bits |= bit
            if letter.lower() in option:
                self.bits &= ~bit

    def element(self, tag: str, attributes: Mapping[str, str]) -> None:
        """Note an element of XML such as ``<Controllable value="0"/>``; unknown ones say nothing."""
        value = attributes.get("value", "1")
        if tag in ("Flags", "Priority"):
            number = int(value, 0) if re.fullmatch(r"0x[0-9a-fA-F]{1,15}|[1-9][0-9]{0,15}|0", value) else 0
            if tag == "Flags":
                self.bits = number
            else:
                self.priority = number
        elif tag in ("Controllable", "Observable", "Forcible", "Preemptible"):
            self.letters(tag[0].lower() if value in ("0", "false", "False") else tag[0])

    def event(self, name: str) -> Event:
        """Return the event; what the model has no word for is kept in its meaning."""
        more = [
            *(["preemptible"] if self.bits & PREEMPTIBLE else []),
            *([f"priority {self.priority}"] if self.priority else []),
            *([f"flags {self.bits & ~15:#x}"] if self.bits & ~15 else []),
        ]
        return Event(
            event_name(name),
            controllable=bool(self.bits & CONTROLLABLE),
            observable=bool(self.bits & OBSERVABLE),
            forcible=bool(self.bits & FORCIBLE),
            meaning=f"in libFAUDES: {', '.join(more)}" if more else "",
        )


def option(event: Event) -> str:
    """Return the letters of the flags in which ``event`` differs from libFAUDES's default."""
    return "C" * event.controllable + "o" * (not event.observable) + "F" * event.forcible


@dataclass(slots=True)
class Generator:
    """A generator while it is read.  States have an index from 1 on, and may have a name; so far in file order."""

    source: str
    length: int  # characters of the file: what is believed of a range of states
    name: str = ""
    events: dict[str, Flags] = field(default_factory=dict)
    n_states: int = 0
    position: dict[int, int] = field(default_factory=dict)  # of the states listed one by one, by index
    index: dict[str, int] = field(default_factory=dict)  # of the named states
    ranges: list[tuple[int, int, int]] = field(default_factory=list)  # first index, last index, position
    initial: set[int] = field(default_factory=set)
    marked: set[int] = field(default_factory=set)

    def add_state(self, where: str, index: int | None, name: str = "") -> int:
        """Add a state, with the next index if it has none, and return its position."""
        index = self.n_states + 1 if index is None else index
        if index in self.position or (name and name in self.index):
            raise ModelError([Mistake(where, f"state {name or index} is listed twice")])
        self.position[index] = self.n_states
        if name:
            self.index[name] = index
        self.n_states += 1
        return self.n_states - 1

    def add_names(self, names: Sequence[str]) -> bool:
        """Add states that have names and nothing else; or return False and add none if that cannot be."""
        if self.n_states or len(set(names)) < len(names):
            return False
        self.n_states = len(names)
        self.position = dict(zip(range(1, self.n_states + 1), range(self.n_states), strict=True))
        self.index = dict(zip(names, self.position, strict=True))
        return True

    def add_range(self, where: str, first: int, last: int) -> None:
        """Add the states with the indices ``first`` to ``last``, which have no names."""
        if first < 1 or last < first or self.n_states + last - first >= max(MOST, self.length):
            raise ModelError([Mistake(where, f"{first} .. {last} is no range of at most {MOST:,} states from 1 on")])
        self.ranges.append((first, last, self.n_states))
        self.n_states += last - first + 1

    def close_states(self, where: str) -> None:
        """Sort the ranges; ModelError if two of them, or a range and a state, overlap."""
        self.ranges.sort()
        firsts = [first for first, _, _ in self.ranges]
        wrong = [b for (_, last, _), (b, _, _) in zip(self.ranges, self.ranges[1:], strict=False) if b <= last]
        for index in self.position if self.ranges else ():
            k = bisect_right(firsts, index) - 1
            wrong += [index] if k >= 0 and index <= self.ranges[k][1] else []
        if wrong:
            raise ModelError([Mistake(where, f"state {wrong[0]} is listed twice")])

    def by_index(self, index: int) -> int | None:
        """Return the position of the state with ``index``."""
        if index in self.position or not self.ranges:
            return self.position.get(index)
        k = bisect_right(self.ranges, (index, MOST + self.length, 0)) - 1
        first, last, position = self.ranges[k]
        return position + index - first if k >= 0 and index <= last else None

    def by_indices(self, indices: NDArray[np.int64]) -> NDArray[np.int64] | None:
        """Return the positions of states that are listed as one range; None if they are not, or one does not exist."""
        if self.position or len(self.ranges) != 1 or not len(indices):
            return None
        ((first, last, _),) = self.ranges
        return indices - first if first <= indices.min() and indices.max() <= last else None

    def by_name(self, name: str) -> int | None:
        """Return the position of the state called ``name``."""
        return None if name not in self.index else self.position[self.index[name]]

    def listed(self, where: str, chosen: set[int], first: int, last: int) -> None:
        """Add the positions of the states with the indices ``first`` to ``last`` to ``chosen``."""
        if last - first >= self.n_states - len(chosen):
            raise ModelError([Mistake(where, f"{first} .. {last} are more than the states that there are")])
        for index in range(first, last + 1):
            if (position := self.by_index(index)) is None:
                raise ModelError([Mistake(where, f"there is no state {index}")])
            chosen.add(position)

    def automaton(
        self, sources: NDArray[np.int64], events: NDArray[np.int64], targets: NDArray[np.int64]
    ) -> Automaton | ExtendedAutomaton:
        """Return the automaton with these transitions; ModelError if it is none."""
        marked = np.zeros(self.n_states, np.bool_)
        marked[list(self.marked)] = True
        name, alphabet = self.name or Path(self.source).stem, self._alphabet()
        columns = marked, sources, events, targets
        if self.index or not self.n_states:
            return assembled(name, alphabet, self._names(), sorted(self.initial), *columns, where=self.source)
        built = assembled(name, alphabet, self.n_states, sorted(self.initial), *columns, where=self.source)
        if isinstance(built, Automaton):
            return replace(built, states=Numbered(self._indices()))
        return replace(built, states=tuple(map(str, self._indices().tolist())))

    def _alphabet(self) -> Alphabet:
        try:
            return Alphabet(flags.event(name) for name, flags in self.events.items())
        except InputError as error:
            raise ModelError([Mistake(self.source, str(error))]) from None

    def _indices(self) -> NDArray[np.int64]:
        indices = np.zeros(self.n_states, np.int64)
        indices[list(self.position.values())] = list(self.position)
        for first, last, position in self.ranges:
            indices[position : position + last - first + 1] = np.arange(first, last + 1)
        return indices

    def _names(self) -> list[str]:
        """Return the names; a state without one is called by its index, after a ``#`` if a name is in the way."""
        if len(self.index) == self.n_states:
            indices: list[int] = []
        else:
            indices = self._indices().tolist()
        names = [str(k) if str(k) not in self.index else f"#{k}" for k in indices] or [""] * self.n_states
        for name, index in self.index.items():
            names[self.position[index]] = name
        return names


@dataclass(frozen=True, slots=True)
class Called:
    """An automaton to be written: its columns, and what the file calls the events and the states.

    ``numbered``: the states are called 1, 2, 3, ... and so need no names in a file of libFAUDES.
    """

    parts: Parts
    events: Sequence[str]
    states: Sequence[str]
    numbered: bool
    names: Names | None


def called(automaton: Automaton | ExtendedAutomaton) -> Called:
    """Return ``automaton`` as libFAUDES can say it; InputError for guards and updates.

    A symbol of libFAUDES is of the visible characters of ASCII without ``"`` and ``#``; the words ``true``, ``false``
    and ``inf`` it writes and does not read again.  Other names of events and states are kept in the table of names.
    """
    parts = apart(automaton, "a generator of libFAUDES")
    events = said(parts.alphabet.names, _sayable, "e")
    states = said(parts.states, _sayable, "s")
    read = [
        Event(name, e.controllable, e.observable, e.forcible) for name, e in zip(events, parts.alphabet, strict=True)
    ]
    numbered = states == list(map(str, range(1, len(states) + 1)))
    return Called(parts, events, states, numbered, beside(parts, read, states))


def _sayable(name: str) -> bool:
    return _SYMBOL.fullmatch(name) is not None
