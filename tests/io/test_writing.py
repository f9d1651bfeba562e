"""What is written reads back the same, and reads well."""

from __future__ import annotations

import json
import tomllib
from random import Random
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thenar.errors import InputError
from thenar.io import dumps, loads
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem
from thenar.testing.random_models import random_problem

FACTORY = Problem(
    Automaton.from_transitions(
        ["idle -start-> busy -finish*-> idle"],
        initial="idle",
        marked=["idle"],
        uncontrollable=["finish*"],
        name="MACHINE 1",
        meaning='It "works".',
    ),
    Automaton.from_arrays(
        Alphabet([Event("start"), Event("repair", forcible=True, observable=False, meaning="by hand")]),
        [0, 1, 1],
        [0],
        [0],
        marked=[True, True],
        initial=1,
        name="SPEC",
        states=["a->b", "end"],
    ),
    name="factory",
    description="one machine",
)


def test_toml_reads_well() -> None:
    assert (
        dumps(FACTORY)
        == """\
name = "factory"
description = "one machine"

[events]
start = {}
"finish*" = { controllable = false }
repair = { observable = false, forcible = true, meaning = "by hand" }

[automata."MACHINE 1"]
kind = "plant"
says = "It \\"works\\"."
initial = "idle"
marked = ["idle"]
transitions = [
  "idle -start-> busy",
  "busy -finish*-> idle",
]

[automata.SPEC]
kind = "spec"
initial = "end"
marked = ["a->b", "end"]
states = ["a->b", "end"]
alphabet = ["repair"]
transitions = [
  ["a->b", "start", "a->b"],
]
"""
    )


def test_json_reads_well() -> None:
    assert (
        dumps(FACTORY, "json")
        == """\
{
  "name": "factory",
  "description": "one machine",
  "events": {
    "start": {},
    "finish*": {"controllable": false},
    "repair": {"observable": false, "forcible": true, "meaning": "by hand"}
  },
  "automata": {
    "MACHINE 1": {
      "kind": "plant",
      "says": "It \\"works\\".",
      "initial": "idle",
      "marked": ["idle"],
      "transitions": [
        "idle -start-> busy",
        "busy -finish*-> idle"
      ]
    },
    "SPEC": {
      "kind": "spec",
      "initial": "end",
      "marked": ["a->b", "end"],
      "states": ["a->b", "end"],
      "alphabet": ["repair"],
      "transitions": [
        ["a->b", "start", "a->b"]
      ]
    }
  }
}
"""
    )


def test_a_long_list_stands_one_entry_a_line() -> None:
    states = [f"a rather long name of state {k}" for k in range(4)]
    long = Automaton.from_transitions([], initial=states[0], states=states)
    assert "states = [\n" + "".join(f'  "{q}",\n' for q in states) + "]\n" in dumps(long)


@pytest.mark.parametrize("format", ["toml", "json"])
def test_very_many_transitions_stand_in_one_text(format: str) -> None:
    """Parsers are quicker with it; it is read at a stroke, and by the patient reader to the same effect."""
    n = 2_000
    ring = Automaton.from_transitions(
        [(f"q{k * 7 % n}", f"e{k % 3}", f"q{(k + 1) * 7 % n}") for k in range(n)],
        initial="q0",
        marked=[f"q{k}" for k in range(1_500)],
        alphabet=["never"],
        name="RING",
    )
    assert "q7 -e1-> q14\n" in dumps(ring, format).replace("\\n", "\n")
    assert content(plain(dumps(ring, format), format).plants[0]) == content(ring)


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ("lit -of-> dark", "big.toml:11: automaton 'LAMP', transition 2: unknown event 'of'; did you mean 'off'?"),
        ("lit off dark", "big.toml:11: automaton 'LAMP', transition 2: cannot read 'lit off dark' as transitions"),
        ("dark -on-> dark", "big.toml:11: automaton 'LAMP', transition 2: nondeterministic: 'on' leads from 'dark'"),
    ],
)
def test_a_mistake_in_a_long_text_is_found_in_its_line(wrong: str, complaint: str) -> None:
    file = f"""
[events]
on = {{}}
off = {{}}
[automata.LAMP]
kind = "plant"
initial = "dark"
marked = "dark"
transitions = '''
dark -on-> lit
{wrong}

lit -off-> dark
'''
"""
    with pytest.raises(InputError) as caught:
        loads(file, "toml", "big.toml")
    assert str(caught.value).startswith(complaint)


# -- there and back ------------------------------------------------------------------------------------------

# odd on purpose: what TOML, JSON and arrow texts treat in their own way
NAMES = st.text(
    st.sampled_from("ab1 -_>.*\"'\\#=,[]{}\n\t\r\x00\x7fé\u2028\u0085🤏"), min_size=1, max_size=5
) | st.sampled_from(["-a->", "a -b-> c", " a", "a ", "true", "1.5", "idle|busy", '"""', "'''", "events", "→"])
EVENT_NAMES = NAMES.filter(lambda name: not any(c.isspace() or c == "," for c in name))
TEXTS = st.just("") | st.text(st.characters(exclude_categories=["Cs"]), max_size=10)


