"""Products: automata that run together."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from thenar.errors import InputError
from thenar.explicit.exploration import Exploration, common_alphabet, ticker
from thenar.explicit.rows import row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.limits import Limits, Progress

__all__ = ["meet", "selfloop", "shuffle", "sync"]


def sync(
    *automata: Automaton, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return the synchronous product A1 || ... || An, its reachable part, numbered breadth-first.

    An event happens when every automaton that has it in its alphabet can do it; a state is marked when all
    components are.  The product is built n-way in one pass, never pairwise; states are named when looked at.
    Time and memory O(reachable transitions).

    Raises AlphabetClash if an event has two meanings, LimitReached at a limit.   [Wonham and Cai 2019, sec. 3.3]

    >>> a = Automaton.from_transitions(["0 -work-> 1 -meet-> 0"], initial="0", marked=["0"], name="A")
    >>> b = Automaton.from_transitions(["0 -rest-> 1 -meet-> 0"], initial="0", marked=["0"], name="B")
    >>> both = sync(a, b)
    >>> both, both.states[3]
    (Automaton 'A||B': 4 states (1 marked), 5 transitions, 3 events, '1|1')
    """
    return _product(automata, "||", name, limits, progress, blocking=False)


def meet(
    *automata: Automaton, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return A1 x ... x An with L = L(A1) ∩ ... ∩ L(An) and Lm likewise, over the union of the alphabets.

    Unlike in :func:`sync`, an event outside an automaton's alphabet is one that it blocks.  Numbering, cost and
    errors as for :func:`sync`.

    >>> a = Automaton.from_transitions(["0 -x-> 0 -y-> 0"], initial="0", marked=["0"])
    >>> b = Automaton.from_transitions(["0 -x-> 1 -z-> 0"], initial="0", marked=["1"])
    >>> list(meet(a, b).transitions())
    [('0|0', 'x', '0|1')]
    """
    return _product(automata, "∩", name, limits, progress, blocking=True)


def shuffle(
    *automata: Automaton, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return the shuffle product: all interleavings of automata whose alphabets are disjoint.

    Raises InputError naming an event that two of them share (their shuffle need not be deterministic),
    LimitReached at a limit.  O(states x transitions) of all.

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"], name="A")
    >>> b = Automaton.from_transitions(["0 -y-> 1"], initial="0", marked=["1"], name="B")
    >>> shuffle(a, b)
    Automaton 'A⧢B': 4 states (1 marked), 4 transitions, 2 events
    """
    seen: dict[str, str] = {}
    for a in automata:
        for e in a.alphabet.names:
            if e in seen:
                raise InputError(
                    f"shuffle: event {e!r} is in both {seen[e]!r} and {a.name!r}; alphabets must be disjoint (see sync)"
                )
        seen |= dict.fromkeys(a.alphabet.names, a.name)
    return _product(automata, "⧢", name, limits, progress, blocking=False)


def selfloop(automaton: Automaton, events: Iterable[Event | str] | Alphabet, name: str = "") -> Automaton:
    """Return ``automaton`` with each of ``events`` looped at every state: it no longer has a say in them.

    The new events come after its own in the alphabet.  Raises InputError if one is in the alphabet already.

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0")
    >>> list(selfloop(a, ["y"]).transitions())
    [('0', 'x', '1'), ('0', 'y', '0'), ('1', 'y', '1')]
    """
    new = Alphabet(events)
    for e in new.names:
        if e in automaton.alphabet:
            raise InputError(f"selfloop: event {e!r} is in the alphabet of {automaton.name!r} already")
    n, k = automaton.n_states, len(new)
    degree = np.diff(automaton.offsets)
    offsets = row_offsets(degree + k)
    own = np.arange(automaton.n_transitions) + k * sources(automaton)
    looped = (offsets[1:, None] - k + np.arange(k)).ravel()
    columns = np.empty((2, automaton.n_transitions + n * k), np.int32)
    columns[:, own] = automaton.events, automaton.targets
    columns[0, looped] = np.tile(np.arange(k) + len(automaton.alphabet), n)
    columns[1, looped] = np.repeat(np.arange(n), k)
    return Automaton(
        name or automaton.name,
        automaton.alphabet | new,
        automaton.initial,
        offsets,
        columns[0],
        columns[1],
        automaton.marked,
        automaton.states,
        meaning=automaton.meaning,
    )


def _product(
    automata: tuple[Automaton, ...],
    sign: str,
    name: str,
    limits: Limits | None,
    progress: Progress | None,
    *,
    blocking: bool,
) -> Automaton:
    if not automata:
        raise InputError("a product needs at least one automaton")
    name = name or sign.join(a.name for a in automata)
    alphabet = common_alphabet(automata)
    if any(a.is_empty for a in automata):
        return Automaton.empty(alphabet, name)
    tick = ticker(limits, progress)
    return Exploration(automata, (), alphabet, tick, blocking=blocking).extract(name, tick).automaton
