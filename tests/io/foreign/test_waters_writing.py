"""What is written as a Waters module does, read again, what it did before."""

from __future__ import annotations

import re
from collections import Counter
from random import Random

import numpy as np
import pytest

from thenar import (
    Alphabet,
    Automaton,
    Event,
    ExtendedAutomaton,
    ExtendedProblem,
    Problem,
    Variable,
    invariant,
    needs,
    synthesize,
)
from thenar.errors import InputError
from thenar.io.foreign import waters
from thenar.library.classics import cat_and_mouse, small_factory
from thenar.testing.extended_oracle import explore
from thenar.testing.random_models import random_extended_problem, random_problem

ODD = ["a b", 'c"d', "e<f>&", "'", "\n", "ä{}", "-1", ":accepting", "\u2028", "\x85"]


def text(problem: Problem | ExtendedProblem) -> bytes:
    return "".join(map(str, waters.dumps(problem).chunks)).encode()


def again(problem: Problem | ExtendedProblem) -> ExtendedProblem:
    return ExtendedProblem.of(waters.loads(text(problem), "m.wmod"))


Facts = tuple[set[object], set[object], set[object], set[object]]


def facts(problem: ExtendedProblem, names: list[str]) -> Facts:
    """Return the initial states, moves, marked and illegal states, seen by ``names``; truths as 0 and 1."""
    listed = [a.name for a in problem.automata] + [v.name for v in problem.variables]
    order = [listed.index(n) for n in names]

    def seen(x: tuple[object, ...]) -> tuple[object, ...]:
        return tuple(int(x[k]) if isinstance(x[k], bool) else x[k] for k in order)  # type: ignore[call-overload]

    system = explore(problem)
    moves: set[object] = {(seen(x), e, seen(y)) for x, row in system.step.items() for e, ys in row.items() for y in ys}
    return set(map(seen, system.initial)), moves, set(map(seen, system.marked)), set(map(seen, system.illegal))


def assert_does_the_same(problem: ExtendedProblem) -> ExtendedProblem:
    names = [a.name for a in problem.automata] + [v.name for v in problem.variables]
    other = again(problem)
    assert facts(other, names) == facts(problem, names)
    return other


REASONS = (
    "whether it stays true; add guards",
    "that the predicate on initial states leaves it",
    "a .wmod file can only say which values and states are",
)


def test_reading_what_was_written_does_the_same() -> None:
    told: Counter[str] = Counter()
    for seed in range(700):
        problem = random_extended_problem(Random(seed))
        try:
            other = assert_does_the_same(problem)
        except InputError as error:
            (reason,) = (r for r in REASONS if r in str(error))
            told[reason] += 1
            continue
        told["written"] += 1
        if seed % 25 == 0:
            for engine in ("explicit", "symbolic"):
                assert synthesize(other, engine).size == synthesize(problem, engine).size
    assert told["written"] > 560
    assert len(told) == len(REASONS) + 1


def test_reading_what_was_written_of_a_plain_problem_changes_nothing() -> None:
    for seed in range(1000):
        rng = Random(seed)
        drawn = random_problem(rng, max_events=5, max_plants=2, max_specs=2)
        events = {e.name: Event(rng.choice(["x", "é<&", "!"]) + e.name, e.controllable, rng.random() < 0.7)
                  for e in drawn.alphabet}  # fmt: skip
        automata = [odd(a, events, rng) for a in drawn.automata]
        n, sigma = len(drawn.plants), Alphabet([*events.values(), Event("never")])
        problem = Problem(automata[:n], automata[n:], name="<p>", alphabet=sigma, description="a\nb & c")
        other = waters.loads(text(problem), "m.wmod")
        assert isinstance(other, Problem)
        assert (other.name, other.description, other.alphabet) == ("<p>", "a\nb & c", sigma)
        for one, two in zip(problem.automata, other.automata, strict=True):
            assert (one.name, one.alphabet, one.initial) == (two.name, two.alphabet, two.initial)
            assert [one.states[q] for q in range(one.n_states)] == [two.states[q] for q in range(two.n_states)]
            for array in ("offsets", "events", "targets", "marked"):
                np.testing.assert_array_equal(getattr(one, array), getattr(two, array))


def odd(a: Automaton, events: dict[str, Event], rng: Random) -> Automaton:
    """Return ``a`` with names that make trouble."""
    states = [rng.choice(ODD) + str(q) for q in range(a.n_states)]
    sigma = Alphabet(events[e] for e in a.alphabet.names)
    return Automaton.from_arrays(
        sigma, a.offsets, a.events, a.targets, marked=a.marked, initial=a.initial, states=states, name=a.name + " <&>"
    )


