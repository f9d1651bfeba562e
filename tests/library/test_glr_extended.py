"""The extended task: the object can be dropped, a skill can take too long, a finger can touch what it should not."""

from functools import cache

import pytest
from tests.oracles import tct

import thenar
from thenar import library
from thenar.library import glr
from thenar.library.glr import extended
from thenar.model.automaton import Automaton
from thenar.testing import assert_isomorphic

NEW = glr.EXTENDED_EVENTS.names[len(glr.EVENTS) :]
COMES_BACK = ["retract_finger_1", "retract_finger_2", "prox_breakC_1", "prox_breakC_2"]
UNCONTROLLABLE = [e.name for e in glr.EXTENDED_EVENTS if not e.controllable]
TO_THE_LIFT = (
    "approach_1, approach_2, align_finger2*, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, "
    "orient_normal1, orient_normal2, apply_gripF*, apply_loadF*, remote_breakC*"
)
LET_GO = "prox_breakC_1, prox_breakC_2"


@cache
def supervisor() -> thenar.Supervisor:
    return thenar.synthesize(glr.problem("extended")).supervisor


def law(*lines: tuple[str, list[str] | tuple[str, ...], str]) -> Automaton:
    """What may happen, over all 33 events; every state is marked and the first one is initial."""
    return Automaton.from_transitions(
        [(state, e, after) for state, events, after in lines for e in events],
        initial=lines[0][0],
        marked={state for state, _, _ in lines},
        events=glr.EXTENDED_EVENTS,
        alphabet=glr.EXTENDED_EVENTS.names,
    )


def all_but(*events: str) -> list[str]:
    return [e for e in glr.EXTENDED_EVENTS.names if e not in events]


def entered_by(*events: str) -> set[int]:
    """The supervisor's states that one of ``events`` enters."""
    s = supervisor().automaton
    return {y for x in range(s.n_states) for e, y in s.row(x) if s.alphabet[e].name in events}


# -- the model -------------------------------------------------------------------------------------------------


def test_the_papers_28_events_come_first_and_the_new_ones_are_uncontrollable() -> None:
    assert glr.EXTENDED_EVENTS[: len(glr.EVENTS)] == glr.EVENTS
    assert NEW == ("obj_dropped*", "timeout_1", "timeout_2", "unexpected_contact_1", "unexpected_contact_2")
    assert all(e.meaning and not e.controllable for e in glr.EXTENDED_EVENTS[len(glr.EVENTS) :])


def test_the_paper_is_the_default() -> None:
    for ours, papers in zip(glr.problem().automata, glr.problem("paper").automata, strict=True):
        assert (ours.name, list(ours.transitions())) == (papers.name, list(papers.transitions()))
    assert glr.problem("paper").alphabet == glr.EVENTS


@pytest.mark.parametrize("i", [1, 2])
def test_without_a_failure_a_finger_does_what_the_papers_does_and_may_let_go_in_two_more_states(i: int) -> None:
    failed = {"failed_free", "failed_touching", "failed_holding", "late"}
    transitions = {t for t in extended.finger(i).transitions() if t[1] not in NEW and t[0] not in failed}
    more = {(state, f"prox_breakC_{i}", "neutral") for state in ("at_Z", "squeezed")}
    assert transitions == set(glr.finger(i).transitions()) | more


def test_finger_2_is_finger_1_renamed() -> None:
    shared = {e for e in extended.finger(1).alphabet.names if e.endswith("*")}
    ours = {(s, e if e in shared else e.translate({49: "2"}), t) for s, e, t in extended.finger(1).transitions()}
    assert ours == set(extended.finger(2).transitions())


def test_what_a_finger_does_in_any_state_but_the_release_can_time_out_and_leads_back() -> None:
    finger = extended.finger(1)
    for q in range(finger.n_states):
        name = finger.states[q]
        if name == "released" or name.startswith("failed") or name == "late":
            continue
        failed = finger.step(q, "timeout_1")
        assert failed is not None, name
        back = {finger.states[t] for e, t in finger.row(failed) if finger.alphabet[e].controllable}
        assert back == {"released" if name == "replaced" else "neutral"}


def test_the_plant_still_has_only_two_marker_states() -> None:
    G = thenar.sync(*glr.problem("extended").plants)
    assert (G.n_states, G.n_transitions) == (176, 801)  # as documented
    assert [G.states[q] for q in range(G.n_states) if G.marked[q]] == ["neutral|neutral", "released|released"]


# -- the supervisor --------------------------------------------------------------------------------------------


