"""DESUMA and UMDES ``.fsm``: text, one finite-state machine a file; MDESops and UltraDES read and write it too.

The file is the number of states, then each state with its transitions, and after them, if need be, further events::

    2                         number of states

    idle   1   1              state, marked (1) or not (0), number of its transitions
    start  busy   c    o      event, state that it leads to, flags

    busy   0   1
    done   idle   uc   o

    EVENTS                    events that no transition carries: they are blocked
    reset  c   o

* The first state is the initial one.
* Flags: ``c`` controllable, ``uc`` uncontrollable, ``o`` observable, ``uo`` unobservable; a flag that is left out means
  ``c`` and ``o``, unless the event has it elsewhere.  A zero for the letter o is read as the letter.
* Columns are separated by tabs, and names may then have spaces; a line without tabs is separated by spaces.
* The order of the alphabet is that in which the file mentions the events.
* Refused: probabilities (the fifth column of MDESops), ``EMPTY_TRACE``, one event with different flags.

Source: "Input File Formats", DESUMA wiki, University of Michigan.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from thenar.errors import InputError
from thenar.io.foreign.apart import BLOCK, Parts, apart, beside, said
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.words import Mistakes, alphabet, decoded, event_name
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads"]

_FLAGS = {"c": (0, True), "uc": (0, False), "o": (1, True), "0": (1, True), "uo": (1, False)}


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    r"""Return the automaton in ``data``; ``source`` is what messages call the file, and the automaton its stem.

    O(length of the file).  Raises ModelError with all mistakes and their lines.

    >>> loads(b"2\n\nidle\t1\t1\nstart\tbusy\tc\to\n\nbusy\t0\t1\ndone\tidle\tuc\to\n", "M.fsm")
    Automaton 'M': 2 states (1 marked), 2 transitions, 2 events
    >>> loads(b"1\n\nidle\t1\t1\nstart\tbusy\n", "M.fsm")
    Traceback (most recent call last):
    thenar.errors.ModelError: M.fsm:4: unknown state 'busy'
    """
    return _Reader(decoded(data, source), source).automaton()


class _Reader:
    """Reads line after line."""

    def __init__(self, text: str, source: str) -> None:
        self.lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        self.source = source
        self.mistakes = Mistakes(source)
        self.states: dict[str, int] = {}
        self.marked: list[bool] = []
        self.events: dict[str, int] = {}
        self.flags: list[list[bool | None]] = []  # controllable and observable, None as long as nothing says so
        self.first: list[int] = []  # line that mentions the event first
        self.known: dict[tuple[str, ...], int] = {}  # event and flags as they stand in the file, and its number
        self.columns: tuple[list[int], list[int], list[str], list[int]] = ([], [], [], [])  # the last are lines

    def automaton(self) -> Automaton | ExtendedAutomaton:
        """Return what the file holds."""
        mistakes = self.mistakes
        at = self.after_blanks(0)
        size = self.lines[at].strip() if at < len(self.lines) else ""
        n = _number(size)
        if n is None:
            mistakes.fail(at + 1, f"the first line is the number of states, not {size!r}")
        if n > len(self.lines):
            mistakes.fail(at + 1, f"{n} states in a file of {len(self.lines)} lines")
        at = self.after_blanks(at + 1)
        for k in range(n):
            if at >= len(self.lines) or self.lines[at].strip() == "EVENTS":
                mistakes.fail(min(at + 1, len(self.lines)), f"{n} states are announced, and {k} follow")
            at = self.after_blanks(self.state(at))
        if at < len(self.lines) and self.lines[at].strip() == "EVENTS":
            for line in range(at + 1, len(self.lines)):
                fields = _fields(self.lines[line])
                if fields:
                    self.event(fields[0], fields[1:], line + 1)
        elif at < len(self.lines):
            mistakes.fail(at + 1, f"{n} states are announced, and more follows; the number is in the first line")
        sources, events, names, lines = self.columns
        targets = list(map(self.states.get, names))
        if None in targets:
            for target, name, line in zip(targets, names, lines, strict=True):
                if target is None:
                    mistakes.unknown(line, "state", name, self.states)
        c, o = ([flag[i] is not False for flag in self.flags] for i in (0, 1))
        sigma = alphabet(list(map(event_name, self.events)), c, o, self.first.__getitem__, mistakes)
        return assembled(
            Path(self.source).stem,
            sigma,
            list(self.states),
            [0] if n else [],
            self.marked,
            sources,
            events,
            [t for t in targets if t is not None],
            where=self.source,
        )

    def after_blanks(self, at: int) -> int:
        while at < len(self.lines) and not self.lines[at].strip():
            at += 1
        return at

    def state(self, at: int) -> int:
        """Read the state in line ``at`` and its transitions; return the line after them."""
        fields = _fields(self.lines[at])
        count = _number(fields[2]) if len(fields) == 3 else None
        if count is None or fields[1] not in ("0", "1"):
            found = self.lines[at].strip()
            self.mistakes.fail(at + 1, f"here stands a state: name, 0 or 1, number of its transitions; not {found!r}")
        name = fields[0]
        if name in self.states:
            self.mistakes.add(at + 1, f"two states are called {name!r}")
        q = self.states.setdefault(name, len(self.states))
        self.marked.append(fields[1] == "1")
        sources, events, names, lines = self.columns
        for line in range(at + 1, at + 1 + count):
            fields = _fields(self.lines[line]) if line < len(self.lines) else []
            if len(fields) < 2:
                has = line - at - 1
                self.mistakes.fail(at + 1, f"state {name!r} announces {count} transitions, and {has} follow")
            key = (fields[0], *fields[2:])
            e = self.known.get(key)
            sources.append(q)
            events.append(self.event(fields[0], fields[2:], line + 1) if e is None else e)
            names.append(fields[1])
            lines.append(line + 1)
        return at + 1 + count

    def event(self, name: str, flags: Sequence[str], line: int) -> int:
        """Return the number of the event ``name``, to which ``flags`` are added."""
        if name == "EMPTY_TRACE":
            self.mistakes.add(line, "EMPTY_TRACE is no event; give the silent transition an unobservable event")
        e = self.events.setdefault(name, len(self.events))
        if e == len(self.flags):
            self.flags.append([None, None])
            self.first.append(line)
        for flag in flags:
            kind, value = _FLAGS.get(flag, (None, True))
            if kind is None:
                what = (
                    "a probability, and automata here have none" if _is_probability(flag) else "no flag: c, uc, o, uo"
                )
                self.mistakes.add(line, f"event {name!r}: {flag!r} is {what}")
            elif self.flags[e][kind] is (not value):
                other = {"c": "uc", "uc": "c", "o": "uo", "0": "uo", "uo": "o"}[flag]
                self.mistakes.add(line, f"event {name!r} is {flag!r} here and {other!r} before; give it one meaning")
            else:
                self.flags[e][kind] = value
        self.known[name, *flags] = e
        return e


def _fields(line: str) -> list[str]:
    """Return the columns of ``line``."""
    return [field for field in map(str.strip, line.split("\t")) if field] if "\t" in line else line.split()


def _number(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 19 else None


def _is_probability(text: str) -> bool:
    try:
        return 0 <= float(text) <= 1
    except ValueError:
        return False


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    """Return ``automaton`` as text; the initial state comes first, the others keep their order.

    Not said: the automaton's name, which is that of the file.  Its meaning, forcible events, meanings of events, the
    order of the alphabet if it is not that of the file, and names of states that have white space or cannot be printed
    are kept in :attr:`Written.names`.

    Raises InputError for several initial states, guards and updates.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> print("".join(dumps(lamp).chunks).expandtabs(5))
    2
    <BLANKLINE>
    off  1    1
    on   lit  c    o
    <BLANKLINE>
    lit  0    1
    off  off  c    o
    <BLANKLINE>
    <BLANKLINE>
    """
    parts = apart(automaton, ".fsm")
    if len(parts.initial) > 1:
        names = ", ".join(repr(parts.states[q]) for q in parts.initial[:3])
        raise InputError(f"automaton {parts.name!r}: .fsm has one initial state, not {names}; determinise it first")
    parts = _initial_first(parts)
    states = said(parts.states, lambda q: q.isprintable() and q.split() == [q], "s")
    events = said(parts.alphabet.names, lambda e: e.isprintable() and e != "EMPTY_TRACE", "e")
    read = [Event(f, e.controllable, e.observable) for f, e in zip(events, parts.alphabet, strict=True)]
    unsaid = bool(parts.meaning) or not _mentioned_in_order(parts)
    return Written(_text(parts, states, read), beside(parts, read, states, unsaid=unsaid))


def _mentioned_in_order(parts: Parts) -> bool:
    """Return whether the file mentions the events in the alphabet's order: those of transitions, then the others."""
    carried, first = np.unique(parts.events, return_index=True)
    return bool((carried == np.arange(len(carried))).all() and (np.diff(first) > 0).all())


