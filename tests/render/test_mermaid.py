import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thenar.library.glr import finger
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.supervisor import Supervisor
from thenar.render import mermaid
from thenar.render.measure import printable

ANY_TEXT = st.text(st.characters(), min_size=1, max_size=30)
LINE = re.compile(
    r'stateDiagram-v2|    (state "[^"#;]*" as s\d+|\[\*\] --> s\d+|s\d+ --> s\d+(: [^":#;]+)?|'
    r'note right of s\d+: [^"#;]+'
    r"|classDef \w+ \S+|class [s\d,]+ \w+|%% .*)"
)


def decoded(text: str) -> str:
    return re.sub(r"#(\d+);", lambda match: chr(int(match[1])), text)


@given(st.lists(ANY_TEXT, min_size=2, max_size=2, unique=True), ANY_TEXT)
def test_any_name_survives(states: list[str], event: str) -> None:
    event = "".join(c for c in event if not c.isspace() and c != ",") or "e"
    a, b = states
    G = Automaton.from_transitions([(a, event, b)], initial=a, events=[Event(event)])
    text = mermaid(G)
    assert all(LINE.fullmatch(re.sub(r"#\d+;", "X", line)) for line in text.splitlines()), text
    assert f'state "{printable(a)}" as s0' in decoded(text)
    assert f'state "{printable(b)}" as s1' in decoded(text)
    assert f"s0 --> s1: {printable(event)}" in decoded(text)


def test_the_finger() -> None:
    text = mermaid(finger(1), highlight=[3])
    assert text.startswith('stateDiagram-v2\n    state "neutral" as s0\n')
    assert "    [*] --> s0\n" in text
    assert "    s5 --> s7: unstable_contact_1!, finger_1_obj_misalign!\n" in text
    assert "    class s0,s17 marked\n" in text
    assert text.endswith("    class s3 highlighted")
    assert text == mermaid(finger(1), highlight=[3])


def test_disabled_events_are_a_note() -> None:
    G = Automaton.from_transitions(["a -go-> b"], initial="a", alphabet=["stop"])
    S = Supervisor(G, np.array([0, 0, 1]), np.array([G.alphabet.index("stop")], np.int32))
    assert "note right of s1: disabled#58; stop" in mermaid(S)


def test_a_large_automaton_is_shown_in_part() -> None:
    G = Automaton.from_transitions([f"{k} -on-> {k + 1}" for k in range(100)], initial="0")
    text = mermaid(G, centre=50)
    assert text.count('state "') == 32, "30 states, and what leads in and out"
    assert text.endswith("%% 30 of 101 states, around state 50")
