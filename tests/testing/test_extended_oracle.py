"""The oracle for extended automata agrees with its definition and with the plain oracle."""

from __future__ import annotations

from itertools import chain, combinations
from random import Random

from hypothesis import given

from thenar.model.automaton import Automaton
from thenar.model.expressions import parse
from thenar.model.extended import (
    Edge,
    ExtendedAutomaton,
    ExtendedProblem,
    Variable,
    invariant,
    needs,
)
from thenar.model.problem import Problem
from thenar.testing import oracle
from thenar.testing.asserts import assert_isomorphic
from thenar.testing.extended_oracle import Exploration, State, Supervision, explore, supcon
from thenar.testing.random_models import random_extended_problem, random_problem
from thenar.testing.strategies import extended_problems

PROBLEMS = 300


def as_automaton(result: Supervision, problem: Problem | ExtendedProblem) -> Automaton:
    """The controlled system as a plain automaton; it has one initial state, and its events choose nothing."""
    if not result:
        return Automaton.empty(problem.alphabet)
    names = {x: "|".join(str(part) for part in x) for x in result.states}
    return Automaton.from_transitions(
        [(names[x], e, names[y]) for x, e, y in result.transitions],
        initial=names[result.initial[0]],
        marked=[names[x] for x in result.states if x in result.marked],
        events=problem.alphabet,
        alphabet=problem.alphabet.names,
        states=list(names.values()),
    )


# -- theorems ------------------------------------------------------------------------------------------------


def test_a_plain_problem_has_the_supervisor_of_the_plain_oracle() -> None:
    for seed in range(PROBLEMS):
        problem = random_problem(Random(seed))
        result, plain = supcon(problem), oracle.supcon(problem.plants, problem.specs, alphabet=problem.alphabet)
        assert result.n_states == plain.n_states
        assert_isomorphic(as_automaton(result, problem), plain)
        disabled = oracle.condat(problem.plants, plain)
        assert sum(map(len, result.disabled.values())) == len(disabled.disabled)


@given(extended_problems(max_plants=2, max_specs=1, max_states=2, max_variables=1))
def test_the_result_holds_every_set_of_states_that_is_good_in_itself(problem: ExtendedProblem) -> None:
    check_largest(problem)


def test_the_result_is_the_largest_on_random_problems_too() -> None:
    assert sum(check_largest(random_extended_problem(Random(seed))) for seed in range(500)) > 150


def check_largest(problem: ExtendedProblem) -> bool:
    """Compare with all sets of states, if they are few."""
    system = explore(problem)
    if len(system.states) > 8:
        return False
    sets = chain.from_iterable(combinations(system.states, n) for n in range(len(system.states) + 1))
    union = set().union(*(x for x in sets if is_good(set(x), system, problem)))
    assert union == supcon(problem).kept
    return True


def is_good(states: set[State], system: Exploration, problem: ExtendedProblem) -> bool:
    """Legal, left by no uncontrollable event, and each with a way to a marked state that never may leave."""
    follow = {x: [t for t in system.step[x].values() if states.issuperset(t)] for x in states}
    escapes = any(
        not problem.alphabet[e].controllable and not states.issuperset(targets)
        for x in states
        for e, targets in system.step[x].items()
    )
    reaching = states & system.marked
    for _ in states:
        reaching |= {x for x in states if any(not reaching.isdisjoint(t) for t in follow[x])}
    return not escapes and states.isdisjoint(system.illegal) and reaching == states


def test_what_is_left_is_closed_legal_and_nonblocking() -> None:
    for seed in range(PROBLEMS):
        problem = random_extended_problem(Random(seed))
        system, result = explore(problem), supcon(problem)
        assert set(result.initial) == set(system.initial) & result.kept
        assert is_good(set(result.states), system, problem)
        for x in result.states:
            possible = [e for e in system.possible[x] if problem.alphabet[e].controllable]
            assert sorted(result.enabled[x] + result.disabled[x]) == sorted(possible)
            for e in result.disabled[x]:
                assert not result.kept.issuperset(system.step[x].get(e, (None,)))  # it had to be


