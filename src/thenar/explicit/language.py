"""Languages: what strings an automaton stands for, whatever its states."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.explicit.exploration import Exploration, ticker
from thenar.explicit.reach import reachable
from thenar.explicit.rows import bytemask, entries, row_offsets, rows_in_order_of, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.limits import Limits, Progress
from thenar.model.names import Grouped, Listed, StateNames
from thenar.model.trace import Check, Trace

__all__ = ["complement", "is_isomorphic", "is_sublanguage", "minimize", "project"]


def project(
    automaton: Automaton,
    events: Iterable[str] | Alphabet,
    *,
    name: str = "",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return the natural projection P: Σ* → Σ0* onto ``events``, as a deterministic automaton.

    L and Lm of the result are the images of those of ``automaton``; all other events are erased.  A state
    stands for the set of states in which the automaton may be; it is marked if one of them is.  The subset
    construction takes O(2^|Q|) in the worst case: give ``limits``.  Not minimal: see :func:`minimize`.

    Raises UnknownName for an event outside the alphabet.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2", "0 -z-> 2"], initial="0", marked=["2"])
    >>> list(project(a, ["y"]).transitions())
    [('{0, 1, 2}', 'y', '2')]
    """
    alphabet = automaton.alphabet.restrict(e if isinstance(e, str) else e.name for e in events)
    if automaton.is_empty:
        return Automaton.empty(alphabet, name)
    hidden = bytemask([e.name not in alphabet for e in automaton.alphabet])
    offsets, labels, targets, marked, member_offsets, members = kernel.project(
        automaton.offsets,
        automaton.events,
        automaton.targets,
        len(automaton.alphabet),
        automaton.initial,
        bytemask(automaton.marked),
        hidden,
        ticker(limits, progress),
    )
    place = np.cumsum(hidden == 0, dtype=np.int32) - 1
    states = Grouped(automaton.states, member_offsets, members)
    return Automaton(
        name or automaton.name, alphabet, 0, offsets, place[labels], targets, marked.view(np.bool_), states
    )


def minimize(automaton: Automaton) -> Automaton:
    """Return the smallest automaton with the same closed and marked behaviour, numbered breadth-first.

    Unreachable states are dropped; a state from which nothing can be completed is kept, since it is part of
    the closed behaviour.  O(|δ| log |Q|).   [Hopcroft 1971; Valmari, IPL 112(6), 2012]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 0", "0 -z-> 2 -y-> 0"], initial="0", marked=["0"])
    >>> minimize(a), minimize(a).states[1]
    (Automaton: 2 states (1 marked), 3 transitions, 3 events, '{1, 2}')
    """
    a = reachable(automaton)
    if a.is_empty:
        return a
    block = kernel.minimize(a.offsets, a.events, a.targets, len(a.alphabet), bytemask(a.marked), ticker())
    order = np.argsort(block, kind="stable")
    sizes = np.bincount(block)
    member_offsets = row_offsets(sizes)
    chosen = order[member_offsets[:-1]]  # any member will do
    edge = entries(a.offsets, chosen)
    quotient = Automaton(
        a.name,
        a.alphabet,
        int(block[a.initial]),
        row_offsets(np.diff(a.offsets)[chosen]),
        a.events[edge],
        block[a.targets[edge]],
        a.marked[chosen],
        Grouped(a.states, member_offsets, order),
        meaning=a.meaning,
    )
    return reachable(quotient)


def complement(automaton: Automaton, name: str = "") -> Automaton:
    """Return an automaton with L = Σ* and Lm = Σ* minus Lm(automaton).

    A state called ``dump`` (with primes, should the name be taken) is added where a transition is missing, also
    to the empty automaton.  O(|Q||Σ|).

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"])
    >>> [complement(a).marks(s) for s in ("ε", "x", "x, x")]
    [True, False, True]
    """
    n, k = automaton.n_states, len(automaton.alphabet)
    table = np.full((n + 1, k), n, np.int32)
    table[sources(automaton), automaton.events] = automaton.targets
    full = n + bool((table[:n] == n).any() or n == 0)
    return Automaton(
        name or automaton.name,
        automaton.alphabet,
        max(automaton.initial, 0),
        np.arange(full + 1, dtype=np.int64) * k,
        np.tile(np.arange(k, dtype=np.int32), full),
        table[:full].ravel(),
        np.concatenate((~automaton.marked, [True]))[:full],
        automaton.states if full == n else _with_dump(automaton.states),
    )