def test_the_supervisor_exists_is_nonblocking_and_disables_no_uncontrollable_event() -> None:
    s = supervisor()
    assert (s.n_states, s.n_transitions) == (26163, 99996)  # as documented; TCT's, see below
    assert thenar.is_nonblocking(s.automaton)
    assert thenar.is_controllable(s.automaton, glr.problem("extended").plants)
    occurring = {s.automaton.alphabet[e].name for e in set(s.automaton.events.tolist())}
    assert occurring == set(glr.EXTENDED_EVENTS.names)


def test_tct_computes_the_same_supervisor() -> None:
    problem = glr.problem("extended")
    assert_isomorphic(supervisor().automaton, tct.supcon(problem.plants, problem.specs))


def test_the_error_free_task_is_marked_by_the_supervisor() -> None:
    assert thenar.is_sublanguage(glr.adequate(), supervisor().automaton)


def test_without_a_failure_it_is_the_papers_supervised_task_less_what_lets_go_in_the_air() -> None:
    """The languages are equal: nothing else of the paper's is lost, and nothing is gained."""
    no_failure = law(("well", all_but(*NEW), "well"))
    ours = thenar.project(thenar.sync(supervisor().automaton, no_failure), glr.EVENTS)
    holds_on = law(
        ("table", all_but("remote_breakC*"), "table"),
        ("table", ["remote_breakC*"], "air"),
        ("air", all_but("remote_makeC*", "prox_breakC_1", "prox_breakC_2"), "air"),
        ("air", ["remote_makeC*"], "table"),
    )
    paper = thenar.synthesize(glr.problem()).supervisor.automaton
    less = thenar.project(thenar.sync(paper, thenar.sync(holds_on, no_failure)), glr.EVENTS)
    assert thenar.is_nonblocking(ours)
    assert_isomorphic(thenar.minimize(ours), thenar.minimize(less))
    assert thenar.is_sublanguage(ours, paper)
    lost = thenar.is_sublanguage(paper, ours).witness
    assert lost is not None
    assert [*lost][-2:] == ["remote_breakC*", "prox_breakC_1"]


# -- what must follow ------------------------------------------------------------------------------------------


def test_after_a_failure_nothing_is_enabled_but_coming_back_until_finger_1_approaches_again() -> None:
    """... and that it may do only when both fingers are back."""
    comes_back = law(
        ("well", all_but(*NEW), "well"),
        ("well", NEW, "failed"),
        ("failed", [*UNCONTROLLABLE, *COMES_BACK], "failed"),
        ("failed", ["approach_1"], "well"),
    )
    s = supervisor().automaton
    assert thenar.is_sublanguage(s, comes_back)
    G = glr.problem("extended").plants
    for x in range(s.n_states):
        if s.step(x, "approach_1") is not None:
            assert s.states[x].split("|")[: len(G)] == ["neutral", "neutral"]


def test_every_failure_leads_back_within_three_events() -> None:
    """Both fingers break contact, and at most one of them finds its contact unstable or askew before it does."""
    s = supervisor().automaton
    longest: dict[int, int] = {}

    def way_back(x: int) -> int:
        if x not in longest:
            steps = [y for e, y in s.row(x) if s.alphabet[e].name not in (*NEW, "approach_1")]
            assert steps or s.marked[x]
            longest[x] = max((1 + way_back(y) for y in steps), default=0)
        return longest[x]

    assert max(way_back(x) for x in entered_by(*NEW)) == 3


def test_after_the_object_is_dropped_both_fingers_let_go_and_the_task_ends() -> None:
    s = supervisor().automaton
    states = entered_by("obj_dropped*")
    assert states
    for dropped in states:
        x = dropped
        while enabled := [e.name for e in s.enabled(x) if e.controllable]:
            assert set(enabled) <= {"prox_breakC_1", "prox_breakC_2"}
            after = s.step(x, enabled[0])
            assert after is not None
            x = after
        assert s.marked[x]
        assert s.states[x].startswith("neutral|neutral|")
    ended = law(
        ("before", all_but("obj_dropped*"), "before"),
        ("before", ["obj_dropped*"], "after"),
        ("after", [*UNCONTROLLABLE, *COMES_BACK], "after"),
    )
    assert thenar.is_sublanguage(s, ended)