UPDATES = ("n + 1", "n - 1", "0", "(n + 1) % {size}", "2 * n", "{size} - 1 - n", "n if n > 1 else n + 1")


def test_a_variable_is_the_automaton_that_counts_it() -> None:
    for seed in range(200):
        rng = Random(seed)
        problem = random_problem(rng, max_events=5, max_plants=2, max_specs=2, max_states=3)
        size, in_plants = rng.randint(2, 5), rng.randrange(2) == 0
        chosen = problem.alphabet.restrict(e.name for e in problem.alphabet if rng.randrange(2))
        formulas = [rng.choice(UPDATES).format(size=size) for _ in chosen]
        marked = [v for v in range(size) if v == 0 or rng.randrange(3)]
        edges = tuple(Edge(0, k, 0, updates=(("n", parse(text)),)) for k, text in enumerate(formulas))
        counter = ExtendedAutomaton("COUNT", chosen, ("on",), (True,), (True,), edges)
        values = [
            (n, e.name, eval(text, {"n": n})) for n in range(size) for e, text in zip(chosen, formulas, strict=True)
        ]
        counting = Automaton.from_transitions(
            [(str(n), e, str(new)) for n, e, new in values if 0 <= new < size],
            initial="0",
            marked=[str(n) for n in marked],
            events=problem.alphabet,
            alphabet=chosen.names,
            states=[str(n) for n in range(size)],
            name="COUNT",
        )
        with_variable = ExtendedProblem(
            [*problem.plants, *[counter] * in_plants],
            [*problem.specs, *[counter] * (not in_plants)],
            variables=[Variable("n", range(size), marked=marked)],
            alphabet=problem.alphabet,
        )
        with_automaton = Problem(
            [*problem.plants, *[counting] * in_plants],
            [*problem.specs, *[counting] * (not in_plants)],
            alphabet=problem.alphabet,
        )
        result = supcon(with_variable)
        assert_isomorphic(as_automaton(result, with_variable), as_automaton(supcon(with_automaton), with_automaton))


def test_a_need_is_the_guard_of_an_automaton_that_only_watches() -> None:
    """In the plants and in the specifications: 'e needs P' is an automaton of one state with the edge e when P."""
    needed = 0
    for seed in range(PROBLEMS):
        p = random_extended_problem(Random(seed))
        conditions = (*p.plant_conditions, *p.spec_conditions)
        watching = {
            id(c): ExtendedAutomaton(
                f"W{k}", p.alphabet.restrict([c.event]), ("on",), (True,), (True,), (Edge(0, 0, 0, c.predicate),)
            )
            for k, c in enumerate(conditions)
            if c.event is not None
        }
        q = ExtendedProblem(
            [*p.plants, *(watching.get(id(c), c) for c in p.plant_conditions)],
            [*p.specs, *(watching.get(id(c), c) for c in p.spec_conditions)],
            variables=p.variables,
            initial=p.initial,
            marked=p.marked,
            alphabet=p.alphabet,
        )
        assert counts(supcon(p)) == counts(supcon(q))
        needed += bool(watching)
    assert needed > 100


def test_an_invariant_of_the_specs_is_an_uncontrollable_event_that_may_not_happen() -> None:
    for seed in range(PROBLEMS):
        p = random_extended_problem(Random(seed))
        rules = [c for c in p.spec_conditions if c.event is None]
        alarm = ExtendedAutomaton.from_edges(
            "ALARM", ["on -alarm-> on"], initial="on", marked=["on"], uncontrollable=["alarm"]
        )
        others = [c for c in p.spec_conditions if c.event is not None]
        q = ExtendedProblem(
            [*p.plants, *p.plant_conditions, alarm],
            [*p.specs, *others, *(needs("alarm", c.predicate) for c in rules)],
            variables=p.variables,
            initial=p.initial,
            marked=p.marked,
        )
        left = [t for t in supcon(q).transitions if t[1] != "alarm"]
        assert (supcon(q).n_states, len(left)) == (supcon(p).n_states, len(supcon(p).transitions))


