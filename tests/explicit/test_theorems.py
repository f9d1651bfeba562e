"""Theorems of supervisory control as properties, and every operation against its slow obvious twin."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import thenar
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.testing import oracle
from thenar.testing.strategies import alphabets, automata, problems

quick = settings(max_examples=150, deadline=None)


def same(a: Automaton, b: Automaton) -> None:
    """Both are equal up to state names, and numbered alike."""
    assert thenar.is_isomorphic(a, b), f"{thenar.is_isomorphic(a, b)}\n{a}\n{b}"
    assert oracle.isomorphic(a, b)


@st.composite
def pairs(draw: st.DrawFn) -> tuple[Automaton, Automaton]:
    """Two automata whose alphabets overlap as they like, with one meaning for each event."""
    alphabet = draw(alphabets(max_events=5))
    parts = [draw(st.sets(st.sampled_from(alphabet.names), min_size=1)) for _ in range(2)]
    first, second = (draw(automata(alphabet.restrict(sorted(p)))) for p in parts)
    return first, second


@quick
@given(problems())
def test_supcon_is_the_oracles(problem: Problem) -> None:
    same(thenar.supcon(problem.plants, problem.specs), oracle.supcon(problem.plants, problem.specs))


@quick
@given(problems())
def test_supcon_is_controllable_nonblocking_and_within_the_specification(problem: Problem) -> None:
    K = thenar.supcon(problem.plants, problem.specs)
    assert thenar.is_controllable(K, problem.plants)
    assert thenar.is_nonblocking(K)
    legal = thenar.sync(*problem.automata)
    assert thenar.is_sublanguage(K, legal)


@settings(max_examples=60, deadline=None)
@given(problems(max_plants=2, max_specs=1))
def test_no_larger_controllable_nonblocking_sublanguage_exists(problem: Problem) -> None:
    """Every set of legal states that is controllable and nonblocking lies within supcon: all sets are tried."""
    K, legal = thenar.supcon(problem.plants, problem.specs), thenar.sync(*problem.automata)
    assume(legal.n_states <= 8)
    for chosen in range(1 << legal.n_states):
        part = thenar.reachable(restricted(legal, [q for q in range(legal.n_states) if chosen >> q & 1]))
        if not part.is_empty and thenar.is_controllable(part, problem.plants) and thenar.is_nonblocking(part):
            assert thenar.is_sublanguage(part, K)


def restricted(automaton: Automaton, keep: list[int]) -> Automaton:
    from thenar.explicit.reach import restrict

    return restrict(automaton, np.isin(np.arange(automaton.n_states), keep))


@quick
@given(problems())
def test_supcon_of_supcon_is_itself(problem: Problem) -> None:
    K = thenar.supcon(problem.plants, problem.specs)
    same(thenar.supcon(problem.plants, K), K)


@quick
@given(problems())
def test_several_plants_and_specs_stand_for_their_product(problem: Problem) -> None:
    specs = [thenar.sync(*problem.specs)] if problem.specs else []
    same(thenar.supcon(thenar.sync(*problem.plants), specs), thenar.supcon(problem.plants, problem.specs))


@quick
@given(problems())
def test_the_closed_loop_is_the_supervisor(problem: Problem) -> None:
    result = thenar.synthesize(problem)
    same(thenar.closed_loop(problem.plants, result.supervisor), result.supervisor.automaton)


@quick
@given(problems())
def test_control_data_is_the_oracles(problem: Problem) -> None:
    result = thenar.synthesize(problem)
    slow = oracle.condat(problem.plants, result.supervisor.automaton)
    fast = thenar.condat(problem.plants, result.supervisor.automaton)
    for x in range(result.supervisor.n_states):
        assert fast.pattern(x) == result.supervisor.pattern(x)
        assert set(fast.pattern(x).disabled) == set(slow.pattern(x).disabled)


@quick
@given(pairs())
def test_sync_is_the_oracles_and_commutative(pair: tuple[Automaton, Automaton]) -> None:
    a, b = pair
    same(thenar.sync(a, b), oracle.sync(a, b))
    same(thenar.sync(a, b), thenar.sync(b, a))


@quick
@given(pairs(), automata())
def test_sync_is_associative(pair: tuple[Automaton, Automaton], c: Automaton) -> None:
    a, b = pair
    try:
        whole = thenar.sync(a, b, c)
    except thenar.AlphabetClash:
        return
    same(thenar.sync(thenar.sync(a, b), c), whole)
    same(thenar.sync(a, thenar.sync(b, c)), whole)


@quick
@given(pairs())
def test_meet_is_the_intersection_of_languages(pair: tuple[Automaton, Automaton]) -> None:
    a, b = pair
    m = thenar.meet(a, b)
    same(m, oracle.meet(a, b))
    assert oracle.language(m, 4) == {
        (s, s_in_a and (s, True) in oracle.language(b, 4))
        for s, s_in_a in oracle.language(a, 4)
        if {(s, True), (s, False)} & oracle.language(b, 4)
    }


@quick
@given(automata())
def test_reachability_is_the_oracles(a: Automaton) -> None:
    for ours, theirs in (
        (thenar.reachable, oracle.reachable),
        (thenar.coreachable, oracle.coreachable),
        (thenar.trim, oracle.trim),
    ):
        assert ours(a).n_states == theirs(a).n_states
        assert ours(a).n_transitions == theirs(a).n_transitions
        same(ours(a), theirs(a))


@quick
@given(automata())
def test_nonblocking_is_the_oracles_and_its_witness_blocks(a: Automaton) -> None:
    check = thenar.is_nonblocking(a)
    assert bool(check) == bool(oracle.is_nonblocking(a))
    if not check:
        assert check.witness is not None
        stuck = a.run(check.witness)[-1]
        assert len(a.run(check.witness)) == len(check.witness) + 1
        assert (thenar.coreachable(at(a, stuck))).is_empty


def at(a: Automaton, state: int) -> Automaton:
    """The automaton started in another state."""
    return Automaton.from_arrays(a.alphabet, a.offsets, a.events, a.targets, marked=a.marked, initial=state)


@quick
@given(problems())
def test_controllability_is_the_oracles_and_its_witness_breaks_it(problem: Problem) -> None:
    specs = problem.specs or (problem.plants[0],)
    spec = thenar.sync(*specs)
    check = thenar.is_controllable(specs, problem.plants)
    assert bool(check) == bool(oracle.is_controllable(spec, problem.plants))
    if not check:
        assert check.witness is not None
        plant = thenar.sync(*problem.plants)
        assert plant.generates(check.witness)
        seen = [e for e in check.witness if e in spec.alphabet]
        assert spec.generates(seen[:-1])
        assert not spec.generates(seen)
        assert not plant.alphabet[check.witness[-1]].controllable


@quick
@given(automata(), st.data())
def test_projection_is_the_oracles(a: Automaton, data: st.DataObject) -> None:
    kept = data.draw(st.sets(st.sampled_from(a.alphabet.names)))
    same(thenar.project(a, kept), oracle.project(a, kept))


@quick
@given(automata(max_states=7))
def test_minimize_keeps_both_languages_in_the_fewest_states(a: Automaton) -> None:
    small = thenar.minimize(a)
    assert oracle.same_languages(small, a)
    assert small.n_states == oracle.minimize(a).n_states
    same(thenar.minimize(small), small)


@quick
@given(automata())
def test_the_complement_of_the_complement_has_the_same_marked_language(a: Automaton) -> None:
    c = thenar.complement(a)
    same(c, oracle.complement(a))
    marked = {s for s, m in oracle.language(a, 4) if m}
    assert {s for s, m in oracle.language(thenar.complement(c), 4) if m} == marked


@quick
@given(pairs())
def test_sublanguage_is_inclusion_up_to_length_five_and_its_witness_is_a_difference(
    pair: tuple[Automaton, Automaton],
) -> None:
    a, b = pair
    check = thenar.is_sublanguage(a, b)
    in_a, in_b = oracle.language(a, 5), oracle.language(b, 5)
    generated, marked = {s for s, _ in in_b}, {s for s, m in in_b if m}
    included = all(s in generated and (not m or s in marked) for s, m in in_a)
    if check:
        assert included
    else:
        assert check.witness is not None
        w = tuple(check.witness)
        known = all(e in b.alphabet for e in w)
        assert a.generates(w)
        assert not (known and b.generates(w)) or (a.marks(w) and not b.marks(w))
        shorter = {s for s, m in in_a if s not in generated or (m and s not in marked)}
        assert len(w) == min(map(len, shorter), default=len(w)), "not a shortest witness"
        assert included == (len(w) > 5)


@quick
@given(automata())
def test_the_shortest_trace_is_marked_and_none_is_shorter(a: Automaton) -> None:
    trace = thenar.shortest_trace(a)
    marked = sorted(len(s) for s, m in oracle.language(a, 5) if m)
    if trace is None:
        assert not marked
    else:
        assert a.marks(trace)
        assert not marked or marked[0] == len(trace)


@quick
@given(automata())
def test_selfloops_are_erased_by_projection(a: Automaton) -> None:
    looped = thenar.selfloop(a, ["extra"])
    assert looped.n_transitions == a.n_transitions + a.n_states
    same(thenar.project(looped, a.alphabet), thenar.reachable(a))


def test_shuffle_interleaves_and_refuses_shared_events() -> None:
    a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"], name="A")
    b = Automaton.from_transitions(["0 -y-> 1"], initial="0", marked=["1"], name="B")
    assert thenar.shuffle(a, b).n_states == 4
    with pytest.raises(thenar.InputError, match=r"shuffle: event 'x' is in both 'A' and 'A'"):
        thenar.shuffle(a, a)


def test_the_empty_automaton_goes_through_every_operation() -> None:
    a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"], name="A")
    empty = Automaton.empty(a.alphabet)
    assert thenar.sync(a, empty).is_empty
    assert thenar.supcon(a, empty).is_empty
    assert thenar.trim(empty).is_empty
    assert thenar.minimize(empty).is_empty
    assert thenar.project(empty, ["x"]).is_empty
    assert thenar.is_nonblocking(empty)
    assert thenar.is_sublanguage(empty, a)
    assert not thenar.is_sublanguage(a, empty)
    assert thenar.complement(empty).marks("x, x")
    assert thenar.shortest_trace(empty) is None
    assert thenar.condat(a, empty).is_empty
