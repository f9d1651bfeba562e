"""Logs: the same run gives the same bytes, a killed one is readable, and a tampered one is found out."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import pytest
from click.testing import CliRunner, Result
from tests.runtime.conftest import Task

from thenar.cli.replay import replay as command
from thenar.errors import InputError
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.runtime.policy import RandomPolicy
from thenar.runtime.record import LogWriter, entry, header, read_log
from thenar.runtime.replay import replay
from thenar.synthesis.api import synthesize

ROOT = Path(__file__).parents[2]


def record(task: Task, path: Path, seed: int = 1, **options: Any) -> Path:
    first = header("glr", variant="paper", seed=seed, events=task.supervisor.automaton.alphabet.names)
    with LogWriter(path, first) as log:
        task.run(task.driver(seed, other=0.002), log=log, **options)
    return path


def change(path: Path, line: int, **fields: object) -> None:
    """Change fields of the entry in a line of a log."""
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[line - 1] = json.dumps(json.loads(lines[line - 1]) | fields)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_the_same_seed_gives_the_same_bytes(task: Task, tmp_path: Path) -> None:
    for seed in range(5):
        a, b = (record(task, tmp_path / name, seed, policy=RandomPolicy(Random(seed))) for name in "ab")
        assert a.read_bytes() == b.read_bytes()
    assert record(task, tmp_path / "c", 1).read_bytes() != record(task, tmp_path / "d", 2).read_bytes()


def test_a_log_is_read_as_the_run_wrote_it(task: Task, tmp_path: Path) -> None:
    first = header("glr", variant="paper", seed=1, events=task.supervisor.automaton.alphabet.names, scenario="nominal")
    with LogWriter(tmp_path / "run.jsonl", first) as log:
        run = task.run(task.driver(1), log=log)
    read = read_log(tmp_path / "run.jsonl")
    assert read.header == first
    assert read.entries == run.entries
    assert (read.torn, read.end) == ("", run.entries[-1])
    assert list(read.entries[2]) == [
        "kind", "t", "event", "plant", "plant_state", "supervisor_state", "enabled", "chosen_by", "sensors",
    ]  # fmt: skip


def test_a_log_cut_off_anywhere_is_read_up_to_its_last_whole_line(task: Task, tmp_path: Path) -> None:
    whole = record(task, tmp_path / "run.jsonl").read_bytes()
    entries = read_log(tmp_path / "run.jsonl").entries
    start = whole.index(b"\n") + 1
    for cut in Random(0).sample(range(start, len(whole)), 60):
        (tmp_path / "cut.jsonl").write_bytes(whole[:cut])
        read = read_log(tmp_path / "cut.jsonl")
        assert read.entries == entries[: whole[start:cut].count(b"\n")]
        assert read.torn.encode() == whole[:cut].rpartition(b"\n")[2]
        assert read.end is None


def test_kill_9_in_the_middle_of_a_run_loses_no_line(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    code = f"""
import time
from tests.runtime.conftest import Task
from tests.runtime.test_record import record
from thenar.explicit.products import sync
from thenar.library import glr
from thenar.synthesis.api import synthesize
from pathlib import Path
problem = glr.problem()
task = Task(synthesize(problem).supervisor, sync(*problem.plants, name="G"))
def watch(entry):
    print(entry["kind"], flush=True)
    time.sleep(0.02)
