"""Many transitions in one text, an arrow a line: read at a stroke, written piece by piece."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import chain, count
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from thenar.io.foreign.assemble import assembled
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet

if TYPE_CHECKING:
    from thenar.io.schema import AutomatonTable

T = TypeVar("T")

__all__ = ["arrow_lines", "lines", "quick"]

_PIECE = 16_384  # transitions that are made text at a time


def lines(listed: str | list[T]) -> list[str] | list[T]:
    """Return the entries of a list, or of a text that holds one a line; empty lines hold none.

    >>> lines("idle\\n\\nbusy\\n")
    ['idle', 'busy']
    """
    return [line for line in listed.split("\n") if line and not line.isspace()] if isinstance(listed, str) else listed


def quick(table: AutomatonTable, name: str, known: Alphabet) -> Automaton | None:
    """Return the automaton that ``table`` describes, if its transitions are one text and nothing is wrong with it.

    Each line is ``state -event-> state``, no white space in the states; everything else, mistakes too, is left to the
    patient reader.  Some two million transitions a second.

    >>> from thenar.io.schema import AutomatonTable
    >>> text = "off -on-> lit\\nlit -off-> off"
    >>> quick(AutomatonTable(kind="plant", initial="off", transitions=text), "LAMP", Alphabet(["on", "off"]))
    Automaton 'LAMP': 2 states (0 marked), 2 transitions, 2 events
    """
    if not isinstance(table.transitions, str) or isinstance(table.initial, list) or table.nondeterministic:
        return None
    words = table.transitions.split()
    n = len(words) // 3
    if len(words) != 3 * n or table.transitions.count("->") != n:
        return None
    arrows = words[1::3]
    del words[1::3]
    marked, declared = lines(table.marked), lines(table.states) if table.states else None
    number: dict[str, int] = defaultdict(count().__next__)
    if declared is None:
        number[table.initial]  # it comes first
    else:
        number = {state: q for q, state in enumerate(declared)}
    shape = {f"-{e}->": k for k, e in enumerate(known.names)}
    try:
        events = np.fromiter(map(shape.__getitem__, arrows), np.int32, n)
        ends = np.fromiter(map(number.__getitem__, words), np.int64, 2 * n)
        if table.initial not in number or not all(state in number for state in marked):
            return None
        own = np.unique([*np.flatnonzero(np.bincount(events, minlength=len(known))), *map(known.index, table.alphabet)])
    except KeyError:  # a state or an event that is not known
        return None
    if (
        len(set(marked)) < len(marked)
        or len(number) < len(declared or ())
        or len(set(table.alphabet)) < len(table.alphabet)
    ):
        return None
    mark = np.zeros(len(number), np.bool_)
    mark[[number[state] for state in marked]] = True
    own = own.astype(np.int64)
    place = np.zeros(len(known), np.int32)
    place[own] = np.arange(len(own))
    states = list(number)
    automaton = assembled(
        name,
        Alphabet(known[k] for k in own.tolist()),
        states,
        [number[table.initial]],
        mark,
        ends[::2],
        place[events],
        ends[1::2],
        meaning=table.says,
    )
    return automaton if isinstance(automaton, Automaton) and automaton.n_transitions == n else None


def arrow_lines(automaton: Automaton, states: Sequence[str]) -> Iterator[str]:
    """Yield the text that :func:`quick` reads, in pieces of some thousand lines; ``states`` are the states' names.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> print("".join(arrow_lines(lamp, ["off", "lit"])), end="")
    off -on-> lit
    lit -off-> off
    """
    arrows = [f" -{e}-> " for e in automaton.alphabet.names]
    source = np.repeat(np.arange(automaton.n_states), np.diff(automaton.offsets))
    for first in range(0, automaton.n_transitions, _PIECE):
        part = slice(first, first + _PIECE)
        s, e, t = (column[part].tolist() for column in (source, automaton.events, automaton.targets))
        words = zip(
            map(states.__getitem__, s),
            map(arrows.__getitem__, e),
            map(states.__getitem__, t),
            ["\n"] * len(s),
            strict=True,
        )
        yield "".join(chain.from_iterable(words))
