"""Runs with a clock: ticks disturb nothing, what is forced is started at once, and what comes too late is noticed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from random import Random
from typing import Any

import pytest
from tests.runtime.fake import FakeDriver

from thenar.errors import ModelError
from thenar.explicit.control import condat
from thenar.explicit.forcing import ForcingSupervisor, supcon_forcing
from thenar.explicit.products import sync
from thenar.explicit.timed import TICK
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.runtime.cheapest import Cheapest
from thenar.runtime.driver import Detector, Skill
from thenar.runtime.executor import execute
from thenar.runtime.plan import Shortest
from thenar.runtime.policy import Policy, Priority, RandomPolicy
from thenar.runtime.record import LogWriter, header, read_log
from thenar.runtime.replay import replay
from thenar.runtime.run import Run

EVENTS = [TICK, Event("heat"), Event("stir"), Event("cool", forcible=True)]
STOVE = Automaton.from_transitions(
    [
        "cold -tick-> cold -heat-> warm -tick-> hot -tick-> burnt -tick-> burnt",
        "warm -stir-> warm",
        "hot -stir-> hot",
        "warm -cool-> cold",
        "hot -cool-> cold",
    ],
    initial="cold",
    marked=["cold"],
    events=EVENTS,
    name="STOVE",
)
PERIOD_S = 0.1
HEAT, STIR = (STOVE.alphabet.index(e) for e in ("heat", "stir"))


class Patient:
    """Heats once, then lets time pass as long as it may, and stirs if ``stirs``."""

    name = "patient"

    def __init__(self, stirs: bool = False) -> None:
        self.stirs, self.asked = stirs, list[tuple[list[int], bool]]()

    def begin(self) -> None:
        self.heated = False

    def saw(self, event: int, state: int) -> None:
        self.heated = True

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        self.asked.append((list(choices), may_wait))
        if not self.heated:
            return choices[0]
        if self.stirs and STIR in choices:
            return STIR
        return None if may_wait or HEAT in choices else choices[0]


class Stove(FakeDriver):
    """Follows the executor's clock too."""

    def __init__(self, *, stir_s: float = 0.02, cool_s: float = 0.02, heat_s: float = 0.02) -> None:
        takes = {"heat": heat_s, "stir": stir_s, "cool": cool_s}
        skills = {e: Skill(e, "achievement", s, 10.0) for e, s in takes.items()}
        clock = {"tick": Detector("tick", 0.0, PERIOD_S, 2 * PERIOD_S)}
        super().__init__(
            STOVE, STOVE.alphabet, Random(1), skills=skills, detectors=clock, chance=lambda event, state: 0.0
        )
        self.exactly = takes

    def start(self, event: str) -> None:
        super().start(event)
        self.ready_at = self.time_s + self.exactly[event]

    def hear(self, entry: Mapping[str, Any]) -> None:
        if entry.get("chosen_by") == "clock":
            self._follow("tick")


class Clocked(FakeDriver):
    """Any plant with a clock, where nothing comes by itself; what is in ``ready_s`` is not ready before."""

    def __init__(self, plant: Automaton, ready_s: Mapping[str, float] | None = None) -> None:
        super().__init__(plant, plant.alphabet, Random(1), chance=lambda event, state: 0.0)
        self.detectors = {**self.detectors, "tick": Detector("tick", 0.0, PERIOD_S, 2 * PERIOD_S)}
        self.from_s = ready_s or {}

    def not_ready(self, event: str) -> str | None:
        return "warming up" if self.time_s < self.from_s.get(event, 0.0) else None

    def hear(self, entry: Mapping[str, Any]) -> None:
        if entry.get("chosen_by") == "clock":
            self._follow("tick")


def supervisor() -> ForcingSupervisor:
    """Whatever does not burn: from *hot* there is no tick."""
    return supcon_forcing(STOVE, [])


def run(driver: Stove, policy: Policy, log: LogWriter | None = None) -> Run:
    return execute(supervisor(), STOVE, driver, policy, on_entry=driver.hear, log=log)


def test_only_where_it_is_hot_the_supervisor_forces_to_cool() -> None:
    S = supervisor()
    assert {S.automaton.states[x]: [e.name for e in S.forced(x)] for x in range(S.n_states)} == {
        "cold": [],
        "warm": [],
        "hot": ["cool"],
    }


