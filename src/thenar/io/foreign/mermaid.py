r"""Mermaid ``stateDiagram-v2`` (and ``stateDiagram``): one automaton as text that wikis and code hosts draw.

* States are called by their description (``state "at work" as s1``, ``s1: at work``), or by their ID where they have
  none or share it with another.
* ``[*] --> s0`` makes a state initial; ``s0 --> [*]`` marks it, and so does the class ``marked`` (``class s0 marked``
  or ``s0:::marked``).
* The text of a transition lists its events, separated by commas; white space within a name becomes ``_``.  ``!`` before
  or behind a name, on one transition at least, says that the event is uncontrollable.
* The title in the front matter is the name of the automaton.
* Notes, styles, directions, directives, comments and what is said to screen readers are skipped; character codes
  (``#33;``) are characters.
* Refused: composite and concurrent states, forks, joins, choices, transitions without text.

Written in addition: the comments ``%% alphabet: a, b!``, which lists the events in order, also those that no
transition carries (the automaton blocks them), and ``%% meaning: ...``.

Source: "State diagrams", https://mermaid.js.org/syntax/stateDiagram.html.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from html.entities import html5
from pathlib import Path

from thenar.io.foreign.apart import BLOCK, Parts, apart, beside, by_pair, said
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.words import Labels, Mistakes, decoded
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads"]

_ID = r'[^\s:{}\[\]<>"]+?'  # as short as what follows it allows
_CLASS = r"(?:\s*:::\s*([\w-]+))?"
_TRANSITION = re.compile(rf"(\[\*\]|{_ID}){_CLASS}\s*-->\s*(\[\*\]|{_ID}){_CLASS}\s*(?::(.*))?")
_STATE = re.compile(rf'(?:state\s+"([^"]*)"\s+as\s+({_ID})|(?:state\s+)?({_ID})){_CLASS}\s*(?::(?!:)(.*))?')
_KIND = re.compile(r"state\s+\S+\s*(<<|\[\[)\s*(fork|join|choice|history)")
_SKIPPED = re.compile(
    r"(%%|direction\s|classDef\s|style\s|click\s|accTitle\s*:|accDescr\s*:|hide\s+empty|scale\s)", re.IGNORECASE
)
_NOTE = re.compile(r"note\s+(?:(?:right|left)\s+of\s+[^\s:]+\s*(:)?|\"[^\"]*\"\s+(as)\s)", re.IGNORECASE)
_LINE_END = re.compile(r"<br\s*/?>|\\n")
_CODE = re.compile(r"#(\d{1,7}|\w{1,31});")
# what a text may hold as it is; anything else is written as a character code
_PLAIN = frozenset("_-+*().,'/| ")


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Return the automaton in ``data``; ``source`` is what messages call the file, its stem a diagram without title.

    O(length of the file).  Raises ModelError with all mistakes and their lines.

    >>> loads(b'''stateDiagram-v2
    ...     [*] --> off
    ...     off --> [*]
    ...     off --> lit: press
    ...     lit --> off: press, burn out!''', "lamp.mmd").alphabet
    Alphabet(press, burn_out!)
    >>> loads(b"stateDiagram-v2\\n[*] --> a\\na --> b", "g.mmd")
    Traceback (most recent call last):
    thenar.errors.ModelError: g.mmd:3: the transition a --> b has no text, and it needs an event
    """
    return _Reader(source).automaton(decoded(data, source))


