"""CIF's own tests of its event-based tools give the answers that CIF gives; read from a folder that may be missing."""

import re
from pathlib import Path

import pytest

import thenar
from thenar.explicit.nondeterminism import determinise
from thenar.io import cif
from thenar.model.automaton import Automaton
from thenar.model.extended import ExtendedAutomaton

TESTS = Path(__file__).resolve().parents[3] / "shared" / "models" / "cif" / "tests_eventbased"
pytestmark = pytest.mark.skipif(not TESTS.is_dir(), reason=f"no {TESTS}: models of others are no part of the project")


def cases(tool: str) -> list[str]:
    """The models of ``tool`` with an expected answer that has an initial location."""
    found = (p.name.removesuffix(".run.expected.cif") for p in (TESTS / tool).glob("*.run.expected.cif"))
    return sorted(set(found) - {"empty_automaton"})


def read(tool: str, name: str) -> tuple[tuple[ExtendedAutomaton, ...], ExtendedAutomaton]:
    """The automata of a model, and the one that CIF makes of them."""
    given, expected = (cif.load(TESTS / tool / f"{name}{ending}.cif") for ending in ("", ".run.expected"))
    (answer,) = expected.automata
    return given.automata, answer


@pytest.mark.parametrize("name", cases("nfa_to_dfa"))
def test_nfa_to_dfa(name: str) -> None:
    (a,), answer = read("nfa_to_dfa", name)
    found = determinise(a)
    assert thenar.is_isomorphic(found, determinise(answer))
    assert states_of(found) == stated("nfa_to_dfa", name)


@pytest.mark.parametrize("name", cases("projection"))
def test_projection(name: str) -> None:
    (a,), answer = read("projection", name)
    found = determinise(a, silent=set(a.alphabet.names) - set(answer.alphabet.names))
    assert thenar.is_isomorphic(found, determinise(answer))
    assert states_of(found) == stated("projection", name)


def states_of(automaton: Automaton) -> set[frozenset[str]]:
    """The sets of states that the states of a subset construction are called after."""
    names = (automaton.states[q] for q in range(automaton.n_states))
    return {frozenset(name.strip("{}").split(", ")) for name in names}


def stated(tool: str, name: str) -> set[frozenset[str]]:
    """The same as CIF annotates them, one ``@state(automaton: "location")`` for each member."""
    text = (TESTS / tool / f"{name}.run.expected.cif").read_text()
    groups = re.findall(r"((?:@state\(.*\)\s+)+)location", text)
    return {frozenset(re.findall(r'"(.*?)"', group)) for group in groups}


@pytest.mark.parametrize("name", sorted(set(cases("synchronous_product")) - {"nondeterministic"}))
def test_synchronous_product(name: str) -> None:
    automata, answer = read("synchronous_product", name)
    product = thenar.sync(*map(determinise, automata))
    assert thenar.is_isomorphic(product, determinise(answer))
    if name == "shuffle":
        assert thenar.is_isomorphic(thenar.shuffle(*map(determinise, automata)), product)


def test_synchronous_product_of_nondeterministic_automata() -> None:
    """CIF multiplies them as they are, thenar makes them deterministic first: the languages are the same."""
    automata, answer = read("synchronous_product", "nondeterministic")
    product = thenar.sync(*map(determinise, automata))
    assert thenar.is_isomorphic(thenar.minimize(product), thenar.minimize(determinise(answer)))


@pytest.mark.parametrize("name", cases("trim"))
def test_trim(name: str) -> None:
    (a,), answer = read("trim", name)
    assert thenar.is_isomorphic(thenar.trim(determinise(a)), determinise(answer))


@pytest.mark.parametrize("tool", ["nfa_to_dfa", "projection"])
def test_an_automaton_without_initial_location_is_refused(tool: str) -> None:
    """CIF warns, and answers with another one; thenar asks for the location that is missing."""
    assert "has no initial location" in (TESTS / tool / "empty_automaton.run.err").read_text()
    with pytest.raises(thenar.ModelError, match="automaton 'p' has no initial location; write 'initial;'"):
        cif.load(TESTS / tool / "empty_automaton.cif")


@pytest.mark.parametrize("tool", ["synchronous_product", "trim"])
def test_a_file_without_automata_is_refused(tool: str) -> None:
    assert "no automaton found" in (TESTS / tool / "empty_file.run.err").read_text()
    with pytest.raises(thenar.ModelError, match="a problem needs at least one automaton"):
        cif.load(TESTS / tool / "empty_file.cif")
