"""Operations on languages: their definitions on strings, their laws, and each against its slow obvious twin."""

import tracemalloc
from collections.abc import Iterable
from itertools import product
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import thenar
from thenar.explicit.nondeterminism import determinise
from thenar.explicit.regular import (
    concatenation,
    difference,
    inverse_project,
    kleene_star,
    left_quotient,
    prefix_closure,
    quotient,
    reverse,
    union,
)
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import Edge, ExtendedAutomaton
from thenar.testing import assert_same_numbering, oracle, regular_oracle
from thenar.testing.regular_oracle import strings
from thenar.testing.strategies import alphabets, automata

quick = settings(max_examples=100, deadline=None)
N = 4  # the length of strings up to which languages are compared with sets of them
Strings = set[tuple[str, ...]]


@st.composite
def several(draw: st.DrawFn, n: int = 2, max_states: int = 4) -> list[Automaton]:
    """Automata whose alphabets overlap as they like, one meaning for each event; one of ten has no states."""
    alphabet = draw(alphabets(max_events=3))
    parts = [draw(st.sets(st.sampled_from(alphabet.names), min_size=1)) for _ in range(n)]
    drawn = [draw(automata(alphabet.restrict(sorted(p)), max_states=max_states)) for p in parts]
    return [Automaton.empty(a.alphabet) if draw(st.integers(0, 9)) == 9 else a for a in drawn]


@st.composite
def nondeterministic(draw: st.DrawFn) -> ExtendedAutomaton:
    """Automata of up to 5 states with several initial states and choices."""
    alphabet = draw(alphabets(max_events=3))
    n = draw(st.integers(1, 5))
    state, event = st.integers(0, n - 1), st.integers(0, len(alphabet) - 1)
    edges = draw(st.lists(st.builds(Edge, state, event, state), max_size=10))
    truths = st.lists(st.booleans(), min_size=n, max_size=n)
    initial, marked = draw(truths.filter(any)), draw(truths)
    names = tuple(f"q{k}" for k in range(n))
    return ExtendedAutomaton("N", alphabet, names, tuple(initial), tuple(marked), tuple(edges))


def same(ours: Automaton, theirs: Automaton) -> None:
    """Both are equal up to state names, numbered alike, and ours is in the form that every operation promises."""
    assert_same_numbering(ours, theirs)
    assert ours.n_states == theirs.n_states
    again = Automaton.from_arrays(
        ours.alphabet, ours.offsets, ours.events, ours.targets, marked=ours.marked, initial=ours.initial
    )
    assert thenar.reachable(again).targets.tolist() == ours.targets.tolist(), "not numbered breadth-first"
    assert len({ours.states[q] for q in range(ours.n_states)}) == ours.n_states


def short(found: Iterable[tuple[str, ...]]) -> Strings:
    return {s for s in found if len(s) <= N}


def concatenated(first: Strings, second: Strings) -> Strings:
    return short((*s, *t) for s, t in product(first, second))


def closed(a: Automaton, n: int = N) -> Strings:
    return strings(a, n, marked=False)


def minimal(a: Automaton) -> Automaton:
    return thenar.minimize(thenar.trim(a))


def same_marked(a: Automaton, b: Automaton) -> None:
    """Lm is the same, over the union of the alphabets."""
    alphabet = a.alphabet | b.alphabet
    assert thenar.is_isomorphic(*(minimal(union(Automaton.empty(alphabet), x)) for x in (a, b)))


# -- each against its twin, and its definition on strings ----------------------------------------------------------


@quick
@given(several())
def test_the_union_has_the_strings_of_both(pair: list[Automaton]) -> None:
    a, b = pair
    both = union(a, b)
    same(both, regular_oracle.union(a, b))
    assert strings(both, N) == strings(a, N) | strings(b, N)
    assert closed(both) == closed(a) | closed(b)


