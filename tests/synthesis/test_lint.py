"""What looks wrong is said, once each; what is right is not complained of."""

import thenar
from thenar import Automaton, ExtendedAutomaton, ExtendedProblem, Problem, Variable


def said(problem: Problem | ExtendedProblem) -> list[str]:
    return [str(mistake) for mistake in thenar.lint(problem)]


def test_the_library_is_clean() -> None:
    for name in ("glr", "glr(extended)", "glr(fingers=3)", "agv", "dining(5)", "small_factory(3)", "transfer_line(50)"):
        assert said(thenar.library.model(name)) == []


def test_states_and_events_that_never_are() -> None:
    plant = Automaton.from_transitions(
        ["a -go-> b", "lost -come-> a"], initial="a", marked=["lost"], alphabet=["stuck"], name="P"
    )
    spec = Automaton.from_transitions([], initial="q", marked=["q"], alphabet=["go"], name="S")
    problem = Problem(plant, spec, alphabet=thenar.Alphabet(["go", "come", "stuck", "nobody"]), name="odd")
    assert said(problem) == [
        "problem 'odd': no marked state is ever reached",
        "automaton 'P': never reaches its state 'b', 'lost'",
        "event 'go': never happens: the specifications forbid it wherever it could",
        "event 'come': never happens: the plants can do it in no state reached",
        "event 'stuck': never happens: the plants can do it in no state reached",
        "event 'nobody': no automaton has it",
    ]


def test_updates_out_of_range_with_an_example() -> None:
    belt = ExtendedAutomaton.from_edges(
        "BELT",
        [
            ("on", "put", "on", "parts < 2", {"parts": "parts + 2"}),
            ("on", "take", "on", "parts > 0", {"parts": "parts - 1"}),
        ],
        initial="on",
        marked=["on"],
    )
    problem = ExtendedProblem([belt], variables=[Variable("parts", range(3))])
    assert said(problem) == [
        "automaton 'BELT': on -put-> on: parts := parts + 2 leaves 0..2, for example where parts == 1; "
        "there the transition is impossible"
    ]


def test_no_initial_state_at_all() -> None:
    cup = ExtendedAutomaton.from_edges("CUP", [("up", "fill", "up")], initial="up", marked=["up"])
    problem = ExtendedProblem([cup], variables=[Variable("n", range(3))], initial="n == 2")
    assert said(problem) == ["problem: no state satisfies the initial conditions of all parts"]
