"""Timed transition graphs: the definition, theorems on time, and what the literature says of its examples."""

from __future__ import annotations

import time
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import thenar
from thenar.explicit.timed import TICK, is_activity_loop_free, timed
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.testing import timed_oracle
from thenar.testing.random_models import random_alphabet, random_automaton
from thenar.testing.strategies import automata

Bounds = dict[str, tuple[int, int | None]]
quick = settings(max_examples=100, deadline=None)


def random_bounds(rng: Random, alphabet: Alphabet, most: int = 4) -> Bounds:
    """Bounds of two events in three."""
    bounds: Bounds = {}
    for e in alphabet.names:
        if rng.randrange(3):
            lower = rng.randrange(most)
            bounds[e] = lower, rng.choice([None, lower + rng.randrange(3)])
    return bounds


def drawn(seed: int, max_events: int = 4) -> tuple[Automaton, Bounds]:
    rng = Random(seed)
    alphabet = random_alphabet(rng, max_events=max_events)
    return random_automaton(rng, alphabet), random_bounds(rng, alphabet)


def machine(k: int, first: int, second: int) -> Automaton:
    """A machine of the timed manufacturing cell: two sorts of work, each begun after a tick, done in a fixed time."""
    activities = Automaton.from_transitions(
        [f"idle -start_{k}1-> work_1 -finish_{k}1-> idle", f"idle -start_{k}2-> work_2 -finish_{k}2-> idle"],
        initial="idle",
        marked=["idle"],
        uncontrollable=[f"finish_{k}1", f"finish_{k}2"],
        name=f"MACH{k}",
    )
    bounds: Bounds = {
        f"start_{k}1": (1, None),
        f"finish_{k}1": (first, first),
        f"start_{k}2": (1, None),
        f"finish_{k}2": (second, second),
    }
    return timed(activities, bounds)


# -- against the definition ------------------------------------------------------------------------------------


def test_a_timed_graph_is_the_oracles_state_by_state() -> None:
    for seed in range(1000):
        activities, bounds = drawn(seed)
        ours, slow = timed(activities, bounds), timed_oracle.timed(activities, bounds)
        assert ours.alphabet == slow.alphabet
        for name in ("offsets", "events", "targets", "marked"):
            assert np.array_equal(getattr(ours, name), getattr(slow, name)), (seed, name)
        assert bool(is_activity_loop_free(ours)) == timed_oracle.is_activity_loop_free(ours), seed


@quick
@given(automata(), st.integers(0, 1 << 30))
def test_without_the_ticks_nothing_happens_that_the_activities_do_not_do(a: Automaton, seed: int) -> None:
    graph = timed(a, random_bounds(Random(seed), a.alphabet))
    untimed = thenar.project(graph, a.alphabet.names)
    assert thenar.is_sublanguage(untimed, a)


@quick
@given(automata())
def test_without_bounds_all_that_the_activities_do_can_be_done_at_any_time(a: Automaton) -> None:
    assert thenar.is_isomorphic(timed(a, {}), thenar.sync(Automaton.from_transitions(
        [("0", "tick", "0")], initial="0", marked=["0"], events=[TICK]), a))  # fmt: skip


def test_activities_that_share_no_event_can_be_timed_before_or_after_their_product() -> None:
    for seed in range(200):
        (a, in_a), (b, in_b) = drawn(seed, 2), drawn(seed + 1000, 2)
        names = {e: e + "'" for e in b.alphabet.names}
        b = Automaton.from_transitions(
            [(s, names[e], t) for s, e, t in b.transitions()],
            initial=b.states[b.initial],
            marked=[b.states[q] for q in range(b.n_states) if b.marked[q]],
            states=[b.states[q] for q in range(b.n_states)],
            events=[Event(names[e.name], e.controllable) for e in b.alphabet],
            alphabet=names.values(),
        )
        in_b = {names[e]: window for e, window in in_b.items()}
        after = timed(thenar.sync(a, b), {**in_a, **in_b})
        assert thenar.is_isomorphic(thenar.sync(timed(a, in_a), timed(b, in_b)), after), seed


