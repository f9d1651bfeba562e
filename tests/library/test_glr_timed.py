"""Section 7 of the paper: with slip at any time the load may never be applied, unless more grip can be forced."""

from functools import cache

import numpy as np
import pytest
from tests.oracles import libfaudes_timed, tct

import thenar
from thenar import library
from thenar.explicit.forcing import ForcingSupervisor, is_forcibly_controllable, supcon_forcing
from thenar.explicit.rows import kept
from thenar.explicit.timed import is_activity_loop_free
from thenar.library import glr
from thenar.library.glr import slip
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.testing import assert_isomorphic, timed_oracle

TO_THE_LOAD = (
    "approach_1, approach_2, align_finger2*, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, "
    "orient_normal1, orient_normal2, apply_gripF*, apply_loadF*"
)
ANSWERED = "incip_slip*, inc_gripF*"
HELD = {*slip.HELD, "grip_decreased"}
COMES_BACK = {"prox_breakC_1", "prox_breakC_2"}


@cache
def supervisor() -> ForcingSupervisor:
    task = glr.timed()
    return supcon_forcing(task.plants, task.specs)


@cache
def unforced() -> Automaton:
    task = glr.timed()
    return thenar.supcon(task.plants, task.specs)


def occurring(automaton: Automaton) -> set[str]:
    return {automaton.alphabet[e].name for e in np.unique(automaton.events).tolist()}


def local(x: int) -> dict[str, str]:
    """What each automaton of the task is in, when the supervisor is in x."""
    task = glr.timed()
    return dict(zip([a.name for a in task.automata], supervisor().automaton.states[x].split("|"), strict=True))


# -- the model -------------------------------------------------------------------------------------------------


def test_the_events_are_the_papers_and_a_tick_and_more_grip_can_be_forced() -> None:
    assert slip.TIMED_EVENTS.names == ("tick", *glr.EVENTS.names)
    assert [e.name for e in slip.TIMED_EVENTS if e.forcible] == ["inc_gripF*"]
    assert not slip.TIMED_EVENTS["tick"].controllable


@pytest.mark.parametrize("i", [1, 2])
def test_but_for_slip_and_its_answer_a_finger_is_the_papers(i: int) -> None:
    def rest(a: Automaton) -> set[tuple[str, str, str]]:
        apart = ("slipping", "friction_slip")
        return {t for t in a.transitions() if t[1] not in ("incip_slip*", "inc_gripF*") and t[0] not in apart}

    assert rest(slip.finger(i)) == rest(glr.finger(i))


@pytest.mark.parametrize("i", [1, 2])
def test_slip_is_self_looped_wherever_the_object_is_held(i: int) -> None:
    loops = {(s, t) for s, e, t in slip.finger(i).transitions() if e == "incip_slip*"}
    assert loops == {(state, state) for state in HELD}


def test_whatever_the_papers_plant_can_do_this_one_can_when_the_clock_is_not_heard() -> None:
    G = thenar.sync(*glr.timed().plants)
    seen = thenar.project(G, glr.EVENTS.names)
    papers = Alphabet(glr.EVENTS[e] for e in seen.alphabet.names)
    plain = Automaton("", papers, seen.initial, seen.offsets, seen.events, seen.targets, seen.marked, seen.states)
    assert thenar.is_sublanguage(thenar.sync(*glr.problem().plants), plain)
    assert not thenar.is_sublanguage(plain, thenar.sync(*glr.problem().plants))


# -- without forcing -------------------------------------------------------------------------------------------


def test_without_forcing_the_task_ends_before_slip_can_occur() -> None:
    """ "...controllability would ensure that the task would end before ever getting to a state where incipient slip
    could occur": the load is never applied, and nothing that comes after it."""
    never = {
        "apply_loadF*", "incip_slip*", "inc_gripF*", "remote_breakC*", "dec_gripF*", "move_to_Z*", "stiffness_EP*",
        "remote_makeC*",
    }  # fmt: skip
    assert occurring(unforced()) == set(slip.TIMED_EVENTS.names) - never
    task = glr.timed()
    assert_isomorphic(unforced(), tct.supcon(task.plants, task.specs))


def test_without_forcing_the_fingers_only_ever_come_back_and_with_it_they_release_the_object() -> None:
    def ends(a: Automaton) -> set[tuple[str, ...]]:
        return {tuple(a.states[x].split("|")[:2]) for x in range(a.n_states) if a.marked[x]}

    assert ends(unforced()) == {("neutral", "neutral")}
    assert ends(supervisor().automaton) == {("neutral", "neutral"), ("released", "released")}


def test_that_more_grip_could_follow_is_not_enough_it_must_be_forcible() -> None:
    task = glr.timed()
    tame = Alphabet(Event(e.name, e.controllable) for e in slip.TIMED_EVENTS)

    def without_force(a: Automaton) -> Automaton:
        alphabet = tame.restrict(a.alphabet.names)
        return Automaton(a.name, alphabet, a.initial, a.offsets, a.events, a.targets, a.marked, a.states)

    found = supcon_forcing([without_force(a) for a in task.plants], [without_force(a) for a in task.specs])
    assert not found.forcing.any()
    assert found.n_states == unforced().n_states


# -- with forcing ----------------------------------------------------------------------------------------------


