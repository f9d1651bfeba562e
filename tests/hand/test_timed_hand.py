"""The timed variant on the hand: every slip is answered in time, whoever chooses, or the run is stopped."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

from thenar.explicit.forcing import ForcingSupervisor, supcon_forcing
from thenar.explicit.products import sync
from thenar.hand import driver
from thenar.hand.driver import TICK_S
from thenar.hand.episode import Episode, run_episode
from thenar.hand.scenarios import SCENARIOS
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.runtime.record import LogWriter, header, read_log
from thenar.runtime.replay import replay

Loop = Callable[[str], tuple[Supervisor, Automaton]]
NAMED = [s for s in SCENARIOS.values() if not s.hole]
SLIP, ANSWER = "incip_slip*", "inc_gripF*"


@cache
def timed() -> tuple[ForcingSupervisor, Automaton]:
    task = glr.timed()
    return supcon_forcing(task.plants, task.specs), sync(*task.plants, name="G")


@cache
def timed_episode(scenario: str, seed: int = 1) -> Episode:
    return run_episode(*timed(), scenario=SCENARIOS[scenario], seed=seed)


def answers(found: Episode) -> list[tuple[str, float]]:
    """What happened after each slip, and how many seconds after it."""
    events = [(e["event"], e["t"]) for e in found.run.entries if e["kind"] == "event"]
    return [(b, t_b - t_a) for (a, t_a), (b, t_b) in pairwise(events) if a == SLIP]


@pytest.mark.parametrize("name", [s.name for s in NAMED])
def test_every_scenario_ends_as_it_does_without_a_clock(episode: Callable[..., Episode], name: str) -> None:
    found, papers = timed_episode(name), episode("paper", name)
    assert found.run.outcome == SCENARIOS[name].ends
    assert found.physical_success == (SCENARIOS[name].ends == "complete")
    assert not found.run.violations
    assert [e for e in found.run.trace if e != "tick"] == list(papers.run.trace)
    assert found.run.time_s == papers.run.time_s


@pytest.mark.parametrize("seed", range(100, 106))
def test_a_random_block_is_lifted_measured_and_replaced(seed: int) -> None:
    found = timed_episode("nominal", seed)
    assert found.discrete_success
    assert found.physical_success
    assert not found.run.violations


@pytest.mark.parametrize(("name", "times"), [("nominal", 1), ("heavy", 3), ("slippery", 3)])
def test_every_slip_is_answered_at_once_and_in_time(name: str, times: int) -> None:
    found = timed_episode(name)
    assert [event for event, _ in answers(found)] == [ANSWER] * times
    assert all(seconds < TICK_S for _, seconds in answers(found))
    entries = found.run.entries
    for k, entry in enumerate(entries):
        if entry["kind"] == "event" and entry["event"] == SLIP:
            started = next(e for e in entries[k:] if e["kind"] == "start")
            assert (started["event"], started["t"]) == (ANSWER, entry["t"])


def test_the_third_slip_while_loading_is_not_answered_and_both_fingers_return() -> None:
    found = timed_episode("too-heavy")
    assert [event for event, _ in answers(found)][:2] == [ANSWER] * 2
    assert list(found.run.trace).count(SLIP) == 3
    assert list(found.run.trace)[-2:] == ["prox_breakC_1", "prox_breakC_2"]


class Timid:
    """Lets go of the object when it slips, if it may."""

    name = "timid"

    def __init__(self, supervisor: Supervisor, order: Sequence[str]) -> None:
        index = supervisor.automaton.alphabet.index
        self.order, self.slip, self.release = [index(e) for e in order], index(SLIP), index("prox_breakC_1")

    def begin(self) -> None:
        self.last = -1

    def saw(self, event: int, state: int) -> None:
        if event in (*self.order, self.slip):
            self.last = event

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        if self.last == self.slip and self.release in choices:
            return self.release
        return next((e for e in self.order if e in choices), None)


ONCE = [e for e in glr.nominal() if e not in ("dec_gripF*", "incip_slip*")]


@pytest.mark.parametrize(("variant", "answer"), [("paper", "prox_breakC_1"), ("timed", ANSWER)])
def test_where_it_is_forced_not_even_a_timid_policy_lets_go(closed_loop: Loop, variant: str, answer: str) -> None:
    """The paper's model says that more grip can follow slip; the timed one that it must."""
    S, G = closed_loop(variant) if variant == "paper" else timed()
    found = run_episode(S, G, scenario=SCENARIOS["heavy"], seed=1, policy=Timid(S, ONCE))
    assert answers(found)[0][0] == answer
    assert not found.run.violations


@pytest.mark.parametrize("seed", range(4))
def test_whatever_a_random_policy_chooses_the_log_is_accepted_and_slip_answered(tmp_path: Path, seed: int) -> None:
    S, G = timed()
    with LogWriter(tmp_path / "log.jsonl", header("glr", events=S.automaton.alphabet.names, seed=seed)) as log:
        found = run_episode(S, G, policy=f"random({seed})", scenario=SCENARIOS["heavy"], seed=seed, log=log)
    checked = replay(read_log(tmp_path / "log.jsonl"), S, G)
    assert checked, checked.differences
    assert not found.run.violations
    assert all(event == ANSWER for event, _ in answers(found)[:2])


def test_a_hand_that_is_too_slow_for_its_clock_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second increase takes 1.37 s: with ticks of a second it is late, and the run says so."""
    monkeypatch.setattr(driver, "TICK_S", 1.0)
    found = run_episode(*timed(), scenario=SCENARIOS["heavy"], seed=1)
    assert found.run.outcome == "stopped"
    assert list(found.run.violations) == ["model violation: 'tick': inc_gripF* was forced, and did not come before it"]
    assert not found.score.dropped


def test_the_clock_ticks_when_nothing_has_happened_for_its_period() -> None:
    events = [(e["event"], e["t"]) for e in timed_episode("heavy").run.entries if e["kind"] == "event"]
    gaps = [(b, t_b - t_a) for (_, t_a), (b, t_b) in pairwise(events)]
    assert [gap for event, gap in gaps if event == "tick"] == pytest.approx([TICK_S] * 2, abs=2e-3)
    assert all(gap < TICK_S or math.isclose(gap, TICK_S, abs_tol=2e-3) for _, gap in gaps)
