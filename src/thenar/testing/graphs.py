"""Automata as dictionaries and sets, for the slow twins in :mod:`thenar.testing.oracle`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.trace import Trace

__all__ = ["Graph", "State", "read", "write"]

State = Any  # a number; in a product a tuple of them, in a projection a frozenset of them


@dataclass(frozen=True)
class Graph:
    """An automaton as dictionaries: ``step[x][e]`` is the state that event e enters from state x."""

    alphabet: Alphabet
    initial: State
    step: dict[State, dict[str, State]]
    marked: set[State]
    names: dict[State, str]

    def without(self, removed: set[State]) -> Graph:
        """Return the rest of the graph when ``removed`` states and all transitions to them are gone."""
        step = {
            x: {e: y for e, y in row.items() if y not in removed} for x, row in self.step.items() if x not in removed
        }
        return Graph(self.alphabet, self.initial, step, self.marked - removed, self.names)

    def shortest_traces(self) -> dict[State, Trace]:
        """Return the states that can be reached, breadth-first, each with a shortest trace to it."""
        traces = {self.initial: Trace()} if self.initial in self.step else {}
        queue = list(traces)
        for x in queue:  # grows while it is read
            for e, y in self.step[x].items():
                if y not in traces:
                    traces[y] = Trace([*traces[x], e])
                    queue.append(y)
        return traces

    def unreachable(self) -> set[State]:
        """Return the states that no string leads to."""
        return set(self.step) - set(self.shortest_traces())

    def blocking(self) -> set[State]:
        """Return the states from which no marked state can be reached."""
        reaching = set(self.marked)
        while more := {
            x for x, row in self.step.items() if x not in reaching and not reaching.isdisjoint(row.values())
        }:
            reaching |= more
        return set(self.step) - reaching


def read(automaton: Automaton) -> Graph:
    """Return ``automaton`` as dictionaries; its states are their numbers."""
    states = range(automaton.n_states)
    names = automaton.alphabet.names
    return Graph(
        automaton.alphabet,
        automaton.initial,
        {q: {names[e]: t for e, t in automaton.row(q)} for q in states},
        {q for q in states if automaton.marked[q]},
        {q: automaton.states[q] for q in states},
    )


def write(graph: Graph) -> Automaton:
    """Return ``graph`` as an automaton, states breadth-first; those out of reach come last, as they were."""
    if graph.initial not in graph.step:
        return Automaton.empty(graph.alphabet)
    order = list(dict.fromkeys([*graph.shortest_traces(), *graph.step]))
    names = [graph.names[x] for x in order]
    if len(set(names)) < len(names):
        raise ValueError("two states have the same name; rename them, the oracle builds automata by name")
    return Automaton.from_transitions(
        [(graph.names[x], e, graph.names[y]) for x in order for e, y in graph.step[x].items()],
        initial=graph.names[graph.initial],
        marked=[graph.names[x] for x in order if x in graph.marked],
        events=graph.alphabet,
        alphabet=graph.alphabet.names,
        states=names,
    )