def test_with_forcing_the_whole_task_is_done() -> None:
    found = supervisor()
    assert (found.n_states, found.n_transitions) == (5564, 17284)  # as documented; libFAUDES's, see below
    assert occurring(found.automaton) == set(slip.TIMED_EVENTS.names)
    assert thenar.is_nonblocking(found.automaton)
    assert is_forcibly_controllable(found.automaton, glr.timed().plants)
    assert found.automaton.marks([*glr.nominal()])


def test_libfaudes_computes_the_same_supervisor() -> None:
    task = glr.timed()
    assert_isomorphic(supervisor().automaton, libfaudes_timed.supcon_forcing(task.plants, task.specs, "tick"))


def test_the_oracle_forces_the_same() -> None:
    task = glr.timed()
    slow, forced = timed_oracle.supcon_forcing(task.plants, task.specs)
    assert_isomorphic(supervisor().automaton, slow)
    assert set(map(tuple, forced.values())) == {("inc_gripF*",)}
    assert len(forced) == supervisor().forcing.sum()


def test_every_slip_is_answered_before_the_next_tick_unless_it_ends_the_task() -> None:
    s = supervisor()
    a = s.automaton
    slipped = {y for x in range(a.n_states) for e, y in a.row(x) if a.alphabet[e].name == "incip_slip*"}
    assert slipped
    for x in slipped:
        enabled = {e.name for e in a.enabled(x)}
        if local(x)["SPEC4"] == "slip_3":
            assert "inc_gripF*" not in enabled
            assert COMES_BACK & enabled
        else:
            assert [e.name for e in s.forced(x)] == ["inc_gripF*"]
            assert enabled <= {"inc_gripF*", *COMES_BACK}, "neither a tick, nor another slip, nor anything else"


def test_no_tick_comes_before_the_answer_while_both_fingers_hold_the_object_but_after_the_third_slip() -> None:
    """All strings: where a slip is unanswered, by how many fingers the object is held, and which slip it was."""
    a = supervisor().automaton
    ticks: set[tuple[int, str]] = set()
    start = (a.initial, frozenset[str](), False)
    seen, queue = {start}, [start]
    for x, held, slipped in queue:  # grows while it is read
        for e, y in a.row(x):
            name = a.alphabet[e].name
            if slipped and name == "tick":
                ticks.add((len(held), local(x)["SPEC4"]))
            if slipped and name == "inc_gripF*":
                assert len(held) == 2, "a finger that has lost the object gives it no more grip"
            fingers = held - {name[-1]} if name in COMES_BACK else held
            fingers = held | {name[-1]} if name.startswith("prox_make_C") else fingers
            if slipped and len(fingers) == 0:
                assert a.marked[y], "it ends the task"
            after = y, fingers, len(fingers) > 0 and name != "inc_gripF*" and (slipped or name == "incip_slip*")
            if after not in seen:
                seen.add(after)
                queue.append(after)
    assert {spec4 for held, spec4 in ticks if held == 2} == {"slip_3"}
    assert {spec4 for held, spec4 in ticks if held == 1} == {"slip_0", "slip_1", "slip_2", "slip_3"}


def test_nothing_is_forced_but_the_answer_to_a_slip() -> None:
    s = supervisor()
    for x in np.flatnonzero(s.forcing).tolist():
        assert [e.name for e in s.forced(x)] == ["inc_gripF*"]
        assert local(x)["SENSOR"] == "has_told"
        assert local(x)["SPEC4"] in ("slip_0", "slip_1", "slip_2")


def test_while_loading_two_slips_are_answered_and_the_third_ends_the_task() -> None:
    s = supervisor().automaton
    two = f"{TO_THE_LOAD}, {ANSWERED}, {ANSWERED}"
    assert s.generates(f"{two}, remote_breakC*")
    assert s.generates(f"{two}, incip_slip*, tick, incip_slip*, prox_breakC_1, prox_breakC_2")
    assert not s.generates(f"{two}, incip_slip*, inc_gripF*")


@pytest.mark.parametrize("then", ["", "dec_gripF*", "move_to_Z*", "move_to_Z*, stiffness_EP*"])
def test_in_the_air_slip_may_come_at_any_time_and_is_answered(then: str) -> None:
    s = supervisor().automaton
    trace = [*TO_THE_LOAD.split(", "), "remote_breakC*", *[e for e in then.split(", ") if e]]
    assert s.generates([*trace, "tick", "tick", "incip_slip*", "inc_gripF*"])
    assert not s.generates([*trace, "incip_slip*", "tick"])
    assert not s.generates([*trace, "inc_gripF*"])


def test_forcing_does_not_stop_the_clock_for_ever() -> None:
    """The plant is not activity-loop-free, for its skills take time that it does not tell; but what is forced ends."""
    s = supervisor()
    a = s.automaton
    assert not is_activity_loop_free(a)
    inside = s.forcing[a.targets] & s.forcing[np.repeat(np.arange(a.n_states), np.diff(a.offsets))]
    assert not kept(a, inside).n_transitions, "no forcing state follows another"
    for x in np.flatnonzero(~s.forcing).tolist():
        assert a.step(x, "tick") is not None


# -- the door --------------------------------------------------------------------------------------------------


def test_the_variant_has_its_names() -> None:
    assert "timed" in glr.VARIANTS
    assert glr.timed().name == library.model("glr(timed)").name == glr.problem("timed").name == "glr(timed)"
    with pytest.raises(thenar.InputError, match="the timed variant of glr has two fingers, not 3"):
        glr.problem("timed", fingers=3)
