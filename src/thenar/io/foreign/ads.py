"""TCT's ``.ADS``: an automaton as text, numbers under headings.

A file names the automaton, and then says under four headings how many states there are, which are marked (``*`` for
all), which have vocal outputs, and what the transitions are: exit state, label, entrance state.  ``#`` begins a
comment; blank lines mean nothing.

* State 0 is the initial one; states are called by their numbers.
* An odd label is a controllable event, an even one uncontrollable; the event is called by its label, and the alphabet
  is what the transitions carry, in rising order.
* Vocal outputs (of states, in hierarchical control) are refused: the model has none.
* A name ``DES`` is none, and is written for an automaton that has none; then the file's stem is the name.

What is written and the file cannot say (names of events and states, observable, forcible, texts) is in the table of
names; an event that the automaton blocks is looped at an extra state that nothing leads to.  UltraDES and others read
and write the same files.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.io.foreign.tct_numbers import MAX_LABEL, MAX_STATES, Numbers, automaton_of, fail, numbers
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads"]

HIGHEST = 9999  # "Transition_Label in range 0 to 9999", says TCT's template
NO_NAME = "DES"
HEADINGS = ("state size", "marker states", "vocal states", "transitions")
HEADING = re.compile(
    rb"^[ \t]*(state size|marker states|vocal states|transitions)\b[^\n]*", re.IGNORECASE | re.MULTILINE
)
COMMENT = re.compile(rb"#[^\n]*")
DIGITS = b"0123456789 \t\n\v\f\r"
BLOCK = 1 << 20  # characters of transitions that are read at a time
ROWS = 1 << 13  # transitions that are written at a time


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Read the automaton in the ADS file ``data``; messages call it ``source``.  O(characters).

    Nondeterministic ones become extended automata.  Raises ModelError with the line for everything else than this
    format, for vocal outputs, and for numbers out of range.

    >>> text = b"# TCT\\nM1\\nState size:\\n2\\nMarker states:\\n0\\nVocal states:\\n\\nTransitions:\\n0 1 1\\n1 2 0\\n"
    >>> machine = loads(text, "m1.ads")
    >>> machine, list(machine.transitions())
    (Automaton 'M1': 2 states (1 marked), 2 transitions, 2 events, [('0', '1', '1'), ('1', '2', '0')])
    """
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n").removeprefix(b"\xef\xbb\xbf")
    places = {m[1].lower().decode(): m for m in HEADING.finditer(text)}
    missing = [h for h in HEADINGS if h not in places and h != "vocal states"]
    if missing:
        fail(source, *(f"no line {h.capitalize() + ':'!r}; this is no ADS file of TCT" for h in missing))
    starts = sorted(m.start() for m in places.values())

    def span(heading: str) -> tuple[int, int]:
        match = places.get(heading)
        return (match.end(), min((k for k in starts if k > match.start()), default=len(text))) if match else (0, 0)

    reader = _Reader(text, source)
    size = reader.numbers(*span("state size"))
    if len(size) != 1 or not 0 <= size[0] <= max(MAX_STATES, len(data)):
        fail(reader.line(places["state size"].end()), f"the state size is a number from 0 to {MAX_STATES:,}")
    n = int(size[0])
    marked = _marked(reader, n, *span("marker states"))
    if len(vocal := reader.numbers(*span("vocal states"))):
        where = reader.line(places["vocal states"].end())
        fail(where, f"state {vocal[0]} has a vocal output; outputs of states are not supported, leave that list empty")
    triples = reader.triples(*span("transitions"))
    s, e, t = (np.ascontiguousarray(column) for column in triples.T)
    bad = np.flatnonzero((s < 0) | (s >= n) | (t < 0) | (t >= n) | (e < 0) | (e > MAX_LABEL))
    if len(bad):
        row = " ".join(map(str, triples[bad[0]].tolist()))
        where = reader.line(places["transitions"].end())
        fail(where, f"transition {bad[0] + 1:,} ({row}) has a state beyond {n - 1:,} or a label beyond {MAX_LABEL:,}")
    return automaton_of(source, n, marked, s, e, t, _name(text[: starts[0]]))


def _name(head: bytes) -> str:
    lines = (line.strip() for line in COMMENT.sub(b"", head).decode("utf-8", "replace").split("\n"))
    name = next((line for line in lines if line), "")
    return "" if name == NO_NAME else name


def _marked(reader: _Reader, n: int, start: int, end: int) -> NDArray[np.bool_]:
    marked = np.zeros(n, np.bool_)
    if COMMENT.sub(b"", reader.text[start:end]).strip() == b"*":
        marked[:] = True
        return marked
    listed = reader.numbers(start, end)
    if len(listed) and not (0 <= listed.min() and listed.max() < n):
        fail(reader.line(start), f"a marker state lies outside 0 .. {n - 1:,}")
    marked[listed] = True
    return marked


