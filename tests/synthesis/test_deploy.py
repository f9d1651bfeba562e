"""Before a supervisor is executed: each check fails for a supervisor that lacks just that property."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thenar.explicit.products import sync
from thenar.library import model
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check
from thenar.synthesis.api import synthesize
from thenar.synthesis.deploy import fit_to_run
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
    assert failed(fit_to_run(supervisor, plant, commands=["a", "b", "unknown"])) == []
    assert failed(fit_to_run(supervisor, plant, commands=["b", "c"])) == [
        "commands end: no after a, b, c, b: the commands c, b can follow each other without end"
    ]


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
