"""What the readers of text share: decoding, names of events, and mistakes with their places."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import NoReturn

from thenar.errors import InputError, Mistake, ModelError, did_you_mean
from thenar.model.events import Alphabet, Event

__all__ = ["Labels", "Mistakes", "alphabet", "decoded", "event_name", "split_label"]

MOST = 20  # mistakes listed; a file with more is of another kind, or damaged
_KNOWN = 1000  # names among which a similar one is looked for
_GAP = re.compile(r"[\s,]")


def decoded(data: bytes, source: str) -> str:
    """Return ``data`` as text, which has to be UTF-8 (a byte order mark is skipped); ModelError with the place.

    >>> decoded(b"a\\xff", "g.dot")
    Traceback (most recent call last):
    thenar.errors.ModelError: g.dot:1:2: byte 0xff is no UTF-8; save the file as UTF-8
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        what = f"byte 0x{data[error.start]:02x} is no UTF-8; save the file as UTF-8"
        raise ModelError([Mistake(f"{source}:{line}:{column}", what)]) from None


def event_name(text: str) -> str:
    r"""Return ``text`` as the name of an event: white space and commas within it become ``_``.

    >>> event_name("  push button"), event_name(r"\Large {$\alpha_1$}")
    ('push_button', '\\Large_{$\\alpha_1$}')
    """
    return _GAP.sub("_", text.strip())


def split_label(text: str) -> tuple[tuple[str, bool], ...]:
    r"""Return the events that the label of an edge lists, and whether they are controllable.

    Commas and line ends separate events; ``!`` before or behind a name says that it is uncontrollable.

    >>> split_label("start, break!"), split_label("push button\n!done")
    ((('start', True), ('break', False)), (('push_button', True), ('done', False)))
    """
    words = (word.strip() for line in text.splitlines() for word in line.split(","))
    return tuple((event_name(word.strip("!")), "!" not in (word[0], word[-1])) for word in words if word)


class Mistakes:
    """Collects what is wrong with a file and where, up to some twenty; then, or when asked, they are raised."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.found: list[Mistake] = []

    def add(self, place: str | int, what: str) -> None:
        """Note a mistake at ``place`` (a line, or "line:column"); raises ModelError if there are too many."""
        self.found.append(Mistake(f"{self.source}:{place}" if place else self.source, what))
        if len(self.found) >= MOST:
            self.check()

    def fail(self, place: str | int, what: str) -> NoReturn:
        """Note a mistake after which nothing can be read, and raise ModelError."""
        self.add(place, what)
        self.check()
        raise AssertionError

    def unknown(self, place: str | int, kind: str, name: str, known: Iterable[str]) -> None:
        """Note that no ``kind`` is called ``name``."""
        self.add(place, f"unknown {kind} {name!r}{did_you_mean(name, islice(known, _KNOWN))}")

    def check(self) -> None:
        """Raise ModelError if there is a mistake."""
        if self.found:
            raise ModelError(self.found)


def alphabet(
    names: Sequence[str],
    controllable: Sequence[bool],
    observable: Sequence[bool],
    place: Callable[[int], str | int],
    mistakes: Mistakes,
) -> Alphabet:
    """Return the alphabet of these events; names that no event can have are mistakes at ``place(k)``."""
    events: dict[str, Event] = {}
    for k, (name, c, o) in enumerate(zip(names, controllable, observable, strict=True)):
        if name in events:
            mistakes.add(place(k), f"two events are called {name!r}; white space and commas in names become '_'")
        try:
            events[name] = Event(name, controllable=c, observable=o)
        except InputError as error:
            mistakes.add(place(k), str(error))
    mistakes.check()
    return Alphabet(events.values())


class Labels:
    """The events that the labels of a drawing list, in the order in which it mentions them.

    ``shown`` turns a label as it stands in the file into what people see.

    >>> labels = Labels(str.strip)
    >>> labels.numbers("start, break!", 1), labels.numbers("break", 2)
    ([0, 1], [1])
    >>> labels.alphabet(str, Mistakes("g.dot"))
    Alphabet(start, break!)
    """

    def __init__(self, shown: Callable[[str], str]) -> None:
        self.shown = shown
        self.controllable: dict[str, bool] = {}
        self.position: dict[str, int] = {}
        self.first: list[int] = []  # where each event is mentioned first
        self.read: dict[str, list[int]] = {}

    def numbers(self, label: str, place: int) -> list[int]:
        """Return the numbers of the events that ``label`` lists; ``place`` is where it stands."""
        if label not in self.read:
            found = split_label(self.shown(label))
            for name, controllable in found:
                if self.position.setdefault(name, len(self.first)) == len(self.first):
                    self.first.append(place)
                self.controllable[name] = controllable and self.controllable.get(name, True)
            self.read[label] = [self.position[name] for name, _ in found]
        return self.read[label]

    def alphabet(self, place: Callable[[int], str | int], mistakes: Mistakes) -> Alphabet:
        """Return the events; an event is uncontrollable if one label says so.  ``place`` is as messages write it."""
        names, controllable = list(self.position), [self.controllable[name] for name in self.position]
        return alphabet(names, controllable, [True] * len(names), lambda k: place(self.first[k]), mistakes)
