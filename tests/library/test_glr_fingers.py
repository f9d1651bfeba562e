"""The paper's task with more than its two fingers."""

import dataclasses
import re
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from random import Random

import pytest

import thenar
from thenar import library
from thenar.library import glr
from thenar.library.glr.automata import ERROR_FREE
from thenar.model.automaton import Automaton
from thenar.testing import assert_isomorphic

OBJECT = {
    *("apply_gripF*", "apply_loadF*", "inc_gripF*", "remote_breakC*", "dec_gripF*", "incip_slip*"),
    *("move_to_Z*", "stiffness_EP*", "remote_makeC*"),
}
THUMB = {"approach_1", "retract_finger_1", "prox_make_C1", "prox_breakC_1"}
PAPER = {"detect_misalignment_2*": "detect_misalignment*", "re-align_finger2_with_finger1*": "re-align_with_finger1*"}
MANY = [3, 4, 10]


@cache
def supervisor(fingers: int) -> Automaton:
    return thenar.synthesize(glr.problem(fingers=fingers)).supervisor.automaton


def renamed(automaton: Automaton, name: Callable[[str], str]) -> Automaton:
    """The same automaton with other names for its events, in the same places of the alphabet."""
    events = thenar.Alphabet(dataclasses.replace(e, name=name(e.name)) for e in automaton.alphabet)
    return dataclasses.replace(automaton, alphabet=events)


def as_the_paper_names_it(event: str) -> str:
    return PAPER.get(event, event)


def numbers(text: str) -> list[int]:
    return [int(n) for n in re.findall(r"\d+", text)]


def concerned(event: str, fingers: int) -> set[int]:
    """Whom the event concerns, by its name and nothing else: a number is a finger's, and a * without one is all's."""
    if event in OBJECT:
        return set(range(1, fingers + 1))
    return {*numbers(event), 1} if event.endswith("*") else {*numbers(event)}


# -- the model -------------------------------------------------------------------------------------------------


def test_two_fingers_are_the_papers_problem_and_the_default() -> None:
    assert thenar.dumps(glr.problem(fingers=2)) == thenar.dumps(glr.problem())
    assert glr.problem(fingers=2).alphabet.names == glr.EVENTS.names
    assert (supervisor(2).n_states, supervisor(2).n_transitions) == (2809, 6076)


@pytest.mark.parametrize("n", MANY)
def test_a_finger_more_has_eleven_events_three_of_them_uncontrollable(n: int) -> None:
    events = glr.problem(fingers=n).alphabet
    assert events == glr.events(n)
    assert (len(events), int(events.uncontrollable.sum())) == (11 * n + 6, 3 * n)
    assert all(e.meaning for e in events)
    assert len({e.meaning for e in events}) == len(events)


@pytest.mark.parametrize("n", MANY)
def test_every_event_is_in_the_fingers_that_it_concerns_and_in_no_other(n: int) -> None:
    problem = glr.problem(fingers=n)
    for event in problem.alphabet.names:
        having = {i for i in range(1, n + 1) if event in problem.automaton(f"FINGER{i}").alphabet}
        having |= {1 for k in range(2, n + 1) if event in problem.automaton(f"REFERENCE{k}").alphabet}
        assert having == concerned(event, n), event


@pytest.mark.parametrize("n", MANY)
def test_an_event_couples_at_most_a_finger_and_finger_1_except_the_objects_and_four_of_finger_1(n: int) -> None:
    """The automata of finger k are FINGERk, REFERENCEk, SPEC1_k, SPEC2_k and SPEC3_k."""
    problem = glr.problem(fingers=n)
    wide = set()
    for event in problem.alphabet.names:
        of = {numbers(a.name)[-1] for a in problem.automata if event in a.alphabet and a.name != "SPEC4"}
        if len(of - {1}) > 1:
            wide.add(event)
    assert wide == OBJECT | THUMB
    assert set(problem.automaton("SPEC4").alphabet.names) < OBJECT | THUMB


def test_no_automaton_grows_with_the_number_of_fingers() -> None:
    def sizes(n: int) -> dict[str, set[tuple[int, int, int]]]:
        kinds: dict[str, set[tuple[int, int, int]]] = {}
        for a in glr.problem(fingers=n).automata:
            kind = "THUMB" if a.name == "FINGER1" else a.name.rstrip("0123456789")
            kinds.setdefault(kind, set()).add((a.n_states, a.n_transitions, len(a.alphabet)))
        return kinds

    assert len(glr.problem(fingers=100).automata) == 5 * 100 - 2
    assert sizes(3) == sizes(4) == sizes(100)
    assert max(states for kind in sizes(3).values() for states, _, _ in kind) == 18


