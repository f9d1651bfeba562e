"""Dijkstra's dining philosophers: a deadlock that nobody specified."""

from __future__ import annotations

from thenar.library.classics.arguments import check_count
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem

__all__ = ["dining"]


def dining(n: int) -> Problem:
    """Return ``n`` philosophers at a round table with a fork between each two.

    A hungry philosopher takes the fork on the left, then the one on the right, eats, and puts both down.
    Taking a fork can be forbidden; when the meal ends cannot.  The specifications say only that a fork is in
    one hand at a time.  If all take their left forks nobody ever eats: the supervisor must keep the last one
    from doing so, only because that state is blocking.

    Fork i lies on the left of philosopher i.  The supervisor has Q(n) - 1 states with the Pell-Lucas numbers
    Q(0) = Q(1) = 2, Q(k) = 2 Q(k-1) + Q(k-2) (computed up to n = 12, not proved): 13 for three philosophers, 33
    for four.   [Dijkstra 1971, Hierarchical ordering of sequential processes]

    Raises InputError if ``n`` is less than 2.

    >>> dining(3)
    Problem 'dining(3)': 3 plants, 3 specs, 9 events (3 uncontrollable)
    """
    check_count("dining", "n", n, least=2, things="philosophers")
    numbers = range(1, n + 1)
    events = Alphabet(
        event
        for i in numbers
        for event in (
            Event(f"take_left_{i}", meaning=f"philosopher {i} takes the fork on the left, fork {i}"),
            Event(f"take_right_{i}", meaning=f"philosopher {i} takes the fork on the right, fork {i % n + 1}"),
            Event(f"release_{i}", controllable=False, meaning=f"philosopher {i} puts both forks down"),
        )
    )
    philosophers = [
        Automaton.from_transitions(
            [f"thinking -take_left_{i}-> has_left -take_right_{i}-> eating -release_{i}-> thinking"],
            initial="thinking",
            marked=["thinking"],
            events=events,
            name=f"PHILOSOPHER{i}",
        )
        for i in numbers
    ]
    forks = [
        Automaton.from_transitions(
            [f"free -take_left_{i},take_right_{left}-> taken -release_{i},release_{left}-> free"],
            initial="free",
            marked=["free"],
            events=events,
            name=f"FORK{i}",
            meaning=f"fork {i} is in one hand at a time",
        )
        for i, left in zip(numbers, [n, *numbers[:-1]], strict=True)  # fork i lies on the right of ``left``
    ]
    return Problem(
        philosophers,
        forks,
        name=f"dining({n})",
        alphabet=events,
        description="Philosophers share a fork with each neighbour and need two to eat.",
    )
