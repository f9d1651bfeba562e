"""PiTCT's ``.DES`` and ``.DAT``: MessagePack.

::

    {"name": "libtct", "version": "2.0", "size": number of states, "init": 0 (-1 in a .DAT),
     "states": {state: {"marked": bool, "next": [[label, entrance state], ...] or nil, "vocal": 0}}}

The extended files (``.EDES``) have ``reached`` and ``coreach`` too, which follow from the rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from thenar.io.foreign.tct_numbers import MAX_LABEL, Numbers, fail
from thenar.io.foreign.tct_records import Records, checked

__all__ = ["is_map", "read", "write"]

NAME, VERSION = "libtct", "2.0"
ROWS = 1 << 10  # states that are written at a time
FIELDS = {"reached", "coreach", "marked", "next", "vocal"}
LONGEST = 64  # bytes of a text


def is_map(data: bytes) -> bool:
    """Return whether ``data`` begins as a MessagePack map does."""
    return data[:1] != b"" and (0x80 <= data[0] <= 0x8F or data[0] in (0xDE, 0xDF))


def read(data: bytes, source: str) -> Records:
    """Return what the MessagePack file ``data`` holds; ModelError with the offset if it is no such file."""
    # An array of more elements than there are labels cannot occur; maps take no memory before they are filled.
    unpacker = msgpack.Unpacker(
        strict_map_key=False,
        max_buffer_size=max(len(data), 1),
        max_str_len=LONGEST,
        max_bin_len=LONGEST,
        max_ext_len=LONGEST,
        max_array_len=MAX_LABEL,
        max_map_len=max(len(data), 1),
    )
    unpacker.feed(data)
    try:
        return _read(unpacker, len(data), source)
    except (msgpack.UnpackException, ValueError, TypeError, OverflowError, UnicodeError) as error:
        reason = str(error) or type(error).__name__
        fail(f"{source}: offset {unpacker.tell():#x}", f"this is no whole MessagePack file of PiTCT: {reason}")


def _read(unpacker: Any, length: int, source: str) -> Records:
    where = f"{source}: offset 0x0"
    head: dict[str, Any] = {}
    states = _columns([], where)
    for _ in range(unpacker.read_map_header()):
        key = unpacker.unpack()
        if key == "states":
            states = _states(unpacker, source)
        elif isinstance(key, str):
            head[key] = unpacker.unpack()
    if head.get("name") != NAME or head.get("version") != VERSION:
        given = f"{head.get('name')!r} {head.get('version')!r}"
        fail(where, f"the file is of {given}, not of {NAME!r} {VERSION!r}")
    size, initial = head.get("size"), head.get("init")
    if type(size) is not int or size != len(states.numbers):
        fail(where, f"size is {size!r}, and {len(states.numbers):,} states follow")
    if (np.sort(states.numbers) != np.arange(size)).any():
        fail(where, f"the states are not numbered 0 .. {size - 1:,}")
    if initial not in (0, -1):
        fail(where, f"the initial state is {initial!r}; TCT's is 0")
    sources = np.repeat(states.numbers, states.counts)
    order = np.argsort(sources, kind="stable")
    return checked(
        where,
        length,
        size,
        np.sort(states.numbers[states.marked]),
        (sources[order], states.pairs[order, 0], states.pairs[order, 1]),
        control_data=initial == -1,
        vocal=int(states.numbers[states.vocal][0]) if states.vocal.any() else None,
    )


@dataclass(frozen=True, slots=True)
class _States:
    """States in the order of the file; those of state k are the next ``counts[k]`` of the ``pairs``."""

    numbers: NDArray[np.int64]
    marked: NDArray[np.bool_]
    vocal: NDArray[np.bool_]
    counts: NDArray[np.int64]
    pairs: NDArray[np.int64]  # (n, 2): label, entrance state


def _states(unpacker: Any, source: str) -> _States:
    """Return all states; some thousand at a time are made columns, which take a tenth of the memory."""
    parts = [_columns([], source)]
    left = unpacker.read_map_header()
    while left:
        many = min(left, ROWS)
        where = f"{source}: offset {unpacker.tell():#x}"
        parts.append(_columns([(unpacker.unpack(), unpacker.unpack()) for _ in range(many)], where))
        left -= many
    return _States(
        np.concatenate([part.numbers for part in parts]),
        np.concatenate([part.marked for part in parts]),
        np.concatenate([part.vocal for part in parts]),
        np.concatenate([part.counts for part in parts]),
        np.concatenate([part.pairs for part in parts]),
    )


def _columns(rows: list[tuple[Any, Any]], where: str) -> _States:
    numbers = [number for number, _ in rows]
    states = [state for _, state in rows]
    if any(type(state) is not dict or not FIELDS.issuperset(state) or "next" not in state for state in states):
        fail(where, "a state has the fields marked, next and vocal")
    lists = [state["next"] or [] for state in states]
    pairs = list(chain.from_iterable(lists)) if {list} >= set(map(type, lists)) else [()]
    if not {list} >= set(map(type, pairs)) or not {2} >= set(map(len, pairs)):
        fail(where, "next is nil or a list of pairs: label, entrance state")
    flat = list(chain.from_iterable(pairs))
    if not {int} >= set(map(type, flat)) | set(map(type, numbers)):
        fail(where, "labels and states are whole numbers")
    n = len(rows)
    return _States(
        np.fromiter(numbers, np.int64, n),
        np.fromiter((state.get("marked") is True for state in states), np.bool_, n),
        np.fromiter((bool(state.get("vocal")) for state in states), np.bool_, n),
        np.fromiter(map(len, lists), np.int64, n),
        np.fromiter(flat, np.int64, len(flat)).reshape(-1, 2),
    )


def write(n: Numbers) -> Iterator[bytes]:
    """Yield a MessagePack ``.DES`` file in pieces."""
    packer = msgpack.Packer(autoreset=False)
    packer.pack_map_header(5)
    for value in ("name", NAME, "version", VERSION, "size", n.size, "init", 0, "states"):
        packer.pack(value)
    packer.pack_map_header(n.size)
    for first in range(0, n.size, ROWS):
        last = min(first + ROWS, n.size)
        lo, hi = int(n.offsets[first]), int(n.offsets[last])
        pairs = list(zip(n.labels[lo:hi].tolist(), n.targets[lo:hi].tolist(), strict=True))
        cuts = (n.offsets[first : last + 1] - lo).tolist()
        for k, mark in enumerate(n.marked[first:last].tolist()):
            row = pairs[cuts[k] : cuts[k + 1]]
            packer.pack(first + k)
            packer.pack({"marked": mark, "next": row or None, "vocal": 0})
        yield packer.bytes()
        packer.reset()
    yield packer.bytes()
