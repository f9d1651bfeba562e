"""libFAUDES's ``.gen``: a generator as text, in sections of words.

::

    <Generator name="machine" ftype="System">          or the name as the first word of the section
    <Alphabet> "start" +C+ "finish" "look" +o+ </Alphabet>
    <States> "idle" "busy" </States>                    or indices: 1 2, or <Consecutive> 1 100 </Consecutive>
    <TransRel> "idle" "start" "busy"  "busy" "finish" "idle" </TransRel>
    <InitStates> "idle" </InitStates>
    <MarkedStates> "idle" </MarkedStates>
    </Generator>

It is read as libFAUDES 2.33 reads it: words may be quoted or not, ``%`` begins a comment, ``&lt;`` and its like are
characters; states have an index from 1 on (by position, or ``name#index``), and may be called by it; the sections
may be called ``T``, ``S``, ``I``, ``M``; states and events that are listed nowhere are those of the transitions.

* Flags of events: ``C`` controllable, ``O`` observable, ``F`` forcible, small letters for the contrary.  Without a
  flag an event is **uncontrollable**, observable and not forcible: libFAUDES's default for its class System
  (generator.dtd).  Its plain class Generator says nothing of control, and is read in the same way.
* ``P`` (preemptible), priorities (of the plug-in for prioritised events) and flags of other plug-ins (roles of inputs
  and outputs) have no word in the model; they are kept in the event's ``meaning`` and change nothing.
* White space and commas in names of events become ``_``.  A state without a name is called by its index.
* Several initial states, and several successors, make an extended automaton.
* The older ``<cGenerator>`` lists the controllable and the observable events behind the generator, and may give the
  number of states in the place of a list.
* Refused: clocks, invariants and guards of timed generators, colours, acceptance of infinite strings, hybrid ones.
* Flags of states and transitions, and unknown sections, are skipped, as libFAUDES does.

Text that is not UTF-8 is taken for Latin-1.  XML in such a file is read by :mod:`thenar.io.foreign.faudes_xml`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from thenar.errors import did_you_mean
from thenar.io.foreign import faudes_xml
from thenar.io.foreign.faudes_parts import Called, Flags, Generator, called, option, skip
from thenar.io.foreign.faudes_plain import PlainWords, Rows
from thenar.io.foreign.faudes_tokens import NotPlainError, Token, Tokens, decoded
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads"]

ROWS = 1 << 13  # transitions, or states, that are written at a time
WRAPPERS = ("aGenerator", "cGenerator")


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Read the generator in the libFAUDES file ``data``, text or XML; messages call it ``source``.  O(characters).

    Raises ModelError with line and column for what is no generator, and for what the module's docstring refuses.

    >>> lamp = b'<Generator> LAMP <T> dark on lit  lit off dark </T> <I> dark </I> <M> dark </M> </Generator>'
    >>> loads(lamp, "lamp.gen"), loads(lamp, "lamp.gen").alphabet
    (Automaton 'LAMP': 2 states (1 marked), 2 transitions, 2 events, Alphabet(on!, off!))
    """
    if faudes_xml.is_xml(data):
        return faudes_xml.loads(data, source)
    text = decoded(data)
    return _Reader(Tokens(text, source), Generator(source, len(text))).read()