@quick
@given(several())
def test_a_concatenation_has_a_string_of_the_first_then_one_of_the_second(pair: list[Automaton]) -> None:
    a, b = pair
    whole = concatenation(a, b)
    same(whole, regular_oracle.concatenation(a, b))
    assert strings(whole, N) == concatenated(strings(a, N), strings(b, N))
    assert closed(whole) == closed(a) | concatenated(strings(a, N), closed(b))


@quick
@given(automata(max_states=4, max_events=3))
def test_the_star_has_any_number_of_strings_one_after_the_other(a: Automaton) -> None:
    star = kleene_star(a)
    same(star, regular_oracle.kleene_star(a))
    powers: Strings = {()}
    while more := concatenated(powers, strings(a, N)) - powers:
        powers |= more
    assert strings(star, N) == powers
    assert closed(star) == powers | concatenated(powers, closed(a))


@quick
@given(automata())
def test_the_prefix_closure_has_the_prefixes_of_marked_strings(a: Automaton) -> None:
    prefixes = prefix_closure(a)
    same(prefixes, regular_oracle.prefix_closure(a))
    longer = N + a.n_states  # a string of L that can be completed can be by fewer events than there are states
    assert strings(prefixes, N) == closed(prefixes) == short(s[:k] for s in strings(a, longer) for k in range(N + 1))


@quick
@given(several())
def test_the_difference_has_what_only_the_first_marks_and_all_that_it_can_do(pair: list[Automaton]) -> None:
    a, b = pair
    rest = difference(a, b)
    same(rest, regular_oracle.difference(a, b))
    assert strings(rest, N) == strings(a, N) - strings(b, N)
    assert closed(rest) == closed(a)


@quick
@given(several(max_states=3))
def test_the_quotient_has_what_the_second_completes_to_a_string_of_the_first(pair: list[Automaton]) -> None:
    a, b = pair
    heads = quotient(a, b)
    same(heads, regular_oracle.quotient(a, b))
    enough = a.n_states * b.n_states  # states of the product: a shortest completion is shorter
    if N + enough <= 8:
        whole, tails = strings(a, 8), strings(b, enough)
        assert strings(heads, N) == {s for s in closed(a) if any((*s, *t) in whole for t in tails)}
    assert closed(heads) == (set() if b.is_empty else closed(a))


@quick
@given(several(max_states=3))
def test_the_left_quotient_has_what_is_left_of_the_first_after_a_string_of_the_second(pair: list[Automaton]) -> None:
    a, b = pair
    tails = left_quotient(a, b)
    same(tails, regular_oracle.left_quotient(a, b))
    enough = a.n_states * b.n_states
    if N + enough <= 8:
        begun = strings(b, enough)
        for marked in (True, False):
            whole = strings(a, 8, marked=marked)
            after = {s[k:] for s in whole for k in range(len(s) + 1) if s[:k] in begun}
            assert strings(tails, N, marked=marked) == short(after)


@quick
@given(automata())
def test_the_reverse_has_the_marked_strings_backwards(a: Automaton) -> None:
    backwards = reverse(a)
    same(backwards, regular_oracle.reverse(a))
    assert strings(backwards, N) == {s[::-1] for s in strings(a, N)}
    assert thenar.is_nonblocking(backwards)


@quick
@given(several())
def test_the_inverse_projection_has_the_strings_that_projection_takes_there(pair: list[Automaton]) -> None:
    a, b = pair
    lifted = inverse_project(a, b.alphabet)
    same(lifted, regular_oracle.inverse_project(a, b.alphabet))
    every = [s for n in range(N + 1) for s in product((a.alphabet | b.alphabet).names, repeat=n)]
    for marked in (True, False):
        known = strings(a, N, marked=marked)
        assert strings(lifted, N, marked=marked) == {
            s for s in every if tuple(e for e in s if e in a.alphabet) in known
        }


