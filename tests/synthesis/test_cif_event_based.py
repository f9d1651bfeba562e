"""CIF's event-based synthesis and checks give the answers that CIF gives; read from a folder that may be missing."""

from pathlib import Path

import pytest

import thenar
from thenar.explicit.abstraction import hide, is_observer, observation_quotient
from thenar.explicit.nondeterminism import determinise
from thenar.io import cif
from thenar.model.automaton import Automaton

TESTS = Path(__file__).resolve().parents[3] / "shared" / "models" / "cif" / "tests_eventbased"
pytestmark = pytest.mark.skipif(not TESTS.is_dir(), reason=f"no {TESTS}: models of others are no part of the project")


def problem(tool: str, name: str) -> thenar.ExtendedProblem:
    return cif.load(TESTS / tool / f"{name}.cif")


def plain(given: thenar.ExtendedProblem) -> thenar.Problem:
    return thenar.Problem(
        [determinise(a) for a in given.plants], [determinise(a) for a in given.specs], alphabet=given.alphabet
    )


def said(tool: str, name: str, ending: str) -> str:
    return (TESTS / tool / f"{name}.{ending}").read_text()


SYNTHESISED = sorted(
    p.name.removesuffix(".run.expected.cif") for p in TESTS.glob("supervisor_synthesis/*.expected.cif")
)


@pytest.mark.parametrize("engine", ["explicit", "symbolic"])
@pytest.mark.parametrize("name", SYNTHESISED)
def test_the_supervisor_is_cifs(name: str, engine: str) -> None:
    given = problem("supervisor_synthesis", name)
    (answer,) = problem("supervisor_synthesis", f"{name}.run.expected").automata
    found = thenar.synthesize(plain(given), engine)
    assert thenar.is_isomorphic(found.supervisor.automaton, determinise(answer))
    assert thenar.synthesize(given, engine).size == found.size


def test_nothing_marked_leaves_no_supervisor() -> None:
    assert "Supervisor is empty (no marker states)" in said("supervisor_synthesis", "empty_unmarked", "run.err")
    assert not thenar.synthesize(problem("supervisor_synthesis", "empty_unmarked"))


def test_a_file_without_plant_is_refused() -> None:
    assert "no plant automaton found" in said("supervisor_synthesis", "empty_file", "run.err")
    with pytest.raises(thenar.ModelError, match="no plant"):
        problem("supervisor_synthesis", "empty_file")


def test_what_cifs_tool_has_as_preconditions_is_no_limit_here() -> None:
    """A nondeterministic plant, a supervisor among the automata, an event of requirements alone: each has a meaning."""
    for name, reason in (
        ("initial_nondeterministic", "An automaton is non-deterministic"),
        ("plant_sup", "Automaton is a supervisor automaton"),
        ("sup_evt_not_in_plant2", "not in the plant alphabet"),
    ):
        assert reason in said("supervisor_synthesis", name, "run.err")
        given = problem("supervisor_synthesis", name)
        assert thenar.synthesize(given, "explicit").size == thenar.synthesize(given, "symbolic").size


@pytest.mark.parametrize("name", ["all_disable", "unctrl_disable"])
def test_an_uncontrollable_event_that_a_supervisor_disables_is_found(name: str) -> None:
    assert 'event "u" at state "p.s1", "s.s1"' in said("controllability_check", name, "expected.txt")
    given = plain(problem("controllability_check", name))
    check = thenar.is_controllable(given.specs[0], given.plants)
    assert not check
    assert str(check.witness) == "u"


@pytest.mark.parametrize(
    ("name", "complaint"),
    [("evt_non_ctrl", "neither controllable nor"), ("non_deterministic", "tau")],
)
def test_what_the_controllability_check_cannot_take_is_refused(name: str, complaint: str) -> None:
    with pytest.raises(thenar.ModelError, match=complaint):
        problem("controllability_check", name)


def test_an_automaton_that_never_marks_is_in_conflict() -> None:
    given = plain(problem("nonconflicting_check", "plant_sup_nontrim"))
    assert not thenar.is_nonconflicting(*given.automata)
    assert thenar.is_nonblocking(plain(problem("nonconflicting_check", "single_aut")).plants[0])


def test_the_abstraction_has_the_states_of_cifs() -> None:
    (automaton,) = plain(problem("automaton_abstraction", "example1")).automata
    (answer,) = cif.load(TESTS / "automaton_abstraction" / "example1.run.expected.cif").automata
    abstraction = observation_quotient(hide(automaton, ["a", "b"]))
    assert abstraction.n_states == len(answer.states) == 3
    assert len(abstraction.events) == len(answer.alphabet) == 2


def test_the_projection_is_no_observer_because_of_c() -> None:
    answer = said("observer_check", "example1", "expected.txt")
    assert 'for observable events "a", "b"' in answer
    assert 'Event that invalidates the observer property: "c"' in answer
    (automaton,) = plain(problem("observer_check", "example1")).automata
    assert not is_observer(automaton, ["a", "b"])
    assert is_observer(automaton, ["a", "b", "c"])
    without = [(s, e, t) for s, e, t in automaton.transitions() if e != "c"]
    assert is_observer(Automaton.from_transitions(without, initial="s0", marked=["s0"]), ["a", "b"])