class _Reader:
    """Reads one generator."""

    def __init__(self, tokens: Tokens, generator: Generator) -> None:
        self.tokens = tokens
        self.generator = generator
        self.open_states = self.open_events = True  # not listed: those of the transitions
        self.wrapper = ""
        self.rows: Rows | None = None
        self.event_position: dict[str, int] = {}
        self.plain = PlainWords(generator)

    def read(self) -> Automaton | ExtendedAutomaton:
        """Read the file."""
        tokens = self.tokens
        while True:
            token = tokens.peek()
            if token.kind == "nothing":
                tokens.fail(token.position, "no section <Generator>; this is no generator of libFAUDES")
            if token.kind == "begin" and token.text == "Generator":
                break
            if token.kind == "begin" and token.text not in WRAPPERS:
                tokens.skip_section()
                continue
            self.wrapper = token.text if token.kind == "begin" else self.wrapper
            tokens.next()
        self.generator.name = tokens.next().attributes.get("name", "")
        if tokens.peek().is_element:
            self.generator.name = tokens.next().text
        while not tokens.ends("Generator"):
            self.section(tokens.peek())
        while self.wrapper and not tokens.ends(self.wrapper):
            self.older_attributes()
        if self.rows is None:
            tokens.fail(tokens.position, "the generator has no section <TransRel>")
        return self.generator.automaton(*self.rows)

    def section(self, token: Token) -> None:
        """Read a section of the generator."""
        tokens = self.tokens
        if token.kind != "begin":
            tokens.take(lambda token: token.kind == "begin", "a section")
        if token.text in ("Alphabet", "A"):
            self.early(token)
            self.alphabet(tokens.next().text)
        elif token.text in ("States", "S"):
            self.early(token)
            self.states(tokens.next().text)
        elif token.text in ("TransRel", "T"):
            self.rows = self.transitions(tokens.next().text)
        elif token.text in ("InitStates", "I"):
            self.state_set(tokens.next().text, self.generator.initial)
        elif token.text in ("MarkedStates", "M"):
            self.state_set(tokens.next().text, self.generator.marked)
        else:
            skip(tokens)

    def early(self, token: Token) -> None:
        """Make sure that the transitions, which need what ``token`` begins, have not been read."""
        if self.rows is not None:
            self.tokens.fail(token.position, f"<{token.text}> stands behind the transitions; libFAUDES wants it before")

    def alphabet(self, section: str) -> None:
        """Read the events and their flags."""
        tokens = self.tokens
        while not tokens.ends(section):
            event = tokens.take(lambda token: token.is_element, "an event")
            self.generator.events[event.text] = flags = Flags()
            self.open_events = False
            while not (token := tokens.peek()).is_element and token.kind not in ("end", "nothing"):
                if token.kind == "option":
                    flags.letters(token.text)
                elif token.kind == "number" and token.text.startswith("0x") and len(token.text) <= 18:
                    flags.bits = int(token.text, 16)
                elif token.kind == "begin":
                    flags.element(token.text, token.attributes)
                skip(tokens)

    def states(self, section: str) -> None:
        """Read the states, by name or by index."""
        tokens, g = self.tokens, self.generator
        begin = tokens.position
        if self.plain.add_states(tokens.plain()):
            self.open_states = False
            tokens.ends(section)
            return
        tokens.position = begin
        while not tokens.ends(section):
            token = tokens.peek()
            where = tokens.where(token.position) if g.n_states < 2 or token.kind == "begin" else g.source
            self.open_states = False
            if token.kind == "begin" and token.text == "Consecutive":
                g.add_range(tokens.where(token.position), *self.range())
                continue
            tokens.take(lambda token: token.is_element, "a state")
            name, sign, index = token.text.partition("#")
            if token.kind == "index":
                g.add_state(where, int(name))
            elif not sign:
                g.add_state(where, None, name)
            elif index.isascii() and index.isdigit() and len(index) < 18:
                g.add_state(where, int(index), name)
            else:
                tokens.fail(token.position, f"{token.text!r}: an index is expected after the #")
            while not (token := tokens.peek()).is_element and token.kind not in ("end", "nothing"):
                if token.kind == "begin" and token.text == "Consecutive":
                    break
                skip(tokens)
        if self.wrapper and len(g.position) == g.n_states == 1 and not g.index:
            (n,) = g.position  # the oldest files say how many states there are
            g.position, g.n_states = {}, 0
            g.add_range(tokens.where(tokens.position), 1, n)
        g.close_states(tokens.where(tokens.position))

    def range(self) -> tuple[int, int]:
        """Read ``<Consecutive> first last </Consecutive>``."""
        tokens = self.tokens
        tokens.next()
        first, last = (int(tokens.take(lambda token: token.kind == "index", "an index").text) for _ in range(2))
        if not tokens.ends("Consecutive"):
            tokens.fail(tokens.position, "a range of states is two indices")
        return first, last

    def state_set(self, section: str, chosen: set[int]) -> None:
        """Read the initial or the marked states."""
        tokens = self.tokens
        begin = tokens.position
        try:
            chosen.update(self.plain.states(tokens.plain()))
        except NotPlainError:
            tokens.position = begin
        while not tokens.ends(section):
            token = tokens.peek()
            if token.kind == "begin" and token.text == "Consecutive":
                self.generator.listed(tokens.where(token.position), chosen, *self.range())
            elif token.is_element:
                chosen.add(self.state(tokens.next()))
            else:
                skip(tokens)

    def state(self, token: Token) -> int:
        """Return the position of the state that ``token`` names."""
        g = self.generator
        found = g.by_index(int(token.text)) if token.kind == "index" else g.by_name(token.text)
        if found is None and self.open_states and token.kind == "index":
            return g.add_state(self.tokens.where(token.position), int(token.text))
        if found is None and self.open_states:
            return g.add_state(self.tokens.where(token.position), None, token.text)
        if found is None:
            near = did_you_mean(token.text, list(g.index)[:1000])
            self.tokens.fail(token.position, f"unknown state {token.text!r}{near}")
        return found

    def transitions(self, section: str) -> Rows:
        """Read the transitions: all at once where they are plain words, else token by token."""
        tokens = self.tokens
        self.event_position = {name: k for k, name in enumerate(self.generator.events)}
        begin = tokens.position
        if not (self.open_states or self.open_events):
            try:
                rows = self.plain.rows(tokens.plain(), self.event_position)
            except NotPlainError:
                tokens.position = begin
            else:
                tokens.ends(section)
                return rows
        return self.rows_by_token(section)

    def rows_by_token(self, section: str) -> Rows:
        """Return the transitions, read token by token."""
        tokens, rows = self.tokens, []
        while not tokens.ends(section):
            source = tokens.take(lambda token: token.is_element, "a state")
            s = self.state(source)
            label = tokens.take(lambda token: token.kind in ("string", "index", "number"), "an event")
            name = label.text
            if name not in self.event_position:
                if not self.open_events:
                    near = did_you_mean(name, list(self.event_position)[:1000])
                    tokens.fail(label.position, f"unknown event {name!r}{near}")
                self.generator.events[name] = Flags()
                self.event_position[name] = len(self.event_position)
            rows.append((s, self.event_position[name], self.state(tokens.take(lambda t: t.is_element, "a state"))))
            while not (token := tokens.peek()).is_element and token.kind not in ("end", "nothing"):
                skip(tokens)
        self.open_states = False
        s_, e_, t_ = np.array(rows, np.int64).reshape(-1, 3).T
        return s_, e_, t_

    def older_attributes(self) -> None:
        """Read what a ``<cGenerator>`` says behind the generator: which events are controllable and observable."""
        tokens = self.tokens
        token = tokens.peek()
        letter = {"Controllable": "C", "Observable": "O", "Forcible": "F"}.get(token.text)
        if token.kind == "begin" and token.text == "EventAttributes":
            tokens.next()
            while not tokens.ends("EventAttributes"):
                self.older_attributes()
        elif token.kind == "begin" and letter:
            listed = {within.text for within in tokens.skip_section()}
            for name, flags in self.generator.events.items():
                flags.letters(letter if name in listed else letter.lower())
        else:
            skip(tokens)


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    """Write ``automaton`` as a generator in libFAUDES's text form, of class System, in pieces.

    States are called by their names; if these are 1, 2, 3, ... they are written as indices.  Names that the form
    cannot say, and texts, are kept in the table of names.  O(states + transitions).

    Raises InputError for guards and updates.

    >>> lamp = Automaton.from_transitions(["dark -on-> lit -off-> dark"], initial="dark", marked=["dark"], name="LAMP",
    ...     uncontrollable=["off"])
    >>> print("".join(dumps(lamp).chunks))
    <Generator name="LAMP" ftype="System">
    <BLANKLINE>
    <Alphabet>
    "on" +C+
    "off"
    </Alphabet>
    <BLANKLINE>
    <States>
    "dark"
    "lit"
    </States>
    <BLANKLINE>
    <TransRel>
    "dark" "on" "lit"
    "lit" "off" "dark"
    </TransRel>
    <BLANKLINE>
    <InitStates>
    "dark"
    </InitStates>
    <BLANKLINE>
    <MarkedStates>
    "dark"
    </MarkedStates>
    <BLANKLINE>
    </Generator>
    <BLANKLINE>
    """
    c = called(automaton)
    return Written(_pieces(c), c.names)