def counter(*edges: tuple[str, str], values: object = range(-4, 5), initial: object = 0) -> ExtendedProblem:
    """Return a problem in which event k does the k-th update of n where its guard is true."""
    drawn = [("p", f"e{k}", "p", guard, {"n": new}) for k, (guard, new) in enumerate(edges)]
    plant = ExtendedAutomaton.from_edges("A", drawn, initial="p", marked=["p"])
    return ExtendedProblem(plant, variables=[Variable("n", values, initial)])  # type: ignore[arg-type]


VALUES = ["n // 3", "n % 3", "n // -3", "n % -3", "(n + 7) // 2 - 3", "-n", "n - 1", "2 * n", "1 if n < 0 else n - 1"]
VALUES += ["(n if n > 0 else -n) - (1 if n % 2 == 0 else 0)", "n * (1 if n == 2 else -1)"]
GUARDS = ["n == 0 or n > 2", "not (n < 1) == (n > 2)", "(n if n > 0 else -n) == 2", "n % 3 == 2", "true", "false"]
GUARDS += ["(n > 0 if n % 2 == 0 else n < 0)", "A.p", "not A.p or n < 3"]


@pytest.mark.parametrize("value", VALUES)
def test_values(value: str) -> None:
    assert_does_the_same(counter(("n < 5", value), ("true", "n + 1"), ("true", "n - 1")))


@pytest.mark.parametrize("guard", GUARDS)
def test_guards(guard: str) -> None:
    assert_does_the_same(counter((guard, "n - n"), ("true", "n + 1"), ("true", "n - 1")))


def test_a_range_with_gaps() -> None:
    problem = counter(("true", "n + 1"), ("true", "n - 2"), values=[0, 1, 3, 7], initial=[0, 7])
    other = assert_does_the_same(problem)
    assert other.variables[0].values == tuple(range(8))


def test_atoms_and_truths() -> None:
    lamp = Variable("lamp", ["dark red", "green", "5"], ["green", "5"], ["green"])
    flag = Variable("my.flag", [False, True])
    edges = [
        ("p", "a", "p", "my.flag", {"lamp": "'dark red' if lamp == green else '5'", "my.flag": "not my.flag"}),
        ("p", "a", "p", "not my.flag and lamp != 'dark red'", {"my.flag": "lamp == green"}),
        ("p", "b", "q", "my.flag == (lamp == '5')", {"my.flag": "true"}),
        ("q", "b", "p", "true", {"lamp": "green"}),
    ]
    plant = ExtendedAutomaton.from_edges("A", edges, initial=["p", "q"], marked=["q"])
    problem = ExtendedProblem(plant, variables=[lamp, flag])
    other = assert_does_the_same(problem)
    assert [v.name for v in other.variables] == ["lamp", "my.flag"]
    assert "The truths my.flag are written as 0 and 1." in waters.dumps(problem).notes


def test_conditions_become_automata() -> None:
    rules = [needs("e0", "n < 3"), invariant("n != 2"), invariant("not A.q"), invariant("n < 4 or A.p", name="high")]
    plant = ExtendedAutomaton.from_edges(
        "A", [("p", "e0", "p", "true", {"n": "n + 1"}), "p -e1-> q -violation-> p"], initial="p", marked=["p"]
    )
    problem = ExtendedProblem([plant, needs("e1", "n > 0")], rules, variables=[Variable("n", range(6))])
    other = assert_does_the_same(problem)
    assert [a.name for a in other.plants] == ["A", "e1 needs", "invariants"]
    assert [a.name for a in other.specs] == ["e0 needs", "no violation"]
    assert other.alphabet.names == ("e0", "e1", "violation", "violation_")
    assert [str(c) for c in other.spec_conditions] == ["not A.q"]
    notes = " ".join(waters.dumps(problem).notes)
    assert "What events need is written as automata of one node" in notes
    assert "an uncontrollable event 'violation_', possible where one is violated" in notes
    assert "Supremica needs its option for automaton variables" in notes
    for engine in ("explicit", "symbolic"):
        assert synthesize(other, engine).size == synthesize(problem, engine).size


