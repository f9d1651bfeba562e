"""Timed discrete-event systems: the clock's ``tick`` as an event, made of activities with time bounds.

An event that may happen at the earliest ``lower`` ticks, and must happen at the latest ``upper`` ticks, after it became
possible has a *timer* that counts down.  That such a system is a synchronous product, of the activities and the timers,
lets the kernel build it.   [Brandin and Wonham 1994; Lin 2024]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.errors import Mistake, ModelError, did_you_mean
from thenar.explicit.exploration import Exploration, ticker
from thenar.explicit.reach import path_to, reachable
from thenar.explicit.rows import kept, row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.limits import Limits, Progress
from thenar.model.names import Numbered
from thenar.model.trace import Check, Trace

__all__ = ["TICK", "is_activity_loop_free", "timed"]

TICK = Event("tick", controllable=False, meaning="the clock ticks: one unit of time has passed")

Bounds = Mapping[str, tuple[int, int | None]]
Ints = NDArray[np.int64]


def timed(
    activities: Automaton,
    bounds: Bounds,
    *,
    name: str = "",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return the timed transition graph of ``activities``: what they do when ``tick`` is an event too.

    ``bounds`` gives the lower and the upper time bound of an event, in ticks.  With an upper bound it is *prospective*,
    with None *remote*; an event without bounds may come at any time, as with (0, None).  The timer of σ starts from its
    upper bound u, or its lower bound l if it is remote, whenever σ becomes possible or has happened; each tick takes
    one off, down to 0, while σ stays possible.  Then

    * a prospective σ may happen while its timer is at most u - l; at 0 there is no tick: σ must happen first, unless
      something else makes it impossible;
    * a remote σ may happen while its timer is 0.

    ``tick`` is uncontrollable and comes first in the alphabet; states are called after the activity and the timers
    that can count, ``activity|timer|timer``, and marked with their activity.  In a :func:`sync` of timed graphs all
    clocks tick together.  Graphs that share a timed event have a timer each; mostly one is meant: sync the activities
    first.  Time and memory O(result) in the kernel, and a bit for each pair of an activity and an event that enters a
    set of possible timed events: activities by the ten thousand with many timed events are better timed in parts.

    Raises ModelError for bounds that are none, or of no event of ``activities``, or for an event that is called
    ``tick`` already; LimitReached at a limit.   [Brandin and Wonham 1994; Wonham and Cai 2019, ch. 9]

    >>> bus = Automaton.from_transitions(["coming -pass-> gone"], initial="coming", marked=["gone"], name="BUS")
    >>> for source, event, target in timed(bus, {"pass": (1, 2)}).transitions():
    ...     print(f"{source} -{event}-> {target}")
    coming|2 -tick-> coming|1
    coming|1 -tick-> coming|0
    coming|1 -pass-> gone|2
    coming|0 -pass-> gone|2
    gone|2 -tick-> gone|2
    """
    alphabet = activities.alphabet
    _check(activities, bounds)
    name = name or activities.name
    complete = Alphabet([TICK, *alphabet])
    if activities.is_empty:
        return Automaton.empty(complete, name)
    window = {alphabet.index(e): b for e, b in bounds.items()}
    timers = [
        _Timer(k, lower if upper is None else upper, lower, upper)
        for k, (lower, upper) in sorted(window.items())
        if (lower if upper is None else upper) > 0
    ]
    urgent = [k for k, (_, upper) in window.items() if upper == 0]
    refined = _Refined.of(activities, [t.event for t in timers], urgent)
    parts = [refined.automaton, *(refined.counting(t) for t in timers)]
    tick = ticker(limits, progress)
    never = np.zeros(len(refined.automaton.alphabet), np.bool_)
    built = Exploration(parts, (), refined.automaton.alphabet, tick, uncontrollable=never).extract(name, tick).automaton
    return Automaton(
        name,
        complete,
        built.initial,
        built.offsets,
        refined.event[built.events].astype(np.int32),
        built.targets,
        built.marked,
        built.states,
        meaning=activities.meaning,
    )


def is_activity_loop_free(automaton: Automaton, *, tick: str = TICK.name) -> Check:
    """Return whether no cycle that can be reached is without ``tick``, so that time always goes on.

    Ask it of the whole plant: a loop of one part may be cut by another.  The witness leads to a cycle and once round
    it.  O(|δ|) for each event of the longest string without a tick.   [Brandin and Wonham 1994]

    >>> idle = Automaton.from_transitions(["0 -tick-> 0", "0 -work-> 1 -rest-> 0"], initial="0")
    >>> print(is_activity_loop_free(idle))
    activity-loop-free: no after work, rest: work, rest can follow each other without end, and no tick between them
    """
    title = "activity-loop-free"
    a = reachable(automaton)
    rushed = kept(a, a.events != a.alphabet.index(tick)) if tick in a.alphabet else a
    cyclic = _on_the_way_to_a_cycle(rushed)
    path = path_to(a, cyclic)
    if path is None:
        return Check(title, True)
    trace, q = path
    loop: list[str] = []
    seen: dict[int, int] = {}
    while q not in seen:  # each state on the way to a cycle has a successor that is
        seen[q] = len(loop)
        event, q = next((e, t) for e, t in rushed.row(q) if cyclic[t])
        loop.append(a.alphabet[event].name)
    again = ", ".join(loop[seen[q] :])
    return Check(
        title, False, Trace([*trace, *loop]), f"{again} can follow each other without end, and no tick between them"
    )


@dataclass(frozen=True, slots=True)
class _Timer:
    """The timer of one event: it counts down from ``start``, above 0."""

    event: int
    start: int
    lower: int
    upper: int | None

    def allows(self) -> Ints:
        """Return the readings at which the event may happen."""
        return np.arange(1 if self.upper is None else self.upper - self.lower + 1)