@st.composite
def alphabets(draw: st.DrawFn) -> Alphabet:
    names = draw(st.lists(EVENT_NAMES, unique=True, max_size=5))
    flag = st.booleans()
    return Alphabet(Event(n, draw(flag), draw(flag), draw(flag), draw(TEXTS)) for n in names)


@st.composite
def automata(draw: st.DrawFn, alphabet: Alphabet, name: str) -> Automaton:
    """Draw any automaton over a part of ``alphabet``: states may be unreachable, and start anywhere."""
    states = draw(st.lists(NAMES, unique=True, min_size=1, max_size=5))
    own = Alphabet(e for e in alphabet if draw(st.booleans()))
    rows = [[(e, draw(st.integers(-1, len(states) - 1))) for e in range(len(own))] for _ in states]
    taken = [[(e, t) for e, t in row if t >= 0] for row in rows]
    return Automaton.from_arrays(
        own,
        np.cumsum([0, *map(len, taken)]),
        [e for row in taken for e, _ in row],
        [t for row in taken for _, t in row],
        marked=draw(st.lists(st.booleans(), min_size=len(states), max_size=len(states))),
        initial=draw(st.integers(0, len(states) - 1)),
        states=states,
        name=name,
    )


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    alphabet = draw(alphabets())
    names = draw(st.lists(NAMES | st.just(""), unique=True, min_size=1, max_size=4))
    drawn = [draw(automata(alphabet, name)) for name in names]
    plants = draw(st.integers(1, len(drawn)))
    return Problem(drawn[:plants], drawn[plants:], name=draw(TEXTS), alphabet=alphabet, description=draw(TEXTS))


def content(automaton: Automaton) -> tuple[object, ...]:
    events = [(e, e.meaning) for e in automaton.alphabet]
    states = [automaton.states[q] for q in range(automaton.n_states)]
    arrays = (automaton.offsets, automaton.events, automaton.targets, automaton.marked)
    return automaton.name, automaton.meaning, events, states, automaton.initial, [a.tolist() for a in arrays]


def plain(text: str, format: str | None = None) -> Problem:
    """Load a file without variables, guards and conditions."""
    problem = loads(text, format)
    assert isinstance(problem, Problem)
    return problem


@settings(deadline=None)  # the first example imports the parsers
@given(problems(), st.sampled_from(["toml", "json"]))
def test_reading_what_was_written_gives_the_same_problem(problem: Problem, format: str) -> None:
    again = plain(dumps(problem, format), format)
    assert (again.name, again.description) == (problem.name, problem.description)
    assert [(e, e.meaning) for e in again.alphabet] == [(e, e.meaning) for e in problem.alphabet]
    assert [content(a) for a in again.plants] == [content(a) for a in problem.plants]
    assert [content(a) for a in again.specs] == [content(a) for a in problem.specs]


@settings(deadline=None)
@given(problems(), st.sampled_from(["toml", "json"]))
def test_a_text_of_transitions_says_the_same_as_a_list(problem: Problem, format: str) -> None:
    with patch("thenar.io.tables.LONG", 0):
        text = dumps(problem, format)
    again = plain(text, format)
    assert list(map(content, again.automata)) == list(map(content, problem.automata))


@settings(deadline=None)  # the first example imports the parsers
@given(problems(), st.sampled_from(["toml", "json"]))
def test_reading_and_writing_once_more_gives_the_same_bytes(problem: Problem, format: str) -> None:
    text = dumps(problem, format)
    assert dumps(loads(text), format) == text


@settings(deadline=None)  # the first example imports the parsers
@given(problems())
def test_both_formats_carry_the_same_data(problem: Problem) -> None:
    assert tomllib.loads(dumps(problem)) == json.loads(dumps(problem, "json"))


def test_an_automaton_alone_is_a_plant() -> None:
    machine = FACTORY.plants[0]
    [again] = plain(dumps(machine)).plants
    assert content(again) == content(machine)


# -- what cannot be written ----------------------------------------------------------------------------------

EMPTY = Automaton.empty(Alphabet(["a"]), "NONE")
ONE = Automaton.from_transitions([], initial="x")


def states(*names: str, name: str = "M") -> Automaton:
    n = len(names)
    return Automaton.from_arrays(Alphabet(), [0] * (n + 1), [], [], marked=[False] * n, states=names, name=name)


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (EMPTY, "automaton 'NONE' has no states, and a model file needs an initial one; there is nothing to write"),
        (states("a", ""), "automaton 'M': state 1 has an empty name; a model file needs one"),
        (
            states("a", "b", "a"),
            "automaton 'M': two states are called 'a'; a model file tells states by their names",
        ),
        (Problem([ONE, ONE]), "two automata have no name; a model file tells automata by their names"),
        (states("\ud800"), r"a name has the character '\ud800', which UTF-8 does not have; rename it"),
    ],
)
def test_what_the_format_cannot_say_is_refused(model: Problem | Automaton, message: str) -> None:
    with pytest.raises(InputError) as caught:
        dumps(model)
    assert str(caught.value) == message


@pytest.mark.parametrize("format", ["toml", "json"])
def test_a_thousand_random_problems_come_back(format: str) -> None:
    for seed in range(1_000):
        problem = random_problem(Random(seed))
        again = plain(dumps(problem, format), format)
        assert list(map(content, again.automata)) == list(map(content, problem.automata)), seed
        assert again.alphabet == problem.alphabet
