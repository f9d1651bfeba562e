"""Supervisor reduction and localization: they control alike, never in more states than TCT does."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import replace
from random import Random
from types import ModuleType

import numpy as np
import pytest
from hypothesis import assume, given, settings
from tests.oracles.worker import PeerError

import thenar
from thenar.explicit.reduction import Reduction, localize, supreduce
from thenar.library import glr
from thenar.library.classics import cat_and_mouse, chain, dining, small_factory, transfer_line
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.testing import assert_same_languages, control_oracle, random_problem
from thenar.testing.strategies import problems

quick = settings(max_examples=150, deadline=None)


@pytest.fixture(scope="module")
def tct() -> ModuleType:
    from tests.oracles import tct

    return tct


@pytest.fixture(scope="module")
def libfaudes() -> ModuleType:
    from tests.oracles import libfaudes

    return libfaudes


def drawn(n: int, most_states: int) -> Iterator[tuple[Problem, Automaton]]:
    """Random problems that have a supervisor of at most ``most_states`` states."""
    for seed in range(n):
        problem = random_problem(Random(seed))
        supervisor = thenar.supcon(problem.plants, problem.specs)
        if 0 < supervisor.n_states <= most_states:
            yield problem, supervisor


def together(problem: Problem, controllers: tuple[Reduction, ...]) -> Automaton:
    return thenar.sync(*problem.plants, *(c.automaton for c in controllers))


# -- theorems ------------------------------------------------------------------------------------------------


@quick
@given(problems())
def test_the_reduced_supervisor_controls_alike(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    small = supreduce(problem.plants, supervisor)
    assert small.lower_bound <= small.n_states <= supervisor.n_states
    assert_same_languages(thenar.closed_loop(problem.plants, small), supervisor)


def test_one_thousand_reduced_supervisors_control_alike() -> None:
    for seed in range(1000):
        problem = random_problem(Random(seed))
        supervisor = thenar.supcon(problem.plants, problem.specs)
        loop = thenar.closed_loop(problem.plants, supreduce(problem.plants, supervisor))
        assert thenar.is_isomorphic(thenar.minimize(loop), thenar.minimize(supervisor)), f"seed {seed}"


@quick
@given(problems(max_specs=2))
def test_any_supervisor_can_be_reduced_also_one_that_follows_the_plant_loosely(problem: Problem) -> None:
    """A specification that happens to be controllable is a supervisor with an alphabet of its own."""
    spec = thenar.sync(*(problem.specs or problem.plants[:1]))
    assume(thenar.is_controllable(spec, problem.plants))
    small = supreduce(problem.plants, spec)
    assert small.n_states <= spec.n_states
    assert_same_languages(thenar.sync(*problem.plants, small.automaton), thenar.sync(*problem.plants, spec))


@quick
@given(problems())
def test_its_feedback_map_is_its_control_data(problem: Problem) -> None:
    small = supreduce(problem.plants, thenar.supcon(problem.plants, problem.specs))
    data = thenar.condat(problem.plants, small.automaton)
    assert np.array_equal(data.disabled_offsets, small.disabled_offsets)
    assert np.array_equal(data.disabled, small.disabled)


@quick
@given(problems())
def test_each_state_has_its_cell_and_events_lead_from_cell_to_cell(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    small = supreduce(problem.plants, supervisor)
    assert len(small.cells) == supervisor.n_states
    for x, cell in enumerate(small.cells.tolist()):
        for e, y in supervisor.row(x):
            assert small.automaton.step(cell, supervisor.alphabet[e]) == small.cells[y]


@quick
@given(problems(max_states=3))
def test_the_smallest_congruence_lies_between_the_lower_bound_and_what_is_found(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    assume(0 < supervisor.n_states <= 7)
    small = supreduce(problem.plants, supervisor)
    assert small.lower_bound <= control_oracle.fewest_cells(problem.plants, supervisor) <= small.n_states


@quick
@given(problems())
def test_it_is_never_larger_than_the_published_algorithms(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    assume(supervisor.n_states <= 40)
    slow = control_oracle.supreduce(problem.plants, supervisor)
    assert_same_languages(thenar.sync(*problem.plants, slow), supervisor)
    assert supreduce(problem.plants, supervisor).n_states <= slow.n_states


@quick
@given(problems())
def test_local_controllers_together_control_alike(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    assert_same_languages(together(problem, localize(problem.plants, supervisor)), supervisor)


@quick
@given(problems())
def test_a_local_controller_disables_the_events_of_its_plant_only(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    owner: dict[str, int] = {}
    for k, plant in enumerate(problem.plants):
        for e in plant.alphabet.names:
            owner.setdefault(e, k)
    for k, controller in enumerate(localize(problem.plants, supervisor)):
        alone = thenar.condat(problem.plants, controller.automaton)  # it is a controllable one
        assert {alone.automaton.alphabet[int(e)].name for e in alone.disabled} <= {e for e in owner if owner[e] == k}
        for x in range(controller.n_states):
            assert set(controller.pattern(x).disabled) <= set(alone.pattern(x).disabled)
            enabled = {e.name for e in controller.automaton.enabled(x)}
            assert enabled | {e.name for e in controller.pattern(x).disabled} == set(
                controller.automaton.alphabet.names
            )


@quick
@given(problems())
def test_the_same_input_gives_the_same_bytes(problem: Problem) -> None:
    supervisor = thenar.supcon(problem.plants, problem.specs)
    first, second = (supreduce(problem.plants, supervisor) for _ in range(2))
    assert first.cells.tobytes() == second.cells.tobytes()
    assert first.automaton.targets.tobytes() == second.automaton.targets.tobytes()


# -- beside the other tools ----------------------------------------------------------------------------------


def test_it_is_never_larger_than_tcts_on_one_thousand_problems(tct: ModuleType) -> None:
    for problem, supervisor in drawn(1000, most_states=1200):
        assert supreduce(problem.plants, supervisor).n_states <= tct.supreduce(problem.plants, supervisor).n_states


def test_local_controllers_are_never_larger_than_tcts_on_one_thousand_problems(tct: ModuleType) -> None:
    for problem, supervisor in drawn(1000, most_states=200):
        for ours, theirs in zip(
            localize(problem.plants, supervisor), tct.localize(problem.plants, supervisor), strict=True
        ):
            assert ours.n_states <= theirs.n_states


def test_without_marking_it_is_never_larger_than_libfaudess(libfaudes: ModuleType) -> None:
    """libFAUDES gives no thought to marking; so here everything is marked.

    Up to 200 states, libFAUDES 2.34 reduces 4 of 806 supervisors to what controls differently, and crashes on 4.
    """
    compared = 0
    for problem, drawn_supervisor in drawn(1000, most_states=100):
        plants, supervisor = [all_marked(p) for p in problem.plants], all_marked(drawn_supervisor)
        try:
            theirs = libfaudes.supreduce(plants, supervisor)
        except PeerError:
            continue
        if thenar.is_isomorphic(*(thenar.minimize(a) for a in (thenar.sync(*plants, theirs), supervisor))):
            compared += 1
            assert supreduce(plants, supervisor).n_states <= theirs.n_states
    assert compared > 700


def all_marked(a: Automaton) -> Automaton:
    return replace(a, marked=np.ones(a.n_states, np.bool_))


# -- answers -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("problem", "states", "bound"),
    [
        # Su and Wonham 2004, sec. 5, and TCT's supreduce 28 (65) -> 8 (31; slb=8)
        pytest.param(transfer_line(1), 8, 8, id="transfer_line(1)"),
        pytest.param(transfer_line(2), 64, 64, id="transfer_line(2)"),
        pytest.param(small_factory(2), 2, 2, id="small_factory(2)"),
        # IDES: SUPER 12 states, SIMSUP 3
        pytest.param(small_factory(2, repair_priority=True), 3, 3, id="small_factory(2, repair_priority)"),
        pytest.param(small_factory(4), 8, 8, id="small_factory(4)"),  # TCT
        pytest.param(chain(4), 8, 8, id="chain(4)"),  # TCT
        pytest.param(dining(3), 7, 7, id="dining(3)"),  # TCT
    ],
)
def test_sizes_of_the_classics(problem: Problem, states: int, bound: int) -> None:
    small = supreduce(problem.plants, thenar.synthesize(problem).supervisor)
    assert (small.n_states, small.lower_bound) == (states, bound)
    assert small.is_smallest


LABELS = [thenar.Event(e, controllable=e in "135") for e in "1234568"]


def labelled(arrows: list[str], marked: str, name: str = "") -> Automaton:
    """An automaton over the labels of TCT, in which states start with 0."""
    return Automaton.from_transitions(arrows, initial="0", marked=list(marked), events=LABELS, name=name)


@pytest.mark.parametrize(
    ("b1", "b2", "others", "whole", "reduced", "slb"),
    [
        ("01", "01", True, (25, 32), (11, 21), 10),
        ("0", "0", False, (6, 7), (3, 7), 3),
        ("0", "01", True, (13, 14), (7, 14), 7),
        ("01", "0", True, (11, 12), (6, 12), 6),
    ],
)
def test_sizes_of_a_transfer_line_with_other_markings_are_those_of_tcts_log(
    b1: str, b2: str, others: bool, whole: tuple[int, int], reduced: tuple[int, int], slb: int
) -> None:
    """The log of a TCT session of others: unit buffers, at most two workpieces in a row rejected."""
    plants = [
        labelled(["0 -1-> 1 -2-> 0"], "0", "M1"),
        labelled(["0 -3-> 1 -4-> 0"], "0", "M2"),
        labelled(["0 -5-> 1 -6,8-> 0"], "0", "TU"),
    ]
    specs = [labelled(["0 -2,8-> 1 -3-> 0"], b1, "B1"), labelled(["0 -4-> 1 -5-> 0"], b2, "B2")]
    if others:
        specs.append(labelled(["0 -6-> 0 -8-> 1 -6-> 0", "1 -8-> 2"], "012", "DESL"))
    supervisor = thenar.supcon(plants, specs)
    assert (supervisor.n_states, supervisor.n_transitions) == whole
    small = supreduce(plants, supervisor)
    assert small.n_states <= reduced[0]
    assert small.lower_bound >= slb
    assert small.n_states < reduced[0] or small.n_transitions == reduced[1]


def test_the_reduced_supervisor_of_the_small_factory_is_that_of_ides() -> None:
    """IDES's SIMSUP, 3 states and 10 transitions, leaves out the two events that never move it."""
    problem = small_factory(2, repair_priority=True)
    small = supreduce(problem.plants, thenar.synthesize(problem).supervisor).automaton
    ides = Automaton.from_transitions(
        [
            "1 -start_1,repair_1-> 1 -finish_1-> 3 -start_2-> 1 -break_2-> 2 -repair_2-> 1",
            "2 -start_1-> 2 -finish_1-> 3 -break_2,repair_2-> 3",
        ],
        initial="1",
        marked=["1"],
        events=problem.alphabet,
    )
    moves = [t for t in small.transitions() if t[1] not in ("break_1", "finish_2")]
    assert (small.n_states, len(moves)) == (ides.n_states, ides.n_transitions) == (3, 10)


