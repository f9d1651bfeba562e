"""Many transitions in one text, an arrow a line: read at a stroke, written piece by piece."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.io.foreign.assemble import assembled
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet

if TYPE_CHECKING:
    from thenar.io.schema import AutomatonTable

T = TypeVar("T")

__all__ = ["arrow_lines", "lines", "numbered_words", "quick", "spelled"]

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
    patient reader.

    >>> from thenar.io.schema import AutomatonTable
    >>> text = "off -on-> lit\\nlit -off-> off"
    >>> quick(AutomatonTable(kind="plant", initial="off", transitions=text), "LAMP", Alphabet(["on", "off"]))
    Automaton 'LAMP': 2 states (0 marked), 2 transitions, 2 events
    """
    if not isinstance(table.transitions, str) or isinstance(table.initial, list) or table.nondeterministic:
        return None
    ids, words = numbered_words(table.transitions)
    n = len(ids) // 3
    if len(ids) != 3 * n or table.transitions.count("->") != n or len(" ".join(words).split()) != len(words):
        return None  # the last one: white space beyond ASCII, which the patient reader parts words at too
    marked, declared = lines(table.marked), lines(table.states) if table.states else []
    if any(len(set(names)) < len(names) for names in (marked, declared, table.alphabet)):
        return None
    arrows = {f"-{e}->": k for k, e in enumerate(known.names)}
    event, place = np.full(len(words), -1), np.full(len(words), -1)
    written = np.flatnonzero(np.bincount(ids[1::3], minlength=len(words)))
    event[written] = [arrows.get(words[w], -1) for w in written.tolist()]
    labels = event[ids[1::3]]
    ends = ids.reshape(-1, 3)[:, ::2].ravel()
    mentioned = np.flatnonzero(np.bincount(ends, minlength=len(words)))  # in the order in which they first are
    called = [words[w] for w in mentioned.tolist()]
    if declared:
        number = {state: q for q, state in enumerate(declared)}
        place[mentioned] = [number.get(state, -1) for state in called]
    else:  # the initial state first, then the others in their order
        k = called.index(table.initial) if table.initial in called else len(called)
        number = {state: q for q, state in enumerate([table.initial, *called[:k], *called[k + 1 :]])}
        place[mentioned] = [*range(1, k + 1), 0, *range(k + 1, len(called))][: len(called)]
    if (labels < 0).any() or (place[mentioned] < 0).any() or not {table.initial, *marked} <= number.keys():
        return None
    if not all(event in known for event in table.alphabet):
        return None
    carried = np.bincount(labels, minlength=len(known)) > 0
    carried[[known.index(event) for event in table.alphabet]] = True
    mark = np.zeros(len(number), np.bool_)
    mark[[number[state] for state in marked]] = True
    automaton = assembled(
        name,
        Alphabet(event for event, has in zip(known, carried, strict=True) if has),
        list(number),
        [number[table.initial]],
        mark,
        place[ends[::2]],
        (np.cumsum(carried) - 1)[labels],
        place[ends[1::2]],
        meaning=table.says,
    )
    return automaton if isinstance(automaton, Automaton) and automaton.n_transitions == n else None


def numbered_words(text: str) -> tuple[NDArray[np.int32], list[str]]:
    """Return the number of each word of ``text``, and the distinct words in the order in which they are first met.

    >>> ids, words = numbered_words("off -on-> lit\\nlit -off-> off")
    >>> ids.tolist(), words
    ([0, 1, 2, 2, 3, 0], ['off', '-on->', 'lit', '-off->'])
    """
    data = text.encode()
    ids, starts, ends = kernel.words(np.frombuffer(data, np.uint8))
    places = zip(starts.tolist(), ends.tolist(), strict=True)
    return ids, [text[a:b] for a, b in places] if len(data) == len(text) else [data[a:b].decode() for a, b in places]


def arrow_lines(automaton: Automaton, states: Sequence[str]) -> Iterator[str]:
    """Yield the text that :func:`quick` reads, in pieces of some thousand lines; ``states`` are the states' names.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> print("".join(arrow_lines(lamp, ["off", "lit"])), end="")
    off -on-> lit
    lit -off-> off
    """
    arrows = [f" -{e}-> " for e in automaton.alphabet.names]
    source = np.repeat(np.arange(automaton.n_states), np.diff(automaton.offsets))
    yield from spelled((states, source), (arrows, automaton.events), ([f"{q}\n" for q in states], automaton.targets))


def spelled(*columns: tuple[Sequence[str], NDArray[np.integer[Any]]]) -> Iterator[str]:
    """Yield, row by row, the words that the numbers in the columns stand for; each column has words of its own.

    >>> list(spelled((["a", "b"], np.array([0, 1])), (["1;", "2;"], np.array([1, 1]))))
    ['a2;b2;']
    """
    words = [np.array([*table, ""], object) for table, _ in columns]
    rows = len(columns[0][1])
    for first in range(0, rows, _PIECE):
        part = np.empty((min(_PIECE, rows - first), len(columns)), object)
        for k, (_, numbers) in enumerate(columns):
            part[:, k] = words[k][numbers[first : first + _PIECE]]
        yield "".join(part.ravel().tolist())
