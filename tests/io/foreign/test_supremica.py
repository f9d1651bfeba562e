"""Supremica's project XML: what is read and written, and the answers of a public benchmark."""

from __future__ import annotations

import contextlib
import re
import time
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thenar import Alphabet, Automaton, Event, ExtendedAutomaton, ExtendedProblem, Problem, Variable, synthesize
from thenar.errors import InputError, ModelError
from thenar.io.foreign import supremica
from thenar.io.foreign.compose import without
from thenar.library.classics import small_factory
from thenar.testing.random_models import random_alphabet, random_automaton, random_problem

MODELS = Path(__file__).resolve().parents[4] / "shared" / "models" / "supremica_xml"
ANSWERS = MODELS.parent / "ANSWERS.md"
needs_models = pytest.mark.skipif(
    not MODELS.is_dir(), reason=f"no {MODELS}: models of others are no part of the project"
)


def answers() -> dict[str, tuple[int, int]]:
    """Return the sizes of supervisors that ANSWERS.md gives for the benchmark of Ciolek et al."""
    if not ANSWERS.is_file():
        return {}
    section = ANSWERS.read_text().split("## supremica_xml")[1].split("\n## ")[0]
    found = {name: (int(q), int(t)) for name, q, t in re.findall(r"([A-Z]{2}-\d-\d) (\d+) \((\d+)\)", section)}
    none = re.search(r"([A-Z]{2}-\d-\d) and ([A-Z]{2}-\d-\d) none exists", section)
    return found | dict.fromkeys(none.groups() if none else (), (0, 0))


@needs_models
def test_every_file_has_an_answer() -> None:
    assert {f.stem for f in MODELS.glob("*.xml")} == set(answers())


@needs_models
@pytest.mark.parametrize("name", answers())
def test_the_supervisors_of_the_benchmark(name: str) -> None:
    problem = supremica.loads((MODELS / f"{name}.xml").read_bytes(), name)
    for engine in ("explicit", "symbolic"):
        size = synthesize(problem, engine).size
        assert (size.states, size.transitions) == answers()[name]
    assert isinstance(problem, Problem)
    assert_same(problem, supremica.loads(text(problem), name))


# -- what is read --------------------------------------------------------------------------------------------


def text(problem: Problem | ExtendedProblem) -> bytes:
    return "".join(map(str, supremica.dumps(problem).chunks)).encode()


def assert_same(a: Problem, b: Problem | ExtendedProblem) -> None:
    """Fail unless the problems are equal, the order of events aside."""
    assert isinstance(b, Problem)
    assert (a.name, len(a.plants), len(a.specs)) == (b.name, len(b.plants), len(b.specs))
    assert a.description == b.description
    for one, other in zip(a.automata, b.automata, strict=True):
        assert (one.name, one.alphabet, one.initial) == (other.name, other.alphabet, other.initial)
        assert [one.states[q] for q in range(one.n_states)] == [other.states[q] for q in range(other.n_states)]
        for array in ("offsets", "events", "targets", "marked"):
            np.testing.assert_array_equal(getattr(one, array), getattr(other, array))


def project(*automata: str, root: str = '<SupremicaProject name="p">') -> bytes:
    tag = root[1:].split(maxsplit=1)[0].rstrip(">")
    return f"{root}{''.join(automata)}</{tag}>".encode()


def automaton(
    name: str = "A",
    kind: str = "Plant",
    *,
    b: str = "",
    q: str = "",
    transitions: tuple[tuple[str, str, str], ...] = (("0", "1", "a"), ("1", "2", "b")),
) -> str:
    rows = "".join(f'<Transition source="{s}" dest="{t}" event="{e}"/>' for s, t, e in transitions)
    return (
        f'<Automaton name="{name}" type="{kind}">'
        f'<Events><Event id="a" label="a"/><Event id="b" label="b" {b}/></Events>'
        f'<States><State id="0" name="zero" initial="true" accepting="true"/>'
        f'<State id="1"/><State id="2" {q}/></States>'
        f"<Transitions>{rows}</Transitions><Layout/></Automaton>"
    )


def test_an_event_may_have_another_number_in_each_automaton() -> None:
    two = '<Automaton name="B" type="Specification"><Events><Event id="7" label="b"/></Events>' + (
        '<States><State id="-1" initial="true"/></States>'
        '<Transitions><Transition source="-1" dest="-1" event="7"/></Transitions></Automaton>'
    )
    problem = supremica.loads(project(automaton(), two, root='<Automata name="Plant" major="0" minor="1">'), "p.xml")
    assert problem.name == "Plant"
    assert [list(a.alphabet.names) for a in problem.automata] == [["a", "b"], ["b"]]
    assert [a.states[0] for a in problem.automata] == ["zero", "-1"]


