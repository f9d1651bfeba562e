"""What a plan is about: the states of a supervisor, each with what of the task has been done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.explicit.control import obeyed
from thenar.explicit.rows import entries
from thenar.model.supervisor import Supervisor

__all__ = ["Cells", "unfold"]

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Cells:
    """The cells (x, D) that can be reached, D being the goal events since the last marked state.

    * ``number``: (2^goals, n_states) int64, the cell of each subset and state; -1 out of reach
    * ``state``, ``done``: (n,) int64, the state and the subset of each cell
    * ``source``, ``target``: (m,) int64, the cells that each transition leaves and enters; sources rise
    * ``event``: (m,) int64
    """

    number: Ints
    state: Ints
    done: Ints
    source: Ints
    event: Ints
    target: Ints

    def find(self, state: int, done: int) -> int:
        """Return the cell of a state and a subset."""
        cell = int(self.number[done, state])
        if cell < 0:
            raise InputError(f"supervisor state {state} cannot be reached with these goal events done")
        return cell


def unfold(supervisor: Supervisor, goals: Sequence[int]) -> Cells:
    """Return the cells that can be reached from the initial state without a goal event, breadth-first.

    ``goals`` are positions in the alphabet; subset D holds goal k if its bit k is set.  O(2^goals (|X| + |ξ|)).

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> cells = unfold(supervisor, [supervisor.automaton.alphabet.index("repair_1")])
    >>> supervisor.n_states, len(cells.state), cells.find(0, done=0), cells.find(0, done=1)
    (12, 24, 0, 5)
    """
    S, n = obeyed(supervisor), supervisor.n_states
    events, targets, offsets, degree = (
        S.events.astype(np.int64),
        S.targets.astype(np.int64),
        S.offsets,
        np.diff(S.offsets),
    )
    bits = np.zeros(len(S.alphabet), np.int64)
    bits[list(goals)] = 1 << np.arange(len(goals))

    def after(cells: Ints) -> tuple[Ints, Ints, Ints]:
        """Return for the rows of ``cells``, which are numbered D n + x: their lengths, events and targets."""
        done, x = np.divmod(cells, n)
        length = degree[x]
        edge = entries(offsets, x)
        before = np.repeat(np.where(S.marked[x], 0, done), length)
        return length, events[edge], (before | bits[events[edge]]) * n + targets[edge]

    number = np.full(n << len(goals), -1, np.int64)
    front, found = np.array([S.initial], np.int64), 0
    layers: list[Ints] = []
    while len(front):
        number[front] = np.arange(found, found + len(front))
        found += len(front)
        layers.append(front)
        reached = after(front)[2]
        front = np.unique(reached[number[reached] < 0])
    cells = np.concatenate(layers)
    length, event, target = after(cells)
    done, state = np.divmod(cells, n)
    return Cells(number.reshape(-1, n), state, done, np.repeat(np.arange(found), length), event, number[target])
