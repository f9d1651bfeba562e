"""Forcing: the supremal forcibly controllable sublanguage against its definition, all others, and libFAUDES."""

from __future__ import annotations

import pickle
from collections.abc import Collection
from random import Random

import numpy as np
import pytest
from tests.explicit.test_timed import random_bounds
from tests.oracles import libfaudes_timed, tct_timed

import thenar
from thenar.explicit.forcing import ForcingSupervisor, is_forcibly_controllable, supcon_forcing
from thenar.explicit.rows import kept
from thenar.explicit.timed import TICK, timed
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.testing import timed_oracle
from thenar.testing.random_models import PLANT, Shape, random_alphabet, random_automaton

# specifications that forbid uncontrollable events often enough for forcing to matter
STRICT = Shape(controllable=60, uncontrollable=55, at_first=70, onward=90, marked=85)

Drawn = tuple[list[Automaton], list[Automaton], list[str] | None]


def some(rng: Random, alphabet: Alphabet) -> Alphabet:
    return Alphabet([e for e in alphabet if rng.random() < 0.6] or [alphabet[0]])


def untimed(seed: int, max_states: int = 4, max_events: int = 6) -> Drawn:
    """Plants, specifications, and the events that are preempted, None for all."""
    rng = Random(seed)
    alphabet = Alphabet(
        Event(e.name, e.controllable, forcible=rng.random() < 0.4) for e in random_alphabet(rng, max_events=max_events)
    )
    plants = [
        random_automaton(rng, some(rng, alphabet), max_states=max_states, shape=PLANT, name=f"G{k}")
        for k in range(rng.randint(1, 2))
    ]
    specs = [
        random_automaton(rng, some(rng, alphabet), max_states=max_states, shape=STRICT, name=f"E{k}")
        for k in range(rng.randint(1, 2))
    ]
    there = {e for a in (*plants, *specs) for e in a.alphabet.names}
    preempted = [e for e in alphabet.names if e in there and rng.random() < 0.6]
    return plants, specs, None if rng.random() < 0.3 else preempted


def with_clock(seed: int) -> Drawn:
    """The same of two timed plants, and a specification that says something of time."""
    rng = Random(seed)
    plants = []
    for k in range(2):
        alphabet = Alphabet(
            Event(f"{e.name}_{k}", e.controllable, forcible=rng.random() < 0.5)
            for e in random_alphabet(rng, max_events=3)
        )
        activities = random_automaton(rng, alphabet, max_states=3, name=f"G{k}")
        plants.append(timed(activities, random_bounds(rng, alphabet, 3)))
    events = Alphabet([TICK, *(e for g in plants for e in g.alphabet[1:])])
    spec = random_automaton(rng, Alphabet([TICK, *some(rng, events[1:])]), max_states=4, shape=STRICT, name="E")
    return plants, [spec], ["tick"]


CASES = [untimed(seed) for seed in range(1000)] + [with_clock(seed) for seed in range(500)]


def forced(supervisor: ForcingSupervisor) -> list[list[str]]:
    states = np.flatnonzero(supervisor.forcing).tolist()
    return sorted(sorted(e.name for e in supervisor.forced(x)) for x in states)


# -- against the definition ------------------------------------------------------------------------------------


def test_supcon_forcing_is_the_oracles_and_forces_the_same() -> None:
    met: set[tuple[bool, bool, bool]] = set()
    for plants, specs, preempted in CASES:
        ours = supcon_forcing(plants, specs, preempted=preempted)
        slow, must = timed_oracle.supcon_forcing(plants, specs, preempted)
        assert thenar.is_isomorphic(ours.automaton, slow)
        assert forced(ours) == sorted(map(sorted, must.values()))
        plain = thenar.supcon(plants, specs)
        met.add((ours.is_empty, bool(must), plain.is_empty))
    assert met == {(True, False, True), (False, False, False), (False, True, False), (False, True, True)}


def test_the_result_is_forcibly_controllable_nonblocking_and_within_the_specification() -> None:
    for plants, specs, preempted in CASES:
        found = supcon_forcing(plants, specs, preempted=preempted)
        K = found.automaton
        assert is_forcibly_controllable(K, plants, preempted=preempted)
        assert timed_oracle.is_forcibly_controllable(K, plants, preempted)
        assert thenar.is_nonblocking(K)
        assert thenar.is_sublanguage(K, thenar.sync(*plants, *specs))
        assert thenar.is_isomorphic(thenar.closed_loop(plants, found), K)


