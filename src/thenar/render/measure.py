"""How much room a text takes, and where its lines break, without asking any font."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from math import fsum

from thenar.render.scene import Label

__all__ = ["cells", "event_text", "label_lines", "printable", "state_lines", "text_width"]

# Widths in em, a little above those of Helvetica and below those of DejaVu Sans, the extremes in use.
_NARROW = frozenset("fijlrtI|!.,:;'`()[]{}\\/- *\"°")
_WIDE = frozenset("mwMW@%—…&+=<>~→")
_EM_NARROW, _EM_WIDE, _EM_UPPER, _EM_OTHER = 0.36, 0.88, 0.70, 0.585

# a state name breaks after the first of these, or, where that is not enough, after the second
_BREAKS = re.compile(r"(?<=\|)"), re.compile(r"(?<=[_, .-])")


def printable(text: str) -> str:
    r"""Return ``text`` with what cannot be shown (control characters, lone surrogates) written as an escape.

    Neither a terminal nor an XML parser then finds an instruction in a name.

    >>> printable("a\x1b[31m"), printable("größe")
    ('a\\x1b[31m', 'größe')
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def text_width(text: str, size: float) -> float:
    """Return about how many px ``text`` is wide in a sans-serif font of ``size`` px."""
    return size * fsum(map(_em, text))  # not sum: its last bit differs between versions of Python


def cells(text: str) -> int:
    """Return how many columns of a terminal ``text`` fills.

    >>> cells("lift"), cells("持ち上げる")
    (4, 10)
    """
    return sum(0 if unicodedata.combining(c) else 1 + (unicodedata.east_asian_width(c) in "WF") for c in text)


def _em(c: str) -> float:
    if c in _NARROW:
        return _EM_NARROW
    if c in _WIDE:
        return _EM_WIDE
    if c.isascii():
        return _EM_UPPER if c.isupper() else _EM_OTHER
    if unicodedata.combining(c):
        return 0.0
    return 1.0 if unicodedata.east_asian_width(c) in "WF" else _EM_UPPER


def state_lines(name: str, columns: int = 20, most: int = 8) -> tuple[str, ...]:
    """Break a state name into up to ``most`` lines of about ``columns`` characters; the rest becomes "…".

    >>> state_lines("idle|neutral|approached_from_the_left")
    ('idle|neutral|', 'approached_from_the_', 'left')
    """
    lines = [printable(name)]
    for breaks in _BREAKS:
        lines = [packed for line in lines for packed in _pack(breaks.split(line), columns)]
    lines = [line[k : k + 2 * columns] for line in lines for k in range(0, max(1, len(line)), 2 * columns)]
    return tuple(lines if len(lines) <= most else [*lines[: most - 1], lines[most - 1][: columns - 1] + "…"])


def _pack(parts: Sequence[str], columns: int) -> list[str]:
    lines = [""]
    for part in parts:
        if lines[-1] and len(lines[-1]) + len(part) > columns:
            lines.append("")
        lines[-1] += part
    return lines


def event_text(label: Label, columns: int = 40) -> str:
    """Return the name of an event as an edge shows it, cut at ``columns`` characters."""
    name = printable(label.event.name)
    return name if len(name) <= columns else name[: columns - 1] + "…"


def label_lines(labels: Sequence[Label], columns: int = 26, most: int = 6) -> tuple[tuple[Label, ...], ...]:
    """Break the events of an edge into up to ``most`` lines of about ``columns`` characters.

    Events beyond that are left out: compare the number of labels in and out.
    """
    lines: list[list[Label]] = []
    room = 0
    for label in labels:
        width = len(event_text(label)) + 2
        if room < width or not lines:
            if len(lines) == most:
                break
            lines.append([])
            room = columns
        lines[-1].append(label)
        room -= width
    return tuple(map(tuple, lines))