@pytest.mark.parametrize("k", [2, 3, 7])
def test_every_other_finger_is_finger_2_renamed_and_so_are_its_specifications(k: int) -> None:
    def rename(event: str) -> str:
        return event if event in OBJECT else event.replace("2", str(k))

    for part in (glr.finger, glr.reference, glr.spec1, glr.spec2, glr.spec3):
        second = {(s.replace("2", str(k)), rename(e), t.replace("2", str(k))) for s, e, t in part(2, 7).transitions()}
        theirs = {(s.replace("2", str(k)), e, t.replace("2", str(k))) for s, e, t in part(k, 7).transitions()}
        assert second == theirs


def test_finger_1_and_its_reference_are_the_papers_finger_1() -> None:
    """So the two-finger task is not another one, only drawn with finger 1 in one piece."""
    assert_isomorphic(renamed(thenar.sync(glr.finger(1, 3), glr.reference(2, 3)), as_the_paper_names_it), glr.finger(1))


def test_the_nominal_task_is_the_papers_a() -> None:
    assert glr.nominal() == thenar.Trace(ERROR_FREE)
    assert thenar.shortest_trace(glr.adequate(5)) == glr.nominal(5)


# -- the supervisor --------------------------------------------------------------------------------------------


def test_three_fingers_have_a_supervisor() -> None:
    s = supervisor(3)
    assert (s.n_states, s.n_transitions) == (164599, 557509)  # TCT finds the same, but takes a minute
    assert thenar.is_nonblocking(s)
    assert thenar.is_controllable(s, glr.problem(fingers=3).plants)
    assert {s.alphabet[e].name for e in set(s.events.tolist())} == set(glr.events(3).names)


@pytest.mark.parametrize(("n", "states"), [(2, 2809), (3, 164599), (4, 13595845)])
def test_the_number_of_states_is_as_documented(n: int, states: int) -> None:
    """The page's formula; the supervisor of four fingers takes some seconds and 2 GB, too much for a test."""
    m = n - 1
    assert 4 * 115**m + 4 * 99**m + 13 * 63**m + 66 * 18**m - 6 * 9**m == states
    if n < 4:
        assert supervisor(n).n_states == states


@pytest.mark.parametrize("n", [2, 3])
def test_the_nominal_task_is_marked_by_the_supervisor(n: int) -> None:
    assert thenar.is_sublanguage(glr.adequate(n), supervisor(n))


def test_exchanging_fingers_2_and_3_gives_the_same_supervisor() -> None:
    exchange = str.maketrans("23", "32")
    assert thenar.is_isomorphic(renamed(supervisor(3), lambda e: e.translate(exchange)), supervisor(3))


def test_hiding_the_events_of_finger_3_leaves_the_supervised_task_of_two_fingers() -> None:
    """Fingers 1 and 2 can do neither more nor less because there is a third: the languages are equal."""
    three = renamed(thenar.minimize(supervisor(3)), as_the_paper_names_it)
    two = thenar.project(three, glr.EVENTS, limits=thenar.Limits(states=100_000))
    assert thenar.is_isomorphic(thenar.minimize(two), thenar.minimize(supervisor(2)))


def local(i: int, fingers: int) -> Automaton:
    """Return finger i's own supervisor, which looks at nothing but finger i and its third specification."""
    return thenar.supcon(glr.finger(i, fingers), glr.spec3(i, fingers))


@pytest.mark.parametrize("n", [2, 3])
def test_the_supervisor_is_the_specifications_and_a_supervisor_of_each_finger_by_itself(n: int) -> None:
    problem = glr.problem(fingers=n)
    modular = thenar.sync(*problem.automata, *(local(i, n) for i in range(1, n + 1)))
    assert thenar.is_isomorphic(modular, supervisor(n))


@pytest.mark.parametrize("n", [2, 5, 10])
def test_a_fingers_own_supervisor_forbids_a_contact_after_three_failures_and_nothing_else(n: int) -> None:
    for i in range(1, n + 1):
        finger, spec = glr.finger(i, n), glr.spec3(i, n)
        found = thenar.synthesize(thenar.Problem(finger, spec)).supervisor
        forbids = {
            (found.automaton.states[x].split("|")[1], e.name)
            for x in range(found.n_states)
            for e in found.pattern(x).disabled
        }
        assert forbids == {("failures_3", f"prox_make_C{i}")}


# -- many fingers: the automata side by side, never their product -------------------------------------------------


