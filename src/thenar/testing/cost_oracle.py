"""Slow, obvious twins of the questions about costs: every policy is tried, in exact arithmetic.

A policy says for each unmarked state what to do there: start one of its controllable events, or wait for an
uncontrollable one.  Their number grows exponentially with the states: fine up to some six.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

from thenar.model.automaton import Automaton
from thenar.testing.graphs import Graph, State, read

__all__ = ["Policy", "best_cost", "expected_cost", "mean_cost", "policies", "strings_cost", "worst_cost"]

Policy: TypeAlias = dict[State, str | None]
Value: TypeAlias = Fraction | float  # exact, or infinite
Numbers: TypeAlias = Mapping[str, Any]


def policies(automaton: Automaton) -> Iterator[Policy]:
    """Yield each policy; None means to wait, where there is something to wait for, or nothing to start.

    >>> a = Automaton.from_transitions(["0 -x,y,u-> 1 -x-> 2"], initial="0", marked=["2"], uncontrollable=["u"])
    >>> len(list(policies(a)))
    3
    """
    graph = read(automaton)
    moves: list[list[str | None]] = []
    for q in graph.step:
        starts: list[str | None] = [e for e in graph.step[q] if graph.alphabet[e].controllable]
        waits: list[str | None] = [None] if len(starts) < len(graph.step[q]) or not starts else []
        moves.append([None] if q in graph.marked else [*starts, *waits])
    for chosen in product(*moves):
        yield dict(zip(graph.step, chosen, strict=True))


def best_cost(automaton: Automaton, costs: Numbers) -> list[Value]:
    """Return for each state the least cost of a string to a marked state: all costs are improved until none can be.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2", "0 -z-> 2"], initial="0", marked=["2"])
    >>> best_cost(a, {"x": 1, "y": 1, "z": 3})
    [Fraction(2, 1), Fraction(1, 1), Fraction(0, 1)]
    """
    graph = read(automaton)
    value: dict[State, Value] = {q: Fraction(0) if q in graph.marked else math.inf for q in graph.step}
    for _ in graph.step:
        for q, row in graph.step.items():
            value[q] = min([value[q], *(_plus(costs[e], value[t]) for e, t in row.items())])
    return list(value.values())


def strings_cost(automaton: Automaton, costs: Numbers, policy: Policy | None = None) -> list[Value]:
    """Return for each state the cost of the dearest string to the first marked state that ``policy`` lets happen.

    Infinite if a string never gets there: it goes round in a circle, or stops where nothing can happen.  Without a
    policy all that can happen may happen.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -u,v-> 2"], initial="0", marked=["2"], uncontrollable=["u", "v"])
    >>> strings_cost(a, {"x": 1, "u": 1, "v": 5}, {0: "x", 1: None, 2: None})
    [Fraction(6, 1), Fraction(5, 1), Fraction(0, 1)]
    """
    graph = read(automaton)

    def dearest(q: State, passed: tuple[State, ...]) -> Value:
        if q in graph.marked:
            return Fraction(0)
        free = {e for e in graph.step[q] if policy is None or not graph.alphabet[e].controllable}
        happens = [(e, t) for e, t in graph.step[q].items() if e in free or (policy and e == policy[q])]
        if q in passed or not happens:
            return math.inf
        return max(_plus(costs[e], dearest(t, (*passed, q))) for e, t in happens)

    return [dearest(q, ()) for q in graph.step]


def worst_cost(automaton: Automaton, costs: Numbers) -> list[Value]:
    """Return for each state the least cost that some policy never exceeds.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -u,v-> 2", "0 -z-> 2"], initial="0", marked=["2"],
    ...     uncontrollable=["u", "v"])
    >>> worst_cost(a, {"x": 1, "u": 1, "v": 5, "z": 4})[0]
    Fraction(4, 1)
    """
    return _least([strings_cost(automaton, costs, policy) for policy in policies(automaton)])


def expected_cost(automaton: Automaton, costs: Numbers, weights: Numbers) -> list[Value]:
    """Return for each state the least expected cost of a policy that gets to a marked state with probability 1.

    >>> coin = Automaton.from_transitions(["toss -throw-> air -heads-> done", "air -tails-> toss"], initial="toss",
    ...     marked=["done"], uncontrollable=["heads", "tails"])
    >>> ones = {"throw": 1, "heads": 1, "tails": 1}
    >>> expected_cost(coin, ones, ones)[0]
    Fraction(4, 1)
    """
    return _least([mean_cost(automaton, costs, weights, policy) for policy in policies(automaton)])


def mean_cost(automaton: Automaton, costs: Numbers, weights: Numbers, policy: Policy) -> list[Value]:
    """Return the expected cost of ``policy`` from each state; infinite where it may never get to a marked one.

    >>> a = Automaton.from_transitions(["0 -x,u-> 1"], initial="0", marked=["1"], uncontrollable=["u"])
    >>> mean_cost(a, {"x": 1, "u": 5}, {"x": 3, "u": 1}, {0: "x", 1: None})
    [Fraction(2, 1), Fraction(0, 1)]
    """
    graph = read(automaton)
    chain = {q: _law(graph, q, weights, policy[q]) for q in graph.step if q not in graph.marked}
    after = {q: {graph.step[q][e] for e in law} for q, law in chain.items()}
    sure = {q for q in chain if all(_reach(r, after) & graph.marked for r in _reach(q, after))}
    states = [q for q in chain if q in sure]
    rows = []
    for q in states:
        row = [Fraction(int(q == other)) for other in states] + [Fraction(0)]
        for e, probability in chain[q].items():
            t = graph.step[q][e]
            row[-1] += probability * Fraction(costs[e])
            if t in chain:
                row[states.index(t)] -= probability
        rows.append(row)
    solved = dict(zip(states, _solve(rows), strict=True))
    return [Fraction(0) if q in graph.marked else solved.get(q, math.inf) for q in graph.step]


def _law(graph: Graph, q: State, weights: Numbers, started: str | None) -> dict[str, Fraction]:
    """Return the probability of each event that may come next in ``q``."""
    if started is not None and weights[started] == math.inf:
        return {started: Fraction(1)}
    free = [e for e in graph.step[q] if not graph.alphabet[e].controllable and weights[e]]
    racing = free + ([started] if started is not None else [])
    total = sum(Fraction(weights[e]) for e in racing)
    return {e: Fraction(weights[e]) / total for e in racing}


def _reach(q: State, after: Mapping[State, set[State]]) -> set[State]:
    """Return what can be reached from ``q``, ``q`` included."""
    found = {q}
    while more := {t for r in found for t in after.get(r, ())} - found:
        found |= more
    return found


def _solve(rows: list[list[Fraction]]) -> list[Fraction]:
    """Return x with A x = b for the rows (A | b), by Gauss and Jordan."""
    n = len(rows)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]


def _plus(cost: Any, value: Value) -> Value:
    return Fraction(cost) + value if value != math.inf else math.inf


def _least(values: Sequence[Sequence[Value]]) -> list[Value]:
    return [min(of_state) for of_state in zip(*values, strict=True)]
