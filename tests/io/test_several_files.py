"""Several files make one problem, and disagree in ways of their own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from thenar.errors import AlphabetClash, ModelError
from thenar.io import load

Says = Callable[..., None]

PLANT = '[automata.M]\nkind = "plant"\ninitial = "x"\n'
SPEC = '[automata.S]\nkind = "spec"\ninitial = "x"\n'


def test_several_files_make_one_problem(tmp_path: Path) -> None:
    (tmp_path / "events.json").write_text('{"name": "all", "events": {"a": {"meaning": "first"}, "b": {}}}')
    (tmp_path / "plant.toml").write_text(
        'name = "part"\n[events]\nc = {}\na = { meaning = "second" }\n'
        '[automata.P]\nkind = "plant"\ninitial = "x"\ntransitions = ["x -b,c-> x"]'
    )
    (tmp_path / "spec.toml").write_text('[automata.S]\nkind = "spec"\ninitial = "x"\ntransitions = ["x -a-> x"]')
    problem = load(tmp_path / "events.json", str(tmp_path / "plant.toml"), tmp_path / "spec.toml")
    assert problem.alphabet.names == ("a", "b", "c")
    assert [a.name for a in problem.automata] == ["P", "S"]
    assert (problem.name, problem.alphabet["a"].meaning) == ("all", "first")


def test_an_event_with_two_meanings_names_both_files(files_say: Says) -> None:
    files_say(
        {
            "hand.toml": "[events]\nslip = { controllable = false }\n" + PLANT,
            "specs.toml": "[events]\nslip = {}\n" + SPEC,
        },
        "event 'slip' is uncontrollable in 'hand.toml' and controllable in 'specs.toml'; give it one meaning",
        error=AlphabetClash,
    )


def test_a_broken_event_is_no_clash(files_say: Says) -> None:
    files_say(
        {
            "hand.toml": "[events]\nslip = { controllable = 'false' }\n" + PLANT,
            "specs.toml": "[events]\nslip = { controllable = false }\n" + SPEC,
        },
        "hand.toml:2: event 'slip', controllable: expected true or false, found the text 'false'",
        error=ModelError,
    )


def test_an_automaton_has_one_home(files_say: Says) -> None:
    files_say(
        {"hand.toml": PLANT, "specs.toml": "\n" + PLANT},
        "specs.toml:2: automaton 'M': already given in hand.toml; rename one of the two",
    )


def test_the_mistakes_of_all_files_are_reported_together(files_say: Says) -> None:
    files_say(
        {"hand.toml": "[events]\nslip = {}\n" + PLANT + "note = 5", "specs.json": '{\n"automata": {"S": 5}}'},
        "hand.toml:6: automaton 'M', note: expected text, found 5",
        "specs.json:2: automaton 'S': expected an object in braces, found 5",
    )


def test_what_no_file_gives_is_missing_in_all(files_say: Says) -> None:
    files_say(
        {"events.toml": "[events]\nslip = {}", "specs.toml": SPEC},
        "events.toml, specs.toml: no plant; at least one automaton of kind 'plant' says what can happen",
    )
