"""The diagrams themselves: any number of levels, one thread at a time."""

import threading
import time

import numpy as np
import pytest

import thenar
from thenar._native import kernel
from thenar.explicit.exploration import ticker
from thenar.symbolic.encode import Encoding
from thenar.symbolic.synthesis import reach


@pytest.mark.parametrize("levels", [1, 11_000, 30_000])
def test_no_number_of_levels_is_too_deep(levels: int) -> None:
    forest = kernel.Forest(np.full(levels, 2, np.uint32), 1 << 40, 1 << 24, 1 << 16)
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
    assert (encoding.initial | encoding.marked).count() > 0