@dataclass(frozen=True, slots=True)
class _Refined:
    """The activities, with events that say what they mean to the timers.

    A timer has to know which timed events are possible: while a tick passes, and after an event.  So each event is
    split by the *class* of the activity that it enters, ``tick`` by that of the activity that it passes in: the set of
    timed events possible there.  In no activity two parts of one event are possible, so nothing else changes.

    * ``event``: (n_labels,) int64, 0 for tick, else 1 + the position in the activities' alphabet
    * ``runs``: (n_labels, n_timers) bool, whether the timed event is possible in the label's class
    """

    automaton: Automaton
    event: Ints
    runs: NDArray[np.bool_]
    column: Mapping[int, int]

    @classmethod
    def of(cls, activities: Automaton, timed_events: list[int], urgent: list[int]) -> _Refined:
        """Split the events of ``activities``; ``urgent`` ones let no tick pass while they are possible."""
        n, source = activities.n_states, sources(activities)
        column = {k: i for i, k in enumerate(timed_events)}
        possible = np.zeros((n, len(timed_events)), np.bool_)
        for k, i in column.items():
            possible[source[activities.events == k], i] = True
        classes, class_of = np.unique(possible, axis=0, return_inverse=True)
        class_of = class_of.reshape(-1)  # NumPy 2.0 gave it the shape of a column
        waits = np.ones(n, np.bool_)
        waits[source[np.isin(activities.events, urgent)]] = False
        resting = np.flatnonzero(waits)
        label = np.concatenate(
            (class_of[resting], (activities.events + 1) * len(classes) + class_of[activities.targets])
        )
        from_, to = np.concatenate((resting, source)), np.concatenate((resting, activities.targets))
        labels, event = np.unique(label, return_inverse=True)
        order = np.lexsort((event, from_))
        alphabet = Alphabet(
            f"{k}/{c}" for k, c in zip(*(x.tolist() for x in divmod(labels, len(classes))), strict=True)
        )
        automaton = Automaton(
            activities.name,
            alphabet,
            activities.initial,
            row_offsets(np.bincount(from_, minlength=n)),
            event[order].astype(np.int32),
            to[order].astype(np.int32),
            activities.marked,
            activities.states,
        )
        return cls(automaton, labels // len(classes), classes[labels % len(classes)], column)

    def counting(self, timer: _Timer) -> Automaton:
        """Return ``timer`` as an automaton over the labels that change or read it; its states are its readings."""
        runs = self.runs[:, self.column[timer.event]]
        own, ticks = self.event == timer.event + 1, self.event == 0
        readings = np.arange(timer.start + 1)
        moves: list[tuple[Ints, Ints, Ints]] = []  # labels, readings before, readings after

        def move(labels: NDArray[np.bool_], before: Ints, after: Ints) -> None:
            found = np.flatnonzero(labels)
            moves.append((np.repeat(found, len(before)), np.tile(before, len(found)), np.tile(after, len(found))))

        counts = ticks & runs
        down = readings if timer.upper is None else readings[1:]
        move(counts, down, np.maximum(down - 1, 0))
        move(own, timer.allows(), np.full(len(timer.allows()), timer.start))
        stops = ~ticks & ~own & ~runs
        move(stops, readings, np.full(len(readings), timer.start))
        label, before, after = (np.concatenate(column) for column in zip(*moves, strict=True))
        mine = np.flatnonzero(counts | own | stops)
        order = np.lexsort((label, before))
        everything = self.automaton.alphabet
        return Automaton(
            "",
            Alphabet(everything[k] for k in mine.tolist()),
            timer.start,
            row_offsets(np.bincount(before, minlength=len(readings))),
            np.searchsorted(mine, label[order]).astype(np.int32),
            after[order].astype(np.int32),
            np.ones(len(readings), np.bool_),
            Numbered(readings),
        )


def _check(activities: Automaton, bounds: Bounds) -> None:
    """Raise ModelError with everything that is wrong with ``bounds``."""
    where = f"automaton {activities.name!r}" if activities.name else "automaton"
    mistakes = []
    if TICK.name in activities.alphabet:
        mistakes.append(Mistake(where, "it has an event 'tick' already; only activities without a clock can be timed"))
    for event, window in bounds.items():
        if event not in activities.alphabet:
            near = did_you_mean(event, activities.alphabet.names)
            mistakes.append(Mistake(where, f"time bounds for unknown event {event!r}{near}"))
        elif not _is_window(window):
            valid = "a pair of whole numbers of ticks, 0 <= lower <= upper, or upper None for no bound"
            mistakes.append(Mistake(where, f"time bounds {window!r} of event {event!r}: {valid}"))
    if mistakes:
        raise ModelError(mistakes)


def _is_window(window: object) -> bool:
    if not (isinstance(window, (tuple, list)) and len(window) == 2):
        return False
    lower, upper = window
    if type(lower) is not int or (upper is not None and type(upper) is not int):
        return False
    return 0 <= lower < 1 << 31 and (upper is None or lower <= upper < 1 << 31)


def _on_the_way_to_a_cycle(automaton: Automaton) -> NDArray[np.bool_]:
    """Return (n_states,) bool: what is left when states without successors are taken away again and again."""
    alive = np.ones(automaton.n_states, np.bool_)
    source, target = sources(automaton), automaton.targets
    while True:
        goes_on = np.zeros(automaton.n_states, np.bool_)
        goes_on[source] = True
        goes_on &= alive
        if goes_on.sum() == alive.sum():
            return alive
        alive = goes_on
        left = alive[source] & alive[target]
        source, target = source[left], target[left]
