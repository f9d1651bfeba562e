"""What may follow a string, how many strings there are, and that each is drawn as often as any other."""

from collections import Counter
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import thenar
from thenar.explicit.strings import count_strings, enabled_after, sample
from thenar.model.automaton import Automaton
from thenar.testing.regular_oracle import strings
from thenar.testing.strategies import automata

quick = settings(max_examples=100, deadline=None)


class Given:
    """A source of chance that says what it is told, and keeps what it was asked."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.asked: list[int] = []

    def randrange(self, stop: int, /) -> int:
        self.asked.append(stop)
        return self.number


@quick
@given(automata(max_states=4, max_events=3), st.integers(0, 4), st.booleans())
def test_each_number_draws_another_string_and_all_strings_are_drawn(a: Automaton, length: int, marked: bool) -> None:
    """Numbers 0 .. n - 1, n the number of strings, give each string once: so what is drawn is exactly uniform."""
    every = strings(a, length, marked=marked)
    assert count_strings(a, length, marked=marked) == len(every)
    drawn = []
    for number in range(len(every)):
        chance = Given(number)
        drawn += [tuple(s) for s in sample(a, length, chance, marked=marked)]
        assert chance.asked == [len(every)]
    assert len(drawn) == len(every)
    assert set(drawn) == every
    if not every:
        with pytest.raises(thenar.InputError, match=r"has no (marked )?string of at most"):
            sample(a, length, Given(0), marked=marked)


@quick
@given(automata(), st.data())
def test_what_is_enabled_after_a_trace_continues_it(a: Automaton, data: st.DataObject) -> None:
    trace = data.draw(st.sampled_from(sorted(strings(a, 3, marked=False))))
    enabled = enabled_after(a, trace)
    assert [e.name for e in enabled] == [e for e in a.alphabet.names if a.generates((*trace, e))]
    for event in a.alphabet:
        if event not in enabled:
            after = thenar.Trace(trace)
            with pytest.raises(thenar.InputError) as refused:
                enabled_after(a, (*trace, event.name, event.name))
            assert f"cannot do {event.name!r} after {after}, in state {a.states[a.run(trace)[-1]]!r}" in str(
                refused.value
            )


@quick
@given(automata())
def test_the_shortest_trace_to_a_state_leads_there_and_none_is_shorter(a: Automaton) -> None:
    found = strings(a, 5, marked=False)
    for q in range(a.n_states):
        lengths = sorted(len(s) for s in found if a.run(s)[-1] == q)
        for to in (q, a.states[q]):
            trace = thenar.shortest_trace(a, to)
            if trace is None:
                assert not lengths
            else:
                assert a.run(trace)[-1] == q
                assert len(trace) == lengths[0]


def test_strings_are_counted_beyond_all_machine_words() -> None:
    """Bit strings without two ones in a row are counted by the Fibonacci numbers.   [OEIS A000045]"""
    bits = Automaton.from_transitions(["0 -zero-> 0", "0 -one-> 1 -zero-> 0"], initial="0", marked=["0", "1"])
    fibonacci = [1, 2]
    while len(fibonacci) <= 500:
        fibonacci.append(fibonacci[-1] + fibonacci[-2])
    assert count_strings(bits, 500) == sum(fibonacci[:501])
    assert sum(fibonacci[:501]) > 2**63
    (long,) = sample(bits, 500, Random(1))
    assert bits.marks(long)
    assert len(long) > 450  # one of 3e10 strings has 450 events or fewer: 1.618 ** 50


def test_what_is_drawn_looks_uniform() -> None:
    """Where random_trace would draw 'b' half of the time, each string comes as often as any other."""
    a = Automaton.from_transitions(["0 -a-> 1 -a,b,c-> 2", "0 -b-> 2"], initial="0", marked=["2"])
    drawn = Counter(str(s) for s in sample(a, 2, Random(3), 4000))
    assert sorted(drawn) == ["a, a", "a, b", "a, c", "b"]
    # chi-squared with 3 degrees of freedom: above 16.3 in one of 1,000 runs, and the seed is fixed
    assert sum((n - 1000) ** 2 / 1000 for n in drawn.values()) < 16.3


def test_the_same_seed_draws_the_same_strings() -> None:
    a = Automaton.from_transitions(["0 -a,b-> 0"], initial="0", marked=["0"])
    assert sample(a, 30, Random(5), 4) == sample(a, 30, Random(5), 4)
    assert len(sample(a, 30, Random(5), 0)) == 0


def test_dead_ends_unreachable_states_and_no_states() -> None:
    a = Automaton.from_transitions(["0 -x-> dead", "lost -x-> lost"], initial="0", marked=["dead"], name="A")
    assert [count_strings(a, n) for n in (0, 1, 9)] == [0, 1, 1]
    assert [count_strings(a, n, marked=False) for n in (0, 1, 9)] == [1, 2, 2]
    with pytest.raises(thenar.InputError, match="'A' has no marked string of at most 0 events to draw; allow longer"):
        sample(a, 0, Random(0))
    none = Automaton.empty(a.alphabet)
    assert count_strings(none, 3) == 0
    with pytest.raises(thenar.InputError, match="the automaton has no string of at most 1 event to draw; its language"):
        sample(none, 1, Random(0), marked=False)
    with pytest.raises(
        thenar.InputError, match="the automaton has no states: no trace is possible, not even the empty"
    ):
        enabled_after(none, "")


def test_wrong_input_is_named() -> None:
    a = Automaton.from_transitions(["0 -x-> 1"], initial="0", name="A")
    with pytest.raises(thenar.UnknownName, match="unknown event 'xx'"):
        enabled_after(a, "x, xx")
    with pytest.raises(thenar.InputError, match="'A' cannot do 'x' after x, in state '1': nothing is possible there"):
        enabled_after(a, "x, x")
    with pytest.raises(thenar.InputError, match="a length of -1: a string has at least 0 events"):
        count_strings(a, -1)


def test_a_limit_of_time_holds() -> None:
    n = 200_000
    ring = Automaton.from_arrays(
        thenar.Alphabet(["x"]), np.arange(n + 1), [0] * n, (np.arange(n) + 1) % n, marked=[True] * n
    )
    with pytest.raises(thenar.LimitReached, match="seconds"):
        count_strings(ring, 1_000_000, limits=thenar.Limits(seconds=0.2))
