"""Explanations are true: each one is checked against the problem it talks about."""

import time
from collections.abc import Iterable

import pytest
from hypothesis import given, settings

import thenar
from thenar.library import glr
from thenar.library.glr.paper import S_PRIME_IN_FULL, SIMULATIONS
from thenar.model.problem import Problem
from thenar.testing.strategies import problems

quick = settings(max_examples=150, deadline=None)


def forbids(problem: Problem, spec: str, trace: Iterable[str]) -> bool:
    """The specification allows all of the trace but its last event."""
    automaton = problem.automaton(spec)
    seen = [e for e in trace if e in automaton.alphabet]
    return automaton.generates(seen[:-1]) and not automaton.generates(seen)


@quick
@given(problems())
def test_every_disablement_is_explained_and_the_explanation_is_true(problem: Problem) -> None:
    result = thenar.synthesize(problem)
    plant, legal = thenar.sync(*problem.plants), thenar.sync(*problem.automata)
    for x in range(min(result.supervisor.n_states, 12)):
        for event in result.supervisor.pattern(x).disabled:
            why = thenar.explain_disabled(result, event.name, state=x)
            string = [*why.after, event.name, *why.continuation]
            assert result.supervisor.automaton.run(why.after)[-1] == x
            assert plant.generates(string)
            assert all(not problem.alphabet[e].controllable for e in why.continuation)
            assert event.name in str(why)
            if why.verdict == "forbidden":
                assert why.violations
                assert all(forbids(problem, v.spec, [*why.after, v.event]) for v in why.violations)
            elif why.verdict == "uncontrollable":
                assert why.violations
                assert all(v.event == string[-1] and forbids(problem, v.spec, string) for v in why.violations)
                assert shortest_violation(problem, [*why.after, event.name]) == len(why.continuation)
            else:
                assert why.verdict == "blocking"
                assert legal.generates(string)


def shortest_violation(problem: Problem, start: list[str]) -> int:
    """Length of the shortest uncontrollable string after ``start`` that the plants can do and the specs forbid."""
    plant, legal = thenar.sync(*problem.plants), thenar.sync(*problem.automata)
    level, n = {(plant.run(start)[-1], legal.run(start)[-1])}, 0
    while level:
        n += 1
        following = set()
        for p, q in level:
            for event in plant.enabled(p):
                if event.controllable:
                    continue
                target, allowed = plant.step(p, event), legal.step(q, event) if event in legal.alphabet else q
                if allowed is None:
                    return n
                assert target is not None
                following.add((target, allowed))
        level = following
    raise AssertionError("no violation")


@quick
@given(problems())
def test_an_impossible_task_has_a_minimal_conflict_and_the_trace_that_shows_it(problem: Problem) -> None:
    result = thenar.synthesize(problem)
    if result:
        assert result.reason is None
        return
    reason = result.reason
    assert reason is not None
    core = [problem.automaton(name) for name in reason.conflict]
    assert not thenar.synthesize(Problem(problem.plants, core))
    assert reason.minimal
    for spec in core:
        assert thenar.synthesize(Problem(problem.plants, [s for s in core if s is not spec])), "not minimal"
    if reason.verdict == "uncontrollable":
        assert thenar.sync(*problem.plants).generates(reason.continuation)
        assert all(forbids(problem, v.spec, reason.continuation) for v in reason.violations)
        assert {v.spec for v in reason.violations} <= set(reason.conflict)


@quick
@given(problems())
def test_every_removed_state_is_explained(problem: Problem) -> None:
    result = thenar.synthesize(problem)
    legal = thenar.sync(*problem.automata)
    for q in range(min(legal.n_states, 12)):
        trace = thenar.shortest_trace(legal, to=q)
        assert trace is not None
        why = thenar.explain_removed(result, trace)
        # by some trace, perhaps another one, the supervisor may reach the very state
        there = legal.states[q] in names_of(result.supervisor.automaton)
        if why.verdict == "enabled":
            assert there, (why, trace)
        elif there and len(problem.automata) > 1:  # then the trace leads there through a removed state
            assert len(why.after) < len(trace), (why, trace)


def names_of(automaton: thenar.Automaton) -> set[str]:
    return {automaton.states[q] for q in range(automaton.n_states)}


def test_the_third_increase_of_the_grip_force_is_disabled_by_specification_4() -> None:
    result = thenar.synthesize(glr.problem())
    trace = SIMULATIONS[1].trace
    why = thenar.explain_disabled(result, trace[-1], after=trace[:-1])
    assert why.verdict == "forbidden"
    assert [v.spec for v in why.violations] == ["SPEC4"]
    assert why.violations[0].state == "slip_3"
    assert "inc_gripF* is disabled: SPEC4" in str(why)
    assert why.enabled == ("prox_breakC_1", "prox_breakC_2")


def test_the_papers_s_prime_is_prevented_because_a_fourth_failure_could_follow() -> None:
    result = thenar.synthesize(glr.problem())
    why = thenar.explain_disabled(result, "unstable_contact_1", after=S_PRIME_IN_FULL)
    assert why.verdict == "prevented"
    assert why.event == "prox_make_C1"
    assert why.continuation == thenar.Trace(["unstable_contact_1"])
    assert [(v.spec, v.state) for v in why.violations] == [("SPEC3_1", "failures_3")]


def test_an_event_that_the_plant_cannot_do_is_impossible_not_disabled() -> None:
    result = thenar.synthesize(glr.problem())
    why = thenar.explain_disabled(result, "move_to_Z*")
    assert why.verdict == "impossible"
    assert "FINGER1 is in its state 'neutral'" in str(why)


