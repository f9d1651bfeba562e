"""The textbook models have the textbooks' sizes, in the slow oracle, in TCT and in libFAUDES."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import ModuleType

import pytest

from thenar.errors import InputError
from thenar.library import classics
from thenar.library.classics import agv, cat_and_mouse, chain, dining, small_factory, transfer_line
from thenar.model.problem import Problem
from thenar.testing import assert_isomorphic, oracle

# states and transitions of the supervisor, with the source of the numbers
SIZES = [
    # the book's specifications, as drawn in the small factory that comes with IDES (its SUPER.xmd)
    (small_factory(2, repair_priority=True), 12, 24),
    # without the priority, and for more machines: TCT and libFAUDES, which agree
    (small_factory(1), 3, 4),
    (small_factory(2), 12, 25),
    (small_factory(3), 48, 139),
    # Wonham and Cai 2019, sec. 4.6
    (transfer_line(), 28, 65),
    (transfer_line(2), 784, 3640),
    # TCT and libFAUDES
    (chain(4), 54, 120),
    (chain(8), 4374, 17496),
    (dining(2), 5, 6),
    (dining(3), 13, 24),
    (dining(4), 33, 84),
    # Wonham and Ramadge 1987, sec. 7.3, as drawn in the example that comes with IDES
    (cat_and_mouse(), 6, 9),
    # Wonham and Cai 2019, sec. 4.7; the states also in the source of CIF's benchmark
    (agv(), 4406, 11338),
]
MODELS = [pytest.param(problem, size, id=problem.name) for problem, *size in SIZES]
SMALL = [pytest.param(problem, size, id=problem.name) for problem, *size in SIZES if size[0] < 1000]


@pytest.fixture(scope="module", params=["tct", "libfaudes"])
def peer(request: pytest.FixtureRequest) -> ModuleType:
    return import_module(f"tests.oracles.{request.param}")


@pytest.mark.parametrize(("problem", "size"), MODELS)
def test_peers_find_the_published_size(peer: ModuleType, problem: Problem, size: list[int]) -> None:
    supervisor = peer.supcon(problem.plants, problem.specs)
    assert [supervisor.n_states, supervisor.n_transitions] == size


@pytest.mark.parametrize(("problem", "size"), SMALL)
def test_oracle_finds_the_same_supervisor(peer: ModuleType, problem: Problem, size: list[int]) -> None:
    supervisor = oracle.supcon(problem.plants, problem.specs)
    assert [supervisor.n_states, supervisor.n_transitions] == size
    assert_isomorphic(supervisor, peer.supcon(problem.plants, problem.specs))


def pell_lucas(n: int) -> int:
    q = [2, 2]
    while len(q) <= n:
        q.append(2 * q[-1] + q[-2])
    return q[n]


@pytest.mark.parametrize(
    ("family", "states"),
    [
        (small_factory, lambda n: 3 * 4 ** (n - 1)),
        (chain, lambda n: 2 * 3 ** (n - 1)),
        (dining, lambda n: pell_lucas(n) - 1),
        (lambda n: transfer_line(n - 1), lambda n: 28 ** (n - 1)),
    ],
)
def test_family_grows_as_its_docstring_says(
    peer: ModuleType, family: Callable[[int], Problem], states: Callable[[int], int]
) -> None:
    for n in (2, 3):
        problem = family(n)
        assert peer.supcon(problem.plants, problem.specs).n_states == states(n)


def test_repair_priority_removes_transitions_but_no_state() -> None:
    for n in (2, 3):
        free, book = (small_factory(n, repair_priority=priority) for priority in (False, True))
        without, with_priority = (oracle.supcon(p.plants, p.specs) for p in (free, book))
        assert without.n_states == with_priority.n_states
        assert without.n_transitions > with_priority.n_transitions


def test_only_deadlock_makes_the_philosophers_wait() -> None:
    problem = dining(3)
    everything = oracle.sync(*problem.automata)
    blocking = oracle.is_nonblocking(everything)
    assert sorted(blocking.witness or ()) == ["take_left_1", "take_left_2", "take_left_3"]
    assert oracle.is_controllable(everything, problem.plants)


@pytest.mark.parametrize("problem", [pytest.param(problem, id=problem.name) for problem, *_ in SIZES])
def test_every_event_and_specification_says_what_it_means(problem: Problem) -> None:
    assert problem.description
    assert all(event.meaning for event in problem.alphabet)
    assert all(spec.meaning for spec in problem.specs)
    assert all(oracle.is_nonblocking(plant) for plant in problem.plants)


def test_events_have_the_order_of_the_labels_in_the_book() -> None:
    labels = [int(event.meaning.split("book: ")[1].rstrip(")")) for event in agv().alphabet]
    assert labels == sorted(labels)
    assert all(event.controllable == (label % 2 == 1) for event, label in zip(agv().alphabet, labels, strict=True))


@pytest.mark.parametrize("model", [small_factory, chain, transfer_line, dining])
@pytest.mark.parametrize("count", [0, -1, "x", 2.0, None, True])
def test_a_bad_count_is_refused_in_a_sentence(model: Callable[[object], Problem], count: object) -> None:
    with pytest.raises(InputError, match=rf"must be a whole number of \w+, at least \d, not {count!r}$"):
        model(count)


def test_one_philosopher_has_only_one_fork() -> None:
    with pytest.raises(InputError, match="whole number of philosophers, at least 2, not 1"):
        dining(1)


def test_the_package_lists_the_models() -> None:
    assert classics.__all__ == sorted(classics.__all__)
    assert all(callable(getattr(classics, name)) for name in classics.__all__)
