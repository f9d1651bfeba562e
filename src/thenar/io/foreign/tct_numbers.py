"""TCT's numbers: states from 0, the initial one first, and labels that are odd for controllable events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError, Mistake, ModelError, counted
from thenar.io.foreign.apart import Parts, apart, beside
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.written import Names
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["MAX_LABEL", "MAX_STATES", "Numbers", "automaton_of", "event_of", "fail", "numbers"]

MAX_LABEL = 65_535  # TCT's type of a label is an unsigned short
MAX_STATES = 2_000_000  # TCT's MAX_STATES, des_data.h; a file may declare so many without a byte for each
SILENT = 1000  # TCT's EEE, the label of a transition that nobody sees


@dataclass(frozen=True, slots=True)
class Numbers:
    """An automaton in TCT's numbers; state q has the transitions ``offsets[q]:offsets[q + 1]``, labels rising."""

    name: str
    size: int
    marked: NDArray[np.bool_]
    offsets: NDArray[np.int64]
    labels: NDArray[np.int64]
    targets: NDArray[np.int64]
    names: Names | None
    notes: tuple[str, ...]


def event_of(label: int) -> Event:
    """Return the event with ``label``: controllable if it is odd.

    >>> event_of(10), event_of(11)
    (Event('10', uncontrollable), Event('11', controllable))
    """
    return Event(str(label), controllable=label % 2 == 1)


def automaton_of(
    source: str,
    size: int,
    marked: NDArray[np.bool_],
    sources: NDArray[np.int64],
    labels: NDArray[np.int64],
    targets: NDArray[np.int64],
    name: str = "",
) -> Automaton | ExtendedAutomaton:
    """Return the automaton with these states, labels and transitions, all of them checked by the caller.

    Its alphabet are the labels that occur, rising, and its initial state is 0.
    """
    present = np.flatnonzero(np.bincount(labels, minlength=1)) if len(labels) else labels
    position = np.zeros(MAX_LABEL + 1, np.int64)
    position[present] = np.arange(len(present))
    alphabet = Alphabet(map(event_of, present.tolist()))
    return assembled(
        name or Path(source).stem, alphabet, size, [0], marked, sources, position[labels], targets, where=source
    )


def numbers(
    automaton: Automaton | ExtendedAutomaton,
    highest: int,
    alphabet: Alphabet | None,
    labels: Mapping[str, int],
    format_: str,
) -> Numbers:
    """Return ``automaton`` in TCT's numbers; ``highest`` is the largest label that ``format_`` can hold.

    An event that is called by a number of the right parity has it as its label; if any event of ``alphabet`` (by
    default, the automaton's) is called otherwise, all of them are counted in their order: the next odd number for a
    controllable event, the next even one for an uncontrollable one.  Of ``labels``, what other files call an event is
    kept as far as its parity is right; the others are counted on from there.

    Raises InputError for too many events, several initial states, guards and updates.
    """
    c = apart(automaton, f"{format_} file")
    if len(c.initial) > 1:
        raise InputError(
            f"automaton {c.name!r} starts in {counted(len(c.initial), 'state')}, and {format_} knows one initial "
            "state only; determinise it first"
        )
    known = c.alphabet if alphabet is None else alphabet
    by_name = dict(zip(known.names, _labels(known, labels), strict=True))
    _check_alphabet(c, by_name, known)
    label = np.array([by_name[e] for e in c.alphabet.names], np.int64)
    if len(label) and label.max() > highest:
        worst = c.alphabet[int(label.argmax())]
        raise InputError(
            f"automaton {c.name!r}: event {worst.name!r} would be label {label.max():,}, and the labels of {format_} "
            f"end at {highest:,}; write it in another format"
        )
    number, order = _from_initial(c)
    s, e, t = number[c.sources], label[c.events], number[c.targets]
    size, marked = len(order), c.marked[order]
    notes: list[str] = []
    blocked = np.flatnonzero(np.bincount(c.events, minlength=len(label)) == 0)
    if len(blocked) and size:
        s = np.append(s, np.full(len(blocked), size))
        e, t = np.append(e, label[blocked]), np.append(t, np.full(len(blocked), size))
        marked = np.append(marked, False)
        listed = ", ".join(c.alphabet[k].name for k in blocked[:5].tolist()) + ", ..." * (len(blocked) > 5)
        notes.append(
            f"TCT knows only events that some transition carries: {listed} never happen{'s' * (len(blocked) == 1)} "
            f"here, and so {'is' if len(blocked) == 1 else 'are'} looped at state {size}, which nothing leads to"
        )
        size += 1
    if ((np.diff(s) < 0) | ((np.diff(s) == 0) & (np.diff(e) <= 0))).any():
        rank = np.lexsort((t, e, s))
        s, e, t = s[rank], e[rank], t[rank]
    offsets = np.zeros(size + 1, np.int64)
    np.cumsum(np.bincount(s, minlength=size), out=offsets[1:])
    return Numbers(c.name, size, marked, offsets, e, t, _names(c, label, order, size), tuple(notes))


def fail(where: str, *what: str) -> NoReturn:
    """Raise ModelError with a mistake for each of ``what``."""
    raise ModelError([Mistake(where, sentence) for sentence in what])


def _labels(alphabet: Alphabet, elsewhere: Mapping[str, int]) -> list[int]:
    own = [int(e.name) if _is_label(e) else -1 for e in alphabet]
    if -1 not in own:
        return own
    kept = {e.name: k for e in alphabet if (k := elsewhere.get(e.name, -1)) % 2 == e.controllable and k >= 0}
    labels, last = [], max([0, *(elsewhere.values() if kept else ())])
    for event in alphabet:
        if event.name in kept:
            labels.append(kept[event.name])
            continue
        last += 1 + ((last + 1) % 2 != event.controllable)
        last += 2 * (last == SILENT)
        labels.append(last)
    return labels


def _is_label(event: Event) -> bool:
    name = event.name
    if not (name.isascii() and name.isdigit() and len(name) <= len(str(MAX_LABEL)) and str(int(name)) == name):
        return False
    return int(name) <= MAX_LABEL and (int(name) % 2 == 1) == event.controllable


def _check_alphabet(c: Parts, by_name: dict[str, int], known: Alphabet) -> None:
    for event in c.alphabet:
        if event.name not in by_name:
            raise InputError(f"event {event.name!r} of automaton {c.name!r} is not in the given alphabet")
    c.alphabet | known  # an event with two meanings


def _from_initial(c: Parts) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the number of each state, the initial one's being 0, and the states in the order of their numbers."""
    order = np.arange(len(c.marked))
    if c.initial and (first := c.initial[0]):
        order[1 : first + 1], order[0] = np.arange(first), first
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return number, order


def _names(c: Parts, label: NDArray[np.int64], order: NDArray[np.int64], size: int) -> Names | None:
    """Return what the numbers do not say, or None if they say all."""
    read = list(map(event_of, label.tolist()))
    ordered = replace(c, states=[c.states[q] for q in order.tolist()])
    if size == len(order) and (size or not read) and (np.diff(label) > 0).all():
        return beside(ordered, read, list(map(str, range(size))))
    events = tuple((r.name, e) for r, e in zip(read, c.alphabet, strict=True))
    return Names(events, tuple(ordered.states), size - len(order))
