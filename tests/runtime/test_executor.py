"""Runs: every log is accepted by G and by S/G, every run ends, and a run ends as its rules say."""

from __future__ import annotations

import json
from collections.abc import Callable
from random import Random

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from tests.runtime.conftest import GOALS, Task
from tests.runtime.fake import FakeDriver, detectors_for, skills_for

from thenar.errors import InputError, ModelError, UnknownName
from thenar.explicit.control import closed_loop
from thenar.explicit.products import sync
from thenar.library.glr.automata import ERROR_FREE
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.runtime.clock import RealClock
from thenar.runtime.driver import Skill
from thenar.runtime.executor import RunLimits, execute
from thenar.runtime.plan import Shortest
from thenar.runtime.policy import Operator, Policy, Priority, RandomPolicy
from thenar.runtime.record import Log
from thenar.runtime.replay import replay
from thenar.synthesis.api import synthesize
from thenar.testing.random_models import random_problem
from thenar.testing.strategies import problems


def run_by_chance(problem: Problem, seed: int, kind: str) -> tuple[Supervisor, Automaton, object]:
    """Run a random problem with everything left to chance, and check what holds for every run."""
    supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants, name="G")
    rng = Random(seed)
    alphabet = supervisor.automaton.alphabet
    commands = [e.name for e in alphabet if e.controllable and rng.random() < 0.3]
    skills = skills_for(alphabet, expected_s=0.004, limit_s=0.02, commands=commands)
    driver = FakeDriver(
        plant,
        alphabet,
        rng,
        skills=skills,
        detectors=detectors_for(alphabet, limit_s=0.05),
        chance=lambda event, state: 0.05,
    )
    driver.unready = {e.name: "not today" for e in alphabet if rng.random() < 0.1}
    policies: dict[str, Callable[[], Policy]] = {
        "random": lambda: RandomPolicy(rng),
        "priority": lambda: Priority(supervisor, []),
        "shortest": lambda: Shortest(supervisor, driver, through=alphabet.names[:2]),
    }
    limits = RunLimits(run_s=1.0, patience_s=0.03)
    run = execute(supervisor, plant, driver, policies[kind](), through=alphabet.names[:2], limits=limits)

    loop = closed_loop(plant, supervisor)
    assert plant.generates([e for e in run.trace if e in plant.alphabet])
    assert loop.generates(run.trace)
    assert run.violations == ()
    assert run.error is None or "did not end within 1 s" in run.message
    assert run.entries[-1]["kind"] == "end"
    assert run.time_s <= 1.01
    if run.status == "done":
        assert loop.marks(run.trace)
    else:
        assert driver.calls[-1] == "stop"
    log = Log("", {}, tuple(json.loads(json.dumps(e)) for e in run.entries))
    assert replay(log, supervisor, plant)
    return supervisor, plant, run


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
@given(problems(max_events=6), st.integers(0, 10**6), st.sampled_from(["random", "priority", "shortest"]))
def test_every_log_is_accepted_and_every_run_ends(problem: Problem, seed: int, kind: str) -> None:
    assume(not synthesize(problem).supervisor.is_empty)
    run_by_chance(problem, seed, kind)


@pytest.mark.parametrize("kind", ["random", "priority", "shortest"])
def test_every_log_of_larger_problems_is_accepted_and_every_run_ends(kind: str) -> None:
    seen = 0
    for seed in range(120):
        problem = random_problem(Random(seed))
        if synthesize(problem):
            run_by_chance(problem, seed, kind)
            seen += 1
    assert seen > 60


def test_without_errors_the_shortest_policy_does_the_papers_task(task: Task) -> None:
    run = task.run(task.driver(1))
    assert run.outcome == "complete"
    assert run.discrete_success
    assert sorted(run.trace) == sorted(ERROR_FREE.split(", "))


@pytest.mark.parametrize("seed", range(20))
def test_with_errors_every_run_ends_as_the_task_is_specified(task: Task, seed: int) -> None:
    run = task.run(task.driver(seed, other=0.004))
    assert run.status == "done"
    assert run.violations == ()
    assert task.supervisor.automaton.marks(run.trace)
    assert run.discrete_success == (run.entries[-2]["plant"] == "released|released" and set(GOALS) <= set(run.trace))


