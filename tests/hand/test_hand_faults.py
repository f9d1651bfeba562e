"""Faults of the real thing: each ends in a safe stop that names it, and the log is whole."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from thenar.errors import InputError
from thenar.hand.episode import run_episode
from thenar.hand.faults import FAULTS, fault
from thenar.hand.objects import Block
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.runtime.record import LogWriter, header, read_log
from thenar.runtime.replay import replay

Loop = Callable[[str], tuple[Supervisor, Automaton]]
CASES = {
    "silent:incip_slip": "detector 'incip_slip*' is silent since",
    "double:incip_slip": "'incip_slip*' was delivered twice",
    "double:prox_make_C1": "'prox_make_C1' was delivered twice",
    "late:incip_slip": "'incip_slip*' was delivered 40 ms late",
    "unordered:apply_gripF": "came out of order",
    "nan:force_x_1": "sensor 'force_x_1' reports nan",
    "nan:shear_3": "sensor 'shear_3' reports nan",
    "endless:move_to_Z": "skill 'move_to_Z*' did not end within 5 s",
}


@pytest.mark.parametrize("name", CASES)
def test_each_fault_ends_in_a_safe_stop_that_names_it(closed_loop: Loop, tmp_path: Path, name: str) -> None:
    S, G = closed_loop("paper")
    first = header("glr", events=[e.name for e in S.automaton.alphabet])
    with LogWriter(tmp_path / "log.jsonl", first) as log:
        found = run_episode(S, G, block=Block(), seed=1, fault=fault(name), log=log)
    assert found.run.outcome == "stopped"
    assert CASES[name] in found.run.message
    recorded = read_log(tmp_path / "log.jsonl")
    assert recorded.end is not None
    assert CASES[name] in recorded.end["message"]
    assert list(recorded.entries) == list(found.run.entries)
    checked = replay(recorded, S, G)
    assert checked.accepted_by_plant
    assert checked.accepted_by_supervisor
    # safe: the fingers stand still, and what was held is still held
    lift = found.recording[:, found.channels.index("lift_command_1")]
    assert lift[-1] == lift[-2]
    assert not found.score.dropped


def test_every_kind_of_fault_is_tried() -> None:
    assert {name.partition(":")[0] for name in CASES} == set(FAULTS)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("silent", "write KIND:PART"),
        ("silnt:incip_slip", "unknown fault 'silnt'; did you mean 'silent'"),
        ("silent:incip_slp", "unknown event with a detector 'incip_slp'; did you mean 'incip_slip"),
        ("nan:force_1", "unknown sensor 'force_1'"),
    ],
)
def test_a_fault_that_cannot_be_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        fault(text)


def test_the_log_survives_kill_9_up_to_its_last_line(closed_loop: Loop, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "thenar.cli", "run", "glr", "--live", "--out", str(tmp_path)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    log = tmp_path / "log.jsonl"
    for _ in range(300):
        time.sleep(0.1)
        if log.exists() and log.read_bytes().count(b"\n") >= 6:
            break
        assert process.poll() is None, process.stderr.read() if process.stderr else ""
    process.kill()
    process.communicate()
    recorded = read_log(log)
    assert len(recorded.entries) >= 5
    assert recorded.end is None
    checked = replay(recorded, *closed_loop("paper"))
    assert checked.accepted_by_plant
    assert checked.accepted_by_supervisor
