"""DESUMA's .fsm: round trips, the answers of others' files, and damaged files."""

from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.io.foreign.drawn import (
    MODELS,
    assert_read_or_refused,
    damaged,
    entries,
    facts,
    needs,
    odd_automaton,
    text,
    with_names,
)

from thenar.errors import InputError, ModelError
from thenar.explicit.control import supcon
from thenar.explicit.language import is_isomorphic, is_sublanguage
from thenar.explicit.nondeterminism import determinise
from thenar.explicit.products import meet, sync
from thenar.io.foreign import desuma
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

M = b"2\n\nidle\t1\t1\nstart\tbusy\tc\to\n\nbusy\t0\t1\ndone\tidle\tuc\tuo\n\nEVENTS\nreset\tc\to\n"


def read(content: str) -> Automaton | ExtendedAutomaton:
    return desuma.loads(content.encode(), "M.fsm")


def refused(content: str) -> str:
    with pytest.raises(ModelError) as error:
        read(content)
    return str(error.value)


def test_flags_and_events_that_no_transition_carries() -> None:
    m = desuma.loads(M, "folder/M.fsm")
    assert list(m.alphabet) == [Event("start"), Event("done", False, False), Event("reset")]
    assert (m.name, facts(m)[1]) == ("M", ("idle", "busy"))


def test_what_writers_differ_in_is_read_alike() -> None:
    same = [
        M.decode().replace("\n", "\r\n"),
        M.decode().replace("\t", "   "),
        M.decode().replace("\n\n", "\n"),
        "\ufeff\n" + M.decode() + "\n\n",
        M.decode().replace("start\tbusy\tc\to", "start\tbusy").replace("uc\tuo", "uo\tuc"),
        M.decode().replace("start\tbusy\tc\to", "start\tbusy\tc\t0"),
    ]
    assert {repr(facts(read(content))) for content in same} == {repr(facts(read(M.decode())))}


def test_names_with_spaces_between_tabs() -> None:
    a = read("1\n\nat work\t1\t1\npush button\tat work\tuc\n")
    assert (a.states[0], a.alphabet[0]) == ("at work", Event("push_button", False))


def test_no_states_is_the_empty_automaton() -> None:
    assert read("0\n\n").alphabet.names == ()
    assert text(desuma.dumps(Automaton.empty(read(M.decode()).alphabet))).startswith(b"0\n\nEVENTS\nstart\tc\to\n")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "M.fsm:2: the first line is the number of states, not ''"),
        ("two\n", "M.fsm:1: the first line is the number of states, not 'two'"),
        ("1000000000\n", "M.fsm:1: 1000000000 states in a file of 2 lines"),
        ("2\n\na\t1\t0\n", "M.fsm:4: 2 states are announced, and 1 follow"),
        ("1\n\na\t1\t0\n\nb\t1\t0\n", "M.fsm:5: 1 states are announced, and more follows; the number is in the first"),
        ("1\n\na\t1\t2\ne\ta\n\n", "M.fsm:3: state 'a' announces 2 transitions, and 1 follow"),
        ("1\n\na\t1\t99999999\n", "M.fsm:3: state 'a' announces 99999999 transitions, and 0 follow"),
        ("1\n\na\t2\t0\n", "M.fsm:3: here stands a state: name, 0 or 1, number of its transitions; not 'a"),
        ("1\n\na\t1\t1\ne\tb\tc\to\n", "M.fsm:4: unknown state 'b'"),
        ("1\n\na\t1\t1\ne\ta\tc\to\t0.5\n", "M.fsm:4: event 'e': '0.5' is a probability"),
        ("1\n\na\t1\t1\ne\ta\tx\n", "M.fsm:4: event 'e': 'x' is no flag: c, uc, o, uo"),
        ("1\n\na\t1\t2\ne\ta\tc\ne\ta\tuc\n", "M.fsm:5: event 'e' is 'uc' here and 'c' before; give it one meaning"),
        ("2\n\na\t1\t0\na\t1\t0\n", "M.fsm:4: two states are called 'a'"),
        ("1\n\na\t1\t1\nEMPTY_TRACE\ta\n", "M.fsm:4: EMPTY_TRACE is no event"),
        ("1\n\na\t1\t1\nε\ta\n", "M.fsm:4: event name 'ε'"),
        ("1\n\na\t1\t2\ne f\ta\ne_f\ta\n", "M.fsm:5: two events are called 'e_f'"),
    ],
)
def test_mistakes_name_the_line(content: str, message: str) -> None:
    assert refused(content).startswith(message)


def test_only_twenty_mistakes_are_listed() -> None:
    lines = "".join(f"e\tb{k}\n" for k in range(100_000))
    assert refused(f"1\n\na\t1\t100000\n{lines}").count("\n") == 19