@quick
@given(nondeterministic(), st.data())
def test_determinising_keeps_the_strings_that_can_lead_there(a: ExtendedAutomaton, data: st.DataObject) -> None:
    silent = data.draw(st.sets(st.sampled_from(a.alphabet.names)))
    ours = determinise(a, silent)
    same(ours, regular_oracle.determinise(a, silent))
    assert [e for e in a.alphabet.names if e not in silent] == list(ours.alphabet.names)
    if not silent:
        longest: set[tuple[tuple[str, ...], int]] = {((), q) for q, first in enumerate(a.initial) if first}
        ways = longest
        for _ in range(N):
            longest = {((*s, a.alphabet[e.event].name), e.target) for s, q in longest for e in a.edges if e.source == q}
            ways = ways | longest
        assert closed(ours) == short(s for s, _ in ways)
        assert strings(ours, N) == short(s for s, q in ways if a.marked[q])


# -- laws ------------------------------------------------------------------------------------------------------------


@quick
@given(several(3))
def test_union_is_commutative_associative_and_idempotent(three: list[Automaton]) -> None:
    a, b, c = three
    whole = union(a, b, c)
    assert thenar.is_isomorphic(union(c, b, a), whole)
    assert oracle.same_languages(union(union(a, b), c), whole)
    assert oracle.same_languages(union(a, union(b, c)), whole)
    assert thenar.is_isomorphic(union(a, a), thenar.reachable(a))
    assert thenar.is_isomorphic(union(a), thenar.reachable(a))


@quick
@given(several(3, max_states=3))
def test_concatenation_is_associative_and_distributes_over_union(three: list[Automaton]) -> None:
    a, b, c = three
    whole = concatenation(a, b, c)
    for other in (concatenation(concatenation(a, b), c), concatenation(a, concatenation(b, c))):
        assert oracle.same_languages(other, whole)
    assert oracle.same_languages(concatenation(a, union(b, c)), union(concatenation(a, b), concatenation(a, c)))
    same_marked(concatenation(union(a, b), c), union(concatenation(a, c), concatenation(b, c)))


@quick
@given(several(max_states=3))
def test_conways_laws_of_the_star(pair: list[Automaton]) -> None:
    """(A ∪ B)* = (A* B)* A* and (A B)* = {ε} ∪ A (B A)* B.   [Conway 1971, chapter 3; C11 and C12]"""
    a, b = pair
    star = kleene_star
    same_marked(star(union(a, b)), concatenation(star(concatenation(star(a), b)), star(a)))
    epsilon = star(Automaton.empty(a.alphabet))
    turned = concatenation(a, star(concatenation(b, a)), b)
    same_marked(star(concatenation(a, b)), union(epsilon, turned))


@quick
@given(automata(max_states=4))
def test_the_star_of_the_star_is_the_star(a: Automaton) -> None:
    assert oracle.same_languages(kleene_star(kleene_star(a)), kleene_star(a))
    assert oracle.same_languages(concatenation(kleene_star(a), kleene_star(a)), kleene_star(a))


@quick
@given(several())
def test_de_morgan(pair: list[Automaton]) -> None:
    a, b = pair
    everything = Automaton.empty(a.alphabet | b.alphabet)
    wide_a, wide_b = union(a, everything), union(b, everything)
    neither = thenar.meet(thenar.complement(wide_a), thenar.complement(wide_b))
    same_marked(union(a, b), thenar.complement(neither))
    same_marked(difference(a, b), thenar.meet(wide_a, thenar.complement(wide_b)))


@quick
@given(several())
def test_the_synchronous_product_is_the_meet_of_the_inverse_projections(pair: list[Automaton]) -> None:
    """The definition of the product.   [Wonham and Cai 2019, sec. 3.3]"""
    a, b = pair
    assert thenar.is_isomorphic(
        thenar.sync(a, b), thenar.meet(inverse_project(a, b.alphabet), inverse_project(b, a.alphabet))
    )


@quick
@given(automata(), st.data())
def test_projection_undoes_inverse_projection_which_contains_what_was_projected(
    a: Automaton, data: st.DataObject
) -> None:
    lifted = inverse_project(a, ["new", "newer"])
    assert thenar.is_isomorphic(thenar.project(lifted, a.alphabet), thenar.reachable(a))
    kept = data.draw(st.sets(st.sampled_from(a.alphabet.names)))
    assert thenar.is_sublanguage(a, inverse_project(thenar.project(a, kept), a.alphabet))


