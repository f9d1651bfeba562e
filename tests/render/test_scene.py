from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thenar.errors import InputError, UnknownName
from thenar.library.glr import finger
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.render.scene import Scene, scene
from thenar.testing.random_models import numbered_alphabet, random_automaton
from thenar.testing.strategies import automata


def ring(n: int) -> Automaton:
    arrows = [(str(k), "step", str((k + 1) % n)) for k in range(n)]
    return Automaton.from_transitions([*arrows, ("5", "jump", "0")], initial="0", marked=["0"], name="RING")


def lit_edges(picture: Scene) -> set[tuple[str, str, str]]:
    return {
        (picture.nodes[edge.source].label, label.event.name, picture.nodes[edge.target].label)
        for edge in picture.edges
        for label in edge.labels
        if label.highlighted
    }


@given(automata(max_states=12))
def test_a_small_automaton_is_shown_whole(G: Automaton) -> None:
    picture = scene(G)
    shown = {
        (picture.nodes[edge.source].label, label.event.name, picture.nodes[edge.target].label)
        for edge in picture.edges
        for label in edge.labels
    }
    assert [node.label for node in picture.nodes] == [G.states[q] for q in range(G.n_states)]
    assert shown == set(G.transitions())
    assert sum(len(edge.labels) for edge in picture.edges) == G.n_transitions
    assert len({(edge.source, edge.target) for edge in picture.edges}) == len(picture.edges)
    assert [node.initial for node in picture.nodes].index(True) == G.initial
    assert [node.marked for node in picture.nodes] == G.marked.tolist()
    assert picture.caption == ""


@given(st.integers(0, 10_000), st.integers(1, 40), st.data())
def test_the_limit_is_kept_and_what_is_cut_is_shown(seed: int, limit: int, data: st.DataObject) -> None:
    G = random_automaton(Random(seed), numbered_alphabet([False, True, False]), max_states=60)
    centre = data.draw(st.integers(0, G.n_states - 1))
    picture = scene(G, centre=centre, limit=limit)
    states = {node.state for node in picture.nodes if node.kind == "state"}
    assert len(states) == min(limit, G.n_states) or len(states) < limit < G.n_states
    assert centre in states
    for q in states:
        shown = {
            label.event for edge in picture.edges for label in edge.labels if picture.nodes[edge.source].state == q
        }
        assert shown == set(G.enabled(q))
    entered = {G.states[t] for q in range(G.n_states) if q not in states for _, t in G.row(q) if t in states}
    stubs = {
        picture.nodes[e.target].label for e in picture.edges if picture.nodes[e.source].kind == "cut" and not e.labels
    }
    assert stubs == entered
    if len(states) < G.n_states:
        assert picture.caption == f"{len(states)} of {G.n_states} states, around state {centre}"


def test_the_neighbourhood_looks_ahead_first_and_then_back() -> None:
    one_way = Automaton.from_transitions([f"{k} -on-> {k + 1}" for k in range(60)], initial="0")
    assert [node.state for node in scene(one_way, centre=50, limit=5).nodes if node.kind == "state"] == [*range(50, 55)]
    assert [node.state for node in scene(one_way, centre=58, limit=5).nodes if node.kind == "state"] == [*range(56, 61)]


def test_the_neighbourhood_is_around_the_highlighted_state() -> None:
    assert scene(ring(40), highlight=[7]).caption == "30 of 40 states, around state 7"
    assert scene(ring(40), highlight=[7], centre=3).caption == "30 of 40 states, around state 3"
    assert scene(ring(2_809)).caption == "30 of 2,809 states, around state 0"


def test_a_path_lights_the_states_and_transitions_it_takes() -> None:
    picture = scene(finger(1), path="approach_1, align_finger2*, retract_finger_1")
    assert [node.label for node in picture.nodes if node.passed] == ["neutral", "approached", "aligned"]
    assert lit_edges(picture) == {
        ("neutral", "approach_1", "approached"),
        ("approached", "align_finger2*", "aligned"),
        ("aligned", "retract_finger_1", "neutral"),
    }


def test_an_event_that_the_path_cannot_take_is_shown_as_refused() -> None:
    picture = scene(finger(1), path="approach_1, approach_1, align_finger2*")
    (refused,) = (edge for edge in picture.edges if picture.nodes[edge.target].kind == "disabled")
    assert picture.nodes[refused.source].label == "approached"
    assert [(label.event.name, label.highlighted, label.disabled) for label in refused.labels] == [
        ("approach_1", True, True)
    ]


def test_a_path_through_a_large_automaton_is_what_is_shown() -> None:
    picture = scene(ring(100), path=" ".join(["step"] * 5))
    assert [node.state for node in picture.nodes if node.kind == "state"] == [0, 1, 2, 3, 4, 5]
    assert picture.caption == "6 of 100 states, those passed by the trace"
    long = scene(ring(100), path=" ".join(["step"] * 50))
    assert [node.state for node in long.nodes if node.kind == "state"] == [*range(21, 51)]
    assert long.caption == "30 of 100 states, the last passed by the trace"


def test_a_supervisor_shows_what_it_disables() -> None:
    G = ring(8)
    S = Supervisor(G, np.array([0, 1, *[1] * 7]), np.array([G.alphabet.index("jump")], np.int32))
    picture = scene(S)
    (stop,) = (edge for edge in picture.edges if picture.nodes[edge.target].kind == "disabled")
    assert picture.nodes[stop.source].state == 0
    assert [(label.event.name, label.disabled, label.highlighted) for label in stop.labels] == [("jump", True, False)]
    (refused,) = (e for e in scene(S, path="jump").edges if scene(S, path="jump").nodes[e.target].kind == "disabled")
    assert [(label.event.name, label.highlighted) for label in refused.labels] == [("jump", True)]


def test_an_automaton_without_states_is_an_empty_picture() -> None:
    assert scene(Automaton.empty(ring(9).alphabet)).caption == "no states"


def test_what_cannot_be_drawn_is_an_error() -> None:
    with pytest.raises(InputError, match="at least 1 state"):
        scene(ring(9), limit=0)
    with pytest.raises(UnknownName, match="unknown event 'stp'; did you mean 'step'"):
        scene(ring(9), path="stp")
    with pytest.raises(UnknownName, match="unknown state 99"):
        scene(ring(9), highlight=[99])
    with pytest.raises(InputError, match="as one graph"):
        scene(Problem(ring(9)))  # type: ignore[arg-type]