@pytest.mark.parametrize("problem", [cat_and_mouse(), glr.problem()], ids=lambda p: p.name)
def test_larger_tasks_are_reduced_and_localized(problem: Problem) -> None:
    supervisor = thenar.synthesize(problem).supervisor
    small = supreduce(problem.plants, supervisor)
    assert small.n_states < supervisor.n_states
    minimal = thenar.minimize(supervisor.automaton)
    assert thenar.is_isomorphic(thenar.minimize(thenar.closed_loop(problem.plants, small)), minimal)
    assert thenar.is_isomorphic(thenar.minimize(together(problem, localize(problem.plants, supervisor))), minimal)


def test_the_grasp_lift_replace_task_is_reduced_below_tcts(tct: ModuleType) -> None:
    problem = glr.problem()
    supervisor = thenar.synthesize(problem).supervisor.automaton
    assert supreduce(problem.plants, supervisor).n_states <= tct.supreduce(problem.plants, supervisor).n_states


# -- the edges -----------------------------------------------------------------------------------------------

PLANT = Automaton.from_transitions(["0 -a-> 1 -u-> 0"], initial="0", marked=["0"], uncontrollable=["u"], name="G")


def test_a_supervisor_that_disables_an_uncontrollable_event_is_refused() -> None:
    deaf = Automaton.from_transitions(["0 -a-> 1"], initial="0", events=PLANT.alphabet, alphabet=["u"], name="S")
    for reduce in (supreduce, localize):
        with pytest.raises(thenar.InputError, match="after a the supervisor 'S' disables uncontrollable event 'u'"):
            reduce(PLANT, deaf)