def test_what_is_forced_is_started_at_once_though_the_policy_would_rather_wait() -> None:
    policy = Patient()
    found = run(Stove(), policy)
    assert list(found.trace) == ["heat", "tick", "cool"]
    assert found.discrete_success
    times = [(e["kind"], e["event"], e["t"]) for e in found.entries if e["kind"] in ("start", "event")]
    assert times[-2][:2] == ("start", "cool")
    assert times[-2][2] == times[-3][2], "not in the period of the tick"
    cool, stir = (STOVE.alphabet.index(e) for e in ("cool", "stir"))
    assert ([stir, cool], True) in policy.asked
    assert ([cool], False) in policy.asked


def test_a_skill_that_is_not_forced_gives_way() -> None:
    driver = Stove(stir_s=9.0)
    found = run(driver, Patient(stirs=True))
    assert list(found.trace) == ["heat", "tick", "cool"]
    assert [(e["event"], e["why"]) for e in found.entries if e["kind"] == "abort"] == [("stir", "cool is forced")]
    assert driver.calls == ["start heat", "start stir", "abort stir", "start cool", "stop"]


@pytest.mark.parametrize(("cool_s", "outcome"), [(0.9 * PERIOD_S, "complete"), (1.1 * PERIOD_S, "stopped")])
def test_a_forced_event_that_comes_after_the_tick_stops_the_run(cool_s: float, outcome: str) -> None:
    found = run(Stove(cool_s=cool_s), Patient())
    assert found.outcome == outcome
    late = "model violation: 'tick': cool was forced, and did not come before it"
    assert list(found.violations) == ([late] if outcome == "stopped" else [])


class Lazy(Patient):
    """Does nothing once it has heated, whether it may wait or not."""

    name = "lazy"

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        return HEAT if not self.heated else None


def test_a_policy_that_does_not_start_what_is_forced_ends_the_run() -> None:
    found = run(Stove(), Lazy())
    assert list(found.trace) == ["heat", "tick"]
    assert found.outcome == "stopped"
    assert "policy 'lazy' waits where cool is forced: plant state 'hot'" in found.message


def test_a_tick_disturbs_no_skill_whose_event_stays_enabled() -> None:
    driver = Stove(heat_s=3.5 * PERIOD_S)
    found = run(driver, Patient())
    assert list(found.trace) == ["tick", "tick", "tick", "heat", "tick", "cool"]
    assert driver.calls.count("start heat") == 1


def test_the_clock_begins_anew_with_every_event() -> None:
    found = run(Stove(heat_s=1.5 * PERIOD_S), Patient())
    times = [e["t"] for e in found.entries if e["kind"] == "event"]
    assert times[2] - times[1] == pytest.approx(PERIOD_S, abs=2e-3)


@pytest.mark.parametrize("seed", range(5))
def test_every_log_is_accepted_by_the_closed_loop_whatever_the_policy(tmp_path: Path, seed: int) -> None:
    S = supervisor()
    policies: list[Policy] = [RandomPolicy(Random(seed)), Priority(S, ["stir"]), Shortest(S, Stove())]
    for k, policy in enumerate(policies):
        path = tmp_path / f"{k}.jsonl"
        with LogWriter(path, header("stove", events=S.automaton.alphabet.names, seed=seed)) as log:
            found = run(Stove(stir_s=0.03 + 0.02 * seed), policy, log)
        assert not found.violations
        assert replay(read_log(path), S, STOVE)


def test_where_only_time_passes_and_changes_nothing_the_run_is_stopped() -> None:
    stuck = Automaton.from_transitions(
        ["0 -heat-> 1 -tick-> 1", "0 -tick-> 0", "1 -cool-> 2", "2 -tick-> 2"],
        initial="0",
        marked=["2"],
        events=EVENTS,
        alphabet=["stir"],
    )
    no_cool = Automaton.from_transitions(
        ["0 -tick,heat-> 0"], initial="0", marked=["0"], events=EVENTS, alphabet=["cool"]
    )
    S = supcon_forcing(stuck, [])
    assert not S.forcing.any()
    lamed = condat(stuck, sync(stuck, no_cool))
    driver = Stove()
    driver.plant = stuck
    found = execute(lamed, stuck, driver, Priority(lamed), on_entry=driver.hear)
    assert found.outcome == "stopped"
    assert "nothing is enabled" in found.message


# -- who waits for the clock -----------------------------------------------------------------------------------


