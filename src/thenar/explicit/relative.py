"""Relative closure: which behaviours a supervisor can mark by control alone, without a say in what is complete."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thenar.explicit.exploration import Automata, Exploration, as_tuple, common_alphabet, ticker
from thenar.explicit.reach import distance_to_marked, path_to, restrict, trim
from thenar.model.automaton import Automaton
from thenar.model.limits import Limits, Progress
from thenar.model.trace import Check

__all__ = ["is_relatively_closed", "sup_relatively_closed"]


def is_relatively_closed(
    spec: Automata, plant: Automata, *, limits: Limits | None = None, progress: Progress | None = None
) -> Check:
    """Return whether K = Lm(G) ∩ Lm(E) is Lm(G)-closed: whether K has every prefix of a string of K that is in Lm(G).

    If it is, and K is controllable and not empty, then a supervisor that only disables events brings K about:
    what it leaves of Lm(G) is K.  If it is not, the supervisor has to say itself when a task is complete.  A
    specification with all states marked always is.  Several plants, or specifications, stand for their product.

    The witness is a shortest prefix that is in Lm(G) and not in K.  O(|δ|) of the product.
    [Ramadge and Wonham 1987; Wonham and Cai 2019, sec. 3.4]

    >>> plant = Automaton.from_transitions(["0 -work-> 1 -rest-> 0"], initial="0", marked=["0"])
    >>> spec = Automaton.from_transitions(["a -work-> b -rest-> c"], initial="a", marked=["c"])
    >>> print(is_relatively_closed(spec, plant))
    relatively closed: no after ε: the plant has completed a task in state '0|a', the specification has not
    """
    product, done = _with_plants_marks(as_tuple(plant), as_tuple(spec), "", limits, progress)
    if product.is_empty:
        return Check("relatively closed", True)
    found = path_to(product, done & ~product.marked & (distance_to_marked(product) >= 0))
    if found is None:
        return Check("relatively closed", True)
    trace, q = found
    why = f"the plant has completed a task in state {product.states[q]!r}, the specification has not"
    return Check("relatively closed", False, trace, why)


def sup_relatively_closed(
    plant: Automata,
    spec: Automata,
    *,
    name: str = "supR",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return sup R(E, G): the largest Lm(G)-closed part of K = Lm(G) ∩ Lm(E), as a trim automaton.

    It is K - (Lm(G) - K)Σ*: what has to pass a string that the plant marks and the specification does not is left
    out.  Several plants, or specifications, stand for their synchronous product.  O(|δ|) of the product.

    Raises AlphabetClash if an event has two meanings, LimitReached at a limit.
    [Wonham and Cai 2019, sec. 3.4; libFAUDES calls it SupRelativelyClosed]

    >>> plant = Automaton.from_transitions(["0 -a-> 1 -b-> 2", "0 -b-> 2"], initial="0", marked=["1", "2"])
    >>> spec = Automaton.from_transitions(["0 -a-> 1 -b-> 2", "0 -b-> 2"], initial="0", marked=["2"])
    >>> list(sup_relatively_closed(plant, spec).transitions())
    [('0|0', 'b', '2|2')]
    """
    product, done = _with_plants_marks(as_tuple(plant), as_tuple(spec), name, limits, progress)
    return product if product.is_empty else trim(restrict(product, ~done | product.marked))


def _with_plants_marks(
    plants: tuple[Automaton, ...],
    specs: tuple[Automaton, ...],
    name: str,
    limits: Limits | None,
    progress: Progress | None,
) -> tuple[Automaton, NDArray[np.bool_]]:
    """Return the product, and in which of its states all plants are marked."""
    alphabet = common_alphabet((*plants, *specs))
    if any(a.is_empty for a in (*plants, *specs)):
        return Automaton.empty(alphabet, name), np.zeros(0, np.bool_)
    tick = ticker(limits, progress)
    exploration = Exploration((*plants, *specs), (), alphabet, tick)
    part = exploration.extract(name, tick)
    at = exploration.coordinates(part.origin).T[: len(plants)]
    return part.automaton, np.all([p.marked[q] for p, q in zip(plants, at, strict=True)], axis=0)
