"""thenar run, scenarios, replay: the hand from the command line."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from thenar.io import save
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.runtime.record import read_log

THENAR = [sys.executable, "-m", "thenar.cli"]


def thenar(*words: str, folder: Path, code: int = 0) -> subprocess.CompletedProcess[str]:
    found = subprocess.run([*THENAR, *words], capture_output=True, text=True, cwd=folder, check=False)
    assert found.returncode == code, (found.returncode, found.stdout, found.stderr)
    return found


def test_a_run_leaves_its_log_its_channels_and_its_picture(tmp_path: Path) -> None:
    found = thenar("run", "glr", "--seed", "3", folder=tmp_path)
    assert "complete" in found.stdout
    assert "physically  success" in found.stdout
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["episode.mcap", "episode.png", "log.jsonl"]
    assert (tmp_path / "out" / "episode.png").read_bytes().startswith(b"\x89PNG")
    again = thenar("replay", "out/log.jsonl", "--json", folder=tmp_path)
    told = json.loads(again.stdout)
    assert told["accepted_by_plant"]["holds"]
    assert told["accepted_by_supervisor"]["holds"]


def test_json_prints_one_object_with_what_was_promised(tmp_path: Path) -> None:
    words = ["--mass", "0.2", "--mu", "0.7", "--stiffness", "5000", "--json", "--out", "here"]
    told = json.loads(thenar("run", "glr", *words, folder=tmp_path).stdout)
    assert {
        "discrete_success",
        "physical_success",
        "trace",
        "estimates",
        "truth",
        "latency_ms",
        "violations",
        "sim_s",
        "wall_s",
        "seed",
    } <= set(told)
    assert told["truth"] == {"mu": 0.7, "weight_n": 1.962, "stiffness_n_per_m": 5000.0}
    assert told["estimates"]["weight_n"] == pytest.approx(1.962, rel=0.01)
    assert told["violations"] == []


def test_the_variant_that_was_run_is_the_one_that_is_replayed(tmp_path: Path) -> None:
    words = ["--variant", "extended", "--scenario", "pulled-while-moving"]
    found = thenar("run", "glr", *words, folder=tmp_path, code=1)
    assert "gave up" in found.stdout
    assert "FAILED: DROPPED" in found.stdout
    assert "obj_dropped*" in thenar("replay", "out/log.jsonl", folder=tmp_path).stdout


def test_the_timed_variant_forces_on_the_hand_and_in_the_replay(tmp_path: Path) -> None:
    found = thenar("run", "glr", "--variant", "timed", "--scenario", "heavy", folder=tmp_path)
    assert "glr(timed), scenario heavy, seed 0: complete" in found.stdout
    assert "physically  success" in found.stdout
    told = json.loads(thenar("replay", "out/log.jsonl", "--json", folder=tmp_path).stdout)
    assert told["accepted_by_plant"]["holds"]
    assert told["accepted_by_supervisor"]["holds"]
    assert not told["differences"]
    assert "tick" in told["trace"]


def test_a_log_of_another_supervisor_is_caught(tmp_path: Path) -> None:
    thenar("run", "glr", "--scenario", "misaligned", "--variant", "extended", folder=tmp_path)
    log = tmp_path / "out" / "log.jsonl"
    lines = log.read_text().splitlines()
    k = next(k for k, line in enumerate(lines) if '"event": "approach_2"' in line and '"kind": "event"' in line)
    log.write_text("\n".join([*lines[:k], *lines[k + 1 :]]) + "\n")
    found = thenar("replay", "out/log.jsonl", folder=tmp_path, code=1)
    assert "no after" in found.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scenario", "hevy"], "unknown scenario 'hevy'; did you mean 'heavy'?"),
        (["--hand", "planer"], "unknown hand 'planer'; did you mean 'planar'?"),
        (["--mass", "-1"], "mass_kg must be between 0.05 and 3, not -1.0"),
        (["--sensors", "labs"], "unknown sensor profile 'labs'; did you mean 'lab'?"),
        (["--policy", "shortets"], "unknown policy 'shortets'; did you mean 'shortest'?"),
        (["--policy", "priority(aproach_1)"], "unknown event 'aproach_1'; did you mean 'approach_1'?"),
        (["--variant", "papper"], "unknown variant 'papper'; did you mean 'paper'?"),
        (["--variant", "timde"], "unknown variant 'timde'; did you mean 'timed'?"),
        (["--fault", "silent:incip_slp"], "unknown event with a detector 'incip_slp'; did you mean 'incip_slip*'?"),
        (["--seed", "-1"], "-1 is not in the range x>=0"),
    ],
)
def test_bad_input_is_one_message_before_anything_moves(tmp_path: Path, words: list[str], message: str) -> None:
    found = thenar("run", "glr", *words, folder=tmp_path, code=2)
    assert message in found.stderr
    assert "Traceback" not in found.stderr
    assert not list(tmp_path.rglob("*.*"))


def test_a_model_whose_events_have_no_skill_is_refused(tmp_path: Path) -> None:
    found = thenar("run", "small_factory", folder=tmp_path, code=2)
    assert "event 'start_1': controllable, but the driver has no skill for it" in found.stderr
    assert not list(tmp_path.rglob("*.*"))


def test_a_task_without_a_supervisor_says_why(tmp_path: Path) -> None:
    problem = glr.problem()
    never = Automaton.from_transitions(
        [], initial="0", marked=["0"], events=problem.alphabet, alphabet=["incip_slip*"], name="NO_SLIP"
    )
    stuck = Automaton.from_transitions(["0 -approach_1-> 1"], initial="0", events=problem.alphabet, name="STUCK")
    save(
        Problem(problem.plants, [*problem.specs, never, stuck], name="stuck", alphabet=problem.alphabet),
        tmp_path / "stuck.toml",
    )
    found = thenar("run", "stuck.toml", folder=tmp_path, code=1)
    assert "No supervisor exists: STUCK alone makes it impossible" in found.stdout
    assert not (tmp_path / "out" / "log.jsonl").exists()


def test_scenarios_are_listed_with_what_they_provoke(tmp_path: Path) -> None:
    told = json.loads(thenar("scenarios", "--json", folder=tmp_path).stdout)
    assert {
        "name": "heavy",
        "says": "1.2 kg at mu 0.5",
        "provokes": "incip_slip*",
        "ends": "complete",
        "hole": False,
    } in told
    text = thenar("scenarios", folder=tmp_path).stdout
    assert all(s["name"] in text for s in told)


def test_ctrl_c_stops_the_hand_and_keeps_the_log(tmp_path: Path) -> None:
    process = subprocess.Popen([*THENAR, "run", "glr", "--live"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    log = tmp_path / "out" / "log.jsonl"
    for _ in range(300):
        time.sleep(0.1)
        if log.exists() and log.read_bytes().count(b"\n") >= 4:
            break
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=10)
    assert process.returncode == 130
    assert "interrupted; the fingers stand still, the log is in" in told
    end = read_log(log).end
    assert end is not None
    assert end["message"] == "interrupted from the keyboard"


def test_an_operator_chooses_at_the_terminal(tmp_path: Path) -> None:
    main, terminal = pty.openpty()
    process = subprocess.Popen(
        [*THENAR, "run", "glr", "--policy", "operator"],
        cwd=tmp_path,
        stdin=terminal,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    os.close(terminal)
    for answer in ("aproach_1", "approach_1", "q"):
        os.write(main, f"{answer}\n".encode())
    told, _ = process.communicate(timeout=60)
    os.close(main)
    assert process.returncode == 1
    assert "'aproach_1' cannot be started here" in told
    assert "the operator stopped the run" in told
    events = [e["event"] for e in read_log(tmp_path / "out" / "log.jsonl").entries if e["kind"] == "event"]
    assert events == ["approach_1"]


def test_a_log_is_not_replayed_against_another_supervisor_of_the_same_name(tmp_path: Path) -> None:
    problem = glr.problem()
    never = Automaton.from_transitions(
        [], initial="0", marked=["0"], events=problem.alphabet, alphabet=["stiffness_EP*"], name="GENTLE"
    )
    save(
        Problem(problem.plants, [*problem.specs, never], name="glr", alphabet=problem.alphabet), tmp_path / "mine.toml"
    )
    thenar("run", "mine.toml", folder=tmp_path, code=1)
    assert "line 1: the log is of supervisor" in thenar("replay", "out/log.jsonl", folder=tmp_path, code=1).stdout
    thenar("replay", "out/log.jsonl", "mine.toml", folder=tmp_path)
