"""Extended problems in model files: what a file means, and that what is written reads back the same."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import thenar
from thenar.errors import InputError
from thenar.io import dumps, expressions, load, loads, save, tables
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE, Expression, Name, Operation, parse
from thenar.model.extended import Condition, Edge, ExtendedAutomaton, ExtendedProblem, disables, invariant, needs
from thenar.model.problem import Problem
from thenar.model.variables import Variable
from thenar.testing.strategies import extended_problems

CELL = ExtendedProblem(
    [
        ExtendedAutomaton.from_edges(
            "CUP 1",
            [
                ("up", "fill", "up", "CELL.n < 3 or ready", {"CELL.n": "CELL.n + 1", "ready": "false"}),
                ("up", "fill", "on -> side", "CELL.n == 3"),
                ("up", "fill", "up"),
                ("up", "fill", "on -> side"),
                ("on -> side", "pour", "up", "true", {"lamp": "'dark red'"}),
            ],
            initial=["on -> side", "up"],
            marked=["up"],
            alphabet=["stop"],
            meaning="A cup.",
        ),
        invariant("'CUP 1'['up'] or lamp == red", name="physics"),
        needs("pour", "CELL.n > -1"),
    ],
    [
        thenar.Automaton.from_transitions(["0 -pour-> 1 -pour-> 0"], initial="0", name="TURNS"),
        disables("TURNS['0'] and not ready", "fill", meaning="Not now."),
    ],
    variables=[
        Variable("CELL.n", range(-1, 4), [0, 1], [3]),
        Variable("ready", [False, True], True),
        Variable("lamp", ["red", "dark red"], marked=[]),
        Variable("size", [1, 2, 4]),
        Variable("no", [True]),
    ],
    initial="CELL.n == 0 or ready",
    marked="lamp == red",
    name="cell",
    alphabet=Alphabet(["stop", "pour", "fill"]),
)


def content(problem: Problem | ExtendedProblem) -> tuple[object, ...]:
    p = ExtendedProblem.of(problem)
    events = [(e, e.meaning) for e in p.alphabet]
    conditions = (p.plant_conditions, p.spec_conditions, p.initial, p.marked)
    return p.name, p.description, events, p.plants, p.specs, p.variables, conditions


def ordered(problem: ExtendedProblem) -> ExtendedProblem:
    """Return ``problem`` with the events of each automaton in the order of the problem: all that a file forgets."""

    def of(a: ExtendedAutomaton) -> ExtendedAutomaton:
        own = problem.alphabet.restrict(a.alphabet.names)
        edges = (Edge(e.source, own.index(a.alphabet[e.event]), e.target, e.guard, e.updates) for e in a.edges)
        return ExtendedAutomaton(a.name, own, a.states, a.initial, a.marked, tuple(edges), meaning=a.meaning)

    return ExtendedProblem(
        [*map(of, problem.plants), *problem.plant_conditions],
        [*map(of, problem.specs), *problem.spec_conditions],
        variables=problem.variables,
        initial=problem.initial,
        marked=problem.marked,
        name=problem.name,
        alphabet=problem.alphabet,
        description=problem.description,
    )


def test_toml_reads_well() -> None:
    assert (
        dumps(CELL)
        == """\
name = "cell"
initial = "CELL.n == 0 or ready"
marked = "lamp == red"

[events]
stop = {}
pour = {}
fill = {}

[variables]
"CELL.n" = { values = "-1..3", initial = [0, 1], marked = 3 }
ready = { values = "bool", initial = true }
lamp = { values = ["red", "dark red"], initial = "red", marked = [] }
size = { values = [1, 2, 4], initial = 1 }
no = { values = [true], initial = true }

[automata."CUP 1"]
kind = "plant"
says = "A cup."
initial = ["on -> side", "up"]
marked = ["up"]
alphabet = ["stop"]
nondeterministic = true
transitions = [
  { arrow = ["up", "fill", "up"], when = "CELL.n < 3 or ready", do = { "CELL.n" = "CELL.n + 1", ready = false } },
  { arrow = ["up", "fill", "on -> side"], when = "CELL.n == 3" },
  ["up", "fill", "up"],
  ["up", "fill", "on -> side"],
  { arrow = ["on -> side", "pour", "up"], do = { lamp = "'dark red'" } },
]

[automata.TURNS]
kind = "spec"
initial = "0"
transitions = [
  "0 -pour-> 1",
  "1 -pour-> 0",
]

[[conditions]]
kind = "plant"
name = "physics"
invariant = "'CUP 1'['up'] or lamp == red"

[[conditions]]
kind = "plant"
event = "pour"
needs = "CELL.n > -1"

