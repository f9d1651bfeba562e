"""Slow, obvious twins of the checks for sampled devices: each definition written down, state by state.

Each function returns the states of the loop, by their numbers, after which the property fails.  ``commands`` are
names of events; the others are inputs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import combinations

from thenar.model.automaton import Automaton
from thenar.testing.graphs import Graph, State, read

__all__ = ["avalanche", "blocked", "choice", "delay", "endless", "longest", "not_confluent", "simultaneity"]

Commands = Collection[str]


def endless(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states from which commands can go round in a circle.

    >>> sorted(endless(Automaton.from_transitions(["0 -a-> 1 -b-> 1", "1 -a-> 2"], initial="0"), {"a", "b"}))
    [0, 1]
    """
    graph = read(loop)
    step = {q: [t for e, t in row.items() if e in commands] for q, row in graph.step.items()}
    circle = {q for q in step if any(q in reach(t, step) for t in step[q])}
    return {q for q in reachable(graph) if reach(q, step) & circle}


def longest(loop: Automaton, commands: Commands) -> int | None:
    """Return how many commands can follow each other; None if without end."""
    graph = read(loop)
    if endless(loop, commands):
        return None

    def far(q: State) -> int:
        return max([0, *(1 + far(t) for e, t in graph.step[q].items() if e in commands)])

    return max(far(q) for q in reachable(graph))


def not_confluent(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states with two bursts after which no bursts lead to the same future."""
    graph = read(loop)
    future = futures(graph)
    step = {q: [t for e, t in row.items() if e in commands] for q, row in graph.step.items()}
    ends = {q: {future[t] for t in reach(q, step)} for q in step}
    return {
        q for q in reachable(graph) if any(ends[x].isdisjoint(ends[y]) for x in reach(q, step) for y in reach(q, step))
    }


def blocked(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states from which a program that starts commands while any is enabled gets to no marked state."""
    graph = read(loop)
    decides = {q for q, row in graph.step.items() if any(e in commands for e in row)}
    step = {q: [t for e, t in row.items() if e in commands or q not in decides] for q, row in graph.step.items()}
    return {q for q in reachable(graph) if not reach(q, step) & (graph.marked - decides)}


def choice(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states with two commands that do not lead to the same future in either order."""
    graph = read(loop)
    return {q for q, a, b in pairs(graph) if {a, b} <= set(commands) and not same(graph, q, (a, b), (b, a))}


def avalanche(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states after which an input once or twice does not have the same future."""
    graph = read(loop)
    inputs = {(q, u) for q in reachable(graph) for u in graph.step[q] if u not in commands}
    return {q for q, u in inputs if go(graph, q, (u, u)) is not None and not same(graph, q, (u,), (u, u))}


def simultaneity(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states with two inputs that can both come, and not with the same future in either order."""
    graph = read(loop)
    return {
        q
        for q, u, v in pairs(graph)
        if not {u, v} & set(commands)
        and (go(graph, q, (u, v)) is not None or go(graph, q, (v, u)) is not None)
        and not same(graph, q, (u, v), (v, u))
    }


def delay(loop: Automaton, commands: Commands) -> set[State]:
    """Return the states with a command that an input before it disables, or makes lead elsewhere."""
    graph = read(loop)
    mixed = [(q, c, u) for q, a, b in pairs(graph) for c, u in ((a, b), (b, a)) if c in commands and u not in commands]
    return {
        q
        for q, c, u in mixed
        if go(graph, q, (u, c)) is None or (go(graph, q, (c, u)) is not None and not same(graph, q, (c, u), (u, c)))
    }


def pairs(graph: Graph) -> Iterator[tuple[State, str, str]]:
    """Yield each state that can be reached with two events that are enabled in it."""
    for q in reachable(graph):
        for a, b in combinations(graph.step[q], 2):
            yield q, a, b


def go(graph: Graph, q: State, string: tuple[str, ...]) -> State | None:
    """Return the state after ``string`` from ``q``, None if it is not possible."""
    for e in string:
        q = graph.step[q].get(e) if q is not None else None
    return q


def same(graph: Graph, q: State, string: tuple[str, ...], other: tuple[str, ...]) -> bool:
    """Return whether two strings are possible from ``q`` and have the same future."""
    x, y, future = go(graph, q, string), go(graph, q, other), futures(graph)
    return x is not None and y is not None and future[x] == future[y]


def futures(graph: Graph) -> dict[State, int]:
    """Return a number for each state, the same for those from which the same strings, and marked strings, are possible.

    All states are taken to be the same, until an event tells two of them apart.
    """
    number = dict.fromkeys(graph.step, 0)
    while True:
        seen = {q: (q in graph.marked, *sorted((e, number[t]) for e, t in graph.step[q].items())) for q in graph.step}
        order = list(dict.fromkeys(seen.values()))
        new = {q: order.index(seen[q]) for q in graph.step}
        if new == number:
            return number
        number = new


def reachable(graph: Graph) -> list[State]:
    """Return the states that some string leads to, those of short strings first."""
    return list(graph.shortest_traces())


def reach(q: State, step: dict[State, list[State]]) -> set[State]:
    """Return what can be reached from ``q``, ``q`` included."""
    found = {q}
    while more := {t for r in found for t in step[r]} - found:
        found |= more
    return found
