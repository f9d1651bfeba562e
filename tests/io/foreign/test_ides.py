"""IDES' .xmd: round trips, the answers of others' files, and damaged files."""

import re
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.io.foreign.drawn import (
    MODELS,
    assert_read_or_refused,
    damaged,
    facts,
    needs,
    odd_automaton,
    text,
    with_names,
)

from thenar.errors import ModelError
from thenar.explicit.control import supcon
from thenar.explicit.language import is_isomorphic
from thenar.explicit.products import meet, sync
from thenar.explicit.reach import trim
from thenar.io.foreign import ides
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

STATES = """
\t<state id="3"><properties><initial /><marked /></properties><name>idle</name></state>
\t<state id="7"><properties/><name>busy</name></state>"""
EVENTS = """
\t<event id="1"><properties><controllable /><observable /></properties><name>start</name></event>
\t<event id="5"><properties /><name>done</name></event>"""
MOVES = """
\t<transition id="1" source="3" target="7" event="1"></transition>
\t<transition id="2" source="7" target="3" event="5"></transition>
"""
META = (
    '<meta tag="layout" version="2.1"><font size="12"/><state id="3"><circle r="18.0" x="6.0" y="9.0"/></state></meta>'
)
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def model(
    data: str = STATES + EVENTS + MOVES, meta: str = META, head: str = 'version="2.1" type="FSA" id="1"'
) -> bytes:
    return f"{HEAD}<model {head}>\n<data>{data}</data>\n{meta}\n</model>\n".encode()


def read(data: bytes) -> Automaton | ExtendedAutomaton:
    return ides.loads(data, "M.xmd")


def refused(data: bytes) -> str:
    with pytest.raises(ModelError) as error:
        read(data)
    return str(error.value)


def test_properties_hold_where_they_stand() -> None:
    m = read(model())
    assert list(m.alphabet) == [Event("start"), Event("done", False, False)]
    expected = {("idle", "start", "busy"), ("busy", "done", "idle")}
    assert facts(m)[1:] == (("idle", "busy"), expected, {"idle"}, {"idle"})
    assert m.name == "M"


def test_version_2_0_has_another_root() -> None:
    data = f"{HEAD}<automaton>{STATES}{EVENTS}{MOVES}</automaton>".encode()
    assert facts(read(data)) == facts(read(model()))


def test_an_annotation_is_the_meaning_and_other_meta_need_not_be_xml() -> None:
    note = '<meta tag="annotation" version="3">one &amp; only</meta>'
    binary = '\n<meta tag="picture" version="1">\n<\x01 & no XML </meta>'
    m = read(model(meta=META + binary + note))
    assert m.meaning == "one & only"
    after = refused(model(meta=binary + "\n<model")).partition(":")[2]
    assert after.startswith("15:")  # places are those of the file, with what is left out


def test_names_that_are_missing_or_shared() -> None:
    twins = STATES.replace("busy", "idle").replace("</state>", "</state>", 1)
    third = '<state id="9"><properties/><name/></state><state id="10"/>'
    assert facts(read(model(twins + third + EVENTS + MOVES)))[1] == ("idle (3)", "idle (7)", "9", "10")


def test_white_space_in_names_of_events() -> None:
    latex = EVENTS.replace("start", r"\Large {$\alpha_1$}")
    assert read(model(STATES + latex + MOVES)).alphabet.names == (r"\Large_{$\alpha_1$}", "done")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'<workspace version="3"><model file="A.xmd" position="0"/></workspace>', "M.xmd:1:1: this is a workspace, a"),
        (model(head='version="3" type="SupEventSet" id="1"'), "M.xmd:2:1: this is a set of events"),
        (model(head='version="3" type="TemplateDesign" id="1"'), "M.xmd:2:1: this is a design with templates"),
        (model(head='version="3" type="PetriNet" id="1"'), "M.xmd:2:1: this is 'PetriNet', and no IDES model of type"),
        (model(head='version="9" type="FSA" id="1"'), "M.xmd:2:1: this is version '9'; versions 2 and 3 are read"),
        (b"<html/>", "M.xmd:1:1: this is 'html', and no IDES model of type FSA"),
        (f"{HEAD}<model version='2.1' type='FSA'/>".encode(), "M.xmd:2:1: a model has one <data>, not 0"),
        (model(MOVES), "M.xmd:4:2: unknown state with id '3'"),
        (model(STATES + EVENTS + MOVES.replace(' event="5"', "")), "M.xmd:9:2: a transition without an event (ε)"),
        (model(STATES + EVENTS + MOVES.replace('target="7"', "")), "M.xmd:8:2: the transition has no target"),
        (model(STATES + STATES + EVENTS + MOVES), "M.xmd:6:2: two states have the id '3'"),
        (model(STATES + EVENTS + EVENTS.replace('"1"', '"2"').replace('"5"', '"6"') + MOVES), "M.xmd:8:2: two events"),
        (model(STATES + EVENTS.replace("done", "") + MOVES), "M.xmd:7:2: event name ''"),
        (
            model(STATES.replace("initial", "timed") + EVENTS + MOVES),
            "M.xmd:4:28: unknown property <timed/>",
        ),
        (model(STATES.replace("<initial />", "") + EVENTS + MOVES), "M.xmd: no initial state"),
        (model(STATES + EVENTS + MOVES + "<timer/>"), "M.xmd:10:1: unknown element <timer>; here stand <state>"),
        (model()[:300], "M.xmd:6:"),
    ],
)
def test_mistakes_name_the_place(data: bytes, message: str) -> None:
    assert refused(data).startswith(message)