def _pieces(c: Called) -> Iterator[str]:
    p = c.parts
    name = faudes_xml.escaped(p.name)
    yield f'<Generator name="{name}" ftype="System">\n\n<Alphabet>\n'
    events = [f'"{faudes_xml.escaped(e)}"' for e in c.events]
    flags = [f" +{letters}+" if (letters := option(e)) else "" for e in p.alphabet]
    yield from _lines([e + f for e, f in zip(events, flags, strict=True)])
    yield "</Alphabet>\n\n<States>\n"
    states = list(c.states) if c.numbered else [f'"{faudes_xml.escaped(q)}"' for q in c.states]
    if c.numbered and len(states) > 1:
        yield f"<Consecutive> 1 {len(states)} </Consecutive>\n"
    else:
        yield from _lines(states)
    yield "</States>\n\n<TransRel>\n"
    middle = [f" {e} " for e in events]
    for k in range(0, len(p.sources), ROWS):
        rows = slice(k, k + ROWS)
        words = ["\n"] * (4 * len(p.sources[rows]))
        words[0::4] = map(states.__getitem__, p.sources[rows].tolist())
        words[1::4] = map(middle.__getitem__, p.events[rows].tolist())
        words[2::4] = map(states.__getitem__, p.targets[rows].tolist())
        yield "".join(words)
    yield "</TransRel>\n\n<InitStates>\n"
    yield from _lines([states[q] for q in p.initial])
    yield "</InitStates>\n\n<MarkedStates>\n"
    yield from _lines([states[q] for q in np.flatnonzero(p.marked).tolist()])
    yield "</MarkedStates>\n\n</Generator>\n"


def _lines(words: Sequence[str]) -> Iterator[str]:
    for k in range(0, len(words), ROWS):
        yield "\n".join(words[k : k + ROWS]) + "\n"
