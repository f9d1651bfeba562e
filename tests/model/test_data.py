"""Models are frozen, strict at the door, and survive a pickle."""

import pickle

import numpy as np
import pytest

import thenar
from thenar.library import glr
from thenar.model.automaton import Automaton


def test_arrays_are_frozen_also_after_a_pickle() -> None:
    supervisor = thenar.synthesize(glr.problem()).supervisor
    for automaton in (glr.finger(1), pickle.loads(pickle.dumps(glr.finger(1))), supervisor.automaton):
        with pytest.raises(ValueError, match="read-only"):
            automaton.targets[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        supervisor.disabled[0] = 1


@pytest.mark.parametrize(
    "error",
    [
        thenar.LimitReached("states", 10, 11, 12),
        thenar.UnknownName("event", "slipp", ["slip"]),
        thenar.ModelError([thenar.Mistake("hand.toml:3", "no initial state"), thenar.Mistake("", "x")]),
        thenar.InputError("wrong"),
    ],
)
def test_errors_survive_a_pickle(error: Exception) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again)) == (type(error), str(error))
    assert again.__dict__ == error.__dict__


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("events", np.array([2**32])),
        ("events", np.array([0.7])),
        ("events", np.array([[0]])),
        ("targets", np.array([2**32 + 1])),
        ("targets", ["1"]),
        ("marked", [2, 0]),
        ("marked", ["False", "True"]),
        ("offsets", [0, 2, 1]),
        ("initial", 5),
    ],
)
def test_hostile_arrays_are_refused_at_the_door(field: str, value: object) -> None:
    good = {"offsets": [0, 1, 1], "events": [0], "targets": [1], "marked": [True, False], "initial": 0}
    alphabet = thenar.Alphabet(["x"])
    assert Automaton.from_arrays(alphabet, **good).n_states == 2  # type: ignore[arg-type]
    with pytest.raises(thenar.ModelError, match="automaton ''"):
        Automaton.from_arrays(alphabet, **{**good, field: value})  # type: ignore[arg-type]


def test_a_text_where_a_list_belongs_is_refused() -> None:
    with pytest.raises(thenar.InputError, match="marked is a list, not the text 'off'"):
        Automaton.from_transitions(["off -on-> lit"], initial="off", marked="off")
    with pytest.raises(thenar.InputError, match="an alphabet is a list of events, not the text 'abc'"):
        thenar.Alphabet("abc")


def test_a_misspelt_uncontrollable_event_is_an_error_whatever_it_comes_in() -> None:
    for names in (["slipp"], (n for n in ["slipp"]), {"slipp"}):
        with pytest.raises(thenar.ModelError, match="unknown event 'slipp'; did you mean 'slip'"):
            Automaton.from_transitions(["a -slip-> b"], initial="a", uncontrollable=names)


def test_the_empty_traces_sign_is_no_event() -> None:
    with pytest.raises(thenar.InputError, match="that is the empty trace"):
        thenar.Event("ε")


def test_limits_are_checked() -> None:
    for wrong in ({"states": -1}, {"states": 1.5}, {"bytes": 2**70}, {"seconds": -1}, {"seconds": float("nan")}):
        with pytest.raises(thenar.InputError, match="limit "):
            thenar.Limits(**wrong)


def test_a_pattern_is_of_a_state_that_exists() -> None:
    supervisor = thenar.synthesize(glr.problem()).supervisor
    for state in (-1, 99_999):
        with pytest.raises(thenar.UnknownName, match="unknown state"):
            supervisor.pattern(state)
