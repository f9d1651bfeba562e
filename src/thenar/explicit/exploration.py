"""The bridge to the native kernel: automata to int arrays and back."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thenar._native import kernel
from thenar.explicit.rows import bytemask, own_mask, rows_in_order_of
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, merge
from thenar.model.limits import Limits, Progress
from thenar.model.names import Composed, Layout, StateNames

__all__ = [
    "Automata",
    "Exploration",
    "Extract",
    "as_tuple",
    "common_alphabet",
    "ticker",
]

Automata: TypeAlias = Automaton | Sequence[Automaton]
"""One automaton, or several that stand for their synchronous product."""


def as_tuple(automata: Automata) -> tuple[Automaton, ...]:
    """Return ``automata`` as a tuple."""
    return (automata,) if isinstance(automata, Automaton) else tuple(automata)


def common_alphabet(automata: Sequence[Automaton]) -> Alphabet:
    """Return the union of the alphabets in order of first mention; raise AlphabetClash naming the automata."""
    return merge([a.alphabet for a in automata], [a.name or "an automaton without a name" for a in automata])


def ticker(limits: Limits | None = None, progress: Progress | None = None, spent: float = 0.0) -> kernel.Ticker:
    """Start the clock of one computation, or of a part of one that has ``spent`` seconds already."""
    bounds = limits or Limits()
    return kernel.Ticker(bounds.states, bounds.transitions, bounds.bytes, bounds.seconds, progress, spent)


class Exploration:
    """The reachable part of plants || specs; the kernel's arrays with the names put back.

    States in which the plants can do an uncontrollable event that a specification forbids are *illegal* and
    have no transitions.  With ``blocking``, every automaton takes part in every event of ``alphabet``: what
    is not in its own alphabet, it blocks.
    """

    def __init__(
        self,
        plants: Sequence[Automaton],
        specs: Sequence[Automaton],
        alphabet: Alphabet,
        tick: kernel.Ticker,
        *,
        uncontrollable: ArrayLike | None = None,
        blocking: bool = False,
    ) -> None:
        self.parts = (*plants, *specs)
        self.n_plants = len(plants)
        self.alphabet = alphabet
        components = []
        for k, part in enumerate(self.parts):
            events, targets = rows_in_order_of(alphabet, part)
            own = np.ones(len(alphabet), np.uint8) if blocking else own_mask(alphabet, part)
            marked = bytemask(part.marked)
            components.append(
                kernel.Component(part.offsets, events, targets, marked, own, part.initial, k < len(plants))
            )
        free = bytemask(alphabet.uncontrollable if uncontrollable is None else uncontrollable)
        self.native = kernel.explore(components, free, tick)

    @property
    def n_states(self) -> int:
        """States explored."""
        return self.native.n_states

    @cached_property
    def layout(self) -> Layout:
        """Where a packed state keeps the state of each part."""
        words, shifts, bits = self.native.layout
        return Layout(tuple(words), tuple(shifts), tuple(bits))

    def coordinates(self, states: ArrayLike) -> NDArray[np.int64]:
        """Return (len(states), parts) int64: the state of each part in each of ``states``."""
        return self.layout.unpack(self.native.keys(np.ascontiguousarray(states, np.int64)))

    def local(self, state: int) -> tuple[list[tuple[Automaton, int]], list[tuple[Automaton, int]]]:
        """Return the plants and the specifications, each with its own state, when the product is in ``state``."""
        parts = list(zip(self.parts, self.coordinates([state])[0].tolist(), strict=True))
        return parts[: self.n_plants], parts[self.n_plants :]

    def names(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``, composed when someone looks."""
        if len(self.parts) == 1:
            return self.parts[0].states.take(self.coordinates(states)[:, 0])
        return Composed(
            tuple(p.states for p in self.parts),
            tuple(p.name for p in self.parts),
            self.layout,
            self.native.keys(states),
        )

    def extract(self, name: str, tick: kernel.Ticker) -> Extract:
        """Return what survives, numbered breadth-first in the order of the alphabet."""
        return Extract(self, name, tick)

    def shortest(
        self, goal: ArrayLike, inside: ArrayLike | None = None, start: int = 0
    ) -> list[tuple[str, int]] | None:
        """Return a shortest path from ``start`` to a state of ``goal`` as (event, state entered), or None."""
        return self._path(start, goal, inside, uncontrollable_only=False)

    def shortest_uncontrollable(self, start: int, goal: ArrayLike) -> list[tuple[str, int]] | None:
        """Return a shortest path of uncontrollable events from ``start`` to a state of ``goal``, or None."""
        return self._path(start, goal, None, uncontrollable_only=True)

    def _path(
        self, start: int, goal: ArrayLike, inside: ArrayLike | None, *, uncontrollable_only: bool
    ) -> list[tuple[str, int]] | None:
        within = np.ones(self.n_states, np.uint8) if inside is None else bytemask(inside)
        found = self.native.path(start, bytemask(goal), within, uncontrollable_only, ticker())
        if found is None:
            return None
        events, states = found
        return [(self.alphabet[e].name, x) for e, x in zip(events, states[1:], strict=True)]


class Extract:
    """The surviving part of an exploration: an automaton, where its states come from, what is disabled."""

    def __init__(self, exploration: Exploration, name: str, tick: kernel.Ticker) -> None:
        offsets, events, targets, marked, self.origin, self.disabled_offsets, self.disabled = (
            exploration.native.extract(tick)
        )
        initial = 0 if len(marked) else -1
        states = exploration.names(self.origin)
        self.automaton = Automaton(
            name, exploration.alphabet, initial, offsets, events, targets, marked.view(np.bool_), states
        )
