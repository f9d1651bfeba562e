"""libFAUDES's generators as XML, as its XWrite writes them and DESTool wraps them (generator.dtd).

::

    <Generator name="machine" ftype="System">
    <Alphabet> <Event name="start"> <Controllable/> </Event> <Event name="finish"/> </Alphabet>
    <StateSet> <State id="1" name="idle"> <Initial/> <Marked/> </State> <State id="2" name="busy"/> </StateSet>
    <TransitionRelation> <Transition x1="1" event="start" x2="2"/> ... </TransitionRelation>
    </Generator>

What flags and names mean, and what is refused, is as in the text form (:mod:`thenar.io.foreign.faudes`).  It is read
as libFAUDES reads it, which knows the five entities of XML and no others, takes ``%`` for the begin of a comment, and
skips elements that it does not know.  Text that is not UTF-8 is taken for Latin-1, whatever is declared.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from thenar.errors import did_you_mean
from thenar.io.foreign.faudes_parts import Called, Flags, Generator, called, skip
from thenar.io.foreign.faudes_tokens import Token, Tokens, decoded
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "escaped", "is_xml", "loads"]

ROWS = 1 << 12  # transitions, or states, that are written at a time
_XML = re.compile(rb"<(?:StateSet|TransitionRelation)[\s/>]")
_TRANSITION = re.compile(r'[\x00-\x20]*<Transition x1="([0-9]{1,17})" event="([^"<>&\x00-\x1f]*)" x2="([0-9]{1,17})"/>')
_ESCAPES = str.maketrans({"<": "&lt;", ">": "&gt;", "&": "&amp;", '"': "&quot;"})


def is_xml(data: bytes) -> bool:
    """Return whether the generator in ``data`` is written as XML and not as text.

    >>> is_xml(b"<Generator> <StateSet/> </Generator>"), is_xml(b"<Generator> <States/> <TransRel/> </Generator>")
    (True, False)
    """
    return _XML.search(data) is not None


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Read the generator in the XML file ``data``; messages call it ``source``.  O(elements).

    Raises ModelError with line and column for what is no generator, and for what the text form refuses too.

    >>> lamp = b'<Generator name="LAMP"><StateSet><State id="1"><Initial/></State></StateSet></Generator>'
    >>> loads(lamp, "lamp.xml")
    Automaton 'LAMP': 1 state (0 marked), 0 transitions, 0 events
    """
    if not is_xml(data):
        from thenar.io.foreign import faudes  # which asks here for what is XML

        return faudes.loads(data, source)
    text = decoded(data)
    return _Reader(Tokens(text, source), Generator(source, len(text))).read()