def test_blocking_is_explained_by_the_deadlock_it_leads_to() -> None:
    plant = thenar.Automaton.from_transitions(
        ["0 -work-> 1 -done-> 0", "0 -gamble-> 2 -lose-> stuck"],
        initial="0",
        marked=["0"],
        uncontrollable=["done", "lose"],
        name="PLANT",
    )
    result = thenar.synthesize(Problem(plant))
    why = thenar.explain_disabled(result, "gamble")
    assert str(why) == (
        "In the initial state the event gamble is disabled: if it happened, no marked state could be reached "
        "from state '2', whatever happened. Enabled there: work."
    )


def test_two_specifications_that_cannot_be_met_together_are_named() -> None:
    events = thenar.Alphabet(["a", "b", thenar.Event("u", controllable=False)])
    plant = thenar.Automaton.from_transitions(
        ["0 -a-> 1 -u-> 2", "0 -b-> 3 -u-> 2"], initial="0", marked=["2"], events=events, name="PLANT"
    )
    no_a = thenar.Automaton.from_transitions([], initial="s", marked=["s"], events=events, alphabet=["a"], name="NO_A")
    no_b = thenar.Automaton.from_transitions([], initial="s", marked=["s"], events=events, alphabet=["b"], name="NO_B")
    idle = thenar.Automaton.from_transitions(["s -u-> s"], initial="s", marked=["s"], events=events, name="IDLE")
    reason = thenar.synthesize(Problem(plant, [no_a, idle, no_b])).reason
    assert reason is not None
    assert reason.conflict == ("NO_A", "NO_B")
    assert str(reason) == (
        "No supervisor exists: NO_A and NO_B cannot be met together; without any one of them there is one. "
        "Already at the start nothing could happen any more in state '0|s|s', which is not marked "
        "(a deadlock: NO_A forbids a in its state 's', and NO_B forbids b in its state 's')."
    )


def test_a_specification_that_closes_the_only_way_out_is_named() -> None:
    plant = thenar.Automaton.from_transitions(
        ["0 -in-> 1 -turn-> 2 -turn-> 1", "2 -out-> 0"], initial="0", marked=["0"], name="HAND"
    )
    stay = thenar.Automaton.from_transitions([], initial="s", marked=["s"], alphabet=["out"], name="STAY")
    why = thenar.explain_disabled(thenar.synthesize(Problem(plant, stay)), "in")
    assert str(why) == (
        "In the initial state the event in is disabled: if it happened, no marked state could be reached from "
        "state '1|s': after turn STAY forbids out in its state 's'."
    )


def test_an_automaton_that_marks_nothing_is_named() -> None:
    plant = thenar.Automaton.from_transitions(["0 -x-> 1 -y-> 0"], initial="0", name="HAND")
    assert str(thenar.synthesize(Problem(plant)).reason) == (
        "No supervisor exists: even without any specification. Already at the start no marked state could be "
        "reached from state '0': HAND marks no state at all."
    )


def test_explaining_the_impossible_never_explores_much_more_than_the_synthesis() -> None:
    """Left without the specification that stops it at once, the plant has ten million states."""
    rings = [
        thenar.Automaton.from_transitions(
            [(str(q), f"turn{k}", str((q + 1) % 10)) for q in range(10)], initial="0", marked=["0"], name=f"RING{k}"
        )
        for k in range(7)
    ]
    boom = thenar.Automaton.from_transitions(
        ["0 -boom-> 1"], initial="0", marked=["0"], uncontrollable=["boom"], name="BOMB"
    )
    freeze = thenar.Automaton.from_transitions(
        [], initial="0", marked=["0"], alphabet=[f"turn{k}" for k in range(7)], name="FREEZE"
    )
    never = thenar.Automaton.from_transitions(
        [], initial="0", marked=["0"], alphabet=["boom"], uncontrollable=["boom"], name="NO_BOOM"
    )
    reason = thenar.synthesize(Problem([*rings, boom], [freeze, never])).reason
    assert reason is not None
    assert reason.verdict == "uncontrollable"
    assert "NO_BOOM" in reason.conflict


def test_a_reason_is_given_however_long_after_the_limit_of_the_synthesis() -> None:
    plant = thenar.Automaton.from_transitions(["0 -x-> 1"], initial="0", name="HAND")
    result = thenar.synthesize(Problem(plant), limits=thenar.Limits(seconds=0.2))
    time.sleep(0.3)
    assert result.reason is not None


def test_bad_questions_get_clear_answers() -> None:
    result = thenar.synthesize(glr.problem())
    with pytest.raises(thenar.UnknownName, match=r"unknown event 'aproach_1'; did you mean 'approach_1'\?"):
        thenar.explain_disabled(result, "aproach_1")
    with pytest.raises(thenar.UnknownName, match="unknown state 99999"):
        thenar.explain_disabled(result, "approach_1", state=99999)
    with pytest.raises(thenar.InputError, match="give a trace or a state, not both"):
        thenar.explain_disabled(result, "approach_1", after="approach_1", state=0)
    with pytest.raises(thenar.InputError, match="a supervisor exists"):
        thenar.explain_empty(result)


def test_an_explanation_is_plain_data() -> None:
    result = thenar.synthesize(glr.problem())
    data = thenar.explain_disabled(result, "approach_2").to_dict()
    assert data["verdict"] == "forbidden"
    assert data["after"] == []
    assert data["violations"] == [
        {
            "spec": "SPEC1",
            "state": "both_back",
            "event": "approach_2",
            "meaning": "Finger 1 approaches the object before finger 2.",
        }
    ]
