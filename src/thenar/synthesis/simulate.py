"""Stepping a supervised plant: what is enabled, what is disabled, and where a trace leads."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass

from thenar.errors import InputError
from thenar.model.supervisor import ControlPattern, Supervisor
from thenar.model.trace import Trace

__all__ = ["Status", "Step", "random_trace", "simulate"]


@dataclass(frozen=True, slots=True)
class Status:
    """What the feedback map says of ``event`` at ``state``: ``"enabled"``, ``"disabled"`` or ``"impossible"``.

    >>> print(Status("approach_1", "enabled", 0))
    Event approach_1 is enabled at state 0
    """

    event: str
    status: str
    state: int

    def __str__(self) -> str:
        """The paper's own words."""
        return f"Event {self.event} is {self.status} at state {self.state}"


@dataclass(frozen=True, slots=True)
class Step:
    """One event of a trace offered to the supervisor in ``state``; ``target`` is None if it is not let through.

    ``statuses`` are what section 6 of the paper prints: the event's own status, then each other event that
    the supervisor disables in that state.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> step = simulate(synthesize(small_factory()).supervisor, "start_1")[0]
    >>> step.state, step.event, step.target
    (0, 'start_1', 1)
    """

    state: int
    event: str
    target: int | None
    pattern: ControlPattern
    statuses: tuple[Status, ...]


def simulate(supervisor: Supervisor, trace: Iterable[str] | str) -> list[Step]:
    """Offer the events of ``trace`` to the supervised plant one by one, until one is not let through.

    Raises InputError if no supervisor exists, UnknownName for an unknown event, before any step is taken.

    >>> from thenar.library import glr
    >>> from thenar.synthesis.api import synthesize
    >>> for step in simulate(synthesize(glr.problem()).supervisor, "approach_1, approach_2"):
    ...     print(*step.statuses, sep="; ")
    Event approach_1 is enabled at state 0; Event approach_2 is disabled at state 0
    Event approach_2 is enabled at state 1
    """
    names = Trace(trace)
    automaton = supervisor.automaton
    for name in names:
        automaton.alphabet.index(name)
    if supervisor.is_empty:
        raise InputError("there is nothing to simulate: no supervisor exists for this problem")
    state, steps = automaton.initial, []
    for name in names:
        pattern, target = supervisor.pattern(state), automaton.step(state, name)
        disabled = [e.name for e in pattern.disabled]
        status = "enabled" if target is not None else "disabled" if name in disabled else "impossible"
        others = (Status(e, "disabled", state) for e in disabled if e != name)
        steps.append(Step(state, name, target, pattern, (Status(name, status, state), *others)))
        if target is None:
            break
        state = target
    return steps


def random_trace(supervisor: Supervisor, length: int, seed: int) -> Trace:
    """Return ``length`` events of the supervised plant, each drawn evenly from those enabled; shorter at a dead end.

    The same seed gives the same trace.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> random_trace(supervisor, 3, seed=1) == random_trace(supervisor, 3, seed=1)
    True
    """
    if supervisor.is_empty:
        raise InputError("there is nothing to simulate: no supervisor exists for this problem")
    rng, automaton, state, names = random.Random(seed), supervisor.automaton, supervisor.automaton.initial, []
    for _ in range(length):
        row = list(automaton.row(state))
        if not row:
            break
        event, state = rng.choice(row)
        names.append(automaton.alphabet[event].name)
    return Trace(names)