class _Reader:
    """The numbers in parts of a text."""

    def __init__(self, text: bytes, source: str) -> None:
        self.text = text
        self.source = source

    def line(self, position: int) -> str:
        """Return the place, as messages call it."""
        line, before = self.text.count(b"\n", 0, position) + 1, self.text.rfind(b"\n", 0, position)
        return f"{self.source}:{line}:{position - before}"

    def numbers(self, start: int, end: int) -> NDArray[np.int64]:
        """Return the numbers from ``start`` to ``end``."""
        block = self.text[start:end]
        if b"#" in block:
            block = COMMENT.sub(b"", block)
        if block.translate(None, DIGITS):  # NumPy would take a sign alone for a part of the next number
            self.check_words(start, end)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                if block.strip():
                    return np.fromstring(block.decode("ascii"), np.int64, sep=" ")
            except (DeprecationWarning, ValueError):
                fail(self.line(start), "a number is expected here")
        return np.zeros(0, np.int64)

    def check_words(self, start: int, end: int) -> None:
        """Raise ModelError for the first word that is no number, if there is one."""
        for match in re.finditer(rb"#[^\n]*|[^\s#]+", self.text[start:end]):
            if not match[0].startswith(b"#") and not re.fullmatch(rb"[+-]?[0-9]{1,18}", match[0]):
                word = match[0][:40].decode("utf-8", "replace")
                fail(self.line(start + match.start()), f"{word!r} is no number that can stand here")

    def triples(self, start: int, end: int) -> NDArray[np.int64]:
        """Return the transitions from ``start`` to ``end``, three numbers in a line."""
        found = [np.zeros((0, 3), np.int64)]
        while start < end:
            stop = self.text.find(b"\n", start + BLOCK, end)
            stop = end if stop < 0 else stop
            values = self.numbers(start, stop)
            lines = COMMENT.sub(b"", self.text[start:stop]).split(b"\n")
            if len(values) != 3 * sum(map(bool, map(bytes.strip, lines))):
                self.misaligned(start, lines)
            found.append(values.reshape(-1, 3))
            start = stop
        return np.concatenate(found)

    def misaligned(self, start: int, lines: list[bytes]) -> None:
        """Raise ModelError for the first of ``lines`` that does not hold three numbers."""
        first = self.text.count(b"\n", 0, start) + 1
        for k, line in enumerate(lines):
            if len(line.split()) not in (0, 3):
                what = f"a transition is three numbers: exit state, label, entrance state; here are {len(line.split())}"
                fail(f"{self.source}:{first + k}:1", what)


def dumps(
    automaton: Automaton | ExtendedAutomaton,
    *,
    alphabet: Alphabet | None = None,
    labels: Mapping[str, int] = MappingProxyType({}),
) -> Written:
    """Write ``automaton`` as an ADS file, in pieces.  O(states + transitions).

    ``alphabet`` are the events of all automata that TCT is to take together, so that an event has the same label in
    each file; by default, those of ``automaton``.  ``labels`` are those that events have in other files already.

    Raises InputError for several initial states, guards and updates, more states than TCT takes, and for events whose
    labels would be beyond 9999.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> written = dumps(lamp)
    >>> print("".join(written.chunks)[-25:], written.names.events[0])
    Transitions:
    0 1 1
    1 3 0
     ('1', Event('on', controllable))
    """
    n = numbers(automaton, HIGHEST, alphabet, labels, "ADS")
    if n.size > MAX_STATES:
        raise InputError(f"{n.size:,} states, and TCT takes at most {MAX_STATES:,} from an ADS file")
    return Written(_pieces(n), n.names, n.notes)


def _pieces(n: Numbers) -> Iterator[str]:
    name = " ".join(COMMENT.sub(b"", n.name.encode("utf-8", "replace")).decode().split())
    if not name or HEADING.match(name.encode()):
        name = NO_NAME
    head = (
        "# CTCT ADS file\n\n{}\n\nState size (State set will be (0,1....,size-1)):\n# <-- in range 0 to 2000000\n{}\n\n"
        "Marker states:\n# <-- one per line, * for all\n"
    )
    yield head.format(name, n.size)
    state = list(map(str, range(n.size)))
    marked = np.flatnonzero(n.marked).tolist()
    for k in range(0, len(marked), ROWS):
        yield "\n".join([state[q] for q in marked[k : k + ROWS]]) + "\n"
    yield "\nVocal states:\n# <-- State  Vocal_Output, Vocal_Output in range 10 to 99.\n\nTransitions:\n"
    sources = np.repeat(np.arange(n.size), np.diff(n.offsets))
    label = {k: f" {k} " for k in np.flatnonzero(np.bincount(n.labels, minlength=1)).tolist()}
    for k in range(0, len(n.labels), ROWS):
        rows = slice(k, k + ROWS)
        s, e, t = (column[rows].tolist() for column in (sources, n.labels, n.targets))
        words = ["\n"] * (4 * len(s))
        words[0::4] = map(state.__getitem__, s)
        words[1::4] = map(label.__getitem__, e)
        words[2::4] = map(state.__getitem__, t)
        yield "".join(words)
