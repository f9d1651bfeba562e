"""TCT and libFAUDES find the same languages: a thousand random inputs through every operation that they have.

Their conventions that differ, and what is compared then:

* TCT's project is minimal.  Its minstate merges states that differ once in some hundred automata (see
  tests/oracles/tct.py): where that changes the language it is no oracle.
* libFAUDES's LanguageConcatenate leaves out what cannot be completed: it is the trim part of ours.
* libFAUDES's KleeneClosure of an automaton that marks nothing is empty; in ours, as in theory, ε is left.
* libFAUDES's LanguageInclusion compares the marked languages only: that is is_sublanguage of the trim parts.
* libFAUDES counts states differently where both are not minimal: the minimal ones are isomorphic.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from random import Random
from typing import Any

import numpy as np
import pytest
from tests.oracles import libfaudes, tct

import thenar
from thenar.explicit import regular
from thenar.explicit.nondeterminism import determinise
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.extended import Edge, ExtendedAutomaton
from thenar.testing import assert_isomorphic, assert_same_numbering, oracle, random_alphabet, random_automaton

INPUTS = 1000
BATCH = 250
SEEDS = [range(k, k + BATCH) for k in range(0, INPUTS, BATCH)]
minimize, trim = thenar.minimize, thenar.trim


@cache
def pair(seed: int) -> tuple[Automaton, Automaton]:
    """Two automata of up to 6 states over parts of one alphabet, all states reachable; one state in three is marked."""
    rng = Random(30_000 + seed)
    alphabet = random_alphabet(rng, max_events=4)

    def one() -> Automaton:
        part = alphabet.restrict(e for k, e in enumerate(alphabet.names) if k == 0 or rng.random() < 0.7)
        drawn = thenar.reachable(random_automaton(rng, part, max_states=6))
        return replace(drawn, marked=np.array([rng.random() < 0.35 for _ in range(drawn.n_states)]))

    return one(), one()


@cache
def nondeterministic(seed: int) -> tuple[ExtendedAutomaton, tuple[str, ...]]:
    """An automaton of up to 5 states with choices, and some of its events."""
    rng = Random(40_000 + seed)
    alphabet, n = random_alphabet(rng, max_events=4), rng.randint(1, 5)
    rows = [
        Edge(rng.randrange(n), rng.randrange(len(alphabet)), rng.randrange(n)) for _ in range(rng.randint(0, 3 * n))
    ]
    initial, marked = ([rng.random() < 0.35 for _ in range(n)] for _ in range(2))
    initial[rng.randrange(n)] = True
    names = tuple(str(q) for q in range(n))
    automaton = ExtendedAutomaton("N", alphabet, names, tuple(initial), tuple(marked), tuple(rows))
    return automaton, tuple(e for e in alphabet.names if rng.random() < 0.35)


def new(a: Automaton, b: Automaton) -> Alphabet:
    """The events of ``b`` that ``a`` does not know."""
    return Alphabet(e for e in b.alphabet if e not in a.alphabet)


def renumbered(a: Automaton, seed: int) -> Automaton:
    """``a`` with its states in another order, and one in two times with one state marked otherwise."""
    rng = Random(seed)
    order = rng.sample(range(a.n_states), a.n_states)
    marked = set(np.flatnonzero(a.marked).tolist()) ^ ({rng.randrange(a.n_states)} if rng.random() < 0.5 else set())
    return Automaton.from_transitions(
        list(a.transitions()),
        initial=a.states[a.initial],
        marked=[a.states[q] for q in marked],
        events=a.alphabet,
        alphabet=a.alphabet.names,
        states=[a.states[q] for q in order],
    )


def asked(
    peer: Any, seeds: range, questions: Callable[[int], list[tuple[Any, ...]]]
) -> Iterator[tuple[int, list[Any]]]:
    """Yield each seed with what the peer answers to its questions, all asked at once."""
    each = [questions(seed) for seed in seeds]
    answers = iter(peer.answers([q for some in each for q in some]))
    for seed, some in zip(seeds, each, strict=True):
        yield seed, [next(answers) for _ in some]


@pytest.mark.parametrize("seeds", SEEDS, ids=str)
def test_tct_finds_the_same_products_parts_and_projections(seeds: range) -> None:
    def questions(seed: int) -> list[tuple[Any, ...]]:
        a, b = pair(seed)
        both = [("sync", a, b), ("meet", a, b), ("is_isomorphic", a, renumbered(a, seed))]
        one = [("trim", a), ("complement", a), ("project", a, kept(a)), ("selfloop", a, new(a, b))]
        return both + one + [("shortest_trace", a, a.n_states - 1)]

    for seed, answers in asked(tct, seeds, questions):
        sync, meet, isomorphic, trimmed, complement, project, selfloop, shortest = answers
        a, b = pair(seed)
        assert_same_numbering(thenar.sync(a, b), sync)
        assert_same_numbering(thenar.meet(a, b), meet)
        assert bool(thenar.is_isomorphic(a, renumbered(a, seed))) == isomorphic
        assert_same_numbering(thenar.trim(a), thenar.reachable(trimmed))
        assert_isomorphic(thenar.complement(a), complement)
        assert_isomorphic(minimize(thenar.project(a, kept(a))), project)
        assert_isomorphic(thenar.selfloop(a, new(a, b)), selfloop)
        assert_isomorphic(regular.inverse_project(a, b.alphabet), selfloop)
        trace = thenar.shortest_trace(a, a.n_states - 1)
        assert trace is not None
        assert len(trace) == (0 if shortest is None else len(shortest))


def kept(a: Automaton) -> tuple[str, ...]:
    return a.alphabet.names[::2]


def test_tcts_minstate_is_ours_except_where_it_changes_the_language() -> None:
    changed = 0
    for seed, (theirs,) in asked(tct, range(INPUTS), lambda seed: [("minimize", pair(seed)[0])]):
        a = pair(seed)[0]
        if oracle.same_languages(a, theirs):
            assert_isomorphic(minimize(a), theirs)
        else:
            changed += 1
    assert changed < INPUTS / 100


@pytest.mark.parametrize("seeds", SEEDS, ids=str)
def test_libfaudes_finds_the_same_languages_of_two_automata(seeds: range) -> None:
    operations = ("union", "concatenation", "difference", "meet", "sync", "is_sublanguage")
    for seed, answers in asked(libfaudes, seeds, lambda seed: [(name, *pair(seed)) for name in operations]):
        a, b = pair(seed)
        union, concatenation, difference, meet, sync, included = answers
        assert_isomorphic(regular.union(a, b), union)
        assert_isomorphic(minimize(trim(regular.concatenation(a, b))), minimize(concatenation))
        assert_isomorphic(minimize(regular.difference(a, b)), minimize(difference))
        assert_isomorphic(thenar.meet(a, b), meet)
        assert_isomorphic(thenar.sync(a, b), sync)
        assert bool(thenar.is_sublanguage(trim(a), trim(b))) == included


@pytest.mark.parametrize("seeds", SEEDS, ids=str)
def test_libfaudes_finds_the_same_languages_of_one_automaton(seeds: range) -> None:
    def questions(seed: int) -> list[tuple[Any, ...]]:
        a, b = pair(seed)
        names = ("kleene_star", "prefix_closure", "complement", "trim", "minimize")
        return [
            *((name, a) for name in names),
            ("project", a, kept(a)),
            ("selfloop", a, new(a, b)),
            ("inverse_project", a, b.alphabet),
        ]

    for seed, answers in asked(libfaudes, seeds, questions):
        star, closure, complement, trimmed, minimal, project, selfloop, lifted = answers
        a, b = pair(seed)
        if a.marked.any():
            assert_isomorphic(minimize(regular.kleene_star(a)), minimize(star))
        else:
            assert star.is_empty
            assert regular.kleene_star(a).marks("ε")
        assert_isomorphic(regular.prefix_closure(a), closure)
        assert_isomorphic(minimize(thenar.complement(a)), minimize(complement))
        assert_isomorphic(trim(a), trimmed)
        assert_isomorphic(minimize(a), minimal)
        assert_isomorphic(minimize(thenar.project(a, kept(a))), minimize(project))
        assert_isomorphic(thenar.selfloop(a, new(a, b)), selfloop)
        assert_isomorphic(regular.inverse_project(a, b.alphabet), lifted)


@pytest.mark.parametrize("seeds", SEEDS, ids=str)
def test_libfaudes_determinises_as_we_do(seeds: range) -> None:
    def questions(seed: int) -> list[tuple[Any, ...]]:
        a, silent = nondeterministic(seed)
        return [("determinise", a), ("determinise", a, silent)]

    for seed, (plain, erased) in asked(libfaudes, seeds, questions):
        a, silent = nondeterministic(seed)
        assert_isomorphic(determinise(a), plain)
        assert_isomorphic(minimize(determinise(a, silent)), minimize(erased))


def test_the_inputs_are_of_all_kinds() -> None:
    kinds: Counter[str] = Counter()
    for seed in range(INPUTS):
        a, b = pair(seed)
        kinds["marks nothing"] += not a.marked.any()
        kinds["has dead ends"] += not thenar.is_nonblocking(a)
        kinds["starts marked"] += bool(a.marked[a.initial])
        kinds["not minimal"] += minimize(a).n_states < a.n_states
        kinds["other alphabet"] += set(a.alphabet) != set(b.alphabet)
        kinds["included"] += bool(thenar.is_sublanguage(trim(a), trim(b)))
        kinds["isomorphic"] += bool(thenar.is_isomorphic(a, renumbered(a, seed)))
        n, silent = nondeterministic(seed)
        kinds["choice"] += len({(e.source, e.event) for e in n.edges}) < len(set(n.edges))
        kinds["several initial states"] += sum(n.initial) > 1
        kinds["silent events"] += bool(silent)
        kinds["sets of states"] += determinise(n).n_states > len(n.states)
    rates = {kind: count / INPUTS for kind, count in kinds.items()}
    assert all(0.05 < rate < 0.95 for rate in rates.values()), rates
