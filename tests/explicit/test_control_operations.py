"""Infimal controllable superlanguages, relative closure, and the witness of a conflict."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from random import Random
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings

import thenar
from thenar.explicit.relative import is_relatively_closed, sup_relatively_closed
from thenar.explicit.superlanguage import infcon
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.testing import assert_same_languages, assert_same_numbering, control_oracle, oracle, random_problem
from thenar.testing.strategies import problems

quick = settings(max_examples=150, deadline=None)


@pytest.fixture(scope="module")
def libfaudes() -> ModuleType:
    from tests.oracles import libfaudes

    return libfaudes


def all_marked(a: Automaton) -> Automaton:
    return replace(a, marked=np.ones(a.n_states, np.bool_))


# -- the infimal controllable superlanguage ------------------------------------------------------------------


@quick
@given(problems())
def test_infcon_is_the_oracles(problem: Problem) -> None:
    fast, slow = infcon(problem.plants, problem.specs), control_oracle.infcon(problem.plants, problem.specs)
    assert_same_numbering(fast, slow)
    assert [fast.states[q] for q in range(fast.n_states)] == [slow.states[q] for q in range(slow.n_states)]


@quick
@given(problems())
def test_infcon_is_controllable_and_has_the_specification_in_it(problem: Problem) -> None:
    least = infcon(problem.plants, problem.specs)
    assert thenar.is_controllable(least, problem.plants)
    legal, plant = thenar.sync(*problem.automata), thenar.sync(*problem.plants)
    assert thenar.is_sublanguage(all_marked(legal), all_marked(least))
    assert thenar.is_sublanguage(least, plant)


@quick
@given(problems(max_states=3))
def test_no_smaller_controllable_superlanguage_exists(problem: Problem) -> None:
    """Whatever it has, up to length five, is a legal string followed by uncontrollable events."""
    least, legal = infcon(problem.plants, problem.specs), thenar.sync(*problem.automata)
    allowed = {s for s, _ in oracle.language(legal, 5)}
    for string, _ in oracle.language(least, 5):
        inside = max(k for k in range(len(string) + 1) if string[:k] in allowed)
        assert not any(least.alphabet[e].controllable for e in string[inside:])


@quick
@given(problems())
def test_infcon_of_what_is_controllable_is_itself(problem: Problem) -> None:
    least = infcon(problem.plants, problem.specs)
    again = infcon(problem.plants, least)
    assert_same_languages(again, least)
    supervisor = thenar.supcon(problem.plants, problem.specs)
    assert_same_languages(all_marked(infcon(problem.plants, supervisor)), all_marked(supervisor))


def test_infcon_is_what_libfaudess_operations_make_of_one_thousand_problems(libfaudes: ModuleType) -> None:
    for seed in range(1000):
        p = random_problem(Random(seed), max_states=3)
        specs = p.specs or p.plants[:1]
        ours = thenar.minimize(all_marked(infcon(p.plants, specs)))
        assert thenar.is_isomorphic(ours, thenar.minimize(libfaudes.infcon(p.plants, specs))), f"seed {seed}"


def test_infcon_of_nothing_is_nothing_and_without_specifications_the_plant() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1 -u-> 0"], initial="0", marked=["0"], uncontrollable=["u"])
    assert infcon(plant, Automaton.empty(plant.alphabet)).is_empty
    assert_same_numbering(infcon(plant, ()), plant)


def test_states_beyond_the_specification_are_called_by_the_plants_and_can_be_found_by_name() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1 -u-> 2 -u-> 0"], initial="0", uncontrollable=["u"])
    other = Automaton.from_transitions(["x -a-> y"], initial="x")
    spec = Automaton.from_transitions(["p -a-> q"], initial="p", events=plant.alphabet, alphabet=["u"])
    least = infcon([plant, other], spec)
    assert [least.states[q] for q in range(least.n_states)] == ["0|x|p", "1|y|q", "2|y|out", "0|y|out"]
    assert least.state("2|y|out") == 2
    assert thenar.trim(all_marked(least)).states[3] == "0|y|out"


# -- relative closure ----------------------------------------------------------------------------------------


@quick
@given(problems())
def test_relative_closure_is_the_oracles(problem: Problem) -> None:
    check = is_relatively_closed(problem.specs, problem.plants)
    slow = control_oracle.is_relatively_closed(problem.specs, problem.plants)
    assert (check.holds, len(check.witness or ())) == (slow.holds, len(slow.witness or ()))
    if not check:
        assert check.witness is not None
        assert thenar.sync(*problem.plants).marks(check.witness)
        assert not thenar.sync(*problem.automata).marks(check.witness)


@quick
@given(problems())
def test_the_supremal_relatively_closed_sublanguage_is_the_oracles(problem: Problem) -> None:
    ours = sup_relatively_closed(problem.plants, problem.specs)
    assert_same_numbering(ours, control_oracle.sup_relatively_closed(problem.plants, problem.specs))


@quick
@given(problems())
def test_it_is_relatively_closed_and_all_of_what_was_so_before(problem: Problem) -> None:
    part = sup_relatively_closed(problem.plants, problem.specs)
    assert is_relatively_closed(part, problem.plants)
    whole = thenar.trim(thenar.sync(*problem.automata))
    assert thenar.is_sublanguage(part, whole)
    if is_relatively_closed(problem.specs, problem.plants):
        assert_same_languages(part, whole)


@quick
@given(problems(max_states=3))
def test_no_larger_relatively_closed_sublanguage_exists(problem: Problem) -> None:
    """What it leaves out, up to length five, has a prefix that no such language can have or do without."""
    part = {s for s, m in oracle.language(sup_relatively_closed(problem.plants, problem.specs), 5) if m}
    plant = {s for s, m in oracle.language(thenar.sync(*problem.plants), 5) if m}
    whole = {s for s, m in oracle.language(thenar.sync(*problem.automata), 5) if m}
    for s in whole:
        assert (s in part) == all(s[:k] in whole for k in range(len(s) + 1) if s[:k] in plant)


@quick
@given(problems())
def test_a_controllable_relatively_closed_language_is_brought_about_by_control_alone(problem: Problem) -> None:
    """Ramadge and Wonham 1987: then what a supervisor leaves of Lm(G), itself all marked, is just K."""
    part = sup_relatively_closed(problem.plants, problem.specs)
    if part.is_empty or not thenar.is_controllable(part, problem.plants):
        return
    assert_same_languages(thenar.sync(*problem.plants, all_marked(part)), part)


def test_libfaudes_finds_the_same_relative_closure_in_one_thousand_problems(libfaudes: ModuleType) -> None:
    verdicts: Counter[bool] = Counter()
    for seed in range(1250):  # one in five has nothing left to ask about
        p = random_problem(Random(seed))
        plant = thenar.trim(thenar.sync(*p.plants))
        specs = p.specs or p.plants[:1]
        within = thenar.trim(thenar.sync(plant, *specs))
        if within.is_empty or within.n_states > 300:
            continue
        check = is_relatively_closed(specs, p.plants)
        assert check.holds == libfaudes.is_relatively_closed(within, plant)
        verdicts[check.holds] += 1
        theirs = libfaudes.sup_relatively_closed(plant, within)
        assert thenar.is_isomorphic(thenar.minimize(sup_relatively_closed(p.plants, specs)), thenar.minimize(theirs)), (
            f"seed {seed}"
        )
    assert min(verdicts.values()) > 100
    assert verdicts.total() >= 1000


def test_relative_closure_of_nothing_holds() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["0", "1"])
    empty = Automaton.empty(plant.alphabet)
    assert is_relatively_closed(empty, plant)
    assert sup_relatively_closed(plant, empty).is_empty
    assert sup_relatively_closed(empty, plant).is_empty


# -- conflicts -----------------------------------------------------------------------------------------------


def test_a_conflict_is_told_by_a_shortest_trace_and_the_state_it_leads_to() -> None:
    a = Automaton.from_transitions(["0 -go-> 1 -x-> 2 -y-> 3"], initial="0", marked=["0", "3"], name="A")
    b = Automaton.from_transitions(["p -y-> q -x-> r"], initial="p", marked=["p", "r"], name="B")
    check = thenar.is_nonconflicting(a, b)
    assert str(check) == "nonconflicting: no after go: no marked state can be reached from state '1|p'"
    assert thenar.sync(a, b).run(check.witness or ())[-1] == thenar.sync(a, b).state("1|p")
