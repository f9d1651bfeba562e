"""Reachability: which states can be entered, from which a marked one can be, and by what trace."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thenar._native import kernel
from thenar.errors import InputError
from thenar.explicit.exploration import Exploration, ticker
from thenar.explicit.products import sync
from thenar.explicit.rows import bytemask, row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.limits import Limits, Progress
from thenar.model.trace import Check, Trace

__all__ = ["coreachable", "is_nonblocking", "is_nonconflicting", "reachable", "shortest_trace", "trim"]


def reachable(automaton: Automaton) -> Automaton:
    """Return the part that can be reached from the initial state, numbered breadth-first.  O(|δ|).

    Two automata are isomorphic exactly if their reachable parts have the same arrays.

    >>> a = Automaton.from_transitions(["lost -x-> 1", "0 -x-> 1"], initial="0")
    >>> [reachable(a).states[q] for q in range(2)]
    ['0', '1']
    """
    if automaton.is_empty:
        return automaton
    tick = ticker()
    part = Exploration((automaton,), (), automaton.alphabet, tick).extract(automaton.name, tick).automaton
    return replace(part, meaning=automaton.meaning)


def coreachable(automaton: Automaton) -> Automaton:
    """Return the part from which a marked state can be reached; states keep their order.  O(|δ|).

    Empty if no marked state can be reached from the initial one.

    >>> a = Automaton.from_transitions(["0 -x-> 1", "0 -y-> dead"], initial="0", marked=["1"])
    >>> coreachable(a)
    Automaton: 2 states (1 marked), 1 transition, 2 events
    """
    return restrict(automaton, distance_to_marked(automaton) >= 0)


def trim(automaton: Automaton) -> Automaton:
    """Return the part that is reachable and coreachable, numbered breadth-first.  O(|δ|).

    >>> a = Automaton.from_transitions(["0 -x-> 1", "0 -y-> dead", "lost -x-> 1"], initial="0", marked=["1"])
    >>> trim(a)
    Automaton: 2 states (1 marked), 1 transition, 2 events
    """
    return reachable(coreachable(automaton))


def is_nonblocking(automaton: Automaton) -> Check:
    """Return whether every string of L(G) can be completed to one of Lm(G): L(G) = prefix closure of Lm(G).

    The witness is a shortest trace to a state from which no marked state can be reached.  O(|δ|).

    >>> a = Automaton.from_transitions(["0 -x-> 1", "0 -y-> dead"], initial="0", marked=["1"])
    >>> print(is_nonblocking(a))
    nonblocking: no after y: no marked state can be reached from state 'dead'
    """
    states = path_to(automaton, distance_to_marked(automaton) < 0)
    if states is None:
        return Check("nonblocking", True)
    trace, q = states
    return Check("nonblocking", False, trace, f"no marked state can be reached from state {automaton.states[q]!r}")


def is_nonconflicting(*automata: Automaton, limits: Limits | None = None, progress: Progress | None = None) -> Check:
    """Return whether the synchronous product of ``automata`` is nonblocking.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2"], initial="0", marked=["2"])
    >>> b = Automaton.from_transitions(["0 -y-> 1 -x-> 2"], initial="0", marked=["2"])
    >>> print(is_nonconflicting(a, b))
    nonconflicting: no after ε: no marked state can be reached from state '0|0'
    """
    check = is_nonblocking(sync(*automata, limits=limits, progress=progress))
    return Check("nonconflicting", check.holds, check.witness, check.reason)


def shortest_trace(automaton: Automaton, to: str | int | None = None) -> Trace | None:
    """Return a shortest trace from the initial state to the state ``to``, or to any marked state.

    None if there is none.  Among the shortest it is the first in the order of the alphabet.  O(|δ|).

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2", "0 -z-> 2"], initial="0", marked=["2"])
    >>> shortest_trace(a), shortest_trace(a, to="1")
    (Trace('z'), Trace('x'))
    """
    goal = automaton.marked if to is None else np.arange(automaton.n_states) == automaton.state(to)
    found = path_to(automaton, goal)
    return found and found[0]


def restrict(automaton: Automaton, keep: NDArray[np.bool_]) -> Automaton:
    """Return the automaton on the states of the mask ``keep``, in their order; empty without the initial state."""
    if automaton.is_empty or not keep[automaton.initial]:
        return Automaton.empty(automaton.alphabet, automaton.name)
    number = np.cumsum(keep) - 1
    source = sources(automaton)
    kept = keep[source] & keep[automaton.targets]
    degree = np.bincount(source[kept], minlength=automaton.n_states)[keep]
    return Automaton(
        automaton.name,
        automaton.alphabet,
        int(number[automaton.initial]),
        row_offsets(degree),
        automaton.events[kept],
        number[automaton.targets[kept]].astype(np.int32),
        automaton.marked[keep],
        automaton.states.take(np.flatnonzero(keep)),
        meaning=automaton.meaning,
    )


def distance_to_marked(automaton: Automaton) -> NDArray[np.int32]:
    """Return (n_states,) int32: events on a shortest way to a marked state, -1 where there is none."""
    a = automaton
    return kernel.distance_to(a.offsets, a.events, a.targets, bytemask(a.marked), ticker())


def path_to(automaton: Automaton, goal: ArrayLike) -> tuple[Trace, int] | None:
    """Return a shortest trace to a state of the mask ``goal``, and that state; None if there is none."""
    if automaton.is_empty:
        return None
    mask = bytemask(goal)
    if len(mask) != automaton.n_states:
        raise InputError(f"a mask of {len(mask)} states for an automaton of {automaton.n_states}")
    a = automaton
    path = kernel.shortest_path(a.offsets, a.events, a.targets, a.initial, mask, ticker())
    if path is None:
        return None
    trace = Trace(automaton.alphabet[int(automaton.events[k])].name for k in path)
    return trace, int(automaton.targets[path[-1]]) if path else automaton.initial
