"""State names, composed only when someone looks: a product of a million states costs no strings."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import DTypeLike, NDArray

__all__ = ["Composed", "Grouped", "Layout", "Listed", "Numbered", "StateNames", "every_name", "state_index"]

SEPARATOR = "|"


class StateNames(Protocol):
    """Names of states 0 .. n-1, looked up one at a time."""

    @abstractmethod
    def __len__(self) -> int: ...
    @abstractmethod
    def __getitem__(self, state: int, /) -> str: ...
    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``, renumbered 0 .. len(states)-1."""
        ...


@dataclass(frozen=True, slots=True)
class Listed:
    """Names as the author of an automaton wrote them."""

    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, state: int, /) -> str:
        return self.names[state]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``."""
        return Listed(tuple(self.names[s] for s in states.tolist()))


@dataclass(frozen=True, slots=True)
class Numbered:
    """States that have no other name than their number."""

    numbers: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, state: int, /) -> str:
        return str(self.numbers[state])

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the numbers of ``states``."""
        return Numbered(self.numbers[states])


@dataclass(frozen=True, slots=True)
class Layout:
    """Where a bit-packed product state keeps the state of each component.

    Component i has ``bits[i]`` bits from bit ``shifts[i]`` on of the 64-bit word ``words[i]``.
    """

    words: tuple[int, ...]
    shifts: tuple[int, ...]
    bits: tuple[int, ...]

    def unpack(self, keys: NDArray[np.uint64], dtype: DTypeLike = np.int64) -> NDArray[Any]:
        """Return (n, components) component states of the packed ``keys`` (n, words), as integers of type ``dtype``."""
        states = np.empty((len(keys), len(self.words)), dtype)
        for k, (word, shift, bits) in enumerate(zip(self.words, self.shifts, self.bits, strict=True)):
            states[:, k] = (keys[:, word] >> np.uint64(shift)) & np.uint64((1 << bits) - 1)
        return states


@dataclass(frozen=True, slots=True)
class Composed:
    """States of a product: ``keys`` (n, words) uint64 hold the states of ``parts`` packed by ``layout``."""

    parts: tuple[StateNames, ...]
    labels: tuple[str, ...]
    layout: Layout
    keys: NDArray[np.uint64]

    def __len__(self) -> int:
        return len(self.keys)

    def __getitem__(self, state: int, /) -> str:
        local = self.coordinates(state)
        return SEPARATOR.join(_quoted(part, q) for part, q in zip(self.parts, local, strict=True))

    def coordinates(self, state: int) -> tuple[int, ...]:
        """Return the state of each component when the product is in ``state``."""
        return tuple(self.layout.unpack(self.keys[[state]])[0].tolist())

    def find(self, wanted: str) -> int | None:
        """Return the first state called ``wanted``, or None; O(n) in NumPy, without composing a name."""
        local = self.layout.unpack(self.keys)
        there, rest = np.ones(len(self), np.bool_), wanted + SEPARATOR
        for k, part in enumerate(self.parts):
            names = {q: _quoted(part, q) + SEPARATOR for q in np.unique(local[:, k]).tolist()}
            fitting = [q for q, name in names.items() if rest.startswith(name)]
            if not fitting:
                return None
            there &= np.isin(local[:, k], fitting)
            rest = rest[len(names[fitting[0]]) :]  # all of one length: they are the same name
        found = np.flatnonzero(there)
        return int(found[0]) if len(found) and not rest else None

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``."""
        return Composed(self.parts, self.labels, self.layout, self.keys[states])


def _quoted(part: StateNames, state: int) -> str:
    """Return the name of a part's state, in quotes where the product's name would be ambiguous without."""
    name = part[state]
    if isinstance(part, Composed) or not (SEPARATOR in name or name.startswith("'")):
        return name
    return "'" + name.replace("'", "''") + "'"


@dataclass(frozen=True, slots=True)
class Grouped:
    """States that stand for sets of other states: state s is ``members[offsets[s]:offsets[s + 1]]``."""

    names: StateNames
    offsets: NDArray[np.int64]
    members: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, state: int, /) -> str:
        group = self.members[self.offsets[state] : self.offsets[state + 1]].tolist()
        return self.names[group[0]] if len(group) == 1 else "{" + ", ".join(self.names[q] for q in group) + "}"

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``."""
        sizes = np.diff(self.offsets)[states]
        offsets = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        members = np.concatenate(
            [self.members[self.offsets[s] : self.offsets[s + 1]] for s in states.tolist()] or [self.members[:0]]
        )
        return Grouped(self.names, offsets, members)


def state_index(names: StateNames | Sequence[str], wanted: str) -> int | None:
    """Return the first state called ``wanted``, or None; O(n)."""
    if isinstance(names, Composed):
        return names.find(wanted)
    return next((q for q in range(len(names)) if names[q] == wanted), None)


def every_name(names: StateNames) -> Sequence[str]:
    """Return all the names; those of a product a component at a time.

    >>> every_name(Numbered(np.arange(3)))
    ['0', '1', '2']
    """
    if isinstance(names, Listed):
        return names.names
    if isinstance(names, Numbered):
        return list(map(str, names.numbers.tolist()))
    if isinstance(names, Composed):
        columns = []
        for part, local in zip(names.parts, names.layout.unpack(names.keys).T, strict=True):
            used, place = np.unique(local, return_inverse=True)
            table = [_quoted(part, q) for q in used.tolist()]
            columns.append(map(table.__getitem__, place.tolist()))
        return list(map(SEPARATOR.join, zip(*columns, strict=True)))
    return [names[q] for q in range(len(names))]
