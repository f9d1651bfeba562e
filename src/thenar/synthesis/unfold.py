"""From sets of states to states: the explicit form of a symbolic supervisor."""

from __future__ import annotations

import numpy as np

from thenar.errors import InputError
from thenar.explicit.exploration import Exploration, ticker
from thenar.explicit.rows import row_offsets
from thenar.model.automaton import Automaton
from thenar.model.names import Composed, Layout, Numbered, StateNames
from thenar.model.supervisor import Supervisor
from thenar.symbolic.levels import Part
from thenar.symbolic.synthesis import SymbolicSupervisor

__all__ = ["unfold"]

IDENTITY = 1


def unfold(supervisor: SymbolicSupervisor) -> Supervisor:
    """Return ``supervisor`` state by state, numbered breadth-first in the order of the alphabet.

    Time and memory grow with its states and transitions.  Raises InputError where it is no deterministic
    automaton: several initial states, or an event with several outcomes.
    """
    encoding, states = supervisor.encoding, supervisor.controlled
    forest, alphabet = encoding.forest, encoding.alphabet
    n = supervisor.n_states
    if n == 0:
        return Supervisor(Automaton.empty(alphabet), np.zeros(1, np.int64), np.zeros(0, np.int32))
    first, _ = forest.steps(states, states & encoding.initial, IDENTITY)
    if len(first) > 1:
        raise InputError(f"the supervisor has {len(first):,} initial states; an automaton has one")
    found = []
    off = []
    for e in encoding.events:
        k = alphabet.index(e.name)
        enabled = states & supervisor.enabled(e)
        sources, targets = forest.steps(states, enabled, e.relation)
        if e.choice and len(np.unique(sources)) < len(sources):
            raise InputError(f"event {e.name!r} may lead from one state to several; an automaton is deterministic")
        found.append(np.stack([sources, np.full(len(sources), k, np.uint32), targets]))
        where, _ = forest.steps(states, states & e.possible - enabled, IDENTITY)
        off.append(np.stack([where, np.full(len(where), k, np.uint32)]))
    q, e, t = np.concatenate(found, axis=1).astype(np.int64)
    order = np.lexsort((e, q))
    marked, _ = forest.steps(states, states & encoding.marked, IDENTITY)
    marks = np.zeros(n, np.bool_)
    marks[marked] = True
    offsets = row_offsets(np.bincount(q, minlength=n))
    events, targets32 = e[order].astype(np.int32), t[order].astype(np.int32)
    whole = Automaton("supC", alphabet, int(first[0]), offsets, events, targets32, marks, Numbered(np.arange(n)))
    tick = ticker()
    numbered = Exploration((whole,), (), alphabet, tick)
    extract = numbered.extract("supC", tick)
    origin = numbered.coordinates(extract.origin)[:, 0]
    place = np.empty(n, np.int64)
    place[origin] = np.arange(n)  # all are reachable
    where, event = np.concatenate(off, axis=1).astype(np.int64)
    where = place[where]
    order = np.lexsort((event, where))
    a = extract.automaton
    names = _names(encoding.parts, supervisor.vectors(n)[origin])
    automaton = Automaton("supC", alphabet, a.initial, a.offsets, a.events, a.targets, a.marked, names)
    return Supervisor(automaton, row_offsets(np.bincount(where, minlength=n)), event[order].astype(np.int32))


def _names(parts: list[Part], vectors: np.ndarray[tuple[int, int], np.dtype[np.uint32]]) -> StateNames:
    """Return names put together from those of the parts when someone looks."""
    words, shifts, bits = [], [], []
    word = shift = 0
    for part in parts:
        width = max(1, (part.size - 1).bit_length())
        if shift + width > 64:
            word, shift = word + 1, 0
        words.append(word)
        shifts.append(shift)
        bits.append(width)
        shift += width
    keys = np.zeros((len(vectors), word + 1), np.uint64)
    for column, w, s in zip(vectors.T, words, shifts, strict=True):
        keys[:, w] |= column.astype(np.uint64) << np.uint64(s)
    return Composed(
        tuple(p.labels for p in parts),
        tuple(p.name for p in parts),
        Layout(tuple(words), tuple(shifts), tuple(bits)),
        keys,
    )
