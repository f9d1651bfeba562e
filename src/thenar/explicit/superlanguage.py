"""The infimal controllable superlanguage: the least that must be allowed, if all of a specification shall be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thenar.explicit.exploration import Automata, Exploration, as_tuple, common_alphabet, ticker
from thenar.explicit.rows import row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.limits import Limits, Progress
from thenar.model.names import SEPARATOR, Numbered, StateNames

__all__ = ["infcon"]


def infcon(
    plant: Automata,
    spec: Automata,
    *,
    name: str = "infC",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return inf C(E, G): the smallest prefix-closed controllable language that has all of L(G) ∩ L(E) in it.

    It is (L(G) ∩ L(E))Σ_uc* ∩ L(G): once an uncontrollable event has led out of the specification, only
    uncontrollable events happen.  Several plants, or specifications, stand for their synchronous product.  A state of
    that product is called as it is there, any other by the states of the plants and ``out``; one is marked if
    the plant is, so that Lm of the result is L of it ∩ Lm(G).  It need not be nonblocking.

    O(|δ| + |Q||Σ_uc|) of the product.  Raises AlphabetClash if an event has two meanings, LimitReached at a limit.
    [Lafortune and Chen, IEEE TAC 35(4), 1990; Cassandras and Lafortune 2021, sec. 3.4]

    >>> plant = Automaton.from_transitions(["0 -go-> 1 -slip-> 2 -go-> 0"], initial="0", uncontrollable=["slip"])
    >>> spec = Automaton.from_transitions(["a -go-> b"], initial="a", alphabet=["slip"], uncontrollable=["slip"])
    >>> list(infcon(plant, spec).transitions())
    [('0|a', 'go', '1|b'), ('1|b', 'slip', '2|out')]
    """
    plants, specs = as_tuple(plant), as_tuple(spec)
    alphabet = common_alphabet((*plants, *specs))
    if any(a.is_empty for a in (*plants, *specs)):
        return Automaton.empty(alphabet, name)
    tick = ticker(limits, progress)
    legal = Exploration((*plants, *specs), (), alphabet, tick).extract("", tick).automaton
    n = legal.n_states
    free = np.flatnonzero(alphabet.uncontrollable)
    table = np.full((n + 1, len(alphabet)), -1, np.int32)
    table[:, free] = n
    table[sources(legal), legal.events] = legal.targets
    source, event = np.nonzero(table >= 0)
    extended = Automaton(
        "",
        alphabet,
        legal.initial,
        row_offsets(np.bincount(source, minlength=n + 1)),
        event.astype(np.int32),
        table[source, event],
        np.ones(n + 1, np.bool_),
        Numbered(np.arange(n + 1)),
    )
    exploration = Exploration((*plants, extended), (), alphabet, tick)
    part = exploration.extract(name, tick)
    *at, x = exploration.coordinates(part.origin).T
    return replace(part.automaton, states=_Names(legal.states, tuple(p.states for p in plants), np.stack(at, 1), x))


@dataclass(frozen=True, slots=True)
class _Names:
    """``inside`` names the states of the product; outside of it, at x = len(inside), it is the plants' states ``at``.

    ``at``: (n, plants) int64; ``x``: (n,) int64.
    """

    inside: StateNames
    plants: tuple[StateNames, ...]
    at: NDArray[np.int64]
    x: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, state: int, /) -> str:
        if self.x[state] < len(self.inside):
            return self.inside[int(self.x[state])]
        names = (p[q] for p, q in zip(self.plants, self.at[state].tolist(), strict=True))
        return SEPARATOR.join((*names, "out"))

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``."""
        return _Names(self.inside, self.plants, self.at[states], self.x[states])