def test_a_feedback_map_counts_as_much_as_missing_transitions() -> None:
    follows = Automaton.from_transitions(["0 -a-> 1 -u-> 0"], initial="0", marked=["0"], events=PLANT.alphabet)
    never = Supervisor(follows, np.array([0, 1, 1]), np.array([0], np.int32))
    small = supreduce(PLANT, never)
    assert (small.n_states, small.automaton.n_transitions, small.cells.tolist()) == (1, 0, [0, -1])
    assert [e.name for e in small.pattern(0).disabled] == ["a"]


def test_marking_by_the_supervisor_is_kept() -> None:
    always = all_marked(PLANT)
    at_first = Automaton.from_transitions(["0 -a-> 1 -u-> 0"], initial="0", marked=["0"], events=PLANT.alphabet)
    assert supreduce(always, at_first).n_states == 2
    assert supreduce(PLANT, at_first).n_states == 1  # the plant does it itself


def test_what_lets_nothing_happen_is_reduced_to_nothing() -> None:
    empty = Automaton.empty(PLANT.alphabet)
    assert supreduce(PLANT, empty).is_empty
    assert repr(supreduce(PLANT, empty)) == "Reduction: no supervisor exists"
    assert supreduce(empty, PLANT).cells.tolist() == [-1, -1]
    assert [c.is_empty for c in localize([PLANT, PLANT], empty)] == [True, True]


