"""Abstraction: less of an automaton, with the same conflicts.

Events that nobody else takes part in are hidden, and states that then behave alike are merged.  Hiding makes automata
nondeterministic, so these functions work on a :class:`Process`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thenar.errors import LimitReached
from thenar.explicit.rows import sources
from thenar.model.automaton import Automaton
from thenar.model.trace import Check

__all__ = [
    "Process",
    "hide",
    "is_nonconflicting_by_abstraction",
    "is_observer",
    "observation_quotient",
    "without_certain_conflicts",
]

TAU = -1  # the label of a silent step
MOST = 10_000  # states of a product, those that can be reached
TRIED = 200_000  # pairs of states that are looked at to find them
STEPS = 4_000_000  # saturated steps, some 100 bytes each


@dataclass(frozen=True, slots=True, eq=False)
class Process:
    """A nondeterministic automaton with silent steps τ.

    * ``events``: the names of what can be seen
    * ``source``, ``label``, ``target``: (n_transitions,) int64, the label a position in ``events``, -1 for τ
    * ``marked``: (n_states,) bool; ``initial``: a state

    >>> hide(Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"]), ["b"]).events
    ('a',)
    """

    events: tuple[str, ...]
    initial: int
    source: NDArray[np.int64]
    label: NDArray[np.int64]
    target: NDArray[np.int64]
    marked: NDArray[np.bool_]

    @property
    def n_states(self) -> int:
        """How many states there are."""
        return len(self.marked)

    @property
    def n_transitions(self) -> int:
        """How many steps there are, silent ones with them."""
        return len(self.label)

    @property
    def is_deterministic(self) -> bool:
        """True if there is no silent step, and never a choice between two steps of one event."""
        steps = np.stack([self.source, self.label])
        return bool((self.label != TAU).all()) and np.unique(steps, axis=1).shape[1] == len(self.label)


def hide(automaton: Automaton | Process, events: Iterable[str]) -> Process:
    """Return ``automaton`` with ``events`` made silent.  O(|δ|).

    >>> a = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> hide(a, ["b"]).label.tolist()
    [0, -1]
    """
    hidden = set(events)
    if isinstance(automaton, Automaton):
        known, label = automaton.alphabet.names, automaton.events.astype(np.int64)
        start, source, target = automaton.initial, sources(automaton), automaton.targets.astype(np.int64)
    else:
        known, label = automaton.events, automaton.label
        start, source, target = automaton.initial, automaton.source, automaton.target
    seen = tuple(e for e in known if e not in hidden)
    place = np.array([*(seen.index(e) if e not in hidden else TAU for e in known), TAU], np.int64)  # place[-1]: τ stays
    return _distinct(Process(seen, start, source, place[label], target, automaton.marked))


def observation_quotient(process: Process) -> Process:
    """Return ``process`` with all observation equivalent states merged: those that no observer can tell apart.

    x ≈ y if whatever x can do, with any silent steps before and after, leads y by the same to an equivalent state, and
    both or none can get to a marked state silently.  The quotient by the coarsest such relation is in conflict
    with the same automata: states x ≈ y have the same strings, and after each of these the same futures, so that in any
    context one can be completed exactly if the other can.

    Time and memory O(|⇒|) for each round of refinement, of which there are at most |Q|; the saturated steps ⇒ may be
    |Q|²|Σ|.  Raises LimitReached if they are more than four million.
    [Milner 1989; Flordal and Malik, SIAM J. Control Optim. 48(3), 2009]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -a-> 2 -y-> 3 -b-> 0"], initial="0", marked=["0"])
    >>> small = observation_quotient(hide(a, ["y"]))
    >>> small.n_states, small.n_transitions
    (3, 3)
    """
    n = process.n_states
    source, label, target = _saturated(process)
    marked = np.zeros(n, np.bool_)
    marked[source[(label == TAU) & process.marked[target]]] = True
    block = marked.astype(np.int64)
    count = len(np.unique(block))
    width = len(process.events) + 1
    while True:
        # of each state: its block, and which blocks it gets to by which event
        states, rows = np.divmod(np.unique(source * (n * width) + block[target] * width + label + 1), n * width)
        bounds = np.searchsorted(states, np.arange(n + 1)).tolist()
        number: dict[tuple[int, bytes], int] = {}
        looks = zip(block.tolist(), bounds[:-1], bounds[1:], strict=True)
        block = np.array([number.setdefault((b, rows[i:k].tobytes()), len(number)) for b, i, k in looks], np.int64)
        if len(number) == count:
            break
        count = len(number)
    merged = np.zeros(count, np.bool_)
    merged[block[marked]] = True
    p = process
    return _distinct(Process(p.events, int(block[p.initial]), block[p.source], p.label, block[p.target], merged))


def is_observer(automaton: Automaton, events: Iterable[str]) -> bool:
    """Return whether the natural projection of ``automaton`` to ``events`` is an Lm-observer.

    That is, whatever of Lm can still be seen after a string s can be seen after every s' that looks the same.  Then the
    projection has not more states than the automaton, and is in conflict with whatever the automaton is, as far as they
    share no hidden event.  For a trim automaton it is so exactly if the quotient by observation equivalence is
    deterministic, and then the quotient is the projection.  Cost as for :func:`observation_quotient`.

    [Wong and Wonham, Discrete Event Dynamic Systems 14, 2004; Pena, Cury and Lafortune, IEEE TAC 54(12), 2009]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -a-> 2", "0 -y-> 3 -b-> 2"], initial="0", marked=["2"])
    >>> is_observer(a, ["a", "b"]), is_observer(a, ["x", "y"])
    (False, True)
    """
    kept = set(events)
    return observation_quotient(
        hide(automaton, [e for e in automaton.alphabet.names if e not in kept])
    ).is_deterministic


def without_certain_conflicts(process: Process) -> Process:
    """Return ``process`` with all states that block in every context merged into one, without a way out.

    States with no way to a marked one are such, and those with a silent step to such a state.  Where an event may
    lead to such a state, its other outcomes make no difference: all is lost if it happens.  O(|δ|) a round.

    [Malik, The language of certain conflicts of a nondeterministic process, 2010; Flordal and Malik 2009]

    >>> a = Automaton.from_transitions(["0 -a-> 1 -x-> dead -b-> dead", "1 -b-> 0"], initial="0", marked=["0"])
    >>> without_certain_conflicts(hide(a, ["x"])).n_states
    2
    """
    p = process
    n = p.n_states
    lost = np.zeros(n, np.bool_)
    while True:
        before = lost.sum(), p.n_transitions
        alive = _reaching(p, p.marked & ~lost)
        lost |= ~alive
        lost[p.source[(p.label == TAU) & lost[p.target]]] = True
        width = len(p.events) + 1
        step = p.source * width + p.label + 1
        risky = np.isin(step, step[lost[p.target]])
        keep = ~lost[p.source] & (lost[p.target] | ~risky)
        p = replace(p, source=p.source[keep], label=p.label[keep], target=p.target[keep])
        if before == (lost.sum(), p.n_transitions):
            break
    if not lost.any():
        return process
    dump = int(np.argmax(lost))
    place = np.where(lost, dump, np.arange(n))
    merged = replace(p, initial=int(place[p.initial]), target=place[p.target], marked=p.marked & ~lost)
    return _reached(_distinct(merged))


def is_nonconflicting_by_abstraction(*automata: Automaton, most: int = MOST) -> Check:
    """Return whether the synchronous product of ``automata`` is nonblocking, without building the whole of it.

    Two at a time are multiplied; what then concerns these two only is hidden, and equivalent states are merged before
    the next one is taken; first those that share the events that concern the fewest.  Long chains and rings need
    little more than their parts do.  The same verdict as :func:`is_nonconflicting`, but no witness.

    Raises LimitReached if two factors together have more than ``most`` states.  [Flordal and Malik 2009]

    >>> from thenar.library.classics import chain
    >>> problem = chain(50)
    >>> is_nonconflicting_by_abstraction(*problem.plants).holds
    True
    """
    if any(a.is_empty for a in automata):
        return Check("nonconflicting", True)  # nothing happens, so nothing blocks
    users: dict[str, set[int]] = {}
    for k, a in enumerate(automata):
        for e in a.alphabet.names:
            users.setdefault(e, set()).add(k)
    processes: dict[int, Process] = {}

    def put(k: int, process: Process | Automaton) -> bool:
        """Make ``process`` the k-th, as small as can be; return False if it blocks in every context."""
        names = process.events if isinstance(process, Process) else process.alphabet.names
        own = [e for e in names if users[e] == {k}]
        for e in own:
            del users[e]
        small = without_certain_conflicts(_reached(hide(process, own)))
        if small.n_states == 1 and not small.marked[0]:
            return False
        processes[k] = observation_quotient(small)
        return True

    blocked = Check("nonconflicting", False, None, "their product is blocking")
    for k, a in enumerate(automata):
        if not put(k, a):
            return blocked
    while users:
        i, j = _next_pair(users, processes)
        product = _times(processes.pop(i), processes.pop(j), most)
        for owners in users.values():
            if j in owners:
                owners.discard(j)
                owners.add(i)
        if not put(i, product):
            return blocked
    # what is left shares nothing: each has silent steps only, and blocks on its own or not at all
    if all(_reaching(p, p.marked).all() for p in processes.values()):
        return Check("nonconflicting", True)
    return blocked


def _next_pair(users: dict[str, set[int]], processes: dict[int, Process]) -> tuple[int, int]:
    """Return the two smallest automata of an event that concerns as few as can be."""
    best: tuple[int, int] | None = None
    least = (len(processes) + 1, 0)
    for owners in users.values():
        if len(owners) > least[0]:
            continue
        first, second = sorted(owners, key=lambda k: (processes[k].n_states, k))[:2]
        rank = len(owners), processes[first].n_states * processes[second].n_states
        if best is None or rank < least:
            best, least = (first, second), rank
    assert best is not None  # there is an event, and it concerns two
    return min(best), max(best)


def _times(a: Process, b: Process, most: int) -> Process:
    """Return the synchronous product, its reachable part."""
    n, m = a.n_states, b.n_states
    if n * m > TRIED:
        raise LimitReached("states", TRIED, n * m, 0)
    events = (*a.events, *(e for e in b.events if e not in a.events))
    columns = []
    in_b = np.array([*(b.events.index(e) if e in b.events else TAU - 1 for e in events), TAU - 1], np.int64)
    in_a = np.array([*range(len(a.events)), *[TAU - 1] * (len(events) - len(a.events)), TAU - 1], np.int64)
    label_b = np.array([*(events.index(e) for e in b.events), TAU], np.int64)[b.label]
    alone_a, alone_b = in_b[a.label] < TAU, in_a[label_b] < TAU
    every = np.arange(m)
    s, e, t = (x[alone_a, None] for x in (a.source, a.label, a.target))
    columns.append(_three(s * m + every, e, t * m + every))
    every = np.arange(n)[:, None] * m
    s, e, t = (x[alone_b][None, :] for x in (b.source, label_b, b.target))
    columns.append(_three(every + s, e, every + t))
    for k, e_b in enumerate(in_b[:-1].tolist()):
        if e_b >= 0 and k < len(a.events):
            here, there = a.label == k, b.label == e_b
            source = a.source[here, None] * m + b.source[there]
            columns.append(_three(source, np.array([[k]]), a.target[here, None] * m + b.target[there]))
    source, label, target = np.concatenate(columns, axis=1)
    marked = (a.marked[:, None] & b.marked).ravel()
    product = _reached(Process(events, a.initial * m + b.initial, source, label, target, marked))
    if product.n_states > most:
        raise LimitReached("states", most, product.n_states, product.n_transitions)
    return product


def _three(*columns: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([c.ravel() for c in np.broadcast_arrays(*columns)])


def _reached(p: Process) -> Process:
    """Return the part that can be reached."""
    there = _closure(p.n_states, p.source, p.target, np.arange(p.n_states) == p.initial)
    place = np.cumsum(there) - 1
    k = there[p.source]
    return Process(p.events, int(place[p.initial]), place[p.source[k]], p.label[k], place[p.target[k]], p.marked[there])


def _reaching(p: Process, goal: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the states from which one of the mask ``goal`` can be reached."""
    return _closure(p.n_states, p.target, p.source, goal)


def _closure(
    n: int, source: NDArray[np.int64], target: NDArray[np.int64], start: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return what can be reached from the mask ``start``, as a mask."""
    order = np.argsort(source, kind="stable")
    offsets = np.searchsorted(source[order], np.arange(n + 1)).tolist()
    successors = target[order].tolist()
    stack = np.flatnonzero(start).tolist()
    found = start.tolist()
    while stack:
        x = stack.pop()
        for y in successors[offsets[x] : offsets[x + 1]]:
            if not found[y]:
                found[y] = True
                stack.append(y)
    return np.array(found, np.bool_)


def _distinct(p: Process) -> Process:
    """Return ``p`` without repeated steps, and without silent ones that lead nowhere."""
    width = len(p.events) + 1
    key = (p.source * width + p.label + 1) * p.n_states + p.target
    key = np.unique(key[(p.label != TAU) | (p.source != p.target)])
    step, target = np.divmod(key, max(p.n_states, 1))
    source, label = np.divmod(step, width)
    return Process(p.events, p.initial, source, label - 1, target, p.marked)


def _saturated(p: Process) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the steps x ⇒ y: silent ones before and after are free; of τ also none at all."""
    n = p.n_states
    silent = p.label == TAU
    later: list[list[int]] = [[] for _ in range(n)]
    for x, y in zip(p.source[silent].tolist(), p.target[silent].tolist(), strict=True):
        later[x].append(y)
    order = _postorder(later)

    def spread(sets: list[int]) -> list[int]:
        """Give every state what the states have that it silently gets to; sets are bits of an int."""
        changed = True
        while changed:  # once and a look, but for cycles of silent steps
            changed = False
            for x in order:
                bits = sets[x]
                for y in later[x]:
                    bits |= sets[y]
                if bits != sets[x]:
                    sets[x], changed = bits, True
        return sets

    silently = spread([1 << x for x in range(n)])
    columns, steps = [], 0
    for e in range(TAU, len(p.events)):
        sets = silently
        if e != TAU:
            here = p.label == e
            sets = [0] * n
            for x, y in zip(p.source[here].tolist(), p.target[here].tolist(), strict=True):
                sets[x] |= silently[y]
            spread(sets)
        steps += sum(bits.bit_count() for bits in sets)
        if steps > STEPS:
            raise LimitReached("transitions", STEPS, n, steps)
        columns.append(_pairs(sets, e))
    source, label, target = np.concatenate(columns, axis=1)
    return source, label, target


def _postorder(later: Sequence[Sequence[int]]) -> list[int]:
    """Return all states, each after those that it leads to as far as there are no cycles; only those that lead on."""
    order: list[int] = []
    seen = [False] * len(later)
    for root in range(len(later)):
        stack = [(root, 0)] if not seen[root] else []
        seen[root] = True
        while stack:
            x, k = stack.pop()
            if k < len(later[x]):
                stack.append((x, k + 1))
                y = later[x][k]
                if not seen[y]:
                    seen[y] = True
                    stack.append((y, 0))
            elif later[x]:
                order.append(x)
    return order


def _pairs(sets: Sequence[int], label: int) -> NDArray[np.int64]:
    """Return (3, n) int64: each member y of each set x as x, ``label``, y."""
    n = len(sets)
    width = (n + 7) // 8
    rows = [x for x in range(n) if sets[x]]
    packed = np.frombuffer(b"".join(sets[x].to_bytes(width, "little") for x in rows), np.uint8).reshape(-1, width)
    row, member = np.nonzero(np.unpackbits(packed, axis=1, bitorder="little"))
    return np.stack([np.array(rows, np.int64)[row], np.full(len(row), label, np.int64), member])