def test_invariants_of_the_plants_become_guards() -> None:
    moves = ["in -out-> out -in-> in", "out -both-> in"]
    cat = ExtendedAutomaton.from_edges("CAT", moves, initial="out", marked=["out"])
    mouse = ExtendedAutomaton.from_edges(
        "MOUSE",
        [("out", "enter", "in", True, {"n": "n + 1"}), "in -leave-> out", "out -both-> out"],
        initial="out", marked=["out"], uncontrollable=["enter"],
    )  # fmt: skip
    physics = [invariant("not (CAT['in'] and MOUSE['in'])"), invariant("n < 3")]
    problem = ExtendedProblem([cat, mouse, *physics], variables=[Variable("n", range(9))])
    other = assert_does_the_same(problem)
    assert [a.name for a in other.plants] == ["CAT", "MOUSE", "physics"]
    assert other.plants[2].alphabet.names == ("in", "enter")
    for engine in ("explicit", "symbolic"):
        assert synthesize(other, engine).size == synthesize(problem, engine).size


def test_an_edge_without_an_update_says_that_the_variable_stays() -> None:
    plant = ExtendedAutomaton.from_edges("A", [("p", "a", "q", True, {"n": "1"}), ("q", "a", "p")], initial="p")
    problem = ExtendedProblem(plant, variables=[Variable("n", range(2))])
    assert text(problem).count(b'Operator="="') == 2
    assert not assert_does_the_same(problem).plants[0].edges[1].updates


def test_predicates_on_one_part_each() -> None:
    plant = ExtendedAutomaton.from_edges("A", ["p -a-> q -a-> p"], initial=["p", "q"], marked=["p", "q"])
    problem = ExtendedProblem(
        plant, variables=[Variable("n", range(4), range(4))], initial="n > 1 and not A.q", marked="A.q and n % 2 == 0"
    )
    other = assert_does_the_same(problem)
    assert other.variables[0].initial == (2, 3)
    assert (other.plants[0].initial, other.plants[0].marked) == ((True, False), (False, True))


def test_automata_without_states_or_marks_or_names() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1"], initial="0", alphabet=["b"])
    problem = Problem(plant, Automaton.empty(Alphabet(["a"]), "S"))
    other = waters.loads(text(problem), "m.wmod")
    assert isinstance(other, Problem)
    assert [(a.name, a.n_states, int(a.marked.sum())) for a in other.automata] == [("automaton_1", 2, 0), ("S", 0, 0)]
    assert waters.dumps(problem).notes == ("Automata without a name are called automaton_1.",)


CHOICE = ExtendedAutomaton.from_edges("A", ["p -a-> p", "p -a-> q"], initial="p")


@pytest.mark.parametrize(
    ("problem", "said"),
    [
        (ExtendedProblem([CHOICE, invariant("not A.q")]), "'A' may choose by 'a' whether it stays true; add guards"),
        (ExtendedProblem([CHOICE, invariant("A.q")]), "no state that the predicate on initial states leaves it"),
        (ExtendedProblem(small_factory().plants, marked=False), "no state is marked"),
        (ExtendedProblem(small_factory().plants, marked="MACHINE1.idle or MACHINE2.idle"), "one by one"),
        (counter(("true", "n + 3000000000 - 3000000000")), "3000000000 does not fit into the 32 bits"),
        (counter(("n * 1000000000 < 5", "0")), "between -4000000000 and 4000000000 does not fit into the 32 bits"),
        (counter(("true", " + ".join(["(1 if n == 1 else 0)"] * 9))), "more than 256 cases"),
        (counter(("true", "n"), values=[2**31], initial=None), "does not fit into the 32 bits"),
        (ExtendedProblem(ExtendedAutomaton.from_edges("n:m", [], initial="p"), variables=[Variable("n.m", [1])]),
         "variable 'n.m' and an automaton would both be called 'n:m'"),
        (ExtendedProblem(ExtendedAutomaton.from_edges("A", [], initial="p"), variables=[Variable("n", ["A"])]),
         "its value 'A' is called like an automaton"),
        (Problem(Automaton.from_transitions([("\x07", "a", "\x07")], initial="\x07", name="A")), "XML cannot hold"),
    ],
)  # fmt: skip
def test_what_cannot_be_written_is_refused(problem: Problem | ExtendedProblem, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        waters.dumps(problem)


@pytest.mark.parametrize("problem", [small_factory(), cat_and_mouse()], ids=lambda p: p.name)
def test_the_same_supervisors(problem: Problem) -> None:
    assert synthesize(waters.loads(text(problem), "m.wmod")).size == synthesize(problem).size


def test_the_file_comes_in_pieces() -> None:
    n = 20_000
    rows = (np.arange(n + 1), np.zeros(n, np.int64), (np.arange(n) + 1) % n)
    ring = Automaton.from_arrays(Alphabet(["a"]), *rows, marked=np.ones(n, np.bool_), name="RING")
    pieces = [len(piece) for piece in map(str, waters.dumps(Problem(ring)).chunks)]
    assert max(pieces) < 400_000 < sum(pieces)