@quick
@given(automata(max_states=6))
def test_brzozowski_reversing_twice_minimises(a: Automaton) -> None:
    """[Brzozowski 1962] Reverse and determinise, twice: the minimal automaton, without minimising anything."""
    assert thenar.is_isomorphic(reverse(reverse(a)), thenar.minimize(thenar.trim(a)))
    assert thenar.minimize(reverse(a)).n_states == reverse(a).n_states


@quick
@given(several())
def test_reversing_turns_a_concatenation_and_the_quotients_round(pair: list[Automaton]) -> None:
    a, b = pair
    same_marked(reverse(concatenation(a, b)), concatenation(reverse(b), reverse(a)))
    same_marked(reverse(left_quotient(a, b)), quotient(reverse(a), reverse(b)))


@quick
@given(several())
def test_a_quotient_of_a_concatenation_contains_what_it_was_made_of(pair: list[Automaton]) -> None:
    a, b = pair
    whole = concatenation(a, b)
    if not thenar.trim(b).is_empty:
        assert strings(a, N) <= strings(quotient(whole, b), N)
    if not thenar.trim(a).is_empty:
        assert strings(b, N) <= strings(left_quotient(whole, a), N)


@quick
@given(automata(), st.data())
def test_the_left_quotient_by_one_string_is_the_automaton_begun_in_another_state(
    a: Automaton, data: st.DataObject
) -> None:
    trace = data.draw(st.sampled_from(sorted(closed(a, 3))))
    path = [(str(k), e, str(k + 1)) for k, e in enumerate(trace)]
    one = Automaton.from_transitions(path, initial="0", marked=[str(len(trace))], events=a.alphabet)
    state = a.run(trace)[-1]
    begun = Automaton.from_arrays(a.alphabet, a.offsets, a.events, a.targets, marked=a.marked, initial=state)
    assert thenar.is_isomorphic(left_quotient(a, one), thenar.reachable(begun))


@quick
@given(automata())
def test_the_prefix_closure_is_the_quotient_by_everything(a: Automaton) -> None:
    everything = thenar.complement(Automaton.empty(a.alphabet))
    same_marked(prefix_closure(a), quotient(a, everything))
    assert thenar.is_isomorphic(prefix_closure(prefix_closure(a)), prefix_closure(a))
    assert bool(thenar.is_nonblocking(a)) == (closed(prefix_closure(a), 5) == closed(a, 5))


@quick
@given(automata())
def test_determinising_a_deterministic_automaton_is_its_reachable_part_and_with_silence_the_projection(
    a: Automaton,
) -> None:
    extended = ExtendedAutomaton.from_automaton(a)
    found = determinise(extended)
    assert thenar.is_isomorphic(found, thenar.reachable(a))
    assert [found.states[q] for q in range(found.n_states)] == [
        thenar.reachable(a).states[q] for q in range(found.n_states)
    ]
    hidden = a.alphabet.names[::2]
    assert thenar.is_isomorphic(determinise(extended, hidden), thenar.project(a, set(a.alphabet.names) - set(hidden)))


# -- answers from the literature ---------------------------------------------------------------------------------


@pytest.mark.parametrize("n", range(1, 9))
def test_the_nth_event_from_the_end_takes_exponentially_many_states(n: int) -> None:
    """Σ* a Σⁿ⁻¹ has n + 1 states backwards and 2ⁿ forwards.   [Meyer and Fischer 1971]"""
    rows = ["0 -a,b-> 0", "0 -a-> 1", *(f"{k} -a,b-> {k + 1}" for k in range(1, n))]
    nth = determinise(ExtendedAutomaton.from_edges("NTH", rows, initial="0", marked=[str(n)]))
    assert nth.n_states == thenar.minimize(nth).n_states == 2**n
    assert thenar.minimize(reverse(nth)).n_states == n + 1


