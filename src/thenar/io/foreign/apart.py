"""An automaton taken apart for those who write it: plain columns, and what a file calls its states and events."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.io.foreign.assemble import columns
from thenar.io.foreign.written import Names
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.expressions import TRUE
from thenar.model.extended import ExtendedAutomaton
from thenar.model.names import every_name

__all__ = ["Parts", "apart", "beside", "by_pair", "said"]

BLOCK = 512  # states, or pairs of states, a piece of a file: some ten kilobytes


@dataclass(frozen=True, slots=True)
class Parts:
    """The columns of an automaton: transition k leads from ``sources[k]`` with ``events[k]`` to ``targets[k]``."""

    name: str
    alphabet: Alphabet
    states: Sequence[str]
    initial: Sequence[int]
    marked: NDArray[np.bool_]
    sources: NDArray[np.int64]
    events: NDArray[np.int64]
    targets: NDArray[np.int64]
    meaning: str


def apart(automaton: Automaton | ExtendedAutomaton, kind: str) -> Parts:
    """Return the columns of ``automaton``; transitions by source, then event.  ``kind`` of file is for the message.

    Raises InputError for guards and updates, which no file of one automaton here can say.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", name="LAMP")
    >>> parts = apart(lamp, "a drawing")
    >>> parts.states, parts.initial, parts.targets.tolist()
    (['off', 'lit'], [0], [1, 0])
    """
    if isinstance(automaton, Automaton):
        states = list(every_name(automaton.states))
        initial = [] if automaton.is_empty else [automaton.initial]
        rows = columns(automaton)
    else:
        for k, edge in enumerate(automaton.edges):
            if edge.guard != TRUE or edge.updates:
                place = f"automaton {automaton.name!r}, {automaton.place(k)}"
                raise InputError(f"{place}: {kind} has no guards and updates; write a .toml, .cif or .wmod file")
        states = list(automaton.states)
        initial = [q for q, first in enumerate(automaton.initial) if first]
        s, e, t = np.unique(np.stack(columns(automaton), axis=1), axis=0).T  # sorted, each once
        rows = s, e, t
    marked = np.asarray(automaton.marked, np.bool_)
    return Parts(automaton.name, automaton.alphabet, states, initial, marked, *rows, automaton.meaning)


def said(names: Sequence[str], sayable: Callable[[str], bool], letter: str) -> list[str]:
    """Return what a file calls ``names``: themselves, or ``letter`` and position where it cannot say them.

    The names returned differ from one another.

    >>> said(["idle", "at work", "s1", "idle"], str.isidentifier, "s")
    ['idle', 's1_', 's1', 's3']
    """
    given = set(names)
    if len(given) == len(names) and all(map(sayable, names)):
        return list(names)
    called: dict[str, None] = {}
    for k, name in enumerate(names):
        if name in called or not sayable(name):
            name = f"{letter}{k}"  # noqa: PLW2901
            while name in given or name in called:
                name += "_"  # noqa: PLW2901
        called[name] = None
    return list(called)


def beside(parts: Parts, read: Sequence[Event], states: Sequence[str], *, unsaid: bool = False) -> Names | None:
    """Return the table that makes ``parts`` of a file whose reader finds the events ``read`` and ``states``.

    None if that is what they are already, and nothing else is ``unsaid``.
    """
    same = all(r == e and r.meaning == e.meaning for r, e in zip(read, parts.alphabet, strict=True))
    if same and not unsaid and list(states) == list(parts.states):
        return None
    return Names(tuple((r.name, e) for r, e in zip(read, parts.alphabet, strict=True)), tuple(parts.states))


def by_pair(parts: Parts) -> Iterator[list[tuple[int, int, list[int]]]]:
    """Yield, some hundred at a time, each pair of states (source, target) with the events that lead across it."""
    order = np.lexsort((parts.events, parts.targets, parts.sources))
    s, e, t = parts.sources[order], parts.events[order], parts.targets[order]
    new = np.ones(len(s), np.bool_)
    new[1:] = (np.diff(s) != 0) | (np.diff(t) != 0)
    starts = np.flatnonzero(new)
    ends = np.append(starts[1:], len(s))
    for k in range(0, len(starts), BLOCK):
        lo, hi = starts[k : k + BLOCK], ends[k : k + BLOCK]
        base = int(lo[0])
        events = e[base : int(hi[-1])].tolist()
        cuts = zip((lo - base).tolist(), (hi - base).tolist(), strict=True)
        yield [(a, b, events[i:j]) for a, b, (i, j) in zip(s[lo].tolist(), t[lo].tolist(), cuts, strict=True)]