def test_another_supervisor_makes_the_hand_do_what_that_one_allows(
    task: Task, replaced: Callable[[Automaton], Task]
) -> None:
    events = task.supervisor.automaton.alphabet
    line = "0 -prox_make_C2-> 1 -prox_make_C1-> 2 -prox_breakC_1,prox_breakC_2-> 0"
    loops = ["0 -prox_breakC_1,prox_breakC_2-> 0", "1 -prox_breakC_1,prox_breakC_2-> 0"]
    other = replaced(Automaton.from_transitions([line, *loops], initial="0", marked=["0", "1", "2"], events=events))
    before, after = task.run(task.driver(1)).trace, other.run(task.driver(1)).trace
    assert before.events.index("prox_make_C1") < before.events.index("prox_make_C2")
    assert after.events.index("prox_make_C1") > after.events.index("prox_make_C2")
    assert sorted(before) == sorted(after)


def test_a_run_repeats_nothing_that_the_supervisor_has_forgotten(task: Task) -> None:
    # a third misalignment ends the attempt, and the next approach resets the count: SPEC2
    driver = task.driver(0)
    driver.chance = lambda event, state: 0.5 if event == "detect_misalignment*" else 0.0
    run = task.run(driver)
    assert run.outcome == "gave_up"
    assert run.trace.events.count("detect_misalignment*") == 3
    assert run.trace.events.count("approach_1") == 1
    assert run.message == "ended in marked state 'neutral|neutral' without dec_gripF*, stiffness_EP*"


def test_a_failure_that_the_supervisor_remembers_is_tried_again(task: Task) -> None:
    driver = task.driver(0)
    driver.chance = lambda event, state: 0.5 if event == "unstable_contact_1" else 0.0
    run = task.run(driver)
    assert run.outcome == "gave_up"
    assert run.trace.events.count("unstable_contact_1") == 3  # SPEC3: the third ends the task
    assert run.trace.events.count("approach_1") == 3


def test_an_uncontrollable_event_aborts_the_skill_and_outdates_its_success(task: Task) -> None:
    driver = task.driver(0)
    fired: list[float] = []

    def chance(event: str, state: str) -> float:
        last_moment = driver.running == "align_finger2*" and driver.time_s >= driver.ready_at
        if event == "detect_misalignment*" and last_moment and not fired:
            fired.append(driver.time_s)
            return 1.0
        return 0.01 if event == "incip_slip*" and "grip_decreased" in state else 0.0

    driver.chance = chance
    run = task.run(driver)
    there = [e for e in run.entries if e["t"] == round(fired[0], 6)]
    assert [(e["kind"], e.get("event")) for e in there] == [
        ("event", "detect_misalignment*"),
        ("abort", "align_finger2*"),
        ("stale", "align_finger2*"),
        ("start", "re-align_with_finger1*"),
    ]
    assert run.discrete_success


def test_a_command_happens_at_once(task: Task) -> None:
    driver = task.driver(1)
    driver.skills = {n: Skill(n, "command", s.expected_s, s.limit_s) for n, s in driver.skills.items()}
    run = task.run(driver)
    times = {e["event"]: e["t"] for e in run.entries if e["kind"] == "event"}
    assert run.discrete_success
    assert times["approach_1"] == times["dec_gripF*"] == 0.0
    assert times["incip_slip*"] > 0.0


def test_commands_without_end_are_stopped() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1 -b-> 2 -c-> 1", "2 -d-> 3"], initial="0", marked=["3"])
    supervisor = synthesize(Problem([plant])).supervisor
    alphabet = supervisor.automaton.alphabet
    driver = FakeDriver(plant, alphabet, Random(0), skills=skills_for(alphabet, commands="abcd"))
    run = execute(supervisor, plant, driver, Priority(supervisor, "abcd"))
    assert run.message == "commands without end: more in one tick than the supervisor has states"


def test_the_hand_waits_for_the_chosen_skill_where_nothing_else_is_ready(task: Task) -> None:
    driver = task.driver(1)

    def not_ready(event: str) -> str | None:
        return "the hand is not warm" if driver.time_s < 1.5 else None

    driver.not_ready = not_ready  # type: ignore[method-assign]
    run = task.run(driver)
    start = next(e for e in run.entries if e["kind"] == "start" and e["event"] == "approach_1")
    assert 1.5 <= start["t"] <= 1.511
    assert run.discrete_success


