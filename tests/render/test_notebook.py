import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings

from thenar.library.glr import finger, problem
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.names import Composed, Layout
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.render import html
from thenar.testing.strategies import automata

HOSTILE = "<script>alert('1')</script>"


def product(n: int = 60) -> Automaton:
    """A large automaton whose states are composed of FINGER1's and FINGER2's."""
    keys = np.array([[i | j << 5] for i in range(18) for j in range(18)], np.uint64)[:n]
    layout = Layout(words=(0, 0), shifts=(0, 5), bits=(5, 5))
    states = Composed((finger(1).states, finger(2).states), ("FINGER1", "FINGER2"), layout, keys)
    return Automaton.from_arrays(
        Alphabet(["on"]), np.arange(n + 1), np.zeros(n, np.int32), (np.arange(n) + 1) % n, marked=np.arange(n) == 0,
        states=states, name="G",
    )  # fmt: skip


def supervisor(G: Automaton) -> Supervisor:
    return Supervisor(G, np.zeros(G.n_states + 1, np.int64), np.zeros(0, np.int32))


def parse(page: str) -> ET.Element:
    """Read a page as XML: stricter than HTML, so a tag or quote that slipped through is an error."""
    return ET.fromstring(page)


@pytest.mark.parametrize("shown", [finger(1), supervisor(finger(1))])
def test_a_small_model_is_drawn(shown: Automaton | Supervisor) -> None:
    page = html(shown, highlight=[2], path="approach_1")
    assert page.count("<svg") == 1
    assert repr(shown) in "".join(parse(page).itertext())


@pytest.mark.parametrize("shown", [product(), supervisor(product())])
def test_a_large_product_is_not_drawn_but_its_components_states_are_named(shown: Automaton | Supervisor) -> None:
    page = html(shown, highlight=[20])
    text = "".join(parse(page).itertext())
    assert "<svg" not in page
    assert "state 20 of the product" in text
    assert "FINGER1: approached" in text
    assert f"FINGER2: {finger(2).states[2]}" in text
    assert "… 48 more" in text
    assert len(page) < 10_000


def test_a_product_shows_its_initial_state_if_none_is_highlighted() -> None:
    assert "FINGER1: neutral" in "".join(parse(html(product())).itertext())


def test_a_problem_shows_its_automata_side_by_side_with_their_states_lit() -> None:
    page = html(problem(), highlight=[1, 0, 2])
    text = "".join(parse(page).itertext())
    assert page.count("<svg") == 7
    assert page.count('fill-opacity="0.35"') == 3
    assert all(automaton.name in text for automaton in problem().automata)


def test_a_large_component_is_not_drawn() -> None:
    big = Automaton.from_transitions([f"{k} -on-> {k + 1}" for k in range(99)], initial="0", name="BIG")
    page = html(Problem([finger(1), big]))
    assert page.count("<svg") == 1
    assert "BIG" in page


def test_a_check_shows_its_verdict_and_witness() -> None:
    text = "".join(parse(html(Check("controllable", False, Trace("lift slip"), "SPEC forbids it"))).itertext())
    assert text == "✗ not controllable after lift → slip: SPEC forbids it"
    assert "".join(parse(html(Check("nonblocking", True))).itertext()) == "✓ nonblocking"
    assert "ε" in html(Check("nonblocking", False, Trace(), "blocked from the start"))
    assert "… 900 more" in html(Check("nonblocking", False, Trace(["a"] * 1000)))


def test_no_name_becomes_markup() -> None:
    odd = Automaton.from_transitions([(HOSTILE, '"><img/onerror=x>', "\x00&amp;")], initial=HOSTILE, name=HOSTILE)
    long = Automaton.from_transitions(
        [(f"{k}{HOSTILE}", "<b>", f"{k + 1}{HOSTILE}") for k in range(50)], initial=f"0{HOSTILE}"
    )
    for shown in (
        odd,
        supervisor(odd),
        long,
        supervisor(long),
        Problem([odd], name=HOSTILE, description=HOSTILE),
        Check(HOSTILE, False, Trace([HOSTILE]), HOSTILE),
        HOSTILE,
    ):
        page = html(shown)
        tags = {re.sub("{.*}", "", element.tag) for element in parse(page).iter()}
        assert not tags & {"script", "img", "b>"}
        assert "<script" not in page


@given(automata(max_states=8))
@settings(max_examples=30)
def test_pages_are_self_contained(G: Automaton) -> None:
    page = html(G)
    assert not re.search(r"<script|<link|<iframe|src=|href=|url\(|@import", page)
    assert page == html(G)


def test_upper_floors_can_register_more() -> None:
    class Run:
        pass

    html.register(Run, lambda obj, **options: "<p>a run</p>")
    assert html(Run()) == "<p>a run</p>"


def test_the_result_is_what_a_notebook_asks_for() -> None:
    import thenar  # installs the formatter

    assert thenar.Check("nonblocking", True)._repr_html_() == html(Check("nonblocking", True))
