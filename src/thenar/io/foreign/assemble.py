"""From the lists of a file to an automaton, plain if it is deterministic."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thenar.errors import Mistake, ModelError
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.names import Listed, Numbered
from thenar.model.problem import Problem

__all__ = ["assembled", "columns", "plain", "simplest"]


def assembled(
    name: str,
    alphabet: Alphabet,
    states: Sequence[str] | int,
    initial: Sequence[int],
    marked: ArrayLike,
    sources: ArrayLike,
    events: ArrayLike,
    targets: ArrayLike,
    *,
    meaning: str = "",
    where: str = "",
) -> Automaton | ExtendedAutomaton:
    """Return the automaton with these transitions: an :class:`Automaton`, or an extended one if it is no such.

    ``states`` are their names, or how many there are if they have none; ``initial`` the initial states;
    ``marked`` (n_states,) truths; transition k leads from ``sources[k]`` with event ``events[k]`` of ``alphabet`` to
    ``targets[k]``, in any order, repetitions count once.  The arrays are trusted.  O(transitions log transitions).

    Raises ModelError, its mistakes at ``where`` (the file), for no initial state and for two states of one name.

    >>> sigma = Alphabet(["a"])
    >>> assembled("A", sigma, ["p", "q"], [0], [True, False], [0, 1], [0, 0], [1, 0])
    Automaton 'A': 2 states (1 marked), 2 transitions, 1 event
    >>> type(assembled("A", sigma, 2, [0], [True, False], [0, 0], [0, 0], [0, 1])).__name__  # a goes to both states
    'ExtendedAutomaton'
    """
    n = states if isinstance(states, int) else len(states)
    wrong = [] if isinstance(states, int) else [q for q, times in Counter(states).items() if times > 1]
    mistakes = [f"two states are called {q!r}" for q in wrong]
    if n and not len(initial):
        mistakes.append("no initial state; every automaton starts somewhere")
    if mistakes:
        raise ModelError([Mistake(where or f"automaton {name!r}", what) for what in mistakes])
    mark = np.asarray(marked, np.bool_)
    if n == 0:
        return Automaton.empty(alphabet, name)
    s, e, t = (np.asarray(column, np.int64) for column in (sources, events, targets))
    s, e, t = _sorted(s, e, t)
    again = (np.diff(s) == 0) & (np.diff(e) == 0)
    first = sorted(set(initial))
    if again.any() or len(first) > 1:
        rows = zip(s.tolist(), e.tolist(), t.tolist(), strict=True)
        names = tuple(map(str, range(n))) if isinstance(states, int) else tuple(states)
        begins = tuple(map(set(first).__contains__, range(n)))
        edges = tuple(Edge(*row) for row in rows)
        return ExtendedAutomaton(name, alphabet, names, begins, tuple(mark.tolist()), edges, meaning=meaning)
    offsets = np.zeros(n + 1, np.int64)
    np.cumsum(np.bincount(s, minlength=n), out=offsets[1:])
    return Automaton(
        name,
        alphabet,
        first[0],
        offsets,
        e.astype(np.int32),
        t.astype(np.int32),
        mark,
        Numbered(np.arange(n)) if isinstance(states, int) else Listed(tuple(states)),
        meaning=meaning,
    )


def columns(automaton: Automaton | ExtendedAutomaton) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the source, the event and the target of each transition, in order.

    >>> lamp = Automaton.from_transitions(["dark -on-> lit -off-> dark"], initial="dark")
    >>> [column.tolist() for column in columns(lamp)]
    [[0, 1], [0, 1], [1, 0]]
    """
    if isinstance(automaton, Automaton):
        sources = np.repeat(np.arange(automaton.n_states), np.diff(automaton.offsets))
        return sources, automaton.events.astype(np.int64), automaton.targets.astype(np.int64)
    edges = np.array([(e.source, e.event, e.target) for e in automaton.edges], np.int64).reshape(-1, 3)
    return edges[:, 0], edges[:, 1], edges[:, 2]


def plain(automaton: Automaton | ExtendedAutomaton) -> Automaton | ExtendedAutomaton:
    """Return the automaton as an :class:`Automaton` if it is one: deterministic, without guards and updates.

    >>> lamp = Automaton.from_transitions(["dark -on-> lit"], initial="dark")
    >>> type(plain(ExtendedAutomaton.from_automaton(lamp))).__name__
    'Automaton'
    """
    if isinstance(automaton, Automaton) or any(e.guard != TRUE or e.updates for e in automaton.edges):
        return automaton
    initial = [q for q, first in enumerate(automaton.initial) if first]
    return assembled(
        automaton.name, automaton.alphabet, automaton.states, initial, automaton.marked, *columns(automaton),
        meaning=automaton.meaning,
    )  # fmt: skip


def simplest(problem: ExtendedProblem) -> Problem | ExtendedProblem:
    """Return ``problem`` as a plain one if it has no variables and conditions, and all its automata are plain."""
    if problem.variables or problem.plant_conditions or problem.spec_conditions:
        return problem
    groups = [[a for a in map(plain, group) if isinstance(a, Automaton)] for group in (problem.plants, problem.specs)]
    if (problem.initial, problem.marked) != (TRUE, TRUE) or sum(map(len, groups)) < len(problem.automata):
        return problem
    return Problem(groups[0], groups[1], name=problem.name, alphabet=problem.alphabet, description=problem.description)


def _sorted(
    s: NDArray[np.int64], e: NDArray[np.int64], t: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the transitions in the order of source, event, target, each once."""
    ds, de = np.diff(s), np.diff(e)
    if ((ds > 0) | ((ds == 0) & (de > 0))).all():  # as most files have them
        return s, e, t
    order = np.lexsort((t, e, s))
    s, e, t = s[order], e[order], t[order]
    new = np.ones(len(s), np.bool_)
    new[1:] = (np.diff(s) != 0) | (np.diff(e) != 0) | (np.diff(t) != 0)
    return s[new], e[new], t[new]