def test_dumps_then_loads_is_the_identity_but_for_the_first_state() -> None:
    rng = Random(1)
    for _ in range(1000):
        original = odd_automaton(rng, entries=False)
        written = desuma.dumps(original)
        again = with_names(desuma.loads(text(written), "file.fsm"), written.names)
        first = entries(original)[0]
        names = [original.states[q] for q in range(len(original.marked))]
        said = list(facts(original))
        said[1] = (names[first], *names[:first], *names[first + 1 :])
        assert facts(again) == tuple(said)


def test_same_input_same_bytes() -> None:
    assert text(desuma.dumps(odd_automaton(Random(3), entries=False))) == text(
        desuma.dumps(odd_automaton(Random(3), entries=False))
    )


def test_several_initial_states_and_guards_are_refused() -> None:
    two = ExtendedAutomaton.from_edges("A", ["p -a-> q"], initial=["p", "q"])
    with pytest.raises(InputError, match=r"one initial state, not 'p', 'q'; determinise it first"):
        desuma.dumps(two)
    with pytest.raises(InputError, match=r"edge 1 .* no guards and updates"):
        desuma.dumps(ExtendedAutomaton.from_edges("A", [("p", "a", "q", "n < 2")], initial="p"))


@settings(max_examples=400, deadline=None)
@given(st.one_of(damaged([M], [b"\t", b"\n", b"99", b"uc", b"EVENTS", b"\xff", b"\x00"]), st.binary(max_size=60)))
def test_damaged_files_are_read_or_refused(data: bytes) -> None:
    assert_read_or_refused(desuma.loads, data)


# -- other people's files


def model(name: str) -> Automaton:
    path = MODELS / "mdesops" / "models" / f"{name}.fsm"
    if not path.exists():
        pytest.skip(f"no {path}")
    automaton = desuma.loads(path.read_bytes(), str(path))
    assert isinstance(automaton, Automaton)
    return automaton


@needs("mdesops")
def test_every_file_loads() -> None:
    files = sorted((MODELS / "mdesops").rglob("*.fsm"))
    assert files
    for file in files:
        _agrees_with_its_lines(file, desuma.loads(file.read_bytes(), str(file)))


def _agrees_with_its_lines(file: Path, a: Automaton | ExtendedAutomaton) -> None:
    """Count states, transitions, events and flags in another way."""
    rows = [line.split("\t") for line in file.read_text().splitlines()[1:] if line.strip()]
    states = [row for row in rows if len(row) == 3]
    moves = [row for row in rows if len(row) == 4]
    _, names, edges, marked, _ = facts(a)
    assert names == tuple(row[0] for row in states)
    assert marked == {row[0] for row in states if row[1] == "1"}
    assert isinstance(edges, set)
    assert len(edges) == len(moves) == sum(int(row[2]) for row in states)
    assert {e.name for e in a.alphabet} == {row[0] for row in moves}
    assert {e.name for e in a.alphabet if not e.controllable} == {row[0] for row in moves if row[2] == "uc"}
    assert {e.name for e in a.alphabet if not e.observable} == {row[0] for row in moves if row[3] == "uo"}


# Answers of MDESops' own tests and of Cassandras and Lafortune, Introduction to Discrete Event Systems, 2nd edition;
# a test needs all files that it names, and some folders have a part of them.


@needs("mdesops")
def test_nothing_of_figure_3_9_is_controllable() -> None:
    # example 3.11 and MDESops, test_supervisor.py
    supremal = supcon(model("sc_tests/book_ex_3_11_G"), model("sc_tests/book_ex_3_11_H"))
    assert supremal.is_empty
    assert model("sc_tests/book_ex_3_11_C").is_empty


@needs("mdesops")
def test_example_3_11_is_of_figure_3_9() -> None:
    assert is_isomorphic(model("sc_tests/book_ex_3_11_H"), model("textbook/fig_3-9_H"))


@needs("mdesops")
def test_product_of_figures_2_1_and_2_2() -> None:
    product = meet(model("textbook/fig_2-1"), model("textbook/fig_2-2"))
    # MDESops, test_composition.py: two states, (x, 0) and (x, 1), the second marked
    assert [product.states[q] for q in range(product.n_states)] == ["x|0", "x|1"]
    assert product.marked.tolist() == [False, True]


@needs("mdesops")
def test_specification_of_problem_3_28_is_within_the_plant() -> None:
    plant = sync(model("textbook/prob_3-28_a"), model("textbook/prob_3-28_b"))
    assert is_sublanguage(model("textbook/prob_3-28_H"), plant)


@needs("mdesops")
def test_observer_of_figure_2_25() -> None:
    # {0}, {1, 2, 3} and {0, 1, 2, 3}; the event epsilon is not seen
    nondeterministic = desuma.loads(
        (MODELS / "mdesops/models/textbook/fig_2-25_nd.fsm").read_bytes(), "fig_2-25_nd.fsm"
    )
    assert isinstance(nondeterministic, ExtendedAutomaton)
    observer = determinise(nondeterministic, silent=["epsilon"])
    assert (observer.n_states, observer.n_transitions) == (3, 5)
