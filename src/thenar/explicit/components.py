"""Circles in automata: strongly connected components, and how far a string can go where there is none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from thenar.explicit.rows import entries, row_offsets, sources
from thenar.model.automaton import Automaton

__all__ = ["heights", "strong_components", "way_round"]


def strong_components(offsets: Sequence[int], targets: Sequence[int]) -> NDArray[np.int64]:
    """Return (n_states,) int64: the strongly connected component of each state of compressed sparse rows.

    A component has a higher number than all that it leads to.  O(n_states + n_transitions).   [Tarjan 1972]

    >>> strong_components([0, 1, 3, 3], [1, 0, 2]).tolist()
    [1, 1, 0]
    """
    n, count = len(offsets) - 1, 0
    order, low, component = [-1] * n, [0] * n, [-1] * n
    stack: list[int] = []
    time = 0
    for root in range(n):
        if order[root] >= 0:
            continue
        work = [(root, offsets[root])]
        while work:
            q, k = work.pop()
            if k == offsets[q]:
                order[q] = low[q] = time
                time += 1
                stack.append(q)
            elif component[targets[k - 1]] < 0:
                low[q] = min(low[q], low[targets[k - 1]])
            while k < offsets[q + 1]:
                t = targets[k]
                k += 1
                if order[t] < 0:
                    work += [(q, k), (t, offsets[t])]
                    break
                if component[t] < 0:
                    low[q] = min(low[q], order[t])
            else:
                if low[q] == order[q]:
                    while component[q] < 0:
                        component[stack.pop()] = count
                    count += 1
    return np.array(component, np.int64)


def heights(automaton: Automaton) -> NDArray[np.int64]:
    """Return (n_states,) int64: the length of a longest string from each state, -1 where there is no longest.  O(|δ|).

    >>> heights(Automaton.from_transitions(["0 -a-> 1 -b-> 2", "0 -b-> 2", "3 -a-> 3 -b-> 0"], initial="0")).tolist()
    [2, 1, 0, -1]
    """
    source = sources(automaton)
    order = np.argsort(automaton.targets, kind="stable")
    before = source[order]
    enters = row_offsets(np.bincount(automaton.targets, minlength=automaton.n_states))
    height, missing = np.full(automaton.n_states, -1), np.diff(automaton.offsets)
    front, level = np.flatnonzero(missing == 0), 0
    missing = missing.copy()
    while len(front):
        height[front] = level
        into = before[entries(enters, front)]
        np.subtract.at(missing, into, 1)
        reached = np.unique(into)
        front, level = reached[missing[reached] == 0], level + 1
    return height


def way_round(automaton: Automaton, height: NDArray[np.int64], state: int) -> tuple[list[str], list[str]]:
    """Return the way from ``state``, whose :func:`heights` are -1, to a cycle, and the events once round it.

    >>> a = Automaton.from_transitions(["0 -a-> 1 -b-> 2 -c-> 1"], initial="0")
    >>> way_round(a, heights(a), 0)
    (['a'], ['b', 'c'])
    """
    names: list[str] = []
    seen: dict[int, int] = {}
    while state not in seen:  # each state without a longest string leads to another one
        seen[state] = len(names)
        event, state = next((e, t) for e, t in automaton.row(state) if height[t] < 0)
        names.append(automaton.alphabet[event].name)
    return names[: seen[state]], names[seen[state] :]
