"""The paper's task: what it publishes, and what ours computes."""

import json
from pathlib import Path

import pytest

import thenar
from thenar.library import glr
from thenar.library.glr import paper

SHARED = Path(__file__).resolve().parents[3] / "shared" / "glr" / "natural.json"


def test_the_alphabet_has_28_events_six_of_them_uncontrollable() -> None:
    """Section 5 lists them."""
    assert len(glr.EVENTS) == 28
    assert {e.name for e in glr.EVENTS if not e.controllable} == {
        "detect_misalignment*",
        "unstable_contact_1",
        "unstable_contact_2",
        "finger_1_obj_misalign",
        "finger_2_obj_misalign",
        "incip_slip*",
    }
    assert all(e.meaning for e in glr.EVENTS)


def test_the_plant_has_90_states_242_transitions_and_two_marker_states() -> None:
    """Section 5: 'a total of 90 states and 242 transitions', 'the plant has only two marker (terminal) states'."""
    G = thenar.sync(glr.finger(1), glr.finger(2))
    assert (G.n_states, G.n_transitions, int(G.marked.sum())) == (90, 242, 2)


def test_finger_2_is_finger_1_renamed() -> None:
    rename = str.maketrans("1", "2")
    shared = {e for e in glr.finger(1).alphabet.names if e.endswith("*")}

    def renamed(event: str) -> str:
        return event if event in shared else event.translate(rename)

    ours = {(s, renamed(e), t) for s, e, t in glr.finger(1).transitions()}
    assert ours == set(glr.finger(2).transitions())


def test_there_is_no_finger_3() -> None:
    with pytest.raises(thenar.InputError, match="fingers 1 and 2, not 3"):
        glr.finger(3)


def test_every_result_that_the_reconstruction_must_reach_is_reached() -> None:
    assert [row for row in paper.results() if row.status == "exact" and not row.match] == []


def test_the_open_results_are_as_documented() -> None:
    """What the reconstruction gives where the published figure is not reached; the documentation prints these."""
    computed = {row.what: row.computed for row in paper.results() if row.status == "open"}
    assert computed["legal language E: states / transitions"] == "3360 / 68704"
    assert computed["supC(E, G): states / transitions"] == "2809 / 6076"
    assert computed["simulation 6.1: state numbers"] == "0 1 2 6 12 25 46 75"
    assert computed["simulation 6.2: state numbers"].startswith("0 1 2 3 8 17 30 54 77 112")


def test_the_simulations_print_the_papers_own_words() -> None:
    lines = [str(status) for step in paper.simulations()[0] for status in step.statuses]
    assert lines[:3] == [
        "Event approach_1 is enabled at state 0",
        "Event approach_2 is disabled at state 0",
        "Event approach_2 is enabled at state 1",
    ]
    assert lines[-1].startswith("Event re-align_with_finger1* is disabled at state ")


def test_the_error_free_task_is_marked_by_the_supervisor() -> None:
    supervisor = thenar.synthesize(glr.problem()).supervisor
    trace = thenar.shortest_trace(glr.adequate())
    assert trace is not None
    assert len(trace) == 20
    assert supervisor.automaton.marks(trace)


def test_when_a_counter_is_reset_changes_the_number_of_states_but_not_the_language() -> None:
    """The counters of specifications 2 and 4, reset by the next approach or as soon as a finger goes back."""
    problem = glr.problem()
    ours = thenar.supcon(problem.plants, problem.specs)
    back2 = ["retract_finger_1", "prox_breakC_1", "retract_finger_2", "prox_breakC_2"]
    early = [
        reset_by(back2, glr.spec2()),
        reset_by(["prox_breakC_1", "prox_breakC_2"], glr.spec4()),
    ]
    specs = [s for s in problem.specs if s.name not in ("SPEC2", "SPEC4")]
    other = thenar.supcon(problem.plants, [*specs, *early])
    assert (ours.n_states, other.n_states) == (2809, 1681)
    assert thenar.is_isomorphic(thenar.minimize(ours), thenar.minimize(other))
    assert thenar.minimize(ours).n_states == 609


def reset_by(events: list[str], spec: thenar.Automaton) -> thenar.Automaton:
    """The specification with its counter reset by ``events`` instead of approach_1."""
    start = spec.states[spec.initial]
    states = [spec.states[q] for q in range(spec.n_states)]
    lines = [t for t in spec.transitions() if t[1] != "approach_1"]
    lines += [(q, e, start) for q in states for e in events]
    return thenar.Automaton.from_transitions(lines, initial=start, marked=states, events=glr.EVENTS, name=spec.name)


def test_supcon_of_the_composed_problem_is_that_of_its_parts() -> None:
    """supC(E, G) as the paper forms it, and from the automata on the fly."""
    problem = glr.problem()
    composed = thenar.supcon(thenar.sync(*problem.plants), glr.legal())
    assert thenar.is_isomorphic(composed, thenar.synthesize(problem).supervisor.automaton)


@pytest.mark.skipif(not SHARED.exists(), reason="the reconstruction's notes are not at hand")
def test_the_automata_are_those_of_the_reconstruction() -> None:
    noted = json.loads(SHARED.read_text())
    for automaton in glr.problem().automata:
        there = noted["automata"][automaton.name]
        assert set(automaton.transitions()) == {tuple(t) for t in there["transitions"]}
        assert automaton.states[automaton.initial] == there["initial"]
        marked = {automaton.states[q] for q in range(automaton.n_states) if automaton.marked[q]}
        assert marked == set(there["marked"])
    controllable = {name: event["controllable"] for name, event in noted["events"].items()}
    assert {e.name: e.controllable for e in glr.EVENTS} == controllable
