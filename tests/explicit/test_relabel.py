"""Renaming events, also so that two become one."""

from random import Random

import pytest

import thenar
from thenar.errors import AlphabetClash, UnknownName
from thenar.explicit.relabel import relabel
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.testing.random_models import random_alphabet, random_automaton
from thenar.testing.regular_oracle import strings


def test_the_languages_are_the_images_of_the_languages() -> None:
    for seed in range(300):
        rng = Random(seed)
        a = random_automaton(rng, random_alphabet(rng, max_events=5))
        new = {e: Event(rng.choice("pq")) for e in a.alphabet.names if rng.random() < 0.7}
        image = relabel(a, new)
        for marked in (True, False):
            wanted = {tuple(new[e].name if e in new else e for e in s) for s in strings(a, 4, marked=marked)}
            assert set(strings(image, 4, marked=marked)) == wanted, seed


def test_renaming_one_by_one_keeps_the_states() -> None:
    lamp = Automaton.from_transitions(
        ["off -on-> lit -off!-> off"], initial="off", uncontrollable=["off!"], name="LAMP"
    )
    renamed = relabel(lamp, {"off!": "fail"}, name="BULB")
    assert [renamed.states[q] for q in range(2)] == ["off", "lit"]
    assert renamed.alphabet["fail"] == Event("fail", controllable=False)
    assert thenar.is_isomorphic(relabel(renamed, {"fail": "off!"}), lamp)


def test_what_cannot_be_reached_is_dropped_whether_events_become_one_or_not() -> None:
    a = Automaton.from_transitions(["lost -x-> 1", "1 -y-> 0", "0 -x,y-> 1"], initial="0", marked=["1"])
    for names in ({}, {"x": "z"}, {"x": "z", "y": "z"}):
        image = relabel(a, names)
        assert [image.states[q] for q in range(image.n_states)] == ["0", "1"]


def test_wrong_names_are_refused() -> None:
    lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", uncontrollable=["off"])
    with pytest.raises(UnknownName, match="unknown event 'of'; did you mean 'off'"):
        relabel(lamp, {"of": "x"})
    with pytest.raises(AlphabetClash, match="event 'on' is controllable in 'on, renamed' and uncontrollable"):
        relabel(lamp, {"off": "on"})
