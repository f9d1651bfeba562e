"""TCT's ADS files: what people and other tools write, round trip, and what is refused."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.io.foreign.odd_automata import odd_automaton, restored, said, several_starts, through_a_file

from thenar.errors import InputError, ModelError
from thenar.io.foreign import ads
from thenar.io.foreign.written import Names
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton

# As TCT's own template goes: comments between the headings and the numbers.
TEMPLATE = """\
# CTCT ADS auto-generated

BUFFER

State size (State set will be (0,1....,size-1)):
# <-- Enter state size, in range 0 to 2000000, on line below.
3

Marker states:
# <-- Enter marker states, one per line.
# To mark all states, enter *.
0
2

Vocal states:
# <-- Enter vocal output states, one per line.

Transitions:
# <-- Enter transition triple, one per line.
0 2 1
1 3 0   # taken away
0 8 1

1 8 2
"""


def read(text: str | bytes) -> Automaton:
    a = ads.loads(text if isinstance(text, bytes) else text.encode(), "file.ads")
    assert isinstance(a, Automaton)
    return a


def text_of(a: Automaton | ExtendedAutomaton) -> str:
    return "".join(map(str, ads.dumps(a).chunks))


def test_the_template_is_read() -> None:
    a = read(TEMPLATE)
    assert (a.name, a.n_states, a.initial, a.marked.tolist()) == ("BUFFER", 3, 0, [True, False, True])
    assert a.alphabet == Alphabet([Event("2", False), Event("3"), Event("8", False)])
    assert set(a.transitions()) == {("0", "2", "1"), ("1", "3", "0"), ("0", "8", "1"), ("1", "8", "2")}


@pytest.mark.parametrize(
    "text",
    [
        TEMPLATE.replace("\n", "\r\n"),
        TEMPLATE.replace("\n", "\r"),
        "\ufeff" + TEMPLATE,
        TEMPLATE.replace("0\n2\n\nVocal", "0 2\n\nVocal"),  # in one line, as UltraDES writes them
        TEMPLATE.replace("0 2 1\n", "0     2   1    \n"),
        TEMPLATE.replace("0 2 1\n", "0\t2\t1\n"),
        TEMPLATE.replace("Marker states:", "MARKER STATES"),
        TEMPLATE.replace("Vocal states:\n# <-- Enter vocal output states, one per line.\n", ""),
        TEMPLATE.replace("1 8 2\n", "1 8 2"),
        TEMPLATE.replace("1 8 2\n", "1 8 2\n1 8 2\n"),
    ],
)
def test_other_ways_to_write_it(text: str) -> None:
    assert said(read(text)) == said(read(TEMPLATE))


def test_a_star_marks_all_states() -> None:
    assert read(TEMPLATE.replace("0\n2\n\nVocal", "  *\n\nVocal")).marked.all()


def test_without_a_name_the_file_gives_it() -> None:
    assert read(TEMPLATE.replace("BUFFER", "")).name == "file"
    assert read(TEMPLATE.replace("BUFFER", "DES")).name == "file"


def test_names_flags_and_blocked_events_come_back_with_the_table() -> None:
    for seed in range(1000):
        a = odd_automaton(Random(seed))
        if not several_starts(a):
            again = ads.loads(text_of(a).encode(), "a.ads")
            assert said(restored(again, ads.dumps(a).names)) == said(a)


def test_the_table_is_found_beside_the_file(tmp_path: Path) -> None:
    for seed in range(40):
        a = odd_automaton(Random(seed))
        if not several_starts(a) and a.states:
            assert said(through_a_file(a, tmp_path / "a.ads")) == said(a)


def test_numbers_need_no_table() -> None:
    a = read(TEMPLATE)
    assert ads.dumps(a).names is None
    assert text_of(read(text_of(a))) == text_of(a)
    b = read(text_of(a))
    assert b.name == a.name
    assert all(np.array_equal(getattr(a, x), getattr(b, x)) for x in ("offsets", "events", "targets", "marked"))


def test_an_automaton_without_states_is_written_and_read() -> None:
    assert read(text_of(Automaton.empty(Alphabet(["1"])))).is_empty


def test_a_name_cannot_be_taken_for_a_heading() -> None:
    a = Automaton.from_transitions(["0 -1-> 0"], initial="0", name="Transitions\n# 5")
    assert read(text_of(a)).n_transitions == 1


def test_files_over_one_alphabet_have_the_same_labels() -> None:
    events = Alphabet(["a", "b"])
    a = Automaton.from_transitions(["0 -b-> 0"], initial="0", events=events)
    names = ads.dumps(a, alphabet=events).names
    assert isinstance(names, Names)
    assert names.events == (("3", Event("b")),)


def test_pieces_are_small() -> None:
    a = Automaton.from_transitions([(str(k), "1", str((k + 1) % 30_000)) for k in range(30_000)], initial="0")
    assert max(map(len, ads.dumps(a).chunks)) < 200_000


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "file.ads: no line 'State size:'"),
        ("State size\n1\n", "no line 'Marker states:'"),
        (TEMPLATE.replace("\n3\n", "\n\n"), "the state size is a number from 0 to 2,000,000"),
        (TEMPLATE.replace("\n3\n", "\n1000000000\n"), "file.ads:5:.*the state size is a number from 0 to 2,000,000"),
        (TEMPLATE.replace("\n3\n", "\n-1\n"), "the state size"),
        (TEMPLATE.replace("\n3\n", "\nthree\n"), r"file.ads:7:1: 'three' is no number"),
        (TEMPLATE.replace("0\n2\n\nV", "0\n3\n\nV"), r"a marker state lies outside 0 \.\. 2"),
        (TEMPLATE.replace("line.\n\nTrans", "line.\n1 20\n\nTrans"), "state 1 has a vocal output"),
        (TEMPLATE.replace("0 8 1", "0 8"), "file.ads:22:1: a transition is three numbers.*here are 2"),
        (TEMPLATE.replace("0 8 1", "0 8 1 1"), "here are 4"),
        (TEMPLATE.replace("0 8 1", "0 x 1"), "file.ads:22:3: 'x' is no number"),
        (TEMPLATE.replace("0 8 1", "0 8 1.5"), "'1.5' is no number"),
        (TEMPLATE.replace("0 8 1", "0 8 é"), "'é' is no number"),
        (TEMPLATE.replace("0 8 1", "0 8 3"), r"transition 3 \(0 8 3\) has a state beyond 2 or a label beyond 65,535"),
        (TEMPLATE.replace("0 8 1", "0 -8 1"), "transition 3"),
        (TEMPLATE.replace("0 8 1", "0 99999999999999999999999 1"), "is no number|transition 3"),
    ],
)
def test_a_bad_file_is_refused_with_line_and_sentence(text: str, what: str) -> None:
    with pytest.raises(ModelError, match=what):
        read(text)


def test_what_it_cannot_hold_is_refused() -> None:
    many = Automaton.from_transitions([("0", f"e{k}", "0") for k in range(5001)], initial="0")
    with pytest.raises(InputError, match="the labels of ADS end at 9,999"):
        ads.dumps(many)
    with pytest.raises(InputError, match="starts in 2 states"):
        ads.dumps(ExtendedAutomaton("A", Alphabet(), ("p", "q"), (True, True), (False, False), ()))


PIECES = [*(line + "\n" for line in TEMPLATE.splitlines()), "*\n", "0 1 1\n", "9" * 30, "\x00", "#", "State size\n"]


@given(
    st.one_of(st.binary(max_size=60), st.lists(st.sampled_from(PIECES), max_size=40).map(lambda p: "".join(p).encode()))
)
def test_no_file_does_harm(data: bytes) -> None:
    with suppress(InputError):
        ads.loads(data, "fuzzed.ads")


@given(st.integers(0, len(TEMPLATE)), st.binary(max_size=4), st.integers(0, 6))
def test_no_changed_file_does_harm(place: int, piece: bytes, dropped: int) -> None:
    data = TEMPLATE.encode()
    with suppress(InputError):
        ads.loads(data[:place] + piece + data[place + dropped :], "fuzzed.ads")
