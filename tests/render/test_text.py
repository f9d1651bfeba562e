import numpy as np
from hypothesis import given

from thenar.library.glr import finger, spec1
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.render import table
from thenar.render.measure import cells
from thenar.testing.strategies import automata


def test_an_automaton_is_a_row_for_each_state() -> None:
    G = Automaton.from_transitions(
        ["idle -start-> busy -done,fail-> idle", "busy -stop-> off"],
        initial="idle", marked=["idle"], uncontrollable=["done", "fail"], name="M",
    )  # fmt: skip
    assert table(G).splitlines() == [
        "Automaton 'M': 3 states (1 marked), 4 transitions, 4 events",
        "",
        "     state  marked  transitions",
        "> 0  idle   yes     start -> busy",
        "  1  busy   -       done!, fail! -> idle; stop -> off",
        "  2  off    -       -",
    ]


def test_a_supervisor_says_what_it_enables_and_disables() -> None:
    G = Automaton.from_transitions(["a -go-> b"], initial="a", alphabet=["stop"], name="S")
    S = Supervisor(G, np.array([0, 0, 1]), np.array([G.alphabet.index("stop")], np.int32))
    assert table(S).splitlines()[2:] == [
        "     state  enabled  disabled",
        "> 0  a      go       -",
        "  1  b      -        stop",
    ]


def test_a_problem_lists_its_components_with_their_sizes() -> None:
    lines = table(Problem([finger(1)], [spec1()], name="half")).splitlines()
    assert lines[0] == "Problem 'half': 1 plant, 1 spec, 23 events (4 uncontrollable)"
    assert [line.split() for line in lines[2:]] == [
        ["automaton", "role", "states", "marked", "transitions", "events"],
        ["FINGER1", "plant", "18", "2", "33", "20"],
        ["SPEC1", "spec", "5", "5", "12", "6"],
    ]


def test_a_check_gives_its_verdict_and_witness() -> None:
    assert table(Check("controllable", False, Trace("lift slip"), "SPEC forbids slip")).splitlines() == [
        "property  controllable",
        "holds     no",
        "witness   lift, slip",
        "reason    SPEC forbids slip",
    ]
    assert table(Check("nonblocking", True)).splitlines()[-1] == "holds     yes"


@given(automata(max_states=12))
def test_every_state_and_transition_is_listed(G: Automaton) -> None:
    lines = table(G).splitlines()[3:]
    assert len(lines) == G.n_states
    for q, line in enumerate(lines):
        assert all(f"{event.name}{'' if event.controllable else '!'}" in line for event in G.enabled(q))
        assert line.startswith(">") == (q == G.initial)


def test_a_long_table_ends_with_the_number_of_rows_left_out() -> None:
    G = Automaton.from_transitions([f"{k} -on-> {k + 1}" for k in range(2808)], initial="0")
    lines = table(G, rows=10).splitlines()
    assert len(lines) == 3 + 10 + 1
    assert lines[-1] == "… 2,799 more"
    assert len(table(G).splitlines()) < 50


def test_columns_align_for_wide_characters_and_no_name_steers_the_terminal() -> None:
    G = Automaton.from_transitions(
        [("持ち上げる", "上", "\x1b[2Jgone\n\r"), ("\x1b[2Jgone\n\r", "下", "x" * 40)], initial="持ち上げる"
    )
    lines = table(G).splitlines()
    assert len(lines) == 3 + 3
    assert "\\x1b[2Jgone\\n\\r" in lines[4]
    assert all(c.isprintable() for line in lines for c in line)
    assert len({cells(line[: line.index(" -  ")]) for line in lines[3:]}) == 1
    assert lines[4].endswith("下 -> 2"), "a long name is replaced by the state's number"


def test_anything_else_is_its_repr() -> None:
    assert table([1, 2]) == "[1, 2]"
    assert table(Automaton.empty(finger(1).alphabet)) == "Automaton: 0 states (0 marked), 0 transitions, 20 events"
