"""Traces, and answers that carry one as their evidence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import overload

from thenar.model.display import Displayable

__all__ = ["Check", "Trace"]


class Trace(Sequence[str]):
    """A string s ∈ Σ* of event names.

    Made of names, or of a text as people write it: names separated by commas or white space, ``ε`` the empty one.

    >>> Trace("lift, slip, squeeze")
    Trace('lift, slip, squeeze')
    >>> str(Trace(["lift"]) + Trace(["slip"])), str(Trace()), len(Trace("ε"))
    ('lift, slip', 'ε', 0)
    """

    __slots__ = ("events",)

    def __init__(self, events: Iterable[str] | str = ()) -> None:
        if isinstance(events, str):
            events = [] if events.strip() == "ε" else events.replace(",", " ").split()
        self.events = tuple(events)

    @overload
    def __getitem__(self, key: int) -> str: ...
    @overload
    def __getitem__(self, key: slice) -> Trace: ...
    def __getitem__(self, key: int | slice) -> str | Trace:
        return Trace(self.events[key]) if isinstance(key, slice) else self.events[key]

    def __len__(self) -> int:
        return len(self.events)

    def __add__(self, other: Iterable[str]) -> Trace:
        return Trace((*self.events, *other))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Trace) and self.events == other.events

    def __hash__(self) -> int:
        return hash(self.events)

    def __str__(self) -> str:
        return ", ".join(self.events) or "ε"

    def __repr__(self) -> str:
        return f"Trace({str(self)!r})"


@dataclass(frozen=True, slots=True)
class Check(Displayable):
    """The answer to a yes-or-no question, with its evidence.

    True exactly if ``holds``; otherwise ``witness`` is a shortest trace that shows why not and ``reason``
    says in words what happens at its end.

    >>> bool(Check("nonblocking", False, Trace(["lift"]), "no marked state can be reached"))
    False
    """

    property: str
    holds: bool
    witness: Trace | None = None
    reason: str = ""

    def __bool__(self) -> bool:
        return self.holds

    def __str__(self) -> str:
        if self.holds:
            return f"{self.property}: yes"
        after = f" after {self.witness}" if self.witness is not None else ""
        return f"{self.property}: no{after}: {self.reason}"
