"""Operations on the languages of automata beyond products: union, concatenation, iteration, quotients, their likes.

An automaton stands for two languages, its closed behaviour L and its marked behaviour Lm ⊆ L; each function says what
both become.  The results are deterministic, numbered breadth-first in the order of the alphabet, and not minimal: see
:func:`~thenar.explicit.language.minimize`.  The intersection of languages is :func:`~thenar.explicit.products.meet`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.explicit.exploration import Exploration, common_alphabet, ticker
from thenar.explicit.nondeterminism import Moves, subsets
from thenar.explicit.products import selfloop
from thenar.explicit.reach import distance_to_marked, reachable, trim
from thenar.explicit.rows import entries, row_offsets, rows_in_order_of, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.limits import Limits, Progress
from thenar.model.names import Composed, Layout

__all__ = [
    "concatenation",
    "difference",
    "inverse_project",
    "kleene_star",
    "left_quotient",
    "prefix_closure",
    "quotient",
    "reverse",
    "union",
]

_PAIRS = Layout((0, 1), (0, 0), (32, 32))  # a word for each of two states


def inverse_project(automaton: Automaton, events: Iterable[Event | str] | Alphabet, *, name: str = "") -> Automaton:
    """Return the inverse projection P⁻¹, where P: (Σ ∪ Σ0)* → Σ* erases those of ``events``, Σ0, that Σ lacks.

    L and Lm of the result are the strings that P maps to L and Lm: in each state the missing events are looped.
    ``events`` may be in the alphabet already; the new ones come after it.  The synchronous product is the
    meet of the inverse projections to the common alphabet.  O(|δ| + |Q||Σ0|).   [Wonham and Cai 2019, sec. 3.3]

    Raises InputError for a text in place of a list, AlphabetClash for an event with two meanings.

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"])
    >>> lifted = inverse_project(a, ["x", "y"])
    >>> list(lifted.transitions()), lifted.marks("y, x, y")
    ([('0', 'x', '1'), ('0', 'y', '0'), ('1', 'y', '1')], True)
    """
    if isinstance(events, str):
        raise InputError(f"inverse_project: events is a list, not the text {events!r}")
    given = Alphabet(e for e in events if isinstance(e, Event) or e not in automaton.alphabet)
    wider = automaton.alphabet | given
    return selfloop(reachable(automaton), wider[len(automaton.alphabet) :], name or automaton.name)


def union(
    *automata: Automaton, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return A1 ∪ ... ∪ An: L and Lm are the unions of those of ``automata``, over the union of their alphabets.

    An automaton that cannot go on drops out, the others stay: a state stands for the states of those that are left,
    called ``{A1.x, A2.y}``.  O(|Q1| ··· |Qn| |Σ|) in the worst case.

    Raises InputError for no automata, AlphabetClash for an event with two meanings, LimitReached at a limit.
    [Hopcroft, Motwani and Ullman 2006, sec. 4.2]

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"], name="A")
    >>> b = Automaton.from_transitions(["0 -x-> 1 -y-> 0"], initial="0", marked=["0"], name="B")
    >>> both = union(a, b)
    >>> both, [both.marks(s) for s in ("ε", "x", "x, y", "x, y, x")]
    (Automaton 'A∪B': 4 states (3 marked), 4 transitions, 2 events, [True, True, True, False])
    """
    _some(automata, "union")
    return subsets(Moves.of(*automata), name or _joined(automata, "∪"), limits, progress)