class _Reader:
    """Reads line after line."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.mistakes = Mistakes(source)
        self.name = Path(source).stem
        self.meaning = ""
        self.states: dict[str, int] = {}
        self.called: dict[str, str] = {}  # the descriptions of states
        self.initial: list[int] = []
        self.marked: set[int] = set()
        self.labels = Labels(lambda text: _shown(_LINE_END.sub("\n", text)))
        self.columns: tuple[list[int], list[int], list[int]] = ([], [], [])

    def automaton(self, text: str) -> Automaton | ExtendedAutomaton:
        """Return what the file holds."""
        lines = text.replace("\r\n", "\n").split("\n")
        at = self.head(lines)
        while at < len(lines):
            at = self.line(lines, at)
        names = [self.called.get(key) or key for key in self.states]
        often = Counter(names)
        names = [name if often[name] == 1 else key for name, key in zip(names, self.states, strict=True)]
        if names and not self.initial:
            self.mistakes.add("", "no initial state; write [*] --> and the ID of the state")
        sigma = self.labels.alphabet(int, self.mistakes)
        return assembled(
            self.name,
            sigma,
            names,
            self.initial,
            [q in self.marked for q in range(len(names))],
            *self.columns,
            meaning=self.meaning,
            where=self.source,
        )

    def head(self, lines: Sequence[str]) -> int:
        """Read the front matter and the kind of diagram; return the line after it."""
        at = _after(lines, 0, lambda line: not line or line.startswith("%%"))
        if at < len(lines) and lines[at].strip() == "---":
            end = _after(lines, at + 1, lambda line: line != "---")
            if end == len(lines):
                self.mistakes.fail(at + 1, "this front matter has no end, a line ---")
            for line in lines[at + 1 : end]:
                if line.startswith("title:"):
                    self.name = _scalar(line.partition(":")[2].strip()) or self.name
            at = _after(lines, end + 1, lambda line: not line or line.startswith("%%"))
        if at == len(lines) or lines[at].strip() not in ("stateDiagram-v2", "stateDiagram"):
            found = repr(lines[at].strip()[:60]) if at < len(lines) else "the end of the file"
            self.mistakes.fail(min(at + 1, len(lines)), f"a diagram of states begins with stateDiagram-v2, not {found}")
        return at + 1

    def line(self, lines: Sequence[str], at: int) -> int:
        """Read the statement in line ``at``; return the line after it."""
        line = lines[at].strip()
        number = at + 1
        if line.startswith("%%"):
            key, _, text = line[2:].strip().partition(": ")
            if key == "alphabet":
                self.labels.numbers(text, number)
            elif key == "meaning":
                self.meaning = _shown(text)
        elif found := _TRANSITION.fullmatch(line):
            self.transition(found, number)
        elif re.match(r"accDescr\s*\{", line):
            return _after(lines, at, lambda text: "}" not in text) + 1
        elif not line or _SKIPPED.match(line):
            pass
        elif found := _NOTE.match(line):
            if not found[1] and not found[2]:
                end = _after(lines, at, lambda text: text.lower() != "end note")
                if end == len(lines):
                    self.mistakes.fail(number, "this note has no end, a line 'end note'")
                return end + 1
        elif (words := line.split())[0] == "class" and len(words) > 2:
            if words[-1] == "marked":
                self.marked.update(map(self.state, "".join(words[1:-1]).split(",")))
        elif found := _KIND.match(line):
            self.mistakes.add(number, f"a {found[2]} is no state; draw each transition from state to state")
        elif line.endswith("{") or line == "}":
            self.mistakes.fail(number, "states within states; an automaton is flat, so draw the states alone")
        elif line == "--":
            self.mistakes.add(number, "concurrent states; write one automaton a file")
        elif found := _STATE.fullmatch(line):
            described, key, bare, mark, text = found.groups()
            q = self.state(key or bare)
            if mark == "marked":
                self.marked.add(q)
            if described or text:
                self.called.setdefault(key or bare, _shown(described or text.strip()))
        else:
            self.mistakes.add(number, f"{line[:60]!r} is no statement of a state diagram that is known here")
        return number

    def state(self, key: str) -> int:
        """Return the number of the state with this ID."""
        return self.states.setdefault(key, len(self.states))

    def transition(self, found: re.Match[str], line: int) -> None:
        """Read ``s --> t: text``."""
        s, t, text = found[1], found[3], found[5] or ""
        for key, kind in ((s, found[2]), (t, found[4])):
            if key != "[*]":
                q = self.state(key)
                if kind == "marked":
                    self.marked.add(q)
        if "[*]" in (s, t):
            if text.strip() or s == t:
                self.mistakes.add(line, "an arrow from or to [*] carries no event; draw a state of its own instead")
            elif s == "[*]":
                self.initial.append(self.states[t])
            else:
                self.marked.add(self.states[s])
            return
        carried = self.labels.numbers(text, line)
        if not carried:
            self.mistakes.add(line, f"the transition {s} --> {t} has no text, and it needs an event")
        for e in carried:
            self.columns[0].append(self.states[s])
            self.columns[1].append(e)
            self.columns[2].append(self.states[t])


def _after(lines: Sequence[str], at: int, skipped: Callable[[str], bool]) -> int:
    """Return the first line from ``at`` on that is not ``skipped``."""
    while at < len(lines) and skipped(lines[at].strip()):
        at += 1
    return at


def _scalar(text: str) -> str:
    """Return the text that YAML writes in one line."""
    if text.startswith('"'):
        try:
            return str(json.loads(text))
        except ValueError:
            return text
    return text[1:-1].replace("''", "'") if text.startswith("'") and text.endswith("'") and len(text) > 1 else text


def _shown(text: str) -> str:
    """Return ``text`` with the characters for which codes stand.

    >>> _shown("#34;a#34; #amp; b#33;")
    '"a" & b!'
    """
    return _CODE.sub(_character, text) if "#" in text else text


def _character(code: re.Match[str]) -> str:
    if code[1].isdigit():
        return chr(int(code[1])) if int(code[1]) < 0x110000 else code[0]
    return html5.get(f"{code[1]};", code[0])


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    """Return ``automaton`` as a ``stateDiagram-v2``: marked states have a thick border, uncontrollable events a ``!``.

    Said is everything but unobservable and forcible events, meanings of events, empty names, and names of events that
    begin or end with ``!``; these are kept in :attr:`Written.names`.

    Raises InputError for guards and updates.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"],
    ...     uncontrollable=["off"], name="LAMP")
    >>> print("".join(dumps(lamp).chunks))
    ---
    title: "LAMP"
    ---
    stateDiagram-v2
        %% alphabet: on, off!
        state "off" as s0
        state "lit" as s1
        [*] --> s0
        s0 --> s1: on
        s1 --> s0: off!
        classDef marked stroke-width:4px
        class s0 marked
    <BLANKLINE>
    """
    parts = apart(automaton, "a drawing")
    states = said(parts.states, bool, "s")
    events = said(parts.alphabet.names, lambda e: e.strip("!") == e, "e")
    read = [Event(f, e.controllable) for f, e in zip(events, parts.alphabet, strict=True)]
    return Written(_text(parts, states, read), beside(parts, read, states))


def _text(parts: Parts, states: Sequence[str], events: Sequence[Event]) -> Iterator[str]:
    """Yield the lines of the file, some hundred at a time."""
    words = [_escaped(e.name) + "!" * (not e.controllable) for e in events]
    if parts.name:
        title = json.dumps(parts.name, ensure_ascii=not parts.name.isprintable())
        yield f"---\ntitle: {title}\n---\n"
    yield f"stateDiagram-v2\n    %% alphabet: {', '.join(words)}\n"
    if parts.meaning:
        yield f"    %% meaning: {_escaped(parts.meaning)}\n"
    for start in range(0, len(states), BLOCK):
        named = enumerate(states[start : start + BLOCK], start)
        yield "".join(f'    state "{_escaped(name)}" as s{k}\n' for k, name in named)
    yield "".join(f"    [*] --> s{q}\n" for q in parts.initial)
    for pairs in by_pair(parts):
        yield "".join(f"    s{s} --> s{t}: {', '.join([words[e] for e in carried])}\n" for s, t, carried in pairs)
    marked = parts.marked.nonzero()[0].tolist()
    if marked:
        yield "    classDef marked stroke-width:4px\n"
    for start in range(0, len(marked), BLOCK):
        yield f"    class {','.join(f's{q}' for q in marked[start : start + BLOCK])} marked\n"


def _escaped(text: str) -> str:
    r"""Return ``text`` such that Mermaid shows it and reads nothing into it.

    >>> _escaped('"a" --> <b>; %%')
    '#34;a#34; --#62; #60;b#62;#59; #37;#37;'
    """
    return "".join(c if c.isalnum() or c in _PLAIN else f"#{ord(c)};" for c in text)