record(task, Path({str(path)!r}), on_entry=watch)
"""
    child = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    seen = [child.stdout.readline().strip() for _ in range(7)]
    os.kill(child.pid, signal.SIGKILL)
    seen += child.stdout.read().split()
    child.stdout.close()
    assert child.wait() == -signal.SIGKILL
    read = read_log(path)
    assert [e["kind"] for e in read.entries][: len(seen)] == seen
    assert read.torn == ""
    assert read.end is None


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("nonsense", "not a line of JSON: Expecting value"),
        ("[1]", "an entry is a JSON object"),
        ('{"kind": "evnt", "t": 0}', "unknown kind 'evnt'; there are: begin, event, start"),
        ('{"kind": "event", "t": "0", "event": "a"}', "the time t is '0', no number"),
        ('{"kind": "event", "t": 1e999, "event": "a"}', "the time t is inf, no number"),
        ('{"kind": "event", "t": true, "event": "a"}', "the time t is True, no number"),
        ('{"kind": "event", "t": 0}', "an event without a name"),
        ('{"kind": "event", "t": 0, "event": 3}', "event is 3, no text"),
        ('{"kind": "event", "t": 0, "event": "a", "plant_state": "0"}', "plant_state is '0', no whole number"),
        ('{"kind": "event", "t": 0, "event": "a", "enabled": "b"}', "enabled is no list of names"),
        ('{"kind": "header", "t": 0}', "unknown kind 'header'"),
        ("", "not a line of JSON"),
        ("[" * 100_000, "not a line of JSON"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, line: str, message: str) -> None:
    path = tmp_path / "run.jsonl"
    good = [json.dumps(header("glr", events=["a"])), json.dumps(entry("note", 0.0, message="hello"))]
    path.write_text("\n".join([*good, line, good[1]]) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_log(path)
    assert str(caught.value).startswith(f"{path}:3: {message}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "its first line is no header"),
        ('{"kind": "head', "its first line is no header"),
        ('{"kind": "event", "t": 0, "event": "a"}\n', "its first line is no header"),
        ('{"kind": "header", "format": "thenar-log", "version": 2}\n', "version 2 of thenar-log; this thenar reads"),
    ],
)
def test_what_is_no_log_is_said_to_be_none(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "run.jsonl"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_log(path)


def test_a_log_that_cannot_be_written_is_an_error_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no folder"):
        LogWriter(tmp_path / "nowhere" / "run.jsonl", header("glr", events=[]))


def test_a_replay_accepts_what_happened(task: Task, tmp_path: Path) -> None:
    for seed in range(5):
        log = read_log(record(task, tmp_path / "run.jsonl", seed))
        found = replay(log, task.supervisor, task.plant)
        assert found
        assert found.differences == ()
        assert task.supervisor.automaton.generates(found.trace)


def test_a_replay_finds_the_line_where_a_log_was_tampered_with(task: Task, tmp_path: Path) -> None:
    path = record(task, tmp_path / "run.jsonl")
    log = read_log(path)
    events = [k for k, e in enumerate(log.entries, 2) if e["kind"] == "event"]

    change(path, events[1], event="move_to_Z*")
    found = replay(read_log(path), task.supervisor, task.plant)
    assert not found
    assert str(found.accepted_by_plant) == (
        f"accepted by the plant: no after approach_1, move_to_Z*: line {events[1]}: "
        "'move_to_Z*' is impossible in plant state 'approached|neutral'"
    )
    assert found.accepted_by_supervisor.reason.startswith(f"line {events[1]}: 'move_to_Z*' is impossible in supervisor")

    change(path, events[0], event="approach_2")  # the plant can, but finger 1 comes first: SPEC1
    found = replay(read_log(path), task.supervisor, task.plant)
    assert found.accepted_by_supervisor.reason == f"line {events[0]}: 'approach_2' is disabled in supervisor state 0"
    assert found.accepted_by_plant.reason.startswith(f"line {events[1]}: ")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"plant": "released|released"}, "plant is recorded as released|released, but is approached|neutral"),
        ({"plant_state": 7}, "plant_state is recorded as 7, but is 1"),
        ({"supervisor_state": 3}, "supervisor_state is recorded as 3, but is 1"),
        ({"enabled": []}, "enabled is recorded as nothing, but is retract_finger_1, approach_2"),
    ],
)
def test_a_replay_recomputes_every_recorded_state(
    task: Task, tmp_path: Path, fields: dict[str, object], message: str
) -> None:
    path = record(task, tmp_path / "run.jsonl")
    line = next(k for k, e in enumerate(read_log(path).entries, 2) if e["kind"] == "event")
    change(path, line, **fields)
    found = replay(read_log(path), task.supervisor, task.plant)
    assert not found
    assert found.accepted_by_plant
    assert found.accepted_by_supervisor
    assert found.differences == (f"line {line}: {message}",)


def test_an_unknown_event_in_a_log_gets_the_nearest_name(task: Task, tmp_path: Path) -> None:
    path = record(task, tmp_path / "run.jsonl")
    line = next(k for k, e in enumerate(read_log(path).entries, 2) if e["kind"] == "event")
    change(path, line, event="aproach_1")
    found = replay(read_log(path), task.supervisor, task.plant)
    assert found.accepted_by_plant.reason == f"line {line}: unknown event 'aproach_1'; did you mean 'approach_1'?"


def test_the_replay_of_another_supervisor_finds_what_that_one_forbids(
    task: Task, tmp_path: Path, replaced: Callable[[Automaton], Task]
) -> None:
    log = read_log(record(task, tmp_path / "run.jsonl", seed=3))
    spec = Automaton.from_transitions([], initial="0", marked=["0"], alphabet=["dec_gripF*"], name="NO_FRICTION")
    other = replaced(spec)
    found = replay(log, other.supervisor, task.plant)
    assert found.accepted_by_plant
    assert bool(found.accepted_by_supervisor) == ("dec_gripF*" not in found.trace)


def test_without_a_supervisor_nothing_is_accepted(task: Task, tmp_path: Path) -> None:
    none = synthesize(Problem([Automaton.from_transitions(["0 -a-> 1"], initial="0")])).supervisor
    found = replay(read_log(record(task, tmp_path / "run.jsonl")), none, task.plant)
    assert found.accepted_by_supervisor.reason == "no supervisor exists"
    assert found.accepted_by_plant


def thenar_replay(*arguments: object) -> Result:
    return CliRunner().invoke(command, [str(a) for a in arguments])


def test_the_command_finds_the_model_in_the_header(task: Task, tmp_path: Path) -> None:
    path = record(task, tmp_path / "run.jsonl")
    done = thenar_replay(path)
    assert done.exit_code == 0
    assert "accepted by the plant: yes\naccepted by the supervisor: yes\nthe run ended: " in done.output
    change(path, 4, event="approach_2", supervisor_state=5)
    done = thenar_replay(path, "glr", "--json")
    assert done.exit_code == 1
    found = json.loads(done.output)
    assert found["accepted_by_supervisor"]["reason"] == "line 4: 'approach_2' is disabled in supervisor state 0"
    assert found["accepted_by_supervisor"]["witness"] == ["approach_2"]


def test_the_command_says_when_a_log_breaks_off(task: Task, tmp_path: Path) -> None:
    path = record(task, tmp_path / "run.jsonl")
    path.write_bytes(path.read_bytes()[:-5])
    done = thenar_replay(path)
    assert done.exit_code == 0
    assert done.output.endswith("the log breaks off in the middle of a line: the run did not get to its end\n")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"task": "gl"}, ":1: unknown model 'gl'; did you mean 'glr'?; name the model: thenar replay LOG MODEL"),
        ({"task": 3}, ":1: task and variant of a header are texts"),
        ({"variant": "extnded"}, ":1: "),
        ({"task": "chain", "variant": "extended"}, ":1: model 'chain' has no variant 'extended'"),
    ],
)
def test_the_command_names_what_is_wrong_in_a_header(
    task: Task, tmp_path: Path, fields: dict[str, object], message: str
) -> None:
    path = record(task, tmp_path / "run.jsonl")
    change(path, 1, **fields)
    done = thenar_replay(path)
    assert isinstance(done.exception, InputError)
    assert str(done.exception).startswith(f"{path}{message}")