def test_a_run_ends_in_the_marked_state_to_which_ticks_lead() -> None:
    """The same events are enabled before and after each tick: nothing but the clock."""
    plant = Automaton.from_transitions(
        ["0 -tick-> 1 -tick-> 2 -tick-> 3 -tick-> 3"], initial="0", marked=["3"], events=[TICK]
    )
    driver, S = Clocked(plant), condat(plant, plant)
    found = execute(S, plant, driver, Priority(S), on_entry=driver.hear)
    assert found.discrete_success
    assert list(found.trace) == ["tick"] * 3


def test_it_does_so_too_where_the_supervisor_takes_no_note_of_the_tick() -> None:
    plant = Automaton.from_transitions(["0 -tick-> 1 -tick-> 2 -tick-> 2"], initial="0", marked=["2"], events=[TICK])
    whatever = Automaton.from_transitions(["any -tick-> any"], initial="any", marked=["any"], events=[TICK])
    driver, S = Clocked(plant), condat(plant, whatever)
    found = execute(S, plant, driver, Priority(S), on_entry=driver.hear)
    assert found.discrete_success
    assert list(found.trace) == ["tick"] * 2


WAY = Automaton.from_transitions(
    ["a -tick-> b -tick-> b", "a -go-> bad -fix-> done", "bad -tick-> bad", "b -go-> done -tick-> done"],
    initial="a",
    marked=["done"],
    events=[TICK, Event("go"), Event("fix")],
)


def test_a_policy_that_waits_for_a_tick_is_asked_again_after_it() -> None:
    driver, S = Clocked(WAY), condat(WAY, WAY)
    found = execute(S, WAY, driver, Cheapest(S, {"fix": 100}), on_entry=driver.hear)
    assert found.discrete_success
    assert list(found.trace) == ["tick", "go"]


def test_a_skill_that_is_not_ready_is_waited_for_over_a_tick_that_changes_nothing_for_it() -> None:
    driver, S = Clocked(WAY, ready_s={"go": 2.5 * PERIOD_S}), condat(WAY, WAY)
    found = execute(S, WAY, driver, Priority(S), on_entry=driver.hear)
    assert list(found.trace) == ["tick", "tick", "go"]
    assert not [e for e in found.entries if e["kind"] == "note"]


HUM = [TICK, Event("stop", forcible=True), Event("hum")]


@pytest.mark.parametrize("hum_s", [0.0, 1.0])
def test_a_forced_event_is_waited_for_while_it_is_not_ready_though_something_else_is(hum_s: float) -> None:
    plant = Automaton.from_transitions(
        ["0 -tick-> 1 -stop-> 2 -tick-> 2", "1 -tick-> 3 -tick-> 3", "1 -hum-> 1"],
        initial="0",
        marked=["2"],
        events=HUM,
    )
    S = supcon_forcing(plant, [])
    driver = Clocked(plant, ready_s={"stop": 1.5 * PERIOD_S, "hum": hum_s})
    found = execute(S, plant, driver, Priority(S, ["hum"]), on_entry=driver.hear)
    assert found.discrete_success
    assert list(found.trace) == ["tick", "stop"]


# -- the door --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("clock", [TICK, Event("tick", False), Event("tick", False, observable=False)])
def test_the_clock_is_known_by_its_name(clock: Event) -> None:
    plant = Automaton.from_transitions(
        ["0 -tick-> 1 -stop-> 2"], initial="0", marked=["2"], events=[clock, Event("stop")]
    )
    driver, S = Clocked(plant), condat(plant, plant)
    found = execute(S, plant, driver, Priority(S), on_entry=driver.hear)
    assert found.discrete_success
    assert list(found.trace) == ["tick", "stop"]


def test_a_clock_that_could_be_held_is_refused() -> None:
    plant = Automaton.from_transitions(["0 -tick-> 1"], initial="0", marked=["1"])
    S = condat(plant, plant)
    with pytest.raises(
        ModelError, match="event 'tick': it is the clock's, which nobody starts: make it uncontrollable"
    ):
        execute(S, plant, Clocked(plant), Priority(S))


def test_a_driver_without_a_clock_is_refused() -> None:
    driver = Stove()
    driver.detectors = {}
    with pytest.raises(ModelError, match="event 'tick': uncontrollable, but the driver has no detector for it"):
        run(driver, Patient())
