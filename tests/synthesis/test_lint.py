"""What looks wrong is said, once each; what is right is not complained of."""

import json
from itertools import permutations
from random import Random

import numpy as np
from click.testing import CliRunner

import thenar
from thenar import Automaton, ExtendedAutomaton, ExtendedProblem, Problem, Variable
from thenar.cli.lint import lint as lint_command
from thenar.explicit.exploration import ticker
from thenar.symbolic.encode import Encoding
from thenar.symbolic.synthesis import reach
from thenar.synthesis.lint import _listed
from thenar.testing.random_models import random_problem


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
        "event 'go': never happens: automaton 'S' has it in its alphabet, but no transition with it",
        "event 'come': never happens: the plants can do it in no state reached",
        "event 'stuck': never happens: automaton 'P' has it in its alphabet, but no transition with it",
        "event 'nobody': no automaton has it",
    ]


def test_the_states_never_reached_are_those_that_no_reachable_state_has() -> None:
    found = 0
    for seed in range(300):
        problem = random_problem(Random(seed))
        if any(a.is_empty for a in problem.automata):
            continue
        whole = thenar.sync(*problem.automata)
        local = list(zip(*(whole.states[q].split("|") for q in range(whole.n_states)), strict=True))
        for k, a in enumerate(problem.automata):
            never = [a.states[q] for q in range(a.n_states) if a.states[q] not in local[k]]
            wrong = [m for m in thenar.lint(problem) if m.where == f"automaton {a.name!r}" and "never" in m.what]
            assert [m.what for m in wrong] == ([f"never reaches its state {_listed(never)}"] if never else []), seed
            found += bool(never)
    assert found > 100


def test_parts_that_no_state_constrains_take_all_their_values() -> None:
    """Diagrams leave out levels that make no difference: between two others, above, and below."""
    for names in permutations("XYZ"):
        free = [Automaton.from_transitions([f"0 -{n}-> 1 -{n}-> 0"], initial="0", marked=["0"], name=n) for n in names]
        idle = Automaton.from_transitions([], initial="0", marked=["0"], states=["0", "1"], name="IDLE")
        wrong = [m for m in said(Problem([free[0], idle, *free[1:]])) if "never reaches" in m]
        assert wrong == ["automaton 'IDLE': never reaches its state '1'"]


def test_a_long_automaton_takes_no_longer_than_its_states() -> None:
    n = 100_000
    chain = Automaton.from_arrays(
        thenar.Alphabet(["a"]),
        np.minimum(np.arange(n + 1), n - 1),
        np.zeros(n - 1, np.int64),
        np.arange(1, n),
        marked=np.arange(n) == n - 1,
    )
    # a set of 100 000 values for each of 100 000 states would take 10 GB
    assert thenar.lint(Problem(chain), limits=thenar.Limits(bytes=1 << 26)) == []


def test_an_automaton_without_states() -> None:
    nothing = Automaton.empty(thenar.Alphabet(["a"]), "NOTHING")
    assert said(Problem(nothing)) == ["automaton 'NOTHING': has no states"]
    plant = Automaton.from_transitions(["0 -a-> 0"], initial="0", marked=["0"], name="P")
    assert said(Problem(plant, nothing)) == ["automaton 'NOTHING': has no states"]
    encoding = Encoding(Problem(plant, nothing), ticker())
    assert not reach(encoding)


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


def test_an_event_that_the_specifications_forbid_together() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1 -b-> 0", "1 -c-> 0"], initial="0", marked=["0"], name="P")
    first = Automaton.from_transitions(["0 -a-> 1 -b-> 0", "0 -c-> 0"], initial="0", marked=["0"], name="S")
    assert said(Problem(plant, first)) == ["event 'c': never happens: the specifications forbid it wherever it could"]


def test_an_automaton_that_marks_nothing() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", name="P")
    assert said(Problem(plant)) == [
        "problem: no marked state is ever reached",
        "automaton 'P': marks none of its states, and so no state of the whole is marked",
    ]


def test_a_specification_that_is_not_trim() -> None:
    plant = Automaton.from_transitions(["0 -a,b-> 0"], initial="0", marked=["0"], name="P")
    spec = Automaton.from_transitions(["0 -a-> dead -b-> end"], initial="0", marked=["0"], name="S")
    wrong = ["automaton 'S': is not trim: from its state 'dead', 'end' it reaches no marked state of its own"]
    assert said(Problem(plant, spec)) == wrong
    assert said(ExtendedProblem.of(Problem(plant, spec))) == wrong


def test_a_plant_may_have_states_that_it_never_recovers_from() -> None:
    plant = Automaton.from_transitions(["0 -work-> 0 -break-> wreck"], initial="0", marked=["0"], name="P")
    assert said(Problem(plant)) == []


def test_a_specification_of_an_event_that_no_plant_has() -> None:
    plant = Automaton.from_transitions(["0 -start-> 1 -finish-> 0"], initial="0", marked=["0"], name="P")
    spec = Automaton.from_transitions(["0 -start-> 1 -finsh-> 0"], initial="0", marked=["0"], name="S")
    assert said(Problem(plant, spec)) == [
        "automaton 'S': speaks of event 'finsh', which no plant has; did you mean 'finish'?"
    ]


def test_alphabets_that_never_meet() -> None:
    plants = [
        Automaton.from_transitions([f"0 -start_{k}-> 1 -finish_{k}-> 0"], initial="0", marked=["0"], name=f"P{k}")
        for k in (1, 2)
    ]
    spec = Automaton.from_transitions(["0 -begin-> 1 -start_1-> 0"], initial="0", marked=["0"], name="S1")
    alone = Automaton.from_transitions(["0 -shift-> 0"], initial="0", marked=["0"], name="S2")
    assert said(Problem(plants, [spec, alone])) == [
        "automaton 'P2': shares no event with another automaton",
        "automaton 'S1': speaks of event 'begin', which no plant has",
        "automaton 'S2': shares no event with a plant",
    ]


def test_the_command_line_also_looks_at_sampled_devices() -> None:
    def run(*words: str) -> tuple[int, str]:
        done = CliRunner().invoke(lint_command, words)
        return done.exit_code, done.output

    assert run("small_factory") == (0, "nothing looks wrong\n")
    waits = "no marked state is reached by who waits only where no command is enabled"
    found = f"sampled device: nonblocking under control: no after ε: {waits}\n"
    assert run("small_factory", "--sampled") == (1, found)
    assert json.loads(run("glr", "--sampled", "--json")[1])[1]["where"] == "sampled device"