def counts(result: Supervision) -> tuple[int, ...]:
    disabled = sum(map(len, result.disabled.values()))
    return result.n_states, len(result.transitions), len(result.marked), len(result.initial), disabled


def test_the_problems_are_of_all_kinds() -> None:
    """What the random problems would be worth if they were all alike: nothing."""
    total = 600
    empty = removed = controlled = illegal = blocking = free = choice = starts = start_lost = owned = physics = 0
    for seed in range(total):
        problem = random_extended_problem(Random(seed))
        system, result = explore(problem), supcon(problem)
        empty += not result
        removed += bool(result) and len(result.kept) < len(system.states)
        controlled += any(result.disabled.values())
        illegal += bool(system.illegal)
        blocking += not is_good(set(system.states), system, problem) and not system.illegal
        free += bool(result) and len(result.kept) == len(system.states) and not any(result.disabled.values())
        choice += any(len(targets) > 1 for row in system.step.values() for targets in row.values())
        starts += len(system.initial) > 1
        start_lost += bool(result) and len(result.initial) < len(system.initial)
        owned += any(e.updates for a in problem.specs for e in a.edges)
        physics += bool(problem.plant_conditions)
    rates = {k: v / total for k, v in locals().items() if k in KINDS}
    assert all(0.08 < rate < 0.65 for rate in rates.values()), rates


KINDS = (
    "empty", "removed", "controlled", "illegal", "blocking", "free",
    "choice", "starts", "start_lost", "owned", "physics",
)  # fmt: skip


# -- what an event that is no controllable one, several initial states and several successors mean ---------------


def test_an_event_is_disabled_as_a_whole() -> None:
    """c leads to 'good' or to 'bad': the supervisor cannot tell them apart beforehand."""
    a = ExtendedAutomaton.from_edges("A", ["0 -c-> good", "0 -c-> bad", "good -d-> 0"], initial="0", marked=["0"])
    result = supcon(ExtendedProblem([a], [invariant("not A.bad")]))
    assert (result.states, result.disabled) == ((("0",),), {("0",): ("c",)})
    u = ExtendedAutomaton.from_edges(
        "A", ["0 -c-> good", "0 -c-> bad"], initial="0", marked=["0"], uncontrollable=["c"]
    )
    assert not supcon(ExtendedProblem([u], [invariant("not A.bad")]))


def test_an_update_out_of_range_is_impossible_in_a_plant_and_a_violation_in_a_spec() -> None:
    n = Variable("n", range(2))
    count = ("on", "u", "on", "true", {"n": "n + 1"})
    counter = ExtendedAutomaton.from_edges("N", [count], initial="on", marked=["on"], uncontrollable=["u"])
    source = Automaton.from_transitions(["0 -u-> 0"], initial="0", marked=["0"], uncontrollable=["u"], name="SOURCE")
    assert supcon(ExtendedProblem([counter, source], variables=[n])).n_states == 2
    assert not supcon(ExtendedProblem([source], [counter], variables=[n]))


def test_all_updates_read_the_old_values() -> None:
    swap = ExtendedAutomaton.from_edges(
        "SWAP", [("on", "swap", "on", "true", {"a": "b", "b": "a"})], initial="on", marked=["on"]
    )
    variables = [Variable("a", range(3), initial=1), Variable("b", range(3), initial=2)]
    assert explore(ExtendedProblem([swap], variables=variables)).states == (("on", 1, 2), ("on", 2, 1))


def test_an_event_that_no_automaton_knows_never_happens() -> None:
    a = Automaton.from_transitions(["0 -u-> 0"], initial="0", marked=["0"], uncontrollable=["u", "v"], alphabet=["v"])
    b = Automaton.from_transitions(["0 -u-> 0"], initial="0", marked=["0"], uncontrollable=["u"], name="B")
    problem = ExtendedProblem([b], [needs("v", "false")], alphabet=a.alphabet)
    assert supcon(problem).n_states == 1


def test_an_automaton_without_states_leaves_nothing() -> None:
    a = Automaton.from_transitions(["0 -a-> 0"], initial="0", marked=["0"])
    assert supcon(Problem([a], [Automaton.empty(a.alphabet, "E")])).n_states == 0