def test_what_is_forced_is_enabled_and_nothing_else_that_it_preempts() -> None:
    for plants, specs, preempted in CASES:
        found = supcon_forcing(plants, specs, preempted=preempted)
        for x in range(found.n_states):
            must, can = found.forced(x), found.pattern(x).enabled
            assert bool(must) == bool(found.forcing[x])
            assert all(e in can and e.forcible for e in must)
            if must:
                assert all(e.forcible for e in can if e.name in found.preempted)


def test_forcible_controllability_is_the_oracles_and_its_witness_breaks_it() -> None:
    broken = 0
    for plants, specs, preempted in CASES:
        check = is_forcibly_controllable(specs, plants, preempted=preempted)
        slow = timed_oracle.is_forcibly_controllable(specs, plants, preempted)
        assert bool(check) == bool(slow)
        if not check:
            assert check.witness is not None
            broken += 1
            legal = thenar.sync(*plants, *specs)
            assert legal.generates(check.witness[:-1])
            lost = not legal.generates(check.witness)
            assert lost or "would preempt" in check.reason
            assert not lost or not legal.alphabet[check.witness[-1]].controllable
            assert len(check.witness) == shortest_break(plants, specs, preempted)
    assert broken > 100


def shortest_break(plants: list[Automaton], specs: list[Automaton], preempted: list[str] | None) -> int:
    """How long the shortest string is after which the definition does not hold, and one event more."""
    plant, legal = thenar.sync(*plants), thenar.sync(*plants, *specs)
    chosen = set(legal.alphabet.names if preempted is None else preempted)
    seen, queue = {(plant.initial, legal.initial)}, [(plant.initial, legal.initial, 0)]
    for g, q, depth in queue:  # grows while it is read
        can, may = ({e.name: e for e in a.enabled(x)} for a, x in ((plant, g), (legal, q)))
        can |= {e.name: e for e in legal.alphabet if e.name not in plant.alphabet}  # no plant hinders these
        lost = {e for e, event in can.items() if not event.controllable and e not in may}
        forcible = {e for e, event in may.items() if event.forcible}
        if lost - chosen or (lost & chosen and (not forcible or (chosen & may.keys()) - forcible)):
            return depth + 1
        for name in may:
            g2 = plant.step(g, name) if name in plant.alphabet else g
            q2 = legal.step(q, name)
            assert g2 is not None
            assert q2 is not None
            if (g2, q2) not in seen:
                seen.add((g2, q2))
                queue.append((g2, q2, depth + 1))
    raise AssertionError("it holds everywhere")


# -- largest ---------------------------------------------------------------------------------------------------


def test_no_larger_forcibly_controllable_nonblocking_sublanguage_exists() -> None:
    """Every choice of transitions of the legal behaviour is tried."""
    tried = larger = 0
    for seed in range(4000):
        plants, specs, preempted = untimed(seed, max_states=3, max_events=4)
        legal = thenar.sync(*plants, *specs)
        if legal.n_transitions > 7:
            continue
        K = supcon_forcing(plants, specs, preempted=preempted)
        if not K.forcing.any() and seed % 8:  # mostly those in which something is forced
            continue
        tried += 1
        larger += not thenar.is_sublanguage(K.automaton, thenar.supcon(plants, specs))
        for part in parts(legal):
            if thenar.is_nonblocking(part) and timed_oracle.is_forcibly_controllable(part, plants, preempted):
                assert thenar.is_sublanguage(part, K.automaton), (seed, list(part.transitions()))
    assert tried > 60
    assert larger > 20


def parts(legal: Automaton) -> list[Automaton]:
    chosen = [[bool(k >> i & 1) for i in range(legal.n_transitions)] for k in range(1 << legal.n_transitions)]
    return [thenar.reachable(kept(legal, np.array(choice, np.bool_))) for choice in chosen]


# -- limits of the notion --------------------------------------------------------------------------------------


