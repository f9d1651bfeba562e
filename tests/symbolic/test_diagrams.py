"""The diagrams themselves: any number of levels, one thread at a time."""

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

import thenar
from thenar._native import kernel
from thenar.explicit.exploration import ticker
from thenar.symbolic.encode import Encoding
from thenar.symbolic.synthesis import reach

ALL = (1 << 63) - 1


def forest_of(*sizes: int) -> kernel.Forest:
    return kernel.Forest(np.array(sizes, np.uint32), ALL, 1 << 24, 1 << 16)


def numbers(*values: int) -> np.ndarray[tuple[int], np.dtype[np.uint32]]:
    return np.array(values, np.uint32)


@pytest.mark.parametrize("levels", [1, 11_000, 30_000])
def test_no_number_of_levels_is_too_deep(levels: int) -> None:
    assert_every_operation_comes_back(levels)


def test_nor_in_a_thread_with_a_small_stack() -> None:
    usual = threading.stack_size(1 << 18)
    done: list[int] = []

    def work() -> None:
        assert_every_operation_comes_back(6_000)
        done.append(6_000)

    try:
        thread = threading.Thread(target=work)
        thread.start()
    finally:
        threading.stack_size(usual)
    thread.join()
    assert done == [6_000]


def assert_every_operation_comes_back(levels: int) -> None:
    forest = forest_of(*[2] * levels)
    tick = kernel.Ticker()
    zeros = forest.all_of([forest.literal(k, np.array([1, 0], np.uint8)) for k in range(1, levels + 1)], tick)
    others = ~zeros
    assert (zeros | others).is_everything
    assert not zeros & others
    assert zeros.count() == 1
    assert others.count() == 2**levels - 1
    assert len(zeros.factors()) == levels
    assert zeros.simplify(zeros | others) == zeros
    assert zeros.forget(np.ones(levels + 1, np.uint8)).is_everything


def test_threads_have_diagrams_of_their_own() -> None:
    found = []
    work = [
        threading.Thread(target=lambda: found.append(thenar.synthesize(thenar.library.model("agv"), "symbolic")))
        for _ in range(4)
    ]
    for thread in work:
        thread.start()
    for thread in work:
        thread.join()
    assert [r.symbolic.n_states for r in found if r.symbolic is not None] == [4406] * 4


def test_diagrams_at_work_refuse_another_thread_and_can_be_used_after_a_limit() -> None:
    problem = thenar.library.glr.problem(fingers=12)
    encoding = Encoding(problem, ticker(thenar.Limits(seconds=2)), order="model")
    said: list[str] = []

    def meddle() -> None:
        time.sleep(0.7)
        try:
            _ = encoding.initial & encoding.marked
        except RuntimeError as error:
            said.append(str(error))

    other = threading.Thread(target=meddle)
    other.start()
    with pytest.raises(thenar.LimitReached, match="seconds"):
        reach(encoding)
    other.join()
    assert said == ["these diagrams are at work in another thread; give each thread its own synthesis"]
    encoding.at_leisure()
    assert (encoding.initial | encoding.marked).count() > 0


def test_what_is_dropped_while_diagrams_are_at_work_is_freed_afterwards() -> None:
    encoding = Encoding(thenar.library.glr.problem(fingers=12), kernel.Ticker(), order="model")
    relations = [e.relation for e in encoding.events]
    others = [encoding.forest.saturation(relations) for _ in range(59)]
    found = [run(encoding.initial, encoding.invariant, encoding.tick, 1000) for run in others]
    assert found == [None] * 59  # but each leaves results in the cache that have to go

    def drop() -> None:
        time.sleep(0.5)
        while others:
            others.pop()

    encoding.tick = kernel.Ticker(seconds=1.5)
    thread = threading.Thread(target=drop)
    thread.start()
    with pytest.raises(thenar.LimitReached, match="seconds"):
        reach(encoding)
    thread.join()
    encoding.at_leisure()
    again = [encoding.forest.saturation(relations[:1]) for _ in range(60)]
    assert again[0](encoding.initial, encoding.initial, kernel.Ticker()) == encoding.initial
    with pytest.raises(ValueError, match="more than 60"):
        encoding.forest.saturation(relations)


def test_a_search_out_of_steps_can_be_taken_up_again() -> None:
    encoding = Encoding(thenar.library.model("agv"), kernel.Ticker())
    forward = encoding.forest.saturation([e.relation for e in encoding.events])
    tries = 0
    while (found := forward(encoding.initial, encoding.invariant, encoding.tick, 256)) is None:
        tries += 1
    assert 1 < tries < 100
    assert found == reach(encoding)