@pytest.mark.parametrize(
    ("kind", "is_plant"),
    [("Plant", True), ("plant", True), ("Undefined", True)]
    + [(kind, False) for kind in ("Specification", "Supervisor", "Interface")],
)
def test_kinds(kind: str, is_plant: bool) -> None:
    problem = supremica.loads(project(automaton("P"), automaton("A", kind)), "p.xml")
    assert [a.name for a in problem.plants] == ["P"] + ["A"] * is_plant
    assert [a.name for a in problem.specs] == ["A"] * (not is_plant)


def test_a_property_is_left_out_and_said_so() -> None:
    problem = supremica.loads(project(automaton("P"), automaton("A", "Property")), "p.xml")
    assert len(problem.automata) == 1
    assert problem.description == "Not read: property 'A', a question about the system."


@pytest.mark.parametrize("kind", ["Plant", "Specification"])
def test_forbidden_states_are_not_entered(kind: str) -> None:
    other = automaton("P") if kind == "Specification" else ""
    problem = supremica.loads(project(other, automaton("A", kind, q='forbidden="true"')), "p.xml")
    assert isinstance(problem, Problem)
    spec = problem.specs[0]
    assert spec.name == ("A" if kind == "Specification" else "A without forbidden states")
    assert list(spec.transitions()) == [("zero", "a", "1")]
    assert spec.alphabet.names == ("a", "b")


def test_states_left_away() -> None:
    for seed in range(300):
        rng = Random(seed)
        a = random_automaton(rng, random_alphabet(rng), max_states=5)
        gone = sorted(rng.sample(range(a.n_states), rng.randint(0, a.n_states)))
        result = without(a, gone)
        assert result.n_states == (0 if a.initial in gone else a.n_states - len(gone))
        rows = {(s, e, t) for s, e, t in a.transitions() if int(s) not in gone and int(t) not in gone}
        assert set(result.transitions()) == (rows if result.n_states else set())


def test_a_nondeterministic_automaton_is_an_extended_one() -> None:
    choice = automaton(transitions=(("0", "1", "a"), ("0", "2", "a")), q='forbidden="true"')
    problem = supremica.loads(project(choice), "p.xml")
    assert isinstance(problem, ExtendedProblem)
    assert [str(c) for c in problem.spec_conditions] == ["not A['2']"]
    assert synthesize(problem).size.states == 1  # a may lead to the forbidden state, so it is disabled
    assert isinstance(supremica.loads(text(ExtendedProblem(problem.plants)), "p.xml"), ExtendedProblem)


def test_an_event_that_is_not_prioritized_is_not_blocked() -> None:
    loose = automaton("L", b='prioritized="false"', transitions=(("0", "1", "a"),))
    problem = supremica.loads(project(automaton("T"), loose), "p.xml")
    assert isinstance(problem, Problem)
    assert ("1", "b", "1") in set(problem.plants[1].transitions())
    with pytest.raises(ModelError, match="event 'b' is prioritized in no automaton"):
        supremica.loads(project(loose), "p.xml")


