"""Mermaid's state diagrams: how people write them, round trips, our own pictures, and damaged files."""

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.io.foreign.drawn import assert_read_or_refused, damaged, facts, odd_automaton, text, with_names

from thenar.errors import InputError, ModelError
from thenar.io.foreign import mermaid
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton
from thenar.render.mermaid import mermaid as drawn

LAMP = """---
title: "LAMP #1"
config:
  theme: dark
---
stateDiagram-v2
    direction LR
    accTitle: a lamp
    accDescr {
        It shines.
    }
    %% a comment --> no transition
    state "shines bright" as lit
    [*] --> off
    off --> [*]
    off --> lit : press
    lit-->off: press, burn out!
    note right of lit
        as long as it is on
    end note
    note left of off : rests
    broken : beyond repair
    lit:::hot --> broken:::marked: #33;drop
    classDef hot fill:#f00,color:white
    class lit,off hot
    style lit fill:#fff
"""


def read(content: str) -> Automaton | ExtendedAutomaton:
    return mermaid.loads(content.encode(), "g.mmd")


def test_a_diagram() -> None:
    a = read(LAMP)
    assert (a.name, list(a.alphabet)) == ("LAMP #1", [Event("press"), Event("burn_out", False), Event("drop", False)])
    lit, broken = "shines bright", "beyond repair"
    edges = {("off", "press", lit), (lit, "press", "off"), (lit, "burn_out", "off"), (lit, "drop", broken)}
    assert facts(a)[1:] == ((lit, "off", broken), edges, {"off", broken}, {"off"})
    assert facts(read(LAMP.replace("\n", "\r\n"))) == facts(a)


def test_the_title_may_be_missing_or_plain() -> None:
    assert read("stateDiagram\n[*] --> a").name == "g"
    assert read("---\ntitle: a lamp\n---\n\n%% x\nstateDiagram-v2\n[*] --> a").name == "a lamp"
    assert read("---\ntitle: 'it''s'\n---\nstateDiagram-v2\n[*] --> a").name == "it's"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "g.mmd:1: a diagram of states begins with stateDiagram-v2, not the end of the file"),
        ("graph LR\n", "g.mmd:1: a diagram of states begins with stateDiagram-v2, not 'graph LR'"),
        ("---\ntitle: x\n", "g.mmd:1: this front matter has no end, a line ---"),
        ("stateDiagram-v2\n[*] --> a\na --> b", "g.mmd:3: the transition a --> b has no text, and it needs an event"),
        ("stateDiagram-v2\na --> a: x", "g.mmd: no initial state"),
        ("stateDiagram-v2\n[*] --> a: x", "g.mmd:2: an arrow from or to [*] carries no event"),
        ("stateDiagram-v2\nstate A {\n", "g.mmd:2: states within states; an automaton is flat"),
        ("stateDiagram-v2\n[*] --> a\n--\n", "g.mmd:3: concurrent states"),
        ("stateDiagram-v2\nstate x <<fork>>\n", "g.mmd:2: a fork is no state"),
        ("stateDiagram-v2\nstate x <<choice>>\n", "g.mmd:2: a choice is no state"),
        ("stateDiagram-v2\nnote left of a\n  text\n", "g.mmd:2: this note has no end, a line 'end note'"),
        ("stateDiagram-v2\n[*] --> a\na -> b: x\n", "g.mmd:3: 'a -> b: x' is no statement of a state diagram"),
        ("stateDiagram-v2\n[*] --> a\na --> a: ε\n", "g.mmd:3: event name 'ε'"),
    ],
)
def test_mistakes_name_the_line(content: str, message: str) -> None:
    with pytest.raises(ModelError) as error:
        read(content)
    assert str(error.value).startswith(message)


def test_dumps_then_loads_is_the_identity() -> None:
    rng = Random(6)
    for _ in range(1000):
        original = odd_automaton(rng)
        written = mermaid.dumps(original)
        again = mermaid.loads(text(written), "file.mmd")
        assert (again.name, again.meaning) == (original.name or "file", original.meaning)
        assert facts(with_names(again, written.names)) == facts(original)


def test_pictures_are_read_too() -> None:
    lamp = Automaton.from_transitions(
        ["off -on-> lit -off-> off", "lit -burn-> off"], initial="off", marked=["off"], uncontrollable=["burn"]
    )
    assert facts(read(drawn(lamp)))[1:] == facts(lamp)[1:]


def test_guards_are_refused() -> None:
    with pytest.raises(InputError, match=r"edge 1 .* no guards and updates"):
        mermaid.dumps(ExtendedAutomaton.from_edges("A", [("p", "a", "q", "n < 2")], initial="p"))


@settings(max_examples=400, deadline=None)
@given(
    st.one_of(
        damaged([LAMP.encode()], [b"-->", b"[*]", b":::", b"#33;", b"{", b"note left of a\n", b"class a b\n", b"\xff"]),
        st.binary(max_size=60),
    )
)
def test_damaged_files_are_read_or_refused(data: bytes) -> None:
    assert_read_or_refused(mermaid.loads, data)


STARTS = ("", "class ", "state ", 'state "', "a --> ", "a:", "a --> b: ", "note ", "note left of a", "state x ")


@pytest.mark.parametrize("piece", [" ", "-", "-->", "a-->", ":", ":::a", "#", "#3", "[*]", '"', "<", "a ", "{", ","])
def test_what_repeats_a_hundred_thousand_times_takes_no_time(piece: str) -> None:
    for start in STARTS:
        for end in ("", "!", " x"):
            line = f"{start}{piece * 100_000}{end}"
            assert_read_or_refused(mermaid.loads, f"stateDiagram-v2\n[*] --> a\n{line}".encode())