def test_long_operations_can_be_stopped_and_short_ones_are_not() -> None:
    forest, rng = forest_of(*[2] * 32), np.random.default_rng(1)
    # the two say nothing of each other's levels, which stand in turns: together they are as large as their product
    odd, even = (forest.table(range(k, 0, -2), rng.integers(0, 2, 1 << 16).astype(np.uint8)) for k in (31, 32))
    forest.watched_by(kernel.Ticker(seconds=0))
    assert odd - forest.everything == forest.nothing
    operations: list[Callable[[], object]] = [lambda: odd & even, lambda: odd | even, lambda: odd - even]
    for operation in operations:
        with pytest.raises(thenar.LimitReached, match="seconds"):
            operation()
    forest.watched_by(kernel.Ticker())
    assert not odd & ~odd


def test_sets_of_other_diagrams_are_refused() -> None:
    forest, other = forest_of(2, 3), forest_of(2, 3)
    tick, far, own = kernel.Ticker(), other.literal(2, np.array([1, 0, 0], np.uint8)), forest.everything
    step = forest.shift(1, numbers(0), numbers(1), 1)
    run = forest.saturation([step])
    wrong: list[Callable[[], object]] = [
        lambda: own & far,
        lambda: own | far,
        lambda: own - far,
        lambda: own.simplify(far),
        lambda: own.products(far, 9),
        lambda: forest.any_of([own, far], tick),
        lambda: forest.all_of([own], tick, far),
        lambda: forest.restrict(step, far),
        lambda: forest.image(far, step),
        lambda: forest.count_steps(far, [step], tick),
        lambda: forest.steps(own, far, step),
        lambda: run(far, own, tick),
        lambda: run(own, far, tick),
    ]
    for operation in wrong:
        with pytest.raises(ValueError, match="other diagrams"):
            operation()


def test_equality_never_raises() -> None:
    forest, other = forest_of(2), forest_of(2)
    for thing in (None, 1, "set", other.everything, forest.nothing):
        assert forest.everything != thing
    assert forest.everything == forest.everything
    with pytest.raises(TypeError):
        forest.everything & 1  # type: ignore[operator]


def test_numbers_are_checked_at_the_door() -> None:
    forest, tick = forest_of(2, 3), kernel.Ticker()
    half = forest.literal(2, np.array([1, 0, 0], np.uint8))
    step = forest.shift(1, numbers(0), numbers(1), 1)
    wrong: list[Callable[[], object]] = [
        lambda: half.child(3),
        lambda: half.forget(np.ones(2, np.uint8)),
        lambda: forest.literal(0, np.ones(1, np.uint8)),
        lambda: forest.literal(3, np.ones(1, np.uint8)),
        lambda: forest.literal(2, np.ones(2, np.uint8)),
        lambda: forest.table([2, 2], np.ones(9, np.uint8)),
        lambda: forest.table([1, 2], np.ones(6, np.uint8)),
        lambda: forest.table([2, 1], np.ones(5, np.uint8)),
        lambda: forest.shift(3, numbers(0), numbers(0), 1),
        lambda: forest.shift(2, numbers(0), numbers(3), 1),
        lambda: forest.shift(2, numbers(3), numbers(0), 1),
        lambda: forest.shift(2, numbers(0, 1), numbers(0), 1),
        lambda: forest.shift(1, numbers(0), numbers(0), step),
        lambda: forest.shift(2, numbers(0), numbers(0), 12345),
        lambda: forest.rows([2, 1], numbers(0, 0, 2, 0)),
        lambda: forest.rows([2, 1], numbers(0, 0, 1)),
        lambda: forest.rows([1, 2], numbers(0, 0, 0, 0)),
        lambda: forest.rows([], numbers(0)),
        lambda: forest.join(step, 12345),
        lambda: forest.join(step, step),
        lambda: forest.either(12345, step),
        lambda: forest.restrict(12345, half),
        lambda: forest.inverse(12345),
        lambda: forest.relation_support(12345),
        lambda: forest.domain(12345),
        lambda: forest.image(half, 12345),
        lambda: forest.count_steps(half, [12345], tick),
        lambda: forest.steps(half, half, 12345),
        lambda: forest.saturation([12345]),
        lambda: forest_of(2, 0),
        lambda: kernel.order(2, np.array([0, 2]), numbers(0, 2), "force", numbers(0, 1), tick),
        lambda: kernel.order(2, np.array([0, 3]), numbers(0, 1), "force", numbers(0, 1), tick),
        lambda: kernel.order(2, np.array([0, 2]), numbers(0, 1), "force", numbers(0, 0), tick),
        lambda: kernel.order(2, np.array([0, 2]), numbers(0, 1), "forse", numbers(0, 1), tick),
    ]
    for k, operation in enumerate(wrong):
        with pytest.raises(ValueError, match=" "):
            pytest.fail(f"{k}: {operation()}")


def test_diagrams_without_levels() -> None:
    forest, tick = forest_of(), kernel.Ticker()
    for states, n in ((forest.nothing, 0), (forest.everything, 1)):
        assert states.count() == n
        assert states.vectors(9).tolist() == []
        assert forest.count_steps(states, [0, 1], tick) == n
        assert [len(x) for x in forest.steps(states, states, 1)] == [n, n]
        assert forest.saturation([1])(states, forest.everything, tick) == states
