"""Abstraction: hiding and merging change the size, but no verdict about conflicts."""

from collections.abc import Iterator
from itertools import combinations
from random import Random

import pytest

import thenar
from thenar.errors import LimitReached
from thenar.explicit import abstraction
from thenar.explicit.abstraction import (
    TAU,
    Process,
    hide,
    is_nonconflicting_by_abstraction,
    is_observer,
    observation_quotient,
    without_certain_conflicts,
)
from thenar.library.classics import chain, dining, small_factory
from thenar.model.automaton import Automaton
from thenar.testing import oracle, random_automaton, random_problem
from thenar.testing.random_models import numbered_alphabet

ALPHABET = numbered_alphabet([False, False, True, False, True])


def some(total: int, max_states: int = 6) -> Iterator[tuple[Automaton, list[str]]]:
    """Random automata, each with some of its events to hide."""
    for seed in range(total):
        rng = Random(seed)
        yield random_automaton(rng, ALPHABET, max_states=max_states), [e for e in ALPHABET.names if rng.random() < 0.5]


def reached_by(p: Process) -> list[list[set[int]]]:
    """Slow twin of the saturated steps: for each state and label, τ last, the states that it may silently lead to."""
    steps = [
        [set(p.target[(p.source == x) & (p.label == e)].tolist()) for e in (*range(len(p.events)), TAU)]
        for x in range(p.n_states)
    ]

    def silently(states: set[int]) -> set[int]:
        while more := {z for y in states for z in steps[y][-1]} - states:
            states = states | more
        return states

    rest = [silently({x}) for x in range(p.n_states)]
    return [
        [silently({z for y in rest[x] for z in steps[y][e]}) for e in range(len(p.events))] + [rest[x]]
        for x in range(p.n_states)
    ]


def equivalent(p: Process) -> set[tuple[int, int]]:
    """Slow twin of observation equivalence: start with all pairs and strike out those that can be told apart."""
    steps = reached_by(p)
    marks = [any(p.marked[y] for y in steps[x][-1]) for x in range(p.n_states)]
    same = {(x, y) for x in range(p.n_states) for y in range(p.n_states) if marks[x] == marks[y]}
    while struck := {
        (x, y)
        for x, y in same
        if not all(any((a, b) in same for b in steps[y][e]) for e in range(len(steps[x])) for a in steps[x][e])
        or not all(any((a, b) in same for a in steps[x][e]) for e in range(len(steps[x])) for b in steps[y][e])
    }:
        same -= struck
    return same


def test_the_quotient_has_a_state_for_each_class_of_observation_equivalence() -> None:
    for automaton, hidden in some(200):
        p = hide(automaton, hidden)
        same = equivalent(p)
        classes = {frozenset(y for y in range(p.n_states) if (x, y) in same) for x in range(p.n_states)}
        assert observation_quotient(p).n_states == len(classes)


def test_states_of_the_quotient_are_never_equivalent() -> None:
    for automaton, hidden in some(200):
        q = observation_quotient(hide(automaton, hidden))
        assert all(x == y for x, y in equivalent(q))


def test_without_hidden_events_the_quotient_is_the_minimal_automaton() -> None:
    for automaton, _ in some(200):
        p = observation_quotient(hide(thenar.reachable(automaton), []))
        assert p.is_deterministic
        least = thenar.minimize(automaton)
        assert (p.n_states, p.n_transitions) == (least.n_states, least.n_transitions)


def residuals(automaton: Automaton, hidden: list[str]) -> list[Automaton]:
    """For each state, the minimal automaton of what can be seen of its marked futures."""
    kept = [e for e in automaton.alphabet.names if e not in hidden]
    return [
        thenar.minimize(thenar.project(thenar.trim(started(automaton, q)), kept)) for q in range(automaton.n_states)
    ]


def started(automaton: Automaton, q: int) -> Automaton:
    a = automaton
    return Automaton.from_arrays(a.alphabet, a.offsets, a.events, a.targets, marked=a.marked, initial=q)


