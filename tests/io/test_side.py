"""What a format has no words for stands in a table beside the file."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest
from tests.io.test_writing import content

import thenar
from thenar.errors import InputError
from thenar.io import load, save
from thenar.library import glr
from thenar.library.classics import small_factory
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.testing.random_models import random_problem


def saved_and_loaded(problem: thenar.Problem, folder: Path, format: str) -> thenar.Problem:
    saved = save(problem, folder, format)
    again = load(*(file for file in saved.files if not file.name.endswith(".names.json")))
    assert isinstance(again, thenar.Problem)
    return again


@pytest.mark.parametrize("format", ["tct", "ads", "faudes", "desuma"])
def test_a_problem_comes_back_from_a_folder_of_files_and_tables(tmp_path: Path, format: str) -> None:
    problem = glr.problem()
    again = saved_and_loaded(problem, tmp_path, format)
    assert [a.name for a in again.plants] == [a.name for a in problem.plants]
    assert [a.name for a in again.specs] == [a.name for a in problem.specs]
    assert set(again.alphabet) == set(problem.alphabet)
    for before in problem.automata:
        after = again.automaton(before.name)
        assert after.meaning == before.meaning
        assert {(e, e.meaning) for e in after.alphabet} == {(e, e.meaning) for e in before.alphabet}
        assert thenar.is_isomorphic(after, before)
        assert {after.states[q] for q in range(after.n_states)} == {before.states[q] for q in range(before.n_states)}
    assert thenar.synthesize(again).size == thenar.synthesize(problem).size


def test_the_files_of_a_problem_agree_on_their_numbers(tmp_path: Path) -> None:
    save(small_factory(), tmp_path, "tct")
    tables = [json.loads(file.read_text()) for file in sorted(tmp_path.glob("*.names.json"))]
    labels: dict[str, str] = {}
    for table in tables:
        for label, event in table["events"].items():
            assert labels.setdefault(event["name"], label) == label
            assert int(label) % 2 == event["controllable"]
    assert len(set(labels.values())) == len(labels)


def test_random_problems_come_back_from_tct_files(tmp_path: Path) -> None:
    rng = Random(5)
    for k in range(100):
        problem = random_problem(rng)
        (tmp_path / str(k)).mkdir()
        again = saved_and_loaded(problem, tmp_path / str(k), "tct")
        assert thenar.synthesize(again).size == thenar.synthesize(problem).size


def test_events_keep_their_numbers_in_a_folder(tmp_path: Path) -> None:
    """TCT puts files together by the numbers of their events: what is written later has to agree."""
    problem = small_factory()
    save(problem, tmp_path, "tct")
    again = load(*sorted(tmp_path.glob("*.DES")))
    assert isinstance(again, thenar.Problem)
    save(thenar.synthesize(again).supervisor.automaton, tmp_path / "SUP.DES")
    tables = [json.loads(file.read_text())["events"] for file in tmp_path.glob("*.names.json")]
    labels = {(event["name"], label) for table in tables for label, event in table.items()}
    assert len(labels) == len({name for name, _ in labels}) == len({label for _, label in labels}) == 8


def test_a_specification_that_is_named_is_one_whatever_its_table_says(tmp_path: Path) -> None:
    for automaton in small_factory().automata:
        save(automaton, tmp_path / f"{automaton.name}.DES")
    plants = [tmp_path / f"MACHINE{k}.DES" for k in (1, 2)]
    assert thenar.synthesize(load(*plants, specs=tmp_path / "BUFFER1.DES")).size.states == 12


def test_a_folder_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    lamp = Automaton.from_transitions(["off -on-> lit"], initial="off", name="A")
    two = thenar.ExtendedAutomaton.from_edges("B", ["x -a-> y"], initial=["x", "y"])
    with pytest.raises(InputError, match="starts in 2 states"):
        save(thenar.ExtendedProblem([lamp, two]), tmp_path, "tct")
    assert not list(tmp_path.iterdir())


def test_states_that_a_writer_adds_are_dropped_again(tmp_path: Path) -> None:
    """TCT knows the events that occur in some transition only; so one that is blocked is looped out of reach."""
    lock = Automaton.from_transitions(["shut -knock-> shut"], initial="shut", alphabet=["open"], name="LOCK")
    saved = save(lock, tmp_path / "LOCK.DES")
    assert any("open" in note for note in saved.notes)
    assert content(load(tmp_path / "LOCK.DES").plants[0]) == content(lock)  # type: ignore[arg-type]
    (tmp_path / "LOCK.DES.names.json").unlink()
    assert load(tmp_path / "LOCK.DES").plants[0].alphabet.names == ("1", "3")


def test_a_specification_is_named_as_one(tmp_path: Path) -> None:
    lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    once = Automaton.from_transitions(["0 -on-> 1"], initial="0", marked=["1"], name="ONCE")
    save(lamp, tmp_path / "lamp.gen")
    save(once, tmp_path / "once.gen")
    problem = load(tmp_path / "lamp.gen", specs=tmp_path / "once.gen")
    assert [a.name for a in problem.plants] == ["LAMP"]
    assert [a.name for a in problem.specs] == ["ONCE"]


def test_a_generator_without_flags_takes_them_from_the_others(tmp_path: Path) -> None:
    """libFAUDES's specifications are plain generators, and say nothing of control."""
    lamp = Automaton.from_transitions(
        ["off -on-> lit -fail-> off"], initial="off", uncontrollable=["fail"], name="LAMP"
    )
    save(lamp, tmp_path / "lamp.gen")
    (tmp_path / "once.gen").write_text(
        "<Generator> once <TransRel> 1 on 2 </TransRel> <InitStates> 1 </InitStates> </Generator>"
    )
    assert not load(tmp_path / "once.gen").alphabet["on"].controllable
    problem = load(tmp_path / "lamp.gen", specs=tmp_path / "once.gen")
    assert problem.alphabet == lamp.alphabet
    assert load(tmp_path / "once.gen", tmp_path / "lamp.gen").alphabet["on"].controllable