@pytest.mark.parametrize(("m", "n"), [(2, 3), (3, 3), (2, 4), (3, 4), (4, 5)])
def test_state_complexities_of_yu_zhuang_and_salomaa(m: int, n: int) -> None:
    """Union mn, concatenation m2ⁿ - 2ⁿ⁻¹ (one marked state in the first), star 2ⁿ⁻¹ + 2ⁿ⁻²: complete automata
    need so many states, and no more.   [Yu, Zhuang and Salomaa, The state complexities of some basic operations on
    regular languages, Theoretical Computer Science 125, 1994]
    """
    first_ring, second_ring = range(m), range(n)
    a_mod_m = Automaton.from_transitions(
        [*(f"{k} -a-> {(k + 1) % m}" for k in first_ring), *(f"{k} -b-> {k}" for k in first_ring)],
        initial="0",
        marked=["0"],
    )
    b_mod_n = Automaton.from_transitions(
        [*(f"{k} -b-> {(k + 1) % n}" for k in second_ring), *(f"{k} -a-> {k}" for k in second_ring)],
        initial="0",
        marked=["0"],
        events=a_mod_m.alphabet,
    )
    assert thenar.minimize(union(a_mod_m, b_mod_n)).n_states == m * n
    first = Automaton.from_transitions(
        [
            *(f"{k} -a-> {(k + 1) % m}" for k in first_ring),
            *(f"{k} -b-> 0" for k in first_ring),
            *(f"{k} -c-> {k}" for k in first_ring),
        ],
        initial="0",
        marked=[str(m - 1)],
    )
    second = Automaton.from_transitions(
        [
            *(f"{k} -b-> {(k + 1) % n}" for k in second_ring),
            *(f"{k} -a-> {k}" for k in second_ring),
            *(f"{k} -c-> 1" for k in second_ring),
        ],
        initial="0",
        marked=[str(n - 1)],
        events=first.alphabet,
    )
    assert thenar.minimize(concatenation(first, second)).n_states == m * 2**n - 2 ** (n - 1)
    counter = Automaton.from_transitions(
        [
            *(f"{k} -a-> {(k + 1) % n}" for k in second_ring),
            "0 -b-> 0",
            *(f"{k} -b-> {(k + 1) % n}" for k in range(1, n)),
        ],
        initial="0",
        marked=[str(n - 1)],
    )
    assert thenar.minimize(kleene_star(counter)).n_states == 2 ** (n - 1) + 2 ** (n - 2)


# -- edges -------------------------------------------------------------------------------------------------------------


def test_automata_without_states_and_without_marks() -> None:
    a = Automaton.from_transitions(["0 -x-> 1 -y-> 0"], initial="0", marked=["1"], name="A")
    none, unmarked = (
        Automaton.empty(a.alphabet),
        Automaton.from_transitions(["0 -x-> 1"], initial="0", events=a.alphabet),
    )
    assert thenar.is_isomorphic(union(a, none), a)
    assert union(none, none).is_empty
    assert concatenation(none, a).is_empty
    assert not concatenation(a, none).marked.any()
    assert closed(concatenation(a, none)) == closed(a)
    assert closed(kleene_star(none)) == strings(kleene_star(none), N) == {()}
    assert strings(kleene_star(unmarked), N) == {()}
    assert closed(kleene_star(unmarked)) == {(), ("x",)}
    assert prefix_closure(unmarked).is_empty
    assert prefix_closure(none).is_empty
    assert thenar.is_isomorphic(difference(a, none), a)
    assert difference(none, a).is_empty
    assert quotient(none, a).is_empty
    assert quotient(a, none).is_empty
    assert not quotient(a, unmarked).marked.any()
    assert left_quotient(a, unmarked).is_empty
    assert left_quotient(none, a).is_empty
    assert reverse(unmarked).is_empty
    assert inverse_project(none, ["z"]).is_empty


def test_an_alphabet_without_events() -> None:
    one = Automaton.from_transitions([], initial="0", marked=["0"])
    for result in (union(one, one), concatenation(one, one), kleene_star(one), reverse(one), quotient(one, one)):
        assert (result.n_states, result.n_transitions, result.marks("")) == (1, 0, True)
    assert not difference(one, one).marks("")