class Parts:
    """S/G by its parts: the plants, the specifications and the fingers' own supervisors, each in its state."""

    def __init__(self, fingers: int) -> None:
        problem = glr.problem(fingers=fingers)
        self.plants = range(len(problem.plants))
        self.specs = range(len(problem.plants), len(problem.automata))
        self.automata = [*problem.automata, *(local(i, fingers) for i in range(1, fingers + 1))]
        self.state = [a.initial for a in self.automata]
        self.having = {e: [j for j, a in enumerate(self.automata) if e.name in a.alphabet] for e in problem.alphabet}
        self.by_name = {e.name: e for e in problem.alphabet}

    def can(self, event: thenar.Event, among: range | None = None) -> bool:
        return all(
            self.automata[j].step(self.state[j], event.name) is not None
            for j in self.having[event]
            if among is None or j in among
        )

    def enabled(self) -> list[thenar.Event]:
        return [e for e in self.having if self.can(e)]

    def do(self, name: str) -> None:
        event = self.by_name[name]
        assert self.can(event), name
        for j in self.having[event]:
            after = self.automata[j].step(self.state[j], name)
            assert after is not None
            self.state[j] = after

    def marked(self) -> bool:
        return all(self.automata[j].marked[self.state[j]] for j in self.plants)

    def finger(self, i: int) -> str:
        j = next(j for j in self.plants if self.automata[j].name == f"FINGER{i}")
        return self.automata[j].states[self.state[j]]


def go_back(parts: Parts, fingers: int) -> None:
    """Lead every finger back by controllable events only, or, once the object is at its height, to the release."""
    if parts.finger(1) in ("at_Z", "squeezed", "replaced"):
        for event in ("stiffness_EP*", "remote_makeC*"):
            if parts.can(parts.by_name[event]):
                parts.do(event)
    for i in range(1, fingers + 1):
        while (state := parts.finger(i)) not in ("neutral", "released"):
            way = {"contact": "suppress_vib", "stable": "orient_normal"}.get(state, "prox_breakC_")
            parts.do(f"{'retract_finger_' if state in ('approached', 'misaligned', 'aligned') else way}{i}")


@pytest.mark.parametrize("n", [3, 10, 30])
def test_many_fingers_do_the_nominal_task_under_the_modular_supervisor(n: int) -> None:
    parts = Parts(n)
    for event in glr.nominal(n):
        parts.do(event)
    assert parts.marked()
    assert [parts.finger(i) for i in range(1, n + 1)] == ["released"] * n


@pytest.mark.parametrize(
    ("n", "seed", "on_course"), [(3, 0, 0.97), (6, 2, 0.97), (10, 4, 0.97), (3, 1, 0.7), (10, 5, 0.3)]
)
def test_the_modular_supervisor_is_controllable_and_nonblocking_wherever_it_gets(
    n: int, seed: int, on_course: float
) -> None:
    """Random walks, most of which favour the nominal task: chance alone would hardly get far in it."""
    parts, chance, nominal = Parts(n), Random(seed), {*glr.nominal(n)} - {f"prox_breakC_{i}" for i in range(1, n + 1)}
    seen = set()
    for _ in range(60 * n):
        for e in parts.having:
            assert e.controllable or not parts.can(e, parts.plants) or parts.can(e)
        here = parts.state.copy()
        go_back(parts, n)
        assert parts.marked()
        parts.state = here
        enabled = parts.enabled()
        if not enabled:
            parts.state = [a.initial for a in parts.automata]
            continue
        wanted = [e for e in enabled if e.name in nominal]
        event = chance.choice(wanted if wanted and chance.random() < on_course else enabled)
        parts.do(event.name)
        seen.add(event.name)
    assert seen >= OBJECT or on_course < 0.9


# -- what the supervisor does ------------------------------------------------------------------------------------


def after(*events: str) -> set[str]:
    """The controllable events that three supervised fingers can do after ``events``."""
    s = supervisor(3)
    return {e.name for e in s.enabled(s.run(events)[-1]) if e.controllable}


def test_finger_1_approaches_first_and_the_others_in_any_order() -> None:
    assert after() == {"approach_1"}
    assert after("approach_1") == {"approach_2", "approach_3", "retract_finger_1"}


def test_finger_1_makes_contact_when_all_are_aligned_with_it_and_no_grip_before_all_are_secured() -> None:
    nominal = list(glr.nominal(3))
    for k, (event, following) in enumerate(pairwise(nominal)):
        enabled = after(*nominal[: k + 1])
        assert following in enabled or following == "incip_slip*"
        if event in ("approach_3", "align_finger2*"):
            assert "prox_make_C1" not in enabled
        assert ("apply_gripF*" in enabled) is (following == "apply_gripF*")