class _Reader:
    """Reads one generator."""

    def __init__(self, tokens: Tokens, generator: Generator) -> None:
        self.tokens = tokens
        self.generator = generator

    def read(self) -> Automaton | ExtendedAutomaton:
        """Read the file; the generator may lie within other elements."""
        tokens, g = self.tokens, self.generator
        while (token := tokens.peek()).kind != "begin" or token.text != "Generator":
            if token.kind == "nothing":
                tokens.fail(token.position, "no <Generator>; this is no generator of libFAUDES")
            tokens.next()
        g.name = tokens.next().attributes.get("name", "")
        rows: list[list[int]] = [[], [], []]
        while not tokens.ends("Generator"):
            token = tokens.peek()
            if token.text == "Alphabet":
                self.elements("Alphabet", {"Event": self.event})
            elif token.text == "StateSet":
                self.elements("StateSet", {"State": self.state, "Consecutive": self.range})
                g.close_states(tokens.where(token.position))
            elif token.text == "TransitionRelation":
                self.transitions(rows)
            else:
                skip(tokens)
        s, e, t = (np.array(column, np.int64) for column in rows)
        return g.automaton(s, e, t)

    def elements(self, tag: str, readers: Mapping[str, Callable[[Token], None]]) -> None:
        """Read the elements in an element, each with the reader of its tag; skip others."""
        tokens = self.tokens
        tokens.next()
        while not tokens.ends(tag):
            token = tokens.peek()
            if token.kind == "begin" and token.text in readers:
                readers[token.text](tokens.next())
            else:
                skip(tokens)

    def event(self, token: Token) -> None:
        """Read an event and its flags."""
        self.generator.events[self.value(token, "name")] = flags = Flags()
        while not self.tokens.ends("Event"):
            child = self.tokens.peek()
            flags.element(child.text, child.attributes)
            skip(self.tokens)

    def state(self, token: Token) -> None:
        """Read a state, and whether it is initial or marked."""
        g = self.generator
        position = g.add_state(g.source, self.number(token, "id"), token.attributes.get("name", ""))
        while not self.tokens.ends("State"):
            child = self.tokens.peek()
            if child.text in ("Initial", "Marked") and child.attributes.get("value", "1") not in (
                "0",
                "false",
                "False",
            ):
                (g.initial if child.text == "Initial" else g.marked).add(position)
            skip(self.tokens)

    def range(self, token: Token) -> None:
        """Read a range of states."""
        where = self.tokens.where(token.position)
        self.generator.add_range(where, self.number(token, "from"), self.number(token, "to"))
        while not self.tokens.ends("Consecutive"):
            skip(self.tokens)

    def transitions(self, rows: list[list[int]]) -> None:
        """Read the transitions: those without anything within them at a stroke."""
        tokens = self.tokens
        tokens.next()
        event = {name: k for k, name in enumerate(self.generator.events)}
        while not tokens.ends("TransitionRelation"):
            token = tokens.peek()
            if token.kind != "begin" or token.text != "Transition":
                skip(tokens)
                continue
            tokens.next()
            name = self.value(token, "event")
            if name not in event:
                tokens.fail(token.position, f"unknown event {name!r}{did_you_mean(name, list(event)[:1000])}")
            for column, value in zip(rows, (self.end(token, "x1"), event[name], self.end(token, "x2")), strict=True):
                column.append(value)
            while not tokens.ends("Transition"):
                skip(tokens)
            self.plain_transitions(event, rows)

    def plain_transitions(self, event: Mapping[str, int], rows: list[list[int]]) -> None:
        """Read the transitions that follow and are written as libFAUDES does, up to one that is wrong."""
        tokens, by_index = self.tokens, self.generator.by_index
        if tokens.pending is not None:
            return
        sources, events, targets = rows
        while match := _TRANSITION.match(tokens.text, tokens.position):
            s, e, t = by_index(int(match[1])), event.get(match[2]), by_index(int(match[3]))
            if s is None or e is None or t is None:
                break
            sources.append(s)
            events.append(e)
            targets.append(t)
            tokens.position = match.end()

    def end(self, token: Token, attribute: str) -> int:
        """Return the position of a state that a transition connects: by index, or by name."""
        value, g = self.value(token, attribute), self.generator
        found = g.by_index(int(value)) if re.fullmatch(r"[0-9]{1,17}", value) else None
        found = g.by_name(value) if found is None else found
        if found is None:
            self.tokens.fail(token.position, f"{attribute}={value!r}: there is no such state")
        return found

    def number(self, token: Token, attribute: str) -> int:
        """Return an index."""
        value = self.value(token, attribute)
        if not re.fullmatch(r"[0-9]{1,17}", value) or int(value) == 0:
            self.tokens.fail(token.position, f"{attribute}={value!r}: a number from 1 on is expected")
        return int(value)

    def value(self, token: Token, attribute: str) -> str:
        """Return an attribute that has to be there."""
        if attribute not in token.attributes:
            near = did_you_mean(attribute, token.attributes)
            self.tokens.fail(token.position, f"<{token.text}> has no attribute {attribute!r}{near}")
        return token.attributes[attribute]


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    """Write ``automaton`` as a generator in libFAUDES's XML form, of class System, in pieces.

    Names that the form cannot say, and texts, are kept in the table of names.  O(states + transitions).

    Raises InputError for guards and updates.

    >>> lamp = Automaton.from_transitions(["dark -on-> lit"], initial="dark", marked=["lit"], name="LAMP")
    >>> print("".join(dumps(lamp).chunks))
    <?xml version="1.0" encoding="UTF-8" standalone="no"?>
    <Generator name="LAMP" ftype="System">
    <Alphabet>
    <Event name="on"><Controllable/></Event>
    </Alphabet>
    <StateSet>
    <State id="1" name="dark"><Initial/></State>
    <State id="2" name="lit"><Marked/></State>
    </StateSet>
    <TransitionRelation>
    <Transition x1="1" event="on" x2="2"/>
    </TransitionRelation>
    </Generator>
    <BLANKLINE>
    """
    c = called(automaton)
    return Written(_pieces(c), c.names)


def escaped(text: str) -> str:
    """Return ``text`` as it stands in a string of libFAUDES.

    >>> escaped('a<"b"')
    'a&lt;&quot;b&quot;'
    """
    return text.translate(_ESCAPES)


def _pieces(c: Called) -> Iterator[str]:
    p = c.parts
    yield '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n'
    yield f'<Generator name="{escaped(p.name)}" ftype="System">\n<Alphabet>\n'
    yield "".join(f'<Event name="{escaped(n)}"{_flags(e)}\n' for n, e in zip(c.events, p.alphabet, strict=True))
    yield "</Alphabet>\n<StateSet>\n"
    initial = set(p.initial)
    for k in range(0, len(c.states), ROWS):
        marked = p.marked[k : k + ROWS].tolist()
        yield "".join(
            f'<State id="{q + 1}"'
            + ("" if c.numbered else f' name="{escaped(c.states[q])}"')
            + _children("<Initial/>" * (q in initial) + "<Marked/>" * marked[q - k], "State")
            for q in range(k, min(k + ROWS, len(c.states)))
        )
    yield "</StateSet>\n<TransitionRelation>\n"
    state = list(map(str, range(1, len(c.states) + 1)))
    middle = [f'" event="{escaped(e)}" x2="' for e in c.events]
    for k in range(0, len(p.sources), ROWS):
        rows = slice(k, k + ROWS)
        words = ['<Transition x1="', "", "", "", '"/>\n'] * len(p.sources[rows])
        words[1::5] = map(state.__getitem__, p.sources[rows].tolist())
        words[2::5] = map(middle.__getitem__, p.events[rows].tolist())
        words[3::5] = map(state.__getitem__, p.targets[rows].tolist())
        yield "".join(words)
    yield "</TransitionRelation>\n</Generator>\n"


def _flags(event: Event) -> str:
    said = "<Controllable/>" * event.controllable + '<Observable value="0"/>' * (not event.observable)
    return _children(said + "<Forcible/>" * event.forcible, "Event").rstrip()


def _children(said: str, tag: str) -> str:
    return f">{said}</{tag}>\n" if said else "/>\n"
