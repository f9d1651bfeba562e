"""The real TCT on the paper's automata: the same states, transitions and numbers."""

from tests.oracles import tct

import thenar
from thenar.library import glr
from thenar.library.glr.paper import SIMULATIONS
from thenar.model.automaton import Automaton
from thenar.testing.asserts import assert_same_numbering


def anything() -> Automaton:
    """One state in which all events loop: it forbids nothing, and has TCT label the events in the order of EVENTS."""
    return Automaton.from_transitions(
        [("q", e, "q") for e in glr.EVENTS.names], initial="q", marked=["q"], events=glr.EVENTS
    )


def test_tct_builds_the_same_plant_state_by_state() -> None:
    fingers = glr.finger(1), glr.finger(2)
    assert_same_numbering(thenar.sync(*fingers), tct.sync(*fingers))


def test_tct_builds_the_same_legal_language_state_by_state() -> None:
    looped = [thenar.selfloop(s, [e for e in glr.EVENTS if e.name not in s.alphabet]) for s in glr.problem().specs]
    assert_same_numbering(thenar.meet(*looped), tct.meet(*looped))


def test_tct_computes_the_same_supervisor_state_by_state() -> None:
    problem = glr.problem()
    theirs = tct.supcon([anything(), *problem.plants], problem.specs)
    ours = thenar.synthesize(problem).supervisor.automaton
    assert (theirs.n_states, theirs.n_transitions) == (2809, 6076)
    assert_same_numbering(ours, theirs)
    for simulation in SIMULATIONS:
        assert ours.run(simulation.trace) == theirs.run(simulation.trace)


def test_tct_disables_the_same_events() -> None:
    problem = glr.problem()
    supervisor = thenar.synthesize(problem).supervisor
    theirs = tct.condat([anything(), *problem.plants], supervisor.automaton)
    for x in range(supervisor.n_states):
        assert set(supervisor.pattern(x).disabled) == set(theirs.pattern(x).disabled)
