"""Before a supervisor is executed: each check fails for a supervisor that lacks just that property."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import thenar
from thenar.errors import InputError, UnknownName
from thenar.explicit.forcing import supcon_forcing
from thenar.explicit.products import sync
from thenar.explicit.timed import TICK
from thenar.library import model
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.synthesis.api import synthesize
from thenar.synthesis.deploy import fit_to_run
from thenar.synthesis.implementation import (
    fit_for_sampling,
    has_bounded_response,
    is_avalanche_free,
    is_choice_free,
    is_confluent,
    is_delay_insensitive,
    is_interleave_insensitive,
    is_nonblocking_under_control,
    longest_burst,
)
from thenar.testing import deploy_oracle
from thenar.testing.graphs import read
from thenar.testing.random_models import random_alphabet, random_automaton, random_problem
from thenar.testing.strategies import problems


def unrestrained(automaton: Automaton) -> Supervisor:
    return Supervisor(automaton, np.zeros(automaton.n_states + 1, np.int64), np.zeros(0, np.int32))


def failed(checks: list[Check]) -> list[str]:
    return [str(check) for check in checks if not check]


@given(problems(max_events=6))
def test_every_synthesised_supervisor_is_fit_to_run(problem: Problem) -> None:
    supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    reasons = failed(fit_to_run(supervisor, plant))
    assert reasons == (["a supervisor exists: no: its automaton has no states"] if supervisor.is_empty else [])


@pytest.mark.parametrize("name", ["glr", "small_factory", "agv"])
def test_the_librarys_supervisors_are_fit_to_run(name: str) -> None:
    problem = model(name)
    assert failed(fit_to_run(synthesize(problem).supervisor, sync(*problem.plants))) == []


def test_an_uncontrollable_event_that_is_not_allowed_is_found() -> None:
    plant = Automaton.from_transitions(["0 -go-> 1 -slip-> 0"], initial="0", marked=["0"], uncontrollable=["slip"])
    dry = Automaton.from_transitions(["0 -go-> 1"], initial="0", marked=["0", "1"], events=plant.alphabet,
                                     alphabet=["slip"], name="DRY")  # fmt: skip
    assert failed(fit_to_run(unrestrained(dry), plant))[0] == (
        "controllable: no after go, slip: the plant can do uncontrollable 'slip', which 'DRY' forbids in state '1'"
    )


def test_a_blocking_loop_is_found() -> None:
    plant = Automaton.from_transitions(["0 -go-> 1", "0 -fall-> pit"], initial="0", marked=["1"])
    assert failed(fit_to_run(unrestrained(plant), plant)) == [
        "nonblocking: no after fall: no marked state can be reached from state 'pit|pit'"
    ]


def test_a_disabled_uncontrollable_event_is_found() -> None:
    plant = Automaton.from_transitions(["0 -go-> 1 -slip-> 0"], initial="0", marked=["0", "1"], uncontrollable=["slip"])
    psi = replace(unrestrained(plant), disabled_offsets=np.array([0, 0, 1]), disabled=np.array([1], np.int32))
    assert failed(fit_to_run(psi, plant)) == [
        "uncontrollable events enabled: no after go: uncontrollable 'slip' is disabled in supervisor state 1"
    ]


def test_commands_that_follow_each_other_without_end_are_found() -> None:
    plant = Automaton.from_transitions(
        ["0 -a-> 1 -b-> 2 -c-> 3 -b-> 2", "3 -done-> 4"], initial="0", marked=["4"], uncontrollable=["done"]
    )
    supervisor = synthesize(Problem([plant])).supervisor
    assert failed(fit_to_run(supervisor, plant, commands=["a", "b"])) == []
    assert failed(fit_to_run(supervisor, plant, commands=["b", "c"])) == [
        "bounded response: no after a, b, c, b: the commands c, b can follow each other without end"
    ]


VENTED = ["0 -tick-> 1 -vent-> 2 -tick-> 2", "1 -stop-> 2"]


@pytest.mark.parametrize(("stop", "fails"), [(False, True), (True, False)])
def test_what_is_forced_has_to_be_controllable_somewhere_for_a_skill_to_start_it(stop: bool, fails: bool) -> None:
    """Synthesis may count on an uncontrollable event that is forcible; the executor cannot make it happen."""
    events = [TICK, Event("vent", False, forcible=True), Event("stop", forcible=True)]
    arrows = VENTED if stop else VENTED[:1]
    plant = Automaton.from_transitions([*arrows, "1 -tick-> 3 -tick-> 3"], initial="0", marked=["2"], events=events)
    supervisor = supcon_forcing(plant, [])
    assert supervisor.forcing.any()
    assert failed(fit_to_run(supervisor, plant)) == fails * [
        "forced events can be started: no after tick: 'vent' is forced there, which no skill can start: "
        "supervisor state 1"
    ]


def test_commands_that_are_none_are_refused() -> None:
    plant = Automaton.from_transitions(["0 -on-> 1 -off-> 0"], initial="0", marked=["0"])
    supervisor = synthesize(Problem([plant])).supervisor
    with pytest.raises(UnknownName, match="unknown event 'onn'; did you mean 'on'"):
        fit_to_run(supervisor, plant, commands=["onn"])
    for ask in (lambda: fit_to_run(supervisor, plant, commands="on"), lambda: has_bounded_response(plant, "on"),
                lambda: fit_for_sampling(supervisor, plant, "on"), lambda: longest_burst(plant, "on")):  # fmt: skip
        with pytest.raises(InputError, match="commands is a list of events, not the text 'on'"):
            ask()


@given(problems(max_events=5, max_specs=1), st.integers(0, 255))
def test_commands_end_exactly_if_no_trace_of_commands_visits_a_state_twice(problem: Problem, mask: int) -> None:
    supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    if supervisor.is_empty:
        return
    S = supervisor.automaton
    commands = {e.name for k, e in enumerate(S.alphabet) if mask >> k & 1}

    def reach(q: int) -> list[int]:
        found: list[int] = []
        todo = [q]
        while todo:
            new = [t for e, t in S.row(todo.pop()) if S.alphabet[e].name in commands and t not in found]
            found += new
            todo += new
        return found

    cyclic = any(q in reach(q) for q in range(S.n_states))
    assert bool(fit_to_run(supervisor, plant, commands)[-1]) == (not cyclic)


# -- on a sampled device --------------------------------------------------------------------------------------

Ask = Callable[[Automaton, Iterable[str]], Check]
Oracle = Callable[[Automaton, Collection[str]], set[int]]

PAIRS: list[tuple[Ask, Oracle]] = [
    (has_bounded_response, deploy_oracle.endless),
    (is_confluent, deploy_oracle.not_confluent),
    (is_nonblocking_under_control, deploy_oracle.blocked),
    (is_choice_free, deploy_oracle.choice),
    (is_avalanche_free, deploy_oracle.avalanche),
    (is_interleave_insensitive, deploy_oracle.simultaneity),
    (is_delay_insensitive, deploy_oracle.delay),
]


def drawn(seed: int) -> tuple[Automaton, list[str]]:
    """A small loop, and which of its events are commands: the controllable ones, or any."""
    rng = Random(seed)
    loop = random_automaton(rng, random_alphabet(rng, max_events=5), max_states=7)
    names = [e.name for e in loop.alphabet if e.controllable]
    return loop, names if seed % 2 else [e for e in loop.alphabet.names if rng.random() < 0.5]


@pytest.mark.parametrize(("ask", "oracle"), PAIRS, ids=lambda f: f.__name__)
def test_each_check_is_its_definition(ask: Ask, oracle: Oracle) -> None:
    failures = 0
    for seed in range(1000):
        loop, commands = drawn(seed)
        bad, check = oracle(loop, commands), ask(loop, commands)
        assert bool(check) == (not bad), (seed, str(check))
        if check.witness is not None:
            states = loop.run(check.witness)
            assert len(states) == 1 + len(check.witness), (seed, str(check))
            depth = min(len(thenar.shortest_trace(loop, q) or ()) for q in bad)
            assert states[depth] in bad, (seed, str(check))  # a shortest way to where it fails
        failures += not check
    assert 25 < failures < 975


def test_bursts_are_as_long_as_they_can_be() -> None:
    for seed in range(1000):
        loop, commands = drawn(seed)
        burst = longest_burst(loop, commands)
        assert (None if burst is None else len(burst)) == deploy_oracle.longest(loop, commands)
        if burst:
            traces = read(loop).shortest_traces().values()
            assert set(burst) <= set(commands)
            assert any(loop.generates(trace + burst) for trace in traces)


def test_without_choice_bursts_are_confluent() -> None:
    """Newman 1942: what commutes step by step commutes as a whole."""
    for seed in range(1000):
        loop, commands = drawn(seed)
        if is_choice_free(loop, commands):
            assert is_confluent(loop, commands)


def test_no_check_follows_from_the_others() -> None:
    """But where bursts end differently, or never and yet in rest, there is a choice of which."""
    failing = set()
    for seed in range(2000):
        loop, commands = drawn(seed)
        failing.add(tuple(ask for ask, _ in PAIRS if not ask(loop, commands)))
    for ask, _ in PAIRS:
        with_choice = ask in (has_bounded_response, is_confluent)
        assert ((ask, is_choice_free) if with_choice else (ask,)) in failing, ask


def test_a_sensor_may_toggle_for_ever_but_the_actuator_answers_it_once() -> None:
    """CIF documentation, bounded response check: the actuator follows the sensor."""
    events = thenar.Alphabet(
        [*map(thenar.Event, ("c_on", "c_off")), thenar.Event("u_on", False), thenar.Event("u_off", False)]
    )
    loop = Automaton.from_transitions(
        ["off -u_on-> on -u_off-> off", "on -c_on-> both -u_off-> actuated -u_on-> both", "actuated -c_off-> off"],
        initial="off", marked=["off"], events=events,
    )  # fmt: skip
    bounded = has_bounded_response(loop)
    assert bounded
    assert bounded.reason == "at most 1 command without an input in between"
    assert str(has_bounded_response(loop, ["u_on", "u_off"])) == (
        "bounded response: no after u_on, u_off: the commands u_on, u_off can follow each other without end"
    )


def test_the_checks_ask_about_languages_and_not_about_states() -> None:
    for seed in range(300):
        loop, commands = drawn(seed)
        for ask, _ in PAIRS:
            assert str(ask(loop, commands)) == str(ask(thenar.minimize(loop), commands))


def test_fit_for_sampling_is_all_checks_on_the_closed_loop() -> None:
    for seed in range(100):
        problem = random_problem(Random(seed))
        supervisor = synthesize(problem).supervisor
        loop = thenar.closed_loop(problem.plants, supervisor)
        commands = [e.name for e in loop.alphabet if e.controllable]
        checks = [str(check) for check in fit_for_sampling(supervisor, problem.plants)]
        assert checks == [str(ask(loop, commands)) for ask, _ in PAIRS]


def test_a_foreign_command_is_refused() -> None:
    with pytest.raises(UnknownName, match="unknown event 'statr_1'; did you mean 'start_1'"):
        is_confluent(synthesize(model("small_factory")).supervisor.automaton, ["statr_1"])


def test_a_state_with_many_events_takes_no_memory_for_all_its_pairs() -> None:
    """A thousand commands that exclude each other: half a million pairs, all of them wrong."""
    names = [f"go_{k}" for k in range(1000)]
    fork = Automaton.from_transitions([("0", e, "1") for e in names], initial="0", marked=["1"])
    tracemalloc.start()
    check = is_choice_free(fork)
    held = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert check.reason == "command 'go_1' was enabled as well, and is not any more"
    assert held < 5e6  # bytes; a pair is two numbers of 8


def test_an_empty_loop_is_fit_for_everything() -> None:
    nothing = Automaton.empty(thenar.Alphabet(["a"]))
    assert all(ask(nothing, ["a"]) for ask, _ in PAIRS)
    assert longest_burst(nothing) == Trace()
