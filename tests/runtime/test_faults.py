"""Faults: each ends in a safe stop whose message names it, and the log has its end."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from tests.runtime.conftest import Task
from tests.runtime.fake import FakeDriver, Tamper, detectors_for, skills_for

from thenar.errors import Fault
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem
from thenar.runtime.bus import EventBus
from thenar.runtime.driver import Detector, Signal, Skill
from thenar.runtime.executor import RunLimits, execute
from thenar.runtime.policy import Priority
from thenar.runtime.run import Run
from thenar.synthesis.api import synthesize


def stopped(run: Run, driver: FakeDriver, message: str) -> None:
    """Check that ``run`` ended in a safe stop, said in its message and at the end of its log."""
    assert run.outcome == "stopped"
    assert run.message == message
    assert driver.calls[-1] == "stop"
    assert [e["message"] for e in run.entries if e["kind"] == "end"] == [message]
    assert run.entries[-1]["kind"] == "end"


def once(event: str, change: Callable[[FakeDriver, Signal], Sequence[Signal]]) -> Tamper:
    """Change what is reported when ``event`` is reported for the first time."""
    seen: list[Signal] = []

    def tamper(driver: FakeDriver, signals: list[Signal]) -> Sequence[Signal]:
        first = next((s for s in signals if s.event == event), None)
        if first is None or seen:
            return signals
        seen.append(first)
        return change(driver, first)

    return tamper


FAULTS: dict[str, tuple[Tamper, str]] = {
    "doubled": (once("approach_1", lambda d, s: [s, s]), "'approach_1' was delivered twice (number 0), again at {t} s"),
    "lost": (
        once("approach_1", lambda d, s: [replace(s, number=1)]),
        "'approach_1': number 0 is missing (number 1 came at {t} s)",
    ),
    "late": (
        once("approach_2", lambda d, s: [replace(s, time_s=s.time_s - 0.040)]),
        "'approach_2' was delivered 40 ms late and came out of order (dated 0.0660 s, after an event of 0.0680 s), "
        "at {t} s",
    ),
    "from the future": (
        once("approach_1", lambda d, s: [replace(s, time_s=99.0)]),
        "'approach_1' is dated 99.000 s, but it is only {t} s",
    ),
    "never": (
        once("approach_1", lambda d, s: [replace(s, time_s=float("nan"))]),
        "'approach_1' is dated nan s, but it is only {t} s",
    ),
    "no one's": (
        once("approach_1", lambda d, s: [replace(s, event="aproach_1")]),
        "'aproach_1' was reported at {t} s: no skill and no detector has that name",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_signal_that_is_not_to_be_trusted_stops_the_run(task: Task, name: str) -> None:
    tamper, message = FAULTS[name]
    driver = task.driver(1, tamper=tamper)
    run = task.run(driver)
    stopped(run, driver, message.format(t=f"{run.time_s:.3f}"))
    assert isinstance(run.error, Fault)


def test_a_signal_that_was_overtaken_stops_the_run() -> None:
    bus = EventBus(Alphabet(["lift", Event("slip", controllable=False)]))
    bus.arrange([Signal("lift", 0.003, 0)], 0.003)
    with pytest.raises(
        Fault, match=r"^'slip' came out of order \(dated 0.0020 s, after an event of 0.0030 s\), at 0.004 s"
    ):
        bus.arrange([Signal("slip", 0.002, 0)], 0.004)


def test_the_bus_orders_one_tick_in_all_ways_alike() -> None:
    events = [*"ab", *(Event(e, controllable=False) for e in "uvwx")]
    detectors = {
        e: Detector(e, 0.1, 1.0, 2.0, priority=p, finger=f)
        for e, p, f in [("u", 1, 0), ("v", 0, 2), ("w", 0, 1), ("x", 0, 1)]
    }
    skills = {"a": Skill("a", "achievement", 1.0, 2.0, finger=2), "b": Skill("b", "achievement", 1.0, 2.0, finger=1)}
    driver = FakeDriver(Automaton.empty(Alphabet()), Alphabet(events), Random(0), skills=skills, detectors=detectors)
    for seed in range(50):
        signals = [Signal(e, 0.1, 0) for e in "abuvwx"]
        Random(seed).shuffle(signals)
        found = EventBus(Alphabet(events), driver).arrange(signals, 0.1)
        assert "".join(s.event for s in found) == "wxvuba"


def test_a_silent_detector_stops_the_run(task: Task) -> None:
    driver = task.driver(1)
    driver.silent_since["incip_slip*"] = 0.1234
    run = task.run(driver)
    stopped(run, driver, "detector 'incip_slip*' is silent since 0.123 s")
    assert 0.173 < run.time_s < 0.19


def test_a_skill_that_never_ends_stops_the_run(task: Task) -> None:
    driver = task.driver(1, tamper=once("prox_make_C1", lambda d, s: []))
    run = task.run(driver)
    stopped(run, driver, "skill 'prox_make_C1' did not end within 0.3 s")


def test_a_detector_that_never_fires_stops_the_run(task: Task) -> None:
    driver = task.driver(1, slip=0.0)
    run = task.run(driver)
    stopped(run, driver, "waited 5 s for incip_slip*: nothing was detected")


def test_an_exception_in_the_driver_stops_the_run(task: Task) -> None:
    def broken(driver: FakeDriver, signals: list[Signal]) -> Sequence[Signal]:
        if driver.time_s >= 0.2:
            raise ZeroDivisionError("no load")
        return signals

    driver = task.driver(1, tamper=broken)
    run = task.run(driver)
    stopped(run, driver, "ZeroDivisionError: no load")
    assert isinstance(run.error, ZeroDivisionError)


def test_a_fault_of_the_driver_stops_the_run_in_its_words(task: Task) -> None:
    def broken(driver: FakeDriver, signals: list[Signal]) -> Sequence[Signal]:
        raise Fault("sensor 'force_1_x' reports nan at 0.001 s")

    driver = task.driver(1, tamper=broken)
    stopped(task.run(driver), driver, "sensor 'force_1_x' reports nan at 0.001 s")


def test_a_clock_that_stands_still_stops_the_run(task: Task) -> None:
    driver = task.driver(1)
    driver.period_s = 0.0
    stopped(task.run(driver), driver, "the driver's clock stands still at 0.000 s")


def test_a_run_that_takes_too_long_is_stopped(task: Task) -> None:
    driver = task.driver(1)
    stopped(task.run(driver, limits=RunLimits(run_s=0.5)), driver, "the run did not end within 0.5 s")


def test_control_c_stops_the_hand_ends_the_log_and_goes_on(task: Task) -> None:
    def interrupted(driver: FakeDriver, signals: list[Signal]) -> Sequence[Signal]:
        if driver.time_s >= 0.2:
            raise KeyboardInterrupt
        return signals

    driver = task.driver(1, tamper=interrupted)
    seen: list[dict[str, Any]] = []
    with pytest.raises(KeyboardInterrupt):
        task.run(driver, on_entry=seen.append)
    assert driver.calls[-1] == "stop"
    assert (seen[-1]["kind"], seen[-1]["message"]) == ("end", "interrupted from the keyboard")


def test_a_driver_that_does_not_stop_is_said_to(task: Task) -> None:
    driver = task.driver(1, slip=0.0)

    def stop() -> None:
        raise OSError("no answer from the bus coupler")

    driver.stop = stop  # type: ignore[method-assign]
    run = task.run(driver)
    assert run.message.endswith("; and the driver does not stop: OSError: no answer from the bus coupler")
    assert run.entries[-1]["message"] == run.message


def test_a_full_disk_stops_the_run(task: Task) -> None:
    class Full:
        lines = 0

        def write(self, entry: Mapping[str, Any]) -> None:
            self.lines += 1
            if self.lines > 5:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    driver = task.driver(1)
    run = task.run(driver, log=Full())
    assert run.outcome == "stopped"
    assert run.message.startswith("OSError: [Errno 28] No space left on device; and the log has no end")
    assert driver.calls[-1] == "stop"


def test_what_the_plants_model_cannot_do_is_a_violation(task: Task) -> None:
    driver = task.driver(1, tamper=once("approach_1", lambda d, s: [s, d.signal("incip_slip*")]))
    run = task.run(driver)
    message = "model violation: 'incip_slip*': the plant's model cannot do it in state 'neutral|neutral'"
    stopped(run, driver, message)
    assert run.violations == (message,)
    assert "violation" in [e["kind"] for e in run.entries]


def test_what_the_supervisor_does_not_follow_is_a_violation() -> None:
    plant = Automaton.from_transitions(
        ["0 -go-> 1 -slip-> 0", "1 -stop-> 2"], initial="0", marked=["2"], uncontrollable=["slip"]
    )
    dry = Automaton.from_transitions(["0 -go-> 1 -stop-> 2"], initial="0", marked=["2"], events=plant.alphabet)
    supervisor = synthesize(Problem([dry], alphabet=plant.alphabet)).supervisor
    driver = FakeDriver(plant, plant.alphabet, Random(0), chance=lambda event, state: 1.0)
    run = execute(supervisor, plant, driver, Priority(supervisor))
    stopped(run, driver, "model violation: 'slip': the supervisor does not follow it from state 1")


def test_an_event_outside_the_model_is_noted_and_ignored(task: Task) -> None:
    driver = task.driver(1, tamper=once("approach_1", lambda d, s: [s, d.signal("obj_dropped")]))
    driver.detectors = {**driver.detectors, "obj_dropped": Detector("obj_dropped", 0.1, 1.0, 2.0)}
    run = task.run(driver)
    assert run.discrete_success
    assert [(e["event"], e["message"]) for e in run.entries if e["kind"] == "note"] == [
        ("obj_dropped", "not an event of the model; ignored")
    ]


@pytest.fixture
def patient() -> tuple[Automaton, FakeDriver]:
    """A plant whose model knows that things can take too long."""
    plant = Automaton.from_transitions(
        ["0 -reach-> 1 -touch-> 2", "0 -timeout_2-> late -home-> 3", "1 -timeout_1-> late"],
        initial="0",
        marked=["2", "3"],
        uncontrollable=["touch", "timeout_1", "timeout_2"],
    )
    skills = {**skills_for(plant.alphabet), "reach": Skill("reach", "achievement", 0.1, 0.2, finger=2)}
    detectors = detectors_for(plant.alphabet.restrict(["touch"]), limit_s=0.25)
    driver = FakeDriver(plant, plant.alphabet, Random(0), skills=skills, detectors=detectors, chance=lambda e, s: 0.0)
    return plant, driver


def test_an_overdue_skill_is_the_fingers_timeout_where_the_plant_has_one(patient: tuple[Automaton, FakeDriver]) -> None:
    plant, driver = patient
    driver.skills = {**driver.skills, "reach": Skill("reach", "achievement", 9.0, 0.2, finger=2)}
    supervisor = synthesize(Problem([plant])).supervisor
    run = execute(supervisor, plant, driver, Priority(supervisor), through=["home"], on_entry=driver.overhear)
    assert run.trace.events == ("timeout_2", "home")
    assert run.outcome == "complete"
    assert [(e["kind"], e.get("event"), e.get("chosen_by", e.get("message", e.get("why")))) for e in run.entries][
        2:5
    ] == [
        ("note", "timeout_2", "skill 'reach' did not end within 0.2 s"),
        ("event", "timeout_2", "watchdog"),
        ("abort", "reach", "timeout_2 came first"),
    ]
    assert run.entries[2]["t"] == 0.2


def test_an_overdue_detector_is_the_fingers_timeout_where_the_plant_has_one(
    patient: tuple[Automaton, FakeDriver],
) -> None:
    plant, driver = patient
    supervisor = synthesize(Problem([plant])).supervisor
    run = execute(supervisor, plant, driver, Priority(supervisor), on_entry=driver.overhear)
    assert run.trace.events == ("reach", "timeout_1", "home")


def test_a_timeout_is_dropped_when_another_event_comes_in_the_same_tick(patient: tuple[Automaton, FakeDriver]) -> None:
    plant, driver = patient
    driver.detectors = {"touch": Detector("touch", 0.1, 0.1, 0.25, priority=-1)}
    supervisor = synthesize(Problem([plant])).supervisor
    reached: list[float] = []

    def touch_at_the_last_moment(event: str, state: str) -> float:
        if event == "touch" and state == "1":
            reached.append(driver.time_s)
            return float(driver.time_s >= reached[0] + 0.249)  # the first look is a tick after the wait began
        return 0.0

    driver.chance = touch_at_the_last_moment
    run = execute(supervisor, plant, driver, Priority(supervisor))
    assert run.trace.events == ("reach", "touch")
    assert [e.get("event") for e in run.entries if e["kind"] == "stale"] == ["timeout_1"]
