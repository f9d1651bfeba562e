"""Events and alphabets: what can happen, and in which order it is listed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import overload

import numpy as np
from numpy.typing import NDArray

from thenar.errors import AlphabetClash, InputError, UnknownName

__all__ = ["Alphabet", "Event"]


@dataclass(frozen=True, slots=True)
class Event:
    """An event σ of an alphabet Σ = Σ_c ∪ Σ_uc.

    ``controllable`` events may be disabled by a supervisor; the others happen when they like.
    ``observable`` and ``forcible`` events are seen, and can be forced, by a supervisor.
    ``meaning`` is a sentence for people; it plays no part in comparisons.

    A name has no white space and no comma, so that traces can be written ``"lift, slip, squeeze"``.

    >>> Event("incip_slip*", controllable=False)
    Event('incip_slip*', uncontrollable)
    """

    name: str
    controllable: bool = True
    observable: bool = True
    forcible: bool = False
    meaning: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if not self.name or any(c.isspace() or c == "," for c in self.name):
            raise InputError(f"event name {self.name!r}: a name is not empty and has no white space and no comma")
        if self.name == "ε":
            raise InputError("event name 'ε': that is the empty trace; give the event another name")

    def __repr__(self) -> str:
        return f"Event({self.name!r}, {', '.join(self.properties)})"

    @property
    def properties(self) -> tuple[str, ...]:
        """The properties in words, as messages print them."""
        return (
            "controllable" if self.controllable else "uncontrollable",
            *(() if self.observable else ("unobservable",)),
            *(("forcible",) if self.forcible else ()),
        )


class Alphabet:
    """An ordered, immutable set of events.

    The order is part of the meaning: operations number states breadth-first, successors in the order of
    the alphabet, as TCT numbers the states of a product in the order of its event labels.

    >>> sigma = Alphabet([Event("lift"), Event("slip", controllable=False)])
    >>> sigma.index("slip"), [e.name for e in sigma]
    (1, ['lift', 'slip'])
    >>> sigma | Alphabet(["squeeze"])
    Alphabet(lift, slip!, squeeze)
    """

    __slots__ = ("_events", "_index")

    def __init__(self, events: Iterable[Event | str] = ()) -> None:
        if isinstance(events, str):
            raise InputError(f"an alphabet is a list of events, not the text {events!r}")
        self._events = tuple(Event(e) if isinstance(e, str) else e for e in events)
        self._index = {e.name: k for k, e in enumerate(self._events)}
        if len(self._index) < len(self._events):
            seen: set[str] = set()
            twice = next(e.name for e in self._events if e.name in seen or seen.add(e.name))  # type: ignore[func-returns-value]
            raise InputError(f"duplicate event {twice!r}: an alphabet lists each event once")

    @overload
    def __getitem__(self, key: int | str) -> Event: ...
    @overload
    def __getitem__(self, key: slice) -> Alphabet: ...
    def __getitem__(self, key: int | str | slice) -> Event | Alphabet:
        if isinstance(key, slice):
            return Alphabet(self._events[key])
        return self._events[self.index(key) if isinstance(key, str) else key]

    def __len__(self) -> int:
        return len(self._events)

    def __iter__(self) -> Iterator[Event]:
        return iter(self._events)

    def __contains__(self, event: object) -> bool:
        return (event.name if isinstance(event, Event) else event) in self._index

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Alphabet) and self._events == other._events

    def __hash__(self) -> int:
        return hash(self._events)

    def __repr__(self) -> str:
        """List the names; ``!`` marks an uncontrollable event, as in Supremica."""
        return f"Alphabet({', '.join(e.name + '!' * (not e.controllable) for e in self)})"

    @property
    def names(self) -> tuple[str, ...]:
        """The names, in order."""
        return tuple(self._index)

    @property
    def uncontrollable(self) -> NDArray[np.bool_]:
        """(len(self),) bool: which events no supervisor can disable."""
        return np.array([not e.controllable for e in self], dtype=np.bool_)

    def index(self, name: object) -> int:
        """Return the position of the event called ``name``; raise UnknownName if there is none."""
        key = name.name if isinstance(name, Event) else name
        try:
            return self._index[key]  # type: ignore[index]
        except KeyError:
            raise UnknownName("event", key, self._index) from None

    def restrict(self, names: Iterable[str]) -> Alphabet:
        """Return the events called ``names``, in the order of this alphabet."""
        return Alphabet(self._events[k] for k in sorted({self.index(n) for n in names}))

    def __or__(self, other: Alphabet) -> Alphabet:
        return merge([self, other])


def merge(alphabets: Sequence[Alphabet], owners: Sequence[str] = ()) -> Alphabet:
    """Return the union in order of first mention; ``owners`` name the alphabets in an AlphabetClash.

    >>> merge([Alphabet(["a"]), Alphabet([Event("a", controllable=False)])], ["G", "SPEC"])
    Traceback (most recent call last):
    thenar.errors.AlphabetClash: event 'a' is controllable in 'G' and uncontrollable in 'SPEC'; give it one meaning
    """
    first: dict[str, tuple[Event, int]] = {}
    for k, alphabet in enumerate(alphabets):
        for event in alphabet:
            known, owner = first.setdefault(event.name, (event, k))
            if known != event:
                here, there = (repr(owners[i]) if owners else f"automaton {i + 1}" for i in (owner, k))
                raise AlphabetClash(
                    f"event {event.name!r} is {', '.join(known.properties)} in {here} and "
                    f"{', '.join(event.properties)} in {there}; give it one meaning"
                )
    return Alphabet(event for event, _ in first.values())