def test_without_forcible_events_or_without_what_they_preempt_it_is_supcon() -> None:
    for plants, specs, preempted in CASES:
        tame = [[without_force(a) for a in group] for group in (plants, specs)]
        plain = thenar.supcon(plants, specs)
        for found in (supcon_forcing(*tame, preempted=preempted), supcon_forcing(plants, specs, preempted=[])):
            assert thenar.is_isomorphic(without_force(found.automaton), without_force(plain))
            assert not found.forcing.any()
        assert thenar.condat(plants, plain).disabled.tolist() == found.disabled.tolist()


def without_force(a: Automaton) -> Automaton:
    tame = Alphabet(Event(e.name, e.controllable) for e in a.alphabet)
    return Automaton(a.name, tame, a.initial, a.offsets, a.events, a.targets, a.marked, a.states)


def test_what_is_controllable_is_forcibly_controllable_so_that_forcing_only_gains() -> None:
    for plants, specs, preempted in CASES:
        plain = thenar.supcon(plants, specs)
        assert is_forcibly_controllable(plain, plants, preempted=preempted)
        assert thenar.is_sublanguage(plain, supcon_forcing(plants, specs, preempted=preempted).automaton)


def test_a_controllable_event_is_not_worth_preempting() -> None:
    for plants, specs, preempted in CASES:
        if preempted is None:
            continue
        alphabet = thenar.sync(*plants, *specs).alphabet
        free = [e for e in preempted if not alphabet[e].controllable]
        for_all, for_free = (supcon_forcing(plants, specs, preempted=p).automaton for p in (preempted, free))
        assert thenar.is_sublanguage(for_all, for_free)


# -- another tool ----------------------------------------------------------------------------------------------


def one_preempted(plants: list[Automaton], specs: list[Automaton], k: int) -> str:
    alphabet = thenar.sync(*plants, *specs).alphabet
    free = [e.name for e in alphabet if not e.controllable] or list(alphabet.names)
    return "tick" if "tick" in alphabet else free[k % len(free)]


def test_libfaudes_computes_the_same_when_one_event_is_preempted() -> None:
    for k, (plants, specs, _) in enumerate(CASES[500:]):
        event = one_preempted(plants, specs, k)
        theirs = libfaudes_timed.supcon_forcing(plants, specs, event)
        assert thenar.is_isomorphic(supcon_forcing(plants, specs, preempted=[event]).automaton, theirs)


def test_tct_computes_the_same_by_a_timeout_unless_it_leaves_nothing_to_force() -> None:
    same = more = 0
    for plants, specs, chosen in CASES:
        legal = thenar.sync(*plants, *specs)
        preempted = [e.name for e in legal.alphabet if not e.forcible and (chosen is None or e.name in chosen)]
        if loops_behind_the_timeout(plants, legal.alphabet, preempted):
            continue
        ours = supcon_forcing(plants, specs, preempted=preempted).automaton
        found = tct_timed.supcon_forcing(plants, specs, preempted)
        if found.is_empty:
            assert ours.is_empty
            same += 1
            continue
        theirs = thenar.project(found, legal.alphabet.names)
        assert thenar.is_sublanguage(ours, theirs)
        if is_forcibly_controllable(theirs, plants, preempted=preempted):
            assert thenar.is_isomorphic(thenar.minimize(ours), thenar.minimize(theirs))
            same += 1
        else:
            more += 1
    assert same + more >= 1000
    assert more


def loops_behind_the_timeout(plants: list[Automaton], alphabet: Alphabet, preempted: list[str]) -> bool:
    """Whether FORCE treats an event differently from others because it loops."""
    plant = thenar.sync(*plants)
    calm = [e.name for e in alphabet if not e.forcible and e.name not in preempted]
    return any(e in calm and s == t for s, e, t in plant.transitions()) or any(e not in plant.alphabet for e in calm)


# -- the literature --------------------------------------------------------------------------------------------


def pedestrian(forcible: bool) -> tuple[list[Automaton], Automaton]:
    """A bus that passes at the second tick, and a pedestrian who can jump from the first on."""
    jump = Event("jump", forcible=forcible)
    bus = Automaton.from_transitions(["a -pass-> g"], initial="a", marked=["a", "g"], uncontrollable=["pass"])
    man = Automaton.from_transitions(["r -jump-> c"], initial="r", marked=["r", "c"], events=[jump])
    street = [timed(bus, {"pass": (2, 2)}), timed(man, {"jump": (1, None)})]
    saved = Automaton.from_transitions(
        ["0 -jump-> 1 -pass-> 2"], initial="0", marked=["2"], events=[jump, *bus.alphabet], name="SAVED"
    )
    return street, saved