# -- theorems on time ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("lower", "upper"), [(0, 0), (0, 3), (2, 2), (1, 4), (3, None), (0, None)])
def test_an_event_comes_between_its_bounds_and_time_does_not_pass_it(lower: int, upper: int | None) -> None:
    door = Automaton.from_transitions(["closed -open-> open"], initial="closed", marked=["open"])
    graph = timed(door, {"open": (lower, upper)})
    for ticks in range(6):
        waited = ["tick"] * ticks
        assert graph.generates(waited) is (upper is None or ticks <= upper)
        assert graph.generates([*waited, "open"]) is (lower <= ticks and (upper is None or ticks <= upper))


def test_a_timer_begins_anew_when_its_event_was_impossible_and_goes_on_otherwise() -> None:
    a = Automaton.from_transitions(
        ["on -alarm-> on", "on -switch-> off -switch-> on", "on -touch-> on"], initial="on", marked=["on"]
    )
    graph = timed(a, {"alarm": (2, None)})
    assert graph.generates("tick, touch, tick, alarm")
    assert not graph.generates("tick, switch, switch, tick, alarm")
    assert graph.generates("tick, switch, tick, switch, tick, tick, alarm, tick, tick, alarm")
    assert not graph.generates("tick, tick, alarm, tick, alarm")


def test_an_event_that_is_due_waits_only_if_another_makes_it_impossible() -> None:
    a = Automaton.from_transitions(["0 -boil-> 1", "0 -off-> 2"], initial="0", marked=["1", "2"])
    graph = timed(a, {"boil": (0, 1)})
    assert not graph.generates("tick, tick")
    assert graph.generates("tick, off, tick, tick")


@quick
@given(st.integers(0, 1 << 30))
def test_a_state_without_tick_has_an_event_that_is_due(seed: int) -> None:
    """Time never stops by itself: where it does, some prospective event may and must happen."""
    activities, bounds = drawn(seed)
    graph = timed(activities, bounds)
    for q in range(graph.n_states):
        if graph.step(q, "tick") is None:
            assert any(bounds.get(e.name, (0, None))[1] is not None for e in graph.enabled(q))


def test_the_witness_of_an_activity_loop_goes_round_it_without_a_tick() -> None:
    for seed in range(300):
        graph = timed(*drawn(seed))
        check = is_activity_loop_free(graph)
        if not check:
            assert check.witness is not None
            states = graph.run(check.witness)
            assert len(states) == len(check.witness) + 1
            first = states.index(states[-1])
            assert first < len(states) - 1
            assert "tick" not in check.witness[first:]


# -- the literature --------------------------------------------------------------------------------------------


def test_the_bus_of_the_endangered_pedestrian_passes_at_the_second_tick() -> None:
    """Brandin and Wonham 1994, and Wonham and Cai 2019, ch. 9: pass with bounds (2, 2), jump with (1, infinity)."""
    bus = timed(
        Automaton.from_transitions(["a -pass-> g"], initial="a", marked=["a", "g"], uncontrollable=["pass"]),
        {"pass": (2, 2)},
    )
    man = timed(Automaton.from_transitions(["r -jump-> c"], initial="r", marked=["r", "c"]), {"jump": (1, None)})
    both = thenar.sync(bus, man)
    assert thenar.is_isomorphic(
        both,
        Automaton.from_transitions(
            [
                "0 -tick-> 1 -tick-> 2 -pass-> run_over -tick-> run_over -jump-> late -tick-> late",
                "1 -jump-> jumped_1 -tick-> jumped_2 -pass-> late",
                "2 -jump-> jumped_2",
            ],
            initial="0",
            marked=["0", "1", "2", "run_over", "late", "jumped_1", "jumped_2"],
            events=both.alphabet,
        ),
    )


def test_the_machines_of_the_timed_manufacturing_cell_keep_their_times() -> None:
    """Brandin and Wonham 1994: machine 1 takes 3 and 2 ticks for its two sorts of work, machine 2 takes 1 and 4."""
    one, two = machine(1, 3, 2), machine(2, 1, 4)
    assert (one.n_states, two.n_states) == (9, 9)  # idle with and without its tick, then a state for each tick of work
    cell = thenar.sync(one, two)
    assert is_activity_loop_free(cell)
    assert thenar.is_nonblocking(cell)
    assert cell.generates("tick, start_11, start_22, tick, tick, tick, finish_11, tick, finish_22")
    assert not cell.generates("tick, start_11, start_22, tick, tick, tick, tick")