def test_all_mistakes_are_named_with_their_places() -> None:
    wrong = project(
        automaton("A", "Plnt", b='controllable="yes"', transitions=(("0", "9", "a"), ("0", "1", "c"))),
        automaton("A", b='controllable="false"'),
        "<Atomaton/>",
    ).replace(b"<Transition ", b"\n<Transition ")
    with pytest.raises(ModelError) as raised:
        supremica.loads(wrong, "p.xml")
    said = [str(m) for m in raised.value.mistakes]
    assert [re.sub(r"^p.xml:\d+:\d+: ", "", m) for m in said] == [
        "an automaton of type 'Plnt'; there are Plant, Specification, Supervisor, Interface or Property",
        "controllable='yes'; write 'true' or 'false'",
        "unknown state '9'",
        "unknown event 'c'",
        "<Atomaton> is not known here; did you mean 'Automaton'?",
        "automaton 'A' is there twice, first in line 1",
    ]
    assert said[2].startswith("p.xml:2:1: ")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "p.xml:1:1: no element found"),
        (b"<Module/>", "no Supremica project: it begins with <Module>"),
        (b'<Automata name="x"/>', "no plant"),
        (project(automaton().replace('initial="true"', "")), "automaton 'A' has no initial state"),
        (project(automaton(b='controllable="false"'), automaton("B")), "event 'b' is uncontrollable in line 1"),
        (b'<!DOCTYPE a [<!ENTITY b "c">]><Automata name="&b;"/>', "declares an entity"),
    ],
)
def test_one_mistake(data: bytes, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        supremica.loads(data, "p.xml")


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_damaged_files_are_refused(data: st.DataObject) -> None:
    good = bytearray(project(automaton(b='observable="false"'), automaton("S", "Supervisor")))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(good)))
        good[at : at + data.draw(st.integers(0, 9))] = data.draw(st.binary(max_size=4) | st.sampled_from([b'"', b"<"]))
    for damaged in (bytes(good), data.draw(st.binary(max_size=50)), bytes(good[: len(good) // 2])):
        with contextlib.suppress(InputError):
            supremica.loads(damaged, "p.xml")


# -- what is written -----------------------------------------------------------------------------------------

ODD = ["a b", 'c"d', "e<f>&", "'", "\n", "ä{}", "-1", "%s", "\u2028", "\x85"]


def test_reading_what_was_written_changes_nothing() -> None:
    for seed in range(1000):
        rng = Random(seed)
        problem = random_problem(rng, max_events=5, max_plants=2, max_specs=2)
        names = {e.name: Event(rng.choice(["x", "é<&", "!"]) + e.name, e.controllable, rng.random() < 0.7)
                 for e in problem.alphabet}  # fmt: skip
        automata = [odd(a, names, rng) for a in problem.automata]
        n = len(problem.plants)
        description = rng.choice(["", "two\nlines & more"])
        strange = Problem(automata[:n], automata[n:], name=rng.choice(["", "<p>"]), description=description)
        assert_same(strange, supremica.loads(text(strange), "p.xml"))


def odd(a: Automaton, events: dict[str, Event], rng: Random) -> Automaton:
    """Return ``a`` with names that make trouble."""
    states = [rng.choice(ODD) + str(q) for q in range(a.n_states)]
    sigma = Alphabet(events[e] for e in a.alphabet.names)
    return Automaton.from_arrays(
        sigma, a.offsets, a.events, a.targets, marked=a.marked, initial=a.initial, states=states, name=a.name + " <&>"
    )


def test_what_is_not_written_is_said() -> None:
    a = Automaton.from_transitions(["0 -a-> 0"], initial="0", events=Alphabet([Event("b"), Event("a", forcible=True)]))
    written = supremica.dumps(Problem(a, alphabet=Alphabet([Event("b"), Event("a", forcible=True)])))
    assert written.notes == (
        "Events are in the order of first mention, not in that of the problem's alphabet.",
        "Events that no automaton has are not written: b.",
        "That a can be forced is not written.",
        "Automata without a name are called automaton_1.",
    )
    assert supremica.dumps(small_factory()).notes == ("Meanings of events and automata are not written.",)
    assert not supremica.dumps(random_problem(Random(2))).notes


def test_an_automaton_without_states() -> None:
    problem = Problem(random_automaton(Random(1), Alphabet(["a"]), name="P"), Automaton.empty(Alphabet(["a"]), "S"))
    assert_same(problem, supremica.loads(text(problem), "p.xml"))


@pytest.mark.parametrize(
    ("problem", "said"),
    [
        (ExtendedProblem(small_factory().plants, variables=[Variable("n", range(3))]), "variable 'n'"),
        (ExtendedProblem(small_factory().plants, marked=False), "a predicate on initial or marked states"),
        (
            ExtendedProblem(ExtendedAutomaton.from_edges("A", ["p -a-> q"], initial=["p", "q"])),
            "the several initial states of automaton 'A'",
        ),
        (
            ExtendedProblem(ExtendedAutomaton.from_edges("A", [("p", "a", "q", False)], initial="p")),
            "guards or updates of automaton 'A'",
        ),
    ],
)
def test_what_cannot_be_written_is_refused(problem: ExtendedProblem, said: str) -> None:
    with pytest.raises(InputError, match=f"Supremica's XML has no way to say {said}; write a .wmod file"):
        supremica.dumps(problem)


def test_a_name_that_xml_cannot_hold_is_refused() -> None:
    with pytest.raises(InputError, match="which XML cannot hold"):
        supremica.dumps(Problem(Automaton.from_transitions(["0 -a\x01-> 0"], initial="0")))
    bell = Automaton.from_transitions([("\x07", "a", "\x07")], initial="\x07")
    with pytest.raises(InputError, match="which XML cannot hold"):
        supremica.dumps(Problem(bell))


def test_labels_with_white_space_and_commas() -> None:
    spaced = project(automaton().replace('label="a"', 'label="go, now"'))
    assert supremica.loads(spaced, "p.xml").alphabet.names == ("go__now", "b")


def test_a_hundred_thousand_transitions_take_seconds() -> None:
    rng = np.random.default_rng(1)
    n, k = 25_000, 4
    alphabet = Alphabet(f"e{i}" for i in range(k))
    rows = (np.arange(n + 1) * k, np.tile(np.arange(k), n), rng.integers(0, n, n * k))
    problem = Problem(Automaton.from_arrays(alphabet, *rows, marked=np.ones(n, np.bool_), name="G"))
    begun = time.perf_counter()
    again = supremica.loads(text(problem), "p.xml")
    assert time.perf_counter() - begun < 20  # 2 s where nothing else runs
    assert_same(problem, again)
