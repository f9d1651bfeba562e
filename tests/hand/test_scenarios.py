"""Every row of the table of scenarios, and every hole of the paper's alphabet."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from thenar.hand.episode import Episode
from thenar.hand.scenarios import SCENARIOS

# What the table says of how often the event comes, where it says more than that it does.
TIMES = {
    "misaligned": ("detect_misalignment*", 1),
    "misaligned-thrice": ("detect_misalignment*", 3),
    "too-heavy": ("incip_slip*", 3),
    "glued": ("incip_slip*", 3),
}
NAMED = [s for s in SCENARIOS.values() if not s.hole]
HOLES = [s for s in SCENARIOS.values() if s.hole]


@pytest.mark.parametrize("variant", ["paper", "extended"])
@pytest.mark.parametrize("name", [s.name for s in NAMED])
def test_each_cause_brings_its_event_about_and_the_run_ends_as_specified(
    episode: Callable[..., Episode], name: str, variant: str
) -> None:
    scenario, found = SCENARIOS[name], episode(variant, name)
    assert found.run.outcome == scenario.ends
    assert not found.run.violations
    assert not scenario.provokes or scenario.provokes in found.run.trace
    assert found.physical_success == (scenario.ends == "complete")
    if scenario.ends == "gave_up":
        assert found.run.entries[-2]["plant"] == "neutral|neutral"
    event, times = TIMES.get(name, ("", 0))
    assert list(found.run.trace).count(event) == times


@pytest.mark.parametrize("name", ["heavy", "slippery"])
def test_the_grip_is_increased_twice_while_loading_and_then_the_block_is_lifted(
    episode: Callable[..., Episode], name: str
) -> None:
    trace = list(episode("paper", name).run.trace)
    assert trace[: trace.index("remote_breakC*")].count("incip_slip*") == 2


@pytest.mark.parametrize("name", [s.name for s in NAMED if not s.provokes])
def test_what_is_tolerated_provokes_nothing_but_slip(episode: Callable[..., Episode], name: str) -> None:
    uncontrollable = [e for e in episode("paper", name).run.trace if e in ("detect_misalignment*",) or "unstable" in e]
    assert uncontrollable == []


@pytest.mark.parametrize("name", [s.name for s in HOLES])
def test_the_papers_alphabet_has_no_word_for_it_and_is_fooled(episode: Callable[..., Episode], name: str) -> None:
    found = episode("paper", name)
    assert not found.physical_success
    assert found.run.outcome == SCENARIOS[name].ends
    assert SCENARIOS[name].provokes not in found.run.trace


@pytest.mark.parametrize("name", ["pulled-while-squeezing", "pulled-while-moving"])
def test_a_block_pulled_out_of_the_grasp_leaves_the_trace_of_a_success(
    episode: Callable[..., Episode], name: str
) -> None:
    nominal, fooled = episode("paper", "nominal"), episode("paper", name)
    assert fooled.run.trace == nominal.run.trace
    assert fooled.discrete_success
    assert fooled.score.dropped


@pytest.mark.parametrize("name", ["missing", "table-gone"])
def test_what_ends_in_silence_is_stopped_by_the_watchdog(episode: Callable[..., Episode], name: str) -> None:
    found = episode("paper", name)
    assert found.run.outcome == "stopped"
    assert "did not end within" in found.run.message


@pytest.mark.parametrize("name", [s.name for s in HOLES])
def test_the_extended_alphabet_catches_it_and_both_fingers_come_back(
    episode: Callable[..., Episode], name: str
) -> None:
    found = episode("extended", name)
    assert SCENARIOS[name].provokes in found.run.trace
    assert found.run.outcome == "gave_up"
    assert found.run.entries[-2]["plant"] == "neutral|neutral"
    assert not found.run.violations