def test_events_that_only_the_divisor_knows_are_in_no_string_of_the_dividend() -> None:
    a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"])
    b = Automaton.from_transitions(["0 -x-> 1", "0 -z-> 1"], initial="0", marked=["1"])
    assert quotient(a, b).alphabet == left_quotient(a, b).alphabet == a.alphabet
    assert strings(quotient(a, b), N) == strings(left_quotient(a, b), N) == {()}


def test_the_first_set_of_states_may_come_again() -> None:
    """Begun in 1 or 2; x leads to just these again, and so it is a loop."""
    twice = ExtendedAutomaton.from_edges("T", ["1 -x-> 2", "2 -x-> 1"], initial=["1", "2"])
    assert list(determinise(twice).transitions()) == [("{1, 2}", "x", "{1, 2}")]


def test_states_are_called_after_their_automata_or_their_places() -> None:
    rows = ["0 -x-> 1"]
    a, b, nameless = (Automaton.from_transitions(rows, initial="0", name=name) for name in ("A", "B", ""))
    assert union(a, b).states[0] == "{A.0, B.0}"
    assert union(a, a).states[0] == union(a, nameless).states[0] == "{1.0, 2.0}"
    dotted = Automaton.from_transitions(rows, initial="0", name="A.0")
    assert union(a, dotted).states[1] == "{1.1, 2.1}"
    assert (union(a, b).name, concatenation(a, b).name, kleene_star(a).name) == ("A∪B", "A·B", "A*")
    assert (quotient(a, b).name, left_quotient(a, b).name, difference(a, b).name) == ("A/B", "B\\A", "A∖B")
    assert (union(a, nameless).name, union(a, nameless, name="both").name) == ("", "both")
    start = Automaton.from_transitions(["start -x-> 1"], initial="start", marked=["1"])
    assert kleene_star(start).states[0] == "{start, start'}"


def test_guards_and_updates_are_refused_all_at_once() -> None:
    guarded = ExtendedAutomaton.from_edges(
        "CUP", [("0", "x", "1", "n < 3", {"n": "n + 1"}), "1 -y-> 0", ("1", "x", "0", "n > 0")], initial="0"
    )
    with pytest.raises(thenar.InputError) as refused:
        determinise(guarded)
    lines = str(refused.value).splitlines()
    assert [line.split(";")[0] for line in lines] == [
        "determinise: edge 1 (0 -x-> 1) of 'CUP': it has a guard",
        "determinise: edge 1 (0 -x-> 1) of 'CUP': it has updates",
        "determinise: edge 3 (1 -x-> 0) of 'CUP': it has a guard",
    ]


def test_sets_of_states_that_would_have_one_name_are_told_apart() -> None:
    rows = [
        ("0", "a", "x"),
        ("0", "a", "y"),
        ("0", "b", "{x, y}"),
        ("x", "b", "x, y"),
        ("y", "b", "z"),
        ("z", "b", "'x"),
    ]
    odd = determinise(ExtendedAutomaton.from_edges("ODD", rows, initial="0"))
    assert [odd.states[q] for q in range(odd.n_states)] == ["0", "{x, y}", "'{x, y}'", "{'x, y', z}", "'''x'"]
    even = determinise(ExtendedAutomaton.from_edges("EVEN", [*rows[:2], ("0", "b", "x, y")], initial="0"))
    assert [even.states[q] for q in range(even.n_states)] == ["0", "{x, y}", "x, y"]


def test_a_difference_takes_no_row_for_what_is_never_met() -> None:
    """To complete the second one would take 10^5 rows of 10^3 events each."""
    n, alphabet = 100_000, Alphabet([f"e{k}" for k in range(1000)])
    offsets = np.minimum(np.arange(n + 1), n - 1)
    chain = Automaton.from_arrays(
        alphabet, offsets, np.zeros(n - 1, np.int64), np.arange(1, n), marked=np.arange(n) == n - 1
    )
    other = Automaton.from_arrays(alphabet, [0, 1], [1], [0], marked=[True])
    tracemalloc.start()
    rest = difference(other, chain)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert thenar.is_isomorphic(thenar.minimize(rest), other)
    assert peak < 1e8