[[conditions]]
kind = "spec"
event = "fill"
disabled_when = "TURNS['0'] and not ready"
says = "Not now."
"""
    )


@pytest.mark.parametrize("format", ["toml", "json"])
def test_everything_that_a_problem_can_say_comes_back(format: str) -> None:
    again = loads(dumps(CELL, format), format)
    assert isinstance(again, ExtendedProblem)
    assert content(again) == content(ordered(CELL))
    assert dumps(again, format) == dumps(CELL, format)


@settings(deadline=None)  # the first example imports the parsers
@given(extended_problems(), st.sampled_from(["toml", "json"]))
def test_reading_what_was_written_gives_the_same_problem(problem: ExtendedProblem, format: str) -> None:
    text = dumps(problem, format)
    again = loads(text, format)
    assert content(again) == content(ordered(problem))
    assert dumps(again, format) == text
    assert tomllib.loads(dumps(problem)) == json.loads(dumps(problem, "json"))


def test_what_is_extended_by_nothing_is_a_plain_problem() -> None:
    plain = thenar.library.classics.small_factory()
    again = loads(dumps(ExtendedProblem.of(plain)))
    assert isinstance(again, Problem)
    assert dumps(again) == dumps(plain)


MACHINE = '[events]\na = {}\n[automata.M]\nkind = "plant"\ninitial = "x"\ntransitions = ["x -a-> y"]\n'


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[events]", 'initial = "M.x"\n[events]'),
        ("[events]", 'marked = "true"\n[events]'),
        ("[events]", '[variables]\nn = { values = "bool" }\n[events]'),
        ('"x"', '["x", "y"]'),
        ('"x"', '"x"\nnondeterministic = true'),
        ('"x -a-> y"', '{ arrow = "x -a-> y", when = "M.x" }'),
        ("[automata.M]", '[[conditions]]\nkind = "spec"\ninvariant = "M.x"\n[automata.M]'),
    ],
)
def test_whatever_extends_a_file_makes_it_extended(old: str, new: str) -> None:
    assert isinstance(loads(MACHINE), Problem)
    assert isinstance(loads(MACHINE.replace(old, new)), ExtendedProblem)


@pytest.mark.parametrize(
    ("old", "new"),
    [('"x"', '["x"]'), ('"x -a-> y"', '{ arrow = "x -a-> y" }'), ('"x"', '"x"\nnondeterministic = false')],
)
def test_another_way_to_write_a_plain_file_leaves_it_plain(old: str, new: str) -> None:
    assert dumps(loads(MACHINE.replace(old, new))) == dumps(loads(MACHINE))


def test_one_table_may_be_several_transitions() -> None:
    text = MACHINE.replace('"x -a-> y"', '{ arrow = "x -a,b-> y -a-> x", when = "not M.z" }, "z -a-> x"')
    machine = loads(text.replace("a = {}", "a = {}\nb = {}")).plants[0]
    assert isinstance(machine, ExtendedAutomaton)
    assert [machine.place(k) for k in range(4)] == [
        "edge 1 (x -a-> y)",
        "edge 2 (x -b-> y)",
        "edge 3 (y -a-> x)",
        "edge 4 (z -a-> x)",
    ]
    assert [str(e.guard) for e in machine.edges] == ["not M.z"] * 3 + ["true"]


def test_guards_tell_transitions_apart() -> None:
    both = '{ arrow = "x -a-> y", when = "M.x" }, { arrow = "x -a-> x", when = "not M.x" }'
    assert len(loads(MACHINE.replace('"x -a-> y"', both)).plants) == 1


def test_several_files_make_one_problem(tmp_path: Path) -> None:
    (tmp_path / "plant.toml").write_text('initial = "n < 2"\n[variables]\nn = { values = "0..2" }\n' + MACHINE)
    (tmp_path / "rules.json").write_text(
        '{"initial": "not ready", "variables": {"ready": {"values": "bool"}}, '
        '"conditions": [{"kind": "spec", "event": "a", "needs": "n > 0 or ready"}]}'
    )
    problem = load(tmp_path / "plant.toml", tmp_path / "rules.json")
    assert isinstance(problem, ExtendedProblem)
    assert [v.name for v in problem.variables] == ["n", "ready"]
    assert [str(c) for c in problem.spec_conditions] == ["a needs n > 0 or ready"]
    assert (problem.name, str(problem.initial)) == ("plant", "n < 2 and not ready")


def test_cif_models_are_written_too(tmp_path: Path) -> None:
    text = (
        "controllable c; uncontrollable u; plant p: disc int[0..3] n; disc bool b; location a: initial; marked; "
        "edge c when n < 3 do n := n + 1, b := not b; edge u when n > 0 do n := n - 1; end requirement p.n < 3;"
    )
    problem = loads(text, "cif")
    assert isinstance(problem, thenar.ExtendedProblem)
    save(problem, tmp_path / "p.toml")
    again = load(tmp_path / "p.toml")
    assert content(again)[2:] == content(ordered(problem))[2:]
    assert thenar.synthesize(again).size == thenar.synthesize(problem).size


# -- what cannot be written --------------------------------------------------------------------------------------

CUP = ExtendedAutomaton.from_edges("M", ["x -go-> x"], initial="x")


def shared(times: int) -> Expression:
    """Return an expression that is short in memory, and long written out."""
    whole: Expression = Operation("or", (Name("n"), Name("n")))
    for _ in range(times):
        whole = Operation("and", (whole, whole))
    return whole


def deep(times: int) -> Expression:
    return Operation("not", (deep(times - 1),)) if times else parse("n")


@pytest.mark.parametrize(
    ("predicate", "message"),
    [
        (shared(18), "condition 'C': an expression of 1,048,575 names and operators is too long for a model file"),
        (deep(201), "condition 'C': an expression nested deeper than 200 cannot be read from a model file"),
        (
            Operation("or", (parse("M['" + "x" * 60_000 + "']"),) * 2),
            "condition 'C': an expression of 120,008 characters is too long for a model file",
        ),
    ],
)
def test_an_expression_that_could_not_be_read_is_not_written(predicate: Expression, message: str) -> None:
    with pytest.raises(InputError) as caught:
        expressions.written(predicate, "condition 'C'")
    assert str(caught.value) == message


def test_an_expression_as_deep_as_may_be_comes_back() -> None:
    problem = ExtendedProblem([CUP], [Condition(deep(200))], variables=[Variable("n", [False, True])])
    assert content(loads(dumps(problem))) == content(problem)
    assert expressions.written(TRUE, "here") == "true"


def test_all_expressions_together_have_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "MAX_TEXT", 20)
    problem = ExtendedProblem([CUP], [invariant("M.x or not M.x")] * 2)
    message = "^expressions of more than 20 characters together are too long for a model file$"
    with pytest.raises(InputError, match=message):
        dumps(problem)