def test_dumps_then_loads_is_the_identity() -> None:
    rng = Random(2)
    for _ in range(1000):
        original = odd_automaton(rng)
        written = ides.dumps(original)
        read_again = ides.loads(text(written), "file.xmd")
        assert read_again.meaning == original.meaning
        assert facts(with_names(read_again, written.names)) == facts(original)


@settings(max_examples=300, deadline=None)
@given(
    st.one_of(
        damaged(
            [model(), model(meta="")], [b"<", b"&", b"</data>", b"<meta ", b'"', b"<state id='3'>", b"\xff", b"\x00"]
        ),
        st.binary(max_size=60),
    )
)
def test_damaged_files_are_read_or_refused(data: bytes) -> None:
    assert_read_or_refused(ides.loads, data)


def test_hostile_meta_takes_no_time() -> None:
    for piece in (b"<meta", b"<meta ", b'<meta "annotation"', b"<meta>", b"</meta>"):
        assert_read_or_refused(ides.loads, model().replace(b"</model>", piece * 100_000))


# -- other people's files

CAT, CENTRAL, MODULAR = "Cat and Mouse Problem", "Small Factory/Centralized_Approach", "Small Factory/Modular_Approach"
_SYMBOL = re.compile(r"(alpha|beta|lambda|mu)_[12]")


def load(name: str) -> Automaton:
    path = MODELS / "ides" / f"{name}.xmd"
    automaton = ides.loads(path.read_bytes(), str(path))
    assert isinstance(automaton, Automaton)
    return automaton


@needs("ides")
def test_every_file_loads_or_says_what_it_lacks() -> None:
    files = sorted(p for p in (MODELS / "ides").rglob("*") if p.suffix in (".xmd", ".xws"))
    assert files
    for file in files:
        if file.suffix == ".xws":
            with pytest.raises(ModelError, match="this is a workspace"):
                ides.loads(file.read_bytes(), file.name)
        elif file.stem == "FactoryLayout":  # a sketch
            with pytest.raises(ModelError, match="a transition without an event"):
                ides.loads(file.read_bytes(), file.name)
        else:
            ides.loads(file.read_bytes(), file.name)


@needs("ides")
def test_sizes() -> None:
    sizes = {
        f"{CAT}/Joint Behaviour": (25, 70),
        f"{CAT}/supC(Specification)": (6, 9),
        f"{CENTRAL}/SUPER": (12, 24),
        f"{CENTRAL}/SIMSUP": (3, 10),
    }
    assert {name: (load(name).n_states, load(name).n_transitions) for name in sizes} == sizes


# What IDES computed, and from which files: the identifiers and annotations of the models say it.
@needs("ides")
def test_cat_and_mouse() -> None:
    cat, mouse, both = load(f"{CAT}/Plant - Cat"), load(f"{CAT}/Plant - Mouse"), load(f"{CAT}/Joint Behaviour")
    specification, supremal = load(f"{CAT}/Specification"), load(f"{CAT}/supC(Specification)")
    assert is_isomorphic(sync(cat, mouse), both)
    assert is_isomorphic(trim(specification), specification)
    assert is_isomorphic(supcon(both, specification), supremal)
    assert is_isomorphic(supcon([cat, mouse], specification), supremal)


@needs("ides")
@pytest.mark.parametrize("approach", [CENTRAL, MODULAR])
def test_small_factory(approach: str) -> None:
    first, second, plant = (load(f"{approach}/{name}") for name in ("Machine_1", "Machine_2", "Factory_Plant"))
    assert is_isomorphic(sync(first, second), plant)
    assert is_isomorphic(supcon([first, second], load(f"{CENTRAL}/Spec")), load(f"{approach}/SUPER"))


@needs("ides")
def test_small_factory_by_two_supervisors() -> None:
    repair, buffer, both = (load(f"{MODULAR}/{name}") for name in ("BRSup", "BufSup", "ModSup"))
    controlled = load(f"{MODULAR}/Meet_PLANT_MODSUP")
    assert is_isomorphic(trim(meet(repair, buffer)), both)
    assert is_isomorphic(meet(load(f"{MODULAR}/Factory_Plant"), both), controlled)
    assert is_isomorphic(load(f"{MODULAR}/SUPER"), controlled)


@needs("ides")
def test_small_factory_with_names_set_in_other_sizes() -> None:
    # SPEC_1 and SIMSUP write some symbols in another size, \large, than the plant does, \Large
    plant = _by_symbols(load(f"{CENTRAL}/Factory_Plant"))
    first, second, spec, reduced, largest = (
        _by_symbols(load(f"{CENTRAL}/{name}"), plant) for name in ("SPEC_1", "SPEC_2", "Spec", "SIMSUP", "SUPER")
    )
    assert is_isomorphic(meet(first, second), spec)
    assert is_isomorphic(sync(plant, reduced), largest)


def _by_symbols(a: Automaton, plant: Automaton | None = None) -> Automaton:
    """Return ``a`` with its events called alpha_1, ...; they are those of ``plant``."""
    names = []
    for event in a.alphabet:
        symbol = _SYMBOL.search(event.name)
        assert symbol
        names.append(Event(symbol[0], event.controllable))
    known = {event.name: event for event in plant.alphabet} if plant else {}
    events = [known.get(event.name, event) for event in names]
    rows = [(a.states[q], events[e].name, a.states[t]) for q in range(a.n_states) for e, t in a.row(q)]
    states = [a.states[q] for q in range(a.n_states)]
    marked = [q for q, m in zip(states, a.marked, strict=True) if m]
    return Automaton.from_transitions(
        rows,
        initial=states[a.initial],
        marked=marked,
        states=states,
        events=events,
        alphabet=[e.name for e in events],
        name=a.name,
    )
