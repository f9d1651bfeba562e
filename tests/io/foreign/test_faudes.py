"""libFAUDES's generators, text and XML: libFAUDES itself, round trip, dialects, and what is refused."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from random import Random
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.io.foreign import peers
from tests.io.foreign.odd_automata import odd_automaton, restored, said, through_a_file

from thenar.errors import InputError, ModelError
from thenar.io.foreign import faudes, faudes_xml
from thenar.io.foreign.faudes_tokens import Tokens
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton
from thenar.model.names import Numbered

FORMS = pytest.mark.parametrize("form", [faudes, faudes_xml], ids=["text", "xml"])
SMALL = "<Generator> G <Alphabet> a b </Alphabet> <States> p q </States> <TransRel> p a q  q b p </TransRel> <InitStates> p </InitStates> <MarkedStates> q </MarkedStates> </Generator>"  # noqa: E501
XML = """\
<?xml version="1.0" encoding="ISO-8859-1" standalone="no"?>
<!DOCTYPE System SYSTEM "http://www.faudes.org/dtd/1.0/system.dtd">
<Generator name="G" ftype="System">
<Alphabet>
<Event name="a"><Controllable/><Observable value="0"/></Event>
<Event name="b"/>
</Alphabet>
<StateSet>
<State id="1" name="p"><Initial/></State>
<State id="2" name="q"><Marked/></State>
</StateSet>
<TransitionRelation>
<Transition x1="1" event="a" x2="2"/>
<Transition x1="2" event="b" x2="1"/>
</TransitionRelation>
</Generator>
"""


def read(text: str | bytes, form: ModuleType = faudes) -> Automaton | ExtendedAutomaton:
    a = form.loads(text if isinstance(text, bytes) else text.encode(), "file.gen")
    assert isinstance(a, Automaton | ExtendedAutomaton)
    return a


def plain(text: str | bytes, form: ModuleType = faudes) -> Automaton:
    a = read(text, form)
    assert isinstance(a, Automaton)
    return a


def text_of(a: Automaton | ExtendedAutomaton, form: ModuleType = faudes) -> str:
    return "".join(form.dumps(a).chunks)


# -- round trip and libFAUDES --------------------------------------------------------------------------------


@FORMS
def test_what_is_written_is_read_again(form: ModuleType) -> None:
    for seed in range(1000):
        a = odd_automaton(Random(seed))
        again = read(text_of(a, form), form)
        assert said(restored(again, form.dumps(a).names)) == said(a)
        assert again.name == (a.name or "file")
        if form.dumps(a).names is None:
            assert again.alphabet == a.alphabet


@pytest.mark.parametrize(("name", "format_"), [("a.gen", "faudes"), ("a.xml", "faudes-xml")])
def test_the_table_is_found_beside_the_file(name: str, format_: str, tmp_path: Path) -> None:
    for seed in range(40):
        a = odd_automaton(Random(seed))
        if a.states:
            assert said(through_a_file(a, tmp_path / name, format_)) == said(a)


@FORMS
def test_libfaudes_reads_what_is_written_and_writes_the_same_automaton(form: ModuleType) -> None:
    automata = [odd_automaton(Random(seed)) for seed in range(300)]
    files = [text_of(a, form).encode() for a in automata]
    for file, (text, xml) in zip(files, peers.faudes_rewrites(files), strict=True):
        events, *rest = said(read(file, form))
        for theirs, its_form in ((text, faudes), (xml, faudes_xml)):
            its_events, *its_rest = said(read(theirs, its_form))
            assert set(its_events) == set(events)  # type: ignore[call-overload]
            assert its_rest == rest


def test_order_of_events_and_states_is_that_of_the_file() -> None:
    events = Alphabet(["u", "b"])
    a = Automaton.from_transitions(["z -u-> m -b-> a"], initial="m", states=["z", "m", "a"], events=events)
    for form in (faudes, faudes_xml):
        b = plain(text_of(a, form), form)
        assert (b.alphabet, b.initial, [b.states[q] for q in range(3)]) == (a.alphabet, 1, ["z", "m", "a"])


@FORMS
def test_states_called_from_1_on_are_indices(form: ModuleType) -> None:
    a = Automaton.from_transitions(["1 -a-> 2 -a-> 3"], initial="2", marked=["3"], states=["1", "2", "3"])
    text = text_of(a, form)
    assert '"1"' not in text.replace('id="1"', "").replace('x1="1"', "")
    assert said(read(text, form)) == said(a)
    assert isinstance(plain(text, form).states, Numbered)


def test_pieces_are_small() -> None:
    a = Automaton.from_transitions([(f"state{k}", "a", f"state{k + 1}") for k in range(30_000)], initial="state0")
    for form in (faudes, faudes_xml):
        assert max(map(len, form.dumps(a).chunks)) < 600_000


# -- what a text may look like -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        SMALL.replace(" p ", ' "p" ').replace("a b", "\"a\" 'b'"),
        SMALL.replace("TransRel>", "T>").replace("States>", "S>").replace("InitS>", "I>").replace("MarkedS>", "M>"),
        SMALL.replace("G <", '"G" % a comment with </Generator>\n <'),
        SMALL.replace("<Generator> G", '<Generator name="G" ftype="Generator">'),
        SMALL.replace("<Generator> G", "<Generator name=G>"),
        '<?xml version="1.0"?> <!-- <States> --> <Something> x </Something>' + SMALL,
        SMALL.replace(" p a q  q b p ", "\n1\n a 2 q\tb 1 "),
        SMALL.replace("p q </States>", "p#7 q#3 </States>").replace(" p a q ", " 7 a q "),
        SMALL.replace("<Alphabet> a b </Alphabet>", "").replace("<States> p q </States>", ""),
        SMALL.replace("<Alphabet> a b </Alphabet>", "").replace("<States> p q </States>", "<States/>"),
        SMALL.replace("<TransRel>", "<Extra> 1 <More> 2 </More> </Extra> <TransRel>"),
        SMALL.replace("a q", "a q +x+ 0x5 <Note> n </Note>").replace("p q </S", "p 0x12 q <Note/> </S"),
        SMALL.replace("\n", "\r\n"),
        SMALL + " % the end",
    ],
)
def test_other_ways_to_write_it(text: str) -> None:
    assert read(text).name == "G"
    assert said(read(text)) == said(read(SMALL))


@pytest.mark.parametrize(
    ("flags", "event"),
    [
        ("", Event("a", False)),
        ("+C+", Event("a")),
        ("+o+", Event("a", False, False)),
        ("+CoF+", Event("a", True, False, True)),
        ("+coF+", Event("a", False, False, True)),
        ("0x5", Event("a", True, False, True)),
        ("<Controllable/>", Event("a")),
        ('<Controllable value="0"/> <Forcible value="true"/>', Event("a", False, True, True)),
        ("+CP+", Event("a", meaning="in libFAUDES: preemptible")),
        ('+C+ <Priority value="3"/>', Event("a", meaning="in libFAUDES: priority 3")),
        ("0x00000103", Event("a", meaning="in libFAUDES: flags 0x100")),
    ],
)
def test_flags_of_events(flags: str, event: Event) -> None:
    a = read(SMALL.replace("a b <", f"a {flags} b <"))
    assert (a.alphabet[0], a.alphabet[0].meaning, len(a.alphabet)) == (event, event.meaning, 2)


def test_flags_of_events_in_xml() -> None:
    assert tuple(read(XML, faudes_xml).alphabet) == (Event("a", True, False), Event("b", False))
    more = XML.replace('<Event name="b"/>', '<Event name="b"><Flags value="0x0c"/><Priority value="2"/></Event>')
    assert read(more, faudes_xml).alphabet[1] == Event("b", False, False, True)
    assert read(more, faudes_xml).alphabet[1].meaning == "in libFAUDES: preemptible, priority 2"


def test_either_form_is_told_by_what_is_in_it() -> None:
    assert said(read(XML, faudes)) == said(read(XML, faudes_xml))
    assert said(read(SMALL, faudes_xml)) == said(read(SMALL, faudes))


def test_a_generator_within_other_elements_is_found() -> None:
    body = XML[XML.index("<Generator") :].replace("<Marked/>", '<Marked/><Graphic x="1"/>')
    text = f"<VioGenerator><VioStyle/>{body}</VioGenerator>"
    assert said(read(text, faudes_xml)) == said(read(XML, faudes_xml))


def test_states_without_names_are_called_by_their_indices() -> None:
    anonymous = "<Generator> <Alphabet> a </Alphabet> <States> <Consecutive> 2 5 </Consecutive> 9 </States>"
    a = plain(anonymous + " <T> 2 a 9 9 a 3 </T> <I> 2 </I> <M> <Consecutive> 3 4 </Consecutive> 9 </M> </Generator>")
    assert [a.states[q] for q in range(a.n_states)] == ["2", "3", "4", "5", "9"]
    assert a.marked.tolist() == [False, True, True, False, True]
    assert list(a.transitions()) == [("2", "a", "9"), ("9", "a", "3")]


def test_an_unnamed_state_makes_way_for_a_name() -> None:
    a = plain('<Generator> <States> 1 "1" </States> <T> 1 a "1" </T> <I> 1 </I> </Generator>')
    assert [a.states[q] for q in range(2)] == ["#1", "1"]


def test_choices_and_several_starts_make_an_extended_automaton() -> None:
    a = read(SMALL.replace("q b p", "q b p p a p").replace("<InitStates> p", "<InitStates> p q"))
    assert isinstance(a, ExtendedAutomaton)
    assert (a.initial, len(a.edges)) == ((True, True), 3)


def test_the_older_form_lists_events_behind_the_generator() -> None:
    behind = "<EventAttributes> <Controllable> a </Controllable> </EventAttributes> <Observable> b </Observable>"
    a = read(f"<cGenerator>\n{SMALL}\n{behind}\n</cGenerator>")
    assert tuple(a.alphabet) == (Event("a", True, False), Event("b", False))
    counted = SMALL.replace("p q </States>", "2 </States>").replace(" p", " 1").replace(" q", " 2")
    assert plain(f"<cGenerator> {counted} </cGenerator>").n_states == 2


@pytest.mark.parametrize("quote", ["", '"'])
def test_numbers_are_looked_up_as_other_words_are(quote: str) -> None:
    for seed in range(300):
        rng = Random(seed)
        listed = [f"{quote}{k}{quote}" for k in range(2, 8)]
        states = "<Consecutive> 2 7 </Consecutive>" if not quote else " ".join(listed)
        words = [*listed, *listed, *rng.sample(['"02"', "02", '"9"', "9", "1", '"2""3"', '"', '""', "²", "2_3"], 1)]
        rows = [f"{rng.choice(words)} e {rng.choice(words)}" for _ in range(4)]
        text = f"<Generator> <Alphabet> e </Alphabet> <States> {states} </States> <T> {' '.join(rows)} </T>"
        results = []
        for version in (text, text.replace("</T>", "<Note/> </T>")):
            try:
                results.append(said(read(f"{version} <I> {listed[0]} </I> </Generator>")))
            except ModelError:
                results.append(("refused",))
        assert results[0] == results[1], rows


def test_names_of_events_lose_white_space_and_commas() -> None:
    assert read(SMALL.replace("a b <", '"a,a" b <').replace(" a q", ' "a,a" q')).alphabet.names == ("a_a", "b")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_encodings(encoding: str) -> None:
    text = SMALL.replace("p", '"größe"')
    assert said(read(text.encode(encoding))) == said(read(text))


def test_words_are_read_alike_at_a_stroke_and_one_by_one() -> None:
    for seed in range(200):
        rng = Random(seed)
        words = ["p", "q", '"p"', "'q'", "1", "2", "a", '"a"', "b", "&amp;", '"&amp;"', "true", "+C+", "% x\n", "0x1"]
        listed = [rng.choice(words) for _ in range(rng.choice((3, 6)))]
        if rng.random() < 0.6:
            listed = [rng.choice(['"p"', "q", "1"]), rng.choice(["a", '"b"']), rng.choice(["p", "2"])] * 2
        body = " ".join(listed)
        text = SMALL.replace(" p a q  q b p ", f" {body} ").replace("a b <", 'a b "&amp;" true <')
        slow = text.replace("</TransRel>", "<Note/> </TransRel>") if len(listed) % 3 == 0 else text
        results = []
        for version in (text, slow):
            try:
                results.append(said(read(version)))
            except ModelError:
                results.append(("refused",))
        assert results[0] == results[1], body


# -- what is refused -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no section <Generator>"),
        ("<EventSet> a b </EventSet>", "no section <Generator>"),
        (SMALL[:-13], "the file ends within a section"),
        (SMALL.replace("</States>", "</Stat>"), "</Stat> does not end <States>"),
        (SMALL.replace("q b p", "q b r"), r"file.gen:1:87: unknown state 'r'"),
        (SMALL.replace("q b p", "q c p"), "unknown event 'c'"),
        (SMALL.replace("q b p", "q b 3"), "unknown state '3'"),
        (SMALL.replace("q b p", "q b"), "a state is expected here, not the end 'TransRel'"),
        (SMALL.replace("q b p", "q"), "an event is expected here"),
        (SMALL.replace("p q <", "p p <"), "state p is listed twice"),
        (SMALL.replace("p q <", "p#1 q#1 <"), "state q is listed twice"),
        (SMALL.replace("p q <", "p#x q <"), "an index is expected after the #"),
        (SMALL.replace("> p </Init", "> </Init"), "no initial state"),
        (SMALL.replace("<States>", "<States> <Consecutive> 5 2 </Consecutive>"), "no range"),
        (SMALL.replace("<States>", "<States> <Consecutive> 1 1000000000 </Consecutive>"), "at most 1,000,000"),
        (SMALL.replace("<States>", "<States> <Consecutive> 1 9 </Consecutive> 3"), "state 3 is listed twice"),
        (SMALL.replace("> q </Marked", "> <Consecutive> 1 9999999 </Consecutive> </Marked"), "more than the states"),
        (SMALL.replace("</Generator>", "<Clocks> c </Clocks> </Generator>"), "<Clocks>: clocks; a timed generator"),
        (SMALL.replace("a q", "a q <Timing> <Guard> c GT 5 </Guard> </Timing>"), "<Timing>: a guard"),
        (SMALL.replace("p q <", "p <Invariant> c LT 5 </Invariant> q <"), "<Invariant>: an invariant"),
        (SMALL.replace("p q <", "p <Colors> red </Colors> q <"), "<Colors>: colours"),
        (SMALL.replace("</Generator>", "<RabinAcceptance> x </RabinAcceptance> </Generator>"), "infinite strings"),
        (SMALL.replace("<States>", "junk <States>"), "a section is expected here, not the string 'junk'"),
        (SMALL.replace("<TransRel> p a q  q b p </TransRel>", ""), "no section <TransRel>"),
        (SMALL.replace("<TransRel>", "<T> </T> <States> r </States> <TransRel>"), "behind the transitions"),
        (SMALL.replace("a b <", "ε b <").replace("p a", "p ε"), "that is the empty trace"),
        (SMALL.replace("a b <", 'a b "c d" c_d <'), "duplicate event 'c_d'"),
        ("<Generator> <X>" + "<Y>" * 2000, "more than 500 sections"),
        (SMALL.replace("p q <", '"p q <'), "no word of libFAUDES begins with"),
        (XML.replace('x2="2"', 'x2="5"'), "file.gen:13:1: x2='5': there is no such state"),
        (XML.replace('event="b"', 'event="c"'), "file.gen:14:1: unknown event 'c'"),
        (XML.replace('event="b"', 'evnt="b"'), "has no attribute 'event'; did you mean 'evnt'"),
        (XML.replace('id="2"', 'id="two"'), "id='two': a number from 1 on"),
        (XML.replace('id="2"', 'id="1"'), "state q is listed twice|state 1"),
        (XML.replace("<StateSet>", '<StateSet><Consecutive from="3" to="4000000000"/>'), "no range of at most"),
        (XML.replace("<Marked/>", "<Invariant>c LT 3</Invariant>"), "<Invariant>: an invariant"),
        (XML[:-14], "the file ends within a section"),
    ],
)
def test_a_bad_file_is_refused_with_place_and_sentence(text: str, what: str) -> None:
    with pytest.raises(ModelError, match=what):
        read(text)


@FORMS
def test_guards_are_refused(form: ModuleType) -> None:
    with pytest.raises(InputError, match="guard"):
        form.dumps(ExtendedAutomaton.from_edges("A", [("p", "a", "p", "n < 3")], initial="p"))


def test_an_empty_section_of_what_is_refused_says_nothing() -> None:
    text = SMALL.replace("</Generator>", "<Clocks/> </Generator>")
    assert said(read(text)) == said(read(SMALL))


PIECES = [
    *("<Generator>", "</Generator>", "<States>", "</States>", "<TransRel>", "</TransRel>", "<I>", "</I>", "<Alphabet>"),
    *("</Alphabet>", "<Consecutive>", "</Consecutive>", "1", "5", "p", '"q"', "a", "+C+", "0x5", "%", "\n"),
    *(
        "<StateSet>",
        '<State id="1">',
        "</StateSet>",
        '<Event name="a"/>',
        "<cGenerator>",
        "</cGenerator>",
        "true",
        "'",
        "¹",
    ),
]


@given(st.binary(max_size=60) | st.lists(st.sampled_from(PIECES), max_size=40).map(lambda p: " ".join(p).encode()))
def test_no_file_does_harm(data: bytes) -> None:
    for form in (faudes, faudes_xml):
        with suppress(InputError):
            form.loads(data, "fuzzed.gen")


@given(
    st.sampled_from([SMALL, XML]),
    st.integers(0, 900),
    st.binary(max_size=4) | st.sampled_from(PIECES).map(str.encode),
    st.integers(0, 9),
)
def test_no_changed_file_does_harm(text: str, place: int, piece: bytes, dropped: int) -> None:
    data = text.encode()
    with suppress(InputError):
        faudes.loads(data[:place] + piece + data[place + dropped :], "fuzzed.gen")


def test_tokens_of_a_large_file_are_found_in_linear_time() -> None:
    for piece in ("<!--", "%", "<A ", '"', "&", "x<", "<!-- -->", "+a+", "%\n", "'", "<![CDATA["):
        hostile = piece * 100_000
        tokens = Tokens(hostile, "big.gen")
        with suppress(ModelError):
            while tokens.next().kind != "nothing":
                pass
