"""Timed discrete-event systems: the clock's ``tick`` as an event, made of activities with time bounds.

An event that may happen at the earliest ``lower`` ticks, and must happen at the latest ``upper`` ticks, after it became
possible has a *timer* that counts down.  That such a system is a synchronous product, of the activities and the timers,
lets the kernel build it.   [Brandin and Wonham 1994; Lin 2024]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral
from typing import SupportsIndex

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import Mistake, ModelError, did_you_mean
from thenar.explicit.components import heights, way_round
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

Bounds = Mapping[str, tuple[SupportsIndex, SupportsIndex | None]]
Ints = NDArray[np.int64]
_BLOCK = 1 << 16  # pairs of a reading and a label between two looks at the limits


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
    first.

    A *label* is an event with the set of timed events that are possible after it, or with ``tick`` before it.  Each
    timer is listed: a row for each tick from 0 to its start, and in it the labels that it minds.  So time and memory
    are O(result + Σ start · labels), whether so many ticks can pass or not: 10⁶ ticks take about 25 MB for each label.
    A bit is taken for each pair of an activity, or of a label, and a timed event.

    Raises ModelError for bounds that are none, or of no event of ``activities``, or for an event that is called
    ``tick`` already; LimitReached at a limit, where the rows of a timer count as states.   [Brandin and Wonham 1994;
    Wonham and Cai 2019, ch. 9]

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
    window = {
        alphabet.index(e): (int(lower), None if upper is None else int(upper)) for e, (lower, upper) in bounds.items()
    }
    timers = [
        _Timer(k, lower if upper is None else upper, lower, upper)
        for k, (lower, upper) in sorted(window.items())
        if (lower if upper is None else upper) > 0
    ]
    urgent = [k for k, (_, upper) in window.items() if upper == 0]
    tick = ticker(limits, progress)
    refined = _Refined.of(activities, [t.event for t in timers], urgent)
    parts = [refined.automaton, *(refined.counting(t, tick) for t in timers)]
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
    """Return whether no cycle that can be reached is without ``tick``: between two ticks only so much can happen.

    Ask it of the whole plant: a loop of one part may be cut by another.  That a tick comes at all does not follow; it
    may be kept out where nothing else is possible either, as by a specification.  The witness leads to a cycle and
    once round it.  O(|δ|).   [Brandin and Wonham 1994]

    >>> idle = Automaton.from_transitions(["0 -tick-> 0", "0 -work-> 1 -rest-> 0"], initial="0")
    >>> print(is_activity_loop_free(idle))
    activity-loop-free: no after work, rest: work, rest can follow each other without end, and no tick between them
    """
    title = "activity-loop-free"
    a = reachable(automaton)
    rushed = kept(a, a.events != a.alphabet.index(tick)) if tick in a.alphabet else a
    height = heights(rushed)
    path = path_to(a, height < 0)
    if path is None:
        return Check(title, True)
    trace, q = path
    onward, loop = way_round(rushed, height, q)
    why = f"{', '.join(loop)} can follow each other without end, and no tick between them"
    return Check(title, False, Trace([*trace, *onward, *loop]), why)


@dataclass(frozen=True, slots=True)
class _Timer:
    """The timer of one event: it counts down from ``start``, above 0."""

    event: int
    start: int
    lower: int
    upper: int | None

    @property
    def most(self) -> int:
        """The last reading at which the event may happen."""
        return 0 if self.upper is None else self.upper - self.lower


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
        happens = (activities.events.astype(np.int64) + 1) * len(classes) + class_of[activities.targets]
        label = np.concatenate((class_of[resting], happens))
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

    def counting(self, timer: _Timer, tick: kernel.Ticker) -> Automaton:
        """Return ``timer`` as an automaton over the labels that change or read it; its states are its readings."""
        runs = self.runs[:, self.column[timer.event]]
        own, ticks = self.event == timer.event + 1, self.event == 0
        mine = np.flatnonzero(own | (ticks == runs))  # no tick that finds it at rest, no event that lets it run on
        own, ticks = own[mine], ticks[mine]
        degrees, labels, after = list[Ints](), list[NDArray[np.int32]](), list[NDArray[np.int32]]()
        rows, found = max(_BLOCK // max(len(mine), 1), 1), 0
        for first in range(0, timer.start + 1, rows):
            reading = np.arange(first, min(first + rows, timer.start + 1))[:, None]
            tick.look(first, found)
            due = (reading == 0) & (timer.upper is not None)
            may = ~(ticks & due) & ~(own & (reading > timer.most))
            before, label = np.nonzero(may)
            degrees.append(may.sum(axis=1))
            labels.append(label.astype(np.int32))
            new = np.where(ticks[label], np.maximum(reading[before, 0] - 1, 0), timer.start)
            after.append(new.astype(np.int32))
            found += len(label)
        everything = self.automaton.alphabet
        return Automaton(
            "",
            Alphabet(everything[k] for k in mine.tolist()),
            timer.start,
            row_offsets(np.concatenate(degrees)),
            np.concatenate(labels),
            np.concatenate(after),
            np.ones(timer.start + 1, np.bool_),
            Numbered(np.arange(timer.start + 1)),
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
    if any(isinstance(b, bool) or not isinstance(b, Integral) for b in (lower, lower if upper is None else upper)):
        return False
    return bool(0 <= lower < 1 << 31 and (upper is None or lower <= upper < 1 << 31))