def test_a_skill_that_does_not_get_ready_is_left_out(task: Task) -> None:
    driver = task.driver(1)
    driver.unready = {"dec_gripF*": "the grip is not steady"}
    run = task.run(driver)
    notes = [e["message"] for e in run.entries if e["kind"] == "note"]
    assert notes == ["not ready: the grip is not steady"]
    assert run.outcome == "gave_up"
    assert run.message == "ended in marked state 'released|released' without dec_gripF*"


def test_if_nothing_gets_ready_the_run_stops_and_says_why(task: Task) -> None:
    driver = task.driver(1)
    driver.unready = {"approach_1": "the hand is switched off"}
    run = task.run(driver)
    assert run.outcome == "stopped"
    assert run.message == "nothing was ready within 2 s: approach_1: the hand is switched off"
    assert 2.0 <= run.time_s <= 2.02


def test_nothing_moves_when_an_event_has_no_skill(task: Task) -> None:
    driver = task.driver()
    driver.skills = {n.replace("move_to_Z*", "move_to_Z"): s for n, s in driver.skills.items()}
    driver.detectors = {n: d for n, d in driver.detectors.items() if n != "incip_slip*"}
    with pytest.raises(ModelError) as caught:
        task.run(driver, policy=RandomPolicy(Random(0)))
    assert [str(m) for m in caught.value.mistakes] == [
        "event 'move_to_Z*': controllable, but the driver has no skill for it; did you mean 'move_to_Z'?",
        "event 'incip_slip*': uncontrollable, but the driver has no detector for it",
    ]
    assert driver.calls == []
    assert driver.ticks == 0


def test_nothing_moves_for_unknown_goals_or_without_a_supervisor(task: Task) -> None:
    driver = task.driver()
    with pytest.raises(UnknownName, match="did you mean 'dec_gripF"):
        task.run(driver, policy=RandomPolicy(Random(0)), through=["dec_grip*"])
    none = synthesize(Problem([Automaton.from_transitions(["0 -a-> 1"], initial="0")])).supervisor
    with pytest.raises(InputError, match="no supervisor exists"):
        execute(none, task.plant, FakeDriver(task.plant, none.automaton.alphabet, Random(0)), RandomPolicy(Random(0)))
    assert driver.ticks == 0


def test_progress_is_reported_twenty_times_a_second(task: Task) -> None:
    calls: list[tuple[float, str | None, str | None]] = []
    run = task.run(task.driver(1), on_tick=lambda *now: calls.append(now))
    assert abs(len(calls) - 20 * run.time_s) <= 2
    assert calls[0] == (0.001, None, "approach_1")


def test_watchers_see_every_entry_as_it_is_logged(task: Task) -> None:
    seen: list[object] = []
    run = task.run(task.driver(1), on_entry=seen.append)
    assert seen == list(run.entries)


def test_real_time_paces_a_run_without_changing_it(task: Task) -> None:
    wall = [0.0]

    def sleep(seconds: float) -> None:
        wall[0] += seconds

    paced = task.run(task.driver(1), clock=RealClock(2.0, now=lambda: wall[0], sleep=sleep))
    assert paced.entries == task.run(task.driver(1)).entries
    assert wall[0] == pytest.approx(paced.time_s / 2, abs=0.01)


def test_the_operator_decides_and_can_stop(task: Task) -> None:
    answers = iter(["1", "nonsense", "approach_2", "align_finger2", "q"])
    asked: list[str] = []

    def ask(text: str) -> str:
        asked.append(text)
        return next(answers)

    run = task.run(task.driver(1), policy=Operator(task.supervisor, ask))
    assert run.trace.events == ("approach_1", "approach_2", "align_finger2*")
    assert run.message == "the operator stopped the run"
    assert asked[1].splitlines()[1:3] == ["    1  retract_finger_1", "    2  approach_2"]
    assert asked[2].startswith("'nonsense' cannot be started here")


def test_a_pause_is_not_made_up_for() -> None:
    """After a question that took half a minute the run goes on at the pace of the clock."""
    wall, slept = [0.0], [0.0]

    def sleep(seconds: float) -> None:
        wall[0] += seconds
        slept[0] += seconds

    clock = RealClock(now=lambda: wall[0], sleep=sleep)
    clock.pace(0.0)
    clock.pace(1.0)
    wall[0] += 30.0
    for k in range(1, 1001):
        clock.pace(1.0 + k * 1e-3)
    assert 1.9 <= slept[0] <= 2.1