# -- the door --------------------------------------------------------------------------------------------------


def test_mistakes_in_the_bounds_are_told_all_at_once() -> None:
    a = Automaton.from_transitions(["0 -work-> 0"], initial="0", name="A")
    bounds: Bounds = {"wrok": (1, 2), "work": (3, 2)}
    with pytest.raises(thenar.ModelError) as error:
        timed(a, bounds)
    assert "unknown event 'wrok'; did you mean 'work'?" in str(error.value)
    assert "time bounds (3, 2) of event 'work': a pair of whole numbers of ticks, 0 <= lower <= upper" in str(
        error.value
    )


@pytest.mark.parametrize("window", [(1,), (-1, 2), (1.0, 2), (True, 2), ("1", None), None, 3])
def test_what_is_no_pair_of_bounds_is_refused(window: object) -> None:
    a = Automaton.from_transitions(["0 -work-> 0"], initial="0")
    with pytest.raises(thenar.ModelError, match=r"time bounds .* of event 'work'"):
        timed(a, {"work": window})  # type: ignore[dict-item]


def test_activities_with_a_clock_of_their_own_are_refused() -> None:
    with pytest.raises(thenar.ModelError, match="has an event 'tick' already"):
        timed(Automaton.from_transitions(["0 -tick-> 0"], initial="0"), {})


def test_no_states_stay_none_and_limits_are_kept() -> None:
    assert timed(Automaton.empty(Alphabet(["a"])), {"a": (1, 2)}).is_empty
    a = Automaton.from_transitions(["0 -work-> 0"], initial="0")
    with pytest.raises(thenar.LimitReached):
        timed(a, {"work": (5000, None)}, limits=thenar.Limits(states=1000))


@pytest.mark.parametrize("limits", [thenar.Limits(states=1000), thenar.Limits(seconds=0.1)])
def test_limits_end_the_counting_of_a_long_timer_too(limits: thenar.Limits) -> None:
    a = Automaton.from_transitions(["0 -x-> 1", "0 -y-> 2 -z-> 0"], initial="0", marked=["1"])
    begin = time.process_time()
    with pytest.raises(thenar.LimitReached):
        timed(a, {"x": (0, 10**7)}, limits=limits)
    assert time.process_time() - begin < 2  # s; the whole of it takes longer


def test_bounds_may_be_numpys_numbers() -> None:
    a = Automaton.from_transitions(["0 -work-> 0"], initial="0", marked=["0"])
    one, two = np.int64(1), np.int64(2)
    assert list(timed(a, {"work": (one, two)}).transitions()) == list(timed(a, {"work": (1, 2)}).transitions())


def test_the_labels_of_many_classes_and_many_events_stay_apart() -> None:
    """Events times classes are more than an int32 holds; 'next' is always due, so that the clock never ticks."""
    m, idle = 15, 1 << 16
    n = 1 << m  # activities that differ in which of m events are possible; each of these leads to the one without any
    events = [*(f"t{k}" for k in range(m)), *(f"idle_{k}" for k in range(idle)), "next"]
    rows = [[*(k for k in range(m) if q >> k & 1), m + idle] for q in range(n)]
    a = Automaton.from_arrays(
        Alphabet(events),
        np.cumsum([0, *map(len, rows)]),
        [e for row in rows for e in row],
        [(q + 1) % n if e == m + idle else 0 for q, row in enumerate(rows) for e in row],
        marked=[True] * n,
    )
    graph = timed(a, {"next": (0, 0)} | {f"t{k}": (0, 1) for k in range(m)})
    assert graph.n_states == n
    assert np.array_equal(np.bincount(graph.events), np.bincount(a.events + 1))


def test_a_long_chain_is_searched_for_loops_in_linear_time() -> None:
    n = 60_000
    chain = Automaton.from_arrays(Alphabet(["a"]), [*range(n), n - 1], [0] * (n - 1), range(1, n), marked=[True] * n)
    begin = time.process_time()
    assert is_activity_loop_free(chain)
    assert time.process_time() - begin < 8  # s; ten times what it takes