def _with_dump(states: StateNames) -> StateNames:
    names = tuple(states[q] for q in range(len(states)))
    dump = "dump"
    while dump in names:
        dump += "'"
    return Listed((*names, dump))


def is_sublanguage(
    a: Automaton, b: Automaton, *, limits: Limits | None = None, progress: Progress | None = None
) -> Check:
    """Return whether L(a) ⊆ L(b) and Lm(a) ⊆ Lm(b), over the union of their alphabets.

    The witness is a shortest string of ``a`` that is not in ``b``, or marked in ``a`` only.  O(|δ|) of the product.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 0"], initial="0", marked=["0"])
    >>> b = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["0"])
    >>> print(is_sublanguage(a, b))
    sublanguage: no after x, y: it is in L of the first only
    """
    if a.is_empty:
        return Check("sublanguage", True)
    if b.is_empty:
        return Check("sublanguage", False, Trace(), "it is in L of the first only")
    alphabet = a.alphabet | b.alphabet
    everything = np.ones(len(alphabet), np.uint8)
    tick = ticker(limits, progress)
    both = Exploration((a,), (b,), alphabet, tick, uncontrollable=everything, blocking=True)
    in_a, in_b = both.coordinates(np.arange(both.n_states)).T
    marked_only = both.shortest(a.marked[in_a] & ~b.marked[in_b])
    leaving = both.shortest(both.native.illegal)
    if marked_only is not None and (leaving is None or len(marked_only) <= len(leaving)):
        return Check("sublanguage", False, Trace(e for e, _ in marked_only), "it is in Lm of the first only")
    if leaving is None:
        return Check("sublanguage", True)
    end = leaving[-1][1] if leaving else 0
    b_can = {e.name for e in b.enabled(int(in_b[end]))}
    event = next(e.name for e in a.enabled(int(in_a[end])) if e.name not in b_can)
    return Check("sublanguage", False, Trace([*(e for e, _ in leaving), event]), "it is in L of the first only")


def is_isomorphic(a: Automaton, b: Automaton) -> Check:
    """Return whether the reachable parts of ``a`` and ``b`` are the same up to the names of their states.

    The alphabets must hold the same events; their order does not matter.  O(|δ|).  The witness is a shortest
    string that only one of them generates, or marks, where there is one.

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"])
    >>> b = Automaton.from_transitions(["p -x-> q -x-> q"], initial="p", marked=["q"])
    >>> print(is_isomorphic(a, b))
    isomorphic: no after x, x: it is in L of the second only
    """
    if set(a.alphabet) != set(b.alphabet):
        only = sorted({e.name for e in set(a.alphabet) ^ set(b.alphabet)})
        return Check("isomorphic", False, None, f"the alphabets differ in {', '.join(only)}")
    first, second = (reachable(_reordered(x, a.alphabet)) for x in (a, b))
    fields = ("offsets", "events", "targets", "marked")
    if all(np.array_equal(getattr(first, f), getattr(second, f)) for f in fields):
        return Check("isomorphic", True)
    for x, y, which in ((first, second, "first"), (second, first, "second")):
        if not (check := is_sublanguage(x, y)):
            return Check("isomorphic", False, check.witness, check.reason.replace("first", which))
    return Check(
        "isomorphic", False, None, "the languages are the same, but one merges states that the other tells apart"
    )


def _reordered(automaton: Automaton, alphabet: Alphabet) -> Automaton:
    if automaton.alphabet == alphabet:
        return automaton
    events, targets = rows_in_order_of(alphabet, automaton)
    offsets: NDArray[np.int64] = automaton.offsets
    return Automaton(
        automaton.name, alphabet, automaton.initial, offsets, events, targets, automaton.marked, automaton.states
    )
