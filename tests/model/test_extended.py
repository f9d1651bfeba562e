"""Extended automata and problems: frozen, strict at the door, every mistake named."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable
from dataclasses import FrozenInstanceError
from random import Random
from typing import Any

import numpy as np
import pytest

import thenar
from thenar.library.classics import small_factory
from thenar.model.expressions import At, Name, parse
from thenar.model.extended import (
    Condition,
    Edge,
    ExtendedAutomaton,
    ExtendedProblem,
    Variable,
    disables,
    invariant,
    needs,
)
from thenar.testing.random_models import random_extended_problem

N, LAMP = Variable("n", range(4)), Variable("lamp", ["red", "green"])


def cup(*edges: Any, initial: Iterable[str] = "up", **options: Any) -> ExtendedAutomaton:
    return ExtendedAutomaton.from_edges("CUP", edges, initial=initial, **options)


def mistakes(build: Callable[[], object]) -> list[str]:
    with pytest.raises(thenar.ModelError) as caught:
        build()
    return [str(m) for m in caught.value.mistakes]


# -- variables -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("n", []), "variable 'n': no value to take"),
        (("n", [1, 1]), "variable 'n': value 1 is listed twice"),
        (("n", [0, True]), "variable 'n': its values must be all whole numbers, all truths or all names"),
        (("n", [0.5]), "variable 'n': its values must be all whole numbers, all truths or all names"),
        (("n", "abc"), "variable 'n': its values are a list, not 'abc'"),
        (("n", range(10**9)), "variable 'n': more than 1,000,000 values"),
        (("n", [2**64]), "variable 'n': its values do not fit into 64 bits"),
        (("n", [1, 2], 3), "variable 'n': its initial value 3 is none of its values"),
        (("n", [0, 1], True), "variable 'n': its initial value True is none of its values"),
        (("n", [0, 1], []), "variable 'n': no initial value"),
        (("n", [0, 1], [0, 0]), "variable 'n': an initial value is listed twice"),
        (
            ("n", ["red"], None, "rde"),
            "variable 'n': its marked value 'rde' is none of its values; did you mean 'red'?",
        ),
        (("in", [0]), "variable 'in': a name is made of letters"),
        (("a b", [0]), "variable 'a b': a name is made of letters"),
        (("true", [0]), "variable 'true': a name is made of letters"),
    ],
)
def test_a_variable_is_checked(arguments: tuple[Any, ...], complaint: str) -> None:
    (found,) = mistakes(lambda: Variable(*arguments))
    assert found.startswith(complaint)


def test_a_variable_names_all_of_its_mistakes() -> None:
    assert len(mistakes(lambda: Variable("in", []))) == 2
    assert len(mistakes(lambda: Variable("n", [1], [2], [3, 4]))) == 3


def test_numpys_values_become_pythons_own() -> None:
    v = Variable("n", np.arange(3), initial=np.int64(1))  # type: ignore[arg-type]
    assert [type(x) for x in (*v.values, *v.initial)] == [int] * 4


def test_one_value_or_several_may_come_first() -> None:
    assert Variable("n", range(3), initial=2).initial == (2,)
    assert Variable("n", range(3), initial=[2, 1]).initial == (2, 1)
    assert Variable("lamp", ["red", "green"], initial="green", marked="red").marked == ("red",)


# -- automata ------------------------------------------------------------------------------------------------


def test_edges_are_written_as_tuples_or_arrows() -> None:
    a = cup(
        "up -tip-> down -lift-> up", ("up", "fill", "up", "n < 3", {"n": "n + 1"}), ("up", "see", "up", True, {"n": 0})
    )
    assert (a.states, a.alphabet.names) == (("up", "down"), ("tip", "lift", "fill", "see"))
    assert a.edges[2] == Edge(0, 2, 0, parse("n < 3"), (("n", parse("n + 1")),))
    assert cup(("up", "e", "up", False)).edges[0].guard == parse("false")
    assert cup(("up", "e", "up", "", {"n": "1"})).edges[0].guard == parse("true")


def test_several_states_may_be_initial() -> None:
    assert cup("up -tip-> down", initial=["up", "down"]).initial == (True, True)


def test_an_author_hears_of_all_mistakes_at_once() -> None:
    found = mistakes(
        lambda: cup(
            ("up", "e"),
            ("up", "e", "up", "n <", {"n": "1"}),
            "up -> x",
            "up -tip-> down",
            ("up", "e", "up", "n > 0", 3),
            marked=["dwn"],
            uncontrollable=["tipp"],
        )
    )
    assert [m.split(": ")[0] for m in found] == [
        "automaton 'CUP', edge 1",
        "automaton 'CUP', edge 2 (up -e-> up)",
        "automaton 'CUP', edge 3",
        "automaton 'CUP', edge 5 (up -e-> up)",
        "automaton 'CUP', marked",
        "automaton 'CUP', uncontrollable",
    ]
    assert found[4].endswith("unknown state 'dwn'; did you mean 'down'?")
    assert found[5].endswith("unknown event 'tipp'; did you mean 'tip'?")


def test_known_events_and_states_bind() -> None:
    sigma = thenar.Alphabet(["tip", "fill"])
    found = mistakes(lambda: cup("up -tpi-> dwon", states=["up", "down"], events=sigma, alphabet=["fil"]))
    assert [m.split(": ")[1] for m in found] == [
        "unknown event 'fil'; did you mean 'fill'?",
        "unknown state 'dwon'; did you mean 'down'?",
        "unknown event 'tpi'; did you mean 'tip'?",
    ]
    assert mistakes(lambda: cup("up -tip-> up", events=sigma, uncontrollable=["tip"])) == [
        "automaton 'CUP', uncontrollable: event 'tip' is controllable in the given events"
    ]
    assert cup("up -fill-> up", "up -tip-> up", events=sigma).alphabet == sigma


def test_a_text_where_a_list_belongs_is_refused() -> None:
    for what in ("marked", "uncontrollable"):
        with pytest.raises(thenar.InputError, match=f"{what} is a list, not the text 'up'"):
            cup("up -tip-> down", **{what: "up"})


def test_what_a_program_builds_is_checked_too() -> None:
    sigma = thenar.Alphabet(["e"])
    assert mistakes(lambda: ExtendedAutomaton("A", sigma, ("p", "p"), (False,), (True, True), (Edge(0, 1, 2),))) == [
        "automaton 'A': two states are called 'p'",
        "automaton 'A': initial has 1 entry for 2 states",
        "automaton 'A': no initial state; write which state the automaton starts in",
        "automaton 'A': edge 1 is of a state or an event that does not exist",
    ]
    twice = Edge(0, 0, 0, updates=(("n", parse(1)), ("n", parse(2))))
    assert mistakes(lambda: ExtendedAutomaton("A", sigma, ("p",), (True,), (True,), (twice,))) == [
        "automaton 'A': edge 1 (p -e-> p): updates 'n' twice"
    ]


# -- problems ------------------------------------------------------------------------------------------------


def test_names_are_found_out() -> None:
    problem = ExtendedProblem(
        cup(("up", "fill", "up", "n < 3 and CUP.up")),
        [invariant("lamp == red"), needs("fill", "n > 0")],
        variables=[N, LAMP],
    )
    assert problem.plants[0].edges[0].guard == parse("n < 3 and CUP['up']")
    assert [c.event for c in problem.spec_conditions] == [None, "fill"]
    assert problem.automaton("CUP") is problem.plants[0]
    assert problem.variable("lamp") is LAMP
    with pytest.raises(thenar.UnknownName, match="unknown variable 'lmap'; did you mean 'lamp'"):
        problem.variable("lmap")
    with pytest.raises(thenar.UnknownName, match="unknown automaton 'CPU'; did you mean 'CUP'"):
        problem.automaton("CPU")


def test_every_mistake_of_a_problem_is_named_at_once() -> None:
    found = mistakes(
        lambda: ExtendedProblem(
            [cup(("up", "fill", "up", "n", {"n": "lamp", "m": 1}))],
            [needs("fil", "n > 0"), "n > 0", invariant("lamp", name="bright")],  # type: ignore[list-item]
            variables=[N, LAMP, N, 3],  # type: ignore[list-item]
            initial="n",
            marked="n ==",
            name="cups",
        )
    )
    assert found == [
        "problem 'cups', specs: 'n > 0' is no automaton and no condition; "
        "a condition is made by invariant, needs or disables",
        "problem 'cups': 3 is no variable",
        "problem 'cups': two parts are called 'n'",
        "automaton 'CUP', edge 1 (up -fill-> up): 'n' is a number, but its new value 'lamp' is green or red",
        "automaton 'CUP', edge 1 (up -fill-> up): updates 'm', which is no variable",
        "automaton 'CUP', edge 1 (up -fill-> up): a guard is true or false, but 'n' is a number",
        "condition 'fil needs n > 0': unknown event 'fil'; did you mean 'fill'?",
        "condition 'bright': a condition is true or false, but 'lamp' is green or red",
        "problem 'cups', initial: it is true or false, but 'n' is a number",
        "problem 'cups', marked: expression 'n ==', column 1: not understood; invalid syntax",
    ]


def test_no_plant_is_a_mistake() -> None:
    assert mistakes(lambda: ExtendedProblem([])) == [
        "problem: no plant; a problem needs at least one automaton that says what can happen"
    ]
    assert len(mistakes(lambda: ExtendedProblem([invariant("true")], cup("up -e-> up")))) == 1


def test_names_that_stand_for_two_things_are_refused() -> None:
    variables = [Variable("CUP.up", [0]), Variable("n", ["m", "CUP.up", "free"]), Variable("m", [0])]
    assert mistakes(lambda: ExtendedProblem(cup("up -e-> up"), variables=variables)) == [
        "variable 'CUP.up': it is called like the state 'up' of automaton 'CUP'; rename one of them",
        "variable 'n': its value 'm' is called like a variable; rename one of them",
        "variable 'n': its value 'CUP.up' is called like the state 'up' of automaton 'CUP'; rename one of them",
    ]


def test_a_variable_is_updated_by_one_automaton() -> None:
    other = ExtendedAutomaton.from_edges("JUG", [("q", "pour", "q", "true", {"n": "n - 1"})], initial="q")
    plants = [cup(("up", "fill", "up", "true", {"n": "n + 1"})), other]
    assert mistakes(lambda: ExtendedProblem(plants, variables=[N])) == [
        "variable 'n': updated by automaton 'CUP' and by automaton 'JUG'; let one of them do it"
    ]


def test_an_invariant_of_the_plants_does_not_depend_on_specs() -> None:
    spec = ExtendedAutomaton.from_edges("E", [("q", "tip", "q", "true", {"n": "n + 1"})], initial="q")
    plants: list[Any] = [cup("up -tip-> up"), invariant("n < 3 or E.q", name="low"), needs("tip", "E.q")]
    assert mistakes(lambda: ExtendedProblem(plants, [spec], variables=[N])) == [
        "condition 'low': an invariant of the plants depends on 'n', which specification 'E' updates; "
        "make it one of the specs",
        "condition 'low': an invariant of the plants depends on 'E.q', a state of a specification; "
        "make it one of the specs",
    ]


def test_events_have_one_meaning() -> None:
    other = ExtendedAutomaton.from_edges("JUG", ["q -tip-> q"], initial="q", uncontrollable=["tip"])
    with pytest.raises(thenar.AlphabetClash, match="controllable in 'CUP' and uncontrollable in 'JUG'"):
        ExtendedProblem([cup("up -tip-> up"), other])
    with pytest.raises(thenar.AlphabetClash, match="the problem's alphabet"):
        ExtendedProblem([cup("up -tip-> up")], alphabet=other.alphabet)
    assert mistakes(lambda: ExtendedProblem([cup("up -tip-> up")], alphabet=thenar.Alphabet(["fill"]))) == [
        "problem: event 'tip' is not in the problem's alphabet"
    ]


def test_every_problem_can_be_extended() -> None:
    plain = small_factory()
    problem = ExtendedProblem.of(plain)
    assert (problem.name, problem.alphabet, len(problem.automata)) == (plain.name, plain.alphabet, 3)
    assert ExtendedProblem.of(problem) is problem
    assert problem.plants[0].states == tuple(plain.plants[0].states[q] for q in range(3))
    unnamed = [thenar.Automaton.from_transitions(["0 -a-> 0"], initial="0") for _ in range(2)]
    assert len(ExtendedProblem.of(thenar.Problem(unnamed)).plants) == 2


def test_problems_are_frozen_and_survive_a_pickle() -> None:
    for seed in range(20):
        problem = random_extended_problem(Random(seed))
        again = pickle.loads(pickle.dumps(problem))
        assert repr(again) == repr(problem)
        assert (again.automata, again.variables) == (problem.automata, problem.variables)
        assert (again.plant_conditions, again.spec_conditions) == (problem.plant_conditions, problem.spec_conditions)
        for part, field in ((problem, "plants"), (problem.plants[0], "edges"), (N, "values")):
            with pytest.raises(FrozenInstanceError):
                setattr(part, field, ())


def test_conditions_are_made_of_texts() -> None:
    assert disables("M.busy", "start") == needs("start", "not M.busy")
    assert invariant(Name("b")) == invariant("b") == Condition(Name("b"))
    assert str(invariant(At("M 1", "in use"))) == "'M 1'['in use']"
    with pytest.raises(thenar.InputError, match="for '=' write '=='"):
        invariant("n = 3")