def test_a_plant_without_events_needs_one_state() -> None:
    still = Automaton.from_transitions([], initial="0", marked=["0"], name="STILL")
    small = supreduce(still, still)
    assert (small.n_states, small.lower_bound, small.automaton.n_transitions) == (1, 1, 0)
    assert localize(still, still)[0].n_states == 1


def test_a_disabled_event_without_a_plant_has_no_owner() -> None:
    strict = Automaton.from_transitions(
        ["0 -a-> 1 -u-> 0"], initial="0", alphabet=["w"], uncontrollable=["u"], name="S"
    )
    with pytest.raises(thenar.InputError, match="localize: 'w', which 'S' disables, is in no plant"):
        localize(PLANT, strict)
    assert supreduce(PLANT, strict).n_states == 1


def test_more_events_than_a_machine_word_has_bits() -> None:
    for n in (62, 63, 64, 65, 130):
        events = [f"e{k}" for k in range(n)]
        loops = [("0", e, "1") for e in events] + [("1", e, "0") for e in events]
        plant = Automaton.from_transitions(loops, initial="0", marked=["0"], events=events)
        but_one = Automaton.from_transitions(loops[:-1], initial="0", marked=["0"], events=events)
        small = supreduce(plant, but_one)
        assert small.n_states == 2
        assert [e.name for e in small.pattern(1).disabled] == [events[-1]]
        assert supreduce(plant, plant).n_states == 1


def test_limits_and_progress_are_kept() -> None:
    problem = transfer_line(2)
    supervisor = thenar.synthesize(problem).supervisor
    with pytest.raises(thenar.LimitReached, match="bytes"):
        supreduce(problem.plants, supervisor, limits=thenar.Limits(bytes=100_000))
    with pytest.raises(thenar.LimitReached, match="seconds"):
        supreduce(problem.plants, supervisor, limits=thenar.Limits(seconds=0))


def test_a_supervisor_too_large_for_the_memory_is_refused_at_once() -> None:
    n = 200_000
    ring = Automaton.from_arrays(
        thenar.Alphabet(["a"]), np.arange(n + 1), np.zeros(n, int), (np.arange(n) + 1) % n, marked=np.arange(n) == 0
    )
    with pytest.raises(thenar.LimitReached, match=r"stopped at the limit of 4,294,967,296 bytes: 200,000 states"):
        supreduce(ring, ring)


@pytest.mark.parametrize("local", [False, True])
def test_a_reduction_survives_a_pickle_and_its_arrays_stay_frozen(local: bool) -> None:
    problem = small_factory()
    supervisor = thenar.synthesize(problem).supervisor
    found = localize(problem.plants, supervisor)[0] if local else supreduce(problem.plants, supervisor)
    again = pickle.loads(pickle.dumps(found))
    assert isinstance(again, Reduction)
    assert repr(again) == repr(found)
    assert np.array_equal(again.cells, found.cells)
    plain = pickle.loads(pickle.dumps(supervisor))
    arrays = [again.cells, *(array for s in (again, plain) for array in (s.disabled, s.disabled_offsets))]
    assert not any(array.flags.writeable for array in arrays)
