"""The slow, obvious twin of what components of a Waters module do together: states in sets, each rule written down.

A component takes part in every event that one of its edges has.  In a state, an event is *possible* if each plant
that takes part has an edge whose guard is true, and the edges agree: whatever variable several of them give a
value, they give it the same, and it is one that the variable can have.  It *happens* if that is so of all
components, plants and specifications.  A variable that no edge gives a value keeps its value.  A state is
*illegal* if an uncontrollable event is possible there and does not happen.  An event of no plant is always possible.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from operator import eq, ge, gt, le, lt, ne
from typing import TypeAlias

__all__ = ["Component", "Edge", "Joint", "explore"]

State: TypeAlias = tuple[str | int, ...]
COMPARE = {"==": eq, "!=": ne, "<": lt, "<=": le, ">": gt, ">=": ge}


@dataclass(frozen=True)
class Edge:
    """``source -event-> target`` where ``guard`` is true: (variable, comparison, number), or always.

    ``updates`` are triples of a variable, one of ``= += -=``, and a number or the name of a variable.
    """

    source: str
    event: str
    target: str
    guard: tuple[str, str, int] | None = None
    updates: tuple[tuple[str, str, int | str], ...] = ()


@dataclass(frozen=True)
class Component:
    """An automaton that begins in ``initial``."""

    name: str
    is_plant: bool
    initial: str
    edges: tuple[Edge, ...]


@dataclass(frozen=True)
class Joint:
    """What is reached: a state is one of each component, then a value of each variable."""

    initial: State
    states: frozenset[State]
    transitions: frozenset[tuple[State, str, State]]
    illegal: frozenset[State]


def explore(
    components: Sequence[Component],
    ranges: Mapping[str, range],
    start: Mapping[str, int],
    uncontrollable: Sequence[str],
) -> Joint:
    """Return all that the components reach together from ``start``, the values at first.

    >>> up = Component("UP", True, "a", (Edge("a", "e", "a", None, (("n", "+=", 1),)),))
    >>> again = Component("AGAIN", True, "b", (Edge("b", "e", "b", ("n", "<", 2), (("n", "=", 1),)),))
    >>> sorted(explore([up, again], {"n": range(4)}, {"n": 0}, []).transitions)
    [(('a', 'b', 0), 'e', ('a', 'b', 1))]
    """
    names = list(ranges)
    events = dict.fromkeys(e.event for c in components for e in c.edges)
    plants = [c for c in components if c.is_plant]
    initial: State = (*(c.initial for c in components), *(start[v] for v in names))
    states, waiting = {initial}, [initial]
    transitions, illegal = set(), set()
    while waiting:
        x = waiting.pop()
        values = {v: int(n) for v, n in zip(names, x[len(components) :], strict=True)}
        places = {c.name: str(q) for c, q in zip(components, x, strict=False)}
        for event in events:
            happened = False
            for moved, new in _together(components, event, places, values, ranges):
                happened = True
                y: State = (
                    *(moved.get(c.name, places[c.name]) for c in components),
                    *({**values, **new}[v] for v in names),
                )
                transitions.add((x, event, y))
                if y not in states:
                    states.add(y)
                    waiting.append(y)
            if event in uncontrollable and not happened and any(_together(plants, event, places, values, ranges)):
                illegal.add(x)
    return Joint(initial, frozenset(states), frozenset(transitions), frozenset(illegal))


def _together(
    components: Sequence[Component],
    event: str,
    places: Mapping[str, str],
    values: Mapping[str, int],
    ranges: Mapping[str, range],
) -> Iterator[tuple[dict[str, str], dict[str, int]]]:
    """Yield where the components go by ``event``, and the new values, for each way to take part together."""
    taking = [c for c in components if any(e.event == event for e in c.edges)]
    open_edges = [
        [e for e in c.edges if e.event == event and e.source == places[c.name] and _holds(e, values)] for c in taking
    ]
    for chosen in product(*open_edges):
        given: dict[str, set[int]] = {}
        for edge in chosen:
            for variable, operator, what in edge.updates:
                amount = values[what] if isinstance(what, str) else what
                before = values[variable]
                new = {"=": amount, "+=": before + amount, "-=": before - amount}[operator]
                given.setdefault(variable, set()).add(new)
        if all(len(found) == 1 and found <= set(ranges[v]) for v, found in given.items()):
            yield (
                {c.name: e.target for c, e in zip(taking, chosen, strict=True)},
                {v: found.pop() for v, found in given.items()},
            )


def _holds(edge: Edge, values: Mapping[str, int]) -> bool:
    if edge.guard is None:
        return True
    variable, operator, bound = edge.guard
    return bool(COMPARE[operator](values[variable], bound))