def test_the_endangered_pedestrian_is_saved_by_forcing_the_jump_before_the_second_tick_and_not_otherwise() -> None:
    """Brandin and Wonham 1994, and Wonham and Cai 2019, ch. 9."""
    street, saved = pedestrian(forcible=True)
    found = supcon_forcing(street, saved)
    assert thenar.is_isomorphic(
        found.automaton,
        Automaton.from_transitions(
            ["0 -tick-> now -jump-> 2 -tick-> 3 -pass-> 4 -tick-> 4"],
            initial="0",
            marked=["4"],
            events=found.automaton.alphabet,
        ),
    )
    assert np.flatnonzero(found.forcing).tolist() == [1]
    assert [e.name for e in found.forced(1)] == ["jump"]
    assert not found.forced(0)
    street, saved = pedestrian(forcible=False)
    assert supcon_forcing(street, saved).is_empty
    assert thenar.supcon(street, saved).is_empty


def test_forcing_preempts_a_breakdown_in_the_untimed_sense() -> None:
    """A machine that may break down while it waits is kept whole by not letting it wait."""
    events = [Event("start", forcible=True), Event("rest"), Event("break", False), Event("done", False)]
    plant = Automaton.from_transitions(
        ["idle -start-> busy -done-> idle", "idle -rest-> idle", "idle -break-> broken"],
        initial="idle",
        marked=["idle"],
        events=events,
    )
    whole = Automaton.from_transitions([], initial="0", marked=["0"], events=events, alphabet=["break"])
    assert thenar.supcon(plant, whole).is_empty
    everything = supcon_forcing(plant, whole, preempted=None)
    assert list(everything.automaton.transitions()) == [("idle|0", "start", "busy|0"), ("busy|0", "done", "idle|0")]
    assert [e.name for e in everything.pattern(0).disabled] == ["rest"]
    only = supcon_forcing(plant, whole, preempted=["break"])
    assert only.automaton.generates("rest, rest, start, done")


# -- the door --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("preempted", "says"),
    [
        (("tick",), "unknown event 'tick': name the events that forced ones preempt, or preempted=None for all"),
        (["brake"], "unknown event 'brake'; did you mean 'break'?: name the events"),
        ("break", "preempted is a list of events, not the text 'break'"),
    ],
)
def test_what_cannot_be_preempted_is_refused(preempted: Collection[str], says: str) -> None:
    a = Automaton.from_transitions(["0 -break-> 0"], initial="0", marked=["0"])
    for function in (supcon_forcing, is_forcibly_controllable):
        with pytest.raises(thenar.InputError) as error:
            function(a, a, preempted=preempted)
        assert says in str(error.value)


def test_nothing_goes_in_and_nothing_comes_out() -> None:
    a = Automaton.from_transitions(["0 -tick-> 0"], initial="0", marked=["0"], events=[TICK])
    empty = Automaton.empty(Alphabet([TICK]))
    assert supcon_forcing(a, empty).is_empty
    assert is_forcibly_controllable(empty, a)
    assert repr(supcon_forcing(a, empty)) == "ForcingSupervisor: none exists"
    with pytest.raises(thenar.UnknownName, match="unknown state '1'"):
        supcon_forcing(a, []).forced("1")


def test_a_forcing_supervisor_survives_a_pickle_and_its_arrays_are_frozen() -> None:
    found = supcon_forcing(*pedestrian(forcible=True))
    again = pickle.loads(pickle.dumps(found))
    assert isinstance(again, ForcingSupervisor)
    assert again.forced(1) == found.forced(1)
    for s in (found, again):
        assert not any(array.flags.writeable for array in (s.forcing, s.disabled, s.disabled_offsets))
    with pytest.raises(thenar.UnknownName, match="unknown state 99"):
        found.forced(99)


def test_limits_are_kept() -> None:
    with pytest.raises(thenar.LimitReached):
        supcon_forcing(*pedestrian(forcible=True), limits=thenar.Limits(states=2))