def test_two_attempts_to_align_are_allowed_to_each_finger() -> None:
    def attempt(k: int) -> list[str]:
        return [f"detect_misalignment_{k}*", f"re-align_finger{k}_with_finger1*"]

    start = ["approach_1", "approach_2", "approach_3"]
    assert attempt(3)[1] in after(*start, *attempt(2) * 2, attempt(3)[0])
    third = after(*start, *attempt(2) * 2, *attempt(3), attempt(2)[0])
    assert attempt(2)[1] not in third
    assert "retract_finger_2" in third


def test_a_finger_that_failed_three_times_makes_no_contact_again() -> None:
    s = supervisor(3)
    start = ["approach_1", "approach_2", "approach_3", "align_finger2*", "align_finger3*"]
    back = ["unstable_contact_3", "prox_breakC_3", "retract_finger_2", "retract_finger_1"]
    failed = [*start, "prox_make_C3", *back]
    assert s.marks(failed * 3)
    assert "prox_make_C3" in after(*failed * 2, *start)
    assert after(*failed * 3, *start) == {
        "prox_make_C1", "prox_make_C2", "retract_finger_1", "retract_finger_2", "retract_finger_3",
    }  # fmt: skip


# -- the door --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fingers", [1, 0, -3, 2.0, True, "two", None])
def test_fewer_than_two_fingers_are_refused(fingers: object) -> None:
    with pytest.raises(thenar.InputError, match="glr: fingers must be a whole number of fingers, at least 2, not"):
        glr.problem(fingers=fingers)  # type: ignore[arg-type]


def test_the_extended_task_has_two_fingers() -> None:
    assert glr.problem("extended", 2).name == "glr(extended)"
    with pytest.raises(thenar.InputError, match="the extended variant of glr has two fingers, not 3"):
        glr.problem("extended", fingers=3)


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (lambda: glr.finger(4, 3), "the task has fingers 1 to 3, not 4"),
        (lambda: glr.spec3(0, 3), "the task has fingers 1 to 3, not 0"),
        (lambda: glr.spec1(1, 3), "finger 1 of 3 is not aligned with finger 1; fingers from 2 on are"),
        (lambda: glr.reference(4, 3), "finger 4 of 3 is not aligned with finger 1"),
        (lambda: glr.nominal(1), "at least 2, not 1"),
        (lambda: glr.events(1), "at least 2, not 1"),
    ],
)
def test_a_finger_that_the_task_does_not_have_is_refused(part: Callable[[], object], says: str) -> None:
    with pytest.raises(thenar.InputError, match=says):
        part()


@pytest.mark.parametrize(
    "text",
    [
        "glr(paper, 3)",
        "glr(fingers=3)",
        "glr(paper, fingers=3)",
        " glr( fingers = 3 , variant = paper ) ",
        "glr(paper,3,)",
    ],
)
def test_a_model_text_names_the_fingers(text: str) -> None:
    assert library.model(text).name == "glr(fingers=3)"


@pytest.mark.parametrize("name", library.MODELS)
def test_the_name_of_a_library_model_is_a_text_that_gives_it(name: str) -> None:
    text = {"chain": "chain(3)", "dining": "dining(3)", "small_factory": "small_factory(3, repair_priority=True)"}
    problem = library.model(text.get(name, name))
    assert repr(library.model(problem.name)) == repr(problem)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("glr(fingers=1)", "whole number of fingers, at least 2, not 1"),
        ("glr(fingers=three)", "whole number of fingers, at least 2, not 'three'"),
        ("glr(extended, 3)", "has two fingers, not 3"),
        ("glr(finger=3)", r"model 'glr\(finger=3\)': it takes no 'finger'; it is glr\(variant"),
        ("glr(fingers=3, fingers=3)", "'fingers' is given twice"),
        ("glr(paper, variant=paper)", "multiple values for argument 'variant'"),
        ("glr(fingers=3, paper)", "the value 'paper' comes after 'fingers'; values with a name come last"),
        ("glr(fingers=)", "an argument is a value or name=value, not 'fingers='"),
        ("glr(,3)", "an argument is a value or name=value, not ''"),
        ("glr(paper 3)", "an argument is a value or name=value, not 'paper 3'"),
        ("dining(-5)", "an argument is a value or name=value, not '-5'"),
        ("small_factory(repair_priority=no)", "'repair_priority' is True or False, not 'no'"),
        ("glr(fingers=12345678901)", "no model has that many parts"),
    ],
)
def test_a_model_text_with_a_wrong_argument_is_refused_in_a_sentence(text: str, says: str) -> None:
    with pytest.raises(thenar.InputError, match=says):
        library.model(text)


def test_a_word_that_says_no_is_no() -> None:
    assert library.model("small_factory(2, repair_priority=False)").name == "small_factory(2)"