def test_pairs_of_a_difference_are_named_as_in_products() -> None:
    a = Automaton.from_transitions(["0 -x-> 1 -y-> 2"], initial="0", marked=["2"])
    b = Automaton.from_transitions(["p -x-> dump"], initial="p", marked=["p"])
    rest = difference(a, b)
    assert [rest.states[q] for q in range(rest.n_states)] == ["0|p", "1|dump", "2|dump'"]
    assert (rest.name, rest.state("2|dump'")) == ("", 2)


def test_wrong_input_is_named() -> None:
    a = Automaton.from_transitions(["0 -x-> 1"], initial="0", name="A")
    slip = Automaton.from_transitions(["0 -x-> 1"], initial="0", uncontrollable=["x"], name="B")
    for operation in (union, concatenation):
        with pytest.raises(thenar.InputError, match=f"{operation.__name__}: give at least one automaton"):
            operation()
        with pytest.raises(
            thenar.InputError, match=rf"{operation.__name__} takes automata, not list: give them one by one"
        ):
            operation([a, a])  # type: ignore[arg-type]
        with pytest.raises(thenar.InputError, match=rf"{operation.__name__} takes automata, not int$"):
            operation(a, 3)  # type: ignore[arg-type]
    with pytest.raises(thenar.InputError, match="determinise: automaton 'A' is an Automaton, which is deterministic"):
        determinise(a)  # type: ignore[arg-type]
    for binary in (union, concatenation, difference, quotient, left_quotient):
        with pytest.raises(thenar.AlphabetClash, match="event 'x' is controllable in 'A' and uncontrollable in 'B'"):
            binary(a, slip)
    with pytest.raises(thenar.AlphabetClash):
        inverse_project(a, Alphabet([Event("x", controllable=False)]))
    with pytest.raises(thenar.InputError, match="inverse_project: events is a list, not the text 'xy'"):
        inverse_project(a, "xy")
    with pytest.raises(thenar.UnknownName, match="unknown event 'tau'"):
        determinise(ExtendedAutomaton.from_automaton(a), silent=["tau"])
    with pytest.raises(thenar.InputError, match="silent is a list of events, not the text 'x'"):
        determinise(ExtendedAutomaton.from_automaton(a), silent="x")


def test_limits_hold() -> None:
    rows = ["0 -a,b-> 0", "0 -a-> 1", *(f"{k} -a,b-> {k + 1}" for k in range(1, 30))]
    with pytest.raises(thenar.LimitReached, match="1,000 states"):
        determinise(ExtendedAutomaton.from_edges("NTH", rows, initial="0", marked=["30"]), limits=thenar.Limits(1000))
    steps = Automaton.from_transitions([f"{k} -a,b-> {k + 1}" for k in range(30)], initial="0", marked=["30"])
    anything = Automaton.from_transitions(["0 -a,b-> 0"], initial="0", marked=["0"])
    few = thenar.Limits(states=10)
    for binary in (union, concatenation, difference, quotient):
        with pytest.raises(thenar.LimitReached):
            binary(steps, steps, limits=few)
    for unary in (kleene_star, reverse):
        with pytest.raises(thenar.LimitReached):
            unary(steps, limits=few)
    with pytest.raises(thenar.LimitReached):
        left_quotient(steps, anything, limits=few)


def test_larger_automata_agree_with_the_twins() -> None:
    for seed in range(20):
        rng = Random(seed)
        alphabet = Alphabet(["a", "b"])
        a, b = (thenar.testing.random_automaton(rng, alphabet, max_states=12) for _ in range(2))
        same(union(a, b), regular_oracle.union(a, b))
        same(difference(a, b), regular_oracle.difference(a, b))
        same(quotient(a, b), regular_oracle.quotient(a, b))
