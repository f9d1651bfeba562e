"""The compressed sparse rows of automata, as NumPy handles them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet

__all__ = ["bytemask", "entries", "kept", "own_mask", "row_offsets", "rows_in_order_of", "sources"]


def bytemask(mask: ArrayLike) -> NDArray[np.uint8]:
    """Return a mask as the kernel takes it."""
    return np.ascontiguousarray(mask, dtype=np.uint8)


def own_mask(alphabet: Alphabet, automaton: Automaton) -> NDArray[np.uint8]:
    """Return (len(alphabet),) uint8: 1 for the events that ``automaton`` takes part in."""
    return bytemask([e.name in automaton.alphabet for e in alphabet])


def row_offsets(degrees: ArrayLike) -> NDArray[np.int64]:
    """Return where rows of these lengths begin, and the last one ends.

    >>> row_offsets([2, 0, 1]).tolist()
    [0, 2, 2, 3]
    """
    return np.concatenate(([0], np.cumsum(degrees))).astype(np.int64)


def entries(offsets: NDArray[np.int64], rows: NDArray[np.integer]) -> NDArray[np.int64]:
    """Return the places of all entries of ``rows``, one row after the other.

    >>> entries(row_offsets([2, 0, 3]), np.array([2, 0])).tolist()
    [2, 3, 4, 0, 1]
    """
    length = offsets[rows + 1] - offsets[rows]
    begin = row_offsets(length)
    places: NDArray[np.int64] = np.arange(begin[-1]) + np.repeat(offsets[rows] - begin[:-1], length)
    return places


def sources(automaton: Automaton) -> NDArray[np.int64]:
    """Return (n_transitions,) int64: the state that each transition leaves."""
    return np.repeat(np.arange(automaton.n_states), np.diff(automaton.offsets))


def kept(automaton: Automaton, keep: NDArray[np.bool_]) -> Automaton:
    """Return ``automaton`` with only the transitions that ``keep``, (n_transitions,) bool, says; states stay."""
    offsets = row_offsets(np.bincount(sources(automaton)[keep], minlength=automaton.n_states))
    return replace(automaton, offsets=offsets, events=automaton.events[keep], targets=automaton.targets[keep])


def rows_in_order_of(alphabet: Alphabet, automaton: Automaton) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return events and targets with the events numbered, and each row sorted, as ``alphabet`` orders them."""
    place = np.array([alphabet.index(e) for e in automaton.alphabet], dtype=np.int32)
    if not len(place):
        return automaton.events, automaton.targets
    events = place[automaton.events]
    if (np.diff(place) > 0).all():
        return events, automaton.targets
    order = np.lexsort((events, sources(automaton)))
    return events[order], automaton.targets[order]
