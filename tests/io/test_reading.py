"""What a model file means."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from thenar.errors import InputError
from thenar.io import dumps, load, loads, save
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.problem import Problem

MACHINE = """
name = "machine"
description = "breaks at times"

[events]
start = {}
finish = { controllable = false, meaning = "a part leaves" }
"break*" = { controllable = false, observable = false }
repair = { forcible = true }

[automata.MACHINE]
kind = "plant"
says = "It works, or it is broken."
note = "after Wonham"
initial = "idle"
marked = ["idle"]
transitions = [
  "idle -start-> busy -finish-> idle",
  ["busy", "break*", "down"],  # a triple, and a comment
  "down -repair-> idle",
]

[automata.ONCE]
kind = "spec"
initial = "fresh"
alphabet = ["repair"]
transitions = ["fresh -start,finish-> fresh"]

[computed]
G = [3, 4]
"""


def plain(text: str, format: str | None = None) -> Problem:
    """Load a file without variables, guards and conditions."""
    problem = loads(text, format)
    assert isinstance(problem, Problem)
    return problem


def test_events_have_the_properties_written_in_the_file() -> None:
    events = loads(MACHINE).alphabet
    assert events.names == ("start", "finish", "break*", "repair")
    assert [e.properties for e in events] == [
        ("controllable",),
        ("uncontrollable",),
        ("uncontrollable", "unobservable"),
        ("controllable", "forcible"),
    ]
    assert events["finish"].meaning == "a part leaves"


def test_automata_have_the_states_and_transitions_written_in_the_file() -> None:
    problem = plain(MACHINE)
    machine, once = problem.automaton("MACHINE"), problem.automaton("ONCE")
    assert (problem.name, problem.description) == ("machine", "breaks at times")
    assert (problem.plants, problem.specs) == ((machine,), (once,))
    assert list(machine.transitions()) == [
        ("idle", "start", "busy"),
        ("busy", "finish", "idle"),
        ("busy", "break*", "down"),
        ("down", "repair", "idle"),
    ]
    assert machine.meaning == "It works, or it is broken."
    assert machine.marks("start, break*, repair")
    assert not machine.marks("start")


def test_one_arrow_carries_several_events_and_alphabet_adds_what_is_blocked() -> None:
    once = plain(MACHINE).automaton("ONCE")
    assert list(once.transitions()) == [("fresh", "start", "fresh"), ("fresh", "finish", "fresh")]
    assert once.alphabet.names == ("start", "finish", "repair")


def test_listed_states_number_the_states() -> None:
    text = (
        '[events]\na = {}\n[automata.M]\nkind = "plant"\ninitial = "y"\nstates = ["z", "y"]\ntransitions = ["y -a-> z"]'
    )
    machine = plain(text).plants[0]
    assert (list(machine.states), machine.initial) == (["z", "y"], 1)  # type: ignore[call-overload]


def test_json_says_the_same_as_toml() -> None:
    from_toml = loads(MACHINE)
    from_json = loads(dumps(from_toml, "json"))
    assert dumps(from_json) == dumps(from_toml)


def test_an_automaton_needs_no_events() -> None:
    assert plain('[automata.M]\nkind = "plant"\ninitial = "x"').plants[0].n_states == 1


def test_the_grasp_lift_replace_model_loads(glr: Path) -> None:
    problem = load(glr)
    assert isinstance(problem, Problem)
    assert (
        repr(problem) == "Problem 'grasp_lift_replace': 2 plants, 5 specs, 28 events (6 uncontrollable)"
    )  # sizes: README of the model
    written = json.loads(glr.read_text())
    assert list(problem.alphabet.names) == list(written["events"])
    for automaton in problem.automata:
        table = written["automata"][automaton.name]
        assert [automaton.states[q] for q in range(automaton.n_states)] == table["states"]
        assert {*automaton.transitions()} == {tuple(t) for t in table["transitions"]}
        assert automaton.meaning == table.get("says", "")


# -- where it comes from -------------------------------------------------------------------------------------


@pytest.mark.parametrize("format", ["toml", "json"])
def test_standard_input_tells_its_format_by_itself(format: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = dumps(loads(MACHINE), format)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"\xef\xbb\xbf\n" + text.encode())))
    problem = load("-")
    assert isinstance(problem, Problem)
    assert dumps(problem, format) == text


def test_endings_may_be_in_capitals(tmp_path: Path) -> None:
    (tmp_path / "MACHINE.TOML").write_text(MACHINE)
    assert load(tmp_path / "MACHINE.TOML").name == "machine"


def test_windows_line_ends_and_byte_order_marks_are_fine(tmp_path: Path) -> None:
    (tmp_path / "machine.toml").write_bytes(b"\xef\xbb\xbf" + MACHINE.replace("\n", "\r\n").encode())
    assert load(tmp_path / "machine.toml").name == "machine"


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(InputError, match=r"^unknown format 'yaml'$"):
        loads("", "yaml")
    with pytest.raises(InputError, match=r"^unknown format 'tml'; did you mean 'toml'\?$"):
        dumps(loads(MACHINE), "tml")


# -- cost ----------------------------------------------------------------------------------------------------


def test_importing_io_brings_neither_pydantic_nor_tree_sitter() -> None:
    code = "import sys, thenar.io; print([m for m in sys.modules if m.startswith(('pydantic', 'tree_sitter'))])"
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert output.stdout == "[]\n"


def test_reading_a_sound_file_brings_no_tree_sitter() -> None:
    code = (
        "import sys, thenar.io; "
        """thenar.io.loads('[automata.M]\\nkind = "plant"\\ninitial = "x"'); """
        "print([m for m in sys.modules if m.startswith('tree_sitter')])"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert output.stdout == "[]\n"


@pytest.fixture(scope="module")
def large() -> Automaton:
    """20,000 states, 100,000 transitions."""
    n, degree = 20_000, 5
    targets = np.random.default_rng(7).integers(0, n, n * degree)
    events = np.tile(np.arange(degree), n)
    return Automaton.from_arrays(
        Alphabet([f"e{k}" for k in range(degree)]),
        np.arange(n + 1) * degree,
        events,
        targets,
        marked=np.ones(n, bool),
        name="LARGE",
    )


@pytest.mark.parametrize("format", ["toml", "json"])
def test_a_hundred_thousand_transitions_load_in_two_seconds(format: str, large: Automaton, tmp_path: Path) -> None:
    save(large, tmp_path / f"large.{format}")
    start = time.process_time()
    problem = load(tmp_path / f"large.{format}")
    assert isinstance(problem, Problem)
    assert problem.plants[0].n_transitions == 100_000
    assert time.process_time() - start < 2.0


@pytest.mark.parametrize("break_it", [("-e", "-f"), ("-> ", "-> q"), ('"0', '"_0')])
def test_a_hundred_thousand_mistakes_are_told_in_seconds(break_it: tuple[str, str], large: Automaton) -> None:
    text = dumps(large).replace(*break_it)
    start = time.process_time()
    with pytest.raises(InputError):
        loads(text)
    assert time.process_time() - start < 10.0  # an unguarded search for near names takes hours
