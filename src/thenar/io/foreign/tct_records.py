"""TCT's binary ``.DES`` and ``.DAT``: blocks of integers behind a signature, of 32 or of 64 bits.

::

    text, 0x1A                                     for people
    "Z8^0L;1" (32 bits) or "Z8^0L;2" (64 bits)     the signature
    55 AA 00 FF                                    the order of bytes
    block: type, size in bytes (4 bytes each), content; type 0 is the automaton, type -1 the end

    content of type 0, integers i of 4 bytes (in the second signature, of 8):
      i  number of states;  i  0 in a .DES, -1 in a .DAT
      i  marker state, ..., -1
      i  exit state, 2 bytes number of transitions, that many transitions; ...; -1
         a transition: 4 bytes, label << 22 | entrance state
         (of 64 bits: 8 bytes entrance state, 8 bytes of which the first two are the label)
      i  state with a vocal output, ...; -1

Some TCT programs write the size of a block behind it, into some other place, or not at all; it is not looked at.
Layout after IDES and the STS package, which read and write both, and the files of TCT itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from struct import Struct, pack

import numpy as np
from numpy.typing import NDArray

from thenar.errors import counted
from thenar.io.foreign.tct_numbers import MAX_LABEL, MAX_STATES, Numbers, fail

__all__ = ["NARROW", "WIDE", "Records", "Width", "checked", "is_binary", "read", "write"]

TITLE = b"CTCT DES file. Version 1.0\x1a"
ORDER = b"\x55\xaa\x00\xff"
HEAD = 4_096  # bytes within which the text for people ends
ROWS = 1 << 13  # states that are written at a time


@dataclass(frozen=True, slots=True)
class Width:
    """How wide the integers of a generation are: ``integer``, and ``row``, with the 2-byte count behind it."""

    signature: bytes
    integer: Struct
    row: Struct
    transition: int  # bytes
    highest: int  # label
    states: int  # at most


NARROW = Width(b"Z8^0L;1", Struct("<i"), Struct("<iH"), 4, 999, 1 << 22)
WIDE = Width(b"Z8^0L;2", Struct("<q"), Struct("<qH"), 16, MAX_LABEL, 1 << 62)


@dataclass(frozen=True, slots=True)
class Records:
    """What a file of TCT holds, of any generation; ``control_data`` is true for a ``.DAT``."""

    size: int
    control_data: bool
    marked: NDArray[np.bool_]
    sources: NDArray[np.int64]
    labels: NDArray[np.int64]
    targets: NDArray[np.int64]
    vocal: int | None  # a state with a vocal output


def is_binary(data: bytes) -> bool:
    """Return whether ``data`` begins as a binary file of TCT does."""
    return b"\x1aZ8^0L;" in data[:HEAD]


def checked(
    where: str,
    limit: int,
    size: int,
    marked: NDArray[np.int64],
    rows: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    *,
    control_data: bool,
    vocal: int | None,
) -> Records:
    """Return the records if all numbers in them are in range; ``limit`` bounds what is believed of the size."""
    if not 0 <= size <= max(MAX_STATES, limit):
        fail(where, f"{size:,} states are declared; TCT takes at most {MAX_STATES:,}, and the file is not that large")
    states = f"there {'is' if size == 1 else 'are'} {counted(size, 'state')}"
    for what, column, end, why in (
        ("a marker state", marked, size, states),
        ("an exit state", rows[0], size, states),
        ("a label", rows[1], MAX_LABEL + 1, f"labels end at {MAX_LABEL:,}"),
        ("an entrance state", rows[2], size, states),
    ):
        bad = column[(column < 0) | (column >= end)]
        if len(bad):
            fail(where, f"{what} is {bad[0]}, and {why}")
    mark = np.zeros(size, np.bool_)
    mark[marked] = True
    return Records(size, control_data, mark, *rows, vocal)


def read(data: bytes, source: str) -> Records:
    """Return what the binary file ``data`` holds; ModelError with the offset if it is damaged."""
    start = data.index(b"\x1aZ8^0L;") + 1
    width = next((w for w in (NARROW, WIDE) if data.startswith(w.signature, start)), None)
    if width is None:
        fail(
            f"{source}: offset {start:#x}",
            f"the signature {data[start : start + 7]!r} is of no known generation of TCT",
        )
    start += len(width.signature)
    if data[start : start + 4] != ORDER:
        fail(f"{source}: offset {start:#x}", "the order of bytes is not 55 AA 00 FF; the file is of another machine")
    file = _File(data, source, start + 4, width)
    while (kind := file.take(_BLOCK.integer)) != 0:
        skipped = file.take(_BLOCK.integer)
        if kind == -1 or skipped < 0:
            fail(file.where, "no block of type 0: the file holds no automaton")
        file.position += skipped
    file.take(_BLOCK.integer)
    where, size, initial = file.where, file.take(width.integer), file.take(width.integer)
    if initial not in (0, -1):
        fail(where, f"the initial state is {initial}; TCT's is 0")
    marked = file.markers()
    rows = file.transitions()
    vocal = file.take(width.integer)
    return checked(
        where, len(data), size, marked, rows, control_data=initial == -1, vocal=None if vocal == -1 else vocal
    )


_BLOCK = NARROW  # types and sizes of blocks have 4 bytes in both generations


class _File:
    """Bytes and a place in them."""

    def __init__(self, data: bytes, source: str, position: int, width: Width) -> None:
        self.data = data
        self.source = source
        self.position = position
        self.width = width

    @property
    def where(self) -> str:
        return f"{self.source}: offset {min(self.position, len(self.data)):#x}"

    def take(self, integer: Struct) -> int:
        """Return the next integer."""
        if self.position + integer.size > len(self.data):
            fail(self.where, "the file ends within its data; it is truncated")
        (value,) = integer.unpack_from(self.data, self.position)
        self.position += integer.size
        return int(value)

    def markers(self) -> NDArray[np.int64]:
        """Return the numbers before the next -1."""
        bytes_ = self.width.integer.size
        count = max(len(self.data) - self.position, 0) // bytes_
        rest = np.frombuffer(self.data, f"<i{bytes_}", count, self.position)
        ends = np.flatnonzero(rest == -1)
        if not len(ends):
            fail(self.where, "the list of marker states does not end; the file is truncated")
        self.position += int(ends[0] + 1) * bytes_
        return rest[: ends[0]].astype(np.int64)

    def transitions(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Return source, label and target of each transition."""
        states, counts, begins = [], [], []
        data, row, step, start = self.data, self.width.row, self.width.transition, self.position
        while self.take(self.width.integer) != -1:
            self.position -= self.width.integer.size
            if self.position + row.size > len(data):
                fail(self.where, "the file ends within a transition; it is truncated")
            state, count = row.unpack_from(data, self.position)
            self.position += row.size
            states.append(state)
            counts.append(count)
            begins.append((self.position - start) // 2)
            self.position += step * count
        words = np.frombuffer(data, "<u2", (self.position - start) // 2, start).astype(np.int64)
        many, first = np.array(counts, np.int64), np.array(begins, np.int64)
        before = np.cumsum(many) - many
        at = np.repeat(first - before * (step // 2), many) + np.arange(many.sum()) * (step // 2)
        sources = np.repeat(np.array(states, np.int64), many)
        low = words[at] | words[at + 1] << 16
        if self.width is NARROW:
            return sources, low >> 22, low & ((1 << 22) - 1)
        return sources, words[at + 4], low | words[at + 2] << 32 | words[at + 3] << 48


def write(n: Numbers, width: Width) -> Iterator[bytes]:
    """Yield a binary ``.DES`` file in pieces."""
    i = width.integer
    counts = np.diff(n.offsets)
    leaving = np.flatnonzero(counts)
    marked = np.flatnonzero(n.marked)
    content = i.size * (5 + len(marked)) + width.row.size * len(leaving) + width.transition * len(n.labels)
    yield b"".join((TITLE, width.signature, ORDER, pack("<iI", 0, content & 0xFFFFFFFF), i.pack(n.size), i.pack(0)))
    kind = f"<i{i.size}"
    yield marked.astype(kind).tobytes() + i.pack(-1)
    cuts = [*range(0, len(leaving), ROWS), len(leaving)]
    for a, b in pairwise(cuts):
        yield _rows(n, leaving[a:b], counts, width)
    yield i.pack(-1) * 2 + pack("<iiii", -1, 8, 0, 0)


def _rows(n: Numbers, states: NDArray[np.int64], counts: NDArray[np.int64], width: Width) -> bytes:
    """Return the rows of ``states`` as they stand in a file: the integers cut into words of 2 bytes."""
    head, step = width.row.size // 2, width.transition // 2
    many = counts[states]
    lo, hi = int(n.offsets[states[0]]), int(n.offsets[states[-1] + 1])
    begin = np.arange(len(states)) * head + (np.cumsum(many) - many) * step
    at = np.repeat(begin + head, many) + (np.arange(hi - lo) - np.repeat(n.offsets[states] - lo, many)) * step
    words = np.zeros(len(states) * head + (hi - lo) * step, "<u2")
    labels, targets = n.labels[lo:hi], n.targets[lo:hi]
    for k in range(head - 1):
        words[begin + k] = states >> 16 * k & 0xFFFF
    words[begin + head - 1] = many
    if width is NARROW:
        targets = labels << 22 | targets
    else:
        words[at + 4] = labels
    for k in range(width.integer.size // 2):
        words[at + k] = targets >> 16 * k & 0xFFFF
    return words.tobytes()
