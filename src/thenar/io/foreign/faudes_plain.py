"""Sections of a libFAUDES file that hold plain words only, read at a stroke: a million transitions a second.

Everything else, and everything that is wrong, raises NotPlainError, and is read again token by token.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from thenar.io.block import numbered_words
from thenar.io.foreign.faudes_parts import Generator
from thenar.io.foreign.faudes_tokens import NotPlainError, is_index, unquoted

__all__ = ["PlainWords", "Rows"]

Rows: TypeAlias = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
"""Source, event and target of each transition."""


class PlainWords:
    """Reads the states and transitions of ``generator``; what a word stands for is looked up once."""

    def __init__(self, generator: Generator) -> None:
        self.generator = generator
        self._states = _Words(self._state)

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
        ids, words = numbered_words(text)
        if len(ids) % 3:
            raise NotPlainError
        event = _Words(lambda word: events.get(unquoted(word)))
        source, label, target = ids.reshape(-1, 3).T
        return _meant(source, words, self._states), _meant(label, words, event), _meant(target, words, self._states)

    def _state(self, word: str) -> int | None:
        g, name = self.generator, unquoted(word)
        return g.by_index(int(word)) if is_index(word) else g.by_name(name)


def _meant(ids: NDArray[np.int32], words: list[str], meaning: _Words) -> NDArray[np.int64]:
    """Return what each of the words with these numbers stands for; each distinct word is looked up once."""
    used = np.flatnonzero(np.bincount(ids, minlength=len(words)))
    found = np.zeros(len(words), np.int64)
    found[used] = [meaning[words[w]] for w in used.tolist()]
    return found[ids]


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
