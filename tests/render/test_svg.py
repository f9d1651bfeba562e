import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thenar.errors import InputError
from thenar.library.glr import finger
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.supervisor import Supervisor
from thenar.render import svg
from thenar.render.measure import printable, state_lines
from thenar.testing.strategies import automata

SVG = "{http://www.w3.org/2000/svg}"
ANY_TEXT = st.text(st.characters(), min_size=1, max_size=60)
EVENT_NAMES = ANY_TEXT.filter(lambda name: not any(c.isspace() or c == "," for c in name))


def words(drawing: str) -> str:
    return "\n".join(ET.fromstring(drawing).itertext())


@given(automata(max_states=12))
def test_every_state_and_event_is_named(G: Automaton) -> None:
    text = words(svg(G))
    assert all(G.states[q] in text for q in range(G.n_states))
    assert all(event in text for _, event, _ in G.transitions())


@given(st.lists(ANY_TEXT, min_size=2, max_size=2, unique=True), EVENT_NAMES, st.booleans(), ANY_TEXT)
def test_any_name_can_be_drawn(states: list[str], event: str, controllable: bool, meaning: str) -> None:
    a, b = states
    G = Automaton.from_transitions(
        [(a, event, b), (b, event, b)], initial=a, marked=[b], events=[Event(event, controllable, meaning=meaning)]
    )
    drawing = svg(G, path=[event, event, event], highlight=[1])  # type: ignore[arg-type]
    text = words(drawing)
    for name in (a, b, event, meaning):
        assert " ".join(printable(name).split()) in " ".join(text.split())
    assert drawing.encode("utf-8").decode("utf-8") == drawing


def test_a_hostile_name_stays_text() -> None:
    G = Automaton.from_transitions(
        [("<script>alert(1)</script>", '"><svg/onload=alert(1)>', "]]>\x00\x1b[31m\ud800")],
        initial="<script>alert(1)</script>",
    )
    root = ET.fromstring(svg(G))
    drawn = {"svg", "title", "style", "rect", "g", "path", "text", "tspan"}
    assert {element.tag.removeprefix(SVG) for element in root.iter()} == drawn - {"tspan"}
    assert not any(key.startswith("on") for element in root.iter() for key in element.attrib)


def test_the_same_model_has_the_same_bytes() -> None:
    assert svg(finger(1)) == svg(finger(1))
    assert svg(finger(1), path="approach_1", layout="own") == svg(finger(1), path="approach_1", layout="own")


def test_a_drawing_is_self_contained_and_accessible() -> None:
    root = ET.fromstring(svg(finger(1)))
    assert root.attrib["role"] == "img"
    assert root[0].tag == SVG + "title"
    assert root[0].text == "Automaton 'FINGER1': 18 states (2 marked), 33 transitions, 20 events"
    assert "prefers-color-scheme:dark" in svg(finger(1))
    assert not any("href" in key or "id" == key for element in root.iter() for key in element.attrib)


def states_drawn(drawing: str) -> dict[int, ET.Element]:
    return {int(g.attrib["data-state"]): g for g in ET.fromstring(drawing).iter(SVG + "g") if "data-state" in g.attrib}


def test_marked_states_have_a_double_line_and_current_ones_are_filled() -> None:
    G = finger(1)
    for q, element in states_drawn(svg(G, highlight=[4])).items():
        assert len(list(element.iter(SVG + "rect"))) == 1 + bool(G.marked[q])
        assert (element.find(SVG + "g").attrib["fill"] != "none") == (q == 4)  # type: ignore[union-attr]


def test_uncontrollable_events_are_dashed_and_controllable_ones_have_a_tick() -> None:
    G = Automaton.from_transitions(["a -can-> b -must-> c"], initial="a", uncontrollable=["must"])
    edges = {}
    for g in ET.fromstring(svg(G)).iter(SVG + "g"):
        title = g.find(SVG + "title")
        if title is not None and "data-state" not in g.attrib:
            edges[(title.text or "").split(":")[0]] = [path.attrib for path in g.iter(SVG + "path")]
    line, tick, head = edges["a → b"]
    assert line["stroke-dasharray"] == "none"
    assert tick["d"].count("L") == 1
    assert head["fill"] == "currentColor"
    line, head = edges["b → c"]
    assert line["stroke-dasharray"] != "none"
    assert head["fill"] != "currentColor"


def test_a_disabled_event_is_struck_through() -> None:
    G = Automaton.from_transitions(["a -go-> b"], initial="a", alphabet=["stop"])
    S = Supervisor(G, np.array([0, 0, 1]), np.array([G.alphabet.index("stop")], np.int32))
    (struck,) = (t for t in ET.fromstring(svg(S)).iter(SVG + "tspan") if t.get("text-decoration") == "line-through")
    assert struck.text == "stop"


def test_a_large_automaton_is_shown_in_part_and_says_so() -> None:
    G = Automaton.from_transitions([f"{k} -on-> {k + 1}" for k in range(100)], initial="0")
    drawing = svg(G, centre=50)
    assert len(states_drawn(drawing)) == 30
    assert "30 of 101 states, around state 50" in words(drawing)
    assert len(states_drawn(svg(G, limit=7))) == 7


def test_an_automaton_without_states_can_be_drawn() -> None:
    assert "no states" in words(svg(Automaton.empty(finger(1).alphabet)))


def test_an_unknown_layout_is_an_error() -> None:
    with pytest.raises(InputError, match="choose 'own' or 'dot'"):
        svg(finger(1), layout="neato")  # type: ignore[arg-type]


def test_long_names_are_broken_and_cut_but_whole_in_the_title() -> None:
    name = "|".join(["neutral"] * 30)
    assert all(len(line) <= 20 for line in state_lines(name))
    assert len(state_lines(name)) == 8
    G = Automaton.from_transitions([(name, "e" * 200, "b")], initial=name)
    root = ET.fromstring(svg(G))
    assert float(root.attrib["width"]) < 600
    assert name in words(svg(G))
    assert "e" * 200 in words(svg(G))


def test_a_drawing_can_be_written_to_a_file_and_read_again(tmp_path: Path) -> None:
    target = tmp_path / "finger.svg"
    target.write_text(svg(finger(1)), encoding="utf-8")
    assert ET.parse(target).getroot().tag == SVG + "svg"