def test_what_an_automaton_says_stands_in_the_table(tmp_path: Path) -> None:
    lamp = Automaton.from_transitions(
        ["off -1-> lit"], initial="off", states=["off", "lit"], name="lamp", meaning="It glows."
    )
    for ending in (".DES", ".gen", ".fsm", ".dot", ".mmd", ".xmd"):
        saved = save(lamp, tmp_path / f"lamp{ending}")
        assert not saved.notes
        assert load(tmp_path / f"lamp{ending}").plants[0].meaning == "It glows."


def test_automata_of_one_name_are_called_after_their_files(tmp_path: Path) -> None:
    for k in (1, 2):
        machine = Automaton.from_transitions([f"i -s{k}-> w"], initial="i", marked=["i"], name="Generator")
        save(machine, tmp_path / f"machine{k}.gen")
    assert [a.name for a in load(tmp_path / "machine1.gen", tmp_path / "machine2.gen").plants] == [
        "machine1",
        "machine2",
    ]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        ({"states": ["a", "b", "c", "d"]}, "is of 2 states, and names 4"),
        ({"events": {"5": {"name": "on"}}}, "has no event '1'"),
        ({"kind": "robot"}, "kind: input should be 'plant' or 'spec'"),
        ({"events": {"1": {"name": 3}}}, "events.1.name: input should be a valid string"),
        ({"states": [1, 2]}, "states.0: input should be a valid string"),
        ({"states": ["a", "a"]}, "two states are called 'a'"),
        ({"events": {"1": {"name": "on"}, "3": {"name": "on"}}}, "duplicate event 'on'"),
        ({"size": [3, 2]}, "is of 3 states, and the file has 2"),
        ({"size": [2, 1]}, "is of 1 transitions, and the file has 2"),
    ],
)
def test_a_table_that_does_not_fit_its_file_is_refused(tmp_path: Path, edit: dict[str, object], message: str) -> None:
    lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    save(lamp, tmp_path / "lamp.DES")
    beside = tmp_path / "lamp.DES.names.json"
    beside.write_text(json.dumps(json.loads(beside.read_text()) | edit))
    with pytest.raises(InputError) as caught:
        load(tmp_path / "lamp.DES")
    assert message in str(caught.value)
    assert "lamp.DES.names.json" in str(caught.value)


@pytest.mark.parametrize("text", ["", "[]", "{", '"x"', "null", "\x00"])
def test_a_table_that_is_none_is_refused(tmp_path: Path, text: str) -> None:
    lamp = Automaton.from_transitions(["off -on-> lit"], initial="off", name="LAMP")
    save(lamp, tmp_path / "lamp.DES")
    (tmp_path / "lamp.DES.names.json").write_text(text)
    with pytest.raises(InputError, match=r"lamp\.DES\.names\.json"):
        load(tmp_path / "lamp.DES")


def test_several_automata_need_a_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds one automaton, and there are 3; name a folder"):
        save(small_factory(), tmp_path / "factory.DES")
    with pytest.raises(InputError, match="holds one automaton, and there are 3; save"):
        thenar.dumps(small_factory(), "ads")
    with pytest.raises(InputError, match="say which format"):
        save(small_factory(), tmp_path)
    twins = [Automaton.from_transitions([f"0 -{n}-> 0"], initial="0", name=n) for n in ("a:b", "A/B")]
    with pytest.raises(InputError, match="would share the file"):
        save(thenar.Problem(twins), tmp_path, "ads")
    assert not list(tmp_path.iterdir())


def test_variables_are_refused_where_there_are_no_words_for_them(tmp_path: Path) -> None:
    cup = thenar.ExtendedAutomaton.from_edges("CUP", [("up", "fill", "up", "n < 3", {"n": "n + 1"})], initial="up")
    problem = thenar.ExtendedProblem(cup, variables=[thenar.Variable("n", range(4))])
    with pytest.raises(InputError, match="has variables, for which TCT DES has no words; thenar convert --flatten"):
        save(problem, tmp_path / "cup.DES")
    with pytest.raises(InputError, match="has a guard or an update"):
        thenar.dumps(cup, "faudes")


def test_a_format_that_is_written_only_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "x.hoa").write_text("HOA: v1")
    with pytest.raises(InputError, match="is written only"):
        load(tmp_path / "x.hoa")


def test_a_stale_table_goes_when_the_file_is_written_anew(tmp_path: Path) -> None:
    sigma = Alphabet([Event("1"), Event("2", controllable=False)])
    save(Automaton.from_transitions(["x -1-> y"], initial="x", name="M"), tmp_path / "M.DES")
    assert (tmp_path / "M.DES.names.json").exists()
    plain = Automaton.from_arrays(sigma, [0, 1, 2], [0, 1], [1, 0], marked=[True, False], name="M")
    save(plain, tmp_path / "M.DES")
    assert not (tmp_path / "M.DES.names.json").exists()
    assert content(load(tmp_path / "M.DES").plants[0]) == content(plain)  # type: ignore[arg-type]
