"""Guards: plants and specifications under their guards are the supervised system."""

from random import Random

import thenar
from thenar.model.expressions import FALSE, TRUE
from thenar.symbolic.guards import Guards, expanded, guards, supervised
from thenar.symbolic.synthesis import SymbolicSupervisor
from thenar.synthesis.api import synthesize
from thenar.testing.random_models import random_extended_problem, random_problem


def solved(problem: thenar.Problem | thenar.ExtendedProblem) -> tuple[SymbolicSupervisor, Guards]:
    supervisor = synthesize(problem, "symbolic").symbolic
    assert supervisor is not None
    return supervisor, guards(supervisor)


def assert_guards_are_the_supervisor(problem: thenar.Problem | thenar.ExtendedProblem) -> None:
    supervisor, found = solved(problem)
    encoding = supervisor.encoding
    if supervisor.is_empty:
        assert set(found.values()) <= {FALSE, TRUE}
        return
    for event in encoding.events:
        if not event.controllable:
            continue
        guard = encoding.predicate(expanded(found[event.name], found.definitions))
        offered = supervisor.controlled & event.offered
        assert offered & guard == offered & supervisor.enabled(event)
        assert (found[event.name] == TRUE) == (offered & supervisor.enabled(event) == offered)
        assert found[event.name] != FALSE or not supervisor.controlled & supervisor.enabled(event)


def test_the_system_under_its_guards_is_the_supervised_system() -> None:
    for seed in range(300):
        assert_guards_are_the_supervisor(random_problem(Random(seed)))
        assert_guards_are_the_supervisor(random_extended_problem(Random(seed)))


def test_automata_and_guards_reach_the_supervised_states_and_need_no_more_control() -> None:
    for seed in range(150):
        for problem in (random_problem(Random(seed)), random_extended_problem(Random(seed))):
            supervisor, _ = solved(problem)
            if supervisor.is_empty:
                continue
            alone, found = solved(supervised(supervisor))
            assert alone.reachable.count() == alone.n_states == supervisor.n_states
            assert alone.n_transitions == supervisor.n_transitions
            assert set(found.values()) <= {TRUE}


def test_library_models() -> None:
    for name in ("glr", "agv", "cat_and_mouse", "dining(6)", "transfer_line(2)", "small_factory(4)"):
        assert_guards_are_the_supervisor(thenar.library.model(name))


def test_an_event_that_needs_no_restriction_says_true() -> None:
    _, found = solved(thenar.library.model("cat_and_mouse"))
    assert [event for event, guard in found.items() if guard != TRUE] == ["c3", "m5"]
    assert str(found["c3"]) == "ROOM4.mouse"


def test_guards_of_a_factory_say_that_the_buffers_must_be_empty() -> None:
    _, found = solved(thenar.library.model("small_factory(3)"))
    written = {event: str(guard) for event, guard in found.items()}
    assert written == {
        "start_1": "BUFFER1.empty",
        "repair_1": "true",
        "start_2": "BUFFER2.empty",
        "repair_2": "true",
        "start_3": "true",
        "repair_3": "true",
    }
