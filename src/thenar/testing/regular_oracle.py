"""Slow, obvious twins of the operations on languages: each state is what has to be remembered of a string.

Everything here is dictionaries and sets.  A state of a result is a Python value (a pair, a set of states); the state
after an event is found by the definition of the operation, and one that nothing can follow, and that is not in the
closed behaviour, is None.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import reduce
from operator import or_

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton
from thenar.testing.graphs import Graph, State, read, write
from thenar.testing.oracle import trim

__all__ = [
    "concatenation",
    "determinise",
    "difference",
    "inverse_project",
    "kleene_star",
    "left_quotient",
    "prefix_closure",
    "quotient",
    "reverse",
    "strings",
    "union",
]

Strings = set[tuple[str, ...]]


def strings(automaton: Automaton, n: int, *, marked: bool = True) -> Strings:
    """Return the strings of Lm, or of L if not ``marked``, of at most ``n`` events.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> sorted(strings(A, 3)), len(strings(A, 3, marked=False))
    ([(), ('a', 'b')], 4)
    """
    graph = read(automaton)
    found: dict[tuple[str, ...], State] = {(): graph.initial} if graph.step else {}
    longest = found
    for _ in range(n):
        longest = {(*s, e): y for s, x in longest.items() for e, y in graph.step[x].items()}
        found = found | longest
    return {s for s, x in found.items() if not marked or x in graph.marked}


def inverse_project(automaton: Automaton, events: Iterable[Event | str]) -> Automaton:
    """Return the automaton that stays where it is when one of ``events`` happens that it does not know.

    >>> A = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"])
    >>> list(inverse_project(A, ["a", "b"]).transitions())
    [('0', 'a', '1'), ('0', 'b', '0'), ('1', 'b', '1')]
    """
    graph = read(automaton)
    alphabet = graph.alphabet | Alphabet(e for e in events if e not in graph.alphabet)
    return _explored(
        alphabet,
        graph.initial if graph.step else None,
        lambda x, e: graph.step[x].get(e) if e in graph.alphabet else x,
        lambda x: x in graph.marked,
    )


def union(*automata: Automaton) -> Automaton:
    """Return the automaton that runs all of ``automata``, each as far as it goes (then its state is None).

    >>> A = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"])
    >>> B = Automaton.from_transitions(["0 -b-> 1"], initial="0", marked=["1"])
    >>> [union(A, B).marks(s) for s in ("a", "b", "ε")]
    [True, True, False]
    """
    graphs = [read(a) for a in automata]

    def step(x: State, e: str) -> State:
        y = tuple(_next(g, q, e) for g, q in zip(graphs, x, strict=True))
        return None if set(y) == {None} else y

    initial = tuple(g.initial if g.step else None for g in graphs)
    return _explored(
        _union(graphs),
        None if set(initial) == {None} else initial,
        step,
        lambda x: any(q in g.marked for g, q in zip(graphs, x, strict=True)),
    )


def concatenation(a: Automaton, b: Automaton) -> Automaton:
    """Return the automaton that runs ``a``, and from each of its marked states on a copy of ``b`` too.

    >>> A = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"])
    >>> B = Automaton.from_transitions(["0 -b-> 1"], initial="0", marked=["1"])
    >>> [concatenation(A, B).marks(s) for s in ("a", "b", "a, b")]
    [False, False, True]
    """
    g, h = read(a), read(b)

    def begun(x: State, copies: set[State]) -> State:
        copies = copies - {None} | ({h.initial} if x in g.marked and h.step else set())
        return None if x is None and not copies else (x, frozenset(copies))

    return _explored(
        g.alphabet | h.alphabet,
        begun(g.initial, set()) if g.step else None,
        lambda state, e: begun(_next(g, state[0], e), {_next(h, y, e) for y in state[1]}),
        lambda state: not h.marked.isdisjoint(state[1]),
    )


def kleene_star(automaton: Automaton) -> Automaton:
    """Return the automaton that runs copies of ``automaton``, a new one from each marked state on; ε is marked.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 2"], initial="0", marked=["2"])
    >>> [kleene_star(A).marks(s) for s in ("ε", "a", "a, b", "a, b, a, b")]
    [True, False, True, True]
    """
    graph = read(automaton)

    def begun(copies: set[State], done: bool) -> State:
        copies = copies - {None} | ({graph.initial} if done and graph.step else set())
        return (frozenset(copies), done) if copies or done else None

    def step(state: State, e: str) -> State:
        copies = {_next(graph, x, e) for x in state[0]}
        return begun(copies, not graph.marked.isdisjoint(copies))

    return _explored(graph.alphabet, begun(set(), True), step, lambda state: state[1])


def prefix_closure(automaton: Automaton) -> Automaton:
    """Return the trim part of ``automaton``, everything marked.

    >>> A = Automaton.from_transitions(["0 -a-> 1", "0 -b-> 2"], initial="0", marked=["1"])
    >>> [prefix_closure(A).marks(s) for s in ("ε", "a", "b")]
    [True, True, False]
    """
    graph = read(trim(automaton))
    return write(Graph(graph.alphabet, graph.initial, graph.step, set(graph.step), graph.names))


def difference(a: Automaton, b: Automaton) -> Automaton:
    """Return the automaton that runs ``a``, and beside it ``b``, and marks what only ``a`` marks.

    >>> A = Automaton.from_transitions(["0 -a-> 0 -b-> 1"], initial="0", marked=["0", "1"])
    >>> B = Automaton.from_transitions(["0 -a-> 0"], initial="0", marked=["0"])
    >>> [difference(A, B).marks(s) for s in ("a", "b", "a, b")]
    [False, True, True]
    """
    g, h = read(a), read(b)

    def step(state: State, e: str) -> State:
        x = _next(g, state[0], e)
        return None if x is None else (x, _next(h, state[1], e))

    return _explored(
        g.alphabet | h.alphabet,
        (g.initial, h.initial if h.step else None) if g.step else None,
        step,
        lambda state: state[0] in g.marked and state[1] not in h.marked,
    )


def quotient(a: Automaton, b: Automaton) -> Automaton:
    """Return ``a``, marked in the states from which a string that ``b`` marks leads to a marked state.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 2"], initial="0", marked=["2"])
    >>> B = Automaton.from_transitions(["0 -b-> 1"], initial="0", marked=["1"])
    >>> [quotient(A, B).marks(s) for s in ("ε", "a", "a, b")]
    [False, True, False]
    """
    g, h = read(a), read(b)
    if not h.step:
        return Automaton.empty(g.alphabet)
    marked = {x for x in g.step if any(p in g.marked and q in h.marked for p, q in _together(g, h, {(x, h.initial)}))}
    graph = Graph(g.alphabet, g.initial, g.step, marked, g.names)
    return write(graph.without(graph.unreachable()))


def left_quotient(a: Automaton, b: Automaton) -> Automaton:
    """Return ``a`` begun in all states at once to which a string leads that ``b`` marks.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 2"], initial="0", marked=["2"])
    >>> B = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"])
    >>> [left_quotient(A, B).marks(s) for s in ("ε", "b", "a, b")]
    [False, True, False]
    """
    g, h = read(a), read(b)
    pairs = _together(g, h, {(g.initial, h.initial)} if g.step and h.step else set())
    edges = {(x, e, y) for x, row in g.step.items() for e, y in row.items()}
    return _subsets(g.alphabet, edges, {x for x, y in pairs if y in h.marked}, g.marked, set())


def reverse(automaton: Automaton) -> Automaton:
    """Return the automaton that runs the trim part of ``automaton`` backwards, from all marked states at once.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 2"], initial="0", marked=["2"])
    >>> reverse(A).marks("b, a")
    True
    """
    graph = read(trim(automaton))
    edges = {(y, e, x) for x, row in graph.step.items() for e, y in row.items()}
    return _subsets(graph.alphabet, edges, graph.marked, {graph.initial}, set())


def determinise(automaton: ExtendedAutomaton, silent: Iterable[str] = ()) -> Automaton:
    """Return the automaton whose state is the set of states in which ``automaton`` may be.

    >>> A = ExtendedAutomaton.from_edges("A", ["0 -a-> 0", "0 -a-> 1"], initial="0", marked=["1"])
    >>> [determinise(A).marks(s) for s in ("ε", "a", "a, a")]
    [False, True, True]
    """
    hidden = set(silent)
    edges = {(e.source, automaton.alphabet[e.event].name, e.target) for e in automaton.edges}
    first, marked = ({q for q, is_so in enumerate(truths) if is_so} for truths in (automaton.initial, automaton.marked))
    alphabet = Alphabet(e for e in automaton.alphabet if e.name not in hidden)
    return _subsets(alphabet, edges, first, marked, hidden)


def _subsets(
    alphabet: Alphabet, edges: set[tuple[State, str, State]], first: set[State], marked: set[State], hidden: set[str]
) -> Automaton:
    def closed(states: set[State]) -> State:
        while more := {y for x, e, y in edges if x in states and e in hidden and y not in states}:
            states = states | more
        return frozenset(states) or None

    return _explored(
        alphabet,
        closed(first),
        lambda states, event: closed({y for x, e, y in edges if x in states and e == event}),
        lambda states: not marked.isdisjoint(states),
    )


def _explored(
    alphabet: Alphabet, initial: State, step: Callable[[State, str], State], is_marked: Callable[[State], bool]
) -> Automaton:
    """Return what is found from ``initial`` on; None is no state."""
    rows: dict[State, dict[str, State]] = {}
    queue = [] if initial is None else [initial]
    for x in queue:  # grows while it is read
        if x not in rows:
            moves = {e: step(x, e) for e in alphabet.names}
            rows[x] = {e: y for e, y in moves.items() if y is not None}
            queue += rows[x].values()
    names = {x: str(k) for k, x in enumerate(rows)}
    return write(Graph(alphabet, initial, rows, {x for x in rows if is_marked(x)}, names))


def _together(g: Graph, h: Graph, pairs: set[tuple[State, State]]) -> set[tuple[State, State]]:
    """Return the pairs of states that the same strings lead to from ``pairs``."""
    queue = list(pairs)
    for x, y in queue:
        for e in g.step[x].keys() & h.step[y].keys():
            after = (g.step[x][e], h.step[y][e])
            if after not in queue:
                queue.append(after)
    return set(queue)


def _next(graph: Graph, state: State, event: str) -> State:
    return None if state is None else graph.step[state].get(event)


def _union(graphs: Iterable[Graph]) -> Alphabet:
    return reduce(or_, (g.alphabet for g in graphs), Alphabet())