def test_a_projection_is_an_observer_exactly_if_what_looks_the_same_has_the_same_marked_futures() -> None:
    found = {True: 0, False: 0}
    for automaton, hidden in some(400, max_states=5):
        trim = thenar.trim(automaton)
        if trim.is_empty:
            continue
        kept = [e for e in ALPHABET.names if e not in hidden]
        looks = thenar.project(trim, kept)
        same = residuals(trim, hidden)
        members = [
            [int(x) for x in looks.states.members[lo:hi]]  # type: ignore[attr-defined]
            for lo, hi in zip(looks.states.offsets[:-1], looks.states.offsets[1:], strict=True)  # type: ignore[attr-defined]
        ]
        expected = all(bool(thenar.is_isomorphic(same[x], same[y])) for m in members for x, y in combinations(m, 2))
        assert is_observer(trim, kept) == expected
        found[expected] += 1
    assert min(found.values()) > 50


def test_the_quotient_by_an_observer_is_the_projection() -> None:
    for automaton, hidden in some(400, max_states=5):
        trim = thenar.trim(automaton)
        kept = [e for e in ALPHABET.names if e not in hidden]
        if not trim.is_empty and is_observer(trim, kept):
            small = observation_quotient(hide(trim, hidden))
            least = thenar.minimize(thenar.project(trim, kept))
            assert (small.n_states, small.n_transitions) == (least.n_states, least.n_transitions)


@pytest.mark.parametrize("seeds", [range(k, k + 250) for k in range(0, 1000, 250)], ids=str)
def test_abstraction_finds_the_same_conflicts_as_the_product(seeds: range) -> None:
    found = {True: 0, False: 0}
    for seed in seeds:
        automata = random_problem(Random(seed), max_plants=5).automata
        expected = bool(oracle.is_nonconflicting(*automata))
        assert bool(is_nonconflicting_by_abstraction(*automata)) == expected
        found[expected] += 1
    assert min(found.values()) > 50


def test_certain_conflicts_are_one_state_without_a_way_out() -> None:
    for automaton, hidden in some(200):
        p = without_certain_conflicts(hide(automaton, hidden))
        blocked = [x for x in range(p.n_states) if not any(p.marked[y] for y in range(p.n_states) if leads(p, x, y))]
        assert len(blocked) <= 1
        assert not any((p.source == x).any() for x in blocked)


def leads(p: Process, x: int, y: int) -> bool:
    seen = {x}
    while more := set(p.target[[s in seen for s in p.source.tolist()]].tolist()) - seen:
        seen |= more
    return y in seen


def test_long_chains_and_rings_take_little() -> None:
    # a buffer that forbids to put is no supervisor, but it is as good an automaton as any
    assert is_nonconflicting_by_abstraction(*chain(60).automata, most=100)
    assert not is_nonconflicting_by_abstraction(*dining(60).automata, most=1000)
    assert is_nonconflicting_by_abstraction(*small_factory(60).automata, most=100)


def test_what_gets_too_large_is_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LimitReached, match="1 states"):
        is_nonconflicting_by_abstraction(*chain(3).automata, most=1)
    monkeypatch.setattr(abstraction, "TRIED", 1)
    with pytest.raises(LimitReached, match="limit of 1 states: 2 states and 0 tr"):
        is_nonconflicting_by_abstraction(*chain(3).automata)
    monkeypatch.setattr(abstraction, "STEPS", 3)
    with pytest.raises(LimitReached, match="3 transitions"):
        observation_quotient(hide(chain(3).plants[0], []))


def test_an_empty_automaton_blocks_nothing() -> None:
    empty = Automaton.empty(ALPHABET)
    assert is_nonconflicting_by_abstraction(empty, random_automaton(Random(1), ALPHABET))
    assert bool(oracle.is_nonconflicting(empty)) is True