def concatenation(
    *automata: Automaton, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return A1 A2 ... An: a string of Lm(A1), then one of Lm(A2), and so on.

    For two automata Lm = Lm(A1) Lm(A2) and L = L(A1) ∪ Lm(A1) L(A2): what can happen while that is done, dead
    ends included; for more of them, the same again.  A state stands for a set of their states: where one string
    ends and the next begins need not be known yet.  The alphabet is the union.  O(|Q1| 2^(|Q2| + ... + |Qn|)) in
    the worst case: give ``limits``.

    Raises InputError for no automata, AlphabetClash for an event with two meanings, LimitReached at a limit.
    [Hopcroft, Motwani and Ullman 2006, sec. 3.2]

    >>> a = Automaton.from_transitions(["0 -x-> 0"], initial="0", marked=["0"], name="A")
    >>> b = Automaton.from_transitions(["0 -x-> 1 -y-> 2"], initial="0", marked=["2"], name="B")
    >>> list(concatenation(a, b).transitions())[0]
    ('{A.0, B.0}', 'x', '{A.0, B.0, B.1}')
    >>> concatenation(a, b).marks("x, x, x, y"), concatenation(a, b).marks("x, x")
    (True, False)
    """
    _some(automata, "concatenation")
    moves = Moves.of(*automata)
    begins = row_offsets([a.n_states for a in automata])
    for a, b, k in zip(automata, automata[1:], range(len(automata)), strict=False):
        if not b.is_empty:
            ends = np.flatnonzero(a.marked) + begins[k]
            moves = moves.silently(ends, np.full(len(ends), b.initial + begins[k + 1]))
    first, last = automata[0], np.arange(begins[-1]) >= begins[-2]
    initial = np.array([] if first.is_empty else [first.initial], np.int64)
    moves = replace(moves, initial=initial, marked=moves.marked & last)
    return subsets(moves, name or _joined(automata, "·"), limits, progress)


def kleene_star(
    automaton: Automaton, *, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return A*: any number of strings of Lm(A), one after the other, also none.

    Lm = Lm(A)* and L = {ε} ∪ Lm(A)* L(A).  ε is marked, also if A is empty or marks nothing: the state ``start``
    (with primes, should the name be taken) stands for the end of a string.  O(2^|Q|) in the worst case: give
    ``limits``.

    Raises LimitReached at a limit.   [Kleene 1956; Hopcroft, Motwani and Ullman 2006, sec. 3.2]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2"], initial="0", marked=["2"], name="A")
    >>> star = kleene_star(a)
    >>> star, [star.marks(s) for s in ("ε", "x", "x, y", "x, y, x, y")]
    (Automaton 'A*': 3 states (2 marked), 3 transitions, 2 events, [True, False, True, True])
    """
    a, start = automaton, automaton.n_states
    moves = Moves.of(replace(a, marked=np.zeros(a.n_states, np.bool_))).and_state("start", marked=True)
    ends = np.flatnonzero(a.marked)
    moves = moves.silently(ends, np.full(len(ends), start)).silently(np.full(len(moves.initial), start), moves.initial)
    title = name or (f"{a.name}*" if a.name else "")
    return subsets(replace(moves, initial=np.array([start])), title, limits, progress)


def prefix_closure(automaton: Automaton, *, name: str = "") -> Automaton:
    """Return an automaton with L = Lm = the prefixes of Lm(A): its trim part, all states marked.

    What cannot be completed to a marked string is gone; nothing is left if nothing is marked.  (L(A) as a marked
    language is A with every state marked, the prefix closure of that is L(A).)  O(|δ|).

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2", "1 -z-> dead"], initial="0", marked=["2"])
    >>> closed = prefix_closure(a)
    >>> closed.marks("x"), closed.generates("x, z")
    (True, False)
    """
    part = trim(automaton)
    return replace(part, marked=np.ones(part.n_states, np.bool_), name=name or automaton.name, meaning="")


def difference(
    a: Automaton, b: Automaton, *, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return A ∖ B: Lm = Lm(A) ∖ Lm(B), and L = L(A), over the union of their alphabets.

    L does not shrink: what is not marked any more can still happen; see :func:`~thenar.explicit.reach.trim`.  A state
    is a pair; where B cannot follow it is in a state ``dump`` (with primes, should the name be taken), and A goes on.
    O(|δA| |QB|) in the worst case; the states that count against ``limits`` are those of A ∩ B.

    Raises AlphabetClash for an event with two meanings, LimitReached at a limit.

    >>> a = Automaton.from_transitions(["0 -x-> 0 -y-> 1"], initial="0", marked=["0", "1"], name="A")
    >>> b = Automaton.from_transitions(["0 -x-> 0"], initial="0", marked=["0"], name="B")
    >>> rest = difference(a, b)
    >>> [rest.marks(s) for s in ("x", "y", "x, y")], rest.generates("x")
    ([False, True, True], True)
    """
    alphabet = common_alphabet([a, b])
    title = name or _joined((a, b), "∖")
    alone, mate, dump = _widened(a, alphabet), _with_dump(_widened(b, alphabet)), b.n_states
    if a.is_empty or b.is_empty:
        return reachable(replace(alone, name=title, meaning=""))
    tick = ticker(limits, progress)
    exploration = Exploration((alone, mate), (), alphabet, tick, blocking=True)
    pairs = exploration.extract("", tick)
    both, n = pairs.automaton, pairs.automaton.n_states
    in_a, in_b = exploration.coordinates(pairs.origin).T
    # first the pairs, each with the row of its state of A, then the states of A beside the dump
    degree, edge = np.diff(alone.offsets), entries(alone.offsets, in_a)
    target, k = alone.targets[edge] + n, len(alphabet)
    every = np.repeat(np.arange(n), degree[in_a]) * k + alone.events[edge]
    target[np.searchsorted(every, sources(both) * k + both.events)] = both.targets
    local = np.stack((np.append(in_a, np.arange(a.n_states)), np.append(in_b, np.full(a.n_states, dump))), axis=1)
    rest = Automaton(
        title,
        alphabet,
        0,
        row_offsets(degree[local[:, 0]]),
        np.append(alone.events[edge], alone.events),
        np.append(target, alone.targets + n).astype(np.int32),
        a.marked[local[:, 0]] & ~mate.marked[local[:, 1]],
        Composed((a.states, mate.states), (a.name, b.name), _PAIRS, local.astype(np.uint64)),
    )
    return reachable(rest)


def quotient(
    a: Automaton, b: Automaton, *, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return the right quotient A / B: what can be completed by a string of B.

    Lm = Lm(A) / Lm(B) = {s | st ∈ Lm(A) for a t ∈ Lm(B)}, and L = L(A) / L(B), which is L(A) unless B is empty.
    So it is A with other marks: a state is marked if a string of Lm(B) leads from it to a marked one.  Its alphabet is
    that of A.  O(|δA| |QB|) in the worst case; the states that count against ``limits`` are pairs.

    Raises AlphabetClash for an event with two meanings, LimitReached at a limit.
    [Hopcroft and Ullman 1979, sec. 3.2]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2 -z-> 3"], initial="0", marked=["3"])
    >>> b = Automaton.from_transitions(["0 -y-> 1 -z-> 2", "0 -z-> 2"], initial="0", marked=["2"])
    >>> [quotient(a, b).marks(s) for s in ("ε", "x", "x, y", "x, y, z")]
    [False, True, True, False]
    """
    title = name or _joined((a, b), "/")
    alphabet = common_alphabet([a, b])
    if a.is_empty or b.is_empty:
        return Automaton.empty(a.alphabet, title)
    # The product in two rounds: in the first A moves alone to any of its states, after the turn both move.
    rounds = Alphabet([*(f"{k}:{e}" for k in (1, 2) for e in alphabet.names), "turn"])
    wide_a, wide_b = _widened(a, alphabet), _widened(b, alphabet)
    k, wait, idle = len(alphabet), b.n_states, np.arange(len(alphabet))
    every = np.arange(a.n_states)
    moving = _assembled(
        rounds,
        np.concatenate((sources(a), sources(a), every)),
        np.concatenate((wide_a.events, wide_a.events + k, np.full(len(every), 2 * k))),
        np.concatenate((wide_a.targets, wide_a.targets, every)),
        a.marked,
        a.initial,
    )
    waiting = _assembled(
        rounds,
        np.concatenate((sources(b), np.full(k, wait), [wait])),
        np.concatenate((wide_b.events + k, idle, [2 * k])),
        np.concatenate((wide_b.targets, np.full(k, wait), [b.initial])),
        np.append(b.marked, False),
        wait,
    )
    tick = ticker(limits, progress)
    exploration = Exploration((moving, waiting), (), rounds, tick)
    pairs = exploration.extract("", tick)
    in_a, in_b = exploration.coordinates(pairs.origin).T
    marked = np.zeros(a.n_states, np.bool_)
    marked[in_a[(in_b == b.initial) & (distance_to_marked(pairs.automaton) >= 0)]] = True
    return reachable(replace(a, marked=marked, name=title, meaning=""))


def left_quotient(
    a: Automaton, b: Automaton, *, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return the left quotient B \\ A: what is left of A after a string of B.

    Lm = {t | st ∈ Lm(A) for an s ∈ Lm(B)} and L = {t | st ∈ L(A) for an s ∈ Lm(B)}; empty if no string of Lm(B)
    is in L(A).  If B marks one string only, that is A begun in another state.  Its alphabet is that of A.
    O(|δA| |QB|) for the states in which it may begin, then O(2^|QA|) in the worst case: give ``limits``.

    Raises AlphabetClash for an event with two meanings, LimitReached at a limit.   [Brzozowski 1964]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2 -z-> 3"], initial="0", marked=["3"])
    >>> b = Automaton.from_transitions(["0 -x-> 1 -y-> 2"], initial="0", marked=["1", "2"])
    >>> [left_quotient(a, b).marks(s) for s in ("y, z", "z", "x, y, z")]
    [True, True, False]
    """
    title = name or _joined((b, a), "\\")
    alphabet = common_alphabet([a, b])
    first = np.zeros(0, np.int64)
    if not (a.is_empty or b.is_empty):
        tick = ticker(limits, progress)
        both = Exploration((a, b), (), alphabet, tick, blocking=True)
        in_a, in_b = both.coordinates(np.arange(both.n_states)).T
        first = np.unique(in_a[b.marked[in_b]])
    return subsets(replace(Moves.of(a), initial=first), title, limits, progress)


def reverse(
    automaton: Automaton, *, name: str = "", limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return an automaton whose Lm are the strings of Lm(A) read backwards, and L the prefixes of these.

    It is trim, and minimal, since A is deterministic; so ``reverse(reverse(a))`` is the minimal trim automaton of
    Lm(A).  O(2^|Q|) in the worst case: give ``limits``.

    Raises LimitReached at a limit.   [Brzozowski 1962]

    >>> a = Automaton.from_transitions(["0 -x-> 0 -y-> 1"], initial="0", marked=["1"])
    >>> [reverse(a).marks(s) for s in ("y", "y, x, x", "x, y")]
    [True, True, False]
    """
    a = trim(automaton)
    m = Moves.of(a)
    backwards = replace(
        m, source=m.target, target=m.source, initial=np.flatnonzero(m.marked), marked=np.arange(a.n_states) == a.initial
    )
    return subsets(backwards, name or (f"reverse({automaton.name})" if automaton.name else ""), limits, progress)


def _some(automata: tuple[Automaton, ...], operation: str) -> None:
    if not automata:
        raise InputError(f"{operation}: give at least one automaton")
    for a in automata:
        if not isinstance(a, Automaton):
            hint = f": give them one by one, {operation}(a, b)" if isinstance(a, Iterable) else ""
            raise InputError(f"{operation} takes automata, not {type(a).__name__}{hint}")


def _joined(automata: tuple[Automaton, ...], sign: str) -> str:
    return sign.join(a.name for a in automata) if all(a.name for a in automata) else ""


def _widened(automaton: Automaton, alphabet: Alphabet) -> Automaton:
    """Return ``automaton`` over the larger ``alphabet``, whose other events it blocks."""
    events, targets = rows_in_order_of(alphabet, automaton)
    return replace(automaton, alphabet=alphabet, events=events, targets=targets)


def _with_dump(automaton: Automaton) -> Automaton:
    """Return ``automaton`` with one more state, the last, which is never entered."""
    return replace(
        automaton,
        offsets=np.append(automaton.offsets, automaton.n_transitions),
        marked=np.append(automaton.marked, False),
        states=Moves.of(automaton).and_state("dump", marked=False).states,
    )


def _assembled(
    alphabet: Alphabet,
    source: NDArray[np.int64],
    event: NDArray[np.int64],
    target: NDArray[np.int64],
    marked: NDArray[np.bool_],
    initial: int,
) -> Automaton:
    """Return the deterministic automaton with these transitions, in any order."""
    order = np.lexsort((event, source))
    return Automaton.from_arrays(
        alphabet,
        row_offsets(np.bincount(source, minlength=len(marked))),
        event[order],
        target[order],
        marked=marked,
        initial=initial,
    )