def test_two_failures_are_forgiven_and_the_third_ends_the_task() -> None:
    def ends_after(n: int) -> Automaton:
        failing = [(str(k), NEW, str(k + 1)) for k in range(n)]
        onward = [(str(k), all_but(*NEW), str(k)) for k in range(n)]
        return law(*failing, *onward, (str(n), [*UNCONTROLLABLE, *COMES_BACK], str(n)))

    s = supervisor().automaton
    assert thenar.is_sublanguage(s, ends_after(extended.RETRIES + 1))
    assert not thenar.is_sublanguage(s, ends_after(extended.RETRIES))
    task = thenar.shortest_trace(glr.adequate())
    assert task is not None
    failure = ["approach_1", "timeout_2", "retract_finger_2", "retract_finger_1"]
    assert s.marks([*failure * 2, *task])
    assert not s.generates([*failure * 3, "approach_1"])


def test_the_object_is_not_let_go_in_the_air_unless_something_failed() -> None:
    s = supervisor()
    in_air = [x for x in range(s.n_states) if set(s.automaton.states[x].split("|")[:2]) <= set(extended.IN_AIR)]
    assert in_air
    for x in in_air:
        assert {e.name for e in s.pattern(x).disabled} >= {"prox_breakC_1", "prox_breakC_2"}


def test_an_object_that_was_let_go_in_the_air_is_not_approached_again() -> None:
    """Its place is known no more; one that was put down, or never lifted, is where it was."""
    known = law(
        ("table", all_but("remote_breakC*"), "table"),
        ("table", ["remote_breakC*"], "air"),
        ("air", all_but("remote_makeC*", "approach_1"), "air"),
        ("air", ["remote_makeC*"], "table"),
    )
    assert thenar.is_sublanguage(supervisor().automaton, known)


@pytest.mark.parametrize(
    ("happens", "again"),
    [
        pytest.param("approach_1, unexpected_contact_2, retract_finger_2, retract_finger_1", True, id="collision"),
        pytest.param("unexpected_contact_1, retract_finger_1", True, id="collision of the first finger"),
        pytest.param(
            "approach_1, approach_2, align_finger2*, timeout_1, retract_finger_1, retract_finger_2",
            True,
            id="missing object",
        ),
        pytest.param(
            "approach_1, approach_2, align_finger2*, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, "
            f"orient_normal1, orient_normal2, apply_gripF*, apply_loadF*, timeout_1, {LET_GO}",
            True,
            id="glued to the table",
        ),
        pytest.param(f"{TO_THE_LIFT}, timeout_1, obj_dropped*, {LET_GO}", False, id="dropped as time runs out"),
        pytest.param(
            f"{TO_THE_LIFT}, dec_gripF*, incip_slip*, inc_gripF*, move_to_Z*, obj_dropped*, {LET_GO}",
            False,
            id="pulled out while squeezed",
        ),
        pytest.param(f"{TO_THE_LIFT}, move_to_Z*, stiffness_EP*, timeout_1, {LET_GO}", False, id="the table has gone"),
        pytest.param(
            f"{TO_THE_LIFT}, move_to_Z*, stiffness_EP*, remote_makeC*, timeout_1, {LET_GO}",
            False,
            id="slow release, which completes the task",
        ),
    ],
)
def test_each_hole_of_the_papers_alphabet_has_its_way_back(happens: str, again: bool) -> None:
    s = supervisor().automaton
    assert s.marks(happens)
    assert s.generates(f"{happens}, approach_1") is again


# -- the door --------------------------------------------------------------------------------------------------


def test_an_unknown_variant_is_refused_with_the_nearest() -> None:
    with pytest.raises(thenar.UnknownName, match=r"^unknown variant 'extendd'; did you mean 'extended'\?$"):
        glr.problem("extendd")


@pytest.mark.parametrize("text", ["glr(extended)", " glr( extended ) "])
def test_a_model_text_names_the_variant(text: str) -> None:
    assert library.model(text).name == "glr(extended)"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("glr(extendd)", r"model 'glr\(extendd\)': unknown variant 'extendd'; did you mean 'extended'\?"),
        ("glr(2)", r"model 'glr\(2\)': unknown variant 2"),
        ("glr(timed, 3)", "the timed variant of glr has two fingers, not 3"),
        ("glr(extended, 2, 2)", "too many positional arguments"),
        ("dining(five)", "whole number of philosophers, at least 2, not 'five'"),
        ("dining(12345678901)", "no model has that many parts"),
    ],
)
def test_a_model_text_with_a_wrong_argument_is_refused_in_a_sentence(text: str, says: str) -> None:
    with pytest.raises(thenar.InputError, match=says):
        library.model(text)
