"""Single strings of a language: what may follow one, how many there are, and some drawn by chance."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError, counted
from thenar.explicit.exploration import ticker
from thenar.explicit.reach import reachable
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.limits import Limits, Progress
from thenar.model.trace import Trace

__all__ = ["Chance", "count_strings", "enabled_after", "sample"]


class Chance(Protocol):
    """A source of chance: ``random.Random(seed)`` is one."""

    def randrange(self, stop: int, /) -> int:
        """Return one of 0 .. stop - 1, each as likely as the others, however large ``stop`` is."""
        ...


def enabled_after(automaton: Automaton, trace: Iterable[str] | str) -> tuple[Event, ...]:
    """Return the events σ with sσ ∈ L for the string s = ``trace``, in the order of the alphabet.  O(|s|).

    Raises UnknownName for an event that the alphabet lacks, and InputError naming the point where the trace leaves L.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off,break-> off"], initial="off", name="LAMP")
    >>> enabled_after(lamp, "on, off, on")
    (Event('off', controllable), Event('break', controllable))
    >>> enabled_after(lamp, "on, on")
    Traceback (most recent call last):
    thenar.errors.InputError: 'LAMP' cannot do 'on' after on, in state 'lit': possible there are off, break
    """
    string = Trace(trace)
    for name in string:
        automaton.alphabet.index(name)
    if automaton.is_empty:
        raise InputError(f"{_whose(automaton)} has no states: no trace is possible, not even the empty one")
    path = automaton.run(string)
    enabled = automaton.enabled(path[-1])
    if len(path) <= len(string):
        done = string[: len(path) - 1]
        there = f"possible there are {', '.join(e.name for e in enabled)}" if enabled else "nothing is possible there"
        state, next_event = automaton.states[path[-1]], string[len(done)]
        raise InputError(f"{_whose(automaton)} cannot do {next_event!r} after {done}, in state {state!r}: {there}")
    return enabled


def count_strings(
    automaton: Automaton,
    length: int,
    *,
    marked: bool = True,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> int:
    """Return how many strings of Lm, or of L if not ``marked``, have at most ``length`` events; exactly.

    O(length |δ|) additions of numbers of O(length log |Σ|) bits, of which as many as states are kept.  Of ``limits``
    those on states and transitions are about what can be reached of the automaton; the seconds bound the counting.

    Raises InputError for a negative length, LimitReached at a limit.

    >>> bits = Automaton.from_transitions(["0 -zero-> 0", "0 -one-> 1 -zero-> 0"], initial="0", marked=["0", "1"])
    >>> [count_strings(bits, n) - count_strings(bits, n - 1) for n in range(1, 8)]  # no two ones in a row
    [2, 3, 5, 8, 13, 21, 34]
    """
    a = reachable(automaton)
    last = deque(_counts(a, length, marked, limits, progress), maxlen=1)[0]
    return 0 if a.is_empty else int(last[a.initial])


def sample(
    automaton: Automaton,
    length: int,
    rng: Chance,
    n: int = 1,
    *,
    marked: bool = True,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> tuple[Trace, ...]:
    """Draw ``n`` strings of Lm, or of L if not ``marked``, of at most ``length`` events, each equally likely.

    The strings are counted with whole numbers of any size, and each drawn by its number: the distribution is exactly
    uniform, and ``rng`` gives one number for a string.  In a language that grows most strings are long, and so are
    most of those drawn.  (:func:`~thenar.synthesis.simulate.random_trace` chooses among the enabled events, all
    alike, as it goes: that is quick, stops nowhere but at dead ends, and prefers strings along which there is little to
    choose.)  The same ``rng`` gives the same strings.

    Counting takes O(length |δ|), and keeps length |Q| numbers; drawing O(length |Σ|) for each string.  ``limits`` bound
    the counting, as in :func:`count_strings`.

    Raises InputError if there is no such string, LimitReached at a limit.   [Nijenhuis and Wilf 1978]

    >>> from random import Random
    >>> a = Automaton.from_transitions(["0 -x-> 1", "0 -y-> 2 -x,y-> 1"], initial="0", marked=["1"])
    >>> sorted({str(s) for s in sample(a, 2, Random(7), 50)})
    ['x', 'y, x', 'y, y']
    """
    a = reachable(automaton)
    rows = list(_counts(a, length, marked, limits, progress))
    total = 0 if a.is_empty else int(rows[-1][a.initial])
    if not total:
        way_out = "allow longer ones" if marked and a.marked.any() else "its language is empty"
        what = f"{'marked ' * marked}string of at most {counted(length, 'event')}"
        raise InputError(f"{_whose(automaton)} has no {what} to draw; {way_out}")
    return tuple(_numbered(a, rows, rng.randrange(total)) for _ in range(n))


def _whose(automaton: Automaton) -> str:
    return repr(automaton.name) if automaton.name else "the automaton"


def _counts(
    automaton: Automaton, length: int, marked: bool, limits: Limits | None, progress: Progress | None
) -> Iterator[NDArray[Any]]:
    """Yield for k = 0 .. length how many strings of at most k events lead from each state to where one may end."""
    if length < 0:
        raise InputError(f"a length of {length}: a string has at least 0 events")
    tick, a = ticker(limits, progress), automaton
    # object: Python's whole numbers, of which there is no largest
    ends = np.asarray(a.marked if marked else np.ones(a.n_states), np.int64).astype(object)
    busy = np.flatnonzero(np.diff(a.offsets))  # the states that something leaves
    row = ends
    yield row
    for _ in range(length):
        tick.look(a.n_states, a.n_transitions)
        further = ends.copy()
        if len(busy):
            further[busy] += np.add.reduceat(row[a.targets], a.offsets[busy])
        row = further
        yield row


def _numbered(automaton: Automaton, rows: list[NDArray[Any]], number: int) -> Trace:
    """Return the string of this ``number``: one before those that it begins, else in the order of the alphabet."""
    state, names = automaton.initial, []
    for row in reversed(rows[:-1]):
        if rows[0][state]:
            if number == 0:
                break
            number -= 1
        for event, target in automaton.row(state):
            if number < row[target]:
                names.append(automaton.alphabet[event].name)
                state = target
                break
            number -= row[target]
    return Trace(names)