def _initial_first(parts: Parts) -> Parts:
    """Return ``parts`` with the initial state as number 0."""
    if not parts.initial or parts.initial[0] == 0:
        return parts
    q = parts.initial[0]
    old = np.concatenate(([q], np.arange(q), np.arange(q + 1, len(parts.states))))  # state k was old[k]
    new = np.argsort(old)
    sources = new[parts.sources]
    order = np.argsort(sources, kind="stable")
    return Parts(
        parts.name,
        parts.alphabet,
        [parts.states[k] for k in old.tolist()],
        [0],
        parts.marked[old],
        sources[order],
        parts.events[order],
        new[parts.targets][order],
        parts.meaning,
    )


def _text(parts: Parts, states: Sequence[str], events: Sequence[Event]) -> Iterator[str]:
    """Yield the lines of the file, some hundred states at a time."""
    n = len(states)
    offsets = np.searchsorted(parts.sources, np.arange(n + 1)).tolist()
    labels = [e.name + "\t" for e in events]
    flags = [f"\t{'c' if e.controllable else 'uc'}\t{'o' if e.observable else 'uo'}\n" for e in events]
    yield f"{n}\n\n"
    for start in range(0, n, BLOCK):
        stop = min(start + BLOCK, n)
        lo, hi = offsets[start], offsets[stop]
        heard, entered = parts.events[lo:hi].tolist(), parts.targets[lo:hi].tolist()
        lines = [labels[e] + states[t] + flags[e] for e, t in zip(heard, entered, strict=True)]
        marked = parts.marked[start:stop].tolist()
        yield "".join(
            f"{states[q]}\t{int(m)}\t{offsets[q + 1] - offsets[q]}\n"
            + "".join(lines[offsets[q] - lo : offsets[q + 1] - lo])
            + "\n"
            for q, m in zip(range(start, stop), marked, strict=True)
        )
    carried = (np.bincount(parts.events, minlength=len(events)) > 0).tolist()
    blocked = [f"{e.name}{flag}" for e, flag, c in zip(events, flags, carried, strict=True) if not c]
    if blocked:
        yield "EVENTS\n" + "".join(blocked)
