"""Sections of a libFAUDES file that hold plain words only, read at a stroke: a million transitions a second.

Everything else, and everything that is wrong, raises NotPlainError, and is read again token by token.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import itemgetter
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from thenar.io.foreign.faudes_parts import Generator
from thenar.io.foreign.faudes_tokens import NotPlainError, is_index, unquoted

__all__ = ["PlainWords", "Rows"]

Rows: TypeAlias = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
"""Source, event and target of each transition."""

BLOCK = 1 << 20  # characters that are read at a time
_FIRST = itemgetter(0)
_TENS = 10 ** np.arange(1, 18)


class PlainWords:
    """Reads the states and transitions of ``generator``; a word is looked at once only, and a number not at all."""

    def __init__(self, generator: Generator) -> None:
        self.generator = generator
        self._states = _Words(self._state)
        self._first: int | None = None  # name of the first state, if the names are consecutive numbers

    def add_states(self, text: str | None) -> bool:
        """Add the states that ``text`` lists; False, and nothing done, unless all have a name and nothing else."""
        words = (text or "").split()
        try:
            names = list(map(unquoted, words))
        except NotPlainError:
            return False
        if not words or any((word[0] != '"' and is_index(word)) or "#" in word for word in words):
            return False
        if not self.generator.add_names(names):
            return False
        if is_index(names[0]) and names == list(map(str, range(int(names[0]), int(names[0]) + len(names)))):
            self._first = int(names[0])
        self._states.update(zip(words, range(len(words)), strict=True))
        return True

    def states(self, text: str | None) -> list[int]:
        """Return the positions of the states that ``text`` lists."""
        if text is None:
            raise NotPlainError
        return list(map(self._states.__getitem__, text.split()))

    def rows(self, text: str | None, events: Mapping[str, int]) -> Rows:
        """Return the transitions that ``text`` lists; ``events`` are the positions of the events by name."""
        if text is None:
            raise NotPlainError
        event = _Words(lambda word: events.get(unquoted(word)))
        found: list[list[NDArray[np.int64]]] = [[np.zeros(0, np.int64)] for _ in range(3)]
        start, words = 0, list[str]()
        while start < len(text):
            stop = text.find("\n", start + BLOCK)
            stop = len(text) if stop < 0 else stop
            words += text[start:stop].split()
            start, n = stop, len(words) // 3
            found[0].append(self._column(words[0 : 3 * n : 3]))
            found[1].append(np.fromiter(map(event.__getitem__, words[1 : 3 * n : 3]), np.int64, n))
            found[2].append(self._column(words[2 : 3 * n : 3]))
            words = words[3 * n :]
        if words:
            raise NotPlainError
        s, e, t = (np.concatenate(column) for column in found)
        return s, e, t

    def _column(self, words: list[str]) -> NDArray[np.int64]:
        """Return the positions of the states that the words name."""
        found = None
        if words and words[0][0] != '"':
            indices = _numbers(words)
            found = None if indices is None else self.generator.by_indices(indices)
        elif self._first is not None and set(map(_FIRST, words)) == {'"'}:
            inner = "".join(words)[1:-1].split('""')
            names = _numbers(inner) if len(inner) == len(words) else None
            if names is not None:
                found = names - self._first
                found = found if 0 <= found.min() and found.max() < self.generator.n_states else None
        if found is not None:
            return found
        return np.fromiter(map(self._states.__getitem__, words), np.int64, len(words))

    def _state(self, word: str) -> int | None:
        g, name = self.generator, unquoted(word)
        return g.by_index(int(word)) if is_index(word) else g.by_name(name)


def _numbers(words: list[str]) -> NDArray[np.int64] | None:
    """Return the numbers that all words are, written as Python writes them; None if they are not."""
    digits, n = "".join(words), len(words)
    lengths = np.fromiter(map(len, words), np.int64, n)
    if not (digits.isascii() and digits.isdigit() and lengths.min() > 0 and lengths.max() < 18):
        return None
    numbers = np.fromiter(map(int, words), np.int64, n)
    return numbers if (np.searchsorted(_TENS, numbers, "right") + 1 == lengths).all() else None


class _Words(dict[str, int]):
    """Looks up what a word stands for once; raises NotPlainError if it stands for nothing."""

    def __init__(self, meaning: Callable[[str], int | None]) -> None:
        super().__init__()
        self.meaning = meaning

    def __missing__(self, word: str) -> int:
        found = self.meaning(word)
        if found is None:
            raise NotPlainError
        self[word] = found
        return found
