"""Machines and buffers: Wonham's small factory and transfer line, and a chain of machines of any length."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from thenar.library.classics.arguments import check_count
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem

__all__ = ["chain", "small_factory", "transfer_line"]


def small_factory(n: int = 2, *, repair_priority: bool = False) -> Problem:
    """Return Wonham's small factory: ``n`` machines that may break down, with unit buffers between them.

    Machine i takes a workpiece from buffer i-1, works, and puts it into buffer i; while it works it may break
    down, and then it waits for its repair.  Its start and its repair can be held back; that it finishes, or
    breaks down, just happens.  No buffer may overflow or underflow.

    With ``repair_priority`` also the book's second specification holds: while the last machine is down, no
    other is repaired.  It forbids transitions, but makes no state unreachable.

    For n = 2 the supervisor has 12 states and 25 transitions, with repair priority 24; in general there are
    3·4ⁿ⁻¹ states (computed up to n = 8, not proved).   [Wonham and Cai 2019, sec. 4.4]

    Raises InputError if ``n`` is less than 1.

    >>> small_factory()
    Problem 'small_factory(2)': 2 plants, 1 spec, 8 events (4 uncontrollable)
    >>> print(*small_factory().automaton("BUFFER1").transitions())
    ('empty', 'finish_1', 'full') ('full', 'start_2', 'empty')
    >>> small_factory(3, repair_priority=True).specs[-1].meaning
    'while machine 3 is down no other machine is repaired'
    """
    check_count("small_factory", "n", n, least=1, things="machines")
    numbers = range(1, n + 1)
    events = Alphabet(
        event
        for i in numbers
        for event in (
            *_work(i),
            Event(f"break_{i}", controllable=False, meaning=f"machine {i} breaks down and discards the workpiece"),
            Event(f"repair_{i}", meaning=f"machine {i} is repaired"),
        )
    )
    machines = [
        Automaton.from_transitions(
            [
                f"idle -start_{i}-> working -finish_{i}-> idle",
                f"working -break_{i}-> down -repair_{i}-> idle",
            ],
            initial="idle",
            marked=["idle"],
            events=events,
            name=f"MACHINE{i}",
        )
        for i in numbers
    ]
    return Problem(
        machines,
        [*_unit_buffers(n, events), *([_repair_priority(n, events)] if repair_priority and n > 1 else [])],
        name=f"small_factory({n}, repair_priority=True)" if repair_priority else f"small_factory({n})",
        alphabet=events,
        description="Machines that may break down work one after the other, with unit buffers between them.",
    )


def chain(n: int) -> Problem:
    """Return ``n`` two-state machines in series with n - 1 unit buffers, the smallest of all production lines.

    The machines of :func:`small_factory` that never break down.  The supervisor has 2·3ⁿ⁻¹ states (computed up to
    n = 12, not proved): a family to see how an algorithm grows.

    Raises InputError if ``n`` is less than 1.

    >>> chain(4)
    Problem 'chain(4)': 4 plants, 3 specs, 8 events (4 uncontrollable)
    """
    check_count("chain", "n", n, least=1, things="machines")
    numbers = range(1, n + 1)
    events = Alphabet(event for i in numbers for event in _work(i))
    return Problem(
        [_machine(f"MACHINE{i}", f"start_{i}", f"finish_{i}", events) for i in numbers],
        _unit_buffers(n, events),
        name=f"chain({n})",
        alphabet=events,
        description="Machines work one after the other, with unit buffers between them.",
    )


def transfer_line(m: int = 1) -> Problem:
    """Return ``m`` independent copies of Wonham's transfer line, in which rejected workpieces are worked again.

    ::

        → M1 → B1 (3) → M2 → B2 (1) → TU → accepted
                 ↑                     ↓
                 └──────── rejected ───┘

    Two machines and a test unit are linked by buffers for three workpieces and for one.  A workpiece that the
    test unit rejects goes back to the first buffer.  The buffers must neither overflow nor underflow, so that
    M1 must leave room in B1 for what is still to be tested.

    One line has a supervisor of 28 states and 65 transitions, m lines one of 28ᵐ states, since they share no
    event.  The events have the order of their labels in the book: 1, 2, 3, 4, 5, 6, 8.
    [Wonham and Cai 2019, sec. 4.6]

    Raises InputError if ``m`` is less than 1.

    >>> transfer_line()
    Problem 'transfer_line(1)': 3 plants, 2 specs, 7 events (4 uncontrollable)
    """
    check_count("transfer_line", "m", m, least=1, things="lines")
    lines = [f"L{k}_" for k in range(1, m + 1)]
    events = Alphabet(
        event
        for line in lines
        for event in (
            Event(f"{line}start_M1", meaning="machine 1 takes a new workpiece (book: 1)"),
            Event(f"{line}finish_M1", controllable=False, meaning="machine 1 puts it into buffer 1 (book: 2)"),
            Event(f"{line}start_M2", meaning="machine 2 takes a workpiece from buffer 1 (book: 3)"),
            Event(f"{line}finish_M2", controllable=False, meaning="machine 2 puts it into buffer 2 (book: 4)"),
            Event(f"{line}test", meaning="the test unit takes a workpiece from buffer 2 (book: 5)"),
            Event(f"{line}accept", controllable=False, meaning="the workpiece is good and leaves the line (book: 6)"),
            Event(f"{line}reject", controllable=False, meaning="the workpiece goes back to buffer 1 (book: 8)"),
        )
    )
    plants, specs = [], []
    for line in lines:
        plants += [
            _machine(f"{line}M1", f"{line}start_M1", f"{line}finish_M1", events),
            _machine(f"{line}M2", f"{line}start_M2", f"{line}finish_M2", events),
            _machine(f"{line}TU", f"{line}test", f"{line}accept,{line}reject", events),
        ]
        specs += [
            _buffer(f"{line}B1", f"{line}finish_M1,{line}reject", f"{line}start_M2", 3, events),
            _buffer(f"{line}B2", f"{line}finish_M2", f"{line}test", 1, events),
        ]
    return Problem(
        plants,
        specs,
        name=f"transfer_line({m})",
        alphabet=events,
        description="Two machines and a test unit, linked by buffers; what the test rejects is worked again.",
    )


def _work(i: int) -> list[Event]:
    return [
        Event(f"start_{i}", meaning=f"machine {i} takes a workpiece and starts to work"),
        Event(f"finish_{i}", controllable=False, meaning=f"machine {i} finishes and passes the workpiece on"),
    ]


def _repair_priority(n: int, events: Alphabet) -> Automaton:
    others = ",".join(f"repair_{i}" for i in range(1, n))
    return Automaton.from_transitions(
        [f"last_is_up -{others}-> last_is_up", f"last_is_up -break_{n}-> last_is_down -repair_{n}-> last_is_up"],
        initial="last_is_up",
        marked=["last_is_up"],
        events=events,
        name="REPAIR_PRIORITY",
        meaning=f"while machine {n} is down no other machine is repaired",
    )


def _machine(name: str, start: str, finish: str, events: Alphabet) -> Automaton:
    return Automaton.from_transitions(
        [f"idle -{start}-> working -{finish}-> idle"], initial="idle", marked=["idle"], events=events, name=name
    )


def _unit_buffers(n: int, events: Alphabet) -> Iterable[Automaton]:
    """Yield the buffers between ``n`` machines in series."""
    for i in range(1, n):
        yield _buffer(f"BUFFER{i}", f"finish_{i}", f"start_{i + 1}", 1, events)


def _buffer(name: str, put: str, take: str, capacity: int, events: Alphabet) -> Automaton:
    levels = ["empty", *(f"holds_{k}" for k in range(1, capacity)), "full"]
    up = [f"{low} -{put}-> {high}" for low, high in pairwise(levels)]
    down = [f"{high} -{take}-> {low}" for low, high in pairwise(levels)]
    return Automaton.from_transitions(
        up + down,
        initial="empty",
        marked=["empty"],
        events=events,
        name=name,
        meaning="the buffer neither overflows nor underflows",
    )
